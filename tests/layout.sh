#!/bin/sh
# Usage: sh tests/layout.sh AWK
# Checks what no compiler does: sentences without a subject, lines over 110 columns, documents that have grown too long,
# and how many headers and names a user meets.
set -u
cd "$(dirname "$0")/.."
awk=$1
failed=0
count() { # WHAT FOUND MOST: fails where there is more than MOST
  printf '%s: %d of at most %d\n' "$1" "$2" "$3"
  [ "$2" -le "$3" ] || failed=1
}
public=$(find include -mindepth 2 -maxdepth 3 -name '*.hpp'; find include -path '*/types/*.hpp')
faults=$(find include tests examples bench README.md \( -name '*.hpp' -o -name '*.cpp' -o -name '*.md' \) ! -path 'examples/site/*' \
  -exec "$awk" -f tests/plain_english.awk {} +)
printf '%s\n' "$faults"
count 'sentences that open with "Of", "The same", "That of" or "What"' "$(printf '%s' "$faults" | grep -c .)" 0
# A column is a character, whatever awk takes for one: continuation bytes do not count.
long=$(find include examples bench \( -name '*.hpp' -o -name '*.cpp' \) -exec env LC_ALL=C "$awk" '
  /R"\($/ { raw = 1 } { text = $0; gsub(/[\200-\277]/, "", text) } length(text) > 110 && !raw { print FILENAME ":" FNR }
  /^\)"/ { raw = 0 }' {} +)
printf '%s\n' "$long"
count 'lines over 110 columns' "$(printf '%s' "$long" | grep -c .)" 0
count 'headers that a user includes' "$(find include -mindepth 2 -maxdepth 3 -name '*.hpp' | grep -c .)" 70
# shellcheck disable=SC2086 # the list is meant to be split
count 'public names' "$("$awk" -f tests/public_names.awk $public | sort -u | grep -c .)" 260
count 'lines of README.md' "$(grep -c '' README.md)" 190
for document in include/cageform/*/README.md bench/README.md tests/README.md; do
  [ ! -f "$document" ] || count "lines of $document" "$(grep -c '' "$document")" 80
done
exit $failed
