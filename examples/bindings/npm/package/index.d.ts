import type { Array32or64, Clip, Fault, Figure, Indices, Numbers, Report, Scalar, Source } from './figures.js';
import type { CoordinateType, Keys, OutsidePoints, Shape, WeightFormat } from './layout.js';

export { CageformError, Clip, Fault, Figure, open, version } from './figures.js';
export type {
  Array32or64,
  CloneOptions,
  Cloned,
  Element,
  Indices,
  Numbers,
  Report,
  Scalar,
  Source,
  Status,
} from './figures.js';

/** Starts the library; without an argument it finds cageform.wasm beside this file. Await it before the first call. */
export function init(source?: Source | Promise<Source>): Promise<void>;

/** Is told the fraction done. Returning false cancels; what it throws is thrown by the call. It may not call the library. */
export type Progress = (done: number) => boolean | void;

declare class Owner {
  /** Frees the memory now; else the garbage collection does. Objects made of this one stay usable. */
  free(): void;
}

/** Cells inside a polygon or a mesh of triangles, for harmonic coordinates. */
export interface CageCells {
  /** So many of the last vertices are not on the boundary; they are handles too. */
  cellVertices?: number;
  /** Points (a = b) and edges inside; everything within the radius follows them. */
  bones?: readonly { a: number; b?: number; radius: number }[];
  /** In the plane two ends an edge, in space three corners a triangle. */
  walls?: Indices;
}

/** A cage, as arrays. */
export class Cage {
  private constructor();
  readonly kind: 'polygon' | 'mesh' | 'curves' | 'lattice' | 'sites';
  readonly dimension: 2 | 3;
  /** Copies of the numbers. */
  readonly vertices: Array32or64 | null;
  readonly loops: Uint32Array | null;
  readonly faces: number[][] | null;

  /** Loops in the plane, and how many vertices each has. */
  static polygon(vertices: Numbers, loops?: Indices | null, options?: CageCells): Cage;
  /** Faces in space, counter-clockwise seen from outside: an array for each, or flat with so many `corners` each (3). Quads
   *  may be divided; a face whose corners are farther off its plane than `offPlane` is a fan. */
  static mesh(
    vertices: Numbers,
    faces: Indices,
    options?: CageCells & { corners?: number; divisions?: number; offPlane?: number },
  ): Cage;
  /** Loops of Bézier curves in the plane, for Green coordinates: 2 to 4 control points an edge; and edges of each loop. */
  static curves(edges: readonly Numbers[], loops?: Indices): Cage;
  /** A box of splines: control points along each axis, a corner of the box, and its edges. Knots along each axis are points +
   *  degree + 1 ascending numbers from 0 to 1; left out, they are uniform. */
  static lattice(options: {
    points?: number | number[];
    origin: number[];
    axes: number[][];
    degree?: number | number[];
    falloff?: number;
    knots?: readonly (Numbers | null | undefined)[];
  }): Cage;
  /** Points without a cage, for Sibson coordinates. */
  static sites(points: Numbers, options?: { dimension?: 2 | 3 }): Cage;
}

/** The faults and warnings of a cage; none if it can serve. */
export function check(cage: Cage): Fault[];

export interface MakeCageOptions {
  /** 3 for a mesh, 2 for segments. */
  dimension?: 2 | 3;
  /** 0: 24 in the plane, 112 in space. */
  vertices?: number;
  /** A share of the figure's diagonal; 0: 0.025 in the plane, 0.02 in space. */
  margin?: number;
  shape?: Shape;
  mirror?: 'none' | 'x' | 'y' | 'z';
  /** In the plane half the width of each segment. */
  radii?: readonly number[] | Float64Array | Float32Array;
  fillTunnels?: boolean;
  manyCages?: boolean;
  regular?: number;
  progress?: Progress;
}
/** Makes a cage around a figure: vertices and triangles in space, or ends and segments in the plane. It takes seconds: run it in
 *  a worker. */
export function makeCage(points: Numbers, indices: Indices, options?: MakeCageOptions): { cage: Cage; report: Report };

/** The names of coordinate types, as coordinates/types.hpp lists them. */
export type CoordinatesKind = CoordinateType;

export interface CoordinatesOptions {
  /** Left out: mean-value; splines of a lattice, curved-green of curves, sibson of sites. */
  kind?: CoordinatesKind;
  /** The scalar of weights, poses and clones; float32 if it is left out. */
  scalar?: Scalar;
  /** Harmonic: the largest error of a weight; 0: 1e-3. */
  accuracy?: number;
  memoryLimit?: number;
  /** curved-green: x, y, radius. */
  disk?: readonly number[];
}

