# awk -f tests/plain_english.awk FILE...
# Prints the sentences of comments and of Markdown text that open with "Of", "The same", "That of" or "What", whose
# subject or verb is then missing, and lines of Markdown prose are joined first. The exit status is 1 where there are any.
function flush_text(    count, sentence, i) {
  count = split(text, sentence, /[.!?:]\)? +/)
  for (i = 1; i <= count; ++i) {
    if (sentence[i] ~ /^[*_("`-]*(Of|The same|That of|What)[ ,]/) {
      printf "%s:%d: %s\n", file, line, substr(sentence[i], 1, 90)
      ++found
    }
  }
  text = ""
}
function add(words) {
  if (text == "") line = FNR
  text = text == "" ? words : text " " words
}
FNR == 1 {
  flush_text()
  file = FILENAME
  fenced = 0
}
FILENAME ~ /\.md$/ {
  if ($0 ~ /^```/) fenced = !fenced
  if (fenced || $0 ~ /^(```|    |\||#|$|- |!\[)/) flush_text()
  if (!fenced && $0 !~ /^(```|    |!\[)/) {
    words = $0
    gsub(/^[|# -]+|\|/, " ", words)
    sub(/^ +/, "", words)
    add(words)
  }
  next
}
# Other languages: comments of whole lines, each by itself.
FILENAME !~ /\.[ch]pp$/ {
  if ($0 ~ /^ *(\/\/|\/\*|\*|#|""")/) {
    words = $0
    sub(/^ *(\/\/+|\/\*+|\*+|#+|""")[!<]* */, "", words)
    add(words)
    flush_text()
  }
  next
}
# A comment behind code, a new comment, or a line that begins an entry of a list such as "///   cost   O(n)".
/\/\/[\/!]?<? / || /^ *\/\/\/?$/ {
  words = $0
  whole = words ~ /^ *\/\//
  sub(/^.*\/\/[\/!]?<?/, "", words)
  if (!whole || words ~ /^ *$/ || words ~ /^  +[a-z_]+  +/ || words ~ /^   +[^ ]/ && words !~ /^ {10}/) flush_text()
  sub(/^  +[a-z_]+  +/, "", words)
  sub(/^ +/, "", words)
  if (words != "") add(words)
  if (!whole) flush_text()
  next
}
{ flush_text() }
END {
  flush_text()
  exit found > 0
}
