// Times bind and clone of 50,000 points with the input of bench.py: node bench.js FOLDER

import { readFile } from 'node:fs/promises';
import { Cage, Coordinates, init, open } from 'cageform';

const given = JSON.parse(await readFile(`${process.argv[2]}/bench.json`, 'utf8'));
const bytes = name => Uint8Array.from(Buffer.from(given[name], 'base64')).buffer,
  floats = name => new Float32Array(bytes(name));

/** Returns the minimum time of a call in ms. */
function best(call, rounds) {
  let least = Infinity;
  for (let n = 0; n < rounds; ++n) {
    const start = performance.now();
    call();
    least = Math.min(least, performance.now() - start);
  }
  return least;
}
const begun = performance.now();
await init();
const started = performance.now() - begun,
  [points, pose, normals] = ['points', 'pose', 'normals'].map(floats);
const coordinates = new Coordinates(Cage.mesh(floats('vertices'), new Uint32Array(bytes('faces'))));
const bind = best(() => {
  const made = coordinates.bind(points);
  made.figure.free();
  made.free();
}, 3);
const { figure } = coordinates.bind(points),
  turned = coordinates.bind(points, { normals }).figure;
const packed = open(coordinates.bind(points).pack({ tolerance: 1e-3 }).bytes),
  out = new Float32Array(points.length),
  own = new Float32Array(points.length);
const shown = [
  bind,
  best(() => figure.clone(pose, { out }), 100),
  best(() => turned.clone(pose, { out, normals: own }), 50),
  best(() => packed.clone(pose, { out }), 100),
  best(() => figure.cloneView(pose), 100),
].map(x => x.toFixed(3));
console.log(
  `${`node ${process.version}`.padEnd(36)} bind ${shown[0]} ms, clone ${shown[1]} ms, with normals ${shown[2]} ms, from a file ${shown[3]} ms, ` +
    `without a copy ${shown[4]} ms; init ${started.toFixed(0)} ms`,
);
