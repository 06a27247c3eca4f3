# shellcheck shell=sh disable=SC2154,SC2086 # command_line.sh has set them; $ok is a word
# Sourced by command_line.sh: figures that wrap_mesh lays on others, and what follows them. A body is a pin with a nose.
mkdir -p wraps && cd wraps || exit 1
wrap="$programs/wrap_mesh"
body() { # ROWS COLUMNS WIDE TALL
  awk -v rows="$1" -v columns="$2" -v wide="$3" -v tall="$4" 'BEGIN { pi = atan2(0, -1)
    for (i = 0; i <= rows; ++i) for (j = 0; j < (i % rows == 0 ? 1 : columns); ++j) {
      t = pi * i / rows; a = 2 * pi * j / columns; r = wide * sin(t) * (1 + 0.4 * cos(2 * t))
      nose = 0.3 * exp(-6 * (1 - sin(t) * sin(a)) - 9 * (cos(t) + 0.4) ^ 2)
      print "v", r * cos(a), tall * (2 - 1.5 * cos(t)), 0.7 * r * sin(a) + nose }
    last = 2 + (rows - 2) * columns
    for (j = 0; j < columns; ++j) { k = (j + 1) % columns
      print "f", 1, 2 + j, 2 + k; print "f", last + columns, last + k, last + j
      for (i = 2; i < 2 + (rows - 2) * columns; i += columns) {
        print "f", i + j, i + columns + j, i + columns + k; print "f", i + j, i + columns + k, i + k } } }'
}
near() { # WHAT MOST FILE FILE   equal lines, but for numbers that differ by at most MOST; in the vertices of OBJ files
  paste -d '|' "$3" "$4" | awk -F '|' -v most="$2" '{ n = split($1, a, /[ ,]/); if (split($2, b, /[ ,]/) != n) exit 1
    for (k = 1; k <= n; ++k) if (a[k] != b[k] && !((a[k] - b[k]) ^ 2 <= most ^ 2)) { print NR ": " $0; exit 1 } }' >log && ok=yes || ok=no
  report $ok "$1"
}
body 16 16 0.3 1 >plain.obj
body 20 20 0.36 1.1 >target.obj
body 12 16 0.302 1 >sleeve.obj # just outside
{ echo '# a body'; echo 'o body'; cat plain.obj; echo 'vt 0.5 0.5'; echo 'vn 0 0 1'; } >body.obj
# A smile: displacements of at most 0.001.
awk '$1 == "v" && $3 > 2.2 { $2 += 0.001 * $3; $4 -= 0.0005 } { print }' body.obj >smile.obj
printf 'name,parent,head x,y,z,tail x,y,z,turn about x,y,z (degrees)\nroot,,0,0.7,0,0,2,0,0,0,0\n"top, 2",root,0,2.0,0,0,3.2,0,0,45,0\n' >bones.csv

# ---- one run with all ----
works "a wrap" "$wrap" body.obj target.obj -o wrapped.obj --lattice 6 --follow sleeve.obj:sleeve_on.obj --follow smile.obj:moved_smile.obj \
  --follow bones.csv:bones_on.csv --morph smile.obj:smile_on.obj --picture wrap.png --report
cp log report
awk '/^source to target/ { found = $4 < 0.1 && $5 < 0.2 } END { exit !found }' report && ok=yes || ok=no
report $ok "the source is on the target"
for line in 'wrapped.obj: .* % of the target.s height' 'sleeve_on.obj: 178 vertices; [1-9][0-9]* of 17[0-9] are inside the target, at most 0.[0-9]* % of its height deep' 'bones_on.csv: 4 points' 'source: body.obj, 242 vertices, 480 triangles' \
  'alignment: scale 1.1, shift (' ' 1/6 .* 1e-04 ' 'unmatched: 0 % of the source' 'folds: 0 of 242 vertices, 0 of 424 points' 'stretch: ' 'ended: all steps are done'; do
  grep "$line" report >log && ok=yes || ok=no
  report $ok "the report has: $line"
