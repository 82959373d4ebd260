/** Answers of a stream with what they leave out. The source is compiled by vite, as for the page. */
import assert from 'node:assert/strict';
import test from 'node:test';
import { createServer } from 'vite';

const vite = await createServer({ configFile: false, logLevel: 'error', server: { middlewareMode: true, ws: false } });
test.after(() => vite.close());
const { whole } = await vite.ssrLoadModule('/src/link/told.ts');

const stats = { nodes_visited: 1, objects_tested: 2, retrieve_us: 3 };
const first = { revision: 'a', count: 9, lod: { mode: 'range', far_dist_m: 500, levels: 4, error_px: 7 }, effects: { haze: { removed: 1 } }, stats };

test('the first answer is whole', () => assert.deepEqual(whole(first, undefined), first));

test('what is left out is as before, but for feedback', () => {
  const steered = whole({ count: 8, lod: { far_dist_m: 480, error_px: 6 }, feedback: { far_dist_m: 480 } }, first);
  assert.deepEqual(steered, { ...first, count: 8, lod: { ...first.lod, far_dist_m: 480, error_px: 6 }, feedback: { far_dist_m: 480 } });
  const next = whole({ count: 8, lod: { error_px: null }, effects: {} }, steered);
  assert.deepEqual(next, { ...first, count: 8, lod: { ...first.lod, far_dist_m: 480, error_px: null }, effects: {} });
});

test('another mode has none of the members of the one before', () => {
  const next = whole({ count: 3, lod: { mode: 'error', max_error_px: 4, error_px: 3.9 } }, first);
  assert.deepEqual(next.lod, { mode: 'error', max_error_px: 4, error_px: 3.9 });
});
