/** How much there is to load, and how long it takes to the first picture with nothing kept from before. */
import assert from 'node:assert/strict';
import test from 'node:test';
import { median, missing, withPage } from './page.mjs';

/** All parts of the page, compressed, bytes: at 10 Mbit/s a fifth of a second. */
const MOST = 224 * 1024;

test('the page is small and shows a picture', { skip: missing }, () =>
  withPage([], { size: { width: 1280, height: 800 } }, async (page, { base }) => {
    const devtools = await page.context().newCDPSession(page);
    await devtools.send('Network.enable');
    await devtools.send('Network.setCacheDisabled', { cacheDisabled: true });
    const times = [];
    let bytes = 0;
    for (let k = 0; k < 5; k += 1) {
      await page.goto('about:blank');
      await page.goto(base);
      await page.waitForFunction(() => performance.getEntriesByName('citylod: first picture').length > 0);
      const seen = await page.evaluate(() => ({
        at: performance.getEntriesByName('citylod: first picture')[0].startTime,
        parts: performance.getEntriesByType('resource').filter((part) => part.name.includes('/assets/')).map((part) => part.encodedBodySize),
      }));
      times.push(seen.at);
      bytes = seen.parts.reduce((sum, part) => sum + part, 0);
    }
    console.log(`first picture of the demo city after ${Math.round(median(times))} ms (median of 5: ${times.map(Math.round).join(', ')}); ${bytes} bytes of parts`);
    assert.ok(bytes > 0 && bytes < MOST, `${bytes} bytes`);
  }));
