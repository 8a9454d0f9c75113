import type { BatchedMesh, Camera, InstancedMesh, Object3D } from "three";
import type { Pvs, PvsAnswer, Source } from "./index.js";
export { AntumbraError } from "./index.js";

/** What GLTFLoader gives. */
export interface LoadedGltf {
  scene: Object3D;
  parser: { associations: Map<unknown, unknown>; json: object };
}

export interface CullingOptions {
  /** Meshes of your own that show objects of the file: objects[i] is what instance i shows; undefined: always drawn. */
  bind?: { mesh: InstancedMesh | BatchedMesh; objects: (number | undefined)[] }[];
  /** Default true: what the near plane lets one see through walls counts, too. */
  near?: boolean;
  /** Take a file although the structure of the scene has changed since it was baked: at your own risk. */
  allowStale?: boolean;
  signal?: AbortSignal;
}

/** Events: `change` (with shown and hidden ids), `outside` (the camera has left every baked cell: everything is drawn),
 * `inside`. */
export class Culling extends EventTarget {
  readonly root: Object3D;
  readonly pvs: Pvs;
  /** Objects drawn, hidden, and not found in the scene. */
  readonly drawn: number;
  readonly hidden: number;
  readonly unmatched: number;
  readonly answer: PvsAnswer;
  /** False: everything is drawn. */
  enabled: boolean;
  /** True: update() changes nothing, so that one can fly off and look at what is drawn. */
  frozen: boolean;
  near: boolean;
  /** Each frame, before rendering, with the camera that renders (in WebXR: renderer.xr.getCamera()). Returns whether
   * anything changed. Other cameras and shadows go on seeing everything. */
  update(camera: Camera): boolean;
  /** Leaves the scene as it was found. */
  dispose(): void;
}

/** Rejects with AntumbraError `mismatch` if the scene's structure has changed since the bake. */
export function cull(gltf: LoadedGltf, source: Source | Pvs, options?: CullingOptions): Promise<Culling>;

/** Of a glTF's JSON; equals PvsInfo.structureFingerprint unless the scene has changed. */
export function structureFingerprint(json: object): bigint;
