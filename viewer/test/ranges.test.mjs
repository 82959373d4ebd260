/** Sets of ranges against sets of numbers. The source is compiled by vite, as for the page. */
import assert from 'node:assert/strict';
import test from 'node:test';
import { createServer } from 'vite';

test('union, difference and counts are those of sets', async (t) => {
  const vite = await createServer({ configFile: false, logLevel: 'error', server: { middlewareMode: true, ws: false } });
  t.after(() => vite.close());
  const { count, countWithin, difference, union } = await vite.ssrLoadModule('/src/ranges.ts');
  let seed = 1;
  const random = (n) => (seed = (seed * 48271) % 2147483647) % n;
  const numbers = (ranges) => ranges.flatMap(([a, b]) => Array.from({ length: b - a }, (_, k) => a + k));
  const ranges = (set) => {
    const found = [];
    for (const n of [...set].sort((a, b) => a - b)) {
      if (found.at(-1)?.[1] === n) found.at(-1)[1] += 1;
      else found.push([n, n + 1]);
    }
    return found;
  };
  const some = () => new Set(Array.from({ length: random(60) }, () => random(80)));
  for (let round = 0; round < 3000; round += 1) {
    const [a, b] = [some(), some()];
    const [ra, rb] = [ranges(a), ranges(b)];
    assert.deepEqual(difference(ra, rb), ranges(new Set([...a].filter((n) => !b.has(n)))));
    assert.deepEqual(union(ra, rb), ranges(new Set([...a, ...b])));
    assert.equal(count(ra), a.size);
    assert.equal(countWithin(ra, 20, 50), numbers(ra).filter((n) => n >= 20 && n < 50).length);
  }
});
