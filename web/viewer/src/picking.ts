// Rays through the scene: what lies under the pointer, what stands in the way, where the floor is.
import { DoubleSide, Material, Matrix3, Mesh, Raycaster, Vector3 } from 'three';
import { acceleratedRaycast, MeshBVH, ObjectBVH } from 'three-mesh-bvh';
import type { Model, SceneObject } from './model';
import type { RayHit } from './walker';

export interface Hit { object: SceneObject; distance: number; point: Vector3 }

/** Meshes from this size on get a tree of their own, the first time a ray comes near. */
const largeMesh = 400;

export class Picking {
  private readonly tree: ObjectBVH;
  private readonly caster = new Raycaster();

  constructor(model: Model) {
    const meshes = model.objects.map(({ mesh }) => mesh);
    for (const mesh of meshes) mesh.raycast = raycast;
    this.tree = new ObjectBVH(meshes);
  }

  /** All objects along a ray, nearest first, each once. */
  along(origin: Vector3, direction: Vector3, far = Infinity): Hit[] {
    this.aim(origin, direction, far, false);
    const hits = this.tree.raycast(this.caster).sort((a, b) => a.distance - b.distance);
    const met = new Set<SceneObject>(), list: Hit[] = [];
    for (const hit of hits) {
      const object = hit.object.userData.object as SceneObject;
      if (met.has(object)) continue;
      met.add(object);
      list.push({ object, distance: hit.distance, point: hit.point });
    }
    return list;
  }

  first(origin: Vector3, direction: Vector3, far = Infinity): (Hit & RayHit) | null {
    this.aim(origin, direction, far, true);
    const [hit] = this.tree.raycast(this.caster);
    if (!hit) return null;
    const normal = hit.face!.normal.clone().applyNormalMatrix(new Matrix3().getNormalMatrix(hit.object.matrixWorld)).normalize();
    return { object: hit.object.userData.object as SceneObject, distance: hit.distance, point: hit.point, normal };
  }

  /** The first object that hides what is behind it, see-through ones left out. */
  firstOpaque(origin: Vector3, direction: Vector3, far = Infinity): Hit | null {
    return this.along(origin, direction, far).find(({ object }) => !isSeeThrough(object)) ?? null;
  }

  private aim(origin: Vector3, direction: Vector3, far: number, firstHitOnly: boolean): void {
    this.caster.set(origin, direction);
    this.caster.near = 0;
    this.caster.far = far;
    (this.caster as Raycaster & { firstHitOnly: boolean }).firstHitOnly = firstHitOnly;
  }
}

export function isSeeThrough(object: SceneObject): boolean {
  const material = [object.ownMaterial].flat()[0] as Material & { alphaTest: number; transmission?: number };
  return material.transparent || material.alphaTest > 0 || (material.transmission ?? 0) > 0;
}

function raycast(this: Mesh, caster: Raycaster, hits: Parameters<Mesh['raycast']>[1]): void {
  const geometry = this.geometry;
  const count = (geometry.index?.count ?? geometry.attributes.position.count) / 3;
  if (count > largeMesh && !geometry.boundsTree) geometry.boundsTree = new MeshBVH(geometry, { indirect: true });
  acceleratedRaycast.call(this, caster, hits);
}

/** Evenly spread points on the surface of an object, the same each time. World coordinates. */
export function surfacePoints(object: SceneObject, count: number): Vector3[] {
  const { geometry, matrixWorld } = object.mesh, positions = geometry.attributes.position;
  const corner = (k: number): number => (geometry.index ? geometry.index.getX(k) : k);
  const a = new Vector3(), b = new Vector3(), c = new Vector3(), areas: number[] = [];
  let sum = 0;
  for (let t = 0; t < object.triangles; ++t) {
    a.fromBufferAttribute(positions, corner(3 * t)).applyMatrix4(matrixWorld);
    b.fromBufferAttribute(positions, corner(3 * t + 1)).applyMatrix4(matrixWorld);
    c.fromBufferAttribute(positions, corner(3 * t + 2)).applyMatrix4(matrixWorld);
    sum += b.sub(a).cross(c.sub(a)).length();
    areas.push(sum);
  }
  const points: Vector3[] = [];
  for (let i = 0, t = 0; i < count && sum > 0; ++i) {
    const at = ((i + 0.5) / count) * sum;
    while (t < areas.length - 1 && areas[t] < at) ++t;
    // The R2 sequence within the triangle.
    let u = (0.5 + i * 0.7548776662466927) % 1, v = (0.5 + i * 0.5698402909980532) % 1;
    if (u + v > 1) [u, v] = [1 - u, 1 - v];
    a.fromBufferAttribute(positions, corner(3 * t));
    b.fromBufferAttribute(positions, corner(3 * t + 1)).sub(a);
    c.fromBufferAttribute(positions, corner(3 * t + 2)).sub(a);
    points.push(a.clone().addScaledVector(b, u).addScaledVector(c, v).applyMatrix4(matrixWorld));
  }
  return points;
}

export const isDoubleSided = (object: SceneObject): boolean => ([object.ownMaterial].flat()[0] as Material).side === DoubleSide;
