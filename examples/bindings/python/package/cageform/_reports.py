"""Reports of calls, and faults of cages."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Dict, List, Optional, Tuple

from . import _c
from ._arrays import index_of

_ELEMENTS: Dict[int, str] = {_c.CAGEFORM_VERTEX: 'vertex', _c.CAGEFORM_EDGE: 'edge', _c.CAGEFORM_FACE: 'face',
                             _c.CAGEFORM_LOOP: 'loop'}
_ENDS: Dict[int, str] = {number: name for name, number in _c.CHOICES['wrap_end'].items()}


@dataclass(frozen=True)
class Fault:
    """A fault of a cage, or a warning."""

    text: str                      #: a message
    is_warning: bool
    a: Optional[Tuple[str, int]]   #: an element, as ('vertex', 7); the index of an edge is that of its first vertex
    b: Optional[Tuple[str, int]]   #: a second element

    def __str__(self) -> str:
        named = ', '.join('%s %d' % element for element in (self.a, self.b) if element)
        return self.text + (' (%s)' % named if named else '')

    @classmethod
    def _of(cls, its: Any) -> Fault:
        def element(kind: int, index: int) -> Optional[Tuple[str, int]]:
            return (_ELEMENTS[kind], index) if kind in _ELEMENTS else None
        return cls(its.text.decode(), its.status == _c.CAGEFORM_OK, element(its.a_is, its.a), element(its.b_is, its.b))


@dataclass(repr=False)
class Report:
    """The result of a call. print() shows the attributes that the call sets; all others are 0, None or empty."""

    status: str = 'ok'
    message: str = ''              #: the error as text; empty without an error
    culprit: Optional[int] = None  #: index of the element with the error: a point, handle, pin, face, clip, …
    faults: int = 0                #: number of errors of the cage; check() lists them
    warnings: int = 0
    fault: Optional[Fault] = None  #: the first error of the cage, or the first warning
    seconds: float = 0

    # bind; the Binding has the lists
    points: int = 0
    on_boundary: int = 0
    outside: int = 0
    faded: int = 0
    not_finite: int = 0
    unreached: int = 0
    not_restored: int = 0
    partition_error: float = 0     #: maximum |sum of weights - 1|
    reproduction_error: float = 0  #: maximum distance of a point from the weighted sum of handles
    least_weight: float = 0
    amplification: float = 0       #: maximum sum of |weights| of a point

    # harmonic coordinates
    unknowns: int = 0              #: unknowns of one function
    memory: int = 0                #: in bytes
    grid_error: float = 0          #: estimated maximum error of a weight
    sufficient_accuracy: float = 0  #: with OutOfMemory: an accuracy that fits; 0: unknown

    # pack
    bytes: int = 0
    dense_bytes: int = 0           #: bytes of a file with all weights
    distance: float = 0            #: maximum change of a point by packing
    mean_distance: float = 0

    # make_cage; volumes are areas in 2D
    vertices: int = 0
    components: int = 0
    tunnels: int = 0
    margin: float = 0
    clearance: float = 0           #: minimum distance between figure and cage
    volume: float = 0
    tightest_volume: float = 0
    least_angle: float = 0

    # Samples
    samples: int = 0
    rotations: int = 0

    # Pins.solve, in the units of the cage
    miss: float = 0                #: maximum distance of a pin from its target; the culprit is this pin
    step: float = 0
    rigid_energy: float = 0
    least_stretch: float = 0
    largest_stretch: float = 0
    iterations: int = 0
    folded: int = 0                #: number of inverted clusters
    settled: bool = False          #: the last solve moved no handle by more than 3e-5 of the cage's size

    # compile_clip
    curve_error: float = 0         #: maximum distance of a coordinate from the curve through its keys

    # fit_skeleton; distances are relative to the figure's diagonal at rest. The culprit is the vertex with the largest distance
    bones: int = 0
    frame: Optional[int] = None    #: the frame of the culprit; None for an invalid vertex: at rest
    beyond: int = 0                #: number of vertices over max_distance
    rms: float = 0
    max_distance: float = 0
    turn: float = 0                #: rotation error of the faces: 99th percentile, in degrees
    mean_influences: float = 0

    # wrap; distances are relative to `height`. miss is the largest distance of a landmark from its place, and the culprit is
    # this landmark. folded and the stretches are those of the map at source, followers and samples
    height: float = 0              #: of the target, along the longest axis of the source
    start: float = 0               #: mean distance from the aligned source to the target
    to_target_mean: float = 0      #: from the vertices of the wrapped source to the target
    to_target_upper: float = 0     #: 95th percentile
    to_target_largest: float = 0
    to_source_mean: float = 0      #: from the vertices of the target to the wrapped source
    to_source_upper: float = 0
    to_source_largest: float = 0
    unmatched_source: float = 0    #: share of the vertices without a match
    unmatched_target: float = 0
    noise: float = 0               #: standard deviation of the target's vertices; below 1e-3: 0
    skipped_faces: int = 0         #: faces of the target without area
    left_out: int = 0              #: spans of the first lattice with more handles than allowed; 0: none
    far_followers: int = 0         #: followers too far from the source to be checked
    ended: str = 'stages'          #: 'stages', 'residual' or 'noise' (was reached), 'fold': a finer fit would fold space
    of_target: bool = False        #: the culprit is of the target

    def __str__(self) -> str:
        lines = [self.message] if self.message else []
        if self.fault and self.fault.is_warning:
            lines.append(str(self.fault))
        for name, value in self._known():
            if name not in ('status', 'message', 'culprit', 'frame', 'fault'):
                value = '%.3g' % value if isinstance(value, float) else 'yes' if value is True else value
                lines.append('%s: %s' % (name.replace('_', ' '), value))
        return '\n'.join(lines) or 'ok'

    def __repr__(self) -> str:
        return 'Report(%s)' % ', '.join('%s=%r' % known for known in self._known())

    def _known(self) -> List[Tuple[str, Any]]:
        listed = [(own.name, getattr(self, own.name), own.default) for own in fields(self)]
        return [(name, value) for name, value, default in listed if value != default]

    @classmethod
    def _of(cls, its: Any) -> Report:
        members = {own.name: getattr(its, own.name) for own in fields(cls)}
        members.update(status=_c.STATUSES.get(its.status, 'failed'), message=its.message.decode(),
                       culprit=index_of(its.culprit), frame=index_of(its.frame),
                       fault=Fault._of(its.fault) if its.fault.text else None, settled=bool(its.settled),
                       ended=_ENDS[its.ended], of_target=bool(its.of_target))
        return cls(**members)
