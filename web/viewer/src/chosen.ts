// The object that the user has chosen: what became of it, and why.
import { Vector3 } from 'three';
import type { Bake } from './bake';
import { element, plural, swatch, whole } from './dom';
import type { SceneObject } from './model';
import { surfacePoints } from './picking';
import { fetchExplanation, type Explanation, type SightAnswer } from './server';
import { drawn, hidden } from './states';
import type { FrameReport, Marks, Viewer } from './viewer';

const green = '#3f9a5f', blue = '#4f7fd0', orange = '#e08a2e', yellow = '#d9b430';
const raysOfOwn = 400;

export class Chosen {
  bake: Bake | null = null;
  /** Does a server answer api/explain? */
  explains = false;
  private object: SceneObject | null = null;
  private others: SceneObject[] = [];
  private question = 0;
  private readonly state = element('p', { class: 'state' });
  private readonly method = element('p', { class: 'muted' });
  private readonly why = element('div');
  private report: FrameReport | null = null;

  constructor(private readonly viewer: Viewer, private readonly place: HTMLElement) {}

  /** What lies under a point of the page: the first is chosen, the others are offered. Only what can be seen counts: objects
   * that are drawn, and hidden ones while their wires show. */
  chooseAt(x: number, y: number, opened: () => void): void {
    const { viewer } = this;
    if (!viewer.picking) return;
    const hits = viewer.picking.along(viewer.camera.position, viewer.rayThrough(x, y)).map(({ object }) => object);
    const shown = hits.filter(({ index }) => {
      const state = viewer.states!.values[index];
      return state === drawn || (state === hidden ? viewer.showHidden : viewer.showOutside);
    });
    this.choose(shown.length > 0 ? shown : null);
    if (shown.length > 0) opened();
  }

  choose(objects: SceneObject[] | null): void {
    this.others = objects ?? [];
    this.take(objects?.[0] ?? null);
  }

  private take(object: SceneObject | null): void {
    this.object = object;
    ++this.question;
    this.viewer.setMarks(null);
    this.viewer.select(object);
    this.place.hidden = object === null;
    if (!object) return;
    const close = element('button', { type: 'button', 'aria-label': 'Let go', title: 'Let go (Esc)' }, '×');
    close.addEventListener('click', () => this.choose(null));
    const id = this.bake ? this.bake.idOf(object.index) : object.index;
    const who = [id >= 0 ? `object ${id}` : 'not in the .pvs', `node ${object.node}`, object.primitive > 0 ? `primitive ${object.primitive}` : '',
      object.instance >= 0 ? `instance ${object.instance}` : '', plural(object.triangles, 'triangle')].filter(Boolean).join(' · ');
    const buttons = element('div', { class: 'pair' });
    const button = (text: string, act: () => void): void => {
      const made = element('button', { type: 'button' }, text);
      made.addEventListener('click', act);
      buttons.append(made);
    };
    button('Ask again from here', () => void this.explain());
    button('Look at it', () => this.lookAt(object));
    this.why.replaceChildren();
    this.place.replaceChildren(element('header', {}, element('h3', {}, object.name), close), element('p', { class: 'muted' }, who),
      this.state, this.method, this.why, buttons, ...this.listOfOthers());
    this.place.parentElement!.scrollTop = 0;
    if (this.report) this.refresh(this.report);
    void this.explain();
  }

  private listOfOthers(): HTMLElement[] {
    if (this.others.length < 2) return [];
    const list = element('ul', { 'aria-label': 'Along the same line' });
    for (const object of this.others.slice(0, 12)) {
      const choose = element('button', { type: 'button' }, object.name);
      choose.addEventListener('click', () => this.take(object));
      const state = this.viewer.states!.values[object.index];
      list.append(element('li', {}, swatch(state === drawn ? 'drawn' : state === hidden ? 'hidden-part' : 'out'), ' ', choose));
    }
    return [element('p', { class: 'muted' }, 'Along the same line:'), list];
  }

