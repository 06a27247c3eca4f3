"""Helpers of the add-on's tests: scenes, and the positions that the Python package computes for the same meshes."""

import os
import tempfile

import bpy
import numpy as np

import cageform
from cageform import deform, library
from cageform.properties import KINDS as TYPES

folder = tempfile.mkdtemp()
KINDS = [kind for kind, *_ in TYPES]


def empty_scene():
    bpy.ops.wm.read_homefile(use_empty=True)


def select_only(*items):
    for item in bpy.context.selected_objects:
        item.select_set(False)
    for item in items:
        item.select_set(True)
    bpy.context.view_layer.objects.active = items[-1]


def monkey(vertices=500, **place):
    """Suzanne with about 500, 2,000, 8,000 or 50,000 vertices."""
    bpy.ops.mesh.primitive_monkey_add(**place)
    figure = bpy.context.object
    levels = {500: 0, 2000: 1, 8000: 2, 50000: 1}[vertices]
    if levels:
        figure.modifiers.new('Subdivision', 'SUBSURF').levels = levels
        bpy.ops.object.modifier_apply(modifier='Subdivision')
    if vertices == 50000:
        bpy.ops.object.mode_set(mode='EDIT')
        bpy.ops.mesh.select_all(action='SELECT')
        bpy.ops.mesh.subdivide(number_cuts=4, smoothness=1)
        bpy.ops.object.mode_set(mode='OBJECT')
    return figure


def box(name='Box', size=3, location=(0, 0, 0)):
    bpy.ops.mesh.primitive_cube_add(size=size, location=location)
    bpy.context.object.name = name
    bpy.context.object.display_type = 'WIRE'
    return bpy.context.object


def bind(figure, cage=None, **settings):
    """Binds a mesh and returns the binding. Makes a cage if none is given."""
    if cage is None:
        select_only(figure)
        bpy.ops.cageform.make_cage(vertices=60)
        select_only(figure)
    else:
        select_only(figure)
        bpy.ops.cageform.add_cage()
        figure.cageform.bindings[figure.cageform.active].cage = cage
    binding = figure.cageform.bindings[figure.cageform.active]
    for name, value in settings.items():
        setattr(binding, name, value)
    bpy.ops.cageform.bind()
    return figure.cageform.bindings[figure.cageform.active]


def bound_monkey(vertices):
    """A scene with a monkey bound to a cage of make_cage; the cage is computed once."""
    path = os.path.join(folder, 'monkey_%d.blend' % vertices)
    if not os.path.exists(path):
        empty_scene()
        bind(monkey(vertices))
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    return bpy.data.objects['Suzanne']


def move(cage, pose):
    """Moves the vertices of a cage in its own space."""
    cage.data.vertices.foreach_set('co', np.ascontiguousarray(pose, np.float32).ravel())
    cage.data.update()
    bpy.context.view_layer.update()


def bent(points, amount=0.4):
    """Returns a pose of any points: a shear that grows with the height, and a swelling."""
    points = np.array(points, dtype=np.float64)
    points[:, 0] += amount * points[:, 2] ** 2
    points[:, 1] *= 1 + amount * np.sin(points[:, 2])
    return points


def key_of(figure, index=0):
    return deform.key_positions(deform.key_of(figure.cageform.bindings[index]))


def shown(item):
    """The vertices of an object as Blender shows it, in world space."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return deform.moved(deform.shown_positions(item, depsgraph).astype(np.float64), item.evaluated_get(depsgraph).matrix_world)


def world(item, points):
    return deform.moved(np.asarray(points, np.float64), item.matrix_world)


def write_obj(name, points, faces):
    path = os.path.join(folder, name)
    with open(path, 'w', encoding='utf-8') as file:
        file.writelines('v %.9g %.9g %.9g\n' % tuple(point) for point in np.float32(points))
        file.writelines('f %s\n' % ' '.join(str(vertex + 1) for vertex in face) for face in faces)
    return path


def read_obj(path):
    points, faces = [], []
    with open(path, encoding='utf-8') as file:
        for line in file:
            kind, *rest = line.split()
            if kind == 'v':
                points.append([float(number) for number in rest[:3]])
            elif kind == 'f':
                faces.append([int(corner.split('/')[0]) - 1 for corner in rest])
    return np.array(points), faces


def expected(figure, cage, rest, pose, kind='harmonic'):
    """Returns the vertices of a mesh in world space, computed by the Python package from OBJ files. `rest` and `pose`
    are the cage's vertices in world space."""
    mirrored = cage.matrix_world.determinant() < 0
    faces = [list(face.vertices)[::-1 if mirrored else 1] for face in cage.data.polygons]
    centre = np.array(cage.matrix_world.translation)  # float positions are most accurate near the origin
    paths = [write_obj('figure.obj', world(figure, deform.rest_positions(figure)) - centre,
                       [list(face.vertices) for face in figure.data.polygons]),
             write_obj('cage.obj', rest - centre, faces), write_obj('pose.obj', pose - centre, faces)]
    points, (corners, faces), posed = read_obj(paths[0])[0], read_obj(paths[1]), read_obj(paths[2])[0]
    coordinates = library.Coordinates(library.Cage.mesh(corners, faces, off_plane=1e-6 * np.ptp(corners, axis=0).max()), kind,
                                      np.float32, accuracy=1e-2 if kind == 'harmonic' else 0)
    its = coordinates.bind(points).figure
    return its.clone(its.pose_handles(posed) if its.handles != its.vertices else posed) + centre


def off(points, others):
    """Returns the maximum distance between points, relative to the size of the second set."""
    return float(np.linalg.norm(np.asarray(points, np.float64) - others, axis=1).max() / np.ptp(others, axis=0).max())
