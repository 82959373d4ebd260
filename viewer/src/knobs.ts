/** What the user sets, and what is asked of the service for it. */

import type { AnsweredLod, Collection, DeclaredEffects, Effects, Lod, Mode } from './api';
import type { Tint } from './colours';

export interface Knobs {
  mode: Mode;
  far_dist_m: number;
  dist_factor: number;
  levels: number;
  beyond: boolean;
  max_error_px: number;
  max_objects: number;
  /** Whether far_dist follows the frame time; in range mode alone. */
  controller: boolean;
  target_ms: number;
  tint: Tint;
  shadows: boolean;
  /** Declared effects that are switched off. */
  without: ReadonlySet<string>;
}

export const KNOBS: Knobs = {
  mode: 'range',
  far_dist_m: 1200,
  dist_factor: 2.5,
  levels: 4,
  beyond: true,
  max_error_px: 6,
  max_objects: 5000,
  controller: false,
  target_ms: 12,
  tint: 'class',
  shadows: true,
  without: new Set(),
};

export function lod(knobs: Knobs): Lod {
  switch (knobs.mode) {
    case 'range':
      return {
        mode: 'range',
        far_dist_m: knobs.far_dist_m,
        dist_factor: knobs.dist_factor,
        levels: knobs.levels,
        beyond: knobs.beyond ? 'show' : 'hide',
      };
    case 'error':
      return { mode: 'error', max_error_px: knobs.max_error_px };
    case 'budget':
      return { mode: 'budget', max_objects: knobs.max_objects };
  }
}

/** What to say of the effects that a scene declares; nothing of others. */
export function effects(knobs: Knobs, declared: DeclaredEffects, speed_mps: number): Effects {
  const said: Effects = {};
  for (const name of Object.keys(declared)) {
    if (knobs.without.has(name)) said[name] = false;
    // The ground is asked for beside the objects; with them it matters only for what it hides.
    else if (name === 'terrain') {
      if (!declared.occlusion || knobs.without.has('occlusion')) said[name] = false;
    }
    // Whole steps: a speed that hardly changes is no news.
    else if (name === 'motion') said[name] = { speed_mps: Math.round(speed_mps * 2) / 2 };
  }
  return said;
}

/** Levels of a scene: which objects each stores, and how far it is drawn. */
export class Levels {
  /** Coarsest first: level and first object. */
  private readonly starts: { level: number; start: number; end: number }[] = [];

  constructor(collection: Collection) {
    let start = 0;
    for (const { level, objects } of collection.levels) {
      this.starts.push({ level, start, end: start + objects });
      start += objects;
    }
  }

  /** How many there are. */
  get count(): number {
    return this.starts.length;
  }

  /** The level that stores an object. */
  of(object: number): number {
    return this.starts.find(({ end }) => object < end)?.level ?? 0;
  }

  /** The objects that a level stores. */
  span(level: number): [start: number, end: number] {
    const found = this.starts.find((at) => at.level === level);
    return found ? [found.start, found.end] : [0, 0];
  }

  /** Where each level ends, finest first, m; the last may be infinite. In range mode alone. */
  ends(answered: AnsweredLod, beyond: boolean): number[] {
    const { far_dist_m, dist_factor, levels } = answered;
    if (answered.mode !== 'range' || far_dist_m === undefined) return [];
    const far = far_dist_m ?? Infinity;
    const ends = Array.from({ length: levels ?? 1 }, (_, k) => far * (dist_factor ?? 1) ** k);
    if (beyond) ends[ends.length - 1] = Infinity;
    return ends;
  }
}
