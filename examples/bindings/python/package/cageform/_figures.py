"""Functions of every frame: clones of figures, playback of clips."""

from __future__ import annotations

import ctypes
import threading
from typing import TYPE_CHECKING, Any, List, Optional, Tuple, Union

import numpy as np

from . import _arrays as arrays
from . import _c
from ._arrays import Array, Source
from ._library import library
from ._objects import Handle, Owner, Progress, Running, bytes_of, make, make_plain
from ._reports import Report
from .errors import check, error_of

if TYPE_CHECKING:
    import numpy.typing as npt


class Figure(Owner):
    """Points that a pose of the handles moves, from Binding.figure or open(). Several threads may clone it at once.

    points, handles, vertices (handles that are points), clips, levels: numbers of each
    dimension, dtype, has_normals, has_tangents
    origin: (dimension,) in float64, the origin of the coordinates of points, handles and clips. Add it to clones.
    """

    points: int
    handles: int
    vertices: int
    dimension: int
    clips: int
    levels: int
    dtype: np.dtype[Any]
    origin: Array
    has_normals: bool
    has_tangents: bool

    def __init__(self) -> None:
        raise TypeError('Binding.figure and open() make Figures')

    @classmethod
    def _of(cls, handle: Handle) -> Figure:
        its = cls.__new__(cls)
        its._object, info = handle, arrays.struct(_c.cageform_figure_info)
        check(library.cageform_figure_describe(handle, info))
        for name in ('points', 'handles', 'vertices', 'dimension', 'clips', 'levels'):
            setattr(its, name, getattr(info, name))
        its.dtype = arrays.dtype_of(info.scalar)
        its.origin = np.array(info.origin[:its.dimension])
        its.has_normals, its.has_tangents = bool(info.has_normals), bool(info.has_tangents)
        return its

    def rest(self) -> Array:
        """Returns the handles at rest, the initial pose: (#handles, dimension)."""
        out = np.empty((self.handles, self.dimension), self.dtype)
        check(library.cageform_figure_rest(self._object, arrays.written_view(out)))
        return out

    def labels(self) -> List[str]:
        """Returns the labels of the handles; '' for none."""
        listed = []
        for handle in range(self.handles):
            text, length = ctypes.c_void_p(), ctypes.c_size_t()
            check(library.cageform_figure_label(self._object, handle, ctypes.byref(text), ctypes.byref(length)))
            listed.append(ctypes.string_at(text, length.value).decode() if text.value and length.value else '')
        return listed

    def level(self, level: int) -> Figure:
        """Opens a level of less detail, for the same poses; level 0 is the figure itself."""
        opened = make_plain(library.cageform_open_level, self._object, _index(level, 'level'), None, keeps=(self._object,))
        return Figure._of(opened)

    def clone(self, pose: npt.ArrayLike, out: Optional[Array] = None, normals: bool = False, tangents: bool = False,
              threads: int = 1) -> Any:
        """Deforms the figure by a pose. The pose at rest gives the bound points, bitwise.

        pose     (#handles, dimension)
        out      (#points, dimension): an array to write and return, instead of a new one
        normals, tangents  True: also returns them; tangents=True includes normals. Tangents are (#points, 4), handedness last

        Returns points (#points, dimension), or a tuple of points and normals, or of points, normals and tangents.
        """
        given = arrays.points(pose, 'pose', self.dimension, self.dtype)
        if out is not None and np.may_share_memory(given, out):
            given = given.copy()
        moved = arrays.output(out, (self.points, self.dimension), self.dtype)
        turned = np.empty((self.points, self.dimension), self.dtype) if normals or tangents else None
        along = np.empty((self.points, 4), self.dtype) if tangents else None
        check(library.cageform_clone(self._object, arrays.view(given), arrays.written_view(moved),
                                     None if turned is None else arrays.written_view(turned),
                                     None if along is None else arrays.written_view(along), _running(threads)))
        moved = arrays.give_back(moved, out)
        return moved if turned is None else (moved, turned) if along is None else (moved, turned, along)

    def gradients(self, of_points: npt.ArrayLike, out: Optional[Array] = None, threads: int = 1) -> Array:
        """Computes gradients with respect to the handles (#handles, dimension) from gradients with respect to the cloned
        points (#points, dimension): the transpose of clone. Writes and returns `out`, if given."""
        given = arrays.points(of_points, 'of_points', self.dimension, self.dtype)
        if out is not None and np.may_share_memory(given, out):
            given = given.copy()
        handles = arrays.output(out, (self.handles, self.dimension), self.dtype)
        check(library.cageform_clone_transposed(self._object, arrays.view(given), arrays.written_view(handles),
                                                _running(threads)))
        return arrays.give_back(handles, out)

    def pose_handles(self, vertices: npt.ArrayLike) -> Array:
        """Computes a pose of all handles (#handles, dimension) from a pose of the cage's vertices (#vertices, dimension).
        Green coordinates need it; for other types both are the same."""
        given = arrays.points(vertices, 'vertices', self.dimension, self.dtype)
        out = np.empty((self.handles, self.dimension), self.dtype)
        check(library.cageform_pose_handles(self._object, arrays.view(given), arrays.written_view(out)))
        return out

    def clip(self, clip: Union[int, str]) -> Clip:
        """Returns a clip, by index or name. Raises KeyError if no clip has the name."""
        if isinstance(clip, str):
            found, name = ctypes.c_size_t(), clip.encode()
            check(library.cageform_figure_find_clip(self._object, name, len(name), ctypes.byref(found)))
            number = arrays.index_of(found.value)
            if number is None:
                raise KeyError(clip)
            clip = number
        handle = make_plain(library.cageform_play, self._object, _index(clip, 'clip'), None, keeps=(self._object,))
        return Clip._of(handle, None)


