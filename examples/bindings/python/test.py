"""Tests of the Python package: python3 test.py, with the package on the path.

CAGEFORM_BESIDE is the program of beside.cpp. CAGEFORM_LAYOUT is the output of the program of `read_header.py layout`.
Tests that need a missing one are skipped.
"""

import contextlib
import copy
import ctypes
import gc
import io
import itertools
import os
import pathlib
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import threading
import tracemalloc
import unittest
import weakref

import numpy as np

import cageform
from cageform import CageformError
from cageform import _arrays as arrays
from cageform import _c, errors

SQUARE = np.array([(0, 0), (4, 0), (4, 4), (0, 4)], dtype=np.float64)
CUBE = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float64)
QUADS = np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)])
TRIANGLES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
TETRAHEDRON = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
CURVES = [[(0, 0), (2, -1), (4, 0)], [(4, 0), (4, 4)], [(4, 4), (3, 5), (1, 3), (0, 4)], [(0, 4), (0, 0)]]
rng = np.random.default_rng(20261126)


def inside(count, dimension=2, dtype=np.float64):
    return (rng.uniform(0.5, 3.5, (count, 2)) if dimension == 2 else rng.uniform(-0.9, 0.9, (count, 3))).astype(dtype)


def hinge():
    """Returns a strip at rest (22, 3), its vertices (8, 22, 3) in frames that bend and move it, and its faces."""
    rest = np.array([(x, y, 0) for x in range(11) for y in (0, 1)], float)
    frames = np.repeat(rest[None], 8, axis=0)
    beyond = np.maximum(rest[:, 0] - 5, 0)
    for t, frame in enumerate(frames):
        frame[:, 0] += (np.cos(0.2 * t) - 1) * beyond + 3 * t
        frame[:, 2] += np.sin(0.2 * t) * beyond
    return rest, frames, np.array([(i, i + 1, i + 2) for i in range(20)])


def ball(size, segments=17, rings=8):
    """Returns the vertices (138, 3) and the faces of an ellipsoid around two poles."""
    across = np.pi * np.arange(1, rings + 1)[:, None] / (rings + 1)
    around = 2 * np.pi * np.arange(segments) / segments
    places = np.stack(np.broadcast_arrays(np.sin(across) * np.cos(around), np.sin(across) * np.sin(around), np.cos(across)), -1)
    below, next = 1 + np.arange(rings * segments), np.tile((np.arange(segments) + 1) % segments, rings)
    right = below - np.tile(np.arange(segments), rings) + next
    faces = [(0, a, b) for a, b in zip(below[:segments], right)] + [(len(below) + 1, b, a) for a, b in zip(below[-segments:], right[-segments:])]
    for a, b, c, d in zip(below[:-segments], right[:-segments], below[segments:], right[segments:]):
        faces += [(a, c, d), (a, d, b)]
    return np.concatenate([[(0, 0, 1)], places.reshape(-1, 3), [(0, 0, -1)]]) * size, np.array(faces)


def rotation(quaternions):
    """Returns the rotation matrices (…, 3, 3) of quaternions x, y, z, w (…, 4)."""
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


