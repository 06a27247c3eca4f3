"""Cageform in Blender: a cage around a mesh, bound in a blink; the mesh follows while the cage is edited, keyed or shaped."""

bl_info = {
    'name': 'Cageform',
    'description': 'Cages that bind in a blink, pins on the mesh',
    'author': 'the cageform project',
    'version': (0, 2, 0),
    'blender': (3, 4, 0),
    'location': 'View3D > Sidebar > Cageform',
    'category': 'Rigging',
}

import threading

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import deform, library
from .deform import bindings, rest_positions

KINDS = [
    ('mean-value', 'Mean Value', 'Closed form: fast, and defined outside the cage'),
    ('harmonic', 'Harmonic', 'Never negative: limbs do not pull each other; points outside stay'),
    ('green', 'Green', 'Keeps shapes, as if the inside were soft matter'),
]
OUTSIDE = [
    ('extend', 'Follow', 'By the extension of the coordinates; with harmonic they stay'),
    ('keep_in_place', 'Stay', 'No pose moves them'),
    ('nearest_boundary', 'Nearest Place', 'They follow the nearest place of the cage'),
]


def active_binding(context):
    figure = context.object
    if figure is None or figure.type != 'MESH':
        return None
    its = figure.cageform
    return its.bindings[its.active] if 0 <= its.active < len(its.bindings) else None


def sentence(error):
    """An error as the panel shows it: a sentence, with its culprit."""
    text = str(error)
    return text[:1].upper() + text[1:] + '.'


def triangles_of(figure, depsgraph):
    """Vertices in world space and triangles of an object as it is shown."""
    evaluated = figure.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    mesh.calc_loop_triangles()
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get('vertices', triangles)
    points = deform.moved(deform.positions(mesh), evaluated.matrix_world)
    evaluated.to_mesh_clear()
    return points, triangles.reshape(-1, 3)


def faces_of(cage):
    """The faces of a cage as lists of vertices."""
    return [list(polygon.vertices) for polygon in cage.data.polygons]


# ---- what is kept in the file ------------------------------------------------------------------------------------------

class Pin(bpy.types.PropertyGroup):
    vertex: bpy.props.IntProperty()
    empty: bpy.props.PointerProperty(type=bpy.types.Object)


class Binding(bpy.types.PropertyGroup):
    number: bpy.props.IntProperty()
    cage: bpy.props.PointerProperty(name='Cage', type=bpy.types.Object, poll=lambda _, item: item.type == 'MESH',
                                    description='The mesh that moves this one: closed, in few faces')
    kind: bpy.props.EnumProperty(name='Type', items=KINDS, default='harmonic')
    accuracy: bpy.props.FloatProperty(name='Accuracy', default=1e-2, min=1e-4, max=0.1, precision=4,
                                      description='Harmonic: the largest error of a weight')
    outside: bpy.props.EnumProperty(name='Outside', items=OUTSIDE, description='What becomes of vertices outside the cage')
    falloff: bpy.props.FloatProperty(name='Falloff', min=0, subtype='DISTANCE',
                                     description='Outside, movement fades to nothing at this distance; 0: it does not')
    report: bpy.props.StringProperty()
    fault: bpy.props.StringProperty()
    pins: bpy.props.CollectionProperty(type=Pin)


class Bindings(bpy.types.PropertyGroup):
    bindings: bpy.props.CollectionProperty(type=Binding)
    active: bpy.props.IntProperty()


# ---- live --------------------------------------------------------------------------------------------------------------

_is_updating = False


def update_all(depsgraph, force=False):
    """Clones all figures whose cages or pins have moved."""
    global _is_updating
    if _is_updating:
        return
    _is_updating = True
    try:
        for binding in bindings():
            deform.update(binding, depsgraph, force)
    finally:
        _is_updating = False


@persistent
def after_depsgraph(scene, depsgraph):
    empties = {update.id.name_full for update in depsgraph.updates if isinstance(update.id, bpy.types.Object)}
    pinned = {binding.id_data.name_full: binding for binding in bindings()
              if any(pin.empty is not None and pin.empty.name_full in empties for pin in binding.pins)}
    if not _is_updating:
        for binding in pinned.values():
            deform.pull(binding, depsgraph)
    update_all(depsgraph)