def _index(number: int, name: str) -> int:
    if number < 0:
        raise ValueError('%s: must not be negative, not %d' % (name, number))
    return number


def _running(threads: int) -> Any:
    return None if threads == 1 else Running(threads, None).struct


def open(source: Source, skip_checksum: bool = False) -> Figure:
    """Opens a packed figure.

    source         the path of a file, or bytes. A file is memory-mapped and must not change while the figure is used. Bytes
                   are copied if they are writable or not aligned to 64
    skip_checksum  does not verify the checksum; reads only tables
    """
    data = arrays.aligned(source)
    options = arrays.struct(_c.cageform_open_options, skip_checksum=skip_checksum)
    made, culprit = ctypes.c_void_p(), ctypes.c_size_t()
    code = library.cageform_open(data.ctypes.data, len(data), options, ctypes.byref(made), ctypes.byref(culprit))
    if code != _c.CAGEFORM_OK:
        part = culprit.value.to_bytes(4, 'little').decode('ascii', 'replace') if 0 < culprit.value < 2 ** 32 else None
        refused = error_of(code, culprit=part)
        raise error_of(code, '%s (part %s)' % (refused, part), part) if part else refused
    return Figure._of(Handle(made.value or 0, data))


class Clip(Owner):
    """The motion of a cage, from compile_clip or Figure.clip. Only one thread at a time may sample it.

    begin, end  times
    vertices    number of vertices of the cage
    name        the name of a figure's clip
    bytes       the packed clip, if compile_clip made it
    """

    begin: float
    end: float
    vertices: int
    name: Optional[str]
    bytes: Optional[Array]

    def __init__(self) -> None:
        raise TypeError('compile_clip and Figure.clip make Clips')

    @classmethod
    def _of(cls, handle: Handle, data: Optional[Array]) -> Clip:
        its = cls.__new__(cls)
        its._object, its.bytes, info = handle, data, arrays.struct(_c.cageform_clip_info)
        check(library.cageform_player_describe(handle, info))
        its.begin, its.end, its.vertices = info.begin, info.end, info.vertices
        its.name = ctypes.string_at(info.name, info.name_length).decode() if info.name else None
        its._shape, its._dtype = (info.vertices, info.dimension), arrays.dtype_of(info.scalar)
        its._lock = threading.Lock()
        return its

    _shape: Tuple[int, int]
    _dtype: np.dtype[Any]
    _lock: threading.Lock

    def sample(self, time: float, out: Optional[Array] = None) -> Array:
        """Returns the cage's vertices at a time: (#vertices, dimension). Writes and returns `out`, if given."""
        pose = arrays.output(out, self._shape, self._dtype)
        with self._lock:
            check(library.cageform_player_sample(self._object, time, arrays.written_view(pose)))
        return arrays.give_back(pose, out)


_ENDS = {'stay': _c.CAGEFORM_STAY, 'straight_on': _c.CAGEFORM_GO_STRAIGHT_ON, 'cycle': _c.CAGEFORM_CYCLE,
         'cycle_with_offset': _c.CAGEFORM_CYCLE_WITH_OFFSET, 'ping_pong': _c.CAGEFORM_PING_PONG}


def compile_clip(times: npt.ArrayLike, poses: npt.ArrayLike, tolerance: float = 0, pack_tolerance: float = 0,
                 keys: str = 'smooth', before: str = 'stay', after: str = 'stay', dtype: npt.DTypeLike = np.float32,
                 threads: Optional[int] = None, progress: Progress = None) -> Tuple[Clip, Report]:
    """Compiles poses of a cage to a clip.

    times           (#times,), ascending
    poses           (#times, #vertices, dimension) of the cage's vertices
    tolerance       maximum error of a coordinate; 0: at most a thousandth of the poses' size
    pack_tolerance  maximum distance caused by 16-bit curves; 0: curves stay exact
    keys            interpolation between poses: 'smooth', 'linear', 'hold'
    before, after   extrapolation before the first time and after the last: 'stay', 'straight_on', 'cycle',
                    'cycle_with_offset', 'ping_pong'
    dtype           of the clip; must be that of the figure
    progress        progress(done) receives the completed fraction, 0 to 1; it returns False to cancel

    Returns a Clip and a Report.
    """
    given = arrays.doubles(times, 'times', None, 'pose')
    posed = arrays.numbers(poses, 'poses')
    if posed.ndim == 3 and len(posed) != len(given):
        raise ValueError('poses: must be an array of shape (%d, #vertices, dimension), not %s' % (len(given), posed.shape))
    listed = arrays.poses(posed, 'poses', '#times, #vertices')
    options = arrays.struct(_c.cageform_clip_options, tolerance=tolerance, pack_tolerance=pack_tolerance,
                            keys=arrays.choice(_c.CHOICES['keys'], keys, 'keys'), before=arrays.choice(_ENDS, before, 'before'),
                            after=arrays.choice(_ENDS, after, 'after'), scalar=arrays.scalar_of(dtype))
    handle, report = make(library.cageform_compile_clip, arrays.pointer(given, ctypes.c_double), len(given),
                          arrays.view(listed), options, running=Running(threads, progress))
    data = bytes_of(handle)
    player = make_plain(library.cageform_play_bytes, data.ctypes.data, len(data), None, keeps=(data,))
    return Clip._of(player, data), report
