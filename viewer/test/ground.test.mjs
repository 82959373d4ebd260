/**
 * The ground on the page against the service: hills made up here, looked at from several places,
 * the triangles drawn held against patches and tiles asked for beside the page.
 */
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';
import { citylod, missing, shown, withPage } from './page.mjs';

/** The hills: posts each way, m between them, the first one. */
const [columns, rows, cell, x0, y0] = [150, 130, 20, 2_600_000, 1_200_000];

/** Where they have none. */
const hole = (c, r) => Math.hypot(c - 40, r - 90) < 6;

/** Hills with a hole, and a village in a national grid. */
function write(folder) {
  const height = (c, r) => 400 + 60 * Math.sin(c / 9) * Math.cos(r / 11) + 9 * Math.sin(c / 1.7 + r) + (c > 70 ? 0.8 * (c - 70) : 0);
  let grid = `ncols ${columns}\nnrows ${rows}\nxllcenter ${x0}\nyllcenter ${y0}\ncellsize ${cell}\nNODATA_value -9999\n`;
  for (let r = rows - 1; r >= 0; r -= 1) {
    const row = Array.from({ length: columns }, (_, c) => (hole(c, r) ? -9999 : height(c, r).toFixed(2)));
    grid += `${row.join(' ')}\n`;
  }
  writeFileSync(join(folder, 'hills.asc'), grid);
  let village = '';
  for (let k = 0; k < 60; k += 1) {
    const [c, r] = [20 + (k % 10) * 11, 20 + Math.floor(k / 10) * 16];
    const [x, y, z] = [x0 + c * cell, y0 + r * cell, height(c, r)];
    village += `o house${k}\nv ${x} ${y} ${z}\nv ${x + 15} ${y} ${z}\nv ${x + 15} ${y + 12} ${z + 9}\nv ${x} ${y + 12} ${z + 9}\nf -4 -3 -2\nf -4 -2 -1\n`;
  }
  writeFileSync(join(folder, 'village.obj'), village);
}

/** The village on the hills and without them. */
function cities(folder) {
  write(folder);
  citylod(folder, 'import', 'village.obj', '-o', 'hills.citylod');
  citylod(folder, 'import', 'hills.asc', '--into', 'hills.citylod');
  citylod(folder, 'import', 'village.obj', '-o', 'level.citylod');
  return ['hills.citylod', 'level.citylod'].map((name) => join(folder, name));
}

/** Goes to a scene. */
async function go(page, base, scene) {
  // From elsewhere: a page that is open writes where it is into the address, at any moment.
  await page.goto('about:blank');
  await page.goto(`${base}/#scene=${scene}`);
  await page.waitForFunction(shown, undefined, { timeout: 60_000 });
}

/** In the page: goes somewhere and waits until the ground of that place is drawn. */
async function stand(place) {
  const app = window.citylod;
  app.rig.jump({ ...place, eye: app.city.relative(place.eye) });
  const pause = (ms) => new Promise((go) => setTimeout(go, ms));
  const here = () => {
    const answered = app.ground.answered?.camera;
    return answered && app.asked && JSON.stringify(answered) === JSON.stringify(app.asked.camera) && app.ground.settled;
  };
  for (let k = 0; k < 600; k += 1) {
    app.stir(true);
    await pause(25);
    if (k > 8 && here()) break;
  }
  const { geometry } = app.stage.ground;
  return {
    settled: here(),
    camera: app.ground.answered.camera,
    effects: app.ground.answered.effects,
    figures: app.ground.figures,
    origin: app.city.collection.origin,
    positions: [...geometry.getAttribute('position').array],
    index: [...geometry.index.array],
    visible: app.stage.ground.visible,
    plane: app.stage.plane.visible,
  };
}

