"""Makes a cage around a mesh, bends it, and writes both: python3 mesh.py MODEL.obj OUT_FOLDER [VERTICES]"""

import pathlib
import sys

import numpy as np

import cageform


def read_obj(path):
    points, faces = [], []
    for line in open(path, encoding='utf-8'):
        words = line.split()
        if words[:1] == ['v']:
            points.append([float(word) for word in words[1:4]])
        elif words[:1] == ['f']:
            corners = [int(word.split('/')[0]) for word in words[1:]]
            faces.append([corner - 1 if corner > 0 else len(points) + corner for corner in corners])
    return np.array(points), faces


def write_obj(path, points, faces):
    with open(path, 'w', encoding='utf-8') as file:
        file.writelines('v %.7g %.7g %.7g\n' % tuple(point) for point in points)
        file.writelines('f %s\n' % ' '.join(str(corner + 1) for corner in face) for face in faces)


def main(model, folder, vertices=60):
    points, faces = read_obj(model)
    triangles = np.array([(face[0], a, b) for face in faces for a, b in zip(face[1:], face[2:])])
    cage, made = cageform.make_cage(points, triangles, vertices=int(vertices))
    print('cage: %d vertices, distance from the figure %.3g' % (made.vertices, made.clearance))
    coordinates = cageform.Coordinates(cage, dtype=np.float32)
    binding = coordinates.bind(points)
    print(binding.report)
    pose = cage.vertices.copy()
    low, high = pose[:, 1].min(), pose[:, 1].max()
    pose[:, 0] += 0.3 * (high - low) * ((pose[:, 1] - low) / (high - low)) ** 2  # displacement grows with the height
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    write_obj(folder / 'cage.obj', pose, cage.faces)
    write_obj(folder / 'bent.obj', binding.figure.clone(pose), faces)


if __name__ == '__main__':
    if len(sys.argv) not in (3, 4):
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
