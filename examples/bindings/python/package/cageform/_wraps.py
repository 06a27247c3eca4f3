"""Maps of space that lay one figure on another."""

from __future__ import annotations

import ctypes
import warnings
from typing import TYPE_CHECKING, Any, Optional, Tuple, Union

import numpy as np

from . import _arrays as arrays
from . import _c
from ._arrays import Array
from ._bindings import Coordinates
from ._cages import Cage
from ._library import library
from ._objects import Handle, Owner, Progress, Running, make
from ._reports import Report
from .errors import check

if TYPE_CHECKING:
    import numpy.typing as npt


class Wrap(Owner):
    """A map of space, from wrap: x -> first(x), then the pose of the cage, then the pose of the lattice. Arrays are copies.

    report        the Report
    first         (3, 4): a matrix; the identity if there are coordinates
    pose          (#handles, 3) of the coordinates, for Figure.clone; without coordinates (0, 3)
    lattice       the Cage of the lattice, in the space of the target, for Coordinates; None: there is no lattice
    lattice_pose  (#points, 3) of the lattice, for Figure.clone
    """

    report: Report
    first: Array
    pose: Array
    lattice: Optional[Cage]
    lattice_pose: Array

    def __init__(self) -> None:
        raise TypeError('wrap makes Wraps')

    @classmethod
    def _of(cls, handle: Handle, report: Report) -> Wrap:
        its, info = cls.__new__(cls), arrays.struct(_c.cageform_wrap_info)
        its._object, its.report = handle, report
        check(library.cageform_wrap_describe(handle, info))
        its.first = np.array(info.first).reshape(4, 3).T.copy()
        its.pose, its.lattice_pose = _copy(info.pose), _copy(info.lattice_pose)
        its.lattice = Cage._of_lattice(info.lattice.contents) if info.lattice else None
        return its

    def move(self, points: npt.ArrayLike, jacobians: bool = False, threads: Optional[int] = None,
             progress: Progress = None) -> Union[Array, Tuple[Array, Array]]:
        """Moves points (#points, 3) from the space of the source to that of the target. With `jacobians`, also returns
        the derivatives of the map at the points: matrices (#points, 3, 3)."""
        given = arrays.points(points, 'points', 3)
        moved = np.empty(given.shape, given.dtype)
        turns = np.empty((len(given), 9), given.dtype) if jacobians else None
        running = Running(threads, progress)
        with running:
            code = library.cageform_wrap_move(self._object, arrays.view(given), arrays.written_view(moved),
                                              None if turns is None else arrays.written_view(turns), running.struct)
        check(code)
        return moved if turns is None else (moved, turns.reshape(-1, 3, 3).swapaxes(1, 2))


def _copy(its: Any) -> Array:
    number = ctypes.c_float if its.scalar == _c.CAGEFORM_FLOAT else ctypes.c_double
    if not its.count:
        return np.empty((0, 3), arrays.dtype_of(its.scalar))
    numbers: Array = np.ctypeslib.as_array(ctypes.cast(its.data, ctypes.POINTER(number)), (its.count, 3))
    return numbers.copy()


def _mesh(points: npt.ArrayLike, faces: npt.ArrayLike, name: str) -> Any:
    """Returns the struct of a mesh, which keeps its arrays alive."""
    places, corners = arrays.points(points, name, 3), arrays.indices(faces, name + '_faces')
    if corners.size and np.shape(faces)[1:] != (3,):
        raise ValueError('%s_faces: must be an array of shape (#faces, 3), not %s' % (name, np.shape(faces)))
    its = arrays.struct(_c.cageform_drawing, points=arrays.view(places), indices=arrays.pointer(corners),
                        index_count=corners.size)
    its.keeps = places, corners
    return its


