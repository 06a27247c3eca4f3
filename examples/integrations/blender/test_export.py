"""Exports contain the motion that Blender shows: shape keys, glTF, packed figures."""

import os
import unittest

import bpy
import numpy as np

from support import *


class Export(unittest.TestCase):
    def setUp(self):
        """A monkey with a cage that bends and moves in ten frames."""
        self.figure = bound_monkey(500)
        self.figure.rotation_euler.z, self.figure.scale = 0.4, (1.2, 1.2, 1.2)
        bpy.context.view_layer.update()
        self.cage = self.figure.cageform.bindings[0].cage
        select_only(self.figure)
        bpy.ops.cageform.bind()
        key = deform.add_key(self.cage, 'bend')
        deform.write_key(key, bent(deform.rest_positions(self.cage)))
        for frame, value in ((1, 0), (10, 1)):
            key.value = value
            key.keyframe_insert('value', frame=frame)
            self.cage.location.x += value
            self.cage.keyframe_insert('location', frame=frame)
        self.scene = bpy.context.scene
        self.scene.frame_start, self.scene.frame_end = 1, 10
        self.wanted = {}
        for frame in range(1, 11):
            self.scene.frame_set(frame)
            self.wanted[frame] = shown(self.figure)
        self.assertGreater(off(self.wanted[10], self.wanted[1]), 0.1)
        select_only(self.figure)

    def assert_plays(self, figure, step, what):
        for frame in range(1, 11, step):
            self.scene.frame_set(frame)
            self.assertLess(off(shown(figure), self.wanted[frame]), 2e-6, '%s, frame %d' % (what, frame))

    def test_bake(self):
        """Baked shape keys play without the cage. A second bake replaces the first, and no other animation."""
        smile = deform.add_key(self.figure, 'smile')
        smile.value = 0
        smile.keyframe_insert('value', frame=1)
        own = smile.id_data.animation_data.action.fcurves[0].keyframe_points[0]
        own.interpolation = 'CONSTANT'
        for step in (3, 1):
            bpy.ops.cageform.bake(step=step)
            names = [key.name for key in self.figure.data.shape_keys.key_blocks if key.name.startswith('Cageform frame')]
            self.assertEqual(len(names), len(range(1, 11, step)))
            self.assertTrue(deform.key_of(self.figure.cageform.bindings[0]).mute)
            self.assert_plays(self.figure, step, 'baked, step %d' % step)
        self.assertEqual(own.interpolation, 'CONSTANT', 'other keyframes stay')
        bpy.data.objects.remove(self.cage)
        self.assert_plays(self.figure, 1, 'without the cage')

    def test_gltf(self):
        """glTF contains the motion: Blender's importer reads the same positions."""
        path, before = os.path.join(folder, 'monkey.glb'), {item.name for item in bpy.data.objects}
        bpy.ops.cageform.write_gltf(filepath=path, step=1)
        self.assertEqual({item.name for item in bpy.data.objects}, before, 'nothing is left in the scene')
        self.assertEqual(bpy.context.object, self.figure)
        self.assert_plays(self.figure, 3, 'the scene still plays')
        np.bool = bool  # the importer of Blender 3.4 uses it; numpy 1.24 of Debian no longer has it
        bpy.ops.import_scene.gltf(filepath=path)
        read = bpy.context.object
        self.assertEqual(read.type, 'MESH')
        for frame in (1, 4, 10):
            self.scene.frame_set(frame)
            points, wanted = shown(read), self.wanted[frame]  # the exporter splits vertices at seams of texture coordinates
            distances = [np.linalg.norm(points - point, axis=1).min() for point in wanted]
            self.assertLess(max(distances), 1e-5 * np.ptp(wanted, axis=0).max(), 'frame %d' % frame)
            distances = [np.linalg.norm(wanted - point, axis=1).min() for point in points]
            self.assertLess(max(distances), 1e-5 * np.ptp(wanted, axis=0).max(), 'frame %d' % frame)

    def test_figure(self):
        """A packed figure has the mesh, its normals and the motion as a clip, within the tolerance."""
        path = os.path.join(folder, 'monkey.figure')
        bpy.ops.cageform.write_figure(filepath=path, loss=1e-4)
        figure = library.open(path)
        self.assertEqual((figure.points, figure.clips, figure.has_normals), (len(self.figure.data.vertices), 1, True))
        clip = figure.clip('scene')
        binding = self.figure.cageform.bindings[0]
        for frame in (1, 4, 7, 10):
            seconds = (frame - 1) * self.scene.render.fps_base / self.scene.render.fps
            points, normals = figure.clone(figure.pose_handles(clip.sample(seconds)), normals=True)
            points = deform.moved(points, np.linalg.inv(deform.matrix_of(binding, 'from_mesh')))
            self.assertLess(off(world(self.figure, points), self.wanted[frame]), 3e-3, 'frame %d' % frame)
        normals = figure.clone(figure.rest(), normals=True)[1]
        turned = np.array(self.figure.matrix_world.to_3x3()) / 1.2
        own = np.array([turned @ vertex.normal for vertex in self.figure.data.vertices])
        self.assertGreater((normals * own).sum(axis=1).min(), 0.999, 'normals agree with the scene')
        bpy.ops.cageform.write_figure(filepath=path, clip=False)
        self.assertEqual(library.open(path).clips, 0)
        with self.assertRaisesRegex(RuntimeError, 'The file cannot be written'):
            bpy.ops.cageform.write_figure(filepath=os.path.join(folder, 'no folder', 'monkey.figure'))
        self.assertEqual([name for name in os.listdir(folder) if name.endswith('.part')], [], 'nothing is half-written')
