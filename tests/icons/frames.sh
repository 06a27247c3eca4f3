#!/bin/sh
# Usage: frames.sh [COUNT] [FOLDER…]
# Drawings that nobody here made, still and animated: the frame of animate_svg in the middle of a motion to a pose and back
# is compared by pixels with the still that deform_svg draws of the pose. COUNT (30) of all .svg and .svgz files in
# the folders, spread evenly; unless told, those of the Debian packages openclipart-svg and, where it is installed,
# inkscape. Prints a line each: the largest difference of a pixel in steps of 1/255, the mean where there is paint, the share
# of that which differs by more than 32; the sizes of both files; what both programs say. Pictures go to out/frames.
# PROGRAMS is the folder of the programs. Takes some minutes; not part of CI.
set -eu
cd "$(dirname "$0")/../.."
count=${1:-30}
[ $# -eq 0 ] || shift
if [ $# -eq 0 ]; then
  sh cmake/install_packages.sh openclipart-svg
  set -- /usr/share/openclipart/svg /usr/share/inkscape/examples
fi
sh cmake/install_packages.sh librsvg2-bin libstb-dev libpugixml-dev zlib1g-dev libtinyobjloader-dev libeigen3-dev g++
[ -n "${PROGRAMS:-}" ] || sh examples/run.sh --build-only
programs=$(cd "${PROGRAMS:-build/examples}" && pwd)
out=$PWD/out/frames
rm -rf "$out"
mkdir -p "$out"
c++ -std=c++20 -O2 -Iinclude -isystem /usr/include/eigen3 -Iexamples/support tests/icons/judge.cpp \
  "$programs/support/libsupport_plane.a" "$programs/../libcageform_plane.a" -lpugixml -lz -ltinyobjloader_double -o "$out/judge"
find "$@" -name '*.svg' -o -name '*.svgz' | LC_ALL=C sort |
  awk -v wanted="$count" '{ name[NR] = $0 } END { n = wanted < NR ? wanted : NR; for (k = 0; k < n; ++k) print name[int(k * NR / n) + 1] }' >"$out/list.txt"
printf '%-40s %8s %8s %8s %10s %10s\n' drawing largest mean '> 32' still motion
number=0
while read -r drawing; do
  number=$((number + 1))
  name=$out/$number
  title=$(basename "$drawing" | cut -c1-38)
  if ! timeout 120 "$programs/deform_svg" "$drawing" --cage auto -o "$name.svg" --png --png-width 400 2>"$name.still.txt" ||
    ! timeout 300 "$programs/animate_svg" "$drawing" --cage auto --seconds 1 --rate 4 -o "$name.motion.svg" --stills "$name." --still-count 4 \
      >"$name.out.txt" 2>"$name.motion.txt"; then
    printf '%-40s refused: %s\n' "$title" "$(tail -n 1 "$name.still.txt" "$name.motion.txt" 2>/dev/null | grep -v '^=' | grep -v '^$' | tail -n 1 | cut -c1-150)"
    continue
  fi
  # The picture grows to all frames: both are drawn in the view of the motion.
  view=$(grep -o 'viewBox="[^"]*"' "$name.03.svg" | head -n 1)
  [ "$view" = "$(grep -o 'viewBox="[^"]*"' "$name.svg" | head -n 1)" ] || {
    "$programs/deform_svg" "$drawing" --cage auto -o "$name.svg" --fit 2>/dev/null
    awk -v view="$view" '!done && sub(/viewBox="[^"]*"/, view) { done = 1 } 1' "$name.svg" >"$name.same.svg"
    mv "$name.same.svg" "$name.svg"
  }
  rsvg-convert --unlimited -b white -w 400 -h 400 "$name.svg" -o "$name.png"
  rsvg-convert --unlimited -b white -w 400 -h 400 "$name.03.svg" -o "$name.03.png"
  difference=$("$out/judge" difference "$name.png" "$name.03.png") || difference='- - -'
  # shellcheck disable=SC2086 # three words
  printf '%-40s %8s %8s %8s %10d %10d\n' "$title" $difference "$(wc -c <"$name.svg")" "$(wc -c <"$name.motion.svg")"
done <"$out/list.txt"
