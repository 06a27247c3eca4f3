"""A bound mesh: its weights, stored as bytes in the .blend file, and the shape key that follows the cage."""

import ctypes
import uuid

import bpy
import numpy as np

from . import library

NAME = 'Cageform'  # name of shape keys and constraints

_figures = {}  # from the stamp of a binding to its opened Figure


def forget():
    _figures.clear()


def bindings():
    """Returns all bindings of the file; fast for thousands of objects without bindings."""
    by_name = bpy.app.version < (5, 0)  # later versions separate properties of add-ons from custom properties
    return [binding for item in bpy.data.objects if ('cageform' in item if by_name else item.type == 'MESH')
            for binding in item.cageform.bindings]


def is_in_scene(item):
    """Whether an object is in the scene. A property that refers to a deleted object keeps the object in the file."""
    return item is not None and item.name in bpy.context.scene.objects


# ---- weights -----------------------------------------------------------------------------------------------------------

def settings_of(binding):
    return {'kind': binding.kind, 'accuracy': binding.accuracy, 'locality': binding.locality, 'outside': binding.outside,
            'falloff': binding.falloff}


def keep(binding, packed, bound, placed):
    """Stores weights and their settings in a hidden text that duplicates of the object share. Blender copies custom
    properties of objects in every frame, but not those of texts."""
    drop(binding)
    binding.data = data = bpy.data.texts.new('.' + NAME)
    data.use_fake_user = False
    data['stamp'] = uuid.uuid4().hex
    data['figure'], data['outside'] = bytes(packed), np.asarray(bound.outside, np.uint32).tobytes()
    data['warnings'] = bound.report.warnings
    data['settings'] = settings_of(binding)
    for name, matrix in zip(('from_cage', 'from_mesh', 'to_mesh'), (*placed, np.linalg.inv(placed[1]))):
        data[name] = matrix.ravel().tolist()


def drop(binding):
    data, binding.data = binding.data, None
    if data is not None and data.users == 0:
        bpy.data.texts.remove(data)


def settings_as_bound(binding):
    return {'locality': 0.0, **binding.data['settings']}  # 0.2.0 stored no locality


def figure_of(binding):
    """Returns the figure of a binding; None if it is not bound. The first call opens the figure."""
    if binding.data is None:
        return None
    stamp = binding.data['stamp']
    if stamp not in _figures:
        _figures[stamp] = library.open(binding.data['figure'], skip_checksum=True)
    return _figures[stamp]


# ---- points ------------------------------------------------------------------------------------------------------------

def places_of(elements):
    numbers = np.empty(3 * len(elements), np.float32)
    elements.foreach_get('co', numbers)
    return numbers.reshape(-1, 3)


def positions(mesh):
    """The vertices of a mesh: (#vertices, 3)."""
    return places_of(mesh.vertices)


def key_positions(key):
    """The vertices of a shape key: (#vertices, 3)."""
    return places_of(key.data)


def write_key(key, points):
    """Writes the vertices of a shape key."""
    numbers = np.ascontiguousarray(points, np.float32).ravel()
    if hasattr(key, 'points'):  # since Blender 4.1
        key.points.foreach_set('co', numbers)
        return
    # In earlier versions foreach_set calls a function per vertex: 7 ms for 50,000. The numbers are contiguous.
    count, first = len(key.data), key.data[0].as_pointer() if len(key.data) else 0
    if count > 1 and 3 * count == len(numbers) and key.data[count - 1].as_pointer() == first + 12 * (count - 1):
        ctypes.memmove(first, numbers.ctypes.data, numbers.nbytes)
    else:
        key.data.foreach_set('co', numbers)


def rest_positions(item):
    """The vertices of an object without shape keys."""
    keys = item.data.shape_keys
    return positions(item.data) if keys is None else key_positions(keys.reference_key)


def shown_positions(item, depsgraph):
    """The vertices of an object as shown, with shape keys and modifiers, also in edit mode."""
    evaluated = item.evaluated_get(depsgraph)
    points = positions(evaluated.to_mesh())
    evaluated.to_mesh_clear()
    return points


def moved(points, matrix):
    """Returns points transformed by a matrix (4, 4), in the scalar of the points."""
    matrix = np.array(matrix, dtype=points.dtype)
    return np.einsum('ij,kj->ik', points, matrix[:3, :3]) + matrix[:3, 3]  # faster than a matrix product, which starts threads


# ---- spaces ------------------------------------------------------------------------------------------------------------
# Weights are computed in the space of the cage, scaled and rotated as at the bind. All meshes of a cage therefore share one
# space, and seams between them stay closed.

def place(binding):
    """Returns the matrices (4, 4) from the spaces of the cage and of the mesh to the space of a new binding."""
    cage, figure = binding.cage.matrix_world, binding.id_data.matrix_world
    turned = cage.to_3x3().to_4x4()
    return np.array(turned), np.array(turned @ cage.inverted() @ figure)


def matrix_of(binding, name):
    """Returns a matrix of the time of the bind: 'from_cage', 'from_mesh', or 'to_mesh', the inverse of 'from_mesh'."""
    return np.reshape(binding.data[name], (4, 4))


def bound_from_cage(binding, depsgraph):
    """Returns the current matrix from the space of the cage to that of a binding."""
    cage, figure = binding.cage.evaluated_get(depsgraph), binding.id_data.evaluated_get(depsgraph)
    return matrix_of(binding, 'from_mesh') @ np.array(figure.matrix_world.inverted_safe() @ cage.matrix_world)