done
[ "$(head -c 4 wrap.png | tail -c 3)" = PNG ] && ok=yes || ok=no
report $ok "the picture is there"
grep -v '^v' body.obj >of_body
grep -v '^v' wrapped.obj | cmp -s - of_body && ok=yes || ok=no
report $ok "only vertices and normals change"
near "displacements of a morph follow as its vertices do" 2e-6 moved_smile.obj smile_on.obj
cmp -s wrapped.obj smile_on.obj && ok=no || ok=yes
report $ok "and they do"
awk -F '[ ,]' 'NR == FNR { if ($1 == "v") v[++n] = $0; next } $1 == "v" && n { split(v[++k], w, " "); if (w[3] < 2.2 && v[k] != $0) exit 1 }' wrapped.obj smile_on.obj && ok=yes || ok=no
report $ok "a vertex without a displacement is that of the source"
[ "$(cut -d , -f 1-2 bones.csv)" = "$(cut -d , -f 1-2 bones_on.csv)" ] && grep -q ',0,45,0$' bones_on.csv &&
  awk -F , 'NR == 2 { exit !($4 > 0.74 && $4 < 0.8 && $7 > 2.17 && $7 < 2.23) }' bones_on.csv && ok=yes || ok=no
report $ok "heads and tails of bones move, the rest stays"

# ---- known maps ----
works "a figure on itself" "$wrap" body.obj body.obj -o same.obj --lattice 6
near "it stays" 1e-8 body.obj same.obj
awk -v OFMT=%.17g '$1 == "v" { print "v", 3 * $2 + 5, 3 * $3 - 1, 3 * $4; next } { print }' body.obj >similar.obj
works "a larger copy elsewhere" "$wrap" body.obj similar.obj -o scaled.obj --lattice 6 --landmark 0:0 --landmarks /dev/stdin <<'CSV'
vertex,x,y,z
241,5,9.5,0
CSV
near "the source becomes it" 1e-6 similar.obj scaled.obj

# ---- a cage ----
works "a wrap by a cage" "$wrap" body.obj target.obj -o caged.obj --cage auto:20 --save-pose pose.obj --report \
  --follow sleeve.obj:sleeve_on.obj --push-out 0.05%
grep -q '^ cage ' log && ok=yes || ok=no
report $ok "its steps are in the report"
grep -q 'sleeve_on.obj: .*--push-out moved .*before, [1-9][0-9]* were inside the target, now 0 of' log && ok=yes || ok=no
report $ok "a sleeve is pushed out of the target"
works "the same cage" "$programs/make_cage" body.obj --vertices 20 -o cage.obj
works "its pose" "$mesh" body.obj --cage cage.obj --pose pose.obj --outside extend -o by_pose.obj
near "the pose of the cage is that map" 1e-6 caged.obj by_pose.obj

# ---- formats ----
awk '/^v / { v[++n] = "vertex " $2 " " $3 " " $4 } /^f/ { face($2, $3, $4); if (NF == 5) face($2, $4, $5) } END { print "endsolid" }
  function face(a, b, c) { print "facet normal 0 0 0 outer loop\n" v[a] "\n" v[b] "\n" v[c] "\nendloop endfacet" }' plain.obj | sed '1isolid body' >body.stl
works "an STL file" "$wrap" body.stl target.obj -o wrapped.stl --lattice 6
grep -q 'wrapped.stl: 0.0' log && ok=yes || ok=no
report $ok "its corners become vertices, so that it has no rim"
works "a glTF file with a morph target" "$programs/export_gltf" plain.obj --cage cage.obj --move 'y>3:0.1,0,0' --morph -o body.glb
works "it is wrapped" "$wrap" body.glb target.obj -o wrapped.glb --lattice 6
grep -q 'its morph targets are moved by the Jacobian; at full weight, the largest distance .*, 0\.[0-9]* %' log && ok=yes || ok=no
report $ok "its morph targets follow"
works "both are the same surface" "$wrap" wrapped.glb wrapped.stl -o again.glb --no-align --lattice 6 --residual 50% --report
awk '/^after alignment/ { found = $5 < 1e-3 } END { exit !found }' log && ok=yes || ok=no
report $ok "to single precision"

# ---- warnings ----
works "a wrong landmark" "$wrap" body.obj target.obj -o off.obj --lattice 6 --landmark 0:0 --landmark 120:0,2.2,3
grep -q 'warning: landmark 2 (--landmark "120:0,2.2,3") is missed by [0-9.]* % of' log && ok=yes || ok=no
report $ok "it is named"
awk '$1 == "v" { print "v", $2, $4, -$3; next } { print }' target.obj >lying.obj
works "a target that lies" "$wrap" body.obj lying.obj -o off.obj --lattice 6
grep -q 'warning: .*do both have the same up and front' log && ok=yes || ok=no
report $ok "the bad fit is told"

