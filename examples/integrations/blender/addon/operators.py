"""The operators that make cages, bind meshes and select faulty elements."""

import os
import threading

import bpy
import numpy as np

from . import deform, follow, library
from .properties import INSIDE_ONLY


def active_binding(context):
    figure = context.object
    if figure is None or figure.type != 'MESH':
        return None
    its = figure.cageform
    return its.bindings[its.active] if 0 <= its.active < len(its.bindings) else None


def is_bound(context):
    binding = active_binding(context)
    return binding is not None and binding.data is not None


def to_object_mode(context):
    if context.mode != 'OBJECT':
        bpy.ops.object.mode_set(mode='OBJECT')


class Work(bpy.types.Operator):
    """Runs work(progress=…, threads=…) on a thread. Shows progress in the status bar; Escape stops the work. In background
    mode it runs without a thread of its own. One processor is left for the window."""

    def start(self, context, work):
        self.done, self.error, self.result, self.stops = 0, None, None, False

        def progress(done):
            self.done = done
            return not self.stops

        threads = None if bpy.app.background else max(1, (os.cpu_count() or 1) - 1)

        def run():
            try:
                self.result = work(progress=progress, threads=threads)
            except Exception as error:  # finish() shows it
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
            context.workspace.status_text_set('%s: %s' % (self.bl_label, 'stopping' if self.stops else
                                                          '%d %%. Press Esc to stop' % round(100 * self.done)))
            return {'RUNNING_MODAL'}
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        return self.finish(context)

    def finish(self, context):
        error = self.error
        for area in context.screen.areas if context.screen else ():
            area.tag_redraw()
        if error is None:
            self.take(context, self.result)
            return {'FINISHED'}
        if not isinstance(error, library.CageformError):
            raise error
        if error.name != 'cancelled':
            self.refuse(context, error)
        self.report({'WARNING' if error.name == 'cancelled' else 'ERROR'}, deform.sentence(error))
        return {'CANCELLED'}

    def refuse(self, context, error):
        pass


def add_binding(figure):
    its = figure.cageform
    for index, binding in enumerate(its.bindings):
        if binding.cage is None:
            its.active = index
            return binding
    its.active = len(its.bindings)
    return its.bindings.add()


class MakeCage(Work):
    """Makes a cage around the selected meshes, without binding them"""
    bl_idname = 'cageform.make_cage'
    bl_label = 'Make Cage'
    bl_options = {'UNDO'}

    vertices: bpy.props.IntProperty(name='Vertices', default=112, min=8, soft_max=500, description='Approximate number of vertices')
    margin: bpy.props.FloatProperty(name='Margin', default=0.02, min=0.006, max=0.5, precision=3,
                                    description='Distance to the mesh, relative to its size')
    mirror: bpy.props.EnumProperty(name='Mirror', description='Make the cage symmetric along a global axis',
                                   items=[('none', 'None', ''), ('x', 'X', ''), ('y', 'Y', ''), ('z', 'Z', '')])

    @classmethod
    def poll(cls, context):
        return any(item.type == 'MESH' for item in context.selected_objects)

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        depsgraph = context.evaluated_depsgraph_get()
        self.figures = [item for item in context.selected_objects if item.type == 'MESH']
        points, triangles, before = [], [], 0
        for figure in self.figures:
            own, corners = shown_triangles(figure, depsgraph)
            triangles.append(corners + before)
            points.append(own)
            before += len(own)
        options = {'vertices': self.vertices, 'margin': self.margin, 'mirror': None if self.mirror == 'none' else self.mirror}
        points, triangles = np.concatenate(points), np.concatenate(triangles)
        if not len(triangles):
            self.report({'ERROR'}, 'The selected meshes have no faces.')
            return {'CANCELLED'}
        return self.start(context, lambda **running: library.make_cage(points, triangles, **options, **running))

    def take(self, context, result):
        made, report = result
        centre = (made.vertices.min(axis=0) + made.vertices.max(axis=0)) / 2
        name = self.figures[0].name + ' cage'
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata((made.vertices - centre).tolist(), [], [face.tolist() for face in made.faces])
        cage = bpy.data.objects.new(name, mesh)
        cage.location, cage.display_type, cage.hide_render = centre, 'WIRE', True
        context.collection.objects.link(cage)
        for figure in self.figures:
            add_binding(figure).cage = cage
        self.report({'INFO'}, 'Made a cage of %d vertices' % report.vertices)


