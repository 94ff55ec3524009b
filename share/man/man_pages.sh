#!/bin/sh
# Manual pages of the program and of each of its commands, made of its own help and compressed.
#   man_pages.sh PROGRAM VERSION FOLDER      FOLDER is new or is replaced
set -eu
program=$1 version=$2 folder=$3
here=$(dirname "$0")
export LC_ALL=C

rm -rf "$folder"
mkdir -p "$folder"
help=$("$program" -h)  # fails where the program does
printf '%s\n' "$help" | awk -f "$here/../help_entries.awk" | awk -v version="$version" -v description="$here/description.roff" -v ending="$here/ending.roff" \
    -f "$here/man_page.awk" >"$folder/touchable.1"
commands=$(printf '%s\n' "$help" | awk '/^Subcommands:/ { within = 1; next } within && /^  [^ ]/ { print $1 }')
test -n "$commands" || { echo "man_pages.sh: the help of $program names no command" >&2; exit 1; }
for command in $commands; do
    help=$("$program" help "$command")
    printf '%s\n' "$help" | awk -f "$here/../help_entries.awk" | awk -v command="$command" -v version="$version" -f "$here/man_page.awk" >"$folder/touchable-$command.1"
done
gzip -9n "$folder"/*.1
