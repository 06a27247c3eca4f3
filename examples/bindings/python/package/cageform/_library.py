"""Finds and loads the shared library, and declares its functions."""

import ctypes
import os

from . import _c

NAMES = ('libcageform.so', 'libcageform.dylib', 'cageform.dll')


def _load() -> ctypes.CDLL:
    folder = os.path.dirname(os.path.abspath(__file__))
    paths = [os.path.join(folder, name) for name in NAMES]
    path = os.environ.get('CAGEFORM_LIBRARY') or next((path for path in paths if os.path.exists(path)), None)
    if path is None:
        raise ImportError('cageform: %s contains none of %s' % (folder, ', '.join(NAMES)))
    try:
        loaded = ctypes.CDLL(path)
        abi = loaded.cageform_abi_version()
        for name, (result, arguments) in _c.FUNCTIONS.items():
            function = getattr(loaded, name)
            function.restype, function.argtypes = result, arguments
    except (OSError, AttributeError) as error:
        raise ImportError('cageform: %s cannot be used: %s' % (path, error)) from error
    if abi != _c.CAGEFORM_C_ABI:
        raise ImportError('cageform: %s has version %d of the C interface, not %d' % (path, abi, _c.CAGEFORM_C_ABI))
    return loaded


library = _load()


def version() -> str:
    """Returns the version of the library."""
    text: bytes = library.cageform_version()
    return text.decode()


def status_text(code: int) -> str:
    """Returns the message of a status."""
    text: bytes = library.cageform_status_text(code)
    return text.decode()
