#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Three scenes made with Blender, rendered to clips, and touched, into out/content/: ./run content (docs/content.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."

say() { printf '\n== %s\n' "$*"; }
out=out/content touchable=build/release/player/touchable
./run install blender
./run build program
mkdir -p "$out"
say "making three scenes"
blender -b --factory-startup --python-exit-code 1 -P engine/content/blender/scenes/make_scenes.py -- "$out" >/dev/null
for name in table face bowl; do
    say "rendering $name"
    blender -b "$out/$name.blend" --python-exit-code 1 -P engine/content/blender/export.py -- "$out/$name.mkv" --overwrite --touchable "$touchable"
    "$touchable" export "$out/$name.mkv" --frame 0 --out "$out/$name" --overwrite
    "$touchable" touch "$out/$name.mkv" --hand wander:extent=0.6,spread=0.02,speed=0.06,seed=4 --fingers 5 --overwrite \
        --json "$out/$name.json" --picture "$out/$name.png" --picture-at 1.6
done
say "the table as if it were a recording: relief and materials of its colour"
"$touchable" relief "$out/table.mkv" "$out/table-relief.mkv" --max-height 2 --overwrite
"$touchable" materials "$out/table-relief.mkv" "$out/table-materials.mkv" --overwrite \
    --material sponge=foam --at 508,275 --material ball=rubber --at 271,180 --material shine=rubber --at 233,139 \
    --material egg=ceramic --at 309,294 --material cup=metal --at 508,85 --material cup=metal --at 475,183 --material mat=felt --at 111,339
for name in friction height; do
    "$touchable" touch "$out/table-materials.mkv" --seconds 0.01 --overwrite --picture "$out/table-$name.png" --picture-size 720x480 --show "$name"
done
cat <<TEXT

$out/NAME.blend    table, face, bowl: open them in Blender, and look at the tab Touch of the sidebar (N)
$out/NAME.mkv      the clip: $touchable $out/table.mkv opens it
$out/NAME/         its first frame as pictures: colour, depth, haptic, height
$out/NAME.png      five fingers on it
$out/NAME.json     what they felt
$out/table-friction.png, $out/table-height.png   what materials and relief made of its colour
TEXT
