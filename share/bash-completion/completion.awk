# SPDX-License-Identifier: Apache-2.0
# Of what `touchable --list-options` prints: Bash's tables.
#   _touchable_commands                    all commands
#   _touchable_options[COMMAND]            its options
#   _touchable_topics[COMMAND]             topics of its help
#   _touchable_values[COMMAND --option]    what its value is: FILE, FOLDER, {word word}, or anything
#   _touchable_words[COMMAND]              words that stand in the place of its first argument
# A word's part that a person fills in is left out: csv:FILE is csv:, median[=3|5] is median.
function words_of(list,    part, count, k, words) {
    count = split(list, part, ",")
    for (k = 1; k <= count; ++k) {
        if (match(part[k], /\[|:|=/)) part[k] = substr(part[k], 1, substr(part[k], RSTART, 1) == "[" ? RSTART - 1 : RSTART)
        words = words (k > 1 ? " " : "") part[k]
    }
    return words
}

function quoted(words) {
    gsub(/'/, "'\\''", words)
    return "'" words "'"
}

BEGIN { print "declare -gA _touchable_options=() _touchable_topics=() _touchable_values=() _touchable_words=()" }
$1 == "command" && $2 != "touchable" { commands = commands (commands == "" ? "" : " ") $2 }
$1 != "option" || $2 == "touchable" { next }
$3 == "Arguments" {
    if (!($2 in first) && $6 != "") print "_touchable_words[" $2 "]=" quoted(words_of($6))
    first[$2]
    next
}
{
    if (index(" " topics[$2] " ", " " tolower($3) " ") == 0) topics[$2] = topics[$2] " " tolower($3)
    count = split($4, name, ", ")
    for (k = 1; k <= count; ++k) {
        options[$2] = options[$2] " " name[k]
        if ($5 == "") continue
        value = $6 != "" ? "{" words_of($6) "}" : $5 ~ /FOLDER/ ? "FOLDER" : $5 ~ /FILE/ ? "FILE" : "anything"
        print "_touchable_values[" quoted($2 " " name[k]) "]=" quoted(value)
    }
}
END {
    count = split(commands, command, " ")
    for (k = 1; k <= count; ++k) {
        print "_touchable_options[" command[k] "]=" quoted(substr(options[command[k]], 2))
        print "_touchable_topics[" command[k] "]=" quoted(substr(topics[command[k]], 2) " all")
    }
    print "_touchable_commands=" quoted(commands " help")
}