def shown_triangles(figure, depsgraph):
    """Returns the vertices in world space and the triangles of an object as shown."""
    evaluated = figure.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    points, triangles = deform.moved(deform.positions(mesh).astype(np.float64), evaluated.matrix_world), triangles_of(mesh)
    evaluated.to_mesh_clear()
    return points, triangles


def triangles_of(mesh):
    mesh.calc_loop_triangles()
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get('vertices', corners)
    return corners.reshape(-1, 3)


class AddCage(bpy.types.Operator):
    """Uses the other selected mesh as a cage of the active mesh"""
    bl_idname = 'cageform.add_cage'
    bl_label = 'Use Selected as Cage'
    bl_options = {'UNDO'}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == 'MESH'

    def execute(self, context):
        binding = add_binding(context.object)
        others = [item for item in context.selected_objects if item.type == 'MESH' and item != context.object]
        if len(others) == 1:
            binding.cage = others[0]
        return {'FINISHED'}


class RemoveCage(bpy.types.Operator):
    """Removes the binding and its shape key, which restores the mesh. The cage stays in the scene"""
    bl_idname = 'cageform.remove_cage'
    bl_label = 'Unbind'
    bl_options = {'UNDO'}

    @classmethod
    def poll(cls, context):
        return active_binding(context) is not None

    def execute(self, context):
        to_object_mode(context)
        its = context.object.cageform
        deform.detach(active_binding(context))
        its.bindings.remove(its.active)
        its.active = max(0, its.active - 1)
        return {'FINISHED'}


class Bind(Work):
    """Binds the mesh to its cage, ignoring shape keys and modifiers of both. The mesh then follows the cage"""
    bl_idname = 'cageform.bind'
    bl_label = 'Bind'
    bl_options = {'UNDO'}

    @classmethod
    def poll(cls, context):
        return active_binding(context) is not None

    def execute(self, context):
        binding = active_binding(context)
        figure, cage = context.object, binding.cage
        fault = ''
        if not deform.is_in_scene(cage):
            fault = 'There is no cage: make one, or choose a mesh as the cage.'
        elif cage == figure:
            fault = 'The cage is the mesh itself: choose another mesh.'
        elif cage.data == figure.data:
            fault = 'The cage shares the data of the mesh: make it single-user.'
        elif any(other.cage == cage and other.data is not None and other != binding for other in figure.cageform.bindings):
            fault = 'This cage already moves the mesh.'
        elif not len(cage.data.polygons):
            fault = 'The cage has no faces.'
        elif not len(figure.data.vertices):
            fault = 'The mesh has no vertices.'
        elif not all(figure.matrix_world.to_scale()) or not all(cage.matrix_world.to_scale()):
            fault = 'The scale of the mesh or the cage is 0.'
        if fault:
            binding.refused = fault
            self.report({'ERROR'}, fault)
            return {'CANCELLED'}
        to_object_mode(context)
        settings, self.placed = deform.settings_of(binding), deform.place(binding)
        from_cage, from_mesh = self.placed
        points = deform.moved(deform.rest_positions(figure).astype(np.float64), from_mesh)
        corners = deform.moved(deform.rest_positions(cage).astype(np.float64), from_cage)
        described = deform.cage_of(corners, cage.data, np.linalg.det(from_cage) < 0)

        def work(**running):
            coordinates = deform.coordinates_of(described, settings)
            bound = coordinates.bind(points, outside=settings['outside'], falloff=settings['falloff'], **running)
            return bound, bound.pack()[0]

        return self.start(context, work)

    def take(self, context, result):
        bound, packed = result
        binding = active_binding(context)
        deform.keep(binding, packed, bound, self.placed)
        deform.attach(binding)
        binding.report, binding.refused = words_of(bound.report, binding), ''
        follow.start(binding, context.evaluated_depsgraph_get())
        self.report({'INFO'}, binding.report.splitlines()[0])

    def refuse(self, context, error):
        active_binding(context).refused = deform.sentence(error)


