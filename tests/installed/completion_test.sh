#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Asks Bash's completion what it offers.
#   completion_test.sh COMPLETION PROGRAM
set -euo pipefail
completion=$1 program=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
faults=0

load() { . "$completion"; }  # in a function, as bash-completion does it
load

# What is offered for the last of these words, in one line.
offered() {
    COMP_WORDS=(touchable "$@") COMP_CWORD=$#
    COMPREPLY=()
    _touchable
    printf '%s\n' "${COMPREPLY[@]}" | sort | paste -s -d ' '
}

expect() {  # what word...
    local wanted=$1 got
    shift
    got=$(offered "$@")
    if [[ $got != "$wanted" ]]; then
        printf 'touchable %s: offered "%s"; expected "%s"\n' "$*" "$got" "$wanted"
        faults=$((faults + 1))
    fi
}

cd "$work"
touch clip.mkv 'two words.png' motion.csv
mkdir folder

expect 'make materials' ma
expect 'play plot' pl
expect 'clip.mkv' cl
expect '--version' --v
expect 'info init-scene' help in
expect 'all camera clip facts files filters help' help info ''
expect 'globe grain' make g
expect '--json' touch --js
expect '--far --fill-from-motion --fill-holes --filters --fingers --force-on --forces --fov' touch --f
expect '' touch --nothing
expect 'clip.mkv' touch --scene cl
expect 'motion.csv' touch --forces = mo
expect 'clip.mkv folder motion.csv two words.png' touch ''
expect 'two words.png' info tw
expect 'folder' export clip.mkv --out f
expect 'auto cpu lazy reference vulkan' touch clip.mkv --builder ''
expect 'lazy' touch --builder = l
expect '' touch --fingers ''
expect '--fullscreen' clip.mkv --fu  # a file is played

expect 'depth depth-linear dynamic-friction' touch clip.mkv --show d
expect 'csv:' touch --hand c
expect 'mouse' play clip.mkv --device m
expect 'camera' help play ca
expect 'device' play --help d

# Every command of the program, every option, and every value that is one of a list.
table=$("$program" --list-options)
commands=$(awk -F '\t' '$1 == "command" && $2 != "touchable" { print $2 }' <<<"$table")
for command in $commands; do
    wanted=$(awk -F '\t' -v command="$command" '$1 == "option" && $2 == command && $3 != "Arguments" { gsub(/, /, "\n", $4); print $4 }' <<<"$table" |
        sort | paste -s -d ' ')
    expect "$wanted" "$command" -
done
values=0
while IFS=$'\t' read -r command option words; do
    expect "$(tr , '\n' <<<"$words" | sed -E 's/\[.*//; s/([:=]).*/\1/' | sort | paste -s -d ' ')" "$command" "$option" ''
    values=$((values + 1))
done < <(awk -F '\t' -v OFS='\t' '$1 == "option" && $4 ~ /^--/ && $6 != "" { print $2, $4, $6 }' <<<"$table")
[[ $(wc -w <<<"$commands") -gt 10 && $values -gt 20 ]] || { echo "few commands and values: $commands, $values"; faults=1; }
((faults == 0))
