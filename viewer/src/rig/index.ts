/**
 * Moves the eye: orbit, fly, walk. Input says what is wished for (`Wish`), a step of time carries
 * it out smoothly. Knows nothing of the page or of what is drawn but what `Site` tells.
 */

import type { Vec3 } from '../api';
import { forward, type Pose } from '../stage';

export type Way = 'orbit' | 'fly' | 'walk';

/** What the rig asks of the city. */
export interface Site {
  /** Height of the ground, m. */
  level: number;
  /** Longest side of the city, m. */
  extent: number;
  /** Whether someone cannot stand here. */
  blocked(x: number, y: number, z: number): boolean;
}

/** Height of eyes above the ground, m. */
const EYES = 1.7;

/** Walking, and running, m/s. */
const WALK = 4;
const RUN = 14;

/** How fast keys turn, degrees a second. */
const GAZE = 60;

/** How fast movements follow what is wished for, 1/s. */
const EAGER = 9;

/** How fast a glide comes to its end, 1/s. */
const GLIDE = 5;

export class Rig {
  pose: Pose = { eye: [0, 0, 100], heading: 0, pitch: -20 };
  way: Way = 'orbit';
  /** Wished movement: right, forward, up, each -1 to 1. */
  wish: Vec3 = [0, 0, 0];
  /** Wished turn: to the right, up, each -1 to 1. */
  gaze: [number, number] = [0, 0];
  fast = false;
  /** Goes at once where it would glide. */
  calm = false;
  /** Multiplies the speed of flight. */
  throttle = 1;
  /** Distance of what the eye turns about, m. */
  reach = 500;
  /** How fast the eye moves now, m/s. */
  speed = 0;
  private velocity: Vec3 = [0, 0, 0];
  private turning: [number, number] = [0, 0];
  private glide: { to: Pose } | undefined;
  private zoom: { way: Vec3; left: number } | undefined;
  private walked = false;
  /** Set down on foot, and not gone anywhere since. */
  private placed = false;

  constructor(private site: Site) {}

  /** Another city. */
  over(site: Site): void {
    this.site = site;
    this.stop();
  }

  /** Stays where it is. */
  stop(): void {
    this.velocity = [0, 0, 0];
    this.turning = [0, 0];
    this.glide = undefined;
    this.zoom = undefined;
  }

  choose(way: Way): void {
    if (way === this.way) return;
    this.way = way;
    this.stop();
    this.walked = false;
    this.placed = false;
  }

  /** Sets the eye down on foot where nobody stands in a wall, as near to there as can be. */
  setDown(x: number, y: number): void {
    const { pose } = this;
    const eye = this.free(x, y);
    this.choose('walk');
    this.go({ eye, heading: pose.heading, pitch: 0 });
    this.placed = true;
  }

  /** Steps out of a wall that was not known of when the eye was set down. */
  stepOut(): void {
    if (!this.placed || this.glide) return;
    const [x, y, z] = this.pose.eye;
    if (this.site.blocked(x, y, z)) this.pose.eye = this.free(x, y);
  }

  /** The nearest free place on the ground, on a spiral of steps of a metre. */
  private free(x: number, y: number): Vec3 {
    const z = this.site.level + EYES;
    for (let k = 0; k < 2000; k += 1) {
      const [away, turn] = [1.1 * Math.sqrt(k), k * 2.4];
      const at: Vec3 = [x + away * Math.cos(turn), y + away * Math.sin(turn), z];
      if (!this.site.blocked(...at)) return at;
    }
    return [x, y, z];
  }

  /** Goes there at once. */
  jump(pose: Pose): void {
    this.stop();
    this.pose = pose;
  }

  /** Glides there. */
  go(pose: Pose): void {
    this.stop();
    if (this.calm) this.pose = pose;
    else this.glide = { to: pose };
  }

  /** Turns by degrees: the eye itself, or in orbit the eye about what it looks at. */
  turn(heading: number, pitch: number): void {
    this.glide = undefined;
    this.turning[0] += heading;
    this.turning[1] += pitch;
  }

  /** Moves the eye sideways, level with the ground: right and forward, m. */
  pan(right: number, ahead: number): void {
    this.glide = undefined;
    const { pose } = this;
    const turn = (pose.heading * Math.PI) / 180;
    const [x, y, z] = pose.eye;
    pose.eye = [x + right * Math.cos(turn) + ahead * Math.sin(turn), y - right * Math.sin(turn) + ahead * Math.cos(turn), z];
  }

  /** Comes nearer by a share of the way to something in a direction (or goes away, below 0). */
  near(way: Vec3, along: number, share: number): void {
    this.glide = undefined;
    const step = Math.min(along, this.site.extent * 2) * share;
    const left = this.zoom ? this.zoom.left : 0;
    // What is still left of the zoom before is taken along.
    this.zoom = { way, left: left + step };
  }

  /** Whether something moves. */
  get moving(): boolean {
    return this.speed > 0.01 || this.glide !== undefined || this.zoom !== undefined ||
      [...this.wish, ...this.gaze].some((w) => w !== 0) || Math.hypot(...this.turning) > 0.01;
  }

