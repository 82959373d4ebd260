/** One house and a whole region: first view, speed, depths and air suit both. */
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';
import { citylod, missing, shown, withPage } from './page.mjs';

/** Houses at these places as OBJ: west, south and foot, m. */
const houses = (places) => places.map(([x, y, z], k) =>
  `o house${k}\nv ${x} ${y} ${z}\nv ${x + 12} ${y} ${z}\nv ${x + 12} ${y + 9} ${z + 8}\nv ${x} ${y + 9} ${z + 8}\nf -4 -3 -2\nf -4 -2 -1\n`).join('');

/** A house, and a region of 60 by 60 km in which one stands each 2 km. */
function cities(folder) {
  const region = Array.from({ length: 31 * 31 }, (_, k) => [2000 * (k % 31), 2000 * Math.floor(k / 31), 3]);
  for (const [name, places] of [['house', [[500, 700, 20]]], ['region', region]]) {
    writeFileSync(join(folder, `${name}.obj`), houses(places));
    citylod(folder, 'import', `${name}.obj`, '-o', `${name}.citylod`);
  }
  return ['house', 'region'].map((name) => join(folder, `${name}.citylod`));
}

/** In the page: the share of the picture's points that show an object, and whether any shows nothing but sky. */
function filled() {
  const { stage } = window.citylod;
  let objects = 0;
  for (let x = -0.95; x < 1; x += 0.1) for (let y = -0.95; y < 1; y += 0.1) if (stage.meet(x, y)?.object !== undefined) objects += 1;
  return objects / 400;
}

/** In the page: how far a second of flight ahead goes from home, m. */
function pace() {
  const { rig } = window.citylod;
  const from = [...rig.pose.eye];
  rig.choose('fly');
  rig.wish = [0, 1, 0];
  for (let k = 0; k < 60; k += 1) rig.step(1 / 60);
  const gone = Math.hypot(...rig.pose.eye.map((v, k) => v - from[k]));
  rig.wish = [0, 0, 0];
  rig.choose('orbit');
  return gone;
}

/** In the page: from a place looking at the middle of the city, the depths of its corners against what is drawn. */
function depths(eye) {
  const app = window.citylod;
  const { min, max } = app.city.bounds;
  const to = min.map((v, k) => (v + max[k]) / 2 - eye[k]);
  app.rig.jump({ eye: [...eye], heading: (Math.atan2(to[0], to[1]) * 180) / Math.PI, pitch: (Math.atan2(to[2], Math.hypot(to[0], to[1])) * 180) / Math.PI });
  app.rig.step(1 / 60);
  app.stage.place(app.rig.pose);
  const { camera, uniforms } = app.stage;
  const along = [...camera.matrixWorld.elements.slice(8, 11)].map((v) => -v);
  const at = app.rig.pose.eye;
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((axis) => ((k >> axis) & 1 ? max : min)[axis]));
  const depth = corners.map((corner) => corner.reduce((sum, v, k) => sum + (v - at[k]) * along[k], 0));
  const middle = Math.hypot(...min.map((v, k) => (v + max[k]) / 2 - at[k]));
  const air = (middle * uniforms.uAir.value) ** 2;
  return { near: camera.near, far: camera.far, depth, above: at[2] - app.stage.lowest, clear: 1 / (1 + air) };
}

test('a house and a region are seen from where they are seen best', { skip: missing }, () => withPage(cities, { size: { width: 960, height: 640 } }, async (page, { base }) => {
  const go = async (scene) => {
    await page.goto('about:blank');
    await page.goto(`${base}/#scene=${scene}`);
    await page.waitForFunction(shown, undefined, { timeout: 60_000 });
    await page.waitForFunction(() => window.citylod.city.instances.count > 0);
  };
  await go('house');
  assert.equal(await page.locator('.facts').textContent(), '1 object');
  const share = await page.evaluate(filled);
  assert.ok(share > 0.04 && share < 0.4, `the house fills ${share} of the picture`);
  const walk = await page.evaluate(pace);
  assert.ok(walk > 1 && walk < 12, `${walk} m in a second, ${24} m from the house`);

  await go('region');
  const flight = await page.evaluate(pace);
  assert.ok(flight > 30, `${flight} m in a second`);
  for (const eye of [[0, 0, 80_000], [-60_000, -60_000, 30_000], [90_000, 0, 100], [40_000, 40_000, 5], [0, 0, 60]]) {
    const { near, far, depth, above, clear } = await page.evaluate(depths, eye);
    const where = `from ${eye}: near ${near}, far ${far}, corners ${Math.min(...depth)} to ${Math.max(...depth)}`;
    assert.ok(Math.max(...depth) < far, where);
    assert.ok(Math.min(...depth.filter((d) => d > 0)) > near || near <= 0.4 * above, where);
    // The ground below the eye is the nearest there is: half the view downwards, and the corners of the picture.
    assert.ok(near <= Math.max(0.4, 0.5 * above), where);
    // 24 bits tell apart what is a hundredth of the distance apart, in the middle of the city.
    assert.ok(far / near < 400_000, where);
    assert.ok(clear > 0.25, `${where}: ${clear} of the middle is seen through the air`);
  }
}));
