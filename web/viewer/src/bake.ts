// A .pvs as the viewer needs it, read by the package `antumbra`.
import type { Box3, Vector3 } from 'three';
import type { Cell } from './cells';
import type { Method } from './culling';
import type { Model } from './model';

export interface Bake {
  name: string;
  guarantee: string;
  facts: [string, string][];
  cells: Cell[];
  methods: Method[];
  /** Set if the file and the scene do not belong together. */
  problem: string;
  /** Number in the file of an object of the model; -1: not in it. */
  idOf(index: number): number;
  /** Object of the model with that number in the file; -1: none. */
  indexOf(id: number): number;
  boxAt(eye: Vector3): Box3 | null;
  dispose(): void;
}

export async function openBake(name: string, _bytes: ArrayBuffer, _model: Model, _byOrder: boolean): Promise<Bake> {
  throw new Error(`${name}: no reader yet`);
}