  /** A step of time, s. */
  step(seconds: number): void {
    const from = [...this.pose.eye] as Vec3;
    if (this.gaze.some((g) => g !== 0)) {
      // As by hand: in orbit the city is turned.
      const by = (this.way === 'orbit' ? -1 : 1) * GAZE * seconds;
      this.turn(this.gaze[0] * by, this.gaze[1] * by);
    }
    if (this.glide) this.follow(seconds);
    else {
      this.swing(seconds);
      this.travel(seconds);
    }
    this.keepAbove();
    const moved = Math.hypot(...this.pose.eye.map((v, k) => v - from[k]!));
    this.speed = seconds > 0 ? moved / seconds : 0;
  }

  private follow(seconds: number): void {
    const { glide, pose } = this;
    if (!glide) return;
    const k = 1 - Math.exp(-GLIDE * seconds);
    const turn = ((glide.to.heading - pose.heading + 540) % 360) - 180;
    pose.eye = pose.eye.map((v, i) => v + (glide.to.eye[i]! - v) * k) as Vec3;
    pose.heading += turn * k;
    pose.pitch += (glide.to.pitch - pose.pitch) * k;
    // On foot the ground there decides how high: what was known of it from here may lie below it.
    const axes = this.way === 'walk' ? 2 : 3;
    const left = Math.hypot(...pose.eye.slice(0, axes).map((v, i) => glide.to.eye[i]! - v));
    if (left < 0.05 && Math.abs(turn) < 0.05) {
      this.pose = { ...glide.to, eye: [...glide.to.eye] };
      this.glide = undefined;
    }
  }

  private swing(seconds: number): void {
    const k = 1 - Math.exp(-24 * seconds);
    const [heading, pitch] = this.turning.map((t) => t * k) as [number, number];
    this.turning = [this.turning[0] - heading, this.turning[1] - pitch];
    const { pose, reach } = this;
    const orbit = this.way === 'orbit';
    const before = forward(pose);
    const pivot = pose.eye.map((v, i) => v + before[i]! * reach) as Vec3;
    pose.heading = (((pose.heading + heading) % 360) + 360) % 360;
    pose.pitch = Math.min(Math.max(pose.pitch + pitch, -89.5), orbit ? 20 : 89.5);
    if (!orbit || (heading === 0 && pitch === 0)) return;
    const after = forward(pose);
    pose.eye = pivot.map((v, i) => v - after[i]! * reach) as Vec3;
  }

  private travel(seconds: number): void {
    const { pose, way, wish } = this;
    if (this.zoom) {
      const step = this.zoom.left * (1 - Math.exp(-14 * seconds));
      pose.eye = pose.eye.map((v, i) => v + this.zoom!.way[i]! * step) as Vec3;
      this.reach = Math.max(this.reach - step, 5);
      this.zoom.left -= step;
      if (Math.abs(this.zoom.left) < 0.02) this.zoom = undefined;
    }
    const [fx, fy, fz] = forward(pose);
    const flat = Math.hypot(fx, fy) || 1;
    const ahead: Vec3 = way === 'fly' ? [fx, fy, fz] : [fx / flat, fy / flat, 0];
    const right: Vec3 = [fy / flat, -fx / flat, 0];
    const pace = this.pace();
    const k = 1 - Math.exp(-EAGER * seconds);
    const still = wish.every((w) => w === 0);
    this.placed &&= still;
    this.velocity = this.velocity.map((v, i) => {
      const up = i === 2 && way !== 'walk' ? wish[2] : 0;
      const wished = (right[i]! * wish[0] + ahead[i]! * wish[1] + up) * pace;
      const next = v + (wished - v) * k;
      return still && Math.abs(next) < 1e-3 * pace ? 0 : next;
    }) as Vec3;
    const [x, y, z] = pose.eye;
    const [vx, vy, vz] = this.velocity.map((v) => v * seconds) as Vec3;
    if (way !== 'walk') {
      pose.eye = [x + vx, y + vy, z + vz];
      return;
    }
    // Along walls, not through them; out of them freely.
    const inside = this.site.blocked(x, y, z);
    const free = (nx: number, ny: number) => inside || !this.site.blocked(nx, ny, z);
    const nx = free(x + vx, y) ? x + vx : x;
    const ny = free(nx, y + vy) ? y + vy : y;
    const height = this.site.level + EYES;
    const fall = this.walked ? 1 : 1 - Math.exp(-7 * seconds);
    if (Math.abs(z - height) < 0.02) this.walked = true;
    pose.eye = [nx, ny, z + (height - z) * fall];
  }

  /** Speed at full wish, m/s: the higher above the ground, the faster. */
  private pace(): number {
    if (this.way === 'walk') return this.fast ? RUN : WALK;
    const above = Math.max(this.pose.eye[2] - this.site.level, 0);
    // In a city of one house, slower: it is soon flown past.
    const least = Math.min(Math.max(this.site.extent * 0.06, 2), 12);
    return (least + above * 0.6) * this.throttle * (this.fast ? 4 : 1);
  }

  private keepAbove(): void {
    const { eye } = this.pose;
    const { level, extent } = this.site;
    const high = Math.max(extent * 1.5, 1000);
    eye[2] = Math.min(Math.max(eye[2], level + Math.min(EYES, 1.5)), level + high);
  }
}
