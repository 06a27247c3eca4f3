"""Skeletons fitted to sequences of meshes."""

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
    """The local transforms of the bones' nodes: x -> rotation(scale * axes(x)) + translation maps a node's frame,
    whose origin is its joint, to its parent's frame."""

    translations: Array  #: (#frames, #bones, 3)
    rotations: Array     #: (#frames, #bones, 4), quaternions x, y, z, w, with consistent signs between frames
    scales: Array        #: (#frames, #bones, 3), 1 for rigid bones
    axes: Array          #: (#frames, #bones, 4), quaternions; identity unless bones are stretched


class Skeleton(Owner):
    """A skeleton with its skin and its motion, from fit_skeleton. Its arrays are copies.

    bones, frames, influences  numbers of each
    parents       (#bones,) int64; parents precede children; -1 for the root, bone 0
    joints        (#bones, 3): the joint of each bone with its parent, at rest
    vertex_bones  (#vertices, #influences): the bones of a vertex; 0 where a weight is 0
    weights       (#vertices, #influences) float32: descending per vertex, with sum 1
    maps          (#frames, #bones, 3, 4): the matrices that move vertices at rest with the bones
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
        raise TypeError('fit_skeleton makes Skeletons')

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
        """Returns the positions (#frames, #vertices, 3) in all frames of vertices with the positions `rest` (#vertices, 3)."""
        given = arrays.points(rest, 'rest', 3)
        if len(given) != len(self.weights):
            raise ValueError('rest: must be an array of shape (%d, 3), not %s' % (len(self.weights), given.shape))
        moved = np.zeros((self.frames, len(given), 3))
        for bones, weights in zip(self.vertex_bones.T, self.weights.T):
            maps = self.maps[:, bones]
            moved += weights[:, None] * (np.einsum('tnij,nj->tni', maps[..., :3], given) + maps[..., 3])
        return moved

    def transforms(self) -> Transforms:
        """Returns the local transforms of the bones' nodes, for engines."""
        count = self.frames * self.bones
        out = [np.empty((count, width)) for width in (3, 4, 3, 4)]
        views = [arrays.written_view(array) for array in out]
        check(library.cageform_skeleton_transforms(self._object, *views))
        return Transforms(*[array.reshape(self.frames, self.bones, -1) for array in out])


def fit_skeleton(rest: npt.ArrayLike, frames: npt.ArrayLike, faces: Optional[npt.ArrayLike] = None, bones: int = 0,
                 max_distance: float = 0, kind: str = 'rigid', influences: int = 4, threads: Optional[int] = None,
                 progress: Progress = None) -> Tuple[Skeleton, Report]:
    """Fits a skeleton to a sequence of meshes: rotating bones, joints, a hierarchy, and a few weights per vertex.

    rest          vertices at rest (#vertices, 3), where all bones have the identity map
    frames        vertices in each frame (#frames, #vertices, 3); the rest pose need not be one of them
    faces         triangles (#faces, 3): weights are smooth along edges; None: no faces
    bones         number of bones; 0: the fewest that meet max_distance
    max_distance  maximum distance of a vertex in any frame, relative to the figure's diagonal at rest; 0: none.
                  With `bones` it is not a limit: report.beyond counts the vertices over it
    kind          'rigid' (rotation, translation), 'similar' (and uniform scale), 'stretched' (any affine map)
    influences    weights per vertex, 1 to 8
    threads       None: all processors; the result does not depend on them
    progress      progress(done) receives the completed fraction, 0 to 1; it returns False to cancel

    Returns the Skeleton and a Report with bones, rms, max_distance, frame, culprit (a vertex), turn, beyond.
    """
    given, moved = arrays.points(rest, 'rest', 3), arrays.numbers(frames, 'frames')
    if moved.ndim != 3 or moved.shape[1:] != given.shape:
        raise ValueError('frames: must be an array of shape (#frames, %d, 3), not %s' % (len(given), moved.shape))
    in_a_row = arrays.poses(moved, 'frames', '#frames, #vertices')
    corners = arrays.indices(() if faces is None else faces, 'faces')
    if faces is not None and corners.size and np.shape(faces)[1:] != (3,):
        raise ValueError('faces: must be an array of shape (#faces, 3), not %s' % (np.shape(faces),))
    options = arrays.struct(_c.cageform_skeleton_options, bones=bones, influences=influences, max_distance=max_distance,
                            kind=arrays.choice(_c.CHOICES['bone_kind'], kind, 'kind'))
    if influences == 0:
        raise ValueError('influences: 1 to 8, not 0')
    handle, report = make(library.cageform_fit_skeleton, arrays.view(given), arrays.view(in_a_row), arrays.pointer(corners),
                          corners.size, options, running=Running(threads, progress))
    return Skeleton._of(handle), report
