/** The card of a picked object: what it is and why it is drawn. */

import type { Item } from '../api';
import { grouped, h, length, short } from './dom';

export interface Why {
  /** From the eye, m. */
  distance: number;
  /** On the screen, pixels. */
  size_px: number;
  sentence: string;
}

/** Attributes shown at first. */
const FEW = 12;

export class Picked {
  readonly element = h('aside', { class: 'picked card', hidden: true, 'aria-label': 'Picked object', 'aria-live': 'polite' });

  constructor(private readonly closed: () => void) {}

  hide(): void {
    this.element.hidden = true;
  }

  show(item: Item, why: Why, link: string): void {
    const row = (name: string, value: string) => [h('dt', {}, name), h('dd', {}, value)];
    const rows = [
      ...row('Height', length(item.height_m)),
      ...row('Footprint', `${grouped(item.footprint_area_m2)} m²`),
      ...row('Distance', length(why.distance)),
      ...row('On screen', `${short(why.size_px)} px`),
    ];
    const attributes = Object.entries(item.attributes ?? {}).filter(([, v]) => v !== null && v !== '');
    const more = attributes.slice(0, FEW).flatMap(([name, value]) =>
      row(name, typeof value === 'object' ? JSON.stringify(value) : String(value)));
    const rest = attributes.length - FEW;
    this.element.replaceChildren(
      h('button', { type: 'button', class: 'close', title: 'Close (Esc)', 'aria-label': 'Close', onclick: () => this.closed() }, '×'),
      h('p', { class: 'kind' }, `${item.class} · level ${item.level}`),
      h('h2', {}, item.id),
      h('p', { class: 'why' }, why.sentence),
      h('dl', {}, ...rows, ...more),
      h('p', { class: 'links' }, h('a', { href: link }, rest > 0 ? `JSON, with ${rest} more attribute${rest > 1 ? 's' : ''}` : 'JSON')),
    );
    this.element.hidden = false;
  }
}
