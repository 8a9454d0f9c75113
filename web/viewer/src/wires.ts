// The edges of all objects as lines: of the hidden ones in red, of those out of view in grey, of the drawn ones as the thin
// ink of a drawing. All three share one buffer of end points; each has a list of the segments that it shows, so that a
// frame costs three draw calls and as many segments as there are to see. Until edges are ready, and for objects beyond
// the budget, boxes stand in.
import {
  BufferAttribute, BufferGeometry, DynamicDrawUsage, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Vector3,
} from 'three';
import { breathe, type Model, type SceneObject } from './model';
import { drawn, hidden, outOfView, type States } from './states';

const mostSegments = 900_000;
const corners = [0, 1, 1, 3, 3, 2, 2, 0, 4, 5, 5, 7, 7, 6, 6, 4, 0, 4, 1, 5, 2, 6, 3, 7];

/** End points of the segments of all objects, those of one object in a row. */
interface Segments {
  positions: BufferAttribute;
  /** Object i has the end points first[i] to first[i + 1]. */
  first: Uint32Array;
  /** Are those of object i only its box? */
  isBox: Uint8Array;
  /** 0, 1, 2, ..: what lists are copied from. */
  counting: Uint32Array;
}

/** The segments of all objects in one state. `behind`: how strongly they show behind other things. */
class StateLines {
  readonly group = new Group();
  private readonly materials: LineBasicMaterial[] = [];
  private geometry = new BufferGeometry();
  /** Distance from which ink begins to fade. */
  readonly reach = { value: 1 };

  constructor(private readonly state: number, private readonly withBoxes: boolean, opacity: number, behind: number) {
    for (const [depthTest, strength] of [[true, opacity], [false, behind]] as const) {
      if (strength === 0) continue;
      const material = new LineBasicMaterial({ transparent: true, opacity: strength, depthTest, depthWrite: false, fog: this.state === outOfView });
      if (this.state === drawn) fadeWithDistance(material, this.reach);
      const lines = new LineSegments(this.geometry, material);
      lines.frustumCulled = lines.matrixAutoUpdate = false;
      lines.renderOrder = 5;
      this.materials.push(material);
      this.group.add(lines);
    }
  }

  setColour(colour: string): void { for (const material of this.materials) material.color.set(colour); }

  setSegments({ positions }: Segments): void {
    this.geometry.dispose();
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute('position', positions);
    for (const lines of this.group.children) (lines as LineSegments).geometry = this.geometry;
  }

  /** Lists the segments of the objects that are in its state. */
  list({ first, isBox, counting }: Segments, states: Uint8Array): void {
    let index = this.geometry.index;
    let needed = 0;
    const takes = (i: number): boolean => states[i] === this.state && (this.withBoxes || !isBox[i]);
    for (let i = 0; i < states.length; ++i) if (takes(i)) needed += first[i + 1] - first[i];
    if (!index || index.count < needed) {
      // A buffer on the card cannot grow: a new one, with room to spare.
      const size = Math.min(counting.length, Math.ceil(needed * 1.5) + 1024);
      const old = this.geometry;
      this.geometry = new BufferGeometry();
      this.geometry.setAttribute('position', old.attributes.position);
      index = new BufferAttribute(new Uint32Array(size), 1).setUsage(DynamicDrawUsage);
      this.geometry.setIndex(index);
      old.deleteAttribute('position');
      old.dispose();
      for (const lines of this.group.children) (lines as LineSegments).geometry = this.geometry;
    }
    const list = index.array as Uint32Array;
    let at = 0;
    for (let i = 0; i < states.length; ++i)
      if (takes(i)) {
        list.set(counting.subarray(first[i], first[i + 1]), at);
        at += first[i + 1] - first[i];
      }
    index.clearUpdateRanges();
    index.addUpdateRange(0, Math.max(1, at));
    index.needsUpdate = true;
    this.geometry.setDrawRange(0, at);
  }

  dispose(): void {
    this.geometry.dispose();
    for (const material of this.materials) material.dispose();
  }
}

