/** Posts of the ground, tile by tile, and where they stand. */

import { at, bytes, type DeclaredGround, type Vec3 } from '../api';

/** A tile: level, and tiles of that level to the west and to the south. */
export type Tile = readonly [level: number, x: number, y: number];

/** Fetches at once. */
const AT_ONCE = 4;

/** Tiles kept: 4 MB of them. */
const MOST = 1000;

const name = (tile: Tile) => tile.join('/');

export class Tiles {
  /** The least recently used first. */
  private readonly all = new Map<string, Float32Array>();
  private readonly coming = new Map<string, Promise<Float32Array>>();
  private waiting: (() => void)[] = [];
  private running = 0;
  private readonly abort = new AbortController();

  constructor(
    private readonly scene: string,
    private readonly revision: string,
    readonly ground: DeclaredGround,
    /** What places are relative to. */
    private readonly origin: Vec3,
  ) {}

  /** Posts a side. */
  get side(): number {
    return 2 ** this.ground.tile_levels + 1;
  }

  /** Column or row (`axis` 0 or 1) of the raster that a post of a tile is on; none is beyond the last. */
  post(tile: Tile, axis: 0 | 1, index: number): number {
    const { posts, block_levels, tile_levels } = this.ground;
    const stride = 2 ** (block_levels - tile_levels - tile[0]);
    return Math.min((tile[axis + 1]! * 2 ** tile_levels + index) * stride, posts[axis]! - 1);
  }

  /** Where a column or row is, m, relative to the scene's origin. */
  place(axis: 0 | 1, post: number): number {
    return this.ground.origin[axis]! + post * this.ground.spacing[axis]! - this.origin[axis]!;
  }

  /** A height as the scene counts it, relative to the origin. */
  height(z: number): number {
    return z - this.origin[2];
  }

  /** The heights of a tile; fetched once. */
  async heights(tile: Tile): Promise<Float32Array> {
    const key = name(tile);
    const known = this.all.get(key);
    if (known) {
      this.all.delete(key);
      this.all.set(key, known);
      return known;
    }
    const coming = this.coming.get(key) ?? this.fetch(key);
    this.coming.set(key, coming);
    try {
      return await coming;
    } finally {
      this.coming.delete(key);
    }
  }

  /** Height of the ground as finely as it is here, m, relative to the origin; none where none is known. */
  at(x: number, y: number): number | undefined {
    const { ground, side } = this;
    const place = [x, y].map((v, k) => (v + this.origin[k]! - ground.origin[k]!) / ground.spacing[k]!);
    if (place.some((p, k) => !(p >= 0 && p <= ground.posts[k]! - 1))) return undefined;
    for (let level = ground.finest; level >= 0; level -= 1) {
      const stride = 2 ** (ground.block_levels - ground.tile_levels - level);
      const cells = (side - 1) * stride;
      const count = ground.blocks.map((blocks) => blocks * 2 ** level);
      const tile = place.map((p, k) => Math.min(Math.floor(p / cells), count[k]! - 1));
      const heights = this.all.get(name([level, tile[0]!, tile[1]!]));
      if (!heights) continue;
      const within = place.map((p, k) => (p - tile[k]! * cells) / stride);
      const [i, j] = within.map((w) => Math.min(Math.floor(w), side - 2)) as [number, number];
      const [u, v] = [within[0]! - i, within[1]! - j];
      const z = (di: number, dj: number) => heights[(j + dj) * side + i + di]!;
      const height = (z(0, 0) * (1 - u) + z(1, 0) * u) * (1 - v) + (z(0, 1) * (1 - u) + z(1, 1) * u) * v;
      if (Number.isFinite(height)) return this.height(height);
    }
    return undefined;
  }

  close(): void {
    this.abort.abort();
    this.waiting = [];
  }

  private async fetch(key: string): Promise<Float32Array> {
    if (this.running >= AT_ONCE) await new Promise<void>((go) => this.waiting.push(go));
    this.running += 1;
    try {
      const path = at(this.scene, `/ground/${key}?revision=${this.revision}`);
      const heights = new Float32Array(await bytes(path, { signal: this.abort.signal }));
      if (this.all.size >= MOST) this.all.delete(this.all.keys().next().value!);
      this.all.set(key, heights);
      return heights;
    } finally {
      this.running -= 1;
      this.waiting.shift()?.();
    }
  }
}
