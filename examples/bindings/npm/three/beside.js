// A GLB file beside the one that deform_mesh wrote from it, each at rest and in the file's animation "walk".

import { AnimationClip, AnimationMixer } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { camera, play, scene } from './view.js';

const models = [],
  mixers = [];
for (const [name, walks, x] of [
  ['character.glb', false, -2.35],
  ['character_posed.glb', false, -0.4],
  ['character.glb', true, 1.2],
  ['character_posed.glb', true, 2.45],
]) {
  const model = await new GLTFLoader().loadAsync(name);
  model.scene.position.x = x;
  model.scene.rotation.y = 0.6;
  model.scene.traverse(node => {
    if (node.isLight) node.visible = false; // those of view.js are enough
  });
  scene.add(model.scene);
  models.push(model);
  if (!walks) continue;
  mixers.push(new AnimationMixer(model.scene));
  mixers.at(-1).clipAction(AnimationClip.findByName(model.animations, 'walk')).play();
}
camera.position.set(0, 2, 12);
camera.fov = 11;
camera.lookAt(0, 1, 0);
camera.updateProjectionMatrix();
window.models = models; // for the test
play(time => {
  for (const mixer of mixers) mixer.setTime(time);
});