class Arrays(unittest.TestCase):
    def test_layouts(self):
        """All memory layouts of the same numbers give bitwise equal results, and outputs are written in place."""
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

    def test_strange_layouts(self):
        """Bound points may be read-only, strided, reversed, transposed, byte-swapped, misaligned or integers."""
        coordinates = cageform.Coordinates(cageform.Cage.polygon(4 * SQUARE))
        whole = rng.integers(1, 15, (60, 2))
        for dtype in (np.float32, np.float64):
            points = whole.astype(dtype)
            locked = points.copy()
            locked.flags.writeable = False
            packed = np.zeros(60, [('flag', np.uint8), ('at', dtype, 2)])
            packed['at'] = points
            expected = coordinates.bind(points).weights()
            for same in (locked, np.repeat(points, 3, axis=0)[::3], points[::-1].copy()[::-1], np.asfortranarray(points),
                         points.astype(points.dtype.newbyteorder()), packed['at'], whole, whole.astype(np.uint8),
                         whole.astype(np.float16), whole.tolist()):
                np.testing.assert_array_equal(coordinates.bind(same).weights(), expected)
            row = np.broadcast_to(points[:1], (5, 2))
            np.testing.assert_array_equal(coordinates.bind(row).weights(), np.repeat(expected[:1], 5, axis=0))

    def test_nothing_is_copied(self):
        """The library reads and writes arrays in place, and a frame makes no large allocation."""
        points = inside(20000, 3, np.float32)
        wide = np.zeros((1000, 8))
        for array in (points, points[::2], wide[:, 3:6], points[5:5], wide[7:8, 1:4]):
            read = arrays.points(array, 'points')
            self.assertIs(read, array)
            self.assertEqual(arrays.view(read).data, array.__array_interface__['data'][0])
        figure = cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES), dtype=np.float32).bind(points[::2]).figure
        pose, out = figure.rest(), np.empty((10000, 3), np.float32)
        tracemalloc.start()
        figure.clone(pose, out=out)
        figure.gradients(out, out=pose)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        self.assertLess(peak, 5000)

    def test_out_over_pose(self):
        """The output may be the array of the pose."""
        figure = cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind(inside(4)).figure
        pose = figure.rest() * (2, 1)
        expected = figure.clone(pose)
        np.testing.assert_array_equal(figure.clone(pose, out=pose), expected)

    def test_refused(self):
        """The exception names the argument and its actual shape, type or value."""
        polygon = cageform.Cage.polygon(SQUARE)
        coordinates = cageform.Coordinates(polygon)
        figure = coordinates.bind(inside(5)).figure
        locked = np.empty((5, 2))
        locked.flags.writeable = False
        for kind, words, call in (
                (ValueError, r'pose.*\(count, 2\), not \(4, 3\)', lambda: figure.clone(np.zeros((4, 3)))),
                (ValueError, r'pose.*not \(8,\)', lambda: figure.clone(np.zeros(8))),
                (ValueError, r'out.*\(5, 2\), not \(4, 2\)', lambda: figure.clone(figure.rest(), out=np.empty((4, 2)))),
                (ValueError, 'out.*read-only', lambda: figure.clone(figure.rest(), out=locked)),
                (TypeError, 'out.*list', lambda: figure.clone(figure.rest(), out=[])),
                (TypeError, 'out.*int64', lambda: figure.clone(figure.rest(), out=np.empty((5, 2), np.int64))),
                (TypeError, 'pose.*complex128', lambda: figure.clone(figure.rest() * 1j)),
                (TypeError, 'points.*<U1', lambda: coordinates.bind([('a', 'b')])),
                (TypeError, 'dtype.*int32', lambda: cageform.Coordinates(polygon, dtype=np.int32)),
                (ValueError, r'normals.*\(5, 3\)', lambda: coordinates.bind(inside(5), normals=np.zeros((5, 3)))),
                (ValueError, "outside: .*'extend'.*not 'away'", lambda: coordinates.bind(inside(5), outside='away')),
                (ValueError, 'threads.*-1', lambda: coordinates.bind(inside(5), threads=-1)),
                (ValueError, 'kind: must be one of', lambda: cageform.Coordinates(polygon, 'sibson-c2')),
                (ValueError, 'largest.*-3', lambda: coordinates.bind(inside(5)).pack(largest=-3)),
                (TypeError, 'largest', lambda: coordinates.bind(inside(5)).pack(largest=1.5)),
                (ValueError, 'first', lambda: coordinates.bind(inside(5)).weights(-1)),
                (ValueError, 'clip.*-1', lambda: figure.clip(-1)),
                (ValueError, 'faces.*2\\*\\*32', lambda: cageform.Cage.mesh(CUBE, [(0, 1, -2)])),
                (TypeError, 'faces.*float64', lambda: cageform.Cage.mesh(CUBE, [(0, 1, 2.5)])),
                (ValueError, r'axes.*\(2, 3\)', lambda: cageform.Cage.lattice(3, (0, 0), np.zeros((2, 3)))),
                (ValueError, r'poses.*\(3, #vertices', lambda: cageform.compile_clip([0, 1, 2], np.zeros((2, 4, 2)))),
                (TypeError, 'Coordinates.bind', cageform.Binding),
                (ValueError, r'poses\[1\] has 6 numbers, poses\[0\] 8$', lambda: cageform.compile_clip([0, 1], [SQUARE, SQUARE[:3]])),
                (ValueError, r'poses\[1\]\[2\] has 3 numbers, poses\[1\]\[0\] 2$',
                 lambda: cageform.compile_clip([0, 1], [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 0), (1, 1, 1)]])),
                (ValueError, r'points\[1\] has 1 number, points\[0\] 2$', lambda: coordinates.bind([('ab', 'c'), (b'de',)])),
                (ValueError, r'points\[1\] has 1 number, points\[0\] 2$', lambda: coordinates.bind([(np.array(1.), 2), (np.array(3.),)])),
                (errors.PoseSizeDiffers, '', lambda: figure.clone(np.zeros((3, 2)))),
                (errors.PoseNotFinite, '', lambda: figure.clone(np.full((4, 2), np.nan))),
                (errors.LoopsDoNotMatch, 'do not add up', lambda: cageform.Coordinates(cageform.Cage.polygon(SQUARE, [5]))),
                (cageform.CageformError, '', lambda: coordinates.bind(inside(5)).weights(3, 3))):
            with self.assertRaisesRegex(kind, words):
                call()

    def test_changed_cage(self):
        """Changed arrays of a cage are read with their current values and types."""
        cage = cageform.Cage.mesh(CUBE.copy(), TRIANGLES)
        cage.vertices[:] *= 2
        self.assertEqual(cageform.Coordinates(cage).rest().max(), 2)
        reversed_ = cageform.Cage(cage.kind, cage.vertices, indices=TRIANGLES.ravel()[::-1].astype(np.int16)[::-1])
        np.testing.assert_array_equal(cageform.Coordinates(reversed_).rest(), cageform.Coordinates(cage).rest())


