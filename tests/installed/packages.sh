#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The Debian package and the wheel, made as a person makes them, give in a bare Debian the forces that the program gives. Exit code 77:
# there is no such Debian (run.sh).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

./run deb
./run wheel
exec tests/installed/run.sh build/release/touchable_*.deb out/touchable-*_x86_64.whl
