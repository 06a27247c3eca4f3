#!/bin/sh
# Usage: sh examples/bindings/npm/three/run.sh [--serve]
# Installs three.js from npm's registry (needs a network) and the package of ../run.sh, and binds the sample character, a
# GLB file, in node. Opens the page in a headless Chromium, checks the points and pictures, and writes out/npm_three_*.png.
# The page with ?beside shows the file beside the one that deform_mesh writes.
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
if [ ! -f $work/data/character_posed.glb ]; then
  [ -f build/build.ninja ] || cmake --preset examples >/dev/null
  cmake --build build --target make_character deform_mesh >$work/build.txt 2>&1 || { cat $work/build.txt; exit 1; }
  build/examples/make_character $work/data -o $work/data/character.glb >/dev/null
  (cd $work/data && ../../../examples/deform_mesh character.glb --cage character_cage.obj --coordinates harmonic \
    --scale 'y>0.9&y<1.3&x>-0.3&x<0.3:1.6,1,2' --scale 'y>0.6&y<0.8:1.2,1,1.3' \
    --scale 'y>1.48&x>-0.3&x<0.3:1.25@0,1.5,0' -o character_posed.glb)
fi
cp examples/bindings/npm/three/package.json examples/bindings/npm/three/*.js examples/bindings/npm/three/index.html $work
cp $work/data/*.glb $work
quiet='--no-audit --no-fund --silent'
# shellcheck disable=SC2086  # the list is meant to be split
(cd $work && npm install $quiet && npm install --offline --no-save $quiet "../../../out/cageform-$version.tgz")
(cd $work && node bind.js data .)
PYTHONDONTWRITEBYTECODE=1 exec /usr/bin/python3 examples/bindings/npm/three/test.py $work out "$@"
