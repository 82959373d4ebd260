/** The page about the picture: what it shows, and what it is told. */

import type { Collection } from './api';
import type { Panel } from './panel';
import type { Picked } from './panel/picked';
import type { Way } from './rig';

export interface Surroundings {
  canvas: HTMLCanvasElement;
  panel: Panel;
  picked: Picked;
  /** Tells the user something for a while. */
  toast(text: string): void;
  /** The state that buttons show. */
  buttons(state: { way: Way; frozen: boolean; touring: boolean }): void;
  /** Another city is shown. */
  opened(collection: Collection): void;
  /** The service has another city now under the name of this one. */
  reload(): void;
  night(): boolean;
}
