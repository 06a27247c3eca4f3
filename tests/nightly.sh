#!/bin/sh
# Usage: sh tests/nightly.sh
# Runs for hours: all tests, including the tables of waves; a check of each header alone; all rooms under
# sanitizers; thousands of icons; drawings in Chromium and Inkscape; 200 mutants of the headers. Prints the
# commands that failed; the exit code is then 1.
set -u
cd "$(dirname "$0")/.." || exit 1
failed=
campaign() { # COMMAND…
  echo "=== $*"
  "$@" || failed="$failed
  $*"
}
export CAGEFORM_NIGHTLY=1 # example_tools then prints the tables of waves (30 s)
campaign sh tests/run.sh nightly
campaign sh tests/run.sh asan
campaign sh tests/icons/run.sh
campaign sh tests/icons/cages.sh
campaign sh tests/icons/frames.sh
campaign sh cmake/install_packages.sh chromium inkscape
campaign /usr/bin/python3 -B tests/drawings/run.py build/examples --inkscape
campaign /usr/bin/python3 tests/examples/affine.py build/examples 9 200
campaign /usr/bin/python3 tests/mutants/run.py
[ -z "$failed" ] && exit 0
echo "Failed:$failed"
exit 1
