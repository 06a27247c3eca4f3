// The meshes of a glTF scene as points that a cage moves, in node and in the page.

import { BufferAttribute, Mesh, Vector4 } from 'three';

/** Returns the meshes of a scene, in its current pose and in world space, with their materials. `attributes` are their
 *  positions, normals and tangents, as parts of three arrays of all points. If a mesh has no tangents, its part stays zero. */
export function worldMeshes(scene) {
  const found = [],
    attributes = [],
    vector = new Vector4();
  scene.updateMatrixWorld(true);
  scene.traverse(node => {
    if (node.isMesh) found.push(node);
  });
  const points = found.reduce((sum, { geometry }) => sum + geometry.attributes.position.count, 0);
  const [positions, normals, tangents] = [3, 3, 4].map(size => new Float32Array(size * points));
  let first = 0;
  const meshes = found.map(mesh => {
    const geometry = mesh.geometry.clone(),
      { count } = geometry.attributes.position;
    geometry.morphAttributes = {};
    for (const [name, array] of Object.entries({ position: positions, normal: normals, tangent: tangents })) {
      const from = geometry.attributes[name];
      if (!from) continue;
      const size = from.itemSize,
        to = new BufferAttribute(array.subarray(size * first, size * (first + count)), size);
      for (let i = 0; i < count; ++i) {
        to.copyAt(i, from, i);
        if (!mesh.isSkinnedMesh) continue;
        vector.fromBufferAttribute(from, i).setW(name === 'position' ? 1 : 0);
        mesh.applyBoneTransform(i, vector);
        to.setXYZ(i, vector.x, vector.y, vector.z);
      }
      geometry.setAttribute(name, to);
      attributes.push(to);
    }
    first += count;
    return new Mesh(geometry.applyMatrix4(mesh.matrixWorld), mesh.material);
  });
  return { meshes, attributes, positions, normals, tangents };
}
