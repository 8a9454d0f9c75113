// The thumb stick of touch screens.
import type { Walker } from './walker';

export function setUpStick(stick: HTMLElement, walker: Walker): void {
  const knob = stick.firstElementChild as HTMLElement;
  let pointer = -1;
  const set = (event: PointerEvent): void => {
    const box = stick.getBoundingClientRect(), radius = box.width / 2;
    let x = (event.clientX - box.left - radius) / radius, y = (event.clientY - box.top - radius) / radius;
    const length = Math.hypot(x, y);
    if (length > 1) [x, y] = [x / length, y / length];
    knob.style.transform = `translate(${x * radius * 0.6}px, ${y * radius * 0.6}px)`;
    walker.setStick(x, -y);
  };
  const stop = (): void => {
    pointer = -1;
    knob.style.transform = '';
    walker.setStick(0, 0);
  };
  stick.addEventListener('pointerdown', (event) => {
    if (pointer >= 0) return;
    pointer = event.pointerId;
    stick.setPointerCapture(pointer);
    set(event);
  });
  stick.addEventListener('pointermove', (event) => { if (event.pointerId === pointer) set(event); });
  stick.addEventListener('pointerup', stop);
  stick.addEventListener('pointercancel', stop);
  const coarse = matchMedia('(pointer: coarse)');
  const show = (): void => { stick.hidden = !coarse.matches || document.documentElement.dataset.scene !== 'yes'; };
  coarse.addEventListener('change', show);
  new MutationObserver(show).observe(document.documentElement, { attributeFilter: ['data-scene'] });
  show();
}