class Memory(unittest.TestCase):
    def test_order(self):
        """Objects stay valid after the deletion of the objects they use, and are freed when nothing refers to them."""
        cage = cageform.Cage.polygon(SQUARE.copy())
        coordinates = cageform.Coordinates(cage)
        points = inside(50)
        binding = coordinates.bind(points)
        clip, _ = cageform.compile_clip([0, 1], np.stack([SQUARE, 2 * SQUARE]), dtype=np.float64)
        packed, _ = binding.pack(clips={'grow': clip})
        figure, opened = binding.figure, cageform.open(packed)
        player, level = opened.clip('grow'), opened.level(0)
        dead = [weakref.ref(its) for its in (cage, coordinates, binding, clip, opened)]
        gc.disable()  # objects must be freed without the collector
        try:
            del cage, coordinates, binding, clip, packed, opened
            self.assertEqual([its() for its in dead], [None] * 5)
        finally:
            gc.enable()
        gc.collect()
        np.testing.assert_array_equal(figure.clone(figure.rest()), points)
        np.testing.assert_array_equal(level.clone(level.rest()), points)
        np.testing.assert_allclose(player.sample(1), 2 * SQUARE)

    def test_cycles(self):
        """The collector frees objects of a reference cycle in a valid order."""
        for _ in range(20):
            binding = cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind(inside(50))
            binding.itself, binding.figure.binding = binding, binding
            del binding
            gc.collect()

    def test_no_leak(self):
        """Memory of the library is freed."""
        def resident():
            with open('/proc/self/statm', encoding='ascii') as file:
                return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')
        if not os.path.exists('/proc/self/statm'):
            self.skipTest('there is no /proc')
        coordinates, points = cageform.Coordinates(cageform.Cage.polygon(SQUARE)), inside(20000)
        for n in range(60):  # of 1.4 MB each
            if n == 10:
                before = resident()
            cageform.open(coordinates.bind(points, threads=1).pack()[0]).rest()
        self.assertLess(resident() - before, 20e6)

    def test_old_figure(self):
        """A figure from before set_labels() of its binding does not change."""
        binding = cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind(inside(5))
        binding.set_labels(['one', 'two', 'three', 'four'])
        before = binding.figure
        binding.set_labels(['a label that is much longer than the one before'] * 4)
        self.assertEqual(before.labels(), ['one', 'two', 'three', 'four'])
        self.assertEqual(len(binding.figure.labels()[0]), 47)

    def test_copies(self):
        """Objects of the library cannot be copied or pickled; cages, reports and exceptions can."""
        coordinates = cageform.Coordinates(cageform.Cage.polygon(SQUARE))
        binding = coordinates.bind(inside(5))
        for its in (coordinates, binding, binding.figure):
            for copied in (copy.copy, copy.deepcopy, pickle.dumps):
                with self.assertRaisesRegex(TypeError, type(its).__name__):
                    copied(its)
        same = pickle.loads(pickle.dumps(coordinates.cage))
        np.testing.assert_array_equal(same.vertices, SQUARE)
        self.assertEqual(pickle.loads(pickle.dumps(binding.report)), binding.report)
        with self.assertRaises(errors.CageSelfCrossing) as caught:
            cageform.Coordinates(cageform.Cage.polygon(SQUARE[[0, 2, 1, 3]]))
        sent = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual((type(sent), str(sent), sent.report),
                         (errors.CageSelfCrossing, str(caught.exception), caught.exception.report))

    def test_bytes_that_change(self):
        """A figure copies bytes that the caller can change."""
        points = inside(50)
        packed = bytearray(cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind(points).pack()[0])
        memory = np.empty(len(packed) + 64, np.uint8)
        start = -memory.ctypes.data % 64
        whole = memory[start:start + len(packed)]
        whole[:] = packed
        figure = cageform.open(whole)
        whole[:] = 255
        np.testing.assert_array_equal(figure.clone(figure.rest()), points)
        with self.assertRaisesRegex(TypeError, 'source'):
            cageform.open(whole[::2])
        with self.assertRaisesRegex(TypeError, 'source'):
            cageform.open(7)

    def test_hostile_files(self):
        """Truncated or corrupt files are errors, at any position."""
        packed = cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind(inside(30)).pack()[0]
        for _ in range(300):
            spoilt = packed.copy()
            spoilt[rng.integers(len(packed))] ^= 1 << rng.integers(8)
            with self.assertRaises(cageform.CageformError):
                cageform.open(spoilt)
            with self.assertRaises(cageform.CageformError):
                cageform.open(packed[:rng.integers(len(packed))].tobytes())


