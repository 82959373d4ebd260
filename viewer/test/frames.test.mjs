/** What the controller is told of the frames since it was told of any. */
import assert from 'node:assert/strict';
import test from 'node:test';
import { createServer } from 'vite';

const vite = await createServer({ configFile: false, logLevel: 'error', server: { middlewareMode: true, ws: false } });
test.after(() => vite.close());
const { Frames } = await vite.ssrLoadModule('/src/frames.ts');

const told = (...samples) => {
  const frames = new Frames();
  for (const [frame_ms, far_dist_m] of samples) frames.push({ frame_ms, far_dist_m });
  return frames.take();
};

test('a frame alone is told as it is, once', () => {
  const frames = new Frames();
  assert.deepEqual([frames.any, frames.take()], [false, undefined]);
  frames.push({ frame_ms: 12, far_dist_m: 500 });
  assert.equal(frames.any, true);
  assert.deepEqual(frames.take(), { frame_ms: 12, far_dist_m: 500 });
  assert.deepEqual([frames.any, frames.take()], [false, undefined]);
});

test('of several the median, whichever came last', () => {
  for (const times of [[20, 10], [10, 20]]) assert.equal(told(...times.map((ms) => [ms, 500])).frame_ms, 15);
  for (const times of [[90, 10, 12], [10, 90, 12], [12, 10, 90]]) assert.equal(told(...times.map((ms) => [ms, 500])).frame_ms, 12);
});

test('frames drawn with another far distance than the newest are left out', () => {
  assert.deepEqual(told([40, 1000], [44, 1000], [10, 500], [11, 510]), { frame_ms: 10.5, far_dist_m: 505 });
});

test('frames without a far distance are not told', () => assert.equal(told([40, undefined]), undefined));
