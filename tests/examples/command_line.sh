#!/bin/sh
# Usage: command_line.sh PROGRAMS DATA FAILING_READ.so
# Runs the example programs as a newcomer would, wrong arguments and broken files included. A failure must
# exit with 1, name the culprit and leave no output behind.
set -u
programs=$1
data=$2
failing_read=$3
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# LD_PRELOAD allows no space in a path.
cp "$failing_read" "$work/failing_read.so" && failing_read=$work/failing_read.so
cd "$work" || exit 1
passed=0
failed=0

report() { # OK? WHAT
  if [ "$1" = yes ]; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED: $2"; cat log 2>/dev/null; fi
}
works() { # WHAT COMMAND…
  what=$1; shift
  if "$@" >log 2>&1; then report yes "$what"; else report no "$what (exit $?)"; fi
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

deform="$programs/deform_svg"
weights="$programs/cage_weights"
field="$programs/coordinate_field"
table="$programs/figure_table"
cat="$data/cat.svg"
animate="$programs/animate_svg"
cage="$data/cat_cage.svg"
pose="$data/cat_pose_step.svg"

# ---- height_map, diffuse_colours ----
svg() { # NAME CONTENT
  printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 50">%s</svg>' "$2" >"$1"
}
heights="$programs/height_map"
colours="$programs/diffuse_colours"
works "a height map" "$heights" "$data/hills.svg" -o hills.png -o hills.pgm -o hills.csv --lines lines.svg --size 96
works "heights as a surface" "$heights" "$data/hills.svg" -o hills.png --3d hills_3d.png --size 48 --turn 20 --rise 45
works "a grid" "$programs/grid_field" hills.csv -o grid.png --surface surface.png --size 60 --levels 5
printf '1,2,.\n3/4,nan,\n' >holes.csv
works "a grid with cells outside" "$programs/grid_field" holes.csv -o grid.png --surface surface.png --size 60 --signs root --zoom 0,0,2,2
printf '1,2\n3,x\n' >word.csv
printf '1,2\n3\n' >ragged.csv
printf '1,2/0\n' >endless.csv
printf '.,\n' >hollow.csv
refuses 'word.csv:2: column 2: not a number' "$programs/grid_field" word.csv -o out.png
refuses 'ragged.csv:2: 1 columns, and the first line has 2' "$programs/grid_field" ragged.csv -o out.png
refuses 'endless.csv:1: column 2: "2/0" is not finite' "$programs/grid_field" endless.csv -o out.png
refuses 'hollow.csv: has no values' "$programs/grid_field" hollow.csv -o out.png
refuses 'nowhere.csv' "$programs/grid_field" nowhere.csv -o out.png
refuses '--zoom' "$programs/grid_field" hills.csv -o out.png --zoom 1,2,3
works "a height map in a frame" "$heights" "$data/hills.svg" -o hills.png --rim frame --size 64
works "diffusion curves" "$colours" "$data/cat_colours.svg" -o colours.png --size 96 --srgb
svg none.svg '<rect width="5" height="5"/>'
svg word.svg '<path id="r" data-height="high" d="M1,1 L9,9"/>'
svg counts.svg '<path data-height="0 1 0 1" data-left="red" data-right="red blue red" d="M1,1 L9,9"/>'
svg dot.svg '<path stroke="white" d="M1,1 L9,9"/><path id="dot" stroke="white" d="M1.1,1.1 L1.101,1.1"/>'
svg paint.svg '<path stroke="url(#g)" d="M1,1 L9,9"/>'
svg far.svg '<path stroke="white" d="M1,1 L9,99"/>'
: >nothing.svg
for program in "$heights" "$colours"; do
  refuses "none.svg: holds no stroke" "$program" none.svg -o out.png
  refuses "dot.svg: path \"dot\" (line 1) is smaller than a pixel" "$program" dot.svg -o out.png
  refuses "far.svg: path (line 1) extends beyond the picture" "$program" far.svg -o out.png
  refuses "url(#g)" "$program" paint.svg -o out.png
  refuses "values for 2 vertices: give one, two for the ends, or one for each" "$program" counts.svg -o out.png
  refuses "nothing.svg: the file is empty" "$program" nothing.svg -o out.png
  refuses "missing.svg" "$program" missing.svg -o out.png
  refuses "--output is required" "$program" far.svg
done
refuses "\"high\" is not a height from 0 to 1" "$heights" word.svg -o out.png
refuses "does not end with" "$heights" "$data/hills.svg" -o out.txt
refuses "--levels" "$heights" "$data/hills.svg" -o out.png --levels 0

. "$here/clone_image.sh"

# ---- relaxation ----
relaxation="$programs/relaxation"
works "sweeps on a line" "$relaxation" "$data/line.csv" -o sheet.svg --png --play film.svg
[ "$(grep -c 'sweeps\?: steady' log)" = 2 ] && ok=yes || ok=no
report $ok "both runs come to rest"
[ "$(grep -c '<animate ' film.svg)" -gt 5 ] && [ -s sheet.png ] && ok=yes || ok=no
report $ok "there are frames, and a picture"
printf '0\n.\n.\n.\n1\n' >column.csv
works "from linear pieces" "$relaxation" column.csv --guess linear -o sheet.svg
grep -q 'linear pieces: 1 sweep: steady, 0 off' log && ok=yes || ok=no
report $ok "the linear guess is at rest"
echo '.,.,2,.' >one.csv
works "one given value, open ends" "$relaxation" one.csv --guess nearest -o sheet.svg
grep -q 'nearest value: 1 sweep: steady, 0 off' log && ok=yes || ok=no
report $ok "a single value is everywhere"
refuses_line() { # MESSAGE TABLE
  printf '%b' "$2" >line.csv
  refuses "$1" "$relaxation" line.csv -o out.svg --play out.plays.svg
}
refuses_line 'line.csv:1: column 2: ' '1,x,.\n'
refuses_line 'line.csv:1: column 1: ' 'nan,.\n'
refuses_line 'line.csv: holds 2 rows of 2 cells' '1,.\n.,2\n'
refuses_line 'line.csv: no cell has a value' '.,.,.\n'
refuses_line 'line.csv: every cell has a value' '1,2\n'
refuses_line 'line.csv: holds no table' ''
awk 'BEGIN { for (n = 0; n < 1001; n++) print n == 0 ? "1" : "." }' >line.csv
refuses 'line.csv: holds 1001 cells; the limit is 1000' "$relaxation" line.csv -o out.svg
refuses 'missing.csv' "$relaxation" missing.csv -o out.svg
refuses '--guess' "$relaxation" column.csv --guess good -o out.svg
refuses 'does not end with' "$relaxation" column.csv -o out.png

# ---- puzzle ----
puzzle="$programs/puzzle"
works "a puzzle in fractions" "$puzzle" "$data/puzzle.csv" --exact --csv fractions.csv -o puzzle.svg
printf '1,1,0,0\n1,7/12,1/6,0\n0,1/6,1/12,0\n0,0,0,0\n' >expected.csv
works "its answers by four neighbours" cmp fractions.csv expected.csv
works "by eight" "$puzzle" "$data/puzzle.csv" --exact --neighbours 8 --csv fractions.csv
printf '1,1,0,0\n1,4/9,2/9,0\n0,2/9,1/9,0\n0,0,0,0\n' >expected.csv
works "its answers by eight" cmp fractions.csv expected.csv
works "a puzzle is made" "$puzzle" --make 5 7 --seed 4 --csv made.csv
for neighbours in 4 8; do
  works "and solved" "$puzzle" made.csv --exact --neighbours $neighbours --csv solved_$neighbours.csv
done
works "by whole numbers, whichever neighbours count" cmp solved_4.csv solved_8.csv
works "random walks" "$puzzle" "$data/puzzle.csv" --walks 1000 --from 2 2
refuses_table() { # MESSAGE TABLE
  printf '%b' "$2" >table.csv
  refuses "$1" "$puzzle" table.csv --exact --csv out.csv -o out.svg
}
refuses_table 'table.csv:1: column 2: "x" is not a whole number' '1,x\n2,3\n'
refuses_table 'table.csv:1: column 2: "1/0" is not a whole number' '1,1/0\n'
refuses_table 'table.csv:2: column 1: "nan" is not a whole number' '1,2\nnan,3\n'
refuses_table 'table.csv:2: 1 columns, and the first line has 2' '1,2\n3\n'
refuses_table 'table.csv:1: column 1: some unknown cells have no path to a given value' '.,.\n.,.\n'
refuses_table 'table.csv: holds no table' ''
refuses "missing.csv" "$puzzle" missing.csv --csv out.csv
refuses "--neighbours is 4 or 8" "$puzzle" table.csv --neighbours 5
refuses "--walks needs --from" "$puzzle" "$data/puzzle.csv" --walks 5
refuses '"-1" is not a whole number from 0' timeout 20 "$puzzle" "$data/puzzle.csv" --walks -1 --from 2 2
refuses '"1e3" is not a whole number from 0' "$puzzle" "$data/puzzle.csv" --walks 1e3 --from 2 2
refuses 'is too large' "$puzzle" "$data/puzzle.csv" --walks 10 --from 2 2 --seed 99999999999999999999
refuses 'not in range' "$puzzle" "$data/puzzle.csv" --walks 0 --from 2 2
works "leading zeros mean nothing" "$puzzle" "$data/puzzle.csv" --walks 010 --from 2 2
grep -q '^10 walks' log && ok=yes || ok=no
report $ok "010 walks are ten"
refuses "--make takes two numbers" "$puzzle" --make 2 9 --csv out.csv
refuses "a table, or --make, is required" "$puzzle"
"$puzzle" --make 40 40 --csv large.csv
refuses "1444 unknown cells are too many for --exact" "$puzzle" large.csv --exact --csv out.csv

# ---- bezier_tables ----
printf 'captions,1\ncaptions,x\n' >known.csv
refuses 'known.csv:2: ' "$programs/bezier_tables" known.csv
sed '/^brute_force/s/,.*/,2/' "$data/bezier_tables.csv" >known.csv
refuses 'row 1 of table brute_force has fewer than 13 numbers' "$programs/bezier_tables" known.csv

# ---- sibson_figures ----
mkdir figures
works "figures of natural neighbours" "$programs/sibson_figures" figures
refuses "cannot write" "$programs/sibson_figures" no_folder
refuses "folder is required" "$programs/sibson_figures"

# ---- deform_svg ----
for type in mean-value harmonic; do
  works "deform the cat, $type" "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates $type -o cat.svg
done
works "deform the man" "$deform" "$data/man.svg" --cage "$data/man_cage.svg" --pose "$data/man_pose.svg" --coordinates barycentric -o man.svg
works "the rest pose" "$deform" "$cat" --cage "$cage" --pose "$cage" -o rest.svg --report --show-cage
works "the rest pose, harmonic" "$deform" "$cat" --cage "$cage" --pose "$cage" --coordinates harmonic -o rest_harmonic.svg
works "help" "$deform" --help
: >empty.svg
printf '<svg xmlns="http://www.w3.org/2000/svg"><path d="M 0 0 L 10 0 L 10 10"/></svg>' >open.svg
printf '<svg xmlns="http://www.w3.org/2000/svg"><polygon points="0,0 10,10 10,0 0,10"/></svg>' >bow_tie.svg
printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path d="M 200 300\n L 210 300 ?"/></svg>' >malformed.svg
printf '<svg xmlns="http://www.w3.org/2000/svg"><g></svg>' >unclosed.svg
printf 'this is no svg' >text.svg
refuses 'nowhere.svg' "$deform" nowhere.svg --cage "$cage" --pose "$pose" -o out.svg
refuses 'nowhere.svg' "$deform" "$cat" --cage nowhere.svg --pose "$pose" -o out.svg
refuses 'nowhere.svg' "$deform" "$cat" --cage "$cage" --pose nowhere.svg -o out.svg
refuses 'empty.svg' "$deform" empty.svg --cage "$cage" --pose "$pose" -o out.svg
refuses 'empty.svg' "$deform" "$cat" --cage empty.svg --pose "$pose" -o out.svg
refuses 'open path' "$deform" "$cat" --cage open.svg --pose "$pose" -o out.svg
refuses 'cross' "$deform" "$cat" --cage bow_tie.svg --pose bow_tie.svg -o out.svg
refuses 'cross' "$deform" "$cat" --cage bow_tie.svg --pose bow_tie.svg --coordinates harmonic -o out.svg
works "a path that cannot be read to its end" "$deform" malformed.svg --cage "$cage" --pose "$pose" -o read.svg
grep -q 'warning: malformed.svg: path: d at 2:12: expected a command letter (line 1)' log && grep -q ' d="M[^?"]*"' read.svg && ok=yes || ok=no
report $ok "it is drawn up to the fault, which is named"
refuses 'malformed.svg: path: d at 2:12: expected a command letter (line 1)' "$deform" "$cat" --cage malformed.svg --pose "$pose" -o out.svg
refuses 'unclosed.svg' "$deform" unclosed.svg --cage "$cage" --pose "$pose" -o out.svg
refuses 'text.svg' "$deform" text.svg --cage "$cage" --pose "$pose" -o out.svg
refuses 'the pose has a loop of 3 vertices, the cage' "$deform" "$cat" --cage "$cage" --pose "$data/man_pose.svg" -o out.svg
refuses 'outside the cage' "$deform" "$cat" --cage "$data/man_cage.svg" --pose "$data/man_pose.svg" --outside refuse -o out.svg
# a figure that leaves the picture: cut off with a warning, or the picture grows
printf '%s\n' -1,-1 11,-1 11,11 -1,11 >picture_cage.csv
printf '%s\n' 4,-1 16,-1 16,11 4,11 >picture_pose.csv
echo '<svg viewBox="0 0 10 10" width="20"><linearGradient id="g" gradientUnits="userSpaceOnUse" x2="10"><stop/></linearGradient><rect width="9" height="9" fill="url(#g)"/></svg>' >picture.svg
works "a figure cut off" "$deform" picture.svg --cage picture_cage.csv --pose picture_pose.csv -o cut.svg
grep -q 'warning: 1 shape is cut off' log && grep -q 'viewBox="0 0 10 10"' cut.svg && grep -q 'gradientTransform="matrix(1 0 0 1 5 0)"' cut.svg && ok=yes || ok=no
report $ok "what is cut off is counted, and the gradient follows"
works "--fit" "$deform" picture.svg --cage picture_cage.csv --pose picture_pose.csv --fit -o fitted.svg
[ ! -s log ] && grep -q 'viewBox="-0.01[0-9]* -0.01[0-9]* 14.0[0-9]* 10.0[0-9]*" width="28.0' fitted.svg && ok=yes || ok=no
report $ok "the picture grows"
works "the picture at rest" "$deform" picture.svg --cage picture_cage.csv --pose picture_cage.csv -o rest_picture.svg
cmp -s picture.svg rest_picture.svg && ok=yes || ok=no
report $ok "what does not move stays byte by byte"
# letters: as a whole, or as outlines, in the order drawn and in their own paint
echo '<svg viewBox="0 0 10 10"><style>text { fill: red }</style><defs><text id="d">d</text></defs><g transform="scale(.5)"><text class="k" x="3" y="9" font-size="6">a<tspan stroke="blue" dy="2">&amp;</tspan></text><text> </text></g></svg>' >letters.svg
works "a text" "$deform" letters.svg --cage picture_cage.csv --pose picture_pose.csv -o out.svg
grep -q 'text (line 1): keeps its letters' log && grep -q '<text class="k" .* transform="matrix(1 0 0 1 10 0)"' out.svg && ok=yes || ok=no
report $ok "a text moves as a whole"
works "a text as paths" "$deform" letters.svg --text-as-paths --cage picture_cage.csv --pose picture_pose.csv -o out.svg
grep -q '<g class="k" font-size="6" style="fill:red"><path d="M[^"]*"/><g stroke="blue"><path d="M[^"]*"/></g></g><text' out.svg &&
  grep -q '<text id="d"' out.svg && ! grep -q 'keeps its letters' log && ok=yes || ok=no
report $ok "letters become paths"
sed 's|<text> </text>|<use href="#d" x="2" y="8"/>|' letters.svg >used.svg
works "a text that is used, as paths" "$deform" used.svg --text-as-paths --cage picture_cage.csv --pose picture_pose.csv -o out.svg
grep -q 'transform="translate(2 8)"><g style="fill:red"><path d="M' out.svg && ! grep -q 'keeps its letters' log && ok=yes || ok=no
report $ok "the copy's letters become paths"
# letters in lists of places stand where letters alone would
drawn_letters() { # NAME TEXTS   prints the outlines
  svg "$1" "<g font-size='20'>$2</g>"
  works "letters, $1" "$deform" "$1" --text-as-paths --cage wide_cage.csv --pose wide_cage.csv -o letters_out.svg
  grep -o ' d="[^"]*"' letters_out.svg | sed 's/ d="//; s/"/ /' | tr -d '\n' | tr M '\n' | sort
}
printf '%s\n' -9,-9 150,-9 150,59 -9,59 >wide_cage.csv
[ "$(drawn_letters listed.svg '<text x="5 25
  50,70" y="20 30">  a&amp;  <tspan y="40" dx="3 4">bc</tspan>d <tspan dx="2 5">e f</tspan> </text>')" = "$(drawn_letters alone.svg \
  '<text x="5" y="20">a</text><text x="25" y="30">&amp;</text><text x="73" y="40">b<tspan dx="4">c</tspan>d <tspan dx="2">e</tspan><tspan dx="5">&#x200b;&#160;f</tspan></text>')" ] && ok=yes || ok=no
report $ok "lists of places"
svg turned.svg '<text y="20" rotate="9 20">ab</text>'
works "turned letters" "$deform" turned.svg --text-as-paths --cage wide_cage.csv --pose wide_cage.csv -o letters_out.svg
grep -q 'warning: text (line 1): the outlines ignore rotate: 9 20' log && ok=yes || ok=no
report $ok "turned letters are named"
for property in dominant-baseline:hanging word-spacing:2em text-transform:uppercase alignment-baseline:middle; do
  for place in "<text y='20' style='$property'>a b" "<text y='20'>a <tspan ${property%:*}='${property#*:}'>b</tspan>" \
    "<style>.k{$property}</style><text y='20' class='k'>a b"; do
    svg placed.svg "$place</text>"
    works "$place" "$deform" placed.svg --text-as-paths --cage wide_cage.csv --pose wide_cage.csv -o letters_out.svg
    grep -q "warning: tspan.* (line 1): the outlines ignore ${property%:*}: ${property#*:}\$\|warning: text (line 1): the outlines ignore ${property%:*}: ${property#*:}\$" log && ok=yes || ok=no
    report $ok "it is named"
  done
done
# lines of text-decoration, wherever they are written
lined=$(drawn_letters lined.svg '<text y="20" text-decoration="underline overline">a<tspan text-decoration="underline overline">b</tspan></text>')
[ "$(printf '%s\n' "$lined" | wc -l)" -gt "$(($(drawn_letters bare.svg '<text y="20">a<tspan>b</tspan></text>' | wc -l) + 3))" ] && ok=yes || ok=no
report $ok "lines are drawn"
letters='a<tspan>b</tspan></text>'
for text in "<text y='20' text-decoration='underline overline'>$letters" "<text y='20' style='text-decoration:overline dotted UNDERLINE red'>$letters" \
  "<text y='20' style='text-decoration-line:underline overline'>$letters" "<g style='text-decoration:underline'><text y='20' text-decoration='overline'>$letters</g>" \
  "<style>tspan{fill:red}.k{text-decoration:overline underline}</style><text y='20' class='k'>$letters"; do
  [ "$(drawn_letters lined.svg "$text")" = "$lined" ] && ok=yes || ok=no
  report $ok "lines: $text"
done
mkdir -p no_programs
refuses 'letters.svg: texts cannot become paths: rsvg-convert (librsvg2-bin) is not installed' \
  env PATH=no_programs "$deform" letters.svg --text-as-paths --cage picture_cage.csv --pose picture_pose.csv -o out.svg
refuses 'not defined outside' "$deform" "$cat" --cage "$data/man_cage.svg" --pose "$data/man_pose.svg" --coordinates harmonic --outside extend -o out.svg
refuses 'simplex' "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates barycentric -o out.svg
refuses 'magic' "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates magic -o out.svg
refuses 'resolution' "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates harmonic --resolution 3 -o out.svg
works "a coarse grid" "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates harmonic --resolution 32 -o out.svg
grep -q 'warning: .*the grid is coarse for the corner at vertex 19 .*off by up to 0.0.* at --resolution 79$' log && ok=yes || ok=no
report $ok "a coarse grid is warned of, with a resolution that will do"
works "a finer grid" "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates harmonic --resolution 79 -o out.svg
grep -q 'the grid is coarse' log && ok=no || ok=yes
report $ok "that resolution will do"
works "local harmonic coordinates" "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates harmonic --locality 20 -o local.svg
works "harmonic coordinates" "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates harmonic --locality 0 -o global.svg
cmp -s local.svg global.svg && ok=no || ok=yes
report $ok "a locality changes the pose"
for wrong in 41 -1 nan; do
  refuses '--locality: ' "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates harmonic --locality $wrong -o out.svg
done
refuses '--pose' "$deform" "$cat" --cage "$cage" -o out.svg
refuses 'missing/out.svg' "$deform" "$cat" --cage "$cage" --pose "$pose" -o missing/out.svg
sed 's|</svg>|<path d="M 60 40 L 160 40 L 160 90 Z"/></svg>|' "$cat" >beside.svg
works "points outside" "$deform" beside.svg --cage "$cage" --pose "$pose" -o outside.svg
[ "$(grep -c 'lie outside the cage.*they follow the extension of the coordinates' log)" = 1 ] && ok=yes || ok=no
report $ok "one warning of points outside"
# A figure is judged as a whole: the result of no element depends on the others, the verdict not on their order.
# Small shapes inside need no more points than at first, large ones outside do.
for seed in 1 2; do
  awk -v seed=$seed 'BEGIN {
    srand(seed)
    for (i = 0; i < 24; ++i) {
      far = i % 8 == 7; size = far ? 30 : 1
      printf "<path id=\"p%d\"%s d=\"M%.2f %.2f", i, i % 5 == 0 ? " fill=\"none\"" : "", far ? -10 + 10 * rand() : 10 + 80 * rand(), far ? -5 + 10 * rand() : 10 + 80 * rand()
      for (k = 0; k < 3; ++k) printf "q%.2f %.2f %.2f %.2f", size * rand(), size * (rand() - 0.5), size * rand(), size * (rand() - 0.5)
      print "z\"/>"
    }
  }' >in_order
  sort -t '"' -k 5 in_order >shuffled
  sed '1!G;h;$!d' in_order >reversed
  for size in 5,95 45,55; do
    low=${size%,*} high=${size#*,}
    printf '%s\n' $low,$low $high,$low $high,$high $low,$high >frame.csv
    for type in mean-value harmonic green; do
      for order in in_order shuffled reversed; do
        { echo '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">'; cat $order; echo '</svg>'; } >ordered.svg
        rm -f ordered_out.svg
        "$deform" ordered.svg --cage frame.csv --move 0:-9,-20 --coordinates $type -o ordered_out.svg >log 2>&1
        { echo $?; sed 's/, first [^;]*;/;/; s/, first .*: is it/: is it/' log; } >$order.verdict
        if [ -f ordered_out.svg ]; then grep '^<path' ordered_out.svg; fi | sort >$order.result
      done
      for threads in 1 2 3; do
        rm -f ordered_out.svg
        "$deform" ordered.svg --cage frame.csv --move 0:-9,-20 --coordinates $type --threads $threads -o ordered_out.svg >log 2>&1
        { echo $?; cat log; if [ -f ordered_out.svg ]; then cat ordered_out.svg; fi; } >$threads.threads
      done
      cmp -s 1.threads 2.threads && cmp -s 1.threads 3.threads && ok=yes || ok=no
      report $ok "any number of threads, $type, $size, $seed"
      cmp -s in_order.verdict shuffled.verdict && cmp -s in_order.verdict reversed.verdict &&
        cmp -s in_order.result shuffled.result && cmp -s in_order.result reversed.result && ok=yes || ok=no
      report $ok "any order of elements, $type, $size, $seed"
      case $size in 5,*) verdict='^0' ;; *) verdict='^1' ;; esac
      head -1 in_order.verdict | grep -q "$verdict" && ok=yes || ok=no
      report $ok "most of the figure is in, or out: $type, $size, $seed"
      [ $size = 5,95 ] || continue
      case $type in harmonic) policy=nearest ;; *) policy=extend ;; esac
      for n in 3 8 17; do
        { echo '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">'; sed -n ${n}p in_order; echo '</svg>'; } >ordered.svg
        works "an element alone" "$deform" ordered.svg --cage frame.csv --move 0:-9,-20 --coordinates $type --outside $policy -o ordered_out.svg
        grep -qxF "$(grep '^<path' ordered_out.svg)" in_order.result && ok=yes || ok=no
        report $ok "the same alone, $type, $n, $seed"
      done
    done
  done
done
# Elements that are not seen may lie outside.
printf '%s\n' 0,0 20,0 20,20 0,20 >frame.csv
for hidden in 'fill="none"' 'visibility="hidden"' 'opacity="0"' 'fill="transparent"' 'fill="#12345600"' 'fill-opacity="0"' \
  'style="fill:none; stroke:red; stroke-opacity:0"' 'fill="none" stroke="red" stroke-width="0"' \
  'fill="hsl(20 30% 40% / 0)"' 'fill="url(#gone) none"' 'clip-path="url(#nothing)"'; do
  svg hidden.svg "<clipPath id='nothing'/><rect x='5' y='5' width='9' height='9'/><rect width='90' height='40' $hidden/>"
  works "hidden outside: $hidden" "$deform" hidden.svg --cage frame.csv --turn 0:9 --outside refuse -o hidden_out.svg
  [ ! -s log ] && ok=yes || ok=no
  report $ok "nothing is said of it"
done
svg shown.svg "<rect x='5' y='5' width='9' height='9'/><rect width='90' height='40'/>"
refuses 'of shown.svg lie outside' "$deform" shown.svg --cage frame.csv --turn 0:9 --outside refuse -o out.svg
# Far from a tiny lattice some points have no weights: their element is named, the others move as alone.
cat >tiny.lattice.json <<'END'
{"format": "lattice/1", "axes": [{"points": 2, "degree": 1}, {"points": 2, "degree": 1}],
 "frame_columns": [[1e-13, 0], [0, 1e-13]], "origin": [0, 0], "falloff": 0}
END
near='<path id="near" d="M20 20L70 25C70 60 40 70 30 60z"/>'
far='<path id="far" d="M120 20L170 25L140 30z"/>'
svg near.svg "$near"
svg both.svg "$far$near"
for name in near both; do
  works "a tiny lattice, $name" "$deform" $name.svg --cage tiny.lattice.json --move all:9,5 --outside nearest-boundary -o ${name}_out.svg
done
grep -q 'both.svg: no weights can be computed for' log && grep -q 'path "far".*stays unchanged' log && ok=yes || ok=no
report $ok "the element without weights is named"
grep -o '<path id="near"[^>]*>' near_out.svg >expected && grep -o '<path id="near"[^>]*>' both_out.svg | cmp -s - expected &&
  ! grep -qF "$near" both_out.svg && grep -qF "$far" both_out.svg && ok=yes || ok=no
report $ok "the other moves as alone"
for policy in keep nearest extend; do
  works "outside: $policy" "$deform" "$cat" --cage "$data/man_cage.svg" --pose "$data/man_pose.svg" --outside $policy -o kept.svg
done
printf '40,30\n340,30\n340,330\n40,330\n' >head_cage.csv
printf '0,20\n300,-10\n320,290\n20,320\n' >head_pose.csv
refuses 'does this cage belong to another figure' "$deform" "$cat" --cage head_cage.csv --pose head_pose.csv -o out.svg
works "a cage of the head alone" "$deform" "$cat" --cage head_cage.csv --pose head_pose.csv --falloff 100 --report -o head.svg
grep -q '^  outside, within the falloff: [1-9]' log && ! grep -q warning log && ok=yes || ok=no
report $ok "the report lists what fades, and nothing is warned of"
works "as harmonic coordinates have none outside, by the nearest boundary" "$deform" "$cat" --cage head_cage.csv --pose head_pose.csv --coordinates harmonic --falloff 100 -o head.svg
for falloff in -1 nan inf far; do
  refuses '--falloff' "$deform" "$cat" --cage head_cage.csv --pose head_pose.csv --falloff $falloff -o out.svg
done
for policy in keep-in-place refuse; do
  refuses "--falloff: with --outside $policy no point outside moves" "$deform" "$cat" --cage head_cage.csv --pose head_pose.csv --falloff 9 --outside $policy -o out.svg
done
refuses 'not defined outside' "$deform" "$cat" --cage head_cage.csv --pose head_pose.csv --coordinates harmonic --falloff 9 --outside extend -o out.svg

# ---- cage_weights ----
printf '0,0\n2,0\n2,2\n0,2\n\n0.5,0.5\n0.5,1\n1,1\n' >hole.csv
printf '1.5,1.5\n2,1\n0.6,0.7\nnan,0\n5,5\n' >points.csv
works "weights" "$weights" --cage hole.csv --points points.csv --report -o weights.csv
grep -q '^points: 5$' log && grep -q '^  outside: 2 (2, 4)$' log && grep -q '^  not finite: 1 (3)$' log && ok=yes || ok=no
report $ok "the report counts and names points"
[ "$(wc -l <weights.csv)" -eq 6 ] && [ "$(head -1 weights.csv)" = status,w0,w1,w2,w3,w4,w5,w6 ] && ok=yes || ok=no
report $ok "a header and a line a point"
sed -n 3p weights.csv | grep -q '^on_boundary,0,0.5,0.5,0,0,0,0$' && ok=yes || ok=no
report $ok "the middle of an edge"
sed -n 5p weights.csv | grep -q '^not_finite,nan,' && ok=yes || ok=no
report $ok "no weights for a point that is not finite"
printf '3,1\n6,1\n1.5,1.5\n' >away.csv
works "weights that fade" "$weights" --cage hole.csv --points away.csv --outside nearest-boundary --falloff 2 -o away_weights.csv
[ "$(sed 1d away_weights.csv | cut -d, -f1-5 | tr '\n' ' ')" = "outside,0,0.25,0.25,0 outside,0,0,0,0 $(sed -n 2p weights.csv | cut -d, -f1-5) " ] && ok=yes || ok=no
report $ok "half of the nearest boundary's at half the falloff, none beyond, those inside as before"
refuses '--falloff: with --outside keep-in-place' "$weights" --cage hole.csv --points away.csv --outside keep-in-place --falloff 2 -o out.csv
refuses 'give --outside nearest-boundary' "$weights" --cage hole.csv --points away.csv --coordinates harmonic --falloff 2 -o out.csv
refuses '--falloff' "$weights" --cage hole.csv --points away.csv --falloff -2 -o out.csv
for scalar in float double; do
  for type in mean-value harmonic; do
    works "weights, $scalar $type" "$weights" --cage hole.csv --points points.csv --coordinates $type --scalar $scalar --resolution 64 --tolerance 1e-5 -o w.csv
  done
