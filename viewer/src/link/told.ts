/** Answers of a stream leave out what is as in the answer before: this fills it in. */

import type { AnsweredLod, AnswerHead, RanEffects, Stats } from '../api';

/** What an answer of a stream says beside its objects. */
export interface Told {
  /** Where the set begins anew. */
  revision?: string;
  count: number;
  /** Whole where it has `mode`. */
  lod: Partial<AnsweredLod> & Pick<AnsweredLod, 'error_px'>;
  effects?: RanEffects;
  feedback?: { far_dist_m: number | null };
  stats?: Stats;
}

const NONE: Stats = { nodes_visited: 0, objects_tested: 0, retrieve_us: 0 };

/** The answer in full. */
export function whole(told: Told, before: AnswerHead | undefined): AnswerHead {
  const { feedback } = told;
  const lod = told.lod.mode ? told.lod : { ...before?.lod, ...told.lod };
  return {
    revision: told.revision ?? before?.revision ?? '',
    count: told.count,
    lod: lod as AnsweredLod,
    effects: told.effects ?? before?.effects ?? {},
    stats: told.stats ?? before?.stats ?? NONE,
    // Chosen for one question: it does not hold for the next.
    ...(feedback ? { feedback } : {}),
  };
}
