#!/bin/sh
# Usage: sh tests/layout.sh AWK
# Checks what no compiler checks: lines over 110 columns, the length of documents, and the number of public
# headers and names. Also checks that public headers contain no implementation.
set -u
cd "$(dirname "$0")/.."
awk=$1
failed=0
count() { # WHAT FOUND MOST: fails if FOUND exceeds MOST
  printf '%s: %d of at most %d\n' "$1" "$2" "$3"
  [ "$2" -le "$3" ] || failed=1
}
# A new coordinate type needs no higher limit: its header does not count, and each table of types may have a row for it.
types=$(sed -n 's|^#include <\(cageform/coordinates/.*\)>|include/\1|p' include/cageform/coordinates/types.hpp)
included=$(find include -mindepth 2 -maxdepth 3 -name '*.hpp' | grep -vxF "$types") # by users
# Columns are characters in any locale: continuation bytes do not count.
long=$(find include examples bench \( -name '*.hpp' -o -name '*.cpp' \) -exec env LC_ALL=C "$awk" '
  FNR == 1 { raw = 0 } /R"\($/ { raw = 1 } { text = $0; gsub(/[\200-\277]/, "", text) } length(text) > 110 && !raw { print FILENAME ":" FNR }
  /^\)"/ { raw = 0 }' {} +)
printf '%s\n' "$long"
count 'lines over 110 columns' "$(printf '%s' "$long" | grep -c .)" 0
# Macros defined by windows.h and its includes; min and max are function-like macros there.
words="near|far|small|hyper|interface|pascal|cdecl|ABSOLUTE|ALTERNATE|CALLBACK|CONST|DELETE|DIFFERENCE|DOMAIN|DUPLICATE|ERROR|FALSE|FAR|IGNORE|IN|INFINITE|INTERFACE|NEAR|OPAQUE|OPTIONAL|OUT|OVERFLOW|PLANES|PURE|REGISTERED|RELATIVE|RGB|STRICT|THIS|TRANSPARENT|TRUE|UNDERFLOW|VOID|WINDING|CreateFont|DrawText|FindText|GetMessage|GetObject|LoadImage|MoveMemory|SendMessage|Yield"
macros=$(find include -name '*.hpp' -exec env LC_ALL=C "$awk" -v words="$words" '
  /R"[a-z]*\(/ { raw = 1 }
  { text = $0; gsub(/"([^"\\]|\\.)*"/, "", text); sub(/\/\/.*/, "", text) }
  !raw && text ~ "(^|[^A-Za-z0-9_])((" words ")([^A-Za-z0-9_]|$)|(min|max)[(])" { print FILENAME ":" FNR ": " $0 }
  /\)[a-z]*"/ { raw = 0 }' {} +)
printf '%s\n' "$macros"
count 'words that windows.h defines' "$(printf '%s' "$macros" | grep -c .)" 0
count 'headers that a user includes' "$(printf '%s\n' "$included" | grep -c .)" 78
# Public headers contain no implementation; it is in subfolders.
# shellcheck disable=SC2086 # the lists are meant to be split
machinery=$(grep -lE 'namespace (.*[: ])?detail([: ].*)?\{' $included)
printf '%s\n' "$machinery"
count 'of them that declare into namespace detail' "$(printf '%s' "$machinery" | grep -c .)" 0
# Public names are those in namespace cageform, wherever their header lies, but none in a folder detail/. A .impl.hpp
# defines functions that other headers declare.
names=$(find include -name '*.hpp' ! -name '*.impl.hpp' -exec "$awk" -f tests/public_names.awk {} + | grep -vF "$types")
count 'public names' "$(printf '%s\n' "$names" | sed 's/.*://' | sort -u | grep -c .)" 460
hidden=$(printf '%s\n' "$names" | grep '/detail/')
printf '%s\n' "$hidden"
count 'of them in folders detail/' "$(printf '%s' "$hidden" | grep -c .)" 0
private=$(grep -rnE 'include <cageform/.*detail/|cageform::detail' examples --include='*.hpp' --include='*.cpp' --include='*.md')
printf '%s\n' "$private"
# The page adds functions to the C interface, so it uses the objects of that.
count 'uses of detail in examples/' "$(printf '%s' "$private" | grep -c .)" 2
rows=$(printf '%s\n' "$types" | grep -c .)
count 'lines of README.md' "$(grep -c '' README.md)" $((191 + rows))
for document in include/cageform/*/README.md bench/README.md tests/README.md; do
  [ ! -f "$document" ] || count "lines of $document" "$(grep -c '' "$document")" 100
done
exit $failed