done
printf '0,0\n4,0\n4,4\n0,4\n' >square.csv
printf '1,1\nnan,1\n2,-1e39\n' >huge.csv
for scalar in double float; do
  works "points that are not finite, $scalar" "$weights" --cage square.csv --points huge.csv --scalar $scalar -o w.csv
  case $scalar in double) bad="1 of 3" last=unreached ;; *) bad="2 of 3" last=not_finite ;; esac
  grep -q "warning: huge.csv: $bad points are not finite, first number 1 counted from 0: their weights are nan; --strict" log &&
    [ "$(cut -d, -f1 w.csv | tr '\n' ,)" = "status,inside,not_finite,$last," ] && ok=yes || ok=no
  report $ok "keep their rows, $scalar"
  refuses 'huge.csv:2: a number is not finite' "$weights" --cage square.csv --points huge.csv --scalar $scalar -o out.csv --strict
done
grep -v nan huge.csv >beyond.csv
refuses 'beyond.csv:2: -1e+39 is beyond single precision, which ends at 3.4e38' "$weights" --cage square.csv --points beyond.csv --scalar float -o out.csv --strict
refuses 'huge.csv: vertex 2: -1e+39 is beyond single precision' "$weights" --cage huge.csv --points square.csv --scalar float -o out.csv
awk -F, '{ printf "%d,%d\n", $1 + 500000, $2 + 4600000 }' square.csv >far.csv
for type in mean-value sibson; do
  works "far away, $type" "$weights" --cage far.csv --points far.csv --coordinates $type -o far_weights.csv
  refuses 'far.csv: is far from the origin: single precision rounds positions there' "$weights" --cage far.csv --points far.csv --coordinates $type --scalar float -o out.csv
done
awk 'BEGIN { for (i = 0; i < 300000; ++i) printf "7x" }' >long.csv
refuses 'long.csv:1: ' "$weights" --cage square.csv --points long.csv -o out.csv
[ "$(wc -c <log)" -lt 300 ] && ok=yes || ok=no
report $ok "a message does not quote all of a long line"
awk 'BEGIN { srand(3); for (i = 0; i < 400; ++i) print rand() "," rand() }' >tangle.csv
refuses 'more' "$weights" --cage tangle.csv --points square.csv -o out.csv
[ "$(wc -l <log)" -lt 20 ] && ok=yes || ok=no
report $ok "faults are listed up to ten"
{ echo '<svg xmlns="http://www.w3.org/2000/svg" viewBox="-30 -30 60 60">'
  for line in $(seq 500); do echo "<text>$line</text>"; done
  echo '<path d="M 1 1 L 2 1 L 2 2"/></svg>'; } >texts.svg
works "an SVG of texts" "$deform" texts.svg --cage square.csv --pose square.csv --outside extend -o texts_out.svg
[ "$(wc -l <log)" -lt 5 ] && grep -q 'text (line 2) and 499 more: keeps its letters' log && ok=yes || ok=no
report $ok "warnings of one kind are one line"
printf '2,2\n1,2\n' >middle.csv
works "a report of a square" "$weights" --cage square.csv --points middle.csv --report -o w.csv
grep -q 'least weight: 0.1' log && ok=yes || ok=no
report $ok "the least weight is one of the weights"
works "points from a pipe" sh -c "cat middle.csv | '$weights' --cage square.csv --points /dev/stdin -o w.csv"
[ "$(wc -l <w.csv)" -eq 3 ] && ok=yes || ok=no
report $ok "all points of a pipe"
echo precious >keep.csv
printf 'x,y\n' >header.csv
refuses 'holds no points' "$weights" --cage square.csv --points header.csv -o keep.csv
grep -q precious keep.csv && ok=yes || ok=no
report $ok "the output of a refused run is what it was"
mkdir -p folder.csv
refuses 'is a folder' "$weights" --cage folder.csv --points middle.csv -o out.csv
refuses 'is a folder' "$weights" --cage square.csv --points folder.csv -o out.csv
# A place outside by a rounding counts as on the boundary.
printf '1,-1e-13\n1,-0.5\n' >near.csv
for type in mean-value harmonic sibson; do
  for outside in extend keep; do
    case $type$outside in mean-valueextend) beyond='[-0-9.]' ;; *) beyond=nan ;; esac
    works "places near the boundary, $type" "$weights" --cage square.csv --points near.csv --coordinates $type --outside $outside -o w.csv --report
    grep -q '^  on the boundary: 1 (0)$' log && grep -q '^  outside: 1 (1)$' log && ok=yes || ok=no
    report $ok "the report counts them, $type $outside"
    sed -n 2p w.csv | awk -F, '{ for (k = 2; k <= 5; ++k) if (($k - (k == 2 ? 0.75 : k == 3 ? 0.25 : 0)) ^ 2 > 1e-20) exit 1 } $1 != "on_boundary" { exit 1 }' &&
      sed -n 3p w.csv | grep -q "^outside,$beyond" && ok=yes || ok=no
    report $ok "they have the boundary's weights, $type $outside"
  done
done
printf '1,2\n3\n' >short.csv
printf '1,2\n3,x\n' >word.csv
printf '0,0\n1,1\n' >two.csv
: >empty.csv
refuses 'short.csv:2' "$weights" --cage hole.csv --points short.csv -o out.csv
refuses 'word.csv:2: not a number: "x"' "$weights" --cage hole.csv --points word.csv -o out.csv
refuses 'empty.csv' "$weights" --cage hole.csv --points empty.csv -o out.csv
refuses 'empty.csv' "$weights" --cage empty.csv --points points.csv -o out.csv
refuses 'fewer than three vertices' "$weights" --cage two.csv --points points.csv -o out.csv
refuses 'nowhere.csv' "$weights" --cage hole.csv --points nowhere.csv -o out.csv
refuses 'half' "$weights" --cage hole.csv --points points.csv --scalar half -o out.csv
refuses 'tolerance' "$weights" --cage hole.csv --points points.csv --coordinates harmonic --tolerance 0 -o out.csv

# Cells inside: a chain from corner to corner, whose ends are those corners (computed elsewhere,
# tests/data/oracle/harmonic2d_splitting_chain_hexagonlike_split_chain.json), and a point.
printf '0,0\n3,0\n4,2\n3,4\n0,4\n-1,2\n\n# chain\n0,0\n1.5,1\n2,2.5\n3,4\n' >split.csv
printf '%s\n' 3.20330810546875,1.0601654052734375 0.384674072265625,0.143402099609375 1.7132568359375,0.897613525390625 >points.csv
printf '%s\n' 0.0166616,0.4582292,0.3938069,0.0187125,0,0,0.0558487,0.0567411 0.8001044,0.0565311,0.0000096,0.0000013,0,0,0.1433376,0.0000160 \
  0.1051080,0.1640736,0.0307739,0.0050666,0,0,0.6144304,0.0805476 >expected.csv
works "weights of a chain" "$weights" --cage split.csv --points points.csv --coordinates harmonic --resolution 256 -o w.csv
[ "$(head -1 w.csv)" = status,w0,w1,w2,w3,w4,w5,w6,w7 ] && ok=yes || ok=no
report $ok "the chain adds two handles"
tail -n +2 w.csv | paste -d, - expected.csv | awk -F, '{ for (k = 2; k <= 9; k++) if (($k - $(k + 8)) ^ 2 > 1e-8) bad = 1 } END { exit bad || NR != 3 }' && ok=yes || ok=no
report $ok "the weights of a chain are right to 1e-4"
printf '0,0\n4,0\n4,4\n0,4\n\n# point 0.5\n2,2\n' >head.csv
printf '2.3,2.3\n3,2\n' >points.csv
works "weights of a point" "$weights" --cage head.csv --points points.csv --coordinates harmonic --linear-precision leave -o w.csv
[ "$(sed -n 2p w.csv)" = on_boundary,0,0,0,0,1 ] && ok=yes || ok=no
report $ok "what lies within the radius of a point follows it alone"
for type in mean-value barycentric; do
  refuses 'interior cells not supported (1): --coordinates harmonic supports them' "$weights" --cage head.csv --points points.csv --coordinates $type -o out.csv
done
cells() { # CELLS: bad.csv with them from line 6
  printf '0,0\n4,0\n4,4\n0,4\n\n%b' "$1" >bad.csv
}
faulty() { # MESSAGE CELLS
  cells "$2"
  refuses "$1" "$weights" --cage bad.csv --points points.csv --coordinates harmonic -o out.csv
}
faulty 'bad.csv:6: the radius is missing' '# point\n2,2\n'
faulty 'bad.csv:6: not a number: "wide"' '# point wide\n2,2\n'
faulty 'bad.csv:6: more than one point follows' '# point 1\n2,2\n3,3\n'
faulty 'bad.csv:6: a chain has two points or more' '# chain\n2,2\n'
faulty 'bad.csv:6: no points follow' '# chain\n\n2,2\n3,3\n'
faulty 'bad.csv:6: "# chain" must be alone on its line' '# chain 3\n2,2\n3,3\n'
faulty 'bad.csv:8: an empty line is missing before # point 1' '# chain\n1,1\n# point 1\n2,2\n'
faulty 'bad.csv:7: 3 columns, but a point in the plane has two: x,y' '# chain\n1,1,1\n2,2\n'
faulty 'radius not positive (4)' '# point 0\n2,2\n'
faulty 'interior cell outside (4)' '# point 0.5\n9,2\n'
faulty 'interior cells touch (4, ' '# point 3\n2,2\n'
printf '# chain\n1,1\n2,2\n' >bad.csv
refuses 'bad.csv: holds no loop' "$weights" --cage bad.csv --points points.csv -o out.csv

for cells in head spine; do
  works "the cat's $cells" "$deform" "$cat" --cage "$data/cat_cage_$cells.csv" --pose "$data/cat_pose_$cells.csv" --coordinates harmonic --show-cage -o $cells.svg
  works "the cat's $cells at rest" "$deform" "$cat" --cage "$data/cat_cage_$cells.csv" --pose "$data/cat_cage_$cells.csv" --coordinates harmonic -o cells_rest.svg
  cmp -s rest_harmonic.svg cells_rest.svg && ok=yes || ok=no
  report $ok "at rest the cells inside change nothing"
  refuses 'interior cells not supported' "$deform" "$cat" --cage "$data/cat_cage_$cells.csv" --pose "$data/cat_pose_$cells.csv" -o out.svg
  refuses 'the pose has 1 block, the cage' "$deform" "$cat" --cage "$data/cat_cage_$cells.csv" --pose "$pose" --coordinates harmonic -o out.svg
done
grep -q '<circle cx="215" cy="245" r="60"' head.svg && ok=yes || ok=no
report $ok "--show-cage draws the point with its radius"
grep -q 'd="M345 335 L460 262 L600 270 L740 375"' spine.svg && ok=yes || ok=no
report $ok "--show-cage draws the chain"
sed 's/^# point 60/# point 50/' "$data/cat_pose_head.csv" >bad.csv
refuses 'bad.csv: block 2: the pose has a point of radius 50, the cage' "$deform" "$cat" --cage "$data/cat_cage_head.csv" --pose bad.csv --coordinates harmonic -o out.svg
sed '$d' "$data/cat_pose_spine.csv" >bad.csv
refuses 'bad.csv: block 2: the pose has a chain of 3 points, the cage' "$deform" "$cat" --cage "$data/cat_cage_spine.csv" --pose bad.csv --coordinates harmonic -o out.svg
sed '9s/0,0/0,1/' split.csv >bad.csv
refuses 'bad.csv: vertex 0 of the cage split.csv is at (0, 0) and, in block 2, at (0, 1)' "$deform" "$cat" --cage split.csv --pose bad.csv --coordinates harmonic -o out.svg

# ---- make_character, deform_mesh, cage_weights in space ----
mesh="$programs/deform_mesh"
works "help of the meshes" "$mesh" --help
works "a character" "$programs/make_character" folder/character
grep -q 'character_cage.obj: 112 vertices, 220 faces$' log && ok=yes || ok=no
report $ok "the character's cage has 112 vertices"
refuses 'cannot make the folder' "$programs/make_character" square.csv
refuses 'folder' "$programs/make_character"
refuses '--followers: give a folder' "$programs/make_character" -o out.glb --followers
refuses '--girth: Value 1.6 not in range' "$programs/make_character" folder/fat --girth 1.6
refuses '--child: Value -0.1 not in range' "$programs/make_character" folder/fat --child -0.1
refuses '--output excludes --child' "$programs/make_character" -o out.glb --child 1
works "a fat child with clothes" "$programs/make_character" folder/fat --girth 1.3 --child 1 --followers
for name in character character_tights character_skirt; do
  [ "$(grep -c '^v ' folder/fat/$name.obj)" -gt 1000 ] && ok=yes || ok=no
  report $ok "the fat child has $name.obj"
done
[ "$(grep -c '^[^#]' folder/fat/character.landmarks.csv)" = 34 ] && ok=yes || ok=no
report $ok "the fat child has 15 places on its skin and 18 joints"
for name in character character_cage character_pose; do cp folder/character/$name.obj .; done
for type in mean-value harmonic green; do
  works "deform the character, $type" "$mesh" character.obj --cage character_cage.obj --pose character_pose.obj --coordinates $type -o posed_$type.obj --report --picture posed.png
  grep -q '^  outside: 0$' log && ok=yes || ok=no
  report $ok "the character lies in its cage"
  [ "$(grep -c '^[vf]' posed_$type.obj)" = "$(grep -c '^[vf]' character.obj)" ] && ok=yes || ok=no
  report $ok "every vertex, normal and face is there"
  works "the character at rest, $type" "$mesh" character.obj --cage character_cage.obj --pose character_cage.obj --coordinates $type -o rest.obj
  cmp -s character.obj rest.obj && ok=yes || ok=no
  report $ok "at rest, $type, the file is the same"
done
# So many vertices that their weights are not held together: forty characters, each moved as one is.
awk '/^v / { v[n++] = $0 } END { for (k = 0; k < 40; ++k) for (i = 0; i < n; ++i) print v[i]; print "f 1 2 3" }' character.obj >crowd.obj
works "a crowd, in batches" "$mesh" crowd.obj --cage character_cage.obj --pose character_pose.obj --coordinates mean-value -o crowd_out.obj --report
grep -q "^points: *$(grep -c '^v ' crowd.obj)" log && ok=yes || ok=no
report $ok "the report is of all batches"
grep '^v ' posed_mean-value.obj >one.txt
grep '^v ' crowd_out.obj | tail -n "$(wc -l <one.txt)" | paste - one.txt |
  awk '{ for (k = 2; k <= 4; ++k) if (($k - $(k + 4)) ^ 2 > 1e-24) exit 1 }' && ok=yes || ok=no
report $ok "batches move vertices as a whole does"
works "a weight painted on the character" "$mesh" character.obj --cage character_cage.obj --pose character_pose.obj -o posed.obj --picture painted.png --weight 30
cmp -s posed.png painted.png && ok=no || ok=yes
report $ok "the paint is seen"
refuses 'there is no vertex 112: character_cage.obj has 112' "$mesh" character.obj --cage character_cage.obj --pose character_pose.obj -o out.obj --picture out.png --weight 112
refuses '--weight needs --picture' "$mesh" character.obj --cage character_cage.obj --pose character_pose.obj -o out.obj --weight 1
printf 'v 0 1 0\nv 0 1 0.01\nv 0 1.01 0\nv 0.01 1 0\n' >points.obj
# Faces of more than three corners: kept as polygons where they are planar and the coordinates know what to do with
# them; what becomes of them is said.
printf 'v %s %s %s\n' 0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1 >box.obj
cat >>box.obj <<END
f 1 3 4 2
f 5 6 8 7
f 1 2 6 5
f 2 4 8 6
f 4 3 7 8
f 3 1 5 7
END
sed '8s/.*/v 1.3 1.2 1.1/' box.obj >bent_box.obj
printf 'v 0.25 0.25 0.25\nv 0.75 0.25 0.5\nv 0.5 0.75 0.5\nf 1 2 3\n' >inner.obj
echo 0.25,0.5,0.75 >inner.csv
for type in mean-value harmonic; do
  works "polygons, $type" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --coordinates $type -o polygons.obj --report
  grep -q 'note: box.obj: 6 faces with more than three corners are kept as polygons' log && ok=yes || ok=no
  report $ok "what becomes of faces of four corners is said, $type"
  works "triangles, $type" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --coordinates $type --faces triangles -o triangles.obj
  grep -q 'note: box.obj: 6 faces are cut into triangles, first in line 9$' log && ok=yes || ok=no
  report $ok "the cut is said, $type"
  cmp -s polygons.obj triangles.obj && ok=no || ok=yes
  report $ok "the choice is heard, $type"
done
works "polygons that coordinates do not take" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --coordinates green -o polygons.obj
grep -q 'note: box.obj: 6 faces are cut into triangles, first in line 9: green supports only triangles' log && ok=yes || ok=no
report $ok "why they are cut is said"
works "an accuracy in space" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --coordinates harmonic --accuracy 0.01 -o accurate.obj --report
grep -q 'note: box.obj: 6 faces with more than three corners are kept as polygons' log && grep -q '^solver: .* unknowns' log && ok=yes || ok=no
report $ok "the adaptive grid is used, with the polygons as they are"
works "a table in space, and of a lattice" "$programs/figure_table" inner.obj box.obj bent_box.obj all inner.obj lattice:2x2x2 lattice:2x2x2 splines
grep -q '^inner  *sibson-c1 ' log && grep -q '^inner  *splines  *3  *8 ' log && ok=yes || ok=no
report $ok "they have rows of control points and of the lattice"
works "local harmonic coordinates in space" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --coordinates harmonic --accuracy 0.01 --locality 20 -o local.obj
cmp -s accurate.obj local.obj && ok=no || ok=yes
report $ok "a locality changes the pose in space"
refuses '--accuracy excludes --resolution' "$mesh" inner.obj --cage box.obj --pose box.obj --coordinates harmonic --accuracy 0.01 --resolution 32 -o out.obj
refuses '--accuracy excludes --tolerance' "$mesh" inner.obj --cage box.obj --pose box.obj --coordinates harmonic --accuracy 0.01 --tolerance 1e-9 -o out.obj
for wrong in -1 nan inf 1e-9 0.5 little; do
  refuses '--accuracy: ' "$mesh" inner.obj --cage box.obj --pose box.obj --coordinates harmonic --accuracy $wrong -o out.obj
done
refuses '--accuracy: ' "$mesh" inner.obj --cage box.obj --pose box.obj --coordinates harmonic --accuracy 0 -o out.obj
works "faces that are not planar" "$mesh" inner.obj --cage bent_box.obj --pose box.obj -o polygons.obj
grep -q 'note: bent_box.obj: 3 faces with more.*; 3 faces are bound as fans about the means of their corners; 3 are not planar, first in line 10$' log && ok=yes || ok=no
report $ok "which of them become fans, and why, is said"
works "faces that are not planar, by green" "$mesh" inner.obj --cage bent_box.obj --pose box.obj --coordinates green -o polygons.obj
grep -q 'note: bent_box.obj: 3 faces are bound as fans .*; 3 faces are cut into triangles, first in line 9: green supports only triangles' log && ok=yes || ok=no
report $ok "only those become fans"
works "faces that are not planar, cut" "$mesh" inner.obj --cage bent_box.obj --pose box.obj --faces triangles -o triangles.obj
grep -q 'note: bent_box.obj: 6 faces are cut into triangles, first in line 9$' log && ok=yes || ok=no
report $ok "all are cut"
for type in mean-value harmonic green; do
  works "fans, $type" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --coordinates $type --faces fan -o fans.obj
  grep -q 'note: box.obj: 6 faces are bound as fans about the means of their corners$' log && ok=yes || ok=no
  report $ok "fans are said, $type"
done
for type in mean-value harmonic; do
  works "fans of divided quads, $type" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --coordinates $type --divisions 3 -o divided.obj
  grep -q 'note: box.obj: 6 faces are bound as fans about the means of their corners; 6 are divided into 3 x 3 cells$' log && ok=yes || ok=no
  report $ok "divisions are said, $type"
  works "fans, $type" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --coordinates $type --faces fan --divisions 1 -o fans.obj
  cmp -s fans.obj divided.obj && ok=no || ok=yes
  report $ok "divisions are heard, $type"
done
works "divisions without fans" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --faces triangles --divisions 3 -o divided.obj
works "the same without divisions" "$mesh" inner.obj --cage box.obj --pose bent_box.obj --faces triangles -o triangles.obj
cmp -s triangles.obj divided.obj && ok=yes || ok=no
report $ok "only fans are divided"
for faces in planar fan; do
  refuses 'box.obj: faces can be divided by 1 to 64, for Green coordinates by 1 only' "$mesh" inner.obj --cage box.obj --pose box.obj --coordinates green --faces $faces --divisions 2 -o out.obj
done
works "one division for green" "$mesh" inner.obj --cage box.obj --pose box.obj --coordinates green --faces fan --divisions 1 -o fans.obj
for wrong in 0 -1 65 1.5 nan many; do
  refuses '--divisions: ' "$mesh" inner.obj --cage box.obj --pose box.obj --divisions $wrong -o out.obj
done
works "weights of divided faces" "$programs/cage_weights" --cage box.obj --points inner.csv --divisions 2 -o divided.csv
grep -q '6 are divided into 2 x 2 cells$' log && ok=yes || ok=no
report $ok "cage_weights divides too"
sed '8s/.*/v 0.2 0.2 1.1/' box.obj >dart.obj # the mean of the lid lies beyond its corner
works "a face whose mean does not see its edges" "$mesh" inner.obj --cage dart.obj --pose box.obj -o out.obj
grep -q '1 face is cut into triangles, first in line 10: the mean of the corners does not see all edges' log && ok=yes || ok=no
report $ok "that it is cut, and why, is said"
works "such a face, with divisions" "$mesh" inner.obj --cage dart.obj --pose box.obj --divisions 2 -o out.obj
grep -q 'the mean of the corners does not see all edges, or a cell of it folds' log && ok=yes || ok=no
report $ok "a cell that folds is named too"
head -n 11 box.obj >open_box.obj
refuses 'the cage is not closed' "$mesh" inner.obj --cage open_box.obj --pose open_box.obj -o out.obj
refuses '--faces: ' "$mesh" inner.obj --cage box.obj --pose box.obj --faces quads -o out.obj
works "weights of a box of polygons" "$programs/cage_weights" --cage box.obj --points inner.csv --coordinates harmonic -o polygons.csv
grep -q 'note: box.obj: 6 faces' log && ok=yes || ok=no
report $ok "cage_weights says what becomes of them too"
echo 0.5,0.5,0.5 >fan_point.csv
works "green weights of fans" "$programs/cage_weights" --cage box.obj --points fan_point.csv --coordinates green --faces fan -o fans.csv
# 8 vertices, then 6 faces of 4 triangles each: in the middle of a cube those of a kind are equal.
awk -F, 'NR == 1 && NF != 33 { exit 1 }
  NR == 2 { for (i = 2; i <= 33; ++i) if (($i - (i < 10 ? 0.125 : $10)) ^ 2 > 1e-28) exit 1 }' fans.csv && ok=yes || ok=no
report $ok "the vertices' come first, then those of the fans' vectors"
works "weights, with no streams to print to" sh -c "'$programs/cage_weights' --cage box.obj --points inner.csv --coordinates harmonic -o closed.csv >&- 2>&-"
cmp -s polygons.csv closed.csv && ok=yes || ok=no
report $ok "what would be printed is not in the file"
# A game loads these files: sizes are told, no file is half-written.
bind="$programs/bind_mesh"
works "a packed character" "$bind" character.obj --cage character_cage.obj --clip folder/character/character_clip.csv \
  --largest 8 --format int16 -o character.figure --report
grep -q '^points: ' log && grep -q '^tangents: ' log && grep -q '^bitangents: ' log && ok=yes || ok=no
report $ok "the report tells the sizes"
grep -q 'warning: character.obj: the packed figure is off by at most .* poses of the motion' log && ok=yes || ok=no
report $ok "more than a hundredth of the size is warned of"
works "a distance that is kept" "$bind" character.obj --cage character_cage.obj --pose character_pose.obj --max-distance 0.002 -o near.figure --report
! grep -q warning log && [ "$(grep -c '^  off by at most .* % of .* 8 poses of the motion' log)" = 3 ] && ok=yes || ok=no
report $ok "the distances are told"
[ "$(wc -c <near.figure)" -lt "$(wc -c <character.figure)" ] && ok=yes || ok=no
report $ok "a distance takes less than eight weights a point"
works "a distance without a motion" "$bind" character.obj --cage character_cage.obj --max-distance 0.05 -o still.figure --report
grep -q '^  off by at most .* a tenth of the cage' log && ok=yes || ok=no
report $ok "what the distance is over is told"
refuses 'weights in this format cannot meet the tolerance' "$bind" character.obj --cage character_cage.obj --pose character_pose.obj --max-distance 0.00001 --format int8 -o out.figure
refuses '--max-distance' "$bind" character.obj --cage character_cage.obj --max-distance 1.5 -o out.figure
refuses '--max-distance' "$bind" character.obj --cage character_cage.obj --max-distance nan -o out.figure
refuses 'nowhere.obj' "$bind" nowhere.obj --cage character_cage.obj -o out.figure
refuses 'nowhere.csv' "$bind" character.obj --cage character_cage.obj --clip nowhere.csv -o out.figure
refuses 'linear precision' "$bind" character.obj --cage character_cage.obj --largest 3 -o out.figure
works "a character of poses" "$bind" character.obj --cage character_cage.obj --pose character_pose.obj character_cage.obj --seconds 0.5 -o posed.figure
works "a character at rest" "$bind" character.obj --cage character_cage.obj -o still.figure
more=$(($(wc -c <posed.figure) - $(wc -c <still.figure) - 112 * 3 * (20 + 4 * 28))) # headers, and what fills them up
[ $more -ge 0 ] && [ $more -lt 512 ] && ok=yes || ok=no
report $ok "three pieces of a curve for every coordinate"
refuses '--pose' "$bind" character.obj --cage character_cage.obj --clip folder/character/character_clip.csv --pose character_pose.obj -o out.figure
refuses 'the pose character.obj has 8066 vertices, the cage character_cage.obj has 112' "$bind" character.obj --cage character_cage.obj --pose character.obj -o out.figure
refuses 'no normals' "$bind" points.obj --cage character_cage.obj -o out.figure
refuses 'points.obj: holds no faces (lines "f a b c"); a cage is a closed mesh' "$bind" character.obj --cage points.obj -o out.figure
works "the first vertices of the character" awk -v n=800 '/^(v|vn|vt) / && ++count[$1] > n { next }
  $1 == "f" { for (k = 2; k <= 4; k++) { split($k, at, "/"); if (at[1] > n || at[2] > n || at[3] > n) next } } { print }' character.obj
