"""Writes input and expected results for Test.cs: python3 figure.py FOLDER. A bound bar with a clip and samples."""

import pathlib
import sys

import numpy as np

import cageform

folder = pathlib.Path(sys.argv[1])
rng = np.random.default_rng(1)
box = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float32)
faces = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)])
cage = cageform.Cage.mesh(box, np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]]))
points = rng.uniform(-0.9, 0.9, (500, 3)).astype(np.float32)
normals = rng.normal(size=(500, 3))
tangents = np.concatenate([np.cross(normals, rng.normal(size=(500, 3))), np.sign(rng.normal(size=(500, 1)))], axis=1)
coordinates = cageform.Coordinates(cage, dtype=np.float32)
binding = coordinates.bind(points, normals, tangents)
binding.set_labels(['left foot', None, 'hand ✋', None, None, None, None, None])
low, _ = coordinates.bind(points[:50]).pack()
clip, _ = cageform.compile_clip([0, 1, 3], np.stack([box, 2 * box, box + 1]))
late, _ = cageform.compile_clip(70000.5 + np.arange(30) / 500, [box + k for k in range(30)], keys='linear')
figure, _ = binding.pack(tolerance=1e-3, clips={'grow': clip, 'late': late}, levels=[low], origin=(5e5, 4.6e6, 0.1))
samples = cageform.Samples(coordinates)

opened, pins = cageform.open(figure), cageform.Pins(samples)
pose = (box + 0.2 * rng.normal(size=(8, 3))).astype(np.float32)
moved, turned, along = opened.clone(pose, tangents=True)
targets, pulled = points[[0, 7, 9]] + np.array([(0, 0, 0), (0, 0, 0), (0, 0, 0.5)], np.float32), box
pins.set(opened, [0, 7, 9])
pulled, _ = pins.solve(targets, pulled)

turn, rise = np.meshgrid(np.linspace(0, 2 * np.pi, 17)[:-1], np.linspace(0, np.pi, 10)[1:-1])
sphere = np.stack([np.sin(rise) * np.cos(turn), np.sin(rise) * np.sin(turn), np.cos(rise)], axis=-1).reshape(-1, 3)
corner = np.arange(len(sphere) - 16)  # open at the poles
beside = corner // 16 * 16 + (corner + 1) % 16
tube = np.concatenate([np.stack([corner, corner + 16, beside + 16], 1), np.stack([corner, beside + 16, beside], 1)]).astype(np.int32)
source, target, coat = (np.float32(sphere * size) for size in ((0.2, 0.2, 1), (0.15, 0.25, 1.2), (0.22, 0.22, 1.1)))
wrap = cageform.wrap(source, tube, target, tube, [(source[0], target[0])], coat, finest=12)
for name, array in (('figure', figure), ('samples', samples.pack()), ('pose', pose), ('moved', moved), ('turned', turned),
                    ('along', along), ('sampled', opened.clip('grow').sample(1.5)), ('level', opened.level(1).clone(pose)),
                    ('targets', targets), ('pulled', pulled), ('source', source), ('target', target), ('faces', tube),
                    ('coat', coat), ('coat_moved', wrap.move(coat)),
                    ('plane', cageform.Coordinates(cageform.Cage.polygon(box[[0, 1, 3, 2], :2])).bind(points[:, :2]).pack()[0])):
    array.tofile(folder / name)