awk 'BEGIN { for (n = 0; n < 144; ++n) { i = n % 12; j = int(n / 12); print "v", i, 2 * j, 0.1 * i * j
  if (i < 11 && j < 11) faces = faces "f " n + 1 " " n + 2 " " n + 14 "\nf " n + 1 " " n + 14 " " n + 13 "\n" } printf "%s", faces }' >open.obj
works "an open figure on itself" "$wrap" open.obj open.obj -o off.obj --lattice 6
grep -q warning log && ok=no || ok=yes
report $ok "its rim is no fault"
awk '$1 == "v" { print "v", $2 + 9000, $3, $4; next } { print }' target.obj >away.obj
works "a target elsewhere, without an alignment" "$wrap" body.obj away.obj -o off.obj --lattice 6 --no-align
grep -q 'warning: .*leave out --no-align' log && ok=yes || ok=no
report $ok "the remedy is named"

# ---- wrong input ----
to="body.obj target.obj -o out.obj"
: >empty.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' >points.obj
printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >line.obj
printf '0,1,2,3\n\n999,1,2,3\n' >far.csv
printf '0,1,2\n1,x,2,3\n' >word.csv
printf 'name,y,z\nhip,1,2\n' >flat.csv
printf 'hip,1,2,3\n' >hip.csv
printf 'knee,1,2,3\n' >knee.csv
refuses 'nowhere.obj: no such file' "$wrap" nowhere.obj target.obj -o out.obj
refuses 'nowhere.obj: no such file' "$wrap" body.obj nowhere.obj -o out.obj
refuses 'empty.obj: is empty' "$wrap" body.obj empty.obj -o out.obj
refuses 'points.obj: has no faces, and a wrap needs a surface' "$wrap" points.obj target.obj -o out.obj
refuses 'points.obj: has no faces, and a wrap needs a surface' "$wrap" body.obj points.obj -o out.obj
refuses 'line.obj: ' "$wrap" body.obj line.obj -o out.obj
refuses 'body.obj is written as .obj' "$wrap" body.obj target.obj -o out.stl
refuses 'far.csv:3: source: there is no vertex 999: the figure has 242' "$wrap" $to --landmarks far.csv
refuses 'word.csv:2: column 2: not a number: "x"' "$wrap" $to --landmarks far.csv:word.csv
refuses 'is "hip", and in knee.csv "knee"' "$wrap" $to --landmarks hip.csv:knee.csv
refuses 'write SOURCE:TARGET' "$wrap" $to --landmark 5
refuses 'target: there is no vertex 402' "$wrap" $to --landmark 5:402
refuses 'flat.csv:2: a point has three numbers: x,y,z' "$wrap" $to --follow flat.csv:out.csv
refuses 'are written as .csv' "$wrap" $to --follow hip.csv:out.obj
refuses 'a follower is a mesh or a CSV file of points' "$wrap" $to --follow hip.txt:out.txt
refuses 'is not IN:OUT' "$wrap" $to --follow sleeve.obj
refuses 'sleeve.obj has 178 vertices, body.obj has 242: a frame is the figure with its vertices moved' "$wrap" $to --morph sleeve.obj:out.smile.obj
refuses 'cannot write body.obj: it is the same file as body.obj, which is read' "$wrap" $to --follow sleeve.obj:body.obj
refuses '--coordinates is for --cage' "$wrap" $to --coordinates harmonic
refuses '--lattice 0 is for --cage' "$wrap" $to --lattice 0
refuses '--other-pose needs landmarks' "$wrap" $to --other-pose
refuses '--push-out' "$wrap" $to --push-out 5m
refuses '"0.05" is not a percentage' "$wrap" $to --follow sleeve.obj:out.sleeve.obj --push-out 0.05
refuses '--push-out is for --follow' "$wrap" $to --push-out 0.05%
refuses '--follow out.ply: the figure sleeve.obj is written as .obj' "$wrap" $to --follow sleeve.obj:out.ply
refuses 'landmark 2 (--landmark "3:1e12,0,0"): too far' "$wrap" $to --landmark 0:0 --landmark 3:1e12,0,0
awk '$1 == "v" { print "v", 30 * $2, 30 * $3, 30 * $4; next } { print }' body.obj >giant.obj
refuses 'giant.obj: is far larger than target.obj: leave out --no-align' "$wrap" giant.obj target.obj -o out.obj --no-align
cd ..
