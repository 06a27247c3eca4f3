"""The operators that add and remove pins."""

import bpy
from mathutils import Vector

from . import deform, library, pins
from .operators import Work, active_binding, is_bound, to_object_mode


class AddPins(Work):
    """Adds an empty at each selected vertex. Move the empties: the mesh follows, deformed as rigidly as the cage allows"""
    bl_idname = 'cageform.add_pins'
    bl_label = 'Pin Selected Vertices'
    bl_options = {'UNDO'}

    MOST = 50

    @classmethod
    def poll(cls, context):
        return is_bound(context)

    def execute(self, context):
        binding = active_binding(context)
        to_object_mode(context)
        self.chosen = [vertex.index for vertex in context.object.data.vertices if vertex.select]
        fault = deform.problem(binding, deform.figure_of(binding)) or pins.problem(binding)
        for other in deform.bindings():
            if other != binding and other.cage == binding.cage and len(other.pins):
                fault = fault or 'Pins of "%s" already move this cage: remove them first.' % other.id_data.name
        if not self.chosen:
            fault = fault or 'No vertex is selected: select some in edit mode.'
        if len(self.chosen) > self.MOST:
            fault = fault or '%d vertices are selected: select at most %d.' % (len(self.chosen), self.MOST)
        if fault:
            self.report({'ERROR'}, fault)
            return {'CANCELLED'}
        if 'samples' in binding.data:
            return self.start(context, lambda **running: None)
        coordinates = deform.coordinates_as_bound(binding)
        return self.start(context, lambda **running: library.Samples(coordinates, **running).pack())

    def take(self, context, samples):
        figure, binding = context.object, active_binding(context)
        if samples is not None:
            binding.data['samples'] = bytes(samples)
        if pins.key_of(binding.cage) is None:
            deform.add_key(binding.cage, pins.NAME)
        shown = deform.key_positions(deform.key_of(binding))
        for pin in [pin for pin in binding.pins if not deform.is_in_scene(pin.empty)]:
            binding.pins.remove(list(binding.pins).index(pin))
        pinned = {pin.vertex for pin in binding.pins}
        for vertex in self.chosen:
            if vertex in pinned:
                continue
            empty = bpy.data.objects.new('%s pin %d' % (figure.name, vertex), None)
            empty.empty_display_type, empty.empty_display_size = 'SPHERE', 0.03 * max(figure.dimensions)
            empty.show_in_front = True
            empty.location = figure.matrix_world @ Vector(shown[vertex])
            context.collection.objects.link(empty)
            pin = binding.pins.add()
            pin.vertex, pin.empty = vertex, empty


class RemovePins(bpy.types.Operator):
    """Removes all pins of this cage. The cage keeps its pose, as a shape key"""
    bl_idname = 'cageform.remove_pins'
    bl_label = 'Remove Pins'
    bl_options = {'UNDO'}

    @classmethod
    def poll(cls, context):
        binding = active_binding(context)
        return binding is not None and len(binding.pins) > 0

    def execute(self, context):
        binding = active_binding(context)
        empties = [pin.empty for pin in binding.pins if pin.empty is not None]
        binding.pins.clear()
        for empty in empties:
            bpy.data.objects.remove(empty)
        return {'FINISHED'}


CLASSES = (AddPins, RemovePins)
