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

/** Starts the library; the default source is cageform.wasm next to this file. Await it before the first call. */
export function init(source?: Source | Promise<Source>): Promise<void>;

/** Receives the completed fraction, 0 to 1. Return false to cancel. The call rethrows exceptions. Must not call the library. */
export type Progress = (done: number) => boolean | void;

declare class Owner {
  /** Frees the memory now; otherwise garbage collection frees it. Objects created from this one stay usable. */
  free(): void;
}

/** Cells inside a polygon or a mesh of triangles, for harmonic coordinates. */
export interface CageCells {
  /** Number of vertices at the end of `vertices` that are not on the boundary; they are handles, too. */
  cellVertices?: number;
  /** Vertices (a = b) and, in 3D, edges inside; everything within the radius moves with them. */
  bones?: readonly { a: number; b?: number; radius: number }[];
  /** 2D: two vertex indices per edge; 3D: three per triangle. */
  walls?: Indices;
}

/** A cage, as arrays. */
export class Cage {
  private constructor();
  readonly kind: 'polygon' | 'mesh' | 'curves' | 'lattice' | 'sites';
  readonly dimension: 2 | 3;
  /** Copies of the arrays. */
  readonly vertices: Array32or64 | null;
  readonly loops: Uint32Array | null;
  readonly faces: number[][] | null;

  /** A 2D cage of loops; `loops` has the number of vertices of each. */
  static polygon(vertices: Numbers, loops?: Indices | null, options?: CageCells): Cage;
  /** A 3D cage of faces, counter-clockwise seen from outside: an array per face, or a flat array with `corners` (3) per face.
   *  `divisions` divides quads. A face with a corner farther than `offPlane` from its plane is a fan. */
  static mesh(
    vertices: Numbers,
    faces: Indices,
    options?: CageCells & { corners?: number; divisions?: number; offPlane?: number },
  ): Cage;
  /** A 2D cage of loops of Bézier curves, for Green coordinates: 2 to 4 control points per edge; `loops`: edges per loop. */
  static curves(edges: readonly Numbers[], loops?: Indices): Cage;
  /** A box of splines: control points along each axis, a corner of the box, and its edges. `knots`: along each axis points +
   *  degree + 1 ascending numbers from 0 to 1; default: uniform. */
  static lattice(options: {
    points?: number | number[];
    origin: number[];
    axes: number[][];
    degree?: number | number[];
    falloff?: number;
    knots?: readonly (Numbers | null | undefined)[];
  }): Cage;
  /** Control points without a cage, for Sibson coordinates. */
  static sites(points: Numbers, options?: { dimension?: 2 | 3 }): Cage;
}

/** Returns the errors and warnings of a cage. */
export function check(cage: Cage): Fault[];

export interface MakeCageOptions {
  /** 3 for a mesh, 2 for segments. */
  dimension?: 2 | 3;
  /** Requested number of vertices; 0: 24 in 2D, 112 in 3D. */
  vertices?: number;
  /** Relative to the figure's diagonal; 0: 0.025 in 2D, 0.02 in 3D. */
  margin?: number;
  shape?: Shape;
  mirror?: 'none' | 'x' | 'y' | 'z';
  /** 2D: half the width of each segment. */
  radii?: readonly number[] | Float64Array | Float32Array;
  fillTunnels?: boolean;
  manyCages?: boolean;
  regular?: number;
  progress?: Progress;
}
/** Makes a cage around a figure: 3D vertices and triangles, or 2D ends and segments. The call takes seconds: run it in
 *  a worker. */
export function makeCage(points: Numbers, indices: Indices, options?: MakeCageOptions): { cage: Cage; report: Report };

/** The names of coordinate types, in the order of coordinates/types.hpp. */
export type CoordinatesKind = CoordinateType;

export interface CoordinatesOptions {
  /** Default: mean-value; for a lattice splines, for curves curved-green, for sites sibson. */
  kind?: CoordinatesKind;
  /** The scalar of weights, poses and clones; default: float32. */
  scalar?: Scalar;
  /** Harmonic: maximum error of a weight; 0: 1e-3. */
  accuracy?: number;
  /** Harmonic: 0, or up to 40 for local harmonic coordinates, which have fewer influences. */
  locality?: number;
  memoryLimit?: number;
  /** curved-green: x, y and radius of a disk. */
  disk?: readonly number[];
}

