"""Times bind and clone of 50,000 points with the native library, and writes the input for bench.js: python3 bench.py FOLDER"""

import base64
import json
import pathlib
import sys
import time

import numpy as np

import cageform

COUNT, SIDE = 50000, 4


def box():
    """Returns a box with grids on its sides: 98 vertices, 192 triangles."""
    index, triangles = {}, []
    at = lambda p: index.setdefault(p, len(index))
    for axis in range(3):
        for end in (0, SIDE):
            for i in range(SIDE):
                for j in range(SIDE):
                    corners = []
                    for u, v in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0, 0, 0]
                        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = end, u, v
                        corners.append(at(tuple(p)))
                    a, b, c, d = corners if end else corners[::-1]
                    triangles += [(a, b, c), (a, c, d)]
    return np.array(list(index), np.float32) * (2 / SIDE) - 1, np.array(triangles, np.uint32)


def best(call, rounds):
    """Returns the minimum time of a call in ms."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1000 * min(times)


def main(folder):
    rng = np.random.default_rng(1)
    vertices, faces = box()
    points = rng.uniform(-0.9, 0.9, (COUNT, 3)).astype(np.float32)
    pose = (vertices + rng.normal(scale=0.1, size=vertices.shape)).astype(np.float32)
    normals = np.tile(np.float32((0, 0, 1)), (COUNT, 1))
    flat = lambda array: base64.b64encode(array.tobytes()).decode()
    (pathlib.Path(folder) / 'bench.json').write_text(json.dumps({name: flat(array) for name, array in (
        ('vertices', vertices), ('faces', faces), ('points', points), ('pose', pose), ('normals', normals))}))
    coordinates = cageform.Coordinates(cageform.Cage.mesh(vertices, faces), dtype=np.float32)
    plain, turned = coordinates.bind(points, threads=1), coordinates.bind(points, normals=normals, threads=1)
    packed = cageform.open(plain.pack(tolerance=1e-3, threads=1)[0])
    out = np.empty_like(points)
    print('%-36s bind %7.1f ms, clone %6.3f ms, with normals %6.3f ms, from a file %6.3f ms' % (
        'native, one thread, %d vertices' % len(vertices), best(lambda: coordinates.bind(points, threads=1), 3),
        best(lambda: plain.figure.clone(pose, out=out), 30), best(lambda: turned.figure.clone(pose, normals=True), 10),
        best(lambda: packed.clone(pose, out=out), 30)))


main(sys.argv[1])
