/**
 * How long a frame takes to make, not how long the display waits for it: a frame of 5 ms on a
 * display of 60 Hz is 5 ms, else a controller could not know how much more there is room for.
 * It begins with the page's work on the frame, and has in it what the page did for it before:
 * taking in the answer that it shows.
 *
 * Where the graphics card has a clock that pages may read, a frame takes as long as the longer of
 * the two, page or card, since they work at the same time. Elsewhere the page waits for the card
 * by reading one pixel back, and a frame takes as long as both.
 */

/** `EXT_disjoint_timer_query_webgl2`. */
interface TimerExtension {
  readonly TIME_ELAPSED_EXT: number;
  readonly GPU_DISJOINT_EXT: number;
}

/** A frame and what it was drawn with. */
export interface Sample {
  frame_ms: number;
  far_dist_m: number | undefined;
}

interface Running {
  query: WebGLQuery;
  page_ms: number;
  far_dist_m: number | undefined;
}

export class Timing {
  private readonly timer: TimerExtension | null;
  private readonly pixel = new Uint8Array(4);
  private readonly running: Running[] = [];
  private query: WebGLQuery | undefined;
  private started = 0;
  private before_ms = 0;

  constructor(
    private readonly gl: WebGL2RenderingContext,
    clock: boolean,
    private readonly measured: (sample: Sample) => void,
  ) {
    this.timer = !clock ? null : (gl.getExtension('EXT_disjoint_timer_query_webgl2') as TimerExtension | null);
  }

  /** The card was lost: what it was asked for will not come. */
  forget(): void {
    this.running.length = 0;
    this.query = undefined;
  }

  /** Does work that belongs to the next frame. */
  ahead(work: () => void): void {
    const from = performance.now();
    work();
    this.before_ms += performance.now() - from;
  }

  /** The page begins a frame. */
  begin(): void {
    this.collect();
    this.started = performance.now() - this.before_ms;
    this.before_ms = 0;
  }

  /** The card begins to draw it. */
  draw(): void {
    if (!this.timer) return;
    this.query = this.gl.createQuery() ?? undefined;
    if (this.query) this.gl.beginQuery(this.timer.TIME_ELAPSED_EXT, this.query);
  }

  end(far_dist_m: number | undefined): void {
    const { gl, timer, query } = this;
    // Nothing is drawn, in no time.
    if (gl.isContextLost()) return;
    if (timer && query) {
      gl.endQuery(timer.TIME_ELAPSED_EXT);
      this.running.push({ query, page_ms: performance.now() - this.started, far_dist_m });
      this.query = undefined;
      return;
    }
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, this.pixel);
    this.measured({ frame_ms: performance.now() - this.started, far_dist_m });
  }

  private collect(): void {
    const { gl, timer } = this;
    if (!timer) return;
    // The card's clock jumped: what it measured meanwhile means nothing.
    if (gl.isContextLost()) return;
    const disjoint = gl.getParameter(timer.GPU_DISJOINT_EXT) as boolean;
    while (this.running.length > 0) {
      const { query, page_ms, far_dist_m } = this.running[0]!;
      if (!disjoint && !gl.getQueryParameter(query, gl.QUERY_RESULT_AVAILABLE)) return;
      this.running.shift();
      if (!disjoint) {
        const card_ms = (gl.getQueryParameter(query, gl.QUERY_RESULT) as number) / 1e6;
        this.measured({ frame_ms: Math.max(page_ms, card_ms), far_dist_m });
      }
      gl.deleteQuery(query);
    }
  }
}

/** Whether the processor draws. Its clock as a graphics card leaves out what is drawn late. */
export function software(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(gl?.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
