// Coordinates and bindings.

import { Cage } from './cages.js';
import { CageformError, MADE, Owner, objectOf, refuse, scalarOf, started } from './engine.js';
import { Clip, Figure, described, written } from './figures.js';
import { CHOICES, CONSTANTS } from './layout.js';
import {
  bytesOf,
  choice,
  flattened,
  nameOf,
  number,
  numbers,
  options,
  points,
  progressOf,
  scalarClass,
  string,
  whole,
} from './numbers.js';

const USUAL = { polygon: 'mean-value', mesh: 'mean-value', curves: 'curved-green', lattice: 'splines', sites: 'sibson' };
/** Calls make(scope, report), which returns the address of an object. Returns the address and the report. */
export const reported = (engine, make) =>
  engine.scoped(scope => {
    const report = scope.newReport();
    return { at: make(scope, report), report: scope.report(report) };
  });

/** Coordinates of several cages over one figure. */
class Blend {
  constructor(cages) {
    if (!Array.isArray(cages) || cages.length === 0) refuse('cages: an array of cages is needed');
    this.cages = cages.map(cage => objectOf(Cage, cage, 'cages'));
  }
}

export class Coordinates extends Owner {
  static kinds = Object.keys(CHOICES.coordinateType);
  #Kind;

  constructor(cage, chosen) {
    super();
    const engine = started(true);
    const cages = cage instanceof Blend ? cage.cages : [objectOf(Cage, cage, 'cage')];
    const {
      kind = USUAL[cages[0].kind],
      scalar = 'float32',
      accuracy = 0,
      locality = 0,
      memoryLimit = 0,
      disk,
    } = options(chosen, ['kind', 'scalar', 'accuracy', 'locality', 'memoryLimit', 'disk']);
    this.#Kind = scalarClass(scalar);
    const own = {
      type: choice(CHOICES.coordinateType, kind, 'kind'),
      scalar: scalarOf(this.#Kind),
      accuracy: number(accuracy, 'accuracy'),
      locality: number(locality, 'locality'),
      memoryLimit: whole(memoryLimit, 'memoryLimit'),
      ...(disk === undefined ? {} : { disk: numbers(disk, 3, 'disk') }),
    };
    const { at, report } = reported(engine, (scope, to) => {
      const structs = cages.map(one => one._describe(scope)),
        how = scope.struct('cageform_coordinates_options', own);
      if (!(cage instanceof Blend))
        return engine.make(scope, 'cageform_coordinates_create', [structs[0], how], { report: to });
      return engine.make(
        scope,
        'cageform_coordinates_blend',
        [scope.array(Uint32Array.from(structs)), structs.length, how],
        { report: to },
      );
    });
    this._adopt(engine, at, [], []);
    const { handles, vertices, dimension, hasWeightsOutside, hasGradients } = described(
      engine,
      'cageform_coordinates_describe',
      at,
      'cageform_coordinates_info',
    );
    Object.assign(this, {
      kind,
      scalar,
      report,
      handles,
      vertices,
      dimension,
      hasWeightsOutside: hasWeightsOutside !== 0,
      hasGradients: hasGradients !== 0,
    });
  }

  static blend(cages, chosen) {
    return new Coordinates(new Blend(cages), chosen);
  }

  rest(out) {
    const { _engine: engine, _at: at } = this;
    return written(engine, this.handles, this.dimension, this.#Kind, out, 'out', (scope, to) =>
      engine.call('cageform_coordinates_rest', at, to),
    );
  }

  solve(chosen) {
    const { _engine: engine, _at: at } = this,
      { progress } = options(chosen, ['progress']),
      told = progressOf(progress);
    return engine.scoped(scope => {
      const report = scope.newReport();
      engine.check(
        engine.run('cageform_coordinates_solve', [at, scope.running(told), report], told),
        scope.report(report),
      );
      return scope.report(report);
    });
  }

  bind(places, chosen) {
    const { _engine: engine, _at: at, dimension } = this;
    const {
      normals,
      tangents,
      outside = 'extend',
      falloff = 0,
      leaveLinearPrecision = false,
      progress,
    } = options(chosen, ['normals', 'tangents', 'outside', 'falloff', 'leaveLinearPrecision', 'progress']);
    const given = points(places, 'points', { dimension }),
      told = progressOf(progress);
    const vectors = [
      normals === undefined ? null : points(normals, 'normals', { dimension }),
      tangents === undefined
        ? null
        : points(tangents, 'tangents', { dimension: tangentLength(tangents, given, dimension) }),
    ];
    const own = {
      outside: choice(CHOICES.outsidePoints, outside, 'outside'),
      leaveLinearPrecision: Boolean(leaveLinearPrecision),
      falloff: number(falloff, 'falloff'),
    };
    const { at: made, report } = reported(engine, (scope, to) => {
      const view = all => (all === null ? 0 : scope.struct('cageform_points', scope.points(all)));
      return engine.make(
        scope,
        'cageform_bind',
        [at, view(given), ...vectors.map(view), scope.struct('cageform_bind_options', own), scope.running(told)],
        { report: to, progress: told },
      );
    });
    return new Binding(MADE, engine, made, { report, points: given.count, handles: this.handles, Kind: this.#Kind });
  }
}

/** Returns the count of numbers per tangent: 3 or 4. */
function tangentLength(tangents, { count }, dimension) {
  const length =
    Array.isArray(tangents?.[0]) || ArrayBuffer.isView(tangents?.[0])
      ? tangents[0].length
      : tangents?.length / Math.max(count, 1);
  return dimension === 3 && length === 4 ? 4 : dimension;
}

const LISTS = {
  onBoundary: CONSTANTS.LIST_ON_BOUNDARY,
  outside: CONSTANTS.LIST_OUTSIDE,
  notFinite: CONSTANTS.LIST_NOT_FINITE,
  unreached: CONSTANTS.LIST_UNREACHED,
  notRestored: CONSTANTS.LIST_NOT_RESTORED,
  faded: CONSTANTS.LIST_FADED,
};
export class Binding extends Owner {
  #Kind;

  /** Internal: Coordinates.bind() makes bindings. */
  constructor(made, engine, at, its) {
    super();
    if (made !== MADE) refuse('Coordinates.bind() makes bindings');
    this._adopt(engine, at, [], []);
    this.#Kind = its.Kind;
    Object.assign(this, { report: its.report, points: its.points, handles: its.handles, scalar: nameOf(its.Kind) });
    this.figure = this.#newFigure();
  }
  #newFigure() {
    const { _engine: engine, _at: at } = this;
    return new Figure(
      MADE,
      engine,
      engine.scoped(scope => engine.make(scope, 'cageform_binding_figure', [at])),
      [this._kept],
    );
  }

  #list(name) {
    const { _engine: engine, _at: at } = this;
    return engine.scoped(scope => {
      const count = scope.struct(4);
      engine.check(engine.call('cageform_binding_list', at, LISTS[name], 0, 0, count));
      const size = engine.view('u32', count, 1)[0],
        listed = scope.struct(4 * Math.max(size, 1));
      engine.check(engine.call('cageform_binding_list', at, LISTS[name], listed, size, count));
      return engine.view('u32', listed, size).slice();
    });
  }
  get onBoundary() {
    return this.#list('onBoundary');
  }
  get outside() {
    return this.#list('outside');
  }
  get notFinite() {
    return this.#list('notFinite');
  }
  get unreached() {
    return this.#list('unreached');
  }
  get notRestored() {
    return this.#list('notRestored');
  }
  get faded() {
    return this.#list('faded');
  }

  weights(first = 0, count = Math.max(this.points - first, 0)) {
    const { _engine: engine, _at: at } = this;
    whole(first, 'first');
    if (whole(count, 'count') > this.points)
      throw new CageformError('index_out_of_bounds', `count: the binding has ${this.points} points`);
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
    const {
      tolerance = 0,
      threshold = 0,
      largest = 0,
      reach = 0,
      poses,
      format = 'smallest',
      clips = {},
      levels = [],
      origin = [],
      progress,
    } = options(chosen, 'tolerance threshold largest reach poses format clips levels origin progress'.split(' '));
    const own = {
      tolerance: number(tolerance, 'tolerance'),
      threshold: number(threshold, 'threshold'),
      largest: whole(largest, 'largest'),
      reach: number(reach, 'reach'),
      format: choice(CHOICES.weightFormat, format, 'format'),
      origin: Array.from(origin, x => number(x, 'origin')),
    };
    const where = poses === undefined ? null : points(flattened(poses, 'poses'), 'poses', { dimension: this.figure.dimension }),
      told = progressOf(progress);
    if (own.origin.length > 3) refuse('origin: at most three numbers are needed');
    if (clips === null || typeof clips !== 'object' || !Array.isArray(levels))
      refuse('clips: an object of clips is needed; levels: an array of bytes is needed');
    const parts = Object.entries(clips).map(([name, clip]) => {
      if (objectOf(Clip, clip, 'clips').bytes === null)
        refuse(`clips: ${name} is not from compileClip()`);
      return { name, data: clip.bytes };
    });
    const coarse = levels.map(level => bytesOf(level, 'levels'));
    return engine.scoped(scope => {
      const partsAt = list =>
        scope.structs(
          'cageform_part',
          list.map(({ name, data }) => ({
            name: name === undefined ? 0 : scope.string(name),
            data: scope.array(data, 64),
            bytes: data.length,
          })),
        );
      const report = scope.newReport();
      const how = scope.struct('cageform_pack_options', {
        ...own,
        ...(where === null ? {} : { poses: scope.points(where) }),
        clips: partsAt(parts),
        clipCount: parts.length,
        levels: partsAt(coarse.map(data => ({ data }))),
        levelCount: coarse.length,
      });
      const made = engine.make(scope, 'cageform_pack', [at, how, scope.running(told)], { report, progress: told });
      return { bytes: taken(engine, scope, made), report: scope.report(report) };
    });
  }
}

/** Returns a copy of a cageform_bytes, and frees the original. */
export function taken(engine, scope, made) {
  try {
    const data = scope.struct(4),
      size = scope.struct(4);
    engine.check(engine.call('cageform_bytes_view', made, data, size));
    return engine.view('u8', engine.view('u32', data, 1)[0], engine.view('u32', size, 1)[0]).slice();
  } finally {
    engine.ended || engine.call('cageform_free', made);
  }
}
