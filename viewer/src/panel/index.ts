/** The panel: figures with their history, the knobs, colours and effects. */

import type { Answer, Collection, Mode } from '../api';
import type { City } from '../city';
import type { Figures } from '../ground';
import type { Way } from '../link';
import type { Knobs, Levels } from '../knobs';
import { countWithin } from '../ranges';
import { classColours, LEVELS, type Tint } from '../colours';
import { grouped, h, length, segmented, short, slider, toggle } from './dom';
import { Meter } from './meter';

const EFFECTS: Record<string, { label: string; title: string }> = {
  motion: { label: 'Motion', title: 'Less detail while the camera moves fast' },
  haze: { label: 'Haze', title: 'Nothing beyond the visibility range' },
  occlusion: { label: 'Occlusion', title: 'Nothing that is hidden behind nearer objects' },
  terrain: { label: 'Terrain', title: 'The ground as it is, finer where it is near' },
};

/** Classes that the legend names. */
const MOST_CLASSES = 8;

/** `SolitaryVegetationObject` → `Solitary vegetation object`. */
const words = (name: string) =>
  name.replace(/([a-z])([A-Z])/g, (_, end: string, start: string) => `${end} ${start.toLowerCase()}`);

const hex = (colour: number) => `#${colour.toString(16).padStart(6, '0')}`;

export class Panel {
  readonly element: HTMLElement;
  readonly frame = new Meter('frame', 'Frame', 'ms', 'Time to make a frame, not what the display waits', short);
  readonly far = new Meter('far', 'Far distance', '', 'How far every object is drawn', length);
  readonly objects = new Meter('objects', 'Objects', '', 'Objects drawn', grouped);
  readonly error = new Meter('error', 'Error bound', 'px', 'Nothing left out of the view for its distance or size is larger on the screen', short);
  private readonly effects = h('div', { class: 'group' });
  private readonly note = h('small', { hidden: true });
  private readonly legend = h('ul', { class: 'legend' });
  private readonly status = h('p', { class: 'status', role: 'status' });
  /** How much of what is drawn has come. */
  readonly progress = h('progress', { class: 'progress', max: 1, value: 1, 'aria-label': 'Loading boxes' });
  private readonly more: HTMLElement;
  private readonly parts;
  private readonly sheet;

  constructor(private readonly changed: (change: Partial<Knobs>) => void, links: Node) {
    const set = (change: Partial<Knobs>) => this.changed(change);
    this.parts = {
      mode: segmented<Mode>('Mode', [
        { value: 'range', text: 'Range', title: 'Everything near, representatives of every district far away' },
        { value: 'error', text: 'Error', title: 'Everything at least so large on the screen' },
        { value: 'budget', text: 'Budget', title: 'So many objects, the largest on the screen' },
      ], (mode) => set({ mode })),
      controller: toggle('Hold frame time', 'Far distance follows the time that frames take (C)', (controller) => set({ controller })),
      target: slider({ label: 'Target', min: 3, max: 60, step: 0.5, text: (v) => `${v} ms`, changed: (target_ms) => set({ target_ms }) }),
      far: slider({ label: 'Far distance', title: 'How far every object is drawn', min: 50, max: 20_000, ratio: true, text: length, changed: (far_dist_m) => set({ far_dist_m }) }),
      factor: slider({ label: 'Factor', title: 'How much farther each coarser level reaches', min: 1.5, max: 4, step: 0.1, text: (v) => `× ${v.toFixed(1)}`, changed: (dist_factor) => set({ dist_factor: Number(dist_factor.toFixed(1)) }) }),
      levels: slider({ label: 'Levels', title: 'Levels that have a range', min: 1, max: 8, step: 1, text: String, changed: (levels) => set({ levels }) }),
      beyond: toggle('Keep every district', 'The last level reaches to infinity', (beyond) => set({ beyond })),
      px: slider({ label: 'Smallest drawn', title: 'Exactly the objects of at least this size on the screen', min: 0.5, max: 200, ratio: true, text: (v) => `${short(v)} px`, changed: (max_error_px) => set({ max_error_px }) }),
      budget: slider({ label: 'Objects', title: 'Exactly so many, the largest on the screen', min: 50, max: 200_000, ratio: true, text: grouped, changed: (v) => set({ max_objects: Math.round(v) }) }),
      tint: segmented<Tint>('Colours', [
        { value: 'class', text: 'Class' }, { value: 'level', text: 'Level' }, { value: 'height', text: 'Height' },
      ], (tint) => set({ tint })),
      shadows: toggle('Shadows', 'Boxes cast shadows on the ground; where none is known, on a plane if they stand about level', (shadows) => set({ shadows })),
    };
    const p = this.parts;
    const meters = h('div', { class: 'meters' }, this.frame.element, this.objects.element, this.far.element, this.error.element);
    const more = h('button', { type: 'button', class: 'more', title: 'Show or hide the knobs (P)', 'aria-expanded': 'true', onclick: () => this.fold() }, h('span', { class: 'sr' }, 'Knobs'));
    this.sheet = h('div', { class: 'sheet' },
      h('section', {},
        h('h2', {}, 'Detail'), p.mode.element,
        h('div', { class: 'group', 'data-mode': 'range' }, p.controller.element, p.target.element, p.far.element, p.factor.element, p.levels.element, p.beyond.element),
        h('div', { class: 'group', 'data-mode': 'error' }, p.px.element),
        h('div', { class: 'group', 'data-mode': 'budget' }, p.budget.element),
      ),
      h('section', {}, h('h2', {}, 'Colours'), p.tint.element, this.legend),
      h('section', {}, h('h2', {}, 'Picture'), p.shadows.element, this.effects, this.note),
    );
    this.more = more;
    const foot = h('footer', {}, this.status, links);
    this.element = h('aside', { class: 'panel card', 'aria-label': 'Figures and knobs' }, meters, more, this.sheet, foot);
  }

