// All functions: those of every frame, and those of bind time.

import { start } from './engine.js';
import { VERSION } from './layout.js';

export { Binding, Coordinates } from './bindings.js';
export { Cage, check, makeCage } from './cages.js';
export { CageformError, Fault, Report } from './engine.js';
export { Clip, Figure, open } from './figures.js';
export { Pins, Samples, compileClip, openSamples } from './pins.js';
export { Wrap, wrap } from './wraps.js';
export const version = VERSION;

/** Starts the library. */
export const init = source => start(source, new URL('./cageform.wasm', import.meta.url), true);
