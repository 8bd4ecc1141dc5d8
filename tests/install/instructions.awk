# Reads objdump -d of the program: AVX and later instructions may stand in the kernels' forms alone, or the
# program would not run on a processor without them.
/^[0-9a-f]+ <.*>:$/ {
  name = $2
  allowed = name ~ /x86_64_v[34]/
  form = name ~ /x86_64_v3/ ? "v3" : name ~ /x86_64_v4/ ? "v4" : ""
  next
}
{
  mnemonic = $2
  wide = mnemonic ~ /^v/ || /%[yz]mm/ || mnemonic ~ /^(shlx|shrx|sarx|rorx|mulx|andn|bzhi|pext|pdep|movbe|lzcnt)[wlq]?$/
  if (!wide || mnemonic ~ /^ver[rw]$/) next
  if (!allowed) {
    if (!(name in reported) && ++found <= 20) print name ": " mnemonic
    reported[name] = 1
  } else {
    ++count[form]
    if (/%zmm/) ++zmm[form]
  }
}
END {
  print "kernels: " count["v3"] + 0 " instructions of v3, " count["v4"] + 0 " of v4, " zmm["v4"] + 0 " with zmm"
  if (found) { print found " functions outside of kernels have instructions that not every processor has"; exit 1 }
  if (count["v3"] < 1000 || zmm["v4"] < 100 || zmm["v3"]) { print "the forms of kernels are not what they are called"; exit 1 }
}
