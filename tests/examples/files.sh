# shellcheck shell=sh disable=SC2013,SC2086,SC2154 # lists of names are meant to be split; command_line.sh has set the rest
# Sourced by command_line.sh. These laws hold for every program that takes files, and for every option that takes one:
#   no input is written over, by whatever name;
#   no name of a file commands the terminal;
#   pictures show no files that a drawing links to.
# A form is a command line whose words name files of files/pool; what else it leaves in its folder are its outputs, so that
# none of them is forgotten. Those of a program that computes for long are told instead, and it is not run to its end.
# A program without a form fails, and an option that may take a file and is in no form.
mkdir -p files/pool files/stand_in
cd files || exit 1
escape=$(printf '\033')

# ---- the files ----
for name in hexagon hexagon_cage hexagon_pose fish fish_points fish_pose_fins hills leaf leaf_cage leaf_pose; do cp "$data/$name.svg" pool; done
cp "$data/puzzle.csv" pool
(
  cd pool || exit 1
  printf '0,0\n1,0\n1,1\n0,1\n' >square.csv
  printf '0.5,0.5\n0.2,0.7\n' >points.csv
  printf 'a\nb\n\nc\n' >labels.txt
  printf 'a\nb\nc\nd\n\n\n\n\n' >box_labels.txt
  printf '1,.,.,2\n' >line.csv
  printf '1,2\n3,4\n' >table.csv
  sed -n 's/.*<circle.*/1/p' fish_points.svg >point_weights.txt
  printf 'v %s %s %s\n' 0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1 >box.obj
  printf 'f %s %s %s %s\n' 1 3 4 2 5 6 8 7 1 2 6 5 2 4 8 6 4 3 7 8 3 1 5 7 >>box.obj
  seq 8 >corner_weights.txt
  "$programs/bind_tiles" box.obj --points box.obj -o box.figure --coordinates harmonic --accuracy 0.1 --save-solution box.solution >/dev/null 2>&1; rm -f box.figure
  sed '8s/.*/v 1.3 1.2 1.1/' box.obj >bent_box.obj
  # The box as an STL file, in which its vertices have another order, and a figure as STL and PLY.
  awk '/^v/ { v[++n] = "vertex " $2 " " $3 " " $4 } /^f/ { face($2, $3, $4); face($2, $4, $5) } END { print "endsolid" }
    function face(a, b, c) { print "facet normal 0 0 0 outer loop\n" v[a] "\n" v[b] "\n" v[c] "\nendloop endfacet" }' box.obj |
    sed '1isolid box' >box.stl
  printf 'solid\nfacet normal 0 0 1\nouter loop\nvertex 0.25 0.25 0.5\nvertex 0.75 0.25 0.5\nvertex 0.5 0.75 0.5\nendloop\nendfacet\nendsolid\n' >inner.stl
  printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float quality\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0.25 0.25 0.25 255 0 0 7\n0.75 0.25 0.5 0 9 0 8\n0.5 0.75 0.5 0 0 1 9\n3 0 1 2\n' >inner.ply
  printf 'v 0.25 0.25 0.25\nv 0.75 0.25 0.5\nv 0.5 0.75 0.5\nf 1 2 3\n' >inner.obj
  sed '3s/.*/v 0.5 0.8 0.6/' inner.obj >bent_inner.obj
  sed '2s/.*/v 0.7 0.3 0.5/' inner.obj >turned_inner.obj
  "$programs/make_splats" inner.obj -o scene.ply --count 20 >/dev/null
  printf '0,0.3,0.3,0.3\n2,0.5,0.75,0.5\n' >space_pins.csv
  printf 'MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0.2 0.2 0.2 0\n0.8 0.2 0.2 0\n0.2 0.8 0.2 0\n0.2 0.2 0.8 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n' \
    >solid.mesh
  for time in 0 0.5; do
    echo "pose,$time,smooth"
    sed -n "s/^v \(.*\) \(.*\) \(.*\)/\1,\2,$time\3/p" box.obj
  done | sed '1ilength,1' >box_clip.csv
  grep '^v' box.obj | cut -d ' ' -f 2- | tr ' ' , | paste -s -d , >box_poses.csv
  "$programs/bind_mesh" inner.obj --cage box.obj -o bound.figure 2>/dev/null
  printf 'length,1\ncontrol,a\nvertices,0\n0,0,0,0,linear\n0.5,9,0,0,linear\n1,0,0,0,linear\n' >clip.csv
  echo 250,250,260,250 >pins.csv
  printf '0,250,250\n1,260,250\n' >markers.csv
  printf '0,0\n7,7\n' >corners.csv
  printf 'low,,0.5,0.5,0.1,0.5,0.5,0.5,0,0,0\nhigh,low,0.5,0.5,0.5,0.5,0.5,0.9,20,0,0\n' >bones.csv
  printf '0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n' >hand.csv
  printf '{"cage": {"vertices": [[0,0],[1,0],[0,1]], "loops": [[0,1,2]]}, "points": [[0.25,0.25]], "coordinates": [[0.5,0.25,0.25]]}' >triangle.json
  printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >cage.obj
  printf '{"format": "lattice/1", "axes": [{"points": 2, "degree": 1}, {"points": 2, "degree": 1}], "frame_columns": [[500,0],[0,500]], "origin": [0,0]}' \
    >plane.lattice.json
  printf '{"format": "lattice/1", "axes": [{"points": 2, "degree": 1}, {"points": 2, "degree": 1}, {"points": 2, "degree": 1}], "frame_columns": [[2,0,0],[0,2,0],[0,0,2]], "origin": [0,0,0]}' \
    >box.lattice.json
  printf '0,0\n500,0\n0,500\n520,510\n' >plane_pose.csv
  echo '0.25,0.25,0.25;0:0.25;1:0.25;2:0.25;3:0.25' >reference.txt
  cat >curves.json <<'JSON'
{"layers": [{"nm": "ball", "ks": {"r": {"a": 1, "k": [
  {"t": 0, "s": [0], "o": {"x": [0.42], "y": [0]}, "i": {"x": [0.58], "y": [1]}}, {"t": 30, "s": [90], "h": 1}]}}}]}
JSON
  cat >cases.json <<'JSON'
{"format": "bezier-sobolev-cases/1", "cases": [{"id": "a", "control_points": [[0, 0], [0.4, 0], [0.6, 1], [1, 1]],
  "degree": 3, "weights": [1, 1], "conditions": ["end_value", "knot_c0"], "knots": {"mode": "uniform_x", "pieces": 2}}]}
JSON
  # The pictures noon.png and evening.png, and the outline boat.svg.
  "$programs/clone_image" --make . --size 32 >log 2>&1 || cat log
  rm log
  # A picture of one red pixel.
  echo iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC | base64 -d >red.png
)
cat >stand_in/ffmpeg <<'SH'
#!/bin/sh
for word in "$@"; do out=${word#file:}; done
cat >"$out"
SH
chmod +x stand_in/ffmpeg

# ---- how a form is run ----
fresh() { # INPUT…   a folder of these alone
  rm -rf run
  mkdir run
  for name in "$@"; do cp "pool/$name" run; done
}
run() { # WORD…   of the form's program, in the folder
  (cd run && PATH="$work/files/stand_in:$PATH" "$programs/$program" "$@") >log 2>&1
}
is_input() { # WORD
  case " $inputs " in *" $1 "*) return 0 ;; esac
  return 1
}
is_output() { # WORD   an output, or how some begin
  for output in $outputs; do
    case $output in "$1"*) return 0 ;; esac
  done
  return 1
}
run_renamed() { # PREFIX CHANGED WORD…   the words of that list with the prefix
  prefix=$1; changed=$2; shift 2
  left=$#
  while [ $left -gt 0 ]; do
    case " $changed " in *" $1 "*) set -- "$@" "$prefix$1" ;; *) set -- "$@" "$1" ;; esac
    shift
    left=$((left - 1))
  done
  run "$@"
}
says_plainly() { # TEXT   of the log: it holds that, and nothing for a terminal
  ! grep -q "$escape" log || { echo "a name commands the terminal" >>log; return 1; }
  [ -z "$1" ] || grep -qF -- "$1" log || { echo "does not say: $1" >>log; return 1; }
}