@persistent
def after_frame(scene, depsgraph):
    update_all(depsgraph)


@persistent
def after_load(*_):
    deform.forget()
    update_all(bpy.context.evaluated_depsgraph_get(), force=True)


@persistent
def after_undo(*_):
    deform.forget()


# ---- operators ---------------------------------------------------------------------------------------------------------

class Work(bpy.types.Operator):
    """Runs work(progress) on a thread, with progress in the status bar and Escape to stop; in the background at once."""

    def start(self, context, work):
        self.done, self.error, self.result, self.stops = 0, None, None, False

        def progress(done):
            self.done = done
            return not self.stops

        def run():
            try:
                self.result = work(progress)
            except Exception as error:  # is shown by finish
                self.error = error

        if bpy.app.background:
            run()
            return self.finish(context)
        self.thread = threading.Thread(target=run)
        self.thread.start()
        self.timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {'RUNNING_MODAL'}

    def modal(self, context, event):
        if event.type == 'ESC':
            self.stops = True
        if event.type != 'TIMER':
            return {'RUNNING_MODAL'}
        if self.thread.is_alive():
            context.workspace.status_text_set('%s: %d %%. Esc stops' % (self.bl_label, round(100 * self.done)))
            return {'RUNNING_MODAL'}
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        return self.finish(context)

    def finish(self, context):
        error = self.error
        if error is None:
            self.take(context, self.result)
            for area in context.screen.areas if context.screen else ():
                area.tag_redraw()
            return {'FINISHED'}
        if not isinstance(error, library.CageformError):
            raise error
        self.refused(context, error)
        self.report({'WARNING' if error.name == 'cancelled' else 'ERROR'}, sentence(error))
        return {'CANCELLED'}

    def refused(self, context, error):
        pass


class MakeCage(Work):
    """Makes a cage around the selected meshes, and binds nothing yet"""
    bl_idname = 'cageform.make_cage'
    bl_label = 'Make Cage'
    bl_options = {'REGISTER', 'UNDO'}

    vertices: bpy.props.IntProperty(name='Vertices', default=112, min=8, soft_max=500)
    margin: bpy.props.FloatProperty(name='Margin', default=0.02, min=0.006, max=0.5,
                                    description='The distance from the figure, as a share of its size')
    mirror: bpy.props.EnumProperty(name='Mirror', items=[('none', 'None', ''), ('x', 'X', ''), ('y', 'Y', ''), ('z', 'Z', '')])

    @classmethod
    def poll(cls, context):
        return any(item.type == 'MESH' for item in context.selected_objects)

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        depsgraph = context.evaluated_depsgraph_get()
        points, triangles, self.figures = [], [], []
        for figure in context.selected_objects:
            if figure.type == 'MESH':
                own, faces = triangles_of(figure, depsgraph)
                triangles.append(faces + sum(len(p) for p in points))
                points.append(own)
                self.figures.append(figure)
        mirror = None if self.mirror == 'none' else self.mirror
        return self.start(context, lambda progress: library.make_cage(
            np.concatenate(points), np.concatenate(triangles), vertices=self.vertices, margin=self.margin, mirror=mirror,
            progress=progress))

    def take(self, context, result):
        made, report = result
        mesh = bpy.data.meshes.new('Cage')
        mesh.from_pydata([tuple(point) for point in made.vertices], [], [tuple(int(v) for v in face) for face in made.faces])
        cage = bpy.data.objects.new(self.figures[0].name + ' cage', mesh)
        cage.display_type = 'WIRE'
        context.collection.objects.link(cage)
        for figure in self.figures:
            add_binding(figure).cage = cage
        self.report({'INFO'}, 'A cage of %d vertices, %.3g from the figure' % (report.vertices, report.clearance))


def add_binding(figure):
    its = figure.cageform
    if its.bindings and its.bindings[its.active].cage is None:
        return its.bindings[its.active]
    taken = {binding.number for binding in its.bindings}
    binding = its.bindings.add()
    binding.number = next(n for n in range(len(taken) + 1) if n not in taken)
    its.active = len(its.bindings) - 1
    return binding


