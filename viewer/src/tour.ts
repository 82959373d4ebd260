/** A flight about the city, for those who would rather look: a slow circle that comes and goes. */

import type { Vec3 } from './api';
import type { Pose } from './stage';

/** Seconds once around. */
const ROUND = 90;

/** The pose after so many seconds. The circle begins where the eye is now, as nearly as it can. */
export function tour(bounds: { min: Vec3; max: Vec3 }, from: Pose): (seconds: number) => Pose {
  const middle = bounds.min.map((v, k) => (v + bounds.max[k]!) / 2) as Vec3;
  const reach = Math.max(bounds.max[0] - bounds.min[0], bounds.max[1] - bounds.min[1], 200);
  const start = Math.atan2(from.eye[0] - middle[0], from.eye[1] - middle[1]);
  return (seconds) => {
    const turn = start + (2 * Math.PI * seconds) / ROUND;
    const swell = 0.5 - 0.5 * Math.cos((2 * Math.PI * seconds) / (ROUND * 0.62));
    const away = reach * (0.42 - 0.26 * swell);
    const height = Math.max(reach * (0.15 - 0.1 * swell), 60);
    const eye: Vec3 = [middle[0] + away * Math.sin(turn), middle[1] + away * Math.cos(turn), bounds.min[2] + height];
    // A little ahead of the middle: the city passes by.
    const aim = turn + Math.PI + 0.42;
    const pitch = (-Math.atan2(height * 0.92, away) * 180) / Math.PI;
    return { eye, heading: ((aim * 180) / Math.PI + 360) % 360, pitch };
  };
}
