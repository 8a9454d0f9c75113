// The page: puts files, picture and panel together.
import { Vector3 } from 'three';
import { openBake, type Bake } from './bake';
import { rampColours, type CellChoice } from './cells';
import { Charts } from './charts';
import { Chosen } from './chosen';
import { brief, byId, element, hush, milliseconds, plural, say, size, whole } from './dom';
import { setUpDropping, sortFiles } from './dropping';
import { loadScene, type SceneSource } from './loading';
import { breathe, makeModel } from './model';
import { download, fetchPath, findOffer, type Offer, type PathFrame } from './server';
import { setUpStick } from './stick';
import './style.css';
import { isDark, setUpTheme } from './theme';
import { methodsOf, type Method } from './culling';
import { Viewer, type FrameReport } from './viewer';
import { overviewOf } from './walker';

const viewer = new Viewer(byId<HTMLCanvasElement>('picture'));
const charts = new Charts(byId('charts'));
const chosen = new Chosen(viewer, byId('chosen'));
let bake: Bake | null = null;
let offer: Offer | null = null;
let path: PathFrame[] | null = null;
/** Those that need no bake. */
let plainMethods: Method[] = [];
let sceneBytes = 0;

// -- progress ----------------------------------------------------------------------------------------------------------
function showProgress(text: string, share: number | null): void {
  byId('progress').hidden = false;
  byId('progress').querySelector('p')!.textContent = text;
  const bar = byId('progress').querySelector('progress')!;
  share === null ? bar.removeAttribute('value') : (bar.value = share);
}
const endProgress = (): void => { byId('progress').hidden = true; };

/** Runs one piece of loading; what goes wrong is said, and nothing else changes. */
let busy = Promise.resolve();
function attempt(work: () => Promise<void>): Promise<void> {
  busy = busy.then(async () => {
    try {
      await work();
    } catch (error) {
      say(error instanceof Error ? error.message : String(error));
    } finally {
      endProgress();
    }
  });
  return busy;
}

// -- files -------------------------------------------------------------------------------------------------------------
async function takeScene(source: SceneSource): Promise<void> {
  showProgress(`Reading ${source.name}`, null);
  await breathe();
  sceneBytes = source.bytes.byteLength;
  const gltf = await loadScene(source, viewer.renderer);
  const model = await makeModel(source.name, gltf, (share) => showProgress(`Preparing ${source.name}`, share));
  const methods = await methodsOf(model);
  dropBake();
  plainMethods = methods;
  path = null;
  byId('tour').hidden = true;
  viewer.setModel(model, methods);
  byId('welcome').hidden = true;
  byId('tools').hidden = byId('keys').hidden = false;
  document.documentElement.dataset.scene = 'yes';
  document.title = `${source.name} · Antumbra viewer`;
  byId('scene-name').textContent = source.name;
  byId('scene-facts').textContent = `${plural(model.objects.length, 'object')} · ${plural(model.triangles, 'triangle')}`;
  byId<HTMLInputElement>('own-materials').checked = model.hasColours;
  const names = new Set(model.objects.map(({ name }) => name));
  byId('names').replaceChildren(...[...names].slice(0, 5000).map((name) => element('option', { value: name })));
  if (model.camera) {
    const eye = model.camera.getWorldPosition(new Vector3());
    viewer.walker.lookAt(eye, eye.clone().add(model.camera.getWorldDirection(new Vector3())));
  } else {
    const { eye, target } = overviewOf(model.bounds, viewer.camera);
    viewer.walker.lookAt(eye, target);
  }
  setFlying(true);
  charts.clear();
  fillMethods();
  fillFacts();
}

function dropBake(): void {
  if (viewer.model) {
    viewer.setMethods(plainMethods);
    viewer.setCells(null);
  }
  bake?.dispose();
  bake = null;
  chosen.bake = null;
  byId('cells-row').hidden = byId('legend').hidden = true;
}

