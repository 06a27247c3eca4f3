"""Writes results of the native library for the tests of the npm package: python3 native.py FOLDER

PYTHONPATH and CAGEFORM_LIBRARY locate the Python package and its library. FOLDER/native.json has cages, points, weights,
poses, clones and packed figures. small.json has a few of them; a copy is in the repository for the test without the
native library (small.js).
"""

import base64
import json
import pathlib
import sys

import numpy as np

import cageform

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]
STAR = [(0.26, 0.36), (0.95, 0.31), (0.43, -0.14), (0.59, -0.81), (0, -0.45), (-0.59, -0.81), (-0.43, -0.14), (-0.95, 0.31),
        (-0.26, 0.36), (0, 1)]
CUBE = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
TRIANGLES = [corner for a, b, c, d in QUADS for corner in ((a, b, c), (a, c, d))]
CURVES = [[(0, 0), (2, -1), (4, 0)], [(4, 0), (4, 4)], [(4, 4), (3, 5), (1, 3), (0, 4)], [(0, 4), (0, 0)]]
SMALL = ('square wachspress float32', 'star mean-value float64', 'cube mean-value float32', 'cube green float64')
rng = np.random.default_rng(38)


def cases():
    """Yields a name, the JavaScript arguments for the cage, the cage, options of coordinates, and a box inside."""
    square = ('polygon', [SQUARE]), cageform.Cage.polygon(SQUARE), (0.5, 3.5)
    star = ('polygon', [STAR[::-1]]), cageform.Cage.polygon(STAR[::-1]), (-0.2, 0.2)
    cube = ('mesh', [CUBE, TRIANGLES]), cageform.Cage.mesh(CUBE, TRIANGLES), (-0.9, 0.9)
    quads = ('mesh', [CUBE, QUADS, {'divisions': 2}]), cageform.Cage.mesh(CUBE, QUADS, divisions=2), (-0.9, 0.9)
    box = {'points': 4, 'origin': [-1, -1, -1], 'axes': [[2, 0, 0], [0, 2, 0], [0, 0, 2]]}
    lattice = ('lattice', [box]), cageform.Cage.lattice(box['points'], box['origin'], box['axes']), (-0.9, 0.9)
    curves = ('curves', [CURVES]), cageform.Cage.curves(CURVES), (0.5, 3)
    sites = ('sites', [CUBE]), cageform.Cage.sites(CUBE), (-0.9, 0.9)
    sites3 = ('sites', [CUBE]), cageform.Cage.sites(CUBE), (-0.9, 0.9)
    triangle = ('polygon', [SQUARE[:3]]), cageform.Cage.polygon(SQUARE[:3]), (2.5, 2.6)
    for kind in ('mean-value', 'harmonic', 'green', 'wachspress', 'discrete-harmonic', 'sibson'):
        yield 'square', square, {'kind': kind}
    for kind in ('mean-value', 'harmonic', 'green', 'sibson'):
        yield 'star', star, {'kind': kind}
        yield 'cube', cube, {'kind': kind}
    yield 'quads', quads, {'kind': 'mean-value'}
    yield 'lattice', lattice, {}
    yield 'curves', curves, {'kind': 'curved-green'}
    yield 'sites', sites, {'kind': 'sibson'}
    yield 'sites of degree 3', sites3, {'kind': 'sibson-c1'}
    yield 'triangle', triangle, {'kind': 'barycentric'}


def main(folder):
    written = []
    for name, (made, cage, (low, high)), options in cases():
        for scalar in ('float32', 'float64'):
            coordinates = cageform.Coordinates(cage, dtype=np.dtype(scalar), **options)
            dimension = coordinates.dimension
            points = rng.uniform(low, high, (40, dimension)).astype(scalar)
            if name == 'triangle':
                points[:, 1] -= 2
            vectors = {}
            if dimension == 3:
                normals = rng.normal(size=(40, 3))
                vectors['normals'] = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(scalar)
            binding = coordinates.bind(points, **vectors)
            vertices = coordinates.rest()[:coordinates.vertices]
            pose = binding.figure.pose_handles((vertices + rng.normal(scale=0.05, size=vertices.shape)).astype(scalar))
            clone = binding.figure.clone(pose, normals=bool(vectors))
            packed, _ = binding.pack()
            poses = np.stack([vertices, pose[:coordinates.vertices], vertices])
            clip, _ = cageform.compile_clip([0, 1, 2], poses, dtype=np.dtype(scalar))
            with_clip, _ = binding.pack(tolerance=1e-2, clips={'there and back': clip})
            flat = lambda array: np.asarray(array, np.float64).ravel().tolist()
            bytes_of = lambda array: base64.b64encode(array.tobytes()).decode()
            entry = {'name': '%s %s %s' % (name, options.get('kind', 'splines'), scalar), 'cage': made,
                     'options': {**options, 'scalar': scalar},
                     'points': flat(points), 'weights': flat(binding.weights()), 'pose': flat(pose), 'packed': bytes_of(packed),
                     'packedWithClip': bytes_of(with_clip), 'sample': flat(clip.sample(0.7)), 'dimension': dimension}
            small = cageform.open(with_clip)
            entry['smallClone'] = flat(small.clone(pose))
            if vectors:
                entry.update(normals=flat(vectors['normals']), clone=flat(clone[0]), clonedNormals=flat(clone[1]))
            else:
                entry['clone'] = flat(clone)
            written.append(entry)
    (pathlib.Path(folder) / 'native.json').write_text(json.dumps(written))
    members = ('name', 'packedWithClip', 'pose', 'smallClone', 'sample')
    kept = [{member: its[member] for member in members} for its in written if its['name'] in SMALL]
    (pathlib.Path(folder) / 'small.json').write_text(json.dumps(kept, indent=0) + '\n')
    print('%d cases of the native library' % len(written))


main(sys.argv[1])
