// Types for the functions of every frame.

import type { LibraryStatus, ReportNumbers, WrapEnd } from './layout.js';

/** A flat array of numbers, or an array per point. Float32Array and Float64Array are read without conversion. */
export type Numbers =
  Float32Array | Float64Array | readonly number[] | readonly (readonly number[] | Float32Array | Float64Array)[];
export type Indices =
  Uint32Array | Uint16Array | Int32Array | readonly number[] | readonly (readonly number[] | Uint32Array)[];
export type Array32or64 = Float32Array | Float64Array;
export type Scalar = 'float32' | 'float64';

/** The name of a status; or 'invalid_argument' for an argument of the wrong type. */
export type Status = LibraryStatus | 'invalid_argument';

/** A status that is not ok. `message` is the error as text. */
export class CageformError extends Error {
  readonly name: 'CageformError';
  readonly status: Status;
  /** The index of the invalid element: a point, handle, pin, face or clip; or the tag of the invalid part of a file. */
  readonly culprit: number | string | null;
  readonly report: Report | null;
}

export interface Element {
  readonly kind: 'vertex' | 'edge' | 'face' | 'loop';
  readonly index: number;
}

/** An error or a warning about a cage; toString() returns it as text. */
export class Fault {
  private constructor();
  readonly text: string;
  readonly isWarning: boolean;
  readonly a: Element | null;
  readonly b: Element | null;
  toString(): string;
}

/** The result of a call; toString() lists the numbers that the call sets. */
export interface Report extends ReportNumbers {
  readonly status: LibraryStatus | 'ok';
  readonly message: string;
  readonly culprit: number | null;
  /** The first error of the cage, or the first warning. */
  readonly fault: Fault | null;
  /** Pins: the last solve moved no handle by more than 3e-5 of the cage's size. */
  readonly settled: boolean;
  /** Wraps: 'stages', 'residual' or 'noise' (was reached), 'fold': a finer fit would fold space. */
  readonly ended: WrapEnd;
  /** Wraps: the culprit is of the target. */
  readonly ofTarget: boolean;
  toString(): string;
}

export interface CloneOptions {
  /** Normals: true for a new array, or an array to write. */
  normals?: Array32or64 | boolean;
  /** 3D: tangents of four numbers; the fourth is the handedness. */
  tangents?: Array32or64 | boolean;
}
export interface Cloned {
  readonly points: Array32or64;
  readonly normals: Array32or64 | undefined;
  readonly tangents: Array32or64 | undefined;
}

declare class Owner {
  protected constructor();
  /** Frees the memory now; otherwise garbage collection frees it. Objects created from this one stay usable. */
  free(): void;
}

/** A figure from a binding or from open(). Poses of its handles deform it. */
export class Figure extends Owner {
  private constructor();
  readonly points: number;
  readonly handles: number;
  /** Number of handles that are points: the size of clips and of the input of poseHandles(). */
  readonly vertices: number;
  readonly dimension: 2 | 3;
  readonly scalar: Scalar;
  readonly clips: number;
  readonly levels: number;
  readonly hasNormals: boolean;
  readonly hasTangents: boolean;
  readonly hasLabels: boolean;
  /** Origin of the coordinates of points, handles and clips: `dimension` numbers. Add it to clones in double precision. */
  readonly origin: readonly number[];

  /** Returns the handles at rest, the initial pose. */
  rest(out?: Array32or64): Array32or64;
  /** The labels of the handles; '' for none. */
  labels(): string[];
  /** Opens a level of less detail, for the same poses. */
  level(level: number): Figure;
  /** Deforms the figure by a pose of all handles. The pose at rest gives the bound points, bitwise. Writes `out`, if given,
   *  which must have the figure's scalar. */
  clone(pose: Numbers, options?: CloneOptions & { out?: Array32or64 }): Cloned;
  /** As clone(), without a copy: returns views of the library's memory. The next clone of this figure overwrites them. They
   *  become invalid when the memory grows or the figure is freed: request new views after calls that create objects or open
   *  files. A view that is invalid after growth has length 0. */
  cloneView(pose: Numbers, options?: { normals?: boolean; tangents?: boolean }): Cloned;
  /** Converts gradients with respect to the cloned points to gradients with respect to the handles: the transpose of clone. */
  gradients(ofPoints: Numbers, out?: Array32or64): Array32or64;
  /** Computes a pose of all handles from a pose of the cage's vertices; Green coordinates need it. */
  poseHandles(vertices: Numbers, out?: Array32or64): Array32or64;
  /** Returns a clip, by index or name. */
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
  /** The packed clip for pack(), if compileClip() made the clip. */
  readonly bytes: Uint8Array | null;
  /** Returns the cage's vertices at a time. */
  sample(time: number, out?: Array32or64): Array32or64;
}

/** Opens a packed figure. Copies the bytes. */
export function open(bytes: ArrayBuffer | ArrayBufferView, options?: { skipChecksum?: boolean }): Figure;

/** The sources of init(): bytes, a compiled module, a response or its promise, or an address. */
export type Source = ArrayBuffer | ArrayBufferView | WebAssembly.Module | Response | URL | string;

/** The version of the library. */
export const version: string;
