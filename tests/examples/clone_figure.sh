# shellcheck shell=sh disable=SC2154,SC2086,SC2002,SC3045 # command_line.sh has set them; $ok is a word
# Sourced by command_line.sh: poses of a packed figure in rows, the same bytes whatever the split, and files of farms.
mkdir -p rows
cd rows || exit 1
clone="$programs/clone_figure"
works "a character for rows" "$programs/make_character" .
works "its figure, weights in float" "$programs/bind_mesh" character.obj --cage character_cage.obj --format float -o character.figure
# The clip's poses as a table; its first row is the cage at rest.
{ sed -n 's/^v \(.*\) \(.*\) \(.*\)/\1,\2,\3/p' character_cage.obj | paste -s -d ,
  awk -F, '/^pose/ { if (row != "") print row; row = "" } /^[-0-9]/ { row = row (row == "" ? "" : ",") $0 } END { print row }' character_clip.csv; } >poses.csv
[ "$(grep -c . poses.csv)" = 25 ] && ok=yes || ok=no
report $ok "a table of 25 poses"
all_of() { # FOLDER   the names of its files
  (cd "$1" && echo *)
}

# ---- what is written ----
mkdir -p mesh one
works "rows into OBJ files" "$clone" character.figure --poses poses.csv --mesh character.obj -o 'mesh/%06d.obj'
[ "$(all_of mesh)" = "$(seq -f '%06g.obj' 0 24 | xargs)" ] && ok=yes || ok=no
report $ok "a file a row"
works "at rest a mesh is its file, byte for byte" cmp character.obj mesh/000000.obj
works "a pose by deform_mesh" "$mesh" character.obj --cage character_cage.obj --pose character_pose.obj -o posed.obj
sed -n 's/^v \(.*\) \(.*\) \(.*\)/\1,\2,\3/p' character_pose.obj | paste -s -d , >pose.csv
works "that pose as a row" "$clone" character.figure --poses pose.csv --rows 0:1 --mesh character.obj -o row.obj
paste -d ' ' posed.obj row.obj | awk '$1 == "v" && ($2 - $6) ^ 2 + ($3 - $7) ^ 2 + ($4 - $8) ^ 2 > 1e-11 { exit 1 } $1 == "f" && $2 != $6 { exit 1 }' && ok=yes || ok=no
report $ok "both put every vertex in one place, to 3e-6"
works "a row without a mesh" "$clone" character.figure --poses poses.csv --rows 3 -o one/3.obj
for kind in v f; do
  grep "^$kind " mesh/000003.obj | sed 's|/[^ ]*||g' >of_mesh
  grep "^$kind " one/3.obj | cmp -s - of_mesh && ok=yes || ok=no
  report $ok "the figure's own triangles: lines of $kind"
done
works "a row as bytes" "$clone" character.figure --poses poses.csv --rows 3:4 -o one/3.ply
works "a row with a mesh" "$clone" character.figure --poses poses.csv --rows 3:4 --mesh character.obj -o one/mesh.ply
grep -q "note: character.obj: not written: .*$(grep -c '^vn' character.obj) of \"vn\"" log && ok=yes || ok=no
report $ok "what a PLY file has no place for"
works "a row as text" "$clone" character.figure --poses poses.csv --rows 3:4 --ascii -o one/text.ply
works "a row as an array" "$clone" character.figure --poses poses.csv --rows 3:4 -o one/3.npy
points=$(grep -c '^v ' character.obj)
grep -aq "^element vertex $points\$" one/3.ply && grep -aq '^format binary_little_endian 1.0$' one/3.ply && ok=yes || ok=no
report $ok "the head of a PLY file"
head -c 128 one/3.npy | tail -c +11 | grep -q "^{'descr': '<f4', 'fortran_order': False, 'shape': ($points, 3), } *\$" && ok=yes || ok=no
report $ok "the head of an array"
tail -c +129 one/3.npy >array
tail -c +"$(($(head -c 400 one/3.ply | sed '/^end_header$/q' | wc -c) + 1))" one/3.ply | head -c $((12 * points)) | cmp -s - array && ok=yes || ok=no
report $ok "an array holds the points of the PLY file, to the bit"
sed '1,/^end_header$/d' one/text.ply | head -n "$points" >words
sed -n 's/^v //p' one/3.obj | cmp -s - words && ok=yes || ok=no
report $ok "a PLY file as text holds those of the OBJ file"
od -An -v -t fF -w12 array | awk 'NR == FNR { for (k = 1; k <= 3; ++k) x[NR, k] = $k; next }
  { for (k = 1; k <= 3; ++k) if ((x[FNR, k] - $k) ^ 2 > 1e-14 * ($k * $k + 1)) exit 1 }' - words && ok=yes || ok=no
