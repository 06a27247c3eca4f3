// The meshes of a GLB file, cloned from their cage every frame and drawn by three.js with their materials.

import { BufferAttribute, BufferGeometry, EdgesGeometry, LineBasicMaterial, LineSegments } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { init, open } from 'cageform/runtime';
import { worldMeshes } from './meshes.js';
import { camera, play, scene } from './view.js';

await init();
const figure = open(await (await fetch('character.figure')).arrayBuffer()),
  dance = figure.clip('dance');
const { cageFaces } = await (await fetch('character.json')).json();
const model = await new GLTFLoader().loadAsync('character.glb');
const { meshes, attributes, positions, normals, tangents } = worldMeshes(model.scene);

const pose = figure.rest(),
  cage = new BufferGeometry();
cage.setAttribute('position', new BufferAttribute(pose, 3)); // the clip writes directly into the drawn positions
cage.setIndex(cageFaces);
const lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0x2266aa }));
for (const object of [...meshes, lines]) object.frustumCulled = false; // bounds are those of the first frame
scene.add(...meshes, lines);
camera.position.set(2.2, 1.4, 5.2);
camera.lookAt(0, 0.95, 0);

window.points = positions; // for the test
play(time => {
  dance.sample(time, pose);
  figure.clone(pose, { out: positions, normals, tangents });
  for (const attribute of attributes) attribute.needsUpdate = true;
  lines.geometry.dispose();
  lines.geometry = new EdgesGeometry(cage, 1);
});
