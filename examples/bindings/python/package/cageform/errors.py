"""The exceptions, one per status, such as CageSelfCrossing for the status cage_self_crossing.

All derive from CageformError, and OutOfMemory also from MemoryError. dir(cageform.errors) lists them.
"""

from typing import TYPE_CHECKING, Any, Dict, List, Optional, Type, Union

from . import _c
from ._library import status_text

if TYPE_CHECKING:
    from ._reports import Report


class CageformError(Exception):
    """An error of the library.

    code     the code of the status, which never changes
    name     the name of the status, such as 'cage_self_crossing'
    culprit  the index of the invalid element: a point, handle, pin, face, clip, …; for a file, the
             four letters of the invalid part; None if there is none
    report   the Report of the call; None for calls without a report
    """

    code: int = -1
    name: str = 'failed'

    def __init__(self, message: str, culprit: Union[int, str, None] = None,
                 report: 'Optional[Report]' = None) -> None:
        super().__init__(message)
        self.culprit = culprit
        self.report = report


def _make() -> Dict[int, Type[CageformError]]:
    made: Dict[int, Type[CageformError]] = {}
    for code, name in _c.STATUSES.items():
        if code == _c.CAGEFORM_OK:
            continue
        title = ''.join(word.capitalize() for word in name.split('_'))
        bases = (CageformError, MemoryError) if name == 'out_of_memory' else (CageformError,)
        made[code] = type(title, bases, {'code': code, 'name': name, '__module__': __name__,
                                         '__doc__': status_text(code)})
    return made


_by_code = _make()
globals().update({kind.__name__: kind for kind in _by_code.values()})
__all__: List[str] = ['CageformError'] + [kind.__name__ for kind in _by_code.values()]

if TYPE_CHECKING:
    def __getattr__(name: str) -> Type[CageformError]: ...


def error_of(code: int, message: str = '', culprit: Union[int, str, None] = None,
             report: Any = None) -> CageformError:
    """Makes the exception of a status."""
    return _by_code.get(code, CageformError)(message or status_text(code), culprit, report)


def check(code: int) -> None:
    """Raises the exception of a status that is not ok."""
    if code != _c.CAGEFORM_OK:
        raise error_of(code)
