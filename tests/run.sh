#!/bin/sh
# Usage: sh tests/run.sh [PRESET [ROOM…]]
# Installs what the tests need (Debian 12 and 13), builds them and runs ctest. PRESET is one of
#   dev      all tests with g++ and portable flags, and the example programs as a new user runs them (default)
#   asan     all tests of the library and of the programs' parsers with clang, address and undefined behaviour
#            sanitizers; for line numbers in reports: cmake --preset asan -DCMAKE_BUILD_TYPE=Debug
#   native   kernel tests with clang and the registers of this processor
#   release  as dev, with benchmarks, and with the flags of published results
#   nightly  as dev, with a check of each header alone; used by tests/nightly.sh
# ROOM is a folder of both tests/ and include/cageform/, such as clone. With rooms, the script builds and runs
# only their tests. To run one test: ctest --test-dir build -R 'clone_tests:.*rest'; with -N, ctest lists the
# tests. Presets other than dev build in build/PRESET.
set -eu
cd "$(dirname "$0")/.."
preset=${1:-dev}
[ $# -eq 0 ] || shift
case $preset in
  dev) build=build ;;
  asan | native | release | nightly) build=build/$preset ;;
  *)
    echo "tests/run.sh: unknown preset $preset; usage: sh tests/run.sh [(dev | asan | native | release | nightly) [ROOM...]]" >&2
    exit 2
    ;;
esac
for room in "$@"; do
  [ "$preset" != native ] && [ -d "tests/$room" ] && [ -d "include/cageform/$room" ] || {
    echo "tests/run.sh: unknown room $room; rooms are the folders of include/cageform, and the preset native has none" >&2
    exit 2
  }
done
packages='cmake ninja-build libeigen3-dev libglm-dev catch2 nlohmann-json3-dev libpugixml-dev zlib1g-dev libtinyobjloader-dev
  libstb-dev libgmp-dev libdraco-dev libmeshoptimizer-dev libegl-dev libgl-dev libopengl-dev libgl1-mesa-dri'
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
    packages="$packages g++ libcli11-dev libtinygltf-dev"
    if [ $# -eq 0 ]; then # not needed for single rooms
      packages="$packages pkg-config librsvg2-bin tango-icon-theme python3-numpy
        g++-mingw-w64-x86-64-win32 g++-arm-linux-gnueabihf qemu-user"
      command -v npm >/dev/null 2>&1 || packages="$packages nodejs npm"
    fi
    [ "$preset" != release ] || packages="$packages libbenchmark-dev libsuitesparse-dev libopenblas0-serial libcgal-dev
      libmpfr-dev"
    ;;
esac
# shellcheck disable=SC2086 # the list is split into words
sh cmake/install_packages.sh $packages
cmake --preset "$preset" >/dev/null
targets='' filter=''
for room in "$@"; do
  targets="$targets ${room}_tests"
  filter="$filter${filter:+|}^${room}_tests:"
done
# shellcheck disable=SC2086
cmake --build "$build" ${targets:+--target $targets}
# Reasons for skipped tests and commands to repeat failed tests follow the output of ctest.
code=0
ctest --test-dir "$build" --no-tests=error --output-on-failure -j "$(nproc 2>/dev/null || echo 2)" ${filter:+-R "$filter"} || code=$?
sed -n 's/^\(-- \)\{0,1\}skipped: /Skipped: /p' "$build/Testing/Temporary/LastTest.log" | sort -u
[ $code -ne 0 ] || exit 0
echo 'To repeat a test that failed:'
sed 's/^[0-9]*://' "$build/Testing/Temporary/LastTestsFailed.log" | while read -r name; do
  pattern=$(printf %s "$name" | sed -e 's/[][().*+?^$\\|]/\\&/g' -e "s/'/./g")
  printf "  ctest --test-dir %s --output-on-failure -R '^%s\$'\n" "$build" "$pattern"
done
exit 1
