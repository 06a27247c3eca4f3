# shellcheck shell=sh disable=SC2154 # command_line.sh has set the rest
# Sourced by command_line.sh: skeletons that fit_skeleton finds in sequences of meshes.
mkdir -p skeletons && cd skeletons || exit 1
fit="$programs/fit_skeleton"
"$programs/make_character" . >/dev/null
for k in 0 1 2 3; do
  "$programs/deform_mesh" character.obj --cage character_cage.obj --twist all:y,0,2,"${k}0" --coordinates mean-value -o twist_$k.obj >/dev/null 2>&1
done
works "bones of OBJ files" "$fit" twist_0.obj twist_?.obj -o twist.glb --bones 3 --report --picture twist.png
[ "$(head -c 4 twist.glb)" = glTF ] && [ "$(head -c 4 twist.png | tail -c 3)" = PNG ] && grep -q '^bones: 3, ' log && ok=yes || ok=no
report $ok "skeleton, picture and report are there"
refuses '1 bone does not keep it within 0.001 %' "$fit" twist_0.obj twist_?.obj -o out.glb --bones 1 --max-distance 0.001%
# A cage with its vertices in reverse: a clip fits their number, and means others.
awk 'FNR == NR { count += $1 == "v"; next } $1 == "v" { v[++n] = $0 } $1 == "f" { for (k = 2; k <= NF; k++) { split($k, part, "/"); $k = count + 1 - part[1] } f[++m] = $0 }
  END { for (k = n; k > 0; k--) print v[k]; for (k = 1; k <= m; k++) print f[k] }' character_cage.obj character_cage.obj >reversed_cage.obj
works "a clip of another cage" "$programs/export_gltf" character.obj --cage reversed_cage.obj --clip character_clip.csv --bones 2 --rate 5 -o reversed.glb
grep -q 'warning: character_clip.csv: all keys are far from the rest pose of reversed_cage.obj' log && ok=yes || ok=no
report $ok "is warned of"
works "a clip of this cage" "$programs/export_gltf" character.obj --cage character_cage.obj --clip character_clip.csv --bones 2 --rate 5 -o own.glb
grep -q 'every key has' log && ok=no || ok=yes
report $ok "is not"
refuses 'twist_1.obj: 1 frame: a motion has two or more' "$fit" twist_0.obj twist_1.obj -o out.glb
refuses 'character_cage.obj has 112 vertices, twist_0.obj has' "$fit" twist_0.obj twist_1.obj character_cage.obj -o out.glb
refuses '--axes' "$fit" twist_0.obj twist_?.obj -o out.glb --axes y,x,z
refuses '--rate' "$fit" twist_0.obj twist_?.obj -o out.glb --rate 0
refuses '"0" is neither "auto" nor a number of bones from 1 to 1024' "$fit" twist_0.obj twist_?.obj -o out.glb --bones 0
refuses '--influences' "$fit" twist_0.obj twist_?.obj -o out.glb --influences 9
refuses 'cannot write missing/out.png' "$fit" twist_0.obj twist_?.obj -o out.glb --bones 2 --picture missing/out.png

# MDD files: floats of 4 bytes, the byte of the sign first.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >solid.obj
printf 'v 0 0 0\nv 0 1 0\nv -1 0 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >turned.obj
o='\000\000\000\000' i='\077\200\000\000' m='\277\200\000\000'
head="\\000\\000\\000\\002\\000\\000\\000\\004$o$i"
frames() { # Z   the solid and the turned one, with so high tips
  printf '%b' "$head$o$o$o$i$o$o$o$i$o$o$o$1$o$o$o$o$i$o$m$o$o$o$o$1"
}
frames "$i" >solid.mdd
frames "$m" >mirror.mdd
works "bones of an MDD file" "$fit" solid.obj solid.mdd -o timed.gltf
grep -A 99 '"accessors"' timed.gltf | tr -d ' \n' | grep -q '"min":\[0.0\],"max":\[1.0\]' && ok=yes || ok=no
report $ok "have its times"
works "an MDD file at a rate" "$fit" solid.obj solid.mdd -o solid.glb --rate 30
works "bones of its frames" "$fit" solid.obj solid.obj turned.obj -o frames.glb
cmp -s solid.glb frames.glb && ok=yes || ok=no
report $ok "an MDD file is as good as its frames"
works "bones of Blender's axes" "$fit" solid.obj mirror.mdd -o mirror.glb --axes x,y,-z --rate 30
cmp -s solid.glb mirror.glb && ok=yes || ok=no
report $ok "Blender's axes are turned back"
works "other axes" "$fit" solid.obj mirror.mdd -o mirror.glb --bones 1
grep -q 'warning: mirror.mdd: every frame is a mirror image of solid.obj; for an MDD file of Blender give --axes x,y,-z' log && ok=yes || ok=no
report $ok "other axes are noticed"
head="\\000\\000\\000\\002\\000\\000\\000\\004$i$o"
frames "$i" >descending.mdd
works "times that do not ascend" "$fit" solid.obj descending.mdd -o descending.glb
grep -q 'note: descending.mdd: the times of its frames do not ascend' log && cmp -s solid.glb descending.glb && ok=yes || ok=no
report $ok "are those of the rate"
head="\\000\\000\\000\\002\\000\\000\\000\\004$m$o"
frames "$i" >before.mdd
works "times before 0" "$fit" solid.obj before.mdd -o before.gltf
grep -q 'note: before.mdd: the times of its frames are counted from the first, -1$' log &&
  grep -A 99 '"accessors"' before.gltf | tr -d ' \n' | grep -q '"min":\[0.0\],"max":\[1.0\]' && ok=yes || ok=no