/** Coordinates of a cage. */
export class Coordinates extends Owner {
  static readonly kinds: readonly CoordinatesKind[];
  constructor(cage: Cage, options?: CoordinatesOptions);
  /** Makes coordinates of several cages over one figure, such as a body and a head. Where cages overlap, weights are blended
   *  by depth. Mean value or harmonic. The handles of the first cage come first, then those of the next. */
  static blend(cages: readonly Cage[], options?: CoordinatesOptions): Coordinates;
  readonly kind: CoordinatesKind;
  readonly scalar: Scalar;
  readonly report: Report;
  /** Number of handles, including vectors. */
  readonly handles: number;
  readonly vertices: number;
  readonly dimension: 2 | 3;
  readonly hasWeightsOutside: boolean;
  readonly hasGradients: boolean;
  rest(out?: Array32or64): Array32or64;
  /** Computes and stores the harmonic functions, so that several binds solve only once. */
  solve(options?: { progress?: Progress }): Report;
  /** Binds points, and normals and tangents (one per point). Points without weights are listed and do not move. */
  bind(points: Numbers, options?: BindOptions): Binding;
}

export interface BindOptions {
  normals?: Numbers;
  /** 3D: 3 or 4 numbers each. */
  tangents?: Numbers;
  outside?: OutsidePoints;
  /** Distance outside at which displacements reach 0; 0: no falloff. */
  falloff?: number;
  leaveLinearPrecision?: boolean;
  progress?: Progress;
}

/** A bound figure with all its weights. */
export class Binding extends Owner {
  private constructor();
  readonly report: Report;
  /** The figure for clone(). It keeps the weights in memory: call its free(), too. */
  readonly figure: Figure;
  readonly points: number;
  readonly handles: number;
  readonly scalar: Scalar;
  /** Point indices in ascending order. */
  readonly onBoundary: Uint32Array;
  readonly outside: Uint32Array;
  readonly notFinite: Uint32Array;
  readonly unreached: Uint32Array;
  readonly notRestored: Uint32Array;
  readonly faded: Uint32Array;
  /** Returns the weights of points, `handles` numbers each. */
  weights(first?: number, count?: number): Array32or64;
  /** Sets one label per handle. Labels are packed with the figure. Replaces `figure` by a new one. */
  setLabels(labels: readonly (string | null)[]): void;
  /** Packs the figure to bytes for open() and for games. */
  pack(options?: PackOptions): { bytes: Uint8Array; report: Report };
}

export interface PackOptions {
  /** Maximum change of a point by packing; 0: no limit. */
  tolerance?: number;
  /** Smaller weights may be dropped; if tolerance, threshold and largest are 0, none is. */
  threshold?: number;
  /** Maximum number of weights per point; 0: all. */
  largest?: number;
  /** The tolerance holds for handles up to this distance from an affine pose; 0: a tenth of the cage's size. */
  reach?: number;
  /** Replaces `reach`: the tolerance holds in these poses, each of all handles. */
  poses?: Numbers;
  format?: WeightFormat;
  clips?: Readonly<Record<string, Clip>>;
  /** Packed figures of less detail with the same handles. */
  levels?: readonly (ArrayBuffer | ArrayBufferView)[];
  /** Origin of the coordinates of points, handles and clips, stored for Figure.origin. */
  origin?: readonly number[];
  progress?: Progress;
}

export interface ClipOptions {
  dimension?: 2 | 3;
  /** Maximum error of a coordinate; 0: at most a thousandth of the poses' size. */
  tolerance?: number;
  /** Maximum distance caused by 16-bit curves; 0: curves stay exact. */
  packTolerance?: number;
  keys?: Keys;
  before?: 'stay' | 'straight_on' | 'cycle' | 'cycle_with_offset' | 'ping_pong';
  after?: 'stay' | 'straight_on' | 'cycle' | 'cycle_with_offset' | 'ping_pong';
  scalar?: Scalar;
  progress?: Progress;
}
/** Compiles poses of the cage's vertices at ascending times to a clip. Poses are a flat array, or an array per time. */
export function compileClip(
  times: Numbers,
  poses: Numbers | readonly Numbers[],
  options?: ClipOptions,
): { clip: Clip; report: Report };

