// The edges of all objects as one set of lines: one draw call whatever is hidden. A texture with one state per object
// decides in the vertex shader which lines exist. Until edges are ready, and for objects beyond the budget, boxes stand in.
import {
  BufferAttribute, BufferGeometry, Color, EdgesGeometry, Float32BufferAttribute, GLSL3, Group, LineSegments, ShaderMaterial,
  Vector3,
} from 'three';
import { breathe, type Model, type SceneObject } from './model';
import { hidden, outOfView, type States } from './states';

const mostSegments = 900_000;
const corners = [0, 1, 1, 3, 3, 2, 2, 0, 4, 5, 5, 7, 7, 6, 6, 4, 0, 4, 1, 5, 2, 6, 3, 7];

const vertexShader = `
  in float owner;
  uniform highp usampler2D states;
  uniform uint shown;
  void main() {
    int id = int(owner);
    uint state = texelFetch(states, ivec2(id % 1024, id / 1024), 0).r;
    gl_Position = state == shown ? projectionMatrix * modelViewMatrix * vec4(position, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  }`;
const fragmentShader = `
  uniform vec3 colour;
  uniform float opacity;
  out vec4 result;
  void main() { result = vec4(colour, opacity); }`;

/** Lines of one state. `through`: how much of them shows behind other things. */
class StateLines {
  readonly group = new Group();
  private readonly materials: ShaderMaterial[];
  constructor(geometry: BufferGeometry, states: States, shown: number, private readonly strength: number, through: number) {
    this.materials = [strength, through].map((opacity, behind) => new ShaderMaterial({
      glslVersion: GLSL3, vertexShader, fragmentShader, transparent: true, depthWrite: false, depthTest: behind === 0,
      uniforms: { states: { value: states.texture }, shown: { value: shown }, colour: { value: new Color() }, opacity: { value: opacity } },
    }));
    for (const material of this.materials) {
      if (material.uniforms.opacity.value === 0) continue;
      const lines = new LineSegments(geometry, material);
      lines.frustumCulled = false;
      lines.matrixAutoUpdate = false;
      lines.renderOrder = 5;
      this.group.add(lines);
    }
  }
  setColour(colour: string): void { for (const material of this.materials) material.uniforms.colour.value.set(colour); }
  setGeometry(geometry: BufferGeometry): void {
    for (const child of this.group.children) (child as LineSegments).geometry = geometry;
  }
  dispose(): void { for (const material of this.materials) material.dispose(); }
  get isStrong(): boolean { return this.strength > 0.5; }
}

export class Wires {
  readonly group = new Group();
  readonly hidden: StateLines;
  readonly outside: StateLines;
  private geometry: BufferGeometry;
  private stopped = false;

  constructor(private readonly model: Model, states: States, private readonly onReady: () => void) {
    this.geometry = boxLines(model.objects);
    this.hidden = new StateLines(this.geometry, states, hidden, 0.75, 0.2);
    this.outside = new StateLines(this.geometry, states, outOfView, 0.28, 0);
    this.group.add(this.outside.group, this.hidden.group);
    void this.refine();
  }

  dispose(): void {
    this.stopped = true;
    this.geometry.dispose();
    this.hidden.dispose();
    this.outside.dispose();
  }

  /** Edges between faces that turn by more than 25 degrees, geometry by geometry, smallest first, in slices of 6 ms. */
  private async refine(): Promise<void> {
    const users = new Map<BufferGeometry, SceneObject[]>();
    for (const object of this.model.objects) {
      const list = users.get(object.mesh.geometry);
      list ? list.push(object) : users.set(object.mesh.geometry, [object]);
    }
    const order = [...users.entries()].sort((a, b) => a[1][0].triangles - b[1][0].triangles);
    const chunks: Float32Array[] = [], owners: Float32Array[] = [], rest: SceneObject[] = [];
    let segments = 0, clock = performance.now();
    const point = new Vector3();
    for (const [geometry, objects] of order) {
      if (this.stopped) return;
      if (performance.now() - clock > 6) {
        await breathe();
        clock = performance.now();
      }
      const worst = objects[0].triangles * 1.5 * objects.length;
      if (segments + Math.min(worst, mostSegments) > mostSegments || objects[0].triangles > 60_000) {
        rest.push(...objects);
        continue;
      }
      const edges = new EdgesGeometry(geometry, 25).attributes.position;
      if (!edges || edges.count === 0) {
        rest.push(...objects);
        continue;
      }
      for (const object of objects) {
        const positions = new Float32Array(edges.count * 3);
        for (let i = 0; i < edges.count; ++i)
          point.fromBufferAttribute(edges as BufferAttribute, i).applyMatrix4(object.mesh.matrixWorld).toArray(positions, i * 3);
        chunks.push(positions);
        owners.push(new Float32Array(edges.count).fill(object.index));
        segments += edges.count / 2;
      }
    }
    const boxes = boxLines(rest);
    chunks.push(boxes.attributes.position.array as Float32Array);
    owners.push(boxes.attributes.owner.array as Float32Array);
    await breathe();
    if (this.stopped) return;
    const refined = new BufferGeometry();
    refined.setAttribute('position', new BufferAttribute(joined(chunks), 3));
    refined.setAttribute('owner', new BufferAttribute(joined(owners), 1));
    this.geometry.dispose();
    this.geometry = refined;
    this.hidden.setGeometry(refined);
    this.outside.setGeometry(refined);
    this.onReady();
  }
}

function joined(parts: Float32Array[]): Float32Array {
  const all = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

function boxLines(objects: SceneObject[]): BufferGeometry {
  const positions = new Float32Array(objects.length * corners.length * 3), owners = new Float32Array(objects.length * corners.length);
  let at = 0;
  for (const { box, index } of objects)
    for (const corner of corners) {
      owners[at] = index;
      positions[at * 3] = corner & 1 ? box.max.x : box.min.x;
      positions[at * 3 + 1] = corner & 2 ? box.max.y : box.min.y;
      positions[at * 3 + 2] = corner & 4 ? box.max.z : box.min.z;
      ++at;
    }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(positions, 3));
  geometry.setAttribute('owner', new Float32BufferAttribute(owners, 1));
  return geometry;
}
