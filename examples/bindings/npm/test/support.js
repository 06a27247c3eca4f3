// Helpers of the tests.

export function assert(holds, message) {
  if (!holds) throw new Error(message);
}
export const equal = (a, b, what) => assert(Object.is(a, b), `${what}: ${a} is not ${b}`);

/** Returns the largest difference of numbers. */
export function difference(a, b) {
  equal(a.length, b.length, 'lengths');
  let most = 0;
  for (let i = 0; i < a.length; ++i) {
    if (!(Math.abs(a[i] - b[i]) <= most)) most = Math.abs(a[i] - b[i]);
  }
  return most;
}
export const sameBits = (a, b, what) =>
  assert(a.length === b.length && a.every((x, i) => Object.is(x, b[i]) || x === b[i]), `${what}: not bitwise equal`);

/** Returns the CageformError of a call, which must throw one with the given status. */
export function refused(cageform, status, call) {
  try {
    call();
  } catch (error) {
    assert(error instanceof cageform.CageformError, `${status}: not a CageformError but ${error?.stack}`);
    equal(error.status, status, `${error.message} (${call})`);
    assert(error.message.length > 5, `${status}: no message`);
    return error;
  }
  throw new Error(`${call} did not throw`);
}

/** Returns a generator of random numbers from a seed (Vigna's splitmix in 32 bits). */
export function randomOf(seed) {
  let state = seed >>> 0;
  const next = () => {
    state = (state + 0x9e3779b9) >>> 0;
    let z = state;
    z = Math.imul(z ^ (z >>> 16), 0x21f0aaad);
    z = Math.imul(z ^ (z >>> 15), 0x735a2d97);
    return ((z ^ (z >>> 15)) >>> 0) / 2 ** 32;
  };
  return { next, uniform: (a, b) => a + (b - a) * next(), pick: n => Math.floor(next() * n) };
}
export const uniformly = (random, count, low, high, Kind = Float32Array) =>
  Kind.from({ length: count }, () => random.uniform(low, high));

export const SQUARE = [
  [0, 0],
  [4, 0],
  [4, 4],
  [0, 4],
];
export const CROSSED = [
  [0, 0],
  [4, 4],
  [4, 0],
  [0, 4],
];
export const CUBE = [-1, 1].flatMap(z => [-1, 1].flatMap(y => [-1, 1].map(x => [x, y, z])));
export const QUADS = [
  [0, 2, 3, 1],
  [4, 5, 7, 6],
  [0, 1, 5, 4],
  [1, 3, 7, 5],
  [3, 2, 6, 7],
  [2, 0, 4, 6],
];
export const TRIANGLES = QUADS.flatMap(([a, b, c, d]) => [
  [a, b, c],
  [a, c, d],
]);
export const CURVES = [
  [
    [0, 0],
    [2, -1],
    [4, 0],
  ],
  [
    [4, 0],
    [4, 4],
  ],
  [
    [4, 4],
    [3, 5],
    [1, 3],
    [0, 4],
  ],
  [
    [0, 4],
    [0, 0],
  ],
];
export const BOX = {
  points: 4,
  origin: [-1, -1, -1],
  axes: [
    [2, 0, 0],
    [0, 2, 0],
    [0, 0, 2],
  ],
};

/** Returns the vertices and the faces of a unit sphere around two poles. */
export function ball(segments = 17, rings = 8) {
  const vertices = [[0, 0, 1]],
    faces = [],
    last = 1 + segments * rings;
  const at = (ring, segment) =>
    ring === 0 ? 0 : ring > rings ? last : 1 + (ring - 1) * segments + (segment % segments);
  for (let ring = 0; ring <= rings; ++ring) {
    for (let segment = 0; segment < segments; ++segment) {
      const across = (Math.PI * (ring + 1)) / (rings + 1),
        around = (2 * Math.PI * segment) / segments;
      if (ring < rings) {
        vertices.push([Math.sin(across) * Math.cos(around), Math.sin(across) * Math.sin(around), Math.cos(across)]);
        faces.push([at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1)]);
      }
      if (ring > 0) faces.push([at(ring, segment), at(ring + 1, segment + 1), at(ring, segment + 1)]);
    }
  }
  vertices.push([0, 0, -1]);
  return { vertices, faces };
}
