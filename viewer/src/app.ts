/** The page at work: a frame after the other, from the hand to the picture. */

import { type Answer, type Ask, type Camera, type Collection, type Problem, told } from './api';
import { City } from './city';
import { Frames } from './frames';
import { Ground } from './ground';
import { watch } from './device';
import * as hash from './hash';
import { effects, type Knobs, KNOBS, lod } from './knobs';
import { extent, home } from './overview';
import { Rig, type Way } from './rig';
import { Input } from './rig/input';
import { type Pose, Stage } from './stage';
import type { Sample } from './stage/timing';
import type { Surroundings } from './surroundings';
import { tour } from './tour';
import { about } from './why';

/** Frames are drawn for so long after the last thing that happened, ms. */
const AWAKE = 1500;

/** Figures are written so often, ms. */
const FIGURES = 160;

export class App {
  knobs: Knobs = KNOBS;
  city: City | undefined;
  ground: Ground | undefined;
  /** Steers instead of the user: the pose after so many seconds, or frames in a test. */
  pilot: ((seconds: number, frame: number) => Pose) | undefined;
  /** Called with each frame; the next waits for what it promises. */
  onframe: ((frame: number) => Promise<void> | void) | undefined;
  readonly rig = new Rig({ level: 0, extent: 1000, blocked: () => false });
  readonly stage: Stage;
  readonly input: Input;
  sample: Sample | undefined;
  /** What was asked last. */
  asked: Ask | undefined;
  private frozen: { pose: Pose; tint: Knobs['tint'] } | undefined;
  private readonly untold = new Frames();
  private running = false;
  private awake = 0;
  private last = 0;
  private started = 0;
  private frames = 0;
  private written = { figures: 0, hash: 0, text: '' };
  private due = true;
  /** Whether boxes were drawn yet. */
  private pictured = false;

  constructor(private readonly around: Surroundings) {
    this.stage = new Stage(around.canvas, (sample) => {
      this.sample = sample;
      this.untold.push(sample);
      around.panel.frame.push(sample.frame_ms);
    });
    this.input = new Input(around.canvas, this.rig, this.stage, {
      click: (x, y) => void this.click(x, y),
      stir: () => {
        if (this.pilot && !this.onframe) this.tour(false);
        this.stir();
      },
    });
    watch(around.canvas, {
      resized: () => this.resize(),
      lost: () => {
        this.stage.timing.forget();
        around.toast('The graphics card went away. The picture comes back when the card does.');
      },
      restored: () => this.stir(true),
      calm: (on) => (this.rig.calm = on),
    });
    this.resize();
    this.night();
  }

  /** Shows a scene, from a place or from its own best side. */
  open(collection: Collection, place: hash.Place): void {
    this.city?.close();
    this.ground?.close();
    this.thaw();
    this.unpick();
    this.tour(false);
    const city = new City(collection, {
      changed: (answer, change) => {
        this.stage.timing.ahead(change);
        this.changed(answer);
      },
      arrived: () => {
        this.rig.stepOut();
        this.stir();
      },
      ground: (level, even) => this.settle(level, even),
      problem: (problem) => this.problem(problem),
      way: () => this.stir(true),
      stale: () => this.around.reload(),
    });
    this.city = city;
    this.untold.forget();
    this.stage.lay(undefined);
    this.ground = Ground.of(collection, {
      drawn: (mesh) => {
        if (!this.laid) return;
        this.stage.lay(mesh, (eye, way) => this.ground?.meet(eye, way, Math.max(4 * this.extent, 5000)));
        this.stir();
      },
      problem: (problem) => this.problem(problem),
    });
    this.stage.show(city.instances, collection.classes, city.bounds);
    this.settle(city.bounds.min[2], false);
    this.around.panel.show(collection, city.levels);
    // Where the processor draws, shadows on the ground take longer than all else: they are for who asks.
    const shadows = !(this.stage.slow && collection.ground);
    this.knobs = { ...this.knobs, shadows, ...(place.mode ? { mode: place.mode } : {}) };
    this.rig.choose(place.way ?? 'orbit');
    this.buttons();
    const { eye, look } = place;
    this.rig.jump(eye && look ? { eye: city.relative(eye), heading: look[0], pitch: look[1] } : this.first);
    this.around.opened(collection);
    this.set({});
  }

  set(change: Partial<Knobs>): void {
    this.knobs = { ...this.knobs, ...change };
    this.untold.forget();
    this.stage.tint(this.knobs.tint);
    this.around.panel.set(this.knobs, false);
    if (!this.laid) {
      this.stage.lay(undefined);
      this.ground?.forget();
    }
    this.air();
    this.stir(true);
  }

