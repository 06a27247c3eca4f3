// The functions of every frame: packed figures and clips.

import { start } from './engine.js';
import { open } from './figures.js';
import { VERSION } from './layout.js';

export { CageformError } from './engine.js';
export { Clip, Figure } from './figures.js';
export { open };
export const version = VERSION;

/** Starts the library. */
export const init = source => start(source, new URL('./runtime.wasm', import.meta.url), false);