def _landmarks(pairs: Optional[npt.ArrayLike], weights: Optional[npt.ArrayLike]) -> Array:
    """Returns landmarks as the library's structs: rows of 7 numbers."""
    given = arrays.numbers(np.empty((0, 2, 3)) if pairs is None else pairs, 'landmarks')
    if given.ndim != 3 or given.shape[1:] != (2, 3):
        raise ValueError('landmarks: must be an array of shape (#landmarks, 2, 3), not %s' % (given.shape,))
    marks = np.ones((len(given), 7))
    marks[:, :6] = given.reshape(-1, 6)
    if weights is not None:
        marks[:, 6] = arrays.doubles(weights, 'weights', len(marks), 'landmark')
    if (marks[:, 6] == 0).any():
        raise ValueError('weights: must be positive')
    return marks


def wrap(source: npt.ArrayLike, source_faces: npt.ArrayLike, target: npt.ArrayLike, target_faces: npt.ArrayLike,
         landmarks: Optional[npt.ArrayLike] = None, follow: Optional[npt.ArrayLike] = None,
         coordinates: Optional[Coordinates] = None, weights: Optional[npt.ArrayLike] = None, align: bool = True,
         other_pose: bool = False, finest: int = 24, refine_contacts: bool = False, least_stiffness: float = 0,
         floor: float = 0, residual: float = 0, samples: int = 0, handles: int = 0, threads: Optional[int] = None,
         progress: Progress = None) -> Wrap:
    """Finds a map of space that lays a source on a target. Clothes, hair and joints of the source follow by Wrap.move:

        wrapped = cageform.wrap(body, body_faces, scan, scan_faces, follow=clothes)
        clothes_on_scan = wrapped.move(clothes)

    source, target    vertices (#vertices, 3) and triangles (#faces, 3) of any topology; open, noisy or in parts. Both
                      have the same up and front, unless three or more landmarks align them
    landmarks         (#landmarks, 2, 3): points of the source, and their places on the target
    follow            (#points, 3): points that will follow, such as the vertices of clothes. Those outside the source
                      are kept outside the target
    coordinates       Coordinates with gradients: a pose of their cage, then a lattice behind it; None: a lattice alone
    weights           (#landmarks,): relative weights; None: 1
    align             scales and moves the source to the target first
    other_pose        source and target have different poses; needs landmarks
    finest            spans of the finest lattice along the target's height: 6, 12, 24, … up to 96. With coordinates
                      lattices begin at 12, and 6 is the cage alone
    refine_contacts   a finer lattice where parts touch, such as thighs; takes twice the time; without coordinates only
    least_stiffness   the search ends at this weight of the rigidity; 0: 1e-7; for noise: 1e-5
    floor             lower bound of the map's least singular value; 0: 0.1
    residual          ends the search below this report.to_target_upper; 0: never
    samples           about the largest number of samples of space; 0: 16000
    handles           the largest number of handles; 0: 8000. Lattices with more are left out: report.left_out
    threads           None: all processors; the result does not depend on them
    progress          progress(done) receives the completed fraction, 0 to 1; it returns False to cancel

    Returns a Wrap. If less than half of a figure has a match on the other, warns, and report.status is 'fit_not_reached'.
    """
    if finest < 6:
        raise ValueError('finest: must be 6, 12, 24, …, not %d' % finest)
    given, wanted = _mesh(source, source_faces, 'source'), _mesh(target, target_faces, 'target')
    options = arrays.struct(_c.cageform_wrap_options, keep_place=not align, other_pose=other_pose, finest=finest,
                            refine_contacts=refine_contacts, least_stiffness=least_stiffness, floor=floor, residual=residual,
                            samples=samples, handles=handles)
    marks = _landmarks(landmarks, weights)
    options.landmarks, options.landmark_count = arrays.pointer(marks, _c.cageform_landmark), len(marks)
    followers = None if follow is None else arrays.points(follow, 'follow', 3)
    if followers is not None:
        options.follow = arrays.view(followers)
    handle, report = make(library.cageform_fit_wrap, None if coordinates is None else coordinates._object, given, wanted,
                          options, running=Running(threads, progress), accepts=_c.CAGEFORM_FIT_NOT_REACHED)
    if report.message:
        warnings.warn(report.message, stacklevel=2)
    return Wrap._of(handle, report)
