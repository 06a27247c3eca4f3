"""Properties of bound objects, stored in the .blend file."""

import bpy

from . import deform

KINDS = [  # .blend files store the numbers
    ('harmonic', 'Harmonic', 'Best for characters: a limb does not move other limbs. Vertices outside the cage stay', 0),
    ('maximum-entropy', 'Maximum Entropy', 'No negative weight, no solve. Vertices outside the cage stay', 3),
    ('mean-value', 'Mean Value', 'Binds fastest, and also moves vertices outside the cage', 1),
    ('green', 'Green', 'Preserves angles and details; the mesh may leave the cage', 2),
]
INSIDE_ONLY = ('harmonic', 'maximum-entropy')  # kinds without weights outside the cage
OUTSIDE = [
    ('extend', 'Follow', 'Vertices outside follow the cage; with Harmonic and Maximum Entropy they stay'),
    ('keep_in_place', 'Stay', 'Vertices outside stay where they are'),
    ('nearest_boundary', 'Follow the Nearest Face', 'Vertices outside move with the nearest face of the cage'),
]


class Pin(bpy.types.PropertyGroup):
    vertex: bpy.props.IntProperty()
    empty: bpy.props.PointerProperty(type=bpy.types.Object)


class Binding(bpy.types.PropertyGroup):
    cage: bpy.props.PointerProperty(name='Cage', type=bpy.types.Object, poll=lambda _, item: item.type == 'MESH',
                                    update=lambda self, _: deform.depend(self),
                                    description='The mesh that moves this mesh: closed, with few faces')
    kind: bpy.props.EnumProperty(name='Type', items=KINDS, default='harmonic')
    accuracy: bpy.props.FloatProperty(name='Accuracy', default=1e-2, min=1e-4, soft_min=1e-3, max=0.1, precision=4,
                                      description='Maximum error of a weight: smaller values make Bind slower')
    locality: bpy.props.FloatProperty(name='Locality', min=0, max=40, precision=1,
                                      description='Fewer vertices of the cage move a point: 40 leaves out a tenth')
    outside: bpy.props.EnumProperty(name='Outside', items=OUTSIDE,
                                    description='Motion of vertices outside the cage')
    falloff: bpy.props.FloatProperty(name='Falloff', min=0, subtype='DISTANCE',
                                     description='Distance outside the cage at which displacements reach 0. '
                                                 '0: no falloff')
    key: bpy.props.StringProperty(description='The shape key of the mesh that this binding writes')
    data: bpy.props.PointerProperty(type=bpy.types.Text, description='The stored weights')
    report: bpy.props.StringProperty(description='Result of the last bind')
    refused: bpy.props.StringProperty(description='Why the mesh could not be bound')
    fault: bpy.props.StringProperty(description='Why the mesh does not follow')
    pins: bpy.props.CollectionProperty(type=Pin)


class Bindings(bpy.types.PropertyGroup):
    bindings: bpy.props.CollectionProperty(type=Binding)
    active: bpy.props.IntProperty()


CLASSES = (Pin, Binding, Bindings)
