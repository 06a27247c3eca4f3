// Everything: the run time, and what is made before it.

import { CageformError, Fault, MADE, Owner, Report, objectOf, refuse, scalarOf, start, started } from './engine.js';
import { Clip, Figure, described, fileAt, orFree, written } from './figures.js';
import { CONSTANTS, VERSION } from './layout.js';
import { bytesOf, choice, classOf, flattened, indices, nameOf, number, numbers, options, points, progressOf, scalarClass, string, whole } from './numbers.js';

export { CageformError, Fault, Report };
export { Clip, Figure, open } from './figures.js';
export const version = VERSION;

/** Starts the library. */
export const init = source => start(source, new URL('./cageform.wasm', import.meta.url), true);

// ---- cages -----------------------------------------------------------------------------------------------------------------

const KINDS = { polygon: CONSTANTS.POLYGON, mesh: CONSTANTS.MESH, curves: CONSTANTS.CURVES, lattice: CONSTANTS.LATTICE, sites: CONSTANTS.SITES };

/** What lies inside of a cage. */
const CELLS = ['cellVertices', 'bones', 'walls'];
function cellsOf({ cellVertices = 0, bones = [], walls }) {
  if (!Array.isArray(bones)) refuse('bones: an array of { a, b, radius } is needed');
  const boneOf = ({ a, b = a, radius }) => ({ a: whole(a, 'bones'), b: whole(b, 'bones'), radius: number(radius, 'bones') });
  return { cellVertices: whole(cellVertices, 'cellVertices'), bones: bones.map(bone => boneOf(bone ?? {})), walls: walls === undefined ? null : indices(walls, 'walls') };
}

export class Cage {
  #its;

  /** Not for callers: the functions below make cages. */
  constructor(made, its) {
    if (made !== MADE) refuse('a cage is made by Cage.polygon(), mesh(), curves(), lattice() or sites()');
    this.#its = { vertices: null, counts: null, indices: null, loops: null, dimension: its.vertices?.dimension, ...its };
    this.kind = its.kind;
    this.dimension = this.#its.dimension;
  }

  static polygon(vertices, loops, chosen) {
    return new Cage(MADE, { kind: 'polygon', vertices: points(vertices, 'vertices', { dimension: 2 }),
                            counts: loops === undefined || loops === null ? null : indices(loops, 'loops'), ...cellsOf(options(chosen, CELLS)) });
  }

  static mesh(vertices, faces, chosen) {
    const { divisions = 1, offPlane = 0, corners = 3, ...cells } = options(chosen, ['divisions', 'offPlane', 'corners', ...CELLS]);
    const listed = Array.isArray(faces) && typeof faces[0] === 'object', flat = indices(faces, 'faces');
    const each = listed ? Uint32Array.from(faces, face => face?.length ?? 1) : new Uint32Array(Math.ceil(flat.length / whole(corners, 'corners', 3))).fill(corners);
    return new Cage(MADE, { kind: 'mesh', vertices: points(vertices, 'vertices', { dimension: 3 }), counts: each, indices: flat,
                      divisions: whole(divisions, 'divisions', 1), offPlane: number(offPlane, 'offPlane'), ...cellsOf(cells) });
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
    return new Cage(MADE, { kind: 'curves', vertices: points(joined, 'edges', { dimension: 2 }), counts: Uint32Array.from(all, edge => Math.max(edge.count - 1, 0)),
                      loops: loops === undefined ? null : indices(loops, 'loops') });
  }

  static lattice(chosen) {
    const { points: along = 4, origin, axes, degree = 3, falloff = 0 } = options(chosen, ['points', 'origin', 'axes', 'degree', 'falloff']);
    if (!Array.isArray(axes) || (axes.length !== 2 && axes.length !== 3)) refuse('axes: two or three edges of the box are needed');
    const dimension = axes.length;
    const each = (given, name) => (typeof given === 'number' ? Array(dimension).fill(whole(given, name)) : numbers(given, dimension, name).map(n => whole(n, name)));
    const padded = list => [...list, 0].slice(0, 3);
    const edges = axes.map(axis => padded(numbers(axis, dimension, 'axes')));
    return new Cage(MADE, { kind: 'lattice', dimension, points: each(along, 'points'), degree: each(degree, 'degree'), falloff: number(falloff, 'falloff'),
                      origin: padded(numbers(origin, dimension, 'origin')), axes: edges });
  }

