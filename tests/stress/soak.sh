#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The stress suites of the touch solver: ./run soak [OPTION...], options of touchable-soak (docs/paper.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

./run install tests
./run build release touchable-soak
exec build/release/tests/stress/touchable-soak "$@"
