#!/bin/sh
# Bash's completion of the program's commands, options and files, made of its own help, to standard output.
#   completion.sh PROGRAM
set -eu
program=$1
here=$(dirname "$0")
export LC_ALL=C

help=$("$program" -h)  # fails where the program does
commands=$(printf '%s\n' "$help" | awk '/^Subcommands:/ { within = 1; next } within && /^  [^ ]/ { print $1 }')
test -n "$commands" || { echo "completion.sh: the help of $program names no command" >&2; exit 1; }
echo "# Made of the help of touchable; do not change it by hand."
echo "_touchable_commands='$(echo $commands) help'"
echo "declare -gA _touchable_options=() _touchable_values=() _touchable_words=()"
for command in $commands; do
    help=$("$program" help "$command")
    printf '%s\n' "$help" | awk -f "$here/../help_entries.awk" | awk -v command="$command" -f "$here/completion.awk"
done
cat "$here/touchable.bash"
