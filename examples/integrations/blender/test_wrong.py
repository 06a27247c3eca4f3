"""Wrong input gives a message and never crashes. Prints the messages."""

import unittest

import bmesh
import bpy
import numpy as np

from support import *


class Wrong(unittest.TestCase):
    def setUp(self):
        empty_scene()
        self.figure, self.cage = monkey(500), box('Cage')

    def says(self, words, operator=bpy.ops.cageform.bind, **options):
        """An operator fails with a message."""
        select_only(self.figure)
        with self.assertRaises(RuntimeError) as caught:
            operator(**options)
        text = str(caught.exception).strip().replace('Error: ', '')
        print('  ' + text)
        self.assertIn(words, text)
        self.assertRegex(text, r'^[A-Z0-9].*\.$', 'a sentence')
        return text

    def use(self, cage):
        select_only(self.figure)
        bpy.ops.cageform.add_cage()
        binding = self.figure.cageform.bindings[self.figure.cageform.active]
        binding.cage = cage
        return binding

    def faces_away(self, cage, count):
        mesh = bmesh.new()
        mesh.from_mesh(cage.data)
        mesh.faces.ensure_lookup_table()
        bmesh.ops.delete(mesh, geom=mesh.faces[:count], context='FACES_ONLY')
        mesh.to_mesh(cage.data)
        mesh.free()

    def test_no_cage(self):
        self.use(None)
        self.says('There is no cage')

    def test_cage_deleted(self):
        self.use(self.cage)
        select_only(self.cage)
        bpy.ops.object.delete()
        self.says('There is no cage')

    def test_itself(self):
        binding = self.use(self.figure)
        self.says('The cage is the mesh itself')
        self.assertIn('itself', binding.refused, 'the panel shows it too')
        twin = self.figure.copy()
        bpy.context.collection.objects.link(twin)
        binding.cage = twin
        self.says('single-user')

    def test_twice(self):
        self.use(self.cage)
        self.rebind()
        self.use(self.cage)
        self.says('already moves the mesh')

    def test_open_cage(self):
        """A cage with a small gap is closed, with a warning; an open cage is an error. Its faults can be selected."""
        self.faces_away(self.cage, 1)
        self.use(self.cage)
        self.rebind()
        report = self.figure.cageform.bindings[0].report
        print('  ' + report.replace('\n', '\n  '))
        self.assertIn('Warnings about the cage: 4.', report)
        bpy.ops.cageform.select_faults()
        bpy.ops.object.mode_set(mode='OBJECT')
        self.assertEqual(sum(vertex.select for vertex in self.cage.data.vertices), 4)
        select_only(self.figure)
        bpy.ops.cageform.remove_cage()
        self.figure.shape_key_clear()
        self.faces_away(self.cage, 2)
        binding = self.use(self.cage)
        self.assertEqual(self.says('').rstrip('.'), binding.refused.rstrip('.'))
        self.assertIsNone(self.figure.data.shape_keys)
        bpy.ops.cageform.select_faults()
        self.assertEqual((bpy.context.object, bpy.context.mode), (self.cage, 'EDIT_MESH'))
        bpy.ops.object.mode_set(mode='OBJECT')
        self.assertGreater(sum(vertex.select for vertex in self.cage.data.vertices), 0, 'something is selected')
        self.cage.data.clear_geometry()
        self.cage.data.from_pydata(*self.closed())
        self.rebind()
        self.assertEqual(binding.refused, '', 'a repaired cage binds, and the message disappears')

    def closed(self):
        bpy.ops.mesh.primitive_cube_add(size=3)
        mesh = bpy.context.object.data
        parts = [vertex.co[:] for vertex in mesh.vertices], [], [list(face.vertices) for face in mesh.polygons]
        bpy.data.objects.remove(bpy.context.object)
        return parts

    def rebind(self):
        select_only(self.figure)
        bpy.ops.cageform.bind()

    def test_crossing_cage(self):
        pose = deform.rest_positions(self.cage)
        pose[pose[:, 2] > 0] *= (1, 1, -1.2)
        pose[0] = (9, 9, 9)
        move(self.cage, pose)
        self.use(self.cage)
        self.says('')
        bpy.ops.cageform.select_faults()
        bpy.ops.object.mode_set(mode='OBJECT')

    def test_inside_out(self):
        """The orientation of the normals of a cage does not change the motion of the mesh."""
        binding, rest, moved = self.use(self.cage), deform.rest_positions(self.cage), {}
        for inwards in (False, True):
            for kind in KINDS:
                binding.kind = kind
                self.rebind()
                move(self.cage, bent(rest, 0.1))
                moved[kind, inwards] = key_of(self.figure)
                move(self.cage, rest)
            self.cage.data.flip_normals()
        for kind in KINDS:
            self.assertLess(off(moved[kind, True], moved[kind, False]), 1e-4, kind)

    def test_flat_and_empty(self):
        """Meshes without vertices, without faces, without volume, and without size."""
        self.use(self.cage)
        square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        for vertices, faces in (([], []), ([(0, 0, 0)] * 4, []), (square, [(0, 1, 2, 3)])):
            self.cage.data.clear_geometry()
            self.cage.data.from_pydata(vertices, [], faces)
            self.says('')
        self.figure.data.clear_geometry()
        self.says('The mesh has no vertices')
        self.says('', bpy.ops.cageform.make_cage)
        self.figure.data.from_pydata([(1, 2, 3)], [], [])
        self.says('', bpy.ops.cageform.make_cage)

    def test_scale_of_nothing(self):
        self.use(self.cage)
        for item in (self.figure, self.cage):
            item.scale.y = 0
            bpy.context.view_layer.update()
            self.says('scale')
            item.scale.y = 1
        bpy.context.view_layer.update()
        self.rebind()

    def test_not_finite(self):
        """A vertex that is not finite does not move and is counted; a cage with such a vertex is an error."""
        self.figure.data.vertices[3].co.x = float('nan')
        binding = self.use(self.cage)
        self.rebind()
        print('  ' + binding.report.replace('\n', '\n  '))
        self.assertIn('Vertices with a position that is not finite: 1.', binding.report)
        move(self.cage, bent(deform.rest_positions(self.cage), 0.1))
        points = key_of(self.figure)
        self.assertTrue(np.isfinite(np.delete(points, 3, axis=0)).all())
        self.assertGreater(np.nanmax(np.abs(points - deform.rest_positions(self.figure))), 0.01)
        self.cage.data.vertices[0].co.x = float('nan')
        self.cage.data.update()
        bpy.context.view_layer.update()
        print('  ' + binding.fault)
        self.assertNotEqual(binding.fault, '', 'a pose that is not finite is not shown')
        np.testing.assert_array_equal(key_of(self.figure), points)
        self.says('')

    def test_outside_entirely(self):
        self.cage.location.x = 50
        bpy.context.view_layer.update()
        binding = self.use(self.cage)
        self.rebind()
        print('  ' + binding.report.replace('\n', '\n  '))
        self.assertIn('Vertices outside the cage: 507. They stay', binding.report)

    def test_topology(self):
        """The panel shows that the numbers of vertices of mesh or cage changed; after undo the mesh follows again."""
        binding = self.use(self.cage)
        self.rebind()
        for item, words in ((self.figure, 'The mesh has'), (self.cage, 'The cage has')):
            before = item.data
            item.data = before.copy()
            mesh = bmesh.new()
            mesh.from_mesh(item.data)
            bmesh.ops.subdivide_edges(mesh, edges=mesh.edges[:3], cuts=1)
            mesh.to_mesh(item.data)
            mesh.free()
            bpy.context.view_layer.update()
            print('  ' + binding.fault)
            self.assertIn(words, binding.fault)
            self.assertIn('bind again', binding.fault)
            self.says(words, bpy.ops.cageform.write_figure, filepath=folder + '/never')
            item.data = before
            bpy.context.view_layer.update()
            self.assertEqual(binding.fault, '')

    def test_edited_mesh(self):
        """Moving vertices of the mesh in edit mode requires a new bind; entering edit mode does not."""
        binding = self.use(self.cage)
        self.rebind()
        for by, words in ((0, ''), (0.2, 'bind again')):
            select_only(self.figure)
            self.figure.active_shape_key_index = 0
            bpy.ops.object.mode_set(mode='EDIT')
            mesh = bmesh.from_edit_mesh(self.figure.data)
            mesh.verts.ensure_lookup_table()
            mesh.verts[7].co.x += by
            bmesh.update_edit_mesh(self.figure.data)
            bpy.context.view_layer.update()
            bpy.ops.object.mode_set(mode='OBJECT')
            bpy.context.view_layer.update()
            print('  ' + binding.fault)
            self.assertIn(words, binding.fault)
        self.assertNotEqual(binding.fault, '')
        self.rebind()
        bpy.context.view_layer.update()
        self.assertEqual(binding.fault, '')

    def test_key_deleted(self):
        binding = self.use(self.cage)
        self.rebind()
        self.figure.shape_key_clear()
        bpy.context.view_layer.update()
        print('  ' + binding.fault)
        self.assertIn('The shape key "Cageform" is gone', binding.fault)
        self.rebind()
        self.assertEqual(binding.fault, '')

    def test_absolute_keys(self):
        binding = self.use(self.cage)
        self.rebind()
        self.figure.data.shape_keys.use_relative = False
        bpy.context.view_layer.update()
        print('  ' + binding.fault)
        self.assertIn('Relative', binding.fault)

    def test_not_a_mesh(self):
        """The operators work only on meshes; only meshes can be cages."""
        bpy.ops.object.camera_add()
        for operator in (bpy.ops.cageform.bind, bpy.ops.cageform.add_cage, bpy.ops.cageform.make_cage, bpy.ops.cageform.bake,
                         bpy.ops.cageform.add_pins, bpy.ops.cageform.write_figure, bpy.ops.cageform.write_gltf):
            self.assertFalse(operator.poll(), operator.idname())

    def test_hidden(self):
        """A mesh can be bound to a hidden cage, and follows it."""
        self.cage.hide_set(True)
        self.cage.hide_viewport = True
        binding = self.use(self.cage)
        self.rebind()
        before = shown(self.figure)
        self.cage.location.x += 1
        bpy.context.view_layer.update()
        self.assertLess(np.abs(shown(self.figure) - before - (1, 0, 0)).max(), 1e-5, binding.fault)
