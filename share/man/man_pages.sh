#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Manual pages of the program and of each of its commands, made of its own table of options and compressed.
#   man_pages.sh PROGRAM VERSION FOLDER      FOLDER is new or is replaced
set -eu
program=$1 version=$2 folder=$3
here=$(dirname "$0")
export LC_ALL=C

rm -rf "$folder"
mkdir -p "$folder"
table=$("$program" --list-options)  # fails where the program does
printf '%s\n' "$table" | awk -F '\t' -v version="$version" -v folder="$folder" -v description="$here/description.roff" \
    -v ending="$here/ending.roff" -f "$here/man_page.awk"
test -f "$folder/touchable-touch.1" || { echo "man_pages.sh: $program --list-options names no command" >&2; exit 1; }
gzip -9n "$folder"/*.1
