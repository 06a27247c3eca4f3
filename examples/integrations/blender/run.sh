#!/bin/sh
# Usage: sh examples/integrations/blender/run.sh [--build-only | --benchmark [PRECISION]]
# Writes out/cageform_blender.zip, the add-on with the library, and tests it in Blender: in background mode and in a window of a
# virtual display. Saves pictures to out/blender/. Downloads only Debian packages.
set -eu
cd "$(dirname "$0")/../../.."
sh cmake/install_packages.sh python3
sh cmake/build_shared.sh
addon=build/blender/cageform
rm -rf build/blender
mkdir -p build/blender out/blender
sh examples/bindings/python/assemble.sh build/shared/libcageform.so build/blender/package
cp -r examples/integrations/blender/addon $addon
cp -r build/blender/package/cageform $addon/library
cp LICENSE $addon
rm -rf $addon/__pycache__ $addon/library/__pycache__ out/cageform_blender.zip
(cd build/blender && /usr/bin/python3 -m zipfile -c ../../out/cageform_blender.zip cageform)
[ "${1:-}" != --build-only ] || exit 0

sh cmake/install_packages.sh blender python3-numpy xvfb xauth libgl1-mesa-dri
fresh() { # with default settings and a separate folder for add-ons
  rm -rf build/blender/user
  mkdir -p build/blender/user
  BLENDER_USER_SCRIPTS=$PWD/build/blender/user BLENDER_USER_CONFIG=$PWD/build/blender/user "$@"
}
if [ "${1:-}" = --benchmark ]; then # comparison with Mesh Deform at a precision
  fresh blender -b --python-exit-code 1 --python examples/integrations/blender/benchmark.py -- out/cageform_blender.zip "${2:-5}" |
    grep -E 'vertices in a cage|bind .* frame'
  exit
fi
fresh blender -b --python-exit-code 1 --python examples/integrations/blender/test.py -- out/cageform_blender.zip
fresh xvfb-run -a -s '-screen 0 1280x800x24' blender --enable-event-simulate -p 0 0 1280 800 \
  --python examples/integrations/blender/window.py -- out/cageform_blender.zip out/blender
