"""Conversion of numpy arrays for the library. Arrays with a suitable type and layout are not copied."""

from __future__ import annotations

import ctypes
import mmap
import operator
import os
from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple, Type, TypeVar, Union

import numpy as np

from . import _c

if TYPE_CHECKING:
    import numpy.typing as npt
    Array = npt.NDArray[Any]
else:
    Array = np.ndarray
Source = Union[str, 'os.PathLike[str]', bytes, bytearray, memoryview, Array]
Struct = TypeVar('Struct', bound=ctypes.Structure)

_SCALARS: Dict[Any, int] = {np.dtype(np.float32): _c.CAGEFORM_FLOAT, np.dtype(np.float64): _c.CAGEFORM_DOUBLE}
_NO_INDEX = ctypes.c_size_t(-1).value


def scalar_of(dtype: npt.DTypeLike) -> int:
    dtype = np.dtype(dtype)
    if dtype not in _SCALARS:
        raise TypeError('dtype: must be float32 or float64, not %s' % dtype)
    return _SCALARS[dtype]


def dtype_of(scalar: int) -> np.dtype[Any]:
    return np.dtype(np.float32 if scalar == _c.CAGEFORM_FLOAT else np.float64)


def index_of(number: int) -> Optional[int]:
    return None if number == _NO_INDEX else number


def _is_list(given: Any) -> bool:
    return hasattr(given, '__len__') and not isinstance(given, (str, bytes)) and bool(getattr(given, 'ndim', 1))


def _count(given: Any) -> int:
    return sum(map(_count, given)) if _is_list(given) else 1


def _refuse_uneven(given: Any, name: str) -> None:
    """Raises an error that names the first nested list whose length differs from that of its first sibling."""
    rows = list(given) if _is_list(given) else []
    for k, row in enumerate(rows):
        _refuse_uneven(row, '%s[%d]' % (name, k))
    for k, row in enumerate(rows):
        if _count(row) != _count(rows[0]):
            raise ValueError('%s[%d] has %d number%s, %s[0] %d' %
                             (name, k, _count(row), '' if _count(row) == 1 else 's', name, _count(rows[0])))


def numbers(given: npt.ArrayLike, name: str) -> Array:
    """Returns an array of real numbers of any type and shape."""
    try:
        array = np.asarray(given)
    except ValueError:
        _refuse_uneven(given, name)
        raise
    if array.dtype.kind not in 'fiu' and array.size:
        raise TypeError('%s: must be real numbers, not %s' % (name, array.dtype))
    return array


def _serves(array: Array, dtype: np.dtype[Any]) -> bool:
    """Whether the library can use an array (count, width) of a type without a copy."""
    (count, width), item, (row, column) = array.shape, array.itemsize, array.strides
    in_rows = column == item and (count < 2 or row >= width * item and row % item == 0)
    return array.dtype == dtype and in_rows and array.flags.aligned


def points(given: npt.ArrayLike, name: str, dimension: Optional[int] = None, dtype: Optional[np.dtype[Any]] = None,
           dimensions: Tuple[int, ...] = (2, 3)) -> Array:
    """Returns points that the library can read: the array itself if possible, else a copy. `dtype` is the required
    type; None: float32 or float64."""
    array = numbers(given, name)
    allowed = dimensions if dimension is None else (dimension,)
    if array.ndim != 2 or array.shape[1] not in allowed:
        raise ValueError('%s: must be an array of shape (count, %s), not %s' %
                         (name, ' or '.join(map(str, allowed)), array.shape))
    if dtype is None:
        dtype = array.dtype if array.dtype in _SCALARS else np.dtype(np.float64)
    return array if _serves(array, dtype) else np.array(array, dtype=dtype, order='C')


def output(out: Optional[Array], shape: Tuple[int, ...], dtype: np.dtype[Any]) -> Array:
    """Returns the array that the library writes: `out` itself if possible, else a new one; give_back() copies it to `out`."""
    if out is None:
        return np.empty(shape, dtype)
    if not isinstance(out, np.ndarray):
        raise TypeError('out: must be an array, not %s' % type(out).__name__)
    if out.shape != shape or not out.flags.writeable:
        raise ValueError('out: must be a writeable array of shape %s, not %s%s' %
                         (shape, '' if out.flags.writeable else 'a read-only one of ', out.shape))
    if not np.can_cast(dtype, out.dtype, 'same_kind'):
        raise TypeError('out: must be real numbers, not %s' % out.dtype)
    return out if _serves(out, dtype) else np.empty(shape, dtype)