async function takeBake(name: string, bytes: ArrayBuffer, byOrder = false): Promise<void> {
  if (!viewer.model) throw new Error(`${name}: give its scene first, or both together`);
  showProgress(`Reading ${name}`, null);
  await breathe();
  const opened = await openBake(name, bytes, viewer.model, byOrder);
  dropBake();
  bake = opened;
  chosen.bake = bake;
  const own = new Map(bake.methods.map((method) => [method.name, method]));
  viewer.setMethods([...plainMethods.filter((method) => !own.has(method.name)), ...own.values()]);
  viewer.method = own.get('pvs')!;
  viewer.setCells(bake.cells);
  byId('cells-row').hidden = bake.cells.length === 0;
  showCells('none');
  fillMethods();
  fillFacts();
  startInside();
}

async function takeFiles(files: Map<string, File>): Promise<void> {
  const { scene, pvs, strangers } = sortFiles(files);
  if (!scene && !pvs) {
    say(`${strangers[0] ?? 'This'}: neither a scene (.glb, .gltf) nor a .pvs; other formats: antumbra view ${strangers[0] ?? 'FILE'}`);
    return;
  }
  hush();
  let loaded = !scene;
  if (scene)
    await attempt(async () => {
      offer = null;
      chosen.explains = false;
      await takeScene({ name: scene[1].name, bytes: await scene[1].arrayBuffer(), files });
      loaded = true;
    });
  if (pvs && loaded) await attempt(async () => takeBake(pvs[1].name, await pvs[1].arrayBuffer()));
}

/** Begins where somebody can stand: on the path, else in a cell that sees a middling number of objects. */
function startInside(): void {
  if (fromAddress()) return;
  if (path) {
    // A little into the walk: its first steps may leave a corner.
    const { eye, target } = path[Math.floor(path.length / 12)];
    viewer.walker.lookAt(eye, target);
    return setFlying(false);
  }
  const seeing = bake?.cells.filter(({ seen }) => seen > 0).sort((a, b) => a.seen - b.seen) ?? [];
  if (seeing.length === 0 || viewer.model?.camera) return;
  const eye = seeing[seeing.length >> 1].box.getCenter(new Vector3());
  const middle = viewer.model!.bounds.getCenter(new Vector3());
  viewer.walker.lookAt(eye, new Vector3(middle.x, eye.y, middle.z));
}

/** #eye=x,y,z&to=x,y,z&method=name: a view to hand on. */
function fromAddress(): boolean {
  const wish = new URLSearchParams(location.hash.slice(1));
  const vector = (key: string): Vector3 | null => {
    const numbers = (wish.get(key) ?? '').split(',').map(Number);
    return numbers.length === 3 && numbers.every(Number.isFinite) ? new Vector3(...numbers) : null;
  };
  const method = viewer.methods.find(({ name }) => name === wish.get('method'));
  if (method) void chooseMethod(method.name);
  const eye = vector('eye'), to = vector('to');
  if (!eye || !to) return false;
  viewer.walker.lookAt(eye, to);
  setFlying(true);
  viewer.recull();
  return true;
}

// -- panel -------------------------------------------------------------------------------------------------------------
function fillMethods(): void {
  byId('methods').querySelector('tbody')!.replaceChildren(...viewer.methods.map((method, i) => {
    const radio = element('input', { type: 'radio', name: 'method', value: method.name, title: `${method.title} (${i + 1})` }) as HTMLInputElement;
    const row = element('tr', { 'data-method': method.name, title: method.title },
      element('th', { scope: 'row' }, element('label', {}, radio, method.name)), element('td'), element('td'), element('td'));
    row.addEventListener('click', () => void chooseMethod(method.name));
    return row;
  }));
  byId('second').replaceChildren(...viewer.methods.map(({ name }) => element('option', { value: name }, name)));
  void chooseMethod(viewer.method!.name);
}

/** Some methods look for occluders before their first answer. */
async function makeReady(method: Method): Promise<boolean> {
  if (!method.prepare) return true;
  let ready = false;
  await attempt(async () => {
    showProgress(`Finding occluders for ${method.name}`, null);
    await breathe();
    await method.prepare?.();
    ready = true;
  });
  return ready;
}

async function chooseMethod(name: string): Promise<void> {
  const method = viewer.methods.find((entry) => entry.name === name);
  if (!method || !(await makeReady(method)) || !viewer.methods.includes(method)) return;
  viewer.method = method;
  viewer.recull();
  for (const row of byId('methods').querySelectorAll<HTMLElement>('tbody tr')) {
    const on = row.dataset.method === name;
    row.classList.toggle('on', on);
    row.querySelector('input')!.checked = on;
  }
  byId('method-note').textContent = `${method.name}: ${method.title}.`;
}

