"""Cages: creation, checks, make_cage."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _c
from . import _arrays as arrays
from ._arrays import Array
from ._library import library
from ._objects import Progress, Running, make
from ._reports import Fault, Report
from .errors import check as check_status

if TYPE_CHECKING:
    import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class Cage:
    """A cage. It refers to the given arrays without a copy. Create one with polygon, mesh, curves, lattice, sites or
    make_cage."""

    kind: int
    vertices: Optional[Array] = None  #: (#vertices, dimension)
    counts: Optional[Array] = None    #: polygon: vertices per loop; mesh: corners per face; curves: degrees
    indices: Optional[Array] = None   #: mesh: the vertices at the corners of all faces
    loops: Optional[Array] = None     #: curves: edges per loop
    members: Dict[str, Any] = field(default_factory=dict)

    @staticmethod
    def polygon(vertices: npt.ArrayLike, loops: Optional[npt.ArrayLike] = None) -> Cage:
        """Makes a 2D cage of loops.

        vertices  (#vertices, 2): loop after loop, in either orientation; the inside is given by the even-odd rule
        loops     (#loops,): number of vertices per loop; None: one loop
        """
        return Cage(_c.CAGEFORM_POLYGON, arrays.points(vertices, 'vertices', 2), _optional(loops, 'loops'))

    @staticmethod
    def mesh(vertices: npt.ArrayLike, faces: Union[Array, Sequence[Sequence[int]]], divisions: int = 1,
             off_plane: float = 0) -> Cage:
        """Makes a 3D cage of faces.

        vertices   (#vertices, 3)
        faces      (#faces, corners) or a list of lists, counter-clockwise seen from outside
        divisions  divisions per side of quads, for mean value and harmonic coordinates
        off_plane  maximum distance of a corner from its face's plane; beyond it, a face is a fan around its mean
        """
        listed = [np.asarray(face) for face in faces]
        counts = [face.size for face in listed]
        corners = np.concatenate(listed) if listed else np.empty(0, np.uint32)
        return Cage(_c.CAGEFORM_MESH, arrays.points(vertices, 'vertices', 3), arrays.indices(counts, 'faces'),
                    arrays.indices(corners, 'faces'), members={'divisions': divisions, 'off_plane': off_plane})

    @staticmethod
    def curves(edges: Sequence[npt.ArrayLike], loops: Optional[npt.ArrayLike] = None) -> Cage:
        """Makes a 2D cage of loops of Bezier curves, for Green coordinates.

        edges  arrays (2 to 4, 2) of control points; each edge begins at the end of the previous one
        loops  (#loops,): number of edges per loop; None: one loop
        """
        listed = [arrays.points(edge, 'edges', 2, np.dtype(np.float64)) for edge in edges]
        if any(len(edge) < 2 for edge in listed):
            raise ValueError('edges: each must have 2 to 4 control points')
        vertices = np.concatenate(listed) if listed else np.empty((0, 2))
        return Cage(_c.CAGEFORM_CURVES, vertices, arrays.indices([len(edge) - 1 for edge in listed], 'edges'),
                    loops=_optional(loops, 'loops'))

    @staticmethod
    def lattice(points: npt.ArrayLike, origin: npt.ArrayLike, axes: npt.ArrayLike, degree: npt.ArrayLike = 3,
                falloff: float = 0) -> Cage:
        """Makes a box of splines, in 2D or 3D.

        points   control points along each axis: a number, or (dimension,)
        origin   (dimension,): a corner of the box
        axes     (dimension, dimension): the edges of the box from `origin`, one per row
        degree   of the splines along each axis: a number, or (dimension,)
        falloff  distance outside at which displacements reach 0; 0: no falloff
        """
        edges = arrays.numbers(axes, 'axes').astype(np.float64)
        if edges.shape not in ((2, 2), (3, 3)):
            raise ValueError('axes: must be an array of shape (2, 2) or (3, 3), not %s' % (edges.shape,))
        dimension = len(edges)
        members = {'points': arrays.indices(np.broadcast_to(np.asarray(points), dimension), 'points'),
                   'degree': arrays.indices(np.broadcast_to(np.asarray(degree), dimension), 'degree'),
                   'origin': arrays.doubles(origin, 'origin', dimension, 'axis'), 'axes': edges, 'falloff': falloff,
                   'dimension': dimension}
        return Cage(_c.CAGEFORM_LATTICE, members=members)

    @staticmethod
    def _of_lattice(its: Any) -> Cage:
        """Copies a lattice of the library in 3D."""
        members = {'points': np.array(its.points), 'degree': np.array(its.degree), 'origin': np.array(its.origin),
                   'axes': np.array(its.axes), 'dimension': 3}
        members['knots'] = [np.ctypeslib.as_array(its.knots[k], (its.knot_counts[k],)).copy() for k in range(3)]
        return Cage(_c.CAGEFORM_LATTICE, members=members)

    @staticmethod
    def sites(vertices: npt.ArrayLike) -> Cage:
        """Makes a cage of points without faces, (#sites, 2 or 3), for Sibson coordinates."""
        return Cage(_c.CAGEFORM_SITES, arrays.points(vertices, 'vertices'))

    def with_cells(self, vertices: npt.ArrayLike, bones: Sequence[Tuple[int, int, float]] = (),
                   walls: Optional[npt.ArrayLike] = None) -> Cage:
        """Returns a copy of this polygon or triangle mesh with cells inside, for harmonic coordinates.

        vertices  (#more, dimension): handles inside; their indices follow those of the cage
        bones     (a, b, radius): everything within the radius of the vertex (a = b) or, in 3D, of the edge moves with it
        walls     vertex indices: 2D edges (#walls, 2), 3D triangles (#walls, 3)
        """
        if self.vertices is None:
            raise ValueError('only polygons and meshes can have cells inside')
        more = arrays.points(vertices, 'vertices', self.vertices.shape[1])
        members = dict(self.members, cell_vertices=len(more), bones=[tuple(bone) for bone in bones],
                       walls=arrays.indices(() if walls is None else walls, 'walls'))
        return Cage(self.kind, np.concatenate([self.vertices, more]), self.counts, self.indices, self.loops, members)

    @property
    def faces(self) -> Union[Array, List[Array], None]:
        """The faces of a mesh: (#faces, corners), or a list of arrays if numbers of corners differ; None for other cages."""
        if self.indices is None:
            return None
        counts = np.full(len(self.indices) // 3, 3) if self.counts is None else self.counts
        if len(counts) and (counts == counts[0]).all():
            return self.indices.reshape(len(counts), int(counts[0]))
        return np.split(self.indices, np.cumsum(counts)[:-1])

    def _describe(self) -> Any:
        """Returns the struct for the library. Converts the arrays anew, because they may have changed."""
        its = arrays.struct(_c.cageform_cage, kind=self.kind)
        its.keeps = []  # pointers in structs do not keep arrays alive
        if self.vertices is not None:
            its.keeps.append(arrays.points(self.vertices, 'vertices'))
            its.vertices = arrays.view(its.keeps[-1])
        for name, length, given in (('counts', 'count_count', self.counts), ('indices', 'index_count', self.indices),
                                    ('loops', 'loop_count', self.loops)):
            if given is not None:
                its.keeps.append(arrays.indices(given, name))
                setattr(its, name, arrays.pointer(its.keeps[-1]))
                setattr(its, length, its.keeps[-1].size)
        for name, value in self.members.items():
            if name == 'bones':
                listed = [_c.cageform_bone(*arrays.indices(bone[:2], name).tolist(), bone[2]) for bone in value]
                its.keeps.append((_c.cageform_bone * max(len(listed), 1))(*listed))
                its.bones, its.bone_count = its.keeps[-1], len(listed)
            elif name == 'walls':
                its.keeps.append(value)
                its.walls, its.wall_index_count = arrays.pointer(value), value.size
            elif name == 'knots':
                its.keeps.append(value)
                for k, knots in enumerate(value):
                    its.knots[k], its.knot_counts[k] = arrays.pointer(knots, ctypes.c_double), knots.size
            elif name == 'axes':
                for axis, edge in zip(its.axes, value):
                    axis[:len(value)] = edge.tolist()
            elif isinstance(value, np.ndarray):
                getattr(its, name)[:len(value)] = value.tolist()
            else:
                arrays.set_member(its, name, value)
        return its


def _optional(given: Optional[npt.ArrayLike], name: str) -> Optional[Array]:
    return None if given is None else arrays.indices(given, name)


def check(cage: Cage) -> List[Fault]:
    """Returns the faults and warnings of a cage; an empty list if it has none."""
    its, count, room = cage._describe(), ctypes.c_size_t(0), 100
    while True:
        faults = (_c.cageform_fault * room)()
        code = library.cageform_check(its, faults, room, ctypes.byref(count))
        if count.value <= room:
            break
        room = count.value
    if code != _c.CAGEFORM_OK and count.value == 0:
        check_status(code)
    return [Fault._of(fault) for fault in faults[:count.value]]


_MIRRORS = {None: 0, 'x': 1, 'y': 2, 'z': 3}


def make_cage(points: npt.ArrayLike, indices: npt.ArrayLike, vertices: int = 0, margin: float = 0,
              shape: str = 'figure', mirror: Optional[str] = None, radii: Optional[npt.ArrayLike] = None,
              areas: Optional[npt.ArrayLike] = None, holes: bool = False, fill_tunnels: bool = False,
              many_cages: bool = False, regular: float = 0, threads: Optional[int] = None,
              progress: Progress = None) -> Tuple[Cage, Report]:
    """Makes a cage around a figure.

    points        3D: vertices (#points, 3); 2D: ends of segments (#points, 2)
    indices       3D: triangles (#triangles, 3); 2D: segments (#segments, 2)
    vertices      requested number of vertices of the cage; 0: 24 in 2D, 112 in 3D
    margin        relative to the figure's diagonal; 0: 0.025 in 2D, 0.02 in 3D
    shape         'figure', 'hull' or 'box'
    mirror        'x', 'y', 'z': the cage is symmetric along this axis, about the centre of the figure
    radii         2D: (#segments,), half the width of each segment
    areas         2D: number of segments of each outline of a filled area; these segments come first
    holes         2D: preserves large empty regions of areas
    fill_tunnels  3D: fills tunnels of the figure
    many_cages    one cage per part, instead of joined parts
    regular       trade-off: higher values give more regular, looser cages; 0: 1
    progress      progress(done) receives the completed fraction, 0 to 1; it returns False to cancel

    Returns the cage and a Report.
    """
    given, corners = arrays.points(points, 'points'), arrays.indices(indices, 'indices')
    own_areas = _optional(areas, 'areas')
    figure = arrays.struct(_c.cageform_drawing, points=arrays.view(given), indices=arrays.pointer(corners),
                           index_count=corners.size, areas=arrays.pointer(own_areas),
                           area_count=0 if own_areas is None else own_areas.size)
    own_radii = None if radii is None else arrays.doubles(radii, 'radii', corners.size // 2, 'segment')
    figure.radii = arrays.pointer(own_radii, ctypes.c_double)
    options = arrays.struct(_c.cageform_make_cage_options, vertices=vertices, margin=margin,
                            shape=arrays.choice(_c.CHOICES['shape'], shape, 'shape'), mirror=arrays.choice(_MIRRORS, mirror, 'mirror'),
                            many_cages=many_cages, holes=holes, fill_tunnels=fill_tunnels, regular=regular)
    handle, report = make(library.cageform_make_cage, figure, options, running=Running(threads, progress))
    its = arrays.struct(_c.cageform_cage)
    check_status(library.cageform_made_cage_describe(handle, its))

    def copy(pointer: Any, size: int) -> Optional[Array]:
        return np.ctypeslib.as_array(pointer, (size,)).copy() if size else None
    made: Array = np.ctypeslib.as_array(ctypes.cast(its.vertices.data, ctypes.POINTER(ctypes.c_double)),
                                        (its.vertices.count, its.vertices.dimension)).copy()
    return Cage(its.kind, made, copy(its.counts, its.count_count), copy(its.indices, its.index_count)), report
