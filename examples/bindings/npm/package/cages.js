// Cages: creation, checks, makeCage().

import { CageformError, Fault, MADE, objectOf, refuse, started } from './engine.js';
import { CHOICES, CONSTANTS } from './layout.js';
import { choice, indices, number, numbers, options, points, progressOf, whole } from './numbers.js';

const KINDS = {
  polygon: CONSTANTS.POLYGON,
  mesh: CONSTANTS.MESH,
  curves: CONSTANTS.CURVES,
  lattice: CONSTANTS.LATTICE,
  sites: CONSTANTS.SITES,
};

/** Returns the struct members for cells inside a cage. */
const CELLS = ['cellVertices', 'bones', 'walls'];
function cellsOf({ cellVertices = 0, bones = [], walls }) {
  if (!Array.isArray(bones)) refuse('bones: an array of { a, b, radius } is needed');
  const boneOf = ({ a, b = a, radius }) => ({
    a: whole(a, 'bones'),
    b: whole(b, 'bones'),
    radius: number(radius, 'bones'),
  });
  return {
    cellVertices: whole(cellVertices, 'cellVertices'),
    bones: bones.map(bone => boneOf(bone ?? {})),
    walls: walls === undefined ? null : indices(walls, 'walls'),
  };
}

export class Cage {
  #its;

  /** Internal: the functions below make cages. */
  constructor(made, its) {
    if (made !== MADE) refuse('Cage.polygon(), mesh(), curves(), lattice() and sites() make cages');
    this.#its = {
      vertices: null,
      counts: null,
      indices: null,
      loops: null,
      dimension: its.vertices?.dimension,
      ...its,
    };
    this.kind = its.kind;
    this.dimension = this.#its.dimension;
  }

  static polygon(vertices, loops, chosen) {
    return new Cage(MADE, {
      kind: 'polygon',
      vertices: points(vertices, 'vertices', { dimension: 2 }),
      counts: loops === undefined || loops === null ? null : indices(loops, 'loops'),
      ...cellsOf(options(chosen, CELLS)),
    });
  }

  static mesh(vertices, faces, chosen) {
    const {
      divisions = 1,
      offPlane = 0,
      corners = 3,
      ...cells
    } = options(chosen, ['divisions', 'offPlane', 'corners', ...CELLS]);
    const listed = Array.isArray(faces) && typeof faces[0] === 'object',
      flat = indices(faces, 'faces');
    const each = listed
      ? Uint32Array.from(faces, face => face?.length ?? 1)
      : new Uint32Array(Math.ceil(flat.length / whole(corners, 'corners', 3))).fill(corners);
    return new Cage(MADE, {
      kind: 'mesh',
      vertices: points(vertices, 'vertices', { dimension: 3 }),
      counts: each,
      indices: flat,
      divisions: whole(divisions, 'divisions', 1),
      offPlane: number(offPlane, 'offPlane'),
      ...cellsOf(cells),
    });
  }

  static curves(edges, loops) {
    if (!Array.isArray(edges)) refuse('edges: an array of edges is needed');
    const all = edges.map(edge => points(edge, 'edges', { dimension: 2, Kind: Float64Array }));
    const joined = new Float64Array(2 * all.reduce((sum, edge) => sum + edge.count, 0));
    let at = 0;
    for (const edge of all) {
      joined.set(edge.numbers, at);
      at += edge.numbers.length;
    }
    return new Cage(MADE, {
      kind: 'curves',
      vertices: points(joined, 'edges', { dimension: 2 }),
      counts: Uint32Array.from(all, edge => Math.max(edge.count - 1, 0)),
      loops: loops === undefined ? null : indices(loops, 'loops'),
    });
  }

  static lattice(chosen) {
    const {
      points: along = 4,
      origin,
      axes,
      degree = 3,
      falloff = 0,
      knots = [],
    } = options(chosen, ['points', 'origin', 'axes', 'degree', 'falloff', 'knots']);
    if (!Array.isArray(axes) || (axes.length !== 2 && axes.length !== 3))
      refuse('axes: two or three edges of the box are needed');
    const dimension = axes.length;
    const each = (given, name) =>
      typeof given === 'number'
        ? Array(dimension).fill(whole(given, name))
        : numbers(given, dimension, name).map(n => whole(n, name));
    const padded = list => [...list, 0].slice(0, 3);
    const edges = axes.map(axis => padded(numbers(axis, dimension, 'axes')));
    return new Cage(MADE, {
      kind: 'lattice',
      dimension,
      points: each(along, 'points'),
      degree: each(degree, 'degree'),
      falloff: number(falloff, 'falloff'),
      knots: Array.from({ length: 3 }, (x, k) => Float64Array.from(knots[k] ?? [], knot => number(knot, 'knots'))),
      origin: padded(numbers(origin, dimension, 'origin')),
      axes: edges,
    });
  }

  static sites(sites, chosen) {
    const { dimension = 3 } = options(chosen, ['dimension']);
    return new Cage(MADE, { kind: 'sites', vertices: points(sites, 'sites', { dimension: dimensionOf(dimension) }) });
  }

  get vertices() {
    return this.#its.vertices?.numbers.slice() ?? null;
  }
  get loops() {
    return this.kind === 'polygon' ? (this.#its.counts?.slice() ?? null) : (this.#its.loops?.slice() ?? null);
  }
  get faces() {
    if (this.kind !== 'mesh') return null;
    const { counts, indices: corners } = this.#its;
    let at = 0;
    return Array.from(counts, count => corners.subarray(at, (at += count))).map(face => Array.from(face));
  }

  /** Writes a cageform_cage. */
  _describe(scope) {
    const {
      vertices,
      counts,
      indices: corners,
      loops,
      divisions = 0,
      offPlane = 0,
      points: along = [],
      degree = [],
      origin = [],
      axes = [],
      falloff = 0,
      knots = [],
      dimension,
      cellVertices = 0,
      bones = [],
      walls = null,
    } = this.#its;
    const length = array => array?.length ?? 0;
    return scope.struct('cageform_cage', {
      kind: KINDS[this.kind],
      ...(vertices === null ? {} : { vertices: scope.points(vertices) }),
      counts: scope.array(counts),
      countCount: length(counts),
      indices: scope.array(corners),
      indexCount: length(corners),
      loops: scope.array(loops),
      loopCount: length(loops),
      divisions,
      offPlane,
      ...(this.kind === 'lattice' ? { dimension } : {}),
      points: along,
      degree,
      origin,
      axes,
      falloff,
      cellVertices,
      bones: scope.structs('cageform_bone', bones),
      boneCount: bones.length,
      walls: scope.array(walls),
      wallIndexCount: length(walls),
      knots: knots.map(list => (list.length > 0 ? scope.array(list) : 0)),
      knotCounts: knots.map(length),
    });
  }
}

