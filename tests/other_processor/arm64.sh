#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Scenes and forces that are known to the bit, by Debian's compiler for 64-bit ARM, under QEMU.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

at=$PWD/build/arm64 launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake -S tests/other_processor -B "$at" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTOUCHABLE_WERROR=ON \
    -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/arm64.cmake" "${launcher[@]}"
cmake --build "$at"
qemu-aarch64 -L /usr/aarch64-linux-gnu "$at/test_other_processor"
