// What became of each object in the last answer.
export const outOfView = 0, hidden = 1, drawn = 2;

export class States {
  readonly values: Uint8Array;
  constructor(readonly count: number) { this.values = new Uint8Array(count); }

  /** From two answers for one view: what the method draws, and what lies in the frustum. Returns the three counts. */
  set(visible: Uint8Array, inFrustum: Uint8Array): [number, number, number] {
    const counts: [number, number, number] = [0, 0, 0];
    for (let i = 0; i < this.count; ++i) {
      const state = visible[i] ? drawn : inFrustum[i] ? hidden : outOfView;
      this.values[i] = state;
      ++counts[state];
    }
    return counts;
  }
}
