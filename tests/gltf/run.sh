#!/bin/sh
# Usage: run.sh PROGRAMS PLAYBACK FOLDER
# Every kind of file that export_gltf, fit_skeleton, skin_mesh and make_hand write is played by a second reader (PLAYBACK) and compared with the clone. Every
# file, also that of make_character, has neither errors nor warnings of Khronos' validator, which is installed from npm into FOLDER. Wrong arguments
# and broken files exit with 1, name the culprit and leave nothing behind. Exit code 77: no npm here, all else passed.
set -u
programs=$1
playback=$2
folder=$3
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$folder" && folder=$(cd "$folder" && pwd) || exit 1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export="$programs/export_gltf"
passed=0
failed=0

report() { # OK? WHAT
  if [ "$1" = yes ]; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED: $2"; cat log 2>/dev/null; fi
}
works() { # WHAT COMMAND…
  what=$1; shift
  if "$@" >log 2>&1; then report yes "$what"; else report no "$what (exit $?)"; fi
}
says() { # MESSAGE   of the command before
  grep -qF -- "$1" log && report yes "$1" || report no "says: $1"
}
says_not() { # MESSAGE
  grep -qF -- "$1" log && report no "does not say: $1" || report yes "$1"
}
refuses() { # MESSAGE COMMAND…   exits 1, says MESSAGE, writes neither out.* nor a temporary file
  message=$1; shift
  rm -f out.* ./*.tmp*
  "$@" >log 2>&1
  code=$?
  ok=yes
  [ "$code" -eq 1 ] || { ok=no; echo "exit code $code" >>log; }
  grep -qF -- "$message" log || { ok=no; echo "does not say: $message" >>log; }
  [ -z "$(find . -name 'out.*' -o -name '*.tmp*')" ] || { ok=no; echo "left a file behind" >>log; }
  report "$ok" "$*"
}

# ---- the character: every kind of file, played ----
works "the character is made" "$programs/make_character" .
works "the character of a game" "$programs/make_character" -o player.glb
says 'player.glb: 28 nodes, 6 meshes, 8 materials, 2 animations, '
works "the character of a game, again" "$programs/make_character" -o again.glb
cmp -s player.glb again.glb && report yes same || report no "the same character twice"
works "the character of a game as text" "$programs/make_character" -o player.gltf
refuses 'does not end with .glb or .gltf' "$programs/make_character" -o out.obj
refuses 'missing/out.glb' "$programs/make_character" -o missing/out.glb
cage="--cage character_cage.obj"
clip="--clip character_clip.csv"
works "the first vertices of the character" awk -v n=800 '$1 == "v" && ++v > n { next } $1 == "vn" && ++m > n { next }
  $1 == "f" { for (k = 2; k <= 4; k++) { split($k, a, "/"); if (a[1] > n || a[3] > n) next } } { print }' character.obj
cp log part.obj
# shellcheck disable=SC2086  # options are meant to be split
{
  works "a skin of 4" "$export" character.obj $cage $clip --coordinates mean-value --skin 4 -o skin_4.glb
  says 'warning: character.obj: a skin of 4 joints per vertex is off by at most'
  works "a skin of 16" "$export" part.obj $cage $clip --coordinates mean-value --skin 16 -o skin_16.glb
  works "a skin as text, weights of 8 bits" "$export" part.obj $cage $clip --coordinates mean-value --skin 4 --weights unorm8 -o unorm8.gltf
  works "weights of 16 bits" "$export" part.obj $cage $clip --coordinates mean-value --skin 8 --weights unorm16 -o unorm16.glb
  works "morph targets" "$export" part.obj $cage $clip --coordinates mean-value --morph -o morph.glb
  works "morph targets as text" "$export" part.obj $cage $clip --coordinates mean-value --morph -o morph.gltf
}
works "played by a second reader" "$playback" character.obj character_cage.obj character_clip.csv skin_4.glb
cat log
works "parts, played by a second reader" "$playback" part.obj character_cage.obj character_clip.csv \
  skin_16.glb unorm8.gltf unorm16.glb morph.glb morph.gltf
cat log
printf 'v 0 0 0\n' >point.obj
echo 'trunk,,0,0.9,0,0,1.4,0,0,0,0' >one.csv
echo 'far,,5,0,0,5,1,0,0,0,0' >far.csv
: >bare.csv
# Some vertices have one normal and some have several: the order of the file is kept all the same.
awk '$1 == "f" && ++faces % 7 == 0 { split($2, a, "/"); split($3, b, "/"); split($4, c, "/"); n = a[3]
  $2 = a[1] "//" n; $3 = b[1] "//" n; $4 = c[1] "//" n } { print }' character.obj >creases.obj
# shellcheck disable=SC2086
works "vertices with several normals" "$export" creases.obj $cage $clip --morph -o creases.glb
works "the order of the vertices" "$playback" creases.obj character_cage.obj character_clip.csv creases.glb
sed 's|^pose,0.7,|pose,0.76,|' character_clip.csv >other.csv
"$playback" character.obj character_cage.obj other.csv skin_4.glb >log 2>&1 && report no "the second reader sees another clip" || report yes other

# ---- far from the origin, as maps have it ----
away='{ for (k = 2; k <= 4; k++) $k += (k == 2) * 500000 + (k == 3) * 4600000 + (k == 4) * 20 } { print }'
for name in character.obj character_cage.obj character_pose.obj; do
  awk -v CONVFMT=%.17g -v OFMT=%.17g '$1 != "v" { print; next } '"$away" $name >far_$name
done
awk -F, -v OFS=, -v CONVFMT=%.17g -v OFMT=%.17g '/^(length|pose|#)/ || NF != 3 { print; next } { $1 += 500000; $2 += 4600000; $3 += 20; print }' character_clip.csv >far_clip.csv
far="far_character.obj --cage far_character_cage.obj --coordinates mean-value --clip far_clip.csv"
# shellcheck disable=SC2086
{
  works "a skin far away" "$export" $far --skin 4 -o far_skin.glb
  works "targets far away" "$export" $far --morph -o far_morph.glb
}
works "far away, played by a second reader" "$playback" far_character.obj far_character_cage.obj far_clip.csv far_skin.glb far_morph.glb
cat log
# ---- a skeleton fitted to a motion ----
# shellcheck disable=SC2086
{
  works "bones by a distance" "$export" part.obj $cage $clip --coordinates mean-value --bones auto --max-distance 1% -o bones_auto.glb --report --picture bones_auto.png
  says 'keys: '
  says 'turned wrongly by '
  works "poses of the clip" "$programs/bind_mesh" part.obj $cage $clip --coordinates mean-value -o part.figure
  mkdir -p frames && works "frames" "$programs/clone_figure" part.figure --poses character_clip.csv --rate 30 --mesh part.obj -o 'frames/%03d.obj'
  works "bones, played by the second reader" "$playback" --near 0.012 part.obj bones_auto.glb 0.1 frames/003.obj 0.3 frames/009.obj 0.6 frames/018.obj
  "$playback" --near 0.012 part.obj bones_auto.glb 0.1 frames/018.obj >log 2>&1 && report no "the second reader sees another frame" || report yes other
  for kind in rigid similar stretched; do
    works "a skeleton of $kind bones" "$programs/fit_skeleton" part.obj frames/00?.obj frames/01?.obj -o fitted_$kind.glb --bones 6 --kind $kind --report
    works "$kind bones, played by the second reader" "$playback" --near 0.05 part.obj fitted_$kind.glb 0.3 frames/009.obj 0.6 frames/018.obj
    cat log
  done
  for frame in part.obj frames/00[0-9].obj frames/01[0-9].obj; do
    awk -v CONVFMT=%.17g -v OFMT=%.17g '$1 != "v" { print; next } '"$away" "$frame" >"far_$(basename "$frame")"
  done
  works "a skeleton far away" "$programs/fit_skeleton" far_part.obj far_00?.obj far_01?.obj -o far_fitted.glb --bones 6 --report
  works "that, played by the second reader" "$playback" --near 0.05 far_part.obj far_fitted.glb 0.3 far_009.obj 0.6 far_018.obj
  grep -aq '"NORMAL"' fitted_rigid.glb && report yes normals || report no "normals are there, which players turn"
  works "a flat skeleton as text" "$programs/fit_skeleton" part.obj frames/00?.obj frames/01?.obj -o fitted_flat.gltf --bones 6 --flat --influences 6
  works "that, played by the second reader" "$playback" --near 0.05 part.obj fitted_flat.gltf 0.3 frames/009.obj 0.6 frames/018.obj
  works "normals of the file" "$export" creases.obj $cage --pose character_pose.obj --coordinates mean-value --bones 3 --weights unorm8 -o bones_creases.glb
  refuses '--bones needs a motion' "$export" part.obj $cage --bones 4 -o out.glb
  refuses '"many" is neither "auto" nor a number of bones' "$export" part.obj $cage $clip --bones many -o out.glb
  refuses '--picture need --bones' "$export" part.obj $cage $clip --skin 4 --flat -o out.glb
  refuses 'use a larger --max-distance, --bones auto, more --influences or --kind similar' "$export" part.obj $cage $clip --coordinates mean-value --bones 1 --max-distance 0.1% -o out.glb
  refuses 'is not a fraction such as 0.002 or 0.2%' "$export" part.obj $cage $clip --bones auto --max-distance 200% -o out.glb
}

# ---- documents in ----
plays_alike() { # SHARE GLB GLB   the last animations move the vertices alike
  /usr/bin/python3 - "$here" "$@" <<'END'
import sys
import numpy as np
sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv[1])
from glb import Document
def played(path, share):
    document = Document(path)
    last = len(document.list("animations")) - 1
    rows = document.evaluate(last, share * document.last_time(last))
    return np.concatenate([part["POSITION"] for part in rows.values()])
moved = 0
for share in np.linspace(0, 1, 7):
    a, b = played(sys.argv[3], share), played(sys.argv[4], share)
    if share == 0: rest, size = b, np.linalg.norm(np.ptp(b, axis=0))
    off, moved = np.abs(a - b).max() / size, max(moved, np.abs(b - rest).max() / size)
    if not off <= float(sys.argv[2]): sys.exit("%s of the size apart" % off)
sys.exit(int(moved < 0.05))
END
}
# shellcheck disable=SC2086
{
  works "a document without motion" "$export" part.obj $cage --coordinates mean-value --skin 4 -o document.glb
  works "a document, a skin" "$export" document.glb $cage $clip --coordinates mean-value --skin 16 -o document_skin.glb
  says 'note: document.glb: its skin is replaced'
  works "a document, morph targets" "$export" document.glb $cage $clip --coordinates mean-value --morph -o document_morph.gltf
  says_not 'is replaced'
  works "a document, bones" "$export" document.glb $cage $clip --coordinates mean-value --bones auto --max-distance 1% -o document_bones.glb
  works "a document, weights of a surface" "$programs/skin_mesh" skin_4.glb --bones character.bones.csv -o document_surface.glb
  works "the animation of a document" "$programs/fit_skeleton" skin_16.glb --max-distance 1% -o document_fitted.glb
  works "a player's walk" "$programs/fit_skeleton" player.glb --animation walk --rate 20 -o player_fitted.glb
  refuses 'player.glb: has no animation "run"; it has "walk", "greeting"' "$programs/fit_skeleton" player.glb --animation run -o out.glb
  printf '%s\n' 'MeshVersionFormatted 2' 'Dimension 3' Vertices 4 '0 0 0 0' '1 0 0 0' '0 1 0 0' '0 0 1 0' \
    Triangles 4 '1 3 2 0' '1 2 4 0' '2 3 4 0' '1 4 3 0' End >medit.mesh
  refuses 'medit.mesh: is a Medit mesh, which is not written as glTF' "$export" medit.mesh --cage box --skin 8 -o out.glb
  refuses 'part.obj: has no animation: give frames' "$programs/fit_skeleton" part.obj -o out.glb
}
works "a document, played by the second reader" "$playback" part.obj character_cage.obj character_clip.csv document_skin.glb
for files in "1e-5 document_skin.glb skin_16.glb" "1e-5 document_morph.gltf morph.glb" "0.02 document_bones.glb bones_auto.glb" \
  "0.02 document_fitted.glb skin_16.glb"; do
  # shellcheck disable=SC2086
  works "$files play alike" plays_alike $files
done
plays_alike 1e-5 document_morph.gltf skin_16.glb >log 2>&1 && report no "the comparison sees another motion" || report yes other
works "models with every property of the format" /usr/bin/python3 "$here/export_models.py" "$programs" models
tail -n 1 log

# ---- bones: weights found on the surface ----
skin="$programs/skin_mesh"
for weights in heat harmonic; do
  works "bones, $weights" "$skin" character.obj --bones character.bones.csv --weights $weights -o bones_$weights.glb --picture bones.png --report
  says 'negative cotangent weights: 0'
done
echo 'trunk,,0,0.9,0,0,1.4,0,30000,0,30000' >spun.csv
refuses 'spun.csv:1: the bone "trunk" turns by 42426.4 degrees, more than 36000' "$skin" character.obj --bones spun.csv -o out.glb
awk -F, -v OFS=, -v CONVFMT=%.17g -v OFMT=%.17g 'NF == 11 && $3 + 0 == $3 { $3 += 500000; $6 += 500000; $4 += 4600000; $7 += 4600000; $5 += 20; $8 += 20 } { print }' \
  character.bones.csv >far_bones.csv
works "bones far away" "$skin" far_character.obj --bones far_bones.csv -o far_bones.gltf
{ cat far_character.obj; echo 'v 0 0 0'; } >stray.obj
works "bones far away, a stray vertex" "$skin" stray.obj --bones far_bones.csv -o far_stray.gltf --report
for file in far_bones far_stray; do awk '/"translation"/ { print; left = 4; next } left-- > 0' $file.gltf >$file.places; done
cmp far_bones.places far_stray.places && report yes stray || report no "a stray vertex changes no place"
awk '/"translation"/ { left = 4 } left-- > 0 && $1 + 0 > 4000000 { far++ } END { exit far != 1 }' far_bones.gltf && report yes far ||
  report no "bones far away: one node alone has a place far from the origin"
# Vertices that a file splits have the weights of one vertex: each face with vertices of its own, printed 1e-7 apart.
split_faces() { # FILE SEED
  awk -v seed="$2" 'BEGIN { srand(seed) } function near(x) { return sprintf(" %.9f", x + (rand() - 0.5) * 2e-7) }
  $1 == "v" { v[++n] = $0 } $1 == "f" { f = "f"; for (k = 2; k <= NF; k++) { split($k, a, "/"); split(v[a[1]], p, " "); print "v" near(p[2]) near(p[3]) near(p[4]); f = f " " ++m } faces = faces f "\n" }
  END { printf "%s", faces }' "$1"
}
seed=59
split_faces character.obj $seed >split_character.obj
for frame in part frames/000 frames/005 frames/010 frames/015; do
  seed=$((seed + 1))
  split_faces $frame.obj $seed >"split_$(basename $frame).obj"
done
for weights in heat harmonic; do
  works "split vertices, $weights" "$skin" split_character.obj --bones character.bones.csv --weights $weights -o split_$weights.glb
  says_not 'is not closed'
done
split_apart() { # GLB   exits 0 if vertices at one place have other joints or weights than each other
  python3 - "$1" <<'END'
import json, struct, sys
data = open(sys.argv[1], "rb").read()
size = struct.unpack_from("<I", data, 12)[0]
scene, data = json.loads(data[20:20 + size]), data[28 + size:]
kinds = {5121: "B", 5123: "H", 5126: "f"}
def rows(index):
    a = scene["accessors"][index]; view = scene["bufferViews"][a["bufferView"]]
    n = {"VEC3": 3, "VEC4": 4}[a["type"]]; kind = kinds[a["componentType"]]; width = n * struct.calcsize(kind)
    begin = view.get("byteOffset", 0) + a.get("byteOffset", 0)
    return [struct.unpack_from("<%d%s" % (n, kind), data, begin + i * view.get("byteStride", width)) for i in range(a["count"])]
known, vertices = {}, 0
for mesh in scene["meshes"]:
    at = mesh["primitives"][0]["attributes"]
    for place, joints, weights in zip(rows(at["POSITION"]), rows(at["JOINTS_0"]), rows(at["WEIGHTS_0"])):
        place, vertices = tuple(round(x, 5) for x in place), vertices + 1
        if known.setdefault(place, (joints, weights)) != (joints, weights): sys.exit(0)
sys.exit(len(known) < vertices / 2)  # most copies were compared
END
}
works "split vertices, a cage" "$export" split_part.obj $cage $clip --skin 4 -o split_cage.glb
works "split vertices, frames" "$programs/fit_skeleton" split_part.obj split_0??.obj --bones 3 --influences 2 -o split_frames.glb
for weights in heat harmonic cage frames; do
  split_apart split_$weights.glb && report no "equal places have equal weights, $weights" || report yes split
done
printf '%s\n' 'left,,-0.2,1,0,-0.6,1,0,0,0,0' 'right,,0.2,1,0,0.6,1,0,0,0,0' >roots.csv
works "two bones without a parent" "$skin" character.obj --bones roots.csv --see-through -o roots.gltf
grep -q '"skeleton": 1' roots.gltf && report yes roots || report no "a node is above both"
works "one bone that stands" "$skin" character.obj --bones one.csv --weights harmonic --skin 1 -o bones_one.gltf
sed '/^f 7/d' character.obj >open_character.obj
works "an open mesh" "$skin" open_character.obj --bones character.bones.csv --see-through --skin 8 -o bones_open.glb
works "an open mesh, unasked" "$skin" open_character.obj --bones character.bones.csv --skin 8 -o bones_unasked.glb
says 'note: open_character.obj: the mesh is not closed'
cmp bones_open.glb bones_unasked.glb && report yes unasked || report no "as with --see-through"
works "a picture of what is written" "$skin" character.obj --bones character.bones.csv --weights harmonic --skin 1 -o bones_few.glb --picture few.png
says 'warning: character.obj: a skin of 1 bones per vertex is off by at most'
works "a picture of more" "$skin" character.obj --bones character.bones.csv --weights harmonic --skin 4 -o bones_more.glb --picture more.png
cmp -s few.png more.png && report no "pictures draw the skin that is written" || report yes drawn
works "from another side" "$skin" character.obj --bones character.bones.csv --weights harmonic -o bones_up.glb --picture up.png --up z --view 20,30
cmp -s up.png more.png && report no "--up and --view turn the picture" || report yes view
refuses '--view' "$skin" character.obj --bones character.bones.csv -o out.glb --picture out.png --view 20
refuses 'no bone moves the part of the mesh about v 1 ' "$skin" character.obj --bones far.csv -o out.glb
refuses 'there is no bone "nobody"' "$skin" character.obj --bones one.csv --weights harmonic --red nobody -o out.glb
refuses 'missing/out.png' "$skin" character.obj --bones one.csv --weights harmonic -o out.glb --picture missing/out.png
refuses 'point.obj: holds no faces' "$skin" point.obj --bones one.csv -o out.glb
refuses 'bare.csv: holds no bones' "$skin" character.obj --bones bare.csv -o out.glb
refuses '--bones is required' "$skin" character.obj -o out.glb
faulty_bones() { # MESSAGE LINES…
  message=$1; shift
  printf '%s\n' "$@" >bones.csv
  refuses "$message" "$skin" character.obj --bones bones.csv -o out.glb
}
faulty_bones 'bones.csv:2: 10 columns, where a bone has 11' '# a comment' 'a,,0,0,0,0,1,0,0,0'
faulty_bones 'bones.csv:1: column 11: not a number: "x"' 'a,,0,0,0,0,1,0,0,0,x'
faulty_bones 'bones.csv:1: column 3: a number is not finite' 'a,,inf,0,0,0,1,0,0,0,0'
faulty_bones 'bones.csv:1: column 3: ' 'a,,1e99,0,0,0,1,0,0,0,0'
faulty_bones 'bones.csv:1: the parent "b" has to come before its child' 'a,b,0,0,0,0,1,0,0,0,0' 'b,,0,0,0,0,1,0,0,0,0'
faulty_bones 'bones.csv:2: there are two bones "a"' 'a,,0,0,0,0,1,0,0,0,0' 'a,,0,0,0,0,1,0,0,0,0'
faulty_bones 'bones.csv:1: the bone has no name' ',,0,0,0,0,1,0,0,0,0'

# ---- a hand: linear between morph targets a quarter of a second apart ----
works "a hand" "$programs/make_hand" .
for pose in fist ball; do works "the hand: $pose" "$programs/pose_hand" --pose $pose -o hand_$pose.obj; done
works "the hand, played by the second reader" "$playback" --at hand.obj hand.glb 1 hand_fist.obj 3 hand_ball.obj
cat log
"$playback" --at hand.obj hand.glb 3 hand_fist.obj >log 2>&1 && report no "the second reader sees another pose" || report yes other

# ---- Green coordinates: the poses of faces are between those of the cage and the figure's ----
# shellcheck disable=SC2086
{
  works "targets by Green coordinates" "$export" character.obj $cage --pose character_pose.obj --morph --coordinates green -o green.glb
  for type in green mean-value; do
    works "the pose, $type" "$programs/deform_mesh" character.obj $cage --pose character_pose.obj --coordinates $type -o posed_$type.obj
  done
  refuses '--skin cannot represent normals of faces' "$export" character.obj $cage $clip --skin 4 --coordinates green -o out.glb
}
works "Green targets, played by the second reader" "$playback" --at character.obj green.glb 1 posed_green.obj
cat log
"$playback" --at character.obj green.glb 1 posed_mean-value.obj >log 2>&1 && report no "the second reader sees another type" || report yes other

# ---- other shapes of input, for the validator ----
# shellcheck disable=SC2086
{
  works "harmonic, no motion" "$export" part.obj $cage --skin 5 --resolution 32 -o still.glb
  works "a threshold, and a report" "$export" part.obj $cage $clip --skin 12 --threshold 0.05 --report -o threshold.glb
  says 'not reproduced: 0'
  says 'off by at most '
  says 'edges by at most '
  says 'poses of the motion'
  works "as many joints as a distance takes" "$export" part.obj $cage $clip --coordinates mean-value --max-distance 0.012 --report -o near.glb
  says 'skin: 8 weights at most'
  refuses 'a skin of 16 joints per vertex is off by at most' "$export" part.obj $cage $clip --coordinates mean-value --max-distance 0.0001 -o out.glb
  refuses 'not even --skin 16 is enough' "$export" part.obj $cage $clip --coordinates mean-value --skin 4 --max-distance 0.001 --weights unorm8 -o out.glb
  refuses '--skin 8 is enough' "$export" part.obj $cage $clip --coordinates mean-value --skin 4 --max-distance 0.012 -o out.glb
  refuses '--morph' "$export" character.obj $cage $clip --morph --max-distance 0.1 -o out.glb
  refuses '--max-distance' "$export" character.obj $cage $clip --max-distance 2 -o out.glb
  works "through a pose" "$export" part.obj $cage --pose character_pose.obj --skin 4 --seconds 0.5 -o pose.glb
  works "a target a pose" "$export" character.obj $cage --pose character_pose.obj character_pose.obj --morph -o poses.gltf
  grep -q '"character_pose"' poses.gltf && report yes name || report no "a target has the name of its pose"
  works "too few joints" "$export" part.obj $cage --skin 2 -o few.glb
  says '2 weights are too few for'
}
# A box of quadrilaterals with a texture and no normals, in a box as its cage; one corner of it stands out.
printf '%s\n' 'v 0 0 0' 'v 4 0 0' 'v 4 4 0' 'v 0 4 0' 'v 0 0 4' 'v 4 0 4' 'v 4 4 4' 'v 0 4 4' >corners
printf '%s\n' 'f 4 3 2 1' 'f 5 6 7 8' 'f 1 2 6 5' 'f 2 3 7 6' 'f 3 4 8 7' 'f 4 1 5 8' >faces
cat corners faces >box.obj
sed 's/^v 4 4 4/v 5 6 5/' box.obj >box_pose.obj
sed 's/4/3/g; s/0/1/g' corners >inner
printf '%s\n' 'vt 0 0' 'vt 1 0' 'vt 1 1' 'vt 0 1' 'f 4/1 3/2 2/3 1/4' 'f 5/1 6/2 7/3 8/4' 'f 1/1 2/2 6/3 5/4' 'f 2/1 3/2 7/3 6/4' \
  'f 3/1 4/2 8/3 7/4' 'f -5/-4 -8/-3 -4/-2 -1/-1' | cat inner - >textured.obj
sed 's/^v 3 3 3/v 9 3 3/' textured.obj >stray.obj
for type in mean-value harmonic; do
  works "a texture, $type" "$export" textured.obj --cage box.obj --pose box_pose.obj --coordinates $type --skin 4 -o textured_$type.gltf
done
grep -q TEXCOORD_0 textured_harmonic.gltf && report yes texture || report no "texture coordinates are there"
works "a texture, targets" "$export" textured.obj --cage box.obj --pose box_pose.obj --morph -o textured_morph.glb
works "a vertex kept in place" "$export" stray.obj --cage box.obj --pose box_pose.obj --outside keep-in-place --skin 4 -o kept.gltf
grep -q '"still"' kept.gltf && report yes still || report no "a joint that stays is there"
works "a vertex outside" "$export" stray.obj --cage box.obj --pose box_pose.obj --skin 4 -o outside.glb
says 'warning: 1 of 8 vertices of stray.obj lie outside the cage box.obj, first v 7 (9, 3, 3); they follow the nearest points of the boundary'
works "a vertex that follows the boundary" "$export" stray.obj --cage box.obj --pose box_pose.obj --outside nearest-boundary --skin 4 -o nearest.glb
works "a vertex kept in place, targets" "$export" stray.obj --cage box.obj --pose box_pose.obj --outside keep-in-place --morph -o kept_morph.glb

# ---- objects and materials ----
printf '%s\n' 'newmtl red' 'Kd 0.8 0.1 0.05' 'newmtl glass' 'Kd 0.5 0.7 0.9' 'd 0.25' 'newmtl lamp' 'Ke 3 2 1' 'newmtl wood' 'Kd 1 1 1' \
  'map_Kd pictures\wood grain.png' >parts.mtl
mkdir -p pictures ../outside_$$
echo iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg== | base64 -d >'pictures/wood grain.png'
printf '\211PNG\r\n\032\nnot ours' >../outside_$$/secret.png
{
  echo 'mtllib parts.mtl'
  cat inner
  printf '%s\n' 'vt 0 0' 'vt 1 0' 'vt 1 1' 'o first' 'usemtl red' 'f 4/1 3/2 2/3 1/1' 'usemtl glass' 'f 5/1 6/2 7/3 8/1' 'o second' 'usemtl lamp' \
    'f 1/1 2/2 6/3 5/1' 'f 2/1 3/2 7/3 6/1' 'o third' 'usemtl wood' 'f 3/1 4/2 8/3 7/1' 'f 4/1 1/2 5/3 8/1'
} >parts.obj
for way in "--skin 4" "--morph" "--bones 1"; do
  # shellcheck disable=SC2086
  works "objects and materials, $way" "$export" parts.obj --cage box.obj --twist all:z,0,4,40 $way -o parts.gltf
  says '3 objects, 4 materials'
  for name in first second third red glass lamp wood BLEND image/png KHR_materials_emissive_strength; do
    grep -q "\"$name\"" parts.gltf && report yes "$name" || report no "$way: parts.gltf has $name"
  done
  [ "$(grep -c '"indices"' parts.gltf)" = 4 ] && report yes primitives || report no "$way: a primitive for every material of an object"
done
# Files of other programs: a byte order mark, no Kd, -halo, pictures of alpha, of emission and of normals, and more.
cp 'pictures/wood grain.png' seen.png
printf '\357\273\277newmtl red\nKd 0.25 0.5 1\nmap_Kd seen.png\nmap_d seen.png\nKa 1 1 1\nmap_Ks seen.png\nmap_Bump -bm 2 seen.png\n' >other.mtl
printf 'newmtl glass\nmap_Kd -s 2 2 2 seen.png\nnorm seen.png\nnewmtl lamp\nd -halo 0.5\nmap_Ke seen.png\nnewmtl wood\nNs 5\n' >>other.mtl
{ echo 'l 1 2'; sed 's/^mtllib.*/mtllib other.mtl/; s/^v \(.*\)/v \1 1 0.5 0/' parts.obj; } >other.obj
works "materials of other programs" "$export" other.obj --cage box.obj --twist all:z,0,4,40 --skin 4 -o other.gltf --report
says 'glTF has no equivalent of these statements: "l" (1), "map_Bump" (1), "map_Bump -bm" (1), "map_Kd -s" (1), "map_Ks" (1)'
says 'statements without equivalent in glTF: "Ka" 1, "l" 1, '
says_not 'defines the material'
tr -d ' \n' <other.gltf >flat.json
for part in '"name":"red","pbrMetallicRoughness":{"baseColorFactor":[0.25,0.5,1.0,1.0]' '"name":"glass","pbrMetallicRoughness":{"baseColorFactor":[1.0,1.0,1.0,1.0]' \
  '"name":"lamp","pbrMetallicRoughness":{"baseColorFactor":[0.72,0.36,0.2,0.5]' '"name":"wood","pbrMetallicRoughness":{"baseColorFactor":[0.72,0.36,0.2,1.0]' \
  '"normalTexture":{"index":0}' '"emissiveTexture":{"index":0}' '"emissiveFactor":[1.0,1.0,1.0]' '"COLOR_0"' '"TANGENT"'; do
  grep -qF "$part" flat.json && report yes "$part" || report no "other.gltf has $part"
done
[ "$(grep -c '"alphaMode": "BLEND"' other.gltf)" = 2 ] && report yes alpha || report no "a picture with alpha and -halo blend"
works "objects and materials, binary" "$export" parts.obj --cage box.obj --twist all:z,0,4,40 --skin 4 -o parts.glb
sed "s|^map_Kd.*|map_Kd ../outside_$$/secret.png|" parts.mtl >escaping.mtl
sed 's/^mtllib.*/mtllib escaping.mtl/' parts.obj >escaping.obj
works "a texture of another folder" "$export" escaping.obj --cage box.obj --skin 4 -o escaping.glb
says "the texture \"../outside_$$/secret.png\" of the material \"wood\" is not in its folder"
grep -q 'not ours' escaping.glb && report no "nothing of another folder is taken" || report yes escaping
rm -r ../outside_$$
sed 's/^mtllib.*/mtllib nowhere.mtl/' parts.obj >lost.obj
works "materials that are not there" "$export" lost.obj --cage box.obj --skin 4 -o lost.glb
says 'its materials, "nowhere.mtl", are not in its folder'
printf 'NEWMTL red\nKD 1 0 0\n' >capitals.mtl
sed 's/^mtllib.*/mtllib capitals.mtl/' parts.obj >capitals.obj
works "no material" "$export" capitals.obj --cage box.obj --skin 4 -o capitals.glb
says 'capitals.mtl defines no material'
mkdir -p posed
works "materials of a posed file" "$programs/deform_mesh" parts.obj --cage box.obj --twist all:z,0,4,40 -o posed/parts.obj
says 'note: posed/parts.obj names its materials as parts.obj does: "parts.mtl"'
grep -q '^mtllib parts.mtl' posed/parts.obj && report yes mtllib || report no "groups and materials stay"
works "a cage that is made" "$export" parts.obj --cage hull:20 --bend all:zx,1,3,40 --skin 8 -o made.glb
works "a cage that is made, packed" "$programs/bind_mesh" parts.obj --cage hull:20 --bend all:zx,1,3,40 -o made.figure
refuses 'a box has 8 vertices' "$export" parts.obj --cage box:9 --skin 8 -o out.glb
refuses 'give only one of --clip, --pose, and operations' "$export" parts.obj --cage box.obj --pose box_pose.obj --twist all:z,0,4,40 --skin 8 -o out.glb

# ---- what is refused ----
works "help" "$export" --help
figure="textured.obj --cage box.obj"
printf '%s\n' 'length,2' 'pose,0' >head.csv
corner_lines() { sed 's/^v //; s/ /,/g' corners; }
{ cat head.csv; corner_lines; printf 'pose,1\n'; corner_lines; } >rest.csv
# shellcheck disable=SC2086
{
  refuses 'nowhere.obj' "$export" nowhere.obj --cage box.obj --skin 4 -o out.glb
  refuses 'nowhere.obj' "$export" textured.obj --cage nowhere.obj --skin 4 -o out.glb
  refuses 'nowhere.obj' "$export" $figure --pose nowhere.obj --skin 4 -o out.glb
  refuses 'nowhere.csv: no such file' "$export" $figure --clip nowhere.csv --skin 4 -o out.glb
  refuses 'point.obj: holds no faces' "$export" point.obj --cage box.obj --skin 4 -o out.glb
  refuses 'give --bones, --skin, --max-distance or --morph to choose what to write' "$export" $figure -o out.glb
  refuses '--morph needs poses' "$export" $figure --morph -o out.glb
  refuses '--skin' "$export" $figure --skin 0 -o out.glb
  refuses '--skin' "$export" $figure --skin 17 -o out.glb
  refuses '--skin' "$export" $figure --skin 4 --morph --pose box_pose.obj -o out.glb
  refuses '--clip' "$export" $figure --skin 4 --pose box_pose.obj --clip rest.csv -o out.glb
  refuses '--weights' "$export" $figure --skin 4 --weights int8 -o out.glb
  refuses '--threshold' "$export" $figure --skin 4 --threshold 2 -o out.glb
  refuses '--seconds' "$export" $figure --skin 4 --seconds 0 -o out.glb
  refuses 'wachspress' "$export" $figure --skin 4 --coordinates wachspress -o out.glb
  refuses '--resolution' "$export" $figure --skin 4 --resolution few -o out.glb
  refuses 'does not end with .glb or .gltf' "$export" $figure --skin 4 -o out.obj
  refuses 'missing/out.glb' "$export" $figure --skin 4 -o missing/out.glb
  refuses 'every pose equals the rest pose' "$export" $figure --morph --clip rest.csv -o out.glb
  refuses '112 vertices' "$export" $figure --pose character_cage.obj --skin 4 -o out.glb
  refuses '1 of 8 vertices of stray.obj lie outside the cage box.obj' "$export" stray.obj --cage box.obj --outside refuse --skin 4 -o out.glb
  sed 's|1/4|1/9|' textured.obj >texture.obj
  sed 's|vt 1 1|vt 1 one|' textured.obj >number.obj
  refuses 'texture.obj: texture index 9 is out of range: the file has 4' "$export" texture.obj --cage box.obj --skin 4 -o out.glb
  refuses 'number.obj: not a number: "one" (line 11)' "$export" number.obj --cage box.obj --skin 4 -o out.glb
sed '/^f 4 3/d; /^f 5/d; /^f 1 2/d' box.obj >open.obj
  refuses 'open edge' "$export" textured.obj --cage open.obj --skin 4 -o out.glb
}
faulty_clip() { # MESSAGE SED-COMMAND
  sed "$2" rest.csv >clip.csv
  # shellcheck disable=SC2086
  refuses "$1" "$export" $figure --clip clip.csv --skin 4 -o out.glb
}
faulty_clip 'clip.csv: the line "length,SECONDS" is missing' 1d
faulty_clip 'clip.csv:1: the length is not positive' 's/length,2/length,0/'
faulty_clip 'clip.csv: the last pose has to be before the end' 's/length,2/length,1/'
faulty_clip 'clip.csv:2: the first pose has to be at time 0' 's/pose,0/pose,0.5/'
faulty_clip 'clip.csv:11: a pose is not later' 's/pose,1/pose,0/'
faulty_clip 'clip.csv:11: a pose is smooth, linear or ease, not "hold"' 's/pose,1/pose,1,hold/'
faulty_clip 'clip.csv:11: column 2: "nan" is not a finite number' 's/pose,1/pose,nan/'
faulty_clip 'clip.csv:3: not a number: "q"' '3s/0/q/'
faulty_clip 'clip.csv:3: 2 columns' '3s/,0$//'
faulty_clip 'clip.csv:10: the previous pose has 7 vertices, but the cage has 8' 3d
faulty_clip 'clip.csv:18: the previous pose has 7 vertices, but the cage has 8' 19d
faulty_clip 'more vertices than the cage has, 8' '3s/.*/&\n&/'
faulty_clip '"pose,TIME" is missing before' 2d
faulty_clip 'fewer than two poses' '11,$d'

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] || exit 1

