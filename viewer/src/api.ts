/** What the service says and is asked, as `/api` describes it. */

import type { Range } from './ranges';

export type Vec3 = [number, number, number];

/** A scene. */
export interface Collection {
  id: string;
  title: string;
  crs: string | null;
  bounds: [number, number, number, number, number, number] | null;
  origin: Vec3;
  objects: number;
  levels: { level: number; nodes: number; objects: number }[];
  classes: string[];
  promotion: string;
  effects: DeclaredEffects;
  ground: DeclaredGround | null;
  /** From where it is seen well; a service may not tell. */
  overview?: Overview | null;
  revision: string;
}

/** A camera, the far distance that goes with it, and a box about what it shows. */
export interface Overview {
  eye: Vec3;
  target: Vec3;
  far_dist_m: number;
  bounds: [number, number, number, number, number, number];
}

/** How the posts of the ground lie. */
export interface DeclaredGround {
  posts: [number, number];
  origin: [number, number];
  spacing: [number, number];
  heights: [number, number] | null;
  block_levels: number;
  tile_levels: number;
  finest: number;
  blocks: [number, number];
}

export interface DeclaredEffects {
  motion?: { reference_speed_mps: number };
  haze?: { visibility_m: number };
  occlusion?: { width_px: number; min_pixels: number };
  terrain?: { criterion: string; max_error_px: number; max_triangles: number };
  [name: string]: unknown;
}

export interface Camera {
  eye: Vec3;
  quaternion: [number, number, number, number];
  fov_y_deg: number;
  viewport: [number, number];
}

export type Mode = 'range' | 'error' | 'budget';

export type Lod =
  | { mode: 'range'; far_dist_m: number | null; dist_factor: number; levels: number; beyond: 'show' | 'hide' }
  | { mode: 'error'; max_error_px: number }
  | { mode: 'budget'; max_objects: number };

/** Switches, or how fast the camera moves. */
export type Effects = Record<string, boolean | { speed_mps: number } | { patches: boolean }>;

/** The last frame and what it was drawn with; without a frame only what is wished for. */
export interface Feedback {
  target_ms: number;
  frame_ms?: number;
  far_dist_m?: number;
}

/** What is asked each frame. */
export interface Ask {
  camera: Camera;
  lod: Lod;
  effects: Effects;
  feedback?: Feedback;
}

export interface AnsweredLod {
  mode: Mode;
  far_dist_m?: number | null;
  dist_factor?: number;
  levels?: number;
  max_error_px?: number;
  max_objects?: number;
  error_px: number | null;
}

export interface Stats {
  nodes_visited: number;
  objects_tested: number;
  retrieve_us: number;
}

/** What the effects that ran did. */
export type RanEffects = Record<string, Record<string, number>>;

/** What both the stream and `POST visible` answer, beside the objects. */
export interface AnswerHead {
  revision: string;
  count: number;
  lod: AnsweredLod;
  effects: RanEffects;
  feedback?: { far_dist_m: number | null; state?: unknown };
  stats: Stats;
}

/** An answer with what it changes: `add` and `remove` are against the answer before. */
export interface Answer extends AnswerHead {
  /** What was asked. */
  ask: Ask;
  ranges: Range[];
  add: Range[];
  remove: Range[];
}

export interface Item {
  id: string;
  index: number;
  class: string;
  level: number;
  bounds: [number, number, number, number, number, number];
  height_m: number;
  footprint_area_m2: number;
  triangles: number;
  attributes: Record<string, unknown> | null;
}

/** Ids and classes of neighbouring objects, column by column. */
export interface Items {
  start: number;
  ids: string[];
  /** Numbers into the scene's `classes`. */
  classes: number[];
}

/** A refusal (RFC 9457). */
export interface Problem {
  type?: string;
  title?: string;
  status?: number;
  detail?: string;
  pointer?: string;
}

/** A refusal in words. */
export function told({ title, detail, pointer }: Problem): string {
  return `${detail ?? title ?? 'The service refused.'}${pointer ? ` (${pointer})` : ''}`;
}

/** A refusal by the service, or no answer at all (`status` 0). */
export class Refused extends Error {
  constructor(readonly problem: Problem) {
    super(problem.detail ?? problem.title ?? 'the service gave no reason');
  }
}

/** Whether what failed may go well another time: what is wrong with a question stays so. */
export function passes(error: unknown): boolean {
  const status = error instanceof Refused ? error.problem.status ?? 0 : 0;
  return status < 400 || status >= 500 || [408, 409, 429].includes(status);
}

/** The address of a scene, or of something in it. */
export function at(scene: string, rest = ''): string {
  return `/collections/${encodeURIComponent(scene)}${rest}`;
}

async function reply(path: string, init?: RequestInit): Promise<Response> {
  let response;
  try {
    response = await fetch(path, init);
  } catch (error) {
    if (init?.signal?.aborted) throw error;
    throw new Refused({ status: 0, detail: 'The service does not answer.' });
  }
  if (response.ok) return response;
  const problem = await response.json().catch(() => ({ title: response.statusText }));
  throw new Refused({ status: response.status, ...problem });
}

export async function json<T>(path: string, init?: RequestInit): Promise<T> {
  const headers = { accept: 'application/json', ...init?.headers };
  return (await (await reply(path, { ...init, headers })).json()) as T;
}

export async function bytes(path: string, init?: RequestInit): Promise<ArrayBuffer> {
  return (await reply(path, init)).arrayBuffer();
}

export async function post<T>(path: string, body: unknown, signal?: AbortSignal): Promise<T> {
  const init: RequestInit = {
    method: 'POST',
    headers: { 'content-type': 'application/json' },
    body: JSON.stringify(body),
  };
  if (signal) init.signal = signal;
  return json<T>(path, init);
}
