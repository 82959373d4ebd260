/** Asking by `POST visible`, one question at a time: for networks that let no WebSocket through. */

import { type AnswerHead, type Ask, at, json, post, Refused } from '../api';
import type { Range } from '../ranges';
import type { Asking, Ears } from './index';

/** After so many questions the stream is tried again. */
const ENOUGH = 3600;

export class Poll implements Asking {
  private readonly abort = new AbortController();
  private reached = false;
  private busy = false;
  private asked = 0;
  /** The controller's state travels with the client. */
  private state: unknown = null;

  constructor(
    private readonly scene: string,
    private readonly ears: Ears,
  ) {
    void this.reach();
  }

  get ready(): boolean {
    return this.reached && !this.busy && !this.abort.signal.aborted;
  }

  ask(ask: Ask): void {
    if (this.ready) void this.send(ask);
  }

  close(): void {
    this.abort.abort();
  }

  /** Nothing may be asked for long: whether the service is there must show at once. */
  private async reach(): Promise<void> {
    try {
      await json(at(this.scene), { signal: this.abort.signal });
      this.reached = true;
      this.ears.opened();
    } catch {
      if (!this.abort.signal.aborted) this.ears.lost(false);
    }
  }

  private async send(ask: Ask): Promise<void> {
    this.busy = true;
    this.asked += 1;
    const { feedback, ...rest } = ask;
    const body = {
      ...rest,
      ...(feedback ? { feedback: { ...feedback, state: this.state } } : {}),
      output: { form: 'ranges' },
    };
    try {
      const { ranges, ...head } = await post<AnswerHead & { ranges: Range[] }>(
        at(this.scene, '/visible'),
        body,
        this.abort.signal,
      );
      this.state = head.feedback?.state ?? null;
      this.ears.answered(ask, head, { all: ranges });
      if (this.asked >= ENOUGH) this.ears.lost(false);
    } catch (error) {
      if (this.abort.signal.aborted) return;
      if (error instanceof Refused && error.problem.status) this.ears.refused(error.problem);
      else this.ears.lost(false);
    } finally {
      this.busy = false;
    }
  }
}