mv log part.obj
works "a packed figure by Green coordinates" "$bind" part.obj --cage character_cage.obj --pose character_pose.obj --coordinates green --max-distance 0.005 -o green.figure --report
[ "$(grep -c '^  off by at most .* 8 poses of the motion' log)" = 3 ] && ok=yes || ok=no
report $ok "poses of the faces are among those that the distance is over"
refuses '--max-distance with --coordinates green needs a motion' "$bind" character.obj --cage character_cage.obj --coordinates green --max-distance 0.05 -o out.figure
{ cat inner.obj; printf 'vt 0 0\nusemtl a\n'; } >dressed.obj
works "what a figure has no part for" "$bind" dressed.obj --cage box.obj -o dressed.figure --report
grep -qx 'not stored: 1 of "usemtl", 1 of "vt"' log && ok=yes || ok=no
report $ok "is counted"
works "Green coordinates without a motion" "$bind" inner.obj --cage box.obj --coordinates green -o green.figure --report
grep -q 'of an affine motion, vectors of its faces too$' log && ok=yes || ok=no
report $ok "what is off is over faces as well"
awk '$1 == "v" && ++n == 8 { print "v 0 1 1"; next } { print }' box.obj >flat_box.obj
works "a motion through a cage that folds" "$bind" inner.obj --cage box.obj --pose flat_box.obj bent_box.obj --coordinates green -o green.figure
[ "$(grep -c 'warning: .* no area' log)" = 1 ] && grep -q 'warning: poses after 1 s: 2 faces have no area, first v 6, v 8, v 7: their normals are undefined$' log && ok=yes || ok=no
report $ok "which faces have no area, and when"
works "targets of a cage that folds" "$programs/export_gltf" inner.obj --cage box.obj --pose flat_box.obj bent_box.obj bent_box.obj --morph --coordinates green -o green.glb
[ "$(grep -c 'warning: .* no area' log)" = 1 ] && grep -q 'warning: poses after 1 s: 2 faces have no area' log && ok=yes || ok=no
report $ok "it is said of that pose alone"
awk '$1 == "v" && ++n == 8 { print "v 1e35 1 1"; next } { print }' box.obj >far_box.obj
refuses 'poses after 0.25 s: ' "$bind" inner.obj --cage box.obj --pose far_box.obj --coordinates green -o out.figure
awk '$1 == "v" && ++n == 8 { print "v nan 1 1"; next } { print }' box.obj >nan_box.obj
for kind in deform_mesh:obj bind_mesh:figure export_gltf:glb; do
  out=out.${kind#*:}
  [ $out = out.glb ] && targets=--morph || targets=
  by_green() { "$programs/${kind%:*}" inner.obj --cage "$1" --pose "$2" --coordinates green $targets -o $out; }
  for faulty in 'box.obj nan_box.obj' 'nan_box.obj box.obj'; do
    refuses 'nan_box.obj: the coordinates of a vertex are not finite' by_green $faulty
  done
  refuses 'the pose character_cage.obj has 112 vertices, the cage box.obj has 8' by_green box.obj character_cage.obj
  refuses 'open_box.obj: the cage is not closed' by_green open_box.obj open_box.obj
done
works "a character by accuracy" "$bind" character.obj --cage character_cage.obj --coordinates harmonic --accuracy 0.01 -o accurate.figure
works "a cat by accuracy" "$deform" "$cat" --cage "$cage" --pose "$data/cat_pose_leap.svg" --coordinates harmonic --accuracy 0.002 -o accurate.svg
works "a vertex in its head by accuracy" "$deform" "$cat" --cage "$data/cat_cage_head.csv" --pose "$data/cat_pose_head.csv" --coordinates harmonic --accuracy 0.002 -o accurate.svg
refuses 'normals need mean-value, harmonic or green' "$bind" character.obj --cage character_cage.obj --coordinates barycentric -o out.figure
refuses 'int12' "$bind" character.obj --cage character_cage.obj --format int12 -o out.figure
# Vertices outside are treated as in all programs.
sed '0,/^v /s/^v .*/v 9 9 9/' character.obj >stray_character.obj
for type in mean-value harmonic; do
  [ $type = harmonic ] && follows='the nearest points of the boundary' || follows='the extension of the coordinates'
  works "a vertex outside a game's cage, $type" "$bind" stray_character.obj --cage character_cage.obj --coordinates $type --resolution 16 -o stray.figure
  [ "$(grep -c "warning: 1 of 8066 vertices of stray_character.obj lie outside the cage character_cage.obj, first v 1 (9, 9, 9); they follow $follows" log)" = 1 ] && ok=yes || ok=no
  report $ok "it is told of, $type"
done
grep -q 'the grid is coarse for the edge between vertices .* (counted from 1, as in the file)' log && ok=yes || ok=no
report $ok "edges are named as the file counts"
works "it is kept in place" "$bind" stray_character.obj --cage character_cage.obj --outside keep-in-place -o stray.figure
works "it fades" "$bind" stray_character.obj --cage character_cage.obj --falloff 0.5 -o stray.figure
refuses '--falloff: with --outside keep-in-place' "$bind" stray_character.obj --cage character_cage.obj --outside keep-in-place --falloff 0.5 -o out.figure
! grep -q warning log && ok=yes || ok=no
report $ok "what was asked for is not warned of"
refuses '1 of 8066 vertices of stray_character.obj lie outside the cage' "$bind" stray_character.obj --cage character_cage.obj --outside refuse -o out.figure
refuses 'not defined outside' "$bind" stray_character.obj --cage character_cage.obj --coordinates harmonic --resolution 16 --outside extend -o out.figure
# Labels of the cage's vertices: columns of weights, joints, and a part of the figure's file.
printf '# corners\r\nlow left\r\n\r\nhigh, "right"\r\nhigh left\r\n' >labels.txt
works "labels of columns" "$weights" --cage square.csv --points points.csv --labels labels.txt -o labelled.csv
[ "$(head -1 labelled.csv)" = 'status,low left,w1,"high, ""right""",high left' ] && ok=yes || ok=no
report $ok "columns have the labels, or numbers"
awk 'BEGIN { print "nose"; for (i = 1; i < 112; ++i) print (i % 2 ? "" : "vertex " i) }' >character.txt
works "labels of a figure" "$bind" character.obj --cage character_cage.obj --labels character.txt -o labelled.figure --report
grep -q '^labels: of 56 of 112 vertices of the cage$' log && grep -aq 'nosevertex 2vertex 4vertex 6' labelled.figure && ok=yes || ok=no
report $ok "labels are kept"
works "labels of joints" "$programs/export_gltf" character.obj --cage character_cage.obj --skin 4 --labels character.txt -o labelled.gltf
[ "$(grep -c '"name": "nose"\|"name": "vertex [0-9]*"' labelled.gltf)" = 56 ] && [ "$(grep -c '"name": "handle [0-9]*"' labelled.gltf)" = 56 ] && ok=yes || ok=no
report $ok "joints have the labels, or numbers"
works "labels of vertices, by Green coordinates" "$weights" --cage square.csv --points points.csv --labels labels.txt --coordinates green -o labelled.csv
[ "$(head -1 labelled.csv)" = 'status,low left,w1,"high, ""right""",high left,w4,w5,w6,w7' ] && ok=yes || ok=no
report $ok "edges have numbers"
refuses 'cross' "$weights" --cage bow_tie.svg --points points.csv --labels labels.txt --coordinates green -o out.csv
refuses_labels() { # MESSAGE [MESSAGE]   of labels.txt, for the square, and for the character
  refuses "labels.txt$1" "$weights" --cage square.csv --points points.csv --labels labels.txt -o out.csv
  [ $# -gt 1 ] || return 0
  refuses "labels.txt$2" "$bind" character.obj --cage character_cage.obj --labels labels.txt -o out.figure
  refuses "labels.txt$2" "$programs/export_gltf" character.obj --cage character_cage.obj --skin 4 --labels labels.txt -o out.glb
}
printf 'a\nb\nc\n' >labels.txt
refuses_labels ': has 3 lines of labels, the cage 4 vertices' ': has 3 lines of labels, the cage 112 vertices'
printf 'a\nb\nc\n\n\n' >labels.txt
refuses_labels ': has 5 lines of labels, the cage 4 vertices' ': has 5 lines of labels, the cage 112 vertices'
printf 'a\nb\n# c\n a\nd\n' >labels.txt
refuses_labels ':4: the label "a" occurs in line 1 already' ':4: the label "a" occurs in line 1 already'
printf 'a\nb\001\nc\nd\n' >labels.txt
refuses_labels ':2: the label "b?" holds a control character' ':2: the label "b?" holds a control character'
printf '# none\n\n\n\n\n' >labels.txt
refuses_labels ': holds no labels' ': holds no labels'
: >labels.txt
refuses_labels ': holds no labels' ': holds no labels'
rm labels.txt
refuses_labels ': no such file' ': no such file'
printf 'w1\n\n\n\n' >labels.txt
refuses_labels ': two columns would have the name "w1"'
awk '$1 == "v" { print "v", 2 - $3, $2, $4 - 1; next } { print }' box.obj >turned_box.obj # by a right angle
works "targets by Green coordinates" "$programs/export_gltf" inner.obj --cage box.obj --pose turned_box.obj --morph --coordinates green -o green.glb
grep -q 'warning: inner.obj: between the keys the targets are off by ' log && ok=yes || ok=no
report $ok "what targets lose between the keys is said"
refuses '--skin cannot represent normals of faces; use --morph' "$programs/export_gltf" character.obj --cage character_cage.obj --skin 4 --coordinates green -o out.glb
refuses '--labels' "$programs/export_gltf" character.obj --cage character_cage.obj --pose character_pose.obj --morph --labels character.txt -o out.glb
# A figure file and glTF hold single precision.
huge() { # LINE FILE   the line's first 0.xxx, or the number at its beginning, is 1e39 in huge.*
  sed "$1s/-\\{0,1\\}[0-9.]*[0-9]/-1e39/" "$2" >"huge.${2##*.}"
}
says_huge='-1e+39 is beyond single precision'
clip=folder/character/character_clip.csv
line_of=$(grep -n '^v ' character.obj | sed -n 5p | cut -d: -f1)
huge "$line_of" character.obj
refuses "huge.obj: v 5: $says_huge, which ends at 3.4e38 (line $line_of)" "$bind" huge.obj --cage character_cage.obj -o out.figure
refuses "huge.obj: v 5: $says_huge, which ends at 3.4e38 (line $line_of)" "$programs/export_gltf" huge.obj --cage character_cage.obj --skin 4 -o out.glb
huge 10 "$clip"
refuses "huge.csv:10: column 1: $says_huge" "$bind" character.obj --cage character_cage.obj --clip huge.csv -o out.figure
refuses "huge.csv:10: column 1: $says_huge" "$programs/export_gltf" character.obj --cage character_cage.obj --skin 4 --clip huge.csv -o out.glb
sed 's/^length,.*/length,1e39/' "$clip" >huge.csv
refuses 'huge.csv:2: 1e+39 is beyond single precision' "$bind" character.obj --cage character_cage.obj --clip huge.csv -o out.figure
awk 'BEGIN { print "length,1e-25"; for (k = 0; k < 2; ++k) { print "pose," k * 5e-26; for (i = 0; i < 112; ++i) print k * 1e10 ",1,1" } }' >fast.csv
refuses 'fast.csv: v 1 moves too fast after' "$bind" character.obj --cage character_cage.obj --clip fast.csv -o out.figure
cmp -s posed_mean-value.obj posed_harmonic.obj && ok=no || ok=yes
report $ok "the coordinates differ"
printf '%s\n' 'v 0 0 0' 'v 4 0 0' 'v 4 4 0' 'v 0 4 0' 'v 0 0 4' 'v 4 0 4' 'v 4 4 4' 'v 0 4 4' \
  'f 4 3 2 1' 'f 5 6 7 8' 'f 1 2 6 5' 'f 2 3 7 6' 'f 3 4 8 7' 'f 4 1 5 8' >box.obj
sed 's/^v 4 4 4/v 6 5 5/' box.obj >box_pose.obj
sed 's/^f 5 6 7 8/f 6 7 8 5/' box.obj >box_turned.obj
grep -v '^f 4 1' box.obj >box_open.obj
sed 's/^f 5 6 7 8/f 5 6 8 7/' box.obj >box_bow_tie.obj
sed 's/^f 4 1 5 8/f 4 1 5 9/' box.obj >box_ninth.obj
sed 's/^v 4 4 4/v 4 nan 4/' box.obj >box_nan.obj
printf '# a point\r\nv 2 2 2 0.5 0.25 1\r\nv 3\t3 \\\r\n3\r\np 1 2\r\n' >figure.obj
works "a cage of squares" "$mesh" figure.obj --cage box.obj --pose box.obj -o rest.obj
cmp -s figure.obj rest.obj && ok=yes || ok=no
report $ok "line ends, colours and joined lines stay"
works "a corner pulled" "$mesh" figure.obj --cage box.obj --pose box_pose.obj -o pulled.obj
grep -q '^v [23].* 0.5 0.25 1' pulled.obj && grep -q '^p 1 2' pulled.obj && ok=yes || ok=no
report $ok "colours and other lines stay when vertices move"
printf 'v 2 2 2\nv 5 2 2\n' >stray.obj
printf 'v 1 2\n' >short.obj
printf '\001\377\000v\n\200f 1 2' >junk.obj
: >empty.obj
refuses 'nowhere.obj' "$mesh" nowhere.obj --cage box.obj --pose box.obj -o out.obj
refuses 'nowhere.obj' "$mesh" figure.obj --cage nowhere.obj --pose box.obj -o out.obj
refuses 'nowhere.obj' "$mesh" figure.obj --cage box.obj --pose nowhere.obj -o out.obj
refuses 'folder: is a folder' "$mesh" folder --cage box.obj --pose box.obj -o out.obj
refuses 'empty.obj: is empty' "$mesh" empty.obj --cage box.obj --pose box.obj -o out.obj
refuses 'junk.obj: holds no vertices' "$mesh" figure.obj --cage junk.obj --pose box.obj -o out.obj
refuses 'short.obj: three numbers are expected (line 1)' "$mesh" short.obj --cage box.obj --pose box.obj -o out.obj
refuses 'box_nan.obj: the coordinates of a vertex are not finite (line 7)' "$mesh" figure.obj --cage box.obj --pose box_nan.obj -o out.obj
refuses 'box_ninth.obj: vertex index 9 is out of range: the file has 8 (line 14)' "$mesh" figure.obj --cage box_ninth.obj --pose box.obj -o out.obj
refuses 'the pose character_cage.obj has 112 vertices, the cage box.obj has 8' "$mesh" figure.obj --cage box.obj --pose character_cage.obj -o out.obj
refuses 'face 2 differs: line 10 of the pose box_turned.obj, line 10 of the cage box.obj' "$mesh" figure.obj --cage box.obj --pose box_turned.obj -o out.obj
refuses 'face 6 differs: the pose box_open.obj has 5 faces, the cage box.obj has 6' "$mesh" figure.obj --cage box.obj --pose box_open.obj -o out.obj
grep -v '^f 4 1\|^f 1 2' box.obj >box_wide_open.obj
works "a cage with a gap" "$mesh" figure.obj --cage box_open.obj --pose box_open.obj -o closed.obj
grep -qF 'deform_mesh: warning: box_open.obj: 4 open edges were closed, first between vertices 1 and 4 (counted from 1, as in the file)' log && ok=yes || ok=no
report $ok "the gap is reported"
refuses 'open edge (0, 1)' "$mesh" figure.obj --cage box_wide_open.obj --pose box_wide_open.obj -o out.obj
refuses 'box_bow_tie.obj: a face cannot be cut into triangles' "$mesh" figure.obj --cage box_bow_tie.obj --pose box_bow_tie.obj -o out.obj
printf 'v 1 1 1\nv 4.000000000004 2 2\nv nan 1 1\n' >rounded.obj
sed 's/^v 4 /v 5 /' box.obj >wider.obj
for coordinates in mean-value harmonic; do
  for outside in auto refuse; do
    works "a rounding outside, $coordinates" "$mesh" rounded.obj --cage box.obj --pose wider.obj --coordinates $coordinates --outside $outside -o rounded_moved.obj
    awk '$1 == "v" && ++n == 2 { x = $2 } END { exit !(x > 4.99999 && x < 5.00001) }' rounded_moved.obj && ! grep -q outside log && ok=yes || ok=no
    report $ok "moves with the face, $coordinates, $outside"
  done
done
grep -q 'warning: rounded.obj: 1 of 3 vertices are left out, first v 3: no face uses them, and they are not finite or very far away; with --strict' log &&
  tail -n 1 rounded_moved.obj | grep -qx 'v nan 1 1' && ok=yes || ok=no
report $ok "a vertex that is no number stays unchanged"
refuses 'rounded.obj: the coordinates of a vertex are not finite (line 3)' "$mesh" rounded.obj --cage box.obj --pose wider.obj --strict -o out.obj
refuses '--memory: Value 0 not in range' "$mesh" rounded.obj --cage box.obj --pose wider.obj --coordinates harmonic --memory 0 -o out.obj
awk '$1 == "v" { $2 *= 200; $3 *= 200; $4 *= 0.1 } { print }' box.obj >film.obj
refuses 'the grid takes ' "$mesh" film.obj --cage film.obj --pose film.obj --coordinates harmonic -o out.obj
grep -q 'more than is allowed (--memory, .*; --coordinates mean-value and green need no grid' log && grep -q 'note: the grid of harmonic coordinates takes about .* GiB for .* nodes, as the cage is 0.* thick in the mean' log && ok=yes || ok=no
report $ok "and says why, and which coordinates need none"
refuses '1 of 2 vertices of stray.obj lie outside the cage box.obj, first v 2 (5, 2, 2)' "$mesh" stray.obj --cage box.obj --pose box_pose.obj --outside refuse -o out.obj
grep -q '; the largest distance from the boundary is [0-9.]*, and the tolerance [0-9.e-]*$' log && ok=yes || ok=no
report $ok "the distance outside, and the tolerance"
for type in mean-value harmonic; do
  works "a vertex outside, $type" "$mesh" stray.obj --cage box.obj --pose box_pose.obj --coordinates $type -o auto_$type.obj
  grep -q 'warning: 1 of 2 vertices of stray.obj lie outside the cage box.obj, first v 2 (5, 2, 2); they follow' log && ok=yes || ok=no
  report $ok "a warning of the vertex outside, $type"
done
works "a vertex extended" "$mesh" stray.obj --cage box.obj --pose box_pose.obj --outside extend -o extended.obj
works "a vertex on the boundary" "$mesh" stray.obj --cage box.obj --pose box_pose.obj --coordinates harmonic --outside nearest-boundary -o nearest.obj
cmp -s auto_mean-value.obj extended.obj && cmp -s auto_harmonic.obj nearest.obj && ok=yes || ok=no
report $ok "auto extends where it can, else takes the nearest boundary"
refuses 'not defined outside' "$mesh" stray.obj --cage box.obj --pose box_pose.obj --coordinates harmonic --outside extend -o out.obj
works "a vertex beyond the falloff" "$mesh" stray.obj --cage box.obj --pose box_pose.obj --falloff 0.5 -o faded.obj
[ "$(grep '^v' faded.obj | tail -1)" = "$(grep '^v' stray.obj | tail -1)" ] && ok=yes || ok=no
report $ok "it stays in place"
works "a vertex within the falloff" "$mesh" stray.obj --cage box.obj --pose box_pose.obj --falloff 1e9 -o faded.obj
cmp -s faded.obj extended.obj && ok=yes || ok=no
report $ok "a falloff without end is as none"
refuses '--falloff: with --outside keep-in-place' "$mesh" stray.obj --cage box.obj --pose box_pose.obj --falloff 1 --outside keep-in-place -o out.obj
refuses '--falloff' "$mesh" stray.obj --cage box.obj --pose box_pose.obj --falloff -1 -o out.obj
for policy in keep nearest extend; do
  works "vertices outside: $policy" "$mesh" stray.obj --cage box.obj --pose box_pose.obj --outside $policy -o kept.obj
done
refuses 'not a simplex (8, 4)' "$mesh" figure.obj --cage box.obj --pose box.obj --coordinates barycentric -o out.obj
refuses 'resolution' "$mesh" figure.obj --cage box.obj --pose box.obj --coordinates harmonic --resolution 3 -o out.obj
refuses 'tolerance' "$mesh" figure.obj --cage box.obj --pose box.obj --coordinates harmonic --tolerance 0 -o out.obj
refuses '--pose' "$mesh" figure.obj --cage box.obj -o out.obj
refuses 'missing/out.obj' "$mesh" figure.obj --cage box.obj --pose box.obj -o missing/out.obj
refuses 'missing/out.png' "$mesh" figure.obj --cage box.obj --pose box.obj -o out.obj --picture missing/out.png

printf '2,2,2\n4,2,1\n1,1,3\n' >points.csv
for scalar in float double; do
  for type in mean-value harmonic; do
    works "weights of a box, $scalar $type" "$weights" --cage box.obj --points points.csv --coordinates $type --scalar $scalar --resolution 16 --report -o w_$type.csv
    [ "$(head -1 w_$type.csv)" = status,w0,w1,w2,w3,w4,w5,w6,w7 ] && ok=yes || ok=no
    report $ok "a box has eight handles"
    sed -n 2p w_$type.csv | awk -F, '{ for (k = 2; k <= 9; k++) x += $k * ((k - 2) % 4 == 1 || (k - 2) % 4 == 2) * 4 } END { exit (x - 2) ^ 2 > 1e-8 }' && ok=yes || ok=no
    report $ok "the weights give the point back"
  done
done
printf '%s\n' 'v 0 0 0' 'v 4 0 0' 'v 0 4 0' 'v 0 0 4' 'f 1 3 2' 'f 1 2 4' 'f 2 3 4' 'f 3 1 4' >tetrahedron.obj
printf 'x,y,z\n1,0.5,2\n' >point.csv
works "weights of a tetrahedron" "$weights" --cage tetrahedron.obj --points point.csv --coordinates barycentric -o w.csv
sed -n 2p w.csv | awk -F, '{ split("0.125 0.25 0.125 0.5", w, " "); for (k = 1; k <= 4; k++) if (($(k + 1) - w[k]) ^ 2 > 1e-30) bad = 1 }
  END { exit bad || NR != 1 || NF != 5 || $1 != "inside" }' && ok=yes || ok=no # to rounding: a solve by orthonormal rows
report $ok "barycentric coordinates of a tetrahedron"
refuses 'not a simplex (8, 4)' "$weights" --cage box.obj --points points.csv --coordinates barycentric -o out.csv
refuses 'middle.csv:1: 2 columns, but a point in space has three: x,y,z' "$weights" --cage box.obj --points middle.csv -o out.csv
refuses 'points.csv:1: 3 columns, but a point in the plane has two: x,y' "$weights" --cage square.csv --points points.csv -o out.csv
refuses 'nowhere.obj' "$weights" --cage nowhere.obj --points points.csv -o out.csv
refuses 'box_bow_tie.obj: a face cannot be cut into triangles' "$weights" --cage box_bow_tie.obj --points points.csv -o out.csv
refuses 'counted from 0' "$weights" --cage box_wide_open.obj --points points.csv -o out.csv
works "weights of a box with a gap" "$weights" --cage box_open.obj --points points.csv -o w.csv
grep -qF 'cage_weights: warning: box_open.obj: 4 open edges were closed, first between vertices 1 and 4 (counted from 1, as in the file)' log && ok=yes || ok=no
report $ok "the gap is reported"

# ---- splats ----
splats="$programs/deform_splats"
works "splats on the character" "$programs/make_splats" character.obj -o scene.ply --count 3000
grep -qx 'scene.ply: 3000 splats of degree 3' log && grep -q 'note: character.obj: not used: 8066 of "vn"' log && ok=yes || ok=no
report $ok "make_splats tells what it made, and what it did not use"
for degree in 0 1 2; do works "splats of degree $degree" "$programs/make_splats" character.obj -o "degree_$degree.ply" --count 100 --degree $degree; done
for scene in scene degree_0 degree_1 degree_2; do
  works "splats at rest, $scene" "$splats" $scene.ply --cage character_cage.obj --pose character_cage.obj -o rest.ply
  cmp $scene.ply rest.ply && ok=yes || ok=no
  report $ok "splats at rest have the same bytes, $scene"
done
printf 'ply\nformat ascii 1.0\nelement camera 2\nproperty float view\nelement vertex 1\n' >named.ply
for name in x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 label; do echo "property float $name"; done >>named.ply
printf 'end_header\n7\n8\n0 1 0 1 1 1 0 -4 -4 -4 1 0 0 0 6\n' >>named.ply
works "splats with more properties" "$splats" named.ply --cage character_cage.obj --pose character_cage.obj -o out.ply --report
grep -qx 'unchanged: "label", 2 of "camera"' log && ok=yes || ok=no
report $ok "what no pose moves is named"
for type in mean-value green; do
  works "splats posed, $type" "$splats" scene.ply --cage character_cage.obj --pose character_pose.obj --coordinates $type -o posed.ply --report
  grep -q '^splats: 3000 of degree 3, 248 bytes each$' log && grep -q '^seconds: read .* bind .* frame .* write ' log && ok=yes || ok=no
  report $ok "deform_splats reports, $type"
done
works "one thread" "$splats" scene.ply --cage lattice:3x5x3 --bend all:yx,0.9,0,90 --split 1.2 --threads 1 -o one.ply
works "threads" "$splats" scene.ply --cage lattice:3x5x3 --bend all:yx,0.9,0,90 --split 1.2 --threads 3 -o three.ply --report
cmp one.ply three.ply && grep -q '^split: [1-9]' log && ok=yes || ok=no
report $ok "the result does not depend on threads"
works "a first look" "$splats" scene.ply --cage box -o look.ply
works "a lattice" "$splats" scene.ply --cage lattice:4x4x4 --turn all:90,y@0,0,0 -o quarter.ply
works "splats drawn" "$programs/draw_splats" scene.ply -o drawn.png --view 20,10 --width 160 --height 120
works "splats drawn beside a mesh" "$programs/draw_splats" quarter.ply --beside character.obj -o drawn.png --width 160 --height 120
works "pins" "$splats" scene.ply --cage box --pin 0 --pin 2000:+0,0.1,0 -o pinned.ply --save-pose pinned.obj
works "the pose of pins" "$splats" scene.ply --cage box --pose pinned.obj -o pinned.ply
head -c 5000 scene.ply >short.ply
sed 's/float opacity/float opaque/' scene.ply >opaque.ply
{ head -c "$(($(wc -c <degree_0.ply) - 4))" degree_0.ply; printf '\000\000\300\177'; } >nan.ply
for program in "$splats" "$programs/draw_splats"; do
  case $program in *draw*) set -- -o out.png ;; *) set -- --cage box --move all:1,0,0 -o out.ply ;; esac
  refuses 'none.ply: no such file' "$program" none.ply "$@"
  refuses 'folder: is a folder' "$program" folder "$@"
  refuses 'short.ply: is cut off: the header declares 3000 splats of 248 bytes' "$program" short.ply "$@"
  refuses 'opaque.ply: a splat has no property opacity' "$program" opaque.ply "$@"
  refuses 'nan.ply: splat 99 (counted from 0): rot_3 is not a finite number' "$program" nan.ply --strict "$@"
  works "a splat that is not finite, $program" "$program" nan.ply "$@"
  grep -q 'warning: nan.ply: 1 of 100 splats are left out, first splat 99 (counted from 0): rot_3 is not a finite number' log && ok=yes || ok=no
  report $ok "is left out, $program"
  refuses 'character.obj: is no PLY file' "$program" character.obj "$@"
done
refuses 'give --pose or operations such as --turn, but not both' "$splats" scene.ply --cage character_cage.obj --pose character_pose.obj --turn all:1,y -o out.ply
refuses '--pose is required' "$splats" scene.ply --cage character_cage.obj -o out.ply
refuses '"1" is neither 0 nor a number from 1.01 to 1e9' "$splats" scene.ply --cage box --split 1 -o out.ply
printf 'v 9 9 9\nv 10 9 9\nv 9 10 9\nv 9 9 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n' >far.obj
refuses '3000 of 3000 splats of scene.ply lie outside' "$splats" scene.ply --cage far.obj --pose far.obj -o out.ply
refuses 'missing/out.ply' "$splats" scene.ply --cage box --move all:1,0,0 -o missing/out.ply
refuses 'scene.ply: splat 0 (counted from 0) leaves the range of single precision in the pose' "$splats" scene.ply --cage box --scale all:1e60 -o out.ply
refuses 'out.obj' "$splats" scene.ply --cage box --move all:1,0,0 -o out.obj
printf 'v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n' >thin.obj
refuses 'thin.obj: its faces have no area' "$programs/make_splats" thin.obj -o out.ply
refuses '--count' "$programs/make_splats" character.obj -o out.ply --count 0
refuses '--degree' "$programs/make_splats" character.obj -o out.ply --degree 4

# ---- pose_cage ----
pose_cage="$programs/pose_cage"
works "numbers of a cage" "$pose_cage" "$cage" --picture numbers.svg --png --figure "$cat"
[ "$(grep -o '<text' numbers.svg | wc -l)" = 25 ] && [ "$(head -c 4 numbers.png | tail -c 3)" = PNG ] && ok=yes || ok=no
report $ok "every vertex has its number"
works "no operation" "$pose_cage" "$cage" -o same.svg
works "is the rest pose" "$deform" "$cat" --cage "$cage" --pose same.svg -o rest_same.svg
works "as the cage is" "$deform" "$cat" --cage "$cage" --pose "$cage" -o rest.svg
cmp -s rest.svg rest_same.svg && ok=yes || ok=no
report $ok "bit by bit"
works "a pose" "$pose_cage" "$cage" --turn '7-11:-25@775,400' --move 'y<200&x<400:0,-10' -o step.svg --picture step_picture.svg
grep -q ': 11 of 25 vertices moved; at rest x from 50 to 950, y from 50 to 750$' log && ok=yes || ok=no
report $ok "what moved is counted"
works "moves the cat" "$deform" "$cat" --cage "$cage" --pose step.svg -o posed.svg
works "as CSV" "$pose_cage" "$cage" --turn '7-11:-25@775,400' --move 'y<200&x<400:0,-10' -o STEP.CSV
mv STEP.CSV step.csv
works "moves it as well" "$deform" "$cat" --cage "$cage" --pose step.csv -o posed_by_csv.svg
cmp -s posed.svg posed_by_csv.svg && ok=yes || ok=no
report $ok "as the SVG does"
printf '%s\n' 0,0 4,0 4,4 0,4 '' '# chain' 1,1 2,2 '' '# point 0.5' 3,1 '' 1,2 1,3 2,3 >blocks.csv
works "blocks, in the order of the words" "$pose_cage" blocks.csv --turn 7:90@0,0 --move 7:1,0 --move 4:0,0.5 --scale 4-6:2@1,3 \
  -o blocks_pose.csv --picture blocks.svg
printf '%s\n' 0,0 4,0 4,4 0,4 '' '# chain' 0,1 2,2 '' '# point 0.5' 3,1 '' 1,2 1,3 3,3 | cmp -s blocks_pose.csv && ok=yes || ok=no
report $ok "handles are the loops' vertices, then what chains and points add"
works "help of the poses" "$pose_cage" --help
works "a bend and a twist in space" "$pose_cage" character_cage.obj --bend 'x>0.27:xy,0.6,1,-60@0,1.3,0' --twist 'y>1:y,1.2,1.5,40@0,0,0' \
  --turn 0-3:10,y --scale 0:1,1,1 -o bent.obj --picture bent.png
works "move the character" "$mesh" character.obj --cage character_cage.obj --pose bent.obj -o posed.obj
refuses_pose() { # MESSAGE WORDS…
  message=$1; shift
  refuses "$message" "$pose_cage" "$cage" "$@" -o out.svg --picture out.numbers.svg
}
refuses_pose '--move "3,10,0": "3,10,0" has no colon' --move 3,10,0
refuses_pose '--turn "5-25:30": there is no vertex 25: the cage has 25, 0 to 24' --move 1:1,1 --turn 5-25:30
refuses_pose '--turn "9-5:30": "9-5" counts backwards' --turn 9-5:30
refuses_pose '"x>2000" holds for no vertex of the cage' --turn 'x>2000:30'
refuses_pose '"left" selects nothing' --scale left:2
refuses_pose '"z>0" selects nothing: write a number, 5-9, all, or a condition such as x>10; the plane has x and y' --scale 'z>0:2'
refuses_pose 'not a number: "far"' --move 1:far,0
refuses_pose '"nan" is not a finite number' --scale 1:nan
refuses_pose '"1,2,3" is not x,y' --move 1:1,2,3
refuses_pose '"5" is not a point: write x,y, or v and vertices' --turn 1:5@5
refuses_pose '--twist "all:y,0,1,30": "y,0,1,30" is for cages in space' --twist all:y,0,1,30
refuses_pose '"xz,0,1,30" must begin with xy or yx' --bend all:xz,0,1,30
refuses_pose 'vertex 0 exceeds the range of numbers' --scale all:1e300@1e300,0 --scale all:1e300
refuses_pose 'were not expected' --grow all:2
refuses 'nothing to write: give -o, --picture or both' "$pose_cage" "$cage" --move 0:1,1
refuses 'cage is required' "$pose_cage" -o out.svg
refuses 'nowhere.svg' "$pose_cage" nowhere.svg -o out.svg
refuses '--png and --figure are for --picture' "$pose_cage" "$cage" -o out.svg --png
refuses 'nowhere.svg' "$pose_cage" "$cage" --picture out.svg --figure nowhere.svg
refuses 'the cage lies in the plane: write .svg or .csv' "$pose_cage" "$cage" -o out.obj
refuses 'the cage lies in space: write .obj' "$pose_cage" character_cage.obj -o out.csv
refuses '--picture takes a .png file' "$pose_cage" character_cage.obj -o out.obj --picture out.svg
refuses 'in the plane the picture is an .svg file' "$pose_cage" "$cage" -o out.svg --picture out.png
refuses 'blocks.csv has chains or points, which need a .csv file' "$pose_cage" blocks.csv -o out.svg
refuses 'is not an angle and an axis' "$pose_cage" character_cage.obj --turn 3:30 -o out.obj
refuses 'two vertices lie at the same position, (4, 4)' "$pose_cage" square.csv --scale all:0@4,4 -o out.svg
printf '%s\n' 1,1 1,1 1,1 >dot.csv
refuses 'cannot be drawn: its size is not finite, or zero' "$pose_cage" dot.csv --picture out.svg
cp square.csv kept.csv
ln -sf kept.csv linked.csv
refuses 'cannot write linked.csv: it is the same file as kept.csv, which is read' "$pose_cage" kept.csv --move 0:1,1 -o linked.csv
cmp -s square.csv kept.csv && ok=yes || ok=no
report $ok "the cage stays"

