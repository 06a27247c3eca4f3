#!/bin/sh
# Usage: sh examples/run.sh [cat | --build-only]
# Installs what the examples need (Debian), builds them into build/examples/, runs them and writes pictures into out/.
# The figures are a cat at rest and in every pose, a man, an aleph, a fish moved by points, a character in space. Other
# pictures are heat maps of coordinates, the convergence of the solver, its grid, and key-frame curves.
# The text output of programs goes to out/*.txt, such as tables of figures and of fits of key-frame curves.
# The cat is drawn first, as soon as the two programs for it are built. Prints one line per step.
#   cat           ends when the cat is drawn, as out/cat.png
#   --build-only  builds all programs and draws nothing
set -eu
cd "$(dirname "$0")/.."
sh cmake/install_packages.sh g++ cmake ninja-build libeigen3-dev libpugixml-dev zlib1g-dev libstb-dev libcli11-dev libtinyobjloader-dev nlohmann-json3-dev libgmp-dev libdraco-dev libmeshoptimizer-dev librsvg2-bin

mode=${1:-}
case $mode in
  '' | cat | --build-only) ;;
  *)
    echo "examples/run.sh: unknown option $mode; usage: sh examples/run.sh [cat | --build-only]" >&2
    exit 2
    ;;
esac
start=$(date +%s)
step() { # WHAT
  count=$((${count:-0} + 1))
  printf '[%d/%d] %s\n' $count 32 "$1"
}
mkdir -p out
step "configure"
cmake --preset examples >/dev/null
build() { # [TARGETS]
  if [ -t 1 ]; then # ninja rewrites a single line
    cmake --build build "$@"
  else
    cmake --build build "$@" >out/build.txt 2>&1 || { cat out/build.txt; exit 1; }
    [ -z "${CI:-}" ] || cat out/build.txt # .ci/run looks for warnings
  fi
}
if [ "$mode" = --build-only ]; then
  step "build into build/examples (some minutes)"
  build
  exit 0
fi
step "build the library and the programs that draw the cat"
build --target deform_svg contact_sheet

programs=build/examples
data=examples/data
report=out/report.txt
: >$report
step "the cat, posed"
# name FIGURE CAGE POSE COORDINATES
deform() {
  "$programs/deform_svg" "$data/$2.svg" --cage "$data/$3.svg" --pose "$data/$4.svg" --coordinates "$5" -o "out/$1.svg" --png --show-cage-lines
}
deform cat_rest cat cat_cage cat_cage mean-value
set -- "at rest" out/cat_rest.svg
for pose in step look tail stretch leap short_leg; do
  deform cat_${pose}_mean_value cat cat_cage cat_pose_$pose mean-value
  deform cat_${pose}_harmonic cat cat_cage cat_pose_$pose harmonic
  words=$(echo $pose | tr _ ' ')
  "$programs/contact_sheet" -o out/cat_$pose.svg --columns 2 --png "$words: mean value" out/cat_${pose}_mean_value.svg \
    "$words: harmonic" out/cat_${pose}_harmonic.svg
  [ $pose = short_leg ] || set -- "$@" "$words" out/cat_${pose}_harmonic.svg
done
"$programs/contact_sheet" -o out/cat.svg --columns 3 --tile 300 --png "$@"
echo "        out/cat.png is the cat at rest and in five poses, after $(($(date +%s) - start)) s"
[ "$mode" != cat ] || exit 0

step "build all other programs (some minutes)"
build
step "lessons"
for lesson in "$programs"/[0-2]*; do
  [ -f "$lesson" ] || continue # not a folder of CMake
  echo "== $(basename "$lesson")"
  "$lesson"
  echo
done >out/lessons.txt

step "the cat by Green coordinates"
# Green coordinates preserve angles. For this the figure may leave the cage.
set --
for pose in stretch leap; do
  deform cat_${pose}_green cat cat_cage cat_pose_$pose green
  for type in mean_value harmonic green; do set -- "$@" "$pose: $(echo $type | tr _ ' ')" out/cat_${pose}_$type.svg; done
done
"$programs/contact_sheet" -o out/cat_green.svg --columns 3 --png --png-width 1800 "$@"

step "the cat, with cells inside its cage"
# Cells inside the cage: a vertex in the face, a chain along the back. The vertices of the cage do not move.
for cells in head spine; do
  "$programs/deform_svg" "$data/cat.svg" --cage "$data/cat_cage_$cells.csv" --pose "$data/cat_pose_$cells.csv" \
    --coordinates harmonic -o out/cat_$cells.svg --png --show-cage-lines
done
"$programs/contact_sheet" -o out/cat_interior.svg --columns 3 --png --png-width 1500 "at rest" out/cat_rest.svg \
  "head vertex moved" out/cat_head.svg "spine moved" out/cat_spine.svg

