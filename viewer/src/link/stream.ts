/** Asking by WebSocket: the service keeps what was sent and answers with changes. */

import { type Answer, type AnswerHead, type Ask, at, type Problem } from '../api';
import { type Told, whole } from './told';
import type { Range } from '../ranges';
import type { Asking, Ears } from './index';

/** A message of the service; an answer may leave out what is as in the one before. */
type Message =
  | { seq: number; revision?: string; problem: Problem }
  | (Told & { seq: number; problem?: undefined } & Pick<Answer, 'add' | 'remove'>);

/** So many questions may be under way; the service answers only the newest of those that wait. */
const MOST_UNDER_WAY = 3;

/** A connection that does not open within this time is taken for blocked, ms. */
const PATIENCE = 4000;

export class Stream implements Asking {
  private readonly socket: WebSocket | undefined;
  private readonly patience: number;
  private asked = new Map<number, Ask>();
  /** The question that was answered last: when a city is exchanged it is answered once more. */
  private last: Ask | undefined;
  private seq = 0;
  /** The answer before, but for its objects. */
  private before: AnswerHead | undefined;
  /** What the service was told last, as JSON; what has not changed is left out. */
  private told = { lod: '', effects: '' };

  constructor(
    scene: string,
    private readonly ears: Ears,
  ) {
    const url = new URL(at(scene, '/stream'), location.href);
    url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
    this.patience = window.setTimeout(() => this.fail(), PATIENCE);
    try {
      this.socket = new WebSocket(url);
    } catch {
      queueMicrotask(() => this.fail());
      return;
    }
    this.socket.onopen = () => {
      clearTimeout(this.patience);
      this.ears.opened();
    };
    this.socket.onclose = ({ wasClean }) => this.fail(wasClean);
    this.socket.onmessage = (event) => this.hear(JSON.parse(String(event.data)) as Message);
  }

  get ready(): boolean {
    return this.socket?.readyState === WebSocket.OPEN && this.asked.size < MOST_UNDER_WAY;
  }

  ask(ask: Ask): void {
    if (!this.ready) return;
    this.seq += 1;
    this.asked.set(this.seq, ask);
    const lod = JSON.stringify(ask.lod);
    const effects = JSON.stringify(ask.effects);
    this.socket?.send(
      JSON.stringify({
        seq: this.seq,
        camera: ask.camera,
        ...(lod === this.told.lod ? {} : { lod: ask.lod }),
        ...(effects === this.told.effects ? {} : { effects: ask.effects }),
        ...(this.seq === 1 ? { stats: true } : {}),
        ...(ask.feedback ? { feedback: ask.feedback } : {}),
      }),
    );
    this.told = { lod, effects };
  }

  close(): void {
    clearTimeout(this.patience);
    if (!this.socket) return;
    this.socket.onclose = null;
    this.socket.onmessage = null;
    this.socket.close();
  }

  private hear(message: Message): void {
    const ask = this.asked.get(message.seq) ?? this.last;
    // Questions before this one were overtaken and will not be answered.
    for (const seq of this.asked.keys()) if (seq <= message.seq) this.asked.delete(seq);
    if (message.problem) {
      // What was refused was not kept: say everything again.
      this.told = { lod: '', effects: '' };
      this.ears.refused(message.problem, message.revision);
      return;
    }
    if (!ask) return;
    this.last = ask;
    const { add, remove, seq: _, ...told } = message;
    this.before = whole(told, this.before);
    // A new connection starts from nothing, while the page still shows the answer before.
    const anew = told.revision !== undefined;
    this.ears.answered(ask, this.before, anew ? { all: add as Range[] } : { add, remove });
  }

  /** `told` where the service said that it closes: then its words come through. */
  private fail(told = false): void {
    this.close();
    this.ears.lost(this.before === undefined && !told);
  }
}
