#!/bin/sh
# Usage: sh tests/run.sh [PRESET]
# Installs what the tests need (Debian), builds and runs them through ctest. PRESET is one of the workflow presets:
#   dev      all tests with g++ and portable flags, and the example programs as a newcomer runs them (the default)
#   asan     all tests of the library with clang under the address and undefined behaviour sanitizers;
#            lines in its reports, longer to compile: cmake --preset asan -DCMAKE_BUILD_TYPE=Debug
#   native   the kernels' tests for this processor's registers, with clang
#   release  what dev tests, and the benchmarks, with the flags that figures are taken with
set -eu
cd "$(dirname "$0")/.."
preset=${1:-dev}
packages='cmake ninja-build libeigen3-dev libglm-dev catch2 nlohmann-json3-dev libpugixml-dev zlib1g-dev libtinyobjloader-dev
  libstb-dev libgmp-dev libegl-dev libgl-dev libopengl-dev libgl1-mesa-dri'
case $preset in
  asan | native)
    packages="$packages clang-19 libclang-rt-19-dev"
    [ "$preset" != native ] || [ "$(dpkg --print-architecture 2>/dev/null)" != amd64 ] ||
      packages="$packages lib32stdc++-12-dev libc6-dev-i386" # a test for 32-bit x86
    if [ "$preset" = native ]; then # a test for WebAssembly
      packages="$packages lld-19 wasi-libc libc++-19-dev-wasm32 libc++abi-19-dev-wasm32 libclang-rt-19-dev-wasm32"
      command -v node >/dev/null 2>&1 || packages="$packages nodejs"
    fi
    ;;
  *)
    packages="$packages g++ pkg-config librsvg2-bin tango-icon-theme libtinygltf-dev python3-numpy
      g++-mingw-w64-x86-64-win32 g++-arm-linux-gnueabihf qemu-user"
    command -v npm >/dev/null 2>&1 || packages="$packages nodejs npm"
    [ "$preset" != release ] || packages="$packages libbenchmark-dev libsuitesparse-dev libopenblas0-serial libcgal-dev
      libmpfr-dev"
    CAGEFORM_WARNINGS_AS_ERRORS=ON sh examples/run.sh --build-only
    ;;
esac
# shellcheck disable=SC2086 # the list is meant to be split
sh cmake/install_packages.sh $packages
cmake --workflow --preset "$preset"
