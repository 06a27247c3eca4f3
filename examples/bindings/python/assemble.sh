#!/bin/sh
# Usage: sh examples/bindings/python/assemble.sh LIBRARY FOLDER [--test]
# Copies the sources of the wheel and the shared library LIBRARY to FOLDER, so that nothing is written into the source tree.
# FOLDER can be put on Python's path. Writes the offsets of struct members in C to FOLDER/layout.txt. --test runs test.py.
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
