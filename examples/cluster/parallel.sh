#!/bin/sh
# Runs a verb over a sequence in parts, as many at once as there are cores, and puts their reports together.
#
#     parallel.sh PARTS WHOLE.json VERB WORDS... --frames RANGE
#     parallel.sh 4 whole.json filter scan.obj in_%04d.png -o out_%04d.png --strength 50% --frames 1-60
#
# A part that is done is not run again: delete its report, WHOLE.json.part_3_of_4, to have it made anew. With GNU
# parallel's --sshlogin the parts run on several machines that share a folder; without GNU parallel xargs runs them here.
set -eu
parts=$1 whole=$2
shift 2
program=${MARQUETRY:-marquetry}
commands=$(mktemp)
trap 'rm -f "$commands"' EXIT

quoted() { printf "'%s' " "$(printf %s "$1" | sed "s/'/'\\\\''/g")"; }

for part in $(seq "$parts"); do
  report=$whole.part_${part}_of_$parts
  [ ! -e "$report" ] || continue
  {
    quoted "$program"
    for word in "$@" --shard "$part/$parts" --threads 1 --report "$report"; do quoted "$word"; done
    echo
  } >> "$commands"
done
if command -v parallel > /dev/null; then
  parallel --halt soon,fail=1 < "$commands"
else
  xargs -d '\n' -P "$(nproc)" -I{} sh -c {} < "$commands"
fi
"$program" merge "$whole".part_*_of_"$parts" -o "$whole"
