"""Meshes follow their cages: all kinds, many meshes, many cages, all ways to move a cage."""

import unittest

import bmesh
import bpy
import numpy as np

from support import *


class Following(unittest.TestCase):
    def setUp(self):
        empty_scene()

    def test_suzanne(self):
        """Suzanne with 50,000 vertices agrees with the Python package, for every kind of coordinates."""
        figure = monkey(50000)
        self.assertGreater(len(figure.data.vertices), 45000)
        cage = bind(figure).cage
        rest = deform.rest_positions(cage)
        for kind in KINDS:
            move(cage, rest)
            figure.cageform.bindings[0].kind = kind
            select_only(figure)
            bpy.ops.cageform.bind()
            self.assertLess(off(key_of(figure), deform.rest_positions(figure)), 2e-7, 'at rest nothing moves, with ' + kind)
            pose = bent(rest)
            move(cage, pose)
            away = off(world(figure, key_of(figure)), expected(figure, cage, world(cage, rest), world(cage, pose), kind))
            print('  %s: difference from the package %.1e of the size' % (kind, away))
            self.assertLess(away, 1e-6, kind)
            self.assertLess(off(shown(figure), world(figure, key_of(figure))), 1e-6, 'Blender shows the shape key')

    def test_transforms(self):
        """Objects may be moved, rotated, scaled and mirrored in any way before a bind."""
        rng = np.random.default_rng(20261126)
        for case in range(6):
            empty_scene()
            figure, cage = monkey(500), box()
            figure.scale = (1.3, -0.8, 0.9) if case % 2 else (0.7, 1.1, 1.2)
            figure.rotation_euler, figure.location = rng.uniform(-1, 1, 3), rng.uniform(-9, 9, 3)
            bpy.context.view_layer.update()
            cage.location, cage.rotation_euler = figure.location, rng.uniform(-1, 1, 3)
            cage.scale = (-1.7, 1.9, 1.8) if case >= 3 else (1.8, 1.7, 1.9)
            bpy.context.view_layer.update()
            rest = deform.rest_positions(cage)
            binding = bind(figure, cage, kind='mean-value')
            self.assertEqual(binding.refused, '', 'case %d' % case)
            pose = bent(rest)
            move(cage, pose)
            wanted = expected(figure, cage, world(cage, rest), world(cage, pose), 'mean-value')
            self.assertLess(off(world(figure, key_of(figure)), wanted), 1e-6, 'case %d' % case)

    def test_objects_move(self):
        """A mesh follows a cage that moves as an object; a mesh that is a child of the cage moves once, not twice."""
        figure, cage = monkey(500, location=(2, 0, 1)), box(location=(2, 0, 1))
        bind(figure, cage)
        rest = shown(figure)
        cage.location, cage.rotation_euler, cage.scale = (5, 1, 0), (0.3, 0.2, 0.9), (1.2, 1.5, 0.9)
        bpy.context.view_layer.update()
        wanted = deform.moved(rest - (2, 0, 1), cage.matrix_world)
        self.assertLess(off(shown(figure), wanted), 1e-6)
        cage.location, cage.rotation_euler, cage.scale = (2, 0, 1), (0, 0, 0), (1, 1, 1)
        bpy.context.view_layer.update()
        self.assertLess(off(shown(figure), rest), 1e-6, 'and back')
        figure.parent, figure.matrix_parent_inverse = cage, cage.matrix_world.inverted()
        cage.location, cage.rotation_euler, cage.scale = (5, 1, 0), (0.3, 0.2, 0.9), (1.2, 1.5, 0.9)
        bpy.context.view_layer.update()
        self.assertLess(off(shown(figure), wanted), 1e-6, 'as a child')
        figure.location.x += 3
        bpy.context.view_layer.update()
        self.assertLess(off(shown(figure), wanted), 1e-6, 'a mesh that moves alone stays in its cage')

    def test_parts_on_one_cage(self):
        """A character of several objects follows one cage; one call makes this cage around all objects."""
        parts = []
        for location, scale in (((0, 0, 0), (0.5, 0.3, 0.7)), ((0, 0, 1), (0.3, 0.3, 0.3)), ((0.7, 0, 0.3), (0.4, 0.1, 0.1)),
                                ((-0.7, 0, 0.3), (0.4, 0.1, 0.1)), ((0, -0.25, 1), (0.1, 0.1, 0.1))):
            bpy.ops.mesh.primitive_uv_sphere_add(location=location, segments=24, ring_count=12)
            bpy.context.object.scale = scale
            parts.append(bpy.context.object)
        bpy.context.view_layer.update()
        select_only(*parts)
        bpy.ops.cageform.make_cage(vertices=80)
        cages = {part.cageform.bindings[0].cage for part in parts}
        self.assertEqual(len(cages), 1, 'all parts have one cage')
        cage = cages.pop()
        for part in parts:
            select_only(part)
            bpy.ops.cageform.bind()
        rest = deform.rest_positions(cage)
        pose = bent(rest, 0.2)
        move(cage, pose)
        for part in parts:
            wanted = expected(part, cage, world(cage, rest), world(cage, pose))
            self.assertLess(off(world(part, key_of(part)), wanted), 2e-6, part.name)

    def test_seam(self):
        """The seam between two halves of a mesh, objects with different transforms, stays closed."""
        whole, cage = monkey(2000), box()
        points, halves = deform.rest_positions(whole), []
        for sign in (-1, 1):
            half = whole.copy()
            half.data = whole.data.copy()
            bpy.context.collection.objects.link(half)
            half.location, half.rotation_euler, half.scale = (sign, 2, 3), (0.3 * sign, 1, 0), (1, 1 + 0.5 * sign, 1)
            bpy.context.view_layer.update()
            inverse = np.array(half.matrix_world.inverted())
            half.data.vertices.foreach_set('co', np.float32(deform.moved(points.astype(np.float64), inverse)).ravel())
            half.data.update()
            halves.append(half)
        rest = deform.rest_positions(cage)
        for half in halves:
            bind(half, cage)
        move(cage, bent(rest, 0.2))
        placed = [shown(half) for half in halves]
        self.assertGreater(off(placed[0], points), 0.05)
        self.assertLess(off(placed[0], placed[1]), 1e-5)

    def test_several_cages(self):
        """The displacements of several cages of a mesh add up; cages can be removed one by one."""
        figure = monkey(2000)
        left, right = box('Left', 1.5, (-1, 0, 0.3)), box('Right', 1.5, (1, 0, 0.3))
        for cage in (left, right):
            bind(figure, cage, kind='harmonic')
        self.assertEqual(len(figure.cageform.bindings), 2)
        rest = deform.rest_positions(figure)
        for cage, amount in ((left, 0.4), (right, 0.2)):
            move(cage, bent(deform.rest_positions(cage), amount))
        both = rest + (key_of(figure, 0) - rest) + (key_of(figure, 1) - rest)
        self.assertGreater(np.abs(key_of(figure, 0) - rest).max(), 0.05)
        self.assertGreater(np.abs(key_of(figure, 1) - rest).max(), 0.05)
        self.assertLess(off(shown(figure), both), 1e-6)
        figure.cageform.active = 0
        alone = key_of(figure, 1)
        bpy.ops.cageform.remove_cage()
        bpy.context.view_layer.update()
        self.assertLess(off(shown(figure), alone), 1e-6, 'the other cage still moves the mesh')
        bpy.ops.cageform.remove_cage()
        bpy.context.view_layer.update()
        np.testing.assert_array_equal(deform.positions(figure.data), rest)
        self.assertEqual(len(figure.constraints), 0, 'nothing is left')
        self.assertEqual([key.name for key in figure.data.shape_keys.key_blocks], ['Basis'])
        self.assertEqual([text.name for text in bpy.data.texts], [])

    def follows(self, figure, cage, rest, what):
        """The mesh agrees with the package for the shown cage. The cage was bound at the origin."""
        pose = shown(cage)
        self.assertGreater(np.abs(pose - rest).max(), 0.05, what + ': the cage has moved')
        self.assertLess(off(shown(figure), expected(figure, cage, rest, pose)), 2e-6, what)

    def test_edit_mode(self):
        """The mesh follows while the cage is in edit mode."""
        figure, cage = monkey(2000), box()
        rest = deform.rest_positions(cage)
        bind(figure, cage)
        select_only(cage)
        bpy.ops.object.mode_set(mode='EDIT')
        for step in range(3):
            mesh = bmesh.from_edit_mesh(cage.data)
            for vertex in mesh.verts:
                if vertex.co.z > 0:
                    vertex.co.x += 0.3
            bmesh.update_edit_mesh(cage.data)
            bpy.context.view_layer.update()
            self.follows(figure, cage, rest, 'in edit mode, step %d' % step)
        bpy.ops.object.mode_set(mode='OBJECT')
        bpy.context.view_layer.update()
        self.follows(figure, cage, rest, 'after edit mode')

    def test_playback(self):
        """The mesh follows a cage that is animated by shape keys, as an object, or by an armature, also a hidden one."""
        figure, cage = monkey(2000), box()
        rest = deform.rest_positions(cage)
        bind(figure, cage)
        key = deform.add_key(cage, 'bend')
        deform.write_key(key, bent(rest, 0.1))
        for frame, value in ((1, 0.4), (20, 1)):
            key.value = value
            key.keyframe_insert('value', frame=frame)
        scene = bpy.context.scene
        self.play(figure, cage, rest, 'shape keys')
        for frame, x in ((1, 0.2), (20, 0.9)):
            cage.location.x = x
            cage.keyframe_insert('location', frame=frame)
        self.play(figure, cage, rest, 'a moving object')
        bpy.ops.object.armature_add()
        armature = bpy.context.object
        modifier = cage.modifiers.new('Armature', 'ARMATURE')
        modifier.object = armature
        group = cage.vertex_groups.new(name='Bone')
        group.add([index for index, point in enumerate(rest) if point[2] > 0], 1, 'REPLACE')
        bone = armature.pose.bones['Bone']
        bone.rotation_mode = 'XYZ'
        for frame, angle in ((1, 0), (20, 0.7)):
            bone.rotation_euler.x = angle
            bone.keyframe_insert('rotation_euler', frame=frame)
        self.play(figure, cage, rest, 'an armature')
        self.assertGreater(np.abs(self.last - rest)[:, 1].max(), 0.3, 'the armature moves the cage')
        cage.hide_viewport = True
        before = shown(figure)
        scene.frame_set(1)
        scene.frame_set(20)
        self.assertLess(off(shown(figure), before), 1e-6, 'a cage hidden in the viewport')
        scene.frame_set(7)
        self.assertGreater(off(shown(figure), before), 1e-2)

    def play(self, figure, cage, rest, what):
        for frame in (1, 5, 12, 20):
            bpy.context.scene.frame_set(frame)
            self.follows(figure, cage, rest, '%s, frame %d' % (what, frame))
        self.last = shown(cage)

    def test_render(self):
        """Renders show the deformed mesh; the cage is not rendered."""
        figure = monkey(500)
        cage = bind(figure).cage
        self.assertTrue(cage.hide_render)
        rest = deform.rest_positions(cage)
        key = deform.add_key(cage, 'bend')
        deform.write_key(key, bent(rest))
        for frame, value in ((1, 0), (3, 1)):
            key.value = value
            key.keyframe_insert('value', frame=frame)
        scene, wanted = bpy.context.scene, {}
        for frame in (1, 2, 3):
            scene.frame_set(frame)
            wanted[frame] = shown(figure)
        scene.frame_set(1)
        rendered = {}

        def record(scene, depsgraph):
            if depsgraph.mode == 'RENDER':
                rendered[scene.frame_current] = key_of(figure)

        bpy.app.handlers.frame_change_post.append(record)
        bpy.ops.object.camera_add(location=(0, -6, 0), rotation=(1.57, 0, 0))
        scene.camera = bpy.context.object
        scene.render.engine = 'CYCLES'
        scene.cycles.samples, scene.cycles.use_denoising = 1, False
        scene.render.resolution_x = scene.render.resolution_y = 8
        scene.frame_start, scene.frame_end, scene.render.filepath = 1, 3, folder + '/frame_'
        try:
            bpy.ops.render.render(animation=True)
        finally:
            bpy.app.handlers.frame_change_post.remove(record)
        self.assertEqual(sorted(rendered), [1, 2, 3])
        for frame, points in rendered.items():
            self.assertLess(off(points, wanted[frame]), 1e-6, 'frame %d' % frame)

    def test_modifiers(self):
        """Modifiers of the mesh apply after the cage. Modifiers of the cage may move its vertices but not add any."""
        figure, cage = monkey(500), box()
        figure.modifiers.new('Before', 'SUBSURF').levels = 1
        binding = bind(figure, cage)
        figure.modifiers.new('After', 'MIRROR')
        plain = len(figure.data.vertices)
        move(cage, bent(deform.rest_positions(cage)))
        self.assertGreater(len(shown(figure)), 4 * plain, 'both modifiers work')
        self.assertGreater(np.abs(key_of(figure) - deform.rest_positions(figure)).max(), 0.05)
        cage.modifiers.new('Subdivision', 'SUBSURF')
        bpy.context.view_layer.update()
        print('  ' + binding.fault)
        self.assertIn('turn these modifiers off', binding.fault)
        cage.modifiers.clear()
        bpy.context.view_layer.update()
        self.assertEqual(binding.fault, '')

    def test_shape_keys_of_the_mesh(self):
        """Other shape keys of the mesh add to the displacements of the cage."""
        figure, cage = monkey(500), box()
        smile = deform.add_key(figure, 'smile')
        rest = deform.rest_positions(figure)
        deform.write_key(smile, rest + (0, 0.2, 0))
        bind(figure, cage)
        move(cage, bent(deform.rest_positions(cage)))
        self.assertLess(off(shown(figure), key_of(figure) + np.array((0, 0.2, 0))), 1e-6)

    def test_outside(self):
        """Vertices outside are counted, can be selected, and move as the setting says."""
        figure, cage = monkey(500), box(size=1.5)
        rest = deform.rest_positions(figure)
        for kind, outside, stay in (('mean-value', 'keep_in_place', True), ('mean-value', 'nearest_boundary', False),
                                    ('mean-value', 'extend', False), ('maximum-entropy', 'extend', True)):
            figure.cageform.bindings.clear()
            binding = bind(figure, cage, kind=kind, outside=outside)
            lies_outside = (np.abs(rest) > 0.75).any(axis=1)
            words = 'Vertices outside the cage: %d. They %s.' % (lies_outside.sum(), 'stay' if stay else 'follow')
            self.assertIn(words, binding.report)
            cage.location.x += 0.3
            bpy.context.view_layer.update()
            stays = (np.abs(key_of(figure) - rest).max(axis=1) < 1e-4)
            self.assertEqual(bool(stays[lies_outside].all()), stay, (kind, outside))
            cage.location.x -= 0.3
            bpy.context.view_layer.update()
        select_only(figure)
        bpy.ops.cageform.select_outside()
        bpy.ops.object.mode_set(mode='OBJECT')
        np.testing.assert_array_equal([vertex.select for vertex in figure.data.vertices], lies_outside)