beside= # inputs that no word names
told=   # outputs of a program that computes for long
form() { # PROGRAM WORD…
  program=$1; shift
  echo "$program" >>formed
  inputs=$beside
  for word in "$@"; do
    if [ -f "pool/$word" ]; then inputs="$inputs $word"; fi
  done
  outputs=$told
  if [ -z "$told" ]; then
    fresh $inputs
    run "$@" && ok=yes || ok=no
    for file in run/*; do
      is_input "${file#run/}" || outputs="$outputs ${file#run/}"
    done
    report $ok "$program $*"
    [ $ok = yes ] || return
  fi

  names= # words that name files
  option=
  for word in "$@"; do
    if is_input "$word" || is_output "$word"; then
      names="$names $word"
      echo "$program $option" >>covered
    fi
    option=$word
  done

  # An output that is an input, by a link; the first by one that has a path of its own, others by a second name.
  for output in $outputs; do
    link="ln -s"
    for input in $inputs; do
      fresh $inputs
      (cd run && $link "$input" "$output")
      link="ln -P"
      run "$@"
      [ $? -eq 1 ] && grep -qF "cannot write $output: it is the same file as $input, which is read" log && ok=yes || ok=no
      for name in $inputs; do cmp -s "pool/$name" "run/$name" || { ok=no; echo "$name is written over" >>log; }; done
      (cd run && cmp -s "$input" "$output" && [ "$(echo *)" = "$(printf '%s\n' $inputs "$output" | sort -u | xargs)" ]) ||
        { ok=no; echo "left: $(ls run)" >>log; }
      report $ok "$output is $input: $program $*"
    done
  done

  # Names that hold commands for a terminal: where all goes well, and where one of the files is missing.
  if [ -z "$told" ]; then
    fresh $inputs
    for name in $inputs; do cp "run/$name" "run/${escape}[7m$name"; done
    run_renamed "${escape}[7m" "$names" "$@" && says_plainly '' && ok=yes || ok=no
    report $ok "names that command the terminal: $program $*"
  fi
  for word in $names; do
    fresh $inputs
    if run_renamed "${escape}[7m/" "$word" "$@"; then ok=no; else says_plainly "\\x1b[7m/$word" && ok=yes || ok=no; fi
    report $ok "$word is missing, and commands the terminal: $program $*"
  done

  # A picture of a drawing that links to another.
  case " $* " in *" --png "* | *" --gif "*) ;; *) return ;; esac
  for input in $inputs; do
    case $input in *.svg) ;; *) continue ;; esac
    fresh $inputs
    sed 's|</svg>|<image width="400" height="400" href="linked.png"/></svg>|' "pool/$input" >"run/$input"
    run "$@" && ok=yes || ok=no
    for output in $outputs; do mv "run/$output" "run/old_$output"; done
    cp pool/red.png run/linked.png
    run "$@" || ok=no
    for output in $outputs; do cmp -s "run/$output" "run/old_$output" || { ok=no; echo "$output shows it" >>log; }; done
    report $ok "$input links to a picture: $program $*"
  done
}

# ---- the forms ----
form deform_svg hexagon.svg --cage hexagon_cage.svg --pose hexagon_pose.svg -o out.svg --png --png-width 40
form deform_svg fish.svg --cage fish_points.svg --pose fish_pose_fins.svg --coordinates sibson --weights point_weights.txt -o out.svg
form deform_svg hexagon.svg --cage plane.lattice.json --pose plane_pose.csv -o out.svg
form deform_svg hexagon.svg --cage hexagon_cage.svg --pins pins.csv -o out.svg --save-pose saved.svg
form animate_svg hexagon.svg --cage hexagon_cage.svg --markers markers.csv --rate 2 -o out.svg --save-clip saved.csv --track 250,250 --save-tracks tracks.csv
form animate_svg hexagon.svg --cage hexagon_cage.svg --pins pins.csv --rate 2 -o out.svg
form pin_poses inner.obj --cage box.obj --pinned 0:+0.1,0,0 -o out_
form pin_poses hexagon.svg --cage hexagon_cage.svg --pinned 250,250:260,250 -o out_
form animate_svg hexagon.svg --cage hexagon_cage.svg --clip clip.csv -o out.svg --stills still_ --still-count 1 --rate 2 \
  --gif out.gif --apng out.png --mp4 out.mp4 --width 40
form animate_svg hexagon.svg --cage hexagon_cage.svg --pose hexagon_pose.svg --rate 2 -o out.svg
form animate_svg hexagon.svg --cage hexagon_cage.svg --pose hexagon_pose.svg --rate 2 --width 40 -o out.gif
form coordinate_field --cage hexagon_cage.svg --vertex 0 --coordinates harmonic --resolution 16 --size 40 -o out.png \
  --classes classes.png --surface surface.png
form coordinate_field --cage auto --figure hexagon.svg --vertex 0 --size 40 -o out.png
form cage_weights --cage square.csv --points points.csv --labels labels.txt -o out.csv
form figure_table hexagon.svg hexagon_cage.svg hexagon_pose.svg mean-value
form figure_table inner.obj box.obj bent_box.obj mean-value
form contact_sheet -o out.svg --png --png-width 60 one hexagon.svg two red.png
form deform_mesh inner.obj --cage box.obj --pose bent_box.obj --coordinates sibson --weights corner_weights.txt -o out.obj
form deform_mesh inner.obj --cage box.obj --pins space_pins.csv --save-pose pinned.obj -o out.obj
form deform_mesh inner.ply --cage box.stl --move 0:0.1,0,0 -o out.ply
form deform_mesh inner.stl --cage box.stl --pose box.stl --save-pose saved.obj -o out.stl
form deform_mesh solid.mesh --cage box.obj --pose bent_box.obj --no-folds -o out.mesh
form make_splats inner.obj -o out.ply --count 20
form deform_splats scene.ply --cage box.obj --pose bent_box.obj --save-pose saved.obj -o out.ply
form deform_splats scene.ply --cage box.obj --pins space_pins.csv --split 1.1 -o out.ply
form draw_splats scene.ply -o out.png --beside inner.obj --width 64 --height 40
form make_box -o out.mesh --cage out_cage.obj
form make_character -o out.glb
form make_cage hexagon.svg -o out.svg --picture picture.svg --png
form make_cage hexagon.svg --lattice 3x3 -o out.lattice.json
form pose_cage hexagon_cage.svg --figure hexagon.svg --move 0:1,1 -o out.svg --picture picture.svg --png
form adaptive_grid --cage hexagon_cage.svg --figure hexagon.svg --accuracy 0.05 -o out.svg --png --png-width 60
form bind_mesh inner.obj --cage box.obj --clip box_clip.csv --labels box_labels.txt -o out.figure
form bind_mesh inner.obj --cage box.obj --pose bent_box.obj --pose-samples -o out.figure
form clone_figure bound.figure --poses box_poses.csv --rows 0:1 --mesh inner.obj -o out.ply
form clone_figure bound.figure --poses box_poses.csv --rows 0:1 --mesh inner.ply -o out.ply
form clone_figure bound.figure --poses box_clip.csv --rows 1:2 -o out.npy
form bind_tiles box.obj --points inner.obj --clip box_clip.csv -o out.figure
form bind_tiles box.obj --points inner.obj --pose bent_box.obj --coordinates harmonic --accuracy 0.1 --save-solution out.solution -o out.figure
form bind_tiles box.obj --points inner.obj --coordinates harmonic --accuracy 0.1 --solution box.solution --save-solution out.solution -o out.figure
form make_tiles inner.obj --points 10 -o out.ply
form export_gltf inner.obj --cage box.obj --clip box_clip.csv --labels box_labels.txt --skin 4 -o out.glb
form export_gltf inner.ply --cage box.stl --move 0:0.1,0,0 --bones 2 -o out.glb
form export_gltf inner.obj --cage box.obj --pose bent_box.obj --morph -o out.gltf
form export_gltf inner.obj --cage box.obj --pose bent_box.obj --bones 2 -o out.glb --picture picture.png
form fit_skeleton inner.obj bent_inner.obj turned_inner.obj -o out.glb --bones 2 --picture picture.png
form grid_field table.csv -o out.png --surface surface.png --size 40
form paths --cage hexagon_cage.svg --point 250,250 -o out.svg --png --paths 10 --rays 10 --drawn 1
form leaf_cages leaf.svg --cage leaf_cage.svg --pose leaf_pose.svg -o out.svg --png
form electron_waves --size 64x48 --mesh 0.2 --steps 8 --frames 3 -o out.png --csv out.csv --stills still_
form electron_waves --size 64x48 --mesh 0.2 --steps 8 --frames 3 --gif out.gif
form boundary_formula --cage hexagon_cage.svg --vertex 0
form relaxation line.csv -o out.svg --png --play plays.svg
form height_map hills.svg -o out.png -o out.pgm -o out.csv --lines lines.svg --size 48
form height_map hills.svg -o out.png --3d surface.png --size 48
form clone_image noon.png evening.png --region boat.svg -o out.png --poisson poisson.png --pasted pasted.png
form clone_image noon.png evening.png --region boat.svg --at 0,0 --at 6,6 --frames frame_ --gif out.gif
form diffuse_colours hills.svg -o out.png --size 48
form fit_curve --lottie curves.json --curve layers/0/ks/r/k/0:0 --pieces 2 --json out.json --plot out.svg --png
form fit_curve --cases cases.json --json out.json
form puzzle puzzle.csv --csv out.csv -o out.svg
form sphere_eversion --cage box.lattice.json --outside extend -o out.png --volume volume.svg --stills still_ --gif out.gif --frames 2 --stages 2 --rows 16 --tile 32
form plane_homotopy circle loops -o out.svg --png --columns 2 --stills still_ --gif out.gif --frames 2
form zooms koch -o out.svg --png --columns 2 --level 1 --size 32 --stills still_ --gif out.gif --frames 2
# Pictures of 1600 x 1000 pixels, and much to compute.
told="out.svg out.png"
form convergence --cage square.csv --resolution 16 -o out.svg --png
form convergence --oracle triangle.json -o out.svg --png
told=out.svg
beside=cage.obj
form convergence --oracle reference.txt -o out.svg
beside=
told="out.obj out.png"
form deform_mesh inner.obj --cage box.obj --pose bent_box.obj -o out.obj --picture out.png
form make_cage box.obj -o out.obj --picture out.png
form pose_cage box.obj --move 0:0.1,0,0 -o out.obj --picture out.png
form lattice_fit box.obj bent_box.obj --cage box.lattice.json -o out.obj --picture out.png
form pose_hand --pose hand.csv -o out.obj --picture out.png
told="out.obj saved.obj out.png"
form wrap_mesh box.obj bent_box.obj --landmarks corners.csv --cage cage.obj --save-pose saved.obj -o out.obj --picture out.png
told=out.png
form lattice_board -o out.png
told="out.glb out.png"
form skin_mesh box.obj --bones bones.csv -o out.glb --picture out.png
told=' ' # no file
form bezier_tables table.csv
told=

# ---- formats of meshes ----
mkdir -p formats
cp pool/inner.ply pool/inner.stl pool/box.stl pool/box.obj formats
cd formats || exit 1
: >empty.ply
sed '$d' inner.ply >cut.ply
tail -c +2 inner.ply >figure.ply
cp inner.stl named.obj
cp ../pool/inner.obj named.ply
cp ../pool/hexagon.svg .
mesh="$programs/deform_mesh"
for ending in ply stl; do
  works "a posed figure in .$ending" "$mesh" "inner.$ending" --cage box.stl --move 'all:0.1,0,0' -o "moved.$ending"
  grep -q '[0-9]\{9\}' "moved.$ending" && ok=no || ok=yes
  report $ok "numbers of single precision have few digits in .$ending"
  works "and moved back" "$mesh" "moved.$ending" --cage box.obj --outside extend --move 'all:-0.1,0,0' -o "back.$ending"
  [ "$(tr -d 0-9.e- <back.$ending)" = "$(tr -d 0-9.e- <inner.$ending)" ] && ok=yes || ok=no
  report $ok "all but the numbers is the same in .$ending"
  refuses "is written as .$ending, since the output has the format of the figure" "$mesh" "inner.$ending" --cage box.stl --pose box.stl -o out.obj
  works "at rest in .$ending" "$mesh" "inner.$ending" --cage box.stl --pose box.stl -o "rest.$ending"
  cmp inner.$ending rest.$ending >log 2>&1 && ok=yes || ok=no
  report $ok "the same bytes at rest in .$ending"
  works "a cage for .$ending" "$programs/make_cage" "inner.$ending" --vertices 12 -o cage.obj
  works "points on .$ending" "$programs/make_tiles" "inner.$ending" --points 10 -o points.ply
  works "a skeleton for .$ending" "$programs/fit_skeleton" "inner.$ending" "moved.$ending" "inner.$ending" --bones 1 -o fitted.glb
done
works "the contents decide" "$mesh" named.obj --cage box.stl --pose box.stl -o named.stl
works "an OBJ file with another extension" "$mesh" named.ply --cage box.stl --pose box.stl -o named_ply.obj
refuses 'hexagon.svg: holds no vertices: it looks like a file of the format SVG, which deform_svg reads' \
  "$mesh" hexagon.svg --cage box.stl --pose box.stl -o out.obj
refuses 'named.obj is written as .stl' "$mesh" named.obj --cage box.stl --pose box.stl -o out.obj
truncate -s 3G huge.glb
refuses 'huge.glb: has more than 2000 MB' "$mesh" huge.glb --cage box.stl --pose box.stl -o out.glb
rm huge.glb
refuses 'empty.ply: is empty' "$mesh" empty.ply --cage box.stl --pose box.stl -o out.ply
refuses 'cut.ply: is cut off in face 0' "$mesh" cut.ply --cage box.stl --pose box.stl -o out.ply
refuses 'figure.ply: is no PLY file' "$mesh" figure.ply --cage box.stl --pose box.stl -o out.ply
refuses 'face 1 differs: the pose box.stl' "$mesh" inner.ply --cage box.obj --pose box.stl -o out.ply
cd ..

# ---- none is forgotten ----
without_inputs="make_hand hand_sheet sibson_figures"
# Options whose words are no files. Those with a default are none either: CLI11 of Debian 13 writes TEXT [default].
words="--lattice --slice --zoom --margin --mirror --move --turn --scale --bend --twist --surround --point --at --values --css --bezier --curve
  --pin --hold --track --pinned --rows --knots --conditions --norm --blue --red --from --make --size --cells --divisions --bones --vertices --volume --area --animation --follow --morph --landmark --push-out"
for file in "$programs"/*; do
  program=${file##*/}
  case $program in [0-9]*) continue ;; esac
  if [ ! -f "$file" ] || [ ! -x "$file" ]; then continue; fi
  "$file" --help >log 2>&1
  ok=yes
  case " $without_inputs " in
    *" $program "*) ;;
    *) grep -qx "$program" formed || { ok=no; echo "no form of it is in files.sh" >>log; } ;;
  esac
  for option in $(sed -n '/ TEXT \[/d; s/^ *\(-[^ ]*\) TEXT\( .*\)*$/\1/p' log); do
    known=no
    for name in $(echo "$option" | tr , ' '); do
      grep -qxF -- "$program $name" covered && known=yes
      for word in $words; do [ "$word" != "$name" ] || known=yes; done
    done
    [ $known = yes ] || { ok=no; echo "$option: no form in files.sh gives it a file" >>log; }
  done
  report $ok "$program has its files tried"
done
cd ..
