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

/** A pose that shows the city: from the south-west, as the sun comes. */
export function home(bounds: Bounds): Pose {
  const { min, max } = bounds;
  const pose: Pose = { eye: [0, 0, 0], heading: 34, pitch: -17 };
  const size = extent(bounds);
  const away = Math.max(0.4 * Math.min(size, LARGE), 2 * Math.min(size, SMALL));
  const aim: Vec3 = [(min[0] + max[0]) / 2, (min[1] + max[1]) / 2, min[2] + 0.35 * (max[2] - min[2])];
  const way = forward(pose);
  pose.eye = aim.map((v, k) => v - way[k]! * away) as Vec3;
  return pose;
}
