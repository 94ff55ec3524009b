#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What desktops and `man` think of the files that are made and written for them.
#   desktop_test.sh SHARE_SOURCE SHARE_BUILT PROGRAM
set -euo pipefail
source=$1 built=$2 program=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for tool in desktop-file-validate update-mime-database man; do
    command -v "$tool" >/dev/null || { echo "needs $tool (Debian: desktop-file-utils, shared-mime-info, man-db)"; exit 77; }
done

said=$(desktop-file-validate "$source/applications/touchable.desktop")
[[ -z $said ]] || { echo "$said"; exit 1; }

mkdir -p "$work/mime/packages"
cp "$source/mime/touchable.xml" "$work/mime/packages"
update-mime-database "$work/mime" >"$work/said" 2>&1 || { cat "$work/said"; exit 1; }
grep -q '^application/x-mcap$' "$work/mime/types"

# A page for the program and for each command, each with its options and without a word of roff's against it.
commands=$("$program" --list-options | awk -F '\t' '$1 == "command" && $2 != "touchable" { print $2 }')
pages=$(cd "$built/man" && ls)
wanted=$({ echo touchable.1.gz; printf 'touchable-%s.1.gz\n' $commands; } | sort)
diff <(LC_ALL=C sort <<<"$pages") <(LC_ALL=C sort <<<"$wanted") || { echo "these pages differ from the program's commands"; exit 1; }
for page in $pages; do
    LC_ALL=C MANROFFSEQ='' man --warnings --local-file "$built/man/$page" >"$work/page" 2>"$work/warnings"
    [[ ! -s $work/warnings ]] || { cat "$work/warnings"; exit 1; }
done
for command in $commands; do
    LC_ALL=C MANWIDTH=1000 man --local-file "$built/man/touchable-$command.1.gz" >"$work/page"
    "$program" help "$command" all | grep -o -E '^  (-[a-z], )?--[a-z-]+' | sed 's/.*--/--/' | while read -r option; do
        grep -q -E -e "(^|[ ,])$option([ ,]|\$)" "$work/page" || { echo "the page of $command lacks $option"; exit 1; }
    done
done
