# shellcheck shell=sh disable=SC2154 # command_line.sh has set them
# Sourced by command_line.sh: the films of sources/films.
eversion="$programs/sphere_eversion"
homotopy="$programs/plane_homotopy"
zooms="$programs/zooms"

works "a sphere is turned inside out" "$eversion" -o eversion.png --rows 24 --tile 48 --volume volume.svg --stills turn_ --frames 3
[ "$(grep -c '^time ' log)" = 12 ] && [ -s turn_002.png ] && [ ! -e turn_003.png ] && grep -q '<path fill="none"' volume.svg && ok=yes || ok=no
report $ok "twelve stages, three frames, and the curve of the volume"
awk '$1 == "time" && $10 + 0 <= 0.03 { bad = 1 } /^time 0.000/ { first = $6 + 0 } /^time 1.000/ { last = $6 + 0 } END { exit bad || !(first > 2.2 && last < -2.2) }' log && ok=yes || ok=no
report $ok "it stays an immersion, and its volume changes the sign"
works "in a lattice" "$eversion" -o twisted.png --rows 24 --tile 48 --stages 3 --bands 0 --cage lattice:4x4x4 --twist all:z,-1,1,90
[ "$(grep -c 'least determinant 0\.[5-9]' log)" = 3 ] && ok=yes || ok=no
report $ok "which turns nothing inside out"
works "in a box" "$eversion" -o bent.png --rows 16 --tile 32 --stages 2 --cage box
refuses 'operations such as --twist pose a cage: give --cage' "$eversion" -o out.png --twist all:z,-1,1,90
refuses '--twist "all:q,0,1,9"' "$eversion" -o out.png --cage box --twist all:q,0,1,9
refuses 'nowhere.obj' "$eversion" -o out.png --cage nowhere.obj
refuses 'missing/out.png' "$eversion" -o missing/out.png
refuses 'missing/out.svg' "$eversion" -o out.png --volume missing/out.svg
refuses 'missing/still_000.png' "$eversion" -o out.png --stills missing/still_
refuses 'does not end with' "$eversion" -o out.png --gif out.txt
refuses '--stages' "$eversion" -o out.png --stages 1
refuses '--rows' "$eversion" -o out.png --rows nan
refuses 'output is required' "$eversion"

works "a homotopy" "$homotopy" circle loops -o homotopy.svg --png --stills homotopy_ --frames 2
grep -q 'both tangents turn 1 times: the speed is at least 0.9' log && [ -s homotopy.png ] && [ -s homotopy_001.png ] && ok=yes || ok=no
report $ok "it is regular"
works "which must fail" "$homotopy" circle eight -o fails.svg
grep -q 'at s = 0.500000, t = 3.141593: speed' log && grep -q 'speed 0' fails.svg && ok=yes || ok=no
report $ok "halfway, at the top"
works "between random curves" "$homotopy" random:2:1 random:2:7 -o random.svg --columns 2
works "between curves that cancel each other" "$homotopy" 0:2.4048 0:-2.4048 -o eights.svg
grep -q 'the second curve starts at t = ' log && ok=yes || ok=no
report $ok "the second one starts elsewhere"
for curve in square 1 x:1 1.5:1 99:1 nan:1 random:1 random:1:x random:1:0.5 random:1:-1 random:1:1,2 1:nan 1:1e9 1:x '1:,' ''; do
  refuses "$curve: " "$homotopy" circle "$curve" -o out.svg
done
refuses 'curves' "$homotopy" circle -o out.svg
refuses 'missing/out.svg' "$homotopy" circle loops -o missing/out.svg
refuses 'missing/still_000.svg' "$homotopy" circle loops -o out.svg --stills missing/still_
refuses 'output is required' "$homotopy" circle loops

for curve in koch peano sierpinski; do
  works "a zoom: $curve" "$zooms" $curve -o zoom.svg --png --level 2 --size 120 --stills zoom_ --frames 3
  cmp -s zoom_000.png zoom_002.png && ! cmp -s zoom_000.png zoom_001.png && ok=yes || ok=no
  report $ok "the last frame is the first one"
done
grep -q '^dimension 2.000000' log && ok=yes || ok=no
report $ok "which fills a square"
refuses 'curve' "$zooms" dragon -o out.svg
refuses '--level' "$zooms" koch -o out.svg --level 9
refuses '--level: 4 is the most for peano' "$zooms" peano -o out.svg --level 5
refuses '--frames' "$zooms" koch -o out.svg --frames 1
refuses 'missing/out.svg' "$zooms" koch -o missing/out.svg
refuses 'does not end with' "$zooms" koch -o out.png
refuses 'output is required' "$zooms" koch
