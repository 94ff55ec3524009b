#!/bin/bash
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
        printf 'touchable %s: offered "%s"; right would be "%s"\n' "$*" "$got" "$wanted"
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
expect '' help info ''
expect 'globe grain' make g
expect '--json' touch --js
expect '--fill-from-motion --fill-holes --filters --fingers --force-on --forces --fov' touch --f
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

# Every command of the program, and every option of its help.
commands=$("$program" -h | awk '/^Subcommands:/ { within = 1; next } within && /^  [^ ]/ { print $1 }')
for command in $commands; do
    wanted=$("$program" help "$command" | grep -o '^  -[a-z,-]*' | tr ', ' '\n\n' | grep -e - | sort | paste -s -d ' ')
    expect "$wanted" "$command" -
done
[[ $(wc -w <<<"$commands") -gt 10 ]] || { echo "the help names few commands: $commands"; faults=1; }
((faults == 0))