/** Coordinates of a cage. */
export class Coordinates extends Owner {
  static readonly kinds: readonly CoordinatesKind[];
  constructor(cage: Cage, options?: CoordinatesOptions);
  /** Makes coordinates of several cages over one figure, such as a body and a head; where they overlap, they are blended by depth. Mean value or
   *  harmonic. Handles are those of the first cage, then of the next. */
  static blend(cages: readonly Cage[], options?: CoordinatesOptions): Coordinates;
  readonly kind: CoordinatesKind;
  readonly scalar: Scalar;
  readonly report: Report;
  /** Their number, vectors among them. */
  readonly handles: number;
  readonly vertices: number;
  readonly dimension: 2 | 3;
  readonly hasWeightsOutside: boolean;
  readonly hasGradients: boolean;
  rest(out?: Array32or64): Array32or64;
  /** Solves for harmonic functions and keeps them, so that several binds solve only once. */
  solve(options?: { progress?: Progress }): Report;
  /** Binds points, and normals and tangents of as many. Bad points are listed and kept in place. */
  bind(points: Numbers, options?: BindOptions): Binding;
}

export interface BindOptions {
  normals?: Numbers;
  /** In space, of 3 or 4 numbers. */
  tangents?: Numbers;
  outside?: OutsidePoints;
  /** Outside, displacements fade to nothing at this distance; 0: they do not. */
  falloff?: number;
  leaveLinearPrecision?: boolean;
  progress?: Progress;
}

/** A figure with all its weights. */
export class Binding extends Owner {
  private constructor();
  readonly report: Report;
  /** To be cloned. It keeps the weights: free() it too. */
  readonly figure: Figure;
  readonly points: number;
  readonly handles: number;
  readonly scalar: Scalar;
  /** Points, by number. */
  readonly onBoundary: Uint32Array;
  readonly outside: Uint32Array;
  readonly notFinite: Uint32Array;
  readonly unreached: Uint32Array;
  readonly notRestored: Uint32Array;
  readonly faded: Uint32Array;
  /** The weights of points, `handles` numbers each. */
  weights(first?: number, count?: number): Array32or64;
  /** Labels the handles. They are packed with the figure; `figure` is then another. */
  setLabels(labels: readonly (string | null)[]): void;
  /** Packs the figure for open(), and for games. */
  pack(options?: PackOptions): { bytes: Uint8Array; report: Report };
}

export interface PackOptions {
  /** The largest distance of a point from where all weights put it; 0: no limit. */
  tolerance?: number;
  /** Weights below may be dropped; with tolerance and largest 0 as well, nothing is. */
  threshold?: number;
  /** How many weights a point keeps. */
  largest?: number;
  /** The tolerance holds this far from affine poses; */
  reach?: number;
  /** or in these poses, one after the other. */
  poses?: Numbers;
  format?: WeightFormat;
  clips?: Readonly<Record<string, Clip>>;
  /** Packed figures of less detail, of the same handles. */
  levels?: readonly (ArrayBuffer | ArrayBufferView)[];
  /** The place from which points, handles and clips count, for Figure.origin. */
  origin?: readonly number[];
  progress?: Progress;
}

export interface ClipOptions {
  dimension?: 2 | 3;
  /** The largest error of a coordinate; 0: a thousandth of the poses' size or less. */
  tolerance?: number;
  /** The largest distance that curves in 16 bits may cost; 0: they stay exact. */
  packTolerance?: number;
  keys?: Keys;
  before?: 'stay' | 'straight_on' | 'cycle' | 'cycle_with_offset' | 'ping_pong';
  after?: 'stay' | 'straight_on' | 'cycle' | 'cycle_with_offset' | 'ping_pong';
  scalar?: Scalar;
  progress?: Progress;
}
/** Compiles poses of the cage's vertices at ascending times: all numbers in a row, or an array for each time. */
export function compileClip(
  times: Numbers,
  poses: Numbers | readonly Numbers[],
  options?: ClipOptions,
): { clip: Clip; report: Report };

/** Samples of the inside of a cage, by which pins move it: of coordinates that have gradients. */
export class Samples extends Owner {
  constructor(
    coordinates: Coordinates,
    options?: { samples?: number; rotations?: number; smoothing?: number; progress?: Progress },
  );
  readonly handles: number;
  readonly dimension: 2 | 3;
  readonly scalar: Scalar;
  readonly report: Report | null;
  /** The bytes that openSamples() reads. */
  pack(): Uint8Array;
}
export function openSamples(bytes: ArrayBuffer | ArrayBufferView, options?: { skipChecksum?: boolean }): Samples;

/** Moves a cage by pins on a figure, as rigidly as possible inside. */
export class Pins extends Owner {
  constructor(samples: Samples, options?: { pinWeight?: number; hard?: boolean; iterations?: number });
  readonly handles: number;
  readonly dimension: 2 | 3;
  readonly scalar: Scalar;
  /** Pins points of a figure, by number, instead of those before. */
  set(figure: Figure, points: Indices, options?: { weights?: readonly number[] | Float64Array }): void;
  /** Holds handles where the pose has them. */
  hold(handles: Indices): void;
  /** A frame: moves a copy of the pose towards the targets, one for each pin; again until report.settled. */
  solve(targets: Numbers, pose: Numbers): { pose: Array32or64; report: Report };
}
