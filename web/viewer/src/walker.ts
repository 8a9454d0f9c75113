// Moving about: keyboard, mouse, touch; on the floor with walls that stop one, or flying.
import { Box3, PerspectiveCamera, Vector3 } from 'three';

export interface RayHit { distance: number; normal: Vector3 }
/** The first surface from `origin` along `direction` (unit) within `far`. */
export type CastRay = (origin: Vector3, direction: Vector3, far: number) => RayHit | null;

const up = new Vector3(0, 1, 0);
const moveKeys: Record<string, [number, number, number]> = {
  KeyW: [0, 0, 1], ArrowUp: [0, 0, 1], KeyS: [0, 0, -1], ArrowDown: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0],
  KeyE: [0, 1, 0], PageUp: [0, 1, 0], KeyQ: [0, -1, 0], PageDown: [0, -1, 0],
};

export class Walker {
  yaw = 0;
  pitch = 0;
  /** Scene units. */
  eyeHeight = 1.65;
  speed = 3;
  flying = true;
  /** Called for a press and release without movement: a choice in the picture. */
  onClick: (x: number, y: number) => void = () => {};
  /** Called when the user takes hold of the camera. */
  onTake: () => void = () => {};
  private readonly keys = new Set<string>();
  private readonly stick = new Vector3();
  private readonly pointers = new Map<number, { x: number; y: number; startX: number; startY: number; moved: boolean }>();
  private pinch = 0;
  private dolly = 0;
  private flight: { from: Vector3; to: Vector3; fromYaw: number; toYaw: number; fromPitch: number; toPitch: number; time: number; length: number } | null = null;

  constructor(readonly camera: PerspectiveCamera, private readonly surface: HTMLElement, private readonly cast: CastRay) {
    camera.rotation.order = 'YXZ';
    surface.addEventListener('pointerdown', (event) => this.press(event));
    surface.addEventListener('pointermove', (event) => this.drag(event));
    surface.addEventListener('pointerup', (event) => this.release(event, true));
    surface.addEventListener('pointercancel', (event) => this.release(event, false));
    surface.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    surface.addEventListener('contextmenu', (event) => event.preventDefault());
    addEventListener('keydown', (event) => this.key(event, true));
    addEventListener('keyup', (event) => this.key(event, false));
    addEventListener('blur', () => this.keys.clear());
  }

  /** The thumb stick: x to the right, z forward, both -1 to 1. */
  setStick(x: number, z: number): void {
    this.stick.set(x, 0, z);
    if (x || z) this.take();
  }

  place(eye: Vector3, yaw: number, pitch: number): void {
    this.flight = null;
    this.camera.position.copy(eye);
    this.yaw = yaw;
    this.pitch = pitch;
    this.turn();
  }

  lookAt(eye: Vector3, target: Vector3): void { this.place(eye, ...anglesTo(eye, target)); }

