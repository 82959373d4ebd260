/** Why an object is drawn, in a sentence. */

import { at, type Item, json, type Vec3 } from './api';
import type { City } from './city';
import type { Knobs } from './knobs';
import type { Why } from './panel/picked';
import { length, short } from './panel/dom';
import type { Stage } from './stage';

/** An object, why it is drawn, and where all of it is; for an eye relative to the scene's origin. */
export async function about(
  object: number, city: City, eye: Vec3, stage: Stage, knobs: Knobs, frozen: boolean,
): Promise<{ item: Item; why: Why; link: string }> {
  const link = at(city.collection.id, `/items/${encodeURIComponent(await city.chunks.id(object))}`);
  const item = await json<Item>(link);
  return { item, why: why(item, city.absolute(eye), stage.viewport[1] / stage.opening.high, city, knobs, frozen), link };
}

/** For an eye in scene coordinates; what is as large as its distance is `scale` / 2 pixels high. */
function why(item: Item, eye: Vec3, scale: number, city: City, knobs: Knobs, frozen: boolean): Why {
  const [x0, y0, z0, x1, y1, z1] = item.bounds;
  const off = (v: number, low: number, high: number) => Math.max(low - v, 0, v - high);
  const distance = Math.hypot(off(eye[0], x0, x1), off(eye[1], y0, y1), off(eye[2], z0, z1));
  const diagonal = Math.hypot(x1 - x0, y1 - y0, z1 - z0);
  // The size that error_px speaks of: the diagonal at the nearest point.
  const size_px = distance > 0 ? (diagonal * scale) / (2 * distance) : Infinity;
  const is = frozen ? 'was' : 'is';
  return { distance, size_px, sentence: sentence(item.level, size_px, city, knobs, is) };
}

function sentence(level: number, size_px: number, city: City, knobs: Knobs, is: string): string {
  const answered = city.answer?.lod;
  if (answered?.mode === 'error') return `Drawn because it ${is} at least ${short(knobs.max_error_px)} px large: ${short(size_px)} px.`;
  if (answered?.mode === 'budget') return `Drawn because it ${is} one of the ${knobs.max_objects} largest on the screen.`;
  const ends = answered ? city.levels.ends(answered, knobs.beyond) : [];
  const end = ends[Math.min(level, ends.length - 1)];
  if (level === 0) return `Drawn because its district ${is} within ${length(end ?? 0)}, where every object is.`;
  const reach = end === undefined || !Number.isFinite(end) ? 'at any distance' : `up to ${length(end)}`;
  return `Stands for its district: drawn ${reach}.`;
}
