"""A mesh is laid on another, and clothes follow."""

import unittest
import warnings

import bpy
import numpy as np

from cageform import wrap_operator
from support import *


def ball(name, scale, **place):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=18, ring_count=10, **place)
    item = bpy.context.object
    item.name, item.scale = name, scale
    bpy.context.view_layer.update()
    return item


class Wrap(unittest.TestCase):
    def setUp(self):
        empty_scene()
        self.source, self.coat = ball('Source', (0.2, 0.2, 1)), ball('Coat', (0.22, 0.22, 1.08))
        self.target = ball('Target', (0.15, 0.25, 1.2))

    def wrap(self, *followers, **options):
        select_only(*followers, self.source)
        return bpy.ops.cageform.wrap_onto(detail='12', **options)

    def far(self, points):
        """Returns how far points are from the target, relative to its size; positive outside."""
        return np.linalg.norm(points / np.array(self.target.scale), axis=1) - 1

    def test_wrapped(self):
        """The mesh lies on the target, and clothes stay outside. Another run gives the same shape key."""
        rest = deform.rest_positions(self.source)
        self.wrap(self.coat, target='Target')
        self.assertLess(np.abs(self.far(shown(self.source))).max(), 0.04)
        self.assertGreater(self.far(shown(self.coat)).min(), 0)
        np.testing.assert_array_equal(deform.rest_positions(self.source), rest)
        before = shown(self.source)
        self.wrap(self.coat, target='Target')
        np.testing.assert_array_equal(shown(self.source), before)
        self.assertEqual([key.name for key in self.source.data.shape_keys.key_blocks], ['Basis', wrap_operator.NAME])
        self.assertIsNone(self.target.data.shape_keys)

    def test_package(self):
        """Objects may be moved, scaled and mirrored. The target is taken as shown. The package gives the same positions."""
        self.source.scale.x *= -1
        self.source.location, self.source.rotation_euler = (3, 2, 1), (0, 0, 0.4)
        self.target.modifiers.new('Subdivision', 'SUBSURF').levels = 1
        self.target.location = (-4, 1, 0)
        bpy.context.view_layer.update()
        rest = world(self.source, deform.rest_positions(self.source))
        self.wrap(self.target)  # the only other selected mesh
        faces = np.array([list(face.vertices)[::-1] for face in self.source.data.loop_triangles])
        evaluated = self.target.evaluated_get(bpy.context.evaluated_depsgraph_get())
        mesh = evaluated.to_mesh()
        mesh.calc_loop_triangles()
        wanted_faces = np.array([list(face.vertices) for face in mesh.loop_triangles])
        wanted = world(self.target, deform.positions(mesh))
        evaluated.to_mesh_clear()
        wrap = library.wrap(rest, faces, wanted, wanted_faces, finest=12)
        self.assertEqual(wrap.report.status, 'ok')
        self.assertLess(off(shown(self.source), wrap.move(rest)), 1e-6)

    def test_bad_fit(self):
        """A target inside out gives a warning; the result is there all the same."""
        self.source.scale = self.target.scale = 0.3, 0.3, 1
        self.target.data.flip_normals()
        with warnings.catch_warnings(record=True) as told:
            self.wrap(target='Target')
        self.assertIn('less than half', ' '.join(str(each.message) for each in told))
        self.assertIsNotNone(deform.find_key(self.source, wrap_operator.NAME))

    def test_refused(self):
        """Wrong selections and meshes give a message with a remedy, and change nothing."""
        self.refused('Choose the mesh to lie on', lambda: self.wrap())
        self.refused('Choose the mesh to lie on', lambda: self.wrap(target='nothing'))
        self.refused('Choose the mesh to lie on', lambda: self.wrap(self.coat, self.target))
        self.refused('another mesh', lambda: self.wrap(target='Source'))
        self.target.data.clear_geometry()
        self.refused('"Target" has no faces', lambda: self.wrap(target='Target'))
        deform.add_key(self.coat, 'smile')
        self.coat.data.shape_keys.use_relative = False
        self.refused('turn on Relative', lambda: self.wrap(self.coat, target='Target'))
        self.assertIsNone(self.source.data.shape_keys)

    def refused(self, words, call):
        with self.assertRaises(RuntimeError) as caught:
            call()
        print('  ' + str(caught.exception).strip())
        self.assertIn(words, str(caught.exception))