step "a cage made from the cat, and a first animation"
# From the figure alone: a cage, a first picture, a pose by the vertex numbers of the picture, a motion to this pose and
# back.
"$programs/make_cage" "$data/cat.svg" -o out/cat_made_cage.svg --picture out/cat_made_numbers.svg >>$report
"$programs/deform_svg" "$data/cat.svg" --cage auto -o out/cat_first_look.svg
set -- --cage auto --coordinates harmonic --turn 7-8:-30@v6,9 --turn 0-2,20-23:12@v3,19
"$programs/deform_svg" "$data/cat.svg" "$@" -o out/cat_wags.svg --fit
"$programs/animate_svg" "$data/cat.svg" "$@" --seconds 1.2 -o out/cat_wag.svg >>$report
"$programs/contact_sheet" -o out/make_cage.svg --columns 3 --png --png-width 1800 "a cage made" out/cat_made_numbers.svg \
  "a first look" out/cat_first_look.svg "tail and head turned" out/cat_wags.svg

step "the cat, posed by vertex numbers"
# Without an editor: the picture shows the vertex numbers, and operations move the vertices.
"$programs/pose_cage" "$data/cat_cage.svg" --figure "$data/cat.svg" --picture out/cat_numbers.svg >>$report
"$programs/pose_cage" "$data/cat_cage.svg" --turn 7-11:-25@775,400 --turn 15-24:12@330,325 --bend '0-1,24:yx,500,750,20' \
  --figure "$data/cat.svg" --picture out/cat_numbers_posed.svg -o out/cat_pose_numbers.svg >>$report
"$programs/deform_svg" "$data/cat.svg" --cage "$data/cat_cage.svg" --pose out/cat_pose_numbers.svg --coordinates harmonic \
  -o out/cat_by_numbers.svg --fit
"$programs/contact_sheet" -o out/pose_cage.svg --columns 3 --png --png-width 1800 "the numbers" out/cat_numbers.svg \
  "tail and head turned, a leg bent" out/cat_numbers_posed.svg "the cat by that pose" out/cat_by_numbers.svg

step "a lattice around the cat, a face pulled out of a board"
# No cage at all: control points in a box.
"$programs/make_cage" "$data/cat.svg" --lattice 4x4 -o out/cat.lattice.json --picture out/cat_lattice_numbers.svg >>$report
"$programs/deform_svg" "$data/cat.svg" --cage lattice:4x4 -o out/cat_lattice_look.svg --show-cage --fit
"$programs/deform_svg" "$data/cat.svg" --cage lattice:4x4+0.2 --turn 0-7:12 -o out/cat_lattice_turned.svg --show-cage --fit
"$programs/contact_sheet" -o out/cat_lattice.svg --columns 3 --png --png-width 1800 "a lattice" out/cat_lattice_numbers.svg \
  "a first look" out/cat_lattice_look.svg "its upper half turned; the motion fades outside" out/cat_lattice_turned.svg
"$programs/lattice_board" -o out/lattice_board.png >>$report

step "a leaf in a cage of curves"
# A cage of four cubics, and the polygon of 25 vertices for the same pose; poses given by the numbers of control points.
"$programs/leaf_cages" "$data/leaf.svg" --cage "$data/leaf_cage.svg" --pose "$data/leaf_pose.svg" -o out/leaf_cages.svg --png --seconds >>$report
set -- --turn 6:40 --curve 0:4:0,-60
"$programs/pose_cage" "$data/leaf_cage.svg" "$@" --figure "$data/leaf.svg" --picture out/leaf_numbers.svg >>$report
set -- "$data/leaf.svg" --cage "$data/leaf_cage.svg" --coordinates curved-green --show-cage-lines "$@"
"$programs/deform_svg" "$@" -o out/leaf_curved.svg
"$programs/deform_svg" "$@" --disk -o out/leaf_disk.svg
"$programs/contact_sheet" -o out/leaf.svg --columns 3 --png --png-width 1800 "control points" out/leaf_numbers.svg \
  "the leaf by that pose" out/leaf_curved.svg "by the function of a disk" out/leaf_disk.svg

step "the cat walks"
# The cat walks: an SVG that browsers play, and twelve frames of a stride.
"$programs/animate_svg" "$data/cat.svg" --cage "$data/cat_cage.svg" --clip "$data/cat_walk.csv" \
  --coordinates harmonic -o out/cat_walk.svg --stills out/cat_walk_ --still-count 24 >>$report
set --
for frame in 01 02 03 04 05 06 07 08 09 10 11 12; do set -- "$@" $frame out/cat_walk_$frame.svg; done
"$programs/contact_sheet" -o out/cat_walk_frames.svg --columns 4 --png --png-width 1600 "$@"
mv out/cat_walk_frames.png out/cat_walk.png
rm -f out/cat_walk_[0-9][0-9].svg out/cat_walk_frames.svg

step "figures pulled by pins"
# Pins hold the paws and pull the tail. Then poses by pins, beside poses by the least moves of the cage vertices that
# satisfy the same pins.
"$programs/deform_svg" "$data/cat.svg" --cage "$data/cat_cage.svg" --coordinates harmonic --pin 212,740 --pin 645,740 \
  --pin 480,400 --pin 915,165:760,60 -o out/cat_pulled.svg --save-pose out/cat_pose_pulled.svg --show-pins --report >>$report
