// Compiled clips, and pins.

import { Coordinates, reported, taken } from './bindings.js';
import { dimensionOf } from './cages.js';
import { MADE, Owner, objectOf, scalarOf, started } from './engine.js';
import { Clip, Figure, described, fileAt, orFree } from './figures.js';
import { CHOICES, CONSTANTS } from './layout.js';
import {
  bytesOf,
  choice,
  classOf,
  flattened,
  indices,
  nameOf,
  number,
  numbers,
  options,
  points,
  progressOf,
  scalarClass,
  whole,
} from './numbers.js';

const ENDS = {
  stay: CONSTANTS.STAY,
  straight_on: CONSTANTS.GO_STRAIGHT_ON,
  cycle: CONSTANTS.CYCLE,
  cycle_with_offset: CONSTANTS.CYCLE_WITH_OFFSET,
  ping_pong: CONSTANTS.PING_PONG,
};

export function compileClip(times, poses, chosen) {
  const engine = started(true);
  const {
    dimension = 3,
    tolerance = 0,
    packTolerance = 0,
    keys = 'smooth',
    before = 'stay',
    after = 'stay',
    scalar = 'float32',
    progress,
  } = options(chosen, ['dimension', 'tolerance', 'packTolerance', 'keys', 'before', 'after', 'scalar', 'progress']);
  const at = points(times, 'times', { dimension: 1, Kind: Float64Array }),
    own = {
      tolerance: number(tolerance, 'tolerance'),
      packTolerance: number(packTolerance, 'packTolerance'),
      keys: choice(CHOICES.keys, keys, 'keys'),
      before: choice(ENDS, before, 'before'),
      after: choice(ENDS, after, 'after'),
      scalar: scalarOf(scalarClass(scalar)),
    };
  const all = points(flattened(poses, 'poses'), 'poses', { dimension: dimensionOf(dimension) }),
    told = progressOf(progress);
  const { bytes, report } = engine.scoped(scope => {
    const to = scope.newReport();
    const made = engine.make(
      scope,
      'cageform_compile_clip',
      [
        scope.array(at.numbers),
        at.count,
        scope.struct('cageform_points', scope.points(all)),
        scope.struct('cageform_clip_options', own),
        scope.running(told),
      ],
      { report: to, progress: told },
    );
    return { bytes: taken(engine, scope, made), report: scope.report(to) };
  });
  const { memory, at: start } = fileAt(engine, bytes);
  const player = orFree(engine, memory, () =>
    engine.scoped(scope => engine.make(scope, 'cageform_play_bytes', [start, bytes.length, 0])),
  );
  return { clip: new Clip(MADE, engine, player, [], [memory], bytes), report };
}

export class Samples extends Owner {
  constructor(coordinates, chosen) {
    super();
    if (coordinates === MADE) return this.#finish(chosen.engine, chosen.at, null);
    const engine = objectOf(Coordinates, coordinates, 'coordinates')._engine;
    const {
      samples = 0,
      rotations = 0,
      smoothing = 0,
      progress,
    } = options(chosen, ['samples', 'rotations', 'smoothing', 'progress']);
    const own = {
      samples: whole(samples, 'samples'),
      rotations: whole(rotations, 'rotations'),
      smoothing: number(smoothing, 'smoothing'),
    };
    const told = progressOf(progress);
    const { at, report } = reported(engine, (scope, to) =>
      engine.make(
        scope,
        'cageform_pose_samples',
        [coordinates._at, scope.struct('cageform_samples_options', own), scope.running(told)],
        { report: to, progress: told },
      ),
    );
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
  const engine = started(true),
    bytes = bytesOf(source, 'source'),
    { skipChecksum = false } = options(chosen, ['skipChecksum']);
  const at = engine.scoped(scope =>
    engine.make(scope, 'cageform_samples_open', [scope.array(bytes, 64), bytes.length, skipChecksum ? 1 : 0]),
  );
  return new Samples(MADE, { engine, at });
}

export class Pins extends Owner {
  #Kind;

  constructor(samples, chosen) {
    super();
    const engine = objectOf(Samples, samples, 'samples')._engine;
    const { pinWeight = 0, hard = false, iterations = 0 } = options(chosen, ['pinWeight', 'hard', 'iterations']);
    const own = {
      pinWeight: number(pinWeight, 'pinWeight'),
      hard: Boolean(hard),
      iterations: whole(iterations, 'iterations'),
    };
    this._adopt(
      engine,
      engine.scoped(scope =>
        engine.make(scope, 'cageform_pins_create', [samples._at, scope.struct('cageform_pins_options', own)]),
      ),
      [],
      [],
    );
    this.#Kind = scalarClass(samples.scalar);
    Object.assign(this, { dimension: samples.dimension, scalar: samples.scalar, handles: samples.handles });
  }

  set(figure, pinned, chosen) {
    const { _engine: engine, _at: at } = this;
    const its = objectOf(Figure, figure, 'figure', engine)._at,
      listed = indices(pinned, 'points'),
      { weights } = options(chosen, ['weights']);
    const own = weights === undefined ? null : Float64Array.from(numbers(weights, listed.length, 'weights'));
    engine.scoped(scope => {
      const report = scope.newReport();
      const code = engine.call(
        'cageform_pins_set',
        at,
        its,
        scope.array(listed),
        listed.length,
        scope.array(own),
        report,
      );
      engine.check(code, scope.report(report));
    });
  }

  hold(handles) {
    const { _engine: engine, _at: at } = this,
      listed = indices(handles, 'handles');
    engine.scoped(scope => {
      const report = scope.newReport(),
        code = engine.call('cageform_pins_hold', at, scope.array(listed), listed.length, report);
      engine.check(code, scope.report(report));
    });
  }

  solve(targets, pose) {
    const { _engine: engine, _at: at, dimension } = this,
      Kind = this.#Kind;
    const to = points(targets, 'targets', { dimension, Kind }),
      from = points(pose, 'pose', { dimension, Kind });
    return engine.scoped(scope => {
      const report = scope.newReport(),
        moved = scope.points(from);
      const code = engine.call(
        'cageform_pins_solve',
        at,
        scope.struct('cageform_points', scope.points(to)),
        scope.struct('cageform_output', moved),
        report,
      );
      const its = scope.report(report);
      engine.check(code, its);
      return { pose: new Kind(engine.buffer, moved.data, from.numbers.length).slice(), report: its };
    });
  }
}