report $ok "the bytes of an array are those numbers"

# ---- any split gives the same bytes ----
mkdir -p whole split
works "all rows at once" "$clone" character.figure --poses poses.csv -o 'whole/%03d.ply'
for part in 17:99 3:4 4:17 0:3; do
  works "rows $part" "$clone" character.figure --poses poses.csv --rows $part --threads 3 -o 'split/%03d.ply'
done
works "the files are equal" diff -r whole split
rm split/007.ply split/011.ply
echo not whole >split/003.ply
works "what is done is left alone" "$clone" character.figure --poses poses.csv --skip-existing --json -o 'split/%03d.ply'
[ "$(grep -c '"status":"skipped"' log)" = 23 ] && [ "$(grep -c '^{"row":[0-9]*,"file":"split/0[01][0-9].ply","status":"written","bytes":[0-9]*,"seconds":[0-9.e-]*}$' log)" = 2 ] && ok=yes || ok=no
report $ok "a line of JSON a row"
[ "$(cat split/003.ply)" = "not whole" ] && ok=yes || ok=no
report $ok "a file that is there is not looked into"
works "they are written again" "$clone" character.figure --poses poses.csv -o 'split/%03d.ply'
works "the files are equal again" diff -r whole split
mkdir -p clip
works "a clip" "$clone" character.figure --poses character_clip.csv --rate 10 -o 'clip/%d.ply'
[ "$(all_of clip | wc -w)" = 24 ] && ok=yes || ok=no # 2.4 s
report $ok "as many rows as the clip has tenths of a second"
works "a pose of the clip is one of the table" cmp clip/5.ply whole/006.ply
cat poses.csv | works "a table from a pipe" "$clone" character.figure --poses /dev/stdin --rows 24 -o pipe.ply
works "it is the last row" cmp pipe.ply whole/024.ply
works "rows that are not there" "$clone" character.figure --poses poses.csv --rows 25:30 -o 'none%d.ply'
grep -q 'note: poses.csv: has 25 rows: none to write' log && [ ! -e none25.ply ] && ok=yes || ok=no
report $ok "it is said, and nothing is written"
works "Green coordinates" "$programs/bind_mesh" character.obj --cage character_cage.obj --coordinates green -o green.figure
works "rows by Green coordinates" "$clone" green.figure --poses poses.csv --rows 0 --mesh character.obj -o green.obj
works "at rest a mesh is its file" cmp character.obj green.obj

# ---- wrong input ----
to=-oout.%d.ply
sed '3s/^[^,]*/word/; 5s/^[^,]*/1e300/; 7s/^[^,]*,//; 9s/^[^,]*/nan/; 11s/^[^,]*/3e38/' poses.csv >bad.csv
mkdir -p bad
"$clone" character.figure --poses bad.csv -o 'bad/%03d.ply' >log 2>&1
[ $? -eq 1 ] && [ "$(all_of bad | wc -w)" = 20 ] && ok=yes || ok=no
grep -qF 'bad.csv:3: column 1: not a number: "word"' log && grep -q 'bad.csv:5: ' log && grep -q "bad.csv:7: 335 numbers, but a pose of the figure's cage has 336" log &&
  grep -qF 'bad.csv:9: column 1: "nan" is not a finite number' log && grep -q 'bad.csv:11: ' log && grep -qF 'note: 5 of 25 rows failed; the others are done' log || ok=no
