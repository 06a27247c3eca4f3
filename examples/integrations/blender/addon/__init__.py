"""Cageform in Blender: a bound mesh follows its cage while the cage is edited, keyed, posed or moved by pins."""

bl_info = {
    'name': 'Cageform',
    'description': 'Deforms a mesh with a cage around it; pins on the mesh move the cage',
    'author': 'the cageform project',
    'version': (0, 2, 0),
    'blender': (3, 4, 0),
    'location': '3D Viewport > Sidebar > Cageform',
    'category': 'Rigging',
}

import bpy

from . import deform, export, follow, operators, panel, pin_operators, properties, wrap_operator

CLASSES = (properties.CLASSES + operators.CLASSES + pin_operators.CLASSES + wrap_operator.CLASSES + export.CLASSES +
           panel.CLASSES)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Object.cageform = bpy.props.PointerProperty(type=properties.Bindings)
    for name, handler in follow.HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in follow.HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    del bpy.types.Object.cageform
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
    follow.forget()
    deform.forget()
