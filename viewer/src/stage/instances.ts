/**
 * The boxes that are drawn, one slot each in a buffer on the graphics card.
 * Taking out and putting in costs what changes: holes are filled with what comes in, then with the
 * last slots, and only the slots that changed are sent.
 */

import {
  BufferAttribute,
  DynamicDrawUsage,
  InstancedBufferGeometry,
  InstancedInterleavedBuffer,
  InterleavedBufferAttribute,
} from 'three';
import { BOX, type Chunk, CHUNK, type Chunks } from '../chunks';
import type { Range } from '../ranges';
import { SUN } from './palette';
import { volume } from './volumes';

/** Floats a slot: min x, y, z, number, max x, y, z, key. */
const SLOT = 8;

/** Room at first, slots. */
const ROOM = 16384;

/** Unchanged slots that are sent again rather than by one more call. */
const GAP = 128;

/** A slot's key: class + CLASSES · level. */
export const CLASSES = 64;

export class Instances {
  readonly geometry = new InstancedBufferGeometry();
  /** The shadow volume of each box. */
  readonly volumes = new InstancedBufferGeometry();
  /** Boxes in the buffer. */
  count = 0;
  private data = new Float32Array(ROOM * SLOT);
  private buffer!: InstancedInterleavedBuffer;
  private holes: number[] = [];
  private dirty: number[] = [];

  /** `levelOf` tells the level of an object by its number; `covers` whether a kind of thing lies on the ground. */
  constructor(
    private readonly chunks: Chunks,
    private readonly levelOf: (object: number) => number,
    private readonly covers: (kind: number, wide: number, high: number) => boolean,
  ) {
    cube(this.geometry);
    volume(this.volumes, SUN);
    this.bind();
  }

  /** Objects wanted by these ranges; those whose chunk is not here yet follow with it. */
  change(add: readonly Range[], remove: readonly Range[]): void {
    this.each(remove, (chunk, from, to) => {
      for (let at = from; at < to; at += 1) {
        const slot = chunk.slots[at]!;
        if (slot === -1) continue;
        if (slot >= 0) this.holes.push(slot);
        chunk.slots[at] = -1;
        chunk.wanted -= 1;
      }
    });
    this.each(add, (chunk, from, to) => {
      for (let at = from; at < to; at += 1) {
        if (chunk.slots[at] !== -1) continue;
        chunk.wanted += 1;
        if (chunk.boxes) this.put(chunk, at);
        else chunk.slots[at] = -2;
      }
      if (!chunk.boxes) this.chunks.fetch(chunk);
    });
    this.settle();
  }

  /** Puts in what was wanted of a chunk before it came. */
  fill(chunk: Chunk): void {
    for (let at = 0; at < chunk.length; at += 1) if (chunk.slots[at] === -2) this.put(chunk, at);
    this.settle();
  }

  /** The number of the object in a slot. */
  object(slot: number): number {
    return this.data[slot * SLOT + 3]!;
  }

  /** Numbers of all objects in the buffer, ascending. */
  objects(): Uint32Array {
    const numbers = new Uint32Array(this.count);
    for (let slot = 0; slot < this.count; slot += 1) numbers[slot] = this.object(slot);
    return numbers.sort();
  }

  /**
   * The nearest box that a ray from `eye` along `way` meets, and how far along; what is around the
   * eye is not met.
   */
  meet(eye: readonly number[], way: readonly number[]): { slot: number; along: number } | undefined {
    const [ex, ey, ez] = eye as [number, number, number];
    const [ix, iy, iz] = way.map((w) => 1 / w) as [number, number, number];
    let best: { slot: number; along: number } | undefined;
    let nearest = Infinity;
    for (let slot = 0, k = 0; slot < this.count; slot += 1, k += SLOT) {
      const { data } = this;
      const ax = (data[k]! - ex) * ix, bx = (data[k + 4]! - ex) * ix;
      const ay = (data[k + 1]! - ey) * iy, by = (data[k + 5]! - ey) * iy;
      const az = (data[k + 2]! - ez) * iz, bz = (data[k + 6]! - ez) * iz;
      const enter = Math.max(Math.min(ax, bx), Math.min(ay, by), Math.min(az, bz));
      const leave = Math.min(Math.max(ax, bx), Math.max(ay, by), Math.max(az, bz));
      if (enter <= leave && enter > 0 && enter < nearest) {
        nearest = enter;
        best = { slot, along: enter };
      }
    }
    return best;
  }

  /** Whether a point is within `margin` of a box, sideways, and not above it. */
  blocked(x: number, y: number, z: number, margin: number): boolean {
    const { data } = this;
    for (let slot = 0, k = 0; slot < this.count; slot += 1, k += SLOT) {
      if (
        x > data[k]! - margin && x < data[k + 4]! + margin &&
        y > data[k + 1]! - margin && y < data[k + 5]! + margin &&
        z > data[k + 2]! - margin && z < data[k + 6]!
      ) return true;
    }
    return false;
  }

