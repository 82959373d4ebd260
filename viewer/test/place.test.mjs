/** What the address of the page says: what of it is right is done, what is not is told. */
import assert from 'node:assert/strict';
import test from 'node:test';
import { createServer } from 'vite';
import { missing, shown, withPage } from './page.mjs';

const vite = await createServer({ configFile: false, logLevel: 'error', server: { middlewareMode: true, ws: false } });
test.after(() => vite.close());
const { read, settle, write } = await vite.ssrLoadModule('/src/hash.ts');

const pose = { eye: [10, -20, 30], look: [34, -17] };
const city = (id) => ({ id, title: id.toUpperCase(), bounds: [0, 0, 0, 1000, 800, 50] });
const here = [city('old'), city('new')];

test('an address that was written is read as it was', () => {
  const place = { scene: 'a b&c', ...pose, way: 'walk', mode: 'error' };
  assert.deepEqual(read(write(place)), { place, faults: [] });
  assert.deepEqual(read(''), { place: {}, faults: [] });
});

test('what is wrong is left out and named', () => {
  for (const [address, place, fault] of [
    ['#eye=1,2&look=3,4', {}, /^eye=1,2 /],
    ['#eye=1,2,&look=3,4', {}, /^eye=1,2, /],
    ['#eye=1,2,x&look=3,4&by=fly', { way: 'fly' }, /^eye=1,2,x /],
    ['#eye=1,2,3&look=3,91', {}, /^look=3,91 /],
    ['#eye=1,2,Infinity&look=3,9', {}, /^eye=/],
    ['#eye=1,2,3', {}, /no look/],
    ['#look=3,4', {}, /no eye/],
    ['#by=swim&mode=error', { mode: 'error' }, /^by=swim .*orbit, fly, walk/],
    ['#mode=all', {}, /^mode=all .*range, error, budget/],
  ]) {
    const said = read(address);
    assert.deepEqual(said.place, place, address);
    assert.equal(said.faults.length, 1, address);
    assert.match(said.faults[0], fault);
  }
});

test('a pose holds in its own scene, where the city is in sight', () => {
  const at = (place) => settle({ place, faults: [] }, here, here[0]);
  assert.deepEqual(at({}), { collection: here[0], place: {}, faults: [] });
  assert.deepEqual(at({ scene: 'new', ...pose }), { collection: here[1], place: { scene: 'new', ...pose }, faults: [] });
  const gone = at({ scene: 'gone', ...pose, way: 'fly' });
  assert.deepEqual([gone.collection, gone.place], [here[0], { scene: 'gone', way: 'fly' }]);
  assert.match(gone.faults[0], /gone.*OLD/);
  const lost = at({ scene: 'new', eye: [500, 5e6, 100], look: [0, 0] });
  assert.deepEqual([lost.collection, lost.place], [here[1], { scene: 'new' }]);
  assert.match(lost.faults[0], /4999\.2\skm/);
});

test('the page tells of a link that is wrong and shows the city', { skip: missing }, () => withPage([], {}, async (page, { base }) => {
  const go = async (address) => {
    await page.goto('about:blank');
    await page.goto(`${base}/${address}`);
    await page.waitForFunction(shown, undefined, { timeout: 60_000 });
  };
  const eye = () => page.evaluate(() => window.citylod.city.absolute(window.citylod.rig.pose.eye));
  await go('');
  const home = await eye();
  assert.equal(await page.locator('.toast.shown').count(), 0);
  for (const [address, told] of [
    ['#scene=atlantis&eye=1,2,3&look=0,0', /no scene “atlantis”/],
    ['#scene=demo&eye=1,2&look=0,0', /eye=1,2 in the link/],
    ['#scene=demo&eye=0,9e7,10&look=0,0', /from the city/],
  ]) {
    await go(address);
    assert.match(await page.locator('.toast.shown').textContent(), told);
    assert.deepEqual(await eye(), home);
    await page.waitForFunction(() => location.hash.startsWith('#scene=demo&eye='));
  }
  // Also where the page is open.
  await page.evaluate(() => { location.hash = '#scene=demo&eye=0,0,90&look=180,-5&by=swim'; });
  await page.waitForFunction(() => /by=swim/.test(document.querySelector('.toast.shown')?.textContent ?? ''));
  await page.waitForFunction(() => window.citylod.rig.pose.heading === 180);
}));