  /** What the method of the last frame did with it. */
  refresh(report: FrameReport): void {
    this.report = report;
    if (!this.object) return;
    const state = this.viewer.states!.values[this.object.index];
    const words = state === drawn ? 'drawn' : state === hidden ? 'hidden' : 'out of view';
    this.state.replaceChildren(swatch(state === drawn ? 'drawn' : state === hidden ? 'hidden-part' : 'out'), words);
    this.method.textContent = this.reasonOf(report, state);
  }

  private reasonOf({ method, answer }: FrameReport, state: number): string {
    const cell = answer.cell === null ? 'the cell' : `cell ${answer.cell}`;
    if (answer.reason && state === drawn) return `${method.name} draws everything here: ${answer.reason}.`;
    if (state !== drawn && state !== hidden) return 'Its box lies outside the viewing pyramid.';
    if (method.name === 'none') return 'Nothing is culled.';
    if (method.name === 'frustum') return 'Its box touches the viewing pyramid; nobody asked what stands before it.';
    if (method.name === 'pvs')
      return state === drawn ? `The list of ${cell} has it, and its box touches the viewing pyramid.`
        : `In the viewing pyramid, but not on the list of ${cell} (${answer.guarantee}).`;
    return state === drawn ? `No occluder that ${method.name} used hides all of its box.` : `Occluders that ${method.name} used hide all of its box.`;
  }

  private lookAt(object: SceneObject): void {
    const { walker, camera } = this.viewer, middle = object.box.getCenter(new Vector3());
    if (!this.viewer.frozen) return walker.lookAt(camera.position.clone(), middle);
    const distance = Math.max(object.box.getSize(new Vector3()).length() * 1.6, camera.near * 20);
    const away = camera.position.clone().sub(middle).normalize();
    walker.flyTo(middle.clone().addScaledVector(away, distance), middle);
  }

  private async explain(): Promise<void> {
    const object = this.object!, eye = this.viewer.cullCamera.position.clone(), question = ++this.question;
    const id = this.bake?.idOf(object.index) ?? -1;
    if (!this.explains || id < 0) return this.show(...this.askOwnRays(object, eye));
    this.why.replaceChildren(element('p', { class: 'why' }, 'Asking for a proof…'));
    try {
      const explanation = await fetchExplanation(id, eye);
      if (question === this.question) this.show(...this.tell(explanation, object));
    } catch (error) {
      if (question !== this.question) return;
      const [blocks, marks] = this.askOwnRays(object, eye);
      blocks.push(element('p', { class: 'muted' }, `The server gave no proof: ${error instanceof Error ? error.message : error}`));
      this.show(blocks, marks);
    }
  }

  private show(blocks: HTMLElement[], marks: Marks): void {
    this.why.replaceChildren(...blocks);
    this.viewer.setMarks(marks);
  }

  private hiderList(hiders: { object: SceneObject; share: number }[]): HTMLElement {
    const list = element('ul');
    for (const { object, share } of hiders.slice(0, 8)) {
      const choose = element('button', { type: 'button' }, object.name);
      choose.addEventListener('click', () => this.choose([object]));
      list.append(element('li', {}, choose, share > 0 ? ` ${(share * 100).toFixed(share < 0.01 ? 1 : 0)} % of the lines` : ''));
    }
    return list;
  }

  // -- the server's proof ----------------------------------------------------------------------------------------------
  private tell(explanation: Explanation, object: SceneObject): [HTMLElement[], Marks] {
    const marks: Marks = { lines: [], objects: [] }, blocks: HTMLElement[] = [];
    blocks.push(this.tellOne(explanation.from_eye, 'from here', marks, orange));
    const cell = explanation.from_cell;
    const name = explanation.cell?.index == null ? 'the cell' : `cell ${explanation.cell.index}`;
    if (cell) blocks.push(this.tellOne(cell, cell.answer === 'visible' ? `from somewhere in ${name}` : `from all of ${name}`, marks, yellow));
    const listed = explanation.pvs?.listed, truth = cell?.answer ?? explanation.from_eye.answer;
    if (explanation.pvs?.always_visible) blocks.push(element('p', { class: 'muted' }, 'It moves or was told never to be culled: it is always drawn.'));
    else if (listed === false && truth === 'visible')
      blocks.push(element('p', { class: 'why bad' }, element('strong', {}, 'The .pvs does not list it'), `It is ${explanation.pvs!.guarantee}: it may miss what can be seen.`));
    else if (listed === true && truth === 'hidden')
      blocks.push(element('p', { class: 'why warn' }, element('strong', {}, 'The .pvs lists it all the same'), 'That costs time, never a hole in the picture.'));
    marks.objects = marks.objects.filter((mark) => mark.object !== object).slice(0, 12);
    return [blocks, marks];
  }

