"""Skeletons that are fitted to sequences of meshes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Tuple

import numpy as np

from . import _arrays as arrays
from . import _c
from ._arrays import Array
from ._library import library
from ._objects import Handle, Owner, Progress, Running, make
from ._reports import Report
from .errors import check

if TYPE_CHECKING:
    import numpy.typing as npt


class Transforms(NamedTuple):
    """The transforms of the bones' nodes, as engines play them: x -> rotation(scale * axes(x)) + translation goes from a
    node's own axes, whose origin is its joint, to those of its parent."""

    translations: Array  #: (#frames, #bones, 3)
    rotations: Array     #: (#frames, #bones, 4), quaternions x, y, z, w, of one sign from frame to frame
    scales: Array        #: (#frames, #bones, 3), 1 of rigid bones
    axes: Array          #: (#frames, #bones, 4), quaternions; the identity unless bones are stretched


class Skeleton(Owner):
    """A skeleton with its skin and its motion, made by fit_skeleton. Its arrays are copies.

    bones, frames, influences  their numbers
    parents       (#bones,) int64; parents come before their children, -1 is that of the root, bone 0
    joints        (#bones, 3): where each bone meets its parent, at rest
    vertex_bones  (#vertices, #influences): the bones of a vertex; 0 where a weight is 0
    weights       (#vertices, #influences) float32: those of a vertex fall, and their sum is 1
    maps          (#frames, #bones, 3, 4): the matrices by which bones move vertices from their places at rest
    """

    bones: int
    frames: int
    influences: int
    parents: Array
    joints: Array
    vertex_bones: Array
    weights: Array
    maps: Array

    def __init__(self) -> None:
        raise TypeError('a Skeleton is made by fit_skeleton')

    @classmethod
    def _of(cls, handle: Handle) -> Skeleton:
        its, info = cls.__new__(cls), arrays.struct(_c.cageform_skeleton_info)
        its._object = handle
        check(library.cageform_skeleton_describe(handle, info))

        def copy(pointer: Any, *shape: int) -> Array:
            array: Array = np.ctypeslib.as_array(pointer, shape)
            return array.copy()
        its.bones, its.frames, its.influences = info.bones, info.frames, info.influences
        parents = copy(info.parents, info.bones)
        its.parents = np.where(parents == 0xFFFFFFFF, -1, parents.astype(np.int64))
        its.joints = copy(info.joints, info.bones, 3)
        its.vertex_bones = copy(info.vertex_bones, info.vertices, info.influences)
        its.weights = copy(info.weights, info.vertices, info.influences)
        its.maps = np.ascontiguousarray(copy(info.maps, info.frames, info.bones, 4, 3).swapaxes(2, 3))
        return its

    def places(self, rest: npt.ArrayLike) -> Array:
        """Returns where vertices (#vertices, 3) that are at `rest` at rest are in the frames: (#frames, #vertices, 3)."""
        given = arrays.points(rest, 'rest', 3)
        if len(given) != len(self.weights):
            raise ValueError('rest: an array of shape (%d, 3), not %s' % (len(self.weights), given.shape))
        moved = np.zeros((self.frames, len(given), 3))
        for bones, weights in zip(self.vertex_bones.T, self.weights.T):
            maps = self.maps[:, bones]
            moved += weights[:, None] * (np.einsum('tnij,nj->tni', maps[..., :3], given) + maps[..., 3])
        return moved

    def transforms(self) -> Transforms:
        """Returns the transforms of the bones' nodes, relative to their parents, as engines play them."""
        count = self.frames * self.bones
        out = [np.empty((count, width)) for width in (3, 4, 3, 4)]
        views = [arrays.written_view(array) for array in out]
        check(library.cageform_skeleton_transforms(self._object, *views))
        return Transforms(*[array.reshape(self.frames, self.bones, -1) for array in out])


def fit_skeleton(rest: npt.ArrayLike, frames: npt.ArrayLike, faces: Optional[npt.ArrayLike] = None, bones: int = 0,
                 max_distance: float = 0, kind: str = 'rigid', influences: int = 4, threads: Optional[int] = None,
                 progress: Progress = None) -> Tuple[Skeleton, Report]:
    """Fits a skeleton to any sequence of meshes: bones that turn, joints, a hierarchy, and a few weights a vertex.

    rest          vertices at rest (#vertices, 3), where no bone has moved
    frames        where they are in each frame (#frames, #vertices, 3); the rest need not be one
    faces         triangles (#faces, 3): weights are smooth along their edges; None: there are none
    bones         their number; 0: as few as keep max_distance
    max_distance  a share of the figure's diagonal at rest, within which every vertex is to stay in every frame; 0: none.
                  With `bones`, report.beyond counts the vertices that are farther away
    kind          'rigid' (bones turn and move), 'similar' (one scale besides), 'stretched' (any affine map)
    influences    weights a vertex, 1 to 8
    threads       None: all processors; the result does not depend on them
    progress      progress(done) is told the fraction done; it returns False to cancel

    Returns the Skeleton and a Report with bones, rms, max_distance, frame, culprit (a vertex), turn, beyond.
    """
    given, moved = arrays.points(rest, 'rest', 3), arrays.numbers(frames, 'frames')
    if moved.ndim != 3 or moved.shape[1:] != given.shape:
        raise ValueError('frames: an array of shape (#frames, %d, 3), not %s' % (len(given), moved.shape))
    in_a_row = arrays.poses(moved, 'frames', '#frames, #vertices')
    corners = arrays.indices(() if faces is None else faces, 'faces')
    if faces is not None and corners.size and np.shape(faces)[1:] != (3,):
        raise ValueError('faces: an array of shape (#faces, 3), not %s' % (np.shape(faces),))
    options = arrays.struct(_c.cageform_skeleton_options, bones=bones, influences=influences, max_distance=max_distance,
                            kind=arrays.choice(_c.CHOICES['bone_kind'], kind, 'kind'))
    if influences == 0:
        raise ValueError('influences: 1 to 8, not 0')
    handle, report = make(library.cageform_fit_skeleton, arrays.view(given), arrays.view(in_a_row), arrays.pointer(corners),
                          corners.size, options, running=Running(threads, progress))
    return Skeleton._of(handle), report
