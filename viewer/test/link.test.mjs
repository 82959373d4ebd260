/** The page finds its way back: after a stream that was closed for silence, after a restart. */
import assert from 'node:assert/strict';
import test from 'node:test';
import { ended, missing, serve, shown, withPage } from './page.mjs';

/** In the page: looks elsewhere. */
const turn = (heading) => {
  const app = window.citylod;
  app.rig.jump({ ...app.rig.pose, heading });
  app.stir(true);
};

/** In the page: whether what is drawn is what was asked last. */
const answered = () => {
  const { city, asked } = window.citylod;
  return city.way === 'stream' && city.answer.ask === asked && city.chunks.pending === 0;
};

/** In the page: what it shows. */
const seen = () => ({ camera: window.citylod.asked.camera, objects: [...window.citylod.city.instances.objects()] });

/** Looks elsewhere and holds what is then shown against the service. */
async function still(page, base, heading) {
  await page.evaluate(turn, heading);
  await page.waitForTimeout(100);
  await page.waitForFunction(answered, undefined, { timeout: 30_000 });
  const { camera, objects } = await page.evaluate(seen);
  const reply = await fetch(`${base}/collections/demo/visible`, {
    method: 'POST',
    headers: { 'content-type': 'application/json' },
    body: JSON.stringify({ camera, lod: { far_dist_m: 1200 }, output: { form: 'ranges' } }),
  });
  const { ranges } = await reply.json();
  assert.deepEqual(objects, ranges.flatMap(([a, b]) => Array.from({ length: b - a }, (_, i) => a + i)));
}

const ends = async (base, reason) => {
  const text = await (await fetch(`${base}/metrics`)).text();
  return Number(new RegExp(`citylod_streams_ended_total{reason="${reason}"} (\\d+)`).exec(text)[1]);
};

test('a stream closed for silence is opened again, without a word', { skip: missing }, () =>
  withPage([], { words: ['--stream-idle-ms', '700'] }, async (page, { base }) => {
    for (let k = 0; k < 100 && (await ends(base, 'idle')) < 2; k += 1) await page.waitForTimeout(100);
    assert.ok((await ends(base, 'idle')) >= 2, 'closed twice meanwhile');
    await still(page, base, 80);
    assert.equal(await page.locator('.toast.shown').count(), 0);
  }));

test('a service that was restarted is found again', { skip: missing }, () =>
  withPage([], {}, async (page, held, errors) => {
    await still(page, held.base, 10);
    const gone = ended(held.service);
    held.service.kill();
    await gone;
    await page.evaluate(turn, 20);
    await page.waitForFunction(() => window.citylod.city.way === 'none');
    assert.match(await page.locator('.status').textContent(), /Reconnecting/);
    await page.waitForTimeout(1500);
    // That nobody listens is all there was to complain about, and the browser does it, not the page.
    assert.ok(errors.every((text) => text.includes('ERR_CONNECTION_REFUSED')), errors.join('\n'));
    Object.assign(held, await serve(held.base.slice('http://'.length), []));
    await page.waitForFunction(shown);
    await page.waitForFunction(() => window.citylod.city.way === 'stream', undefined, { timeout: 20_000 });
    errors.length = 0;
    await still(page, held.base, 30);
  }));
