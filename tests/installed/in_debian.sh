#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a command in a clone of what is committed, in a bare root of a Debian that mmdebstrap makes and removes:
#     tests/installed/in_debian.sh SUITE COMMAND
# Exit code 77: there is no such root.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

skip() { echo "in_debian.sh: skipped: $*" >&2; exit 77; }
[[ $(id -u) == 0 ]] || skip "only root can make a root folder of Debian"
command -v mmdebstrap >/dev/null || skip "needs mmdebstrap (Debian: mmdebstrap)"
# shellcheck disable=SC2016  # apt-get replaces these
mirror=$(apt-get indextargets --format '$(ORIGIN) $(REPO_URI)' 'Created-By: Packages' | sed -n '/security/!s/^Debian //p' | head -n 1)
[[ -n $mirror ]] || skip "this machine's apt knows no mirror of Debian; apt-get update"

work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
apt-config dump Acquire | grep -E '::(Proxy|Retries|https)' >"$work/apt.conf" || true  # how this machine reaches its sources
export TMPDIR=$work checkout=$PWD made=$work/made tried=$2
# Debian's installer writes etc/hosts, mmdebstrap does not.
# shellcheck disable=SC2016  # the shell of mmdebstrap expands these
if mmdebstrap --quiet --mode=root --format=null --variant=minbase --include=git,ca-certificates --aptopt="$work/apt.conf" \
    --customize-hook='touch "$made" && echo "127.0.0.1 localhost" >"$1/etc/hosts" && git clone -q "$checkout" "$1/touchable" && chroot "$1" env -i PATH="$PATH" HOME=/root LC_ALL=C.UTF-8 sh -c "cd /touchable && $tried"' \
    "$1" - <<<"deb $mirror $1 main"; then exit 0; fi
[[ -e $made ]] || skip "mmdebstrap could not make a root (above)"
exit 1
