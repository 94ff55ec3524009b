#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The Python package with the libraries in it, for pip: ./run wheel (docs/python.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# The same bytes from the same commit: times in the wheel are the commit's.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CMakeLists.txt)}
export SOURCE_DATE_EPOCH
./run install wheel
./run build program touchable_shared touchable_media_shared
# Built from a copy, so that nothing is left in the source.
at=out/wheel
rm -rf "$at" out/touchable-*.whl
mkdir -p "$at"
cp -rL python CMakeLists.txt "$at"  # with the licence, which is a link
TOUCHABLE_LIBRARIES=$PWD/build/release/capi /usr/bin/python3 -m build --wheel --no-isolation --outdir out "$at/python" >"$at/log" 2>&1 ||
    { cat "$at/log" >&2; exit 1; }
rm -rf "$at"
echo "$(echo out/touchable-*.whl): pip install --no-index --no-deps it, into a virtual environment with numpy"