pinned() { # NAME FIGURE CAGE POSE POSE POSE   each POSE is a list of pins
  "$programs/pin_poses" "$2" --cage "$3" --coordinates harmonic --pinned "$4" --pinned "$5" --pinned "$6" -o "out/pins_$1_" >>$report 2>&1
  for number in 1 2 3; do tiles="$tiles pins out/pins_$1_$number.svg least~squares out/pins_$1_${number}_least.svg"; done
}
tiles=
pinned cat "$data/cat.svg" "$data/cat_cage.svg" "212,740 645,740 480,400 150,250:110,430" \
  "212,740 645,740:560,740 700,420:680,580 200,200:200,220" "212,740:60,600 645,740:840,700 480,400:470,340"
pinned man "$data/man.svg" auto "240,320 272,165 84,600:230,640" "240,320 84,600 378,250:390,110" \
  "240,320 84,600 118,338:90,150 378,250:400,110"
icons=/usr/share/icons/Tango/scalable # package tango-icon-theme
if [ -d $icons ]; then
  pinned stick $icons/devices/input-gaming.svg auto "8,37 40,37 24.4,8:34,12" "8,37 40,37 24.4,8:37,20" "8,37 40,37:40,28 24.4,8"
  pinned devil $icons/emotes/face-devilish.svg auto "20,23 20,38 7,5.4:2,13" "20,23 20,38 45,18:44,8" "20,38 20,6:20,14"
  pinned mouse $icons/devices/input-mouse.svg auto "24,28 24,42 24,4:16,4 41,8.5:32,2" "24,42 24,20:30,18@30" "24,28 24,14 24,42:36,40"
fi
set --
for word in $tiles; do set -- "$@" "$(echo "$word" | tr '~' ' ')"; done
"$programs/contact_sheet" -o out/pins.svg --columns 6 --tile 260 --png --png-width 880 "$@"

step "the cat walks by twelve markers"
"$programs/animate_svg" "$data/cat.svg" --cage "$data/cat_cage.svg" --markers "$data/cat_markers.csv" --coordinates harmonic \
  -o out/cat_markers.svg --report >>$report

step "the man, the aleph"
deform man_posed man man_cage man_pose barycentric
deform man_rest man man_cage man_cage barycentric
deform point_rest point man_cage man_cage barycentric
deform point_posed point man_cage man_pose barycentric
deform point_square point_square aleph_cage aleph_cage harmonic
"$programs/contact_sheet" -o out/points.svg --columns 3 --png "a point in a triangle" out/point_rest.svg \
  "the cage moved: the same weights" out/point_posed.svg "in a square" out/point_square.svg
deform aleph_rest aleph aleph_cage aleph_cage mean-value
deform aleph_mean_value aleph aleph_cage aleph_pose mean-value
deform aleph_harmonic aleph aleph_cage aleph_pose harmonic
"$programs/contact_sheet" -o out/man.svg --columns 2 --png "at rest" out/man_rest.svg "posed: barycentric" out/man_posed.svg
"$programs/contact_sheet" -o out/aleph.svg --columns 3 --png "at rest" out/aleph_rest.svg \
  "mean value" out/aleph_mean_value.svg "harmonic" out/aleph_harmonic.svg

step "a convex and a concave cage"
# Rows: at rest, mean value, harmonic; the figure at rest is white, under the posed figure.
set --
for type in rest mean-value harmonic; do
  for figure in hexagon biped; do
    name=out/${figure}_$(echo $type | tr - _).svg
    [ $type = rest ] || "$programs/deform_svg" "$data/$figure.svg" --cage "$data/${figure}_cage.svg" --show-cage-lines --show-rest \
      --pose "$data/${figure}_pose.svg" --coordinates $type --resolution 160 -o "$name"
    [ $type != rest ] || "$programs/deform_svg" "$data/$figure.svg" --cage "$data/${figure}_cage.svg" --show-cage-lines \
      --pose "$data/${figure}_cage.svg" -o "$name"
    set -- "$@" "$(echo $type | sed 's/rest/at rest/; s/-/ /')" "$name"
  done
done
"$programs/contact_sheet" -o out/two_cages.svg --columns 2 --png "$@"
# One pose by five coordinate types: the deformed squares show what each type preserves.
set --
for type in mean-value harmonic green sibson sibson-c1; do
  "$programs/deform_svg" "$data/checkerboard.svg" --cage "$data/checkerboard_cage.csv" --pose "$data/checkerboard_pose.csv" \
    --coordinates $type -o out/checkerboard_$type.svg --show-cage-lines
  set -- "$@" "$type" out/checkerboard_$type.svg
done
"$programs/deform_svg" "$data/checkerboard.svg" --cage "$data/checkerboard_cage.csv" --pose "$data/checkerboard_cage.csv" \
  -o out/checkerboard_rest.svg --show-cage-lines
