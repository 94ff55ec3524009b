#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The portable archive runs where nothing is installed, and on older and newer systems than the one that built it, with the force
# hash of the program that was built, and opens a window there. Exit code 77: there are no such systems.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
skip() { echo "portable.sh: skipped: $*" >&2; exit 77; }
[[ $(id -u) == 0 ]] || skip "only root can make a root folder"
command -v mmdebstrap >/dev/null || skip "needs mmdebstrap (Debian: mmdebstrap)"
# shellcheck disable=SC2016  # apt-get replaces these
mirror=$(apt-get indextargets --format '$(ORIGIN) $(REPO_URI)' 'Created-By: Packages' | sed -n '/security/!s/^Debian //p' | head -n 1)
[[ -n $mirror ]] || skip "this machine's apt knows no mirror of Debian; apt-get update"

./run portable
./run wheel
archive=$(echo out/touchable-*-linux-x86_64.tar.xz) program=build/release/player/touchable
work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
mkdir "$work/its folder"
tar -C "$work/its folder" -xf "$archive"
unpacked=$(basename "$work"/its\ folder/*)
/usr/bin/python3 -m zipfile -e out/touchable-*_x86_64.whl "$work/its folder/wheel"
if [[ $(</etc/os-release) == *'VERSION_ID="12"'* ]]; then  # a Python keeps the C library and libstdc++ that it has: RHEL 9's are these
    media=("$work/its folder/$unpacked/lib/libtouchable-media.so.0")
    mapfile -t -O 1 media < <(ldd "${media[0]}" | sed -n "s/.* => \(.*\/$unpacked\/.*\) (.*/\1/p")
    for newest in GLIBC_2.34 GLIBCXX_3.4.29; do
        needs=$(objdump -T "${media[@]}" | grep -oE "${newest%_*}_[0-9.]+" | sort -V | tail -1)
        [[ $needs == "$newest" ]] || { echo "libtouchable-media or a library that it needs wants $needs, newer than $newest" >&2; exit 1; }
    done
fi
touching=(touch /tmp/globe.mkv --hand wander:extent=0.4,seed=2 --fingers 3 --json /tmp/report.json --overwrite)
hash_in() { sed -n 's/.*"force_hash": "\([0-9a-f]\{16\}\)".*/\1/p' "$1/tmp/report.json"; }
say() { printf '\n== %s\n' "$*"; }
expect_hash() {  # where folder
    [[ $(hash_in "$2") == "$expected" ]] || { echo "$1: force hash '$(hash_in "$2")', not $expected" >&2; exit 1; }
    say "$1: force hash $expected"
}

mkdir "$work/built" "$work/built/tmp"
"$program" make globe "$work/built/tmp/globe.mkv" --size 320x240 --frames 30 --bits 16
"$program" touch "$work/built/tmp/globe.mkv" "${touching[@]:2:4}" --json "$work/built/tmp/report.json" >/dev/null
expected=$(hash_in "$work/built")
[[ -n $expected ]] || { echo "the report has no force hash" >&2; exit 1; }

run_in() {  # root: makes a clip and touches it, as a person who may not write to the archive, with others' libraries on the path
    mkdir -p "$1/tmp" "$1/hostile"
    chmod 1777 "$1/tmp"
    rm -f "$1"/tmp/{globe.mkv,report.json}
    for library in libc.so.6 libstdc++.so.6 libavutil.so.57 libz.so.1; do echo none >"$1/hostile/$library"; done
    for words in "make globe /tmp/globe.mkv --size 320x240 --frames 30 --bits 16" "${touching[*]}"; do
        # shellcheck disable=SC2086  # words
        chroot --userspec=65534:65534 "$1" "/its folder/$unpacked/bin/touchable" $words >/dev/null
    done
}
export LD_LIBRARY_PATH=/hostile HOME=/tmp
chmod -R a-w,a+rX "$work/its folder"

mkdir "$work/empty"
cp -a "$work/its folder" "$work/empty"
run_in "$work/empty"
expect_hash "an empty root, as another user, with a hostile LD_LIBRARY_PATH" "$work/empty"

unset LD_LIBRARY_PATH
apt-config dump Acquire | grep -E '::(Proxy|Retries|https)' >"$work/apt.conf" || true
for suite in bullseye trixie forky; do
    root=$work/$suite options=()
    # A newer Debian's key comes with the one before it. The lists of a release to come may be old where the mirror is.
    if [[ $suite == forky ]]; then
        echo 'Acquire::Check-Valid-Until "false";' >"$work/valid.conf"
        options=(--keyring="$work/trixie/usr/share/keyrings" --aptopt="$work/valid.conf")
    fi
    packages=xvfb
    if [[ $suite != bullseye ]]; then packages+=,mesa-vulkan-drivers,python3-numpy; fi
    mmdebstrap --quiet --mode=root --variant=minbase --include=$packages --aptopt="$work/apt.conf" "${options[@]}" \
        "$suite" "$root" "deb $mirror $suite main" || skip "mmdebstrap could not make $suite (above)"
    cp -a "$work/its folder" "$root"
    LD_LIBRARY_PATH=/hostile run_in "$root"
    expect_hash "$suite" "$root"
    mount --bind /dev "$root/dev"
    mount -t proc proc "$root/proc"
    say "$suite: a window"
    chroot "$root" sh -c "Xvfb :97 -screen 0 1280x800x24 >/dev/null 2>&1 & server=\$!; sleep 2
        DISPLAY=:97 '/its folder/$unpacked/bin/touchable' play /tmp/globe.mkv --seconds 3 --painter mesh --screenshot /tmp/window.png
        code=\$?; kill \$server; exit \$code" || failed=yes
    if [[ $suite != bullseye ]]; then
        for site in "/its folder/$unpacked/python" "/its folder/wheel"; do
            PYTHONPATH=$site TOUCHABLE_MEDIA=/its\ folder/$unpacked chroot "$root" python3 -c 'import touchable
print(touchable.open("/tmp/globe.mkv").touch([[0, 0, -0.1]] * 50).force_n.shape)' || failed=yes
        done
    fi
    umount -l "$root/dev" "$root/proc"
    [[ -z ${failed:-} && -s $root/tmp/window.png ]] || { echo "$suite: no window, or no Python module" >&2; exit 1; }
    cp "$root/tmp/window.png" "${TOUCHABLE_KEEP:-$work}/window-$suite.png"
done
