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


def _options(kind: str, dtype: npt.DTypeLike, accuracy: float, memory_limit: int, locality: float) -> Any:
    return arrays.struct(_c.cageform_coordinates_options, type=arrays.choice(_c.CHOICES['coordinate_type'], kind, 'kind'),
                         scalar=arrays.scalar_of(dtype), accuracy=accuracy, memory_limit=memory_limit,
                         locality=locality)


class Coordinates(Owner):
    """Coordinates of a cage. They bind figures to the cage.

    cage          a Cage; its arrays are copied
    kind          one of Coordinates.kinds; None: 'mean-value' for polygons and meshes, else the type for this kind of cage
    dtype         of weights, poses and clones: float32 or float64
    accuracy      harmonic: maximum error of a weight, 1e-5 to 0.1; 0: 1e-3
    memory_limit  harmonic: maximum memory of the solver in bytes; 0: 8 GiB
    disk          curved-green: (x, y, radius) of a disk
    locality      harmonic: 0, or up to 40 for local harmonic coordinates, which have fewer influences

    Attributes: report, cage (blended: a list), dtype, handles (their number, including the vectors of 'green'),
    vertices (number of handles that are points), dimension, has_weights_outside, has_gradients
    """

    kinds: Tuple[str, ...] = tuple(_c.CHOICES['coordinate_type'])

    def __init__(self, cage: Cage, kind: Optional[str] = None, dtype: npt.DTypeLike = np.float64, accuracy: float = 0,
                 memory_limit: int = 0, disk: Optional[Tuple[float, float, float]] = None, locality: float = 0) -> None:
        if kind is None:
            kind = _DEFAULTS.get(cage.kind, 'mean-value')
        options = _options(kind, dtype, accuracy, memory_limit, locality)
        if disk is not None:
            options.disk[:] = arrays.doubles(disk, 'disk', 3, 'of x, y, radius').tolist()
        self._adopt(cage, dtype, *make(library.cageform_coordinates_create, cage._describe(), options))

    @classmethod
    def blend(cls, cages: Sequence[Cage], kind: str = 'mean-value', dtype: npt.DTypeLike = np.float64,
              accuracy: float = 0, memory_limit: int = 0, locality: float = 0) -> Coordinates:
        """Makes coordinates of several cages over one figure, such as a body and a head: polygons, or meshes of
        triangles. Where cages overlap, weights are blended by depth. The handles of the first cage come first, then
        those of the next. The kind is 'mean-value' or 'harmonic'; the other arguments are as above. The culprit is the
        invalid cage."""
        described = [cage._describe() for cage in cages]
        listed = (ctypes.POINTER(_c.cageform_cage) * max(len(described), 1))(*[ctypes.pointer(its) for its in described])
        its = cls.__new__(cls)
        its._adopt(list(cages), dtype, *make(library.cageform_coordinates_blend, ctypes.cast(listed, ctypes.c_void_p),
                                             len(described),
                                             _options(kind, dtype, accuracy, memory_limit, locality)))
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
        """Computes and stores the harmonic functions, so that several binds solve only once. Do not call it while another
        thread binds with these coordinates. Other types need no solve."""
        return invoke(library.cageform_coordinates_solve, self._object, running=Running(threads, progress))

    def bind(self, points: npt.ArrayLike, normals: Optional[npt.ArrayLike] = None,
             tangents: Optional[npt.ArrayLike] = None, outside: str = 'extend', falloff: float = 0,
             leave_linear_precision: bool = False, threads: Optional[int] = None,
             progress: Progress = None) -> Binding:
        """Binds a figure. Points without weights do not move; the binding lists them.

        points    (#points, dimension)
        normals   (#points, dimension)
        tangents  3D: (#points, 3), or (#points, 4) with the handedness
        outside   treatment of points outside: 'extend', 'keep-in-place', 'nearest-boundary'
        falloff   distance outside at which displacements reach 0; 0: no falloff
        leave_linear_precision  does not correct the weights
        threads   None: all processors
        progress  progress(done) receives the completed fraction, 0 to 1; it returns False to cancel
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

    figure   the Figure, for clone()
    report   the Report of the bind
    points, handles: numbers of points and handles; dtype
    """

    figure: Figure
    report: Report
    points: int
    handles: int
    dtype: np.dtype[Any]

    def __init__(self) -> None:
        raise TypeError('Coordinates.bind makes Bindings')

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
        """Points with NaN or infinite numbers; no pose moves them."""
        return self._list(_c.CAGEFORM_LIST_NOT_FINITE)

    @property
    def unreached(self) -> Array:
        """Points without weights, or whose weights overflow; they do not move."""
        return self._list(_c.CAGEFORM_LIST_UNREACHED)

    @property
    def not_restored(self) -> Array:
        """Points that affine poses do not move exactly, because their weights could not be corrected."""
        return self._list(_c.CAGEFORM_LIST_NOT_RESTORED)

    @property
    def faded(self) -> Array:
        """Points outside, within the falloff."""
        return self._list(_c.CAGEFORM_LIST_FADED)

    def weights(self, first: int = 0, count: Optional[int] = None) -> Array:
        """Returns the weights of `count` points from point `first`: (count, #handles); None: of all points from `first`."""
        count = max(self.points - first, 0) if count is None else count
        if first < 0 or count < 0:
            raise ValueError('first, count: must not be negative, not %d, %d' % (first, count))
        out = np.empty((count, self.handles), self.dtype)
        check(library.cageform_binding_weights(self._object, first, count, out.ctypes.data, out.nbytes))
        return out

    def set_labels(self, labels: Sequence[Optional[str]]) -> None:
        """Sets one label per handle, a str or None. Labels are packed with the figure. Replaces `figure` by a new one."""
        texts = (ctypes.c_char_p * max(len(labels), 1))(*[None if its is None else its.encode() for its in labels])
        check(library.cageform_binding_set_labels(self._object, ctypes.cast(texts, ctypes.c_void_p), len(labels)))
        self.figure = self._make_figure()

    def pack(self, tolerance: float = 0, threshold: float = 0, largest: int = 0, reach: float = 0,
             poses: Optional[npt.ArrayLike] = None, format: str = 'smallest', clips: Optional[Mapping[str, Clip]] = None,
             levels: Sequence[Source] = (), origin: Sequence[float] = (), threads: Optional[int] = None,
             progress: Progress = None) -> Tuple[Array, Report]:
        """Packs the figure to bytes for open() and for games.

        tolerance  maximum change of a point by packing; 0: no limit
        threshold  smaller weights may be dropped; if tolerance, threshold and largest are 0, none is
        largest    maximum number of weights per point; 0: all
        poses      (#poses, #handles, dimension): the tolerance holds in these poses; None: within `reach` of affine poses
        reach      maximum distance of a handle from an affine pose, in cage units; 0: a tenth of the cage's size
        format     of weights: 'smallest', 'scalar', 'half', 'int16', 'int8'
        clips      dict from names to Clips
        levels     packed figures of less detail with the same handles: files or bytes
        origin     origin of the coordinates of points, handles and clips, stored for Figure.origin; (): 0

        Returns the bytes and a Report. The bytes are a read-only uint8 array (#bytes,) aligned to 64; its tofile() writes a file.
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
                raise ValueError('clips: %r belongs to a figure; only clips of compile_clip can be packed' % name)
            named[name.encode()] = clip.bytes
        reduced = [arrays.aligned(level) for level in levels]
        parts = [_c.cageform_part(name, data.ctypes.data, data.nbytes) for name, data in named.items()]
        options.clips, options.clip_count = (_c.cageform_part * max(len(parts), 1))(*parts), len(parts)
        parts = [_c.cageform_part(None, data.ctypes.data, data.nbytes) for data in reduced]
        options.levels, options.level_count = (_c.cageform_part * max(len(parts), 1))(*parts), len(parts)
        handle, report = make(library.cageform_pack, self._object, options, running=Running(threads, progress))
        return bytes_of(handle), report