"$programs/contact_sheet" -o out/types.svg --columns 3 --png --png-width 1200 "at rest" out/checkerboard_rest.svg "$@"

step "the fish, by points without a cage"
deform fish_points fish fish_points fish_points sibson
for pose in pose_tail pose_fins; do
  for type in sibson sibson-c1; do deform "fish_${pose}_$type" fish fish_points fish_$pose $type; done
done
"$programs/contact_sheet" -o out/fish.svg --columns 2 --png --png-width 1400 "at rest" "$data/fish.svg" \
  "its points" out/fish_points.svg "tail: sibson" out/fish_pose_tail_sibson.svg "tail: sibson-c1" out/fish_pose_tail_sibson-c1.svg \
  "fins: sibson" out/fish_pose_fins_sibson.svg "fins: sibson-c1" out/fish_pose_fins_sibson-c1.svg

"$programs/sibson_figures" out >out/sibson.txt

step "a character in space"
"$programs/make_character" out >>$report
set --
for type in mean-value harmonic green sibson-c1; do
  name=out/character_$(echo $type | tr - _)
  "$programs/deform_mesh" out/character.obj --cage out/character_cage.obj --pose out/character_pose.obj \
    --coordinates $type -o "$name.obj" --picture "$name.png" --weight 30
  set -- "$@" "$type" "$name.png"
done
"$programs/contact_sheet" -o out/character_types.svg --columns 2 --tile 700 --png --png-width 1400 "$@"
# Poses by pins on head, hips, hands and feet, beside poses by the least moves of the cage vertices that satisfy the
# same pins.
head=0,1.75,0 hips=0,0.9,0 left=0.9,1.325,0 right=-0.9,1.325,0 foot=0.19,0.06,0.03 other=-0.19,0.06,0.03
"$programs/pin_poses" out/character.obj --cage out/character_cage.obj --coordinates harmonic -o out/character_pins_ \
  --pinned "$head $hips $left:0.55,1.9,0.2 $right:=-0.5,0.8,0.15 $foot $other" \
  --pinned "$head:0,1.72,0.1 $hips $left:0.4,0.72,0.25 $right:=-0.4,0.72,0.25 $foot $other" \
  --pinned "$head:=0,1.72,-0.12 $hips $left:=0.75,1.5,-0.3 $right:=-0.8,1.1,0.3 $foot:0.2,0.6,0.72 $other" \
  --pinned "$head:0.45,1.6,0.05 $hips $left:0.95,0.8,0.1 $right:=-0.35,1.85,0.1 $foot $other" \
  --pinned "$head:0,1.35,0.12 $hips:=0,0.52,-0.25 $left:0.6,0.95,0.55 $right:=-0.6,0.95,0.55 $foot $other" \
  --pinned "$head:0,1.78,0.02 $hips:0,0.98,0 $left:0.65,1.85,0 $right:=-0.65,1.85,0 $foot:0.6,0.3,0 $other:=-0.2,0.02,0.03" >>$report
"$programs/contact_sheet" -o out/character_pins.svg --columns 1 --tile 1560 --png --png-width 1000 \
  "by pins" out/character_pins_all.png "by least squares" out/character_pins_all_least.png
# Tetrahedra bent by 180 degrees, which folds cells; with --no-folds the bend stops before the first fold.
"$programs/make_box" -o out/box.mesh --cage out/box_cage.obj >>$report
for stop in "" --no-folds; do
  "$programs/deform_mesh" out/box.mesh --cage out/box_cage.obj --bend all:xy,1.5,2.5,180 $stop -o "out/box_bent$stop.mesh" \
    --picture "out/box_bent$stop.png" --report >>$report
done
"$programs/contact_sheet" -o out/box_folds.svg --columns 1 --tile 1000 --png --png-width 1000 \
  "bent by 180 degrees" out/box_bent.png "where the first tetrahedron would fold" out/box_bent--no-folds.png
# Splats on the character, bent, and drawn beside the bent mesh.
"$programs/make_splats" out/character.obj -o out/splats.ply --count 100000 >>$report
bend() { # PROGRAM FIGURE [OPTION ...]
  "$@" --cage lattice:4x9x4 --bend all:yx,0.9,0,75 --twist all:y,0,2,50
}
bend "$programs/deform_splats" out/splats.ply --split 1.2 -o out/splats_bent.ply --report >>$report
bend "$programs/deform_mesh" out/character.obj -o out/splats_bent.obj
set --
for view in 0,8 65,20 180,10; do
  "$programs/draw_splats" out/splats_bent.ply --beside out/splats_bent.obj -o "out/splats_$view.png" --view $view --width 1200 --height 800
  set -- "$@" "seen from $view" "out/splats_$view.png"
