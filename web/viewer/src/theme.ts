// Light or dark: what the system says, until the user says otherwise.
const key = 'antumbra-theme';
const system = matchMedia('(prefers-color-scheme: dark)');

const stored = (): string | null => { try { return localStorage.getItem(key); } catch { return null; } };

export const isDark = (): boolean => document.documentElement.dataset.theme === 'dark';

export function setUpTheme(changed: () => void): void {
  const apply = (): void => {
    const dark = (stored() ?? (system.matches ? 'dark' : 'light')) === 'dark';
    document.documentElement.dataset.theme = dark ? 'dark' : 'light';
    changed();
  };
  system.addEventListener('change', apply);
  document.getElementById('theme')!.addEventListener('click', () => {
    try { localStorage.setItem(key, isDark() ? 'light' : 'dark'); } catch { /* pages from disk may have no storage */ }
    document.documentElement.dataset.theme = isDark() ? 'light' : 'dark';
    changed();
  });
  apply();
}
