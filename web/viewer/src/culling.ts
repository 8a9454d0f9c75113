// The methods that can decide what is drawn, all by the package `antumbra`, behind one interface.
import { Mesh, PerspectiveCamera, Vector3 } from 'three';
import { CullScene, type Culler, type Occluders } from 'antumbra/cull';
import { breathe, type Model } from './model';
import { isDoubleSided, isSeeThrough } from './picking';

export interface Answer {
  /** One byte per object of the model: 1: drawn. */
  visible: Uint8Array;
  count: number;
  triangles: number;
  /** Of this call alone. */
  cullMs: number;
  guarantee: string;
  /** Number of the view cell, if the method has one. */
  cell: number | null;
  /** Why the method could not tell and draws everything; ''. */
  reason: string;
}

export interface Method {
  readonly name: string;
  readonly title: string;
  /** Null once it can answer; else what makes it ready, to be awaited before the first cull(). */
  readonly prepare: (() => Promise<void>) | null;
  /** Writes its answer for a view into `into`. */
  cull(camera: PerspectiveCamera, into: Answer): void;
}

export const emptyAnswer = (count: number): Answer =>
  ({ visible: new Uint8Array(count), count: 0, triangles: 0, cullMs: 0, guarantee: 'conservative', cell: null, reason: '' });

/** Runs a method with a clock; adds up what it draws. */
export function ask(method: Method, model: Model, camera: PerspectiveCamera, into: Answer): void {
  into.cell = null;
  into.reason = '';
  const start = performance.now();
  method.cull(camera, into);
  into.cullMs = performance.now() - start;
  into.count = into.triangles = 0;
  for (let i = 0; i < into.visible.length; ++i)
    if (into.visible[i]) {
      ++into.count;
      into.triangles += model.objects[i].triangles;
    }
}

const eye = new Vector3(), direction = new Vector3(), up = new Vector3();

/** A culler of the package. `indexOf` gives the model's object for each object of the cull scene, -1 where it has none;
 * objects that the cull scene lacks are always drawn. */
export class PackageMethod implements Method {
  prepare: (() => Promise<void>) | null = null;
  private culler: Culler | null;

  constructor(readonly name: string, readonly title: string, culler: Culler | null, private indexOf: Int32Array | null = null,
    private readonly cellAt: ((eye: Vector3) => number | null) | null = null) {
    this.culler = culler;
  }

  setCuller(culler: Culler, indexOf: Int32Array | null): void {
    this.culler = culler;
    this.indexOf = indexOf;
    this.prepare = null;
  }

  cull(camera: PerspectiveCamera, into: Answer): void {
    camera.getWorldPosition(eye);
    camera.getWorldDirection(direction);
    up.set(0, 1, 0).transformDirection(camera.matrixWorld);
    const answer = this.culler!.cull({
      eye: eye.toArray(), direction: direction.toArray(), up: up.toArray(), fov: camera.fov, aspect: camera.aspect, near: camera.near,
      far: camera.far,
    });
    const { visible } = into;
    if (this.indexOf) {
      visible.fill(1);
      const { bits } = answer;
      for (let id = 0; id < this.indexOf.length; ++id) {
        const index = this.indexOf[id];
        if (index >= 0) visible[index] = (bits[id >> 3] >> (id & 7)) & 1;
      }
    } else {
      visible.fill(0);
      for (const id of answer.ids) visible[id] = 1;
    }
    into.guarantee = answer.guarantee;
    into.reason = answer.reason;
    if (this.cellAt) {
      into.cell = this.cellAt(eye);
      if (answer.everything) into.reason ||= 'no baked cell here';
    }
  }
}

const titles: Record<string, string> = {
  none: 'everything, whatever the view',
  frustum: 'what lies in the viewing pyramid',
  planes: 'less what large convex occluders hide, by supporting and separating planes (Coorg and Teller 1997)',
  masked: 'less what a small picture of the occluders hides',
  pvs: 'what the baked file lists for the cell, in the viewing pyramid',
};
export const titleOf = (name: string): string => titles[name] ?? name;

/** Methods of the package that are drawn up for comparison, in this order. */
export const occlusionMethods = ['planes', 'masked'];

function boundsOf(model: Model): Float64Array {
  const bounds = new Float64Array(model.objects.length * 6);
  model.objects.forEach(({ box }, i) => bounds.set([...box.min.toArray(), ...box.max.toArray()], i * 6));
  return bounds;
}

/** What a scene without a bake can be culled with. The methods with occluders find them when they are first asked for. */
export async function methodsOf(model: Model): Promise<Method[]> {
  const boxes = await CullScene.create({ bounds: boundsOf(model) });
  const methods: Method[] = ['none', 'frustum'].map((name) => new PackageMethod(name, titleOf(name), boxes.createCuller(name)));
  let scene: Promise<CullScene> | null = null;
  for (const name of occlusionMethods) {
    const method = new PackageMethod(name, titleOf(name), null);
    method.prepare = async () => {
      scene ??= occludersOf(model).then((occluders) => CullScene.create({ bounds: boundsOf(model), occluders }));
      method.setCuller((await scene).createCuller(name), null);
    };
    methods.push(method);
  }
  return methods;
}

/** More occluders cost more memory than they hide. */
const mostOccluders = 150_000;

/** Triangles that block sight, the largest of them where there are many. World coordinates. */
async function occludersOf(model: Model): Promise<Occluders> {
  const solid = model.objects.filter((object) => !isSeeThrough(object));
  const total = solid.reduce((sum, { triangles }) => sum + triangles, 0);
  // Whole objects, largest faces first, so that what is connected stays connected.
  const worth = solid.map((object) => {
    const size = object.box.getSize(new Vector3());
    return { object, worth: (size.x * size.y + size.y * size.z + size.z * size.x) / Math.max(1, object.triangles) };
  });
  if (total > mostOccluders) worth.sort((a, b) => b.worth - a.worth);
  const vertices: number[] = [], triangles: number[] = [], twoSided: number[] = [], point = new Vector3();
  let clock = performance.now();
  for (const { object } of worth) {
    if (triangles.length / 3 + object.triangles > mostOccluders) continue;
    if (performance.now() - clock > 8) {
      await breathe();
      clock = performance.now();
    }
    const { geometry, matrixWorld } = object.mesh as Mesh, base = vertices.length / 3, { position } = geometry.attributes;
    for (let i = 0; i < position.count; ++i) {
      point.fromBufferAttribute(position, i).applyMatrix4(matrixWorld);
      vertices.push(point.x, point.y, point.z);
    }
    const mirrored = matrixWorld.determinant() < 0, sides = isDoubleSided(object) ? 1 : 0;
    for (let t = 0; t < object.triangles; ++t) {
      const [a, b, c] = [0, 1, 2].map((k) => base + (geometry.index ? geometry.index.getX(3 * t + k) : 3 * t + k));
      triangles.push(a, mirrored ? c : b, mirrored ? b : c);
      twoSided.push(sides);
    }
  }
  return { vertices, triangles, twoSided };
}
