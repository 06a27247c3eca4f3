// Uses every public member of the declarations. Compiled with tsc --strict and run in node.

import {
  Cage,
  CageformError,
  Coordinates,
  Figure,
  Pins,
  Samples,
  check,
  compileClip,
  init,
  makeCage,
  open,
  openSamples,
  version,
  wrap,
} from 'cageform';
import type { Array32or64, BindOptions, Binding, Fault, Report, Status, Wrap, WrapOptions } from 'cageform';
import { init as initRuntime, open as openSmall } from 'cageform/runtime';

function expect(holds: boolean, what: string): void {
  if (!holds) throw new Error(what);
}

await init();
await initRuntime();
const square: readonly (readonly number[])[] = [
  [0, 0],
  [4, 0],
  [4, 4],
  [0, 4],
];
const cage: Cage = Cage.polygon(square);
const faults: Fault[] = check(cage);
expect(faults.length === 0 && cage.kind === 'polygon' && cage.vertices?.length === 8, 'cage');
const coordinates = new Coordinates(cage, { kind: 'harmonic', scalar: 'float32', accuracy: 1e-4 });
const solved: Report = coordinates.solve({ progress: (done: number) => done <= 1 });
expect(solved.unknowns > 0 && solved.status === 'ok' && coordinates.hasGradients, String(solved));
const options: BindOptions = { outside: 'keep-in-place', progress: () => undefined };
const binding: Binding = coordinates.bind(Float32Array.of(1, 1, 2, 3), options);
const figure: Figure = binding.figure,
  pose: Array32or64 = figure.rest();
pose[4] = 6;
pose[5] = 6;
const out = new Float32Array(4),
  { points, normals } = figure.clone(pose, { out });
expect(points === out && normals === undefined && points[0]! > 1, 'clone');
expect(figure.cloneView(pose).points.length === 4 && figure.gradients(points).length === 8, 'views and gradients');
const { clip } = compileClip([0, 1], [[...figure.rest()], [...pose]], { dimension: 2, keys: 'linear' });
const { bytes, report } = binding.pack({ tolerance: 1e-3, clips: { wave: clip } });
expect(report.bytes === bytes.length && open(bytes).clip('wave').sample(1).length === 8, 'packed');
expect(openSmall(bytes.buffer).clone(pose).points.length === 4, 'run time');
const pins = new Pins(openSamples(new Samples(coordinates, { samples: 500 }).pack()), { hard: true });
pins.set(figure, [0], { weights: [1] });
expect(pins.solve([1.2, 1.1], pose).report.iterations > 0, 'pins');
expect(
  makeCage(
    square,
    [
      [0, 1],
      [1, 2],
    ],
    { dimension: 2, vertices: 12, radii: [0.1, 0.1] },
  ).cage.dimension === 2,
  'made cage',
);
const corners = [
    [0, 0, 1],
    [1, 0, 0],
    [-1, 1, 0],
    [-1, -1, 0],
  ],
  sides = [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2],
  choice: WrapOptions = {
    landmarks: [
      [
        [0, 0, 1],
        [0, 0, 1],
      ],
    ],
    finest: 6,
    follow: [0, 0, 2],
  };
const wrapped: Wrap = wrap(corners, sides, corners, sides, choice);
expect(wrapped.report.ended === 'stages' && wrapped.first.length === 12, String(wrapped.report));
expect(
  (wrapped.lattice?.dimension ?? 3) === 3 && wrapped.latticePose.length % 3 === 0 && wrapped.pose.length === 0,
  'poses',
);
expect(
  wrapped.move([0, 0, 2]).points.length === 3 && wrapped.move([], { jacobians: true }).jacobians?.length === 0,
  'move',
);
try {
  figure.clone([0]);
} catch (error) {
  if (!(error instanceof CageformError)) throw error;
  const status: Status = error.status,
    culprit: number | string | null = error.culprit;
  expect(status === 'dimension_differs' && culprit === null, status);
}
for (const wrong of [
  // @ts-expect-error: there is no such kind
  () => new Coordinates(cage, { kind: 'mean value' }),
  // @ts-expect-error: figures are made by open() and bind()
  () => new Figure(),
]) {
  try {
    wrong();
    throw new Error('not refused');
  } catch (error) {
    expect(error instanceof CageformError, String(error));
  }
}
for (const object of [figure, binding, coordinates, pins, clip, wrapped]) object.free();
console.log(`typed consumer of cageform ${version}: ok`);
