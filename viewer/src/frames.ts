/**
 * What to tell the controller of the frames drawn since it was told of any. By POST there are
 * several to an answer: the first of them takes in what changed and is dearer than the others, and
 * which of them is the last when the next question goes out is always the same one. Told of that
 * one alone, the controller holds another time than that of the frames.
 */

import type { Sample } from './stage/timing';

/** A frame time, ms, and what was drawn with it, m. */
export interface Told {
  frame_ms: number;
  far_dist_m: number;
}

/** Frames whose far_dist differs by no more than this share are taken together. */
const ALIKE = 0.05;

/** Frames remembered: more than that are of another time. */
const MOST = 16;

export class Frames {
  private samples: Told[] = [];

  push({ frame_ms, far_dist_m }: Sample): void {
    if (far_dist_m === undefined) return;
    this.samples.push({ frame_ms, far_dist_m });
    if (this.samples.length > MOST) this.samples.shift();
  }

  /** Whether there is something to tell. */
  get any(): boolean {
    return this.samples.length > 0;
  }

  /** The median of the frames that were drawn as the newest one was; forgets them all. */
  take(): Told | undefined {
    const newest = this.samples.at(-1)?.far_dist_m;
    if (newest === undefined) return undefined;
    const alike = this.samples.filter(({ far_dist_m }) => Math.abs(far_dist_m / newest - 1) <= ALIKE);
    this.samples = [];
    return { frame_ms: median(alike.map((s) => s.frame_ms)), far_dist_m: median(alike.map((s) => s.far_dist_m)) };
  }

  forget(): void {
    this.samples = [];
  }
}

/** The middle one, or the mean of the two in the middle. */
function median(values: number[]): number {
  const sorted = values.sort((a, b) => a - b);
  const half = sorted.length >> 1;
  return sorted.length % 2 === 1 ? sorted[half]! : (sorted[half - 1]! + sorted[half]!) / 2;
}
