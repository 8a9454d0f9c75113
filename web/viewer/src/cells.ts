// View cells as boxes, coloured by how much is seen from them.
import { Box3, BoxGeometry, Color, EdgesGeometry, Group, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4, MeshBasicMaterial, Quaternion, Vector3 } from 'three';

export interface Cell {
  box: Box3;
  /** Objects seen; -1: not baked, -2: inside matter. */
  seen: number;
}

/** From few to many: the same five steps in both themes, readable for the colour-blind. */
const ramp = ['#3b6f8f', '#4f9a94', '#93b56b', '#dcb44a', '#c4663a'].map((colour) => new Color(colour));
export const rampColours = ramp.map((colour) => '#' + colour.getHexString());

export function rampColour(share: number, into: Color): Color {
  const t = Math.max(0, Math.min(1, share)) * (ramp.length - 1), i = Math.min(ramp.length - 2, Math.floor(t));
  return into.copy(ramp[i]).lerp(ramp[i + 1], t - i);
}

export type CellChoice = 'none' | 'level' | 'all';

export class Cells {
  readonly group = new Group();
  readonly least: number;
  readonly most: number;
  private plates: InstancedMesh | null = null;
  private readonly current: LineSegments;
  private level = NaN;
  private choice: CellChoice = 'none';

  constructor(private readonly cells: Cell[]) {
    const seen = cells.filter((cell) => cell.seen >= 0).map((cell) => cell.seen);
    this.least = seen.reduce((a, b) => Math.min(a, b), Infinity);
    this.most = seen.reduce((a, b) => Math.max(a, b), 0);
    this.current = new LineSegments(new EdgesGeometry(new BoxGeometry()), new LineBasicMaterial({ color: 0x2f6f8f, transparent: true, opacity: 0.9 }));
    this.current.visible = false;
    this.group.add(this.current);
  }

  /** Rebuilds if the choice, or the level of `eye`, has changed. True if it did. */
  show(choice: CellChoice, eye: Vector3): boolean {
    const own = this.cells.find((cell) => cell.box.containsPoint(eye));
    const level = choice === 'level' ? (own ?? this.nearest(eye))?.box.min.y ?? NaN : NaN;
    if (choice === this.choice && Object.is(level, this.level)) return false;
    this.choice = choice;
    this.level = level;
    if (this.plates) {
      this.plates.removeFromParent();
      this.plates.dispose();
      this.plates = null;
    }
    const chosen = this.cells.filter((cell) => cell.seen >= 0 && (choice === 'all' || (choice === 'level' && Math.abs(cell.box.min.y - level) < 1e-6)));
    if (chosen.length === 0) return true;
    const flat = choice === 'level';
    const material = new MeshBasicMaterial({ transparent: true, opacity: flat ? 0.55 : 0.2, depthWrite: false, fog: false });
    this.plates = new InstancedMesh(new BoxGeometry(), material, chosen.length);
    const matrix = new Matrix4(), colour = new Color(), none = new Quaternion();
    chosen.forEach((cell, i) => {
      const size = cell.box.getSize(new Vector3()), middle = cell.box.getCenter(new Vector3());
      if (flat) {
        middle.y = cell.box.min.y + size.y * 0.04;
        size.y *= 0.02;
      }
      this.plates!.setMatrixAt(i, matrix.compose(middle, none, size.multiply(new Vector3(0.94, flat ? 1 : 0.9, 0.94))));
      this.plates!.setColorAt(i, rampColour((cell.seen - this.least) / Math.max(1, this.most - this.least), colour));
    });
    this.plates.renderOrder = 4;
    this.group.add(this.plates);
    return true;
  }

  /** Draws the borders of one cell; null: none. */
  mark(box: Box3 | null): void {
    this.current.visible = box !== null;
    if (!box) return;
    box.getCenter(this.current.position);
    box.getSize(this.current.scale);
  }

  setAccent(colour: string): void { (this.current.material as LineBasicMaterial).color.set(colour); }

  private nearest(eye: Vector3): Cell | undefined {
    let best: Cell | undefined, least = Infinity;
    for (const cell of this.cells) {
      const distance = cell.box.distanceToPoint(eye);
      if (cell.seen >= 0 && distance < least) [best, least] = [cell, distance];
    }
    return best;
  }

  dispose(): void {
    this.plates?.dispose();
    this.current.geometry.dispose();
  }
}
