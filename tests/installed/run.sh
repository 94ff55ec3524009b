#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# A bare Debian 12 with the package alone: the program there, a program in C that links what is installed, and a wheel of
# Python's package give the same force hash.
#   run.sh DEB [WHEEL]
# Root, mmdebstrap (Debian: mmdebstrap) and the Debian sources of this machine's apt are all it takes; without them: exit code 77.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
(($# == 1 || $# == 2)) || { echo "run.sh DEB [WHEEL]" >&2; exit 2; }
for given in "$@"; do
    [[ -r $given ]] || { echo "run.sh: $given is not there" >&2; exit 2; }
done

skip() { echo "run.sh: skipped: $*" >&2; exit 77; }
[[ $(id -u) == 0 ]] || skip "only root can make a root folder of Debian"
command -v mmdebstrap >/dev/null || skip "needs mmdebstrap (Debian: mmdebstrap)"
sources=$(apt-get indextargets --format '$(ORIGIN) $(CODENAME) deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    sed -n 's/^Debian bookworm[^ ]* //p' | sort -u)
[[ -n $sources ]] || skip "this machine's apt knows no source of Debian 12 (bookworm); apt-get update"

work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
apt-config dump Acquire | grep -E '::(Proxy|Retries|https)' >"$work/apt.conf" || true  # how this machine reaches its sources

certificates=()
if [[ $sources == *https:* ]]; then certificates=(--include=ca-certificates); fi

# mmdebstrap makes the root in a folder of its own, which it removes in the end, whatever comes of the hook.
export TOUCHABLE_DEB=$(realpath "$1") TOUCHABLE_WHEEL=${2:+$(realpath "$2")} TOUCHABLE_EXAMPLES=$here/../../examples
export TOUCHABLE_ROOT_IS_THERE=$work/there
if TMPDIR=$work mmdebstrap --quiet --mode=root --format=null --variant=minbase --aptopt="$work/apt.conf" "${certificates[@]}" \
    --customize-hook="$here/in_bare_root.sh" bookworm - <<<"$sources"; then exit 0; fi
[[ -e $work/there ]] || skip "mmdebstrap could not make a root (above)"
exit 1
