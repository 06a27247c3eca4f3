// Binds the character and packs it with its dance: node bind.js FOLDER OUT
// FOLDER has character.obj, its cage and its clip (make_character writes them). The page opens OUT/character.figure.
// OUT/character.json has the faces and, for the test, the points that the page must compute at one time.

import { readFile, writeFile } from 'node:fs/promises';
import { Cage, Coordinates, compileClip, init, open } from 'cageform';

/** Returns the vertices and triangles of an OBJ text. */
function parse(text) {
  const rows = text.split('\n').map(line => line.split(' '));
  const vertices = rows.filter(([word]) => word === 'v').flatMap(row => row.slice(1, 4).map(Number));
  const faces = rows
    .filter(([word]) => word === 'f')
    .map(row => row.slice(1, 4).map(corner => parseInt(corner, 10) - 1));
  return { vertices: Float32Array.from(vertices), faces };
}

/** Returns vertex normals: means of the face normals, weighted by area. */
function normalsOf({ vertices, faces }) {
  const normals = new Float32Array(vertices.length),
    at = i => vertices.subarray(3 * i, 3 * i + 3);
  for (const [a, b, c] of faces) {
    const [p, q, r] = [a, b, c].map(at),
      u = q.map((x, k) => x - p[k]),
      v = r.map((x, k) => x - p[k]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const corner of [a, b, c])
      normal.forEach((x, k) => {
        normals[3 * corner + k] += x;
      });
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    for (let k = 0; k < 3; ++k) normals[i + k] /= length;
  }
  return normals;
}

/** Returns the times and poses of a clip; the last pose repeats the first. */
function parseClip(text) {
  const times = [],
    poses = [];
  let length = 0;
  for (const [word, ...rest] of text
    .split('\n')
    .filter(line => line && !line.startsWith('#'))
    .map(line => line.split(','))) {
    if (word === 'length') length = Number(rest[0]);
    else if (word === 'pose') {
      times.push(Number(rest[0]));
      poses.push([]);
    } else poses.at(-1).push(Number(word), ...rest.map(Number));
  }
  return { times: [...times, length], poses: [...poses, poses[0]] };
}

const [folder, out] = process.argv.slice(2);
const file = name => readFile(`${folder}/${name}`, 'utf8');
await init();
const mesh = parse(await file('character.obj')),
  cage = parse(await file('character_cage.obj'));
const start = performance.now();
const binding = new Coordinates(Cage.mesh(cage.vertices, cage.faces), { kind: 'harmonic' }).bind(mesh.vertices, {
  normals: normalsOf(mesh),
});
console.log(`${binding.points} points bound in ${Math.round(performance.now() - start)} ms`);
const { times, poses } = parseClip(await file('character_clip.csv'));
const { clip } = compileClip(times, poses, { after: 'cycle', packTolerance: 1e-4 });
const { bytes, report } = binding.pack({ tolerance: 5e-3, clips: { dance: clip } });
console.log(`${bytes.length} bytes, maximum error ${report.distance.toPrecision(2)}`);
await writeFile(`${out}/character.figure`, bytes);

const figure = open(bytes),
  time = 0.6,
  { points } = figure.clone(figure.clip('dance').sample(time));
await writeFile(
  `${out}/character.json`,
  JSON.stringify({ faces: mesh.faces.flat(), cageFaces: cage.faces.flat(), time, points: Array.from(points) }),
);
