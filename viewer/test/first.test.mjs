/** The first view: the city fills pictures of all shapes, and land does not bury what stands on it. */
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';
import { citylod, missing, shown, withPage } from './page.mjs';

/** A box on the ground as a CityJSON solid: west, south, foot, side and height, m. */
const block = (type, x, y, z, side, height) => {
  const vertices = [0, 1].flatMap((up) => [[0, 0], [1, 0], [1, 1], [0, 1]].map(([u, v]) => [x + u * side, y + v * side, z + up * height]));
  const faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
  return { type, vertices, faces };
};

/** Houses in a park whose box is higher than they are, and the same in OBJ with two of them 300 km away. */
function cities(folder) {
  const houses = Array.from({ length: 36 }, (_, k) => block('Building', 100 + 20 * (k % 6), 100 + 20 * Math.floor(k / 6), 1, 10, 7));
  const blocks = [block('PlantCover', 0, 0, 0, 300, 15), block('PlantCover', 300, 0, 0, 900, 15), ...houses];
  const objects = {};
  const vertices = [];
  blocks.forEach((made, k) => {
    const boundaries = [made.faces.map((face) => [face.map((v) => v + vertices.length)])];
    objects[`o${k}`] = { type: made.type, geometry: [{ type: 'Solid', lod: '1', boundaries }] };
    vertices.push(...made.vertices);
  });
  const park = { type: 'CityJSON', version: '2.0', transform: { scale: [1, 1, 1], translate: [0, 0, 0] }, CityObjects: objects, vertices };
  writeFileSync(join(folder, 'park.city.json'), JSON.stringify(park));
  const obj = [...houses, block('', 300_000, 0, 0, 10, 7), block('', 300_100, 0, 0, 10, 7)].map(({ vertices: corners, faces }, k) =>
    [`o h${k}`, ...corners.map((v) => `v ${v.join(' ')}`), ...faces.map((face) => `f ${face.map((v) => v - 8).join(' ')}`)].join('\n'));
  writeFileSync(join(folder, 'astray.obj'), obj.join('\n'));
  citylod(folder, 'import', 'park.city.json', '-o', 'park.citylod');
  citylod(folder, 'import', 'astray.obj', '-o', 'astray.citylod');
  const tower = block('', 0, 0, 0, 20, 90);
  writeFileSync(join(folder, 'tower.obj'), [...tower.vertices.map((v) => `v ${v.join(' ')}`), ...tower.faces.map((face) => `f ${face.map((v) => v + 1).join(' ')}`)].join('\n'));
  citylod(folder, 'import', 'tower.obj', '-o', 'tower.citylod');
  citylod(folder, 'generate', '--objects', '23951', '-o', 'made.citylod');
  return ['park', 'astray', 'tower', 'made'].map((name) => join(folder, `${name}.citylod`));
}

/** In the page: the classes of what the picture shows in a grid of points, row by row from below. */
function classes() {
  const { stage, city } = window.citylod;
  const rows = [];
  for (let y = -0.95; y < 1; y += 0.1) {
    const row = [];
    for (let x = -0.95; x < 1; x += 0.1) {
      const object = stage.meet(x, y)?.object;
      const chunk = object === undefined ? undefined : city.chunks.of(object);
      row.push(chunk ? city.collection.classes[chunk.classes?.[object - chunk.start] ?? 0] : '');
    }
    rows.push(row);
  }
  return rows;
}

const go = async (page, base, scene) => {
  await page.goto('about:blank');
  await page.goto(`${base}/#scene=${scene}`);
  await page.waitForFunction(shown, undefined, { timeout: 60_000 });
  await page.waitForFunction(() => window.citylod.city.instances.count > 0);
};

/** Shares of the width and of the height between the outermost things of a kind. */
const spread = (rows, is) => {
  const across = rows[0].map((_, x) => rows.some((row) => is(row[x])));
  const up = rows.map((row) => row.some(is));
  return [across, up].map((line) => (line.lastIndexOf(true) - line.indexOf(true) + 1) / line.length);
};

