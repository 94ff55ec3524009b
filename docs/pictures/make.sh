#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Makes the pictures of README.md and docs/play.md anew, by the program itself, without a display:
#     docs/pictures/make.sh [build/release/player/touchable [OLD_PROGRAM]]
# With an older program also views.webp: what both draw, the older above. Needs Blender and python3-pil, which
# matplotlib brings;
# views of recordings need ../../../shared/data (tests/real_data.hpp).
set -euo pipefail
touchable=$(realpath "${1:-$(dirname "$0")/../../build/release/player/touchable}")
old=${2:+$(realpath "$2")}
cd "$(dirname "$0")"
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

# Blender's own cube, and two of `./run content`'s scenes.
blender -b --factory-startup --python-exit-code 1 -P ../../engine/content/blender/scenes/make_scenes.py -- "$work" >/dev/null
blender -b --factory-startup --python-exit-code 1 \
    --python-expr "import bpy; bpy.ops.wm.save_as_mainfile(filepath='$work/cube.blend')" >/dev/null
for name in cube table face; do
    blender -b "$work/$name.blend" --python-exit-code 1 -P ../../engine/content/blender/export.py -- "$work/$name.mkv" \
        --frames 1-1 --touchable "$touchable" >/dev/null
done
cat >"$work/script" <<'SCRIPT'
0.3  move 740 450
0.5  press left
SCRIPT
"$touchable" play "$work/cube.mkv" --headless --size 1280x720 --script "$work/script" --screenshot "$work/cube.png" --at 2 >/dev/null
for name in table face; do
    "$touchable" touch "$work/$name.mkv" --hand wander:extent=0.6,spread=0.02,speed=0.06,seed=4 --seconds 3 --fingers 5 \
        --view orbit:az=30,el=18 --picture "$work/$name.png" --picture-at 1.6 >/dev/null
done
python3 - "$work" <<'PYTHON'
import sys
from PIL import Image

for made, name in (("cube", "cube"), ("table", "touched"), ("face", "face")):
    picture = Image.open(f"{sys.argv[1]}/{made}.png").convert("RGB").resize((640, 360), Image.LANCZOS)
    picture.quantize(160, dither=Image.FLOYDSTEINBERG).save(f"blender-{name}.png", optimize=True)
    print(f"blender-{name}.png")
PYTHON

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

"$touchable" touch "$work/globe.mkv" --hand wander:extent=0.4 --fingers 5 --picture demo.png --picture-at 1.2 \
    --view orbit:az=8,el=4,zoom=1.06 --picture-size 1200x760 --overwrite >/dev/null 2>&1
echo demo.png

# pack OUT MILLISECONDS FILE...: a moving picture.
pack() {
    /usr/bin/python3 - "$@" <<'PACK'
import sys
from PIL import Image
pictures = [Image.open(name).convert("RGB") for name in sys.argv[3:]]
pictures[0].save(sys.argv[1], save_all=True, append_images=pictures[1:], duration=int(sys.argv[2]), loop=0,
                 quality=60, method=6)
PACK
    echo "$1"
}

"$touchable" make globe "$work/long.mkv" --size 720x480 --frames 120 >/dev/null
{
    printf '0.2 move 285 150\n0.5 press left\n1 move 315 158\n1.5 move 350 165\n2 move 375 190\n2.4 release left\n2.5 leave\n'
    for tenth in 26 27 28 29 30 31 32 33 34 35; do echo "${tenth:0:1}.${tenth:1} turn 3"; done
    echo '4.3 quit'
} >"$work/script"
"$touchable" play "$work/long.mkv" --headless --size 600x400 --script "$work/script" --fps 12 \
    --video "$work/film-%03d.png" >/dev/null 2>&1
pack touch.webp 83 "$work"/film-*.png

[[ -n $old ]] || exit 0
data=${TOUCHABLE_DATA:-../../../shared/data}
for scene in cliffs step bumps; do "$touchable" make "$scene" "$work/$scene.mkv" --size 640x480 --frames 2 >/dev/null; done
views=("$work/globe.mkv own" "$work/globe.mkv orbit:az=30,el=8" "$work/globe.mkv orbit:az=70,el=0"
    "$work/cliffs.mkv orbit:az=25,el=10" "$work/step.mkv orbit:az=30,el=15" "$work/bumps.mkv orbit:az=-40,el=20"
    "$data/stills/redwood5 own" "$data/stills/redwood5 orbit:az=30,el=10" "$data/stills/redwood5 orbit:az=-25,el=5"
    "$data/stills/lensblur/yamasa-maneki-neko.jpg own" "$data/stills/lensblur/yamasa-maneki-neko.jpg orbit:az=20,el=5"
    "$data/stills/lensblur/greek-helmet.jpg orbit:az=-20,el=5")
for index in "${!views[@]}"; do
    read -r clip view <<<"${views[index]}"
    for program in old touchable; do
        "${!program}" touch "$clip" --seconds 0.05 --fingers 1 --picture "$work/$(printf %02d "$index")-$program.png" --view "$view" \
            --picture-size 320x200 --overwrite >/dev/null 2>&1
    done
done
/usr/bin/python3 - "$work" <<'SHEET'
import pathlib
import sys
from PIL import Image
names = sorted(pathlib.Path(sys.argv[1]).glob("*-old.png"))
sheet = Image.new("RGB", (4 * 322, 2 * 201 * 3 + 2 * 4), "white")
for index, name in enumerate(names):
    x, y = 322 * (index % 4), 406 * (index // 4)
    sheet.paste(Image.open(name), (x, y))
    sheet.paste(Image.open(str(name).replace("-old", "-touchable")), (x, y + 201))
sheet.save("views.webp", quality=80, method=6)
SHEET
echo views.webp
