#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The add-on as a zip file that Blender installs: ./run addon (docs/content.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."

./run install addon
at=out/addon
rm -rf "$at"
mkdir -p "$at/touchable_clips"
cp engine/content/blender/*.py "$at/touchable_clips"
(cd "$at" && /usr/bin/python3 -m zipfile -c ../touchable-blender.zip touchable_clips)
rm -rf "$at"
echo "out/touchable-blender.zip: in Blender, Edit > Preferences > Add-ons > Install from Disk (before 4.2: Install)"
