"""Reads the C header of the library: its structs, constants, statuses and functions, for bindings of other languages.

    python3 read_header.py ../../include/cageform/c/cageform.h cageform/_c.py    writes declarations for ctypes
"""

import re
import sys

NUMBERS = {'size_t': 'c_size_t', 'uint32_t': 'c_uint32', 'int32_t': 'c_int32', 'uint64_t': 'c_uint64', 'double': 'c_double',
           'int': 'c_int', 'char': 'c_char', 'cageform_status': 'c_int32'}


class Header:
    """structs: name to [(field, type, [lengths])]; functions: name to (type, [(name, type)]); constants: name to
    number; statuses: [(number, name, text or None)]. A type is the text of C without const and names."""

    def __init__(self, text):
        self.statuses = [(int(n), name, own) for n, name, own in re.findall(
            r'X\((\d+), [A-Z0-9_]+, ([a-z0-9_]+)(?:,[\s\\]*"([^"]*)")?\)', text)]
        text = re.sub(r'/\*.*?\*/', '', text, flags=re.S)
        text = re.sub(r'^\s*#.*(?:\\\n.*)*$', '', text, flags=re.M)
        self.constants = {name: int(number) for name, number in re.findall(r'\b(CAGEFORM_\w+) = (\d+)', text)}
        self.structs = {}
        for name, body in re.findall(r'typedef struct (\w+) \{(.*?)\} \1;', text, flags=re.S):
            self.structs[name] = [field for line in body.split(';') for field in fields_of(line)]
        self.functions = {}
        for kind, name, arguments in re.findall(r'CAGEFORM_API ([\w \*]+?)(\w+)\((.*?)\);', text, flags=re.S):
            listed = [] if arguments.strip() == 'void' else [typed(a)[:2] for a in arguments.split(',')]
            self.functions[name] = (plain(kind), [(n, t) for n, t in listed])


def plain(kind):
    return re.sub(r'\s+', ' ', re.sub(r'\bconst\b', '', kind)).strip().replace(' *', '*')


def typed(text):
    """Returns name, type and lengths of a declaration."""
    text = re.sub(r'\s+', ' ', text).strip()
    if '(*' in text:
        return re.search(r'\(\*(\w+)\)', text).group(1), 'function', []
    kind, name, lengths = re.fullmatch(r'(.*?)(\w+)((?:\[\d+\])*)', text).groups()
    return name, plain(kind), [int(n) for n in re.findall(r'\d+', lengths)]


def fields_of(line):
    """Returns the fields of a line of a struct: several may share a type."""
    line = re.sub(r'\s+', ' ', line).strip()
    if not line:
        return []
    if '(*' in line:
        return [typed(line)]
    first, *more = [part.strip() for part in line.split(',')]
    name, kind, lengths = typed(first)
    fields = [(name, kind, lengths)]
    for part in more:
        name, own, lengths = typed(kind.rstrip('*') + ' ' + part)
        fields.append((name, own, lengths))
    return fields


def ctypes_of(kind, structs):
    if kind == 'function' or kind == 'cageform_range_body':
        raise ValueError(kind)
    if kind in NUMBERS:
        return NUMBERS[kind]
    if kind in structs:
        return kind
    if kind == 'char*':
        return 'c_char_p'
    if kind.endswith('*') and kind[:-1] in structs:
        return 'POINTER(%s)' % kind[:-1]
    if kind.endswith('**') or kind.endswith('*') and kind[:-1] in NUMBERS and kind != 'char*':
        return 'c_void_p' if kind.endswith('**') else 'POINTER(%s)' % NUMBERS[kind[:-1]]
    return 'c_void_p'  # void, and objects


def write_ctypes(header):
    lines = ['"""Declarations for ctypes, written by read_header.py from cageform.h."""', '',
             'from ctypes import *', '', 'RANGE_BODY = CFUNCTYPE(None, c_void_p, c_size_t, c_size_t)',
             'FUNCTIONS_OF = {', "    'parallel_for': CFUNCTYPE(None, c_void_p, c_size_t, c_size_t, RANGE_BODY, c_void_p),",
             "    'progress': CFUNCTYPE(c_int, c_void_p, c_double),", '}', '']
    for name, number in header.constants.items():
        lines.append('%s = %d' % (name, number))
    lines += ['', 'STATUSES = {']
    lines += ["    %d: '%s'," % (number, name) for number, name, _ in header.statuses] + ['}', '']
    for name, fields in header.structs.items():
        lines += ['', 'class %s(Structure):' % name, '    _fields_ = [']
        for field, kind, lengths in fields:
            own = "FUNCTIONS_OF['%s']" % field if kind == 'function' else ctypes_of(kind, header.structs)
            for length in reversed(lengths):
                own = '(%s * %d)' % (own, length)
            lines.append("        ('%s', %s)," % (field, own))
        lines += ['    ]', '']
    lines += ['', 'FUNCTIONS = {']
    for name, (kind, arguments) in header.functions.items():
        listed = ', '.join(ctypes_of(k, header.structs) for _, k in arguments)
        lines.append("    '%s': (%s, [%s])," % (name, ctypes_of(kind, header.structs), listed))
    lines += ['}', '']
    return '\n'.join(lines)


if __name__ == '__main__':
    with open(sys.argv[1], encoding='utf-8') as file:
        written = write_ctypes(Header(file.read()))
    with open(sys.argv[2], 'w', encoding='utf-8') as file:
        file.write(written)
