# shellcheck shell=sh disable=SC2154 # command_line.sh has set the rest
# Sourced by command_line.sh. Tiles of points are bound by many processes:
#   the bytes do not depend on the split, the order, threads or memory, nor on processes that were ended in between;
#   a tile that cannot be read is named, and the others are done; a failure that may pass ends with 75.
mkdir tiles_test
cd tiles_test || exit 1
"$programs/make_character" . >/dev/null
tiles="$programs/bind_tiles"
bind_tiles() { # FOLDER WORD…   binds to figures in that folder
  folder=$1; shift
  mkdir -p "$folder"
  "$tiles" character_cage.obj -o "$folder/*.figure" --largest 8 --format int8 "$@"
}
same() { # WHAT FOLDER OTHER   the folders hold the same bytes, and nothing temporary
  diff -r "$2" "$3" >log 2>&1 && [ -z "$(find "$2" "$3" -name '*.tmp*')" ] && ok=yes || ok=no
  report $ok "$1"
}
ends() { # CODE TEXT COMMAND…   ends with that code, and says the text
  code=$1; text=$2; shift 2
  "$@" >log 2>&1
  found=$?
  ok=yes
  [ $found -eq "$code" ] || { ok=no; echo "exit code $found, not $code" >>log; }
  grep -qF -- "$text" log || { ok=no; echo "does not say: $text" >>log; }
  report $ok "$*"
}

# ---- splits ----
mkdir few many
works "tiles of a mesh" "$programs/make_tiles" character.obj --points 6400 --tiles 64 -o few/%02d.ply
works "one of these tiles alone" "$programs/make_tiles" character.obj --points 6400 --tiles 64 --rows 9:10 -o few/again_%02d.ply
cmp few/09.ply few/again_09.ply >log 2>&1 && ok=yes || ok=no
report $ok "a tile does not depend on the others"
rm few/again_09.ply
works "64 tiles by one process" bind_tiles one --points 'few/*.ply'
for rows in 50:64 0:1 22:33 33:34 1:22 40:50 34:40; do bind_tiles seven --points 'few/*.ply' --rows $rows >log 2>&1 || report no "rows $rows"; done
same "7 processes, in any order" one seven
for row in $(seq 63 -1 0); do bind_tiles each --points 'few/*.ply' --rows "$row" >log 2>&1 || report no "row $row"; done
same "64 processes" one each
works "three tiles at a time" bind_tiles threads --points 'few/*.ply' --threads 3 --memory 400
same "threads" one threads
works "rows beyond the last tile" bind_tiles none --points 'few/*.ply' --rows 64:200

# ---- what is done ----
touch stamp
works "all tiles again" bind_tiles one --points 'few/*.ply' --json
[ "$(grep -c '"state":"was done"' log)" -eq 64 ] && [ -z "$(find one -name '*.figure' -newer stamp)" ] && ok=yes || ok=no
report $ok "done tiles are left as they are"
sed -n 's/.*{"row":0,.*"points":100,"bytes":[0-9]*,"weights_a_point":[0-9.]*,"largest_distance":[0-9.]*,.*/yes/p' log | grep -q yes && ok=yes || ok=no
report $ok "a line of JSON for each tile"
cp -r one harmed
printf 'x' | dd of=harmed/05.figure bs=1 seek=3000 conv=notrunc 2>/dev/null
head -c 2000 one/06.figure >harmed/06.figure
cp one/07.figure harmed/08.figure
rm harmed/09.figure
works "tiles whose figures were harmed" bind_tiles harmed --points 'few/*.ply' --json
[ "$(grep -c '"state":"done"' log)" -eq 4 ] && ok=yes || ok=no
report $ok "they are bound again"
same "and are as before" one harmed
works "other options" bind_tiles harmed --points 'few/0?.ply' --json --coordinates mean-value --outside nearest-boundary
[ "$(grep -c '"state":"done"' log)" -eq 10 ] && ok=yes || ok=no
report $ok "other options make other figures"