done
"$programs/contact_sheet" -o out/splats.svg --columns 3 --tile 900 --png --png-width 1500 "$@"
# Fits the pose of a lattice to the pose by the cage; then poses the character by the file with that pose.
"$programs/lattice_fit" out/character.obj out/character_harmonic.obj --cage lattice:6x6x6 -o out/lattice_pose.obj \
  --picture out/lattice_fit.png >>$report
"$programs/deform_mesh" out/character.obj --cage lattice:6x6x6 --pose out/lattice_pose.obj -o out/character_lattice.obj
# Makes cages around figures that already have one, and deforms the character by a made cage.
"$programs/make_cage" out/character.obj --picture out/character_made.png -o out/character_made_cage.obj >>$report
"$programs/make_cage" out/character.obj --quads --rings --mirror x --picture out/character_quads.png -o out/character_quads.obj >>$report
"$programs/deform_mesh" out/character.obj --cage auto:60 -o out/character_look.obj --picture out/character_look.png
for name in aleph fish; do "$programs/make_cage" "$data/$name.svg" --picture out/${name}_made.svg >>$report; done
# The parts of a cage, and a pose given by part numbers.
"$programs/make_cage" out/character.obj --mirror x --vertices 120 --picture out/character_parts.png \
  -o out/character_parts.obj >>$report
arm=$(sed -n 's/^g part_-//p' out/character_parts.obj | sort -n | head -1) # the largest pair of parts that are mirror images of each other
"$programs/deform_mesh" out/character.obj --cage out/character_parts.obj --turn "part $arm:-50,y" --turn "part -$arm:20,y" \
  -o out/character_by_parts.obj --picture out/character_by_parts.png
"$programs/contact_sheet" -o out/cage_parts.svg --columns 2 --png --png-width 1600 "the parts of a cage" \
  out/character_parts.png "a pose by their numbers" out/character_by_parts.png
"$programs/contact_sheet" -o out/made_cages.svg --columns 4 --png --png-width 1600 cat.svg out/cat_made_numbers.svg \
  aleph.svg out/aleph_made.svg fish.svg out/fish_made.svg character.obj out/character_made.png

step "a character for a game"
# Files for a game: a packed binding with the dance, and glTF files with a skin and with morph targets.
"$programs/bind_mesh" out/character.obj --cage out/character_cage.obj --clip out/character_clip.csv \
  --coordinates harmonic --max-distance 0.001 -o out/character.figure --report >>$report
mkdir -p out/character_poses # four poses of its clip; examples/integrations/farms/run.sh makes hundreds on a render farm
"$programs/clone_figure" out/character.figure --poses out/character_clip.csv --rate 10 --rows 0:4 --json \
  -o 'out/character_poses/%02d.ply' >>$report
# Points in tiles; each of two processes binds half of the tiles.
mkdir -p out/tiles
"$programs/make_tiles" out/character.obj --points 40000 --tiles 4 -o out/tiles/%d.ply
for rows in 0:2 2:4; do
  "$programs/bind_tiles" out/character_cage.obj --points 'out/tiles/*.ply' --rows $rows -o 'out/tiles/*.figure' \
    --largest 16 --format half >>$report
done
"$programs/export_gltf" out/character.obj --cage out/character_cage.obj --clip out/character_clip.csv --max-distance 0.01 \
  --coordinates harmonic -o out/character_skin.glb --report >>$report
"$programs/export_gltf" out/character.obj --cage out/character_cage.obj --clip out/character_clip.csv --bones 24 \
  --coordinates harmonic -o out/character_bones.glb --picture out/character_bones.png --report >>$report
mkdir -p out/character_frames # a sequence of meshes, as other programs write it
"$programs/clone_figure" out/character.figure --poses out/character_clip.csv --rate 10 --mesh out/character.obj \
  -o 'out/character_frames/%02d.obj' >>$report