def give_back(written: Array, out: Optional[Array]) -> Array:
    """Copies the written array to the caller's array, if they differ; returns the caller's array."""
    if out is None or written is out:
        return written
    out[...] = written
    return out


def view(array: Array, kind: Any = _c.cageform_points) -> Any:
    """Returns the struct for points that are read. The array must be kept alive while the struct is used."""
    count, width = array.shape
    stride = array.strides[0] if count > 1 else 0
    size = (count - 1) * stride + width * array.itemsize if count else 0
    return kind(array.ctypes.data, count, stride, size, _SCALARS[array.dtype], width)


def written_view(array: Array) -> Any:
    """Returns the struct for points that are written."""
    return view(array, _c.cageform_output)


def poses(given: npt.ArrayLike, name: str, count: str) -> Array:
    """Returns the points of all poses as one array, pose after pose."""
    array = numbers(given, name)
    if array.ndim != 3:
        raise ValueError('%s: must be an array of shape (%s, dimension), not %s' % (name, count, array.shape))
    return points(array.reshape(-1, array.shape[2]), name)


def doubles(given: npt.ArrayLike, name: str, count: Optional[int], of: str) -> Array:
    """Returns `count` numbers as a one-dimensional float64 array."""
    array = np.ascontiguousarray(numbers(given, name), dtype=np.float64)
    if array.ndim != 1 or count is not None and len(array) != count:
        raise ValueError('%s: must have one number per %s: an array of shape (%s,), not %s' %
                         (name, of, 'count' if count is None else count, array.shape))
    return array


def indices(given: npt.ArrayLike, name: str) -> Array:
    """Returns integers as a uint32 array of one dimension."""
    array = np.asarray(given)
    if array.size and array.dtype.kind not in 'iu':
        raise TypeError('%s: must be integers, not %s' % (name, array.dtype))
    if array.size and (array.min() < 0 or array.max() > 0xFFFFFFFF):
        raise ValueError('%s: must be integers from 0 to 2**32 - 1, not %d to %d' % (name, array.min(), array.max()))
    return np.ascontiguousarray(array, dtype=np.uint32).ravel()


def pointer(array: Optional[Array], kind: Any = ctypes.c_uint32) -> Any:
    """Returns a pointer to an array's numbers, which keeps the array alive; None for an empty array."""
    return array.ctypes.data_as(ctypes.POINTER(kind)) if array is not None and array.size else None


def set_member(its: ctypes.Structure, name: str, value: Any) -> None:
    """Sets a member of a struct; raises an error if the number is out of its range."""
    value = operator.index(value) if hasattr(value, '__index__') else value
    try:
        setattr(its, name, value)
    except TypeError:
        raise TypeError('%s: %r has the wrong type' % (name, value)) from None
    if isinstance(value, int) and getattr(its, name) != value:
        raise ValueError('%s: %d is out of range' % (name, value))


def struct(of: Type[Struct], /, **members: Any) -> Struct:
    """Makes a struct that begins with its size."""
    its = of()
    setattr(its, 'size', ctypes.sizeof(of))
    for name, value in members.items():
        set_member(its, name, value)
    return its


def choice(choices: Dict[Any, int], given: Any, name: str) -> int:
    if isinstance(given, str) and given not in choices:
        given = given.replace('_', '-')
    if given not in choices:
        raise ValueError('%s: must be one of %s, not %r' % (name, ', '.join(map(repr, choices)), given))
    return choices[given]


def bytes_in(source: Any, name: str) -> Array:
    """Returns the bytes of memory as uint8, without a copy."""
    try:
        return np.frombuffer(memoryview(source).cast('B'), np.uint8) if len(source) else np.empty(0, np.uint8)
    except TypeError:
        raise TypeError('%s: must be contiguous bytes, not %s' % (name, type(source).__name__)) from None


def aligned(source: Source) -> Array:
    """Returns the bytes of a file, which is memory-mapped, or of memory, aligned to 64 bytes. Memory that is writable or
    not aligned is copied."""
    if isinstance(source, (str, os.PathLike)):
        with open(source, 'rb') as file:
            mapped = os.fstat(file.fileno()).st_size > 0
            data = bytes_in(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) if mapped else b'', 'source')
    else:
        data = bytes_in(source, 'source')
    if data.ctypes.data % 64 == 0 and not data.flags.writeable:
        return data
    memory = np.empty(len(data) + 64, np.uint8)
    start = -memory.ctypes.data % 64
    memory[start:start + len(data)] = data
    return memory[start:start + len(data)]
