// A lit scene in the window, drawn every frame. #0.6 in the address shows only the time 0.6.

import { AmbientLight, Color, DirectionalLight, PerspectiveCamera, Scene, WebGLRenderer } from 'three';

export const scene = new Scene(),
  camera = new PerspectiveCamera(30, innerWidth / innerHeight, 0.1, 50);
scene.background = new Color(0xeef0f3);
const light = new DirectionalLight(0xffffff, 2.5);
light.position.set(2, 4, 5);
scene.add(new AmbientLight(0xffffff, 1), light);

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

/** Calls show(seconds) before each picture. */
export function play(show) {
  let frames = 0,
    spent = 0;
  renderer.setAnimationLoop(now => {
    const stop = location.hash.slice(1),
      start = performance.now();
    show(stop === '' ? now / 1000 : Number(stop));
    spent += performance.now() - start;
    ++frames;
    renderer.render(scene, camera);
    window.drawn = { frames, milliseconds: spent / frames, time: stop === '' ? null : Number(stop) };
  });
}