report $ok "rows that are wrong are named, and the others done"
(exec 3>&- 4>&- && ulimit -n 5 && "$clone" character.figure --poses poses.csv "$to") >log 2>&1
[ $? -eq 75 ] && grep -q 'cannot write out.0.ply: Too many open files' log && grep -q 'repeat the command' log && ok=yes || ok=no
report $ok "a failure that may pass asks for another try"
(exec 3>&- && ulimit -n 4 && "$clone" character.figure --poses poses.csv "$to") >log 2>&1
[ $? -eq 75 ] && grep -q 'poses.csv: cannot be opened: Too many open files' log && ok=yes || ok=no
report $ok "and where it is that of a file to read"
head -c 5000 character.figure >cut.figure
{ head -c 9000 character.figure; printf '\377\377'; tail -c +9003 character.figure; } >changed.figure
: >empty.figure
mkdir -p folder
refuses 'no such file' "$clone" nowhere.figure --poses poses.csv "$to"
refuses 'folder: is a folder' "$clone" folder --poses poses.csv "$to"
refuses 'empty.figure: is empty' "$clone" empty.figure --poses poses.csv "$to"
refuses 'cut.figure: the packed data is cut off' "$clone" cut.figure --poses poses.csv "$to"
refuses 'changed.figure: the checksum of the packed data differs' "$clone" changed.figure --poses poses.csv "$to"
refuses 'character.obj: the memory holds no packed figure' "$clone" character.obj --poses poses.csv "$to"
refuses 'nowhere.csv: no such file' "$clone" character.figure --poses nowhere.csv "$to"
refuses 'empty.figure: is empty' "$clone" character.figure --poses empty.figure "$to"
refuses 'has 112 vertices, the figure' "$clone" character.figure --poses poses.csv --mesh character_cage.obj "$to"
refuses '"3:2" is no range of rows' "$clone" character.figure --poses poses.csv --rows 3:2 "$to"
refuses 'several rows would have one name' "$clone" character.figure --poses poses.csv -o out.ply
refuses 'write %06d once' "$clone" character.figure --poses poses.csv -o 'out.%s.ply'
refuses '-o out.%d.stl: needs --mesh, an STL file' "$clone" character.figure --poses poses.csv -o 'out.%d.stl'
refuses '--flip-faces: character.figure is written without faces' "$clone" character.figure --poses poses.csv --flip-faces -o 'out.%d.npy'
refuses '--flip-faces: character.obj is written without faces' "$clone" character.figure --poses poses.csv --mesh character.obj --flip-faces -o 'out.%d.npy'
refuses '--ascii: only .ply files' "$clone" character.figure --poses poses.csv --ascii -o 'out.%d.npy'
refuses 'cannot write missing/out.0.ply: No such file or directory' "$clone" character.figure --poses poses.csv -o 'missing/out.%d.ply'
refuses '--rate' "$clone" character.figure --poses character_clip.csv --rate 0 "$to"
refuses '--threads' "$clone" character.figure --poses poses.csv --threads 0 "$to"

# ---- the files of farms: short, and parsed. sh examples/integrations/farms/run.sh runs two of them ----
farms="$data/../integrations/farms"
for file in slurm.sbatch dask_map.py opencue.py kubernetes.yaml; do
  [ "$(grep -c '' "$farms/$file")" -le 30 ] && ok=yes || ok=no
  report $ok "$file has at most 30 lines"
done
works "shell is parsed" sh -n "$farms/slurm.sbatch"
works "shell is parsed" sh -n "$farms/run.sh"
if command -v python3 >/dev/null 2>&1; then
  for file in dask_map.py opencue.py; do
    works "$file is parsed" python3 -c 'import ast, sys; ast.parse(open(sys.argv[1], encoding="utf-8").read())' "$farms/$file"
  done
fi
cd ..
