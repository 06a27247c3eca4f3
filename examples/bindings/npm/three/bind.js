// Binds the character and packs it with its dance: node bind.js FOLDER OUT
// FOLDER has character.glb, its cage and its clip (make_character writes them). The page opens OUT/character.figure.
// OUT/character.json has the faces of the cage and, for the test, the points at rest and those that the page must compute
// at one time.

import { readFile, writeFile } from 'node:fs/promises';
import { Cage, Coordinates, compileClip, init, open } from 'cageform';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { worldMeshes } from './meshes.js';

/** Returns the vertices and triangles of a cage in an OBJ text. */
function parse(text) {
  const rows = text.split('\n').map(line => line.split(' '));
  const vertices = rows.filter(([word]) => word === 'v').map(row => row.slice(1, 4).map(Number));
  const faces = rows
    .filter(([word]) => word === 'f')
    .map(row => row.slice(1, 4).map(corner => parseInt(corner, 10) - 1));
  return { vertices, faces };
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
const loader = new GLTFLoader().register(() => ({ name: 'no pictures', loadTexture: async () => null }));
const { scene } = await loader.parseAsync(new Uint8Array(await readFile(`${folder}/character.glb`)).buffer, '');
const { positions, normals, tangents } = worldMeshes(scene);
const cage = parse(await file('character_cage.obj'));
const start = performance.now();
const binding = new Coordinates(Cage.mesh(cage.vertices, cage.faces), { kind: 'harmonic' }).bind(positions, {
  normals,
  tangents,
});
console.log(`${binding.points} points bound in ${Math.round(performance.now() - start)} ms`);
const { times, poses } = parseClip(await file('character_clip.csv'));
const { clip } = compileClip(times, poses, { after: 'cycle', packTolerance: 1e-4 });
// Points at one place may move apart by at most twice the tolerance.
const { bytes, report } = binding.pack({ tolerance: 1e-4, poses: poses.flat(), clips: { dance: clip } });
console.log(`${bytes.length} bytes, maximum error ${report.distance.toPrecision(2)}`);
await writeFile(`${out}/character.figure`, bytes);

const figure = open(bytes),
  time = 0.6,
  { points } = figure.clone(figure.clip('dance').sample(time));
await writeFile(
  `${out}/character.json`,
  JSON.stringify({ cageFaces: cage.faces.flat(), rest: Array.from(positions), time, points: Array.from(points) }),
);