# ---- ended in between ----
works "large tiles" "$programs/make_tiles" character.obj --points 400000 --tiles 8 -o many/%d.ply
works "large tiles by one process" bind_tiles whole --points 'many/*.ply'
for signal in TERM KILL; do
  mkdir broken_$signal
  "$tiles" character_cage.obj --points 'many/*.ply' -o "broken_$signal/*.figure" --largest 8 --format int8 --threads 2 >log 2>&1 &
  process=$!
  while [ ! -f broken_$signal/1.figure ] && kill -0 $process 2>/dev/null; do sleep 0.05; done
  kill -$signal $process 2>/dev/null
  wait $process 2>/dev/null
  if [ $signal = KILL ]; then find broken_KILL -name '*.tmp*' -exec rm {} +; fi
  [ -z "$(find broken_$signal -name '*.tmp*')" ] && ok=yes || ok=no
  for file in broken_$signal/*.figure; do cmp "$file" "whole/${file##*/}" >>log 2>&1 || ok=no; done
  report $ok "after SIG$signal whole figures stay, and nothing else"
  works "the rest after SIG$signal" bind_tiles broken_$signal --points 'many/*.ply'
  same "all after SIG$signal" whole broken_$signal
done
rm -r many whole broken_*

# ---- tiles that cannot be read ----
mkdir bad
for n in 0 1 2 3; do cp "few/0$n.ply" "bad/good_$n.ply"; done
head -c 700 few/04.ply >bad/cut.ply
echo 'no points at all' >bad/text.ply
: >bad/empty.ply
mkdir bad/folder.ply
printf 'ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n0 nan 0\n' >bad/nan.ply
printf 'ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n' >bad/flat.ply
ends 1 'bad/cut.ply: is cut off' bind_tiles bad_out --points 'bad/*.ply' --threads 2 --strict
for text in 'bad/text.ply: is no PLY file' 'bad/empty.ply: is no PLY file' 'bad/folder.ply: is a folder' \
  'bad/nan.ply: 1 point, first number 1 counted from 0, are not finite' 'bad/flat.ply: its element vertex has no property z'; do
  grep -qF "$text" log && ok=yes || ok=no
  report $ok "$text"
done
for n in 0 1 2 3; do cp "one/0$n.figure" "bad/good_$n.figure"; done
[ "$(ls bad_out)" = "$(cd bad && ls -- *.figure)" ] && ok=yes || ok=no
for n in 0 1 2 3; do cmp "one/0$n.figure" "bad_out/good_$n.figure" >>log 2>&1 || ok=no; done
report $ok "the tiles beside broken ones are done"
works "a point that is not finite" bind_tiles nan --points bad/nan.ply --json
grep -qF 'warning: bad/nan.ply: 1 of 2 points are not finite in float, first number 1 counted from 0: no pose moves them; --strict' log &&
  grep -q '"points":2,.*"not_finite":1}' log && ok=yes || ok=no
report $ok "is counted"
works "a pose of it" "$programs/clone_figure" nan/nan.figure --poses character_clip.csv --rate 1 --rows 1:2 -o nan/%d.obj
[ "$(grep -c '^v ' nan/1.obj)" = 2 ] && [ "$(grep '^v ' nan/1.obj | tail -n 1)" = 'v 0 nan 0' ] && ok=yes || ok=no
report $ok "keeps its row"
ends 1 'bad/nan.ply: 1 point, first number 1 counted from 0, are not finite' bind_tiles nan --points bad/nan.ply --strict
ends 1 'lie outside the cage' bind_tiles bad_out --points character_pose.obj --outside refuse

# ---- failures that may pass ----
ends 75 'cannot be read: Input/output error' env LD_PRELOAD="$failing_read" FAILING_FILE=02.ply FAILING_AFTER=200 \
  "$tiles" character_cage.obj --points 'few/0[123].ply' -o 'bad_out/*.figure' --json
grep -q '"row":1,.*"state":"failed".*"try_again":true' log && [ -f bad_out/01.figure ] && [ -f bad_out/03.figure ] &&
  [ ! -f bad_out/02.figure ] && ok=yes || ok=no