# ---- make_cage: hostile figures ----
make_cage="$programs/make_cage"
hostile() { # NAME CONTENT
  printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">%s</svg>' "$2" >"$1.svg"
}
no_cage() { # MESSAGE CONTENT   of an SVG file
  hostile hostile "$2"
  refuses "make_cage: hostile.svg$1" timeout 20 "$make_cage" hostile.svg -o out.svg --picture out.numbers.svg
  refuses "deform_svg: hostile.svg$1" timeout 20 "$deform" hostile.svg --cage auto -o out.svg
  refuses "animate_svg: hostile.svg$1" timeout 20 "$animate" hostile.svg --cage auto -o out.svg
  refuses "coordinate_field: hostile.svg$1" timeout 20 "$field" --cage auto --figure hostile.svg --vertex 0 -o out.png
}
caged() { # WHAT CONTENT   and what moves nothing moves no point: all of it lies in the cage
  hostile hostile "$2"
  works "a cage about $1" timeout 20 "$make_cage" hostile.svg -o hostile_cage.svg
  works "which takes $1" timeout 60 "$deform" hostile.svg --cage hostile_cage.svg --pose hostile_cage.svg --coordinates harmonic --outside refuse -o posed.svg
}
unread=' paints nothing that a cage could enclose; hostile.svg'
no_cage ' paints nothing that a cage could enclose' ''
no_cage ' paints nothing that a cage could enclose' '<path d="M 5,5"/>'
no_cage ' paints nothing that a cage could enclose' '<g display="none"><rect width="5" height="5"/></g><rect width="5" height="5" visibility="hidden"/><rect width="5" height="5" opacity="0"/><rect width="9" height="9" fill="none"/>'
no_cage ' paints nothing that a cage could enclose' '<defs><rect width="50" height="50"/></defs>'
no_cage ' paints nothing that a cage could enclose' '<rect transform="scale(0)" width="5" height="5"/>'
no_cage "$unread: path: d at 1:9: expected a number" '<path d="M 5,5 L NaN,50 z"/>'
no_cage "$unread: path: d at 1:9: number out of range" '<path d="M 5,5 L 1e999,50 z"/>'
no_cage " paints nothing that a cage could enclose; path (line 1): has coordinates out of range" '<path d="M 5,5 L 1e300,50 L 3,1e300 z"/>'
no_cage ': a coordinate of the figure is not a finite number, or too large' '<path stroke="red" stroke-width="1e308" d="M 5,5 L 50,50"/>'
no_cage ' paints nothing that a cage could enclose; path (line 1): has coordinates out of range' '<path d="M 1e15,1e15 h 1 v 1 h -1 z"/>'
no_cage ': the figure has no extent, or no area' '<path d="M 0,0 L 1e-300,0 L 0,1e-300 z"/>'
no_cage ' paints nothing that a cage could enclose; circle (line 1): the property "r" is not deformed: abs(7px)' '<circle style="r:abs(7px)"/>'
no_cage ' paints nothing that a cage could enclose; use "u" (line 1): uses itself' '<use id="u" href="#u"/>'
: >hostile.svg
refuses 'hostile.svg: the file is empty' "$make_cage" hostile.svg -o out.svg
printf 'PK\003\004 no svg' >hostile.svg
refuses 'hostile.svg: not XML' "$make_cage" hostile.svg -o out.svg
refuses 'hostile.svg: not XML' "$deform" hostile.svg --cage auto -o out.svg
echo '<html></html>' >hostile.svg
refuses 'hostile.svg: not SVG: the root element is <html>' "$make_cage" hostile.svg -o out.svg
refuses 'nowhere.svg: no such file' "$make_cage" nowhere.svg -o out.svg
refuses 'nowhere.svg: no such file' "$deform" nowhere.svg --cage auto -o out.svg
refuses 'nowhere.svg: no such file' "$animate" nowhere.svg --cage auto -o out.svg
refuses 'nowhere.svg: no such file' "$field" --cage auto --figure nowhere.svg --vertex 0 -o out.png
refuses 'nowhere.obj: no such file' "$mesh" nowhere.obj --cage auto -o out.obj
printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="nan 0 5 5"><rect width="5" height="5"/></svg>' >hostile.svg
works "a figure with a faulty viewBox" "$make_cage" hostile.svg -o out.svg
refuses 'hostile.svg: svg: viewBox is not four numbers' "$deform" hostile.svg --cage hostile.svg --pose hostile.svg -o out.svg
caged "a line" '<path stroke="red" fill="none" d="M 5,5 L 50,50"/>'
caged "a stroke of no length" '<path stroke="red" stroke-width="4" d="M 5,5 L 5,5"/>'
caged "a gigantic stroke" '<path stroke="red" stroke-width="1e6" d="M 5,5 L 50,50"/>'
caged "a needle's mitre" '<path stroke="red" fill="none" stroke-miterlimit="1e9" d="M 0,0 L 50,0.001 L 0,0.002"/>'
caged "figures of two sizes" '<path d="M 0,0 h 1 v 1 h -1 z M 1e9,1e9 h 1e-3 v 1e-3 h -1e-3 z"/>'
caged "a figure far away" '<path d="M 1e9,1e9 h 1 v 1 h -1 z"/>'
caged "what a clip path cuts off" '<clipPath id="c"><rect width="5" height="5"/></clipPath><rect clip-path="url(#c)" width="50" height="50"/>'
caged "a letter" '<text x="5" y="50">a</text>'
thousand=$(awk 'BEGIN { for (n = 0; n < 1000; n++) printf "<circle cx=\"%d\" cy=\"%d\" r=\"0.5\"/>", 300 * (n % 32), 300 * int(n / 32) }')
caged "a thousand parts" "<g transform=\"scale(0.0105)\">$thousand</g>" # on the page: what lies beside it does not count
works "two thousand vertices" timeout 60 "$make_cage" hostile.svg --vertices 2000 -o hostile_cage.svg
hostile parts '<rect width="16" height="16"/><rect x="40" y="12" width="4" height="4"/><rect x="60" y="12" width="4" height="4"/><path fill-rule="evenodd" d="M0,40h60v50h-60z M15,55h30v20h-30z"/>'
works "a loop for each part, and a hole" "$make_cage" parts.svg --parts --holes --vertices 40 --margin 1% -o parts.csv
grep -q ' 40 vertices, ' log && [ "$(grep -c . parts.csv) $(grep -c '^$' parts.csv)" = '40 4' ] && ok=yes || ok=no
report $ok "four parts and the hole share the vertices"
for viewbox in '0 0 0 0' '0 0 -5 5'; do # which draw nothing, or are none
  printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="%s"><rect width="5" height="5"/></svg>' "$viewbox" >hostile.svg
  works "a viewBox without size" "$make_cage" hostile.svg -o hostile_cage.svg --picture numbers.svg
done
works "a first look" "$deform" "$cat" --cage auto -o first.svg
[ ! -s log ] && ok=yes || ok=no
report $ok "it is not cut off, and all lies in the cage"
works "a cage of its own and operations" "$deform" "$cat" --cage auto:16 --turn 'y<200:10' --coordinates harmonic --outside refuse -o first.svg
refuses 'auto:2: no such file; to make a cage, write auto, hull or box, for 3 to 1000000 vertices auto:N or hull:N, or for the fewest within 15 % of the tightest auto:15%' "$deform" "$cat" --cage auto:2 -o out.svg
refuses 'auto:x: no such file' "$animate" "$cat" --cage auto:x -o out.svg
refuses '--turn "16:5": there is no vertex 16: the cage has 16' "$deform" "$cat" --cage auto:16 --turn 16:5 -o out.svg
refuses 'cat.svg: the pose holds a number that is not finite' "$deform" "$cat" --cage auto --move 1:1e300,0 -o out.svg
refuses 'empty.svg: the file is empty' "$deform" empty.svg --cage auto -o out.svg
no_mesh_cage() { # MESSAGE LINES…   of an OBJ file
  why=$1; shift
  printf '%s\n' "$@" >hostile.obj
  refuses "make_cage: hostile.obj: $why" timeout 20 "$make_cage" hostile.obj -o out.obj --picture out.png
  refuses "deform_mesh: hostile.obj: $why" timeout 20 "$mesh" hostile.obj --cage auto -o out.obj --picture out.png
}
mesh_caged() { # WHAT   of hostile.obj
  works "a cage in space about $1" timeout 60 "$make_cage" hostile.obj --vertices 40 --margin 10% -o hostile_cage.obj
  works "which takes $1" timeout 60 "$mesh" hostile.obj --cage hostile_cage.obj --pose hostile_cage.obj --outside refuse -o posed.obj
}
: >hostile.obj
refuses 'hostile.obj: is empty' "$make_cage" hostile.obj -o out.obj
refuses 'nowhere.obj' "$make_cage" nowhere.obj -o out.obj
no_mesh_cage 'the figure has no extent, or no area' 'v 1 2 3'
no_mesh_cage 'the figure has no extent, or no area' 'v 1 1 1' 'v 1 1 1' 'v 1 1 1' 'f 1 2 3'
no_mesh_cage 'the coordinates of a vertex are not finite (line 2)' 'v 0 0 0' 'v nan 0 0' 'v 0 1 0' 'f 1 2 3'
no_mesh_cage 'the coordinates of a vertex are not finite (line 2)' 'v 0 0 0' 'v inf 0 0' 'v 0 1 0' 'f 1 2 3'
no_mesh_cage 'a coordinate of the figure is not a finite number, or too large (v 2)' 'v 0 0 0' 'v 1e300 0 0' 'v 0 1e300 0' 'f 1 2 3'
no_mesh_cage 'the coordinates of a vertex are not finite (line 2)' 'v 0 0 0' 'v 1e999 0 0' 'v 0 1 0' 'f 1 2 3'
no_mesh_cage 'a coordinate of the figure is not a finite number, or too large (v 2)' 'v 0 0 0' 'v 1e150 0 0' 'v 0 1e150 0' 'f 1 2 3'
no_mesh_cage 'the figure has no extent, or no area' 'v 0 0 0' 'v 1e-150 0 0' 'v 0 1e-150 0' 'f 1 2 3'
no_mesh_cage 'the figure has no extent, or no area' 'v 0 0 0' 'v 1e-300 0 0' 'v 0 1e-300 0' 'f 1 2 3'
no_mesh_cage 'vertex index 9 is out of range: the file has 3 (line 4)' 'v 0 0 0' 'v 1 0 0' 'v 0 1 0' 'f 1 2 9'
no_mesh_cage 'vertex index -4 is out of range: the file has 3 before this line (line 4)' 'v 0 0 0' 'v 1 0 0' 'v 0 1 0' 'f 1 2 -4'
no_mesh_cage 'a vertex index is 0; indices count from 1 (line 4)' 'v 0 0 0' 'v 1 0 0' 'v 0 1 0' 'f 1 2 0'
no_mesh_cage 'holds no vertices: it is no glTF, PLY, STL or Medit file, and has no OBJ lines' 'no mesh'
no_mesh_cage 'no cage around the figure was found: a margin of 0.0282843 at coordinates of 1e+15 is below' 'v 1e15 0 0' 'v 1000000000000001 0 0' 'v 1e15 1 0' 'f 1 2 3'
no_mesh_cage 'a face has fewer than three corners (line 3)' 'v 0 0 0' 'v 1 0 0' 'f 1 2'
printf '%s\n' 'v 0 0 0' 'v 1 0 0' 'v 2 0 0' 'f 1 2 3' >hostile.obj
mesh_caged "a line"
printf '%s\n' 'v 0 0 0' 'v 1e9 0 0' 'v 0 1e9 0' 'f 1 2 3' 'v 0 0 1e-3' 'v 1e-3 0 1e-3' 'v 0 1e-3 1e-3' 'f 4 5 6' >hostile.obj
mesh_caged "figures of two sizes in space"
awk 'BEGIN { srand(1); for (n = 0; n < 1000; n++) { x = 99 * rand(); y = 99 * rand(); z = 99 * rand()
  print "v", x, y, z; print "v", x + 1, y, z; print "v", x, y + 1, z; print "v", x, y, z + 1; print "f -4 -3 -2"; print "f -4 -2 -1" } }' >hostile.obj
mesh_caged "a thousand parts in space"
works "operations in space" "$mesh" hostile.obj --cage hostile_cage.obj --turn 'x>50:20,y@50,50,50' -o posed.obj
refuses '--holes is for figures in the plane' "$make_cage" character.obj --holes -o out.obj
refuses 'for a figure in space the cage is an .obj file' "$make_cage" character.obj -o out.svg
refuses 'for a figure in the plane the cage is an .svg or .csv file' "$make_cage" "$cat" -o out.obj
for margin in 0 -1% nan 1e9 5x; do
  refuses '--margin' "$make_cage" "$cat" --margin $margin -o out.svg
done
refuses '--vertices' "$make_cage" "$cat" --vertices 2 -o out.svg
for words in '--vertices few' '--vertices 12.5' '--volume 0%' '--volume -1%' '--volume nan' '--volume 15' '--volume 1e9%' '--volume x%'; do
  # shellcheck disable=SC2086  # the words are meant to be split
  refuses "${words%% *}" "$make_cage" "$cat" $words -o out.svg
done
refuses '--volume: --cage box has 8 vertices' "$make_cage" "$cat" --cage box --volume 5% -o out.svg
refuses '--vertices: --cage box has 8 vertices' "$make_cage" "$cat" --cage box --vertices auto -o out.svg
refuses '--lattice' "$make_cage" "$cat" --lattice 4x4 --volume 5% -o out.svg
works "the fewest vertices" "$make_cage" "$cat" --vertices auto -o fewest.csv
grep -q '^vertices  area over the tightest  deepest hollow spanned$' log && grep -q ' <- made$' log && ok=yes || ok=no
report $ok "says what each doubling brings"
works "the fewest vertices of a share" "$make_cage" "$cat" --area 5% -o fewest_share.csv
cmp -s fewest.csv fewest_share.csv && ok=yes || ok=no
report $ok "in the plane auto is 5 %"
works "too few for a share" "$make_cage" "$cat" --volume 0.01% --vertices 20 -o fewest.csv
grep -qF 'no cage of up to 20 vertices is within 0.01 % of the tightest; this one of 20 has' log && ok=yes || ok=no
report $ok "says how near it comes"
works "a cage of the fewest vertices, made in passing" "$deform" "$cat" --cage auto:5% -o fewest_look.svg
works "about a hull" "$deform" "$cat" --cage hull:10% -o fewest_look.svg
refuses 'auto:-5%: no such file; to make a cage' "$deform" "$cat" --cage auto:-5% -o out.svg
refuses 'a cage exceeds the tightest by a share above 0' "$make_cage" "$cat" --area 0 -o out.svg
refuses '--cage: auto:5 not in {auto,hull,box}' "$make_cage" "$cat" --cage auto:5 -o out.svg
printf '%s\n' 'v 0 0 0' 'v 1 0 0' 'v 0 1 0' 'v 0 0 1' 'f 1 2 3' 'f 1 2 4' >few.obj
works "the fewest vertices in space" "$make_cage" few.obj --vertices auto --volume 40% --margin 10% -o few_cage.obj
grep -q '^vertices  volume over the tightest  deepest hollow spanned$' log && ok=yes || ok=no
report $ok "says what each doubling brings in space"
{ cat few.obj; echo 'v 1e6 -1e6 1e6'; } >few_stray.obj
for words in '--vertices 20' '--lattice 3x3x3'; do
  # shellcheck disable=SC2086  # the words are meant to be split
  works "a cage, $words" "$make_cage" few.obj $words --margin 10% -o few_cage.obj
  # shellcheck disable=SC2086
  works "with a vertex that no face has" "$make_cage" few_stray.obj $words --margin 10% -o stray_cage.obj
  cmp -s few_cage.obj stray_cage.obj && ok=yes || ok=no
  report $ok "is about what faces have"
done
works "quads" "$make_cage" few.obj --vertices 40 --margin 10% --mirror z --quads -o quads.obj --picture quads.png
grep -qE '^faces: [0-9]+ quads and [0-9]+ triangles; .* % of the triangles were paired; the diagonals of the most warped' log &&
  awk '/^v/ { v++ } /^f/ { cut += NF - 3; if (NF == 5) quads++ } END { exit !(cut == 2 * v - 4 && quads > 19) }' quads.obj && ok=yes || ok=no
report $ok "says how many; cut, they are the triangles of a closed cage"
works "quads again" "$make_cage" few.obj --vertices 40 --margin 10% --mirror z --quads -o again.obj
cmp -s quads.obj again.obj && ok=yes || ok=no
report $ok "gives the same cage each time"
for words in mean-value harmonic green 'mean-value --faces fan' 'mean-value --faces triangles' 'mean-value --divisions 3'; do
  # shellcheck disable=SC2086  # the words are meant to be split
  works "quads, $words" "$mesh" few.obj --cage quads.obj --pose quads.obj --coordinates $words --outside refuse -o posed.obj
done
refuses '--quads is for figures in space: a cage in the plane has no faces' "$make_cage" "$cat" --quads -o out.svg
works "no rings" "$make_cage" few.obj --vertices 40 --margin 10% --rings -o rings.obj
grep -qF -e '--rings: no limb was found, or every ring would take more than a quarter of the vertices' log && ok=yes || ok=no
report $ok "says that there is no limb"
refuses '--rings is for figures in space: a cage in the plane has no limbs' "$make_cage" "$cat" --rings -o out.svg
refuses '--lattice' "$make_cage" few.obj --lattice 3x3x3 --rings -o out.obj
refuses '--lattice' "$make_cage" few.obj --lattice 3x3x3 --quads -o out.obj
# A ball with a long arm along x: parts 1 and 2. A posed part takes what hangs on it along, and nothing else.
awk 'function cube(x, y, z, i, j) { for (i = 0; i < 8; i++) print "v", x + i % 2, y + int(i / 2) % 2, z + int(i / 4)
    for (i = 1; i <= 8; i++) for (j = i + 1; j < 8; j++) print "f", i - 9, j - 9, -1 }
  BEGIN { for (n = 0; n < 64; n++) cube(n % 4, int(n / 4) % 4, int(n / 16)); for (n = 4; n < 16; n++) cube(n, 1.5, 1.5) }' >arm.obj
works "a cage with parts" "$make_cage" arm.obj --vertices 60 -o arm_cage.obj --picture arm.png --view 30,20
grep -q '^parts: 1 ([0-9]* vertices), 2 ([0-9]*)$' log && [ "$(grep '^g ' arm_cage.obj | tr '\n' ' ')" = 'g part_1 g part_2 ' ] && ok=yes || ok=no
report $ok "which the message and the file name"
works "a part about its joint" "$programs/pose_cage" arm_cage.obj --turn 'part 2:90,z' -o arm_pose.obj
paste -d ' ' arm_cage.obj arm_pose.obj | awk '$1 == "v" && $2 < 3.9 && ($2 != $6 || $3 != $7 || $4 != $8) || $1 == "v" && $2 > 15 && $7 < 9 || $1 == "g" && $2 != $4 { bad++ } END { exit bad }' && ok=yes || ok=no
report $ok "turns alone, and the pose has the groups"
works "a ring about a limb, with quads" "$make_cage" arm.obj --vertices 60 --rings --quads -o ring_cage.obj
grep -q '^rings: about 2 ([0-9]* vertices)$' log && grep -q '^parts: 1 ([0-9]* vertices), 2 ([0-9]*)$' log && ok=yes || ok=no
report $ok "which the message names"
works "a part about its ring" "$programs/pose_cage" ring_cage.obj --turn 'part 2:90,x' -o ring_pose.obj
works "rings of the fewest vertices, mirrored" "$make_cage" arm.obj --vertices auto --rings --mirror z -o ring_cage.obj
grep -q '^rings: about 2 (' log && ok=yes || ok=no
report $ok "with a ring across the mirror"
works "a part of a cage in passing" "$mesh" arm.obj --cage auto:60 --turn 'part 2:20,z' -o arm_look.obj
refuses '--turn "part 3:30,z": "part 3" is no part of the cage, which has part 1, part 2' "$mesh" arm.obj --cage arm_cage.obj --turn 'part 3:30,z' -o out.obj
refuses '"part two" is no part of the cage' "$programs/pose_cage" arm_cage.obj --turn 'part two:30,z' -o out.obj
refuses '"part 1" selects nothing: the cage has no parts' "$programs/pose_cage" "$cage" --turn 'part 1:30' -o out.svg
refuses '--mirror' "$make_cage" "$cat" --mirror w -o out.svg
refuses 'the grid spans the figure and its image across the mirror at 1e+09' "$make_cage" "$cat" --mirror x=1e9 -o out.svg
refuses 'nothing to write: give -o, --picture or both' "$make_cage" "$cat"
refuses '--fill-tunnels is for figures in space' "$make_cage" "$cat" --fill-tunnels -o out.svg
cp "$cat" kept.svg
refuses 'cannot write ./kept.svg: it is the same file as kept.svg, which is read' "$make_cage" kept.svg -o ./kept.svg
cmp -s "$cat" kept.svg && ok=yes || ok=no
report $ok "the figure stays"

# ---- lattices ----
works "a lattice, its picture and its rows and columns" "$make_cage" "$cat" --lattice 4x4 -o cat.lattice.json --picture numbers.svg --png
works "a lattice's rows and columns" "$make_cage" "$cat" --lattice 4x4 -o lattice.svg
[ "$(grep -c '<polyline' lattice.svg)" -eq 8 ] && ok=yes || ok=no
report $ok "they are eight lines"
works "a first look" "$deform" "$cat" --cage lattice:4x4 -o first.svg --png --show-cage
works "at rest" "$deform" "$cat" --cage lattice:4x4 --pose lattice.svg -o rest.svg
works "by its file" "$deform" "$cat" --cage cat.lattice.json --move 5:10,0 -o by_file.svg
works "by its word" "$deform" "$cat" --cage lattice:4x4 --move 5:10,0 -o by_word.svg
cmp -s by_file.svg by_word.svg && ok=yes || ok=no
report $ok "a lattice's file is its word"
works "a pose of a lattice" "$programs/pose_cage" cat.lattice.json --move 5:10,0 -o lattice_pose.svg --picture numbers.svg
works "as points" "$programs/pose_cage" cat.lattice.json --move 5:10,0 -o lattice_pose.csv
for lattice_pose in lattice_pose.svg lattice_pose.csv; do
  works "a figure by $lattice_pose" "$deform" "$cat" --cage cat.lattice.json --pose $lattice_pose -o by_pose.svg
  cmp -s by_file.svg by_pose.svg && ok=yes || ok=no
  report $ok "it is the pose"
done
works "a frozen lattice" "$deform" "$cat" --cage lattice:4x4 --freeze 1 --move 'all:10,0' -o frozen.svg
works "whose inner points move" "$deform" "$cat" --cage lattice:4x4 --move 5,6,9,10:10,0 -o inner.svg
cmp -s frozen.svg inner.svg && ok=yes || ok=no
report $ok "frozen points stay at rest"
works "frozen points of a file's pose stay too" "$deform" "$cat" --cage cat.lattice.json --freeze 1 --pose lattice_pose.svg -o by_pose.svg
works "a lattice that folds" "$deform" "$cat" --cage lattice:4x4 --move 5:3000,0 -o folded.svg --fit
grep -q 'warning: .*the posed lattice folds most at (.*): the figure may fold over itself there' log && ok=yes || ok=no
report $ok "is named"
works "a turned lattice that fades" "$deform" "$cat" --cage lattice:5x4/2+0.1@20 --turn all:20 -o faded.svg
works "Bernstein polynomials" "$animate" "$cat" --cage lattice:3x3/bernstein --turn 0-2:10 --seconds 0.2 -o played.svg --fit
works "a coordinate of a lattice" "$field" --cage cat.lattice.json --vertex 5 -o field.png --surface field_surface.png --size 64
printf '500,400\n-50,400\n' >places.csv
works "a lattice's weights" "$weights" --cage cat.lattice.json --points places.csv -o lattice_weights.csv
[ "$(head -1 lattice_weights.csv)" = "status$(seq -f ,w%g -s '' 0 15)" ] && grep -q ^outside lattice_weights.csv && ok=yes || ok=no
report $ok "their columns are its points, along x first"
works "a lattice that fades has still handles" "$make_cage" "$cat" --lattice 4x4+0.2 -o fading.lattice.json
works "with their weights" "$weights" --cage fading.lattice.json --points places.csv -o lattice_weights.csv
[ "$(sed -n '2s/.*,\(.*\),\(.*\),\(.*\)/\1 \2 \3/p' lattice_weights.csv)" = '0 0 0' ] && ok=yes || ok=no
report $ok "which are zero inside, in the last columns"
printf 'v %s %s %s\n' 0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1 >cube.obj
printf 'f %s %s %s %s\n' 1 3 4 2 5 6 8 7 1 2 6 5 2 4 8 6 4 3 7 8 3 1 5 7 >>cube.obj
works "a lattice in space" "$make_cage" cube.obj --lattice 3x3x3/2+0.5 -o cube.lattice.json --picture lattice.png
works "as a mesh" "$make_cage" cube.obj --lattice 3x3x3/2+0.5 -o cube_lattice.obj
works "a mesh by a lattice" "$mesh" cube.obj --cage lattice:4x4x4 --twist all:z,0,1,40 -o twisted.obj --picture lattice.png --report
works "by a lattice's file" "$mesh" cube.obj --cage cube.lattice.json --freeze 1 --move 'all:0,0,1' -o moved.obj
works "a lattice's pose in space" "$programs/pose_cage" cube.lattice.json --move 13:0,0,1 -o cube_pose.obj --picture lattice.png
works "which is the same" "$mesh" cube.obj --cage cube.lattice.json --pose cube_pose.obj -o posed.obj
cmp -s moved.obj posed.obj && ok=yes || ok=no
report $ok "the one point in the middle is free"
works "a lattice for a game" "$bind" cube.obj --cage lattice:3x3x3 --twist all:z,0,1,40 -o cube.figure
works "a lattice's joints" "$programs/export_gltf" cube.obj --cage lattice:3x3x3 --twist all:z,0,1,40 --skin 8 -o cube.glb
works "a face pulled out of a board" "$programs/lattice_board" -o board.png
grep -q '^35 x 35 x 2 points: distances of the board from the relief: rms 0.00' log && ok=yes || ok=no
report $ok "which follows the relief"
refuses 'output is required' "$programs/lattice_board"

# ---- electron_waves ----
waves="$programs/electron_waves"
small="--size 64x48 --mesh 0.2 --frames 3"
for scene in slit two-slits spin shadow; do
  # shellcheck disable=SC2086 # words
  works "waves: $scene" "$waves" --scene $scene $small --threads 2 -o waves.png --csv waves.csv --stills waves_
  head -1 waves.csv | grep -qx 'run,time,norm,energy,mean_x,mean_y,transmitted' && [ -s waves_00.png ] && [ -s waves_03.png ] &&
    ! cmp -s waves_00.png waves_03.png && ok=yes || ok=no
  report $ok "which move"
  rm waves_*
done
works "waves in float" "$waves" --float --size 64x48 --mesh 0.2 --walls absorbing -o waves.png --csv waves.csv
[ "$(wc -l <waves.csv)" = 51 ] && ok=yes || ok=no
report $ok "which have a line for each frame of two runs"
if [ -n "${CAGEFORM_NIGHTLY:-}" ]; then # tests/nightly.sh
  works "how exact waves are" "$waves" --tables
  grep -q '^0.01   1.7.e-07   16.0 ' log && grep -qx 'mesh 0.05   34.0921  1.8092' log && grep -qx 'plane waves 0.58720' log && ok=yes || ok=no
  report $ok "to the fourth order"
fi
refuses 'nothing to write' "$waves"
refuses 'orbit not in {slit,two-slits,spin,shadow}' "$waves" --scene orbit -o out.png
refuses 'missing/out.png: No such file' "$waves" -o missing/out.png
refuses 'missing/out.00.png: No such file' "$waves" --stills missing/out.
refuses '12: give columns and rows, such as 384x288' "$waves" --size 12 -o out.png
refuses '64x47: rows have to be a multiple of 4' "$waves" --size 64x47 -o out.png
refuses '16x16: a lattice has from 32 to 65536 columns' "$waves" --size 16x16 -o out.png
refuses 'is 6.3 x 4.7 wavelengths' "$waves" --size 64x48 -o out.png
refuses 'GB, and the machine has' "$waves" --size 65536x65536 -o out.png
refuses 'needs more than 100000000 steps' "$waves" --step 1e-12 -o out.png
refuses 'lattice:0x4: an axis has 2 points or more' "$deform" "$cat" --cage lattice:0x4 -o out.svg
refuses 'cat.svg: a lattice about a drawing has two axes: lattice:4x4' "$deform" "$cat" --cage lattice:4x4x4 -o out.svg
refuses 'cube.obj: a lattice about a mesh has three axes: lattice:4x4x4' "$mesh" cube.obj --cage lattice:4x4 -o out.obj
refuses 'lattice:4x4/9: the degree is 1, 2 or 3; for the highest, use /bernstein' "$animate" "$cat" --cage lattice:4x4/9 -o out.svg
refuses 'lattice:4: a lattice has two axes' "$field" --cage lattice:4 --figure "$cat" --vertex 0 -o out.png
refuses '--lattice: lattice:70x4/bernstein: Bernstein polynomials take at most 64 points along an axis' "$make_cage" "$cat" --lattice 70x4/bernstein -o out.svg
refuses 'lattice:4x4x4@30: @ANGLE is only for the box of a drawing' "$bind" cube.obj --cage lattice:4x4x4@30 -o out.figure
refuses 'cube.lattice.json: this lattice has three axes, but a drawing needs two' "$deform" "$cat" --cage cube.lattice.json -o out.svg
refuses 'cat.lattice.json: this lattice has two axes, but a mesh needs three' "$mesh" cube.obj --cage cat.lattice.json -o out.obj
refuses 'make_cage --lattice writes a .lattice.json file' "$weights" --cage lattice:4x4 --points places.csv -o out.csv
refuses 'cat_cage.svg: holds 1 line, and the lattice the lattice about' "$deform" "$cat" --cage lattice:4x4 --pose "$cage" -o out.svg
refuses 'places.csv: holds 2 points, and the lattice' "$deform" "$cat" --cage lattice:4x4 --pose places.csv -o out.svg
refuses '--freeze is for lattices' "$deform" "$cat" --cage auto --freeze 1 -o out.svg
refuses '--freeze 2 leaves no point of the lattice to move' "$deform" "$cat" --cage lattice:4x4 --freeze 2 -o out.svg
refuses 'there is no vertex 16' "$deform" "$cat" --cage lattice:4x4+1 --move 16:1,1 -o out.svg
refuses '--lattice' "$make_cage" "$cat" --lattice 4x4 --vertices 12 -o out.svg
refuses 'out.json: give --lattice and a name that ends with .lattice.json' "$make_cage" "$cat" --lattice 4x4 -o out.json
refuses 'out.lattice.json: give --lattice' "$make_cage" "$cat" -o out.lattice.json
echo '{' >broken.lattice.json
refuses 'broken.lattice.json: is no JSON' "$deform" "$cat" --cage broken.lattice.json -o out.svg
refuses 'nowhere.lattice.json: no such file' "$weights" --cage nowhere.lattice.json --points places.csv -o out.csv
works "coordinates that a lattice has not" "$deform" "$cat" --cage lattice:4x4 --coordinates green -o first.svg
grep -q 'warning: --coordinates green is not used: a lattice has functions of its own' log && ok=yes || ok=no
report $ok "are named"

