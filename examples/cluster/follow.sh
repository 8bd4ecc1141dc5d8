#!/bin/sh
# Follows a sequence of meshes in parts, as many at once as there are cores, and joins them.
#
#     follow.sh PARTS SEQUENCE OUT.evolving [options of track]
#     follow.sh 8 captured/ walk.evolving --remesh --frames 1-400
#
# Parts are kept beside the result, OUT.part_3.evolving. A part that was stopped goes on where it was; delete one to have
# it made anew. With GNU parallel's --sshlogin the parts run on several machines that share a folder; without GNU parallel
# xargs runs them here.
set -eu
parts=$1 sequence=$2 whole=$3
shift 3
program=${MARQUETRY:-marquetry}
part=${whole%.evolving}.part_%d.evolving
commands=$(mktemp)
trap 'rm -f "$commands"' EXIT

quoted() { printf "'%s' " "$(printf %s "$1" | sed "s/'/'\\\\''/g")"; }

for number in $(seq "$parts"); do
  for word in "$program" track "$sequence" -o "$part" --shard "$number/$parts" --resume --threads 1 "$@"; do quoted "$word"; done
  echo
done > "$commands"
if command -v parallel > /dev/null; then
  parallel --halt soon,fail=1 < "$commands"
else
  xargs -d '\n' -P "$(nproc)" -I{} sh -c {} < "$commands"
fi
"$program" track "$sequence" -o "$whole" --motion "$part" "$@"
