#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Bash's completion of the program's commands, options, values and files, made of its own table of options, to standard output.
#   completion.sh PROGRAM
set -eu
program=$1
here=$(dirname "$0")
export LC_ALL=C

table=$("$program" --list-options)  # fails where the program does
echo "# Made of the options of touchable; do not change it by hand."
printf '%s\n' "$table" | awk -F '\t' -f "$here/completion.awk"
cat "$here/touchable.bash"
