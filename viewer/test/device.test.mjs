/** What browsers, screens and hands do to the page: no WebGL, a card that goes, more pixels, keys alone, slow loading. */
import assert from 'node:assert/strict';
import test from 'node:test';
import { missing, shown, withPage } from './page.mjs';

/** In the page: draws for a while and tells what the frame has in its corner. */
async function corner() {
  const app = window.citylod;
  app.stir(true);
  for (let k = 0; k < 3; k += 1) await new Promise(requestAnimationFrame);
  return [...app.stage.timing.pixel];
}

test('without WebGL the page says so', { skip: missing }, () => withPage([], {}, async (page, { base }, errors) => {
  await page.addInitScript(() => {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function context(kind, ...rest) {
      return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest);
    };
  });
  await page.goto('about:blank');
  await page.goto(base);
  await page.locator('.despair').waitFor();
  assert.match(await page.locator('.despair').textContent(), /cannot draw the city.*WebGL 2/);
  assert.equal(await page.locator('.panel, .dock, canvas').count(), 0, 'nothing is offered that does nothing');
  // three says it too.
  assert.ok(errors.every((text) => /WebGL/.test(text)), errors.join('\n'));
  errors.length = 0;
}));

test('the picture comes back with the graphics card', { skip: missing }, () => withPage([], {}, async (page, _, errors) => {
  const before = await page.evaluate(corner);
  assert.ok(before.some((value) => value > 0));
  await page.evaluate(() => {
    const gl = document.querySelector('#view').getContext('webgl2');
    window.card = gl.getExtension('WEBGL_lose_context');
    window.card.loseContext();
  });
  await page.waitForFunction(() => /graphics card/.test(document.querySelector('.toast.shown')?.textContent ?? ''));
  const told = await page.evaluate(async () => {
    const samples = [];
    const { sample } = window.citylod;
    window.citylod.stir(true);
    for (let k = 0; k < 5; k += 1) await new Promise(requestAnimationFrame);
    if (window.citylod.sample !== sample) samples.push(window.citylod.sample);
    return samples;
  });
  assert.deepEqual(told, [], 'no frame time is taken where nothing is drawn');
  await page.evaluate(() => {
    window.citylod.stage.timing.pixel.fill(0);
    window.card.restoreContext();
  });
  await page.waitForFunction(() => window.citylod.stage.timing.pixel.some((value) => value > 0));
  assert.deepEqual(await page.evaluate(corner), before);
  assert.ok(errors.every((text) => /context/i.test(text)), errors.join('\n'));
  errors.length = 0;
}));

/** In the page, before it is opened: the processor that draws is taken for a card. */
const card = () => {
  const get = WebGL2RenderingContext.prototype.getExtension;
  WebGL2RenderingContext.prototype.getExtension = function extension(name) {
    return name === 'WEBGL_debug_renderer_info' ? null : get.call(this, name);
  };
};

for (const [scale, ratio] of [[2, 2], [3, 2]]) {
  test(`on a screen of ${scale} pixels to each the picture has ${ratio}`, { skip: missing }, () =>
    withPage([], { scale, prepare: (page) => page.addInitScript(card) }, async (page) => {
      const { size, asked, slow } = await page.evaluate(() => {
        const { width, height } = document.querySelector('#view');
        return { size: [width, height], asked: window.citylod.asked.camera.viewport, slow: window.citylod.stage.slow };
      });
      assert.equal(slow, false);
      assert.deepEqual([size, asked], [[480 * ratio, 320 * ratio], [480 * ratio, 320 * ratio]]);
    }));
}

test('who wants little to move sees no glides', { skip: missing }, () => withPage([], {}, async (page) => {
  await page.emulateMedia({ reducedMotion: 'reduce' });
  await page.waitForFunction(() => window.citylod.rig.calm);
  const there = await page.evaluate(() => {
    const app = window.citylod;
    const home = structuredClone(app.rig.pose);
    app.rig.jump({ ...home, eye: [0, 0, 300] });
    app.reset();
    return [app.rig.pose, home];
  });
  assert.deepEqual(there[0], there[1]);
  const moved = await page.evaluate(() => [...document.querySelectorAll('*')].filter((e) => getComputedStyle(e).transitionProperty !== 'none').map((e) => e.className));
  assert.deepEqual(moved, []);
}));