# ---- cages of curves ----
leaf="$data/leaf.svg"
leaf_cage="$data/leaf_cage.svg"
works "a leaf by curves" "$deform" "$leaf" --cage "$leaf_cage" --pose "$data/leaf_pose.svg" --coordinates curved -o leaf.svg --png --show-cage --report
grep -q 'status: ok' log && [ -s leaf.png ] && ok=yes || ok=no
report $ok "it is bound and drawn"
works "at rest" "$deform" "$leaf" --cage "$leaf_cage" --pose "$leaf_cage" --coordinates curved-green -o leaf_rest.svg
cmp -s "$leaf" leaf_rest.svg && ok=yes || ok=no
report $ok "a cage of curves at rest moves nothing"
works "a pose by numbers" "$programs/pose_cage" "$leaf_cage" --turn 6:20 --curve 0:4:0,-30 -o leaf_pose.svg --picture leaf_numbers.svg
grep -q 'leaf_cage.svg: 3 of 12 control points moved' log && [ "$(grep -o '>[0-9]*</text>' leaf_numbers.svg | wc -l)" -eq 12 ] && ok=yes || ok=no
report $ok "an end takes its control points along, and all have numbers"
works "by its file" "$deform" "$leaf" --cage "$leaf_cage" --pose leaf_pose.svg --coordinates curved-green -o leaf_by_file.svg
works "by the operations" "$deform" "$leaf" --cage "$leaf_cage" --turn 6:20 --curve 0:4:0,-30 --coordinates curved-green -o leaf_by_words.svg
cmp -s leaf_by_file.svg leaf_by_words.svg && ok=yes || ok=no
report $ok "the file is the pose"
works "a leaf that moves" "$animate" "$leaf" --cage "$leaf_cage" --pose leaf_pose.svg --coordinates curved-green --seconds 0.2 -o leaf_moves.svg
printf 'length,1\ncontrol,tip\nvertices,5,6,7\n0,0,0,0,linear\n0.5,0,40,0,linear\n1,0,0,0,linear\n' >leaf_clip.csv
works "by a clip of its control points" "$animate" "$leaf" --cage "$leaf_cage" --clip leaf_clip.csv --coordinates curved-green --rate 5 -o leaf_moves.svg
works "a control point's coordinate" "$field" --cage "$leaf_cage" --vertex 1 --coordinates curved-green --size 64 -o leaf_field.png --surface leaf_surface.png
works "a row of the table" "$table" "$leaf" "$leaf_cage" leaf_pose.svg curved-green
printf '300,200\n10,10\n' >leaf_points.csv
works "the weights of curves" "$weights" --cage "$leaf_cage" --points leaf_points.csv --coordinates curved-green -o leaf_weights.csv
awk -F, 'NR == 1 { fits = NF == 25 && $13 == "w11" && $25 == "w23" }
  NR > 1 { sum = 0; for (i = 2; i <= 13; ++i) sum += $i; if ((sum - 1) ^ 2 > 1e-24) fits = 0 }
  END { exit !(fits && NR == 3) }' leaf_weights.csv && grep -q ^inside leaf_weights.csv && grep -q ^outside leaf_weights.csv && ok=yes || ok=no
report $ok "are those of control points, which sum to one, then of legs"
works "in single precision" "$weights" --cage "$leaf_cage" --points leaf_points.csv --coordinates curved-green --scalar float -o leaf_float.csv
works "in the smallest disk" "$weights" --cage "$leaf_cage" --points leaf_points.csv --coordinates curved-green --disk -o leaf_disk.csv
works "in a large disk" "$weights" --cage "$leaf_cage" --points leaf_points.csv --coordinates curved-green --disk-radius 1e9 -o leaf_large.csv
cmp -s leaf_weights.csv leaf_disk.csv && ok=no || ok=yes
report $ok "a disk changes the weights"
awk -F, 'NR == FNR { if (FNR == 2) for (i = 2; i <= 13; ++i) w[i] = $i; next }
  FNR == 2 { for (i = 2; i <= 13; ++i) if (($i - w[i]) ^ 2 > 1e-12) exit 1 }' leaf_weights.csv leaf_large.csv && ok=yes || ok=no
report $ok "but one that is large hardly does"
works "a polygon as curves" "$deform" "$cat" --cage "$cage" --pose "$pose" --coordinates curved-green -o curved_cat.svg
works "whose edges bend" "$deform" "$cat" --cage auto:12 --coordinates curved-green --curve 0:1:-60,10 -o curved_cat.svg --show-cage
works "its pose by numbers" "$programs/pose_cage" "$cage" --coordinates curved-green --move 3:5,5 -o curved_pose.svg
grep -q 'cat_cage.svg: 3 of 75 control points moved' log && grep -q 'd="M[^C]*C[^C]*C[^C]*L[^C]*Z"' curved_pose.svg && ok=yes || ok=no
report $ok "the edges beside it are cubics, and the others lines"
works "which is a pose of the polygon" "$deform" "$cat" --cage "$cage" --pose curved_pose.svg --coordinates curved-green -o curved_cat.svg
works "a circle as a cage" "$programs/pose_cage" "$data/fish_points.svg" --coordinates curved-green --picture circle_numbers.svg
grep -q ': 0 of 24 control points moved' log && ok=yes || ok=no
report $ok "is eight cubics"
works "curves that cross" "$deform" "$leaf" --cage "$leaf_cage" --move 3:0,600 --coordinates curved-green -o crossing.svg --fit
grep -q 'warning: .*in the posed cage edges cross' log && ok=yes || ok=no
report $ok "are named"
works "a leaf in two cages" "$programs/leaf_cages" "$leaf" --cage "$leaf_cage" --pose "$data/leaf_pose.svg" -o leaf_cages.svg --png
grep -q '^curves *24 handles' log && grep -q '^polygon *50 handles' log && awk '/differ by/ { exit !($5 < 2) }' log && ok=yes || ok=no
report $ok "by half the handles it is the same figure to a pixel"
works "a disk that is not used" "$deform" "$cat" --cage "$cage" --pose "$pose" --disk -o curved_cat.svg
grep -q 'warning: --disk is not used: it is for cages of --coordinates curved-green' log && ok=yes || ok=no
report $ok "is named"

for type in mean-value harmonic green; do
  refuses 'the first shape is a path with curves: path (line 3); --coordinates curved-green takes curves' "$deform" "$leaf" --cage "$leaf_cage" --coordinates $type --move 0:1,1 -o out.svg
done
refuses '--coordinates curved-green takes curves' "$weights" --cage "$leaf_cage" --points leaf_points.csv -o out.csv
refuses '--coordinates curved-green takes curves' "$animate" "$leaf" --cage "$leaf_cage" --turn 0:9 -o out.svg
refuses '--coordinates curved-green takes curves' "$programs/pose_cage" "$leaf_cage" --coordinates green -o out.svg
svg gap.svg '<path id="gap" d="M0 0C10 -20 40 -20 50 0L50 50M10 10H20V20Z"/>'
refuses 'gap.svg: no closed outline: a loop of curves is not closed: an edge ends where the next does not begin: subpath 0, counted from 0, of path "gap" (line 1) begins at (0, 0) and ends at (50, 50)' \
  "$deform" "$leaf" --cage gap.svg --coordinates curved-green --move 0:1,1 -o out.svg
refuses 'subpath 0, counted from 0, of path "gap"' "$programs/pose_cage" gap.svg -o out.svg
svg eight.svg '<path d="M0 0C60 60 -10 60 50 0Z"/>'
refuses 'eight.svg: two edges of the cage cross or touch' "$weights" --cage eight.svg --points leaf_points.csv --coordinates curved-green -o out.csv
svg flat.svg '<path d="M0 0Q25 0 50 0Z"/>'
refuses 'flat.svg: ' "$weights" --cage flat.svg --points leaf_points.csv --coordinates curved-green -o out.csv
svg fewer.svg '<path d="M0 0C1 1 2 2 9 9C1 5 1 1 0 0Z"/>'
refuses 'fewer.svg: the pose has 2 edges, the cage' "$deform" "$leaf" --cage "$leaf_cage" --pose fewer.svg --coordinates curved-green -o out.svg
sed 's/C 510 290 400 365 290 365/L 290 365/' "$leaf_cage" >lower.svg
refuses 'lower.svg: edge 2, counted from 0, a line (L), is a cubic (C) in the cage' "$animate" "$leaf" --cage "$leaf_cage" --pose lower.svg --coordinates curved-green -o out.svg
refuses 'cat_cage_head.csv: this coordinate type does not support interior cells: --coordinates curved-green supports only loops' "$weights" --cage "$data/cat_cage_head.csv" --points leaf_points.csv --coordinates curved-green -o out.csv
refuses 'the disk does not contain the cage' "$weights" --cage "$leaf_cage" --points leaf_points.csv --coordinates curved-green --disk-radius 10 -o out.csv
refuses '--disk-radius' "$weights" --cage "$leaf_cage" --points leaf_points.csv --coordinates curved-green --disk-radius -1 -o out.csv
refuses '--curve "0:0:1,1": the cage has no curves; --coordinates curved-green makes its edges curves' "$deform" "$cat" --cage "$cage" --curve 0:0:1,1 -o out.svg
refuses '--curve "1:0:1,1": there is no loop 1: the cage has 1, 0 to 0' "$deform" "$leaf" --cage "$leaf_cage" --coordinates curved-green --curve 1:0:1,1 -o out.svg
refuses 'there is no vertex 12' "$deform" "$leaf" --cage "$leaf_cage" --coordinates curved-green --move 12:1,1 -o out.svg
refuses 'out.csv: '"$leaf_cage"' has curves, which need an .svg file' "$programs/pose_cage" "$leaf_cage" --move 0:1,1 -o out.csv
refuses 'cube.obj lies in space' "$programs/pose_cage" cube.obj --coordinates curved-green -o out.obj
refuses 'cube.obj: curved-green takes a cage in the plane' "$weights" --cage cube.obj --points leaf_points.csv --coordinates curved-green -o out.csv
refuses 'curved' "$mesh" cube.obj --cage auto --coordinates curved-green -o out.obj
refuses '--values: curved-green coordinates do not interpolate' "$field" --cage "$leaf_cage" --coordinates curved-green --values 1,2,3,4,5,6,7,8,9,10,11,12 -o out.png
refuses "--classes: $leaf_cage: the papers' grid needs a cage of lines" "$field" --cage "$leaf_cage" --coordinates curved-green --vertex 0 --classes out.classes.png -o out.png
# ---- pins ----
svg_of() { # OUT ARGUMENTS…   the cat in its cage
  svg_to=$1; shift
  "$deform" "$cat" --cage "$cage" -o "$svg_to" "$@"
}
same() { # WHAT ONE OTHER
  cmp -s "$2" "$3" && ok=yes || ok=no
  report $ok "$1"
}
stands_at="212,740 645,740" # its paws
stands="--pin 212,740 --pin 645,740"
printf '915,165,915,165\n212,740,212,740\n645,740,645,740\n' >rest_pins.csv
for type in mean-value harmonic green; do
  works "at rest, $type" svg_of rest.svg --pose "$cage" --coordinates $type
  works "pins at rest, $type" svg_of pinned.svg --pins rest_pins.csv --coordinates $type
  same "pins at rest leave the figure at rest, $type" rest.svg pinned.svg
done
for type in mean-value harmonic; do
  # shellcheck disable=SC2086 # the words are options
  works "the tail pulled, $type" svg_of pinned.svg $stands --pin 915,165:760,60 --pin 200,200@-40 --coordinates $type --save-pose pinned_pose.svg --report
  grep -q '^pins: 4, held: 0 of 25 handles' log && grep -q '^largest miss: 0\.0.*, pin [1-4] (--pin "' log && grep -q '^stretch: .*, 0 folded' log && ok=yes || ok=no
  report $ok "the report has the miss, its pin and the stretch"
  works "the pose that is saved, $type" svg_of by_pose.svg --pose pinned_pose.svg --coordinates $type
  same "it is the pose of the pins, $type" pinned.svg by_pose.svg
done
printf 'x,y,tx,ty,angle,weight\n# paws\n212,740,212,740\n645,740,645,740\n\n915,165,760,60\n200,200,200,200,-40,1\n' >pins.csv
works "pins of a file" svg_of by_file.svg --pins pins.csv --coordinates harmonic
same "they are those of the words" pinned.svg by_file.svg
# shellcheck disable=SC2086
works "by how much" svg_of by_moves.svg $stands --pin 915,165:-155,-105 --pin '200,200:=200,200@-40' --coordinates harmonic
same "signs move, and = is a place" pinned.svg by_moves.svg
works "pins and held vertices" svg_of held.svg --pin 915,165:+0,-60 --hold 0-5 --save-pose held.csv
[ "$(head -6 held.csv)" = "$("$pose_cage" "$cage" -o still.csv >/dev/null; head -6 still.csv)" ] && ! cmp -s held.csv still.csv && ok=yes || ok=no
report $ok "held vertices stay to the bit"
works "held where a pose has them" svg_of held.svg --pin 915,165:+0,-60 --hold 0-5 --move 0-5:5,0 --save-pose held.csv
[ "$(head -1 held.csv)" = 180,750 ] && ok=yes || ok=no
report $ok "they are there"
works "one pin" svg_of moved.svg --pin 480,420:+30,-20 --save-pose one.csv
awk -F, 'NR == FNR { x[FNR] = $1; y[FNR] = $2; next } ($1 - x[FNR] - 30) ^ 2 + ($2 - y[FNR] + 20) ^ 2 > 1e-18 { bad = 1 } END { exit bad }' still.csv one.csv && ok=yes || ok=no
report $ok "one pin moves the cage as a whole"
works "a pin outside, where the coordinates go on" svg_of moved.svg --pin -50,400:+1,1
grep -q 'warning: pin 1 (--pin "-50,400:+1,1") at (-50, 400) lies outside the cage .*; it follows the extension' log && ok=yes || ok=no
report $ok "it is warned of"
works "a pin outside, at the boundary's nearest point" svg_of moved.svg --pin -50,400:+1,1 --coordinates harmonic --outside nearest-boundary
works "a pin outside, within the falloff" svg_of moved.svg --pin 20,400:+1,1 --coordinates harmonic --falloff 300
refuses 'pin 1 (--pin "-500,400:+1,1") at (-500, 400): a pin lies where the coordinates have no weights' \
  svg_of out.svg --pin -500,400:+1,1 --falloff 300
works "two pins at one place" svg_of moved.svg --pin 480,420:500,420 --pin 480,420:500,440 --fit --show-pins
[ "$(grep -o '<circle ' moved.svg | wc -l)" = 2 ] && ok=yes || ok=no
grep -q 'warning: pin 2 (--pin "480,420:500,440") at (480, 420) has another target than --pin "480,420:500,420" at the same position' log || ok=no
report $ok "are named and drawn"
seq 1 200 | awk '{ x = 300 + 2 * $1; printf "%g,420,%g,%g\n", x, x, 420 + 60 * sin($1 / 9) }' >many_pins.csv
works "more pins than a cage can follow" svg_of moved.svg --pins many_pins.csv --coordinates harmonic --fit
grep -q 'warning: pins fold the figure, in [0-9]* of [0-9]* parts: .*, or lower --pin-weight' log && ok=yes || ok=no
report $ok "folds are told, and a remedy"
works "which is one" svg_of moved.svg --pins many_pins.csv --coordinates harmonic --fit --pin-weight 10
grep -q fold log && ok=no || ok=yes
report $ok "nothing folds"
# whatever moves a figure
pinned_is_posed() { # WHAT FIGURE POSE ARGUMENTS…
  what=$1 of=$2 file=$3; shift 3
  works "$what" "$deform" "$of" "$@" --pin 480,420:500,400 --pin 300,300 -o pinned.svg --save-pose "$file" --fit
  works "$what, by its pose" "$deform" "$of" "$@" --pose "$file" -o by_pose.svg --fit
  same "$what: pins and their pose are one" pinned.svg by_pose.svg
}
pinned_is_posed "a made cage" "$cat" saved.svg --cage auto:24 --coordinates harmonic
pinned_is_posed "a lattice" "$cat" saved.svg --cage lattice:4x4
pinned_is_posed "a lattice that fades" "$cat" saved.csv --cage lattice:5x4/2+0.1@20 --freeze 1
pinned_is_posed "cells inside" "$cat" saved.csv --cage "$data/cat_cage_spine.csv" --coordinates harmonic
pinned_is_posed "points without a cage" "$data/fish.svg" saved.csv --cage "$data/fish_points.svg" --coordinates sibson
pinned_is_posed "points in a box" "$data/fish.svg" saved.csv --cage "$data/fish_points.svg" --coordinates sibson-c1 --surround 0.2
works "a cage of curves" "$deform" "$leaf" --cage "$leaf_cage" --coordinates curved-green --pin 100,100:+20,0@10 --pin 200,120 -o pinned.svg --fit
works "a text and an image by pins" "$deform" letters.svg --cage picture_cage.csv --pin 5,5:+2,0 -o pinned.svg --fit
grep -q '<text class="k" .* transform="matrix(1 0 0 1 4 0)"' pinned.svg && ok=yes || ok=no
report $ok "the text moves along"
: >no_pins.csv
echo '1,2,3' >few_pins.csv
printf 'x,y,tx,ty\n480,420,500,y\n' >word_pins.csv
echo '480,420,500,420,,-1' >light_pins.csv
echo '480,420,500,nan' >nan_pins.csv
refuses_pin() { # MESSAGE ARGUMENTS…
  message=$1; shift
  refuses "$message" svg_of out.svg "$@"
}
refuses_pin 'pin 1 (--pin "5,5:1,1") at (5, 5) lies outside the cage' --pin 5,5:1,1 --coordinates harmonic
refuses_pin 'no_pins.csv: holds no pins' --pins no_pins.csv
refuses_pin 'few_pins.csv:1: 3 columns, but a pin has x,y,TX,TY[,ANGLE[,WEIGHT]]' --pins few_pins.csv
refuses_pin 'word_pins.csv:2: not a number: "y"' --pins word_pins.csv
refuses_pin 'light_pins.csv:1: the weight "-1" is not positive' --pins light_pins.csv
refuses_pin 'nan_pins.csv:1: "nan" is not a finite number' --pins nan_pins.csv
refuses_pin 'nowhere.csv: no such file' --pins nowhere.csv
refuses_pin '--pin "5": "5" is not a place: write x,y' --pin 5
refuses_pin '--pin "480,420:": "" is not a target: write x,y' --pin 480,420:
refuses_pin '--pin "480,420:inf,1": "inf" is not a finite number' --pin 480,420:inf,1
refuses_pin '--pin "480,420@y": not a number: "y"' --pin 480,420@y
refuses_pin '--hold "0-25": there is no vertex 25' --pin 480,420 --hold 0-25
refuses_pin '--hold "all" leaves no vertex of the cage to move' --pin 480,420 --hold all
refuses_pin '--hold is for pins' --hold 1 --pose "$pose"
refuses_pin 'give --hold too, or only one of pins and a pose' --pin 480,420 --pose "$pose"
refuses_pin 'give --hold too, or only one of pins and a pose' --pin 480,420 --turn 1:3
refuses_pin '--pin-weight' --pin 480,420 --pin-weight 0
refuses_pin '--save-pose out.pose.svg: with these coordinates pins also pose edges' --pin 480,420 --coordinates green --save-pose out.pose.svg
refuses_pin 'the same file as ' --pin 480,420 --save-pose out.svg
refuses '--save-pose out.pose.svg: points need a .csv file' "$deform" "$data/fish.svg" --cage "$data/fish_points.svg" --coordinates sibson --pin 480,300 -o out.svg --save-pose out.pose.svg
refuses 'has chains or points, which need a .csv file' "$deform" "$cat" --cage "$data/cat_cage_spine.csv" --coordinates harmonic --pin 480,420 -o out.svg --save-pose out.pose.svg

# beside the least moves of the cage
works "poses by pins and by least squares" "$programs/pin_poses" "$cat" --cage "$cage" --coordinates harmonic --pinned "$stands_at 150,250:110,430" --pinned "480,420:500,420" -o sheet_
[ "$(grep -o '<circle ' sheet_1.svg | wc -l)" = 3 ] && [ -s sheet_2_least.svg ] && grep -q '^sheet_1_least.svg: stretch 0\.0.*, 0\.[1-9].* % of the inside folded' log && grep -q '^sheet_1.svg: .*, 0 % of the inside folded' log && ok=yes || ok=no
report $ok "the head by least squares folds"
grep -q '^sheet_2.svg: stretch 1.00 to 1.00' log && ! grep -q '^sheet_2_least.svg: stretch 1.00 to' log && ok=yes || ok=no
report $ok "one pin moves the figure as it is, by least squares it does not"
refuses '--pin "480": "480" is not a place' "$programs/pin_poses" "$cat" --cage "$cage" --pinned '480' -o out.
refuses 'lies outside the cage' "$programs/pin_poses" "$cat" --cage "$cage" --coordinates harmonic --pinned '5,5:6,6' -o out.
refuses 'a pose has no pins' "$programs/pin_poses" "$cat" --cage "$cage" --pinned ' ' -o out.
refuses '--pinned is required' "$programs/pin_poses" "$cat" --cage "$cage" -o out.

# motions by pins and by markers
motion() { # OUT ARGUMENTS…   of the cat in its cage
  svg_to=$1; shift
  "$animate" "$cat" --cage "$cage" --coordinates harmonic --rate 10 -o "$svg_to" "$@"
}
# shellcheck disable=SC2086
works "to a pin's target and back" motion wag.svg $stands --pin 915,165:860,120 --seconds 1 --stills wag_ --still-count 2 --save-clip wag.csv --report
# shellcheck disable=SC2086
works "half the time takes the figure there" svg_of there.svg $stands --pin 915,165:860,120 --coordinates harmonic --save-pose there.csv
awk -F, '/^control/ { n++ } /^0\.5,/ { x[n] = $2; y[n] = $3 }
         FILENAME == "still.csv" { rx[FNR] = $1; ry[FNR] = $2 }
         FILENAME == "there.csv" { if ((rx[FNR] + x[FNR] - $1) ^ 2 + (ry[FNR] + y[FNR] - $2) ^ 2 > 0.25) bad = 1; rows++ }
         END { exit bad || rows != 25 || n != 25 }' wag.csv still.csv there.csv && ok=yes || ok=no
report $ok "the key there is the pose of these pins"
works "the keys as a clip" motion by_clip.svg --clip wag.csv
same "they are the motion" wag.svg by_clip.svg
printf '%s\n' length,1 pin,tail,915,165 0,0,0,0,ease 0.5,-55,-45,0,ease 1,0,0,0,ease pin,front,212,740 0,0,0,0,linear 1,0,0,0,linear \
  pin,hind,645,740,1 0,0,0,0,linear 1,0,0,0,linear >pins_clip.csv
works "a clip of pins" motion by_pins.svg --clip pins_clip.csv
same "says the same" wag.svg by_pins.svg
printf '%s\n' time,tail_x,tail_y,front_x,front_y 0,915,165,212,740 0.5,915,165,212,740 1,915,165,212,740 >markers.csv
works "markers at rest" motion rest_walk.svg --markers markers.csv --stills rest_ --still-count 2
works "the figure at rest, in as many pieces" motion posed_walk.svg --pose "$cage" --seconds 1 --stills posed_ --still-count 2
same "markers at rest leave it there" rest_01.svg posed_01.svg
same "at all times" rest_02.svg posed_02.svg
tracks=
for point in 212,735 215,600 645,735 645,620 250,440 700,440 480,420 148,253 220,125 800,400 880,290 920,160; do tracks="$tracks --track $point"; done
# shellcheck disable=SC2086
works "points of the cat that walks" motion walk.svg --clip "$data/cat_walk.csv" $tracks --save-tracks tracks.csv
awk -F, 'NR == FNR { line[FNR] = $0; n = FNR; next } { split(line[FNR], a); for (k = 1; k <= NF; k++) if (a[k] + 0 - $k > 0.05 || $k - a[k] > 0.05) bad = 1 }
         END { exit bad || FNR != n || n < 25 }' tracks.csv "$data/cat_markers.csv" && ok=yes || ok=no
report $ok "are those of cat_markers.csv"
# shellcheck disable=SC2086
works "the cat walks from these alone" motion marched.svg --markers "$data/cat_markers.csv" $tracks --save-tracks marched.csv --report
grep -q '^pins: 12, held: 0 of 25' log && grep -q '^late,far-legs,0.6' marched.csv && ok=yes || ok=no
report $ok "with what comes late"
awk -F, 'NR == FNR { line[FNR] = $0; next } /^[0-9]/ { split(line[FNR], a); for (k = 2; k <= NF; k++) { d = a[k] - $k; if (d > 1 || d < -1) bad = 1 } rows++ }
         END { exit bad || rows != 25 }' tracks.csv marched.csv && ok=yes || ok=no
report $ok "its points go within a unit of theirs"
printf 'time,nose.x,nose.y,a,b\nrest,148,253,480,420\n7,150,250,480,420\n7.5,,,490,420\n8,160,250,500,420\n' >lost.csv
works "a marker that is lost" motion lost.svg --markers lost.csv --save-clip lost_clip.csv
grep -q '^length,1.5$' lost_clip.csv && ok=yes || ok=no
report $ok "the motion returns for half a second"
refuses_markers() { # MESSAGE TEXT
  printf '%b' "$2" >markers.csv
  refuses "$1" motion out.svg --markers markers.csv
}
refuses_markers 'markers.csv: holds fewer than two times' ''
refuses_markers 'markers.csv: holds fewer than two times' '0,1,2\n'
refuses_markers 'markers.csv:1: a row is a time, then x,y of every marker' '0,1\n'
refuses_markers 'markers.csv:2: 5 columns, and the first row has 3' '0,480,420\n1,480,420,1,2\n'
refuses_markers 'markers.csv:2: a time is not later than the one before it' '0,480,420\n0,480,420\n'
refuses_markers 'markers.csv:2: not a number: "x"' '0,480,420\n1,x,420\n'
refuses_markers 'markers.csv:2: not a number: ""' '0,480,420\n1,,420\n'
refuses_markers 'markers.csv: "marker 2" has no rest position' '0,480,420,,\n1,480,420,3,4\n'
refuses_markers 'markers.csv: "2" has no position at any time' 'time,1,,2,\nrest,480,420,500,420\n0,480,420,,\n1,480,420,,\n'
refuses_markers 'markers.csv: "b" has no position at any time' 'time,a,,b,\nrest,480,420,500,420\n0,480,420,,\n1,480,420,,\n'
refuses_markers 'markers.csv:2: the rest row has to be the first row' '0,480,420\nrest,480,420\n1,480,420\n'
refuses_markers 'markers.csv:1: "late" takes an element and seconds' 'late,3\n'
refuses_markers 'pin 1 (markers.csv: marker 1) at (5, 5) lies outside the cage' '0,5,5\n1,6,6\n'
refuses_markers 'markers.csv: its length needs' '0,480,420\n1e9,480,420\n'
printf '%s\n' length,1 control,a vertices,0 0,0,0,0,ease 1,0,0,0,ease pin,b,480,420 0,0,0,0,ease 1,0,0,0,ease >both.csv
refuses 'both.csv:6: a clip has either controls or pins' motion out.svg --clip both.csv
printf '%s\n' length,1 pin,b,480,420 vertices,0 >both.csv
refuses 'both.csv:3: a pin has no vertices' motion out.svg --clip both.csv
printf '%s\n' length,1 pin,b,480,420,0 >both.csv
refuses 'both.csv:2: the weight of a pin is not positive' motion out.svg --clip both.csv
refuses 'give only one of --clip, --markers, pins, and a pose' motion out.svg --clip wag.csv --pin 480,420
refuses 'give only one of --clip, --markers, pins, and a pose' motion out.svg --markers lost.csv --turn 1:3
refuses '--hold is for pins, and the motion has none' motion out.svg --clip "$data/cat_walk.csv" --hold 1
refuses '--track and --save-tracks need each other' motion out.svg --clip "$data/cat_walk.csv" --track 480,420
refuses '--save-clip out.clip.csv: with these coordinates pins also pose edges' "$animate" "$cat" --cage "$cage" --coordinates green --rate 10 --pin 480,420:+1,0 -o out.svg --save-clip out.clip.csv

# ---- tetrahedra, folds, pins in space ----
seq 8 >corner_weights.txt
make_box="$programs/make_box"
works "a box of tetrahedra" "$make_box" -o bar.mesh --cage bar_cage.obj
grep -qx 'bar.mesh: 425 vertices, 1536 tetrahedra' log && ok=yes || ok=no
report $ok "tells its size"
refuses '--flip-faces: bar.mesh: the format is not supported' "$mesh" bar.mesh --cage bar_cage.obj --pose bar_cage.obj --flip-faces -o out.mesh
works "a box of one cube" "$make_box" -o cube.mesh --size 1,2,3 --cells 1,1,1
[ "$(grep -c '^[01] [02] [03] 0$' cube.mesh)" = 8 ] && [ "$(sed -n '/Tetrahedra/{n;p;}' cube.mesh)" = 6 ] && ok=yes || ok=no
report $ok "has eight corners and six cells"
refuses '--size: ' "$make_box" -o out.mesh --size 1,2
refuses '--size: a length is not a positive number' "$make_box" -o out.mesh --size 1,0,2
refuses '--size: ' "$make_box" -o out.mesh --size 1,nan,2
refuses '--cells: a number along an axis is not a whole number from 1' "$make_box" -o out.mesh --cells 4,2.5,1
refuses '--cells: more than 16,777,216 together' "$make_box" -o out.mesh --cells 1000,1000,1000
refuses '--divisions: ' "$make_box" -o out.mesh --cage out.obj --divisions 0,1,1
refuses '"out.vtk" does not end with .mesh' "$make_box" -o out.vtk
in_bar() { # OUT ARGUMENTS…   the bar in its cage
  out=$1; shift
  "$mesh" bar.mesh --cage bar_cage.obj -o "$out" "$@"
}
works "tetrahedra at rest" in_bar bar_rest.mesh --pose bar_cage.obj --report
cmp -s bar.mesh bar_rest.mesh && ok=yes || ok=no
report $ok "the file is the same"
grep -qx 'figure: 425 vertices, 0 normals, 1536 tetrahedra' log && grep -qx 'folds: 0 of 1536 tetrahedra' log &&
  grep -qx 'largest step without a fold: 1' log && ok=yes || ok=no