"$programs/fit_skeleton" out/character.obj out/character_frames/*.obj --rate 10 --bones 24 -o out/character_fitted.glb --report >>$report
"$programs/export_gltf" out/character.obj --cage out/character_cage.obj --clip out/character_clip.csv --morph \
  --coordinates harmonic -o out/character_morph.glb >>$report

step "a character and its bones"
for weights in heat harmonic; do
  "$programs/skin_mesh" out/character.obj --bones out/character.bones.csv --weights $weights -o out/bones_$weights.glb \
    --picture out/bones_$weights.png --report >>$report
done

step "a puppet on another"
"$programs/make_character" out/adult --followers >>$report
"$programs/make_character" out/child --girth 1.4 --child 0.6 >>$report
"$programs/wrap_mesh" out/adult/character.obj out/child/character.obj -o out/wrapped.obj --push-out 0.05% --picture out/wrap.png --report \
  --follow out/adult/character_tights.obj:out/tights.obj --follow out/adult/character_skirt.obj:out/skirt.obj \
  --follow out/adult/character.bones.csv:out/wrapped.bones.csv >>$report

step "a hand"
# Control points without a cage: natural neighbours, moved by 22 joint angles.
"$programs/make_hand" out >>$report
"$programs/pose_hand" --pose fist --picture out/hand_fist.png
"$programs/hand_sheet" out >out/hand.txt

step "three poses by every coordinate type"
# The types are those of the library's list that support the cage of the biped; the last two rows are local harmonic coordinates and a lattice.
types=out/types
mkdir -p $types
"$programs/make_character" $types >>$report
cp out/hand.obj $types
"$programs/make_cage" $types/hand.obj --vertices 200 -o $types/hand_cage.obj >>$report
for name in cage pose; do "$programs/pose_cage" "$data/biped_$name.svg" -o $types/biped_$name.csv >>$report; done
"$programs/deform_mesh" $types/hand.obj --cage $types/hand_cage.obj --coordinates harmonic -o $types/hand_best.obj \
  --turn 'y>0.76&x>-0.13&x<0.07:60,x@-0.03,0.72,0' --save-pose $types/hand_pose.obj
"$programs/deform_mesh" $types/character.obj --cage $types/character_cage.obj --pose $types/character_pose.obj \
  --coordinates harmonic -o $types/character_best.obj
# A lattice has other handles, so its pose is fitted: in the plane to that of the cage, in space to the harmonic one.
"$programs/make_cage" "$data/biped_cage.svg" --lattice 6x6 -o $types/biped.lattice.json >>$report
"$programs/lattice_fit" "$data/biped_cage.svg" "$data/biped_pose.svg" --cage $types/biped.lattice.json \
  -o $types/biped_lattice.csv >>$report
for figure in character hand; do
  "$programs/lattice_fit" $types/$figure.obj ${types}/${figure}_best.obj --cage lattice:6x6x6 -o $types/${figure}_lattice.obj >>$report
done
printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 16 10"/>' >$types/none.svg
sheet=$types/sheet.txt
: >$sheet
type_row() { # LABEL PLANE'S-CAGE ITS-POSE SPACE'S-CAGE ITS-POSE [OPTION ...]   cages and poses: what follows the name of the figure
  label=$1 plane=$2 plane_pose=$3 space=$4 space_pose=$5
  shift 5
  "$programs/deform_svg" "$data/biped.svg" --cage "$plane" --pose "$plane_pose" "$@" -o "$types/biped $label.svg" --show-cage-lines \
    2>/dev/null || return 0 # the type needs a convex cage or a simplex
  echo "$label, in the plane|$types/biped $label.svg" >>$sheet
  for figure in character hand; do
    picture="$types/$figure $label.png"
    "$programs/deform_mesh" $types/$figure.obj --cage "$(echo "$space" | sed "s|@|$types/$figure|")" --pose "$types/$figure$space_pose" "$@" \
      -o $types/posed.obj --picture "$picture" 2>/dev/null || picture=$types/none.svg
    echo "$label|$picture" | sed "/none.svg/s/.*|/not in space|/" >>$sheet
  done
}
for type in $(sed -n 's/^    X(\([a-z0-9_]*\), .*/\1/p' include/cageform/coordinates/types.hpp | tr _ -); do
  type_row $type $types/biped_cage.csv $types/biped_pose.csv @_cage.obj _pose.obj --coordinates $type
done
type_row "local harmonic" $types/biped_cage.csv $types/biped_pose.csv @_cage.obj _pose.obj --coordinates harmonic --locality 20
type_row lattice $types/biped.lattice.json $types/biped_lattice.csv lattice:6x6x6 _lattice.obj
set --
while IFS='|' read -r caption file; do set -- "$@" "$caption" "$file"; done <$sheet
"$programs/contact_sheet" -o out/every_type.svg --columns 6 --tile 300 --png --png-width 720 "$@"
set -- # of each figure: by all types in its cage, by its lattice
for figure in character hand; do
  set -- "$@" $types/$figure.obj $types/${figure}_cage.obj $types/${figure}_pose.obj all
  set -- "$@" $types/$figure.obj lattice:6x6x6 $types/${figure}_lattice.obj splines
done
"$programs/figure_table" --locality 20 "$data/biped.svg" $types/biped_cage.csv $types/biped_pose.csv all \
  "$data/biped.svg" $types/biped.lattice.json $types/biped_lattice.csv splines "$@" >out/every_type.txt

step "heat maps"
field() { # NAME CAGE VERTEX COORDINATES [OPTION ...]
  name=$1 cage=$2 vertex=$3 type=$4
  shift 4
  "$programs/coordinate_field" --cage "$data/$cage.svg" --vertex "$vertex" --coordinates "$type" --resolution 256 \
    -o "out/$name.png" "$@" >>$report
}
field field_cat_8_harmonic cat_cage 8 harmonic --surface out/surface_cat_8.png
field field_biped_1_signs biped_cage 1 mean-value --signs root --levels 0
field field_cat_8_zoom cat_cage 8 harmonic --zoom 780,240,180,140 --levels 20
field field_cat_8_mean_value cat_cage 8 mean-value
for vertex in 1 2; do
  field field_biped_${vertex}_mean_value biped_cage $vertex mean-value
  field field_biped_${vertex}_harmonic biped_cage $vertex harmonic
