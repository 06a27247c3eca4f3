#!/bin/sh
# Usage: sh examples/python/build.sh
# Builds the shared library and puts the sources of the Python package together, apart from those of the project:
# build/python/wheel, with the library in its folder cageform.
set -eu
cd "$(dirname "$0")/../.."
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev python3
build=build/python
mkdir -p $build
cmake -S . -B $build -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON -DCAGEFORM_BUILD_COMPILED=ON \
  -DCAGEFORM_BUILD_TESTS=OFF -DCAGEFORM_BUILD_EXAMPLES=OFF -DCAGEFORM_INSTALL=OFF > $build.log 2>&1 || { cat $build.log; exit 1; }
ninja -C $build cageform_compiled
wheel=$build/wheel
rm -rf $wheel
mkdir -p $wheel
cp -r examples/python/package/. LICENSE $wheel
cp -L $build/libcageform.so $wheel/cageform
/usr/bin/python3 examples/python/read_header.py include/cageform/c/cageform.h $wheel/cageform/_c.py
sed -n 's/.*VERSION_STRING "\(.*\)".*/\1/p' include/cageform/version.hpp > $wheel/VERSION