/** Samples of the interior of a cage, for Pins. The coordinates must have gradients. */
export class Samples extends Owner {
  constructor(
    coordinates: Coordinates,
    options?: { samples?: number; rotations?: number; smoothing?: number; progress?: Progress },
  );
  readonly handles: number;
  readonly dimension: 2 | 3;
  readonly scalar: Scalar;
  readonly report: Report | null;
  /** Returns the bytes for openSamples(). */
  pack(): Uint8Array;
}
export function openSamples(bytes: ArrayBuffer | ArrayBufferView, options?: { skipChecksum?: boolean }): Samples;

/** Moves a cage so that pinned points reach targets and its interior deforms as rigidly as possible. */
export class Pins extends Owner {
  constructor(samples: Samples, options?: { pinWeight?: number; hard?: boolean; iterations?: number });
  readonly handles: number;
  readonly dimension: 2 | 3;
  readonly scalar: Scalar;
  /** Replaces all pins by pins at points of a figure, given by index. */
  set(figure: Figure, points: Indices, options?: { weights?: readonly number[] | Float64Array }): void;
  /** Replaces the set of fixed handles, which keep their positions in the pose. */
  hold(handles: Indices): void;
  /** Moves a copy of the pose towards the targets, one per pin. Repeat, for instance every frame, until report.settled. */
  solve(targets: Numbers, pose: Numbers): { pose: Array32or64; report: Report };
}

export interface WrapOptions {
  /** Points of the source, and their places on the target. */
  landmarks?: readonly (readonly [from: readonly number[], to: readonly number[]])[];
  /** Relative weights of the landmarks; default: 1. */
  weights?: readonly number[];
  /** Points that will follow, such as the vertices of clothes. Those outside the source are kept outside the target. */
  follow?: Numbers;
  /** Coordinates with gradients: a pose of their cage, then a lattice behind it. Default: a lattice alone. */
  coordinates?: Coordinates;
  /** Whether to scale and move the source to the target first; default: true. */
  align?: boolean;
  /** Source and target have different poses; needs landmarks. */
  otherPose?: boolean;
  /** Spans of the finest lattice along the target's height: 6, 12, 24 (default) … 96. With coordinates lattices begin at 12,
   *  and 6 is the cage alone. */
  finest?: number;
  /** A finer lattice where parts touch, such as thighs; takes twice the time; without coordinates only. */
  refineContacts?: boolean;
  /** The search ends at this weight of the rigidity; 0: 1e-7; for noise: 1e-5. */
  leastStiffness?: number;
  /** Lower bound of the map's least singular value; 0: 0.1. */
  floor?: number;
  /** Ends the search below this report.toTargetUpper; 0: never. */
  residual?: number;
  /** About the largest number of samples of space; 0: 16000. */
  samples?: number;
  /** The largest number of handles; 0: 8000. Lattices with more are left out: report.leftOut. */
  handles?: number;
  progress?: Progress;
}

/** A map of space: `first`, then the pose of the cage, then the pose of the lattice. Arrays are copies. */
export class Wrap extends Owner {
  private constructor();
  readonly report: Report;
  /** The images of the axes x, y, z and of the origin; the identity if there are coordinates. */
  readonly first: readonly number[];
  /** The pose of the coordinates, for clone(); empty without coordinates. */
  readonly pose: Array32or64;
  /** In the space of the target; null: no lattice. */
  readonly lattice: Cage | null;
  readonly latticePose: Array32or64;
  /** Moves points of the source. Jacobians are 9 numbers per point: the images of the axes x, y, z. */
  move(points: Numbers, options?: { jacobians?: boolean }): { points: Array32or64; jacobians: Array32or64 | undefined };
}

/** Finds a map of space that lays a source on a target, both triangle meshes in 3D. Clothes, hair and joints of the source
 *  follow by move(). Both figures have the same up and front, unless three or more landmarks align them. If less than half of
 *  a figure has a match, report.status is 'fit_not_reached'. The call takes seconds: run it in a worker. */
export function wrap(
  source: Numbers,
  sourceFaces: Indices,
  target: Numbers,
  targetFaces: Indices,
  options?: WrapOptions,
): Wrap;
