#!/bin/sh
# Usage: sh examples/page/run.sh
# Installs what the page needs (Debian), compiles page.cpp and the library to WebAssembly, and writes
# out/cageform.html: one file that a browser opens by a double click, without a network.
set -eu
cd "$(dirname "$0")/../.."
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev libpugixml-dev zlib1g-dev libstb-dev libcli11-dev libtinyobjloader-dev \
  nlohmann-json3-dev libgmp-dev clang-19 lld-19 wasi-libc libc++-19-dev-wasm32 libc++abi-19-dev-wasm32 libclang-rt-19-dev-wasm32
page=examples/page
data=examples/data
work=build/page
mkdir -p out $work

echo "the character (its program takes some minutes to build the first time)"
[ -f build/build.ninja ] || cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE= -DCMAKE_CXX_FLAGS='-O2 -march=native' \
  -DCAGEFORM_BUILD_TESTS=OFF -DCAGEFORM_BUILD_BENCH=OFF >/dev/null
cmake --build build --target make_character >$work/build.txt 2>&1 || { cat $work/build.txt; exit 1; }
build/examples/make_character $work >/dev/null

echo "the library to WebAssembly (a minute)"
clang++-19 --target=wasm32-wasi -mexec-model=reactor -std=c++20 -O2 -flto -msimd128 -DNDEBUG -fno-exceptions -fno-rtti \
  -Wall -Wextra -Iinclude -isystem /usr/include/eigen3 $page/page.cpp -Wl,--strip-all -o $work/page.wasm

# packed FILE: as a string of JavaScript
packed() {
  printf '"'
  gzip -9 -n -c "$1" | base64 -w 0
  printf '"'
}
# Five digits of a dance are enough to be seen.
sed 's/\(\.[0-9]\{4\}\)[0-9]*/\1/g' $work/character_clip.csv >$work/character_clip.txt
# text FILE: the same, without packing
text() {
  printf '`'
  cat "$1"
  printf '`'
}
# Of the mesh only places and faces: normals are made anew.
for name in character character_cage character_pose; do
  sed -n -e 's|//[0-9]*||g' -e '/^[vf] /p' $work/$name.obj >$work/$name.txt
done

{
  cat <<'END'
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:">
<title>cageform</title>
<style>
END
  cat $page/style.css
  printf '</style>\n</head>\n<body>\n'
  cat $page/page.html
  printf '<div id="stage" aria-hidden="true"></div>\n<script>\n"use strict";\nconst DATA = {\n'
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
  for part in engine path figure cage field clip view app pointer timeline save mesh main; do cat $page/js/$part.js; done
  printf '</script>\n</body>\n</html>\n'
} >$work/cageform.html
mv $work/cageform.html out/cageform.html
echo "out/cageform.html: $(wc -c <out/cageform.html) bytes; open it in a browser"
