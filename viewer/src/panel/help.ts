/** What keys, mouse and fingers do. */

import { h } from './dom';

const GROUPS: [string, [string, string][]][] = [
  ['Move', [
    ['1 2 3', 'Orbit, fly, walk'],
    ['W A S D', 'Move'],
    ['Arrows', 'Turn'],
    ['+ −', 'Nearer, farther'],
    ['E Q', 'Up, down'],
    ['Shift', 'Faster'],
    ['Home', 'Back to the first view'],
    ['T', 'Tour'],
  ]],
  ['Mouse', [
    ['Drag', 'Turn'],
    ['Right drag, Shift drag', 'Move over the ground'],
    ['Wheel', 'Nearer, farther'],
    ['Click', 'What is this, and why is it drawn'],
  ]],
  ['Touch', [
    ['One finger', 'Turn'],
    ['Two fingers', 'Move, nearer, farther'],
    ['Tap', 'What is this'],
    ['Stick', 'Fly and walk'],
  ]],
  ['See', [
    ['Enter', 'What is in the middle, and why is it drawn'],
    ['F', 'Freeze the selection and step outside'],
    ['L', 'Colours: class, level, height'],
    ['C', 'Controller on or off'],
    ['M', 'Mode: range, error, budget'],
    ['N', 'Light or dark'],
    ['P', 'Knobs'],
  ]],
];

/** The dialog; opened by `?`. */
export function help(): HTMLDialogElement {
  const groups = GROUPS.map(([title, rows]) =>
    h('section', { class: title === 'Touch' ? 'touch' : 'keys' }, h('h3', {}, title), h('dl', {}, ...rows.flatMap(([keys, what]) => [
      h('dt', {}, ...keys.split(', ').map((k) => h('kbd', {}, k))), h('dd', {}, what),
    ]))));
  const dialog: HTMLDialogElement = h('dialog', { class: 'helping card', 'aria-label': 'Help', onclick: (e: Event) => e.target === dialog && dialog.close() },
    h('form', { method: 'dialog' }, h('button', { class: 'close', title: 'Close (Esc)', 'aria-label': 'Close' }, '×')),
    h('h2', {}, 'Find your way'),
    h('div', { class: 'columns' }, ...groups),
    h('p', {}, 'Near the camera every object is drawn. With distance districts thin out, level by level, down to the representatives that stand for them. The address of this page holds where you are: share it.'),
  );
  return dialog;
}