# ---- cages -------------------------------------------------------------------------------------------------------------

def cage_of(points, mesh, is_mirrored=False):
    """Returns a cage of the library with the faces of a mesh. Reverses the faces if the points are mirrored."""
    faces = [list(polygon.vertices)[::-1 if is_mirrored else 1] for polygon in mesh.polygons]
    return library.Cage.mesh(points, faces, off_plane=1e-6 * float(np.ptp(points, axis=0).max()) if len(points) else 0)


def coordinates_of(cage, settings):
    options = {'accuracy': settings['accuracy'], 'locality': settings['locality']} if settings['kind'] == 'harmonic' else {}
    return library.Coordinates(cage, settings['kind'], np.float32, **options)


def coordinates_as_bound(binding):
    """Creates the coordinates of a binding again, from the cage at rest as it was bound."""
    settings, mirrored = settings_as_bound(binding), np.linalg.det(matrix_of(binding, 'from_cage')) < 0
    rest = figure_of(binding).rest()[:len(binding.cage.data.vertices)]
    return coordinates_of(cage_of(rest, binding.cage.data, mirrored), settings)


# ---- the shape key -----------------------------------------------------------------------------------------------------

def add_key(item, name):
    """Adds a visible shape key and returns it."""
    if item.data.shape_keys is None:
        item.shape_key_add(name='Basis', from_mix=False)
    key = item.shape_key_add(name=name, from_mix=False)
    key.value = 1
    return key


def find_key(item, name):
    keys = item.data.shape_keys
    return None if keys is None else keys.key_blocks.get(name)


def key_of(binding):
    """Returns the shape key that a binding writes; None if there is none."""
    return find_key(binding.id_data, binding.key)


def constraint_of(binding):
    return binding.id_data.constraints.get(binding.key) if binding.key else None


def depend(binding):
    """Adds a disabled constraint, which tells Blender that the mesh depends on the cage. Without it Blender does not evaluate
    cages that are hidden in the viewport or in renders. A vertex group name, which may be arbitrary, makes it depend on vertices."""
    constraint, parent = constraint_of(binding), binding.cage
    while parent is not None and parent != binding.id_data:
        parent = parent.parent
    if constraint is not None:
        constraint.target = None if parent == binding.id_data else binding.cage  # a cage cannot be above its parent
        constraint.subtarget = NAME


def attach(binding):
    """Adds the shape key and the constraint, if they are missing."""
    if key_of(binding) is None:
        binding.key = add_key(binding.id_data, NAME).name
    if constraint_of(binding) is None:
        constraint = binding.id_data.constraints.new('CHILD_OF')
        constraint.name, constraint.mute, constraint.show_expanded = binding.key, True, False
    depend(binding)


def detach(binding):
    """Removes the shape key, the constraint and the weights."""
    key, constraint = key_of(binding), constraint_of(binding)
    if key is not None:
        binding.id_data.shape_key_remove(key)
    if constraint is not None:
        binding.id_data.constraints.remove(constraint)
    drop(binding)


# ---- following ---------------------------------------------------------------------------------------------------------

def problem(binding, figure):
    """Returns why a mesh cannot follow its cage, as a sentence; '' if it can."""
    mesh, cage = binding.id_data.data, binding.cage
    if not is_in_scene(cage):
        return 'The cage is gone: undo, or choose another cage and bind again.'
    if len(mesh.vertices) != figure.points:
        return 'The mesh has %d vertices and had %d when it was bound: bind again.' % (len(mesh.vertices), figure.points)
    if len(cage.data.vertices) != figure.vertices:
        return 'The cage has %d vertices and had %d when it was bound: bind again.' % (len(cage.data.vertices),
                                                                                       figure.vertices)
    if key_of(binding) is None:
        return 'The shape key "%s" is gone: bind again.' % binding.key
    if not mesh.shape_keys.use_relative:
        return 'The shape keys are absolute: turn on Relative in the list of shape keys.'
    return ''


def sentence(error):
    """Returns an error of the library as a sentence."""
    text = str(error)
    return text[:1].upper() + text[1:] + '.'


def say(binding, fault):
    """Shows a fault in the panel; '' removes it."""
    if binding.fault != fault:
        binding.fault = fault


def cage_positions(binding, depsgraph):
    """Returns the vertices of the cage as shown, in its own space, and a sentence if modifiers change their number."""
    points, bound = shown_positions(binding.cage, depsgraph), figure_of(binding).vertices
    if len(points) == bound:
        return points, ''
    return None, 'The cage has %d vertices with its modifiers and %d without: turn these modifiers off.' % (len(points), bound)


def was_edited(binding):
    """Whether vertices of the mesh were moved after the bind."""
    figure = figure_of(binding)
    now, bound = moved(rest_positions(binding.id_data), matrix_of(binding, 'from_mesh')), figure.clone(figure.rest())
    return bool(np.abs(now - bound).max() > 1e-5 * np.ptp(bound, axis=0).max())


def clone(figure, vertices):
    """Returns the points of a figure for a pose of the cage's vertices, in the space of the binding."""
    return figure.clone(figure.pose_handles(vertices) if figure.handles != figure.vertices else vertices)
