/** The page: finds the scenes, brings the picture and the buttons together. */

import './style.css';
import { type Collection, json, passes } from './api';
import * as hash from './hash';
import { dock } from './panel/dock';
import { h } from './panel/dom';
import { help } from './panel/help';
import { Panel } from './panel';
import { Picked } from './panel/picked';
import type { App as AppType } from './app';
import type { Tint } from './colours';

// three is most of the code: it comes while the service is asked.
const coming = import('./app');

/** What the browser test and the curious hold on to. */
declare global {
  interface Window {
    citylod?: AppType;
  }
}

const THEMES = ['auto', 'light', 'dark'] as const;
const TINTS: readonly Tint[] = ['class', 'level', 'height'];
const dark = matchMedia('(prefers-color-scheme: dark)');
const root = document.documentElement;
let theme: (typeof THEMES)[number] = THEMES.find((t) => t === localStorage.getItem('theme')) ?? 'auto';

function night(): boolean {
  return theme === 'dark' || (theme === 'auto' && dark.matches);
}

function paint(): void {
  root.dataset['theme'] = night() ? 'dark' : 'light';
}

function toast(text: string): void {
  const box = document.querySelector<HTMLElement>('.toast') ?? document.body.appendChild(h('div', { class: 'toast', role: 'alert' }));
  box.textContent = text;
  box.classList.add('shown');
  clearTimeout(Number(box.dataset['timer']));
  box.dataset['timer'] = String(setTimeout(() => box.classList.remove('shown'), 3000 + 40 * text.length));
}

/** Nothing can be shown: says why and what to do. */
function despair(title: string, text: string): void {
  document.body.replaceChildren(
    h('main', { class: 'despair card', role: 'alert' }, h('h1', {}, title), h('p', {}, text),
      h('p', {}, h('a', { href: '/about' }, 'What the service offers'), ' works without pictures.')),
  );
}

async function start(): Promise<void> {
  // Problem documents point to /#kind, which the page about the service explains.
  if (/^#[a-z-]+$/.test(location.hash)) location.replace(`/about${location.hash}`);
  paint();
  const { collections } = await json<{ collections: Collection[] }>('/collections');
  const first = () => collections.find((c) => c.objects > 0) ?? collections[0];
  if (!first()) return despair('No scene is being served.', 'Start the service with a city: citylod serve town.citylod');

  const canvas = document.querySelector('canvas')!;
  const scenes = h('select', { 'aria-label': 'Scene', onchange: () => follow(`#scene=${encodeURIComponent(scenes.value)}`) });
  const offer = () => scenes.replaceChildren(...collections.map((c) => h('option', { value: c.id }, c.title)));
  offer();
  const facts = h('span', { class: 'facts' });
  const themeButton = h('button', { type: 'button', title: 'Light, dark or as the system has it (N)', onclick: () => turn() });
  const links = h('nav', {}, h('a', { href: '/about' }, 'About'), h('a', { href: '/api' }, 'API'), themeButton);
  let app: AppType | undefined;
  const panel = new Panel((change) => app?.set(change), links);
  const picked = new Picked(() => app?.unpick());
  const helping = help();
  const docked = dock({
    way: (way) => app?.way(way),
    freeze: () => app?.freeze(),
    tour: () => app?.tour(),
    home: () => app?.reset(),
    help: () => helping.showModal(),
  });
  document.body.append(
    h('header', { class: 'bar card' }, h('a', { class: 'brand', href: '/about', title: 'About citylod' }, 'city', h('b', {}, 'lod')), scenes, facts),
    panel.progress, panel.element, picked.element, docked.element, helping,
  );
  if (matchMedia('(max-width: 46rem), (max-height: 34rem)').matches) panel.fold();

  /** Opens what an address says, and tells what of it there is not. */
  function follow(address: string, news: string[] = []): void {
    const otherwise = first();
    if (!otherwise) return toast('No scene is being served any more.');
    const { collection, place, faults } = hash.settle(hash.read(address), collections, otherwise);
    app?.open(collection, place);
    if (collection.objects === 0) news = [...news, 'This city has no objects: there is nothing to see.'];
    if (news.length + faults.length > 0) toast([...news, ...faults].join(' '));
  }

  /** Another set of scenes is served. Asks again while the service begins anew. */
  async function reload(): Promise<void> {
    try {
      const list = await json<{ collections: Collection[] }>('/collections');
      collections.splice(0, collections.length, ...list.collections);
    } catch {
      setTimeout(() => void reload(), 1000);
      return;
    }
    offer();
    follow(location.hash, ['The city was exchanged for a newer one.']);
  }

  function turn(): void {
    theme = THEMES[(THEMES.indexOf(theme) + 1) % THEMES.length]!;
    localStorage.setItem('theme', theme);
    repaint();
  }

  function repaint(): void {
    paint();
    themeButton.textContent = { auto: 'Auto', light: 'Light', dark: 'Dark' }[theme];
    app?.night();
  }

  const { App } = await coming;
  try {
    app = new App({
      canvas, panel, picked, toast, night,
      buttons: (state) => docked.set(state),
      opened: (collection) => {
        scenes.value = collection.id;
        facts.textContent = `${collection.objects.toLocaleString('en')} object${collection.objects === 1 ? '' : 's'}`;
        document.title = `${collection.title} · citylod`;
      },
      reload: () => void reload(),
    });
  } catch {
    return despair('This browser cannot draw the city.', 'The viewer needs WebGL 2. Try another browser, or allow hardware acceleration.');
  }
  window.citylod = app;
  root.classList.toggle('slow', app.stage.slow);
  docked.stick((at) => input(at));
  follow(location.hash);
  repaint();
  root.classList.add('ready');

  function input(at: { x: number; y: number } | undefined): void {
    app?.input.hold(at);
  }

  dark.addEventListener('change', repaint);
  addEventListener('hashchange', () => follow(location.hash));
  addEventListener('keydown', (event) => {
    const typing = event.target instanceof HTMLElement && event.target.matches('select, textarea, input:not([type=range]):not([type=checkbox])');
    if (!app || typing || event.ctrlKey || event.metaKey || event.altKey || helping.open) return;
    const keys: Record<string, () => void> = {
      '1': () => app?.way('orbit'),
      '2': () => app?.way('fly'),
      '3': () => app?.way('walk'),
      f: () => app?.freeze(),
      t: () => app?.tour(),
      c: () => app && app.set({ controller: !app.knobs.controller }),
      m: () => app && app.set({ mode: ({ range: 'error', error: 'budget', budget: 'range' } as const)[app.knobs.mode] }),
      l: () => app && app.set({ tint: TINTS[(TINTS.indexOf(app.knobs.tint) + 1) % TINTS.length]! }),
      n: () => turn(),
      p: () => panel.fold(),
      '?': () => helping.showModal(),
      home: () => app?.reset(),
      escape: () => app?.unpick(),
    };
    const run = keys[event.key.toLowerCase()];
    if (run && !event.repeat) run();
  });
}

start().catch((error: unknown) => {
  despair('The city cannot be shown.', error instanceof Error ? error.message : String(error));
  const again = h('button', { type: 'button', class: 'again', onclick: () => location.reload() }, 'Try again');
  if (passes(error)) document.querySelector('.despair')?.append(again);
});
