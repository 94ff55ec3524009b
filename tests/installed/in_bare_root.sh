#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What run.sh does in its bare root, a hook of mmdebstrap.
#   in_bare_root.sh ROOT
set -euo pipefail
root=$1
# Whatever follows goes into that folder: it has to be a root of its own.
[[ -x $root/usr/bin/apt-get && ! $root -ef / ]] || { echo "in_bare_root.sh: '$root' is no root folder of Debian" >&2; exit 2; }

touch "$TOUCHABLE_ROOT_IS_THERE"  # what fails from here on is a fault of what is installed
say() { printf '\n== %s\n' "$*"; }
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C DEBIAN_FRONTEND=noninteractive "$@"; }
# By the root's own apt, inside: nothing of this machine changes.
install() {
    inside apt-get -q -q --yes --no-install-recommends -o Dpkg::Use-Pty=0 install "$@" >"$root/root/apt.log" 2>&1 ||
        { cat "$root/root/apt.log" >&2; return 1; }
}
hash_of_report() { sed -n 's/.*"force_hash": "\([0-9a-f]\{16\}\)".*/\1/p' "$root/root/report.json"; }

expect_hash() {  # who hash
    say "$1: force hash $2"
    [[ $2 == "$expected" ]] || { echo "$1 has not the hash of the program, $expected" >&2; exit 1; }
}

say "installing $(basename "$TOUCHABLE_DEB") with what it depends on"
cp "$TOUCHABLE_DEB" "$root/root"
install "/root/$(basename "$TOUCHABLE_DEB")"
inside sh -c '! command -v cc gcc g++ clang python3' || { echo "the root is not bare" >&2; exit 1; }

say "the program alone"
inside sh -c 'cd /root && touchable make globe demo.mkv && touchable touch demo.mkv --forces forces.csv --json report.json'
expected=$(hash_of_report)
[[ -n $expected ]] || { echo "the report has no force hash" >&2; exit 1; }

say "a program in C"
install gcc libc6-dev pkg-config
cp "$TOUCHABLE_EXAMPLES/c/touch_clip.c" "$root/root"
inside sh -c 'cd /root && cc touch_clip.c $(pkg-config --cflags --libs touchable-media) -o touch_clip'
expect_hash "the program in C" "$(inside sh -c 'cd /root && ./touch_clip demo.mkv forces.csv')"

if [[ -n $TOUCHABLE_WHEEL ]]; then
    say "the wheel"
    install python3-venv python3-pip python3-numpy
    cp "$TOUCHABLE_WHEEL" "$root/root"
    cp "$(dirname "$0")/touch_clip.py" "$root/root"
    inside python3 -m venv --system-site-packages /root/venv
    inside sh -c 'cd /root && venv/bin/pip install --quiet --no-index --no-deps *.whl'
    expect_hash "Python" "$(inside sh -c 'cd /root && venv/bin/python touch_clip.py demo.mkv forces.csv')"
fi