test('keys are enough', { skip: missing }, () => withPage([], { size: { width: 1280, height: 900 } }, async (page) => {
  const devtools = await page.context().newCDPSession(page);
  const { nodes } = await devtools.send('Accessibility.getFullAXTree');
  const used = nodes.filter((node) => !node.ignored && ['button', 'radio', 'switch', 'slider', 'combobox', 'link', 'application'].includes(node.role?.value));
  const unnamed = used.filter((node) => !/[a-z]/i.test(node.name?.value ?? ''));
  assert.deepEqual(unnamed.map((node) => [node.role.value, node.name?.value]), []);
  assert.ok(used.length > 15, `${used.length}`);

  // Whatever Tab comes to is seen to have the focus.
  const reached = [];
  for (let k = 0; k < 40; k += 1) {
    await page.keyboard.press('Tab');
    const at = await page.evaluate(() => {
      const element = document.activeElement;
      if (element === document.body) return undefined;
      const shows = element.matches('.toggle input') ? element.nextElementSibling : element;
      const { outlineStyle, outlineWidth } = getComputedStyle(shows);
      return { name: element.id || element.className || element.getAttribute('aria-label') || element.textContent, marked: outlineStyle !== 'none' && outlineWidth !== '0px', role: element.role };
    });
    if (!at) break;
    assert.ok(at.marked, `${at.name} has a mark`);
    reached.push(at);
  }
  assert.equal(reached[0].name, 'view');
  assert.equal(reached.filter(({ role }) => role === 'radio').length, 3, 'a group of radio buttons is one stop');

  // Arrows choose where there is a choice, and turn elsewhere.
  const heading = () => page.evaluate(() => window.citylod.rig.pose.heading);
  const start = await heading();
  await page.locator('[role=radio][aria-checked=true]', { hasText: 'Range' }).focus();
  await page.keyboard.press('ArrowRight');
  assert.deepEqual(await page.evaluate(() => [window.citylod.knobs.mode, document.activeElement.textContent]), ['error', 'Error']);
  await page.keyboard.press('ArrowLeft');
  assert.equal(await page.evaluate(() => window.citylod.knobs.mode), 'range');
  assert.equal(await heading(), start);
  await page.locator('#view').focus();
  await page.keyboard.down('ArrowRight');
  await page.waitForFunction((from) => Math.abs(window.citylod.rig.pose.heading - from) > 3, start);
  await page.keyboard.up('ArrowRight');

  // What is in the middle is told, and closed again.
  await page.evaluate(() => {
    const app = window.citylod;
    const [x0, y0, , x1, y1, z1] = app.city.instances.box(0);
    app.rig.jump({ eye: [(x0 + x1) / 2, (y0 + y1) / 2, z1 + 60], heading: 0, pitch: -89 });
    app.stir(true);
  });
  await page.waitForFunction(() => window.citylod.stage.camera.position.z === window.citylod.rig.pose.eye[2]);
  await page.keyboard.press('Enter');
  await page.locator('.picked:not([hidden])').waitFor();
  await page.keyboard.press('Escape');
  await page.locator('.picked').waitFor({ state: 'hidden' });
}));

test('boxes that take long are waited for, those that fail are fetched again', { skip: missing }, () => withPage([], {}, async (page, { base }, errors) => {
  let failed = 0;
  let release;
  const held = new Promise((go) => (release = go));
  await page.route('**/boxes?*', async (route) => {
    if (failed < 2) {
      failed += 1;
      return route.abort();
    }
    await held;
    return route.continue();
  });
  await page.goto('about:blank');
  await page.goto(base);
  await page.waitForFunction(() => document.querySelector('.progress.shown')?.value < 1 && /Loading/.test(document.querySelector('.status').textContent), undefined, { timeout: 30_000 });
  // The link tells where the service is gone; a fetch that failed tells nothing more.
  assert.equal(await page.locator('.toast.shown').count(), 0);
  release();
  await page.waitForFunction(shown, undefined, { timeout: 30_000 });
  await page.waitForFunction(() => window.citylod.city.instances.count === window.citylod.city.answer.count && !document.querySelector('.progress.shown'));
  assert.equal(failed, 2);
  assert.ok(errors.every((text) => text.includes('ERR_FAILED')), errors.join('\n'));
  errors.length = 0;
}));