class AddBinding(bpy.types.Operator):
    """Adds a cage to this mesh; a selected mesh is taken as the cage"""
    bl_idname = 'cageform.add_binding'
    bl_label = 'Add Cage'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == 'MESH'

    def execute(self, context):
        binding = add_binding(context.object)
        others = [item for item in context.selected_objects if item.type == 'MESH' and item != context.object]
        if len(others) == 1:
            binding.cage = others[0]
        return {'FINISHED'}


class RemoveBinding(bpy.types.Operator):
    """Removes the cage from this mesh, with its shape key"""
    bl_idname = 'cageform.remove_binding'
    bl_label = 'Remove Cage'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return active_binding(context) is not None

    def execute(self, context):
        figure, binding = context.object, active_binding(context)
        keys = figure.data.shape_keys
        name = 'Cageform' if binding.number == 0 else 'Cageform %d' % binding.number
        if keys is not None and name in keys.key_blocks:
            figure.shape_key_remove(keys.key_blocks[name])
        deform.drop(binding)
        figure.cageform.bindings.remove(figure.cageform.active)
        figure.cageform.active = max(0, figure.cageform.active - 1)
        return {'FINISHED'}


class Bind(Work):
    """Binds the mesh to its cage; it then follows the cage"""
    bl_idname = 'cageform.bind'
    bl_label = 'Bind'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return active_binding(context) is not None

    def execute(self, context):
        binding = active_binding(context)
        if binding.cage is None:
            self.report({'ERROR'}, 'There is no cage: make one, or choose a mesh as the cage')
            return {'CANCELLED'}
        if binding.cage == context.object:
            self.report({'ERROR'}, 'The cage is the mesh itself: choose another mesh')
            return {'CANCELLED'}
        figure, cage = context.object, binding.cage
        if cage.mode == 'EDIT':
            cage.update_from_editmode()
        to_figure = figure.matrix_world.inverted_safe() @ cage.matrix_world
        described = library.Cage.mesh(deform.moved(deform.positions(cage.data), to_figure), faces_of(cage),
                                      off_plane=1e-6 * max(cage.dimensions))
        points = rest_positions(figure)
        kind, accuracy = binding.kind, binding.accuracy
        options = {'outside': binding.outside, 'falloff': binding.falloff}

        def work(progress):
            coordinates = library.Coordinates(described, kind, np.float32, accuracy=accuracy if kind == 'harmonic' else 0)
            bound = coordinates.bind(points, progress=progress, **options)
            packed, _ = bound.pack()
            return bound, packed

        return self.start(context, work)

    def take(self, context, result):
        bound, packed = result
        binding, its = active_binding(context), bound.report
        deform.drop(binding)
        deform.store(binding, deform.FIGURE, packed)
        outside = np.asarray(bound.outside, dtype=np.uint32)
        deform.store(binding, deform.OUTSIDE, outside.tobytes())
        words = ['%d vertices bound to %d handles in %.2f s' % (its.points, bound.handles, its.seconds)]
        if its.outside:
            does = {'extend': 'stay' if binding.kind == 'harmonic' else 'follow', 'keep_in_place': 'stay',
                    'nearest_boundary': 'follow the nearest place of the cage'}[binding.outside]
            words.append('%d outside the cage: they %s' % (its.outside, does))
        for count, text in ((its.not_finite, 'not finite'), (its.unreached, 'not reached'), (its.warnings, 'warnings of the cage')):
            if count:
                words.append('%d %s' % (count, text))
        if its.least_weight < -0.01:
            words.append('weights down to %.2f: parts may move the wrong way' % its.least_weight)
        binding.report, binding.fault = '\n'.join(words), ''
        deform.update(binding, context.evaluated_depsgraph_get(), force=True)
        self.report({'INFO'}, words[0])

    def refused(self, context, error):
        binding = active_binding(context)
        binding.fault = sentence(error)
        fault = error.report.fault if error.report is not None and error.report.faults else None
        if fault is not None:
            binding['culprits'] = [index for element in (fault.a, fault.b) if element is not None for index in element[1:]]
            binding['culprits_are'] = fault.a[0] if fault.a else ''