function fillFacts(): void {
  const { model } = viewer;
  if (!model) return;
  const extent = model.bounds.getSize(new Vector3()).toArray().map((x) => Number(x.toPrecision(3))).join(' × ');
  const facts: [string, string][] = [['scene', `${model.name}, ${size(sceneBytes)}`], ['extent', extent], ...(bake?.facts ?? [])];
  if (!bake) facts.push(['.pvs', 'none; drop one here to see what it knows']);
  byId('facts').replaceChildren(...facts.map(([name, text]) => element('div', {}, element('dt', {}, name), element('dd', {}, text))));
}

/** Means over the last frames, so that a clock of 0.1 ms shows 0.02. */
const cullTimes = new Map<string, number[]>();
function meanCull(name: string, value: number): number {
  const list = cullTimes.get(name) ?? [];
  list.push(value);
  if (list.length > 60) list.shift();
  cullTimes.set(name, list);
  return list.reduce((a, b) => a + b, 0) / list.length;
}

let panelDue = 0;
function onFrame(left: FrameReport, right: FrameReport | null): void {
  const cullMs = meanCull(left.method.name, left.answer.cullMs);
  charts.push({ drawn: left.counts.drawn, hidden: left.counts.hidden, triangles: left.answer.triangles, cullMs, drawMs: left.drawMs });
  const rightMs = right && meanCull(right.method.name, right.answer.cullMs);
  if (panelDue) return;
  panelDue = window.setTimeout(() => {
    panelDue = 0;
    showNow(left, cullMs);
    byId('halves').hidden = !right;
    if (right) [left, right].forEach((report, i) => describeHalf(byId('halves').children[i], report, i ? rightMs! : cullMs));
    chosen.refresh(left);
    document.documentElement.dataset.ready = 'yes';
  }, 60);
}

function describeHalf(label: Element, { method, answer, drawMs }: FrameReport, cullMs: number): void {
  label.querySelector('strong')!.textContent = method.name;
  label.querySelector('span')!.textContent =
    `${plural(answer.count, 'object')}, ${brief(answer.triangles)} triangles, ${milliseconds(cullMs)} + ${milliseconds(drawMs)} ms`;
}

function showNow(report: FrameReport, cullMs: number): void {
  const { drawn, hidden, outOfView } = report.counts, all = viewer.model!.objects.length;
  const parts = byId('bar').children as HTMLCollectionOf<HTMLElement>;
  [drawn, hidden, outOfView].forEach((count, i) => { parts[i].style.flex = `${count} 0 0`; });
  byId('bar').setAttribute('aria-label', `${drawn} drawn, ${hidden} hidden, ${outOfView} out of view of ${all}`);
  byId('drawn').textContent = whole(drawn);
  byId('hidden').textContent = whole(hidden);
  byId('out').textContent = whole(outOfView);
  byId('triangles').textContent = brief(report.answer.triangles);
  byId('calls').textContent = whole(report.calls);
  byId('ms').textContent = `${milliseconds(cullMs)} + ${milliseconds(report.drawMs)}`;
  const { answer } = report, eye = viewer.cullCamera.position.toArray().map((x) => x.toFixed(1)).join(', ');
  byId('place').textContent = (answer.reason ? answer.reason : `${answer.guarantee}${answer.cell === null ? '' : `, cell ${answer.cell}`}`) + ` · eye ${eye}`;
  viewer.markCell(bake?.boxAt(viewer.cullCamera.position) ?? null);
  const row = byId('methods').querySelector<HTMLElement>(`tr[data-method="${report.method.name}"]`);
  if (!row) return;
  row.children[1].textContent = whole(answer.count);
  row.children[2].textContent = brief(answer.triangles);
  row.children[3].textContent = milliseconds(cullMs);
}

function showCells(choice: CellChoice): void {
  byId<HTMLSelectElement>('cells').value = viewer.cellChoice = choice;
  const range = viewer.cellRange;
  byId('legend').hidden = choice === 'none' || !range;
  if (range) {
    const [low, band, high] = byId('legend').children as HTMLCollectionOf<HTMLElement>;
    low.textContent = whole(range.least);
    high.textContent = whole(range.most);
    band.style.background = `linear-gradient(to right, ${rampColours.join(', ')})`;
  }
  viewer.redraw();
}

