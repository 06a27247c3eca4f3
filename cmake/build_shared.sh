#!/bin/sh
# Builds build/shared/libcageform.so, the C interface for other languages; it depends only on the C library. Takes some
# minutes the first time.
set -eu
cd "$(dirname "$0")/.."
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev
build=build/shared
mkdir -p $build
{
  cmake -S . -B $build -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON -DCAGEFORM_BUILD_COMPILED=ON \
    -DCMAKE_SHARED_LINKER_FLAGS='-static-libstdc++ -static-libgcc -Wl,--gc-sections -s' -DCAGEFORM_BUILD_TESTS=OFF \
    -DCAGEFORM_BUILD_EXAMPLES=OFF && ninja -C $build cageform_compiled
} >$build/log.txt 2>&1 || { cat $build/log.txt; exit 1; }
