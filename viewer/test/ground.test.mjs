/**
 * The ground on the page against the service: hills made up here, looked at from several places,
 * the triangles drawn held against patches and tiles asked for beside the page.
 */
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { chromium } from 'playwright-core';

const root = join(import.meta.dirname, '..', '..');
const binary = process.env.CITYLOD ?? join(root, 'target/debug/citylod');
const browser = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
const missing = !browser ? 'needs Chromium' : !existsSync(binary) ? `needs ${binary}: cargo build` : undefined;

const flags = ['--headless', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];

/** Hills with a hole, and a village in a national grid. */
function write(folder) {
  const [columns, rows, cell, x0, y0] = [150, 130, 20, 2_600_000, 1_200_000];
  const height = (c, r) => 400 + 60 * Math.sin(c / 9) * Math.cos(r / 11) + 9 * Math.sin(c / 1.7 + r) + (c > 70 ? 0.8 * (c - 70) : 0);
  let grid = `ncols ${columns}\nnrows ${rows}\nxllcenter ${x0}\nyllcenter ${y0}\ncellsize ${cell}\nNODATA_value -9999\n`;
  for (let r = rows - 1; r >= 0; r -= 1) {
    const row = Array.from({ length: columns }, (_, c) => (Math.hypot(c - 40, r - 90) < 6 ? -9999 : height(c, r).toFixed(2)));
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

async function withPage(run) {
  const folder = mkdtempSync(join(tmpdir(), 'citylod-ground-'));
  write(folder);
  const command = (...words) => execFileSync(binary, words, { cwd: folder, stdio: 'ignore' });
  command('import', 'village.obj', '-o', 'hills.citylod');
  command('import', 'hills.asc', '--into', 'hills.citylod');
  command('import', 'village.obj', '-o', 'level.citylod');
  const service = spawn(binary, ['serve', '--listen', '127.0.0.1:0', 'hills.citylod', 'level.citylod'], { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'] });
  let context;
  try {
    const base = await new Promise((found, failed) => {
      let text = '';
      service.stderr.on('data', (part) => {
        text += part;
        const at = /http:\/\/127\.0\.0\.1:\d+/.exec(text);
        if (at) found(at[0]);
      });
      service.on('exit', () => failed(new Error(`the service ended: ${text}`)));
    });
    context = await chromium.launchPersistentContext(join(folder, 'profile'), { executablePath: browser, args: flags, viewport: { width: 480, height: 320 } });
    const page = await context.newPage();
    const errors = [];
    page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
    page.on('pageerror', (error) => errors.push(String(error)));
    await run(page, base);
    assert.deepEqual(errors, [], 'errors on the console');
  } finally {
    await context?.close();
    service.kill();
    rmSync(folder, { recursive: true, force: true });
  }
}

const shown = (page) => page.waitForFunction(() => window.citylod?.city?.answer && window.citylod.city.chunks.pending === 0, undefined, { timeout: 60_000 });

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
  const { geometry } = app.stage.relief;
  return {
    settled: here(),
    camera: app.ground.answered.camera,
    effects: app.ground.answered.effects,
    figures: app.ground.figures,
    origin: app.city.collection.origin,
    positions: [...geometry.getAttribute('position').array],
    index: [...geometry.index.array],
    visible: app.stage.relief.visible,
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

test('the ground on the page is what the service answers', { skip: missing }, () => withPage(async (page, base) => {
  await page.goto(`${base}/#scene=hills`);
  await shown(page);
  const counts = [];
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
    // No cracks: a side belongs to two triangles, which run along it in opposite directions, or lies at an end.
    const sides = new Map();
    for (let t = 0; t < seen.index.length; t += 3) {
      for (let k = 0; k < 3; k += 1) {
        const side = `${seen.index[t + k]} ${seen.index[t + ((k + 1) % 3)]}`;
        assert.ok(!sides.has(side), 'a side is passed once each way');
        sides.set(side, true);
      }
    }
    counts.push(triangles.length);
  }
  console.log(`triangles of ground: ${counts.join(', ')}`);
  assert.ok(new Set(counts).size === counts.length && Math.min(...counts) > 100, `${counts}`);
}));

test('the ground can be switched off, and other scenes have none', { skip: missing }, () => withPage(async (page, base) => {
  await page.goto(`${base}/#scene=hills`);
  await shown(page);
  await page.waitForFunction(() => window.citylod.stage.relief.visible, undefined, { timeout: 30_000 });
  const toggle = page.locator('label.toggle', { hasText: 'Terrain' }).locator('input');
  await toggle.evaluate((input) => input.click());
  await page.waitForFunction(() => !window.citylod.stage.relief.visible && window.citylod.stage.plane.visible);
  await toggle.evaluate((input) => input.click());
  await page.waitForFunction(() => window.citylod.stage.relief.visible && !window.citylod.stage.plane.visible, undefined, { timeout: 30_000 });
  // Who walks stands on it.
  await page.evaluate(() => window.citylod.way('walk'));
  await page.waitForFunction(() => {
    const app = window.citylod;
    const { eye } = app.rig.pose;
    return Math.abs(eye[2] - app.ground.height(eye[0], eye[1]) - 1.7) < 0.1;
  }, undefined, { timeout: 30_000 });
  await page.goto(`${base}/#scene=level`);
  await page.reload();
  await shown(page);
  const level = await page.evaluate(() => [window.citylod.ground === undefined, window.citylod.stage.relief.visible, window.citylod.stage.plane.visible]);
  assert.deepEqual(level, [true, false, true]);
  assert.equal(await page.locator('label.toggle', { hasText: 'Terrain' }).count(), 0);
}));
