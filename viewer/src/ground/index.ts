/**
 * The ground of a scene: asks for the patches of a view, fetches the tiles that they lie in, and
 * hands on the triangles once it is whole. One question at a time, the newest view next.
 */

import { type AnswerHead, type Ask, at, type Collection, passes, post, Refused, type Problem, type Vec3 } from '../api';
import { type GroundMesh, mesh, type Patch } from './mesh';
import { Tiles } from './tiles';

/** Time between questions, ms: the ground changes little from frame to frame. */
const PAUSE = 90;

/** Time after which what failed is asked for again, ms. */
const AGAIN = 1000;

/** What is drawn, as the service counts it. */
export interface Figures {
  patches: number;
  triangles: number;
  error_px: number | null;
}

export interface GroundEvents {
  drawn(mesh: GroundMesh): void;
  problem(problem: Problem): void;
}

type Answered = AnswerHead & { effects: { terrain?: Figures & { list?: Patch[] } } };

export class Ground {
  readonly tiles: Tiles;
  figures: Figures | undefined;
  /** What the triangles drawn now answer. */
  answered: Ask | undefined;
  private wanted: Ask | undefined;
  private busy = false;
  private last = '';
  private readonly abort = new AbortController();

  private constructor(
    private readonly collection: Collection,
    ground: NonNullable<Collection['ground']>,
    private readonly events: GroundEvents,
  ) {
    this.tiles = new Tiles(collection.id, collection.revision, ground, collection.origin);
  }

  /** The ground of a scene, where it has any. */
  static of(collection: Collection, events: GroundEvents): Ground | undefined {
    return collection.ground ? new Ground(collection, collection.ground, events) : undefined;
  }

  /** Whether what is drawn is that of the view asked for last. */
  get settled(): boolean {
    return !this.busy && this.wanted === undefined;
  }

  /** Wants the ground for a view, none of the objects. */
  ask(view: Ask): void {
    const effects = { ...view.effects, terrain: { patches: true } };
    if ('occlusion' in this.collection.effects) Object.assign(effects, { occlusion: false });
    const ask: Ask = { camera: view.camera, lod: { mode: 'budget', max_objects: 0 }, effects };
    const text = JSON.stringify(ask);
    if (text === this.last) return;
    this.last = text;
    this.wanted = ask;
    void this.next();
  }

  /** Asks anew when it is wanted again. */
  forget(): void {
    this.last = '';
    this.wanted = undefined;
    this.answered = undefined;
    this.figures = undefined;
  }

  /** Height of the ground at a place, m; the lowest known where none is. */
  height(x: number, y: number): number {
    const { ground } = this.tiles;
    return this.tiles.at(x, y) ?? this.tiles.height(ground.heights?.[0] ?? 0);
  }

  /** How far from an eye a way meets the ground; not at all beyond so many metres. */
  meet([x, y, z]: Vec3, [dx, dy, dz]: Vec3, far: number): number | undefined {
    const above = (along: number) => z + dz * along - (this.tiles.at(x + dx * along, y + dy * along) ?? -Infinity);
    let before = 0;
    for (let along = 1; along < far; along += Math.max(above(along) * 0.3, 0.02 * along, 0.5)) {
      if (above(along) <= 0) {
        for (let k = 0; k < 16; k += 1) {
          const middle = (before + along) / 2;
          if (above(middle) <= 0) along = middle;
          else before = middle;
        }
        return along;
      }
      before = along;
    }
    return undefined;
  }

  close(): void {
    this.abort.abort();
    this.tiles.close();
  }

  private async next(): Promise<void> {
    if (this.busy || !this.wanted) return;
    this.busy = true;
    const ask = this.wanted;
    this.wanted = undefined;
    let pause = PAUSE;
    try {
      const answer = await post<Answered>(at(this.collection.id, '/visible'), { ...ask, output: { form: 'ranges' } }, this.abort.signal);
      const { list, ...figures } = answer.effects.terrain ?? { patches: 0, triangles: 0, error_px: 0 };
      // Of another revision the page will hear by other ways.
      if (list && answer.revision === this.collection.revision) {
        const heights = await Promise.all(list.map(async (patch) => [patch, await this.tiles.heights([patch[0], patch[1], patch[2]])] as const));
        if (!this.abort.signal.aborted && this.last !== '') {
          this.figures = figures;
          this.answered = ask;
          this.events.drawn(mesh(this.tiles, heights));
        }
      }
    } catch (error) {
      if (this.abort.signal.aborted) return;
      const status = error instanceof Refused ? error.problem.status : undefined;
      // A service that is gone or begins anew is reported by the objects.
      if (error instanceof Refused && status && status !== 409) this.events.problem(error.problem);
      // While nothing moves too.
      if (passes(error) && this.last !== '') {
        this.wanted ??= ask;
        pause = AGAIN;
      }
    }
    setTimeout(() => {
      this.busy = false;
      void this.next();
    }, pause);
  }
}
