#!/bin/sh
# Usage: sh tests/run.sh [PRESET]
# Installs what the tests need (Debian), builds and runs all of them through ctest. PRESET is one of the
# workflow presets: dev (the default), clang, asan, noexcept, release.
set -eu
cd "$(dirname "$0")/.."
preset=${1:-dev}
case $preset in
  clang) compiler=clang-19 ;;
  asan) compiler='clang-19 libclang-rt-19-dev' ;; # builds in two thirds of the time of g++
  *) compiler=g++ ;;
esac
# shellcheck disable=SC2086
sh cmake/install_packages.sh $compiler cmake ninja-build libeigen3-dev libglm-dev catch2 nlohmann-json3-dev \
  libpugixml-dev libstb-dev libcli11-dev libtinyobjloader-dev librsvg2-bin tango-icon-theme \
  libegl-dev libgl-dev libgl1-mesa-dri libtinygltf-dev \
  $([ "$preset" != dev ] || command -v npm >/dev/null 2>&1 || echo nodejs npm) \
  $([ "$preset" != release ] || echo libbenchmark-dev libsuitesparse-dev)
cmake --workflow --preset "$preset"
