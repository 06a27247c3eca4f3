#!/bin/sh
# Usage: sh examples/bindings/npm/three/run.sh [--serve]
# Installs three.js from npm's registry (needs a network) and the package of ../run.sh, and binds the sample character in
# node. Opens the page in a headless Chromium, checks the points and pictures, and writes out/npm_three_*.png.
#   --serve   serves the page for a browser instead, until it is stopped
# The package's own tests do not include this script, because they need no network.
set -eu
cd "$(dirname "$0")/../../../.."
version=$(sed -n 's/.*VERSION_STRING "\(.*\)".*/\1/p' include/cageform/version.hpp)
[ -f "out/cageform-$version.tgz" ] || sh examples/bindings/npm/run.sh --build-only
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev libpugixml-dev zlib1g-dev libstb-dev libcli11-dev \
  libtinyobjloader-dev nlohmann-json3-dev libgmp-dev chromium python3
work=build/npm/three
mkdir -p $work/data
if [ ! -f $work/data/character.obj ]; then
  [ -f build/build.ninja ] || cmake --preset examples >/dev/null
  cmake --build build --target make_character >$work/build.txt 2>&1 || { cat $work/build.txt; exit 1; }
  build/examples/make_character $work/data >/dev/null
fi
cp examples/bindings/npm/three/package.json examples/bindings/npm/three/*.js examples/bindings/npm/three/index.html $work
quiet='--no-audit --no-fund --silent'
# shellcheck disable=SC2086  # the list is meant to be split
(cd $work && npm install $quiet && npm install --offline --no-save $quiet "../../../out/cageform-$version.tgz")
(cd $work && node bind.js data .)
PYTHONDONTWRITEBYTECODE=1 exec /usr/bin/python3 examples/bindings/npm/three/test.py $work out "$@"
