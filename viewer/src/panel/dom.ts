/** Parts that the panels are made of. */

type Child = Node | string | null | undefined | false;

/** An element. Properties are set as they are; those with a dash and `class`, `role` as attributes. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Record<string, unknown> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === false) continue;
    if (name.includes('-') || name === 'class' || name === 'role' || name === 'for') element.setAttribute(name, String(value));
    else (element as unknown as Record<string, unknown>)[name] = value;
  }
  element.append(...children.filter((c): c is Node | string => c !== null && c !== undefined && c !== false));
  return element;
}

/** A drawing of 20 × 20, from the strokes of a path. */
export function icon(path: string): SVGSVGElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 20 20');
  svg.setAttribute('aria-hidden', 'true');
  const stroke = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  stroke.setAttribute('d', path);
  svg.append(stroke);
  return svg;
}

export interface Choice<T extends string> {
  element: HTMLElement;
  set(value: T): void;
}

/** One of a few. */
export function segmented<T extends string>(
  label: string,
  options: readonly { value: T; text: string; title?: string; icon?: string }[],
  chosen: (value: T) => void,
): Choice<T> {
  const buttons = options.map((option) =>
    h(
      'button',
      { type: 'button', role: 'radio', title: option.title, onclick: () => chosen(option.value) },
      option.icon !== undefined && icon(option.icon),
      h('span', {}, option.text),
    ),
  );
  const element = h('div', { class: 'segmented', role: 'radiogroup', 'aria-label': label }, ...buttons);
  // One stop for Tab; arrows choose, and do not steer.
  element.addEventListener('keydown', (event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    const at = buttons.findIndex((button) => button === event.target);
    if (by === undefined || at < 0) return;
    event.preventDefault();
    event.stopPropagation();
    const to = (at + by + options.length) % options.length;
    buttons[to]!.focus();
    chosen(options[to]!.value);
  });
  return {
    element,
    set: (value) => options.forEach((option, k) => {
      const on = option.value === value;
      buttons[k]!.setAttribute('aria-checked', String(on));
      buttons[k]!.tabIndex = on ? 0 : -1;
    }),
  };
}

export interface Slider {
  element: HTMLElement;
  set(value: number): void;
  enable(on: boolean): void;
}

/** A number between two others, on a scale of equal steps or equal ratios. */
export function slider(options: {
  label: string;
  title?: string;
  min: number;
  max: number;
  step?: number;
  ratio?: boolean;
  text(value: number): string;
  changed(value: number): void;
}): Slider {
  const { min, max, ratio } = options;
  const to = (v: number) => (ratio ? Math.log(v / min) / Math.log(max / min) : (v - min) / (max - min));
  const from = (p: number) => (ratio ? min * (max / min) ** p : min + p * (max - min));
  const round = (v: number) => (options.step ? Math.round(v / options.step) * options.step : Number(v.toPrecision(3)));
  const steps = options.step && !ratio ? Math.round((max - min) / options.step) : 400;
  const output = h('output');
  const show = (value: number) => {
    output.textContent = options.text(value);
    input.setAttribute('aria-valuetext', options.text(value));
    input.style.setProperty('--at', `${100 * Math.min(Math.max(to(value), 0), 1)}%`);
  };
  const input = h('input', {
    type: 'range', min: '0', max: String(steps), step: '1', 'aria-label': options.label,
    oninput: () => {
      const value = round(from(Number(input.value) / steps));
      show(value);
      options.changed(value);
    },
  });
  const element = h('label', { class: 'slider', title: options.title }, h('span', {}, options.label), output, input);
  return {
    element,
    set: (value) => {
      if (document.activeElement !== input || input.disabled) input.value = String(Math.round(to(value) * steps));
      show(value);
    },
    enable: (on) => {
      input.disabled = !on;
      element.classList.toggle('off', !on);
    },
  };
}

export interface Toggle {
  element: HTMLElement;
  set(on: boolean): void;
  enable(on: boolean): void;
}

/** On or off. */
export function toggle(label: string, title: string, changed: (on: boolean) => void): Toggle {
  const input = h('input', { type: 'checkbox', role: 'switch', onchange: () => changed(input.checked) });
  const element = h('label', { class: 'toggle', title }, h('span', {}, label), input, h('i'));
  return {
    element,
    set: (on) => (input.checked = on),
    enable: (on) => {
      input.disabled = !on;
      element.classList.toggle('off', !on);
    },
  };
}

/** `12345` → `12,345`. */
export const grouped = (n: number) => Math.round(n).toLocaleString('en');

/** A length, in the unit that suits it. */
export function length(metres: number): string {
  if (Number.isNaN(metres)) return '–';
  if (!Number.isFinite(metres)) return '∞';
  if (metres >= 10_000) return `${(metres / 1000).toFixed(1)}\u00a0km`;
  return metres >= 100 ? `${grouped(metres)}\u00a0m` : `${metres.toFixed(1)}\u00a0m`;
}

/** A number of three digits or so. */
export function short(n: number): string {
  if (!Number.isFinite(n)) return '∞';
  return n >= 100 ? grouped(n) : n.toFixed(1);
}
