"""Poses of cages by pins on figures."""

from __future__ import annotations

import ctypes
import threading
from typing import TYPE_CHECKING, Any, Optional, Tuple

import numpy as np

from . import _arrays as arrays
from . import _c
from ._arrays import Array, Source
from ._bindings import Coordinates
from ._figures import Figure
from ._library import library
from ._objects import Handle, Owner, Progress, Running, bytes_of, invoke, make, make_plain
from ._reports import Report
from .errors import check

if TYPE_CHECKING:
    import numpy.typing as npt


class Samples(Owner):
    """Samples of the interior of a cage, for Pins. Create them once. The coordinates must have gradients.

    samples    requested number of samples; 0: chosen from the number of handles
    rotations  number of clusters with a rotation of their own; 0: chosen from the number of handles
    smoothing  distance over which bends are spread, relative to the cage's size

    handles, dimension, dtype; report: None for opened samples
    """

    handles: int
    dimension: int
    dtype: np.dtype[Any]
    report: Optional[Report]

    def __init__(self, coordinates: Coordinates, samples: int = 0, rotations: int = 0, smoothing: float = 0,
                 threads: Optional[int] = None, progress: Progress = None) -> None:
        options = arrays.struct(_c.cageform_samples_options, samples=samples, rotations=rotations, smoothing=smoothing)
        self._adopt(*make(library.cageform_pose_samples, coordinates._object, options, running=Running(threads, progress)))

    def _adopt(self, handle: Handle, report: Optional[Report]) -> None:
        self._object, self.report, info = handle, report, arrays.struct(_c.cageform_samples_info)
        check(library.cageform_samples_describe(handle, info))
        self.handles, self.dimension, self.dtype = info.handles, info.dimension, arrays.dtype_of(info.scalar)

    def pack(self) -> Array:
        """Returns the bytes (#bytes,) as uint8, for open_samples."""
        return bytes_of(make(library.cageform_samples_pack, self._object)[0])


def open_samples(source: Source, skip_checksum: bool = False) -> Samples:
    """Opens packed samples from the path of a file, or from bytes. Copies them."""
    data = arrays.aligned(source)
    samples = Samples.__new__(Samples)
    samples._adopt(make_plain(library.cageform_samples_open, data.ctypes.data, len(data), int(skip_checksum)), None)
    return samples


class Pins(Owner):
    """Moves a cage so that pinned points reach targets and its interior deforms as rigidly as possible.

        pins = cageform.Pins(cageform.Samples(coordinates))
        pins.set(binding.figure, [12, 40])            # indices of points
        pose, report = pins.solve(targets, pose)      # repeat until report.settled

    samples     Samples; they are copied
    pin_weight  stiffness of a pin of weight 1 relative to the stretch of the figure; 0: 1e4
    hard        pins are a thousand times nearer to their targets
    iterations  per solve; 0: 4

    Only one thread at a time may use it.
    """

    def __init__(self, samples: Samples, pin_weight: float = 0, hard: bool = False, iterations: int = 0) -> None:
        options = arrays.struct(_c.cageform_pins_options, pin_weight=pin_weight, hard=hard, iterations=iterations)
        self._object = make_plain(library.cageform_pins_create, samples._object, options)
        self.dimension, self.dtype = samples.dimension, samples.dtype
        self._lock = threading.Lock()

    def set(self, figure: Figure, points: npt.ArrayLike, weights: Optional[npt.ArrayLike] = None) -> None:
        """Replaces all pins by pins at points of a figure: indices (#pins,) and weights (#pins,); None: weights 1. The pose
        does not change."""
        given = arrays.indices(points, 'points')
        counted = None if weights is None else arrays.doubles(weights, 'weights', len(given), 'pin')
        with self._lock:
            invoke(library.cageform_pins_set, self._object, figure._object, arrays.pointer(given), len(given),
                   arrays.pointer(counted, ctypes.c_double))

    def hold(self, handles: npt.ArrayLike) -> None:
        """Replaces the set of fixed handles (#held,), which keep their positions in the pose."""
        given = arrays.indices(handles, 'handles')
        with self._lock:
            invoke(library.cageform_pins_hold, self._object, arrays.pointer(given), len(given))

    def solve(self, targets: npt.ArrayLike, pose: npt.ArrayLike) -> Tuple[Array, Report]:
        """Moves a copy of the pose (#handles, dimension) towards the targets (#pins, dimension).
        Returns the pose, and a Report with miss, step, settled, folded, least_stretch, largest_stretch."""
        wanted = arrays.points(targets, 'targets', self.dimension, self.dtype)
        moved = np.array(arrays.points(pose, 'pose', self.dimension, self.dtype), order='C')
        with self._lock:
            report = invoke(library.cageform_pins_solve, self._object, arrays.view(wanted), arrays.written_view(moved))
        return moved, report
