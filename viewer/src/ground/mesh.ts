/** From patches to triangles, as `/api` describes it under `Patches`. */

import type { Tiles, Tile } from './tiles';

/** A tile and the fans between its posts. */
export type Patch = readonly [level: number, x: number, y: number, fans: readonly number[]];

export interface GroundMesh {
  /** Three a post, relative to the scene's origin. */
  positions: Float32Array;
  /** Three a post, of length 1: the mean of the triangles about it. */
  normals: Float32Array;
  /** Three a triangle. */
  triangles: Uint32Array;
}

/** Posts are shared by all triangles that meet there, of whatever tile, so there are no cracks. */
class Builder {
  private readonly numbers = new Map<number, number>();
  private readonly positions: number[] = [];
  private readonly triangles: number[] = [];

  constructor(private readonly tiles: Tiles) {}

  /** Draws a tile: two triangles, or its fans. */
  add([level, x, y, fans]: Patch, heights: Float32Array): void {
    const tile = [level, x, y] as const;
    const end = this.tiles.side - 1;
    const vertex = (i: number, j: number) => this.vertex(tile, heights, i, j);
    if (fans.length === 0) {
      const [sw, se, ne, nw] = [vertex(0, 0), vertex(end, 0), vertex(end, end), vertex(0, end)];
      this.triangle(sw, se, ne);
      this.triangle(sw, ne, nw);
    }
    for (const fan of fans) {
      let index = fan >> 8;
      let down = 0;
      while (index >= 4 ** down) {
        index -= 4 ** down;
        down += 1;
      }
      const size = end / 2 ** down;
      const left = (index % 2 ** down) * size;
      const low = Math.floor(index / 2 ** down) * size;
      this.fan(fan, (i, j) => vertex(left + (i * size) / 2, low + (j * size) / 2));
    }
  }

  /** The triangles of a square about its middle; `vertex` takes halves of its side. */
  private fan(fan: number, vertex: (i: number, j: number) => number): void {
    const corners = [[0, 0], [2, 0], [2, 2], [0, 2]] as const;
    const sides = [[1, 0], [2, 1], [1, 2], [0, 1]] as const;
    type Place = readonly [number, number];
    // Posts of no triangle may be unknown, and are left out.
    const triangle = (a: Place, b: Place) => this.triangle(vertex(1, 1), vertex(...a), vertex(...b));
    for (const [k, side] of sides.entries()) {
      const next = (k + 1) % 4;
      const [here, there] = [(fan >> k) & 1, (fan >> next) & 1];
      if ((fan >> (4 + k)) & 1) {
        if (here) triangle(corners[k]!, side);
        if (there) triangle(side, corners[next]!);
      } else if (here || there) {
        triangle(corners[k]!, corners[next]!);
      }
    }
  }

  private vertex(tile: Tile, heights: Float32Array, i: number, j: number): number {
    const { tiles, numbers, positions } = this;
    const column = tiles.post(tile, 0, i);
    const row = tiles.post(tile, 1, j);
    const key = row * tiles.ground.posts[0] + column;
    const known = numbers.get(key);
    if (known !== undefined) return known;
    const number = positions.length / 3;
    const z = tiles.height(heights[j * tiles.side + i]!);
    positions.push(tiles.place(0, column), tiles.place(1, row), z);
    numbers.set(key, number);
    return number;
  }

  /** What lies beyond the last column or row has no area. */
  private triangle(a: number, b: number, c: number): void {
    if (this.across(a, b, c)[2] > 0) this.triangles.push(a, b, c);
  }

  /** Cross product of two sides: twice the area long, upwards. */
  private across(a: number, b: number, c: number): [number, number, number] {
    const p = this.positions;
    const u = [0, 1, 2].map((k) => p[b * 3 + k]! - p[a * 3 + k]!);
    const v = [0, 1, 2].map((k) => p[c * 3 + k]! - p[a * 3 + k]!);
    return [u[1]! * v[2]! - u[2]! * v[1]!, u[2]! * v[0]! - u[0]! * v[2]!, u[0]! * v[1]! - u[1]! * v[0]!];
  }

  finish(): GroundMesh {
    const { positions, triangles } = this;
    const normals = new Float32Array(positions.length);
    for (let t = 0; t < triangles.length; t += 3) {
      const corners = triangles.slice(t, t + 3) as [number, number, number];
      const across = this.across(...corners);
      for (const corner of corners) for (let k = 0; k < 3; k += 1) normals[corner * 3 + k]! += across[k]!;
    }
    for (let n = 0; n < normals.length; n += 3) {
      const length = Math.hypot(normals[n]!, normals[n + 1]!, normals[n + 2]!) || 1;
      for (let k = 0; k < 3; k += 1) normals[n + k]! /= length;
    }
    return { positions: new Float32Array(positions), normals, triangles: new Uint32Array(triangles) };
  }
}

/** The ground of some patches, each with the heights of its tile. */
export function mesh(tiles: Tiles, patches: readonly (readonly [Patch, Float32Array])[]): GroundMesh {
  const builder = new Builder(tiles);
  for (const [patch, heights] of patches) builder.add(patch, heights);
  return builder.finish();
}