class SelectOutside(bpy.types.Operator):
    """Selects the vertices outside the cage, in edit mode"""
    bl_idname = 'cageform.select_outside'
    bl_label = 'Select Vertices Outside'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        binding = active_binding(context)
        return binding is not None and deform.stored(binding, deform.OUTSIDE)

    def execute(self, context):
        indices = np.frombuffer(bytes(deform.stored(active_binding(context), deform.OUTSIDE)), np.uint32)
        select(context, context.object, indices, 'VERT')
        return {'FINISHED'}


class SelectFaults(bpy.types.Operator):
    """Selects what is at fault in the cage, in edit mode"""
    bl_idname = 'cageform.select_faults'
    bl_label = 'Select Faults of the Cage'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        binding = active_binding(context)
        return binding is not None and binding.cage is not None

    def execute(self, context):
        cage = active_binding(context).cage
        described = library.Cage.mesh(deform.positions(cage.data), faces_of(cage), off_plane=1e-6 * max(cage.dimensions))
        faults = [fault for fault in library.check(described) if not fault.is_warning]
        if not faults:
            self.report({'INFO'}, 'The cage has no faults')
            return {'FINISHED'}
        named = [element for fault in faults for element in (fault.a, fault.b) if element is not None]
        faces = [index for kind, index in named if kind == 'face']
        vertices = [index for kind, index in named if kind in ('vertex', 'edge')]
        select(context, cage, np.array(faces or vertices, dtype=np.int64), 'FACE' if faces else 'VERT')
        self.report({'WARNING'}, '%d faults, the first: %s' % (len(faults), faults[0]))
        return {'FINISHED'}


def select(context, item, indices, mode):
    """Shows an object in edit mode with some of its vertices or faces selected."""
    if context.object is not None and context.object.mode != 'OBJECT':
        bpy.ops.object.mode_set(mode='OBJECT')
    bpy.ops.object.select_all(action='DESELECT')
    context.view_layer.objects.active = item
    item.select_set(True)
    mesh = item.data
    for elements in (mesh.vertices, mesh.edges, mesh.polygons):
        elements.foreach_set('select', np.zeros(len(elements), bool))
    chosen = mesh.polygons if mode == 'FACE' else mesh.vertices
    flags = np.zeros(len(chosen), bool)
    flags[indices[indices < len(chosen)]] = True
    chosen.foreach_set('select', flags)
    bpy.ops.object.mode_set(mode='EDIT')
    context.tool_settings.mesh_select_mode = (mode == 'VERT', False, mode == 'FACE')


class AddPins(Work):
    """Pins the selected vertices: an empty at each moves the figure, as rigidly as the cage can"""
    bl_idname = 'cageform.add_pins'
    bl_label = 'Pin Selected Vertices'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        binding = active_binding(context)
        return binding is not None and deform.stored(binding, deform.FIGURE)

    def execute(self, context):
        figure, binding = context.object, active_binding(context)
        if figure.mode == 'EDIT':
            figure.update_from_editmode()
        self.chosen = [vertex.index for vertex in figure.data.vertices if vertex.select]
        if not self.chosen:
            self.report({'ERROR'}, 'No vertex is selected: select some in edit mode')
            return {'CANCELLED'}
        if len(self.chosen) > 50:
            self.report({'ERROR'}, '%d vertices are selected: pins are few' % len(self.chosen))
            return {'CANCELLED'}
        if deform.stored(binding, deform.SAMPLES):
            return self.start(context, lambda progress: None)
        rest = deform.figure_of(binding).rest()
        cage = binding.cage
        described = library.Cage.mesh(rest[:len(cage.data.vertices)], faces_of(cage), off_plane=1e-6 * max(cage.dimensions))
        kind, accuracy = binding.kind, binding.accuracy

        def work(progress):
            coordinates = library.Coordinates(described, kind, np.float32, accuracy=accuracy if kind == 'harmonic' else 0)
            return library.Samples(coordinates, progress=progress).pack()

        return self.start(context, work)

    def take(self, context, samples):
        figure, binding = context.object, active_binding(context)
        if samples is not None:
            deform.store(binding, deform.SAMPLES, samples)
        if figure.mode == 'EDIT':
            bpy.ops.object.mode_set(mode='OBJECT')
        shown = deform.positions(figure.evaluated_get(context.evaluated_depsgraph_get()).data)
        pinned = {pin.vertex for pin in binding.pins}
        for vertex in self.chosen:
            if vertex in pinned:
                continue
            empty = bpy.data.objects.new('%s pin %d' % (figure.name, vertex), None)
            empty.empty_display_type, empty.empty_display_size = 'SPHERE', 0.02 * max(figure.dimensions)
            empty.location = figure.matrix_world @ __import__('mathutils').Vector(shown[vertex])
            context.collection.objects.link(empty)
            pin = binding.pins.add()
            pin.vertex, pin.empty = vertex, empty


