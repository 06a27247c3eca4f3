"""Coordinates of cages, and figures bound by them."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import _arrays as arrays
from . import _c
from ._arrays import Array, Source
from ._cages import Cage
from ._figures import Clip, Figure
from ._library import library
from ._objects import Handle, Owner, Progress, Running, bytes_of, invoke, make, make_plain
from ._reports import Report
from .errors import check

if TYPE_CHECKING:
    import numpy.typing as npt

_DEFAULTS = {_c.CAGEFORM_LATTICE: 'splines', _c.CAGEFORM_SITES: 'sibson', _c.CAGEFORM_CURVES: 'curved-green'}


def _options(kind: str, dtype: npt.DTypeLike, accuracy: float, memory_limit: int) -> Any:
    return arrays.struct(_c.cageform_coordinates_options, type=arrays.choice(_c.CHOICES['coordinate_type'], kind, 'kind'),
                         scalar=arrays.scalar_of(dtype), accuracy=accuracy, memory_limit=memory_limit)


class Coordinates(Owner):
    """Coordinates of a cage, by which figures are bound.

    cage          a Cage, which is copied from
    kind          one of Coordinates.kinds; None: the one of this kind of cage, of polygons and meshes 'mean-value'
    dtype         of weights, poses and clones: float32 or float64
    accuracy      harmonic: the largest error of a weight, 1e-5 to 0.1; 0: 1e-3
    memory_limit  harmonic: in bytes; 0: 8 GiB
    disk          curved-green: (x, y, radius) of a disk

    report, cage (a list if they are blended), dtype, handles (their number; vectors are among them in 'green'), vertices (handles that are
    points), dimension, has_weights_outside, has_gradients
    """

    kinds: Tuple[str, ...] = tuple(_c.CHOICES['coordinate_type'])

    def __init__(self, cage: Cage, kind: Optional[str] = None, dtype: npt.DTypeLike = np.float64, accuracy: float = 0,
                 memory_limit: int = 0, disk: Optional[Tuple[float, float, float]] = None) -> None:
        if kind is None:
            kind = _DEFAULTS.get(cage.kind, 'mean-value')
        options = _options(kind, dtype, accuracy, memory_limit)
        if disk is not None:
            options.disk[:] = arrays.doubles(disk, 'disk', 3, 'of x, y, radius').tolist()
        self._adopt(cage, dtype, *make(library.cageform_coordinates_create, cage._describe(), options))

    @classmethod
    def blend(cls, cages: Sequence[Cage], kind: str = 'mean-value', dtype: npt.DTypeLike = np.float64,
              accuracy: float = 0, memory_limit: int = 0) -> Coordinates:
        """Makes coordinates of several cages over one figure, such as a body and a head: polygons, or meshes of
        triangles. Where cages overlap, they are blended by depth. Handles are those of the first cage, then of the next.
        The kind is 'mean-value' or 'harmonic'; the rest is as above. The culprit is the cage that is refused."""
        described = [cage._describe() for cage in cages]
        listed = (ctypes.POINTER(_c.cageform_cage) * max(len(described), 1))(*[ctypes.pointer(its) for its in described])
        its = cls.__new__(cls)
        its._adopt(list(cages), dtype, *make(library.cageform_coordinates_blend, ctypes.cast(listed, ctypes.c_void_p),
                                             len(described), _options(kind, dtype, accuracy, memory_limit)))
        return its

    def _adopt(self, cage: Union[Cage, List[Cage]], dtype: npt.DTypeLike, handle: Handle, report: Report) -> None:
        self.cage, self.dtype, self._object, self.report = cage, np.dtype(dtype), handle, report
        info = arrays.struct(_c.cageform_coordinates_info)
        check(library.cageform_coordinates_describe(self._object, info))
        self.handles, self.vertices, self.dimension = info.handles, info.vertices, info.dimension
        self.has_weights_outside, self.has_gradients = bool(info.has_weights_outside), bool(info.has_gradients)

    def rest(self) -> Array:
        """Returns the handles at rest: (#handles, dimension)."""
        out = np.empty((self.handles, self.dimension), self.dtype)
        check(library.cageform_coordinates_rest(self._object, arrays.written_view(out)))
        return out

    def solve(self, threads: Optional[int] = None, progress: Progress = None) -> Report:
        """Solves for harmonic functions and keeps them, so that several binds solve only once; not while another
        thread binds by these coordinates. Others are ready."""
        return invoke(library.cageform_coordinates_solve, self._object, running=Running(threads, progress))

    def bind(self, points: npt.ArrayLike, normals: Optional[npt.ArrayLike] = None,
             tangents: Optional[npt.ArrayLike] = None, outside: str = 'extend', falloff: float = 0,
             leave_linear_precision: bool = False, threads: Optional[int] = None,
             progress: Progress = None) -> Binding:
        """Binds a figure. Bad points are listed by the binding and kept in place, the others are bound.

        points    (#points, dimension)
        normals   (#points, dimension)
        tangents  (#points, 3), or 4 with the handedness; in space
        outside   what becomes of points outside: 'extend', 'keep-in-place', 'nearest-boundary'
        falloff   outside, displacements fade to nothing at this distance; 0: they do not
        leave_linear_precision  leaves weights as the coordinates gave them
        threads   None: all processors
        progress  progress(done) is told the fraction done; it returns False to cancel
        """
        bound = arrays.points(points, 'points', self.dimension)
        turned = None if normals is None else arrays.points(normals, 'normals', self.dimension)
        along = None if tangents is None else arrays.points(tangents, 'tangents', dimensions=(3, 4))
        options = arrays.struct(_c.cageform_bind_options, outside=arrays.choice(_c.CHOICES['outside_points'], outside, 'outside'),
                                leave_linear_precision=leave_linear_precision, falloff=falloff)
        handle, report = make(library.cageform_bind, self._object, arrays.view(bound),
                              None if turned is None else arrays.view(turned),
                              None if along is None else arrays.view(along), options,
                              running=Running(threads, progress))
        return Binding._of(handle, self, len(bound), report)


class Binding(Owner):
    """A figure with all its weights, made by Coordinates.bind.

    figure   the Figure, to be cloned
    report   how the bind went
    points, handles (their numbers), dtype
    """

    figure: Figure
    report: Report
    points: int
    handles: int
    dtype: np.dtype[Any]

    def __init__(self) -> None:
        raise TypeError('a Binding is made by Coordinates.bind')

    @classmethod
    def _of(cls, handle: Handle, coordinates: Coordinates, count: int, report: Report) -> Binding:
        its = cls.__new__(cls)
        its._object, its.report, its.points = handle, report, count
        its.handles, its.dtype = coordinates.handles, coordinates.dtype
        its.figure = its._make_figure()
        return its

    def _make_figure(self) -> Figure:
        return Figure._of(make_plain(library.cageform_binding_figure, self._object, keeps=(self._object,)))

    def _list(self, number: int) -> Array:
        count = ctypes.c_size_t(0)
        check(library.cageform_binding_list(self._object, number, None, 0, ctypes.byref(count)))
        out = np.empty(count.value, np.uintp)
        check(library.cageform_binding_list(self._object, number, arrays.pointer(out, ctypes.c_size_t), out.size,
                                            ctypes.byref(count)))
        return out.astype(np.intp)

    @property
    def on_boundary(self) -> Array:
        """Points on the cage, as an array of indices in ascending order."""
        return self._list(_c.CAGEFORM_LIST_ON_BOUNDARY)

    @property
    def outside(self) -> Array:
        """Points outside."""
        return self._list(_c.CAGEFORM_LIST_OUTSIDE)

    @property
    def not_finite(self) -> Array:
        """Points that are not finite numbers; they are kept as they are."""
        return self._list(_c.CAGEFORM_LIST_NOT_FINITE)

    @property
    def unreached(self) -> Array:
        """Points whose weights do not exist or overflow; they are kept in place."""
        return self._list(_c.CAGEFORM_LIST_UNREACHED)

    @property
    def not_restored(self) -> Array:
        """Points that affine poses do not move as they should, because no weights could be found that do."""
        return self._list(_c.CAGEFORM_LIST_NOT_RESTORED)

    @property
    def faded(self) -> Array:
        """Points outside whose displacements fade."""
        return self._list(_c.CAGEFORM_LIST_FADED)

    def weights(self, first: int = 0, count: Optional[int] = None) -> Array:
        """Returns the weights of points: (count, #handles); None: of all from the first on."""
        count = max(self.points - first, 0) if count is None else count
        if first < 0 or count < 0:
            raise ValueError('first, count: numbers from 0 on, not %d, %d' % (first, count))
        out = np.empty((count, self.handles), self.dtype)
        check(library.cageform_binding_weights(self._object, first, count, out.ctypes.data, out.nbytes))
        return out

    def set_labels(self, labels: Sequence[Optional[str]]) -> None:
        """Labels the handles: a str or None for each. They are packed with the figure. `figure` is made anew."""
        texts = (ctypes.c_char_p * max(len(labels), 1))(*[None if its is None else its.encode() for its in labels])
        check(library.cageform_binding_set_labels(self._object, ctypes.cast(texts, ctypes.c_void_p), len(labels)))
        self.figure = self._make_figure()

    def pack(self, tolerance: float = 0, threshold: float = 0, largest: int = 0, reach: float = 0,
             poses: Optional[npt.ArrayLike] = None, format: str = 'smallest', clips: Optional[Mapping[str, Clip]] = None,
             levels: Sequence[Source] = (), origin: Sequence[float] = (), threads: Optional[int] = None,
             progress: Progress = None) -> Tuple[Array, Report]:
        """Packs the figure for open, and for games.

        tolerance  the largest distance of a point from where all weights put it; 0: no limit
        threshold  weights below may be dropped; with all three 0, nothing is
        largest    how many weights a point keeps; 0: all
        poses      (#poses, #handles, dimension): where the tolerance holds; None: within `reach` of affine poses
        reach      in parts of the cage's size; 0: a tenth
        format     of weights: 'smallest', 'scalar', 'half', 'int16', 'int8'
        clips      Clips by their names
        levels     packed figures of less detail, of the same handles: their files or bytes
        origin     the place from which points, handles and clips count, for Figure.origin; () is 0

        Returns the bytes (#bytes,) as uint8, read-only, at a multiple of 64, and a Report. Their tofile() writes a file.
        """
        options = arrays.struct(_c.cageform_pack_options, tolerance=tolerance, threshold=threshold, largest=largest,
                                reach=reach, format=arrays.choice(_c.CHOICES['weight_format'], format, 'format'))
        options.origin[:len(origin)] = list(origin)
        listed = None if poses is None else arrays.poses(poses, 'poses', '#poses, #handles')
        if listed is not None:
            options.poses = arrays.view(listed)
        named: Dict[bytes, Array] = {}
        for name, clip in (clips or {}).items():
            if clip.bytes is None:
                raise ValueError('clips: %r is of a figure; those of compile_clip can be packed' % name)
            named[name.encode()] = clip.bytes
        reduced = [arrays.aligned(level) for level in levels]
        parts = [_c.cageform_part(name, data.ctypes.data, data.nbytes) for name, data in named.items()]
        options.clips, options.clip_count = (_c.cageform_part * max(len(parts), 1))(*parts), len(parts)
        parts = [_c.cageform_part(None, data.ctypes.data, data.nbytes) for data in reduced]
        options.levels, options.level_count = (_c.cageform_part * max(len(parts), 1))(*parts), len(parts)
        handle, report = make(library.cageform_pack, self._object, options, running=Running(threads, progress))
        return bytes_of(handle), report