/** The triangles that the service describes, by the words of `/api`: nine numbers each. */
async function described(base, camera, effects) {
  const { ground } = await (await fetch(`${base}/collections/hills`)).json();
  const reply = await fetch(`${base}/collections/hills/visible`, {
    method: 'POST',
    headers: { 'content-type': 'application/json' },
    body: JSON.stringify({ camera, effects, lod: { mode: 'budget', max_objects: 0 } }),
  });
  const { effects: { terrain } } = await reply.json();
  const n = ground.tile_levels;
  const triangles = [];
  for (const [level, x, y, fans] of terrain.list) {
    const bytes = await (await fetch(`${base}/collections/hills/ground/${level}/${x}/${y}`)).arrayBuffer();
    const view = new DataView(bytes);
    const side = 2 ** n + 1;
    assert.equal(bytes.byteLength, 4 * side * side);
    const stride = 2 ** (ground.block_levels - n - level);
    const post = (i, j) => {
      const at = [Math.min((x * 2 ** n + i) * stride, ground.posts[0] - 1), Math.min((y * 2 ** n + j) * stride, ground.posts[1] - 1)];
      return [...at.map((p, k) => ground.origin[k] + p * ground.spacing[k]), view.getFloat32(4 * (j * side + i), true)];
    };
    const draw = (...places) => {
      const [a, b, c] = places.map(([i, j]) => post(i, j));
      if ((b[0] - a[0]) * (c[1] - a[1]) !== (b[1] - a[1]) * (c[0] - a[0])) triangles.push([a, b, c]);
    };
    const all = 2 ** n;
    if (fans.length === 0) {
      draw([0, 0], [all, 0], [all, all]);
      draw([0, 0], [all, all], [0, all]);
    }
    for (const fan of fans) {
      const [index, midpoints, quarters] = [fan >> 8, (fan >> 4) & 15, fan & 15];
      const squares = [];
      for (let count = 1; squares.length <= index; count *= 2) {
        for (let row = 0; row < count; row += 1) for (let column = 0; column < count; column += 1) squares.push([column, row, all / count]);
      }
      const [column, row, size] = squares[index];
      const at = (i, j) => [column * size + i * size, row * size + j * size];
      const corners = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
      const middles = [at(0.5, 0), at(1, 0.5), at(0.5, 1), at(0, 0.5)];
      for (let k = 0; k < 4; k += 1) {
        const next = (k + 1) % 4;
        const has = (bits, bit) => Math.floor(bits / 2 ** bit) % 2 === 1;
        if (has(midpoints, k)) {
          if (has(quarters, k)) draw(at(0.5, 0.5), corners[k], middles[k]);
          if (has(quarters, next)) draw(at(0.5, 0.5), middles[k], corners[next]);
        } else if (has(quarters, k) || has(quarters, next)) draw(at(0.5, 0.5), corners[k], corners[next]);
      }
    }
  }
  return { triangles, terrain };
}

/** Whether a camera sees a place. */
function sees({ eye, quaternion: [x, y, z, w], fov_y_deg, viewport }, place) {
  const d = place.map((v, k) => v - eye[k]);
  // Turned the other way round: what the camera has on its right, up, and behind it.
  const right = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
  const up = [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)];
  const behind = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
  const along = (axis) => axis.reduce((sum, v, k) => sum + v * d[k], 0);
  const depth = -along(behind);
  const half = depth * Math.tan((fov_y_deg * Math.PI) / 360);
  return depth > 0.1 && Math.abs(along(up)) < half && Math.abs(along(right)) < (half * viewport[0]) / viewport[1];
}

/**
 * Sides that no other triangle passes the other way, by what ends there: the raster at its border,
 * or at a post without a height as near as a third corner would be, or what is seen. What is none
 * of these is a crack.
 */
function ends({ positions, index, origin, camera }) {
  const sides = new Set();
  for (let t = 0; t < index.length; t += 3) {
    for (let k = 0; k < 3; k += 1) {
      const side = `${index[t + k]} ${index[t + ((k + 1) % 3)]}`;
      assert.ok(!sides.has(side), 'a side is passed once each way');
      sides.add(side);
    }
  }
  const place = (v) => [0, 1, 2].map((k) => positions[3 * v + k] + origin[k]);
  const post = ([x, y]) => [(x - x0) / cell, (y - y0) / cell];
  const found = {};
  for (const side of sides) {
    const [a, b] = side.split(' ').map(Number);
    if (sides.has(`${b} ${a}`)) continue;
    const [from, to] = [place(a), place(b)];
    const [p, q] = [from, to].map((at) => post(at).map(Math.round));
    const border = [columns, rows].some((posts, k) => p[k] === q[k] && (p[k] === 0 || p[k] === posts - 1));
    const [c, r] = [0, 1].map((k) => (p[k] + q[k]) / 2);
    const near = 1.2 * Math.hypot(p[0] - q[0], p[1] - q[1]);
    const beside = (u, v) => (q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0]) < 0;
    let lacks = false;
    for (let v = 84; v <= 96; v += 1) {
      for (let u = 34; u <= 46; u += 1) lacks ||= hole(u, v) && beside(u, v) && Math.hypot(u - c, v - r) <= near;
    }
    const middle = from.map((v, k) => (v + to[k]) / 2);
    const why = border ? 'border' : lacks ? 'hole' : sees(camera, middle) ? 'crack' : 'view';
    (found[why] ??= []).push([from, to]);
  }
  return found;
}

