/** What hands do to the picture: mouse, fingers and keys, told to the rig. */

import type { Stage } from '../stage';
import type { Rig } from './index';

/** Degrees a pixel. */
const TURN = 0.22;

/** A press that moves less is a click, pixels. */
const STILL = 5;

export interface InputEvents {
  /** A click or tap at a point of the picture, -1 to 1, y up. */
  click(x: number, y: number): void;
  /** Anything at all: the page has to draw. */
  stir(): void;
}

type Point = { x: number; y: number };

const MOVES: Record<string, [axis: 0 | 1 | 2, by: 1 | -1]> = {
  KeyW: [1, 1],
  KeyS: [1, -1],
  KeyD: [0, 1],
  KeyA: [0, -1],
  KeyE: [2, 1], Space: [2, 1],
  KeyQ: [2, -1],
};

const TURNS: Record<string, [axis: 0 | 1, by: 1 | -1]> = {
  ArrowRight: [0, 1],
  ArrowLeft: [0, -1],
  ArrowUp: [1, 1],
  ArrowDown: [1, -1],
};

/** Steps nearer a key press, in notches of a wheel. */
const STEPS: Record<string, number> = { '+': -1, '=': -1, '-': 1 };

export class Input {
  private readonly pointers = new Map<number, Point>();
  private readonly keys = new Set<string>();
  private travelled = 0;
  private grip = 0;
  private stick: Point | undefined;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly rig: Rig,
    private readonly stage: Stage,
    private readonly events: InputEvents,
  ) {
    canvas.addEventListener('pointerdown', (e) => this.down(e));
    canvas.addEventListener('pointermove', (e) => this.move(e));
    for (const end of ['pointerup', 'pointercancel'] as const) canvas.addEventListener(end, (e) => this.up(e));
    canvas.addEventListener('wheel', (e) => this.wheel(e), { passive: false });
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    addEventListener('keydown', (e) => this.key(e, true));
    addEventListener('keyup', (e) => this.key(e, false));
    addEventListener('blur', () => this.release());
  }

  /** A stick on the page, held so far right and up, -1 to 1; undefined when let go. */
  hold(stick: Point | undefined): void {
    this.stick = stick;
    this.wish();
  }

  private down(event: PointerEvent): void {
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.focus();
    if (this.pointers.size === 0) this.travelled = 0;
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.grip = this.spread();
    this.grasp();
    this.events.stir();
  }

  /** What is in the middle now is what the eye turns about. */
  private grasp(): void {
    const middle = this.stage.meet(0, 0);
    if (middle) this.rig.reach = middle.along;
  }

  private move(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const fingers = this.pointers.size;
    const dx = (now.x - before.x) / fingers;
    const dy = (now.y - before.y) / fingers;
    this.travelled += Math.hypot(dx, dy);
    this.pointers.set(event.pointerId, now);
    this.events.stir();
    if (fingers === 2) {
      const grip = this.spread();
      if (this.grip > 0 && grip > 0) this.pinch(1 - this.grip / grip);
      this.grip = grip;
    }
    const orbit = this.rig.way === 'orbit';
    const pan = orbit ? fingers === 2 || event.buttons !== 1 || event.shiftKey : fingers === 2;
    if (pan) {
      // What lies under the middle of the picture follows the hand.
      const metres = (2 * Math.max(this.rig.reach, 10) * Math.tan(Math.PI / 6)) / this.canvas.clientHeight;
      this.rig.pan(-dx * metres, dy * metres);
    } else {
      // In orbit the city is turned by hand; elsewhere the head, so that what is seen follows too.
      this.rig.turn(orbit ? dx * TURN : -dx * TURN * 0.6, orbit ? -dy * TURN : dy * TURN * 0.6);
    }
  }

  private up(event: PointerEvent): void {
    if (!this.pointers.delete(event.pointerId)) return;
    this.grip = this.spread();
    const clicked = event.type === 'pointerup' && this.pointers.size === 0 && this.travelled < STILL;
    if (clicked && event.button === 0) {
      const at = this.point(event);
      this.events.click(at.x, at.y);
    }
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const notches = event.deltaY / (event.deltaMode === 1 ? 3 : 100);
    const at = this.point(event);
    this.nearer(at.x, at.y, notches);
  }

  /** Comes nearer to what a point of the picture shows, or goes away, by notches. */
  private nearer(x: number, y: number, notches: number): void {
    this.events.stir();
    const hit = this.stage.meet(x, y);
    const along = hit?.along ?? this.rig.reach;
    const way = hit?.way ?? this.stage.meet(0, 0)?.way;
    if (way) this.rig.near(way, along, 1 - 1.18 ** Math.max(Math.min(notches, 4), -4));
  }

  private pinch(share: number): void {
    const hit = this.stage.meet(0, 0);
    if (hit) this.rig.near(hit.way, hit.along, share);
  }

  private key(event: KeyboardEvent, down: boolean): void {
    const typing = event.target instanceof HTMLElement && event.target.matches('input, select, textarea');
    if (down && (typing || event.ctrlKey || event.metaKey || event.altKey)) return;
    this.rig.fast = event.shiftKey;
    const step = STEPS[event.key];
    if (down && step !== undefined) return this.nearer(0, 0, step);
    if (down && event.key === 'Enter' && event.target === this.canvas) return this.events.click(0, 0);
    if (!(event.code in MOVES || event.code in TURNS)) return;
    // Space presses the button that has the focus.
    if (event.target instanceof HTMLButtonElement && event.code === 'Space') return;
    if (down) this.keys.add(event.code);
    else this.keys.delete(event.code);
    if (down) event.preventDefault();
    this.wish();
  }

  private release(): void {
    this.keys.clear();
    this.pointers.clear();
    this.stick = undefined;
    this.rig.fast = false;
    this.wish();
  }

  private wish(): void {
    const wish: [number, number, number] = [this.stick?.x ?? 0, this.stick?.y ?? 0, 0];
    const gaze: [number, number] = [0, 0];
    for (const code of this.keys) {
      const [axis, by] = MOVES[code] ?? [0, 0];
      wish[axis] = Math.max(-1, Math.min(1, wish[axis] + by));
      const [about, turn] = TURNS[code] ?? [0, 0];
      gaze[about] += turn;
    }
    this.rig.wish = wish;
    this.rig.gaze = gaze;
    if (gaze.some((g) => g !== 0)) this.grasp();
    this.events.stir();
  }

  /** How far two fingers are apart. */
  private spread(): number {
    const [a, b] = [...this.pointers.values()];
    return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  }

  private point(event: MouseEvent): Point {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return { x: ((event.clientX - left) / width) * 2 - 1, y: 1 - ((event.clientY - top) / height) * 2 };
  }
}
