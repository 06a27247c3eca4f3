"""Objects of the library, and calls that create objects or run long."""

from __future__ import annotations

import ctypes
import os
import signal
import threading
import weakref
from typing import Any, Callable, List, NoReturn, Optional, Tuple

import numpy as np

from . import _c
from ._arrays import Array, struct
from ._library import library
from ._reports import Report
from .errors import check, error_of

Progress = Optional[Callable[[float], object]]


class Handle:
    """A pointer to an object. The object is freed when nothing refers to it, and before the objects that it uses."""

    def __init__(self, address: int, *keeps: Any) -> None:
        self._as_parameter_ = ctypes.c_void_p(address)  # what ctypes passes
        # A finalizer keeps its arguments alive until it has run, also in reference cycles.
        weakref.finalize(self, _free, address, keeps).atexit = False


def _free(address: int, _: Tuple[Any, ...], free: Any = library.cageform_free) -> None:
    free(address)


class Owner:
    """The base of classes that own an object of the library."""

    _object: Handle

    def __reduce_ex__(self, _: Any) -> NoReturn:
        raise TypeError('%s is memory of the library and cannot be copied or pickled. Bytes of '
                        'pack() are' % type(self).__name__)


class Running:
    """Threads and progress of a call. An exception of progress is raised after the call. Ctrl-C cancels the call."""

    def __init__(self, threads: Optional[int], progress: Progress) -> None:
        if threads is None:
            threads = len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count() or 1
        if not 0 <= threads <= 1024:
            raise ValueError('threads: 0 to 1024, not %d' % threads)
        self.struct = struct(_c.cageform_running, threads=threads)
        self._raised: List[BaseException] = []
        self._signals: List[Tuple[int, Any]] = []

        def step(_: Any, done: float) -> int:
            if self._signals or self._raised:
                return 0
            try:
                return 0 if progress is not None and progress(done) is False else 1
            except BaseException as error:
                self._raised.append(error)
                return 0

        self.struct.progress = _c.FUNCTIONS_OF['progress'](step)

    def __enter__(self) -> Running:
        # In a callback, Python would raise KeyboardInterrupt and ctypes would drop it: this stores the signal.
        self._handler = signal.getsignal(signal.SIGINT)
        self._handles = callable(self._handler) and threading.current_thread() is threading.main_thread()
        if self._handles:
            signal.signal(signal.SIGINT, lambda number, frame: self._signals.append((number, frame)))
        return self

    def __exit__(self, *_: Any) -> None:
        if self._handles:
            signal.signal(signal.SIGINT, self._handler)
        if self._signals and callable(self._handler):
            self._handler(*self._signals[0])
        if self._raised:
            raise self._raised[0]


def invoke(function: Any, *arguments: Any, running: Optional[Running] = None) -> Report:
    """Calls a function. Its last arguments are the running struct (if `running` is given) and a report.
    Returns the report, or raises the exception of its status."""
    return _invoke(function, arguments, running, ())


def make(function: Any, *arguments: Any, running: Optional[Running] = None, keeps: Tuple[Any, ...] = (),
         accepts: int = _c.CAGEFORM_OK) -> Tuple[Handle, Report]:
    """Calls a function that creates an object. Its last arguments are the running struct (if `running` is given), the
    address for the object, and a report. It also creates the object with the status `accepts`."""
    made = ctypes.c_void_p()
    try:
        report = _invoke(function, arguments, running, (ctypes.byref(made),), accepts)
    except BaseException:
        library.cageform_free(made)  # the object exists if `progress` raised in its last call
        raise
    return Handle(made.value or 0, *keeps), report


def _invoke(function: Any, arguments: Tuple[Any, ...], running: Optional[Running], out: Tuple[Any, ...],
            accepts: int = _c.CAGEFORM_OK) -> Report:
    its = struct(_c.cageform_report)
    if running is None:
        code = function(*arguments, *out, its)
    else:
        with running:
            code = function(*arguments, running.struct, *out, its)
    report = Report._of(its)
    if code not in (_c.CAGEFORM_OK, accepts):
        raise error_of(code, report.message, report.culprit, report)
    return report


def make_plain(function: Any, *arguments: Any, keeps: Tuple[Any, ...] = ()) -> Handle:
    """Calls a function that creates an object. Its last argument is the address for the object."""
    made = ctypes.c_void_p()
    check(function(*arguments, ctypes.byref(made)))
    return Handle(made.value or 0, *keeps)


class _Memory:
    """Bytes of the library, with the array interface of numpy."""

    def __init__(self, handle: Handle, address: int, size: int) -> None:
        self.keeps = handle
        self.__array_interface__ = {'shape': (size,), 'typestr': '|u1', 'data': (address, True), 'version': 3}


def bytes_of(handle: Handle) -> Array:
    """Returns an object's bytes as an array, which keeps the object alive."""
    data, size = ctypes.c_void_p(), ctypes.c_size_t()
    check(library.cageform_bytes_view(handle, ctypes.byref(data), ctypes.byref(size)))
    return np.asarray(_Memory(handle, data.value or 0, size.value))