  way(way: Way): void {
    const before = this.rig.way;
    const middle = this.stage.meet(0, 0);
    if (way === 'walk' && before !== way && middle) {
      // Where one looks, not where one hovers; not beyond the city.
      const { eye } = this.rig.pose;
      const { min, max } = this.city?.bounds ?? { min: eye, max: eye };
      const on = (k: 0 | 1) => Math.min(Math.max(eye[k] + middle.way[k] * middle.along, min[k]), max[k]);
      this.rig.setDown(on(0), on(1));
    } else this.rig.choose(way);
    this.stir();
    this.buttons();
  }

  /** Back to where the city was seen first. */
  reset(): void {
    this.tour(false);
    if (this.rig.way === 'walk') this.rig.choose('orbit');
    this.rig.go(this.first);
    this.buttons();
    this.stir();
  }

  tour(on = !this.pilot): void {
    const was = this.pilot !== undefined;
    this.pilot = on && this.city ? tour(this.city.sights, this.rig.pose) : undefined;
    this.started = performance.now();
    if (on && this.rig.way === 'walk') this.rig.choose('fly');
    if (was !== on) this.buttons();
    this.stir();
  }

  /** Holds the selection while the eye steps outside; again, goes on. */
  freeze(): void {
    if (this.frozen) this.thaw();
    else if (this.city?.answer) {
      const { answer, levels } = this.city;
      const { pose } = this.rig;
      this.frozen = { pose: { ...pose, eye: [...pose.eye] }, tint: this.knobs.tint };
      this.stage.place(pose);
      const ends = levels.ends(answer.lod, this.knobs.beyond).filter(Number.isFinite);
      this.stage.freeze(Math.min(Math.max(...ends, 600) * 1.1, Math.max(this.extent * 1.2, 200)));
      this.stage.rings(pose.eye, ends);
      this.set({ tint: 'level' });
      if (this.rig.way === 'walk') this.rig.choose('fly');
      this.around.toast('Frozen. Move freely: the selection stays that of the frame you left. F goes on.');
    }
    this.buttons();
    this.stir(true);
  }

  night(): void {
    this.stage.night(this.around.night());
    this.stir();
  }

  unpick(): void {
    this.stage.pick(undefined);
    this.around.picked.hide();
    this.stir();
  }

  /** Draws for a while; `due` also asks again. */
  stir(due = false): void {
    this.due ||= due;
    this.awake = performance.now() + AWAKE;
    if (this.running) return;
    this.running = true;
    this.last = performance.now();
    requestAnimationFrame((now) => this.frame(now));
  }

  private frame(now: number): void {
    const seconds = Math.min(Math.max((now - this.last) / 1000, 0), 0.1);
    this.last = now;
    this.frames += 1;
    this.stage.timing.begin();
    this.steer(seconds, now);
    if (this.laid) this.stage.level(this.level);
    this.stage.place(this.rig.pose);
    this.ask();
    this.stage.draw(this.far);
    if (!this.pictured && this.city && this.city.instances.count > 0) {
      this.pictured = true;
      performance.mark('citylod: first picture');
    }
    this.figures(now);
    const again = () => {
      if (this.rig.moving || this.pilot || performance.now() < this.awake) requestAnimationFrame((then) => this.frame(then));
      else this.running = false;
    };
    const hold = this.onframe?.(this.frames);
    if (hold) void hold.then(again);
    else again();
  }

  private steer(seconds: number, now: number): void {
    if (!this.pilot) {
      this.rig.step(seconds);
      return;
    }
    const before = this.rig.pose.eye;
    this.rig.jump(this.pilot((now - this.started) / 1000, this.frames));
    const { eye } = this.rig.pose;
    if (seconds > 0) this.rig.speed = Math.hypot(...eye.map((v, k) => v - before[k]!)) / seconds;
  }

  private ask(): void {
    const { city, knobs } = this;
    if (!city || this.frozen || !city.ready) return;
    const controlled = knobs.controller && knobs.mode === 'range';
    const { turn: quaternion, fov: fov_y_deg, viewport } = this.stage;
    const camera: Camera = { eye: city.absolute(this.rig.pose.eye), quaternion, fov_y_deg, viewport };
    const ask: Ask = { camera, lod: lod(knobs), effects: effects(knobs, city.collection.effects, this.rig.speed) };
    const same = JSON.stringify(ask) === JSON.stringify({ ...this.asked, feedback: undefined });
    if (same && !this.due && !(controlled && this.untold.any)) return;
    if (controlled) ask.feedback = { target_ms: knobs.target_ms, ...this.untold.take() };
    this.due = false;
    this.asked = ask;
    city.ask(ask);
    if (this.laid) this.ground?.ask(ask);
  }

