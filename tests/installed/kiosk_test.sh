#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The systemd unit of docs/exhibit.md: systemd accepts it, its command opens a kiosk, and it ends as the unit expects.
#   kiosk_test.sh SOURCE_DIR PROGRAM
set -euo pipefail
page=$1/docs/exhibit.md program=$2
command -v Xvfb >/dev/null || { echo "needs Xvfb (Debian: xvfb)"; exit 77; }
work=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$work"' EXIT
unit=$work/touchable.service

# The block of the page that begins with [Unit], with this program and this folder.
sed -n '/^    \[Unit\]/,/^[^ ]/s/^    //p' "$page" | sed "s|/usr/bin/touchable|$program|; s|%h|$work|g" >"$unit"
if command -v systemd-analyze >/dev/null; then
    mkdir -m 700 "$work/run"
    said=$(XDG_RUNTIME_DIR=$work/run systemd-analyze --user verify --man=no "$unit" 2>&1) || { echo "$said"; exit 1; }
    [[ $said != *"$unit"* ]] || { echo "$said"; exit 1; }
fi
command=$(sed -n 's/^ExecStart=//p' "$unit")
expected=$(sed -n 's/^SuccessExitStatus=//p' "$unit")
[[ $command && $expected ]] || { echo "$page has no unit with ExecStart and SuccessExitStatus"; exit 1; }

"$program" make globe "$work/globe.mkv" --size 64x48 --frames 4 >/dev/null
Xvfb -displayfd 3 -screen 0 640x480x24 -nolisten tcp 3>"$work/display" 2>/dev/null &
until [[ -s $work/display ]]; do kill -0 $!; sleep 0.1; done
DISPLAY=:$(<"$work/display")
export DISPLAY XDG_CONFIG_HOME=$work
$command >"$work/said" 2>&1 &
kiosk=$!
until grep -q ',start,' "$work/use.csv" 2>/dev/null; do kill -0 $kiosk || { cat "$work/said"; exit 1; }; sleep 0.1; done
kill -TERM $kiosk
status=0
wait $kiosk || status=$?
[[ $status == "$expected" ]] || { cat "$work/said"; echo "exit code $status, the unit has $expected"; exit 1; }
grep -q ',end,' "$work/use.csv"
