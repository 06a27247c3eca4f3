"""Tests of the Python package: python3 test.py, with the package on the path."""

import ctypes
import os
import pathlib
import tempfile
import unittest

import numpy as np

import cageform
from cageform import _c, errors

SQUARE = np.array([(0, 0), (4, 0), (4, 4), (0, 4)], dtype=np.float64)
CUBE = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)
QUADS = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)])
TRIANGLES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
rng = np.random.default_rng(20261126)


def inside(count, dimension=2, dtype=np.float64):
    return (rng.uniform(0.5, 3.5, (count, 2)) if dimension == 2 else rng.uniform(-0.9, 0.9, (count, 3))).astype(dtype)


class Arrays(unittest.TestCase):
    def test_layouts(self):
        """Every layout of the same numbers gives the same bits, and outputs are the caller's memory."""
        binding = cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind(inside(50))
        pose = binding.figure.rest()
        pose[2] += (1.5, 0.25)
        expected = binding.figure.clone(pose)
        wide = np.zeros((4, 5))
        wide[:, 1:3] = pose
        for same in (pose.copy(order='F'), wide[:, 1:3], pose[::-1].copy()[::-1], pose.tolist(), pose.astype('>f8')):
            np.testing.assert_array_equal(binding.figure.clone(same), expected)
        out = np.empty((50, 2))
        self.assertIs(binding.figure.clone(pose, out=out), out)
        np.testing.assert_array_equal(out, expected)
        spread = np.full((50, 4), 7.0)
        binding.figure.clone(pose, out=spread[:, 1:3])
        np.testing.assert_array_equal(spread[:, 1:3], expected)
        self.assertTrue((spread[:, [0, 3]] == 7).all())
        transposed = np.empty((2, 50)).T
        binding.figure.clone(pose, out=transposed)
        np.testing.assert_array_equal(transposed, expected)

    def test_nothing_is_copied(self):
        points = inside(10, 3, np.float32)
        self.assertIs(cageform._points(points), points)
        every_other = points[::2]
        self.assertIs(cageform._points(every_other), every_other)

    def test_refused(self):
        figure = cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind(inside(5)).figure
        with self.assertRaises(ValueError):
            figure.clone(np.zeros((4, 3)))
        with self.assertRaises(ValueError):
            figure.clone(np.zeros(8))
        with self.assertRaises(ValueError):
            figure.clone(figure.rest(), out=np.empty((4, 2)))
        with self.assertRaises(errors.PoseSizeDiffers):
            figure.clone(np.zeros((3, 2)))
        with self.assertRaises(errors.PoseNotFinite):
            figure.clone(np.full((4, 2), np.nan))
        with self.assertRaises(TypeError):
            cageform.Coordinates(cageform.Cage.polygon(SQUARE), dtype=np.int32)