  static sites(sites, chosen) {
    const { dimension = 3 } = options(chosen, ['dimension']);
    return new Cage(MADE, { kind: 'sites', vertices: points(sites, 'sites', { dimension: dimensionOf(dimension) }) });
  }

  get vertices() { return this.#its.vertices?.numbers.slice() ?? null; }
  get loops() { return this.kind === 'polygon' ? this.#its.counts?.slice() ?? null : this.#its.loops?.slice() ?? null; }
  get faces() {
    if (this.kind !== 'mesh') return null;
    const { counts, indices: corners } = this.#its;
    let at = 0;
    return Array.from(counts, count => corners.subarray(at, at += count)).map(face => Array.from(face));
  }

  /** Writes a cageform_cage. */
  _describe(scope) {
    const { vertices, counts, indices: corners, loops, divisions = 0, offPlane = 0, points: along = [], degree = [], origin = [], axes = [],
            falloff = 0, dimension, cellVertices = 0, bones = [], walls = null } = this.#its;
    const length = array => array?.length ?? 0;
    return scope.struct('cageform_cage', {
      kind: KINDS[this.kind], ...(vertices === null ? {} : { vertices: scope.points(vertices) }), counts: scope.array(counts), countCount: length(counts),
      indices: scope.array(corners), indexCount: length(corners), loops: scope.array(loops), loopCount: length(loops), divisions, offPlane,
      ...(this.kind === 'lattice' ? { dimension } : {}), points: along, degree, origin, axes, falloff,
      cellVertices, bones: scope.structs('cageform_bone', bones), boneCount: bones.length, walls: scope.array(walls), wallIndexCount: length(walls),
    });
  }
}

function dimensionOf(given) {
  if (given !== 2 && given !== 3) throw new CageformError('dimension_differs', 'dimension: 2 or 3 is needed');
  return given;
}

export function check(cage) {
  const engine = started(true);
  objectOf(Cage, cage, 'cage');
  return engine.scoped(scope => {
    const its = cage._describe(scope), count = scope.struct(4), most = 2000, faults = scope.structs('cageform_fault', Array(most).fill({}));
    const code = engine.call('cageform_check', its, faults, most, count), found = engine.view('u32', count, 1)[0];
    if (code >= 1000 || (code !== 0 && found === 0)) engine.check(code);
    const { size } = scope.layout('cageform_fault');
    return Array.from({ length: Math.min(found, most) }, (x, n) => new Fault(scope.read('cageform_fault', faults + n * size), engine));
  });
}

const SHAPES = { figure: CONSTANTS.SHAPE_FIGURE, hull: CONSTANTS.SHAPE_HULL, box: CONSTANTS.SHAPE_BOX };
const MIRRORS = { none: 0, x: 1, y: 2, z: 3 };

export function makeCage(places, joined, chosen) {
  const engine = started(true);
  const { dimension = 3, vertices = 0, margin = 0, shape = 'figure', mirror = 'none', radii, fillTunnels = false, manyCages = false, regular = 0, progress } =
    options(chosen, ['dimension', 'vertices', 'margin', 'shape', 'mirror', 'radii', 'fillTunnels', 'manyCages', 'regular', 'progress']);
  const given = points(places, 'points', { dimension: dimensionOf(dimension) }), corners = indices(joined, 'indices'), told = progressOf(progress);
  const own = radii === undefined ? null : Float64Array.from(numbers(radii, Math.floor(corners.length / 2), 'radii'));
  const how = { vertices: whole(vertices, 'vertices'), margin: number(margin, 'margin'), shape: choice(SHAPES, shape, 'shape'),
                mirror: choice(MIRRORS, mirror, 'mirror'), fillTunnels: Boolean(fillTunnels), manyCages: Boolean(manyCages), regular: number(regular, 'regular') };
  return engine.scoped(scope => {
    const report = scope.newReport();
    const figure = scope.struct('cageform_drawing', { points: scope.points(given), indices: scope.array(corners), indexCount: corners.length, radii: scope.array(own) });
    const made = engine.make(scope, 'cageform_make_cage', [figure, scope.struct('cageform_make_cage_options', how), scope.running(told)], { report, progress: told });
    try {
      const its = scope.struct('cageform_cage');
      engine.check(engine.call('cageform_made_cage_describe', made, its));
      const { kind, vertices: at, counts, countCount, indices: faces, indexCount } = scope.read('cageform_cage', its);
      const copied = (from, count) => (count === 0 ? null : engine.view('u32', from, count).slice());
      const found = points(engine.view('f64', at.data, at.count * at.dimension).slice(), 'vertices', { dimension: at.dimension });
      const cage = { kind: kind === CONSTANTS.MESH ? 'mesh' : 'polygon', vertices: found, counts: copied(counts, countCount), indices: copied(faces, indexCount) };
      cage.counts ??= cage.indices && new Uint32Array(cage.indices.length / 3).fill(3);
      return { cage: new Cage(MADE, cage), report: scope.report(report) };
    } finally {
      engine.ended || engine.call('cageform_free', made);
    }
  });
}

// ---- coordinates and bindings ----------------------------------------------------------------------------------------------

const TYPES = { 'mean-value': CONSTANTS.MEAN_VALUE, harmonic: CONSTANTS.HARMONIC, green: CONSTANTS.GREEN, sibson: CONSTANTS.SIBSON,
                barycentric: CONSTANTS.BARYCENTRIC, wachspress: CONSTANTS.WACHSPRESS, 'discrete-harmonic': CONSTANTS.DISCRETE_HARMONIC, splines: CONSTANTS.SPLINES };
const USUAL = { polygon: 'mean-value', mesh: 'mean-value', curves: 'green', lattice: 'splines', sites: 'sibson' };
const OUTSIDE = { extend: CONSTANTS.EXTEND, keep_in_place: CONSTANTS.KEEP_IN_PLACE, nearest_boundary: CONSTANTS.NEAREST_BOUNDARY };

/** Calls make(scope, report), which returns an object's address, and returns that with the report. */
const reported = (engine, make) => engine.scoped(scope => {
  const report = scope.newReport();
  return { at: make(scope, report), report: scope.report(report) };
});

/** Several cages over one figure. */
class Blend {
  constructor(cages) {
    if (!Array.isArray(cages) || cages.length === 0) refuse('cages: an array of cages is needed');
    this.cages = cages.map(cage => objectOf(Cage, cage, 'cages'));
  }
}

export class Coordinates extends Owner {
  #Kind;

  constructor(cage, chosen) {
    super();
    const engine = started(true);
    const cages = cage instanceof Blend ? cage.cages : [objectOf(Cage, cage, 'cage')];
    const { kind = USUAL[cages[0].kind], scalar = 'float32', accuracy = 0, memoryLimit = 0, degree = 1, disk } =
      options(chosen, ['kind', 'scalar', 'accuracy', 'memoryLimit', 'degree', 'disk']);
    this.#Kind = scalarClass(scalar);
    const own = { type: choice(TYPES, kind, 'kind'), scalar: scalarOf(this.#Kind), accuracy: number(accuracy, 'accuracy'),
                  memoryLimit: whole(memoryLimit, 'memoryLimit'), sibsonDegree: whole(degree, 'degree'), ...(disk === undefined ? {} : { disk: numbers(disk, 3, 'disk') }) };
    const { at, report } = reported(engine, (scope, to) => {
      const structs = cages.map(one => one._describe(scope)), how = scope.struct('cageform_coordinates_options', own);
      if (!(cage instanceof Blend)) return engine.make(scope, 'cageform_coordinates_create', [structs[0], how], { report: to });
      return engine.make(scope, 'cageform_coordinates_blend', [scope.array(Uint32Array.from(structs)), structs.length, how], { report: to });
    });
    this._adopt(engine, at, [], []);
    const { handles, vertices, dimension, hasWeightsOutside, hasGradients } =
      described(engine, 'cageform_coordinates_describe', at, 'cageform_coordinates_info');
    Object.assign(this, { kind, scalar, report, handles, vertices, dimension, hasWeightsOutside: hasWeightsOutside !== 0, hasGradients: hasGradients !== 0 });
  }

  static blend(cages, chosen) { return new Coordinates(new Blend(cages), chosen); }

  rest(out) {
    const { _engine: engine, _at: at } = this;
    return written(engine, this.handles, this.dimension, this.#Kind, out, 'out', (scope, to) => engine.call('cageform_coordinates_rest', at, to));
  }

  solve(chosen) {
    const { _engine: engine, _at: at } = this, { progress } = options(chosen, ['progress']), told = progressOf(progress);
    return engine.scoped(scope => {
      const report = scope.newReport();
      engine.check(engine.run('cageform_coordinates_solve', [at, scope.running(told), report], told), scope.report(report));
      return scope.report(report);
    });
  }

  bind(places, chosen) {
    const { _engine: engine, _at: at, dimension } = this;
    const { normals, tangents, outside = 'extend', falloff = 0, leaveLinearPrecision = false, progress } =
      options(chosen, ['normals', 'tangents', 'outside', 'falloff', 'leaveLinearPrecision', 'progress']);
    const given = points(places, 'points', { dimension }), told = progressOf(progress);
    const vectors = [normals === undefined ? null : points(normals, 'normals', { dimension }),
                     tangents === undefined ? null : points(tangents, 'tangents', { dimension: tangentLength(tangents, given, dimension) })];
    const own = { outside: choice(OUTSIDE, outside, 'outside'), leaveLinearPrecision: Boolean(leaveLinearPrecision), falloff: number(falloff, 'falloff') };
    const { at: made, report } = reported(engine, (scope, to) => {
      const view = all => (all === null ? 0 : scope.struct('cageform_points', scope.points(all)));
      return engine.make(scope, 'cageform_bind', [at, view(given), ...vectors.map(view), scope.struct('cageform_bind_options', own), scope.running(told)],
                         { report: to, progress: told });
    });
    return new Binding(MADE, engine, made, { report, points: given.count, handles: this.handles, Kind: this.#Kind });
  }
}

/** Returns how many numbers a tangent has. */
function tangentLength(tangents, { count }, dimension) {
  const length = Array.isArray(tangents?.[0]) || ArrayBuffer.isView(tangents?.[0]) ? tangents[0].length : tangents?.length / Math.max(count, 1);
  return dimension === 3 && length === 4 ? 4 : dimension;
}

const LISTS = { onBoundary: CONSTANTS.LIST_ON_BOUNDARY, outside: CONSTANTS.LIST_OUTSIDE, notFinite: CONSTANTS.LIST_NOT_FINITE,
                unreached: CONSTANTS.LIST_UNREACHED, notRestored: CONSTANTS.LIST_NOT_RESTORED, faded: CONSTANTS.LIST_FADED };
const FORMATS = { smallest: CONSTANTS.FORMAT_SMALLEST, scalar: CONSTANTS.FORMAT_SCALAR, half: CONSTANTS.FORMAT_HALF, int16: CONSTANTS.FORMAT_INT16, int8: CONSTANTS.FORMAT_INT8 };

export class Binding extends Owner {
  #Kind;

  /** Not for callers: Coordinates.bind() makes bindings. */
  constructor(made, engine, at, its) {
    super();
    if (made !== MADE) refuse('a binding is made by Coordinates.bind()');
    this._adopt(engine, at, [], []);
    this.#Kind = its.Kind;
    Object.assign(this, { report: its.report, points: its.points, handles: its.handles, scalar: nameOf(its.Kind) });
    this.figure = this.#newFigure();
  }
  #newFigure() {
    const { _engine: engine, _at: at } = this;
    return new Figure(MADE, engine, engine.scoped(scope => engine.make(scope, 'cageform_binding_figure', [at])), [this._kept]);
  }

  #list(name) {
    const { _engine: engine, _at: at } = this;
    return engine.scoped(scope => {
      const count = scope.struct(4);
      engine.check(engine.call('cageform_binding_list', at, LISTS[name], 0, 0, count));
      const size = engine.view('u32', count, 1)[0], listed = scope.struct(4 * Math.max(size, 1));
      engine.check(engine.call('cageform_binding_list', at, LISTS[name], listed, size, count));
      return engine.view('u32', listed, size).slice();
    });
  }
  get onBoundary() { return this.#list('onBoundary'); }
  get outside() { return this.#list('outside'); }
  get notFinite() { return this.#list('notFinite'); }
  get unreached() { return this.#list('unreached'); }
  get notRestored() { return this.#list('notRestored'); }
  get faded() { return this.#list('faded'); }

  weights(first = 0, count = Math.max(this.points - first, 0)) {
    const { _engine: engine, _at: at } = this;
    whole(first, 'first');
    if (whole(count, 'count') > this.points) throw new CageformError('index_out_of_bounds', `count: there are ${this.points} points`);
    return engine.scoped(scope => {
      const { members, numbers: taken } = scope.output(count, this.handles, this.#Kind);
      engine.check(engine.call('cageform_binding_weights', at, first, count, members.data, members.bytes));
      return taken().slice();
    });
  }

  setLabels(labels) {
    const { _engine: engine, _at: at } = this;
    if (!Array.isArray(labels)) refuse('labels: an array of strings, or null, is needed');
    const texts = labels.map(label => (label === null ? null : string(label, 'labels')));
    engine.scoped(scope => {
      const list = scope.array(Uint32Array.from(texts, text => (text === null ? 0 : scope.string(text))));
      engine.check(engine.call('cageform_binding_set_labels', at, list, texts.length));
    });
    this.figure = this.#newFigure();
  }

  pack(chosen) {
    const { _engine: engine, _at: at } = this;
    const { tolerance = 0, threshold = 0, largest = 0, reach = 0, poses, format = 'smallest', clips = {}, levels = [], progress } =
      options(chosen, ['tolerance', 'threshold', 'largest', 'reach', 'poses', 'format', 'clips', 'levels', 'progress']);
    const own = { tolerance: number(tolerance, 'tolerance'), threshold: number(threshold, 'threshold'), largest: whole(largest, 'largest'),
                  reach: number(reach, 'reach'), format: choice(FORMATS, format, 'format') };
    const where = poses === undefined ? null : points(flattened(poses), 'poses', { dimension: this.figure.dimension }), told = progressOf(progress);
    if (clips === null || typeof clips !== 'object' || !Array.isArray(levels)) refuse('clips: an object of clips, levels: an array of bytes is needed');
    const parts = Object.entries(clips).map(([name, clip]) => {
      if (objectOf(Clip, clip, 'clips').bytes === null) refuse(`clips: ${name} has no bytes, as compileClip() did not make it`);
      return { name, data: clip.bytes };
    });
    const coarse = levels.map(level => bytesOf(level, 'levels'));
    return engine.scoped(scope => {
      const partsAt = list => scope.structs('cageform_part', list.map(({ name, data }) => (
        { name: name === undefined ? 0 : scope.string(name), data: scope.array(data, 64), bytes: data.length })));
      const report = scope.newReport();
      const how = scope.struct('cageform_pack_options', { ...own, ...(where === null ? {} : { poses: scope.points(where) }), clips: partsAt(parts),
                                                          clipCount: parts.length, levels: partsAt(coarse.map(data => ({ data }))), levelCount: coarse.length });
      const made = engine.make(scope, 'cageform_pack', [at, how, scope.running(told)], { report, progress: told });
      return { bytes: taken(engine, scope, made), report: scope.report(report) };
    });
  }
}

/** Returns a copy of a cageform_bytes, which is freed. */
function taken(engine, scope, made) {
  try {
    const data = scope.struct(4), size = scope.struct(4);
    engine.check(engine.call('cageform_bytes_view', made, data, size));
    return engine.view('u8', engine.view('u32', data, 1)[0], engine.view('u32', size, 1)[0]).slice();
  } finally {
    engine.ended || engine.call('cageform_free', made);
  }
}

// ---- clips and pins --------------------------------------------------------------------------------------------------------

const JOINED = { smooth: CONSTANTS.SMOOTH, linear: CONSTANTS.LINEAR, hold: CONSTANTS.HOLD };
const ENDS = { stay: CONSTANTS.STAY, straight_on: CONSTANTS.GO_STRAIGHT_ON, cycle: CONSTANTS.CYCLE, cycle_with_offset: CONSTANTS.CYCLE_WITH_OFFSET,
               ping_pong: CONSTANTS.PING_PONG };

export function compileClip(times, poses, chosen) {
  const engine = started(true);
  const { dimension = 3, tolerance = 0, packTolerance = 0, keys = 'smooth', before = 'stay', after = 'stay', scalar = 'float32', progress } =
    options(chosen, ['dimension', 'tolerance', 'packTolerance', 'keys', 'before', 'after', 'scalar', 'progress']);
  const at = points(times, 'times', { dimension: 1, Kind: Float64Array }), own = {
    tolerance: number(tolerance, 'tolerance'), packTolerance: number(packTolerance, 'packTolerance'), keys: choice(JOINED, keys, 'keys'),
    before: choice(ENDS, before, 'before'), after: choice(ENDS, after, 'after'), scalar: scalarOf(scalarClass(scalar)) };
  const all = points(flattened(poses), 'poses', { dimension: dimensionOf(dimension) }), told = progressOf(progress);
  const { bytes, report } = engine.scoped(scope => {
    const to = scope.newReport();
    const made = engine.make(scope, 'cageform_compile_clip', [scope.array(at.numbers), at.count, scope.struct('cageform_points', scope.points(all)),
                                                              scope.struct('cageform_clip_options', own), scope.running(told)], { report: to, progress: told });
    return { bytes: taken(engine, scope, made), report: scope.report(to) };
  });
  const { memory, at: start } = fileAt(engine, bytes);
  const player = orFree(engine, memory, () => engine.scoped(scope => engine.make(scope, 'cageform_play_bytes', [start, bytes.length, 0])));
  return { clip: new Clip(MADE, engine, player, [], [memory], bytes), report };
}

export class Samples extends Owner {
  constructor(coordinates, chosen) {
    super();
    if (coordinates === MADE) return this.#finish(chosen.engine, chosen.at, null);
    const engine = objectOf(Coordinates, coordinates, 'coordinates')._engine;
    const { samples = 0, rotations = 0, smoothing = 0, progress } = options(chosen, ['samples', 'rotations', 'smoothing', 'progress']);
    const own = { samples: whole(samples, 'samples'), rotations: whole(rotations, 'rotations'), smoothing: number(smoothing, 'smoothing') };
    const told = progressOf(progress);
    const { at, report } = reported(engine, (scope, to) => engine.make(scope, 'cageform_pose_samples', [
      coordinates._at, scope.struct('cageform_samples_options', own), scope.running(told)], { report: to, progress: told }));
    this.#finish(engine, at, report);
  }
  #finish(engine, at, report) {
    this._adopt(engine, at, [], []);
    const { handles, dimension, scalar } = described(engine, 'cageform_samples_describe', at, 'cageform_samples_info');
    Object.assign(this, { handles, dimension, scalar: nameOf(classOf(scalar)), report });
  }

  pack() {
    const { _engine: engine, _at: at } = this;
    return engine.scoped(scope => {
      const report = scope.newReport();
      return taken(engine, scope, engine.make(scope, 'cageform_samples_pack', [at], { report }));
    });
  }
}

export function openSamples(source, chosen) {
  const engine = started(true), bytes = bytesOf(source, 'source'), { skipChecksum = false } = options(chosen, ['skipChecksum']);
  const at = engine.scoped(scope => engine.make(scope, 'cageform_samples_open', [scope.array(bytes, 64), bytes.length, skipChecksum ? 1 : 0]));
  return new Samples(MADE, { engine, at });
}

export class Pins extends Owner {
  #Kind;

  constructor(samples, chosen) {
    super();
    const engine = objectOf(Samples, samples, 'samples')._engine;
    const { pinWeight = 0, hard = false, iterations = 0 } = options(chosen, ['pinWeight', 'hard', 'iterations']);
    const own = { pinWeight: number(pinWeight, 'pinWeight'), hard: Boolean(hard), iterations: whole(iterations, 'iterations') };
    this._adopt(engine, engine.scoped(scope => engine.make(scope, 'cageform_pins_create', [samples._at, scope.struct('cageform_pins_options', own)])), [], []);
    this.#Kind = scalarClass(samples.scalar);
    Object.assign(this, { dimension: samples.dimension, scalar: samples.scalar, handles: samples.handles });
  }

  set(figure, pinned, chosen) {
    const { _engine: engine, _at: at } = this;
    const its = objectOf(Figure, figure, 'figure', engine)._at, listed = indices(pinned, 'points'), { weights } = options(chosen, ['weights']);
    const own = weights === undefined ? null : Float64Array.from(numbers(weights, listed.length, 'weights'));
    engine.scoped(scope => {
      const report = scope.newReport();
      const code = engine.call('cageform_pins_set', at, its, scope.array(listed), listed.length, scope.array(own), report);
      engine.check(code, scope.report(report));
    });
  }

  hold(handles) {
    const { _engine: engine, _at: at } = this, listed = indices(handles, 'handles');
    engine.scoped(scope => {
      const report = scope.newReport(), code = engine.call('cageform_pins_hold', at, scope.array(listed), listed.length, report);
      engine.check(code, scope.report(report));
    });
  }

  solve(targets, pose) {
    const { _engine: engine, _at: at, dimension } = this, Kind = this.#Kind;
    const to = points(targets, 'targets', { dimension, Kind }), from = points(pose, 'pose', { dimension, Kind });
    return engine.scoped(scope => {
      const report = scope.newReport(), moved = scope.points(from);
      const code = engine.call('cageform_pins_solve', at, scope.struct('cageform_points', scope.points(to)), scope.struct('cageform_output', moved), report);
      const its = scope.report(report);
      engine.check(code, its);
      return { pose: new Kind(engine.buffer, moved.data, from.numbers.length).slice(), report: its };
    });
  }
}
