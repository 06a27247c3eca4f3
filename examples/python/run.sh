#!/bin/sh
# Usage: sh examples/python/run.sh [--tests-only WHEEL]
# Builds the shared library and a wheel, out/cageform-*.whl, installs it into a folder of its own, and runs its tests and the
# scripts. Nothing is loaded but Debian packages.
set -eu
cd "$(dirname "$0")/../.."
sh cmake/install_packages.sh python3 python3-numpy python3-setuptools python3-wheel python3-pip python3-matplotlib
sh examples/python/build_library.sh
build=build/python
# The sources of the wheel are put together apart, so that nothing is written among those of the project.
wheel=$build/wheel
rm -rf $wheel
mkdir -p $wheel out
cp -r examples/python/package/. LICENSE $wheel
cp -L $build/libcageform.so $wheel/cageform
/usr/bin/python3 examples/python/read_header.py include/cageform/c/cageform.h $wheel/cageform/_c.py
sed -n 's/.*VERSION_STRING "\(.*\)".*/\1/p' include/cageform/version.hpp > $wheel/VERSION
(cd $wheel && /usr/bin/python3 setup.py -q bdist_wheel)
cp $wheel/dist/*.whl out
/usr/bin/python3 -m pip install -q --no-index --no-deps --target $build/site --upgrade $wheel/dist/*.whl
PYTHONPATH=$build/site /usr/bin/python3 examples/python/test.py
