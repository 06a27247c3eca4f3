#!/bin/sh
# Usage: round_trip.sh PROGRAMS MODULES FOLDER [SEED]
# deform_mesh moves each file of make_models.py and compress.mjs by affine poses of a box. compare_documents.py finds nothing but
# the points moved, and Khronos' validator no new error or warning. At rest, files of floats stay as they are, byte for byte.
# Broken files are refused. MODULES/node_modules has the packages of package.json; without them, compressed files and the
# validator are left out.
set -u
deform=$1/deform_mesh
modules=$2
mkdir -p "$3" && folder=$(cd "$3" && pwd) || exit 1
here=$(cd "$(dirname "$0")" && pwd)
python=/usr/bin/python3
failed=0
passed=0

fails() { # WHAT   and the log
  failed=$((failed + 1))
  echo "FAILED: $1"
  sed 's/^/    /' "$folder/log"
}
validated() { # FILE   each kind of error and warning once
  node "$here/validate.mjs" "$modules" "$1" | sed -n 's/^  \(error\|warning\) \([A-Z_]*\).*/\1 \2/p' | sort -u
}
refused() { # OUTPUT   one line, and no file
  [ "$(grep -c . "$folder/log")" -eq 1 ] && [ ! -e "$1" ]
}
moves() { # FILE KIND OPERATION…
  file=$(basename "$1") kind=$2 given=$1 input=$1 decoded=''
  shift 2
  out=$folder/$kind/$file
  [ ! -e "$folder/models/decoded/$file" ] || { input=$folder/models/decoded/$file decoded=--decoded; }
  if ! "$deform" "$given" --cage box "$@" -o "$out" >"$folder/log" 2>&1; then
    case $file in refused_*) refused "$out" && passed=$((passed + 1)) && return ;; esac
    fails "$kind $file"
    return
  fi
  "$python" "$here/compare_documents.py" "$input" "$out" "$@" $decoded >"$folder/log" 2>&1 || { fails "$kind $file"; return; }
  sed "s|.*/$kind/|$kind |" "$folder/log"
  case $kind/$file in
    */draco* | */meshopt* | */quantized*) ;;
    */buffers_of_glb.glb) ;; # its second buffer becomes part of the file
    rest/*.glb) cmp "$given" "$out" >"$folder/log" 2>&1 || { fails "$kind $file: the same bytes"; return; } ;;
  esac
  if [ -d "$modules/node_modules/gltf-validator" ]; then
    validated "$input" >"$folder/before"
    validated "$out" >"$folder/after"
    comm -13 "$folder/before" "$folder/after" >"$folder/log"
    [ ! -s "$folder/log" ] || { fails "$kind $file: new faults"; return; }
  fi
  passed=$((passed + 1))
}

rm -rf "$folder/models"
"$python" "$here/make_models.py" "$folder/models" "${4:-1}" || exit 1
if [ -d "$modules/node_modules/draco3dgltf" ]; then
  node "$here/compress.mjs" "$modules" "$folder/models" || exit 1
else
  echo "skipped: compressed files, which need npm's draco3dgltf and meshoptimizer"
fi
"$python" "$here/compare_test.py" "$folder/models" || exit 1
for kind in rest moved scaled turned stretched; do
  rm -rf "${folder:?}/$kind"
  mkdir "$folder/$kind"
  cp "$folder"/models/*.png "$folder/$kind"
done
for model in "$folder"/models/*.gl*; do
  moves "$model" rest --move all:0,0,0
  moves "$model" moved --move all:0.5,-0.25,1
  moves "$model" scaled --scale all:1.5@0.5,0,0
  moves "$model" turned --turn all:70,1,-1,0.5@0.2,0,0
  moves "$model" stretched --scale all:1.4,0.7,1.1@0,0,0 --turn all:40,y@0,1,0 --move all:1,2,-1 --scale all:0.8,1,1.2@0,0,1
done
echo "$passed passed, $failed failed"
"$python" "$here/broken_models.py" "$folder/broken" "$deform" '{in}' --cage box --scale all:1.5,0.8,1.2 -o '{out}' || failed=1
[ "$failed" -eq 0 ]
