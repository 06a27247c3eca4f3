#!/bin/sh
# Usage: sh examples/bindings/python/assemble.sh LIBRARY FOLDER [--test]
# Puts the sources of the wheel together in FOLDER, with a shared library, so that nothing is written among those of the project.
# FOLDER may be on Python's path. FOLDER/layout.txt says where members of the structs lie in C. --test runs test.py.
set -eu
library=$(realpath "$1") folder=$(realpath -m "$2")
cd "$(dirname "$0")"
include=../../../include
python=/usr/bin/python3
rm -rf "$folder"
mkdir -p "$folder"
cp -r package/. ../../../LICENSE "$folder"
cp -L "$library" "$folder/cageform/libcageform.so"
sed -n 's/.*VERSION_STRING "\(.*\)".*/\1/p' $include/cageform/version.hpp >"$folder/VERSION"
$python read_header.py ctypes $include/cageform/c/cageform.h >"$folder/cageform/_c.py"
$python read_header.py layout $include/cageform/c/cageform.h >"$folder/layout.c"
cc -std=c99 -I$include "$folder/layout.c" -o "$folder/layout"
"$folder/layout" >"$folder/layout.txt"
[ "${3-}" != --test ] || CAGEFORM_LAYOUT="$folder/layout.txt" PYTHONPATH="$folder" $python test.py
