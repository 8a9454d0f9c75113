// The methods that can decide what is drawn, behind one interface.
import { Frustum, Matrix4, PerspectiveCamera } from 'three';
import type { Model } from './model';

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

/** Draws everything. */
export class NoCulling implements Method {
  readonly name = 'none';
  readonly title = 'everything, whatever the view';
  cull(_camera: PerspectiveCamera, into: Answer): void {
    into.visible.fill(1);
    into.guarantee = 'conservative';
  }
}

/** What three.js does by itself: every box against six planes. */
export class FrustumCulling implements Method {
  readonly name = 'frustum';
  readonly title = 'what lies in the viewing pyramid';
  private readonly frustum = new Frustum();
  private readonly matrix = new Matrix4();
  constructor(private readonly model: Model) {}
  cull(camera: PerspectiveCamera, into: Answer): void {
    this.frustum.setFromProjectionMatrix(this.matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    for (const { index, box } of this.model.objects) into.visible[index] = this.frustum.intersectsBox(box) ? 1 : 0;
    into.guarantee = 'conservative';
  }
}
