// The picture: draws what a method says, from one camera, while another one may decide what that is.
import {
  BufferGeometry, DoubleSide, EdgesGeometry, Float32BufferAttribute, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, Object3D, PerspectiveCamera, Plane, Scene, Vector3, WebGLRenderer,
} from 'three';
import { Cells, type Cell, type CellChoice } from './cells';
import { ask, emptyAnswer, type Answer, type Method } from './culling';
import { Looks } from './looks';
import { disposeModel, extentOf, type Model, type SceneObject } from './model';
import { Picking } from './picking';
import { States } from './states';
import { overviewOf, Walker } from './walker';
import { Wires } from './wires';

export interface FrameReport {
  method: Method;
  answer: Answer;
  /** drawn, hidden although in the frustum, out of view. */
  counts: { drawn: number; hidden: number; outOfView: number };
  calls: number;
  drawMs: number;
}

/** Lines and tinted objects that belong to an explanation. */
export interface Marks {
  lines: { from: Vector3; to: Vector3; colour: string }[];
  objects: { object: SceneObject; colour: string }[];
}

const colourOf = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();

/** Methods learn from frame to frame which occluders pay: so many frames after the last change the answer stands. */
const kSettling = 12;

export class Viewer {
  readonly camera = new PerspectiveCamera(60, 1, 0.1, 1000);
  readonly walker: Walker;
  readonly renderer: WebGLRenderer;
  model: Model | null = null;
  picking: Picking | null = null;
  states: States | null = null;
  methods: Method[] = [];
  method: Method | null = null;
  /** Not null: two pictures side by side, this one on the right. */
  second: Method | null = null;
  /** Not null: culling is frozen to this camera. */
  frozen: PerspectiveCamera | null = null;
  showHidden = true;
  showOutside = false;
  showInk = true;
  cellChoice: CellChoice = 'none';
  /** Seen from above, with the culling frozen: leave out what is above the eye that was frozen. */
  cutsOpen = true;
  onFrame: (left: FrameReport, right: FrameReport | null) => void = () => {};
  private readonly scene = new Scene();
  /** Edges of what is drawn, cut open with it. */
  private readonly drawing = new Scene();
  private readonly overlay = new Scene();
  private readonly cut = new Plane(new Vector3(0, -1, 0));
  private readonly world = new Group();
  private readonly marks = new Group();
  private readonly pyramid = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ transparent: true, opacity: 0.9, fog: false }));
  private readonly looks = new Looks(this.scene);
  private wires: Wires | null = null;
  private cells: Cells | null = null;
  private answers: [Answer, Answer, Answer] | null = null;
  private frustum: Method | null = null;
  private cullNeeded = true;
  private renderNeeded = true;
  private dark = false;
  private last = 0;
  private readonly pixel = new Uint8Array(4);
  /** Moves the camera by itself; returns false when it is done. */
  autopilot: ((seconds: number) => boolean) | null = null;

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: false });
    this.renderer.info.autoReset = true;
    this.renderer.autoClear = false;
    this.world.updateMatrixWorld = () => {};
    this.scene.add(this.world);
    this.pyramid.frustumCulled = false;
    this.pyramid.visible = false;
    this.overlay.add(this.pyramid, this.marks);
    this.walker = new Walker(this.camera, canvas, (origin, direction, far) => this.picking?.first(origin, direction, far) ?? null);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    this.resize();
    requestAnimationFrame((time) => this.frame(time));
  }

  /** Takes the place of the scene before. */
  setModel(model: Model, methods: Method[]): void {
    this.clear();
    this.model = model;
    const count = model.objects.length;
    this.states = new States(count);
    this.answers = [emptyAnswer(count), emptyAnswer(count), emptyAnswer(count)];
    this.frustum = methods.find(({ name }) => name === 'frustum')!;
    this.picking = new Picking(model);
    this.method = this.frustum;
    this.setMethods(methods);
    this.scene.add(model.rest);
    const extent = extentOf(model.bounds);
    this.camera.near = extent * 2e-4;
    this.camera.far = extent * 8;
    if (extent > 4 && extent < 20_000) {
      this.walker.eyeHeight = 1.65;
      this.walker.speed = 3;
      this.camera.near = Math.min(this.camera.near, 0.05);
    } else {
      this.walker.eyeHeight = extent / 12;
      this.walker.speed = extent / 6;
    }
    this.wires = new Wires(model, this.walker.eyeHeight * 8, () => this.redraw());
    this.overlay.add(this.wires.group);
    this.drawing.add(this.wires.ink.group);
    this.looks.apply(model, model.hasColours);
    this.setTheme(this.dark);
    this.resize();
  }

  private clear(): void {
    this.select(null);
    this.setMarks(null);
    this.setCells(null);
    this.frozen = null;
    this.second = null;
    this.autopilot = null;
    if (!this.model) return;
    this.wires!.group.removeFromParent();
    this.wires!.ink.group.removeFromParent();
    this.wires!.dispose();
    this.model.rest.removeFromParent();
    disposeModel(this.model);
    this.world.children = [];
    this.model = null;
  }

  setMethods(methods: Method[]): void {
    this.methods = methods;
    this.method = methods.find(({ name }) => name === this.method?.name) ?? this.frustum;
    this.second = methods.find(({ name }) => name === this.second?.name) ?? null;
    this.recull();
  }

  setCells(cells: Cell[] | null): void {
    this.cells?.group.removeFromParent();
    this.cells?.dispose();
    this.cells = cells && new Cells(cells);
    if (this.cells) {
      this.overlay.add(this.cells.group);
      this.cells.setAccent(colourOf('accent'));
    }
    this.recull();
  }
  get cellRange(): { least: number; most: number } | null { return this.cells && { least: this.cells.least, most: this.cells.most }; }

  setTheme(dark: boolean): void {
    this.dark = dark;
    if (this.model) this.looks.setTheme(dark, extentOf(this.model.bounds));
    this.wires?.hidden.setColour(colourOf('bad'));
    this.wires?.outside.setColour(colourOf('muted'));
    this.wires?.ink.setColour(dark ? '#0b0d10' : '#3a352c');
    this.cells?.setAccent(colourOf('accent'));
    (this.pyramid.material as LineBasicMaterial).color.set(colourOf('accent'));
    this.redraw();
  }

  useOwnMaterials(own: boolean): void {
    if (this.model) this.looks.apply(this.model, own);
    this.redraw();
  }

  redraw(): void { this.renderNeeded = true; }
  recull(): void {
    this.cullNeeded = this.renderNeeded = true;
    this.settling = kSettling;
  }
  /** How many more frames are culled although nothing moves. */
  settling = 0;

  freeze(on: boolean): void {
    this.frozen = on ? this.camera.clone() : null;
    this.frozen?.updateMatrixWorld();
    this.pyramid.visible = on;
    if (on) this.drawPyramid();
    this.recull();
  }

  goOutside(): void {
    if (!this.model) return;
    this.walker.flying = true;
    const { eye, target } = overviewOf(this.model.bounds, this.camera);
    this.walker.flyTo(eye, target);
  }

  /** The camera that decides what is drawn. */
  get cullCamera(): PerspectiveCamera { return this.frozen ?? this.camera; }

  private drawPyramid(): void {
    const camera = this.frozen!, points: Vector3[] = [];
    const far = Math.min(extentOf(this.model!.bounds) * 0.25, 60 * this.walker.eyeHeight);
    const tangent = Math.tan((camera.fov * Math.PI) / 360), eye = camera.position;
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) =>
      new Vector3(x * tangent * camera.aspect, y * tangent, -1).multiplyScalar(far).applyMatrix4(camera.matrixWorld));
    corners.forEach((corner, i) => points.push(eye, corner, corner, corners[(i + 1) % 4]));
    this.pyramid.geometry.dispose();
    this.pyramid.geometry = new BufferGeometry().setFromPoints(points);
  }

  /** Outlines an object; null: none. */
  select(object: SceneObject | null): void {
    this.selected = object;
    this.remark();
  }
  selected: SceneObject | null = null;
  private shownMarks: Marks | null = null;
  setMarks(marks: Marks | null): void {
    this.shownMarks = marks;
    this.remark();
  }

  private remark(): void {
    this.marks.traverse((object: Object3D) => {
      const mesh = object as Mesh;
      if (mesh.userData.ownGeometry) mesh.geometry.dispose();
      if (mesh.isMesh || object.type === 'LineSegments') (mesh.material as MeshBasicMaterial).dispose();
    });
    this.marks.clear();
    for (const { object, colour } of this.shownMarks?.objects ?? []) this.tint(object, colour, 0.38);
    if (this.selected) this.tint(this.selected, colourOf('accent'), 0.45);
    for (const { from, to, colour } of this.shownMarks?.lines ?? []) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new Float32BufferAttribute([...from.toArray(), ...to.toArray()], 3));
      for (const [depthTest, opacity] of [[true, 1], [false, 0.35]] as const) {
        const line = new LineSegments(geometry, new LineBasicMaterial({ color: colour, transparent: true, opacity, depthTest, depthWrite: false, fog: false }));
        line.userData.ownGeometry = true;
        line.renderOrder = 8;
        this.marks.add(line);
      }
    }
    this.redraw();
  }

  private tint({ mesh, triangles }: SceneObject, colour: string, opacity: number): void {
    const fill = new Mesh(mesh.geometry, new MeshBasicMaterial({ color: colour, transparent: true, opacity, depthTest: false, depthWrite: false, side: DoubleSide, fog: false }));
    fill.renderOrder = 6;
    const parts: Object3D[] = [fill];
    if (triangles < 20_000) {
      const edges = new LineSegments(new EdgesGeometry(mesh.geometry, 25), new LineBasicMaterial({ color: colour, depthTest: false, transparent: true, opacity: 0.9, fog: false }));
      edges.renderOrder = 7;
      edges.userData.ownGeometry = true;
      parts.push(edges);
    }
    for (const part of parts) {
      part.matrixAutoUpdate = part.matrixWorldAutoUpdate = false;
      part.frustumCulled = false;
      part.matrixWorld.copy(mesh.matrixWorld);
      this.marks.add(part);
    }
  }

  /** Direction of the ray through a point of the page. */
  rayThrough(x: number, y: number): Vector3 {
    const box = this.canvas.getBoundingClientRect();
    let across = (x - box.left) / box.width;
    if (this.second) across = (across * 2) % 1;
    return new Vector3(across * 2 - 1, 1 - ((y - box.top) / box.height) * 2, 0.5).unproject(this.camera).sub(this.camera.position).normalize();
  }

  private frame(time: number): void {
    requestAnimationFrame((next) => this.frame(next));
    const seconds = Math.min(0.25, (time - this.last) / 1000);
    this.last = time;
    if (!this.model) return;
    let moved = this.walker.update(seconds) || this.walker.moved;
    this.walker.moved = false;
    if (this.autopilot) {
      moved = true;
      if (!this.autopilot(seconds)) this.autopilot = null;
    }
    if (moved) this.frozen ? this.redraw() : this.recull();
    else if (this.settling > 0) {
      this.settling -= 1;
      this.cullNeeded = this.renderNeeded = true;
    }
    if (this.renderNeeded) this.draw();
  }

  /** Decides and draws one frame now. */
  draw(): void {
    if (!this.model || !this.method || this.camera.aspect === 0) return;
    this.camera.updateMatrixWorld();
    this.cull();
    this.renderNeeded = false;
    const { width, height } = this.size;
    const showsCells = this.cells !== null && this.cellChoice !== 'none';
    this.cells?.show(this.cellChoice, this.cullCamera.position);
    this.cells && (this.cells.group.visible = showsCells || this.frozen !== null);
    if (this.wires) {
      this.wires.hidden.group.visible = this.showHidden;
      this.wires.outside.group.visible = this.showOutside;
      this.wires.ink.group.visible = this.showInk;
    }
    const half = Math.floor(width / 2), [first, second, third] = this.answers!;
    const left = this.drawHalf(this.method, first, third, 0, this.second ? half : width, height);
    const right = this.second ? this.drawHalf(this.second, second, third, half, width - half, height) : null;
    if (right) this.states!.set(first.visible, third.visible); // what the rest of the page speaks of
    this.onFrame(left, right);
  }

  private cull(): void {
    if (!this.cullNeeded) return;
    this.cullNeeded = false;
    const [first, second, inFrustum] = this.answers!;
    ask(this.frustum!, this.model!, this.cullCamera, inFrustum);
    ask(this.method!, this.model!, this.cullCamera, first);
    if (this.second) ask(this.second, this.model!, this.cullCamera, second);
  }

  private get size(): { width: number; height: number } {
    const place = this.canvas.parentElement!;
    return { width: Math.max(1, place.clientWidth), height: Math.max(1, place.clientHeight) };
  }

  private drawHalf(method: Method, answer: Answer, inFrustum: Answer, x: number, width: number, height: number): FrameReport {
    const { renderer, model } = this, list: Object3D[] = [];
    for (const object of model!.objects) if (answer.visible[object.index]) list.push(object.mesh);
    this.world.children = list;
    const [outOfView, hidden, drawn] = this.states!.set(answer.visible, inFrustum.visible);
    this.wires?.update(this.states!);
    renderer.setViewport(x, 0, width, height);
    renderer.setScissor(x, 0, width, height);
    renderer.setScissorTest(true);
    this.cut.constant = this.cullCamera.position.y + 0.3 * this.walker.eyeHeight;
    const isCut = this.cutsOpen && this.frozen !== null && this.camera.position.y > this.cut.constant;
    renderer.clippingPlanes = isCut ? [this.cut] : [];
    const start = performance.now();
    renderer.clear();
    renderer.render(this.scene, this.camera);
    const calls = renderer.info.render.calls;
    // Reading one pixel waits until the card has drawn: the time is that of the frame, not of giving orders.
    const gl = renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, this.pixel);
    const drawMs = performance.now() - start;
    if (this.showInk) renderer.render(this.drawing, this.camera);
    renderer.clippingPlanes = [];
    renderer.render(this.overlay, this.camera);
    return { method, answer, counts: { drawn, hidden, outOfView }, calls, drawMs };
  }

  /** Outlines the box of the culling camera's cell. */
  markCell(box: Cell['box'] | null): void { this.cells?.mark(box); }

  /** The picture as it is, as a PNG. */
  async screenshot(): Promise<Blob> {
    this.draw();
    return await new Promise((resolve, reject) =>
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('the browser gave no picture'))), 'image/png'));
  }

  resize(): void {
    const { width, height } = this.size;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = (this.second ? width / 2 : width) / height;
    // A tall picture keeps its width of view instead of its height.
    this.camera.fov = this.camera.aspect >= 1 ? 60 : Math.min(85, (2 * Math.atan(Math.tan(Math.PI / 6) / this.camera.aspect) * 180) / Math.PI);
    this.camera.updateProjectionMatrix();
    this.recull();
  }
}
