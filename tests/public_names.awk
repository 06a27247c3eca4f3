# Prints the public names that headers declare, as FILE:NAME: those in namespace cageform, or in a namespace in it other
# than detail. Neither a forward declaration nor the definition of a member outside its class counts.
# Usage: awk -f tests/public_names.awk $(find include -name '*.hpp')
FNR == 1 { depth = 0; hidden = 0; raw = 0 }
/R"\($/ { raw = 1 } # the text of a shader is no C++
raw { if (/^\)"/) raw = 0; next }
/^namespace [a-z_:A-Z ]*\{/ {
    ++depth
    if (!hidden && $0 ~ /detail/) hidden = depth
    next
}
/^} \/\/ namespace/ {
    if (hidden == depth) hidden = 0
    --depth
    next
}
hidden || depth == 0 { next }
/^#|^\/\/|^}|^template|^ |^$|^using namespace|^static_assert|^extern|^public:|^private:|^protected:|^requires/ { next }
/^(class|struct) [A-Za-z_0-9]+;|; \/\/ (in|there) / { next }
function say(name) { if (name !~ /^operator|^CAGEFORM/) print FILENAME ":" name }
{
    line = $0
    gsub(/\[\[[a-z]*\]\] |alignas\([a-zA-Z0-9()]*\) /, "", line)
    sub(/^enum class /, "enum ", line)
    if (line !~ /^using /) sub(/ = .*/, ";", line)
}
line ~ /^(class|struct|enum|concept|using) / {
    split(line, word, /[ :<;]/)
    say(word[2])
    next
}
line ~ />::[A-Za-z_0-9~]+\(/ { next } # of a class template
{
    if (match(line, /[A-Za-z_0-9]+\(/)) say(substr(line, RSTART, RLENGTH - 1))
    else if (match(line, /[A-Za-z_0-9]+(\{.*\})?;/)) { name = substr(line, RSTART); sub(/[^A-Za-z_0-9].*/, "", name); say(name) }
}
