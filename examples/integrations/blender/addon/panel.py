"""The panel in the sidebar of the 3D Viewport."""

import blf
import bpy

from . import deform
from .export import Bake, WriteFigure, WriteGltf
from .operators import AddCage, Bind, MakeCage, RemoveCage, SelectFaults, SelectOutside, active_binding
from .pin_operators import AddPins, RemovePins
from .wrap_operator import WrapOnto


def write(layout, context, text):
    """Writes a text in lines that fit the sidebar."""
    scale = context.preferences.system.ui_scale
    room = context.region.width - 75 * scale  # without tabs and margins
    blf.size(0, 11 * scale)
    for sentence in text.splitlines():
        line = ''
        for word in sentence.split():
            longer = line + ' ' + word if line else word
            if line and blf.dimensions(0, longer)[0] > room:
                layout.label(text=line)
                longer = word
            line = longer
        layout.label(text=line)


class CAGEFORM_UL_bindings(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        layout.label(text=item.cage.name if item.cage else 'No cage', icon='MESH_ICOSPHERE')


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
        layout.operator(MakeCage.bl_idname, icon='MESH_ICOSPHERE')
        layout.operator(AddCage.bl_idname)
        layout.operator(WrapOnto.bl_idname, icon='MOD_SHRINKWRAP')
        its = figure.cageform
        if len(its.bindings) > 1:
            layout.template_list('CAGEFORM_UL_bindings', '', its, 'bindings', its, 'active', rows=2)
        binding = active_binding(context)
        if binding is None:
            return
        self.draw_settings(context, binding)
        if binding.data is not None:
            self.draw_motion(context, binding)

    def draw_settings(self, context, binding):
        layout = self.layout
        column = layout.column()
        column.use_property_split, column.use_property_decorate = True, False
        column.prop(binding, 'cage')
        column.prop(binding, 'kind')
        if binding.kind == 'harmonic':
            column.prop(binding, 'accuracy')
            column.prop(binding, 'locality')
        column.prop(binding, 'outside')
        if binding.outside != 'keep_in_place':
            column.prop(binding, 'falloff')
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.operator(Bind.bl_idname, icon='LINKED')
        row.operator(RemoveCage.bl_idname, text='', icon='X')
        if binding.data is not None and deform.settings_as_bound(binding) != deform.settings_of(binding):
            write(layout, context, 'The settings have changed: bind again to use them.')
        for fault in filter(None, (binding.refused, binding.fault)):
            box = layout.box()
            box.alert = True
            write(box.column(align=True), context, fault)
        if binding.refused or binding.data is not None and binding.data['warnings']:
            layout.operator(SelectFaults.bl_idname)

    def draw_motion(self, context, binding):
        layout = self.layout
        write(layout.column(align=True), context, binding.report)
        if SelectOutside.poll(context):
            layout.operator(SelectOutside.bl_idname)
        row = layout.row(align=True)
        row.operator(AddPins.bl_idname, icon='PINNED')
        row.operator(RemovePins.bl_idname, text='', icon='X')
        column = layout.column(align=True)
        for operator in (Bake, WriteGltf, WriteFigure):
            column.operator(operator.bl_idname)


CLASSES = (CAGEFORM_UL_bindings, CAGEFORM_PT_panel)
