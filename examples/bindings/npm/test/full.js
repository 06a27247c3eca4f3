// Tests calls when all 4 GB are in use, only in node: node --test full.js

import { test } from 'node:test';
import * as cageform from 'cageform';
import { BOX, CUBE, TRIANGLES, equal, refused, sameBits } from './support.js';

const { Cage, Coordinates, Pins, Samples } = cageform;

await cageform.init();
const space = new Coordinates(Cage.mesh(CUBE, TRIANGLES));
const harmonic = () => new Coordinates(Cage.mesh(CUBE, TRIANGLES), { kind: 'harmonic', accuracy: 1e-4 });
const changed = harmonic();
const pins = new Pins(new Samples(space, { samples: 4000 }));
const figure = space.bind(CUBE).figure;
const wide = new Coordinates(Cage.lattice({ ...BOX, points: 15 })); // 13 kB per point
const lattice = wide.bind([0, 0, 0]);
const expected = figure.clone(CUBE.map(([x, y, z]) => [2 * x, y, z])).points;
const held = [];

await test('allocations of every size run out of memory', () => {
  for (const coordinates of [wide, space]) {
    for (let points = 1 << 16; points > 50 || (coordinates === wide && points >= 1); points >>= 1) {
      for (;;) {
        try {
          held.push(coordinates.bind(new Float32Array(3 * points)));
        } catch (error) {
          equal(error.status, 'out_of_memory', error.stack);
          break;
        }
      }
    }
  }
});
await test('calls without memory return errors; the functions of every frame still work', () => {
  sameBits(figure.clone(CUBE.map(([x, y, z]) => [2 * x, y, z])).points, expected, 'clone');
  refused(cageform, 'out_of_memory', () => harmonic().bind(CUBE));
  refused(cageform, 'out_of_memory', () => lattice.setLabels(Array(3375).fill('x'.repeat(3000))));
  refused(cageform, 'out_of_memory', () => new Samples(space));
});
await test('a partly modified object is never used again', () => {
  refused(cageform, 'out_of_memory', () => changed.solve());
  refused(cageform, 'object_of_another_kind', () => changed.solve());
  refused(cageform, 'object_of_another_kind', () => changed.bind(CUBE));
});
await test('all calls work again after memory is freed', () => {
  for (const binding of held) {
    binding.figure.free();
    binding.free();
  }
  refused(cageform, 'object_of_another_kind', () => changed.bind(CUBE));
  changed.free();
  pins.set(figure, [0, 1]);
  sameBits(harmonic().bind(CUBE).figure.clone(CUBE).points, Float32Array.from(CUBE.flat()), 'clone at rest');
  lattice.setLabels(Array(3375).fill('x'));
});
