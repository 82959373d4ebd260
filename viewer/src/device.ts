/** What the browser and the machine do to the page while it is open. */

export interface DeviceEvents {
  /** The picture has another size, or its screen has other pixels. */
  resized(): void;
  /** The graphics card is gone for now, and is there again. */
  lost(): void;
  restored(): void;
  /** Whether the user wants little to move. */
  calm(on: boolean): void;
}

export function watch(canvas: HTMLCanvasElement, events: DeviceEvents): void {
  const size = new ResizeObserver(() => events.resized());
  try {
    // Tells of other pixels in the same place too.
    size.observe(canvas, { box: 'device-pixel-content-box' });
  } catch {
    size.observe(canvas);
  }
  canvas.addEventListener('webglcontextlost', () => events.lost());
  canvas.addEventListener('webglcontextrestored', () => events.restored());
  const calm = matchMedia('(prefers-reduced-motion: reduce)');
  calm.addEventListener('change', () => events.calm(calm.matches));
  events.calm(calm.matches);
}
