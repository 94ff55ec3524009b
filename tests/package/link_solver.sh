#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Another project links the solver, which is built without FFmpeg, Vulkan and CLI11, and touches with it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

at=$PWD/build/solver
cmake -S . -B "$at" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTOUCHABLE_PARTS=solver -DCMAKE_INSTALL_PREFIX="$at/installed"
cmake --build "$at"
cmake --install "$at" >/dev/null
cmake -S tests/package -B "$at/package" -G Ninja -DCMAKE_PREFIX_PATH="$at/installed"
cmake --build "$at/package"
"$at/package/touch_a_hill"