  /** What the present picture was drawn with, m; none outside range mode or where all is drawn. */
  private get far(): number | undefined {
    const answer = this.city?.answer;
    return answer?.feedback?.far_dist_m ?? answer?.lod.far_dist_m ?? undefined;
  }

  private changed(answer: Answer): void {
    const steered = answer.feedback?.far_dist_m;
    const moved = steered != null && Math.abs(steered / this.knobs.far_dist_m - 1) > 0.005;
    if (steered != null && this.knobs.controller) this.knobs = { ...this.knobs, far_dist_m: steered };
    if (answer.add.length + answer.remove.length > 0 || moved) this.stir();
  }

  private figures(now: number): void {
    const { city, around: { panel } } = this;
    if (city?.answer) panel.push(city.answer, this.far);
    if (city && now - this.written.figures > FIGURES) {
      this.written.figures = now;
      panel.write(city, this.knobs, this.laid ? this.ground?.figures : undefined);
    }
    if (now - this.written.hash > 400 && this.city && !this.pilot) {
      this.written.hash = now;
      const text = this.address();
      if (text !== this.written.text) history.replaceState(null, '', text);
      this.written.text = text;
    }
  }

  /** The address of where the eye is. */
  address(): string {
    const { pose, way } = this.rig;
    const city = this.city;
    return hash.write({
      scene: city?.collection.id ?? '',
      eye: city?.absolute(pose.eye) ?? pose.eye,
      look: [pose.heading, pose.pitch],
      way,
      mode: this.knobs.mode,
    });
  }

  private async click(x: number, y: number): Promise<void> {
    const hit = this.stage.meet(x, y);
    const city = this.city;
    if (!city || hit?.object === undefined) return this.unpick();
    this.stage.pick(hit.object);
    this.stir();
    try {
      const from = this.frozen?.pose ?? this.rig.pose;
      const { item, why, link } = await about(hit.object, city, from.eye, this.stage, this.knobs, this.frozen !== undefined);
      this.around.picked.show(item, why, link);
    } catch (error) {
      this.unpick();
      this.problem({ detail: error instanceof Error ? error.message : String(error) });
    }
  }

  private thaw(): void {
    if (!this.frozen) return;
    const { pose, tint } = this.frozen;
    this.frozen = undefined;
    this.stage.thaw();
    this.stage.rings([0, 0, 0], []);
    this.rig.go(pose);
    this.set({ tint });
    this.buttons();
  }

  private problem(problem: Problem): void {
    this.around.toast(told(problem));
  }

  /** From where the city is seen first. */
  private get first(): Pose {
    return this.city ? home(this.city.sights, this.stage.opening) : this.rig.pose;
  }

  private get extent(): number {
    return this.city ? extent(this.city.bounds) : 1000;
  }

  /** Whether the scene has ground and it is drawn. */
  private get laid(): boolean {
    return this.ground !== undefined && !this.knobs.without.has('terrain');
  }

  /** Height of the ground under the eye, m. */
  private get level(): number {
    const [x, y] = this.rig.pose.eye;
    return this.laid ? this.ground!.height(x, y) : this.plane;
  }

  /** Height of the plane that is drawn in want of ground, m. */
  private plane = 0;

  private settle(level: number, even: boolean): void {
    this.even = even;
    this.plane = level;
    this.stage.level(level);
    const blocked = (x: number, y: number, z: number) => this.city?.instances.blocked(x, y, z, 0.5) ?? false;
    const { pose } = this.rig;
    const under = () => this.level;
    this.rig.over({ get level() { return under(); }, extent: this.extent, blocked });
    this.rig.jump(pose);
    this.air();
    this.stir();
  }

  private even = false;

  private air(): void {
    const haze = this.city?.collection.effects.haze;
    if (haze && !this.knobs.without.has('haze')) this.stage.haze(haze.visibility_m);
    else this.stage.clear(this.extent);
    this.stage.cast(this.knobs.shadows, this.knobs.shadows && this.even);
  }

  private buttons(): void {
    this.around.buttons({ way: this.rig.way, frozen: this.frozen !== undefined, touring: this.pilot !== undefined });
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.around.canvas;
    if (clientWidth > 0 && clientHeight > 0) {
      const { first, rig } = this;
      this.stage.resize(clientWidth, clientHeight, Math.min(devicePixelRatio || 1, 2));
      // Who has not moved yet sees the city in the new shape too.
      if (JSON.stringify(rig.pose) === JSON.stringify(first)) rig.jump(this.first);
      this.stir(true);
    }
  }
}
