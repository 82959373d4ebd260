/**
 * The way to the service: frames are asked, answers come back as changes to what is drawn.
 * By WebSocket where one can be had, by `POST visible` where it is blocked.
 */

import type { Answer, AnswerHead, Ask, Problem } from '../api';
import { difference, type Range, union } from '../ranges';
import { Poll } from './poll';
import { Stream } from './stream';

export type Way = 'stream' | 'post' | 'none';

/** What either way hands on: a change to the set before, or a whole set. */
export type Change =
  | { add: Range[]; remove: Range[] }
  | { all: Range[] };

/** What a way tells its link. */
export interface Ears {
  answered(ask: Ask, head: AnswerHead, change: Change): void;
  /** `revision` where the set is void, as the service has another one now. */
  refused(problem: Problem, revision?: string): void;
  /** It is ready for questions. */
  opened(): void;
  /** It cannot be had; `blocked` where nothing came through it. */
  lost(blocked: boolean): void;
}

/** One way of asking. */
export interface Asking {
  /** Whether a question would be answered soon. */
  readonly ready: boolean;
  ask(ask: Ask): void;
  close(): void;
}

export interface LinkEvents {
  answer(answer: Answer): void;
  problem(problem: Problem): void;
  /** What the service has now, where it could not answer for it. */
  revision(revision: string): void;
  way(way: Way): void;
}

/** After so many attempts at a stream, where there was one before, it may be the network after all. */
const ENOUGH = 6;
/** Longest wait between attempts to reach the service again, ms. */
const LONGEST_WAIT = 8000;

/** Asks about one scene until it is closed; finds its way again when the service comes back. */
export class Link {
  private asking: Asking | undefined;
  private ranges: Range[] = [];
  private attempts = 0;
  /** A stream was had: where none can be had now, it is more likely that the service is away. */
  private streamed = false;
  private timer: number | undefined;
  private closed = false;
  private generation = 0;

  constructor(
    private readonly scene: string,
    private readonly events: LinkEvents,
  ) {
    this.stream();
  }

  /** Whether a question asked now would be answered soon. */
  get ready(): boolean {
    return this.asking?.ready ?? false;
  }

  ask(ask: Ask): void {
    this.asking?.ask(ask);
  }

  close(): void {
    this.closed = true;
    clearTimeout(this.timer);
    this.asking?.close();
    this.asking = undefined;
  }

  private stream(): void {
    this.use((ears) => new Stream(this.scene, ears), 'stream');
  }

  private poll(): void {
    this.use((ears) => new Poll(this.scene, ears), 'post');
  }

  private use(make: (ears: Ears) => Asking, way: Way): void {
    this.generation += 1;
    const mine = this.generation;
    // A way that was given up has nothing more to say.
    const current = () => !this.closed && mine === this.generation;
    this.asking?.close();
    this.asking = make({
      opened: () => current() && this.events.way(way),
      refused: (problem, revision) => {
        if (!current()) return;
        this.events.problem(problem);
        if (revision !== undefined) this.events.revision(revision);
      },
      answered: (ask, head, change) => {
        if (!current()) return;
        this.attempts = 0;
        this.streamed ||= way === 'stream';
        this.take(ask, head, change);
      },
      lost: (blocked) => {
        if (!current()) return;
        this.events.way('none');
        this.asking = undefined;
        if (blocked && (!this.streamed || this.attempts >= ENOUGH)) {
          this.attempts += 1;
          this.poll();
          return;
        }
        const wait = Math.min(250 * 2 ** this.attempts, LONGEST_WAIT);
        this.attempts += 1;
        this.timer = window.setTimeout(() => this.stream(), wait);
      },
    });
  }

  private take(ask: Ask, head: AnswerHead, change: Change): void {
    const before = this.ranges;
    let { add, remove } = 'all' in change ? { add: [], remove: [] } : change;
    if ('all' in change) {
      this.ranges = change.all;
      add = difference(change.all, before) as never[];
      remove = difference(before, change.all) as never[];
    } else {
      this.ranges = union(difference(before, remove), add);
    }
    this.events.answer({ ...head, ask, ranges: this.ranges, add, remove });
  }
}
