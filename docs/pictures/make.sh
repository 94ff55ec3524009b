#!/bin/bash
# Makes the pictures of docs/play.md and of the README anew, by the program itself, without a display:
#     docs/pictures/make.sh [build/release/player/touchable]
set -euo pipefail
cd "$(dirname "$0")"
touchable=$(realpath "${1:-../../build/release/player/touchable}")
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
"$touchable" make globe "$work/globe.mkv" --size 720x480 --frames 60

# picture NAME SECONDS OPTION...: the window, SECONDS after it opened, once the script from standard input was done to it.
picture() {
    local name=$1 seconds=$2
    shift 2
    cat >"$work/script"
    "$touchable" play "$work/globe.mkv" --headless --size 800x450 --script "$work/script" \
        --screenshot "$name.png" --at "$seconds" --overwrite "$@" >/dev/null
}

# A finger presses; the first seconds of words are over.
picture window 5 <<'SCRIPT'
0.1  play-pause
0.2  seek 1
0.3  turn 18
0.3  tilt 8
3.5  move 372 196
3.8  press left
4.6  move 380 200
SCRIPT

picture research 5 <<'SCRIPT'
0.1  play-pause
0.2  seek 1
0.3  panel
0.4  overlay depth
1.0  measure 300,150 420,260
4.0  move 300 160
4.6  move 302 160
SCRIPT

picture kiosk 4 --kiosk --kiosk-texts en --idle 1 60 </dev/null

cat >"$work/labels.json" <<'LABELS'
{"touchable_labels": 1, "labels": [
    {"caption": {"en": "Land: it is rough, and does not give way"}, "rectangle": [0, 0, 719, 479]}]}
LABELS
picture label 4 --kiosk --kiosk-texts en --labels "$work/labels.json" <<'SCRIPT'
0.1  move 380 200
0.3  press left
SCRIPT