export function dimensionOf(given) {
  if (given !== 2 && given !== 3) throw new CageformError('dimension_differs', 'dimension: 2 or 3 is needed');
  return given;
}

export function check(cage) {
  const engine = started(true);
  objectOf(Cage, cage, 'cage');
  return engine.scoped(scope => {
    const its = cage._describe(scope),
      count = scope.struct(4),
      most = 2000,
      faults = scope.structs('cageform_fault', Array(most).fill({}));
    const code = engine.call('cageform_check', its, faults, most, count),
      found = engine.view('u32', count, 1)[0];
    if (code >= 1000 || (code !== 0 && found === 0)) engine.check(code);
    const { size } = scope.layout('cageform_fault');
    return Array.from(
      { length: Math.min(found, most) },
      (x, n) => new Fault(scope.read('cageform_fault', faults + n * size), engine),
    );
  });
}

const MIRRORS = { none: 0, x: 1, y: 2, z: 3 };

export function makeCage(places, joined, chosen) {
  const engine = started(true);
  const {
    dimension = 3,
    vertices = 0,
    margin = 0,
    shape = 'figure',
    mirror = 'none',
    radii,
    fillTunnels = false,
    manyCages = false,
    regular = 0,
    progress,
  } = options(chosen, 'dimension vertices margin shape mirror radii fillTunnels manyCages regular progress'.split(' '));
  const given = points(places, 'points', { dimension: dimensionOf(dimension) }),
    corners = indices(joined, 'indices'),
    told = progressOf(progress);
  const own = radii === undefined ? null : Float64Array.from(numbers(radii, Math.floor(corners.length / 2), 'radii'));
  const how = {
    vertices: whole(vertices, 'vertices'),
    margin: number(margin, 'margin'),
    shape: choice(CHOICES.shape, shape, 'shape'),
    mirror: choice(MIRRORS, mirror, 'mirror'),
    fillTunnels: Boolean(fillTunnels),
    manyCages: Boolean(manyCages),
    regular: number(regular, 'regular'),
  };
  return engine.scoped(scope => {
    const report = scope.newReport();
    const figure = scope.struct('cageform_drawing', {
      points: scope.points(given),
      indices: scope.array(corners),
      indexCount: corners.length,
      radii: scope.array(own),
    });
    const made = engine.make(
      scope,
      'cageform_make_cage',
      [figure, scope.struct('cageform_make_cage_options', how), scope.running(told)],
      { report, progress: told },
    );
    try {
      const its = scope.struct('cageform_cage');
      engine.check(engine.call('cageform_made_cage_describe', made, its));
      const { kind, vertices: at, counts, countCount, indices: faces, indexCount } = scope.read('cageform_cage', its);
      const copied = (from, count) => (count === 0 ? null : engine.view('u32', from, count).slice());
      const found = points(engine.view('f64', at.data, at.count * at.dimension).slice(), 'vertices', {
        dimension: at.dimension,
      });
      const cage = {
        kind: kind === CONSTANTS.MESH ? 'mesh' : 'polygon',
        vertices: found,
        counts: copied(counts, countCount),
        indices: copied(faces, indexCount),
      };
      cage.counts ??= cage.indices && new Uint32Array(cage.indices.length / 3).fill(3);
      return { cage: new Cage(MADE, cage), report: scope.report(report) };
    } finally {
      engine.ended || engine.call('cageform_free', made);
    }
  });
}