report $ok "a disk that does not answer asks for another try"
mkdir full
if unshare -rm sh -c 'mount -t tmpfs -o size=64k none full' 2>/dev/null; then
  # shellcheck disable=SC2016 # expanded by the inner shell
  ends 75 'No space left on device' unshare -rm sh -c 'mount -t tmpfs -o size=20k none full &&
    "$1" character_cage.obj --points "few/0*.ply" -o "full/*.figure" --largest 8 --format int8; code=$?
    ls full; for file in full/*; do cmp "$file" "one/${file##*/}" || exit 1; done; exit $code' sh "$tiles"
  grep -q '\.tmp' log && ok=no || ok=yes
  report $ok "a full disk keeps the figures that are done"
fi

# ---- solutions ----
harmonic="--coordinates harmonic --accuracy 0.05 --points few/00.ply --points few/01.ply"
works "harmonic tiles" bind_tiles solved $harmonic --save-solution cage.solution
works "by the solution" bind_tiles read $harmonic --solution cage.solution
same "a solution gives the bytes of the solve" solved read
works "saving what was read" bind_tiles read $harmonic --solution cage.solution --save-solution again.solution
cmp cage.solution again.solution >log 2>&1 && ok=yes || ok=no
report $ok "a solution is the same again"
mkdir -p refused
head -c 9000 cage.solution >cut.solution
ends 1 'cut.solution: the packed data is cut off' bind_tiles refused $harmonic --solution cut.solution
cp cage.solution flipped.solution
printf '\377' | dd of=flipped.solution bs=1 seek=7000 conv=notrunc 2>/dev/null
ends 1 'flipped.solution: the checksum of the packed data differs' bind_tiles refused $harmonic --solution flipped.solution
ends 1 'text.ply: the memory holds no packed functions' bind_tiles refused $harmonic --solution bad/text.ply
ends 1 'no.solution: no such file' bind_tiles refused $harmonic --solution no.solution
ends 1 'cage.solution: the packed functions are of another accuracy or another grid' "$tiles" character_cage.obj \
  --points few/00.ply -o refused/a.figure --coordinates harmonic --accuracy 0.1 --solution cage.solution
ends 1 'cage.solution: the packed data was made for another cage' "$tiles" character_pose.obj --points few/00.ply \
  -o refused/a.figure --coordinates harmonic --accuracy 0.05 --solution cage.solution
ends 1 '--save-solution need --coordinates harmonic' bind_tiles refused --points few/00.ply --save-solution no.solution

# ---- outputs, before anything is solved ----
cp few/00.ply in.figure
cp character_cage.obj in.solution
ends 1 'cannot write in.figure: it is the same file as in.figure, which is read' "$tiles" character_cage.obj --points in.figure \
  -o in.figure --coordinates harmonic --save-solution no.solution
ends 1 'cannot write in.solution: it is the same file as in.solution, which is read' "$tiles" in.solution --points few/00.ply \
  -o refused/a.figure --coordinates harmonic --save-solution in.solution
ends 1 'which is written too' bind_tiles refused --points few/00.ply bad/../few/00.ply
awk '$1 == "v" { $2 += 500000 } { print }' character_cage.obj >far_cage.obj
ends 1 'far_cage.obj: is far from the origin: single precision rounds positions there by up to' "$tiles" far_cage.obj --points 'few/*.ply' -o 'refused/*.figure'
ends 1 'write a * in place of the name' "$tiles" character_cage.obj --points 'few/*.ply' -o refused/a.figure
ends 1 'cannot write no_such_folder/00.figure' "$tiles" character_cage.obj --points 'few/*.ply' -o 'no_such_folder/*.figure' \
  --coordinates harmonic --save-solution no.solution
ln -s /dev/full full.solution
ends 1 'cannot write full.solution: it is not a regular file' bind_tiles refused $harmonic --save-solution full.solution
ends 1 '--rows: "3:1" is no range of rows' bind_tiles refused --points 'few/*.ply' --rows 3:1
ends 1 'few/*.obj: no such file' bind_tiles refused --points 'few/*.obj'
ends 1 'a tile takes' bind_tiles refused --points 'few/*.ply' --memory 64
cmp few/00.ply in.figure >log 2>&1 && cmp character_cage.obj in.solution >>log 2>&1 && [ ! -e no.solution ] && [ -z "$(ls refused)" ] && ok=yes || ok=no
report $ok "nothing is written"
cd ..