// -- camera and culling --------------------------------------------------------------------------------------------------
function setFlying(flying: boolean): void {
  viewer.walker.flying = flying;
  byId('walk').setAttribute('aria-pressed', String(!flying));
  byId('fly').setAttribute('aria-pressed', String(flying));
  if (!flying) viewer.walker.land();
  viewer.recull();
}

let outsideFrom: { eye: Vector3; target: Vector3; flying: boolean } | null = null;
function setFrozen(on: boolean): void {
  viewer.freeze(on);
  byId('freeze').setAttribute('aria-pressed', String(on));
  byId('banner').hidden = !on;
  byId('banner').textContent = 'Culling is frozen where you stood: move on freely.';
  if (!on) outsideFrom = null;
}

function goOutside(): void {
  if (!viewer.model) return;
  if (outsideFrom) {
    const { eye, target, flying } = outsideFrom;
    viewer.walker.flyTo(eye, target);
    setTimeout(() => { setFrozen(false); setFlying(flying); }, 950);
    outsideFrom = null;
    return;
  }
  const eye = viewer.camera.position.clone();
  const from = { eye, target: eye.clone().add(viewer.walker.direction), flying: viewer.walker.flying };
  if (!viewer.frozen) setFrozen(true);
  outsideFrom = from;
  setFlying(true);
  viewer.goOutside();
}

function setCompared(on: boolean): void {
  if (!viewer.model) return;
  const other = viewer.method!.name === 'frustum' ? 'none' : 'frustum';
  viewer.second = on ? viewer.methods.find(({ name }) => name === other)! : null;
  byId('compare').setAttribute('aria-pressed', String(on));
  byId('second-row').hidden = byId('halves').hidden = !on;
  if (on) byId<HTMLSelectElement>('second').value = viewer.second!.name;
  viewer.resize();
}

function setTour(on: boolean): void {
  byId('tour').setAttribute('aria-pressed', String(on));
  if (!on || !path) {
    viewer.autopilot = null;
    return;
  }
  if (viewer.frozen) setFrozen(false);
  const frames = path;
  let at = frames.reduce((best, frame, i) =>
    (frame.eye.distanceTo(viewer.camera.position) < frames[best].eye.distanceTo(viewer.camera.position) ? i : best), 0);
  if (at > frames.length - 3) at = 0;
  viewer.autopilot = (seconds) => {
    at = Math.min(frames.length - 1, at + seconds * 6);
    const i = Math.min(frames.length - 2, Math.floor(at)), t = at - i;
    viewer.walker.lookAt(new Vector3().lerpVectors(frames[i].eye, frames[i + 1].eye, t), new Vector3().lerpVectors(frames[i].target, frames[i + 1].target, t));
    if (at < frames.length - 1) return true;
    byId('tour').setAttribute('aria-pressed', 'false');
    return false;
  };
}

