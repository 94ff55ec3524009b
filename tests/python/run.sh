#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the wheel of the library in a build folder, installs it in a virtual environment, and runs the tests there, with that
# folder's libtouchable-media; then those on arrays without it:
#     tests/python/run.sh BUILD_DIR
# Exit code 77: Debian's Python lacks what the tests need.
set -euo pipefail
build=$(realpath "${1:?which folder was built? run.sh build/release}")
source=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../..")
python=/usr/bin/python3  # Debian's, which has its packages
packages="python3-build python3-setuptools python3-wheel python3-venv python3-pip python3-matplotlib"  # with numpy, PIL; python3-distributed, without which some tests are left out
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg

for needed in build setuptools wheel pip venv numpy matplotlib PIL; do
    "$python" -c "import $needed" 2>/dev/null || { echo "$python has no $needed (Debian: $packages)"; exit 77; }
done

# In a copy, so that two builds do not meet and nothing is left in the source.
cp -rL "$source/python" "$source/CMakeLists.txt" "$work"
TOUCHABLE_LIBRARIES=$build/capi/wheel "$python" -m build --wheel --no-isolation --outdir "$work/wheel" "$work/python" \
    >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
"$python" -m venv --system-site-packages --without-pip "$work/venv"
"$work/venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-index --no-deps "$work"/wheel/*.whl

cd "$work"  # where no folder `touchable` stands in the way
unset PYTHONPATH LD_LIBRARY_PATH
export TOUCHABLE_WHEEL=$(echo "$work"/wheel/*.whl) TOUCHABLE_PROGRAM=$build/player/touchable TOUCHABLE_SOURCE=$source
export TOUCHABLE_LIBRARIES=$build/capi
TOUCHABLE_MEDIA=$build/capi "$work/venv/bin/python" "$source/tests/python/run_tests.py"
unset TOUCHABLE_PROGRAM GTEST_FILTER
TOUCHABLE_MEDIA=$work "$work/venv/bin/python" "$source/tests/python/run_tests.py"
