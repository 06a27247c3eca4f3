"""Update handlers: after Blender evaluates a scene, cages follow their pins, and meshes follow their cages."""

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import deform, library, pins

_poses = {}      # from (name of the mesh's object, shape key) to the pose of the cage that the mesh shows
_edited = set()  # the same pairs: meshes in edit mode
_differ = set()  # the same pairs: meshes with vertices moved in edit mode


def forget():
    for its in (_poses, _edited, _differ):
        its.clear()
    pins.forget()


def start(binding, depsgraph):
    """Lets a mesh follow its cage."""
    its = binding.id_data.name_full, binding.key
    _poses.pop(its, None)
    _differ.discard(its)
    update(binding, depsgraph)


def update(binding, depsgraph, vertices=None, fault=''):
    """Clones a mesh if its cage has moved. `vertices` are those of the cage if pins moved it, `fault` is an error of the pins."""
    figure, its = deform.figure_of(binding), (binding.id_data.name_full, binding.key)
    if figure is None:
        return
    if binding.id_data.mode == 'EDIT':
        _edited.add(its)
        _poses.pop(its, None)  # edit mode also changes shape keys
        return
    fault = deform.problem(binding, figure) or fault
    if not fault and its in _edited:
        _edited.discard(its)
        (_differ.add if deform.was_edited(binding) else _differ.discard)(its)
    if not fault and vertices is None:
        vertices, fault = deform.cage_positions(binding, depsgraph)
    key = deform.key_of(binding)
    if fault or key.mute:
        deform.say(binding, fault)
        return
    pose = deform.moved(vertices.astype(np.float64), deform.bound_from_cage(binding, depsgraph))
    if not np.isfinite(pose).all():
        fault = 'A vertex of the cage has a position that is not finite.'
    elif its in _differ:
        fault = 'Vertices of the mesh were moved in edit mode: bind again.'
    deform.say(binding, fault)
    if not np.isfinite(pose).all() or np.array_equal(_poses.get(its), pose):
        return
    _poses[its] = pose
    try:
        deform.write_key(key, deform.moved(deform.clone(figure, pose), deform.matrix_of(binding, 'to_mesh')))
    except library.CageformError as error:
        deform.say(binding, deform.sentence(error))
    binding.id_data.data.update()


def update_all(depsgraph):
    pulled = {}  # from a cage's name to (its vertices or None, a fault). The first mesh with pins moves the cage
    bindings = deform.bindings()
    for binding in bindings:
        if len(binding.pins) and binding.cage is not None and binding.cage.name_full not in pulled:
            pulled[binding.cage.name_full] = pins.pull(binding, depsgraph)
    written = set()  # linked duplicates share a mesh and its shape key: only the first object writes it
    for binding in bindings:
        its = binding.id_data.data.name_full, binding.key
        if its not in written:
            written.add(its)
            vertices, fault = pulled.get(binding.cage.name_full, (None, '')) if binding.cage is not None else (None, '')
            update(binding, depsgraph, vertices, fault if len(binding.pins) else '')


@persistent
def after_evaluation(scene, depsgraph):
    update_all(depsgraph)


@persistent
def after_load(*_):
    forget()
    deform.forget()
    update_all(bpy.context.evaluated_depsgraph_get())


@persistent
def after_undo(*_):
    forget()


HANDLERS = (('depsgraph_update_post', after_evaluation), ('frame_change_post', after_evaluation), ('load_post', after_load),
            ('undo_post', after_undo), ('redo_post', after_undo))
