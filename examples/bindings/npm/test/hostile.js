// Hostile calls of the package.

import { CUBE, QUADS, BOX, SQUARE, TRIANGLES, assert, randomOf, uniformly } from './support.js';

/** Calls functions with random arguments. All exceptions must be CageformErrors after which the library still works. */
export function hostile({ cageform }, count, seed) {
  const { Cage, Coordinates, Samples, Pins, CageformError } = cageform,
    random = randomOf(seed),
    { pick } = random;
  const space = new Coordinates(Cage.mesh(CUBE, TRIANGLES)),
    plane = new Coordinates(Cage.polygon(SQUARE), { kind: 'green', scalar: 'float64' });
  const freed = new Coordinates(Cage.polygon(SQUARE));
  freed.free();
  const bindings = [space.bind(uniformly(random, 90, -0.9, 0.9)), plane.bind(uniformly(random, 90, 0.5, 3.5))];
  const files = bindings.map(binding => binding.pack({ tolerance: 1e-2 }).bytes),
    samples = new Samples(space, { samples: 300 });
  const { clip } = cageform.compileClip([0, 1], [CUBE, CUBE]);
  const objects = [
    space,
    plane,
    freed,
    ...bindings,
    ...bindings.map(binding => binding.figure),
    samples,
    new Pins(samples),
    clip,
    Cage.polygon(SQUARE),
    Cage.lattice(BOX),
    Cage.sites(CUBE),
    Cage.mesh(CUBE, QUADS),
  ];
  const numbers = [
    0,
    -0,
    1,
    -1,
    2,
    3,
    4,
    7,
    8,
    24,
    0.5,
    NaN,
    Infinity,
    -Infinity,
    1e308,
    1e-308,
    2 ** 31,
    2 ** 32 - 1,
    2 ** 32,
    2 ** 53,
    '3',
    'x',
    '',
    null,
    undefined,
    true,
    5n,
    Symbol('s'),
  ];
  const arrayOf = () => {
    const size = [0, 1, 2, 3, 8, 16, 24, 30, 45, 90, 91][pick(11)],
      wild = pick(3) === 0;
    const values = Array.from({ length: size }, () =>
      wild && pick(8) === 0 ? numbers[pick(numbers.length)] : random.uniform(-2, 4),
    );
    const tame = () => values.map(value => (typeof value === 'number' ? value : 0));
    switch (pick(9)) {
      case 0:
        return values;
      case 1:
        return Float32Array.from(tame());
      case 2:
        return Float64Array.from(tame());
      case 3:
        return Uint32Array.from(tame());
      case 4:
        return new Uint8Array(size);
      case 5:
        return Array.from({ length: pick(9) }, () => values.slice(0, pick(5)));
      case 6:
        return tame().map(value => Math.abs(Math.floor(value)));
      case 7:
        return pick(2) ? CUBE : SQUARE;
      default:
        return [
          new DataView(new ArrayBuffer(8)),
          new BigInt64Array(3),
          files[pick(2)],
          files[pick(2)].subarray(pick(300)),
          new ArrayBuffer(pick(100)),
          { length: 3 },
          [[]],
          [null],
        ][pick(8)];
    }
  };
  const names = (
    'out normals tangents kind scalar progress dimension vertices radii tolerance clips levels poses format ' +
    'weights points origin axes degree skipChecksum divisions samples falloff disk accuracy landmarks follow coordinates'
  ).split(' ');
  const words =
    'green harmonic mean-value splines sibson barycentric float32 float64 box hull half int8 x smooth wave'.split(' ');
  const anything = depth => {
    switch (pick(depth > 2 ? 4 : 7)) {
      case 0:
        return numbers[pick(numbers.length)];
      case 1:
        return arrayOf();
      case 2:
        return objects[pick(objects.length)];
      case 3:
        return words[pick(words.length)];
      case 4:
        return Object.fromEntries(
          Array.from({ length: pick(3) }, () => [names[pick(names.length)], anything(depth + 1)]),
        );
      case 5:
        return Array.from({ length: pick(4) }, () => anything(depth + 1));
      default:
        return pick(2) ? () => pick(4) > 0 : {};
    }
  };
  const slender = CUBE.map(([x, y, z]) => [0.2 * x, 0.2 * y, z]); // few samples
  const mostly = own => (pick(8) === 0 ? anything(0) : own());
  const figures = () => objects[5 + pick(2)];
  const calls = [
    () =>
      new Coordinates(
        mostly(() => objects[10 + pick(4)]),
        mostly(() => ({ kind: words[pick(6)] })),
      ),
    () =>
      space.bind(
        mostly(() => uniformly(random, 90, -1.2, 1.2)),
        anything(1),
      ),
    () => plane.bind(mostly(arrayOf), anything(1)),
    () =>
      figures().clone(
        mostly(() => uniformly(random, 24, -2, 2)),
        anything(1),
      ),
    () => figures().cloneView(mostly(arrayOf), anything(1)),
    () => figures().gradients(anything(0), anything(0)),
    () => figures().poseHandles(mostly(arrayOf), anything(0)),
    () => figures().clip(anything(0)),
    () => figures().level(anything(0)),
    () => figures().rest(anything(0)),
    () => figures().labels(),
    () =>
      cageform.open(
        mostly(() => files[pick(2)].slice(0, pick(2) ? undefined : pick(500))),
        anything(1),
      ),
    () => cageform.openSamples(mostly(arrayOf), anything(1)),
    () => bindings[pick(2)].weights(anything(0), anything(0)),
    () => bindings[pick(2)].setLabels(anything(0)),
    () => bindings[pick(2)].pack(anything(0)),
    () => Cage.polygon(mostly(arrayOf), anything(0)),
    () => Cage.mesh(anything(0), anything(0), anything(1)),
    () => Cage.curves(anything(0), anything(0)),
    () => Cage.lattice(anything(0)),
    () => new Coordinates(Cage.sites(mostly(arrayOf), anything(1)), anything(1)),
    () =>
      new Coordinates(
        Cage.mesh(
          mostly(() => CUBE),
          mostly(() => TRIANGLES),
        ),
        anything(1),
      ),
    () =>
      new Coordinates(
        Cage.polygon(
          mostly(() => SQUARE),
          mostly(() => undefined),
        ),
        anything(1),
      ),
    () => cageform.check(mostly(() => objects[10 + pick(4)])),
    () =>
      cageform.compileClip(
        mostly(() => [0, 1]),
        mostly(() => [CUBE, CUBE]),
        anything(1),
      ),
    () => clip.sample(anything(0), anything(0)),
    () => Coordinates.blend([mostly(() => objects[10]), mostly(() => objects[10])], anything(1)),
    () => new Pins(anything(0), anything(0)),
    () => objects[8].set(mostly(figures), mostly(arrayOf), anything(1)),
    () => objects[8].hold(mostly(arrayOf)),
    () =>
      objects[8].solve(
        mostly(arrayOf),
        mostly(() => CUBE),
      ),
    () => new cageform[['Figure', 'Clip', 'Binding', 'Samples', 'Cage'][pick(5)]](anything(0), anything(0)),
    () =>
      pick(150) === 0
        ? cageform.makeCage(
            mostly(() => CUBE),
            mostly(() => TRIANGLES),
            mostly(() => ({ vertices: 12, progress: () => pick(50) > 0 })),
          )
        : cageform.makeCage(arrayOf(), arrayOf(), anything(1)),
    () =>
      pick(150) === 0
        ? cageform.wrap(
            mostly(() => slender),
            mostly(() => TRIANGLES),
            mostly(() => slender),
            mostly(() => TRIANGLES),
            mostly(() => ({ finest: 6, follow: slender, progress: () => pick(50) > 0 })),
          )
        : cageform.wrap(arrayOf(), arrayOf(), arrayOf(), arrayOf(), anything(1)),
  ];
  let refusals = 0;
  const met = new Set();
  for (let n = 0; n < count; ++n) {
    const call = calls[pick(calls.length)];
    try {
      const made = call();
      if (typeof made?.free === 'function' && !objects.includes(made)) made.free();
      made?.clip?.free?.();
    } catch (error) {
      assert(error instanceof CageformError, `call ${n} of seed ${seed}: ${call} threw ${error?.stack}`);
      assert(
        !error.message.includes('stopped after an internal error'),
        `call ${n} of seed ${seed}: ${call} stopped the library: ${error.stack}`,
      );
      ++refusals;
      met.add(error.status);
    }
  }
  assert(refusals > count / 4 && refusals < count && met.size > 20, `${refusals} refusals, ${met.size} statuses`);
  const pose = bindings[0].figure.rest();
  assert(bindings[0].figure.clone(pose).points.every(Number.isFinite), 'the library still works');
  return `${refusals} refused, ${met.size} statuses`;
}