class RemovePins(bpy.types.Operator):
    """Removes all pins of this binding; the cage stays as it is"""
    bl_idname = 'cageform.remove_pins'
    bl_label = 'Remove Pins'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        binding = active_binding(context)
        return binding is not None and len(binding.pins) > 0

    def execute(self, context):
        binding = active_binding(context)
        for pin in binding.pins:
            if pin.empty is not None:
                bpy.data.objects.remove(pin.empty)
        binding.pins.clear()
        return {'FINISHED'}


def frames_of(scene, step):
    frames = list(range(scene.frame_start, scene.frame_end + 1, step))
    return frames if frames[-1] == scene.frame_end else frames + [scene.frame_end]


class Bake(bpy.types.Operator):
    """Writes the motion into shape keys, so that the file plays without this add-on"""
    bl_idname = 'cageform.bake'
    bl_label = 'Bake to Shape Keys'
    bl_options = {'REGISTER', 'UNDO'}

    step: bpy.props.IntProperty(name='Every', default=4, min=1, description='Frames from a shape key to the next')

    @classmethod
    def poll(cls, context):
        binding = active_binding(context)
        return binding is not None and deform.stored(binding, deform.FIGURE)

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        figure, scene, binding = context.object, context.scene, active_binding(context)
        current, frames = scene.frame_current, frames_of(scene, self.step)
        baked = []
        for frame in frames:
            scene.frame_set(frame)
            deform.update(binding, context.evaluated_depsgraph_get(), force=True)
            numbers = np.empty(3 * len(figure.data.vertices), np.float32)
            deform.shape_key(binding).data.foreach_get('co', numbers)
            baked.append(numbers)
        for number, (frame, numbers) in enumerate(zip(frames, baked)):
            key = figure.shape_key_add(name='Cageform frame %d' % frame, from_mix=False)
            key.data.foreach_set('co', numbers)
            for at, value in ((number - 1, 0), (number, 1), (number + 1, 0)):
                if 0 <= at < len(frames):
                    key.value = value
                    key.keyframe_insert('value', frame=frames[at])
            for curve in figure.data.shape_keys.animation_data.action.fcurves:
                for point in curve.keyframe_points:
                    point.interpolation = 'LINEAR'
        deform.shape_key(binding).mute = True
        scene.frame_set(current)
        self.report({'INFO'}, '%d shape keys; that of the cage is muted' % len(frames))
        return {'FINISHED'}


