"""Cage-based deformation: bind a figure to a coarse cage once, then move it with the cage.

    import cageform

    cage = cageform.Cage.polygon([(0, 0), (4, 0), (4, 4), (0, 4)])
    binding = cageform.Coordinates(cage, 'harmonic').bind([(1, 1), (2, 3)])
    print(binding.report)
    pose = binding.figure.rest()
    pose[2] = 6, 6
    points = binding.figure.clone(pose)

Points are numpy arrays of shape (#points, dimension), dimension 2 or 3, of float32 or float64. An array is used without
a copy if it has the required type, the numbers of a row are contiguous, and rows ascend in memory; otherwise it is
copied. Errors are exceptions named after statuses, in cageform.errors, with the index of the invalid element. Other
Python threads run during a call.
"""

try:
    import numpy as _numpy
except ImportError as _error:
    raise ImportError('cageform needs numpy: install python3-numpy, or numpy with pip (%s)' % _error) from _error

from . import errors
from ._bindings import Binding, Coordinates
from ._cages import Cage, check, make_cage
from ._figures import Clip, Figure, compile_clip, open
from ._library import version as _version
from ._pins import Pins, Samples, open_samples
from ._reports import Fault, Report
from ._skeletons import Skeleton, fit_skeleton
from ._wraps import Wrap, wrap
from .errors import CageformError

__all__ = ['Binding', 'Cage', 'CageformError', 'Clip', 'Coordinates', 'Fault', 'Figure', 'Pins', 'Report', 'Samples',
           'Skeleton', 'Wrap', 'check', 'compile_clip', 'errors', 'fit_skeleton', 'make_cage', 'open', 'open_samples', 'wrap']
__version__ = _version()

for _name in __all__:  # so that messages, help() and pickles show the public names
    if _name != 'errors':
        globals()[_name].__module__ = __name__
del _name