report $ok "no fold is reported"
fold="--bend all:xy,1.5,2.5,180"
# shellcheck disable=SC2086 # the words are options
works "tetrahedra that fold" in_bar bar_folded.mesh $fold --report --picture bar.png
grep -q '^folds: 33 of 1536 tetrahedra, first tetrahedron ' log && grep -q "^least V'/V: -0\.1.*, tetrahedron " log &&
  grep -q '^largest step without a fold: 0\.48.*, then tetrahedron [0-9]* folds$' log && ok=yes || ok=no
report $ok "are counted and named"
# shellcheck disable=SC2086
works "a pose that stops" in_bar bar_stopped.mesh $fold --no-folds --report
grep -q 'note: bar.mesh: the pose stops at 0\.48[0-9]* of its way from rest, where tetrahedron [0-9]* would fold$' log && ok=yes || ok=no
report $ok "says where, and which tetrahedron"
# The step by bisection: the least V'/V of all cells on the way from rest to the folded pose.
found=$(awk '
  function volume(f, t, a, b, c, d,   k, x, y, z) {
    split(a " " b " " c " " d, v, " ")
    for (k = 1; k <= 4; k++) { X[k] = at(f, t, v[k], 1); Y[k] = at(f, t, v[k], 2); Z[k] = at(f, t, v[k], 3) }
    for (k = 2; k <= 4; k++) { X[k] -= X[1]; Y[k] -= Y[1]; Z[k] -= Z[1] }
    return X[2] * (Y[3] * Z[4] - Z[3] * Y[4]) - Y[2] * (X[3] * Z[4] - Z[3] * X[4]) + Z[2] * (X[3] * Y[4] - Y[3] * X[4])
  }
  function at(f, t, i, k) { return P[1, i, k] + t * (P[f, i, k] - P[1, i, k]) }
  function least(f, t,   n, r, m) {
    m = 2
    for (n = 1; n <= cells; n++) {
      r = volume(f, t, C[n, 1], C[n, 2], C[n, 3], C[n, 4]) / volume(1, 0, C[n, 1], C[n, 2], C[n, 3], C[n, 4])
      if (r < m) m = r
    }
    return m
  }
  FNR == 1 { f++; part = "" }
  /^[A-Z]/ { part = $1; n = 0; next }
  NF == 1 { next }
  part == "Vertices" { n++; for (k = 1; k <= 3; k++) P[f, n, k] = $k }
  part == "Tetrahedra" { n++; cells = n; for (k = 1; k <= 4; k++) C[n, k] = $k }
  END {
    lower = 0; upper = 1
    for (t = 0.02; t < 1; t += 0.02) { if (least(2, t) <= 0) { upper = t; break } lower = t }
    for (n = 0; n < 20; n++) { m = (lower + upper) / 2; if (least(2, m) > 0) lower = m; else upper = m }
    r = least(3, 1)
    printf "%.4f %d", lower, (r > 0 && r < 1e-6)
  }' bar.mesh bar_folded.mesh bar_stopped.mesh)
said=$(sed -n 's/^largest step without a fold: \([0-9.]*\), .*: the figure stops there$/\1/p' log)
[ "$found" = "$said 1" ] && ok=yes || { ok=no; echo "bisection: $found, said: $said" >>log; }
report $ok "the step is that of bisection, and no tetrahedron is folded there"
# shellcheck disable=SC2086
works "a pose that stops sooner" in_bar bar_sooner.mesh $fold --no-folds --fold-threshold 0.3
grep -q 'stops at 0\.[0-4]' log && ! cmp -s bar_sooner.mesh bar_stopped.mesh && ok=yes || ok=no
report $ok "as the threshold says"
works "a pose that does not fold" in_bar bar_bent.mesh --bend all:xy,0,4,60
works "need not stop" in_bar bar_unfolded.mesh --bend all:xy,0,4,60 --no-folds
cmp -s bar_bent.mesh bar_unfolded.mesh && ! grep -q stops log && ok=yes || ok=no
report $ok "and does not"
# shellcheck disable=SC2086
works "a surface that stops" "$mesh" character.obj --cage character_cage.obj --scale 'y>1:1,-0.2,1' --no-folds -o surface.obj --report
grep -q 'note: character.obj: the pose stops at 0\.[0-9]* of its way from rest, where the figure at v [0-9]* would fold' log &&
  grep -q '^folds: [0-9]* of 8066 vertices, first v ' log && ok=yes || ok=no
report $ok "names a vertex"
works "a mesh in a made cage" "$mesh" bar.mesh --cage auto:30 -o bar_made.mesh
works "a mesh in a lattice" "$mesh" bar.mesh --cage lattice:4x3x3 --twist all:x,0,4,90 -o bar_twisted.mesh
works "cells need no gradients" "$mesh" bar.mesh --cage box --coordinates harmonic --resolution 24 --twist all:x,0,4,20 -o bar_moved.mesh --report
grep -qx 'folds: 0 of 1536 tetrahedra' log && ok=yes || ok=no
report $ok "they are looked at"
works "points with weights" "$mesh" inner.obj --cage box.obj --coordinates sibson --weights corner_weights.txt --pose box.obj -o moved.obj --report
grep -qx 'folds: not known: no gradients are computed for points with weights' log && ok=yes || ok=no
report $ok "have no gradients"
refuses 'inner.obj: --no-folds: ' "$mesh" inner.obj --cage box.obj --coordinates sibson --weights corner_weights.txt --pose box.obj -o out.obj --no-folds
refuses '--fold-threshold' in_bar out.mesh --pose bar_cage.obj --fold-threshold 1
refuses '-o out.obj: the figure bar.mesh is written as .mesh' in_bar out.obj --pose bar_cage.obj
refuses '-o out.mesh: the figure inner.obj is written as .obj' "$mesh" inner.obj --cage box.obj --pose box.obj -o out.mesh
: >empty.mesh
printf 'MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n' >short.mesh
sed 's/^Dimension 3/Dimension 2/' bar.mesh >flat.mesh
sed '/^Tetrahedra/,$ s/^1 2 /1 9999 /' bar.mesh >index.mesh
sed '/^Tetrahedra/{n;n;s/.*/1 2 3 4 0/;}' bar.mesh >thin.mesh
refuses_mesh() { # MESSAGE FILE ARGUMENTS…
  message=$1 file=$2; shift 2
  refuses "$message" "$mesh" "$file" --cage bar_cage.obj --bend all:xy,0,4,60 -o out.mesh "$@"
}
refuses_mesh 'empty.mesh: is empty' empty.mesh
refuses_mesh 'short.mesh: Vertices end after 3 of 4 (line 7)' short.mesh
refuses_mesh 'flat.mesh: Dimension is "2": a mesh in space has 3 (line 2)' flat.mesh
refuses_mesh 'index.mesh: vertex index 9999 is out of range: the file has 425 (line ' index.mesh
refuses_mesh 'nowhere.mesh: no such file' nowhere.mesh
refuses_mesh 'thin.mesh: --no-folds: tetrahedron 1: the simplex has no volume relative to its size' thin.mesh --no-folds
works "a report of a flat cell" "$mesh" thin.mesh --cage bar_cage.obj --bend all:xy,0,4,60 -o thin_out.mesh --report
grep -qx 'folds: not known: tetrahedron 1: the simplex has no volume relative to its size' log && ok=yes || ok=no
report $ok "names it"

by_pins() { # OUT ARGUMENTS…   the character in its cage
  out=$1; shift
  "$mesh" character.obj --cage character_cage.obj -o "$out" "$@"
}
printf '0,%s\n' "$(sed -n '/^v /{s/^v //;s/ /,/g;p;q;}' character.obj)" >rest_pins.csv
for type in mean-value green; do
  works "pins at rest in space, $type" by_pins pinned.obj --pins rest_pins.csv --pin 4000 --pin 8000 --coordinates $type
  cmp -s character.obj pinned.obj && ok=yes || ok=no
  report $ok "pins at rest leave the file as it is, $type"
done
for type in harmonic mean-value; do
  works "a limb pulled, $type" by_pins pinned.obj --pin 0 --pin 4000@20,y --pin 8000:+0.1,+0.2,0 --coordinates $type --save-pose pinned_cage.obj --report
  grep -q '^pins: 3, held: 0 of 112 handles' log && grep -q '^largest miss: 0\.0.*, pin [1-3] (--pin "' log && grep -q '^folds: ' log &&
    grep -q '^pin 1 .*: stays$' log && grep -q '^pin 3 .*: moved by (0.1, 0.2, 0) to (' log && ok=yes || ok=no
  report $ok "the report has the miss, its pin and folds"
  works "the cage that is saved, $type" by_pins by_pose.obj --pose pinned_cage.obj --coordinates $type
  # Harmonic functions that are kept for the samples are rounded to floats in space.
  paste pinned.obj by_pose.obj | awk -v most="$([ $type = harmonic ] && echo 1e-5 || echo 0)" \
    '/^v / { for (k = 2; k <= 4; k++) { d = $k - $(k + 4); if (d > most || -d > most) bad = 1 } n++ } END { exit bad || n != 8066 }' && ok=yes || ok=no
  report $ok "it is the pose of the pins, $type"
done
awk '/^v / { n++; for (i = 1; i < 4; i++) p[n, i] = $(i + 1) }
     function place(i) { return p[i, 1] "," p[i, 2] "," p[i, 3] }
     END { print "vertex,TX,TY,TZ,RX,RY,RZ"; print "0," place(1); print "4000," place(4001) ",0,20,0"
           print "# a foot"; print place(8001) "," p[8001, 1] + 0.1 "," p[8001, 2] + 0.2 "," p[8001, 3] }' character.obj >space_pins.csv
works "pins of a file in space" by_pins by_file.obj --pins space_pins.csv --coordinates mean-value
awk '/^v / && NR == FNR { x[FNR] = $2; y[FNR] = $3; next }
     /^v / { if (($2 - x[FNR]) ^ 2 + ($3 - y[FNR]) ^ 2 > 1e-8) bad = 1; n++ } END { exit bad || n != 8066 }' pinned.obj by_file.obj && ok=yes || ok=no
report $ok "they are those of the words"
works "held vertices in space" by_pins held.obj --pin 8000:+0.1,+0.2,0 --hold 0-40 --save-pose held_cage.obj
awk '/^v / { n++; if (NR == FNR) v[n] = $0; else { if (!m) m = n; if (v[n - m + 1] != $0 && n - m < 41) bad = 1; if (v[n - m + 1] != $0) moved = 1 } }
     END { exit bad || !moved }' character_cage.obj held_cage.obj && ok=yes || ok=no
report $ok "stay to the bit"
works "a pin that goes far" by_pins far.obj --pin 0 --pin 8000:+0,+9,0
grep -q 'warning: pin 2 (--pin "8000:+0,+9,0") at .*: moved by (0, 9, 0) to (.*), outside twice the box of the cage' log && ok=yes || ok=no
report $ok "is warned of"
works "pins of tetrahedra that stop" in_bar bar_pinned.mesh --pin 0 --pin 424:+-6,+1,0 --pin 16 --no-folds --save-pose bar_pose.obj --report
grep -q 'the pose stops at' log && grep -q '^pins: 3' log && ok=yes || ok=no
report $ok "the stop is said"
works "a lattice by pins" "$mesh" bar.mesh --cage lattice:4x3x3+0.2 --freeze 1 --pin 200:+0,+0.05,0 -o pinned.mesh --save-pose lattice_pose.obj
works "a lattice by that pose" "$mesh" bar.mesh --cage lattice:4x3x3+0.2 --freeze 1 --pose lattice_pose.obj -o by_pose.mesh
cmp -s pinned.mesh by_pose.mesh && ok=yes || ok=no
report $ok "is the same"
for type in sibson sibson-c1; do
  works "points by pins, $type" "$mesh" inner.obj --cage box.obj --coordinates $type --surround 0.3 --pin 0:+0.1,0,0 --pin 1 -o pinned.obj --save-pose sites_pose.obj
  works "points by that pose, $type" "$mesh" inner.obj --cage box.obj --coordinates $type --surround 0.3 --pose sites_pose.obj -o by_pose.obj
  cmp -s pinned.obj by_pose.obj && ok=yes || ok=no
  report $ok "is the same, $type"
done
works "poses of a mesh by pins and by least squares" "$programs/pin_poses" character.obj --cage character_cage.obj --pinned '0 4000 8000:+0.1,+0.2,0' --pinned '0:+0.1,0,0' -o in_space_
[ -s in_space_all.png ] && [ -s in_space_all_least.png ] && [ "$(grep -c ': stretch .* of the inside folded$' log)" = 4 ] && ok=yes || ok=no
report $ok "two pictures, and the stretch of each pose"
refuses 'there is no vertex 9000: the figure has 8066, counted from 0' "$programs/pin_poses" character.obj --cage character_cage.obj --pinned 9000 -o out.
refuses '--pinned " ": a pose has no pins' "$programs/pin_poses" character.obj --cage character_cage.obj --pinned ' ' -o out.
refuses 'lies outside the cage box.obj' "$programs/pin_poses" inner.obj --cage box.obj --coordinates harmonic --pinned 9,9,9 -o out.
refuses_in_space() { # MESSAGE ARGUMENTS…
  message=$1; shift
  refuses "$message" by_pins out.obj "$@"
}
echo '1,2' >few_pins.csv
refuses_in_space 'there is no vertex 8066: the figure has 8066, counted from 0' --pin 8066
refuses_in_space '--pin "1,2": "1,2" is not a place: write x,y,z, or the number of a vertex' --pin 1,2
refuses 'pin 1 (--pin "9,9,9") at (9, 9, 9) lies outside the cage box.obj' "$mesh" inner.obj --cage box.obj --coordinates harmonic --pin 9,9,9 -o out.obj
refuses_in_space 'few_pins.csv:1: 2 columns, but a pin has x,y,z,TX,TY,TZ[,RX,RY,RZ[,WEIGHT]], or a vertex for x,y,z' --pins few_pins.csv
refuses_in_space 'no_pins.csv: holds no pins' --pins no_pins.csv
refuses_in_space '--pin "0@40": ' --pin 0@40
refuses_in_space '--hold is for pins' --hold 1 --pose character_pose.obj
refuses_in_space 'give --hold too, or only one of pins and a pose' --pin 0 --pose character_pose.obj
refuses '--save-pose out.pose.obj: with green pins move faces as well as vertices' "$mesh" inner.obj --cage box.obj --pin 0 --coordinates green --save-pose out.pose.obj -o out.obj
refuses_in_space 'the same file as ' --pin 0 --save-pose out.obj
works "pins in a tetrahedron" "$mesh" inner.obj --cage tetrahedron.obj --coordinates barycentric --pin 0:+0.1,0,0 --pin 1 -o pinned.obj
refuses '--weights: pins do not support points with weights' "$mesh" inner.obj --cage box.obj --coordinates sibson --weights corner_weights.txt --pin 0 -o out.obj
works "samples for a game's pins" "$bind" character.obj --cage character_cage.obj --pose-samples -o pins.figure --report
bytes=$(sed -n 's/^samples for pins: \([0-9]*\) bytes, of [0-9]* points in 224 clusters, .* s$/\1/p' log)
more=$(($(wc -c <pins.figure) - $(wc -c <still.figure) - ${bytes:-0}))
[ "${bytes:-0}" -gt 100000 ] && [ $more -ge 0 ] && [ $more -lt 256 ] && ok=yes || { ok=no; echo "$bytes, $more" >>log; }
report $ok "are beside the figure"

# ---- lattice_fit ----
fit="$programs/lattice_fit"
works "a lattice fitted to what a lattice has made" "$fit" cube.obj twisted.obj --cage lattice:4x4x4 --smoothness 1e-12 -o fit_pose.obj --picture fit.png
grep -q '^cube.obj: by 4 x 4 x 4 control points of degree 3, 3, 3$' log && grep -Eq '^largest distance: [0-9.]+e-[0-9]+, of v [1-8] at \([01], [01], [01]\); rms: [0-9.]+e-' log &&
  grep -q '^points of the lattice that move no vertex: 0$' log && grep -q '^seconds to bind and fit: ' log && ok=yes || ok=no
report $ok "follows it"
works "by the fitted pose" "$mesh" cube.obj --cage lattice:4x4x4 --pose fit_pose.obj -o fitted.obj
grep '^v' twisted.obj >twisted_v && grep '^v' fitted.obj | paste - twisted_v | awk '{ for (k = 2; k < 5; k++) if (($k - $(k + 4)) ^ 2 > 1e-10) exit 1 }' && ok=yes || ok=no
report $ok "the cube is the twisted one"
works "with a frozen layer" "$fit" cube.obj twisted.obj --cage cube.lattice.json --freeze 1 -o fit_pose.obj
[ "$(grep -c '^v' fit_pose.obj)" = 31 ] && ok=yes || ok=no # still handles too
report $ok "the pose has all its points"
svg lines.svg '<path d="M 10 10 L 90 10 L 90 40 L 10 40 Z"/>'
svg moved_lines.svg '<path d="M 15 12 L 95 12 L 95 42 L 15 42 Z"/>'
for out in fit_pose.svg fit_pose.csv; do
  works "a lattice fitted in the plane" "$fit" lines.svg moved_lines.svg --cage lattice:3x3 -o $out
  grep -Eq '^largest distance: ([0-9.]+e-[0-9]+|0), of point [0-3] at ' log && ok=yes || ok=no
  report $ok "a shift is followed by every lattice"
  works "by that pose" "$deform" lines.svg --cage lattice:3x3 --pose $out -o fitted.svg
  grep -q 'd="M15[ ,]12' fitted.svg && ok=yes || ok=no
  report $ok "the lines have moved"
done
: >empty.obj
: >empty.svg
refuses 'character.obj has 8066 vertices, cube.obj has 8: both need the same vertices' "$fit" cube.obj character.obj --cage lattice:4x4x4 -o out.obj
refuses 'empty.obj' "$fit" empty.obj cube.obj --cage lattice:4x4x4 -o out.obj
refuses 'empty.obj' "$fit" cube.obj empty.obj --cage lattice:4x4x4 -o out.obj
refuses 'empty.svg' "$fit" lines.svg empty.svg --cage lattice:3x3 -o out.svg
refuses 'nowhere.obj' "$fit" cube.obj nowhere.obj --cage lattice:4x4x4 -o out.obj
refuses 'nowhere.obj' "$fit" nowhere.obj cube.obj --cage lattice:4x4x4 -o out.obj
refuses 'nowhere.lattice.json' "$fit" cube.obj cube.obj --cage nowhere.lattice.json -o out.obj
refuses 'a lattice about a mesh has three axes: lattice:4x4x4' "$fit" cube.obj cube.obj --cage lattice:4x4 -o out.obj
refuses '--cage "cube.obj" is no lattice: write one such as lattice:4x4x4' "$fit" cube.obj cube.obj --cage cube.obj -o out.obj
refuses '--freeze 2 leaves no point of the lattice to move' "$fit" cube.obj cube.obj --cage lattice:4x4x4 --freeze 2 -o out.obj
refuses '--smoothness' "$fit" cube.obj cube.obj --cage lattice:4x4x4 --smoothness -1 -o out.obj
refuses '--smoothness' "$fit" cube.obj cube.obj --cage lattice:4x4x4 --smoothness word -o out.obj
refuses 'twisted.obj: the points do not determine the pose: give more, or more smoothness' "$fit" cube.obj twisted.obj --cage lattice:4x4x4 --smoothness 0 -o out.obj
refuses 'the figure lies in space: write .obj' "$fit" cube.obj cube.obj --cage lattice:4x4x4 -o out.svg
refuses 'the figure lies in the plane: write .svg or .csv' "$fit" lines.svg lines.svg --cage lattice:4x4 -o out.obj
refuses '--picture is for figures in space' "$fit" lines.svg lines.svg --cage lattice:4x4 -o out.svg --picture out.png
refuses 'output is required' "$fit" cube.obj cube.obj --cage lattice:4x4x4

# ---- coordinate_field, figure_table, contact_sheet ----
works "a field" "$field" --cage "$cage" --vertex 8 --coordinates harmonic --resolution 64 --size 120 -o field.png
works "a field by the papers' solver" "$field" --cage "$cage" --vertex 8 --coordinates harmonic --solver averaging-pyramid --resolution 64 --size 120 -o swept.png
cmp -s field.png swept.png && ok=no || ok=yes
report $ok "is another than ours"
refuses 'is not one of multigrid, averaging-pyramid' "$field" --cage "$cage" --vertex 8 --coordinates harmonic --solver direct -o out.png
works "a field as a surface" "$field" --cage "$cage" --vertex 8 --size 120 -o field.png --surface surface.png --turn 35 -100 0 --height 1
[ -s surface.png ] && ok=yes || ok=no
report $ok "the surface is there"
printf '0,0\n4,0\n4,3\n0,3\n' >rectangle.csv
works "a field of values" "$field" --cage rectangle.csv --values 1,2,3,2 --coordinates harmonic --resolution 32 --size 60 -o field.png --surface surface.png
refuses '--values: 3 values, but rectangle.csv has 4 vertices' "$field" --cage rectangle.csv --values 1,2,3 -o out.png
refuses '--values: not a number: "x"' "$field" --cage rectangle.csv --values 1,2,x,4 -o out.png
refuses 'give --vertex or --values to choose what to draw' "$field" --cage rectangle.csv -o out.png
refuses 'excludes' "$field" --cage rectangle.csv --vertex 1 --values 1,2,3,4 -o out.png
works "rays and Brownian paths" "$programs/paths" --cage "$data/biped_cage.svg" --point 150,540 --rays 1000 --paths 100 -o paths.svg --png
[ -s paths.png ] && ok=yes || ok=no
report $ok "the paths are drawn"
"$programs/paths" --cage rectangle.csv --point 1,1 --rays 10 --paths 10 --seed 7 -o paths.svg | grep -qx "seed 7" && ok=yes || ok=no
report $ok "the seed of the paths is printed"
refuses 'the point is not inside rectangle.csv' "$programs/paths" --cage rectangle.csv --point 7,1 -o out.svg
refuses 'the point is not inside rectangle.csv' "$programs/paths" --cage rectangle.csv --point 4,1 -o out.svg
refuses '--point: a coordinate is not finite' "$programs/paths" --cage rectangle.csv --point nan,1 -o out.svg
refuses '--point: 3 columns' "$programs/paths" --cage rectangle.csv --point 7,1,2 -o out.svg
refuses '--point: not a number' "$programs/paths" --cage rectangle.csv --point x,1 -o out.svg
refuses 'without chains and points inside' "$programs/paths" --cage "$data/cat_cage_head.csv" --point 300,300 -o out.svg
refuses 'cross' "$programs/paths" --cage bow_tie.svg --point 0,0 -o out.svg
refuses 'nowhere.svg' "$programs/paths" --cage nowhere.svg --point 0,0 -o out.svg
printf '0,0\n0,4\n4,4\n4,0\n' >square_4.csv
formula="$programs/boundary_formula"
works "a function on the boundary" "$formula" --cage square_4.csv --vertex 0 --at 1,0
for words in 'h_0(x, 0) = 1 - x/4, 0 <= x <= 4' 'x = 0, y = 4 t, 0 <= t <= 1:  h_0 = 1 - t' 'on all other edges it is 0' 'h_0(1, 0) = 0.75'; do
  grep -qF "$words" log && ok=yes || ok=no
  report $ok "the formula says: $words"
done
printf '1000000.25,0\n1000004.25,0\n1000004.25,4\n' >far.csv
works "a function far away" "$formula" --cage far.csv --vertex 1
grep -qF '= (x - 1000000.25)/4, 1000000.25 <= x <= 1000004.25' log && ok=yes || ok=no
report $ok "the formula has all digits"
works "a function of a chain" "$formula" --cage "$data/cat_cage_spine.csv" --vertex 26
refuses 'is not on the boundary, which is 1 away' "$formula" --cage square_4.csv --vertex 0 --at 1,1
refuses 'there is no vertex 4: square_4.csv has 4' "$formula" --cage square_4.csv --vertex 4
refuses '--at: 1 column' "$formula" --cage square_4.csv --vertex 0 --at 1
refuses 'cross' "$formula" --cage bow_tie.svg --vertex 0
refuses '"-1" is not a whole number from 0' "$formula" --cage square_4.csv --vertex -1
printf '0,0\n0,0\n1,1\n1,0\n' >twice.csv
refuses 'duplicate vertices (0, 1)' "$formula" --cage twice.csv --vertex 0
refuses 'nowhere.csv' "$formula" --cage nowhere.csv --vertex 0
works "the papers' grid" "$field" --cage "$cage" --vertex 8 --size 120 -o field.png --resolution 40 --classes classes.png
[ -s classes.png ] && ok=yes || ok=no
report $ok "the cells are drawn"
refuses 'the papers'"'"' grid needs a cage without chains and points inside' "$field" --cage "$data/cat_cage_spine.csv" --vertex 1 --coordinates harmonic -o field.png --classes out.png
works "the figure at rest under the posed one" "$deform" "$data/biped.svg" --cage "$data/biped_cage.svg" --pose "$data/biped_pose.svg" -o biped.svg --show-rest --png
grep -q '<image .*white-at-rest' biped.svg && ok=yes || ok=no
report $ok "--show-rest draws the figure at rest"
works "a part of a field by signs" "$field" --cage "$cage" --vertex 8 --size 120 -o field.png --zoom 100,100,300,200 --signs root --levels 0 --no-colour-bar
refuses 'is not a part of the plane' "$field" --cage "$cage" --vertex 8 -o out.png --zoom 1,2,0,5
refuses 'is not a part of the plane' "$field" --cage "$cage" --vertex 8 -o out.png --zoom here
refuses '--surface' "$field" --cage "$cage" --vertex 8 -o out.png --surface out.svg
refuses '--signs' "$field" --cage "$cage" --vertex 8 -o out.png --signs minus
works "a negative field" "$field" --cage "$data/biped_cage.svg" --vertex 2 --size 120 -o field.png
grep -q ': -0.3' log && ok=yes || ok=no
report $ok "mean value is negative in the biped's other leg"
works "a field of a chain" "$field" --cage "$data/cat_cage_spine.csv" --vertex 26 --coordinates harmonic --resolution 64 --size 120 -o field.png
refuses 'there is no vertex 29' "$field" --cage "$data/cat_cage_spine.csv" --vertex 29 --coordinates harmonic -o out.png
refuses 'interior cells not supported' "$field" --cage "$data/cat_cage_head.csv" --vertex 0 -o out.png
grid="$programs/adaptive_grid"
works "the grid of a cat" "$grid" --cage "$cage" --figure "$cat" --accuracy 0.01 -o grid.svg --png
grep -q 'cells inside the cage or on its boundary' log && [ -s grid.png ] && ok=yes || ok=no
report $ok "its cells are counted and drawn"
works "a part of it" "$grid" --cage "$data/cat_cage_spine.csv" --zoom 254,518,16,14 -o grid.svg
refuses 'no part of the grid is at --zoom' "$grid" --cage "$cage" --zoom 5000,0,1,1 -o out.svg
works "of a vertex inside" "$grid" --cage "$data/cat_cage_head.csv" -o grid.svg
refuses 'cross' "$grid" --cage bow_tie.svg -o out.svg
refuses '--accuracy' "$grid" --cage "$cage" --accuracy 1e-9 -o out.svg
refuses '--slice: ' "$grid" --cage "$cage" --slice z=1 -o out.svg
refuses '"z" is not a plane' "$grid" --cage box.obj --slice z -o out.svg
refuses 'the plane does not meet the cage' "$grid" --cage box.obj --slice x=7 -o out.svg
works "a slice" "$grid" --cage box.obj --figure inner.obj --accuracy 0.02 --slice y=0.5 -o grid.svg
refuses 'cells inside' "$programs/convergence" --cage "$data/cat_cage_head.csv" -o out.svg
refuses '--cage or --oracle is required' "$programs/convergence" -o out.svg
printf '{"cage": {"vertices": [[0, 0], [1, 0], [0, 1]], "loops": [[0, 1, 2]]}, "points": [[0.25, 0.25]], "coordinates": [[0.5, 0.25, 0.25]]}' >triangle.json
cp triangle.json "$(printf 'a < b & \377.json')"
works "errors of known weights, from a file with signs in its name" "$programs/convergence" --oracle "$(printf 'a < b & \377.json')" -o errors.svg --png
grep -q ', 32 cells: [0-9]* unknowns, 0.[0-9]* s, error ' log && grep -q ', accuracy 1e-03: ' log && ok=yes || ok=no
report $ok "they are said of both grids"
works "the distance of other types from known weights" "$programs/convergence" --oracle triangle.json --types
grep -qx 'triangle, barycentric: 0.000 from the oracle' log && grep -qx 'triangle, maximum-entropy: 0.000 from the oracle' log && ok=yes || ok=no
report $ok "all types are barycentric in a triangle"
refuses 'output is required' "$programs/convergence" --oracle triangle.json
sed 's/\[0.5, /[/' triangle.json >short.json
printf '0.2,0.2,0.2;0:x\n' >word.txt
cp box.obj cage.obj
refuses 'short.json: vertices and weights of a point differ in number' "$programs/convergence" --oracle short.json -o out.svg
refuses 'box.obj: ' "$programs/convergence" --oracle box.obj -o out.svg
refuses 'word.txt:1: not a line of an oracle' "$programs/convergence" --oracle word.txt -o out.svg
refuses 'there is no vertex 25' "$field" --cage "$cage" --vertex 25 -o out.png
refuses 'cross' "$field" --cage bow_tie.svg --vertex 0 -o out.png
works "the table" "$table" "$cat" "$cage" "$pose" mean-value,harmonic,green
grep -q '^cat  *green  *[0-9]*  *50 ' log && ok=yes || ok=no
report $ok "by Green coordinates edges are handles"
refuses 'vertex not convex (' "$table" "$cat" "$cage" "$pose" wachspress
refuses 'not one of' "$table" "$cat" "$cage" "$pose" magic
refuses 'arguments are FIGURE CAGE POSE' "$table" "$cat"
works "a table of all types, at a grid of points" "$table" --grid 40 "$data/biped.svg" "$data/biped_cage.svg" "$data/biped_pose.svg" all
awk '$2 == "mean-value" { least = $8; folds = $11 } $2 == "maximum-entropy" { entropy = $8; better = $11 } $2 == "harmonic" { itself = $10 }
  $2 == "barycentric" { extra = 1 } END { exit !(least < -0.2 && entropy == 0 && better > folds && itself == "0.000" && !extra) }' log && ok=yes || ok=no
report $ok "by mean value the biped has negative weights and is deformed more; types that its cage does not support are left out"
works "a sheet" "$programs/contact_sheet" -o sheet.svg "at rest" "$cat" "a step" cat.svg
works "a sheet of pictures" "$programs/contact_sheet" -o sheet.svg "a field" field.png "at rest" "$cat"
grep -q 'image/png;base64,iVBORw0KGgo' sheet.svg && ok=yes || ok=no
report $ok "a sheet holds the pictures"
cp "$cat" cat.png
refuses 'cat.png: is not a PNG file' "$programs/contact_sheet" -o out.svg caption cat.png
refuses 'nowhere.png: no such file' "$programs/contact_sheet" -o out.svg caption nowhere.png
works "a caption with signs" "$programs/contact_sheet" -o sheet.svg "a < b & c" "$cat"
grep -q 'a &lt; b &amp; c' sheet.svg && ok=yes || ok=no
report $ok "a caption is escaped"
for caption in 'bad\377' 'bad\033[7m' 'bad\001'; do
  # shellcheck disable=SC2059 # the caption is meant to be a format
  caption=$(printf "$caption")
  refuses 'the caption "bad\x' "$programs/contact_sheet" -o out.svg "$caption" "$cat"
  grep -q 'holds control characters, or is not UTF-8' log && ok=yes || ok=no
  report $ok "and why is said"
done
works "help of the table" "$table" --help
refuses 'outside the cage' "$table" "$cat" "$data/man_cage.svg" "$data/man_pose.svg" mean-value
refuses 'alternate' "$programs/contact_sheet" -o out.svg lonely
refuses 'nowhere.svg' "$programs/contact_sheet" -o out.svg caption nowhere.svg
works "a coordinate of a cage that is made" "$field" --cage auto:12 --figure "$cat" --vertex 11 -o field.png --size 64
refuses '--cage auto needs a --figure, around which it is made' "$field" --cage auto --vertex 1 -o out.png
refuses 'there is no vertex 12: the cage of cat.svg has 12' "$field" --cage auto:12 --figure "$cat" --vertex 12 -o out.png

# ---- fit_curve, bezier_tables ----
curve="$programs/fit_curve"
cases="$(dirname "$data")/../tests/data/bezier-cases.json"
works "help of fit_curve" "$curve" --help
works "the sup norm" "$curve" --css 0.25,0.1,0.25,1 --pieces 3 --norm sup
refuses "does not support conditions that couple pieces" "$curve" --css 0.25,0.1,0.25,1 --pieces 3 --norm sup --conditions end_value,knot_c0
works "help of the tables" "$programs/bezier_tables" --help
refuses 'please: no such file' "$programs/bezier_tables" please
works "a table of pieces" "$curve" --css 0.4,0,0.6,1 --pieces 2 --conditions end_value,knot_c0 --knots uniform
grep -Eq 'largest error 0.00218169 at time 0.(745764|254236); W12 error 0.026167 ' log && ok=yes || ok=no
report $ok "the errors are those of the case s01"
works "a plot and a JSON file" "$curve" --css 0.8,-0.3,0.2,1.3 --tolerance 0.001 --plot fit.svg --png --json fit.json
[ -s fit.svg ] && [ -s fit.png ] && [ -s fit.json ] && ok=yes || ok=no
report $ok "plot, picture and JSON are there"
for knots in uniform arcs optimal 0,0.3,0.7,1; do
  for degree in 3 4 5; do
    pieces='--pieces 3'
    [ $knots != 0,0.3,0.7,1 ] || pieces=
    # shellcheck disable=SC2086
    works "knots $knots, degree $degree" "$curve" --css 0.2,1.3,0.8,1.3 $pieces --knots $knots --degree $degree --conditions end_value,c0,c1
  done
done
for norm in w12 l2 1,0.01; do
  works "norm $norm" "$curve" --bezier 24,0,31,12,39,9,48,10 --pieces 3 --norm $norm --in-units --plot fit.svg
done
works "a vertical tangent" "$curve" --css 0,1,1,0 --tolerance 0.01 --json fit.json
grep -q '"w12_error": null' fit.json && ok=yes || ok=no
report $ok "an infinite error is null"
cp "$cases" "$(printf 'cases \377.json')"
works "cases whose file has a name that is no UTF-8" "$curve" --cases "$(printf 'cases \377.json')" --json results.json
grep -qF 'results of fit_curve for cases \\xff.json' results.json && ok=yes || ok=no
report $ok "the name is escaped"
works "the cases" "$curve" --cases "$cases" --json results.json
[ "$(grep -c '"result"' results.json)" = "$(grep -c '"expected"' "$cases")" ] && ok=yes || ok=no
report $ok "a result for every case"
for easing in linear ease ease-in ease-out ease-in-out 'cubic-bezier(0.8, -0.3, 0.2, 1.3)' ' EASE '; do
  works "the easing $easing" "$curve" --css "$easing" --pieces 2
done
works "an easing by its name" "$curve" --css ease-in-out --pieces 3 --json named.json
works "and by its numbers" "$curve" --css 0.42,0,0.58,1 --pieces 3 --json numbers.json
[ "$(sed 1,2d named.json)" = "$(sed 1,2d numbers.json)" ] && ok=yes || ok=no
report $ok "the name says the numbers"
refuses '"ease-inout" is not an easing: write linear, ease,' "$curve" --css ease-inout --pieces 3 --json out.json
refuses 'steps(4): holds and straight lines need no fit' "$curve" --css 'steps(4)' --pieces 3 --json out.json
refuses 'x1 and x2 lie between 0 and 1' "$curve" --css 'cubic-bezier(0, 0, 1.2, 1)' --pieces 3 --json out.json
refuses 'character 17 is not expected' "$curve" --css 'cubic-bezier(0, x, 1, 1)' --pieces 3 --json out.json
refuses '--css: "1e999" is not a finite number' "$curve" --css 0,1e999,1,1 --pieces 3 --json out.json
refuses '--css: a given value is not a finite number, or too large' "$curve" --css 0,1e308,1,1 --pieces 3 --json out.json
cat >ball.json <<'END'
{"layers": [{"nm": "ball", "ks": {
  "r": {"a": 1, "k": [{"t": 0, "s": [0], "o": {"x": [0.42], "y": [0]}, "i": {"x": [0.58], "y": [1]}},
                      {"t": 30, "s": [90], "h": 1}, {"t": 40, "s": [10]}]},
  "s": {"a": 1, "k": [{"t": 0, "s": [100, 100], "o": {"x": 0.3, "y": 0}, "i": {"x": [0.6, 0.6], "y": [1, 1.4]}},
                      {"t": 20, "s": [120, 80]}]},
  "p": {"a": 1, "k": [{"t": 0, "s": [0, 0], "to": [9, 0], "ti": [0, 0], "o": {"x": 0.3, "y": 0}, "i": {"x": 0.6, "y": 1}},
                      {"t": 20, "s": [50, 80]}]},
  "o": {"a": 0, "k": 100}}}]}
END
works "what a Lottie file has" "$curve" --lottie ball.json
{
  echo 'layers/0/ks/r/k/0:0  frames 0 to 30, 0 to 90  (ball)'
  echo 'layers/0/ks/r/k/1:0  frames 30 to 40, held at 90  (ball)'
  echo 'layers/0/ks/s/k/0:0  frames 0 to 20, 100 to 120  (ball)'
  echo 'layers/0/ks/s/k/0:1  frames 0 to 20, 100 to 80  (ball)'
  echo 'layers/0/ks/p/k/0:path  frames 0 to 20, 0 to 1  (ball)'
} >expected
cmp -s expected log && ok=yes || ok=no
report $ok "the list of its curves"
works "a curve of it" "$curve" --lottie ball.json --curve layers/0/ks/r/k/0:0 --pieces 3 --json lottie.json
works "the same curve by its handles" "$curve" --bezier 0,0,12.6,0,17.4,90,30,90 --pieces 3 --json bezier.json
[ "$(sed -n '/"knots_x"/,/\]/p' lottie.json)" = "$(sed -n '/"knots_x"/,/\]/p' bezier.json)" ] && ok=yes || ok=no
report $ok "is fitted as that"
refuses 'the value is held' "$curve" --lottie ball.json --curve layers/0/ks/r/k/1:0 --pieces 3 --json out.json
refuses 'there is no curve "layers"' "$curve" --lottie ball.json --curve layers --pieces 3 --json out.json
refuses '--lottie needs --curve' "$curve" --lottie ball.json --pieces 3 --json out.json
refuses '--curve needs --lottie' "$curve" --css ease --curve x --pieces 3 --json out.json
awk 'BEGIN { for (i = 0; i < 100000; ++i) printf "["; for (i = 0; i < 100000; ++i) printf "]" }' >deep.json
refuses 'deep.json: nested too deeply' "$curve" --lottie deep.json
refuses 'bad.json: no animated values' sh -c "echo '{}' >bad.json; '$curve' --lottie bad.json"
sed 's/"t": 30/"t": null/' ball.json >bad.json
refuses 'bad.json: invalid Lottie keyframe: type must be number, but is null' "$curve" --lottie bad.json
sed 's/120/1e999/' ball.json >bad.json
refuses "bad.json: number overflow parsing '1e999'" "$curve" --lottie bad.json
refuses 'given by one of' "$curve" --pieces 3 --json out.json
refuses 'given by one of' "$curve" --css 0,0,1,1 --bezier 0,0,0,0,1,1,1,1 --pieces 3 --json out.json
refuses '--css: 3 numbers' "$curve" --css 0,0,1 --pieces 3 --json out.json
refuses '--bezier: not a number: "x"' "$curve" --bezier 0,0,0,x,1,1,1,1 --pieces 3 --json out.json
refuses '--bezier: 9 numbers' "$curve" --bezier 0,0,0,0,1,1,1,1,1 --pieces 3 --json out.json
refuses '--css: "nan" is not a finite number' "$curve" --css 0,nan,1,1 --pieces 3 --json out.json
refuses '--css: time decreases somewhere' "$curve" --css 1.5,0,0,1 --pieces 3 --json out.json
refuses '--bezier: the second key is not later' "$curve" --bezier 1,0,0.5,0,0.5,1,0,1 --pieces 3 --json out.json
refuses 'the number of pieces' "$curve" --css 0.4,0,0.6,1 --json out.json
refuses 'the number of pieces' "$curve" --css 0.4,0,0.6,1 --pieces 3 --tolerance 0.1 --json out.json
refuses '--pieces' "$curve" --css 0.4,0,0.6,1 --pieces 0 --json out.json
refuses '--pieces' "$curve" --css 0.4,0,0.6,1 --pieces few --json out.json
refuses '--tolerance' "$curve" --css 0.4,0,0.6,1 --tolerance 0 --json out.json
refuses '--tolerance' "$curve" --css 0.4,0,0.6,1 --tolerance nan --json out.json
refuses 'cannot be met' "$curve" --css 0.85,0,0.15,1 --tolerance 1e-9 --json out.json
refuses 'unknown condition "smooth"' "$curve" --css 0.4,0,0.6,1 --pieces 3 --conditions end_value,smooth --json out.json
refuses 'unknown condition ""' "$curve" --css 0.4,0,0.6,1 --pieces 3 --conditions end_value, --json out.json
refuses 'too many conditions' "$curve" --css 0.4,0,0.6,1 --pieces 2 --conditions end_value,knot_value,end_d1,end_d2,knot_d1,knot_d2 --json out.json
refuses 'degree' "$curve" --css 0.4,0,0.6,1 --pieces 3 --degree 7 --json out.json
refuses 'weights' "$curve" --css 0.4,0,0.6,1 --pieces 3 --norm 0,1 --json out.json
refuses '--norm: not a number: "most"' "$curve" --css 0.4,0,0.6,1 --pieces 3 --norm most --json out.json
refuses '--knots: not a number: "even"' "$curve" --css 0.4,0,0.6,1 --knots even --json out.json
refuses '--knots: the knots do not ascend' "$curve" --css 0.4,0,0.6,1 --knots 0,0.7,0.3,1 --json out.json
refuses '--knots: knots begin at the first key' "$curve" --css 0.4,0,0.6,1 --knots 0.1,0.5,1 --json out.json
refuses 'slope' "$curve" --css 0,1,0.5,1 --pieces 3 --knots uniform --conditions end_value,knot_value,end_d1 --json out.json
refuses '--png needs --plot' "$curve" --css 0.4,0,0.6,1 --pieces 3 --png --json out.json
refuses 'missing/out.svg' "$curve" --css 0.4,0,0.6,1 --pieces 3 --json out.json --plot missing/out.svg
refuses 'missing/out.json' "$curve" --css 0.4,0,0.6,1 --pieces 3 --plot out.svg --json missing/out.json
refuses '--cases needs --json' "$curve" --cases "$cases"
refuses 'nowhere.json: no such file' "$curve" --cases nowhere.json --json out.json
refuses 'folder.csv: is a folder' "$curve" --cases folder.csv --json out.json
refuses 'empty.csv: is empty' "$curve" --cases empty.csv --json out.json
echo '{"format": "bezier-sobolev-cases/1", "cases": [' >bad.json
refuses 'bad.json: ' "$curve" --cases bad.json --json out.json
echo '[]' >bad.json
refuses 'bad.json: is not of the format' "$curve" --cases bad.json --json out.json
echo '{"format": "bezier-sobolev-cases/2", "cases": []}' >bad.json
refuses 'bad.json: is not of the format' "$curve" --cases bad.json --json out.json
faulty_case() { # MESSAGE SED-COMMAND   the cases, changed
  sed "$2" "$cases" >bad.json
  refuses "$1" "$curve" --cases bad.json --json out.json
}
faulty_case 'case s01-inout-two-pieces: unknown condition "end_valu"' '0,/"end_value"/s//"end_valu"/'
faulty_case 'case s01-inout-two-pieces: weights: null is not a number' '27s/1/null/'
faulty_case 'case s01-inout-two-pieces: unknown mode of knots "uniform"' '0,/"uniform_x"/s//"uniform"/'
faulty_case 'case s01-inout-two-pieces: control_points: time decreases somewhere' '0,/0\.4,/s//4,/'
faulty_case 'case s01-inout-two-pieces: pieces has to be a whole number' '0,/"pieces": 2/s//"pieces": 0/'
faulty_case 'case s01-inout-two-pieces: no fit: pieces are of degree' '0,/"degree": 3/s//"degree": 9/'
faulty_case 'case s04-linear-inner-exact: knots.x: the knots do not ascend' 's/^ *1\.25,/4,/'
faulty_case 'case number 1: ' '0,/"id"/s//"name"/'
faulty_case 'case s01-inout-two-pieces: ' '0,/"degree"/s//"grade"/'
faulty_case 'bad.json: ' '0,/0\.4,/s//NaN,/'

# ---- icons that nobody here drew, where they are installed (package tango-icon-theme) ----
icons=/usr/share/icons/Tango/scalable
if [ -d $icons ]; then
  printf '%s\n' -12,-12 24,-12 60,-12 60,24 60,60 24,60 -12,60 -12,24 >icon_cage.csv
  printf '%s\n' -12,-16 24,6 60,-12 52,24 66,60 24,50 -12,64 -20,24 >icon_pose.csv
  ids() { grep -oE ' id="[^"]*"' "$1" | sort; }
  elements() { grep -oE '<[a-zA-Z]+' "$1" | grep -cEv 'Gradient|stop'; } # shapes may get gradients of their own
  for icon in apps/internet-web-browser places/user-trash emotes/face-smile devices/camera-photo apps/system-users; do
    works "icon $icon" "$deform" $icons/$icon.svg --cage icon_cage.csv --pose icon_pose.csv --outside extend -o icon.svg
    ids $icons/$icon.svg >before
    ids icon.svg | comm -23 before - | grep -q . && ok=no || ok=yes
    report $ok "icon $icon keeps every id"
    [ "$(elements $icons/$icon.svg)" = "$(elements icon.svg)" ] && ok=yes || ok=no
    report $ok "icon $icon keeps every element"
    cmp -s $icons/$icon.svg icon.svg && ok=no || ok=yes
    report $ok "icon $icon is deformed"
  done
fi

# ---- points without a cage: sibson, sibson-c1 ----
row_is() { # WHAT STATE "w0 w1 …"   the first point's row in w.csv, to 1e-12; the reference values are those of tests/data/sibson
  sed -n 2p w.csv >log
  awk -F, -v state="$2" -v expected="$3" '{ n = split(expected, w, " ")
    bad = $1 != state || NF != n + 1
    for (i = 1; i <= n; ++i) { d = $(i + 1) - w[i]; if (d * d > 1e-24) bad = 1 } }
    END { exit bad || NR != 1 }' log && ok=yes || ok=no
  report $ok "$1"
}
printf '# a square\n0,0\n1,0\n\n1,1\n0,1\n0.5,0.5\n' >sites.csv
printf '0.25,0.375\n3,3\n' >point.csv
works "weights of sites" "$weights" --cage sites.csv --points point.csv --coordinates sibson -o w.csv --report
grep -q '^amplification (largest sum |w|): 1 at point 0$' log && ok=yes || ok=no
report $ok "degree 1 amplifies nothing"
row_is "Sibson's coordinates" inside "0.375 0.006521739130434782 0 0.13152173913043477 0.48695652173913045"
sed -n 3p w.csv >log
grep -q '^outside,nan,nan,nan,nan,nan$' log && ok=yes || ok=no
report $ok "no weights outside the hull"
works "weights of sites, smooth" "$weights" --cage sites.csv --points point.csv --coordinates sibson-c1 -o w.csv --report
grep -q '^amplification (largest sum |w|): 1.1357' log && ok=yes || ok=no
report $ok "the report has the amplification"
row_is "Farin's interpolant" inside "0.321624200792444 -0.014479358870304923 -0.05337579920755596 0.11052064112969508 0.6357103161557217"
works "weights of sites, single precision" "$weights" --cage sites.csv --points point.csv --coordinates sibson-c1 --scalar float -o w.csv
{ echo x,y,z; for x in 0 1; do for y in 0 1; do for z in 0 1; do echo $x,$y,$z; done; done; done; echo 0.5,0.5,0.5; } >sites_3d.csv
awk -F, 'NR > 1 { print "v", $1, $2, $3 }' sites_3d.csv >sites.obj
echo 0.625,0.5,0.4375 >point_3d.csv
for sites in sites_3d.csv sites.obj; do
  works "weights of $sites" "$weights" --cage $sites --points point_3d.csv --coordinates sibson-c1 -o w.csv
  row_is "Farin's interpolant, $sites" inside "-0.006034235353040686 -0.027254366194391165 -0.006034235353040686 -0.027254366194391165 0.06649563380560883 0.025215764646959314 0.06649563380560883 0.025215764646959314 0.8831544061897274"
