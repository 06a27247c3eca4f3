#!/bin/sh
# Usage: sh examples/bindings/python/run.sh [--benchmark | --bare RELEASE]
# Writes out/cageform-….whl and tests it: the tests, types with mypy, the scripts, and, as root, the tests on a Debian with
# numpy and without a compiler. --benchmark compares times with C++; --bare runs the tests, as root, on another Debian release.
set -eu
cd "$(dirname "$0")/../../.."
sh cmake/install_packages.sh python3 python3-numpy python3-setuptools python3-wheel python3-build python3-venv python3-pip \
  python3-matplotlib python3-meshio mypy debootstrap librsvg2-bin
sh cmake/build_shared.sh
python=/usr/bin/python3
lib=$PWD/build/shared
work=$PWD/build/python

rm -rf "$work"
mkdir -p "$work" out
sh examples/bindings/python/assemble.sh "$lib/libcageform.so" "$work/wheel"
(cd "$work/wheel" && $python -m build --no-isolation --wheel >"$work/log.txt" 2>&1) || { cat "$work/log.txt"; exit 1; }
rm -f out/cageform-*.whl
cp "$work"/wheel/dist/*.whl out
wheel=$(cd out && echo cageform-*.whl)
echo "out/$wheel, $(wc -c <"out/$wheel") bytes"
$python -m pip install -q --root-user-action=ignore --no-index --no-deps --target "$work/site" "out/$wheel"
export PYTHONPATH="$work/site"

# Tests the wheel on a Debian release with only numpy and pip.
test_bare() { # RELEASE
  bare=$work/bare
  mkdir "$bare"
  trap 'rm -rf --one-file-system "$bare"' EXIT
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Codename: bookworm' 2>/dev/null | head -n 1)
  debootstrap --variant=minbase --include=python3-numpy,python3-pip "$1" "$bare" "$mirror" >"$work/log.txt" 2>&1 ||
    { tail "$work/log.txt"; exit 1; }
  cp "out/$wheel" examples/bindings/python/test.py "$work/wheel/layout.txt" "$bare/root"
  [ ! -e "$bare/usr/bin/cc" ] || { echo "this Debian has a compiler"; exit 1; }
  chroot "$bare" /usr/bin/env -i PATH=/usr/bin:/bin HOME=/root CAGEFORM_LAYOUT=/root/layout.txt sh -ec "cd /root
    python3 -m pip install -q --root-user-action=ignore --no-index --no-deps --target site --no-warn-script-location $wheel
    PYTHONPATH=site python3 -c 'import numpy, sys, cageform
print(\"Debian $1: Python %s, numpy %s, cageform %s\" % (sys.version.split()[0], numpy.__version__, cageform.__version__))'
    PYTHONPATH=site python3 test.py"
  rm -rf --one-file-system "$bare"
}

# The tests compare results with this C++ program.
c++ -std=c++20 -O2 -DNDEBUG -DCAGEFORM_COMPILED -Iinclude examples/bindings/python/beside.cpp -o "$work/beside" -L"$lib" -lcageform \
  -Wl,-rpath,"$lib"
case ${1-} in
  --benchmark) exec $python examples/bindings/python/benchmark.py "$work/beside" ;;
  --bare) test_bare "$2"; exit ;;
esac

CAGEFORM_BESIDE="$work/beside" CAGEFORM_LAYOUT="$work/wheel/layout.txt" $python examples/bindings/python/test.py
(cd "$work/site" && MYPYPATH=. mypy --strict -p cageform)

scripts=examples/bindings/python/scripts data=examples/data out=out/python
mkdir -p $out
$python $scripts/svg_points.py $data/cat.svg $data/cat_cage.svg $data/cat_pose_step.svg $out/cat.svg
rsvg-convert -o $out/cat.png $out/cat.svg
for format in obj ply stl; do
  $python $scripts/model.py tests/data/fingers/cage.obj $out/bent.$format
done
$python $scripts/model.py $out/bent.stl $out/bent_again.stl
sh cmake/install_packages.sh libpugixml-dev zlib1g-dev libstb-dev libcli11-dev libtinyobjloader-dev nlohmann-json3-dev libgmp-dev
[ -f build/build.ninja ] || cmake --preset examples >/dev/null
cmake --build build --target make_character >"$work/log.txt" 2>&1 || { cat "$work/log.txt"; exit 1; }
build/examples/make_character -o $out/character.glb >/dev/null
$python $scripts/model.py $out/character.glb $out/bent.glb
$python $scripts/clip.py
$python $scripts/gradients.py
$python $scripts/skeleton.py
$python $scripts/plot_weights.py $out/weights.png

if [ "$(id -u)" -eq 0 ]; then
  test_bare bookworm
else
  echo "not as root: not tested on a Debian without a compiler"
fi