/** Many fine lines far away would make a dark smear: they become thinner there. */
function fadeWithDistance(material: LineBasicMaterial, reach: { value: number }): void {
  material.onBeforeCompile = (shader) => {
    shader.uniforms.reach = reach;
    shader.vertexShader = shader.vertexShader.replace('void main() {', 'varying float distanceAway;\nvoid main() {')
      .replace('#include <project_vertex>', '#include <project_vertex>\n distanceAway = -mvPosition.z;');
    shader.fragmentShader = shader.fragmentShader.replace('void main() {', 'varying float distanceAway;\nuniform float reach;\nvoid main() {')
      .replace('#include <opaque_fragment>', '#include <opaque_fragment>\n gl_FragColor.a *= clamp(reach / max(distanceAway, 1e-6), 0.0, 1.0);');
  };
}

export class Wires {
  readonly group = new Group();
  readonly hidden = new StateLines(hidden, true, 0.8, 0.2);
  readonly outside = new StateLines(outOfView, true, 0.3, 0);
  readonly ink = new StateLines(drawn, false, 0.3, 0);
  private segments: Segments;
  private stopped = false;

  /** `reach`: how far drawn edges are seen in full strength, scene units. */
  constructor(private readonly model: Model, reach: number, private readonly onReady: () => void) {
    this.ink.reach.value = reach;
    this.segments = gather(model.objects.map(boxSegments), new Uint8Array(model.objects.length).fill(1));
    this.group.add(this.outside.group, this.hidden.group);
    for (const lines of this.all) lines.setSegments(this.segments);
    void this.refine();
  }
  private get all(): StateLines[] { return [this.hidden, this.outside, this.ink]; }

  /** For the picture that is drawn next. */
  update(states: States): void {
    for (const lines of this.all) if (lines.group.visible) lines.list(this.segments, states.values);
  }

  dispose(): void {
    this.stopped = true;
    for (const lines of this.all) lines.dispose();
  }

  /** Edges between faces that turn by more than 25 degrees, simplest objects first, in slices of 6 ms. */
  private async refine(): Promise<void> {
    const users = new Map<BufferGeometry, SceneObject[]>();
    for (const object of this.model.objects) {
      const list = users.get(object.mesh.geometry);
      list ? list.push(object) : users.set(object.mesh.geometry, [object]);
    }
    const order = [...users.entries()].sort((a, b) => a[1][0].triangles - b[1][0].triangles);
    const parts: Float32Array[] = this.model.objects.map(boxSegments), isBox = new Uint8Array(parts.length).fill(1);
    const point = new Vector3();
    let segments = 0, clock = performance.now();
    for (const [geometry, objects] of order) {
      if (this.stopped) return;
      if (performance.now() - clock > 6) {
        await breathe();
        clock = performance.now();
      }
      if (objects[0].triangles > 60_000) continue;
      const edges = new EdgesGeometry(geometry, 25).attributes.position;
      if (!edges || edges.count === 0 || segments + (edges.count / 2) * objects.length > mostSegments) continue;
      for (const object of objects) {
        const positions = new Float32Array(edges.count * 3);
        for (let i = 0; i < edges.count; ++i)
          point.fromBufferAttribute(edges as BufferAttribute, i).applyMatrix4(object.mesh.matrixWorld).toArray(positions, i * 3);
        parts[object.index] = positions;
        isBox[object.index] = 0;
      }
      segments += (edges.count / 2) * objects.length;
    }
    await breathe();
    if (this.stopped) return;
    this.segments = gather(parts, isBox);
    for (const lines of this.all) lines.setSegments(this.segments);
    this.onReady();
  }
}

function gather(parts: Float32Array[], isBox: Uint8Array): Segments {
  const first = new Uint32Array(parts.length + 1);
  parts.forEach((part, i) => { first[i + 1] = first[i] + part.length / 3; });
  const all = new Float32Array(first[parts.length] * 3);
  parts.forEach((part, i) => all.set(part, first[i] * 3));
  const counting = new Uint32Array(first[parts.length]);
  for (let i = 0; i < counting.length; ++i) counting[i] = i;
  return { positions: new BufferAttribute(all, 3), first, isBox, counting };
}

function boxSegments({ box }: SceneObject): Float32Array {
  const positions = new Float32Array(corners.length * 3);
  corners.forEach((corner, at) => {
    positions[at * 3] = corner & 1 ? box.max.x : box.min.x;
    positions[at * 3 + 1] = corner & 2 ? box.max.y : box.min.y;
    positions[at * 3 + 2] = corner & 4 ? box.max.z : box.min.z;
  });
  return positions;
}
