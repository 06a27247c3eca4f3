"""Bends a model in a cage made around it: python3 model.py MODEL OUT [VERTICES]

MODEL is a GLB file, or a file that meshio opens: OBJ, PLY, STL. A GLB file keeps all but its positions and normals.
Joints do not move, so animations of a skin do not fit the new shape. Morph targets do not move. A mesh of two nodes
follows the last node. Primitives must be triangles with indices and normals. The program deform_mesh has none of these
limits.
"""

import json
import pathlib
import struct
import sys

import meshio
import numpy as np

import cageform


def bend(points, triangles, vertices, normals=None):
    cage, made = cageform.make_cage(points, triangles, vertices=vertices)
    print('cage: %d vertices, distance from the figure %.3g' % (made.vertices, made.clearance))
    binding = cageform.Coordinates(cage).bind(points, normals)
    print(binding.report)
    pose = cage.vertices.copy()
    low, high = pose[:, 1].min(), pose[:, 1].max()
    pose[:, 0] += 0.3 * (high - low) * ((pose[:, 1] - low) / (high - low)) ** 2  # displacement grows with the height
    return binding.figure.clone(pose, normals=normals is not None)


def times(matrices, vectors):
    return (matrices @ vectors[..., None])[..., 0]


def bend_glb(model, out, vertices):
    data = bytearray(model.read_bytes())
    length, = struct.unpack_from('<I', data, 12)
    document = json.loads(data[20:20 + length])
    accessors, nodes = document['accessors'], document['nodes']

    def numbers(index):  # of the file in memory; a copy if they are normalized
        accessor = accessors[index]
        view = document['bufferViews'][accessor['bufferView']]
        dtype = np.dtype({5121: 'u1', 5123: '<u2', 5125: '<u4', 5126: '<f4'}[accessor['componentType']])
        shape = accessor['count'], {'SCALAR': 1, 'VEC3': 3, 'VEC4': 4, 'MAT4': 16}[accessor['type']]
        start = 28 + length + view.get('byteOffset', 0) + accessor.get('byteOffset', 0)
        strides = view.get('byteStride', shape[1] * dtype.itemsize), dtype.itemsize
        values = np.ndarray(shape, dtype, data, start, strides)
        return values / np.iinfo(dtype).max if accessor.get('normalized') else values

    worlds = {}  # matrices of nodes

    def visit(index, parent):
        node, matrix = nodes[index], np.eye(4)
        x, y, z, w = node.get('rotation', (0, 0, 0, 1))
        cross = np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
        matrix[:3, :3] = (np.eye(3) + 2 * (w * cross + cross @ cross)) * node.get('scale', (1, 1, 1))
        matrix[:3, 3] = node.get('translation', (0, 0, 0))
        worlds[index] = parent @ (np.reshape(node['matrix'], (4, 4)).T if 'matrix' in node else matrix)
        for child in node.get('children', []):
            visit(child, worlds[index])

    for root in document['scenes'][document.get('scene', 0)]['nodes']:
        visit(root, np.eye(4))
    parts, points, normals, triangles, count = [], [], [], [], 0
    for index in filter(lambda index: 'mesh' in nodes[index], worlds):
        for primitive in document['meshes'][nodes[index]['mesh']]['primitives']:
            names = primitive['attributes']
            matrices = worlds[index][None]
            if 'skin' in nodes[index]:  # a matrix per point
                skin = document['skins'][nodes[index]['skin']]
                inverse = numbers(skin['inverseBindMatrices']).reshape(-1, 4, 4).transpose(0, 2, 1)
                joints = np.array([worlds[joint] for joint in skin['joints']]) @ inverse
                matrices = np.einsum('nk,nkij->nij', numbers(names['WEIGHTS_0']), joints[numbers(names['JOINTS_0'])])
            linear, shift = matrices[:, :3, :3], matrices[:, :3, 3]
            back = np.linalg.inv(linear)
            parts.append((names, linear, shift, back))
            points.append(times(linear, numbers(names['POSITION'])) + shift)
            normals.append(times(back.swapaxes(1, 2), numbers(names['NORMAL'])))
            triangles.append(numbers(primitive['indices']).reshape(-1, 3).astype(np.uint32) + count)
            count += len(points[-1])
    moved, turned = bend(np.concatenate(points), np.concatenate(triangles), vertices, np.concatenate(normals))
    ends = np.cumsum([len(part) for part in points])
    for (names, linear, shift, back), point, normal in zip(parts, np.split(moved, ends), np.split(turned, ends)):
        positions = numbers(names['POSITION'])
        positions[:] = times(back, point - shift)
        accessors[names['POSITION']].update(min=positions.min(axis=0).tolist(), max=positions.max(axis=0).tolist())
        normal = times(linear.swapaxes(1, 2), normal)
        numbers(names['NORMAL'])[:] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    text = json.dumps(document).encode()
    text += b' ' * (-len(text) % 4)
    chunks = struct.pack('<I', len(text)) + b'JSON' + text + data[20 + length:]
    out.write_bytes(b'glTF' + struct.pack('<II', 2, 12 + len(chunks)) + chunks)


def main(model, out, vertices=60):
    model, out = pathlib.Path(model), pathlib.Path(out)
    if model.suffix == '.glb':
        return bend_glb(model, out, int(vertices))
    mesh = meshio.read(model)
    corners = [block.data[:, [0, k, k + 1]] for block in mesh.cells for k in range(1, block.data.shape[1] - 1)]
    mesh.points = bend(mesh.points, np.concatenate(corners), int(vertices))
    mesh.write(out)


if __name__ == '__main__':
    if len(sys.argv) not in (3, 4):
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