def words_of(report, binding):
    """Returns the result of a bind as text, one sentence per line."""
    lines = ['Bound %d vertices.' % report.points, 'It took %.2f s.' % report.seconds]
    if report.outside:
        stays = binding.outside == 'keep_in_place' or binding.outside == 'extend' and binding.kind in INSIDE_ONLY
        lines.append('Vertices outside the cage: %d. They %s.' % (report.outside, 'stay' if stays else 'follow'))
    if report.not_finite:
        lines.append('Vertices with a position that is not finite: %d. They stay.' % report.not_finite)
    if report.unreached:
        lines.append('Vertices too near the cage for this accuracy: %d. They stay.' % report.unreached)
    if report.warnings:
        first = str(report.fault).replace(' (warning)', '')
        lines.append('Warnings about the cage: %d. The first: %s.' % (report.warnings, first))
    if report.least_weight < -0.01:
        lines.append('The lowest weight is %.2f: parts may move in the opposite direction.' % report.least_weight)
    shared = sum(item.data == binding.id_data.data for item in bpy.data.objects)
    if shared > 1:
        lines.append('%d objects share this mesh: all of them move.' % shared)
    return '\n'.join(lines)


class SelectOutside(bpy.types.Operator):
    """Selects, in edit mode, the vertices that were outside the cage at the bind"""
    bl_idname = 'cageform.select_outside'
    bl_label = 'Select Vertices Outside'
    bl_options = {'UNDO'}

    @classmethod
    def poll(cls, context):
        return is_bound(context) and len(active_binding(context).data['outside']) > 0

    def execute(self, context):
        indices = np.frombuffer(active_binding(context).data['outside'], np.uint32)
        select(context, context.object, indices, 'VERT')
        return {'FINISHED'}


class SelectFaults(bpy.types.Operator):
    """Selects the faulty vertices and faces of the cage in edit mode"""
    bl_idname = 'cageform.select_faults'
    bl_label = 'Select Faults of the Cage'
    bl_options = {'UNDO'}

    @classmethod
    def poll(cls, context):
        binding = active_binding(context)
        return binding is not None and deform.is_in_scene(binding.cage)

    def execute(self, context):
        cage = active_binding(context).cage
        faults = library.check(deform.cage_of(deform.rest_positions(cage), cage.data))
        faults = [fault for fault in faults if not fault.is_warning] or faults
        named = [element for fault in faults for element in (fault.a, fault.b) if element is not None]
        if not named:
            self.report({'INFO'}, 'The cage has no faulty vertices or faces')
            return {'CANCELLED'}
        faces = [index for kind, index in named if kind == 'face']
        vertices = [index for kind, index in named if kind != 'face']
        select(context, cage, np.array(faces or vertices), 'FACE' if faces else 'VERT')
        self.report({'WARNING'}, 'Faults: %d. The first: %s' % (len(faults), faults[0]))
        return {'FINISHED'}


def select(context, item, indices, mode):
    """Shows an object in edit mode with some of its vertices or faces selected."""
    to_object_mode(context)
    item.hide_viewport = False
    item.hide_set(False)
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


CLASSES = (MakeCage, AddCage, RemoveCage, Bind, SelectOutside, SelectFaults)
