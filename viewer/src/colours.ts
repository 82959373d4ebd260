/** Colours that both the picture and its legend use. */

export type Tint = 'class' | 'level' | 'height';

/** Levels, finest first; coarser than the last share its colour. */
export const LEVELS = [0x4f7fc4, 0x35a7a0, 0x7fbf5a, 0xf0c13b, 0xf08a3c, 0xd6487e, 0x8a4fc8, 0x5b5b6b];

/** What is not named here takes one of the others, in the order of the scene's classes. */
const KNOWN: [RegExp, number][] = [
  [/build|^house|tower|office|residential/i, 0xe6e0d6],
  [/tree|vegetation|plant|forest|park|green|grass/i, 0x86b27b],
  [/water|river|lake|sea/i, 0x7fb2d9],
  [/road|rail|transport|street|square|track/i, 0xa9adb3],
  [/bridge|tunnel/i, 0xc9a877],
  [/landuse|terrain|relief|ground/i, 0xc9c7a8],
  [/furniture|installation|pole|light/i, 0xb88f8f],
];
const OTHERS = [0xd9b38c, 0x9bb7d4, 0xc79fc2, 0xa8c4a0, 0xe0a39a, 0xb6b08f, 0x8fbfbf];

/** A colour for each class. */
export function classColours(classes: readonly string[]): number[] {
  let other = 0;
  return classes.map((name) => {
    const known = KNOWN.find(([pattern]) => pattern.test(name));
    return known ? known[1] : OTHERS[other++ % OTHERS.length]!;
  });
}
