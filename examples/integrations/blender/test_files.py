"""Bindings stored in the .blend file: saving, undo, renaming, duplicates, links."""

import os
import unittest

import bpy
import numpy as np

from support import *


def push(what):
    """Adds an undo step, as the window does after a command; in background mode Blender adds none."""
    bpy.ops.ed.undo_push(message=what)


class Files(unittest.TestCase):
    def setUp(self):
        empty_scene()
        self.figure, self.cage = monkey(500), box('Cage')

    def posed(self):
        """Binds and bends, and returns the shown vertices."""
        bind(self.figure, self.cage)
        move(self.cage, bent(deform.rest_positions(self.cage), 0.1))
        return shown(self.figure)

    def save(self, name='scene.blend'):
        path = os.path.join(folder, name)
        bpy.ops.wm.save_as_mainfile(filepath=path)
        return path

    def find(self):
        self.figure, self.cage = bpy.data.objects.get('Suzanne'), bpy.data.objects.get('Cage')

    def assert_follows(self, what, figure=None, cage=None):
        """The mesh follows another pose of the cage."""
        figure, cage = figure or self.figure, cage or self.cage
        before = shown(figure)
        move(cage, deform.rest_positions(cage) + (0.25, 0, 0))
        step = shown(figure) - before
        self.assertLess(np.abs(np.abs(step).max() - 0.25), 0.05, what)

    def test_saved(self):
        """A saved file opens with bitwise equal positions and one hidden text per binding, and the mesh still follows."""
        self.posed()
        key = key_of(self.figure)
        report = self.figure.cageform.bindings[0].report
        path = self.save()
        bpy.ops.wm.open_mainfile(filepath=path)
        self.find()
        np.testing.assert_array_equal(key_of(self.figure), key)
        self.assertEqual(len(bpy.data.texts), len(self.figure.cageform.bindings))
        self.assertIn('Bound 507 vertices', report)
        self.assert_follows('after opening')

    def test_undo(self):
        """Undo and redo of a bind, a pose, and an unbind."""
        push('begin')
        rest = shown(self.figure)
        bind(self.figure, self.cage)
        push('bind')
        move(self.cage, bent(deform.rest_positions(self.cage), 0.1))
        push('pose')
        posed = shown(self.figure)
        select_only(self.figure)
        bpy.ops.cageform.remove_cage()
        push('unbind')
        self.assertEqual(len(self.figure.cageform.bindings), 0)

        self.undo()
        self.assertLess(off(shown(self.figure), posed), 1e-6, 'undo of an unbind')
        self.assert_follows('after undo of an unbind')
        self.undo()  # to the last step, the bind; assert_follows adds no step
        self.assertLess(off(shown(self.figure), rest), 1e-6, 'undo of a pose')
        self.assert_follows('after undo of a pose')
        self.undo()
        self.assertEqual(len(self.figure.cageform.bindings), 0, 'undo of a bind')
        self.assertIsNone(self.figure.data.shape_keys)
        self.redo()
        self.assertEqual(len(self.figure.cageform.bindings), 1, 'redo of a bind')
        self.assert_follows('after redo of a bind')
        self.redo()
        self.assertLess(off(shown(self.figure), posed), 1e-6, 'redo of a pose')
        self.redo()
        self.assertEqual(len(self.figure.cageform.bindings), 0, 'redo of an unbind')
        self.assertLess(off(shown(self.figure), rest), 1e-6)

    def undo(self):
        bpy.ops.ed.undo()
        bpy.context.view_layer.update()
        self.find()

    def redo(self):
        bpy.ops.ed.redo()
        bpy.context.view_layer.update()
        self.find()

    def test_renamed(self):
        """Objects, meshes and texts may be renamed."""
        self.posed()
        self.figure.name, self.cage.name, self.figure.data.name, self.cage.data.name = 'A', 'B', 'C', 'D'
        self.figure.cageform.bindings[0].data.name = 'E'
        self.assert_follows('renamed')

    def test_deleted(self):
        """Deleting a cage keeps the mesh as it is; undo restores the cage. Deleting a mesh also deletes its weights."""
        self.posed()
        push('pose')
        select_only(self.cage)
        bpy.ops.object.delete()
        push('delete')
        before = shown(self.figure)
        bpy.context.view_layer.update()
        print('  ' + self.figure.cageform.bindings[0].fault)
        self.assertIn('The cage is gone', self.figure.cageform.bindings[0].fault)
        np.testing.assert_array_equal(shown(self.figure), before)
        self.undo()
        self.assert_follows('after undo of a deletion')
        self.assertEqual(self.figure.cageform.bindings[0].fault, '')
        select_only(self.figure)
        bpy.ops.object.delete()
        bpy.context.view_layer.update()
        path = self.save('deleted.blend')
        bpy.ops.wm.open_mainfile(filepath=path)
        self.assertEqual(len(bpy.data.texts), 0, 'no weights are left in the file')

    def test_two_of_a_name(self):
        """Two cages with one name, one of them in another file, are not confused."""
        path = os.path.join(folder, 'cage.blend')
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
        binding = bind(self.figure, self.cage)
        with bpy.data.libraries.load(path, link=True) as (there, here):
            here.objects = ['Cage']
        linked = next(item for item in bpy.data.objects if item.library is not None)
        self.assertEqual(linked.name, self.cage.name)
        bpy.context.collection.objects.link(linked)
        bpy.context.view_layer.update()
        self.assertEqual(binding.cage, self.cage)
        self.assert_follows('beside a linked cage')
        other = monkey(500)
        bind(other, linked)
        self.assertEqual(other.cageform.bindings[0].cage, linked)
        self.assertLess(off(shown(other), deform.rest_positions(other)), 1e-6, 'a mesh can be bound to a cage of another file')

    def test_duplicates(self):
        """A duplicate also follows the cage and shares the weights; a linked duplicate has the shape of the original."""
        self.posed()
        select_only(self.figure)
        bpy.ops.object.duplicate(linked=False)
        twin = bpy.context.object
        self.assertEqual(twin.cageform.bindings[0].data, self.figure.cageform.bindings[0].data)
        self.assert_follows('the first')
        self.assertLess(off(shown(twin), shown(self.figure)), 1e-6)
        select_only(self.figure)
        bpy.ops.object.duplicate(linked=True)
        linked = bpy.context.object
        linked.location.x += 5
        self.assert_follows('with a linked duplicate')
        self.assertLess(off(shown(linked) - (5, 0, 0), shown(self.figure)), 1e-6, 'the same shape, elsewhere')
        select_only(twin)
        bpy.ops.cageform.remove_cage()
        self.assert_follows('after unbinding only the duplicate')
        self.assertLess(off(shown(twin), deform.rest_positions(twin)), 1e-6)

    def test_appended(self):
        """An appended or linked bound mesh includes its cage and weights, and follows."""
        self.posed()
        before = shown(self.figure)
        path = self.save('library.blend')
        for link in (False, True):
            empty_scene()
            with bpy.data.libraries.load(path, link=link) as (there, here):
                here.objects = ['Suzanne', 'Cage']
            self.find()
            for item in (self.figure, self.cage):
                bpy.context.collection.objects.link(item)
            bpy.context.view_layer.update()
            self.assertLess(off(shown(self.figure), before), 1e-6)
            if link:  # a linked cage can only be moved by an override
                select_only(self.figure, self.cage)
                with bpy.context.temp_override(selected_objects=[self.figure, self.cage]):
                    self.cage = self.cage.override_create(remap_local_usages=True)
                self.cage.location.x += 0.25
                bpy.context.view_layer.update()
            else:
                self.assert_follows('appended')

    def test_turned_off(self):
        """Without the add-on the file shows the last pose; after the add-on is enabled again, the mesh follows."""
        before = self.posed()
        bpy.ops.preferences.addon_disable(module='cageform')
        bpy.context.view_layer.update()
        self.assertLess(off(shown(self.figure), before), 1e-6)
        bpy.ops.preferences.addon_enable(module='cageform')
        self.assert_follows('on again')
