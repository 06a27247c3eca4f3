#!/bin/sh
# Usage: sh examples/page/run.sh
# Installs Debian packages, compiles page.cpp and the library to WebAssembly, and writes
# out/cageform.html, a single file that needs no network.
set -eu
cd "$(dirname "$0")/../.."
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev libpugixml-dev zlib1g-dev libstb-dev libcli11-dev libtinyobjloader-dev \
  nlohmann-json3-dev libgmp-dev python3 clang-19 lld-19 wasi-libc libc++-19-dev-wasm32 libc++abi-19-dev-wasm32 libclang-rt-19-dev-wasm32
page=examples/page
npm=examples/bindings/npm
data=examples/data
work=build/page
mkdir -p out $work

echo "the character (its program takes some minutes to build the first time)"
[ -f build/build.ninja ] || cmake --preset examples >/dev/null
cmake --build build --target make_character >$work/build.txt 2>&1 || { cat $work/build.txt; exit 1; }
build/examples/make_character $work >/dev/null

/usr/bin/python3 $npm/write_module.py include/cageform/c/cageform.h include/cageform/version.hpp $work
if [ ! -f $work/page.wasm ] || [ -n "$(find include $page/*.?pp $page/run.sh $npm/cageform.cpp $npm/compile.sh -newer $work/page.wasm -type f)" ]; then
  echo "the library to WebAssembly (a minute)"
  # Loops over coordinates are unrolled, which halves the time of a 3D cage. Unrolling longer loops and automatic
  # vectorisation would make the page 7 % larger and not faster.
  options=
  for option in -unroll-full-max-count=4 -unroll-runtime=0 -unroll-allow-partial=0 -vectorize-loops=false -vectorize-slp=false; do
    options="$options -mllvm $option -Wl,-mllvm,$option"
  done
  for name in free status_text coordinates_create coordinates_describe coordinates_rest coordinates_solve bind binding_figure \
    figure_describe clone pose_handles make_cage made_cage_describe bytes_view \
    pose_samples samples_pack samples_open samples_describe call_begin call_undo call_progress; do
    options="$options -Wl,--export=cageform_$name"
  done
  # shellcheck disable=SC2086  # the list is meant to be split
  sh $npm/compile.sh $page/page.cpp $work/page.wasm -I$work -funroll-loops $options \
    -Wl,--export=malloc,--export=free,--export=__stack_pointer
fi

# packed FILE: prints the packed file as a JavaScript string
packed() {
  printf '"'
  gzip -9 -n -c "$1" | base64 -w 0
  printf '"'
}
# Five digits are enough for the dance.
sed 's/\(\.[0-9]\{4\}\)[0-9]*/\1/g' $work/character_clip.csv >$work/character_clip.txt
# text FILE: the same without packing
text() {
  printf '`'
  cat "$1"
  printf '`'
}
# The mesh has only positions and faces; normals are computed. A face follows directly after its last vertex, with relative
# indices, because this packs better.
for name in character character_cage character_pose; do
  sed -n -e 's|//[0-9]*||g' -e '/^[vf] /p' $work/$name.obj | awk '
    /^v / { place[++count] = $0 }
    /^f / {
      last = 0; face = "f"
      for (k = 2; k <= NF; ++k) if ($k + 0 > last) last = $k + 0
      for (k = 2; k <= NF; ++k) face = face " " $k - last - 1
      faces[last] = faces[last] face "\n"
    }
    END { for (i = 1; i <= count; ++i) printf "%s\n%s", place[i], faces[i] }' >$work/$name.txt
done

# The script of the page. The parts share one scope, in this order.
{
  printf '\n"use strict";\nconst DATA = {\n'
  for name in cat aleph biped; do
    printf '%s: { figure: ' $name
    text $data/$name.svg
    printf ', cage: '
    text $data/${name}_cage.svg
    printf ' },\n'
  done
  printf 'walk: '
  text $data/cat_walk.csv
  printf ',\ncharacter: { mesh: '
  packed $work/character.txt
  printf ', cage: '
  packed $work/character_cage.txt
  printf ', pose: '
  packed $work/character_pose.txt
  printf ', dance: '
  packed $work/character_clip.txt
  printf ' },\nwasm: '
  packed $work/page.wasm
  printf '\n};\n'
  # The npm package as a function that returns its exports, because plain scripts have no modules. Strips comments and indentation.
  printf 'function cageformPackage() {\n'
  { cat $work/layout.js; for part in host engine numbers figures cages bindings pins; do cat $npm/package/$part.js; done; } |
    sed -e '/^import .*;$/d' -e '/^import {$/,/;$/d' -e '/^ *\/\*\*.*\*\/$/d' -e '/^ *\/\*\*/,/\*\//d' -e '/^ *\/\//d' -e 's/^ *//' -e 's/^export //'
  printf 'return { CHANGING, Cage, Coordinates, Samples, makeCage, openSamples, start, started, taken };\n}\n'
  printf 'const cageform = cageformPackage();\n'
  for part in engine read path safe_svg figure cage kinds field clip pins plane_pins view app pointer timeline save mesh mesh_pins keep main; do cat $page/js/$part.js; done
} >$work/page.js

# hash FILE: prints the hash of a script or style for the content security policy
hash() {
  printf "'sha256-%s'" "$(sha256sum <"$1" | cut -c 1-64 | tr a-f A-F | basenc --base16 -d | base64)"
}

# The policy allows no other script and no other style.
{
  cat <<END
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src $(hash $work/page.js) 'wasm-unsafe-eval'; style-src $(hash $page/style.css); img-src data: blob:; worker-src blob:; base-uri 'none'; form-action 'none'">
<title>cageform</title>
END
  printf '<style>'
  cat $page/style.css
  printf '</style>\n</head>\n<body>\n'
  cat $page/page.html
  printf '<div id="stage" aria-hidden="true"></div>\n<script>'
  cat $work/page.js
  printf '</script>\n</body>\n</html>\n'
} >$work/cageform.html
mv $work/cageform.html out/cageform.html
echo "out/cageform.html: $(wc -c <out/cageform.html) bytes; open it in a browser"
