#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The wheels, made as a person makes them, pass the tests on arrays with the same forces in bare roots without FFmpeg: by pip in Debian
# 12 (numpy 1) and 13 (numpy 2), and for 64-bit ARM under QEMU. Exit code 77: there are no such roots.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

skip() { echo "wheels.sh: skipped: $*" >&2; exit 77; }
[[ $(</etc/os-release) == *'VERSION_ID="12"'* ]] || skip "the wheel for any Linux is made on Debian 12"
[[ $(id -u) == 0 ]] || skip "only root can make a root folder of Debian"
command -v mmdebstrap >/dev/null || skip "needs mmdebstrap (Debian: mmdebstrap)"
# shellcheck disable=SC2016  # apt-get replaces these
mirror=$(apt-get indextargets --format '$(ORIGIN) $(REPO_URI)' 'Created-By: Packages' | sed -n '/security/!s/^Debian //p' | head -n 1)
[[ -n $mirror ]] || skip "this machine's apt knows no mirror of Debian; apt-get update"

./run wheel
./run wheel aarch64
work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
apt-config dump Acquire | grep -E '::(Proxy|Retries|https)' >"$work/apt.conf" || true  # how this machine reaches its sources
program='from common import hill, stroke; import touchable; depth, camera = hill(); print(touchable.Surface(depth, camera).touch(stroke(camera)).force_hash)'

try() {  # suite architecture machine mmdebstrap-option...
    local root=$work/$1-$2 inside='' python
    mmdebstrap --quiet --mode=root --architectures="$2" --aptopt="$work/apt.conf" "${@:4}" "$1" "$root" "deb $mirror $1 main" ||
        skip "mmdebstrap could not make a root (above)"
    mkdir "$root/source"
    cp -r --parents docs/python.md examples/python tests/python "$root/source"
    cp out/touchable-*_"$3".whl "$root"
    if [[ $3 == aarch64 ]]; then  # what was unpacked here runs by QEMU alone: no pip
        inside=$root
        /usr/bin/python3 -m zipfile -e "$root"/*.whl "$root/site"
        python=(qemu-aarch64 -L "$root" -E LD_LIBRARY_PATH=/usr/lib/aarch64-linux-gnu/blas:/usr/lib/aarch64-linux-gnu/lapack "$root/usr/bin/python3")
    else
        chroot "$root" sh -c 'python3 -m venv --system-site-packages venv && venv/bin/pip install --quiet --no-index --no-deps *.whl'
        python=(chroot "$root" /venv/bin/python)
    fi
    export TOUCHABLE_SOURCE=$inside/source PYTHONPATH=$inside/site:$inside/source/tests/python
    "${python[@]}" -c 'import numpy, sys; print("\n== Python", sys.version.split()[0], "numpy", numpy.__version__)'
    "${python[@]}" "$inside/source/tests/python/run_tests.py"
    "${python[@]}" -c "$program" | tee -a "$work/hashes"
}
with=--include=python3-venv,python3-pip,python3-numpy,python3-pil
try bookworm amd64 x86_64 --variant=minbase $with
try trixie amd64 x86_64 --variant=minbase $with
try bookworm arm64 aarch64 --variant=extract --include=python3,python3-numpy,python3-pil
[[ $(sort -u "$work/hashes" | wc -l) == 1 ]] || { echo "the force hashes differ" >&2; exit 1; }
