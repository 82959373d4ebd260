/**
 * Sets of object numbers as ranges: half-open, ascending, neither touching nor overlapping.
 * Every function takes and returns such lists, in time linear in the number of ranges.
 */

/** `start` to `end`, without `end`. */
export type Range = readonly [start: number, end: number];

/** How many numbers there are. */
export function count(set: readonly Range[]): number {
  return set.reduce((sum, [start, end]) => sum + end - start, 0);
}

/** What is in `a` but not in `b`. */
export function difference(a: readonly Range[], b: readonly Range[]): Range[] {
  const left: Range[] = [];
  let at = 0;
  for (const [from, end] of a) {
    let start = from;
    while (at < b.length && b[at]![1] <= start) at += 1;
    for (let k = at; k < b.length && b[k]![0] < end; k += 1) {
      const [taken, free] = b[k]!;
      if (taken > start) left.push([start, taken]);
      start = Math.max(start, free);
    }
    if (start < end) left.push([start, end]);
  }
  return left;
}

/** What is in `a` or in `b`. */
export function union(a: readonly Range[], b: readonly Range[]): Range[] {
  const all: [number, number][] = [];
  for (let i = 0, k = 0; i < a.length || k < b.length; ) {
    const takeA = k >= b.length || (i < a.length && a[i]![0] <= b[k]![0]);
    const [start, end] = takeA ? a[i++]! : b[k++]!;
    const last = all.at(-1);
    if (last !== undefined && last[1] >= start) last[1] = Math.max(last[1], end);
    else all.push([start, end]);
  }
  return all;
}

/** How many numbers of the set lie in `start .. end`. */
export function countWithin(set: readonly Range[], start: number, end: number): number {
  let sum = 0;
  for (const [from, to] of set) sum += Math.max(0, Math.min(to, end) - Math.max(from, start));
  return sum;
}
