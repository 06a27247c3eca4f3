# Prints the public names that headers declare: those in namespace cageform, or in a namespace in it other than detail.
# Usage: awk -f tests/public_names.awk $(find include -name '*.hpp') | sort -u
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
/^#|^\/\/|^}|^template|^ |^$|^using namespace|^static_assert|^extern|^public:|^private:|^protected:/ { next }
function say(name) { if (name !~ /^operator|^CAGEFORM/) print name }
/^(class|struct|enum class|concept|using) / {
    line = $0
    sub(/^enum class /, "enum ", line)
    sub(/\[\[[a-z]*\]\] /, "", line)
    split(line, word, /[ :<;]/)
    say(word[2])
    next
}
{
    line = $0
    sub(/^\[\[[a-z]*\]\] /, "", line)
    if (match(line, /[A-Za-z_0-9]+\(/)) say(substr(line, RSTART, RLENGTH - 1))
    else if (match(line, /[A-Za-z_0-9]+(\{.*\})?( = .*)?;$/)) { name = substr(line, RSTART); sub(/[^A-Za-z_0-9].*/, "", name); say(name) }
}
