// The tests of the package, for node and browsers: each has a name and run({ cageform, runtime, file, bytes }). `file(path)`
// returns the text of a file, `bytes(name)` the bytes of a module of the package.

import { hostile } from './hostile.js';
import {
  BOX,
  CROSSED,
  CUBE,
  CURVES,
  QUADS,
  SQUARE,
  TRIANGLES,
  assert,
  ball,
  difference,
  equal,
  randomOf,
  refused,
  sameBits,
  uniformly,
} from './support.js';

/** Returns coordinates of every type on every cage that it supports, with points inside. */
function* everyType({ Cage, Coordinates, CageformError }, random) {
  for (const scalar of ['float32', 'float64']) {
    const Kind = scalar === 'float32' ? Float32Array : Float64Array,
      space = () => uniformly(random, 60, -0.9, 0.9, Kind);
    const cages = [
      [Cage.polygon(SQUARE), () => uniformly(random, 60, 0.5, 3.5, Kind)],
      [
        Cage.polygon(SQUARE.slice(0, 3)),
        () => uniformly(random, 60, 0.4, 0.6, Kind).map((x, n) => (n % 2 ? x : x + 2)),
      ],
      [Cage.mesh(CUBE, TRIANGLES), space],
      [Cage.mesh(CUBE, QUADS, { divisions: 2 }), space],
      [Cage.lattice(BOX), space],
      [Cage.curves(CURVES), () => uniformly(random, 60, 0.5, 3, Kind)],
      [Cage.sites(CUBE), space],
    ];
    for (const kind of Coordinates.kinds) {
      let taken = 0;
      for (const [cage, inside] of cages) {
        try {
          const coordinates = new Coordinates(cage, { kind, scalar }),
            points = inside();
          coordinates.bind(points);
          yield { coordinates, points, Kind };
          ++taken;
        } catch (error) {
          const known = ['cage_kind_not_supported', 'not_a_simplex', 'divisions_not_supported'];
          if (!(error instanceof CageformError && known.includes(error.status))) throw error;
        }
      }
      assert(taken > 0, `${kind} supports none of the cages`);
    }
  }
}

const bytesOf64 = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));

