import type { Source } from './figures.js';

export { CageformError, Clip, Figure, open, version } from './figures.js';
export type { Array32or64, CloneOptions, Cloned, Numbers, Scalar, Source, Status } from './figures.js';

/** Starts the library; without an argument it finds runtime.wasm beside this file. Await it before the first call. */
export function init(source?: Source | Promise<Source>): Promise<void>;
