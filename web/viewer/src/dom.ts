// Small helpers for the page.
export const byId = <T extends HTMLElement = HTMLElement>(id: string): T => document.getElementById(id) as T;

export function element(tag: string, attributes: Record<string, string> = {}, ...children: (Node | string)[]): HTMLElement {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const grouped = new Intl.NumberFormat('en', { maximumFractionDigits: 0 });
export const whole = (value: number): string => grouped.format(value);
const compact = new Intl.NumberFormat('en', { notation: 'compact', maximumSignificantDigits: 3 });
/** At most four letters or so. */
export const brief = (value: number): string => (value < 10_000 ? whole(value) : compact.format(value));
export const milliseconds = (value: number): string => (value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2));
export const plural = (count: number, word: string): string => `${whole(count)} ${word}${count === 1 ? '' : 's'}`;
export const size = (bytes: number): string => (bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`);

/** A line that stays until it is closed. */
export function say(text: string, kind: 'error' | 'note' = 'error'): void {
  const close = element('button', { type: 'button', 'aria-label': 'Close' }, '×');
  const line = element('div', { class: kind }, element('span', {}, text), close);
  close.addEventListener('click', () => line.remove());
  byId('messages').append(line);
  while (byId('messages').children.length > 3) byId('messages').firstElementChild!.remove();
}
export const hush = (): void => byId('messages').replaceChildren();

export const swatch = (state: 'drawn' | 'hidden-part' | 'out'): HTMLElement => element('i', { class: state });