  /** Shows or hides the knobs. */
  fold(): void {
    const folded = this.element.classList.toggle('folded');
    this.more.setAttribute('aria-expanded', String(!folded));
  }

  /** Another scene. */
  show(collection: Collection, levels: Levels): void {
    for (const meter of [this.frame, this.far, this.objects, this.error]) meter.forget();
    this.effects.replaceChildren();
    this.switches.clear();
    for (const name of Object.keys(collection.effects)) {
      const known = EFFECTS[name] ?? { label: name, title: name };
      const part = toggle(known.label, known.title, (on) => {
        const without = new Set(this.knobs?.without);
        if (on) without.delete(name);
        else without.add(name);
        this.changed({ without });
      });
      this.switches.set(name, part);
      this.effects.append(part.element);
    }
    this.levels = levels;
    this.classes = collection.classes;
  }

  private switches = new Map<string, ReturnType<typeof toggle>>();
  private levels: Levels | undefined;
  private classes: string[] = [];
  private knobs: Knobs | undefined;

  /** Remembers the figures of a frame; `far` is what it is drawn with, m. */
  push(answer: Answer, far: number | undefined): void {
    this.objects.push(answer.count);
    this.far.push(answer.lod.mode === 'range' ? far ?? Infinity : NaN);
    this.error.push(answer.lod.error_px ?? Infinity);
  }

  /** Writes all that changes by itself. */
  write(city: City, knobs: Knobs, ground: Figures | undefined): void {
    for (const meter of [this.frame, this.far, this.objects, this.error]) meter.show();
    this.set(knobs, false);
    const ends = city.answer ? city.levels.ends(city.answer.lod, knobs.beyond) : [];
    this.explain(knobs.tint, city.answer, ends);
    this.say(city.way, city.answer, city.chunks.progress);
    this.tell(ground);
  }

  /** Puts the knobs where they are. */
  set(knobs: Knobs, levelTint: boolean): void {
    const p = this.parts;
    this.knobs = knobs;
    p.mode.set(knobs.mode);
    p.controller.set(knobs.controller);
    p.target.set(knobs.target_ms);
    p.target.enable(knobs.controller);
    p.far.set(knobs.far_dist_m);
    p.far.enable(!knobs.controller);
    p.factor.set(knobs.dist_factor);
    p.levels.set(knobs.levels);
    p.beyond.set(knobs.beyond);
    p.px.set(knobs.max_error_px);
    p.budget.set(knobs.max_objects);
    p.tint.set(levelTint ? 'level' : knobs.tint);
    p.shadows.set(knobs.shadows);
    this.switches.forEach((part, name) => part.set(!knobs.without.has(name)));
    for (const group of this.element.querySelectorAll<HTMLElement>('[data-mode]')) group.hidden = group.dataset['mode'] !== knobs.mode;
    this.frame.against(knobs.controller && knobs.mode === 'range' ? knobs.target_ms : undefined);
  }

  /** What the colours stand for; for levels with how far they reach and how many are drawn. */
  private explain(tint: Tint, answer: Answer | undefined, ends: readonly number[]): void {
    const row = (colour: string, name: string, reach = '', drawn = '') =>
      h('li', {}, h('i', { style: `background:${colour}` }), h('span', {}, name), h('small', {}, reach), h('b', {}, drawn));
    if (tint === 'height') {
      this.legend.replaceChildren(h('li', { class: 'scale' }, h('i'), h('small', {}, '5 m'), h('small', {}, '40 m'), h('small', {}, '160 m')));
    } else if (tint === 'class') {
      const colours = classColours(this.classes);
      const rows = this.classes.slice(0, MOST_CLASSES).map((name, k) => row(hex(colours[k]!), words(name)));
      const more = this.classes.length - rows.length;
      this.legend.replaceChildren(...rows, ...(more > 0 ? [h('li', {}, h('small', {}, `and ${more} more`))] : []));
    } else {
      const rows = [];
      for (let level = 0; level < (this.levels?.count ?? 0); level += 1) {
        const [start, end] = this.levels!.span(level);
        const drawn = answer ? countWithin(answer.ranges, start, end) : 0;
        const far = ends[Math.min(level, ends.length - 1)];
        const reach = far === undefined ? '' : Number.isFinite(far) ? `to ${length(far)}` : 'at any distance';
        rows.push(row(hex(LEVELS[Math.min(level, 7)]!), `Level ${level}`, reach, grouped(drawn)));
      }
      this.legend.replaceChildren(...rows);
    }
  }

  /** Says what is drawn of the ground. */
  private tell(ground: Figures | undefined): void {
    const within = ground && (ground.error_px === null ? '' : `, within ${short(ground.error_px)} px`);
    const text = ground ? `${grouped(ground.triangles)} triangles of ground${within}` : '';
    if (this.note.textContent !== text) this.note.textContent = text;
    this.note.hidden = text === '';
  }

  /** Says how the service is reached and what the last answer took. */
  private say(way: Way, answer: Answer | undefined, progress: number): void {
    this.status.dataset['way'] = way;
    this.progress.value = progress;
    this.progress.classList.toggle('shown', progress < 1);
    const live = { stream: 'Live', post: 'Live by POST', none: 'Reconnecting…' }[way];
    const took = answer && way !== 'none' ? ` · found in ${short(answer.stats.retrieve_us)} µs` : '';
    const text = progress < 1 && way !== 'none' ? 'Loading boxes…' : `${live}${took}`;
    if (this.status.textContent !== text) this.status.textContent = text;
  }
}
