import type { Source } from './figures.js';

export { CageformError, Clip, Figure, open, version } from './figures.js';
export type { Array32or64, CloneOptions, Cloned, Numbers, Scalar, Source, Status } from './figures.js';

/** Starts the library; the default source is runtime.wasm next to this file. Await it before the first call. */
export function init(source?: Source | Promise<Source>): Promise<void>;
