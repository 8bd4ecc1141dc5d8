#!/bin/bash
# hands.sh MARQUETRY: a person's hands at the window, by real mouse and keyboard on a screen of Xvfb: opens a
# model in the empty window, paints on it, compares, saves, opens another one by a dialog, paints again, and
# closes. On the way a list is closed by a key, and a model by its button. Run by hands_test.cpp in a folder with
# sphere.obj and other.obj. Writes window.log, where there is ffmpeg pictures of the list, and pictures of the whole
# way where SHOTS names a folder.
set -euo pipefail
marquetry=$1
mkdir bin elsewhere  # the desktop's dialogs are looked for in the first; the window is started in the other
folder=$PWD
cd elsewhere
PATH=$folder/bin "$marquetry" view --size 900x460 --scale 1 --report "$folder/report.json" > "$folder/window.log" 2>&1 &
viewer=$!
cd "$folder"
trap 'kill $viewer 2> /dev/null || true' EXIT

fail() {
  echo "hands.sh: $1" >&2
  cat window.log >&2
  exit 1
}
# shot NAME
shot() {
  [ -z "${SHOTS:-}" ] ||
    ffmpeg -v error -y -f x11grab -video_size 900x460 -i "$DISPLAY" -frames:v 1 "$SHOTS/$1.png"
}
# seen NAME: a picture of the panel, without the mouse
seen() {
  ! command -v ffmpeg > /dev/null ||
    ffmpeg -v error -y -f x11grab -draw_mouse 0 -video_size 300x440 -i "$DISPLAY" -frames:v 1 "$1.png"
}
# until WHAT COMMAND...: for twenty seconds at most
until_true() {
  local what=$1
  shift
  for _ in $(seq 200); do
    if "$@" > /dev/null 2>&1; then return; fi
    kill -0 $viewer 2> /dev/null || fail "the window closed before: $what"
    sleep 0.1
  done
  fail "twenty seconds have gone, and not: $what"
}
# again_until TEST... -- COMMAND...: the command every other second until the test is true, ten times at most; a slow
# machine may not have been ready for it
again_until() {
  local test=()
  while [ "$1" != -- ]; do
    test+=("$1")
    shift
  done
  shift
  for _ in $(seq 10); do
    "$@"
    for _ in $(seq 20); do
      if "${test[@]}"; then return; fi
      sleep 0.1
    done
  done
  fail "ten times '$*', and not: ${test[*]}"
}
titled() { [ "$(xdotool getwindowname "$window")" = "$1" ]; }
closed() { ! kill -0 $viewer 2> /dev/null; }
key() {
  xdotool key --window 0 "$1" 2> /dev/null || xdotool key "$1"
  sleep 0.3
}

window=
found() { window=$(xdotool search --onlyvisible --name marquetry | head -1) && [ -n "$window" ]; }
until_true "there is a window" found
xdotool windowmove "$window" 0 0
xdotool windowfocus "$window" || true
until_true "the empty window has its title" titled marquetry
shot start

# Open: there is no dialog here, so that the window asks for a path itself.
open_by_path() {
  key Escape  # what may have gone wrong before
  key ctrl+o
  xdotool type --delay 1 "$PWD/sphere.obj"  # at once, in place of the folder, which is selected
  key Return  # at once: what was written before counts
}
again_until titled "sphere.obj - marquetry" -- open_by_path
! grep "no frames in this folder" window.log || fail "what was written after Ctrl + O did not reach the box"
key ctrl+o
sleep 1
shot path
key Escape
! grep -E 'sphere\.(o|ob)?(:|$| )' window.log || fail "a path was opened without its last letters"

# Paint: the model is in the middle of 300 to 658.
xdotool mousemove 78 87 click 1
sleep 1
shot brush
slow_stroke() {
  xdotool mousemove 430 200 mousedown 1
  for x in 450 480 520; do xdotool mousemove $x 215; sleep 0.05; done
  xdotool mouseup 1
}
again_until titled "* sphere.obj - marquetry" -- slow_stroke
sleep 1
shot painted
again_until titled "sphere.obj - marquetry" -- key ctrl+z
key ctrl+y
until_true "a stroke is done again" titled "* sphere.obj - marquetry"
press() {
  xdotool mousemove "$1" "$2"
  sleep 0.3
  xdotool click 1
  sleep 0.5
}
again_until titled "sphere.obj - marquetry" -- press 30 250  # undo, below the brush
again_until titled "* sphere.obj - marquetry" -- press 75 250  # redo

# A turn by the right button, compare, and back: nothing is lost.
xdotool mousemove 460 300 mousedown 3 mousemove 420 280 mouseup 3
key 2
shot compared
key n
until_true "a place where the textures differ is found" grep -q "place 1 of" window.log
shot place
key f
key 3
key ctrl+s
until_true "the texture is saved" test -s filtered.png
until_true "the title says that it is saved" titled "sphere.obj - marquetry"

# Photographs are asked for: the button that begins with them is dim.
key 4
press 190 195
xdotool mousemove 200 420
sleep 7  # until what was said is gone
seen photographs_before
press 140 355
xdotool mousemove 200 420
sleep 0.5
seen photographs_after
shot photographs

# The list of what is shown, and the key that closes it.
key 1
xdotool mousemove 200 400
sleep 0.5
seen list_before
press 84 217
xdotool mousemove 200 400
sleep 0.3
seen list_open
shot list
key Escape
sleep 0.3
seen list_closed

# Back to the empty window, and to the model again.
again_until titled marquetry -- press 263 15
shot closed
again_until titled "sphere.obj - marquetry" -- open_by_path
! grep "no frames in this folder" window.log || fail "what was written after Ctrl + O did not reach the box"
key ctrl+o
sleep 1
shot path
key Escape

# Another model, by the dialog of a desktop, which is a script here.
cat > bin/zenity << END
#!/bin/sh
echo "\$@" > "$folder/dialog"
echo "$folder/other.obj"
END
chmod +x bin/zenity
key ctrl+o
until_true "the title is that of the other model" titled "other.obj - marquetry"
grep -q -- '--title=Open a model.*\*\.obj' dialog || fail "the dialog does not say what is chosen"

# A stroke on it, fast, that is asked for when the window is to close.
key 3
fast_stroke() { xdotool mousemove 440 230 mousedown 1 mousemove 470 260 mousemove 500 250 mouseup 1; }
again_until titled "* other.obj - marquetry" -- fast_stroke
key ctrl+q
sleep 0.5
shot question
closed && fail "the window closed without a question"
key Return
until_true "the second stroke is saved" test -s filtered_2.png
for _ in $(seq 200); do
  if closed; then break; fi
  sleep 0.1
done
closed || fail "twenty seconds have gone, and the window is not closed"
wait $viewer || fail "the viewer ended with status $?"
trap - EXIT
