#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The Debian package of program and libraries: ./run deb (docs/install.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Reproducible: times in the package are the commit's.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CMakeLists.txt)}
export SOURCE_DATE_EPOCH
./run install deb
rm -f build/release/touchable_*.deb
./run build program deb
