#!/bin/sh
# Usage: cages.sh [COUNT]
# Cages around COUNT (1,000) different icons of six themes that Debian has, spread evenly over each: made, verified, bound (cages.cpp).
# Prints a table; takes some minutes for each of its rows; not part of CI. ICONS is the folder of the themes (/usr/share/icons).
set -eu
cd "$(dirname "$0")/../.."
count=${1:-1000}
icons=${ICONS:-/usr/share/icons}
themes='Tango Adwaita breeze Papirus Faenza elementary-xfce'
[ -n "${ICONS:-}" ] || sh cmake/install_packages.sh tango-icon-theme adwaita-icon-theme breeze-icon-theme papirus-icon-theme \
  faenza-icon-theme elementary-xfce-icon-theme
sh cmake/install_packages.sh libpugixml-dev zlib1g-dev libeigen3-dev g++
mkdir -p out/icons
sources=
for name in files/csv files/input_file pictures/drawn_figure svg/animation svg/css_colour svg/deform svg/document svg/motion svg/paint \
  svg/path svg/references svg/shapes svg/style svg/walk svg/xml; do
  sources="$sources examples/support/$name.cpp"
done
# shellcheck disable=SC2086
c++ -std=c++20 -O3 -march=native -DNDEBUG -Iinclude -isystem /usr/include/eigen3 -Iexamples/support tests/icons/cages.cpp $sources \
  -lpugixml -lz -o out/icons/cages
set -- $themes
each=$(((count + $# - 1) / $#))
for theme in $themes; do # one name of each content
  find "$icons/$theme" -name '*.svg' -type f 2>/dev/null | LC_ALL=C sort | tr '\n' '\0' | xargs -0 -r md5sum |
    awk '!seen[$1]++ { print substr($0, 35) }' |
    awk -v wanted="$each" '{ name[NR] = $0 } END { n = wanted < NR ? wanted : NR; for (k = 0; k < n; ++k) print name[int(k * NR / n) + 1] }'
done | head -n "$count" >out/icons/list.txt
out/icons/cages <out/icons/list.txt
