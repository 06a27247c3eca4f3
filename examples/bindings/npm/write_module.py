"""Writes struct offsets in WebAssembly, statuses, constants and exports from the C header, for the npm package.

    python3 write_module.py include/cageform/c/cageform.h include/cageform/version.hpp FOLDER

Writes FOLDER/layout.js and layout.d.ts for the package; layout_check.hpp, with which the compiler verifies the offsets in
cageform.cpp; exports.txt and exports_runtime.txt, linker options. The package has no skeletons yet. Its run-time module
has no pins, because they would be a third of its bytes.
"""

import pathlib
import re
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / 'python'))
from read_header import Header  # noqa: E402

# Number types of JavaScript views, and their bytes. Pointers and functions are addresses of 4 bytes.
NUMBERS = {'size_t': ('u32', 4), 'uint32_t': ('u32', 4), 'int32_t': ('i32', 4), 'uint64_t': ('u64', 8), 'double': ('f64', 8),
           'int': ('i32', 4), 'char': ('u8', 1), 'cageform_status': ('i32', 4)}


def kind_of(kind, layouts):
    """Returns the number type of a field, its bytes and its alignment."""
    if kind in layouts:
        return kind, layouts[kind]['size'], layouts[kind]['alignment']
    name, size = NUMBERS.get(kind, ('u32', 4))
    return name, size, size


def layouts_of(header):
    layouts = {}
    for struct, fields in header.structs.items():
        at, widest, placed = 0, 1, {}
        for name, kind, lengths in fields:
            known, size, alignment = kind_of(kind, layouts)
            at = -(-at // alignment) * alignment
            count = 1
            for length in lengths:
                count *= length
            placed[name] = [known, at, count, kind]
            at += size * count
            widest = max(widest, alignment)
        layouts[struct] = {'size': -(-at // widest) * widest, 'alignment': widest, 'fields': placed}
    return layouts


def camel(name):
    return re.sub(r'_(\w)', lambda match: match.group(1).upper(), name)


def write_script(header, layouts, version):
    lines = ['// Written by write_module.py from cageform.h.', '', "export const VERSION = '%s';" % version, '',
             '// Names of fields: number type, offset, count.', 'export const STRUCTS = {']
    for struct, its in layouts.items():
        fields = ', '.join("%s: ['%s', %d, %d]" % (camel(name), kind, at, count)
                           for name, (kind, at, count, _) in its['fields'].items())
        lines.append('  %s: { size: %d, fields: { %s } },' % (struct, its['size'], fields))
    lines += ['};', '', 'export const STATUSES = {']
    lines += ["  %d: '%s'," % (number, name) for number, name in header.statuses.items()] + ['};', '', 'export const CONSTANTS = {']
    named = {name[len('CAGEFORM_'):]: number for name, number in header.constants.items()}
    lines += ['  %s: %d,' % constant for constant in named.items() if constant[0].lower() not in header.statuses.values()]
    lines += ['};', '', '// The values of options.', 'export const CHOICES = {']
    lines += ['  %s: { %s },' % (camel(name), ', '.join("'%s': %d" % its for its in choices.items())) for name, choices in header.choices.items()]
    lines += ['};', '']
    return '\n'.join(lines)


def write_types(header, layouts):
    lines = ['// Written by write_module.py from cageform.h.', '',
             '/** The name of a status of the library. */', 'export type LibraryStatus =']
    lines += ["  | '%s'" % name for number, name in header.statuses.items() if number != 0]
    lines[-1] += ';'
    for name, choices in header.choices.items():
        lines += ['', 'export type %s = %s;' % (camel('_' + name), ' | '.join("'%s'" % word for word in choices))]
    lines += ['', '/** Numbers of a report, documented in the C header. Fields that do not apply to a call are 0. */',
              'export interface ReportNumbers {']
    for name, (kind, _, count, _) in layouts['cageform_report']['fields'].items():
        if name not in ('size', 'status', 'reserved', 'culprit', 'frame', 'fault', 'message', 'settled', 'ended', 'of_target'):
            lines.append('  readonly %s: number;' % camel(name))
    return '\n'.join(lines + ['}', ''])


def write_check(layouts, runtime):
    """Returns static assertions for the structs of the run time, or for all structs."""
    lines = ['// Written by write_module.py from cageform.h.', '#pragma once', '', '#include <cageform/c/cageform.h>', '',
             '#include <cstddef>', '']
    for struct, its in layouts.items():
        if struct not in runtime.structs:
            lines.append('#if !defined(CAGEFORM_C_RUNTIME_ONLY)')
        lines.append('static_assert(sizeof(%s) == %d);' % (struct, its['size']))
        lines += ['static_assert(offsetof(%s, %s) == %d);' % (struct, name, at) for name, (_, at, _, _) in its['fields'].items()]
        if struct not in runtime.structs:
            lines.append('#endif')
    return '\n'.join(lines + [''])


def exports_of(header, without=()):
    own = [name for name in header.functions if not any(word in name for word in without)]
    calls = ['cageform_call_begin', 'cageform_call_undo', 'cageform_call_progress']
    names = [*own, *calls, 'malloc', 'free', '__stack_pointer']
    return '\n'.join('-Wl,--export=' + name for name in names) + '\n'


def main():
    text, version, folder = pathlib.Path(sys.argv[1]).read_text(), pathlib.Path(sys.argv[2]).read_text(), pathlib.Path(sys.argv[3])
    header, runtime = Header(text), Header(text[:text.index('#if !defined(CAGEFORM_C_RUNTIME_ONLY)')])
    layouts = layouts_of(header)
    number = re.search(r'VERSION_STRING "(.*)"', version).group(1)
    for name, written in (('layout.js', write_script(header, layouts, number)), ('layout.d.ts', write_types(header, layouts)),
                          ('layout_check.hpp', write_check(layouts, runtime)), ('exports.txt', exports_of(header, ('skeleton',))),
                          ('exports_runtime.txt', exports_of(runtime, ('pins', 'samples')))):
        path = folder / name
        if not path.exists() or path.read_text() != written:
            path.write_text(written)


if __name__ == '__main__':
    main()
