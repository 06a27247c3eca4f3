#!/bin/sh
# Usage: sh examples/page/test.sh [--quick | --if-there]
# Tests out/cageform.html (examples/page/run.sh makes it if it is missing) in a headless Chromium, which is installed
# (Debian): real drags, drops and saves, positions compared with the native programs, 10,000 drags without growth. Saves
# pictures to out/page_*.png.
#   --quick      without the 10,000 drags, and with 200 hostile SVGs instead of 2,000
#   --hostile COUNT, --seed FIRST   tests COUNT hostile SVGs, from seed FIRST
#   --cages FILE…   instead of the tests: drops OBJ files, and prints the time for a cage of 60 vertices around each
#   --if-there   as --quick, but installs and builds nothing: prints what is missing and exits with 77
set -eu
cd "$(dirname "$0")/../.."
programs='cage_weights deform_mesh deform_svg animate_svg make_cage'

if [ "${1:-}" = --if-there ]; then
  skip() {
    echo "skipped: $1"
    exit 77
  }
  command -v python3 >/dev/null || skip "no python3"
  command -v chromium >/dev/null || skip "no chromium"
  [ -f out/cageform.html ] || skip "no out/cageform.html: run examples/page/run.sh"
  newer=$(find examples/page examples/bindings/npm include -newer out/cageform.html -type f | head -n 1)
  [ -z "$newer" ] || skip "out/cageform.html is older than $newer"
  for program in $programs; do [ -x build/examples/$program ] || skip "no build/examples/$program"; done
else
  sh cmake/install_packages.sh python3 chromium
  [ -f out/cageform.html ] || sh examples/page/run.sh
  # shellcheck disable=SC2086  # the list is meant to be split
  cmake --build build --target $programs >build/page/test.txt 2>&1 || { cat build/page/test.txt; exit 1; }
fi
PYTHONDONTWRITEBYTECODE=1 exec python3 examples/page/test.py out/cageform.html out "$@"
