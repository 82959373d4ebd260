/**
 * Boxes of one revision of a scene, fetched chunk by chunk as they are wanted.
 * A chunk's address names its contents, so the browser may keep it for ever; this keeps what is in
 * use, and some more.
 */

import { at, bytes, json, type Items, passes } from './api';

/** Objects a chunk. */
export const CHUNK = 4096;

/** Floats a box: min x, y, z, max x, y, z, relative to the scene's origin. */
export const BOX = 6;

/** Fetches at once: as many as browsers open connections to a host, less one for what the user does. */
const AT_ONCE = 5;

/** Time after which what failed is fetched again, ms. */
const AGAIN = 1000;

/** Chunks kept though nothing of them is drawn: 50 MB. */
const SPARE = 512;

export interface Chunk {
  readonly start: number;
  readonly length: number;
  /** Six a box; missing until it has come. */
  boxes: Float32Array | undefined;
  /** Numbers into the scene's classes; missing until they have come, and where there is but one. */
  classes: Uint16Array | undefined;
  ids: string[] | undefined;
  /** Where each object is drawn: a slot, -1 not wanted, -2 wanted but not here yet. */
  readonly slots: Int32Array;
  /** Objects wanted. */
  wanted: number;
  asked: boolean;
}

export class Chunks {
  private readonly all = new Map<number, Chunk>();
  private waiting: Chunk[] = [];
  private running = 0;
  /** Failed, and to be fetched again. */
  private failing = 0;
  /** Of those fetched since nothing was pending. */
  private done = 0;
  private readonly abort = new AbortController();

  constructor(
    private readonly scene: string,
    private readonly revision: string,
    private readonly objects: number,
    private readonly classCount: number,
    private readonly arrived: (chunk: Chunk) => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  /** Chunks that are wanted and not here yet. */
  get pending(): number {
    return this.waiting.length + this.running + this.failing;
  }

  /** How much of what was wanted together is here, 0 to 1; 1 where nothing is pending. */
  get progress(): number {
    return this.pending === 0 ? 1 : this.done / (this.done + this.pending);
  }

  /** The chunk that an object is in. */
  of(object: number): Chunk {
    const number = Math.floor(object / CHUNK);
    let chunk = this.all.get(number);
    if (!chunk) {
      this.makeRoom();
      const start = number * CHUNK;
      const length = Math.min(CHUNK, this.objects - start);
      const slots = new Int32Array(length).fill(-1);
      chunk = { start, length, boxes: undefined, classes: undefined, ids: undefined, slots, wanted: 0, asked: false };
      this.all.set(number, chunk);
    }
    return chunk;
  }

  /** Fetches a chunk, coarse ones first; `arrived` is called once it is here. */
  fetch(chunk: Chunk): void {
    if (chunk.asked) return;
    chunk.asked = true;
    this.waiting.push(chunk);
    this.next();
  }

  /** The id of an object. */
  async id(object: number): Promise<string> {
    const known = this.of(object);
    const at = object - known.start;
    if (known.ids) return known.ids[at]!;
    const items = await this.items(object, object + 1);
    return items.ids[0]!;
  }

  close(): void {
    this.abort.abort();
    this.waiting = [];
  }

  private next(): void {
    if (this.running >= AT_ONCE || this.waiting.length === 0) return;
    // What is no longer wanted is fetched last.
    this.waiting.sort((a, b) => Number(b.wanted > 0) - Number(a.wanted > 0) || a.start - b.start);
    const chunk = this.waiting.shift()!;
    this.running += 1;
    void this.load(chunk).finally(() => {
      this.running -= 1;
      this.done = this.pending === 0 ? 0 : this.done + 1;
      this.next();
    });
    this.next();
  }

  private async load(chunk: Chunk): Promise<void> {
    const end = chunk.start + chunk.length;
    try {
      const span = `start=${chunk.start}&end=${end}&revision=${this.revision}`;
      const [boxes, items] = await Promise.all([
        bytes(at(this.scene, `/boxes?${span}`), { signal: this.abort.signal }),
        this.classCount > 1 ? this.items(chunk.start, end) : undefined,
      ]);
      chunk.boxes = new Float32Array(boxes);
      if (items) {
        chunk.classes = Uint16Array.from(items.classes);
        chunk.ids = items.ids;
      }
      this.arrived(chunk);
    } catch (error) {
      if (this.abort.signal.aborted) return;
      this.failed(error);
      if (!passes(error)) return;
      this.failing += 1;
      // Not counted as done.
      this.done -= 1;
      setTimeout(() => {
        this.failing -= 1;
        if (this.abort.signal.aborted) return;
        this.waiting.push(chunk);
        this.next();
      }, AGAIN);
    }
  }

  private items(start: number, end: number): Promise<Items> {
    const span = `start=${start}&end=${end}&revision=${this.revision}`;
    return json<Items>(at(this.scene, `/items?${span}`), { signal: this.abort.signal });
  }

  private makeRoom(): void {
    if (this.all.size < SPARE) return;
    for (const [number, chunk] of this.all) {
      if (chunk.wanted === 0 && chunk.boxes) {
        this.all.delete(number);
        return;
      }
    }
  }
}