/** As text, whatever the order: each triangle from its least corner on. */
function text(triangles) {
  return triangles
    .map((corners) => {
      const words = corners.map((corner) => corner.map((v) => Math.fround(v)).join(' '));
      const least = words.indexOf([...words].sort()[0]);
      return [0, 1, 2].map((k) => words[(least + k) % 3]).join(', ');
    })
    .sort();
}

test('the ground on the page is what the service answers', { skip: missing }, () => withPage(cities, {}, async (page, { base }) => {
  await go(page, base, 'hills');
  const counts = [];
  const met = {};
  for (const place of [
    { eye: [2_600_900, 1_199_700, 700], heading: 0, pitch: -15 },
    { eye: [2_601_500, 1_201_300, 900], heading: 200, pitch: -35 },
    { eye: [2_600_850, 1_201_500, 520], heading: 300, pitch: -5 },
    { eye: [2_595_000, 1_195_000, 4000], heading: 45, pitch: -25 },
  ]) {
    const seen = await page.evaluate(stand, place);
    assert.ok(seen.settled, 'the ground came');
    assert.ok(seen.visible && !seen.plane, 'it is drawn in place of the plane');
    assert.ok(seen.positions.every(Number.isFinite), 'no hole is drawn');
    const { triangles, terrain } = await described(base, seen.camera, seen.effects);
    const { list: _, took_us: __, ...figures } = terrain;
    const { took_us: ___, ...shownFigures } = seen.figures;
    assert.deepEqual(shownFigures, figures);
    assert.equal(triangles.length, figures.triangles);
    const vertex = (v) => [0, 1, 2].map((k) => seen.positions[3 * v + k]);
    const drawn = Array.from({ length: seen.index.length / 3 }, (_, t) => [0, 1, 2].map((k) => vertex(seen.index[3 * t + k])));
    const moved = triangles.map((corners) => corners.map((corner) => corner.map((v, k) => v - seen.origin[k])));
    assert.deepEqual(text(drawn), text(moved));
    const open = ends(seen);
    for (const [why, sides] of Object.entries(open)) met[why] = (met[why] ?? 0) + sides.length;
    assert.deepEqual(open.crack ?? [], [], 'a side belongs to two triangles, or the ground ends there');
    counts.push(triangles.length);
  }
  console.log(`triangles of ground: ${counts.join(', ')}; sides at ends: ${JSON.stringify(met)}`);
  for (const why of ['border', 'hole', 'view']) assert.ok(met[why] > 0, `no side is at the end of the ground: ${why}`);
  assert.ok(new Set(counts).size === counts.length && Math.min(...counts) > 100, `${counts}`);
}));

test('the ground can be switched off, and other scenes have none', { skip: missing }, () => withPage(cities, {}, async (page, { base }) => {
  await go(page, base, 'hills');
  await page.waitForFunction(() => window.citylod.stage.ground.visible, undefined, { timeout: 30_000 });
  const toggle = page.locator('label.toggle', { hasText: 'Terrain' }).locator('input');
  await toggle.evaluate((input) => input.click());
  await page.waitForFunction(() => !window.citylod.stage.ground.visible && window.citylod.stage.plane.visible);
  await toggle.evaluate((input) => input.click());
  await page.waitForFunction(() => window.citylod.stage.ground.visible && !window.citylod.stage.plane.visible, undefined, { timeout: 30_000 });
  // Who walks stands on it.
  await page.evaluate(() => window.citylod.way('walk'));
  await page.waitForFunction(() => {
    const app = window.citylod;
    const { eye } = app.rig.pose;
    return Math.abs(eye[2] - app.ground.height(eye[0], eye[1]) - 1.7) < 0.1;
  }, undefined, { timeout: 30_000 });
  await go(page, base, 'level');
  const level = await page.evaluate(() => [window.citylod.ground === undefined, window.citylod.stage.ground.visible, window.citylod.stage.plane.visible]);
  assert.deepEqual(level, [true, false, true]);
  assert.equal(await page.locator('label.toggle', { hasText: 'Terrain' }).count(), 0);
}));