class WriteFigure(bpy.types.Operator):
    """Writes a packed figure for games, with the motion of the cage as a clip"""
    bl_idname = 'cageform.write_figure'
    bl_label = 'Write Figure'

    filepath: bpy.props.StringProperty(subtype='FILE_PATH')
    filter_glob: bpy.props.StringProperty(default='*.figure', options={'HIDDEN'})
    loss: bpy.props.FloatProperty(name='Loss', default=1e-3, min=0, precision=4,
                                  description='The largest distance that packing may move a vertex, a share of its size')
    clip: bpy.props.BoolProperty(name='Motion', default=True, description='The frames of the scene as a clip')

    @classmethod
    def poll(cls, context):
        return Bake.poll(context)

    def invoke(self, context, event):
        self.filepath = bpy.path.ensure_ext(context.object.name, '.figure')
        context.window_manager.fileselect_add(self)
        return {'RUNNING_MODAL'}

    def execute(self, context):
        figure, scene, binding = context.object, context.scene, active_binding(context)
        own = deform.figure_of(binding)
        cage = binding.cage
        described = library.Cage.mesh(own.rest()[:len(cage.data.vertices)], faces_of(cage),
                                      off_plane=1e-6 * max(cage.dimensions))
        accuracy = binding.accuracy if binding.kind == 'harmonic' else 0
        mesh = figure.data
        mesh.calc_normals_split() if hasattr(mesh, 'calc_normals_split') else None
        normals = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get('normal', normals)
        try:
            bound = library.Coordinates(described, binding.kind, np.float32, accuracy=accuracy).bind(
                rest_positions(figure), normals.reshape(-1, 3), outside=binding.outside, falloff=binding.falloff)
            clips = {}
            if self.clip:
                current, times, poses = scene.frame_current, [], []
                for frame in range(scene.frame_start, scene.frame_end + 1):
                    scene.frame_set(frame)
                    poses.append(deform.cage_positions(binding, context.evaluated_depsgraph_get()))
                    times.append((frame - scene.frame_start) * scene.render.fps_base / scene.render.fps)
                scene.frame_set(current)
                clips['scene'] = library.compile_clip(times, np.array(poses))[0]
            packed, report = bound.pack(tolerance=self.loss * max(figure.dimensions), clips=clips)
        except library.CageformError as error:
            self.report({'ERROR'}, sentence(error))
            return {'CANCELLED'}
        packed.tofile(bpy.path.abspath(self.filepath))
        self.report({'INFO'}, '%d kB, at most %.2g from the mesh' % (report.bytes // 1000, report.distance))
        return {'FINISHED'}


# ---- the panel ---------------------------------------------------------------------------------------------------------

class CAGEFORM_UL_bindings(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        layout.label(text=item.cage.name if item.cage else 'no cage', icon='MESH_ICOSPHERE')


class CAGEFORM_PT_panel(bpy.types.Panel):
    bl_label = 'Cageform'
    bl_space_type = 'VIEW_3D'
    bl_region_type = 'UI'
    bl_category = 'Cageform'

    def draw(self, context):
        layout = self.layout
        figure = context.object
        if figure is None or figure.type != 'MESH':
            layout.label(text='Select a mesh.')
            return
        its = figure.cageform
        row = layout.row(align=True)
        row.operator(MakeCage.bl_idname)
        row.operator(AddBinding.bl_idname, text='Use a Mesh')
        if len(its.bindings) > 1:
            layout.template_list('CAGEFORM_UL_bindings', '', its, 'bindings', its, 'active', rows=2)
        binding = active_binding(context)
        if binding is None:
            return
        column = layout.column()
        column.prop(binding, 'cage')
        column.prop(binding, 'kind')
        if binding.kind == 'harmonic':
            column.prop(binding, 'accuracy')
        column.prop(binding, 'outside')
        if binding.outside != 'keep_in_place':
            column.prop(binding, 'falloff')
        row = layout.row(align=True)
        row.operator(Bind.bl_idname, icon='LINKED')
        row.operator(RemoveBinding.bl_idname, text='', icon='X')
        for line in binding.report.splitlines():
            layout.label(text=line)
        if binding.fault:
            box = layout.box()
            box.alert = True
            for line in wrapped(binding.fault):
                box.label(text=line)
            box.operator(SelectFaults.bl_idname)
        if SelectOutside.poll(context):
            layout.operator(SelectOutside.bl_idname)
        if deform.stored(binding, deform.FIGURE):
            row = layout.row(align=True)
            row.operator(AddPins.bl_idname, icon='PINNED')
            row.operator(RemovePins.bl_idname, text='', icon='X')
            layout.operator(Bake.bl_idname)
            layout.operator(WriteFigure.bl_idname)


def wrapped(text, width=44):
    lines = ['']
    for word in text.split():
        if len(lines[-1]) + len(word) > width:
            lines.append('')
        lines[-1] += (' ' if lines[-1] else '') + word
    return lines


CLASSES = (Pin, Binding, Bindings, MakeCage, AddBinding, RemoveBinding, Bind, SelectOutside, SelectFaults, AddPins, RemovePins,
           Bake, WriteFigure, CAGEFORM_UL_bindings, CAGEFORM_PT_panel)
HANDLERS = (('depsgraph_update_post', after_depsgraph), ('frame_change_post', after_frame), ('load_post', after_load),
            ('undo_post', after_undo), ('redo_post', after_undo))


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Object.cageform = bpy.props.PointerProperty(type=Bindings)
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    del bpy.types.Object.cageform
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
    deform.forget()