test('the city fills a picture of any shape', { skip: missing }, () => withPage(cities, {}, async (page, { base }) => {
  for (const [width, height] of [[400, 900], [1280, 720], [2560, 600]]) {
    await page.setViewportSize({ width, height });
    for (const [scene, least] of [['made', [0.9, 0.6]], ['park', [0.6, 0.2]], ['astray', [0.6, 0.2]]]) {
      await go(page, base, scene);
      const found = spread(await page.evaluate(classes), (name) => name !== '' && name !== 'PlantCover');
      assert.ok(found.every((share, k) => share >= least[k]), `${scene} at ${width} x ${height}: ${found}`);
    }
  }
  // A tower is seen to its top.
  await page.setViewportSize({ width: 1280, height: 720 });
  await go(page, base, 'tower');
  const rows = await page.evaluate(classes);
  assert.ok(rows.at(-1).every((name) => name === '') && spread(rows, (name) => name !== '')[1] > 0.5);
  // Another shape before anyone moved: as if it had been opened so.
  await go(page, base, 'astray');
  await page.setViewportSize({ width: 400, height: 900 });
  await page.waitForFunction(() => window.citylod.stage.viewport[0] === 400);
  const pose = () => page.evaluate(() => window.citylod.rig.pose);
  const turned = await pose();
  await go(page, base, 'astray');
  assert.deepEqual(turned, await pose());
  await page.evaluate(() => window.citylod.rig.jump({ eye: [0, 0, 300], heading: 0, pitch: -30 }));
  await page.setViewportSize({ width: 900, height: 400 });
  await page.waitForFunction(() => window.citylod.stage.viewport[0] === 900);
  assert.deepEqual((await pose()).eye, [0, 0, 300]);
}));

test('land lies under what stands on it', { skip: missing }, () => withPage(cities, {}, async (page, { base }) => {
  await go(page, base, 'park');
  const found = (await page.evaluate(classes)).flat();
  const count = (name) => found.filter((other) => other === name).length;
  assert.ok(count('Building') > 40, `${count('Building')} of 400 points show a building`);
  assert.ok(count('PlantCover') > 20, `${count('PlantCover')} of 400 points show the park`);
}));

test('what the page says of a service that is slow, has no room or is gone, and of a city of nothing', { skip: missing }, () => {
  const nothing = (folder) => {
    citylod(folder, 'generate', '--objects', '0', '-o', 'nothing.citylod');
    return [...cities(folder), join(folder, 'nothing.citylod')];
  };
  return withPage(nothing, {}, async (page, { base }, errors) => {
    await page.goto('about:blank');
    await page.goto(`${base}/#scene=nothing`);
    await page.waitForFunction(() => /no objects/.test(document.querySelector('.toast.shown')?.textContent ?? ''));
    assert.equal(await page.locator('.waiting').isVisible(), false);
    await page.route('**/collections', async (route) => {
      await page.locator('.waiting').waitFor();
      await route.fulfill({ status: 503, contentType: 'application/problem+json', body: '{"detail":"no room"}' });
    });
    await page.goto('about:blank');
    await page.goto(`${base}/#scene=park`);
    await page.locator('.despair', { hasText: 'no room' }).waitFor();
    await page.unroute('**/collections');
    await page.locator('.again').click();
    await page.waitForFunction(shown, undefined, { timeout: 60_000 });
    // What cannot be told of is not marked either.
    await page.route('**/items*/**', (route) => route.abort());
    const marked = () => page.evaluate(() => window.citylod.stage.uniforms.uPick.value);
    await page.evaluate(() => {
      const app = window.citylod;
      for (let y = -0.9; y < 0.9; y += 0.05) if (app.stage.meet(0, y)?.object !== undefined) return app.click(0, y);
    });
    await page.locator('.toast.shown').waitFor();
    assert.equal(await marked(), -1);
    assert.ok(errors.every((text) => /503|ERR_FAILED/.test(text)), errors.join('\n'));
    errors.length = 0;
  });
});
