# shellcheck shell=sh disable=SC2086,SC2154 # command_line.sh has set what is not set here
# Sourced by command_line.sh: clone_image.
clone="$programs/clone_image"
mkdir -p cloned
cd cloned || exit 1
works "pictures to clone between" "$clone" --make . --size 64
same() { # WHAT FILE FILE
  cmp -s "$2" "$3" && ok=yes || ok=no
  report $ok "$1"
}
works "a boat in the evening" "$clone" noon.png evening.png --region boat.svg -o boat.png --poisson exact.png --pasted pasted.png --report
grep -q 'set-up: .* s; a move: .* ms' log && grep -q 'differ by at most [0-9]*, in the mean by' log && ok=yes || ok=no
report $ok "the report says how long, and how far"
for file in boat.png exact.png pasted.png; do
  [ "$(head -c 4 $file | tail -c 3)" = PNG ] && ! cmp -s $file evening.png && ok=yes || ok=no
  report $ok "$file is a picture of its own"
done
works "a boat where it is" "$clone" noon.png noon.png --region boat.svg -o itself.png
same "cloning a picture into itself changes nothing" noon.png itself.png
works "a way of places" "$clone" noon.png evening.png --region boat.svg --at 0,0 --at 24,8 --steps 3 --frames way_ -o strip.png
[ "$(echo way_*)" = "way_01.png way_02.png way_03.png way_04.png" ] && [ -s strip.png ] && ok=yes || ok=no
report $ok "each place has a frame"
works "its third place" "$clone" noon.png evening.png --region boat.svg --at 16,5 -o third.png
same "a place of many is that place alone" way_03.png third.png
works "with threads" "$clone" noon.png evening.png --region boat.svg --at 16,5 -o threads.png --threads 3
same "threads change nothing" third.png threads.png
works "a mask" "$clone" noon.png evening.png --region noon.png -o masked.png
printf '10,10\n50,10\n50,40\n10,40\n\n20,20\n30,20\n30,30\n20,30\n' >ring.csv
works "a region with a hole" "$clone" noon.png evening.png --region ring.csv -o ring.png --report
grep -q '2 loops of' log && ok=yes || ok=no
report $ok "the hole has an outline"

refuses_clone() { # MESSAGE WORD…
  message=$1; shift
  refuses "$message" "$clone" noon.png evening.png "$@"
}
refuses_clone '--region is required' -o out.png
refuses_clone 'give -o, --frames or --gif' --region boat.svg
refuses_clone 'does not end with .png' --region boat.svg -o out.jpg
refuses_clone '"3" is not a pixel X,Y' --region boat.svg --at 3 -o out.png
refuses_clone '"3,4.5" is not a pixel X,Y' --region boat.svg --at 3,4.5 -o out.png
refuses_clone '"nan,4" is not a pixel X,Y' --region boat.svg --at nan,4 -o out.png
refuses_clone '"1e300,4" is not a pixel X,Y' --region boat.svg --at 1e300,4 -o out.png
refuses_clone '--at 40,0: the region, ' --region boat.svg --at 40,0 -o out.png
refuses_clone 'beyond its right side; X from 0 to ' --region boat.svg --at 40,0 -o out.png
refuses_clone '2 beyond its left side, 1 beyond its top' --region boat.svg --at=-2,-1 -o out.png
refuses_clone '--steps' --region boat.svg --at 0,0 --steps 0 -o out.png
refuses_clone 'missing.svg' --region missing.svg -o out.png
refuses_clone 'missing/out.png' --region boat.svg -o missing/out.png
refuses_clone 'missing/' --region boat.svg --frames missing/out_
refuses_clone 'it is the same file as noon.png' --region boat.svg -o noon.png
"$clone" --make small --size 32 >/dev/null
refuses 'small/noon.png: the mask has 32 x 24 pixels, and the source 64 x 48' "$clone" noon.png evening.png --region small/noon.png -o out.png
refuses 'the target is too small' "$clone" noon.png small/evening.png --region boat.svg -o out.png
refuses 'without --at: the region, ' "$clone" noon.png small/evening.png --region boat.svg -o out.png
outline() { # MESSAGE LINES
  printf '%b' "$2" >outline.csv
  refuses_clone "$1" --region outline.csv -o out.png
}
outline 'outline.csv: the outline reaches (70, 10), outside the source of 64 x 48 pixels' '10,10\n70,10\n10,40\n'
outline "outline.csv: the outline contains no centre of a pixel" '10.1,10.1\n10.3,10.1\n10.2,10.3\n'
outline 'outline.csv: the region has no inside' '10,10\n40,10\n40,12\n10,12\n'
outline 'outline.csv' ''
outline 'outline.csv:2: ' '10,10\nx,12\n'
# A black picture of 1 x 1 pixels, and pictures that are none.
echo iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg== | base64 -d >black.png
refuses 'black.png: the mask is empty' "$clone" black.png evening.png --region black.png -o out.png
refuses 'evening.png: the mask has' "$clone" black.png evening.png --region evening.png -o out.png
head -c 100 noon.png >cut.png
refuses 'cut.png: is a damaged PNG file' "$clone" cut.png evening.png --region boat.svg -o out.png
refuses 'boat.svg: is not a PNG file' "$clone" boat.svg evening.png --region boat.svg -o out.png
refuses 'boat.svg: is not a PNG file' "$clone" noon.png boat.svg --region boat.svg -o out.png
: >empty.png
refuses 'empty.png: the file is empty' "$clone" noon.png empty.png --region boat.svg -o out.png
refuses 'missing.png' "$clone" missing.png evening.png --region boat.svg -o out.png
refuses '.: is a folder' "$clone" . evening.png --region boat.svg -o out.png
# A header of 60000 x 60000 pixels, without any.
printf '\211PNG\r\n\032\n\0\0\0\rIHDR\0\0\352\140\0\0\352\140\010\006\0\0\0\0\0\0\0' >huge.png
refuses 'huge.png: holds 60000 x 60000 pixels; 100 million are the most' "$clone" huge.png evening.png --region boat.svg -o out.png
refuses 'give a source and a target' "$clone" noon.png --region boat.svg -o out.png
refuses 'source excludes --make' "$clone" noon.png --make out.folder
refuses 'cannot make the folder noon.png/out' "$clone" --make noon.png/out
refuses '--size' "$clone" --make out.folder --size 4
cd ..
