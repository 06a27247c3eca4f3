#!/bin/sh
# Usage: round_trip.sh PROGRAMS MODULES FOLDER [SEED]
# deform_mesh moves each file of make_models.py and compress.mjs by affine poses of a box. compare_documents.py finds nothing but the
# points moved, and Khronos' validator no new error or warning. At rest, files of floats stay as they are, byte for byte. Broken
# files are refused. MODULES/node_modules has the packages of package.json; without it, compressed files and the validator are left out.
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
validated() { # FILE   each error and warning, without places
  node "$here/validate.mjs" "$modules" "$1" | sed -n 's/^  \(error\|warning\) \([A-Z_]*\).*/\1 \2/p' | sort -u
}
moves() { # FILE KIND OPERATION…
  file=$1 kind=$2
  shift 2
  out=$folder/$kind/$(basename "$file") name="$kind $(basename "$file")" input=$file decoded=''
  if [ -e "$folder/models/decoded/$(basename "$file")" ]; then input=$folder/models/decoded/$(basename "$file") decoded=--decoded; fi
  if ! "$deform" "$file" --cage box "$@" -o "$out" >"$folder/log" 2>&1; then
    case $(basename "$file") in
      refused_*) if [ "$(grep -c . "$folder/log")" -eq 1 ] && [ ! -e "$out" ]; then passed=$((passed + 1)); else fails "$name: refused with one line"; fi ;;
      *) fails "$name" ;;
    esac
    return
  fi
  "$python" "$here/compare_documents.py" "$input" "$out" "$@" $decoded >"$folder/log" 2>&1 || { fails "$name"; return; }
  sed "s|.*/$kind/|$kind |" "$folder/log"
  if [ "$kind" = rest ]; then
    case $(basename "$file") in
      draco* | meshopt* | quantized*) ;;
      *.glb) cmp "$file" "$out" >"$folder/log" 2>&1 || { fails "$name: the same bytes"; return; } ;;
    esac
  fi
  if [ -d "$modules/node_modules/gltf-validator" ]; then
    validated "$input" >"$folder/before"
    validated "$out" >"$folder/after"
    comm -13 "$folder/before" "$folder/after" >"$folder/log"
    [ ! -s "$folder/log" ] || { fails "$name: new faults"; return; }
  fi
  passed=$((passed + 1))
}

rm -rf "$folder/models"
"$python" "$here/make_models.py" "$folder/models" ${4:-} || exit 1
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
for file in "$folder"/models/*.gl*; do
  moves "$file" rest --move all:0,0,0
  moves "$file" moved --move all:0.5,-0.25,1
  moves "$file" scaled --scale all:1.5@0.5,0,0
  moves "$file" turned --turn all:70,1,-1,0.5@0.2,0,0
  moves "$file" stretched --scale all:1.4,0.7,1.1@0,0,0 --turn all:40,y@0,1,0 --move all:1,2,-1 --scale all:0.8,1,1.2@0,0,1
done
echo "$passed passed, $failed failed"
"$python" "$here/broken_models.py" "$folder/broken" "$deform" '{in}' --cage box --move all:1,0,0 -o '{out}' || failed=1
[ "$failed" -eq 0 ]
