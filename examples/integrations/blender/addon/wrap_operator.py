"""The operator that lays a mesh on another; clothes and hair follow."""

import bpy
import numpy as np

from . import deform, library
from .operators import Work, shown_triangles, to_object_mode, triangles_of

NAME = 'Cageform wrap'  # name of the shape keys


def outwards(triangles, item):
    """Returns triangles in world space with normals that point outwards, also if the object is mirrored."""
    return triangles[:, ::-1] if item.matrix_world.determinant() < 0 else triangles


def world_rest(item):
    """Returns the vertices of an object without shape keys and modifiers in world space."""
    return deform.moved(deform.rest_positions(item).astype(np.float64), item.matrix_world)


def other_meshes(context):
    return [item for item in context.selected_objects if item.type == 'MESH' and item != context.object]


class WrapOnto(Work):
    """Lays the active mesh on another mesh in the same pose. The other selected meshes, such as clothes and hair, follow.
    The result is a shape key of each"""
    bl_idname = 'cageform.wrap_onto'
    bl_label = 'Wrap onto…'
    bl_options = {'UNDO'}

    target: bpy.props.StringProperty(name='Target', description='The mesh to lie on. It has the same up and front. '
                                                                'Empty: the only other selected mesh')
    detail: bpy.props.EnumProperty(name='Detail', default='24', items=[
        ('12', 'Low', 'Fastest'), ('24', 'Medium', 'For bodies'), ('48', 'High', 'Slowest; for targets without noise')])
    refine_contacts: bpy.props.BoolProperty(name='Refine Contacts', description='Works more finely where parts touch, such as '
                                                                                'thighs. Takes twice the time')

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == 'MESH'

    def invoke(self, context, event):
        others = other_meshes(context)
        self.target = others[0].name if len(others) == 1 else ''
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        self.layout.prop_search(self, 'target', context.scene, 'objects')
        self.layout.prop(self, 'detail')
        self.layout.prop(self, 'refine_contacts')

    def execute(self, context):
        to_object_mode(context)
        source, others = context.object, other_meshes(context)
        target = context.scene.objects.get(self.target) if self.target else others[0] if len(others) == 1 else None
        self.items = [source] + [item for item in others if item != target]
        fault = self.problem(target)
        if fault:
            self.report({'ERROR'}, fault)
            return {'CANCELLED'}
        self.target = target.name
        places = [world_rest(item) for item in self.items]
        faces = outwards(triangles_of(source.data), source)
        wanted, wanted_faces = shown_triangles(target, context.evaluated_depsgraph_get())
        wanted_faces, options = outwards(wanted_faces, target), {'finest': int(self.detail), 'refine_contacts': self.refine_contacts}
        if not len(faces) or not len(wanted_faces):
            self.report({'ERROR'}, '"%s" has no faces.' % (source if not len(faces) else target).name)
            return {'CANCELLED'}

        def work(**running):
            wrap = library.wrap(places[0], faces, wanted, wanted_faces, follow=np.concatenate(places[1:] or [places[0][:0]]),
                                **options, **running)
            return wrap.report, [wrap.move(points) for points in places]

        return self.start(context, work)

    def problem(self, target):
        """Returns why the meshes cannot be wrapped, as a sentence; '' if they can."""
        if target is None or target.type != 'MESH':
            return 'Choose the mesh to lie on: select it, too, or name it as the target.'
        if target == self.items[0]:
            return 'The target must be another mesh than the active one.'
        for item in self.items:
            keys = item.data.shape_keys
            if keys is not None and not keys.use_relative:
                return 'The shape keys of "%s" are absolute: turn on Relative in the list of shape keys.' % item.name
        return ''

    def take(self, context, result):
        report, moved = result
        for item, points in zip(self.items, moved):
            key = deform.find_key(item, NAME) or deform.add_key(item, NAME)
            deform.write_key(key, deform.moved(points, np.linalg.inv(item.matrix_world)))
            item.data.update()
        if report.message:
            self.report({'WARNING'}, deform.sentence(report.message))
        self.report({'INFO'}, 'Distance to "%s", in %% of its height: mean %.3f, for 95 %% of the vertices below %.3f' %
                    (self.target, 100 * report.to_target_mean, 100 * report.to_target_upper))


CLASSES = (WrapOnto,)
