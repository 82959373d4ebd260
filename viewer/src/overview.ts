/** How large a city is, and from where it is seen first. One house or a whole region. */

import type { Vec3 } from './api';
import { forward, type Pose } from './stage';

/** Corners relative to the scene's origin, m. */
export interface Bounds {
  min: Vec3;
  max: Vec3;
}

/** The longest side, m, at least 10; heights count for more, as a tower is seen from farther away. */
export function extent({ min, max }: Bounds): number {
  return Math.max(max[0] - min[0], max[1] - min[1], 1.5 * (max[2] - min[2]), 10);
}

/** Up to this extent a city is seen from outside, m; larger ones fill the picture. */
const SMALL = 100;

/** Beyond this extent only the middle is, m: from farther away most of what is drawn is less than a pixel. */
const LARGE = 6000;

/** Share of what is looked at that has to be in the picture: the rest of a city may go on beyond it. */
const PART = 0.62;

/** How much wider than what is looked at a picture of a small city is. */
const ROOM = 1.5;

/** From where the sun comes, degrees. */
const HEADING = 34;

/** How steeply to look down, degrees: the higher a picture for its width, the more ground it has room for. */
export function pitch(aspect: number): number {
  return -Math.min(Math.max(28 - 7.5 * aspect, 11), 25);
}

/** Half the height and half the width of the picture, at a distance of 1. */
export interface Opening {
  high: number;
  wide: number;
}

/** A pose that shows what is within these bounds in a picture of any shape. */
export function home(bounds: Bounds, { high, wide }: Opening): Pose {
  const { min, max } = bounds;
  const pose: Pose = { eye: [0, 0, 0], heading: HEADING, pitch: pitch(wide / high) };
  const size = extent(bounds);
  // A narrow picture of all of a city would be a band of it between sky and foreground.
  const part = PART * Math.min(1, Math.sqrt(wide / high));
  const share = size > SMALL ? part * Math.min(1, LARGE / size) : ROOM;
  const way = forward(pose);
  const flat = Math.hypot(way[0], way[1]);
  const right: Vec3 = [way[1] / flat, -way[0] / flat, 0];
  const up: Vec3 = [right[1] * way[2], -right[0] * way[2], flat];
  // The middle of one house, else nearer to the ground; a city may go on at the sides, towers are seen whole.
  const aside = size > SMALL ? 0.35 : 0.5;
  const spans = [max[0] - min[0], max[1] - min[1], max[2] - min[2]] as const;
  const shares = [share, share, Math.max(share, 1.15)] as const;
  const along = (axis: Vec3, corner: number) =>
    axis.reduce((sum, v, k) => sum + (((corner >> k) & 1) - (k === 2 ? aside : 0.5)) * v * spans[k]! * shares[k]!, 0);
  let away = Math.min(0.2 * size, 20);
  for (let corner = 0; corner < 8; corner += 1) {
    const nearer = -along(way, corner);
    away = Math.max(away, nearer + Math.abs(along(right, corner)) / wide, nearer + Math.abs(along(up, corner)) / high);
  }
  const aim: Vec3 = [(min[0] + max[0]) / 2, (min[1] + max[1]) / 2, min[2] + aside * spans[2]];
  pose.eye = aim.map((v, k) => v - way[k]! * away) as Vec3;
  return pose;
}