class Laws(unittest.TestCase):
    def coordinates(self):
        polygon, mesh = cageform.Cage.polygon(SQUARE), cageform.Cage.mesh(CUBE, TRIANGLES)
        for dtype in (np.float32, np.float64):
            for kind in ('mean-value', 'harmonic', 'green', 'wachspress', 'discrete-harmonic', 'sibson'):
                yield cageform.Coordinates(polygon, kind, dtype)
            for kind in ('mean-value', 'harmonic', 'green', 'sibson'):
                yield cageform.Coordinates(mesh, kind, dtype)
            yield cageform.Coordinates(cageform.Cage.mesh(CUBE, QUADS, divisions=2), dtype=dtype)
            yield cageform.Coordinates(cageform.Cage.lattice(3, (-1, -1, -1), 2 * np.eye(3)), dtype=dtype)
            yield cageform.Coordinates(cageform.Cage.sites(CUBE), degree=3, dtype=dtype)
            yield cageform.Coordinates(cageform.Cage.polygon(SQUARE[:3]), 'barycentric', dtype)

    def test_every_type(self):
        for coordinates in self.coordinates():
            points = inside(20, coordinates.dimension, coordinates.dtype)
            if coordinates.handles == 3:
                points = (points / 8 + (2.5, 0.5)).astype(coordinates.dtype)
            figure = coordinates.bind(points).figure
            np.testing.assert_array_equal(figure.clone(figure.rest()), points)  # to the bit
            vertices = figure.rest()[:coordinates.vertices] + np.asarray(0.25, coordinates.dtype)
            moved = figure.clone(figure.pose_handles(vertices))
            np.testing.assert_allclose(moved, points + 0.25, atol=2e-5 if coordinates.dtype == np.float32 else 1e-12)
            weights = coordinates.bind(points).weights()
            np.testing.assert_allclose(weights[:, :coordinates.vertices].sum(axis=1), 1, atol=1e-4)

    def test_gradients(self):
        figure = cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES)).bind(inside(100, 3)).figure
        pose, gradients = figure.rest() + rng.normal(size=(8, 3)), rng.normal(size=(100, 3))
        of_handles = figure.gradients(gradients)
        step = rng.normal(size=(8, 3))
        value = lambda t: (figure.clone(pose + t * step) * gradients).sum()
        self.assertAlmostEqual((value(1) - value(-1)) / 2, (of_handles * step).sum(), places=9)

    def test_threads(self):
        cage = cageform.Cage.mesh(CUBE, TRIANGLES)
        points = inside(3000, 3)
        one, two = (cageform.Coordinates(cage).bind(points, threads=n).weights() for n in (1, 2))
        np.testing.assert_array_equal(one, two)
        figure = cageform.Coordinates(cage).bind(points).figure
        np.testing.assert_array_equal(figure.clone(2 * CUBE), figure.clone(2 * CUBE, threads=2))


class Figures(unittest.TestCase):
    def test_file(self):
        points = inside(200, dtype=np.float32)
        binding = cageform.Coordinates(cageform.Cage.polygon(SQUARE), dtype=np.float32).bind(points)
        binding.set_labels(['foot', None, 'head', ''])
        poses = np.stack([SQUARE, SQUARE * (1, 1.5), SQUARE])
        clip, report = cageform.compile_clip([0, 1, 2], poses)
        self.assertEqual((clip.begin, clip.end, clip.vertices), (0, 2, 4))
        packed, report = binding.pack(tolerance=1e-3, clips={'wave': clip})
        self.assertEqual(report.bytes, len(packed))
        self.assertLess(report.distance, 1e-3)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / 'square.cage'
            packed.tofile(path)
            for figure in (cageform.open(path), cageform.open(bytes(packed)), cageform.open(packed)):
                self.assertEqual(figure.labels(), ['foot', '', 'head', ''])
                np.testing.assert_array_equal(figure.clone(figure.rest()), points)
                played = figure.clip('wave')
                np.testing.assert_allclose(played.sample(1), SQUARE * (1, 1.5))
                with self.assertRaises(KeyError):
                    figure.clip('walk')
            spoilt = bytearray(packed)
            spoilt[-100] ^= 1
            with self.assertRaises(errors.BlobCorrupt):
                cageform.open(bytes(spoilt))
            with self.assertRaises(errors.NotAFigure):
                cageform.open(b'')
            with self.assertRaises(FileNotFoundError):
                cageform.open(os.path.join(folder, 'none'))

    def test_normals(self):
        points, normals = inside(30, 3), rng.normal(size=(30, 3))
        tangents = np.concatenate([np.cross(normals, rng.normal(size=(30, 3))), np.sign(rng.normal(size=(30, 1)))], axis=1)
        figure = cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES)).bind(points, normals, tangents).figure
        turn = np.array([(0, -1, 0), (1, 0, 0), (0, 0, 1)])
        moved, turned, along = figure.clone(CUBE @ turn.T, tangents=True)
        unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        np.testing.assert_allclose(turned, unit @ turn.T, atol=1e-12)
        np.testing.assert_array_equal(along[:, 3], tangents[:, 3])
        without = cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES)).bind(points).figure
        with self.assertRaises(errors.VectorsMissing):
            without.clone(CUBE, normals=True)


