#!/bin/sh
# Usage: sh examples/integrations/packaging/run.sh
# Tests the vcpkg port and the Conan recipe: installs the headers, alone and with the shared library, and builds programs in C++
# and C. Uses vcpkg and Conan if they are in PATH, else stand_ins/, which execute the port and the recipe.
set -eu
cd "$(dirname "$0")/../../.."
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev python3
sh cmake/build_shared.sh
own=examples/integrations/packaging
work=$PWD/build/packaging
clients=tests/package
rm -rf "$work"
mkdir -p "$work"
passed=0
step() { # NAME COMMAND…
  name=$1
  shift
  "$@" >"$work/log.txt" 2>&1 || { cat "$work/log.txt"; echo "FAILED: $name"; exit 1; }
  passed=$((passed + 1))
  echo "$name"
}
program() { # SOURCE BUILD PROGRAM OPTIONS…: configures, builds and runs
  source=$1 build=$2 program=$3
  shift 3
  cmake -S "$source" -B "$build" -G Ninja "$@" && ninja -C "$build" "$program" && "$build/$program"
}

version=$(sed -n 's/.*VERSION_STRING "\(.*\)".*/\1/p' include/cageform/version.hpp)
step "vcpkg: the version is $version" grep -q "\"version\": \"$version\"" $own/vcpkg/cageform/vcpkg.json
if command -v vcpkg >/dev/null 2>&1; then
  step "vcpkg itself" vcpkg install --classic "cageform[compiled]" --overlay-ports=$own/vcpkg
else
  echo "no vcpkg: using stand_ins/vcpkg.cmake"
  step "vcpkg: only headers" cmake -DFEATURES=core -DSHARED=OFF -DBUILD="$work/headers" -DINSTALLED="$work/vcpkg_headers" \
    -P $own/stand_ins/vcpkg.cmake
  step "vcpkg: a C++ program" program $clients "$work/1" client -DCMAKE_PREFIX_PATH="$work/vcpkg_headers"
  step "vcpkg: with the library" cmake '-DFEATURES=core;compiled' -DSHARED=ON -DBUILD=build/shared -DINSTALLED="$work/vcpkg" \
    -P $own/stand_ins/vcpkg.cmake
  step "vcpkg: a C++ program with the library" program $clients "$work/2" client -DCMAKE_PREFIX_PATH="$work/vcpkg" -DCOMPILED=ON
  step "vcpkg: a C program" program $clients/c "$work/3" client_c -DCMAKE_PREFIX_PATH="$work/vcpkg"
fi

if command -v conan >/dev/null 2>&1; then
  step "Conan: only headers" conan create $own/conan --build=missing
  step "Conan: the static library" conan create $own/conan --build=missing -o '&:compiled=True'
  step "Conan: the shared library" conan create $own/conan --build=missing -o '&:compiled=True' -o '&:shared=True'
else
  echo "no Conan: using stand_ins/conan.py"
  step "Conan: only headers" /usr/bin/python3 $own/stand_ins/conan.py $own/conan/conanfile.py "$work/conan_build" \
    "$work/conan_headers"
  step "Conan: a C++ program" program $own/conan/test_package "$work/4" client \
    -DCMAKE_PREFIX_PATH="$work/conan_headers/share/cmake/cageform"
  step "Conan: with the library" /usr/bin/python3 $own/stand_ins/conan.py $own/conan/conanfile.py build/shared "$work/conan" \
    compiled=True shared=True
  step "Conan: a C++ program with the library" program $own/conan/test_package "$work/5" client -DCOMPILED=ON \
    -DCMAKE_PREFIX_PATH="$work/conan/share/cmake/cageform"
  step "Conan: a C program" program $own/conan/test_package "$work/5" client_c
fi
echo "$passed passed, 0 failed"
