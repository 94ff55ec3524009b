#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The Python package with libtouchable in it, for pip: ./run wheel [aarch64] (docs/python.md). Made on Debian 12 it fits any Linux
# since glibc 2.34. aarch64: by the cross compiler, for 64-bit ARM.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

machine=${1:-$(uname -m)} group=wheel options=(-DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 -DTOUCHABLE_PARTS=wheel)
if [[ $machine != "$(uname -m)" ]]; then group=cross options+=(-DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/arm64.cmake"); fi
if command -v ccache >/dev/null; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
# The same bytes from the same commit: times in the wheel are the commit's.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CMakeLists.txt)}
export SOURCE_DATE_EPOCH
./run install $group
cmake -S . -B "build/wheel-$machine" -G Ninja "${options[@]}"
cmake --build "build/wheel-$machine" --target touchable_wheel
# Built from a copy, so that nothing is left in the source.
at=out/wheel
rm -rf "$at" out/touchable-*linux*"_$machine.whl"
mkdir -p "$at"
cp -rL python CMakeLists.txt "$at"  # with the licence, which is a link
TOUCHABLE_LIBRARIES=$PWD/build/wheel-$machine/capi/wheel /usr/bin/python3 -m build --wheel --no-isolation --outdir out "$at/python" >"$at/log" 2>&1 ||
    { cat "$at/log" >&2; exit 1; }
rm -rf "$at"
echo "$(echo out/touchable-*linux*"_$machine.whl"): pip install it where there is numpy"
