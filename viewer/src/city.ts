/** One scene on the page: its boxes, what is drawn of it, and the way to the service. */

import { type Answer, type Ask, type Collection, type Problem, Refused, type Vec3 } from './api';
import { type Chunk, Chunks } from './chunks';
import { covers, isCover } from './cover';
import { Levels } from './knobs';
import { Link, type Way } from './link';
import type { Bounds } from './overview';
import { Instances } from './stage/instances';

export interface CityEvents {
  /** What is drawn changes by this. */
  changed(answer: Answer, change: () => void): void;
  /** Boxes came. */
  arrived(): void;
  /** Where the ground is, as far as the boxes tell. */
  ground(level: number, even: boolean): void;
  problem(problem: Problem): void;
  way(way: Way): void;
  /** The service has another revision now: this city is over. */
  stale(): void;
}

/** Ground that rises less than this among nine of ten boxes counts as even, m. */
const EVEN = 3;

/** The plane lies so far under what covers it, m. */
const UNDER = 1;

export class City {
  readonly levels: Levels;
  readonly chunks: Chunks;
  readonly instances: Instances;
  answer: Answer | undefined;
  way: Way = 'none';
  private readonly link: Link;

  constructor(
    readonly collection: Collection,
    private readonly events: CityEvents,
  ) {
    const { id, revision, objects, classes } = collection;
    this.levels = new Levels(collection);
    this.chunks = new Chunks(id, revision, objects, classes.length, (chunk) => this.arrive(chunk), (error) => {
      // A service that is gone, or has another city now, is reported by the link.
      const status = error instanceof Refused ? error.problem.status : undefined;
      if (status === 0 || status === 409) return;
      events.problem({ detail: `Boxes could not be fetched: ${error instanceof Error ? error.message : String(error)}` });
    });
    this.instances = new Instances(this.chunks, (object) => this.levels.of(object), covers(classes));
    this.link = new Link(id, {
      answer: (answer) => this.take(answer),
      problem: (problem) => events.problem(problem),
      revision: (revision) => this.is(revision),
      way: (way) => {
        this.way = way;
        events.way(way);
      },
    });
    if (objects > 0) this.chunks.fetch(this.chunks.of(0));
  }

  get ready(): boolean {
    return this.link.ready;
  }

  ask(ask: Ask): void {
    this.link.ask(ask);
  }

  /** Scene coordinates of a place given relative to the origin. */
  absolute(place: Vec3): Vec3 {
    return place.map((v, k) => v + this.collection.origin[k]!) as Vec3;
  }

  /** The other way round. */
  relative(place: Vec3): Vec3 {
    return place.map((v, k) => v - this.collection.origin[k]!) as Vec3;
  }

  /** Corners relative to the origin; a square kilometre where there is nothing. */
  get bounds(): Bounds {
    const bounds = this.collection.bounds;
    if (!bounds) return { min: [-500, -500, 0], max: [500, 500, 0] };
    return {
      min: this.relative([bounds[0], bounds[1], bounds[2]]),
      max: this.relative([bounds[3], bounds[4], bounds[5]]),
    };
  }

  /** The same about what is seen first. */
  get sights(): Bounds {
    const bounds = this.collection.overview?.bounds;
    if (!bounds) return this.bounds;
    return {
      min: this.relative([bounds[0], bounds[1], bounds[2]]),
      max: this.relative([bounds[3], bounds[4], bounds[5]]),
    };
  }

  close(): void {
    this.link.close();
    this.chunks.close();
  }

  /** Whether the service still has this city. */
  private is(revision: string): boolean {
    if (revision === this.collection.revision) return true;
    this.close();
    this.events.stale();
    return false;
  }

  private take(answer: Answer): void {
    if (!this.is(answer.revision)) return;
    this.answer = answer;
    this.events.changed(answer, () => this.instances.change(answer.add, answer.remove));
  }

  private arrive(chunk: Chunk): void {
    this.instances.fill(chunk);
    if (chunk.start === 0 && chunk.boxes) {
      const boxes = chunk.boxes;
      const floors = Array.from({ length: chunk.length }, (_, k) => boxes[k * 6 + 2]!).sort((a, b) => a - b);
      const low = floors[Math.floor(floors.length * 0.05)] ?? 0;
      const high = floors[Math.floor(floors.length * 0.95)] ?? 0;
      const even = high - low < EVEN;
      // Sheets that cover the ground lie on the plane, not under it.
      const under = this.collection.classes.some(isCover) ? this.bounds.min[2] - UNDER : low;
      this.events.ground(even ? under : this.bounds.min[2], even);
    }
    this.events.arrived();
  }
}
