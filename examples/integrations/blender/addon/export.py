"""The operators that write the motion to shape keys, glTF files, and packed figures for games."""

import os

import bpy
import numpy as np

from . import deform, library
from .operators import active_binding, is_bound, to_object_mode

BAKED = 'Cageform frame '  # prefix of the names of baked shape keys


def keys_of(figure):
    """Returns the shape keys of a mesh that follow cages."""
    keys = [deform.key_of(binding) for binding in figure.cageform.bindings]
    return [key for key in keys if key is not None]


def frames_of(scene, step):
    frames = list(range(scene.frame_start, scene.frame_end + 1, step))
    return frames if frames[-1] == scene.frame_end else frames + [scene.frame_end]


def record(figure, scene, frames):
    """Returns the vertices of a mesh, deformed only by its cages, in each frame: a list of (#vertices, 3)."""
    current, rest, recorded = scene.frame_current, deform.rest_positions(figure), []
    for frame in frames:
        scene.frame_set(frame)
        recorded.append(rest + sum(key.value * (deform.key_positions(key) - rest) for key in keys_of(figure)))
    scene.frame_set(current)
    return recorded


def bake(figure, frames, recorded):
    """Adds a shape key per frame, with value 1 at this frame and 0 at the neighbouring frames."""
    for index, (frame, points) in enumerate(zip(frames, recorded)):
        key = figure.shape_key_add(name='%s%d' % (BAKED, frame), from_mix=False)
        deform.write_key(key, points)
        for at, value in ((index - 1, 0), (index, 1), (index + 1, 0)):
            if 0 <= at < len(frames):
                key.value = value
                key.keyframe_insert('value', frame=frames[at])
        for point in curve_of(key).keyframe_points:
            point.interpolation = 'LINEAR'


def curve_of(key):
    """Returns the keyframes of a shape key's value; None if there are none."""
    path, animated = key.path_from_id('value'), key.id_data.animation_data
    curves = animated.action.fcurves if animated is not None and animated.action is not None else ()
    return next((curve for curve in curves if curve.data_path == path), None)


def remove_bake(figure):
    """Removes the shape keys of an earlier bake with their keyframes, and unmutes those that follow cages."""
    for key in [key for key in figure.data.shape_keys.key_blocks if key.name.startswith(BAKED)]:
        curve = curve_of(key)
        if curve is not None:
            key.id_data.animation_data.action.fcurves.remove(curve)
        figure.shape_key_remove(key)
    for key in keys_of(figure):
        key.mute = False


class Motion:
    """An operator that records the frames of the scene."""

    step: bpy.props.IntProperty(name='Frame Step', default=4, min=1,
                                description='Number of frames between shape keys; in between, vertices move linearly')

    @classmethod
    def poll(cls, context):
        return is_bound(context)


class Bake(Motion, bpy.types.Operator):
    """Writes the motion to shape keys, so that the file plays without this add-on"""
    bl_idname = 'cageform.bake'
    bl_label = 'Bake to Shape Keys'
    bl_options = {'REGISTER', 'UNDO'}

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        figure, frames = context.object, frames_of(context.scene, self.step)
        remove_bake(figure)
        bake(figure, frames, record(figure, context.scene, frames))
        for key in keys_of(figure):
            key.mute = True
        self.report({'INFO'}, 'Baked %d shape keys. The shape key that follows the cage is muted' % len(frames))
        return {'FINISHED'}


def export_gltf(path):
    """Exports the selection with one animation."""
    one = {'export_nla_strips': False, 'export_animation_mode': 'ACTIVE_ACTIONS'}  # up to 3.5; from 3.6
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    bpy.ops.export_scene.gltf(filepath=path, export_format='GLB', use_selection=True, export_morph=True,
                              export_animations=True, **{name: value for name, value in one.items() if name in known})


