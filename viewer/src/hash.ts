/** The address of the page: which scene, from where, how. Coordinates are the scene's own. */

import type { Mode, Vec3 } from './api';
import type { Way } from './rig';

export interface Place {
  scene?: string;
  eye?: Vec3;
  /** Heading and pitch, degrees. */
  look?: [number, number];
  way?: Way;
  mode?: Mode;
}

function numbers(text: string | null, count: number): number[] | undefined {
  const parts = text?.split(',').map(Number) ?? [];
  return parts.length === count && parts.every(Number.isFinite) ? parts : undefined;
}

function oneOf<T extends string>(text: string | null, options: readonly T[]): T | undefined {
  return options.find((option) => option === text);
}

/** What an address says; what it does not say well it does not say. */
export function read(hash: string): Place {
  const said = new URLSearchParams(hash.replace(/^#/, ''));
  const place: Place = {};
  const scene = said.get('scene');
  const eye = numbers(said.get('eye'), 3) as Vec3 | undefined;
  const look = numbers(said.get('look'), 2) as [number, number] | undefined;
  const way = oneOf(said.get('by'), ['orbit', 'fly', 'walk'] as const);
  const mode = oneOf(said.get('mode'), ['range', 'error', 'budget'] as const);
  if (scene !== null) place.scene = scene;
  if (eye) place.eye = eye;
  if (look) place.look = look;
  if (way) place.way = way;
  if (mode) place.mode = mode;
  return place;
}

/** The address of a place: to the centimetre and the hundredth of a degree. */
export function write(place: Required<Place>): string {
  const eye = place.eye.map((v) => Number(v.toFixed(2))).join(',');
  const look = place.look.map((v) => Number(v.toFixed(2))).join(',');
  return `#scene=${encodeURIComponent(place.scene)}&eye=${eye}&look=${look}&by=${place.way}&mode=${place.mode}`;
}
