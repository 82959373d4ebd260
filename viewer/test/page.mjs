/** A service of its own and a page that shows it, for tests in a browser. */
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const root = join(import.meta.dirname, '..', '..');
const binary = process.env.CITYLOD ?? join(root, 'target/debug/citylod');
const browser = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);

/** Why no page can be shown here, if so. */
export const missing = !browser ? 'needs Chromium' : !existsSync(binary) ? `needs ${binary}: cargo build` : undefined;

const flags = ['--headless', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'];

/** Runs a command of the program, in a folder. */
export const citylod = (folder, ...words) => execFileSync(binary, words, { cwd: folder, stdio: 'ignore' });

/** Starts a service; gives the process and where it listens. */
export async function serve(listen, words) {
  const service = spawn(binary, ['serve', '--listen', listen, ...words], { stdio: ['ignore', 'pipe', 'pipe'] });
  const base = await new Promise((found, failed) => {
    let text = '';
    const read = (part) => {
      text += part;
      const at = /http:\/\/127\.0\.0\.1:\d+/.exec(text);
      if (at) found(at[0]);
    };
    service.stdout.on('data', read);
    service.stderr.on('data', read);
    service.on('exit', () => failed(new Error(`the service ended: ${text}`)));
  });
  return { service, base };
}

/** Done when a process has ended. */
export const ended = (process) => new Promise((done) => process.on('exit', done));

/** In the page: whether it shows the whole answer. */
export const shown = () => window.citylod?.city?.answer && window.citylod.city.chunks.pending === 0;

/**
 * Runs with a service over these files and a page that shows it. In place of the files may be what
 * makes cities in a folder and gives their paths. `options` are more words for the
 * service, what to do with the page before it is opened, and the screen: its size in CSS pixels and
 * pixels of its own for each. No error may come to the console, but
 * those that `run` removes from the list.
 */
export async function withPage(files, { words = [], prepare, size = { width: 480, height: 320 }, scale = 1 }, run) {
  const folder = mkdtempSync(join(tmpdir(), 'citylod-viewer-'));
  const cities = typeof files === 'function' ? files(folder) : files.map((file) => {
    citylod(folder, 'import', file, '-o', 'real.citylod');
    return join(folder, 'real.citylod');
  });
  const held = await serve('127.0.0.1:0', [...words, ...cities]);
  let context;
  try {
    context = await chromium.launchPersistentContext(join(folder, 'profile'), { executablePath: browser, args: flags, viewport: size, deviceScaleFactor: scale });
    const page = await context.newPage();
    const errors = [];
    page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
    page.on('pageerror', (error) => errors.push(String(error)));
    await prepare?.(page);
    await page.goto(held.base);
    await page.waitForFunction(shown, undefined, { timeout: 60_000 });
    await run(page, held, errors);
    assert.deepEqual(errors, [], 'errors on the console');
  } finally {
    await context?.close();
    held.service.kill();
    rmSync(folder, { recursive: true, force: true });
  }
}

/** The middle one. */
export const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];
