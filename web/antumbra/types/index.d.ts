/** Whatever holds the bytes of a .pvs file. In node, URLs may be file: URLs. */
export type Source =
  | ArrayBufferLike
  | ArrayBufferView
  | URL
  | string
  | Response
  | Blob
  | ReadableStream<Uint8Array>
  | AsyncIterable<Uint8Array>;

export type Vector = readonly [number, number, number] | Float32Array | Float64Array | number[];

/** What an answer promises: `exact` what is visible and nothing else, `conservative` all that is visible, perhaps more,
 * `aggressive` only what is visible, perhaps not all of it, `approximate` neither. */
export type Guarantee = "exact" | "conservative" | "aggressive" | "approximate";

export type ErrorCode = "usage" | "io" | "corrupt" | "unsupported" | "limit" | "mismatch" | "cancelled" | "internal";

export class AntumbraError extends Error {
  readonly code: ErrorCode;
}

export interface PvsInfo {
  /** Of answers inside baked cells. */
  readonly guarantee: Guarantee;
  readonly objectCount: number;
  /** Cells of the grid; 0: a view tree in place of a grid. */
  readonly cellCount: number;
  readonly grid: { readonly count: number[]; readonly min: number[]; readonly max: number[] } | null;
  /** Faces are seen from both sides, whatever their material says. */
  readonly doubleSided: boolean;
  readonly origin: number[];
  /** Hash of the geometry that was baked, hexadecimal. */
  readonly sceneFingerprint: string;
  /** Hash of the scene's structure: see fingerprintOf() of antumbra/three. */
  readonly structureFingerprint: bigint;
  readonly fileBytes: number;
  readonly visibilityBytes: number;
  readonly volumeCount: number;
  /** Parts of objects that are listed besides the objects; 0: none. */
  readonly clusterCount: number;
  readonly treeNodes: number;
  readonly method: string;
  readonly toolVersion: string;
  /** Options of the bake and what it measured. */
  readonly options: Record<string, unknown>;
}

export interface PvsObject {
  readonly id: number;
  /** glTF indices; -1: no such notion. */
  readonly node: number;
  readonly primitive: number;
  readonly instance: number;
  readonly name: string;
  readonly occludes: boolean;
  readonly doubleSided: boolean;
  readonly alwaysVisible: boolean;
  readonly moves: boolean;
  readonly triangles: number;
  readonly bounds: { readonly min: number[]; readonly max: number[] };
}

export interface Cell {
  readonly index: number;
  /** From cells that are not baked, and from inside solid matter, everything is visible. */
  readonly kind: "baked" | "not-baked" | "solid";
  readonly min: number[];
  readonly max: number[];
}

export interface Question {
  /** Where the viewer is. NaN, infinite or outside every cell: everything is visible. */
  eye?: Vector;
  /** The viewer is somewhere within this distance of `eye` along each axis: a headset, a near plane. */
  radius?: number;
  /** In place of `eye`: the viewer is somewhere in this box. */
  box?: { min: Vector; max: Vector };
  /** Which way he looks, with `up` (default: +y), `fov` (vertical, degrees, default 60), `aspect` (default 16/9): only
   * objects that touch the frustum. */
  direction?: Vector;
  up?: Vector;
  fov?: number;
  aspect?: number;
}

export interface BasicAnswer {
  /** Whether anything differs from the answer before. */
  readonly changed: boolean;
  /** Objects that became visible, and that became hidden, since the answer before; before the first one all are visible. */
  readonly shown: Uint32Array;
  readonly hidden: Uint32Array;
  readonly guarantee: Guarantee;
  /** Nothing is known here: all objects are in the answer. */
  readonly everything: boolean;
  readonly count: number;
  readonly objectCount: number;
  /** The visible objects, ascending. */
  readonly ids: Uint32Array;
  /** Object o is bit o % 8 of byte o / 8. */
  readonly bits: Uint8Array;
  sees(object: number): boolean;
}

/** Live: the same object is returned by each query of a view. */
export interface PvsAnswer extends BasicAnswer {
  /** The cell, -1: outside all of them, -3: from several cells, or for a range. */
  readonly cell: number;
}

export class PvsView {
  readonly answer: PvsAnswer;
  query(question: Question): PvsAnswer;
  /** Can something of a cluster be seen, by the last answer? Also true where that cannot be told. */
  seesCluster(cluster: number): boolean;
  /** The same of all clusters: cluster c is bit c % 8 of byte c / 8. */
  clusterBits(): Uint8Array;
  /** Can something that moves within this box be seen, by the last answer? Only a file with occludee volumes can say no. */
  seesBox(min: Vector, max: Vector): boolean;
  dispose(): void;
}

export class Pvs {
  readonly info: PvsInfo;
  /** With the file's own view. For several cameras make a view for each. */
  query(question: Question): PvsAnswer;
  createView(): PvsView;
  object(id: number): PvsObject;
  /** The objects of a glTF node, or of one of its primitives or instances. */
  find(key: { node: number; primitive?: number; instance?: number }): number[];
  /** Node, primitive, instance of each object. */
  keys(): Int32Array;
  /** For each triangle of the object in the scene's file, in order, the number of its cluster; 0xFFFFFFFF: none (it has no
   * area). */
  clustersOf(id: number): Uint32Array;
  /** The object's index buffer (three entries a triangle, as in the scene's file) sorted by cluster, and which part of the
   * sorted one each cluster is: draw the ranges of those that are seen. `mismatch`: it has other triangles than the baked
   * object; draw that whole. */
  sortByCluster<T extends Uint16Array | Uint32Array | number[]>(
    id: number,
    index: T,
  ): { index: T; ranges: { cluster: number; start: number; count: number }[] };
  /** Of a view tree: the leaf among its nodes. */
  cell(index: number): Cell;
  /** The numbers of all cells: of a grid, or the leaves of a view tree (which may share their space, if it splits directions). */
  cells(): number[];
  /** Number of the cell at a point, or -1 (also where a view tree splits directions). */
  cellAt(point: Vector): number;
  /** A copy of the file. */
  bytes(): Uint8Array;
  /** Gives all memory back; views are dead after it. */
  dispose(): void;
}

/** Checks the whole file once. Rejects with an AntumbraError: `corrupt` names the damaged part, `unsupported`: written by a
 * later version, `io`: it could not be loaded. */
export function open(source: Source, options?: { signal?: AbortSignal }): Promise<Pvs>;

export const version: string;