done
"$programs/boundary_formula" --cage "$data/cat_cage.svg" --vertex 8 --at 937.5,237.5 >>$report
# The grid of the papers, coarse and fine.
for cells in 32 64; do
  "$programs/coordinate_field" --cage "$data/cat_cage.svg" --vertex 8 --coordinates harmonic --resolution $cells \
    -o out/field_cat_$cells.png --classes out/classes_$cells.png >>$report
done
"$programs/contact_sheet" -o out/classes.svg --columns 2 --png "32 cells" out/classes_32.png "64 cells" out/classes_64.png

# A field with values at the corners of a rectangle; the black line shows the given values.
"$programs/coordinate_field" --cage "$data/rectangle.csv" --y-up --values 1,2,4,2 --coordinates harmonic \
  -o out/field_rectangle.png --surface out/surface_rectangle.png --turn 35 -60 >>$report
# Mean value coordinates are means over rays, harmonic coordinates are means over Brownian paths.
"$programs/paths" --cage "$data/biped_cage.svg" --point 150,540 -o out/paths.svg --png >out/paths.txt

for type in wachspress mean-value discrete-harmonic; do
  field "field_heptagon_$(echo $type | tr - _)" heptagon_cage 3 $type
done
# With f = √r weights are negative in the thin cage of tests/coordinates/three_point.cpp.
"$programs/contact_sheet" -o out/convex.svg --columns 3 --tile 480 --png --png-width 1800 \
  "Wachspress, f = 1: nowhere negative" out/field_heptagon_wachspress.png \
  "mean value, f = r (√r: to −0.015 in thin cages)" out/field_heptagon_mean_value.png \
  "discrete harmonic, f = r²: to −0.16" out/field_heptagon_discrete_harmonic.png

"$programs/contact_sheet" -o out/biped_signs.svg --columns 2 --png \
  "mean value: negative (blue) in the other leg" out/field_biped_1_mean_value.png \
  "harmonic: nowhere negative" out/field_biped_1_harmonic.png

step "heights and colours from strokes"
"$programs/height_map" "$data/hills.svg" -o out/hills.png -o out/hills.csv --lines out/hills_lines.svg \
  --3d out/hills_3d.png --levels 0.05 >>$report
"$programs/grid_field" out/hills.csv -o out/grid_field.png --levels 20 --surface out/grid_surface.png --turn 60 >>$report
"$programs/diffuse_colours" "$data/cat_colours.svg" -o out/cat_colours.png >>$report
"$programs/contact_sheet" -o out/strokes.svg --columns 3 --png --png-width 1500 "heights" out/hills.png \
  "level lines" out/hills_lines.svg "colours on both sides of lines" out/cat_colours.png

step "a boat in another picture"
"$programs/clone_image" --make out >>$report
boat() { # OPTION…
  "$programs/clone_image" out/noon.png out/evening.png --region out/boat.svg "$@" >>$report
}
boat -o out/boat.png --pasted out/boat_pasted.png --poisson out/boat_exact.png --report
boat --at 20,64 --at 280,64 --steps 3 -o out/clone_way.png
"$programs/contact_sheet" -o out/clone_image.svg --columns 2 --png --png-width 860 "a boat at noon" out/noon.png \
  "pasted into the evening" out/boat_pasted.png "cloned by mean value coordinates" out/boat.png \
  "by the Poisson equation" out/boat_exact.png

step "puzzles of numbers"
"$programs/puzzle" "$data/puzzle.csv" --exact -o out/puzzle_4.svg >out/puzzle.txt
"$programs/puzzle" "$data/puzzle.csv" --exact --neighbours 8 --walks 10000 --from 2 2 -o out/puzzle_8.svg >>out/puzzle.txt
"$programs/contact_sheet" -o out/puzzle.svg --columns 2 --png "each the mean of four neighbours" out/puzzle_4.svg \
  "of eight" out/puzzle_8.svg
# A hundred by a hundred cells: the values given on the border determine all others.
awk 'function cell(x, y, n) { if (y == 0) return int(1000 * sin(3.14159 * x / n)) "/1000"
                              if (y == n) return int(-1000 * sin(6.28318 * x / n)) "/1000"
                              return x == 0 || x == n ? 0 : "." }
     BEGIN { for (y = 0; y < 100; y++) for (x = 0; x < 100; x++) printf "%s%s", cell(x, y, 99), x < 99 ? "," : "\n" }' >out/border.csv
"$programs/puzzle" out/border.csv --csv out/means.csv >/dev/null
"$programs/grid_field" out/means.csv -o out/means.png --surface out/means_surface.png >>$report

step "how the solver converges"
"$programs/relaxation" "$data/line.csv" -o out/relaxation.svg --png --play out/relaxation_plays.svg >>$report
known=tests/data/oracle # weights to many digits
"$programs/convergence" --cage "$data/cat_cage.svg" --cage "$data/biped_cage.svg" --oracle $known/harmonic2d_cat.json \
  --oracle $known/harmonic2d_l_shape.json --oracle $known/harmonic3d_l_prism_triangulated.json \
  --oracle tests/data/fingers/reference.txt --oracle tests/data/fingers/skin.txt \
  -o out/convergence.svg --png >out/convergence.txt
