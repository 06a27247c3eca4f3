#!/bin/sh
# Usage: sh examples/integrations/ogre/run.sh [--build-only]
# The library in a game engine: installs OGRE and a software renderer (Debian), builds into build/engine/, and binds the
# character with mean value and with Green coordinates. Plays its dances in OGRE, saves pictures to out/ogre_*.png and
# out/ogre_green_*.png, and checks with 10,000 frames of each that memory does not grow.
set -eu
cd "$(dirname "$0")/../../.."
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev libpugixml-dev zlib1g-dev libstb-dev libcli11-dev \
  libtinyobjloader-dev nlohmann-json3-dev libogre-1.12-dev libgl1-mesa-dri xvfb xauth

cmake -S . -B build/engine -G Ninja -DCMAKE_BUILD_TYPE= -DCMAKE_CXX_FLAGS='-O3 -march=native -DNDEBUG' \
  -DCAGEFORM_BUILD_TESTS=OFF -DCAGEFORM_BUILD_BENCH=OFF -DCAGEFORM_BUILD_ENGINE_EXAMPLE=ON >/dev/null
cmake --build build/engine --target make_character bind_mesh ogre_client
[ "${1:-}" != --build-only ] || exit 0

programs=build/engine/examples
mkdir -p out
"$programs/make_character" out
# OGRE 1.12 needs X windows: a virtual display.
in_x() { xvfb-run -a -s '-screen 0 1280x960x24' "$@"; }
dance() { # FIGURE PICTURES COORDINATES
  "$programs/bind_mesh" out/character.obj --cage out/character_cage.obj --clip out/character_clip.csv \
    --coordinates "$3" --max-distance 0.001 -o "$1" --report
  in_x "$programs/ogre_client" "$1" --pictures "$2" --count 6
  in_x "$programs/ogre_client" "$1" --width 320 --height 240 --frames 10000
}
dance out/character.figure out/ogre_ mean-value
dance out/character_green.figure out/ogre_green_ green
