// What became of each object in the last answer, on the processor and as a texture for the shaders of wires.
import { DataTexture, RedIntegerFormat, UnsignedByteType } from 'three';

export const outOfView = 0, hidden = 1, drawn = 2;

const width = 1024;

export class States {
  readonly values: Uint8Array;
  readonly texture: DataTexture;
  private readonly padded: Uint8Array;

  constructor(readonly count: number) {
    const height = Math.max(1, Math.ceil(count / width));
    this.padded = new Uint8Array(width * height);
    this.values = this.padded.subarray(0, count);
    this.texture = new DataTexture(this.padded, width, height, RedIntegerFormat, UnsignedByteType);
    this.texture.needsUpdate = true;
  }

  /** From two answers for one view: what the method draws, and what lies in the frustum. Returns the three counts. */
  set(visible: Uint8Array, inFrustum: Uint8Array): [number, number, number] {
    const counts: [number, number, number] = [0, 0, 0];
    for (let i = 0; i < this.count; ++i) {
      const state = visible[i] ? drawn : inFrustum[i] ? hidden : outOfView;
      this.values[i] = state;
      ++counts[state];
    }
    this.texture.needsUpdate = true;
    return counts;
  }

  dispose(): void { this.texture.dispose(); }
}
