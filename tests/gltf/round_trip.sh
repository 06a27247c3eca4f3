#!/bin/sh
# Usage: round_trip.sh PROGRAMS MODULES FOLDER [SEED]
# deform_mesh moves each file of make_models.py and compress.mjs by affine poses of a box. compare_documents.py checks that
# only points have moved. Khronos' validator must find no new error or warning. At rest, files of floats keep all their bytes.
# Broken files are refused. MODULES/node_modules has the packages of package.json; without them, compressed files and the
# validator are left out.
set -u
deform=$1/deform_mesh
modules=$2
mkdir -p "$3" && folder=$(cd "$3" && pwd) || exit 1
here=$(cd "$(dirname "$0")" && pwd)
python=/usr/bin/python3
failed=0

fails() { # WHAT   prints WHAT and the log
  failed=$((failed + 1))
  echo "FAILED: $1"
  sed 's/^/    /' "$folder/log"
}
issues() { # FILE…   lines with the name of a file and an error or a warning
  node "$here/validate.mjs" "$modules" "$@" | awk '/^[^ ]/ { sub(/: [0-9]+ errors.*/, ""); sub(/.*\//, ""); file = $0 }
    /^  (error|warning) / { print file, $1, $2 }' | sort -u
}
poses() { # KIND OPERATION…
  kind=$1
  shift
  rm -rf "${folder:?}/$kind"
  mkdir "$folder/$kind"
  for model in "$folder"/models/*.gl*; do
    name=$(basename "$model")
    if "$deform" "$model" --cage box "$@" -o "$folder/$kind/$name" >"$folder/log" 2>&1; then
      case $kind/$name in
        */draco* | */meshopt* | */quantized* | */buffers_of_glb.glb) ;; # the last gets its second buffer into the file
        rest/*.glb) cmp "$model" "$folder/$kind/$name" >"$folder/log" 2>&1 || fails "$kind $name: the same bytes" ;;
      esac
    else
      case $name in refused_*) [ "$(grep -c . "$folder/log")" -eq 1 ] && [ ! -e "$folder/$kind/$name" ] && continue ;; esac
      fails "$kind $name"
    fi
  done
  "$python" "$here/compare_documents.py" "$folder/models" "$folder/$kind" "$@" >"$folder/log" 2>&1 || fails "$kind: the same documents"
  sed "s|.*/$kind/|$kind |" "$folder/log"
  if [ -d "$modules/node_modules/gltf-validator" ]; then
    issues "$folder/$kind"/*.gl* >"$folder/after"
    comm -13 "$folder/before" "$folder/after" >"$folder/log"
    [ ! -s "$folder/log" ] || fails "$kind: no new errors and warnings"
  fi
}

rm -rf "$folder/models"
"$python" "$here/make_models.py" "$folder/models" "${4:-1}" || exit 1
if [ -d "$modules/node_modules/draco3dgltf" ]; then
  node "$here/compress.mjs" "$modules" "$folder/models" || exit 1
  issues "$folder"/models/*.gl* "$folder"/models/decoded/*.gl* >"$folder/before"
else
  echo "skipped: compressed files and the validator, which need npm"
fi
"$python" "$here/compare_test.py" "$folder/models" || exit 1
poses rest --move all:0,0,0
poses moved --move all:0.5,-0.25,1
poses scaled --scale all:1.5@0.5,0,0
poses stretched --scale all:1.4,0.7,1.1@0,0,0 --turn all:40,y@0,1,0 --move all:1,2,-1 --scale all:0.8,1,1.2@0,0,1
"$python" "$here/broken_models.py" "$folder/broken" "$deform" '{in}' --cage box --scale all:1.5,0.8,1.2 -o '{out}' >"$folder/log" ||
  fails "broken files"
tail -n 1 "$folder/log"
echo "$failed failed"
[ "$failed" -eq 0 ]
