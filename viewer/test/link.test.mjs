/** The page finds its way back: after a stream that was closed for silence, after a restart. */
import assert from 'node:assert/strict';
import test from 'node:test';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { citylod, ended, missing, serve, shown, withPage } from './page.mjs';

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
    await gone; // and nobody moves meanwhile
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

/** Writes a city of so many houses where there may be one. */
function build(folder, houses) {
  const house = (k) => `o house${k}\nv ${20 * k} 0 0\nv ${20 * k + 9} 0 0\nv ${20 * k + 9} 12 8\nv ${20 * k} 12 8\nf -4 -3 -2\nf -4 -2 -1\n`;
  writeFileSync(join(folder, 'town.obj'), Array.from({ length: houses }, (_, k) => house(k)).join(''));
  citylod(folder, 'import', 'town.obj', '-o', 'town.citylod');
  return join(folder, 'town.citylod');
}

test('a city that was exchanged is shown, and told', { skip: missing }, () => {
  let folder;
  const first = (at) => [build((folder = at), 1)];
  return withPage(first, {}, async (page, held, errors) => {
    assert.equal(await page.locator('.facts').textContent(), '1 object');
    const eye = await page.evaluate(() => window.citylod.rig.pose.eye);
    // The list of scenes cannot be had at once: it is asked for again.
    let failed = 0;
    await page.route('**/collections', (route) => (failed++ < 1 ? route.abort() : route.continue()));
    build(folder, 3);
    held.service.kill('SIGHUP');
    await page.waitForFunction(() => window.citylod.city.collection.objects === 3 && window.citylod.city.answer?.count === 3, undefined, { timeout: 30_000 });
    assert.match(await page.locator('.toast.shown').textContent(), /exchanged/);
    assert.equal(await page.locator('.facts').textContent(), '3 objects');
    assert.equal(failed, 2);
    // Seen from where it was seen before, though its origin is another now.
    const [before, now] = [eye, await page.evaluate(() => window.citylod.rig.pose.eye)];
    assert.ok(Math.abs(before[2] - now[2]) < 0.02, `${before} ${now}`);
    assert.ok(errors.every((text) => text.includes('ERR_FAILED')), errors.join('\n'));
    errors.length = 0;
  });
});
