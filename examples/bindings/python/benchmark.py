"""Times bind and clone in Python and in C++: python3 benchmark.py BESIDE [REPEATS], where BESIDE is the program of beside.cpp.

Python and C++ run alternately. Prints medians in milliseconds and their ratio.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import cageform

ROUNDS, POINTS = 9, 50000
rng = np.random.default_rng(1)


def sphere(rings=8, around=12):
    """Returns a cage: the (98, 3) vertices and the triangles of a sphere around the figure."""
    up, turn = np.pi * np.arange(1, rings + 1) / (rings + 1), 2 * np.pi * np.arange(around) / around
    ring = np.stack([np.outer(np.sin(up), np.cos(turn)), np.outer(np.sin(up), np.sin(turn)),
                     np.outer(np.cos(up), np.ones(around))], axis=2).reshape(-1, 3)
    vertices = np.concatenate([[(0, 0, 1)], ring, [(0, 0, -1)]])
    last, faces = len(vertices) - 1, []
    for n in range(around):
        m = (n + 1) % around
        faces += [(0, 1 + n, 1 + m), (last, last - around + m, last - around + n)]
        for row in range(1, last - around, around):
            faces += [(row + n, row + around + n, row + around + m), (row + n, row + around + m, row + m)]
    return vertices, np.array(faces, dtype=np.uint32)


def seconds(action, count):
    taken = []
    for _ in range(count):
        start = time.perf_counter()
        action()
        taken.append(time.perf_counter() - start)
    return taken


def main(program, repeats=3):
    vertices, faces = sphere()
    print('%d points, a cage of %d vertices, one thread; medians in ms' % (POINTS, len(vertices)))
    print('%-26s %9s %9s %7s' % ('', 'C++', 'Python', 'ratio'))
    for dtype in (np.float32, np.float64):
        points = rng.normal(size=(POINTS, 3))
        points *= (rng.uniform(0, 0.8, POINTS) / np.linalg.norm(points, axis=1))[:, None]
        points, pose = points.astype(dtype), (vertices * (1, 2, 1)).astype(dtype)
        coordinates = cageform.Coordinates(cageform.Cage.mesh(vertices, faces), dtype=dtype)
        figure, out = coordinates.bind(points).figure, np.empty_like(points)
        theirs, ours, new_arrays = {'bind': [], 'clone': []}, {'bind': [], 'clone': []}, []
        with tempfile.TemporaryDirectory() as folder:
            for name, array in (('vertices', vertices), ('faces', faces), ('points', points), ('pose', pose)):
                array.tofile(os.path.join(folder, name))
            for _ in range(ROUNDS):
                printed = subprocess.run([program, folder, np.dtype(dtype).name, str(repeats)], check=True,
                                         stdout=subprocess.PIPE).stdout.decode()
                for line in printed.splitlines():
                    name, *taken = line.split()
                    theirs[name] += [float(number) for number in taken]
                ours['bind'] += seconds(lambda: coordinates.bind(points, threads=1), repeats)
                ours['clone'] += seconds(lambda: figure.clone(pose, out=out), 20 * repeats)
                new_arrays += seconds(lambda: figure.clone(pose), 20 * repeats)
        for name, taken, beside in (('bind', ours['bind'], theirs['bind']), ('clone', ours['clone'], theirs['clone']),
                                    ('clone, a new array', new_arrays, theirs['clone'])):
            mine, their = 1e3 * statistics.median(taken), 1e3 * statistics.median(beside)
            print('%-26s %9.3f %9.3f %7.3f' % (np.dtype(dtype).name + ' ' + name, their, mine, mine / their))


if __name__ == '__main__':
    if len(sys.argv) not in (2, 3):
        raise SystemExit(__doc__)
    main(sys.argv[1], *map(int, sys.argv[2:]))
