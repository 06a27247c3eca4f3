// Types of the functions of every frame.

import type { LibraryStatus, ReportNumbers } from './layout.js';

/** Numbers in one row, or an array for each point. float32 and float64 arrays are read as they are. */
export type Numbers =
  Float32Array | Float64Array | readonly number[] | readonly (readonly number[] | Float32Array | Float64Array)[];
export type Indices =
  Uint32Array | Uint16Array | Int32Array | readonly number[] | readonly (readonly number[] | Uint32Array)[];
export type Array32or64 = Float32Array | Float64Array;
export type Scalar = 'float32' | 'float64';

/** The name of a status; or 'argument_refused', of an argument that is no such thing as its type says. */
export type Status = LibraryStatus | 'argument_refused';

/** A status that is not ok. `message` is a sentence. */
export class CageformError extends Error {
  readonly name: 'CageformError';
  readonly status: Status;
  /** The index that the status names: of a point, handle, pin, face, clip; or the tag of the part of a file. */
  readonly culprit: number | string | null;
  readonly report: Report | null;
}

export interface Element {
  readonly kind: 'vertex' | 'edge' | 'face' | 'loop';
  readonly index: number;
}

/** A fault of a cage, or a warning; it prints itself. */
export class Fault {
  private constructor();
  readonly text: string;
  readonly isWarning: boolean;
  readonly a: Element | null;
  readonly b: Element | null;
  toString(): string;
}

/** How a call went; toString() says what the call knows. */
export interface Report extends ReportNumbers {
  readonly status: LibraryStatus | 'ok';
  readonly message: string;
  readonly culprit: number | null;
  /** The first fault of the cage, or the first warning. */
  readonly fault: Fault | null;
  /** Pins: the pose has come to rest. */
  readonly settled: boolean;
  toString(): string;
}

export interface CloneOptions {
  /** Normals, in an array that is written, or in a new one. */
  normals?: Array32or64 | boolean;
  /** Tangents in space, of four numbers: the fourth is the handedness. */
  tangents?: Array32or64 | boolean;
}
export interface Cloned {
  readonly points: Array32or64;
  readonly normals: Array32or64 | undefined;
  readonly tangents: Array32or64 | undefined;
}

declare class Owner {
  protected constructor();
  /** Frees the memory now; else the garbage collection does. Objects made of this one stay usable. */
  free(): void;
}

/** A figure that is cloned with poses of its handles: of a binding, or by open(). */
export class Figure extends Owner {
  private constructor();
  readonly points: number;
  readonly handles: number;
  /** Handles that are points: what clips and poseHandles() take. */
  readonly vertices: number;
  readonly dimension: 2 | 3;
  readonly scalar: Scalar;
  readonly clips: number;
  readonly levels: number;
  readonly hasNormals: boolean;
  readonly hasTangents: boolean;
  readonly hasLabels: boolean;
  /** The place from which points, handles and clips count: dimension numbers. Add it to clones, in double precision. */
  readonly origin: readonly number[];

  /** The handles at rest: a pose to start from. */
  rest(out?: Array32or64): Array32or64;
  /** The labels of the handles; '' for those without. */
  labels(): string[];
  /** Opens a level of less detail, which takes the same poses. */
  level(level: number): Figure;
  /** Moves the figure with a pose of all handles. At rest the points come back to the bit. `out` is written instead of a new
   *  array; it has the figure's scalar. */
  clone(pose: Numbers, options?: CloneOptions & { out?: Array32or64 }): Cloned;
  /** As clone(), without a copy: views of the library's memory. The next clone of this figure overwrites them. They end when
   *  the memory grows or the figure is freed: after a call that makes an object or opens a file, ask anew. A view that has
   *  ended by growth has length 0. */
  cloneView(pose: Numbers, options?: { normals?: boolean; tangents?: boolean }): Cloned;
  /** The transpose of clone: gradients of a function of the points to those of the handles. */
  gradients(ofPoints: Numbers, out?: Array32or64): Array32or64;
  /** A pose of all handles from one of the cage's vertices; Green coordinates need it. */
  poseHandles(vertices: Numbers, out?: Array32or64): Array32or64;
  /** Plays a clip, by number or name. */
  clip(clip: number | string): Clip;
}

/** The motion of a cage. */
export class Clip extends Owner {
  private constructor();
  readonly begin: number;
  readonly end: number;
  readonly vertices: number;
  readonly dimension: 2 | 3;
  readonly scalar: Scalar;
  readonly name: string | null;
  /** The bytes that pack() takes, if compileClip() made the clip. */
  readonly bytes: Uint8Array | null;
  /** The cage's vertices at a time. */
  sample(time: number, out?: Array32or64): Array32or64;
}

/** Opens a packed figure, whose bytes are copied. */
export function open(bytes: ArrayBuffer | ArrayBufferView, options?: { skipChecksum?: boolean }): Figure;

/** The sources that init() takes: bytes, a compiled module, a response or its promise, or an address. */
export type Source = ArrayBuffer | ArrayBufferView | WebAssembly.Module | Response | URL | string;

/** The version of the library. */
export const version: string;
