"""Cage-based deformation: bind a figure to a coarse cage once, then move it with the cage.

    import cageform, numpy as np

    cage = cageform.Cage.polygon([(0, 0), (4, 0), (4, 4), (0, 4)])
    binding = cageform.Coordinates(cage, 'harmonic').bind([(1, 1), (2, 3)])
    pose = binding.figure.rest()
    pose[2] = 6, 6
    points = binding.figure.clone(pose)

Arrays are numpy's, float32 or float64: points (#points, dimension), dimension 2 or 3. What is read is not copied where it
has the right scalar and its rows are contiguous. Errors are exceptions named after statuses, with the culprit.
"""

import ctypes
import os
from dataclasses import dataclass, field

import numpy as np

from . import _c

__all__ = ['Cage', 'Coordinates', 'Binding', 'Figure', 'Clip', 'Samples', 'Pins', 'Report', 'Fault', 'CageformError', 'errors', 'open',
           'open_samples', 'make_cage', 'check', 'compile_clip', 'version']


def _load():
    folder = os.path.dirname(os.path.abspath(__file__))
    names = ['libcageform.so', 'libcageform.dylib', 'cageform.dll']
    chosen = os.environ.get('CAGEFORM_LIBRARY')
    paths = [chosen] if chosen else [os.path.join(folder, name) for name in names if os.path.exists(os.path.join(folder, name))]
    if not paths:
        raise ImportError('cageform: %s holds none of %s' % (folder, ', '.join(names)))
    library = ctypes.CDLL(paths[0])
    abi = library.cageform_abi_version()
    if abi != 1:
        raise ImportError('cageform: %s has version %d of the C interface, not 1' % (paths[0], abi))
    for name, (result, arguments) in _c.FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


_library = _load()
version = _library.cageform_version().decode()


# ---- errors ------------------------------------------------------------------------------------------------------------

class CageformError(Exception):
    """A status that is not ok.

    code     its number, which never changes
    name     its name, as 'cage_self_crossing'
    culprit  the index that it names, of a point, pin, face, clip ...; None if there is none
    report   the Report of the call; None if it makes none
    """

    code, name = -1, 'failed'

    def __init__(self, message, culprit=None, report=None):
        super().__init__(message)
        self.culprit, self.report = culprit, report


class _Errors:
    """The exceptions by name: errors.CageSelfCrossing is raised for the status cage_self_crossing."""

    def __init__(self):
        self._by_code = {}
        for code, name in _c.STATUSES.items():
            if code == 0:
                continue
            title = ''.join(word.capitalize() for word in name.split('_'))
            base = (CageformError, MemoryError) if name == 'out_of_memory' else (CageformError,)
            kind = type(title, base, {'code': code, 'name': name, '__module__': 'cageform.errors',
                                      '__doc__': _library.cageform_status_text(code).decode()})
            setattr(self, title, kind)
            self._by_code[code] = kind


errors = _Errors()


def _check(code, report=None):
    if code == 0:
        return
    text = _library.cageform_status_text(code).decode()
    kind = errors._by_code.get(code, CageformError)
    if report is None:
        raise kind(text)
    raise kind(report.message or text, report.culprit, report)


# ---- reports -----------------------------------------------------------------------------------------------------------

_ELEMENTS = {1: 'vertex', 2: 'edge', 3: 'face', 4: 'loop'}


@dataclass
class Fault:
    """A fault of a cage, or a warning: two elements, each ('vertex', 7) or None."""

    text: str
    is_warning: bool
    a: tuple
    b: tuple

    def __str__(self):
        named = ', '.join('%s %d' % element for element in (self.a, self.b) if element)
        return self.text + (' (%s)' % named if named else '')


def _fault_of(its):
    element = lambda kind, index: (_ELEMENTS[kind], index) if kind in _ELEMENTS else None
    return Fault(its.text.decode(), its.status == 0, element(its.a_is, its.a), element(its.b_is, its.b))


class Report:
    """How a call went. Its members are those of cageform_report in cageform.h; `message` says what was refused, and
    `culprit` which. It prints what the call knows."""

    def __init__(self):
        self._c = _c.cageform_report()
        self._c.size = ctypes.sizeof(self._c)

    def __getattr__(self, name):
        if name.startswith('_'):
            raise AttributeError(name)
        value = getattr(self._c, name)
        if name == 'culprit':
            return None if value == ctypes.c_size_t(-1).value else value
        if name == 'message':
            return value.decode()
        if name == 'fault':
            return _fault_of(value) if value.text else None
        return value

    def __dir__(self):
        return [name for name, _ in _c.cageform_report._fields_ if name not in ('size', 'reserved')]

    def __str__(self):
        lines = [self.message] if self.message else []
        for name, kind in _c.cageform_report._fields_:
            value = getattr(self, name)
            if name in ('size', 'reserved', 'message', 'fault', 'status', 'culprit') or not value:
                continue
            lines.append('%s: %s' % (name.replace('_', ' '), '%.3g' % value if isinstance(value, float) else value))
        return '\n'.join(lines) if lines else 'ok'

    __repr__ = __str__