class WriteGltf(Motion, bpy.types.Operator):
    """Writes the mesh as glTF, with its motion as shape keys, using Blender's exporter"""
    bl_idname = 'cageform.write_gltf'
    bl_label = 'Export glTF'

    filepath: bpy.props.StringProperty(subtype='FILE_PATH')
    filter_glob: bpy.props.StringProperty(default='*.glb', options={'HIDDEN'})

    def invoke(self, context, event):
        self.filepath = bpy.path.ensure_ext(context.object.name, '.glb')
        context.window_manager.fileselect_add(self)
        return {'RUNNING_MODAL'}

    def execute(self, context):
        to_object_mode(context)
        figure, frames = context.object, frames_of(context.scene, self.step)
        if all(key.mute for key in keys_of(figure)):
            self.report({'ERROR'}, 'The shape key that follows the cage is muted: turn it on.')
            return {'CANCELLED'}
        recorded, selected = record(figure, context.scene, frames), list(context.selected_objects)
        name, copy = figure.name, figure.copy()
        copy.data = figure.data.copy()
        copy.cageform.bindings.clear()
        copy.modifiers.clear()
        copy.constraints.clear()
        copy.shape_key_clear()
        copy.shape_key_add(name='Basis', from_mix=False)
        figure.name, copy.name = name + ' bound', name  # the name of the mesh in the file
        context.collection.objects.link(copy)
        bake(copy, frames, recorded)
        for item in selected:
            item.select_set(False)
        copy.select_set(True)
        context.view_layer.objects.active = copy
        try:
            export_gltf(bpy.path.ensure_ext(self.filepath, '.glb'))
        finally:
            mesh, action = copy.data, copy.data.shape_keys.animation_data.action
            bpy.data.objects.remove(copy)
            bpy.data.meshes.remove(mesh)
            bpy.data.actions.remove(action)
            figure.name = name
            for item in selected:
                item.select_set(True)
            context.view_layer.objects.active = figure
        return {'FINISHED'}


def write_whole(path, numbers):
    """Writes an array to a file; after an error the previous file is unchanged."""
    beside = path + '.part'
    try:
        numbers.tofile(beside)
        os.replace(beside, path)
    finally:
        if os.path.exists(beside):
            os.remove(beside)


class WriteFigure(bpy.types.Operator):
    """Writes the mesh and its weights as a packed figure for games, with the motion of the cage as a clip"""
    bl_idname = 'cageform.write_figure'
    bl_label = 'Export Figure'

    filepath: bpy.props.StringProperty(subtype='FILE_PATH')
    filter_glob: bpy.props.StringProperty(default='*.figure', options={'HIDDEN'})
    loss: bpy.props.FloatProperty(name='Loss', default=1e-3, min=0, precision=4,
                                  description='Maximum change of a vertex by packing, relative to the size')
    clip: bpy.props.BoolProperty(name='Motion', default=True, description='Write the frames of the scene as a clip')

    @classmethod
    def poll(cls, context):
        return is_bound(context)

    def invoke(self, context, event):
        self.filepath = bpy.path.ensure_ext(context.object.name, '.figure')
        context.window_manager.fileselect_add(self)
        return {'RUNNING_MODAL'}

    def execute(self, context):
        figure, binding = context.object, active_binding(context)
        fault = deform.problem(binding, deform.figure_of(binding))
        if fault:
            self.report({'ERROR'}, fault)
            return {'CANCELLED'}
        settings, own = deform.settings_as_bound(binding), deform.figure_of(binding)
        points = own.clone(own.rest())
        normals = np.empty((len(points), 3), np.float32)
        figure.data.vertices.foreach_get('normal', normals.ravel())
        normals = normals @ deform.matrix_of(binding, 'to_mesh')[:3, :3]
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        try:
            bound = deform.coordinates_as_bound(binding).bind(points, normals.astype(np.float32),
                                                              outside=settings['outside'], falloff=settings['falloff'])
            clips = {'scene': clip_of(binding, context)} if self.clip else {}
            packed, report = bound.pack(tolerance=self.loss * np.ptp(points, axis=0).max(), clips=clips)
            write_whole(bpy.path.abspath(self.filepath), packed)
        except library.CageformError as error:
            self.report({'ERROR'}, deform.sentence(error))
            return {'CANCELLED'}
        except OSError as error:
            self.report({'ERROR'}, 'The file cannot be written: %s.' % error)
            return {'CANCELLED'}
        self.report({'INFO'}, 'Wrote %d kB. Packing moves a vertex by at most %.2g' % (report.bytes // 1000, report.distance))
        return {'FINISHED'}


def clip_of(binding, context):
    """Returns the motion of the cage in the frames of the scene: times in seconds, poses in the space of the binding."""
    scene, times, poses = context.scene, [], []
    current = scene.frame_current
    for frame in frames_of(scene, 1):
        scene.frame_set(frame)
        depsgraph = context.evaluated_depsgraph_get()
        vertices = deform.shown_positions(binding.cage, depsgraph)
        poses.append(deform.moved(vertices, deform.bound_from_cage(binding, depsgraph)))
        times.append((frame - scene.frame_start) * scene.render.fps_base / scene.render.fps)
    scene.frame_set(current)
    return library.compile_clip(times, np.array(poses))[0]


CLASSES = (Bake, WriteGltf, WriteFigure)
