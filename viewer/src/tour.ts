/** A flight about the city, for those who would rather look: a slow circle that comes and goes. */

import type { Vec3 } from './api';
import { type Bounds, extent } from './overview';
import type { Pose } from './stage';

/** Seconds once around. */
const ROUND = 90;

/** Of a city that is larger, m, so much is flown about. */
const WIDEST = 6000;

/** The pose after so many seconds. The circle begins where the eye is now, as nearly as it can. */
export function tour(bounds: Bounds, from: Pose): (seconds: number) => Pose {
  const middle = bounds.min.map((v, k) => (v + bounds.max[k]!) / 2) as Vec3;
  // Of a region its middle: once around would be faster than anything flies.
  const reach = Math.min(extent(bounds), WIDEST);
  // One house is looked at from outside.
  const outside = Math.max(2 * Math.min(reach, 100) - 0.3 * reach, 0);
  const start = Math.atan2(from.eye[0] - middle[0], from.eye[1] - middle[1]);
  return (seconds) => {
    const turn = start + (2 * Math.PI * seconds) / ROUND;
    const swell = 0.5 - 0.5 * Math.cos((2 * Math.PI * seconds) / (ROUND * 0.62));
    const away = Math.max(reach * (0.42 - 0.26 * swell), outside);
    const height = Math.max(reach * (0.15 - 0.1 * swell), Math.min(0.6 * reach, 60));
    const eye: Vec3 = [middle[0] + away * Math.sin(turn), middle[1] + away * Math.cos(turn), bounds.min[2] + height];
    // A little ahead of the middle: the city passes by.
    const aim = turn + Math.PI + 0.42;
    const pitch = (-Math.atan2(height * 0.92, away) * 180) / Math.PI;
    return { eye, heading: ((aim * 180) / Math.PI + 360) % 360, pitch };
  };
}