async function saveScreenshot(): Promise<void> {
  if (!viewer.model) return;
  const link = document.createElement('a');
  link.href = URL.createObjectURL(await viewer.screenshot());
  link.download = `${viewer.model.name.replace(/\.\w+$/, '')}-${viewer.method!.name}.png`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

// -- wiring ------------------------------------------------------------------------------------------------------------
function toggleHelp(): void {
  const text = byId('help-text');
  text.hidden = !text.hidden;
  byId('help').setAttribute('aria-expanded', String(!text.hidden));
  if (!text.hidden) openSheet(true);
}
function openSheet(open: boolean): void {
  byId('panel').classList.toggle('open', open);
  byId('grip').setAttribute('aria-expanded', String(open));
}

const actions: Record<string, () => void> = {
  f: () => setFrozen(!viewer.frozen), o: goOutside, c: () => setCompared(!viewer.second), g: () => setFlying(!viewer.walker.flying),
  t: () => { if (path) setTour(!viewer.autopilot); }, p: () => void saveScreenshot(), '?': toggleHelp, escape: () => chosen.choose(null),
};
addEventListener('keydown', (event) => {
  const target = event.target as HTMLElement;
  if (event.ctrlKey || event.metaKey || event.altKey || /^(SELECT|TEXTAREA)$/.test(target.tagName) || (target as HTMLInputElement).type === 'search') return;
  const key = event.key.toLowerCase();
  if (viewer.model && actions[key]) actions[key]();
  else if (viewer.model && /^[1-9]$/.test(key)) void chooseMethod(viewer.methods[Number(key) - 1]?.name ?? '');
});

byId('walk').addEventListener('click', () => setFlying(false));
byId('fly').addEventListener('click', () => setFlying(true));
byId('freeze').addEventListener('click', actions.f);
byId('outside').addEventListener('click', actions.o);
byId('compare').addEventListener('click', actions.c);
byId('tour').addEventListener('click', actions.t);
byId('screenshot').addEventListener('click', actions.p);
byId('help').addEventListener('click', toggleHelp);
byId('grip').addEventListener('click', () => openSheet(!byId('panel').classList.contains('open')));
byId('now').addEventListener('click', () => { if (getComputedStyle(byId('grip')).display !== 'none') openSheet(!byId('panel').classList.contains('open')); });
byId('second').addEventListener('change', async (event) => {
  const method = viewer.methods.find(({ name }) => name === (event.target as HTMLSelectElement).value)!;
  if (!(await makeReady(method)) || !viewer.second) return;
  viewer.second = method;
  viewer.recull();
});
byId('cells').addEventListener('change', (event) => showCells((event.target as HTMLSelectElement).value as CellChoice));
const checkbox = (id: string, set: (on: boolean) => void): void =>
  byId(id).addEventListener('change', (event) => { set((event.target as HTMLInputElement).checked); viewer.redraw(); });
checkbox('show-hidden', (on) => { viewer.showHidden = on; });
checkbox('show-ink', (on) => { viewer.showInk = on; });
checkbox('cut-open', (on) => { viewer.cutsOpen = on; });
checkbox('show-outside', (on) => { viewer.showOutside = on; });
checkbox('own-materials', (on) => viewer.useOwnMaterials(on));
byId('find').addEventListener('change', (event) => {
  const wish = (event.target as HTMLInputElement).value.trim();
  const object = viewer.model?.objects.find(({ name }) => name === wish) ?? viewer.model?.objects.find(({ name }) => name.includes(wish));
  if (wish && object) chosen.choose([object]);
  else if (wish) say(`No object is called ${wish}`, 'note');
});
viewer.onFrame = onFrame;
// Not before the tap is over: its click would meet the sheet.
viewer.walker.onClick = (x, y) => chosen.chooseAt(x, y, () => setTimeout(() => openSheet(true), 80));
viewer.walker.onTake = () => {
  byId('keys').classList.add('gone');
  if (viewer.autopilot) setTour(false);
};
setUpStick(byId('stick'), viewer.walker);
setUpTheme(() => {
  viewer.setTheme(isDark());
  charts.rebuild();
});
setUpDropping((files) => void takeFiles(files));
addEventListener('hashchange', () => { if (viewer.model) fromAddress(); });
byId('picture').addEventListener('webglcontextlost', () => say('The browser took the graphics away; load the page again.'));

async function begin(): Promise<void> {
  await attempt(async () => {
    offer = await findOffer();
    if (!offer) return;
    byId('welcome').hidden = true;
    const { name, scene, pvs, byOrder } = offer;
    const bytes = await download(scene, (share) => showProgress(`Loading ${name}`, share));
    await takeScene({ name, bytes, folder: new URL(scene, location.href).href.replace(/[^/]*$/, '') });
    chosen.explains = offer.explains;
    if (pvs) await takeBake(pvs.split('/').pop()!, await download(pvs, (share) => showProgress('Loading the .pvs', share)), byOrder);
    else fromAddress();
  });
  if (!viewer.model) byId('welcome').hidden = false;
  else if (offer && document.querySelector('meta[name=antumbra-server]')) {
    path = await fetchPath().catch(() => null);
    byId('tour').hidden = !path;
    if (path && !location.hash) startInside();
  }
  document.documentElement.dataset.loaded = 'yes';
}
void begin();

// For the console, tests and benchmarks: the parts by name.
Object.assign(window, { antumbraViewer: { viewer, chosen, takeFiles, get bake() { return bake; } } });
