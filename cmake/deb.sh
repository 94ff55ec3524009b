#!/usr/bin/env bash
# The Debian package of program and libraries: ./run deb (docs/install.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

./run install deb
rm -f build/release/touchable_*.deb
./run build program deb
