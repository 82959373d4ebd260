/** A figure with its short history as a line. */

import { h } from './dom';

/** Frames remembered. */
const MEMORY = 120;

export class Meter {
  readonly element: HTMLElement;
  private readonly value = h('b', {}, '–');
  private readonly note = h('small');
  private readonly canvas = h('canvas', { 'aria-hidden': 'true' });
  private readonly history: number[] = [];
  /** A line to hold the history against. */
  private mark: number | undefined;

  constructor(
    name: string,
    label: string,
    private readonly unit: string,
    title: string,
    private readonly text: (value: number) => string,
  ) {
    this.element = h(
      'div', { class: 'meter', title, 'data-meter': name },
      h('span', {}, label), h('div', {}, this.value, this.note), this.canvas,
    );
    this.note.textContent = unit;
  }

  push(value: number): void {
    this.history.push(value);
    if (this.history.length > MEMORY) this.history.shift();
  }

  forget(): void {
    this.history.length = 0;
  }

  against(mark: number | undefined): void {
    this.mark = mark;
  }

  /** Draws what was pushed; now and then, as nobody reads sixty figures a second. */
  show(note?: string): void {
    const last = this.history.at(-1);
    this.value.textContent = last === undefined ? '–' : this.text(last);
    this.note.textContent = note ?? this.unit;
    this.line();
  }

  private line(): void {
    const { canvas, history } = this;
    const ratio = devicePixelRatio || 1;
    const width = canvas.clientWidth * ratio, height = canvas.clientHeight * ratio;
    if (width === 0) return;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    const pen = canvas.getContext('2d');
    if (!pen) return;
    pen.clearRect(0, 0, width, height);
    const finite = history.filter(Number.isFinite);
    if (finite.length < 2) return;
    const top = Math.max(...finite, this.mark ?? 0) * 1.12 || 1;
    const style = getComputedStyle(canvas);
    const y = (v: number) => height - ratio - (Math.min(v, top) / top) * (height - 2 * ratio);
    const x = (k: number) => width - ((history.length - 1 - k) / (MEMORY - 1)) * width;
    if (this.mark !== undefined) {
      pen.strokeStyle = style.getPropertyValue('--soft');
      pen.lineWidth = ratio;
      pen.setLineDash([3 * ratio, 3 * ratio]);
      pen.beginPath();
      pen.moveTo(0, y(this.mark));
      pen.lineTo(width, y(this.mark));
      pen.stroke();
      pen.setLineDash([]);
    }
    pen.beginPath();
    history.forEach((v, k) => pen[k === 0 ? 'moveTo' : 'lineTo'](x(k), y(v)));
    pen.strokeStyle = style.color;
    pen.lineWidth = 1.4 * ratio;
    pen.lineJoin = 'round';
    pen.stroke();
    pen.lineTo(x(history.length - 1), height);
    pen.lineTo(x(0), height);
    pen.globalAlpha = 0.1;
    pen.fillStyle = style.color;
    pen.fill();
    pen.globalAlpha = 1;
  }
}