  private tellOne(sight: SightAnswer, where: string, marks: Marks, colour: string): HTMLElement {
    const small = (text: string): HTMLElement => element('small', {}, text);
    if (sight.answer === 'visible') {
      if (sight.witness) marks.lines.push({ from: new Vector3(...(sight.witness.from as [number, number, number])), to: new Vector3(...(sight.witness.to as [number, number, number])), colour });
      return element('div', { class: 'why good' }, element('strong', {}, `Visible ${where}: proved`),
        sight.touches ? 'The viewpoint touches it.' : 'A line of sight is free, by exact arithmetic; it is drawn in the picture.',
        ...(sight.lines_through > 0 ? [small(`${whole(sight.lines_through)} of ${plural(sight.sight_lines, 'sight line')} got through`)]
          : sight.touches ? [] : [small('No sight line found it; the proof did.')]));
    }
    const hiders = sight.hiders.map(({ id, share }) => ({ object: this.viewer.model!.objects[this.bake!.indexOf(id)], share })).filter(({ object }) => object);
    for (const { object } of hiders) marks.objects.push({ object, colour: blue });
    const proved = sight.answer === 'hidden';
    return element('div', { class: proved ? 'why bad' : 'why warn' },
      element('strong', {}, proved ? `Hidden ${where}: proved` : `Undecided ${where}`),
      proved ? 'No line of sight gets through. What hides it is tinted blue:' : `None of ${plural(sight.sight_lines, 'sight line')} got through, but the proof was not finished. In the way:`,
      this.hiderList(hiders), ...(sight.certificate?.verified ? [small('The certificate was accepted by the independent verifier.')] : []));
  }

  // -- rays of our own -------------------------------------------------------------------------------------------------
  private askOwnRays(object: SceneObject, eye: Vector3): [HTMLElement[], Marks] {
    const { picking } = this.viewer, marks: Marks = { lines: [], objects: [] };
    const met = new Map<SceneObject, number>();
    let reached = 0, counted = 0, free: Vector3 | null = null;
    for (const point of surfacePoints(object, raysOfOwn)) {
      const way = point.clone().sub(eye), length = way.length();
      if (length < 1e-9) continue;
      ++counted;
      const first = picking!.firstOpaque(eye, way.divideScalar(length), length * (1 - 1e-4));
      if (!first || first.object === object) {
        ++reached;
        free ??= point;
      } else met.set(first.object, (met.get(first.object) ?? 0) + 1);
    }
    const note = element('small', {}, `Rays in this browser, single precision: a hint, not a proof.${this.bake ? ' Proofs: antumbra view, or antumbra explain.' : ''}`);
    if (reached > 0) {
      marks.lines.push({ from: eye, to: free!, colour: green });
      return [[element('div', { class: 'why good' }, element('strong', {}, 'Seen from here, it seems'),
        `${whole(reached)} of ${plural(counted, 'ray')} towards it got through; one is drawn in the picture.`, note)], marks];
    }
    const hiders = [...met.entries()].sort((a, b) => b[1] - a[1]).map(([hider, count]) => ({ object: hider, share: count / counted }));
    for (const { object: hider } of hiders.slice(0, 8)) marks.objects.push({ object: hider, colour: blue });
    return [[element('div', { class: 'why warn' }, element('strong', {}, 'Hidden from here, it seems'),
      `None of ${plural(counted, 'ray')} towards it got through. In the way, tinted blue:`, this.hiderList(hiders), note)], marks];
  }
}
