/** The buttons at the foot of the picture, and the stick for thumbs. */

import type { Way } from '../rig';
import { h, icon, segmented } from './dom';

const ICONS = {
  orbit: 'M10 13.2c4 0 7.2-1.4 7.2-3.2S14 6.8 10 6.8 2.8 8.2 2.8 10s3.2 3.2 7.2 3.2zM10 10h.01',
  fly: 'M3 11l14-7-5 13-2.5-5.5z',
  walk: 'M11 3.2h.01M8 18l2-5-2.5-2.5.8-4h3l2.2 3 2.5.8M10 13l2.5 5M6.5 9l1.8-2.5',
  freeze: 'M10 2.5v15M3.5 6.2l13 7.6M16.5 6.2l-13 7.6',
  tour: 'M4 16c0-6 12-3 12-9M4 16h.01M16 4h.01',
  home: 'M3.5 9.5L10 4l6.5 5.5M5.5 8.5V16h9V8.5',
  help: 'M7.5 7.5a2.5 2.5 0 1 1 3.6 2.2c-.8.4-1.1.9-1.1 1.8M10 14.5h.01',
};

export interface DockEvents {
  way(way: Way): void;
  freeze(): void;
  tour(): void;
  home(): void;
  help(): void;
}

type Point = { x: number; y: number };

/** How far the stick goes, pixels. */
const THROW = 42;

export interface Dock {
  element: HTMLElement;
  set(state: { way: Way; frozen: boolean; touring: boolean }): void;
  /** Called with where the stick is held. */
  stick(held: (at: Point | undefined) => void): void;
}

export function dock(events: DockEvents): Dock {
  const ways = segmented<Way>('Move', [
    { value: 'orbit', text: 'Orbit', title: 'Turn about the city (1)', icon: ICONS.orbit },
    { value: 'fly', text: 'Fly', title: 'Fly freely (2)', icon: ICONS.fly },
    { value: 'walk', text: 'Walk', title: 'Walk in the streets (3)', icon: ICONS.walk },
  ], events.way);
  const button = (name: keyof typeof ICONS, text: string, title: string, run: () => void) =>
    h('button', { type: 'button', title, class: name, onclick: run }, icon(ICONS[name]), h('span', {}, text));
  const freeze = button('freeze', 'Freeze', 'Freeze the selection and step outside (F)', events.freeze);
  const tour = button('tour', 'Tour', 'Fly around the city (T)', events.tour);
  const knob = h('i');
  const pad = h('div', { class: 'stick', hidden: true, 'aria-label': 'Stick to move' }, knob);
  const element = h('nav', { class: 'dock', 'aria-label': 'Move and look' },
    pad,
    h('div', { class: 'card' },
      ways.element, freeze, tour,
      button('home', 'Home', 'Back to the first view (Home)', events.home),
      button('help', 'Help', 'Keys and gestures (?)', events.help)));
  return {
    element,
    set: ({ way, frozen, touring }) => {
      ways.set(way);
      freeze.setAttribute('aria-pressed', String(frozen));
      tour.setAttribute('aria-pressed', String(touring));
      pad.hidden = way === 'orbit' || !matchMedia('(pointer: coarse)').matches;
    },
    stick: (held) => {
      const place = (at: Point | undefined) => {
        knob.style.transform = at ? `translate(${at.x * THROW}px, ${-at.y * THROW}px)` : '';
        held(at);
      };
      const at = (event: PointerEvent): Point => {
        const { left, top, width, height } = pad.getBoundingClientRect();
        const x = (event.clientX - left - width / 2) / THROW;
        const y = -(event.clientY - top - height / 2) / THROW;
        const far = Math.max(Math.hypot(x, y), 1);
        return { x: x / far, y: y / far };
      };
      pad.addEventListener('pointerdown', (event) => {
        pad.setPointerCapture(event.pointerId);
        place(at(event));
      });
      pad.addEventListener('pointermove', (event) => pad.hasPointerCapture(event.pointerId) && place(at(event)));
      for (const end of ['pointerup', 'pointercancel'] as const) pad.addEventListener(end, () => place(undefined));
    },
  };
}