export const tests = [
  {
    name: 'a call before init() throws an error with a message',
    before: true,
    run({ cageform }) {
      refused(cageform, 'invalid_argument', () => new cageform.Coordinates(cageform.Cage.polygon(SQUARE)));
      refused(cageform, 'invalid_argument', () => cageform.open(new Uint8Array(100)));
    },
  },

  {
    name: 'init() rejects invalid modules',
    before: true,
    async run({ cageform, bytes }) {
      for (const wrong of [new Uint8Array(8), 7, {}, new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0])]) {
        const error = await cageform.init(wrong).then(
          () => null,
          given => given,
        );
        assert(error instanceof cageform.CageformError, `init(${wrong}) gave ${error}`);
      }
      const small = await cageform.init(await bytes('runtime.wasm')).then(
        () => null,
        given => given,
      );
      assert(small instanceof cageform.CageformError, 'the run-time module lacks the functions of bind time');
    },
  },

  // The native library with portable settings (no fused multiply-add) has the same arithmetic, except functions of the C
  // library and the iterative harmonic solver.
  {
    name: 'weights, clones, normals and files equal those of the native library',
    async run({ cageform, file }) {
      const { Cage, Coordinates, open } = cageform;
      for (const native of JSON.parse(await file('native.json'))) {
        const [kind, given] = native.cage,
          Kind = native.options.scalar === 'float32' ? Float32Array : Float64Array;
        const coordinates = new Coordinates(Cage[kind](...given), native.options);
        const binding = coordinates.bind(Kind.from(native.points), native.normals ? { normals: native.normals } : {});
        const bound = native.options.kind === 'harmonic' ? 1e-6 : native.options.scalar === 'float32' ? 0 : 1e-15;
        const near = (a, b, what) =>
          assert(difference(a, b) <= bound, `${native.name}: ${what} differs by ${difference(a, b)}`);
        near(binding.weights(), native.weights, 'weights');
        const normals = native.normals !== undefined,
          clone = binding.figure.clone(native.pose, { normals });
        near(clone.points, native.clone, 'clone');
        if (normals) near(clone.normals, native.clonedNormals, 'normals');

        const opened = open(bytesOf64(native.packed)),
          again = opened.clone(native.pose, { normals });
        sameBits(again.points, native.clone, `${native.name}, opened`);
        if (normals) sameBits(again.normals, native.clonedNormals, `${native.name}, opened, normals`);
        const small = open(bytesOf64(native.packedWithClip));
        sameBits(small.clone(native.pose).points, native.smallClone, `${native.name}, fewer weights`);
        sameBits(small.clip('there and back').sample(0.7), native.sample, `${native.name}, clip`);
        for (const own of [binding.figure, binding, coordinates, opened, small]) own.free();
      }
    },
  },

  {
    name: 'weights agree with the reference data to its accuracy',
    async run({ cageform, file }) {
      const { Cage, Coordinates } = cageform;
      const cases = [
        [
          'mean-value',
          5e-11,
          [
            'meanvalue2d_star',
            'meanvalue2d_cat',
            'meanvalue2d_square_square_hole',
            'meanvalue3d_cube',
            'meanvalue3d_l_prism',
          ],
        ],
        ['harmonic', 1e-4, ['harmonic2d_l_shape', 'harmonic2d_star', 'harmonic3d_cube_triangulated']],
        ['wachspress', 1e-13, ['wachspress2d_hexagon', 'wachspress2d_rectangle']],
        ['discrete-harmonic', 1e-13, ['discrete_harmonic2d_hexagon']],
        ['sibson', 1e-12, ['sibson2d_random_points', 'sibson3d_random_points_3d']],
      ];
      for (const [kind, bound, names] of cases) {
        for (const name of names) {
          const {
            cage,
            sites,
            points,
            coordinates: expected,
            dimension,
          } = JSON.parse(await file(`oracle/${name}.json`));
          const made = sites
            ? Cage.sites(sites, { dimension })
            : dimension === 3
              ? Cage.mesh(cage.vertices, cage.faces)
              : Cage.polygon(
                  cage.loops.flat().map(vertex => cage.vertices[vertex]),
                  cage.loops.map(loop => loop.length),
                );
          const order = dimension === 2 && !sites ? cage.loops.flat() : null; // of the vertices
          const coordinates = new Coordinates(made, {
            kind,
            scalar: 'float64',
            ...(kind === 'harmonic' ? { accuracy: bound } : {}),
          });
          const binding = coordinates.bind(points, { leaveLinearPrecision: true }),
            weights = binding.weights();
          let most = 0;
          points.forEach((point, n) => {
            for (let i = 0; i < coordinates.handles; ++i)
              most = Math.max(most, Math.abs(weights[n * coordinates.handles + i] - expected[n][order ? order[i] : i]));
          });
          assert(most <= bound, `${name}: maximum error of a weight ${most}`);
        }
      }
    },
  },

  {
    name: 'a locality lowers the harmonic weight of a far corner',
    run({ cageform: { Cage, Coordinates } }) {
      const far = [0, 20, 40].map(
        locality => new Coordinates(Cage.polygon(SQUARE), { kind: 'harmonic', locality }).bind([1, 1]).weights()[2],
      );
      assert(far[1] < 0.1 * far[0] && far[2] < 0.1 * far[1], `weights ${far}`);
    },
  },

  {
    name: 'every type: weights sum to one, the rest pose is bitwise exact, translations are exact',
    run({ cageform }) {
      const random = randomOf(1);
      for (const { coordinates, points, Kind } of everyType(cageform, random)) {
        const binding = coordinates.bind(points),
          { figure } = binding,
          what = `${coordinates.kind} ${coordinates.scalar}`;
        sameBits(figure.clone(figure.rest()).points, points, what);
        const weights = binding.weights(),
          count = points.length / coordinates.dimension;
        for (let n = 0; n < count; ++n) {
          let sum = 0;
          for (let i = 0; i < coordinates.vertices; ++i) sum += weights[n * coordinates.handles + i];
          assert(Math.abs(sum - 1) <= (Kind === Float32Array ? 2e-5 : 1e-10), `${what}: weights sum to ${sum}`);
        }
        const vertices = coordinates
          .rest()
          .subarray(0, coordinates.vertices * coordinates.dimension)
          .map(x => x + 0.25);
        const moved = figure.clone(figure.poseHandles(vertices)).points;
        const off = difference(
          moved,
          points.map(x => x + 0.25),
        );
        assert(off <= (Kind === Float32Array ? 2e-5 : 1e-10), `${what}: error of a moved point ${off}`);
      }
    },
  },

  {
    name: 'gradients are the transpose of clone',
    run({ cageform }) {
      const random = randomOf(2),
        coordinates = new cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES), { scalar: 'float64' });
      const { figure } = coordinates.bind(uniformly(random, 300, -0.9, 0.9, Float64Array));
      const ofPoints = uniformly(random, 300, -1, 1, Float64Array),
        step = uniformly(random, 24, -1, 1, Float64Array),
        rest = figure.rest();
      const value = t =>
        figure.clone(rest.map((x, i) => x + t * step[i])).points.reduce((sum, x, i) => sum + x * ofPoints[i], 0);
      const slope = figure.gradients(ofPoints).reduce((sum, x, i) => sum + x * step[i], 0);
      assert(Math.abs((value(1) - value(-1)) / 2 - slope) < 1e-11, 'slopes differ');
    },
  },

  {
    name: "all array layouts give bitwise equal results; `out` is written and returned",
    run({ cageform }) {
      const random = randomOf(3),
        flat = uniformly(random, 300, -0.9, 0.9),
        coordinates = new cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES));
      const rows = Array.from({ length: 100 }, (x, n) => Array.from(flat.subarray(3 * n, 3 * n + 3)));
      const pose = coordinates.rest().map(x => x + random.uniform(-0.1, 0.1)),
        expected = coordinates.bind(flat).figure.clone(pose).points;
      for (const points of [Array.from(flat), Float64Array.from(flat), rows, rows.map(row => Float32Array.from(row))]) {
        const { figure } = coordinates.bind(points);
        for (const same of [pose, Array.from(pose), Float64Array.from(pose)])
          sameBits(figure.clone(same).points, expected, 'layout');
        const out = new Float32Array(300),
          normals = coordinates.bind(points, { normals: rows.map(() => [0, 0, 1]) }).figure;
        assert(figure.clone(pose, { out }).points === out, 'out is returned');
        sameBits(out, expected, 'out');
        const own = new Float32Array(300),
          turned = normals.clone(pose, { normals: own });
        assert(turned.normals === own && own.some(x => x !== 0), 'normals are written');
      }
      assert(
        Math.abs(
          Math.hypot(
            ...coordinates
              .bind(flat, { normals: rows.map(() => [0, 0, 1]) })
              .figure.clone(pose, { normals: true })
              .normals.subarray(0, 3),
          ) - 1,
        ) < 1e-5,
        'normals have length 1',
      );
    },
  },

  {
    name: 'the rest pose reproduces normals and tangents',
    run({ cageform }) {
      const coordinates = new cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES));
      const binding = coordinates.bind([0, 0, 0, 0.5, 0.5, 0.5], {
        normals: [0, 0, 1, 0, 1, 0],
        tangents: [1, 0, 0, 1, 0, 0, 1, -1],
      });
      const { points, normals, tangents } = binding.figure.clone(binding.figure.rest(), {
        normals: true,
        tangents: true,
      });
      assert(difference(points, [0, 0, 0, 0.5, 0.5, 0.5]) === 0, 'points');
      assert(
        difference(normals, [0, 0, 1, 0, 1, 0]) < 1e-6 && difference(tangents, [1, 0, 0, 1, 0, 0, 1, -1]) < 1e-6,
        `${normals} ${tangents}`,
      );
      const view = binding.figure.cloneView(binding.figure.rest(), { normals: true, tangents: true });
      sameBits(view.normals, normals, 'views of normals');
      sameBits(view.tangents, tangents, 'views of tangents');
    },
  },

  {
    name: 'a view becomes invalid when memory grows, with length 0, and the next view is correct',
    run({ cageform }) {
      const coordinates = new cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES)),
        random = randomOf(4);
      const { figure } = coordinates.bind(uniformly(random, 3000, -0.9, 0.9)),
        pose = coordinates.rest().map(x => 2 * x);
      const expected = figure.clone(pose).points,
        { points: view } = figure.cloneView(pose);
      sameBits(view, expected, 'view');
      assert(figure.cloneView(pose).points === view, 'the view is the same while memory does not grow');
      const held = [];
      for (let n = 0; view.length > 0 && n < 60; ++n) held.push(coordinates.bind(uniformly(random, 300000, -0.9, 0.9)));
      equal(view.length, 0, 'length of an invalid view');
      refused(cageform, 'dimension_differs', () => coordinates.bind([1]));
      refused(cageform, 'pose_size_differs', () => figure.clone(view));
      sameBits(figure.cloneView(pose).points, expected, 'view after growth');
      sameBits(
        coordinates.bind(figure.cloneView(figure.rest()).points).figure.clone(pose).points,
        expected,
        'a view as input',
      );
      for (const binding of held) {
        binding.figure.free();
        binding.free();
      }
    },
  },

  {
    name: 'keys whose times are equal in float32',
    run({ cageform }) {
      const late = 70000.5,
        times = Array.from({ length: 30 }, (x, k) => late + k / 500),
        poses = times.map((time, k) => [k, 0, 0, -k]);
      for (const scalar of ['float32', 'float64']) {
        const { clip } = cageform.compileClip(times, poses, { dimension: 2, scalar, keys: 'linear' });
        assert(clip.begin === late && Math.abs(clip.end - times[29]) < 1e-7, `${clip.begin} to ${clip.end}`);
        times.forEach((time, k) => assert(difference(clip.sample(time), poses[k]) < 1e-3, `${scalar}, key ${k}`));
      }
    },
  },

  {
    name: 'a figure file: labels, clips, levels',
    run({ cageform }) {
      const random = randomOf(5),
        coordinates = new cageform.Coordinates(cageform.Cage.polygon(SQUARE)),
        points = uniformly(random, 400, 0.5, 3.5);
      const binding = coordinates.bind(points),
        { figure: before } = binding;
      binding.setLabels(['foot', null, 'head', '']);
      binding.setLabels(['Fuß', null, 'head', '']);
      sameBits(before.clone(before.rest()).points, points, 'a figure from before setLabels()');
      const rest = Array.from(coordinates.rest()),
        taller = rest.map((x, i) => (i % 2 ? 1.5 * x : x));
      const { clip, report } = cageform.compileClip([0, 1, 2], [rest, taller, rest], { dimension: 2, after: 'cycle' });
      assert(report.curveError < 0.01 && clip.begin === 0 && clip.end === 2 && clip.vertices === 4, String(report));
      const coarse = coordinates.bind(points.slice(0, 100)).pack();
      const { bytes, report: packed } = binding.pack({
        tolerance: 1e-3,
        clips: { wave: clip },
        levels: [coarse.bytes],
        origin: [5e5, 4.6e6 + 0.25],
      });
      assert(packed.bytes === bytes.length && packed.distance <= 1e-3, String(packed));
      const figure = cageform.open(bytes);
      equal(figure.labels().join(), 'Fuß,,head,', 'labels');
      equal(`${figure.clips} ${figure.levels} ${figure.handles} ${figure.points}`, '1 1 4 200', 'counts');
      equal(figure.origin.join(), '500000,4600000.25', 'origin');
      const wave = figure.clip('wave'),
        by = figure.clip(0);
      equal(wave.name, 'wave', 'name');
      assert(difference(wave.sample(1), taller) < 0.01 && difference(by.sample(3), taller) < 0.01, 'samples');
      const out = new Float32Array(8);
      assert(wave.sample(0.3, out) === out, 'out');
      equal(figure.level(1).points, 50, 'points of a level');
      refused(cageform, 'index_out_of_bounds', () => figure.clip('walk'));
      const error = refused(cageform, 'index_out_of_bounds', () => figure.clip(7));
      assert(error.culprit === null, 'no culprit');
      for (let n = 0; n < 400; ++n) {
        // corrupt files
        const spoilt = bytes.slice(0, n % 2 ? undefined : random.pick(bytes.length));
        if (n % 2) spoilt[random.pick(spoilt.length)] ^= 1 << random.pick(8);
        try {
          cageform.open(spoilt).clone(rest);
        } catch (fault) {
          assert(
            fault instanceof cageform.CageformError && !['failed', 'invalid_argument'].includes(fault.status),
            `${n}: ${fault.stack}`,
          );
          continue;
        }
        assert(spoilt.length === bytes.length, `${n}: a truncated file was opened`);
      }
      const trusted = bytes.slice(); // without the checksum, errors must not trap
      for (let n = 0; n < 400; ++n) {
        trusted.set(bytes);
        for (let k = 0; k < 4; ++k) trusted[random.pick(trusted.length)] = random.pick(256);
        try {
          cageform.open(trusted, { skipChecksum: true }).clone(rest);
        } catch (fault) {
          assert(fault instanceof cageform.CageformError && fault.status !== 'failed', `${n}: ${fault.stack}`);
        }
      }
    },
  },

  {
    name: 'pins reach their targets, with packed samples',
    run({ cageform }) {
      const coordinates = new cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES));
      const samples = new cageform.Samples(coordinates, { samples: 2000 }),
        bytes = samples.pack(),
        opened = cageform.openSamples(bytes);
      sameBits(opened.pack(), bytes, 'packed again');
      const { figure } = coordinates.bind([-0.5, 0, 0, 0.5, 0, 0, 0, 0.5, 0.3]),
        targets = [-0.6, 0.1, 0, 0.6, 0, 0.1, 0, 0.5, 0.4];
      const poses = [samples, opened].map(its => {
        const pins = new cageform.Pins(its);
        refused(cageform, 'pins_do_not_match', () => pins.solve([0, 0, 0], figure.rest()));
        pins.set(figure, [0, 1, 2]);
        let step = { pose: figure.rest() },
          frames = 0;
        do step = pins.solve(targets, step.pose);
        while (!step.report.settled && ++frames < 500);
        assert(step.report.settled && step.report.miss < 0.01, String(step.report));
        assert(difference(figure.clone(step.pose).points, targets) < 0.01, 'targets');
        const wrong = refused(cageform, 'index_out_of_range', () => pins.set(figure, [0, 77]));
        equal(wrong.culprit, 1, 'culprit');
        return step.pose;
      });
      sameBits(poses[0], poses[1], 'poses');
    },
  },

  {
    name: 'makeCage: encloses the figure, reports progress, can be cancelled, rethrows exceptions',
    run({ cageform }) {
      const told = [],
        ends = [
          [0, 0],
          [3, 0],
          [3, 2],
        ],
        joined = [
          [0, 1],
          [1, 2],
        ],
        radii = [0.1, 0.2];
      const flat = cageform.makeCage(ends, joined, {
        dimension: 2,
        radii,
        vertices: 20,
        progress: done => {
          told.push(done);
        },
      });
      equal(
        `${flat.cage.kind} ${flat.cage.dimension} ${flat.cage.vertices.length}`,
        `polygon 2 ${2 * flat.report.vertices}`,
        'cage',
      );
      assert(flat.report.clearance > 0, String(flat.report));
      assert(
        told.length > 1 && told.every((x, i) => x >= 0 && x <= 1 && (i === 0 || x >= told[i - 1])),
        'progress ascends',
      );
      equal(new cageform.Coordinates(flat.cage).bind(ends).outside.length, 0, 'points outside');
      const { cage, report } = cageform.makeCage(CUBE, TRIANGLES, { shape: 'box' });
      assert(
        cage.kind === 'mesh' && cage.vertices.length === 3 * report.vertices && report.clearance > 0,
        String(report),
      );
      equal(cageform.check(cage).length, 0, 'faults');
      equal(new cageform.Coordinates(cage).bind(CUBE).outside.length, 0, 'points outside');
      refused(cageform, 'cancelled', () => cageform.makeCage(CUBE, TRIANGLES, { progress: () => false }));
      const own = new Error('mine');
      let caught = null;
      try {
        cageform.makeCage(CUBE, TRIANGLES, {
          progress() {
            throw own;
          },
        });
      } catch (error) {
        caught = error;
      }
      assert(caught === own, 'the exception is that of the callback');
      const inside = refused(cageform, 'invalid_argument', () =>
        cageform.makeCage(CUBE, TRIANGLES, {
          progress() {
            cageform.check(cage);
          },
        }),
      );
      assert(inside.message.includes('progress()'), inside.message);
    },
  },

  {
    name: 'faults of cages are named',
    run({ cageform }) {
      const [fault] = cageform.check(cageform.Cage.polygon(CROSSED));
      equal(String(fault), 'edges cross or touch (edge 0, edge 2)', 'fault');
      const error = refused(
        cageform,
        'cage_self_crossing',
        () => new cageform.Coordinates(cageform.Cage.polygon(CROSSED)),
      );
      assert(error.report.fault.a.kind === 'edge' && error.message.includes('edge 0'), error.message);
      equal(cageform.check(cageform.Cage.polygon(SQUARE)).length, 0, 'no fault');
    },
  },

  {
    name: 'cells inside a cage are handles; several cages are blended',
    run({ cageform }) {
      const { Cage, Coordinates } = cageform;
      const inside = new Coordinates(
        Cage.polygon([...SQUARE, [2, 2]], null, { cellVertices: 1, bones: [{ a: 4, radius: 0.5 }] }),
        { kind: 'harmonic' },
      );
      const { figure } = inside.bind([2.1, 2.2, 0.5, 0.5]),
        pose = figure.rest(),
        before = figure.clone(pose).points;
      pose[8] += 0.25;
      const after = figure.clone(pose).points;
      equal(inside.handles, 5, 'handles');
      assert(Math.abs(after[0] - before[0] - 0.25) < 1e-5 && after[2] - before[2] < 0.1, `${before} ${after}`);
      refused(
        cageform,
        'interior_cells_not_supported',
        () =>
          new Coordinates(
            Cage.polygon([...SQUARE, [2, 2]], null, { cellVertices: 1, bones: [{ a: 4, radius: 0.5 }] }),
            { kind: 'mean-value' },
          ),
      );
      refused(cageform, 'invalid_argument', () => Cage.polygon(SQUARE, null, { bones: [null] }));
      const two = Coordinates.blend([Cage.polygon(SQUARE), Cage.polygon(SQUARE.map(([x, y]) => [x + 3, y]))]),
        points = Float32Array.of(1, 1, 3.5, 2, 6, 3);
      const bound = two.bind(points),
        moved = two.rest().map((x, i) => x + (i % 2));
      equal(two.handles, 8, 'handles of both');
      assert(
        difference(
          bound.figure.clone(moved).points,
          points.map((x, i) => x + (i % 2)),
        ) < 1e-5,
        'both cages move',
      );
      equal(
        refused(cageform, 'cage_self_crossing', () => Coordinates.blend([Cage.polygon(SQUARE), Cage.polygon(CROSSED)]))
          .culprit,
        1,
        'the invalid cage',
      );
      refused(cageform, 'invalid_argument', () => Coordinates.blend([]));
      refused(cageform, 'argument_null', () => Coordinates.blend([null]));
    },
  },

  {
    name: 'invalid points are listed and do not move',
    run({ cageform }) {
      const coordinates = new cageform.Coordinates(cageform.Cage.polygon(SQUARE));
      const binding = coordinates.bind([NaN, 1, 9, 9, 1, 1], { outside: 'keep-in-place' });
      equal(`${binding.notFinite} ${binding.outside}`, '0 1', 'lists');
      assert(Number.isNaN(binding.figure.clone(binding.figure.rest()).points[0]), 'a point that is not finite does not change');
    },
  },

  {
    name: 'wrong input of every kind is a CageformError',
    run({ cageform }) {
      const { Cage, Coordinates, Samples, Pins, open, openSamples, check, makeCage, compileClip } = cageform;
      const plane = new Coordinates(Cage.polygon(SQUARE)),
        space = new Coordinates(Cage.mesh(CUBE, TRIANGLES));
      const { figure } = plane.bind([1, 1, 2, 2]),
        other = space.bind([0, 0, 0]),
        freed = plane.bind([1, 1]);
      const wrong = [];
      const no = (status, call) => {
        try {
          refused(cageform, status, call);
        } catch (error) {
          wrong.push(error.message);
        }
      };
      freed.figure.free();
      freed.free();
      freed.free(); // the second call has no effect
      no('object_of_another_kind', () => freed.weights());
      no('object_of_another_kind', () => freed.figure.clone(SQUARE));
      no('pose_size_differs', () => figure.clone([[0, 0]]));
      no('pose_not_finite', () =>
        figure.clone([
          [0, 0],
          [1, NaN],
          [2, 2],
          [3, Infinity],
        ]),
      );
      no('dimension_differs', () => figure.clone([1, 2, 3]));
      no('dimension_differs', () => figure.clone(CUBE));
      no('argument_null', () => figure.clone(null));
      no('argument_null', () => figure.clone());
      no('invalid_argument', () => figure.clone('pose'));
      no('invalid_argument', () => figure.clone([1n, 2n]));
      no('invalid_argument', () => figure.clone(new BigInt64Array(8)));
      no('invalid_argument', () => figure.clone(['a', 'b']));
      no('invalid_argument', () => figure.clone([1, {}, Symbol('x'), null]));
      no('output_too_small', () => figure.clone(SQUARE, { out: new Float32Array(3) }));
      no('scalar_differs', () => figure.clone(SQUARE, { out: new Float64Array(4) }));
      no('invalid_argument', () => figure.clone(SQUARE, { outt: new Float32Array(4) }));
      no('invalid_argument', () => figure.clone(SQUARE, { tangents: true }));
      no('vectors_missing', () => figure.clone(SQUARE, { normals: true }));
      no('vectors_missing', () => other.figure.clone(CUBE, { tangents: true }));
      no('index_out_of_bounds', () => figure.level(3));
      no('invalid_argument', () => figure.level(-1));
      no('invalid_argument', () => figure.level(1.5));
      no('invalid_argument', () => figure.clip({}));
      no('index_out_of_bounds', () => figure.clip('none'));
      no('argument_null', () => new Coordinates());
      no('object_of_another_kind', () => new Coordinates(figure));
      no('choice_unknown', () => new Coordinates(Cage.polygon(SQUARE), { kind: 'mean value' }));
      no('choice_unknown', () => new Coordinates(Cage.polygon(SQUARE), { scalar: 'int8' }));
      no('choice_unknown', () => new Coordinates(Cage.polygon(SQUARE), { kind: 'toString' }));
      no('cage_kind_not_supported', () => new Coordinates(Cage.sites(CUBE), { kind: 'harmonic' }));
      no('accuracy_not_supported', () =>
        new Coordinates(Cage.polygon(SQUARE), { kind: 'harmonic', accuracy: 3 }).bind([1, 1]),
      );
      no('accuracy_not_supported', () =>
        new Coordinates(Cage.polygon(SQUARE), { kind: 'harmonic', accuracy: NaN }).bind([1, 1]),
      );
      no('locality_not_supported', () =>
        new Coordinates(Cage.polygon(SQUARE), { kind: 'harmonic', locality: 41 }).bind([1, 1]),
      );
      no('invalid_argument', () => new Coordinates(Cage.polygon(SQUARE), { accuracy: '3' }));
      no('invalid_argument', () => new Coordinates(Cage.polygon(SQUARE), null));
      no('too_few_vertices', () => new Coordinates(Cage.polygon([])));
      no(
        'vertex_not_finite',
        () =>
          new Coordinates(
            Cage.polygon([
              [0, 0],
              [1, NaN],
              [2, 2],
            ]),
          ),
      );
      no('face_without_vertex', () => new Coordinates(Cage.mesh(CUBE, [[0, 1, 99]])));
      no('counts_do_not_match', () => new Coordinates(Cage.mesh(CUBE, [0, 1, 2, 3])));
      no(
        'cage_has_no_area',
        () =>
          new Coordinates(
            Cage.polygon([
              [0, 0],
              [1, 1],
              [2, 2],
            ]),
          ),
      );
      no('invalid_argument', () => Cage.mesh(CUBE, [[0, 1, -1]]));
      no('invalid_argument', () => Cage.mesh(CUBE, [[0, 1, 1.5]]));
      no('invalid_argument', () => new Cage({ kind: 'round' }));
      no('invalid_argument', () => new Cage());
      no('invalid_argument', () =>
        Cage.lattice({
          origin: [0],
          axes: [
            [1, 0],
            [0, 1],
          ],
        }),
      );
      no('invalid_argument', () => Cage.lattice());
      no('dimension_differs', () => Cage.sites(CUBE, { dimension: 7 }));
      no('dimension_differs', () => plane.bind(CUBE));
      no('vectors_do_not_match', () => space.bind(CUBE, { normals: [[0, 0, 1]] }));
      no('invalid_argument', () => plane.bind([1, 1], { progress: 3 }));
      no('choice_unknown', () => plane.bind([1, 1], { outside: 'no' }));
      no('falloff_not_supported', () => plane.bind([1, 1], { falloff: -1 }));
      no('labels_do_not_match', () => plane.bind([1, 1]).setLabels(['a']));
      no('invalid_argument', () => plane.bind([1, 1]).setLabels([1, 2, 3, 4]));
      no('index_out_of_bounds', () => plane.bind([1, 1]).weights(0, 7));
      no('index_out_of_bounds', () => plane.bind([1, 1]).weights(1, 1));
      no('choice_unknown', () => plane.bind([1, 1]).pack({ format: 'small' }));
      no('object_of_another_kind', () => plane.bind([1, 1]).pack({ clips: { a: figure } }));
      no('argument_null', () => plane.bind([1, 1]).pack({ levels: [null] }));
      no('argument_null', () => open());
      no('invalid_argument', () => open('a file'));
      no('not_a_figure', () => open(new Uint8Array(0)));
      no('not_a_figure', () => open(new Uint8Array(1000)));
      no('not_pose_samples', () => openSamples(new Uint8Array(1000)));
      no('object_of_another_kind', () => check(SQUARE));
      no('argument_null', () => check());
      no('figure_empty', () => makeCage([], []));
      no('argument_null', () => makeCage(CUBE));
      no('invalid_argument', () => makeCage(CUBE, TRIANGLES, { vertices: -3 }));
      no('index_out_of_range', () => makeCage(CUBE, [[0, 1, 88]]));
      no('invalid_argument', () =>
        makeCage(
          [
            [0, 0],
            [1, 1],
          ],
          [[0, 1]],
          { dimension: 2, radii: [1, 2] },
        ),
      );
      no('keys_not_ascending', () => compileClip([1, 0], [CUBE, CUBE]));
      no('counts_do_not_match', () => compileClip([0, 1, 2], [CUBE, CUBE]));
      const square = [
        [0, 0],
        [1, 0],
        [1, 1],
      ];
      for (const [words, poses] of [
        ['poses[2] has 4 numbers, poses[0] 6', [square, square.flat(), [0, 0, 1, 1], square]],
        ['poses[1] has 8 numbers, poses[0] 6', [square, [...square, [0, 1]]]],
        ['poses[1][2] has 3 numbers, poses[1][0] 2', [square, [[0, 0], [1, 0], [1, 1, 1]]]],
        ['poses[3] has 1 number, poses[0] 6', [square, square, square, 7]],
      ]) {
        const times = poses.map((row, k) => k);
        const { message } = refused(cageform, 'counts_do_not_match', () => compileClip(times, poses, { dimension: 2 }));
        equal(message.split(': ').pop(), words, 'a row of a different length');
      }
      no('object_of_another_kind', () => new Samples(figure));
      no('object_of_another_kind', () => new Pins(space));
      no('invalid_argument', () => new cageform.Figure());
      no('invalid_argument', () => new cageform.Clip());
      const pins = new Pins(new Samples(space, { samples: 500 }));
      no('bindings_differ', () => pins.set(figure, [0]));
      no('object_of_another_kind', () => pins.set(space, [0]));
      no('invalid_argument', () => pins.set(other.figure, [0], { weights: [1, 2] }));
      no('index_out_of_range', () => pins.hold([99]));
      no('object_of_another_kind', () => Coordinates.prototype.rest.call(freed.figure));
      equal(wrong.join('\n'), '', 'refusals');
    },
  },

  {
    name: 'knots of a lattice: uniform knots change nothing, others move the points along their axis',
    run({ cageform }) {
      const { Cage, Coordinates } = cageform,
        rest = knots => new Coordinates(Cage.lattice({ ...BOX, points: 5, knots }), { scalar: 'float64' }).rest();
      const knots = inner => [0, 0, 0, 0, inner, 1, 1, 1, 1],
        plain = rest(),
        moved = rest([undefined, knots(0.3)]);
      sameBits(rest([knots(0.5), knots(0.5), knots(0.5)]), plain, 'uniform knots');
      plain.forEach((x, n) => equal(moved[n] !== x, n % 3 === 1 && Math.abs(x) < 1, `number ${n} has moved`));
      refused(cageform, 'lattice_knots_not_supported', () => rest([[0, 1]]));
    },
  },

  {
    name: 'running out of memory is a status, and the memory is freed',
    run({ cageform }) {
      const { Cage, Coordinates } = cageform,
        space = new Coordinates(Cage.mesh(CUBE, TRIANGLES));
      const many = new Float32Array(3e7),
        fine = space.bind(CUBE).figure,
        pose = fine.rest(),
        expected = fine.clone(pose).points;
      // 10^7 points of 3,375 handles take 135 GB.
      const lattice = new Coordinates(Cage.lattice({ ...BOX, points: 15 }));
      let grown = null;
      for (let n = 0; n < 12; ++n) {
        const error = refused(cageform, 'out_of_memory', () => lattice.bind(many));
        assert(error.report.status === 'out_of_memory' && error.culprit === null, 'report');
        const size = fine.cloneView(pose).points.buffer.byteLength;
        grown ??= size;
        equal(size, grown, 'memory after the first call');
      }
      refused(cageform, 'too_many_handles', () => new Coordinates(Cage.lattice({ ...BOX, points: 2000 })));
      sameBits(fine.clone(pose).points, expected, 'clone');
      lattice.free();
    },
  },

  {
    name: 'free() in any order; a figure keeps the objects that it uses',
    run({ cageform }) {
      const random = randomOf(6),
        points = uniformly(random, 30000, -0.9, 0.9);
      let size = null;
      for (let n = 0; n < 60; ++n) {
        const coordinates = new cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES)),
          binding = coordinates.bind(points),
          { figure } = binding;
        const opened = cageform.open(binding.pack().bytes),
          pose = figure.rest();
        const all = [coordinates, binding, figure, opened];
        for (let k = all.length; k > 1; --k) all.push(...all.splice(random.pick(k), 1));
        for (const object of all.slice(0, 2)) object.free();
        for (const own of all.slice(2)) {
          if (own instanceof cageform.Figure) sameBits(own.clone(pose).points, points, 'after other objects were freed');
        }
        if (n > 2)
          size ??=
            all.filter(own => own instanceof cageform.Figure && all.indexOf(own) >= 2)[0]?.cloneView(pose).points.buffer
              .byteLength ?? null;
        for (const object of all) object.free();
      }
      const { figure } = new cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES)).bind(points);
      assert(figure.cloneView(figure.rest()).points.buffer.byteLength === size, 'memory grows although all objects are freed');
    },
  },

  { name: '10,000 hostile calls', run: context => hostile(context, 10000, 7) },

  {
    name: 'the run-time module opens, clones and plays with bitwise equal results',
    async run({ cageform, runtime, file }) {
      await runtime.init();
      for (const native of JSON.parse(await file('native.json'))) {
        const figure = runtime.open(bytesOf64(native.packedWithClip));
        sameBits(figure.clone(native.pose).points, native.smallClone, native.name);
        sameBits(figure.clip('there and back').sample(0.7), native.sample, native.name);
      }
      equal(runtime.version, cageform.version, 'versions');
    },
  },

  {
    name: 'a wrap lays a figure on another, and its coat follows',
    run({ cageform }) {
      const { Cage, Coordinates, wrap } = cageform;
      const { vertices: unit, faces } = ball(),
        scaled = size => unit.map(vertex => vertex.map((x, k) => x * size[k]));
      const source = scaled([0.2, 0.2, 1]),
        target = scaled([0.15, 0.25, 1.2]),
        coat = scaled([0.22, 0.22, 1.1]),
        steps = [];
      const landmarks = [[source[0], target[0]]];
      const map = wrap(source, faces, target, faces, {
        landmarks,
        follow: coat,
        finest: 12,
        progress: done => void steps.push(done),
      });
      const { report } = map;
      assert(report.toTargetUpper < 0.01 && report.start > 0.01 && report.miss < 0.02, String(report));
      assert(report.status === 'ok' && report.ended === 'noise' && steps.at(-1) === 1, 'report');
      const { points: moved, jacobians } = map.move(coat, { jacobians: true });
      const isOutside = (x, n) => n % 3 > 0 || Math.hypot(x / 0.15, moved[n + 1] / 0.25, moved[n + 2] / 1.2) > 1;
      assert(moved.length === 3 * coat.length && moved.every(isOutside), 'the coat stays outside');
      const aside = map.move(coat.map(([x, y, z]) => [x, y + 1e-6, z])).points;
      assert(
        jacobians.every(
          (slope, n) =>
            n % 9 < 3 ||
            n % 9 > 5 ||
            Math.abs((aside[3 * Math.floor(n / 9) + (n % 3)] - moved[3 * Math.floor(n / 9) + (n % 3)]) / 1e-6 - slope) <
              1e-4,
        ),
        'Jacobians',
      );
      const placed = coat.map(p =>
        [0, 1, 2].map(j => p[0] * map.first[j] + p[1] * map.first[3 + j] + p[2] * map.first[6 + j] + map.first[9 + j]),
      );
      const lattice = new Coordinates(map.lattice, { scalar: 'float64' }).bind(placed).figure;
      assert(difference(lattice.clone(map.latticePose).points, moved) < 1e-9, 'the lattice is the map');
      assert(
        map.pose.length === 0 && map.move(Float32Array.from(coat.flat())).points instanceof Float32Array,
        'arrays',
      );

      const coordinates = new Coordinates(Cage.mesh(CUBE, TRIANGLES));
      const by = wrap(source, faces, target, faces, { coordinates, finest: 6 });
      const bound = coordinates.bind(source);
      coordinates.free();
      assert(by.lattice === null && by.report.toTargetUpper < 0.05, String(by.report));
      assert(difference(bound.figure.clone(by.pose).points, by.move(source).points) < 1e-5, 'the pose is the map');

      const thick = scaled([0.3, 0.3, 1]),
        insideOut = faces.map(([a, b, c]) => [b, a, c]);
      const bad = wrap(thick, faces, thick, insideOut, { finest: 6, leastStiffness: 1e-2 });
      assert(bad.report.status === 'fit_not_reached' && bad.report.unmatchedSource > 0.5, String(bad.report));
      const error = refused(cageform, 'figure_not_finite', () =>
        wrap(
          source,
          faces,
          target.map((vertex, n) => (n === 5 ? [0, NaN, 0] : vertex)),
          faces,
        ),
      );
      assert(error.culprit === 5 && error.report.ofTarget && error.message.includes('target vertex 5'), error.message);
      refused(cageform, 'figure_empty', () => wrap(source, faces, target, []));
      refused(cageform, 'cancelled', () => wrap(source, faces, target, faces, { progress: () => false }));
      refused(cageform, 'invalid_argument', () => wrap(source, faces, target, faces, { landmarks: [[[0, 0, 0]]] }));
      refused(cageform, 'invalid_argument', () => wrap(source, faces, target, faces, { finest: 0 }));
      refused(cageform, 'weights_not_positive', () => wrap(source, faces, target, faces, { landmarks, weights: [-1] }));
      refused(cageform, 'object_of_another_kind', () => wrap(source, faces, target, faces, { coordinates: bound }));
    },
  },
];
