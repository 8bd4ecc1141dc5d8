# Turns the cpp blocks of a page of docs/ into one source: what they include in front, the rest as the body of one
# function, in the order of the page, so that a snippet sees what those before it made. Errors name the page's lines.
#   awk -v page=docs/library.md -v name=library -v out=library.cpp -f snippets.awk docs/library.md
/^```/ {
  if (inside) inside = 0
  else if ($0 == "```cpp") { inside = 1; begins = 1; ++blocks }
  else other = !other
  next
}
inside && /^#include|^using namespace/ { head = head place() $0 "\n"; begins = 1; next }
inside {
  if (begins) { body = body place(); begins = 0 }
  body = body $0 "\n"
}
function place() { return "#line " NR " \"" page "\"\n" }
END {
  if (!blocks) { print page ": no cpp block" > "/dev/stderr"; exit 1 }
  print "// Made of the snippets of " page "." > out
  split("atomic cstdio filesystem string utility vector", headers, " ")
  for (i = 1; i <= 6; ++i) print "#include <" headers[i] ">" > out
  print head "void snippets_of_" name "();\nvoid snippets_of_" name "() {" > out
  print body "}" > out
}