test('ground that could not be had is asked for again while nothing moves', { skip: missing }, () => withPage(cities, {}, async (page, { base }, errors) => {
  await go(page, base, 'hills');
  await page.waitForFunction(() => window.citylod.stage.ground.visible && window.citylod.ground.settled);
  for (const failing of ['**/visible', '**/ground/*/*/*']) {
    let failed = 0;
    await page.route(failing, (route) => {
      failed += 1;
      return failed <= 2 ? route.abort() : route.continue();
    });
    await go(page, base, 'hills');
    await page.waitForFunction(() => window.citylod.stage.ground.visible && window.citylod.ground.settled, undefined, { timeout: 30_000 });
    assert.ok(failed > 2, `${failing}: ${failed}`);
    await page.unroute(failing);
  }
  assert.ok(errors.every((error) => /ERR_FAILED/.test(error)), `${errors}`);
  errors.length = 0;
}));

/**
 * In the page: of places on the ground in the picture, how many are darker with shadows than
 * without, and how many have a box between them and the sun.
 */
function shade() {
  const { stage, city } = window.citylod;
  const [width, height] = stage.viewport;
  const gl = document.querySelector('#view').getContext('webgl2');
  const picture = (on) => {
    stage.cast(on, on);
    stage.draw(undefined);
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  };
  const [lit, dark] = [picture(false), picture(true)];
  const sun = stage.uniforms.uSun.value.toArray();
  const eye = stage.camera.position.toArray();
  // Of each pixel: whether it should be in shade, or nothing where that is not judged.
  const judged = Array.from({ length: width * height }, (_, k) => {
    const [x, y] = [k % width, Math.floor(k / width)];
    const hit = stage.meet(((x + 0.5) / width) * 2 - 1, ((y + 0.5) / height) * 2 - 1);
    if (!hit || hit.object !== undefined || hit.along > 400) return undefined;
    // The triangles drawn are not the finest: ground half a metre higher or lower is seen elsewhere along the way.
    const [due, ...about] = [0, 0.5, -0.5].map((dz) => {
      const along = hit.along + dz / hit.way[2];
      return city.instances.meet(eye.map((v, k) => v + along * hit.way[k]), sun) !== undefined;
    });
    return about.every((other) => other === due) ? due : undefined;
  });
  const found = { both: 0, drawn: 0, due: 0, lighter: 0 };
  for (let y = 1; y < height - 1; y += 1) {
    for (let x = 1; x < width - 1; x += 1) {
      const at = y * width + x;
      const due = judged[at];
      // The ground is drawn as far behind itself as it slopes across a pixel, so that edges move by as much.
      const rows = [-width, 0, width];
      if (due === undefined || rows.some((row) => [-1, 0, 1].some((column) => judged[at + row + column] !== due))) continue;
      const change = dark[4 * at] - lit[4 * at];
      if (change > 0) found.lighter += 1;
      if (due && change < 0) found.both += 1;
      else if (due) found.due += 1;
      else if (change < 0) found.drawn += 1;
    }
  }
  return found;
}

test('shadows lie on the ground where a box stands before the sun', { skip: missing }, () => withPage(cities, {}, async (page, { base }) => {
  await go(page, base, 'hills');
  const boxes = await page.evaluate(() => {
    const { city, ground } = window.citylod;
    const places = Array.from({ length: city.instances.count }, (_, slot) => {
      const [, , , x, y, z] = city.instances.box(slot);
      const [u, v] = [x + 0.9, y + 0.6];
      return { top: city.absolute([x, y, z]), foot: city.absolute([u, v, ground.height(u, v) + 1.7]) };
    });
    // Not where the hill behind the house is higher than the house.
    return places.filter(({ top, foot }) => top[2] - foot[2] > 2).slice(0, 6);
  });
  assert.equal(boxes.length, 6);
  const seen = { above: 0, within: 0 };
  for (const { top, foot } of boxes) {
    for (const [kind, place] of [
      ['above', { eye: [top[0], top[1], top[2] + 50], heading: 0, pitch: -85 }],
      ['within', { eye: foot, heading: 40, pitch: -80 }],
    ]) {
      const { settled } = await page.evaluate(stand, place);
      assert.ok(settled, 'the ground came');
      const found = await page.evaluate(shade);
      const where = `${kind}: ${JSON.stringify(found)} from ${place.eye}`;
      assert.equal(found.lighter, 0, where);
      assert.ok(found.drawn + found.due <= 3, where);
      seen[kind] += found.both;
    }
  }
  console.log(`pixels of shadow: ${JSON.stringify(seen)}`);
  assert.ok(seen.above > 1000 && seen.within > 10_000, JSON.stringify(seen));
}));