class Reports(unittest.TestCase):
    def test_points(self):
        points = np.array([(1, 1), (9, 9), (np.nan, 0), (2, 0)])
        binding = cageform.Coordinates(cageform.Cage.polygon(SQUARE), 'harmonic').bind(points)
        self.assertEqual(list(binding.outside), [1])
        self.assertEqual(list(binding.not_finite), [2])
        self.assertEqual(list(binding.on_boundary), [3])
        self.assertIn('outside: 1', str(binding.report))
        fading = cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind([(2, 5), (2, 7)], falloff=2)
        self.assertEqual((list(fading.outside), list(fading.faded)), ([0, 1], [0]))
        np.testing.assert_allclose(fading.weights().sum(axis=1), [0.5, 0])
        with self.assertRaises(errors.FalloffNotSupported):
            cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind([(2, 5)], falloff=-1)

    def test_faults(self):
        crossing = cageform.Cage.polygon(SQUARE[[0, 2, 1, 3]])
        faults = cageform.check(crossing)
        self.assertEqual(len(faults), 1)
        self.assertEqual({faults[0].a[0], faults[0].b[0]}, {'edge'})
        with self.assertRaises(errors.CageSelfCrossing) as caught:
            cageform.Coordinates(crossing)
        self.assertEqual(caught.exception.report.faults, 1)
        self.assertIn('edge', str(caught.exception))
        with self.assertRaises(errors.CageNotClosed):
            cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES[2:7]))
        self.assertEqual(cageform.check(cageform.Cage.mesh(CUBE, QUADS)), [])

    def test_progress(self):
        told = []
        cageform.Coordinates(cageform.Cage.polygon(SQUARE), 'harmonic').bind(inside(10), progress=told.append)
        self.assertEqual(told[-1], 1)
        self.assertEqual(told, sorted(told))
        with self.assertRaises(errors.Cancelled):
            cageform.Coordinates(cageform.Cage.polygon(SQUARE), 'harmonic').bind(inside(10), progress=lambda done: False)

        def fails(done):
            raise RuntimeError('mine')
        with self.assertRaisesRegex(RuntimeError, 'mine'):
            cageform.Coordinates(cageform.Cage.polygon(SQUARE), 'harmonic').bind(inside(10), progress=fails)

    def test_structs(self):
        """The declarations are those of the header: no struct of ctypes has another size than its numbers add up to."""
        for name in ('cageform_points', 'cageform_report', 'cageform_cage'):
            self.assertEqual(ctypes.sizeof(getattr(_c, name)) % 8, 0)


class Made(unittest.TestCase):
    def test_cages(self):
        cage, report = cageform.make_cage(CUBE, TRIANGLES, shape='box')
        self.assertEqual(report.vertices, 8)
        self.assertGreater(report.clearance, 0)
        self.assertEqual(cage.faces.shape, (12, 3))
        cageform.Coordinates(cage).bind(CUBE)
        ring = np.stack([np.cos(np.arange(12) * np.pi / 6), np.sin(np.arange(12) * np.pi / 6)], axis=1)
        cage, report = cageform.make_cage(ring, [(k, (k + 1) % 12) for k in range(12)], vertices=8)
        self.assertEqual(len(cage.vertices), 8)
        with self.assertRaises(errors.FigureEmpty):
            cageform.make_cage(np.empty((0, 2)), np.empty((0, 2), int))

    def test_pins(self):
        bar = np.array([(0, 0), (2, 0), (4, 0), (6, 0), (6, 1), (4, 1), (2, 1), (0, 1)], float)
        coordinates = cageform.Coordinates(cageform.Cage.polygon(bar))
        points = np.array([(0.5, 0.5), (3, 0.5), (5.5, 0.5)])
        figure = coordinates.bind(points).figure
        samples = cageform.Samples(coordinates)
        pins = cageform.Pins(cageform.open_samples(samples.pack()))
        pins.set(figure, [0, 1, 2])
        pose, report = pins.solve(points, figure.rest())
        np.testing.assert_array_equal(pose, bar)  # at rest to the bit
        targets = np.array([(0.5, 0.5), (3, 0.5), (5, 2)])
        for _ in range(100):
            pose, report = pins.solve(targets, pose)
            if report.settled:
                break
        self.assertTrue(report.settled)
        np.testing.assert_allclose(figure.clone(pose), targets, atol=0.01)
        with self.assertRaises(errors.IndexOutOfRange) as caught:
            pins.set(figure, [0, 7])
        self.assertEqual(caught.exception.culprit, 1)


if __name__ == '__main__':
    unittest.main(verbosity=1)