class BesideCpp(unittest.TestCase):
    def test_bits(self):
        """Weights, clones and packed files are bitwise equal to those of C++."""
        program = os.environ.get('CAGEFORM_BESIDE')
        if not program:
            self.skipTest('CAGEFORM_BESIDE is not set')
        for dtype in (np.float32, np.float64):
            points, pose = inside(1000, 3, dtype), (CUBE + 0.3 * rng.normal(size=(8, 3))).astype(dtype)
            with tempfile.TemporaryDirectory() as folder:
                for name, array in (('vertices', CUBE), ('faces', TRIANGLES.astype(np.uint32)), ('points', points),
                                    ('pose', pose)):
                    array.tofile(os.path.join(folder, name))
                subprocess.run([program, folder, np.dtype(dtype).name, '0'], check=True, stdout=subprocess.DEVNULL)
                theirs = {name: pathlib.Path(folder, name).read_bytes() for name in ('weights', 'clone', 'figure')}
            binding = cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES), dtype=dtype).bind(points)
            self.assertEqual(binding.weights().tobytes(), theirs['weights'])
            self.assertEqual(binding.figure.clone(pose).tobytes(), theirs['clone'])
            self.assertEqual(binding.figure.clone(pose.astype(np.float64)).tobytes(), theirs['clone'])
            self.assertEqual(binding.pack(tolerance=1e-3)[0].tobytes(), theirs['figure'])

    def test_layout(self):
        """Structs of ctypes have the layout of C."""
        path = os.environ.get('CAGEFORM_LAYOUT')
        if not path:
            self.skipTest('CAGEFORM_LAYOUT is not set')
        lines = pathlib.Path(path).read_text(encoding='ascii').splitlines()
        self.assertGreater(len(lines), 200)
        for line in lines:
            name, number = line.split()
            kind, _, member = name.partition('.')
            its = getattr(_c, kind)
            self.assertEqual(getattr(its, member).offset if member else ctypes.sizeof(its), int(number), name)


class Laws(unittest.TestCase):
    def bindings(self):
        """Yields name, coordinates, points and binding of every type on every cage that it supports."""
        cages = [cageform.Cage.polygon(SQUARE), cageform.Cage.polygon(SQUARE[:3]), cageform.Cage.mesh(CUBE, TRIANGLES),
                 cageform.Cage.mesh(CUBE, QUADS, divisions=2), cageform.Cage.mesh(CUBE[[0, 1, 2, 4]], TETRAHEDRON),
                 cageform.Cage.lattice(3, (-1, -1, -1), 2 * np.eye(3)), cageform.Cage.sites(CUBE), cageform.Cage.curves(CURVES)]
        for kind, cage, dtype in itertools.product(cageform.Coordinates.kinds, cages, (np.float32, np.float64)):
            try:
                coordinates = cageform.Coordinates(cage, kind, dtype)
                points = inside(20, coordinates.dimension, coordinates.dtype)
                if coordinates.vertices == coordinates.dimension + 1:  # within the simplex
                    points = (points / 8 + ((2.5, 0.5) if coordinates.dimension == 2 else -0.7)).astype(dtype)
                yield kind, coordinates, points, coordinates.bind(points)
            except CageformError as error:
                self.assertIn(error.name, ('cage_kind_not_supported', 'not_a_simplex', 'divisions_not_supported'))

    def test_every_type(self):
        seen = set()
        for kind, coordinates, points, binding in self.bindings():
            seen.add(kind)
            figure = binding.figure
            np.testing.assert_array_equal(figure.clone(figure.rest()), points)  # to the bit
            vertices = figure.rest()[:coordinates.vertices] + np.asarray(0.25, coordinates.dtype)
            moved = figure.clone(figure.pose_handles(vertices))
            np.testing.assert_allclose(moved, points + 0.25, atol=2e-5 if coordinates.dtype == np.float32 else 1e-12)
            np.testing.assert_allclose(binding.weights()[:, :coordinates.vertices].sum(axis=1), 1, atol=1e-4)
        self.assertEqual(seen, set(cageform.Coordinates.kinds))

    def test_locality(self):
        """A locality lowers the weight of a far corner; out of range it is refused."""
        cage = cageform.Cage.polygon(SQUARE)
        far = [cageform.Coordinates(cage, 'harmonic', locality=locality).bind([(1, 1)]).weights()[0, 2] for locality in (0, 20, 40)]
        self.assertLess(far[1], 0.1 * far[0])
        self.assertLess(far[2], 0.1 * far[1])
        for wrong in (41, -1, np.nan):
            with self.assertRaises(errors.LocalityNotSupported):
                cageform.Coordinates(cage, 'harmonic', locality=wrong).bind([(1, 1)])

    def test_cells(self):
        """A vertex inside is a handle: points around it follow it."""
        cage = cageform.Cage.polygon(SQUARE).with_cells([(1, 1), (3, 3), (3, 2)], bones=[(4, 4, 0.5)], walls=[(5, 6)])
        coordinates = cageform.Coordinates(cage, 'harmonic')
        self.assertEqual(coordinates.handles, 7)
        points = [(1, 1), (1.2, 1.1), (3, 2.5)]
        weights = coordinates.bind(points, leave_linear_precision=True).weights()
        np.testing.assert_allclose([weights[0, 4], weights[1, 4], weights[2, 5:].sum()], 1, atol=1e-3)  # the accuracy
        figure = coordinates.bind(points).figure
        np.testing.assert_array_equal(figure.clone(figure.rest()), points)
        bar = cageform.Cage.mesh(CUBE, TRIANGLES).with_cells([(0, 0, -0.4), (0, 0, 0.4)], bones=[(8, 9, 0.2)])
        self.assertEqual(cageform.Coordinates(bar, 'harmonic').handles, 10)
        with self.assertRaises(errors.InteriorCellsNotSupported):
            cageform.Coordinates(cage)
        with self.assertRaises(errors.IndexOutOfBounds):
            cageform.Coordinates(cageform.Cage.polygon(SQUARE).with_cells([(1, 1)], bones=[(7, 7, 0.5)]), 'harmonic')

    def test_blend(self):
        """With two cages, each moves its part of the figure."""
        cages = [cageform.Cage.polygon(SQUARE), cageform.Cage.polygon(SQUARE + (6, 0))]
        coordinates = cageform.Coordinates.blend(cages)
        self.assertEqual(coordinates.handles, 8)
        figure = coordinates.bind([(2, 2), (8, 2)]).figure
        pose = figure.rest()
        pose[4:] += (0, 1)
        np.testing.assert_allclose(figure.clone(pose), [(2, 2), (8, 3)], atol=1e-12)
        with self.assertRaises(errors.CageSelfCrossing) as caught:
            cageform.Coordinates.blend(cages[:1] + [cageform.Cage.polygon(SQUARE[[0, 2, 1, 3]])])
        self.assertEqual(caught.exception.culprit, 1)
        with self.assertRaises(cageform.CageformError):
            cageform.Coordinates.blend([])

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

    def test_threads_of_python(self):
        """Threads clone one figure concurrently; they sample one clip and solve one set of pins one at a time."""
        coordinates = cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES))
        points = inside(20000, 3)
        figure = coordinates.bind(points).figure
        clip, _ = cageform.compile_clip(np.arange(8), CUBE * np.linspace(1, 2, 8)[:, None, None], dtype=np.float64)
        pins = cageform.Pins(cageform.Samples(coordinates))
        pins.set(figure, [0, 1, 2])
        poses = [CUBE * scale for scale in (0.5, 1, 2, 3)]
        expected = [figure.clone(pose) for pose in poses]
        times = np.linspace(0, 7, 50)
        sampled = [clip.sample(time) for time in times]
        wrong = []

        def work(own):
            for n in range(50):
                if not (figure.clone(poses[own]) == expected[own]).all():
                    wrong.append('clone')
                if not (clip.sample(times[n]) == sampled[n]).all():
                    wrong.append('sample')
                if not (pins.solve(points[:3], CUBE)[0] == CUBE).all():
                    wrong.append('solve')
        workers = [threading.Thread(target=work, args=(own,)) for own in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertEqual(wrong, [])

    def test_released(self):
        """Other Python threads run during a call."""
        coordinates, points = cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES)), inside(100000, 3)
        ticks, done = [0], threading.Event()

        def count():
            while not done.wait(1e-4):
                ticks[0] += 1
        counter = threading.Thread(target=count)
        counter.start()
        while ticks[0] < 3:
            coordinates.bind(points, threads=1)
        done.set()
        counter.join()