  /** Corners of a slot's box: min x, y, z, max x, y, z. */
  box(slot: number): [number, number, number, number, number, number] {
    const k = slot * SLOT;
    const d = this.data;
    return [d[k]!, d[k + 1]!, d[k + 2]!, d[k + 4]!, d[k + 5]!, d[k + 6]!];
  }

  dispose(): void {
    for (const geometry of [this.geometry, this.volumes]) geometry.dispose();
  }

  private each(ranges: readonly Range[], run: (chunk: Chunk, from: number, to: number) => void): void {
    for (const [start, end] of ranges) {
      for (let at = start; at < end; ) {
        const chunk = this.chunks.of(at);
        const to = Math.min(end, chunk.start + CHUNK);
        run(chunk, at - chunk.start, to - chunk.start);
        at = to;
      }
    }
  }

  private put(chunk: Chunk, at: number): void {
    let slot = this.holes.pop();
    if (slot === undefined) {
      slot = this.count;
      this.count += 1;
      if (this.count * SLOT > this.data.length) this.grow();
    }
    const boxes = chunk.boxes!;
    const k = slot * SLOT, b = at * BOX, object = chunk.start + at;
    const { data } = this;
    data[k] = boxes[b]!;
    data[k + 1] = boxes[b + 1]!;
    data[k + 2] = boxes[b + 2]!;
    data[k + 3] = object;
    data[k + 4] = boxes[b + 3]!;
    data[k + 5] = boxes[b + 4]!;
    const kind = chunk.classes?.[at] ?? 0;
    const [wide, high] = [Math.max(data[k + 4]! - data[k]!, data[k + 5]! - data[k + 1]!), boxes[b + 5]! - data[k + 2]!];
    // What covers the ground is a sheet at its lowest: a box would bury what stands on it.
    data[k + 6] = this.covers(kind, wide, high) ? data[k + 2]! : boxes[b + 5]!;
    data[k + 7] = Math.min(kind, CLASSES - 1) + CLASSES * this.levelOf(object);
    chunk.slots[at] = slot;
    this.dirty.push(slot);
  }

  /** Closes the holes that are left, and marks what has to be sent. */
  private settle(): void {
    // From the end: then the last slot is never a hole itself.
    this.holes.sort((a, b) => b - a);
    for (const hole of this.holes) {
      const last = this.count - 1;
      if (hole !== last) {
        this.data.copyWithin(hole * SLOT, last * SLOT, this.count * SLOT);
        const object = this.object(hole);
        const chunk = this.chunks.of(object);
        chunk.slots[object - chunk.start] = hole;
        this.dirty.push(hole);
      }
      this.count -= 1;
    }
    this.holes.length = 0;
    this.tally();
    if (this.dirty.length === 0) return;
    const slots = this.dirty.filter((slot) => slot < this.count).sort((a, b) => a - b);
    this.dirty = [];
    for (let i = 0; i < slots.length; ) {
      const first = slots[i]!;
      let last = first;
      for (i += 1; i < slots.length && slots[i]! - last <= GAP; i += 1) last = slots[i]!;
      this.buffer.addUpdateRange(first * SLOT, (last - first + 1) * SLOT);
    }
    this.buffer.needsUpdate = true;
  }

  private grow(): void {
    const larger = new Float32Array(this.data.length * 2);
    larger.set(this.data);
    this.data = larger;
    this.bind();
  }

  private bind(): void {
    // Frees the buffers on the card; they are made again with the next frame.
    this.dispose();
    this.buffer = new InstancedInterleavedBuffer(this.data, SLOT, 1);
    this.buffer.setUsage(DynamicDrawUsage);
    for (const geometry of [this.geometry, this.volumes]) {
      geometry.setAttribute('low', new InterleavedBufferAttribute(this.buffer, 4, 0));
      geometry.setAttribute('high', new InterleavedBufferAttribute(this.buffer, 4, 4));
    }
    this.tally();
  }

  private tally(): void {
    for (const geometry of [this.geometry, this.volumes]) geometry.instanceCount = this.count;
  }
}

/** A unit cube: corners, and for each face its axis with the sign of its side. */
function cube(geometry: InstancedBufferGeometry): void {
  const corners: number[] = [];
  const faces: number[] = [];
  const index: number[] = [];
  const sides: [axis: number, side: number][] = [[2, 1], [0, 0], [0, 1], [1, 0], [1, 1], [2, 0]];
  for (const [axis, side] of sides) {
    const u = (axis + 1) % 3, v = (axis + 2) % 3;
    const first = corners.length / 3;
    for (const [a, b] of [[0, 0], [1, 0], [1, 1], [0, 1]] as const) {
      const corner = [0, 0, 0];
      corner[axis] = side;
      corner[u] = a;
      corner[v] = b;
      corners.push(...corner);
      const face = [0, 0, 0];
      face[axis] = side * 2 - 1;
      faces.push(...face);
    }
    index.push(...(side ? [0, 1, 2, 0, 2, 3] : [0, 2, 1, 0, 3, 2]).map((k) => first + k));
  }
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(corners), 3));
  geometry.setAttribute('normal', new BufferAttribute(new Float32Array(faces), 3));
  geometry.setIndex(index);
}
