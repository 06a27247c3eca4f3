#!/bin/sh
# Usage: sh examples/python/build_library.sh
# Installs what the shared library needs (Debian), and builds it: build/python/libcageform.so.
set -eu
cd "$(dirname "$0")/../.."
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev
build=build/python
mkdir -p build
cmake -S . -B $build -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON -DCAGEFORM_BUILD_COMPILED=ON \
  -DCAGEFORM_BUILD_TESTS=OFF -DCAGEFORM_BUILD_EXAMPLES=OFF -DCAGEFORM_INSTALL=OFF >$build.log 2>&1 || { cat $build.log; exit 1; }
ninja -C $build cageform_compiled