class Figures(unittest.TestCase):
    def test_file(self):
        points = inside(200, dtype=np.float32)
        binding = cageform.Coordinates(cageform.Cage.polygon(SQUARE), dtype=np.float32).bind(points)
        binding.set_labels(['foot', None, 'head', ''])
        poses = np.stack([SQUARE, SQUARE * (1, 1.5), SQUARE])
        clip, report = cageform.compile_clip([0, 1, 2], poses)
        self.assertEqual((clip.begin, clip.end, clip.vertices), (0, 2, 4))
        late = 70000.5 + np.arange(30) / 500  # float32 cannot tell these times apart
        played, _ = cageform.compile_clip(late, [SQUARE + k for k in range(30)], keys='linear')
        self.assertEqual(played.begin, late[0])
        for k, time in enumerate(late):
            np.testing.assert_allclose(played.sample(time), SQUARE + k, atol=1e-3)
        packed, report = binding.pack(tolerance=1e-3, clips={'wave': clip}, origin=(5e5, 4.6e6 + 0.25))
        self.assertEqual(report.bytes, len(packed))
        self.assertLess(report.distance, 1e-3)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / 'square.cage'
            packed.tofile(path)
            for figure in (cageform.open(path), cageform.open(bytes(packed)), cageform.open(packed)):
                self.assertEqual(figure.labels(), ['foot', '', 'head', ''])
                self.assertEqual(figure.origin.tolist(), [5e5, 4.6e6 + 0.25])
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

    def test_file_of_bind_mesh(self):
        """A figure of `bind_mesh --move 3:0,0,0.5 --seconds 0.5` with its clip."""
        path = os.path.join(os.path.dirname(__file__), '../../../tests/data/figures/clip.figure')
        if not os.path.exists(path):
            self.skipTest('only in the repository')
        clip = cageform.open(path).clip('pose')
        self.assertEqual((clip.begin, clip.end, clip.vertices), (0, 1, 4))
        np.testing.assert_array_equal(clip.sample(0.5)[3], (0, 0, 1.5))

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

    def test_interrupt(self):
        """Ctrl-C cancels a long call, with or without a progress callback, and the call restores the signal handler."""
        cage = cageform.Cage.mesh(CUBE, TRIANGLES)
        # A shell starts background processes with this signal ignored; Python keeps that.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))
        for progress in (None, lambda done: None):
            coordinates = cageform.Coordinates(cage, 'harmonic', accuracy=2e-4)
            timer = threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT))
            timer.start()
            with self.assertRaises(KeyboardInterrupt):
                while True:  # until it is interrupted, however fast
                    coordinates.bind(inside(10, 3), progress=progress)
                    coordinates = cageform.Coordinates(cage, 'harmonic', accuracy=2e-4)
            timer.join()
            self.assertIs(signal.getsignal(signal.SIGINT), signal.default_int_handler)

        def interrupts(done):
            os.kill(os.getpid(), signal.SIGINT)
        with self.assertRaises(KeyboardInterrupt):
            cageform.Coordinates(cage, 'harmonic').bind(inside(10, 3), progress=interrupts)

    def test_print(self):
        binding = cageform.Coordinates(cageform.Cage.polygon(SQUARE)).bind([(1, 1), (9, 9)])
        self.assertRegex(str(binding.report), '(?s)^seconds: .*\npoints: 2\noutside: 1\n.*partition error: ')
        self.assertRegex(repr(binding.report), r'^Report\(seconds=.*, points=2, outside=1, .*\)$')
        self.assertEqual((str(cageform.Report()), repr(cageform.Report())), ('ok', 'Report()'))
        names = {name for name, _ in _c.cageform_report._fields_} - {'size', 'reserved'}
        self.assertEqual(set(vars(cageform.Report())), names)

    def test_errors(self):
        """Every status has an exception with a docstring."""
        self.assertGreater(len(errors.__all__), 100)
        for name in errors.__all__:
            kind = getattr(errors, name)
            self.assertTrue(issubclass(kind, cageform.CageformError) and kind.__doc__, name)
        self.assertTrue(issubclass(errors.OutOfMemory, MemoryError))

    def test_documented(self):
        """All public names have a docstring."""
        for name in cageform.__all__:
            its = getattr(cageform, name)
            self.assertTrue(its.__doc__, name)
            for member, own in vars(its).items():
                if isinstance(its, type) and callable(own) and not member.startswith('_'):
                    self.assertTrue(own.__doc__, '%s.%s' % (name, member))

    def test_readme(self):
        """The program of the README prints the output shown there."""
        readme = pathlib.Path(__file__).with_name('README.md')
        if not readme.exists():
            self.skipTest('there is no README.md')
        code, printed = re.search('```python\n(.*?)```.*?```text\n(.*?)```', readme.read_text(encoding='utf-8'), re.S).groups()
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(code, {})
        self.assertEqual(out.getvalue(), printed)

    def test_import(self):
        """Without numpy or the library, the import error names the missing part."""
        for code, words in (("sys.modules['numpy'] = None", 'cageform needs numpy'),
                            ("os.environ['CAGEFORM_LIBRARY'] = '/nowhere.so'", '/nowhere.so cannot be used')):
            run = subprocess.run([sys.executable, '-c', 'import os, sys\n%s\nimport cageform' % code],
                                 env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)), stderr=subprocess.PIPE, check=False)
            self.assertNotEqual(run.returncode, 0)
            self.assertRegex(run.stderr.decode().splitlines()[-1], '^ImportError: .*' + words)


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

    def test_skeletons(self):
        """Arrays, transforms and report of a skeleton agree for every kind; results do not depend on threads."""
        rest, frames, faces = hinge()
        for kind in ('rigid', 'similar', 'stretched'):
            skeleton, report = cageform.fit_skeleton(rest, frames, faces, bones=2, kind=kind, threads=1)
            again, _ = cageform.fit_skeleton(rest.tolist(), list(frames), bones=2, faces=faces, kind=kind, threads=3)
            for name in ('parents', 'joints', 'vertex_bones', 'weights', 'maps'):
                np.testing.assert_array_equal(getattr(skeleton, name), getattr(again, name))
            self.assertEqual((skeleton.bones, skeleton.frames, skeleton.influences), (2, 8, 4))
            self.assertEqual((report.bones, report.beyond), (2, 0))
            self.assertEqual((skeleton.maps.shape, skeleton.weights.shape), ((8, 2, 3, 4), (len(rest), 4)))
            self.assertEqual(list(skeleton.parents), [-1, 0])
            self.assertAlmostEqual(skeleton.joints[1, 0], 5, places=2)  # the hinge
            np.testing.assert_allclose(skeleton.weights.sum(axis=1), 1, atol=1e-6)
            self.assertTrue((np.diff(skeleton.weights, axis=1) <= 0).all())
            self.assertLess(report.max_distance, 5e-3)
            size = np.linalg.norm(np.ptp(rest, axis=0))
            distances = np.linalg.norm(skeleton.places(rest) - frames, axis=2) / size
            self.assertAlmostEqual(distances.max(), report.max_distance, places=6)
            self.assertAlmostEqual(distances[report.frame, report.culprit], report.max_distance, places=6)
            self.assertAlmostEqual(np.sqrt((distances ** 2).mean()), report.rms, places=6)
            self.check_transforms(skeleton, kind)

    def check_transforms(self, skeleton, kind):
        """The product of the nodes' transforms from the root, after a shift by -joint, is the bone's map."""
        moves, turns, scales, axes = skeleton.transforms()
        if kind == 'rigid':
            self.assertTrue((scales == 1).all())
        if kind != 'stretched':
            self.assertTrue((axes == (0, 0, 0, 1)).all())
        for turned in (turns, axes):
            np.testing.assert_allclose(np.linalg.norm(turned, axis=2), 1)
            self.assertTrue(((turned[1:] * turned[:-1]).sum(axis=2) >= 0).all())
        local = np.zeros((skeleton.frames, skeleton.bones, 4, 4))
        local[..., :3, :3] = rotation(turns) @ (scales[..., None] * rotation(axes))
        local[..., :3, 3], local[..., 3, 3] = moves, 1
        for bone, parent in enumerate(skeleton.parents):
            if parent >= 0:
                local[:, bone] = local[:, parent] @ local[:, bone]
        places = local[..., :3, 3] - np.einsum('tbij,bj->tbi', local[..., :3, :3], skeleton.joints)
        # A scale within 1e-6 of 1 is 1: of the bone and of its parent, over distances below 10.
        np.testing.assert_allclose(local[..., :3, :3], skeleton.maps[..., :3], atol=2e-6)
        np.testing.assert_allclose(places, skeleton.maps[..., 3], atol=2e-5)

    def test_bones_by_distance(self):
        rest, frames, faces = hinge()
        skeleton, report = cageform.fit_skeleton(rest.astype(np.float32), frames, max_distance=0.002)
        self.assertLessEqual(report.max_distance, 0.002)
        self.assertEqual((skeleton.bones, report.beyond), (report.bones, 0))
        self.assertRegex(str(report), 'bones: %d\nrms: ' % report.bones)

    def test_skeletons_refused(self):
        rest, frames, faces = hinge()
        torn, wrong = frames.copy(), faces.copy()
        torn[5, 7, 1], wrong[3, 1] = np.nan, len(rest)
        for kind, words, call in (
                (errors.BonesNotSupported, '', lambda: cageform.fit_skeleton(rest, frames)),
                (errors.MotionEmpty, '', lambda: cageform.fit_skeleton(rest, frames[:1], bones=2)),
                (errors.MotionEmpty, '', lambda: cageform.fit_skeleton(rest[:0], frames[:, :0], bones=2)),
                (errors.FrameNotFinite, 'frame 5, vertex 7', lambda: cageform.fit_skeleton(rest, torn, bones=2)),
                (errors.FrameNotFinite, 'vertex 7', lambda: cageform.fit_skeleton(torn[5], frames, bones=2)),
                (errors.FaceWithoutVertex, 'face 3', lambda: cageform.fit_skeleton(rest, frames, wrong, bones=2)),
                (errors.InfluencesNotSupported, '', lambda: cageform.fit_skeleton(rest, frames, bones=2, influences=9)),
                (errors.ValueNotFinite, '', lambda: cageform.fit_skeleton(rest, frames, max_distance=np.nan)),
                (errors.Cancelled, '', lambda: cageform.fit_skeleton(rest, frames, bones=2, progress=lambda done: False)),
                (ValueError, 'influences.*0', lambda: cageform.fit_skeleton(rest, frames, bones=2, influences=0)),
                (ValueError, 'bones: -1', lambda: cageform.fit_skeleton(rest, frames, bones=-1)),
                (ValueError, "kind: .*'soft'", lambda: cageform.fit_skeleton(rest, frames, bones=2, kind='soft')),
                (ValueError, r'frames.*\(#frames, 22, 3\), not \(8, 11, 3\)',
                 lambda: cageform.fit_skeleton(rest, frames[:, ::2], bones=2)),
                (ValueError, r'rest.*\(22, 2\)', lambda: cageform.fit_skeleton(rest[:, :2], frames, bones=2)),
                (ValueError, r'faces.*\(#faces, 3\)', lambda: cageform.fit_skeleton(rest, frames, [0, 1, 2], bones=2)),
                (TypeError, 'fit_skeleton', cageform.Skeleton)):
            with self.assertRaisesRegex(kind, words):
                call()
        with self.assertRaises(errors.FrameNotFinite) as caught:
            cageform.fit_skeleton(rest, torn, bones=2)
        self.assertEqual((caught.exception.culprit, caught.exception.report.frame), (7, 5))

    def test_wraps(self):
        """A spheroid is laid on an ellipsoid by a lattice, and by a cage. Its coat follows; poses and Jacobians are those of the map."""
        (source, faces), (target, _) = ball((0.2, 0.2, 1)), ball((0.15, 0.25, 1.2))
        coat, marks = 1.1 * source, np.stack([source[[0, -1]], target[[0, -1]]], axis=1)
        steps = []
        wrap = cageform.wrap(source, faces, target, faces, marks, coat, weights=[1, 2], finest=12, threads=1, progress=steps.append)
        again = cageform.wrap(source.tolist(), faces, np.float32(target), faces.tolist(), marks, coat, weights=[1, 2], finest=12)
        self.assertLess(np.abs(wrap.move(coat) - again.move(coat)).max(), 1e-6)
        self.assertEqual((steps == sorted(steps), steps[-1], wrap.report.status, wrap.report.ended), (True, 1, 'ok', 'noise'))
        self.assertAlmostEqual(wrap.report.height, 2.4)
        self.assertLess(max(wrap.report.to_target_upper, wrap.report.to_source_upper), 0.01)
        self.assertIn('to target mean: ', str(wrap.report))
        coarse = cageform.wrap(source, faces, target, faces, handles=500, samples=1000).report
        self.assertEqual((coarse.left_out, coarse.samples < 1200), (12, True))
        misses = np.linalg.norm(wrap.move(marks[:, 0]) - marks[:, 1], axis=1) / 2.4
        self.assertAlmostEqual(misses.max(), wrap.report.miss)
        self.assertEqual(misses.argmax(), wrap.report.culprit)
        moved, turns = wrap.move(coat, jacobians=True)
        self.assertTrue((np.linalg.norm(moved / (0.15, 0.25, 1.2), axis=1) > 1).all(), 'the coat stays outside')
        aside = wrap.move(coat + (0, 1e-6, 0))
        np.testing.assert_allclose(turns @ (0, 1, 0), (aside - moved) / 1e-6, atol=1e-4)
        lattice = cageform.Coordinates(wrap.lattice).bind(coat @ wrap.first[:, :3].T + wrap.first[:, 3])
        np.testing.assert_allclose(lattice.figure.clone(wrap.lattice_pose), moved, atol=1e-9)
        self.assertEqual((wrap.move(np.float32(coat)).dtype, wrap.pose.shape), (np.float32, (0, 3)))

        coordinates = cageform.Coordinates(cageform.Cage.mesh(CUBE, TRIANGLES), dtype=np.float32)
        wrap = cageform.wrap(source, faces, target, faces, coordinates=coordinates, finest=6)
        self.assertEqual((wrap.lattice, wrap.pose.shape, wrap.pose.dtype), (None, (8, 3), np.float32))
        np.testing.assert_allclose(coordinates.bind(source).figure.clone(wrap.pose), wrap.move(source), atol=1e-6)
        del coordinates
        gc.collect()
        self.assertLess(wrap.report.to_target_upper, 0.05)
        self.assertLess(np.abs(wrap.move(source) - target).max(), 0.2)

    def test_wraps_refused(self):
        source, faces = ball((0.3, 0.3, 1))
        holed, beyond = source.copy(), faces.copy()
        holed[5, 1], beyond[7, 2] = np.nan, len(source)
        good, marks = (source, faces, source, faces), np.zeros((2, 2, 3))
        plane = cageform.Coordinates(cageform.Cage.polygon(SQUARE))
        for kind, words, call in (
                (errors.FigureNotFinite, 'target vertex 5', lambda: cageform.wrap(source, faces, holed, faces)),
                (errors.IndexOutOfRange, 'source face 7', lambda: cageform.wrap(source, beyond, source, faces)),
                (errors.FigureEmpty, '', lambda: cageform.wrap(source, faces, source, np.empty((0, 3), int))),
                (errors.WeightsNotPositive, 'landmark 1', lambda: cageform.wrap(*good, marks, weights=[1, -1])),
                (errors.ValueNotFinite, 'follower 5', lambda: cageform.wrap(*good, follow=holed)),
                (errors.ValueNotFinite, '', lambda: cageform.wrap(*good, floor=1)),
                (errors.DimensionDiffers, '', lambda: cageform.wrap(*good, coordinates=plane)),
                (errors.Cancelled, '', lambda: cageform.wrap(*good, progress=lambda done: False)),
                (ValueError, r'weights.*\(2,\), not \(3,\)', lambda: cageform.wrap(*good, marks, weights=[1, 2, 3])),
                (ValueError, 'weights: must be positive', lambda: cageform.wrap(*good, marks, weights=[0, 1])),
                (ValueError, r'landmarks.*\(#landmarks, 2, 3\), not \(2, 3\)', lambda: cageform.wrap(*good, marks[0])),
                (ValueError, r'target_faces.*\(#faces, 3\)', lambda: cageform.wrap(source, faces, source, faces[:, :2])),
                (ValueError, 'finest.*not 0', lambda: cageform.wrap(*good, finest=0)),
                (TypeError, 'wrap makes', cageform.Wrap)):
            with self.assertRaisesRegex(kind, words):
                call()
        with self.assertWarnsRegex(UserWarning, 'less than half'):
            wrap = cageform.wrap(source, faces, source, faces[:, ::-1], finest=6, least_stiffness=1e-2)
        self.assertEqual(wrap.report.status, 'fit_not_reached')
        self.assertGreater(wrap.report.unmatched_source, 0.5)
        with self.assertRaisesRegex(ValueError, r'points.*not \(7, 2\)'):
            wrap.move(np.zeros((7, 2)))

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
