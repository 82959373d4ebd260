/** The address of the page: which scene, from where, how. Coordinates are the scene's own. */

import type { Collection, Mode, Vec3 } from './api';
import { length } from './panel/dom';
import type { Way } from './rig';

export interface Place {
  scene?: string;
  eye?: Vec3;
  /** Heading and pitch, degrees. */
  look?: [number, number];
  way?: Way;
  mode?: Mode;
}

/** A place, and what of the address could not be used, each as a sentence. */
export interface Said {
  place: Place;
  faults: string[];
}

const WAYS = ['orbit', 'fly', 'walk'] as const;
const MODES = ['range', 'error', 'budget'] as const;

function numbers(text: string, count: number): number[] | undefined {
  const parts = text.split(',').map((part) => (part.trim() === '' ? NaN : Number(part)));
  return parts.length === count && parts.every(Number.isFinite) ? parts : undefined;
}

/** What an address says. A pose that is not whole and right is left out as a whole. */
export function read(hash: string): Said {
  const said = new URLSearchParams(hash.replace(/^#/, ''));
  const place: Place = {};
  const faults: string[] = [];
  const part = <T>(name: string, read: (text: string) => T | undefined, needed: string): T | undefined => {
    const text = said.get(name);
    const value = text === null ? undefined : read(text);
    if (text !== null && value === undefined) faults.push(`${name}=${text} in the link is not ${needed}.`);
    return value;
  };
  const eye = part('eye', (text) => numbers(text, 3) as Vec3 | undefined, 'x,y,z in metres');
  const look = part('look', (text) => {
    const [heading, pitch] = numbers(text, 2) ?? [];
    return heading !== undefined && pitch !== undefined && Math.abs(pitch) <= 90 ? [heading, pitch] as [number, number] : undefined;
  }, 'heading,pitch in degrees, pitch from -90 to 90');
  const way = part('by', (text) => WAYS.find((way) => way === text), `one of ${WAYS.join(', ')}`);
  const mode = part('mode', (text) => MODES.find((mode) => mode === text), `one of ${MODES.join(', ')}`);
  const scene = said.get('scene');
  if (scene !== null) place.scene = scene;
  if (eye && look) Object.assign(place, { eye, look });
  else if (eye && !said.has('look')) faults.push('The link has an eye and no look=heading,pitch.');
  else if (look && !said.has('eye')) faults.push('The link has a look and no eye=x,y,z.');
  if (way) place.way = way;
  if (mode) place.mode = mode;
  return { place, faults };
}

/** An eye farther from a city than this many times its extent sees nothing of it; at least so many m. */
const FAR = 20;
const FAR_M = 20_000;

/**
 * What of an address there is here: a scene that is served, the first where it names none, and a
 * place from which it can be seen. A pose in another scene, or out of its sight, is left out.
 */
export function settle(said: Said, collections: readonly Collection[], first: Collection): Said & { collection: Collection } {
  const { eye: _, look: __, ...rest } = said.place;
  const { scene } = said.place;
  const named = scene === undefined ? first : collections.find(({ id }) => id === scene);
  if (!named) {
    const fault = `There is no scene “${scene}” here. This is ${first.title}.`;
    return { collection: first, place: rest, faults: [...said.faults, fault] };
  }
  const away = said.place.eye && named.bounds ? beyond(said.place.eye, named.bounds) : 0;
  if (away === 0) return { collection: named, ...said };
  const fault = `The eye of the link is ${length(away)} from the city.`;
  return { collection: named, place: rest, faults: [...said.faults, fault] };
}

/** How far an eye is from a city out of whose sight it is, m; 0 within it. */
function beyond(eye: Vec3, bounds: NonNullable<Collection['bounds']>): number {
  const [low, high] = [bounds.slice(0, 3), bounds.slice(3)];
  const extent = Math.max(...high.map((v, k) => v - low[k]!));
  const away = Math.hypot(...eye.map((v, k) => Math.max(low[k]! - v, 0, v - high[k]!)));
  return away > Math.max(FAR * extent, FAR_M) ? away : 0;
}

/** The address of a place: to the centimetre and the hundredth of a degree. */
export function write(place: Required<Place>): string {
  const eye = place.eye.map((v) => Number(v.toFixed(2))).join(',');
  const look = place.look.map((v) => Number(v.toFixed(2))).join(',');
  return `#scene=${encodeURIComponent(place.scene)}&eye=${eye}&look=${look}&by=${place.way}&mode=${place.mode}`;
}
