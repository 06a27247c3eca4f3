#!/bin/sh
# Usage: sh examples/python/run.sh
# Builds the shared library and a wheel, out/cageform-*.whl, installs it into a folder of its own, and runs its tests and the
# scripts. Nothing is loaded but Debian packages.
set -eu
cd "$(dirname "$0")/../.."
sh cmake/install_packages.sh python3-numpy python3-setuptools python3-wheel python3-pip python3-matplotlib
sh examples/python/build.sh
build=build/python
wheel=$build/wheel
mkdir -p out
(cd $wheel && /usr/bin/python3 setup.py -q bdist_wheel)
cp $wheel/dist/*.whl out
/usr/bin/python3 -m pip install -q --no-index --no-deps --target $build/site --upgrade $wheel/dist/*.whl
PYTHONPATH=$build/site /usr/bin/python3 examples/python/test.py