report $ok "are counted from the first"
for k in 1 2 10 12; do cp "twist_$((k % 4)).obj" "frame_$k.obj"; done
works "frames by a pattern" "$fit" twist_0.obj frame_*.obj -o pattern.glb --bones 2
grep -q 'note: the files were put in the order of their numbers, from frame_1.obj to frame_12.obj' log &&
  grep -q 'note: a number is missing between frame_2.obj and frame_10.obj: others are 1 apart' log && ok=yes || ok=no
report $ok "are put in order"
works "frames in order" "$fit" twist_0.obj frame_1.obj frame_2.obj frame_10.obj frame_12.obj -o ordered.glb --bones 2
cmp -s pattern.glb ordered.glb && ok=yes || ok=no
report $ok "are the same"
: >empty.mdd
head -c 30 solid.mdd >short.mdd
{ cat solid.mdd; echo; } >long.mdd
printf '\377\377\377\377\000\000\000\004' >huge.mdd
frames '\177\300\000\000' >nan.mdd
works "more bones than four vertices allow" "$fit" solid.obj solid.mdd -o solid.glb --bones 3
grep -q 'warning: solid.obj: 3 bones were requested, but only 1 bone is useful' log && ok=yes || ok=no
report $ok "which is said"
refuses 'empty.mdd: is no MDD file: it has 0 bytes' "$fit" solid.obj empty.mdd -o out.glb
refuses 'short.mdd: has 30 bytes, but 2 frames of 4 vertices take 112' "$fit" solid.obj short.mdd -o out.glb
refuses 'long.mdd: has 113 bytes' "$fit" solid.obj long.mdd -o out.glb
refuses 'huge.mdd: has 8 bytes, but 4294967295 frames' "$fit" solid.obj huge.mdd -o out.glb
refuses 'nan.mdd: frame 0, v 4: a coordinate is not finite' "$fit" solid.obj nan.mdd -o out.glb
sed '/^f .*4/d' solid.obj >flat.obj
works "a vertex that no face has" "$fit" flat.obj nan.mdd -o flat.glb
grep -q 'warning: nan.mdd: frame 0, 1 of 4 vertices are left out, here and in all other files, first v 4: ' log && ok=yes || ok=no
report $ok "is left out"
refuses 'nan.mdd: frame 0, v 4: a coordinate is not finite' "$fit" flat.obj nan.mdd -o out.glb --strict
printf 'v 0 0 0\nv 0 1 0\nv nan 0 0\nv 0 0 1\n' >no_faces.obj
refuses 'no_faces.obj: v 3: a coordinate is not finite' "$fit" solid.obj solid.obj no_faces.obj -o out.glb
refuses 'no_faces.obj: v 3: a coordinate is not finite' "$programs/lattice_fit" solid.obj no_faces.obj --cage lattice:2x2x2 -o out.obj
refuses 'solid.mdd has 4 vertices, the figure' "$fit" twist_0.obj solid.mdd -o out.glb
refuses 'nowhere.mdd: no such file' "$fit" solid.obj nowhere.mdd -o out.glb
refuses 'one MDD file holds all frames: give it alone' "$fit" solid.obj solid.mdd turned.obj -o out.glb

for signal in INT TERM; do # while it fits
  env --default-signal=$signal "$fit" twist_0.obj twist_?.obj -o out.glb --bones 400 >log 2>&1 &
  program=$!
  sleep 1
  kill -$signal $program && ok=yes || ok=no
  wait $program && ok=no
  [ -z "$(find . -name '*.tmp*')" ] && [ ! -e out.glb ] || ok=no
  report $ok "no skeleton is left behind after SIG$signal"
done
printf 'low,,0.5,0.5,0.1,0.5,0.5,0.5,0,0,0\nhigh,low,0.5,0.5,0.5,0.5,0.5,0.9,20,0,0\n' >bones.csv
printf 'bone,parent,"head, x",y,z,x,y,z,x,y,z\r\n"low","",0.5,0.5,0.1,"0.5",0.5,0.5,0,0,0,,\r\n"high","low",0.5,0.5,0.5,0.5,0.5,0.9,20,0,0,,\r\n,,\r\n' >sheet.csv
for bones in bones sheet; do works "bones of $bones.csv" "$programs/skin_mesh" ../box.obj --bones $bones.csv -o $bones.glb; done
works "bones as a spreadsheet writes them are the same" cmp bones.glb sheet.glb
cd .. || exit 1
