// Files that the user gives: by dropping them, folders included, or by choosing them.
type Take = (files: Map<string, File>) => void;

async function entriesOf(entry: FileSystemEntry, path: string, into: Map<string, File>): Promise<void> {
  if (entry.isFile) {
    into.set(path + entry.name, await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject)));
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    const batch = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (batch.length === 0) return;
    for (const child of batch) await entriesOf(child, `${path}${entry.name}/`, into);
  }
}

export function setUpDropping(take: Take): void {
  const drop = document.getElementById('drop')!, input = document.getElementById('files') as HTMLInputElement;
  let depth = 0;
  addEventListener('dragenter', (event) => { event.preventDefault(); ++depth; drop.hidden = false; });
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('dragleave', () => { if (--depth <= 0) drop.hidden = true; });
  addEventListener('drop', async (event) => {
    event.preventDefault();
    depth = 0;
    drop.hidden = true;
    const items = [...(event.dataTransfer?.items ?? [])].filter((item) => item.kind === 'file');
    const entries = items.map((item) => item.webkitGetAsEntry?.() ?? null), files = new Map<string, File>();
    if (entries.some((entry) => entry?.isDirectory)) {
      for (const entry of entries) if (entry) await entriesOf(entry, '', files);
    } else for (const file of event.dataTransfer?.files ?? []) files.set(file.name, file);
    if (files.size > 0) take(files);
  });
  input.addEventListener('change', () => {
    const files = new Map([...(input.files ?? [])].map((file) => [file.name, file]));
    input.value = '';
    if (files.size > 0) take(files);
  });
  for (const button of document.querySelectorAll('[data-do=open]')) button.addEventListener('click', () => input.click());
}

/** Which of the given files is the scene, and which the bake. */
export function sortFiles(files: Map<string, File>): { scene: [string, File] | null; pvs: [string, File] | null; strangers: string[] } {
  let scene: [string, File] | null = null, pvs: [string, File] | null = null;
  const strangers: string[] = [];
  for (const [path, file] of files) {
    if (/\.(glb|gltf)$/i.test(path)) scene ??= [path, file];
    else if (/\.pvs$/i.test(path)) pvs ??= [path, file];
    else if (!/\.(bin|png|jpe?g|webp|ktx2|avif)$/i.test(path)) strangers.push(path);
  }
  return { scene, pvs, strangers };
}
