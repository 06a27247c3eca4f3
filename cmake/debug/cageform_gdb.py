# Pretty printers of cageform for gdb. In ~/.gdbinit or at the gdb prompt:
#     source PREFIX/share/cageform/cageform_gdb.py
# Types are matched without the inline namespace, so that all settings work.
import re

import gdb
import gdb.printing


def short(value):
    """Returns the name of an enumerator without namespaces, or its number if it has no name."""
    for field in value.type.strip_typedefs().fields():
        if field.enumval == int(value):
            return field.name.rsplit("::", 1)[-1]
    return str(int(value))


def size_of(vector):
    """Returns the size of a std::vector, of libstdc++ or libc++."""
    try:
        begin, end = vector["_M_impl"]["_M_start"], vector["_M_impl"]["_M_finish"]
    except gdb.error:
        begin, end = vector["__begin_"], vector["__end_"]
    return int(end - begin)


class Vec:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        first, last = self.value["v"].type.range()
        return "(" + ", ".join(str(self.value["v"][k]) for k in range(first, last + 1)) + ")"


class Enumerator:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        return short(self.value)


class Buffer:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        return "%d elements" % int(self.value["size_"])

    def children(self):
        element = self.value.type.strip_typedefs().template_argument(0)
        data = self.value["data_"].cast(element.pointer())
        for n in range(int(self.value["size_"])):
            yield "[%d]" % n, data[n]

    def display_hint(self):
        return "array"


class StridedPoints:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        return "%d points" % int(self.value["size_"])

    def children(self):
        arguments = self.value.type.strip_typedefs()
        scalar, dimension = arguments.template_argument(0), int(arguments.template_argument(1))
        byte = gdb.lookup_type("char").pointer()
        data, stride, axis = (self.value[m] for m in ("data_", "point_stride_", "axis_stride_"))
        for n in range(int(self.value["size_"])):
            places = [(data.cast(byte) + n * stride + k * axis).cast(scalar.pointer()) for k in range(dimension)]
            yield "[%d]" % n, "(" + ", ".join(str(place.dereference()) for place in places) + ")"

    def display_hint(self):
        return "array"


class Bound:
    """Prints a value by the numbers of its points and handles; `counts` of the types below computes them."""

    def __init__(self, value):
        self.value = value

    def to_string(self):
        return "%d points, %d handles" % self.counts()


class Binding(Bound):
    def counts(self):
        return int(self.value["point_count_"]), size_of(self.value["rest_handles_"])

    def children(self):
        yield "rest_handles", self.value["rest_handles_"]


class BindingView(Bound):
    def counts(self):
        return int(self.value["weights"]["points"]), int(self.value["weights"]["rows"])


class PackedBindingView(Bound):
    def counts(self):
        return int(self.value["points"]), int(self.value["handles"])

    def to_string(self):
        return Bound.to_string(self) + ", " + short(self.value["format"])


class Polygon:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        loops, status = int(self.value["loops_"]["size_"]), short(self.value["status_"])
        return "%d vertices, %d loops, %s" % (size_of(self.value["vertices_"]), loops, status)

    def children(self):
        yield "vertices", self.value["vertices_"]


class TriangleMesh:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        return "%d vertices, %d faces" % (size_of(self.value["vertices_"]), size_of(self.value["faces_"]))

    def children(self):
        yield "vertices", self.value["vertices_"]
        yield "faces", self.value["faces_"]


class Printers(gdb.printing.PrettyPrinter):
    known = {
        "Vec": Vec,
        "Status": Enumerator,
        "PointState": Enumerator,
        "WeightFormat": Enumerator,
        "Buffer": Buffer,
        "StridedPoints": StridedPoints,
        "Binding": Binding,
        "BindingView": BindingView,
        "PackedBindingView": PackedBindingView,
        "Polygon": Polygon,
        "TriangleMesh": TriangleMesh,
    }

    def __call__(self, value):
        name = value.type.unqualified().strip_typedefs().tag or ""
        found = re.match(r"cageform::v\w+::(\w+)(<|$)", name)
        return self.known[found.group(1)](value) if found and found.group(1) in self.known else None


gdb.printing.register_pretty_printer(None, Printers("cageform"), replace=True)