done
# Convex polygons by a function of the distance: exact values of tests/data/oracle/family2d_kite.json; vertices named.
printf '0,0\n2,-1\n3,0\n2,1\n' >kite.csv
printf '2,0.5\n5,0\n' >kite_points.csv
works "weights by Wachspress" "$weights" --cage kite.csv --points kite_points.csv --coordinates wachspress --outside keep-in-place -o w.csv
row_is "Wachspress coordinates" inside "0.125 0.0625 0.25 0.5625"
works "discrete harmonic weights" "$weights" --cage kite.csv --points kite_points.csv --coordinates discrete-harmonic -o w.csv
row_is "discrete harmonic coordinates" inside "0.08333333333333333 0.125 0.16666666666666666 0.625"
sed -n 3p w.csv >log
grep -q '^outside,nan,nan,nan,nan$' log && ok=yes || ok=no
report $ok "no discrete harmonic weights outside the cage"
printf '0,0\n2,-1\n1,0\n2,1\n' >arrow.csv
refuses 'vertex not convex (2)' "$weights" --cage arrow.csv --points kite_points.csv --coordinates discrete-harmonic -o out.csv
printf '0,0\n4,0\n4,4\n0,4\n\n# point 0.5\n2,2\n' >cell.csv
refuses 'interior cells not supported (1)' "$weights" --cage cell.csv --points kite_points.csv --coordinates wachspress -o out.csv
# Green coordinates: vertices, then edges or faces (tests/data/oracle/green2d_unit_square.json, green3d_tetrahedron.json).
printf '0,0\n1,0\n1,1\n0,1\n' >green.csv
printf '0.25,0.75\n2,0.25\n' >green_points.csv
works "weights by Green" "$weights" --cage green.csv --points green_points.csv --coordinates green -o w.csv
row_is "Green coordinates" inside "0.210041913056813301 0.158265960489395451 0.210041913056813301 0.421650213396977937 0.0844784677307639 0.0844784677307639 0.2027863412769719 0.2027863412769719"
[ "$(sed -n 3p w.csv | cut -d, -f1)" = outside ] && ! grep -q nan w.csv && ok=yes || ok=no
report $ok "Green coordinates go on outside"
printf 'v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n' >green.obj
echo 0.25,0.5,0.25 >green_point.csv
works "weights by Green in space" "$weights" --cage green.obj --points green_point.csv --coordinates green -o w.csv
row_is "Green coordinates in space" inside "0.3913023332146537 0.15655371735261814 0.17218713831014207 0.27995681112258614 0.17984160580831229 0.11040741074782118 0.17556978173465604 0.16646440674593613"
refuses 'interior cells not supported (1)' "$weights" --cage cell.csv --points kite_points.csv --coordinates green -o out.csv
works "a Green field" "$field" --cage "$data/biped_cage.svg" --vertex 2 --coordinates green --size 64 -o field_green.png
refuses '--values: green coordinates do not interpolate' "$field" --cage green.csv --values 1,2,3,4 --coordinates green -o out.png
works "a cat by Green" "$deform" "$cat" --cage "$cage" --pose "$data/cat_pose_stretch.svg" --coordinates green -o cat_green.svg
works "a cat by Green at rest" "$deform" "$cat" --cage "$cage" --pose "$cage" --coordinates green --flatness 0.01 -o rest_green.svg
works "a cat by mean value at rest" "$deform" "$cat" --cage "$cage" --pose "$cage" --flatness 0.01 -o rest_mean.svg
cmp -s rest_green.svg rest_mean.svg && ! cmp -s rest_green.svg cat_green.svg && ok=yes || ok=no
report $ok "at rest every type leaves the cat as it is"
# Turned by a right angle and twice as large; then an edge and a face without size.
printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 8 8"><path d="M0.25 0.25L0.75 0.5L0.25 0.75Z"/></svg>' >green.svg
printf '5,1\n5,3\n3,3\n3,1\n' >green_pose.csv
works "a similarity by Green" "$deform" green.svg --cage green.csv --pose green_pose.csv --coordinates green -o turned.svg
grep -q 'M4.5 1.5 L4 2.5 L3.5 1.5 Z' turned.svg && ok=yes || { ok=no; cat turned.svg >>log; }
report $ok "Green coordinates take a similarity along"
printf '0,0\n1,0\n1,0\n0,1\n' >green_pose.csv
works "an edge without length" "$deform" green.svg --cage green.csv --pose green_pose.csv --coordinates green -o turned.svg
grep -q 'warning: green_pose.csv: 1 edge has no length, from vertex 1 to 2: its normal is undefined$' log && ok=yes || ok=no
report $ok "it is told of"
sed 's/^v 0 3 0/v 1 0 0/' green.obj >green_pose.obj
works "faces without area" "$mesh" green.obj --cage green.obj --pose green_pose.obj --coordinates green -o turned.obj
grep -q 'warning: green_pose.obj: 1 face has no area, v 1, v 3, v 2: its normal is undefined$' log && ok=yes || ok=no
report $ok "they are told of"
# The younger types in every program of the plane: a sound cage, cells inside, a vertex that is no number, a pose with one.
printf '0,0\n1,0\nnan,1\n0,1\n' >nan_cage.csv
printf '0,0\n1,0\n1,1\n0.4,0.4\n0,1\n' >dented.csv
printf '0,0\n4,0\n4,4\n0,4\n\n1,1\n1,2\n2,2\n2,1\n' >hole.csv
printf 'length,1\n\ncontrol,a corner\nvertices,2\ntime,x,y,turn,kind\n0,0,0,0,linear\n0.5,1,1,0,linear\n' >corner.csv
for type in wachspress discrete-harmonic green; do
  works "a row of $type" "$table" green.svg green.csv green.csv $type
  works "a motion by $type" "$animate" green.svg --cage green.csv --clip corner.csv --rate 4 --coordinates $type -o walk.svg
  works "a figure by $type" "$deform" green.svg --cage green.csv --pose green.csv --coordinates $type -o posed.svg
  works "a field of $type" "$field" --cage green.csv --vertex 1 --coordinates $type --size 32 -o field.png
  works "weights of $type" "$weights" --cage green.csv --points green_points.csv --coordinates $type --outside keep-in-place -o w.csv
  faults="cell interior cells not supported (1)
nan_cage vertex not finite (2)"
  [ $type = green ] || faults="$faults