  /** Glides to a place; at once for those who asked their system for less motion. */
  flyTo(eye: Vector3, target: Vector3): void {
    const [yaw, pitch] = anglesTo(eye, target);
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) return this.place(eye, yaw, pitch);
    const turn = Math.atan2(Math.sin(yaw - this.yaw), Math.cos(yaw - this.yaw));
    this.flight = {
      from: this.camera.position.clone(), to: eye.clone(), fromYaw: this.yaw, toYaw: this.yaw + turn,
      fromPitch: this.pitch, toPitch: pitch, time: 0, length: 0.9,
    };
  }

  get direction(): Vector3 {
    return new Vector3(0, 0, -1).applyEuler(this.camera.rotation);
  }

  /** Moves on by `seconds`; true if the camera moved. */
  update(seconds: number): boolean {
    if (this.flight) return this.glide(seconds);
    const wish = new Vector3().copy(this.stick);
    for (const key of this.keys) if (moveKeys[key]) wish.add(new Vector3(...moveKeys[key]));
    const turn = (this.keys.has('ArrowLeft') ? 1 : 0) - (this.keys.has('ArrowRight') ? 1 : 0);
    let changed = false;
    if (turn) {
      this.yaw += turn * seconds * 1.6;
      changed = true;
    }
    wish.z += this.dolly;
    const dolly = this.dolly;
    this.dolly = 0;
    if (wish.lengthSq() > 0) {
      const haste = this.keys.has('ShiftLeft') || this.keys.has('ShiftRight') ? 3 : 1;
      const length = Math.min(wish.length(), dolly ? 40 : 1);
      const step = wish.normalize().multiplyScalar(length * this.speed * haste * Math.min(seconds, 0.1));
      this.flying ? this.fly(step) : this.walk(step);
      changed = true;
    }
    if (!this.flying) changed = this.fall(seconds) || changed;
    if (changed) this.turn();
    return changed;
  }

  /** Stands on the floor below, if there is one within reach. */
  land(): void {
    const floor = this.cast(this.camera.position, new Vector3(0, -1, 0), this.eyeHeight * 8);
    if (floor) this.camera.position.y += this.eyeHeight - floor.distance;
  }

  private glide(seconds: number): boolean {
    const flight = this.flight!;
    flight.time = Math.min(flight.length, flight.time + seconds);
    const t = flight.time / flight.length, s = t * t * (3 - 2 * t);
    this.camera.position.lerpVectors(flight.from, flight.to, s);
    this.yaw = flight.fromYaw + (flight.toYaw - flight.fromYaw) * s;
    this.pitch = flight.fromPitch + (flight.toPitch - flight.fromPitch) * s;
    if (t >= 1) this.flight = null;
    this.turn();
    return true;
  }

  private fly(step: Vector3): void {
    this.camera.position.add(new Vector3(step.x, 0, -step.z).applyEuler(this.camera.rotation)).addScaledVector(up, step.y);
  }

  /** Along the floor; a wall lets one slide along it. */
  private walk(step: Vector3): void {
    const way = new Vector3(step.x, 0, -step.z).applyAxisAngle(up, this.yaw);
    const room = this.eyeHeight * 0.16;
    for (let attempt = 0; attempt < 3 && way.lengthSq() > 1e-12; ++attempt) {
      const length = way.length(), direction = way.clone().divideScalar(length);
      let wall: RayHit | null = null;
      for (const height of [0, -0.35, -0.7]) {
        const from = this.camera.position.clone().addScaledVector(up, height * this.eyeHeight);
        const hit = this.cast(from, direction, length + room);
        if (hit && (!wall || hit.distance < wall.distance)) wall = hit;
      }
      if (!wall) {
        this.camera.position.add(way);
        return;
      }
      wall.normal.y = 0;
      if (wall.normal.lengthSq() < 1e-6) return;
      wall.normal.normalize();
      if (wall.normal.dot(direction) > 0) wall.normal.negate();
      way.addScaledVector(wall.normal, -way.dot(wall.normal));
    }
  }

  private fall(seconds: number): boolean {
    const floor = this.cast(this.camera.position, new Vector3(0, -1, 0), this.eyeHeight * 8);
    if (!floor) return false;
    const lack = this.eyeHeight - floor.distance;
    if (Math.abs(lack) < this.eyeHeight * 1e-3) return false;
    const most = this.eyeHeight * seconds * (lack > 0 ? 6 : 4);
    this.camera.position.y += Math.max(-most, Math.min(most, lack));
    return true;
  }

  private turn(): void {
    this.pitch = Math.max(-1.55, Math.min(1.55, this.pitch));
    this.camera.rotation.set(this.pitch, this.yaw, 0);
    this.camera.updateMatrixWorld();
  }

  private take(): void {
    this.flight = null;
    this.onTake();
  }

  private key(event: KeyboardEvent, down: boolean): void {
    if (!(event.code in moveKeys) && !/^(Arrow|Shift)/.test(event.code)) return;
    const target = event.target as HTMLElement;
    if (down && (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName))) return;
    if (!down) {
      this.keys.delete(event.code);
      return;
    }
    this.keys.add(event.code);
    if (!event.code.startsWith('Shift')) {
      event.preventDefault();
      this.take();
    }
  }

  private press(event: PointerEvent): void {
    this.surface.setPointerCapture(event.pointerId);
    this.surface.focus({ preventScroll: true });
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, startX: event.clientX, startY: event.clientY, moved: false });
    this.pinch = 0;
  }

  private drag(event: PointerEvent): void {
    const pointer = this.pointers.get(event.pointerId);
    if (!pointer) return;
    const dx = event.clientX - pointer.x, dy = event.clientY - pointer.y;
    pointer.x = event.clientX;
    pointer.y = event.clientY;
    if (Math.hypot(pointer.x - pointer.startX, pointer.y - pointer.startY) > 4) pointer.moved = true;
    if (!pointer.moved) return;
    this.take();
    if (this.pointers.size === 2) {
      const [a, b] = [...this.pointers.values()];
      const distance = Math.hypot(a.x - b.x, a.y - b.y);
      if (this.pinch) this.dolly += (distance - this.pinch) * 0.25;
      this.pinch = distance;
      return;
    }
    const scale = (this.camera.fov / 180) * Math.PI / this.surface.clientHeight * 1.4;
    this.yaw += dx * scale;
    this.pitch += dy * scale;
    this.turn();
    this.moved = true;
  }
  /** Looking about happens between updates. */
  moved = false;

  private release(event: PointerEvent, choose: boolean): void {
    const pointer = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (choose && pointer && !pointer.moved && this.pointers.size === 0) this.onClick(event.clientX, event.clientY);
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.take();
    this.dolly -= Math.sign(event.deltaY) * Math.min(6, Math.abs(event.deltaY) / 20);
  }
}

function anglesTo(eye: Vector3, target: Vector3): [number, number] {
  const d = target.clone().sub(eye);
  return [Math.atan2(-d.x, -d.z), Math.atan2(d.y, Math.hypot(d.x, d.z))];
}

/** A place outside from which the whole box is in the picture, and its middle. */
export function overviewOf(box: Box3, camera: PerspectiveCamera): { eye: Vector3; target: Vector3 } {
  const target = box.getCenter(new Vector3()), size = box.getSize(new Vector3());
  const half = Math.min(camera.fov, 2 * Math.atan(Math.tan(camera.fov * Math.PI / 360) * camera.aspect) * 180 / Math.PI) * Math.PI / 360;
  const distance = 0.5 * size.length() / Math.sin(half) * (camera.aspect < 1 ? 0.95 : 0.72);
  return { eye: target.clone().addScaledVector(new Vector3(0.42, 0.72, 0.62).normalize(), distance), target };
}
