// The scene as the viewer needs it: a flat list of objects, each one mesh with a fixed place in the world.
import {
  Box3, BufferGeometry, Color, Group, InstancedMesh, Material, Matrix4, Mesh, MeshStandardMaterial, Object3D,
  PerspectiveCamera, SkinnedMesh, Texture, Vector3,
} from 'three';
import type { GLTF } from 'three/addons/loaders/GLTFLoader.js';

/** Who an object is in the scene file: the same three numbers that a .pvs stores. */
export interface ObjectKey { node: number; primitive: number; instance: number }

export interface SceneObject extends ObjectKey {
  /** Place in Model.objects. */
  index: number;
  name: string;
  mesh: Mesh;
  triangles: number;
  /** World. */
  box: Box3;
  ownMaterial: Material | Material[];
}

export interface Model {
  name: string;
  objects: SceneObject[];
  /** Lines, points, lights and whatever else is drawn but never culled. */
  rest: Group;
  triangles: number;
  bounds: Box3;
  camera: PerspectiveCamera | null;
  /** The glTF document. */
  json: object;
  /** Does the file bring colours, or is it bare geometry? */
  hasColours: boolean;
}

const trianglesOf = (geometry: BufferGeometry): number =>
  Math.floor((geometry.index ? geometry.index.count : geometry.attributes.position?.count ?? 0) / 3);

/** Leaves the browser time to breathe: resolves after its next task. */
export const breathe = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));

const isColoured = (material: Material): boolean => {
  const standard = material as MeshStandardMaterial;
  return Boolean((standard.map as Texture | null) ?? standard.vertexColors) ||
    (standard.color instanceof Color && !material.transparent && standard.color.getHex() !== 0xffffff);
};

/** Index of the node in the file that `object` was made for, from its nearest ancestor that has one. */
const nodeOf = (object: Object3D, associations: GLTF['parser']['associations']): number => {
  for (let at: Object3D | null = object; at; at = at.parent) {
    const node = associations.get(at)?.nodes;
    if (node !== undefined) return node;
  }
  return -1;
};

const nameOf = (json: { nodes?: { name?: string; mesh?: number }[]; meshes?: { name?: string }[] }, node: number): string => {
  const entry = json.nodes?.[node];
  return entry?.name ?? (entry?.mesh !== undefined ? json.meshes?.[entry.mesh]?.name : undefined) ?? `node ${node}`;
};

/**
 * Turns a loaded glTF into a Model. Every mesh and every instance becomes a mesh of its own with a frozen matrix, so that
 * what is drawn is a plain list. Yields to the browser between slices of 8 ms and tells how far it is.
 */
export async function makeModel(name: string, gltf: GLTF, progress: (share: number) => void): Promise<Model> {
  const root = gltf.scene;
  root.updateMatrixWorld(true);
  const { associations, json } = gltf.parser;
  const meshes: Mesh[] = [];
  const rest = new Group();
  let camera: PerspectiveCamera | null = null;
  const others: Object3D[] = [];
  root.traverse((object) => {
    if ((object as Mesh).isMesh) meshes.push(object as Mesh);
    else if ((object as PerspectiveCamera).isPerspectiveCamera) camera ??= object as PerspectiveCamera;
    else if (object.type === 'Points' || object.type.startsWith('Line')) others.push(object);
  });
  const objects: SceneObject[] = [];
  const bounds = new Box3();
  let triangles = 0, hasColours = false, clock = performance.now();
  const add = (mesh: Mesh, matrix: Matrix4, key: ObjectKey, label: string): void => {
    const { geometry } = mesh;
    if (!geometry.boundingBox) geometry.computeBoundingBox();
    const own = new Mesh(geometry, mesh.material);
    own.matrixAutoUpdate = own.matrixWorldAutoUpdate = false;
    own.matrix.copy(matrix);
    own.matrixWorld.copy(matrix);
    own.frustumCulled = false;
    const object: SceneObject = {
      ...key, index: objects.length, name: label, mesh: own, triangles: trianglesOf(geometry),
      box: geometry.boundingBox!.clone().applyMatrix4(matrix), ownMaterial: mesh.material,
    };
    own.userData.object = object;
    objects.push(object);
    bounds.union(object.box);
    triangles += object.triangles;
  };
  for (let i = 0; i < meshes.length; ++i) {
    const mesh = meshes[i];
    if (performance.now() - clock > 8) {
      progress(i / meshes.length);
      await breathe();
      clock = performance.now();
    }
    if ((mesh as SkinnedMesh).isSkinnedMesh) continue;
    for (const material of [mesh.material].flat()) hasColours ||= isColoured(material);
    const node = nodeOf(mesh, associations);
    const several = (json.meshes?.[json.nodes?.[node]?.mesh ?? -1]?.primitives?.length ?? 1) > 1;
    const primitive = associations.get(mesh)?.primitives ??
      Math.max(0, several ? mesh.parent?.children.filter((child) => (child as Mesh).isMesh).indexOf(mesh) ?? 0 : 0);
    const label = nameOf(json, node) + (several ? `/primitive ${primitive}` : '');
    if ((mesh as InstancedMesh).isInstancedMesh) {
      const instanced = mesh as InstancedMesh, matrix = new Matrix4();
      for (let k = 0; k < instanced.count; ++k) {
        instanced.getMatrixAt(k, matrix);
        add(mesh, matrix.clone().premultiply(mesh.matrixWorld), { node, primitive, instance: k }, `${label}#${k}`);
      }
    } else add(mesh, mesh.matrixWorld, { node, primitive, instance: -1 }, label);
  }
  for (const mesh of meshes) if ((mesh as SkinnedMesh).isSkinnedMesh) others.push(mesh);
  for (const other of others) rest.attach(other);
  if (objects.length === 0) throw new Error(`${name}: nothing to draw: the file holds no triangles`);
  objects.sort((a, b) => a.node - b.node || a.primitive - b.primitive || a.instance - b.instance);
  objects.forEach((object, index) => { object.index = index; });
  return { name, objects, rest, triangles, bounds, camera, json, hasColours };
}

/** Frees what the graphics card holds of a model. */
export function disposeModel(model: Model): void {
  const materials = new Set<Material>();
  for (const object of model.objects) {
    object.mesh.geometry.dispose();
    for (const material of [object.ownMaterial].flat()) materials.add(material);
  }
  for (const material of materials) material.dispose();
}

/** The longest side of a box. */
export const extentOf = (box: Box3): number => Math.max(...box.getSize(new Vector3()).toArray());
