"""The places of the headers that can be changed, found by libclang, and headers with changes: for run.py."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADERS = ROOT / "include" / "cageform"
EIGEN = ["-isystem", "/usr/include/eigen3"]
OPERATORS = {"&&": "||", "||": "&&", "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==",
             "+": "-", "-": "+", "*": "/", "/": "*"}

class Mutant:
    """The text of a header from begin to end, in bytes, and the C++ that stands there instead: `code`, with N
    for the number and {} for the original, in which other mutants may lie."""

    def __init__(self, path, begin, end, code, what):
        self.path, self.begin, self.end, self.code, self.what = path, begin, end, code, what
        self.folder = path.relative_to(HEADERS).parts[0]
        self.number = 0

    def found_in(self, text):
        """Names the place, from the text of the header."""
        before = text[:self.begin]
        self.line = before.count(b"\n") + 1
        self.place = f"{self.path.relative_to(HEADERS)}:{self.line}"
        self.column = self.begin - before.rfind(b"\n")
        return self

    def key(self):
        return (self.path, self.begin, -self.end, self.what)


class Finder:
    """All places of the headers that can be changed, and the beginnings of all functions."""

    def __init__(self):
        from clang import cindex  # installed by now
        self.kinds = cindex.CursorKind
        self.cindex = cindex
        self.texts = {}
        self.found, self.functions = [], []
        self.find()

    def find(self):
        index = self.cindex.Index.create()
        headers = sorted(str(p.relative_to(ROOT / "include")) for p in HEADERS.rglob("*.hpp"))
        source = "".join(f"#include <{header}>\n" for header in headers)
        record = self.cindex.TranslationUnit.PARSE_DETAILED_PROCESSING_RECORD
        flags = ["-std=c++20", "-I", str(ROOT / "include"), *EIGEN]
        unit = index.parse("all.cpp", flags, [("all.cpp", source)], record)
        errors = [str(d) for d in unit.diagnostics if d.severity >= self.cindex.Diagnostic.Error]
        if errors:
            sys.exit("\n".join(errors))
        self.macros = {}
        inside = [c for c in unit.cursor.get_children()
                  if c.location.file and c.location.file.name.startswith(str(HEADERS))]
        for cursor in inside:
            if cursor.kind == self.kinds.MACRO_INSTANTIATION:
                extent = (cursor.extent.start.offset, cursor.extent.end.offset)
                self.macros.setdefault(cursor.location.file.name, []).append(extent)
        for cursor in inside:
            if cursor.kind.is_declaration():
                self.declarations(cursor)
        unique = {m.key(): m for m in self.found}
        self.found = [unique[key] for key in sorted(unique)]

    def text(self, path):
        if path not in self.texts:
            self.texts[path] = pathlib.Path(path).read_bytes()
        return self.texts[path]

    def add(self, cursor, code, what, begin=None, end=None):
        path = cursor.extent.start.file.name
        begin = cursor.extent.start.offset if begin is None else begin
        end = cursor.extent.end.offset if end is None else end
        text = self.text(path)[begin:end]
        if b"//" in text or b"/*" in text or text.startswith(b"{"):
            return
        if any(a < end and begin < b for a, b in self.macros.get(path, [])):
            return
        self.found.append(self.mutant(path, begin, end, code, " ".join(what.split())))

    def mutant(self, path, begin, end, code, what):
        return Mutant(pathlib.Path(path), begin, end, code, what).found_in(self.text(path))

    def source(self, cursor):
        begin, end = cursor.extent.start, cursor.extent.end
        return self.text(begin.file.name)[begin.offset:end.offset].decode()

    def declarations(self, cursor):
        kinds = self.kinds
        if cursor.kind in (kinds.FUNCTION_DECL, kinds.CXX_METHOD, kinds.CONSTRUCTOR, kinds.DESTRUCTOR,
                           kinds.FUNCTION_TEMPLATE, kinds.CONVERSION_FUNCTION):
            result = cursor.result_type.spelling.split("::")[-1]
            after_member = False
            for child in cursor.get_children():
                if child.kind == kinds.COMPOUND_STMT or after_member and child.kind.is_expression():
                    self.body(child, result)
                if child.kind == kinds.COMPOUND_STMT and len(list(child.get_children())) > 1:
                    begin = child.extent.start.offset + 1
                    self.functions.append(self.mutant(child.extent.start.file.name, begin, begin,
                                                      " (void)cageform_mutant(N); {}", cursor.spelling))
                after_member = child.kind == kinds.MEMBER_REF
        elif cursor.kind in (kinds.NAMESPACE, kinds.CLASS_DECL, kinds.STRUCT_DECL, kinds.CLASS_TEMPLATE,
                             kinds.CLASS_TEMPLATE_PARTIAL_SPECIALIZATION):
            for child in cursor.get_children():
                self.declarations(child)

    def body(self, cursor, result):
        """Adds what a statement or an expression offers, and goes on with its parts, but for constants."""
        kinds, kind = self.kinds, cursor.kind
        if not cursor.extent.start.file:  # made by the compiler
            return
        children = list(cursor.get_children())
        if kind == kinds.LAMBDA_EXPR:
            result = ""
            children = [c for c in children if c.kind == kinds.COMPOUND_STMT]
        elif kind == kinds.VAR_DECL:
            head = self.text(cursor.location.file.name)[cursor.extent.start.offset:cursor.location.offset]
            if b"constexpr" in head or b"static" in head:
                return
            children = [c for c in children if c.extent.start.offset > cursor.location.offset]
        elif kind in (kinds.DECL_REF_EXPR, kinds.STATIC_ASSERT, kinds.TYPE_REF, kinds.TEMPLATE_REF,
                      kinds.PARM_DECL, kinds.TYPE_ALIAS_DECL, kinds.CONCEPT_SPECIALIZATION_EXPR,
                      kinds.REQUIRES_EXPR):
            return
        elif kind == kinds.MEMBER_REF_EXPR:
            children = [c for c in children if c.extent.start.offset == cursor.extent.start.offset]
        elif kind == kinds.CASE_STMT:
            children = children[1:]
        elif kind == kinds.STRUCT_DECL:
            return self.declarations(cursor)
        elif kind in (kinds.IF_STMT, kinds.WHILE_STMT, kinds.CONDITIONAL_OPERATOR):
            if re.match(r"if\s+constexpr", self.source(cursor)):
                children = children[1:]
            else:
                self.condition(cursor, children)
        elif kind in (kinds.BINARY_OPERATOR, kinds.CALL_EXPR) and len(children) > 1:
            self.operator(cursor, children)
        elif kind in (kinds.INTEGER_LITERAL, kinds.CXX_BOOL_LITERAL_EXPR):
            self.literal(cursor)
        elif kind == kinds.RETURN_STMT and children:
            value = self.source(children[0])
            if result == "bool" and value not in ("true", "false"):
                self.add(children[0], "(cageform_mutant(N) != static_cast<bool>({}))", f"return !({value})")
            elif result == "Status" and value != "Status::ok":
                self.add(children[0], "(cageform_mutant(N) ? Status::ok : ({}))", f"Status::ok, not {value}")
        if kind in (kinds.COMPOUND_STMT, kinds.IF_STMT, kinds.FOR_STMT, kinds.CXX_FOR_RANGE_STMT):
            for child in children if kind == kinds.COMPOUND_STMT else children[-2:]:
                self.statement(child)
        for child in children:
            self.body(child, result)

    def condition(self, cursor, children):
        text = self.text(cursor.extent.start.file.name)
        for child in children[:2]:
            begin, end = child.extent.start.offset, child.extent.end.offset
            ternary = cursor.kind == self.kinds.CONDITIONAL_OPERATOR
            before, after = text[:begin].rstrip()[-1:], text[end:end + 20].lstrip()[:1]
            if ternary or (before in b"(;" and after == b")"):
                code = "(cageform_mutant(N) != static_cast<bool>({}))"
                return self.add(child, code, f"!({self.source(child)})")

    def operator(self, cursor, children):
        """An operator of any type is what stands between two parts, and nothing else."""
        path = cursor.extent.start.file.name
        first, last = children[0].extent, children[-1].extent
        if first.start.offset != cursor.extent.start.offset or last.end.offset != cursor.extent.end.offset:
            return
        between = self.text(path)[first.end.offset:last.start.offset]
        sign = between.decode().strip()
        if sign in OPERATORS:
            left, right = self.source(children[0]), self.source(children[-1])
            changed = f"{left} {OPERATORS[sign]} {right}"
            self.add(cursor, f"(cageform_mutant(N) ? ({changed}) : ({{}}))", f"{changed}, not {sign}")

    def literal(self, cursor):
        text, value = self.text(cursor.extent.start.file.name), self.source(cursor)
        before, after = text[cursor.extent.start.offset - 1:][:1], text[cursor.extent.end.offset:][:1]
        number = re.fullmatch(r"(\d+)([uUlL]*)", value)
        if before == b"<" or after == b">":  # of a template
            return
        if number:
            changed = "0" if number[1] == "1" else str(int(number[1]) + 1)
            self.add(cursor, f"(cageform_mutant(N) ? {changed}{number[2]} : {{}})", f"{changed}, not {value}")
        elif value in ("true", "false"):
            self.add(cursor, "(cageform_mutant(N) != {})", f"not {value}")

    def statement(self, cursor):
        """A statement without a value can go."""
        text, end = self.text(cursor.extent.start.file.name), cursor.extent.end.offset
        value = self.source(cursor)
        is_call = re.search(r"\)$", value) and not re.match(r"(return|if|for|while|switch|do|else)\b", value)
        kinds = self.kinds
        assigns = cursor.kind in (kinds.COMPOUND_ASSIGNMENT_OPERATOR, kinds.UNARY_OPERATOR) or (
            cursor.kind in (kinds.BINARY_OPERATOR, kinds.CALL_EXPR) and re.search(r"[^=<>!]=[^=]", value))
        if text[end:end + 1] == b";" and cursor.kind.is_expression() and (is_call or assigns):
            self.add(cursor, "{{ if (!cageform_mutant(N)) {{ {} }} }}", f"no {value};", end=end + 1)


def rewritten(text, mutants):
    """The text of a header with its mutants; lines stay where they are."""

    def rest(begin, end, inner):
        result, at = "", begin
        while inner:
            head, inner = inner[0], inner[1:]
            nested = [m for m in inner if m.end <= head.end]
            inner = inner[len(nested):]
            result += text[at:head.begin].decode()
            original = rest(head.begin, head.end, nested)
            code = head.code.replace("mutant(N)", f"mutant({head.number})")
            code = code.replace("{{", "\1").replace("}}", "\2").replace("{}", original)
            lines = text[head.begin:head.end].count(b"\n")
            result += code.replace("\1", "{").replace("\2", "}").replace("\n", " ") + "\n" * lines
            at = head.end
        return result + text[at:end].decode()

    return rest(0, len(text), sorted(mutants, key=Mutant.key))