# Where the adaptive grid is fine: in narrow parts, at corners, in fingers.
grid() { # NAME CAGE [OPTION ...]
  name=$1 cage=$2
  shift 2
  "$programs/adaptive_grid" --cage "$cage" "$@" -o "out/$name.svg" >>$report
}
fingers=tests/data/fingers/cage.obj
grid grid_cat "$data/cat_cage.svg" --figure "$data/cat.svg" --accuracy 0.001
grid grid_corner "$data/cat_cage.svg" --accuracy 0.001 --zoom 254.5,518,16,14.2
grid grid_body $fingers --accuracy 0.002 --slice z=0.9
grid grid_fingers $fingers --accuracy 0.002 --slice y=138.5 --zoom 64,-12,26,24
grid grid_hand out/hand_cage.obj --figure out/hand.obj --accuracy 0.005 --slice z=0 --zoom -0.29,0.42,0.64,0.56
"$programs/contact_sheet" -o out/adaptive_grid.svg --columns 3 --tile 560 --png --png-width 1500 \
  "to 0.001, the finer the darker" out/grid_cat.svg "at a corner" out/grid_corner.svg \
  "fingers in a cage to 0.005, cut from above" out/grid_hand.svg \
  "a body of 180 units to 0.002, cut from the front" out/grid_body.svg "its hand, fingers 1.7 thick, from above" out/grid_fingers.svg

# The weights at every point of a grid over the biped's cage, as numbers.
awk 'BEGIN { for (y = 50; y < 700; y += 10) for (x = 50; x < 450; x += 10) print x "," y }' >out/biped_points.csv
"$programs/cage_weights" --cage "$data/biped_cage.svg" --points out/biped_points.csv --coordinates mean-value \
  --outside keep-in-place --report -o out/biped_weights.csv >out/biped_report.txt

step "electrons as waves"
# One process per processor, because these pictures take a third of the total time. The scenes shadow and spin need the
# larger lattice.
printf '%s\n' 'shadow 320x240' 'spin 320x240' 'slit 256x192' 'two-slits 256x192' |
  xargs -P "$(nproc)" -L 1 sh -c '"$0/electron_waves" --scene "$1" --size "$2" --mesh 0.12 --float -o "out/waves_$1.png" \
    --csv "out/waves_$1.csv" >"out/waves_$1.txt"' "$programs"
for scene in slit two-slits spin shadow; do
  echo "$scene:"
  cat out/waves_$scene.txt
  rm out/waves_$scene.txt
done >out/waves.txt

step "a key-frame curve"
# A key-frame curve fitted by as few cubic pieces as a screen of 1920 pixels requires.
"$programs/fit_curve" --css 0.8,-0.3,0.2,1.3 --tolerance 0.00052 --plot out/fit_curve.svg --png \
  --json out/fit_curve.json

step "films of mathematics"
# A sphere turned inside out, also in a lattice; curves that are deformed into other curves; endless zooms. Makes films
# if ffmpeg is installed.
film() { # NAME PROGRAM WORD…   appends --gif
  name=$1
  shift
  if command -v ffmpeg >/dev/null; then set -- "$@" --gif "out/$name.gif"; fi
  "$programs/$@" >>out/films.txt
}
: >out/films.txt
film eversion sphere_eversion -o out/eversion.png --volume out/eversion_volume.svg --tile 240 --frames 60
"$programs/sphere_eversion" -o out/eversion_twisted.png --cage lattice:6x6x6 --twist all:z,-1,1,120 --tile 240 >>out/films.txt
"$programs/plane_homotopy" circle loops -o out/homotopy.svg --png >>out/films.txt
"$programs/plane_homotopy" circle eight -o out/homotopy_fails.svg --png >>out/films.txt
for curve in koch peano sierpinski; do film zoom_$curve zooms $curve -o out/zoom_$curve.svg --png --frames 25; done

step "tables"
"$programs/figure_table" "$data/man.svg" "$data/man_cage.svg" "$data/man_pose.svg" barycentric \
  "$data/cat.svg" "$data/cat_cage.svg" "$data/cat_pose_step.svg" mean-value,harmonic,green \
  "$data/aleph.svg" "$data/aleph_cage.svg" "$data/aleph_pose.svg" mean-value,harmonic >out/figures.txt
"$programs/bezier_tables" "$data/bezier_tables.csv" >out/curves.txt

cat <<END

Open out/cat.png. The gallery, examples/README.md, describes the pictures in out/. Open .svg files in a browser, .glb files
in a viewer of glTF, .ply files in a viewer of splats. The .txt files are tables, measured values and other output.

sh examples/page/run.sh makes out/cageform.html, a page to try all this in a browser.
END
