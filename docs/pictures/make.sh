#!/bin/bash
# Makes the pictures of README.md and docs/play.md anew, by the program itself, without a display:
#     docs/pictures/make.sh [build/release/player/touchable]
set -euo pipefail
cd "$(dirname "$0")"
touchable=$(realpath "${1:-../../build/release/player/touchable}")
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
"$touchable" make globe "$work/globe.mkv" --size 720x480 --frames 40 2>/dev/null

# picture NAME SECONDS OPTION...: the window, SECONDS after it opened, once the script from standard input was done to it.
picture() {
    local name=$1 seconds=$2
    shift 2
    cat >"$work/script"
    "$touchable" play "$work/globe.mkv" --headless --script "$work/script" \
        --screenshot "$name.png" --at "$seconds" --overwrite "$@" >/dev/null
    echo "$name.png"
}

picture window 3 --size 800x450 <<'SCRIPT'
0.1  play-pause
0.2  seek 1
0.4  move 470 150
1.0  press left
2.6  move 502 158
SCRIPT

# After the first press the window no longer hints how to press.
picture research 3 --size 1000x560 <<'SCRIPT'
0.1  play-pause
0.2  seek 1
0.3  move 300 250
0.4  press left
0.5  release left
0.6  panel
0.8  overlay depth
1.0  measure 260,150 330,330
2.0  move 560 240
2.6  move 562 240
SCRIPT

picture kiosk 4 --size 800x450 --kiosk --kiosk-texts en --idle 1 60 </dev/null

cat >"$work/labels.json" <<'LABELS'
{"touchable_labels": 1, "labels": [
    {"caption": {"en": "Grassland: firm, and a little rough"}, "rectangle": [0, 0, 719, 479]}]}
LABELS
picture label 4 --size 800x450 --kiosk --kiosk-texts en --labels "$work/labels.json" <<'SCRIPT'
0.1  play-pause
0.2  seek 1
0.4  move 310 290
1.0  press left
SCRIPT

# The trial lasts ten seconds at least, the touch before the question twenty.
picture study-question 37 --size 960x540 --kiosk --kiosk-texts en --study paper-4.2 --results "$work/results" <<'SCRIPT'
0.5  continue
1.0  continue
1.5  answer 2
2.0  continue
13.0 continue
13.5 continue
34.5 continue
35.0 answer 6
SCRIPT
