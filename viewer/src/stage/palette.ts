/** Colours of the picture, by day and by night. */

import { Color, ColorManagement } from 'three';
import type { Vec3 } from '../api';

// Colours are used as they are shown. Said here, before the first is made.
ColorManagement.enabled = false;

/** Towards the sun. */
export const SUN: Vec3 = [-0.52, -0.42, 0.74];

export interface Palette {
  zenith: Color;
  horizon: Color;
  /** About the sun. */
  glow: Color;
  ground: Color;
  line: Color;
  shadow: number;
  /** Light of the sun, and of the sky from above and from below. */
  sun: Color;
  above: Color;
  below: Color;
  /** Darkness of edges, 0 to 1; by night edges are light. */
  edge: Color;
  ring: Color;
  pick: Color;
  /** From low to tall. */
  heights: Color[];
}

const colours = (...hex: number[]) => hex.map((h) => new Color(h));

export const DAY: Palette = {
  zenith: new Color(0x6f9fd0),
  horizon: new Color(0xdde6ec),
  glow: new Color(0xfff1d6),
  ground: new Color(0xd3d2cb),
  line: new Color(0xb9b9b4),
  shadow: 0.84,
  sun: new Color(0.46, 0.42, 0.36),
  above: new Color(0.68, 0.71, 0.76),
  below: new Color(0.56, 0.56, 0.58),
  edge: new Color(0x3a4452),
  ring: new Color(0x1f6feb),
  pick: new Color(0xff7a1a),
  heights: colours(0xe9e4da, 0xcfd9e2, 0x9db9d3, 0x5d8cbd, 0x1f5a99, 0xe4572e),
};

export const NIGHT: Palette = {
  zenith: new Color(0x070b14),
  horizon: new Color(0x26354a),
  glow: new Color(0x5c6f8f),
  ground: new Color(0x18202c),
  line: new Color(0x273344),
  shadow: 0.72,
  sun: new Color(0.22, 0.26, 0.33),
  above: new Color(0.3, 0.35, 0.44),
  below: new Color(0.2, 0.22, 0.28),
  edge: new Color(0xbcd3f2),
  ring: new Color(0x6fb1ff),
  pick: new Color(0xff9a4a),
  heights: colours(0x5d6b80, 0x62809f, 0x5f97c6, 0x6fb4e6, 0xa9dcff, 0xff9a5c),
};
