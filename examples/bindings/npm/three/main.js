// A character, cloned from its cage every frame and drawn by three.js. #0.6 in the address shows only the time 0.6.

import {
  AmbientLight,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  EdgesGeometry,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshStandardMaterial,
  PerspectiveCamera,
  Scene,
  WebGLRenderer,
} from 'three';
import { init, open } from 'cageform/runtime';

const bytesOf = async name => (await fetch(name)).arrayBuffer();
await init();
const figure = open(await bytesOf('character.figure')),
  dance = figure.clip('dance');
const { faces, cageFaces } = await (await fetch('character.json')).json();

/** A geometry whose positions change every frame. */
function geometryOf(count, indices) {
  const geometry = new BufferGeometry();
  for (const name of ['position', 'normal'])
    geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * count), 3));
  geometry.setIndex(indices);
  return geometry;
}
const body = geometryOf(figure.points, faces),
  { position, normal } = body.attributes;
const pose = figure.rest(),
  cage = new BufferGeometry();
cage.setAttribute('position', new BufferAttribute(pose, 3)); // the clip writes directly into the drawn positions
cage.setIndex(cageFaces);

/** Computes the pose, the points and their normals at a time. */
function show(time) {
  dance.sample(time, pose);
  figure.clone(pose, { out: position.array, normals: normal.array });
  position.needsUpdate = normal.needsUpdate = true;
}

const scene = new Scene(),
  camera = new PerspectiveCamera(30, innerWidth / innerHeight, 0.1, 50);
scene.background = new Color(0xeef0f3);
const light = new DirectionalLight(0xffffff, 2.5);
light.position.set(2, 4, 5);
const skin = new Mesh(body, new MeshStandardMaterial({ color: 0xd9824a, roughness: 0.6 }));
const lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0x2266aa }));
skin.frustumCulled = lines.frustumCulled = false; // bounds are those of the first frame
scene.add(new AmbientLight(0xffffff, 1), light, skin, lines);
camera.position.set(2.2, 1.4, 5.2);
camera.lookAt(0, 0.95, 0);

const renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setPixelRatio(devicePixelRatio);
document.body.append(renderer.domElement);
function resize() {
  renderer.setSize(innerWidth, innerHeight);
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
}
addEventListener('resize', resize);
resize();

let frames = 0,
  spent = 0;
function draw(now) {
  const stop = location.hash.slice(1),
    start = performance.now();
  show(stop === '' ? now / 1000 : Number(stop));
  spent += performance.now() - start;
  ++frames;
  lines.geometry.dispose();
  lines.geometry = new EdgesGeometry(cage, 1);
  renderer.render(scene, camera);
  if (frames % 30 === 0)
    document.getElementById('says').textContent = `${figure.points} points, ${(spent / frames).toFixed(2)} ms per frame`;
  window.drawn = {
    frames,
    milliseconds: spent / frames,
    time: stop === '' ? null : Number(stop),
    points: position.array,
  };
  requestAnimationFrame(draw);
}
requestAnimationFrame(draw);
