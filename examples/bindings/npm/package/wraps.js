// Maps of space that lay one figure on another.

import { Coordinates, reported } from './bindings.js';
import { Cage } from './cages.js';
import { MADE, Owner, objectOf, refuse, started } from './engine.js';
import { described } from './figures.js';
import { classOf, indices, number, numbers, options, points, progressOf, whole } from './numbers.js';

const OPTIONS = (
  'landmarks weights follow coordinates align otherPose finest refineContacts leastStiffness floor residual ' +
  'samples handles progress'
).split(' ');

export class Wrap extends Owner {
  /** Internal: wrap() makes wraps. */
  constructor(made, engine, at, report) {
    super();
    if (made !== MADE) refuse('wrap() makes wraps');
    this._adopt(engine, at, [], []);
    const { first, pose, lattice, latticePose } = described(engine, 'cageform_wrap_describe', at, 'cageform_wrap_info');
    const copied = ({ data, count, scalar }) => new (classOf(scalar))(engine.buffer, data, 3 * count).slice();
    Object.assign(this, {
      report,
      first,
      pose: copied(pose),
      lattice: lattice === 0 ? null : latticeOf(engine, lattice),
      latticePose: copied(latticePose),
    });
  }

  move(given, chosen) {
    const { _engine: engine, _at: at } = this,
      { jacobians = false } = options(chosen, ['jacobians']),
      from = points(given, 'points', { dimension: 3 });
    return engine.scoped(scope => {
      const Kind = from.numbers.constructor,
        to = scope.output(from.count, 3, Kind),
        turns = scope.output(jacobians ? from.count : 0, 9, Kind);
      const code = engine.call(
        'cageform_wrap_move',
        at,
        scope.struct('cageform_points', scope.points(from)),
        scope.struct('cageform_output', to.members),
        jacobians ? scope.struct('cageform_output', turns.members) : 0,
        0,
      );
      engine.check(code);
      return { points: to.numbers().slice(), jacobians: jacobians ? turns.numbers().slice() : undefined };
    });
  }
}

function latticeOf(engine, at) {
  const {
    points: along,
    degree,
    origin,
    axes,
    knots,
    knotCounts,
  } = engine.scoped(scope => scope.read('cageform_cage', at));
  return Cage.lattice({
    points: along,
    degree,
    origin,
    axes: [0, 3, 6].map(k => axes.slice(k, k + 3)),
    knots: knots.map((from, k) => engine.view('f64', from, knotCounts[k]).slice()),
  });
}

/** Returns the members of landmarks, from an array of [from, to]. */
function landmarksOf(pairs, weights) {
  if (!Array.isArray(pairs) || pairs.some(pair => pair?.length !== 2))
    refuse('landmarks: an array of [from, to] is needed');
  const own = weights === undefined ? pairs.map(() => 1) : numbers(weights, pairs.length, 'weights');
  if (own.includes(0)) refuse('weights: positive numbers are needed');
  return pairs.map(([from, to], n) => ({
    source: numbers(from, 3, 'landmarks'),
    target: numbers(to, 3, 'landmarks'),
    weight: own[n],
  }));
}

export function wrap(source, sourceFaces, target, targetFaces, chosen) {
  const engine = started(true);
  const {
    landmarks = [],
    weights,
    follow = [],
    coordinates,
    align = true,
    otherPose = false,
    finest = 24,
    refineContacts = false,
    leastStiffness = 0,
    floor = 0,
    residual = 0,
    samples = 0,
    handles = 0,
    progress,
  } = options(chosen, OPTIONS);
  const meshes = [
    [points(source, 'source', { dimension: 3 }), indices(sourceFaces, 'sourceFaces')],
    [points(target, 'target', { dimension: 3 }), indices(targetFaces, 'targetFaces')],
  ];
  const marks = landmarksOf(landmarks, weights),
    followers = points(follow, 'follow', { dimension: 3 }),
    told = progressOf(progress),
    cage = coordinates === undefined ? 0 : objectOf(Coordinates, coordinates, 'coordinates', engine)._at;
  const own = {
    landmarkCount: marks.length,
    keepPlace: !align,
    otherPose: Boolean(otherPose),
    refineContacts: Boolean(refineContacts),
    finest: whole(finest, 'finest', 6),
    leastStiffness: number(leastStiffness, 'leastStiffness'),
    floor: number(floor, 'floor'),
    residual: number(residual, 'residual'),
    samples: whole(samples, 'samples'),
    handles: whole(handles, 'handles'),
  };
  const { at, report } = reported(engine, (scope, to) => {
    const [from, onto] = meshes.map(([vertices, corners]) =>
      scope.struct('cageform_drawing', {
        points: scope.points(vertices),
        indices: scope.array(corners),
        indexCount: corners.length,
      }),
    );
    const how = scope.struct('cageform_wrap_options', {
      ...own,
      landmarks: scope.structs('cageform_landmark', marks),
      follow: scope.points(followers),
    });
    return engine.make(scope, 'cageform_fit_wrap', [cage, from, onto, how, scope.running(told)], {
      report: to,
      progress: told,
      accepts: engine.codes.fit_not_reached,
    });
  });
  return new Wrap(MADE, engine, at, report);
}
