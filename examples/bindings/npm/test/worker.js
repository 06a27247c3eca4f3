// Makes a cage in a worker.

import { init, makeCage } from '/node_modules/cageform/index.js';

onmessage = async ({ data: { points, indices, options } }) => {
  try {
    await init();
    const { cage } = makeCage(points, indices, {
      ...options,
      progress: done => {
        postMessage({ done });
      },
    });
    postMessage({ vertices: cage.vertices, faces: cage.faces });
  } catch (error) {
    postMessage({ fault: String(error) });
  }
};
