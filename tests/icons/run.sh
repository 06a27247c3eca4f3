#!/bin/sh
# Usage: run.sh [EVERY]
# 3,500 icons that nobody here drew, of four themes that Debian has: all different ones of Tango and Adwaita, and as many of Breeze and of
# Papirus as make up the number, spread evenly. With EVERY, each EVERY-th of these. deform_svg takes each through
# the identity pose and through a bend. The drawings of rsvg-convert are compared with the icon, and with the picture of the icon
# bent (judge.cpp). Prints a table a theme; out/icons/ gets rows.txt, the pictures of those that differ most, and a sheet
# of the worst twenty: at rest, expected, bent. Takes some minutes; not part of CI.
# ICONS is the folder of the themes (/usr/share/icons), PROGRAMS and JOBS are that of deform_svg and the processes at a time.
set -eu
cd "$(dirname "$0")/../.."
every=${1:-1}
icons=${ICONS:-/usr/share/icons}
jobs=${JOBS:-$(nproc)}
out=$PWD/out/icons
[ -n "${ICONS:-}" ] || sh cmake/install_packages.sh tango-icon-theme adwaita-icon-theme breeze-icon-theme papirus-icon-theme
sh cmake/install_packages.sh librsvg2-bin libstb-dev libpugixml-dev zlib1g-dev libtinyobjloader-dev libeigen3-dev g++
[ -n "${PROGRAMS:-}" ] || sh examples/run.sh --build-only
programs=$(cd "${PROGRAMS:-build/examples}" && pwd)
rm -rf "$out"
mkdir -p "$out/kept"
c++ -std=c++20 -O2 -Iinclude -isystem /usr/include/eigen3 -Iexamples/support tests/icons/judge.cpp \
  "$programs/support/libsupport_plane.a" "$programs/../libcageform_plane.a" -lpugixml -lz -ltinyobjloader_double -o "$out/judge"

# ---- which ----
# One name of each content, in the order of names; spread evenly over a theme where only some of it is wanted.
different() { # THEME WANTED
  find "$icons/$1" -name '*.svg' -type f | LC_ALL=C sort | tr '\n' '\0' | xargs -0 md5sum | awk '!seen[$1]++ { print substr($0, 35) }' |
    awk -v wanted="$2" -v theme="$1" '{ name[NR] = $0 } END { n = wanted && wanted < NR ? wanted : NR
      for (k = 0; k < n; ++k) print theme "\t" name[int(k * NR / n) + 1] }'
}
{ different Tango 0; different Adwaita 0; } >"$out/list.txt"
rest=$((3500 - $(wc -l <"$out/list.txt")))
different breeze $((rest / 2)) >>"$out/list.txt"
different Papirus $((rest - rest / 2)) >>"$out/list.txt"

# ---- each ----
# A row: THEME, NAME, FOLDER, OUTCOME, identity's largest difference, whether its bytes are equal, bend's mean and share, warnings.
cat >"$out/one.sh" <<'END'
number=$1 theme=${2%%	*} icon=${2#*	}
work=$out/kept/$number
mkdir -p "$work"
row() { # OUTCOME FIELDS…   in one write, for others write beside it
  line=$(printf '\t%s' "$@")
  printf '%s\t%s\t%s%s\n' "$theme" "${icon#"$icons"/}" "$number" "$line"
}
drop() { rm -rf "$work"; }
draw() { rsvg-convert -o "$work/$1.png" "$work/$1.svg" 2>/dev/null; }
deform() { # NAME POSE
  "$programs/deform_svg" "$work/rest.svg" --cage "$work/cage.csv" --pose "$work/$2.csv" -o "$work/$1.svg" 2>"$work/$1.txt"
}
"$out/judge" prepare "$icon" "$work" 2>/dev/null || { row unreadable; drop; exit; }
draw rest && draw wide || { row undrawable; drop; exit; }
deform identity cage && deform bend bend || { row refused; cat "$work"/*.txt >&2; drop; exit; }
draw identity && draw bend || { row broken; exit; }
cmp -s "$work/rest.svg" "$work/identity.svg" && equal=1 || equal=0
difference=$("$out/judge" compare "$work") || { row broken; exit; }
set -- $difference
count() { grep -c -- "$1" "$work/bend.txt" || true; }
row judged "$1" $equal "$2" "$3" "$(count 'cut off')" "$(count 'letters')" "$(wc -l <"$work/bend.txt")"
awk "BEGIN { exit !($2 > 5 || $1 > 3) }" || drop
END
export out icons programs
awk '{ print NR; print }' "$out/list.txt" | awk -v every="$every" 'int((NR - 1) / 2) % every == 0' | tr '\n' '\0' |
  xargs -0 -n 2 -P "$jobs" sh "$out/one.sh" >"$out/rows.txt" 2>"$out/errors.txt"

# ---- what came out ----
awk -F'\t' '{ n[$1]++ } $4 != "judged" { odd[$1]++; next } { same[$1] += $5 <= 3; equal[$1] += $6; over6[$1] += $7 > 6; over8[$1] += $7 > 8
    over12[$1] += $7 > 12; cut[$1] += $9 > 0; text[$1] += $10 > 0; mean[$1] += $7 }
  END { printf "%-8s %6s %8s %12s %9s | bend, mean difference %5s %5s %5s | %7s %8s\n", "theme", "icons", "refused", "identity<=3", "bytes",
          "> 6", "> 8", "> 12", "cut off", "text"
    for (t in n) printf "%-8s %6d %8d %12d %9d | %21.2f %5d %5d %5d | %7d %8d\n", t, n[t], odd[t], same[t], equal[t], mean[t] / (n[t] - odd[t]),
          over6[t], over8[t], over12[t], cut[t], text[t] }' "$out/rows.txt"
awk -F'\t' '$4 != "judged" { print $4 ": " $2 }' "$out/rows.txt"
echo "The worst, by mean difference of the bend:"
grep -P '\tjudged\t' "$out/rows.txt" | sort -t"$(printf '\t')" -k7,7 -gr | head -20 >"$out/worst.txt"
awk -F'\t' '{ printf "  %6.2f  %5s  %s\n", $7, $3, $2 }' "$out/worst.txt"
folders=$(cut -f3 "$out/worst.txt" | while read -r number; do [ ! -d "$out/kept/$number" ] || echo "$out/kept/$number"; done)
# shellcheck disable=SC2086 # the list is meant to be split
[ -z "$folders" ] || "$out/judge" sheet "$out/worst.png" $folders
