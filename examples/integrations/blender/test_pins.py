"""Pins move the cage so that pinned vertices are at their empties, also if other things move the cage."""

import os
import unittest

import bpy
import numpy as np

from cageform import pins
from support import *


def tips(figure, count=4):
    """Returns vertices that are far apart."""
    points = deform.rest_positions(figure)
    chosen = [int(points[:, 2].argmax())]
    while len(chosen) < count:
        chosen.append(int(np.min([np.linalg.norm(points - points[k], axis=1) for k in chosen], axis=0).argmax()))
    return chosen


def pin(figure, vertices):
    """Pins vertices, and returns their empties."""
    select_only(figure)
    for vertex in figure.data.vertices:
        vertex.select = vertex.index in vertices
    bpy.ops.cageform.add_pins()
    bpy.context.view_layer.update()
    of = {each.vertex: each.empty for each in figure.cageform.bindings[0].pins}
    return [of[vertex] for vertex in vertices]


class Pins(unittest.TestCase):
    def setUp(self):
        self.figure = bound_monkey(2000)
        self.cage = self.figure.cageform.bindings[0].cage
        self.rest = deform.rest_positions(self.cage)
        self.vertices = tips(self.figure)

    def miss(self, empties):
        """Returns the maximum distance of a pinned vertex from its empty, relative to the size."""
        places = np.array([empty.matrix_world.translation for empty in empties])
        return np.linalg.norm(shown(self.figure)[self.vertices] - places, axis=1).max() / max(self.figure.dimensions)

    def drag(self, empty, *by):
        empty.location = [a + b for a, b in zip(empty.location, by)]
        bpy.context.view_layer.update()

    def test_drag(self):
        """Setting a pin moves nothing. A dragged pin moves its vertex; other pins hold theirs."""
        before = shown(self.figure)
        empties = pin(self.figure, self.vertices)
        self.assertLess(off(shown(self.figure), before), 1e-5, 'setting pins moves nothing')
        for step in range(5):
            self.drag(empties[0], 0.1, 0.05, 0.1)
            self.assertLess(self.miss(empties), 1e-3, 'step %d' % step)
        np.testing.assert_array_equal(deform.rest_positions(self.cage), self.rest, 'the cage at rest stays as it was')
        self.assertGreater(np.abs(deform.key_positions(pins.key_of(self.cage)) - self.rest).max(), 0.1)
        self.assertLess(off(shown(self.figure), self.wanted()), 1e-6, 'the mesh agrees with this pose of the cage')
        for step in range(5):
            self.drag(empties[0], -0.1, -0.05, -0.1)
        self.assertLess(off(shown(self.figure), before), 1e-2, 'and back')

    def wanted(self):
        return expected(self.figure, self.cage, world(self.cage, self.rest), shown(self.cage))

    def test_keyed_cage(self):
        """Other shape keys of the cage keep their effect, and pinned vertices are still at their empties."""
        key = deform.add_key(self.cage, 'bend')
        deform.write_key(key, bent(self.rest, 0.15))
        bpy.context.view_layer.update()
        empties = pin(self.figure, self.vertices)
        self.drag(empties[0], 0.2, 0, 0.2)
        self.assertLess(self.miss(empties), 1e-3)
        written = deform.key_positions(pins.key_of(self.cage))
        for value in (0.5, 0, 1):
            key.value = value
            bpy.context.view_layer.update()
            self.assertLess(self.miss(empties), 1e-3, 'another key at %g' % value)
            self.assertLess(off(shown(self.figure), self.wanted()), 1e-6)
        again = deform.key_positions(pins.key_of(self.cage))
        self.assertLess(off(again, written), 1e-3, 'the pose does not depend on the path')
        np.testing.assert_array_equal(deform.key_positions(key), np.float32(bent(self.rest, 0.15)), 'the other key stays')
        np.testing.assert_array_equal(deform.rest_positions(self.cage), self.rest)

    def test_playback(self):
        """Animated pins play in any order of frames, while the cage moves as an object."""
        empties = pin(self.figure, self.vertices)
        for frame, x in ((1, 0), (10, 0.6)):
            empties[0].location.x += x
            empties[0].keyframe_insert('location', frame=frame)
        for each in empties:
            each.parent, each.matrix_parent_inverse = self.cage, self.cage.matrix_world.inverted()
        for frame, angle in ((1, 0), (10, 1)):
            self.cage.rotation_euler.z = angle
            self.cage.keyframe_insert('rotation_euler', frame=frame)
        played = {}
        for frame in (1, 4, 7, 10, 5, 7, 1):
            bpy.context.scene.frame_set(frame)
            self.assertLess(self.miss(empties), 1e-3, 'frame %d' % frame)
            if frame in played:
                self.assertLess(off(shown(self.figure), played[frame]), 1e-3, 'frame %d again' % frame)
            played[frame] = shown(self.figure)

    def test_saved(self):
        """A saved file with pins opens with the same positions, and its pins still work."""
        empties = pin(self.figure, self.vertices)
        self.drag(empties[0], 0.3, 0.1, 0)
        before = key_of(self.figure)
        path = os.path.join(folder, 'pins.blend')
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        self.figure = bpy.data.objects['Suzanne']
        self.cage = self.figure.cageform.bindings[0].cage
        np.testing.assert_array_equal(key_of(self.figure), before)
        empties = [bpy.data.objects['Suzanne pin %d' % vertex] for vertex in self.vertices]
        self.drag(empties[0], 0, 0, 0.2)
        self.assertLess(self.miss(empties), 1e-3)

    def test_removed(self):
        """A pin without its empty has no effect. After the removal of all pins the pose stays, as a shape key that can be muted."""
        empties = pin(self.figure, self.vertices)
        self.drag(empties[0], 0.4, 0, 0)
        select_only(empties[0])
        bpy.ops.object.delete()
        bpy.context.view_layer.update()
        del empties[0], self.vertices[0]
        self.drag(empties[0], 0, 0, 0.1)
        self.assertLess(self.miss(empties), 1e-3)
        posed = shown(self.figure)
        select_only(self.figure)
        bpy.ops.cageform.remove_pins()
        bpy.context.view_layer.update()
        self.assertEqual([item for item in bpy.data.objects if item.type == 'EMPTY'], [])
        self.assertLess(off(shown(self.figure), posed), 1e-6)
        pins.key_of(self.cage).value = 0
        bpy.context.view_layer.update()
        self.assertLess(off(shown(self.figure), deform.rest_positions(self.figure)), 1e-6)

    def test_several_meshes(self):
        """Pins on one mesh move all meshes of the cage; pins on a second mesh are an error with a message."""
        other = monkey(500)
        select_only(other)
        bpy.ops.cageform.add_cage()
        other.cageform.bindings[0].cage = self.cage
        bpy.ops.cageform.bind()
        empties = pin(self.figure, self.vertices)
        before = shown(other)
        self.drag(empties[0], 0.4, 0, 0)
        self.assertGreater(off(shown(other), before), 1e-2)
        wanted = expected(other, self.cage, world(self.cage, self.rest), shown(self.cage))
        self.assertLess(off(shown(other), wanted), 1e-6)
        self.assert_refused(other, 'remove them first')

    def test_refused(self):
        """Vertices that cannot be pinned give a message with a remedy."""
        self.assert_refused(self.figure, 'No vertex is selected', [])
        self.assert_refused(self.figure, 'at most 50', list(range(60)))
        self.cage.modifiers.new('Wave', 'WAVE')
        self.assert_refused(self.figure, 'apply "Wave", or turn it off')
        self.cage.modifiers.clear()
        select_only(self.figure)
        self.figure.cageform.bindings[0].kind = 'green'
        bpy.ops.cageform.bind()
        self.assert_refused(self.figure, 'bind with another type')

    def assert_refused(self, figure, words, vertices=(0, 5)):
        with self.assertRaises(RuntimeError) as caught:
            pin(figure, list(vertices))
        print('  ' + str(caught.exception).strip())
        self.assertIn(words, str(caught.exception))

    def test_modifier_later(self):
        """A later modifier of the cage disables the pins, and the panel shows a message."""
        empties = pin(self.figure, self.vertices)
        self.cage.modifiers.new('Wave', 'WAVE')
        self.drag(empties[0], 0.4, 0, 0)
        binding = self.figure.cageform.bindings[0]
        print('  ' + binding.fault)
        self.assertIn('Pins cannot move a cage with modifiers', binding.fault)
        self.cage.modifiers.clear()
        bpy.context.view_layer.update()
        self.assertEqual(binding.fault, '')
        self.assertLess(self.miss(empties), 1e-3)