dented vertex not convex (3)
hole vertex not convex (4)"
  while read -r faulty; do
    name=${faulty%% *} words=${faulty#* }
    refuses "$words" "$deform" green.svg --cage $name.csv --pose $name.csv --coordinates $type -o out.svg
    refuses "$words" "$field" --cage $name.csv --vertex 1 --coordinates $type -o out.png
    refuses "$words" "$weights" --cage $name.csv --points green_points.csv --coordinates $type -o out.csv
    refuses "$words" "$animate" green.svg --cage $name.csv --clip corner.csv --coordinates $type -o out.svg
    refuses "$words" "$table" green.svg $name.csv $name.csv $type
  done <<END
$faults
END
  refuses 'a number that is not finite' "$deform" green.svg --cage green.csv --pose nan_cage.csv --coordinates $type -o out.svg
  refuses 'a number that is not finite' "$table" green.svg green.csv nan_cage.csv $type
  refuses 'hole.csv: the pose has 2 blocks, the cage green.csv 1 block' "$table" green.svg green.csv hole.csv $type
done
refuses 'takes a cage in the plane' "$weights" --cage sites.obj --points point_3d.csv --coordinates wachspress -o out.csv
refuses 'wachspress not in {mean-value,harmonic' "$mesh" character.obj --cage character_cage.obj --pose character_cage.obj --coordinates wachspress -o out.obj
sed 's/^0.5,0.5$/0.3,0.4/' sites.csv >uneven.csv
works "weights of uneven sites" "$weights" --cage uneven.csv --points point.csv --coordinates sibson-c1 -o w.csv
for rule in gentle mirrored; do
  works "weights of sites, $rule" "$weights" --cage uneven.csv --points point.csv --coordinates sibson-c1 --gradients $rule -o w_$rule.csv
  cmp -s w.csv w_$rule.csv && ok=no || ok=yes
  report $ok "$rule is another rule"
done
refuses 'steep not in' "$weights" --cage sites.csv --points point.csv --coordinates sibson-c1 --gradients steep -o out.csv
printf '# two\n0,0\n1,0\n' >bad.csv
refuses 'bad.csv: holds too few points, 2: in the plane three are needed' "$weights" --cage bad.csv --points point.csv --coordinates sibson -o out.csv
printf 'x,y\n0,0\n1,0\n\n1,1\n1,0\n' >bad.csv
refuses 'line 3 and line 6' "$weights" --cage bad.csv --points point.csv --coordinates sibson -o out.csv
printf '0,0\n# a hole\n1,nan\n1,1\n' >bad.csv
refuses 'line 3' "$weights" --cage bad.csv --points point.csv --coordinates sibson -o out.csv
printf '0,0\n1,1\n2,2\n7,7\n' >bad.csv
refuses 'bad.csv: all sites lie in a plane (in 2D on a line)' "$weights" --cage bad.csv --points point.csv --coordinates sibson -o out.csv
printf '0,0\n1,0\n0,1e39\n' >bad.csv
refuses 'bad.csv: line 3: 1e+39 is beyond single precision' "$weights" --cage bad.csv --points point.csv --coordinates sibson --scalar float -o out.csv
printf '0,0\n1,0\n0,1,2\n' >bad.csv
refuses 'bad.csv:3: 3 columns' "$weights" --cage bad.csv --points point.csv --coordinates sibson -o out.csv
printf '# nothing\n' >bad.csv
refuses 'bad.csv: holds no points' "$weights" --cage bad.csv --points point.csv --coordinates sibson -o out.csv
: >bad.csv
refuses 'bad.csv' "$weights" --cage bad.csv --points point.csv --coordinates sibson -o out.csv
refuses 'sibson not in {mean-value,harmonic' "$field" --cage "$cage" --vertex 0 --coordinates sibson -o out.png
# circles of an SVG; what lies outside their hull stays, with a warning
circles() { printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><rect width="9" height="9"/><g transform="translate(1 1)"><circle r="1"/><circle id="b" cx="6" r="1"/><circle cx="6" cy="%s" r="2"/><circle cy="6" r="1"/></g></svg>' "$1"; }
circles 6 >circles.svg
circles 8 >circles_pose.svg
echo '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><path d="M7 7 L4 4 L1 1"/></svg>' >line.svg
for type in sibson sibson-c1; do
  works "deform by circles, $type" "$deform" line.svg --cage circles.svg --pose circles_pose.svg --coordinates $type -o circled.svg --show-cage
  [ ! -s log ] && grep -q 'd="M7 9' circled.svg && grep -q '<circle cx="7" cy="9" r="0.1' circled.svg && ok=yes || ok=no
  report $ok "the end of the line follows its circle, $type"
  works "the same at rest, $type" "$deform" line.svg --cage circles.svg --pose circles.svg --coordinates $type -o circled.svg
  cmp -s line.svg circled.svg && ok=yes || ok=no
  report $ok "at rest nothing has changed, $type"
done
echo '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><path d="M9 9 L8 8"/></svg>' >beyond.svg
works "outside the hull" "$deform" beyond.svg --cage circles.svg --pose circles_pose.svg --coordinates sibson -o circled.svg
[ "$(wc -l <log)" = 1 ] && grep -q 'lie outside the convex hull of circles.svg, first (9, 9).*; they stay in place, and the figure may tear there (--surround, --outside)' log && grep -q 'd="M9 9' circled.svg && ok=yes || ok=no
report $ok "what lies outside the hull stays, with one warning"
works "outside the hull, nearest" "$deform" beyond.svg --cage circles.svg --pose circles_pose.svg --coordinates sibson --outside nearest-boundary -o circled.svg
grep -q 'd="M9 11' circled.svg && ok=yes || ok=no
report $ok "or follows the nearest point of the hull"
refuses 'outside the convex hull' "$deform" beyond.svg --cage circles.svg --pose circles_pose.svg --coordinates sibson --outside refuse -o out.svg
refuses 'not defined outside' "$deform" beyond.svg --cage circles.svg --pose circles_pose.svg --coordinates sibson --outside extend -o out.svg
sed 's/<circle r="1"\/>//' circles.svg >bad.svg
refuses 'bad.svg: the pose has 3 points, circles.svg 4' "$deform" line.svg --cage circles.svg --pose bad.svg --coordinates sibson -o out.svg
refuses 'bow_tie.svg: holds no circles' "$deform" line.svg --cage bow_tie.svg --pose circles.svg --coordinates sibson -o out.svg
sed 's/cx="6" r/r/' circles.svg >bad.svg
refuses 'circle (line 1) and circle "b" (line 1)' "$deform" line.svg --cage bad.svg --pose bad.svg --coordinates sibson -o out.svg
sed 's/r="1"/r="1e-18"/g' circles.svg >tiny.svg # arcs shorter than a rounding
works "tiny circles" "$deform" line.svg --cage tiny.svg --pose circles_pose.svg --coordinates sibson -o tiny_out.svg
"$deform" line.svg --cage circles.svg --pose circles_pose.svg --coordinates sibson -o circled.svg && cmp -s circled.svg tiny_out.svg && ok=yes || ok=no
report $ok "a circle has its place, however small"
printf '0,0\n1,0\n1,1\n0,1\n0.5,inf\n' >bad.csv
refuses 'bad.csv: line 5: a number is not finite' "$deform" line.svg --cage sites.csv --pose bad.csv --coordinates sibson -o out.svg
# vertices of an OBJ
sed 's/0.5 0.5 0.5/0.5 0.5 0.75/' sites.obj >sites_pose.obj
printf 'v 0.5 0.5 0.5\nv 2 2 2\nv 0 0 1\nf 1 2 3\n' >figure.obj
for type in sibson sibson-c1; do
  works "deform by vertices, $type" "$mesh" figure.obj --cage sites.obj --pose sites_pose.obj --coordinates $type -o moved.obj --picture moved.png
  printf 'v 0.5 0.5 0.75\nv 2 2 2\nv 0 0 1\nf 1 2 3\n' | cmp -s - moved.obj && grep -q '1 of 3 vertices of figure.obj lie outside the convex hull of sites.obj, first v 2 (2, 2, 2); they stay in place' log && ok=yes || ok=no
  report $ok "a vertex at a site goes with it, one outside stays, $type"
done
printf 'v 0 0 0\nv 1 0 0\n' >bad.obj
refuses 'bad.obj: the pose has 2 points, sites.obj 9' "$mesh" figure.obj --cage sites.obj --pose bad.obj --coordinates sibson -o out.obj
refuses 'bad.obj: holds too few points, 2: in space four are needed' "$mesh" figure.obj --cage bad.obj --pose bad.obj --coordinates sibson -o out.obj
sed '5s/.*/v 0 1 1/' sites.obj >bad.obj
refuses 'v 4 and v 5' "$mesh" figure.obj --cage bad.obj --pose bad.obj --coordinates sibson -o out.obj
refuses 'sites.obj: holds no faces' "$mesh" figure.obj --cage sites.obj --pose sites.obj -o out.obj
echo '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><path d="M9 9 L7 7"/></svg>' >half_out.svg
works "surrounded in the plane" "$deform" half_out.svg --cage circles.svg --pose circles_pose.svg --coordinates sibson --surround 0.25 -o circled.svg
! grep -q 'outside' log && ! grep -q 'd="M9 9' circled.svg && grep -q '7 9"' circled.svg && ok=yes || ok=no
report $ok "with points around all nothing is outside, and a site still has its figure point"
works "surrounded in space" "$mesh" figure.obj --cage sites.obj --pose sites_pose.obj --coordinates sibson --surround 0.1 -o moved.obj --picture moved.png --report
! grep -q 'outside the convex hull' log && grep -q '^control points: 17$' log && ! grep -q 'triangles' log && ok=yes || ok=no
report $ok "the report has points, not triangles"
printf 'v 0.3 0.3 0.3\nv 0.4 0.3 0.3\nv 0.3 0.4 0.3\nf 1 2 3\n' >still.obj
seq 9 | sed 's/.*/2/' >even_weights.txt
works "even weights" "$mesh" still.obj --cage sites.obj --pose sites_pose.obj --coordinates sibson --weights even_weights.txt -o even.obj
"$mesh" still.obj --cage sites.obj --pose sites_pose.obj --coordinates sibson -o moved.obj && cmp -s even.obj moved.obj && ok=yes || ok=no
report $ok "even weights change nothing"
{ echo '# the last'; seq 8 | sed 's/.*/1/'; echo 3; } >weights.txt
works "weights in space" "$mesh" still.obj --cage sites.obj --pose sites.obj --coordinates sibson --weights weights.txt --surround 0.1 -o heavy.obj
cmp -s still.obj heavy.obj && ok=no || ok=yes
report $ok "a heavy point draws the figure to it"
printf '1\n1\n3\n1\n' >weights.txt
works "weights in the plane" "$deform" line.svg --cage circles.svg --pose circles.svg --coordinates sibson --weights weights.txt -o heavy.svg
cmp -s line.svg heavy.svg && ok=no || ok=yes
report $ok "a heavy circle draws the figure to it"
for weight in 0 -1 nan inf word; do
  printf '1\n1\n%s\n1\n' $weight >bad.txt
  refuses 'bad.txt:3: ' "$deform" line.svg --cage circles.svg --pose circles.svg --coordinates sibson --weights bad.txt -o out.svg
done
printf '1\n1\n' >bad.txt
refuses 'bad.txt: holds 2 weights where there are 4 points' "$deform" line.svg --cage circles.svg --pose circles.svg --coordinates sibson --weights bad.txt -o out.svg
refuses 'bad.txt: holds 2 weights where there are 9 points' "$mesh" still.obj --cage sites.obj --pose sites.obj --coordinates sibson --weights bad.txt -o out.obj
: >bad.txt
refuses 'bad.txt: holds 0 weights' "$deform" line.svg --cage circles.svg --pose circles.svg --coordinates sibson --weights bad.txt -o out.svg
refuses 'no_such_file' "$deform" line.svg --cage circles.svg --pose circles.svg --coordinates sibson --weights no_such_file -o out.svg
refuses 'sibson-c1 has negative weights' "$deform" line.svg --cage circles.svg --pose circles.svg --coordinates sibson-c1 --weights weights.txt -o out.svg
refuses 'points without a cage' "$deform" line.svg --cage "$cage" --pose "$cage" --surround 1 -o out.svg
refuses '--surround' "$mesh" still.obj --cage sites.obj --pose sites.obj --coordinates sibson --surround -1 -o out.obj
sed 's/cx="6" cy="6" r="2"/cx="6" cy="6" r="0"/' circles.svg >bad.svg
refuses 'bad.svg: circle (line 1): has no radius above 0' "$deform" line.svg --cage bad.svg --pose bad.svg --coordinates sibson -o out.svg
# ---- a hand ----
works "a hand" "$programs/make_hand" folder/hand
grep -q 'hand_poses.csv: 7 poses$' log && ok=yes || ok=no
report $ok "the hand has seven poses"
refuses 'cannot make the folder' "$programs/make_hand" square.csv
refuses 'cannot make the folder' "$programs/hand_sheet" square.csv
works "the hand posed by a file" "$programs/pose_hand" --pose folder/hand/hand_poses.csv --picture hand.png
: >empty_poses.csv
refuses 'empty_poses.csv: holds no pose' "$programs/pose_hand" --pose empty_poses.csv --picture out.png
echo '1,2,3' >short_pose.csv
refuses 'short_pose.csv:1: 3 numbers where a pose has 22' "$programs/pose_hand" --pose short_pose.csv --picture out.png
echo '0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,nan' >nan_pose.csv
refuses 'nan_pose.csv:1: thumb_ip' "$programs/pose_hand" --pose nan_pose.csv --picture out.png
echo '0,95,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0' >far_pose.csv
refuses 'index_mcp is 95, but its range is from -20 to 90' "$programs/pose_hand" --pose far_pose.csv --picture out.png
refuses 'no_such_file' "$programs/pose_hand" --pose no_such_file --picture out.png
echo '0,30,60,,0,30,60,,0,30,60,,0,30,60,,0,0,0,0,0,0' >tendons.csv
echo '0,30,60,40,0,30,60,40,0,30,60,40,0,30,60,40,0,0,0,0,0,0' >joints.csv
works "a pose without its last joints" "$programs/pose_hand" --pose tendons.csv -o tendons.obj
works "the same pose with them" "$programs/pose_hand" --pose joints.csv -o joints.obj
works "the last joint follows by two thirds" cmp tendons.obj joints.obj
works "the hand as an OBJ file" "$programs/pose_hand" --pose rest -o hand_rest.obj
grep '^v' hand_rest.obj >rest && grep '^v' folder/hand/hand.obj | cmp -s - rest && ok=yes || ok=no
report $ok "at rest the hand is what make_hand writes"
refuses 'hand_poses.csv: holds 7 poses, but an OBJ file has one' "$programs/pose_hand" --pose folder/hand/hand_poses.csv -o out.obj
refuses 'give --picture or --output to choose what to write' "$programs/pose_hand" --pose fist
refuses '"out.jpg" does not end with .png' "$programs/pose_hand" --pose fist --picture out.jpg
refuses '--pose is required' "$programs/pose_hand" --picture out.png
refuses '--kappa' "$programs/pose_hand" --pose fist --kappa nan --picture out.png
refuses '--kappa' "$programs/pose_hand" --pose fist --kappa -1 --picture out.png
refuses 'missing/out.png' "$programs/pose_hand" --pose fist --picture missing/out.png
echo '0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,bent,0,0,0,0' >word_pose.csv
refuses 'word_pose.csv:1: ' "$programs/pose_hand" --pose word_pose.csv --picture out.png
for program in make_hand hand_sheet; do
  refuses 'folder is required' "$programs/$program"
  refuses 'spare' "$programs/$program" folder/hand spare
done

# ---- what all programs have ----
mkdir -p no_files
version=$(sed -n 's/.*VERSION_STRING "\(.*\)"/\1/p' "$(dirname "$data")/../include/cageform/version.hpp")
for program in adaptive_grid animate_svg bezier_tables bind_mesh bind_tiles boundary_formula cage_weights clone_figure clone_image \
  contact_sheet convergence coordinate_field deform_mesh deform_splats deform_svg diffuse_colours draw_splats \
  electron_waves export_gltf figure_table fit_curve fit_skeleton grid_field hand_sheet height_map lattice_board lattice_fit \
  leaf_cages make_box make_cage make_character make_hand make_splats make_tiles paths pin_poses plane_homotopy \
  pose_cage pose_hand puzzle relaxation skin_mesh sphere_eversion zooms; do
  works "version of $program" "$programs/$program" --version
  [ "$(cat log)" = "$program (cageform) $version" ] && ok=yes || ok=no
  report $ok "$program tells its version"
  works "short help of $program" "$programs/$program" --help
  short=$(wc -l <log)
  grep -q "^  $program " log && ok=yes || ok=no
  report $ok "the help of $program has examples"
  # In a folder without files every example fails for want of its file, not for its words.
  grep "^  $program " log | sed 's/^ *[a-z_]* //' >shown_words
  while read -r words; do
    case $program in clone_image | fit_curve | make_box | make_character | make_hand | hand_sheet | pose_hand | lattice_board | electron_waves | plane_homotopy | sphere_eversion | zooms) continue ;; esac # which need none
    (cd no_files && eval "'$programs/$program' $words") >log 2>&1 </dev/null && ok=no || ok=yes
    grep -q 'no such file' log || ok=no
    report $ok "the help of $program shows $words"
  done <shown_words
  works "help of $program" "$programs/$program" --help-all
  [ "$(wc -l <log)" -ge "$short" ] && ok=yes || ok=no
  report $ok "--help-all of $program tells more"
  grep -q 'support/\|\.hpp' log && ok=no || ok=yes
  report $ok "the help of $program names no source file"
  if [ "$program" != pose_cage ] && grep -q -- '--coordinates' log; then # which has no default
    grep -q -- '--coordinates .*[=[]mean-value' log && grep -q -- '--resolution .*128 in the plane, 64 in space' log &&
      grep -q -- '--tolerance .*[=[]1e-06' log && ok=yes || ok=no
    report $ok "the defaults of $program are those of all"
  fi
  case $program in make_cage | make_box) continue ;; esac # which take none
  if grep -q -- '--cage' log; then
    grep -q 'A cage in the plane is the first closed polygon\|A cage is a closed mesh' log && ok=yes || ok=no
    report $ok "the help of $program says how a cage looks"
  fi
done
refuses '"out.png" does not end with .svg' "$deform" "$cat" --cage "$cage" --pose "$pose" -o out.png
refuses '"out" does not end with .svg' "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" -o out
refuses '"out.svg" does not end with .png' "$field" --cage "$cage" --vertex 8 -o out.svg
refuses '-o out.ply: the figure figure.obj is written as .obj' "$mesh" figure.obj --cage box.obj --pose box.obj -o out.ply
refuses '"out.jpg" does not end with .png' "$mesh" figure.obj --cage box.obj --pose box.obj -o out.obj --picture out.jpg
refuses '"out.txt" does not end with .csv' "$weights" --cage square.csv --points middle.csv -o out.txt
refuses '"out.bin" does not end with .figure' "$bind" character.obj --cage character_cage.obj -o out.bin
refuses '"out.png" does not end with .svg' "$curve" --css 0,0,1,1 --pieces 2 --plot out.png
works "an ending in capitals" "$deform" "$cat" --cage "$cage" --pose "$pose" -o CAT.SVG
works "an ending in some capitals" "$animate" "$cat" --cage "$cage" --move 3:9,0 --rate 2 -o WAVE.Svg
grep -q "<animate " WAVE.Svg && ok=yes || ok=no
report $ok "is an SVG that plays"

# ---- animate_svg ----
works "a cat that walks and keeps angles" "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --rate 6 --coordinates green -o walk.svg
works "a cat that walks" "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --rate 12 -o walk.svg --stills still_ --still-count 2
[ "$(grep -c '<animate ' walk.svg)" -ge 1 ] && [ -s still_01.svg ] && [ -s still_02.svg ] && ok=yes || ok=no
report $ok "the walk and two stills are there"
grep -q 'gradientTransform="matrix' still_02.svg && ok=yes || ok=no
report $ok "gradients follow in stills"
sed 's|</svg>|<path d="M -900 0 L -800 0 L -800 50 Z"/></svg>|' "$cat" >stray.svg
for type in mean-value harmonic; do
  works "a stray shape, $type" "$animate" stray.svg --cage "$cage" --clip "$data/cat_walk.csv" --rate 4 --coordinates $type -o walk.svg
  grep -q 'warning: .* points of stray.svg lie outside the cage .*, first (-900, 0), .* they follow' log && ok=yes || ok=no
  report $ok "points outside are named, $type"
done
refuses 'stray.svg lie outside the cage' "$animate" stray.svg --cage "$cage" --clip "$data/cat_walk.csv" --outside refuse -o out.svg
works "a cat that walks and what is far stays" "$animate" stray.svg --cage "$cage" --clip "$data/cat_walk.csv" --rate 6 --falloff 200 -o walk.svg
grep -q '<path d="M -900 0 L -800 0 L -800 50 Z"/>' walk.svg && ok=yes || ok=no
report $ok "its path is not animated"
refuses '--falloff: with --outside keep-in-place' "$animate" stray.svg --cage "$cage" --clip "$data/cat_walk.csv" --outside keep-in-place --falloff 200 -o out.svg
refuses 'not defined outside' "$animate" stray.svg --cage "$cage" --clip "$data/cat_walk.csv" --coordinates harmonic --outside extend -o out.svg
refuses 'the same file as ' "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --rate 4 -o out.01.svg --stills out. --still-count 1

# Films, by a stand-in for ffmpeg that writes down what it is given: its last word is the file.
mkdir -p stand_in none films
cat >stand_in/ffmpeg <<'END'
#!/bin/sh
for word in "$@"; do out=${word#file:}; done
printf '%s\n' "$*" >words
cat >"$out"
END
chmod +x stand_in/ffmpeg
cp stand_in/ffmpeg films/ffmpeg
for kind in gif apng mp4; do
  works "a $kind" env PATH="$work/stand_in:$PATH" "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --rate 2 --width 64 -o walk.svg --$kind "a \$(touch stray) film.$kind"
  [ "$(tr -d '\0' <"a \$(touch stray) film.$kind" | grep -ac 'IHDR')" = 5 ] && [ ! -e stray ] && grep -q -- "-framerate 2.08333 .* -f $kind file:" words && ok=yes || ok=no
  report $ok "its five frames are pictures, and its name is no command"
done 2>/dev/null
ln -s "$(command -v rsvg-convert)" none/rsvg-convert
refuses 'ffmpeg (ffmpeg) is not installed' env PATH="$work/none" "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --rate 2 -o out.svg --gif out.gif
rm none/rsvg-convert
ln -s "$work/stand_in/ffmpeg" none/ffmpeg
refuses 'rsvg-convert (librsvg2-bin) is not installed' env PATH="$work/none" "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --rate 2 -o out.svg --gif out.gif
works "a film of waves" env PATH="$work/stand_in:$PATH" "$programs/electron_waves" --size 64x48 --mesh 0.2 --steps 6 --frames 3 --gif waves.gif
[ "$(tr -d '\0' <waves.gif | grep -ac 'IHDR')" = 4 ] && ok=yes || ok=no
report $ok "has four frames"
printf '#!/bin/sh\nexit 1\n' >stand_in/ffmpeg
refuses 'cannot write out.gif: ' env PATH="$work/stand_in:$PATH" "$programs/electron_waves" --size 64x48 --mesh 0.2 --steps 6 --gif out.gif --csv out.csv
refuses 'cannot write out.mp4: ' env PATH="$work/stand_in:$PATH" "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --rate 2 -o out.svg --mp4 out.mp4
refuses '"out.avi" does not end with .mp4' "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" -o out.svg --mp4 out.avi
clip() { # LENGTH TIMES…   a control whose keys have these times
  echo "length,$1"; shift
  echo 'control,a'; echo 'vertices,0'
  for time in "$@"; do echo "$time,0,0,0,linear"; done
}
clip 1e9 0 1 >many.csv
refuses 'many.csv: "a": repeated over the clip it has 1e+09 keys' "$animate" "$cat" --cage "$cage" --clip many.csv -o out.svg
clip 1e300 0 1e-300 >many.csv
refuses 'many.csv: "a": the length of the clip is not a multiple of the duration of these keys' "$animate" "$cat" --cage "$cage" --clip many.csv -o out.svg
clip 1 1e9 1000000001 >many.csv
refuses 'many.csv: "a": its first key, at 1e+09, is more than a million of its periods' "$animate" "$cat" --cage "$cage" --clip many.csv -o out.svg
clip 1e9 0 1e9 >many.csv
refuses 'many.csv: its length needs 6e+10 frames' "$animate" "$cat" --cage "$cage" --clip many.csv -o out.svg
clip 1 0 1 | sed '1aground,1,1e-300' >many.csv
refuses 'many.csv: during the clip the ground moves by 1e-300 units' "$animate" "$cat" --cage "$cage" --clip many.csv -o out.svg
clip 1 0 0.25 0.5 1 | sed 's/^0.25,0/0.25,1e308/; s/linear/automatic/' >many.csv
refuses 'many.csv: "a": the key at 0: a given value' "$animate" "$cat" --cage "$cage" --clip many.csv -o out.svg

works "a first look, from the figure alone" "$animate" "$cat" --cage auto -o first.svg
[ "$(grep -c '<animate ' first.svg)" -gt 5 ] && ok=yes || ok=no
report $ok "it moves"
works "to a pose and back" "$animate" "$cat" --cage "$cage" --turn 7-11:-25@v6,12 --seconds 1 --rate 10 -o there.svg --stills there_ --still-count 2
works "the pose as a file" "$pose_cage" "$cage" --turn 7-11:-25@v6,12 -o turned.svg
works "says the same" "$animate" "$cat" --cage "$cage" --pose turned.svg --seconds 1 --rate 10 -o there_by_file.svg --stills file_ --still-count 2
cmp -s there.svg there_by_file.svg && ! cmp -s there_01.svg there_02.svg && ok=yes || ok=no
report $ok "half the time takes the figure there"
refuses 'give --clip or operations such as --turn, but not both' "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --turn 1:1 -o out.svg
refuses '--clip excludes --pose' "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --pose "$pose" -o out.svg
refuses 'give --pose or operations such as --turn, but not both' "$animate" "$cat" --cage "$cage" --pose "$pose" --turn 1:1 -o out.svg
refuses '--pose is required, or operations such as --turn' "$animate" "$cat" --cage "$cage" -o out.svg
refuses '--turn "99:1": there is no vertex 99' "$animate" "$cat" --cage auto --turn 99:1 -o out.svg
for program in "$deform" "$animate"; do
  works "a pose whose cage crosses itself" "$program" "$cat" --cage "$cage" --move 0:500,0 -o out.svg
  grep -q 'warning: .*: in the posed cage edges cross or touch (.*: the figure may fold over itself there' log && ok=yes || ok=no
  report $ok "is drawn, and the crossing is named"
done
works "a film alone" env PATH="$work/films:$PATH" "$animate" "$cat" --cage auto --seconds 0.2 --width 64 -o alone.gif
[ "$(tr -d '\0' <alone.gif | grep -ac 'IHDR')" = 5 ] && grep -q -- '-framerate 25 .* -f gif' words && ok=yes || ok=no
report $ok "has 25 frames a second"
printf '<svg viewBox="0 0 100 100"><text x="40" y="50" font-size="9">here</text><image x="40" y="60" width="9" height="9" href="data:,"/><path d="M40 60h20v9z"/></svg>' >carried.svg
works "a text and an image in motion" "$animate" carried.svg --cage box --move all:30,0 --rate 4 -o carried_walk.svg --stills carried_ --still-count 2
[ "$(grep -c '<animateTransform attributeName="transform" type="translate"' carried_walk.svg)" -ge 1 ] && ok=yes || ok=no
grep -q '<text [^>]*transform="matrix(1 0 0 1 30 0)"' carried_02.svg && grep -q '<image [^>]*transform="matrix(1 0 0 1 30 0)"' carried_02.svg || ok=no
report $ok "both follow"
works "a cat that walks in few bytes" "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --size-limit 60000 -o walk.svg
within=$(sed -n 's/.* key frames of attributes, within \(.*\) units$/\1/p' log)
[ "$(wc -c <walk.svg)" -le 60000 ] && awk "BEGIN { exit !($within > 0.3) }" && ok=yes || ok=no
report $ok "they fit, and the distance that this takes is told"
works "without a limit" "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --flatness 0.3 -o walk.svg
grep -q 'within 0.3 units' log && [ "$(wc -c <walk.svg)" -gt 60000 ] && ok=yes || ok=no
report $ok "there are more"
refuses 'units, more than --size-limit 500' "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --size-limit 500 -o out.svg
refuses '--size-limit is for SVG files' "$animate" "$cat" --cage "$cage" --clip "$data/cat_walk.csv" --size-limit 500 -o out.gif
works "a motion out of the picture" "$animate" carried.svg --cage box --move all:90,0 --rate 4 -o wide.svg --fit
grep -q 'viewBox="-[0-9.]* -[0-9.]* 150[.0-9]* ' wide.svg && ok=yes || ok=no
report $ok "--fit grows it to all frames"
refuses 'does this cage belong to another figure' "$deform" "$data/biped.svg" --cage "$data/hexagon_cage.svg" --move 0:1,1 -o out.svg
gzip -c "$cat" >packed.svgz
works "a packed figure" "$deform" packed.svgz --cage "$cage" --pose "$pose" -o packed_out.svg
works "the figure itself" "$deform" "$cat" --cage "$cage" --pose "$pose" -o unpacked_out.svg
cmp -s packed_out.svg unpacked_out.svg && ok=yes || ok=no
report $ok "they are one"
head -c 300 packed.svgz >broken.svgz
refuses 'broken.svgz: a damaged gzip file' "$deform" broken.svgz --cage "$cage" --pose "$pose" -o out.svg
head -c 300000000 /dev/zero | gzip -c >bomb.svgz
refuses 'bomb.svgz: is larger than 256 MiB when unpacked' "$deform" bomb.svgz --cage auto -o out.svg
refuses "is a share of the figure's diagonal: 5% or, as a number, 0.05?" "$make_cage" "$cat" --margin 5 -o out.svg
hostile large '<path d="M 0,0 L 1e12,0 L 0,1e12 z"/>'
works "a figure of 1e12 units" "$animate" large.svg --cage auto -o large_look.svg
refuses '--seconds' "$animate" "$cat" --cage "$cage" --seconds 0 --move 0:5,0 -o out.svg

# ---- outputs: all or none, none twice, nothing left behind ----
cp figure.obj kept.obj
ln -s ../kept.obj folder/link.png
refuses 'cannot write folder/link.png: it is the same file as ./kept.obj' \
  "$mesh" figure.obj --cage box.obj --pose box_pose.obj -o ./kept.obj --picture folder/link.png
cmp -s figure.obj kept.obj && ok=yes || ok=no
report $ok "neither of two outputs of one name is written"
echo precious >kept.svg
mkdir -p kept.png no_programs
refuses 'cannot write kept.png: it is not a regular file' "$deform" "$cat" --cage "$cage" --pose "$pose" -o kept.svg --png
rmdir kept.png
refuses 'cannot write kept.png: rsvg-convert (librsvg2-bin) is not installed' \
  env PATH=no_programs "$deform" "$cat" --cage "$cage" --pose "$pose" -o kept.svg --png
grep -q precious kept.svg && [ ! -e kept.png ] && ok=yes || ok=no
report $ok "the old SVG stays where the picture fails"
works "a picture" "$deform" "$cat" --cage "$cage" --pose "$pose" -o kept.svg --png --png-width 120
[ "$(head -c 4 kept.png | tail -c 3)" = PNG ] && ! grep -q precious kept.svg && ok=yes || ok=no
report $ok "SVG and picture are there"
if [ -e /dev/full ]; then
  "$deform" "$cat" --cage "$cage" --pose "$pose" -o kept.svg --report >/dev/full 2>log && ok=no || ok=yes
  grep -q 'cannot write to standard output' log || ok=no
  report $ok "a report that cannot be written is a failure"
fi
refuses 'File too large' sh -c "ulimit -f 1; '$mesh' character.obj --cage character_cage.obj --pose character_pose.obj -o out.obj"
mkfifo pipe.csv
for signal in INT TERM HUP PIPE; do # while it waits for more points
  # In a shell that puts programs behind it, INT is ignored: env sets it as it is otherwise.
  env --default-signal=$signal "$weights" --cage square.csv --points pipe.csv -o out.csv >log 2>&1 &
  program=$!
  exec 9>pipe.csv
  echo 1,1 >&9
  tries=0
  until ls out.csv.tmp* >/dev/null 2>&1 || [ $tries -eq 100 ]; do sleep 0.1; tries=$((tries + 1)); done
  [ $tries -lt 100 ] && ok=yes || ok=no
  kill -$signal $program
  wait $program && ok=no
  exec 9>&-
  [ -z "$(find . -name '*.tmp*')" ] && [ ! -e out.csv ] || ok=no
  report $ok "nothing is left behind after SIG$signal"
done

# ---- a read that fails midway is no end of the file ----
broken() { # FILE BYTES COMMAND…   the file, in this folder, cannot be read beyond so many bytes
  file=$1; bytes=$2; shift 2
  refuses "$file: cannot be read: Input/output error" env LD_PRELOAD="$failing_read" FAILING_FILE="/$file" FAILING_AFTER="$bytes" "$@"
}
cp "$cat" "$cage" "$pose" "$data/cat_walk.csv" "$cases" folder/character/character_clip.csv .
awk 'BEGIN { for (i = 0; i < 20000; ++i) print 0.1 + i / 10000 "," 1.5 }' >many.csv
broken many.csv 100000 "$weights" --cage square.csv --points many.csv -o out.csv
broken middle.csv 4 "$weights" --cage square.csv --points middle.csv -o out.csv
broken split.csv 24 "$weights" --cage split.csv --points middle.csv -o out.csv
for bytes in 0 200; do
  broken cat.svg $bytes "$deform" cat.svg --cage cat_cage.svg --pose cat_pose_step.svg -o out.svg
  broken cat_cage.svg $bytes "$deform" cat.svg --cage cat_cage.svg --pose cat_pose_step.svg -o out.svg
  broken cat_pose_step.svg $bytes "$deform" cat.svg --cage cat_cage.svg --pose cat_pose_step.svg -o out.svg
  broken cat_walk.csv $bytes "$animate" cat.svg --cage cat_cage.svg --clip cat_walk.csv -o out.svg
  broken character_clip.csv $bytes "$bind" character.obj --cage character_cage.obj --clip character_clip.csv -o out.figure
  broken character.txt $bytes "$bind" character.obj --cage character_cage.obj --labels character.txt -o out.figure
  broken character.obj $bytes "$mesh" character.obj --cage character_cage.obj --pose character_pose.obj -o out.obj
  broken character_cage.obj $bytes "$mesh" character.obj --cage character_cage.obj --pose character_pose.obj -o out.obj
  broken bezier-cases.json $bytes "$curve" --cases bezier-cases.json --json out.json
  broken field.png $bytes "$programs/contact_sheet" -o out.svg caption field.png
done
mkdir -p folder.svg folder.png
refuses 'folder.csv: is a folder' "$animate" cat.svg --cage cat_cage.svg --clip folder.csv -o out.svg
refuses 'folder.csv: is a folder' "$bind" character.obj --cage character_cage.obj --clip folder.csv -o out.figure
refuses 'folder.svg: is a folder' "$deform" folder.svg --cage cat_cage.svg --pose cat_pose_step.svg -o out.svg
refuses 'folder.png: is a folder' "$programs/contact_sheet" -o out.svg caption folder.png
printf '2,2\n' >locked.csv
chmod 0 locked.csv
[ -r locked.csv ] || # a superuser reads it
  refuses 'locked.csv: cannot be opened: Permission denied' "$weights" --cage square.csv --points locked.csv -o out.csv

# ---- poses in rows ----
. "$here/clone_figure.sh"

. "$here/films.sh"

# ---- skeletons ----
. "$here/skeletons.sh"

# ---- wraps ----
. "$here/wrap_mesh.sh"

# ---- what holds of all files ----
. "$here/files.sh"
# ---- tiles of points ----
. "$here/tiles.sh"

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
