"""What moves figures: bindings kept as bytes in the .blend, opened once, cloned whenever a cage has moved."""

import bmesh
import bpy
import numpy as np

from . import library

FIGURE, SAMPLES, OUTSIDE = 'cageform_figure', 'cageform_samples', 'cageform_outside'

_opened = {}   # (object's name, binding's number): (hash of the bytes, Figure)
_last = {}     # as above: the pose that was cloned last
_pinned = {}   # as above: (hash, Pins, the pins' vertices)


def forget():
    """Drops what belongs to the file that was open."""
    for cache in (_opened, _last, _pinned):
        cache.clear()


def key_of(binding):
    return binding.id_data.name_full, binding.number


def store(binding, name, data):
    """Keeps bytes in the .blend, with the object of the binding."""
    binding.id_data['%s_%d' % (name, binding.number)] = bytes(data)


def stored(binding, name):
    return binding.id_data.get('%s_%d' % (name, binding.number))


def drop(binding):
    for name in (FIGURE, SAMPLES, OUTSIDE):
        binding.id_data.pop('%s_%d' % (name, binding.number), None)
    for cache in (_opened, _last, _pinned):
        cache.pop(key_of(binding), None)


def figure_of(binding):
    """The figure of a binding, opened where it lies; None if there is none."""
    data = stored(binding, FIGURE)
    if data is None:
        return None
    data = bytes(data)
    mark = hash(data)
    known = _opened.get(key_of(binding))
    if known is None or known[0] != mark:
        known = _opened[key_of(binding)] = (mark, library.open(data, skip_checksum=True))
        _last.pop(key_of(binding), None)
    return known[1]


def positions(mesh):
    """The vertices of a mesh: (#vertices, 3)."""
    numbers = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get('co', numbers)
    return numbers.reshape(-1, 3)


def rest_positions(figure):
    """The vertices of an object without what shape keys do to them."""
    keys = figure.data.shape_keys
    if keys is None:
        return positions(figure.data)
    numbers = np.empty(3 * len(figure.data.vertices), np.float32)
    keys.reference_key.data.foreach_get('co', numbers)
    return numbers.reshape(-1, 3)


def moved(points, matrix):
    """Points by a matrix of Blender's, in double."""
    matrix = np.array(matrix, dtype=np.float64)
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def cage_positions(binding, depsgraph):
    """The vertices of the cage as it is now, also while it is edited, in the space of the figure."""
    cage, figure = binding.cage, binding.id_data
    evaluated = cage.evaluated_get(depsgraph)
    if cage.mode == 'EDIT':
        mesh = bmesh.from_edit_mesh(cage.data)
        points = np.array([vertex.co for vertex in mesh.verts], dtype=np.float32).reshape(-1, 3)
    else:
        points = positions(evaluated.data)
    to_figure = figure.evaluated_get(depsgraph).matrix_world.inverted_safe() @ evaluated.matrix_world
    return moved(points, to_figure)


def shape_key(binding):
    """The shape key that a binding writes, made if it is missing."""
    figure = binding.id_data
    if figure.data.shape_keys is None:
        figure.shape_key_add(name='Basis', from_mix=False)
    name = 'Cageform' if binding.number == 0 else 'Cageform %d' % binding.number
    key = figure.data.shape_keys.key_blocks.get(name)
    if key is None:
        key = figure.shape_key_add(name=name, from_mix=False)
        key.value = 1
    return key


def update(binding, depsgraph, force=False):
    """Clones a figure if its cage has moved. Returns whether it has, and sets the binding's fault."""
    if binding.cage is None or binding.id_data.mode == 'EDIT':
        return False
    figure = figure_of(binding)
    if figure is None:
        return False
    pose = cage_positions(binding, depsgraph)
    if len(pose) != figure.vertices:
        fault = 'The cage has %d vertices, %d when it was bound: bind again.' % (len(pose), figure.vertices)
    elif len(binding.id_data.data.vertices) != figure.points:
        fault = 'The mesh has %d vertices, %d when it was bound: bind again.' % (len(binding.id_data.data.vertices),
                                                                                  figure.points)
    else:
        fault = ''
    if binding.fault != fault:
        binding.fault = fault
    if fault:
        return False
    last = _last.get(key_of(binding))
    if not force and last is not None and last.shape == pose.shape and (last == pose).all():
        return False
    _last[key_of(binding)] = pose
    try:
        handles = figure.pose_handles(pose) if figure.handles != figure.vertices else pose
        points = figure.clone(handles)
    except library.CageformError as error:
        binding.fault = str(error)
        return False
    key = shape_key(binding)
    key.data.foreach_set('co', points.astype(np.float32).ravel())
    binding.id_data.data.update()
    return True


def bindings():
    """All bindings of the file."""
    for figure in bpy.data.objects:
        if figure.type == 'MESH':
            yield from figure.cageform.bindings


# ---- pins --------------------------------------------------------------------------------------------------------------

def solver_of(binding):
    """The solver of a binding's pins; None if it has none. Empties that were deleted are forgotten."""
    pins = [pin for pin in binding.pins if pin.empty is not None]
    data = stored(binding, SAMPLES)
    if not pins or data is None:
        return None, []
    vertices = [pin.vertex for pin in pins]
    mark = hash((bytes(data), tuple(vertices)))
    known = _pinned.get(key_of(binding))
    if known is None or known[0] != mark:
        solver = library.Pins(library.open_samples(bytes(data), skip_checksum=True))
        solver.set(figure_of(binding), vertices)
        known = _pinned[key_of(binding)] = (mark, solver)
    return known[1], pins


def pull(binding, depsgraph):
    """Moves the cage so that pinned vertices are at their empties. Returns the report of the last frame; None if nothing is
    pinned."""
    solver, pins = solver_of(binding)
    if solver is None:
        return None
    figure, cage = binding.id_data, binding.cage
    to_figure = figure.matrix_world.inverted_safe()
    targets = moved(np.array([pin.empty.evaluated_get(depsgraph).matrix_world.translation for pin in pins]), to_figure)
    pose = moved(positions(cage.data), to_figure @ cage.matrix_world)
    report = None
    for _ in range(200):
        pose, report = solver.solve(targets, pose)
        if report.settled:
            break
    back = moved(pose, cage.matrix_world.inverted_safe() @ figure.matrix_world)
    cage.data.vertices.foreach_set('co', back.astype(np.float32).ravel())
    cage.data.update()
    return report
