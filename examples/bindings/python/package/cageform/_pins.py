"""Cages posed by pins on their figures."""

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
    """Samples of the inside of a cage, by which pins move it: made once, of coordinates that have gradients.

    samples    about how many; 0: by the number of handles
    rotations  how many turn on their own; 0: by the number of handles
    smoothing  spreads bends over this share of the cage's size

    handles, dimension, dtype; report: None if they were opened
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
        """Returns the bytes (#bytes,) as uint8, which open_samples reads."""
        return bytes_of(make(library.cageform_samples_pack, self._object)[0])


def open_samples(source: Source, skip_checksum: bool = False) -> Samples:
    """Opens packed samples: the path of a file, or bytes. They are copied."""
    data = arrays.aligned(source)
    samples = Samples.__new__(Samples)
    samples._adopt(make_plain(library.cageform_samples_open, data.ctypes.data, len(data), int(skip_checksum)), None)
    return samples


class Pins(Owner):
    """Moves a cage by pins on a figure, as rigidly as possible inside.

        pins = cageform.Pins(cageform.Samples(coordinates))
        pins.set(binding.figure, [12, 40])            # numbers of points
        pose, report = pins.solve(targets, pose)      # again until report.settled

    samples     Samples, or those of open_samples; they are copied
    pin_weight  what a pin counts beside the stretch of the whole figure; 0: 1e4
    hard        pins miss a thousand times less
    iterations  of a frame; 0: 4

    One thread at a time uses it.
    """

    def __init__(self, samples: Samples, pin_weight: float = 0, hard: bool = False, iterations: int = 0) -> None:
        options = arrays.struct(_c.cageform_pins_options, pin_weight=pin_weight, hard=hard, iterations=iterations)
        self._object = make_plain(library.cageform_pins_create, samples._object, options)
        self.dimension, self.dtype = samples.dimension, samples.dtype
        self._lock = threading.Lock()

    def set(self, figure: Figure, points: npt.ArrayLike, weights: Optional[npt.ArrayLike] = None) -> None:
        """Pins points of a figure, instead of those before: their numbers (#pins,), and weights (#pins,), 1 if there
        are none. The pose stays."""
        given = arrays.indices(points, 'points')
        counted = None if weights is None else arrays.doubles(weights, 'weights', len(given), 'pin')
        with self._lock:
            invoke(library.cageform_pins_set, self._object, figure._object, arrays.pointer(given), len(given),
                   arrays.pointer(counted, ctypes.c_double))

    def hold(self, handles: npt.ArrayLike) -> None:
        """Holds handles (#held,) where the pose has them, instead of those before."""
        given = arrays.indices(handles, 'handles')
        with self._lock:
            invoke(library.cageform_pins_hold, self._object, arrays.pointer(given), len(given))

    def solve(self, targets: npt.ArrayLike, pose: npt.ArrayLike) -> Tuple[Array, Report]:
        """Computes a frame: moves a copy of the pose (#handles, dimension) towards the targets (#pins, dimension).
        Returns the pose, and a Report with miss, step, settled, folded, least_stretch, largest_stretch."""
        wanted = arrays.points(targets, 'targets', self.dimension, self.dtype)
        moved = np.array(arrays.points(pose, 'pose', self.dimension, self.dtype), order='C')
        with self._lock:
            report = invoke(library.cageform_pins_solve, self._object, arrays.view(wanted), arrays.written_view(moved))
        return moved, report