# ---- arrays ------------------------------------------------------------------------------------------------------------

def _scalar_of(dtype):
    dtype = np.dtype(dtype)
    if dtype == np.float32:
        return 0
    if dtype == np.float64:
        return 1
    raise TypeError('numbers are float32 or float64, not %s' % dtype)


def _points(points, dtype=None, name='points', dimension=None):
    """Returns an array of points that the library can read: itself if it can, else a copy."""
    array = np.asarray(points) if dtype is None else np.asarray(points, dtype=dtype)
    if array.dtype not in (np.float32, np.float64):
        array = array.astype(np.float64)
    if array.ndim != 2 or array.shape[1] not in ((2, 3, 4) if dimension is None else (dimension,)):
        raise ValueError('%s: an array (count, %s), not %s' % (name, dimension or '2 or 3', array.shape))
    item = array.itemsize
    if array.strides[1] != item or (len(array) > 1 and (array.strides[0] < array.shape[1] * item or array.strides[0] % item)) \
            or not array.flags.aligned or not array.dtype.isnative:
        array = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder('='))
    return array


def _view(array, kind=_c.cageform_points):
    stride = array.strides[0] if len(array) > 1 else 0
    bytes_ = (len(array) - 1) * stride + array.shape[1] * array.itemsize if len(array) else 0
    return kind(array.ctypes.data, len(array), stride, bytes_, _scalar_of(array.dtype), array.shape[1])


def _output(out, shape, dtype, name='out'):
    """Returns an array to be written, and the caller's if it has to be copied back."""
    if out is None:
        return np.empty(shape, dtype), None
    if not isinstance(out, np.ndarray) or out.shape != shape or not out.flags.writeable:
        raise ValueError('%s: a writeable array %s' % (name, shape))
    array = _points(out, dtype, name)
    return array, None if array is out else out


def _indices(numbers, name):
    array = np.ascontiguousarray(numbers)
    if array.size and (array.dtype.kind not in 'iu' or array.min() < 0 or array.max() > 0xFFFFFFFF):
        raise ValueError('%s: whole numbers from 0 to 2**32 - 1' % name)
    return array.astype(np.uint32).ravel()


def _pointer(array, kind=ctypes.c_uint32):
    return array.ctypes.data_as(ctypes.POINTER(kind)) if array is not None and array.size else None


def _struct(of, **members):
    its = of()
    its.size = ctypes.sizeof(its)
    for name, value in members.items():
        setattr(its, name, value)
    return its


def _running(threads, progress):
    """Threads and progress(done) of a call. What progress raises is raised again after the call."""
    raised = []

    def step(_, done):
        try:
            return 0 if progress(done) is False else 1
        except BaseException as error:  # also KeyboardInterrupt: the library stops first
            raised.append(error)
            return 0

    its = _struct(_c.cageform_running, threads=os.cpu_count() or 1 if threads is None else threads)
    if progress is not None:
        its.progress = _c.FUNCTIONS_OF['progress'](step)
    return its, raised


class _Object:
    """An object of the library, freed with this one; `_keeps` live as long."""

    def __init__(self, handle, *keeps):
        self._handle, self._keeps = handle, keeps

    def __del__(self):
        if getattr(self, '_handle', None):
            _library.cageform_free(self._handle)


def _call(function, *arguments, report=None, raised=()):
    """Calls a function whose last argument but a report's is where it puts an object; returns the object."""
    made = ctypes.c_void_p()
    ends = () if report is None else (ctypes.byref(report._c),)
    code = function(*arguments, ctypes.byref(made), *ends)
    if raised:
        raise raised[0]
    _check(code, report)
    return made


# ---- cages -------------------------------------------------------------------------------------------------------------