# ---- Khronos' validator ----
if ! command -v node >/dev/null 2>&1 || ! command -v npm >/dev/null 2>&1; then
  echo "skipped: the glTF validator needs node and npm (Debian packages nodejs, npm)"
  exit 77
fi
if ! cmp -s "$here/package-lock.json" "$folder/package-lock.json" || [ ! -d "$folder/node_modules/gltf-validator" ]; then
  cp "$here/package.json" "$here/package-lock.json" "$folder"
  if ! (cd "$folder" && npm ci --fetch-retries=1 --no-audit --no-fund --ignore-scripts) >log 2>&1; then
    rm -f "$folder/package-lock.json"
    cat log
    npm ping --fetch-retries=0 >/dev/null 2>&1 && exit 1
    echo "skipped: the glTF validator: the npm registry cannot be reached"
    exit 77
  fi
fi
node "$here/validate.mjs" "$folder" ./*.glb ./*.gltf || exit 1
issues() { # FILE…   lines with the model of a file and an error or a warning
  node "$here/validate.mjs" "$folder" "$@" | awk '/^[^ ]/ { sub(/: [0-9]+ errors.*/, ""); sub(/.*\//, ""); sub(/\..*/, ""); file = $0 }
    /^  (error|warning) / { print file, $1, $2 }' | sort -u
}
rm -f models/*.moved.gl* models/*.wanted.gl*
for model in models/*.gl*; do
  case $model in *.*.gl*) echo "$model" >>outputs ;; *) echo "$model" >>inputs ;; esac
done
# shellcheck disable=SC2046  # names without spaces
issues $(cat inputs) >before && issues $(cat outputs) >after
if [ ! -s outputs ] || comm -13 before after | grep .; then
  echo "FAILED: a document gets errors or warnings"
  exit 1
fi
# It does find faults: an animation that lacks two thirds of its numbers.
sed 's/CUBICSPLINE/LINEAR/' unorm8.gltf >broken.gltf
if node "$here/validate.mjs" "$folder" broken.gltf >log 2>&1 || ! grep -q '[1-9][0-9]* errors' log; then
  echo "FAILED: the validator takes a broken file"
  exit 1
fi
