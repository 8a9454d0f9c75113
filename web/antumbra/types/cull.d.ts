import type { BasicAnswer, Guarantee, Pvs, Vector } from "./index.js";
export { AntumbraError } from "./index.js";

/** Triangles that surely block sight: opaque, not animated, really drawn. Few and large ones pay most. */
export interface Occluders {
  vertices: ArrayLike<number>;
  /** Three vertices each, counter-clockwise seen from the front. */
  triangles: ArrayLike<number>;
  /** For each triangle: 1 blocks sight from behind, too. */
  twoSided?: ArrayLike<number>;
}

export interface CullSceneInput {
  /** For each object: least x, y, z, greatest x, y, z. */
  bounds: ArrayLike<number>;
  /** For each object: 4 = always visible. */
  flags?: ArrayLike<number>;
  occluders?: Occluders;
  /** Boxes are kept in single precision relative to this place; default: the centre of all. */
  origin?: Vector;
}

export interface CullerOptions {
  /** `planes`: occluders per frame, 0..64. */
  occluders?: number;
  /** `masked`: pixels across, 8..2048; polygons per frame at most; patches with fewer pixels per polygon are not drawn. */
  rasterWidth?: number;
  polygonBudget?: number;
  pixelsPerPolygon?: number;
}

export interface Camera {
  eye: Vector;
  /** Any point on the line of sight, or else a direction. */
  target?: Vector;
  direction?: Vector;
  up?: Vector;
  projection?: "perspective" | "orthographic";
  /** Perspective: full vertical angle in degrees, default 60. */
  fov?: number;
  /** Orthographic: height of the view volume. */
  height?: number;
  aspect?: number;
  near?: number;
  far?: number;
}

export interface CullAnswer extends BasicAnswer {
  /** Why everything is visible, or "". */
  readonly reason: string;
  readonly stages: {
    boxesTested: number;
    outsideFrustum: number;
    hiddenByPvs: number;
    hiddenByOccluders: number;
    occludersUsed: number;
  };
}

export type Method = "none" | "frustum" | "masked" | "planes" | "pvs" | (string & {});

/** Boxes and occluders, prepared: about a microsecond for each. Make it anew when the scene has changed. */
export class CullScene {
  static create(input: CullSceneInput, options?: { simd?: boolean }): Promise<CullScene>;
  static fromPvs(pvs: Pvs, options?: { simd?: boolean }): Promise<CullScene>;
  readonly objectCount: number;
  readonly occluderCount: number;
  readonly methods: string[];
  createCuller(method: Method, options?: CullerOptions): Culler;
  dispose(): void;
}

export class Culler {
  readonly method: string;
  readonly guarantee: Guarantee;
  /** With the culler's own view. For several cameras make a view for each. */
  cull(camera: Camera): CullAnswer;
  createView(): CullView;
  dispose(): void;
}

export class CullView {
  readonly answer: CullAnswer;
  cull(camera: Camera): CullAnswer;
  dispose(): void;
}

export function hasSimd(): boolean;