@dataclass
class Cage:
    """A cage, as arrays. Make one by polygon, mesh, curves, lattice or sites, or by make_cage."""

    kind: int
    vertices: np.ndarray = None  #: (#vertices, dimension)
    counts: np.ndarray = None    #: polygon: vertices of each loop; mesh: corners of each face; curves: degree of each edge
    indices: np.ndarray = None   #: mesh: the vertices at the corners of all faces, one after the other
    loops: np.ndarray = None     #: curves: edges of each loop
    members: dict = field(default_factory=dict)

    @staticmethod
    def polygon(vertices, loops=None):
        """Loops in the plane: vertices (#V, 2), and how many vertices each loop has."""
        counts = None if loops is None else _indices(loops, 'loops')
        return Cage(_c.CAGEFORM_POLYGON, _points(vertices, name='vertices', dimension=2), counts)

    @staticmethod
    def mesh(vertices, faces, divisions=1, off_plane=0):
        """Faces in space: vertices (#V, 3) and faces, an array (#F, 3 or 4) or a list of lists, counter-clockwise seen from
        outside. Quads may be divided; a face whose corners are farther off its plane than `off_plane` is a fan."""
        array = isinstance(faces, np.ndarray) and faces.ndim == 2
        counts = np.full(len(faces), faces.shape[1]) if array else np.array([len(face) for face in faces])
        indices = faces if array else np.array([vertex for face in faces for vertex in face], dtype=np.int64)
        return Cage(_c.CAGEFORM_MESH, _points(vertices, name='vertices', dimension=3), _indices(counts, 'faces'),
                    _indices(indices, 'faces'), members={'divisions': divisions, 'off_plane': off_plane})

    @staticmethod
    def curves(edges, loops=None):
        """Loops of Bezier curves in the plane, for Green coordinates: each edge an array (2 to 4, 2) of control points."""
        edges = [_points(edge, np.float64, 'edge', 2) for edge in edges]
        points = np.concatenate(edges) if edges else np.empty((0, 2))
        return Cage(_c.CAGEFORM_CURVES, points, _indices([len(edge) - 1 for edge in edges], 'edges'),
                    loops=None if loops is None else _indices(loops, 'loops'))

    @staticmethod
    def lattice(points, origin, axes, degree=3, falloff=0):
        """A box of splines: control points along each axis, a corner of the box, and its edges (dimension, dimension)."""
        axes = np.asarray(axes, dtype=np.float64)
        dimension = len(axes)
        if axes.shape not in ((2, 2), (3, 3)):
            raise ValueError('axes: an array (2, 2) or (3, 3), not %s' % (axes.shape,))
        points = list(np.broadcast_to(points, dimension))
        degree = list(np.broadcast_to(degree, dimension))
        origin = np.asarray(origin, dtype=np.float64)
        if origin.shape != (dimension,):
            raise ValueError('origin: %d numbers' % dimension)
        return Cage(_c.CAGEFORM_LATTICE, members={'points': points, 'degree': degree, 'origin': origin, 'axes': axes,
                                                  'falloff': falloff, 'dimension': dimension})

    @staticmethod
    def sites(points):
        """Points without a cage, for Sibson coordinates: (#sites, 2 or 3)."""
        return Cage(_c.CAGEFORM_SITES, _points(points, name='points'))

    @property
    def faces(self):
        """The faces of a mesh as an array (#F, corners), or a list of arrays if they have different numbers of corners."""
        if self.indices is None:
            return None
        counts = self.counts if self.counts is not None else np.full(len(self.indices) // 3, 3)
        if len(counts) and (counts == counts[0]).all():
            return self.indices.reshape(len(counts), counts[0])
        return np.split(self.indices, np.cumsum(counts)[:-1])

    def _describe(self):
        its = _struct(_c.cageform_cage, kind=self.kind)
        if self.vertices is not None:
            its.vertices = _view(self.vertices)
        for name, array in (('counts', self.counts), ('indices', self.indices), ('loops', self.loops)):
            setattr(its, name, _pointer(array))
        its.count_count = 0 if self.counts is None else len(self.counts)
        its.index_count = 0 if self.indices is None else len(self.indices)
        its.loop_count = 0 if self.loops is None else len(self.loops)
        for name, value in self.members.items():
            if name == 'axes':
                for k, axis in enumerate(value):
                    for n, number in enumerate(axis):
                        its.axes[k][n] = number
            elif name in ('points', 'degree', 'origin'):
                for k, number in enumerate(value):
                    getattr(its, name)[k] = number if name == 'origin' else int(number)
            else:
                setattr(its, name, value)
        return its


def check(cage):
    """Returns the faults and warnings of a cage, as Fault; an empty list if it can serve."""
    its, count = cage._describe(), ctypes.c_size_t(0)
    faults = (_c.cageform_fault * 2000)()
    code = _library.cageform_check(its, faults, len(faults), ctypes.byref(count))
    if code >= 1000 or code != 0 and count.value == 0:
        _check(code)
    return [_fault_of(fault) for fault in faults[:count.value]]


_SHAPES = {'figure': 0, 'hull': 1, 'box': 2}
_MIRRORS = {None: 0, 'x': 1, 'y': 2, 'z': 3}


def make_cage(points, indices, vertices=0, margin=0, shape='figure', mirror=None, radii=None, fill_tunnels=False,
              many_cages=False, regular=0, threads=None, progress=None):
    """Makes a cage around a figure, and returns it with a Report.

    points, indices  in space vertices (#V, 3) and triangles (#F, 3); in the plane ends (#V, 2) and segments (#S, 2)
    vertices         0: 24 in the plane, 112 in space
    margin           as a share of the figure's diagonal; 0: 0.025 in the plane, 0.02 in space
    shape            'figure', 'hull' or 'box'
    mirror           'x', 'y', 'z': the cage is symmetric along this axis
    radii            in the plane half the width of each segment
    """
    points = _points(points)
    indices = _indices(indices, 'indices')
    figure = _struct(_c.cageform_drawing, points=_view(points), indices=_pointer(indices), index_count=len(indices))
    if radii is not None:
        radii = np.ascontiguousarray(radii, dtype=np.float64)
        if radii.shape != (len(indices) // 2,):
            raise ValueError('radii: one number for each of %d segments' % (len(indices) // 2))
        figure.radii = _pointer(radii, ctypes.c_double)
    options = _struct(_c.cageform_make_cage_options, vertices=vertices, margin=margin, shape=_choice(_SHAPES, shape, 'shape'),
                      mirror=_choice(_MIRRORS, mirror, 'mirror'), fill_tunnels=int(fill_tunnels), many_cages=int(many_cages),
                      regular=regular)
    report = Report()
    running, raised = _running(threads, progress)
    made = _Object(_call(_library.cageform_make_cage, figure, options, running, report=report, raised=raised))
    its = _struct(_c.cageform_cage)
    _check(_library.cageform_made_cage_describe(made._handle, its))
    take = lambda pointer, count: np.ctypeslib.as_array(pointer, (count,)).copy() if count else None
    corners = np.ctypeslib.as_array(ctypes.cast(its.vertices.data, ctypes.POINTER(ctypes.c_double)),
                                    (its.vertices.count, its.vertices.dimension)).copy()
    return Cage(its.kind, corners, take(its.counts, its.count_count), take(its.indices, its.index_count)), report


def _choice(choices, given, name):
    if given not in choices:
        raise ValueError('%s: one of %s, not %r' % (name, ', '.join(repr(c) for c in choices), given))
    return choices[given]


# ---- coordinates and bindings ------------------------------------------------------------------------------------------

_TYPES = {'mean-value': 0, 'harmonic': 1, 'green': 2, 'sibson': 3, 'barycentric': 4, 'wachspress': 5, 'discrete-harmonic': 6,
          'splines': 7}
_OUTSIDE = {'extend': 0, 'keep_in_place': 1, 'nearest_boundary': 2}


class Coordinates(_Object):
    """Coordinates of a cage.

    kind      'mean-value', 'harmonic', 'green', 'sibson' (degree 1, or 3: smooth at the sites), 'barycentric', 'wachspress',
              'discrete-harmonic'; 'splines' of a lattice, which is the default there
    dtype     of weights, poses and clones
    accuracy  harmonic: the largest error of a weight, 1e-5 to 0.1
    disk      Green on curves: (x, y, radius)

    report, handles (their number, vectors among them), vertices, dimension, has_weights_outside, has_gradients
    """

    def __init__(self, cage, kind=None, dtype=np.float64, accuracy=0, memory_limit=0, degree=1, disk=None):
        default = 'splines' if cage.kind == _c.CAGEFORM_LATTICE else 'sibson' if cage.kind == _c.CAGEFORM_SITES else \
            'green' if cage.kind == _c.CAGEFORM_CURVES else 'mean-value'
        options = _struct(_c.cageform_coordinates_options, type=_choice(_TYPES, kind or default, 'kind'),
                          scalar=_scalar_of(dtype), accuracy=accuracy, memory_limit=memory_limit, sibson_degree=degree)
        for k, number in enumerate(disk or ()):
            options.disk[k] = number
        self.report, self.cage, self.dtype = Report(), cage, np.dtype(dtype)
        super().__init__(_call(_library.cageform_coordinates_create, cage._describe(), options, report=self.report))
        info = _struct(_c.cageform_coordinates_info)
        _check(_library.cageform_coordinates_describe(self._handle, info))
        self.handles, self.vertices, self.dimension = info.handles, info.vertices, info.dimension
        self.has_weights_outside, self.has_gradients = bool(info.has_weights_outside), bool(info.has_gradients)

    def rest(self):
        """The handles at rest: (#handles, dimension)."""
        out = np.empty((self.handles, self.dimension), self.dtype)
        _check(_library.cageform_coordinates_rest(self._handle, _view(out, _c.cageform_output)))
        return out

    def solve(self, threads=None, progress=None):
        """Solves for harmonic functions and keeps them, so that several binds solve only once. Returns a Report."""
        report = Report()
        running, raised = _running(threads, progress)
        code = _library.cageform_coordinates_solve(self._handle, running, report._c)
        if raised:
            raise raised[0]
        _check(code, report)
        return report

    def bind(self, points, normals=None, tangents=None, outside='extend', falloff=0, leave_linear_precision=False,
             threads=None,
             progress=None):
        """Binds points (#points, dimension), and normals and tangents of as many rows (tangents in space, of 3 or 4 numbers).
        Bad points are listed and kept in place. `outside`: 'extend', 'keep_in_place', 'nearest_boundary'; displacements
        outside fade to nothing at the distance `falloff`, if it is not 0. `progress(done)` may return False to cancel."""
        points = _points(points, dimension=self.dimension)
        more = [None if array is None else _points(array, name=name) for array, name in
                ((normals, 'normals'), (tangents, 'tangents'))]
        options = _struct(_c.cageform_bind_options, outside=_choice(_OUTSIDE, outside, 'outside'),
                          leave_linear_precision=int(leave_linear_precision), falloff=falloff)
        report = Report()
        running, raised = _running(threads, progress)
        handle = _call(_library.cageform_bind, self._handle, _view(points), *(None if a is None else _view(a) for a in more),
                       options, running, report=report, raised=raised)
        return Binding(handle, self, len(points), report)


class Binding(_Object):
    """A figure with all its weights. `report`; `figure`, to be cloned; lists of points as arrays of indices: `on_boundary`,
    `outside`, `not_finite`, `unreached`, `not_restored`, `faded`."""

    def __init__(self, handle, coordinates, points, report):
        super().__init__(handle)
        self.report, self.points, self.handles, self.dtype = report, points, coordinates.handles, coordinates.dtype
        self._dimension = coordinates.dimension
        self.figure = self._figure()

    def _figure(self):
        return Figure(_call(_library.cageform_binding_figure, self._handle), self)

    def __getattr__(self, name):
        lists = ('on_boundary', 'outside', 'not_finite', 'unreached', 'not_restored', 'faded')
        if name not in lists:
            raise AttributeError(name)
        count = ctypes.c_size_t(0)
        _check(_library.cageform_binding_list(self._handle, lists.index(name), None, 0, ctypes.byref(count)))
        out = np.empty(count.value, np.uintp)
        _check(_library.cageform_binding_list(self._handle, lists.index(name), _pointer(out, ctypes.c_size_t), len(out),
                                              ctypes.byref(count)))
        return out.astype(np.intp)

    def weights(self, first=0, count=None):
        """The weights of points: (count, #handles)."""
        count = self.points - first if count is None else count
        out = np.empty((max(count, 0), self.handles), self.dtype)
        _check(_library.cageform_binding_weights(self._handle, first, count, out.ctypes.data, out.nbytes))
        return out

    def set_labels(self, labels):
        """Labels the handles: a str or None for each. They are packed with the figure."""
        texts = (ctypes.c_char_p * max(len(labels), 1))(*[None if label is None else label.encode() for label in labels])
        _check(_library.cageform_binding_set_labels(self._handle, ctypes.cast(texts, ctypes.c_void_p), len(labels)))
        self.figure = self._figure()

    def pack(self, tolerance=0, threshold=0, largest=0, reach=0, poses=None, format='smallest', clips=None, levels=(),
             threads=None, progress=None):
        """Packs the figure for open, and for games.

        tolerance  the largest distance of a point from where all weights put it; 0: no limit
        threshold  weights below may be dropped; with all three 0, nothing is
        largest    how many weights a point keeps
        poses      (#poses, #handles, dimension): where the tolerance holds; else within `reach` of affine poses
        format     of weights: 'smallest', 'scalar', 'half', 'int16', 'int8'
        clips      a dict of names and Clips
        levels     packed figures of less detail, of the same handles

        Returns the bytes as a numpy array of uint8, aligned to 64 bytes, and a Report. Its tofile() writes a file.
        """
        formats = {'smallest': 0, 'scalar': 1, 'half': 2, 'int16': 3, 'int8': 4}
        options = _struct(_c.cageform_pack_options, tolerance=tolerance, threshold=threshold, largest=largest, reach=reach,
                          format=_choice(formats, format, 'format'))
        if poses is not None:
            poses = np.ascontiguousarray(poses)
            if poses.ndim != 3:
                raise ValueError('poses: an array (#poses, #handles, dimension), not %s' % (poses.shape,))
            poses = _points(poses.reshape(-1, poses.shape[2]), name='poses')
            options.poses = _view(poses)
        part_of = lambda name, data: _c.cageform_part(name, data.ctypes.data, data.nbytes)
        clips = {name: clip.bytes for name, clip in (clips or {}).items()}
        levels = [np.asarray(level) for level in levels]
        own_clips = (_c.cageform_part * max(len(clips), 1))(*[part_of(n.encode(), data) for n, data in clips.items()])
        own_levels = (_c.cageform_part * max(len(levels), 1))(*[part_of(None, data) for data in levels])
        options.clips, options.clip_count = own_clips, len(clips)
        options.levels, options.level_count = own_levels, len(levels)
        report = Report()
        running, raised = _running(threads, progress)
        return _bytes_of(_call(_library.cageform_pack, self._handle, options, running, report=report, raised=raised)), report


def _bytes_of(handle):
    """Returns an object's bytes as an array that keeps it."""
    owner = _Object(handle)
    data, size = ctypes.c_void_p(), ctypes.c_size_t()
    _check(_library.cageform_bytes_view(handle, ctypes.byref(data), ctypes.byref(size)))

    class Memory:
        __array_interface__ = {'shape': (size.value,), 'typestr': '|u1', 'data': (data.value, True), 'version': 3}
        keeps = owner

    return np.asarray(Memory())


class Figure(_Object):
    """A figure that is cloned with poses of its handles: of a Binding, or by open.

    points, handles, vertices (handles that are points), dimension, dtype, has_normals, has_tangents, clips (their number),
    levels
    """

    def __init__(self, handle, *keeps):
        super().__init__(handle, *keeps)
        info = _struct(_c.cageform_figure_info)
        _check(_library.cageform_figure_describe(self._handle, info))
        for name in ('points', 'handles', 'vertices', 'dimension', 'clips', 'levels'):
            setattr(self, name, getattr(info, name))
        self.dtype = np.dtype((np.float32, np.float64)[info.scalar])
        self.has_normals, self.has_tangents = bool(info.has_normals), bool(info.has_tangents)

    def rest(self):
        """The handles at rest: (#handles, dimension)."""
        out = np.empty((self.handles, self.dimension), self.dtype)
        _check(_library.cageform_figure_rest(self._handle, _view(out, _c.cageform_output)))
        return out

    def labels(self):
        """The labels of the handles; '' for those without."""
        listed = []
        for handle in range(self.handles):
            text, length = ctypes.c_void_p(), ctypes.c_size_t()
            _check(_library.cageform_figure_label(self._handle, handle, ctypes.byref(text), ctypes.byref(length)))
            listed.append(ctypes.string_at(text, length.value).decode() if length.value else '')
        return listed

    def level(self, level):
        """Opens a level of less detail, which takes the same poses."""
        return Figure(_call(_library.cageform_open_level, self._handle, level, None), self)

    def clone(self, pose, out=None, normals=False, tangents=False, threads=1):
        """Moves the figure with a pose (#handles, dimension): returns points, or a tuple of points, normals and tangents (4
        numbers: the fourth is the handedness). `out` is written instead of a new array. At rest the points come back to the
        bit."""
        pose = _points(pose, self.dtype, 'pose', self.dimension)
        points, back = _output(out, (self.points, self.dimension), self.dtype)
        turned = np.empty_like(points, order='C') if normals or tangents else None
        along = np.empty((self.points, 4), self.dtype) if tangents else None
        view = lambda array: None if array is None else _view(array, _c.cageform_output)
        running = None if threads == 1 else _running(threads, None)[0]
        _check(_library.cageform_clone(self._handle, _view(pose), view(points), view(turned), view(along), running))
        if back is not None:
            back[...] = points
            points = back
        return points if turned is None else (points, turned) if along is None else (points, turned, along)

    def gradients(self, of_points, out=None, threads=1):
        """The transpose of clone: gradients of a function of the points (#points, dimension) to those of handles."""
        of_points = _points(of_points, self.dtype, 'of_points', self.dimension)
        handles, back = _output(out, (self.handles, self.dimension), self.dtype)
        running = None if threads == 1 else _running(threads, None)[0]
        _check(_library.cageform_clone_transposed(self._handle, _view(of_points), _view(handles, _c.cageform_output), running))
        if back is not None:
            back[...] = handles
        return handles if back is None else back

    def pose_handles(self, vertices):
        """A pose of all handles from one of the cage's vertices; Green coordinates need it, others take either."""
        vertices = _points(vertices, self.dtype, 'vertices', self.dimension)
        out = np.empty((self.handles, self.dimension), self.dtype)
        _check(_library.cageform_pose_handles(self._handle, _view(vertices), _view(out, _c.cageform_output)))
        return out

    def clip(self, clip):
        """Plays a clip, by number or name."""
        if isinstance(clip, str):
            found, name = ctypes.c_size_t(), clip.encode()
            _check(_library.cageform_figure_find_clip(self._handle, name, len(name), ctypes.byref(found)))
            if found.value == ctypes.c_size_t(-1).value:
                raise KeyError(clip)
            clip = found.value
        return Clip(_call(_library.cageform_play, self._handle, clip, None), None, self)


def _aligned(source):
    """Returns the bytes of a file, which is mapped, or of memory, at a multiple of 64."""
    if isinstance(source, (str, os.PathLike)):
        data = np.memmap(source, mode='r') if os.path.getsize(source) else np.empty(0, np.uint8)
    else:
        data = np.frombuffer(source, np.uint8)
    if data.ctypes.data % 64 == 0:
        return data
    memory = np.empty(len(data) + 64, np.uint8)
    start = -memory.ctypes.data % 64
    memory[start:start + len(data)] = data
    return memory[start:start + len(data)]


def open(source, skip_checksum=False):
    """Opens a packed figure: the path of a file, which is mapped, or bytes. Copies only what is not aligned to 64 bytes."""
    data = _aligned(source)
    options = _struct(_c.cageform_open_options, skip_checksum=int(skip_checksum))
    handle, culprit = ctypes.c_void_p(), ctypes.c_size_t()
    code = _library.cageform_open(data.ctypes.data, len(data), options, ctypes.byref(handle), ctypes.byref(culprit))
    if code != 0:
        part = culprit.value.to_bytes(4, 'little').decode('ascii', 'replace') if culprit.value else None
        text = _library.cageform_status_text(code).decode()
        raise errors._by_code[code](text + (' (part %s)' % part if part else ''), part)
    return Figure(handle, data)


# ---- clips and pins ----------------------------------------------------------------------------------------------------

class Clip(_Object):
    """The motion of a cage: `begin`, `end`, `vertices`, `name`; `bytes` if compile_clip made it."""

    def __init__(self, handle, data, *keeps):
        super().__init__(handle, data, *keeps)
        info = _struct(_c.cageform_clip_info)
        _check(_library.cageform_player_describe(self._handle, info))
        self.begin, self.end, self.vertices, self.bytes = info.begin, info.end, info.vertices, data
        self.name = info.name[:info.name_length].decode() if info.name else None
        self._shape, self._dtype = (info.vertices, info.dimension), np.dtype((np.float32, np.float64)[info.scalar])

    def sample(self, time, out=None):
        """The cage's vertices at a time: (#vertices, dimension)."""
        pose, back = _output(out, self._shape, self._dtype)
        _check(_library.cageform_player_sample(self._handle, time, _view(pose, _c.cageform_output)))
        if back is not None:
            back[...] = pose
        return pose if back is None else back


def compile_clip(times, poses, tolerance=0, pack_tolerance=0, keys='smooth', before='stay', after='stay', dtype=np.float32,
                 threads=None, progress=None):
    """Compiles poses of the cage's vertices (#times, #vertices, dimension) at ascending times to a Clip, and returns it with
    a Report.

    tolerance       the largest error of a coordinate; 0: a thousandth of the poses' size or less
    pack_tolerance  the largest distance that curves in 16 bits may cost; 0: they stay exact
    keys            how poses are joined: 'smooth', 'linear', 'hold'
    before, after   'stay', 'straight_on', 'cycle', 'cycle_with_offset', 'ping_pong'
    """
    times = np.ascontiguousarray(times, dtype=np.float64).ravel()
    poses = np.asarray(poses)
    if poses.ndim != 3 or len(poses) != len(times):
        raise ValueError('poses: an array (%d, #vertices, dimension), not %s' % (len(times), poses.shape))
    listed = _points(poses.reshape(-1, poses.shape[2]), name='poses')
    ends = {'stay': 0, 'straight_on': 1, 'cycle': 2, 'cycle_with_offset': 3, 'ping_pong': 4}
    options = _struct(_c.cageform_clip_options, tolerance=tolerance, pack_tolerance=pack_tolerance,
                      keys=_choice({'smooth': 0, 'linear': 1, 'hold': 2}, keys, 'keys'),
                      before=_choice(ends, before, 'before'), after=_choice(ends, after, 'after'), scalar=_scalar_of(dtype))
    report = Report()
    running, raised = _running(threads, progress)
    data = _bytes_of(_call(_library.cageform_compile_clip, _pointer(times, ctypes.c_double), len(times), _view(listed), options,
                           running, report=report, raised=raised))
    return Clip(_call(_library.cageform_play_bytes, data.ctypes.data, len(data), None), data), report


class Samples(_Object):
    """Samples of the inside of a cage, by which pins move it: made once, of coordinates that have gradients.

    samples    about how many; 0: 16 a handle, at least 4,000
    rotations  how many turn on their own; 0: by the number of handles
    smoothing  spreads bends over this share of the cage's size

    handles, dimension, dtype; report
    """

    def __init__(self, coordinates, samples=0, rotations=0, smoothing=0, threads=None, progress=None):
        options = _struct(_c.cageform_samples_options, samples=samples, rotations=rotations, smoothing=smoothing)
        report = Report()
        running, raised = _running(threads, progress)
        self._adopt(_call(_library.cageform_pose_samples, coordinates._handle, options, running, report=report, raised=raised),
                    report)

    def _adopt(self, handle, report):
        _Object.__init__(self, handle)
        info = _struct(_c.cageform_samples_info)
        _check(_library.cageform_samples_describe(self._handle, info))
        self.handles, self.dimension, self.report = info.handles, info.dimension, report
        self.dtype = np.dtype((np.float32, np.float64)[info.scalar])

    def pack(self):
        """Returns the bytes as a numpy array of uint8; open_samples reads them."""
        report = Report()
        return _bytes_of(_call(_library.cageform_samples_pack, self._handle, report=report))


def open_samples(source, skip_checksum=False):
    """Opens packed samples: the path of a file, or bytes."""
    data = _aligned(source)
    handle = ctypes.c_void_p()
    _check(_library.cageform_samples_open(data.ctypes.data, len(data), int(skip_checksum), ctypes.byref(handle)))
    samples = Samples.__new__(Samples)
    samples._adopt(handle, None)
    return samples


class Pins(_Object):
    """Moves a cage by pins on a figure, as rigidly as possible inside.

        pins = cageform.Pins(cageform.Samples(coordinates))
        pins.set(binding.figure, [12, 40])            # numbers of points
        pose, report = pins.solve(targets, pose)      # again until report.settled

    pin_weight  what a pin counts beside the stretch of the whole figure; 0: 1e4
    hard        pins miss a thousand times less
    iterations  of a frame; 0: 4
    """

    def __init__(self, samples, pin_weight=0, hard=False, iterations=0):
        own = _struct(_c.cageform_pins_options, pin_weight=pin_weight, hard=int(hard), iterations=iterations)
        super().__init__(_call(_library.cageform_pins_create, samples._handle, own))
        self.dimension, self.dtype = samples.dimension, samples.dtype

    def set(self, figure, points, weights=None):
        """Pins points of a figure, instead of those before. The pose stays."""
        points, report = _indices(points, 'points'), Report()
        if weights is not None:
            weights = np.ascontiguousarray(weights, dtype=np.float64)
            if weights.shape != points.shape:
                raise ValueError('weights: one for each of %d pins' % len(points))
        _check(_library.cageform_pins_set(self._handle, figure._handle, _pointer(points), len(points),
                                          _pointer(weights, ctypes.c_double), report._c), report)

    def hold(self, handles):
        """Holds handles where the pose has them."""
        handles, report = _indices(handles, 'handles'), Report()
        _check(_library.cageform_pins_hold(self._handle, _pointer(handles), len(handles), report._c), report)

    def solve(self, targets, pose):
        """A frame: moves a copy of the pose (#handles, dimension) towards the targets (#pins, dimension). Returns the pose
        and a Report with miss, step, settled, folded, least_stretch, largest_stretch."""
        targets = _points(targets, self.dtype, 'targets', self.dimension)
        pose = np.array(pose, dtype=self.dtype, order='C')
        if pose.ndim != 2 or pose.shape[1] != self.dimension:
            raise ValueError('pose: an array (#handles, %d), not %s' % (self.dimension, pose.shape))
        report = Report()
        _check(_library.cageform_pins_solve(self._handle, _view(targets), _view(pose, _c.cageform_output), report._c), report)
        return pose, report
