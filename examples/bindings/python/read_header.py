"""Reads the C header of the library, for bindings of other languages.

    python3 read_header.py ctypes include/cageform/c/cageform.h >_c.py     declarations for ctypes
    python3 read_header.py layout include/cageform/c/cageform.h >layout.c  a C program that prints the offsets of members
"""

import os.path
import re
import sys

NUMBERS = {'size_t': 'c_size_t', 'uint16_t': 'c_uint16', 'uint32_t': 'c_uint32', 'uint64_t': 'c_uint64',
           'int32_t': 'c_int32', 'float': 'c_float', 'double': 'c_double', 'int': 'c_int', 'char': 'c_char', 'cageform_status': 'c_int32'}


class Header:
    """constants: name to number; choices: enumeration to name to number, with names for other languages, such as
    'mean-value' for CAGEFORM_MEAN_VALUE; statuses: number to name in lower case; structs: name to a list of members (name,
    type, lengths of array dimensions); functions: name to (type, types of arguments). Types are those of C without
    const; 'function' is a pointer to one."""

    def __init__(self, text):
        listed = re.findall(r'X\((\d+), ([A-Z0-9_]+), ([a-z0-9_]+)', text)
        self.statuses = {int(number): name for number, _, name in listed}
        self.constants = {'CAGEFORM_' + name: int(number) for number, name, _ in listed}
        self.constants.update((name, int(number)) for name, number in re.findall(r'#define (CAGEFORM_C_ABI) (\d+)', text))
        text = re.sub(r'/\*.*?\*/', '', text, flags=re.S)
        text = re.sub(r'^\s*#.*(?:\\\n.*)*$', '', text, flags=re.M)
        self.constants.update((name, int(number)) for name, number in re.findall(r'\b(CAGEFORM_\w+) = (\d+)', text))
        self.choices = {name: named_choices(body) for name, body in re.findall(r'enum cageform_(\w+) \{(.*?)\};', text, flags=re.S)}
        self.structs = {name: [member for line in body.split(';') if line.strip() for member in members_of(line)]
                        for name, body in re.findall(r'typedef struct (\w+) \{(.*?)\} \1;', text, flags=re.S)}
        self.functions = {}
        for kind, name, arguments in re.findall(r'CAGEFORM_API ([\w \*]+?)(\w+)\((.*?)\);', text, flags=re.S):
            listed = [] if arguments.strip() == 'void' else arguments.split(',')
            self.functions[name] = plain(kind), [declared(argument)[1] for argument in listed]


def named_choices(body):
    """Returns the names of enumerators without their common prefix: 'half' for CAGEFORM_FORMAT_HALF."""
    listed = re.findall(r'(CAGEFORM_\w+) = (\d+)', body)
    common = os.path.commonprefix([name for name, _ in listed]).rfind('_') + 1
    return {name[common:].lower().replace('_', '-'): int(number) for name, number in listed}


def plain(kind):
    return ' '.join(re.sub(r'\bconst\b', '', kind).split()).replace(' *', '*')


def declared(text):
    """Returns the name, the type and the array lengths of a declaration."""
    if '(*' in text:
        return re.search(r'\(\*(\w+)\)', text).group(1), 'function', []
    kind, name, lengths = re.fullmatch(r'(.*?)(\w+)((?:\[\d+\])*)', ' '.join(text.split())).groups()
    return name, plain(kind), [int(length) for length in re.findall(r'\d+', lengths)]


def members_of(line):
    """Returns the members declared by one line of a struct; several may share a type."""
    if '(*' in line:
        return [declared(line)]
    first, *more = line.split(',')
    members = [declared(first)]
    return members + [declared(members[0][1].rstrip('*') + ' ' + other) for other in more]


def ctypes_of(kind, structs):
    """Returns the ctypes type. Objects, memory and pointers to pointers are c_void_p."""
    if kind in structs:
        return kind
    if kind in NUMBERS:
        return NUMBERS[kind]
    if kind == 'char*':
        return 'c_char_p'
    pointed = kind[:-1]
    if pointed in structs or pointed in NUMBERS:
        return 'POINTER(%s)' % ctypes_of(pointed, structs)
    return 'c_void_p'


def python_type(kind, lengths):
    whole = kind in NUMBERS and kind not in ('double', 'char') and not lengths
    return 'int' if whole else 'float' if kind == 'double' and not lengths else 'Any'


def write_ctypes(header):
    lines = ['"""Declarations of cageform.h, written by read_header.py."""', '',
             'from ctypes import *', 'from typing import Any, Dict, List, Tuple', '',
             'RANGE_BODY = CFUNCTYPE(None, c_void_p, c_size_t, c_size_t)', 'FUNCTIONS_OF: Dict[str, Any] = {',
             "    'parallel_for': CFUNCTYPE(None, c_void_p, c_size_t, c_size_t, RANGE_BODY, c_void_p),",
             "    'progress': CFUNCTYPE(c_int, c_void_p, c_double),", '}', '']
    lines += ['%s = %d' % constant for constant in header.constants.items()]
    lines += ['', 'CHOICES: Dict[str, Dict[str, int]] = {'] + ["    '%s': %r," % its for its in header.choices.items()] + ['}']
    lines += ['', 'STATUSES: Dict[int, str] = {'] + ["    %d: '%s'," % status for status in header.statuses.items()] + ['}', '']
    for name, members in header.structs.items():
        lines += ['', 'class %s(Structure):' % name]
        lines += ['    %s: %s' % (member, python_type(kind, lengths)) for member, kind, lengths in members]
        lines += ['    _fields_ = [']
        for member, kind, lengths in members:
            own = "FUNCTIONS_OF['%s']" % member if kind == 'function' else ctypes_of(kind, header.structs)
            for length in reversed(lengths):
                own = '(%s * %d)' % (own, length)
            lines.append("        ('%s', %s)," % (member, own))
        lines += ['    ]', '']
    lines += ['', 'FUNCTIONS: Dict[str, Tuple[Any, List[Any]]] = {']
    for name, (kind, arguments) in header.functions.items():
        listed = ', '.join(ctypes_of(argument, header.structs) for argument in arguments)
        lines.append("    '%s': (%s, [%s])," % (name, ctypes_of(kind, header.structs), listed))
    return '\n'.join(lines + ['}'])


def write_layout(header):
    lines = ['#include <cageform/c/cageform.h>', '#include <stdio.h>', '', 'int main(void) {']
    for name, members in header.structs.items():
        lines.append('    printf("%s %%zu\\n", sizeof(%s));' % (name, name))
        lines += ['    printf("%s.%s %%zu\\n", offsetof(%s, %s));' % (name, member, name, member) for member, _, _ in members]
    return '\n'.join(lines + ['    return 0;', '}'])


if __name__ == '__main__':
    writers = {'ctypes': write_ctypes, 'layout': write_layout}
    if len(sys.argv) != 3 or sys.argv[1] not in writers:
        raise SystemExit(__doc__)
    with open(sys.argv[2], encoding='utf-8') as file:
        print(writers[sys.argv[1]](Header(file.read())))
