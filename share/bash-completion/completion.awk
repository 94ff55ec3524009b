# Of what help_entries.awk makes of `touchable help COMMAND`: three entries of Bash's tables.
#   _touchable_options[COMMAND]            all options
#   _touchable_values[COMMAND --option]    what its value is: FILE, FOLDER, {word,word}, or anything
#   _touchable_words[COMMAND]              words that stand in the place of its first argument
/^[A-Z].*:$/ {
    positional = $0 == "Positionals:"
    next
}
positional && match($0, /\tone of [a-z, ]+/) {
    words = substr($0, RSTART + 8, RLENGTH - 8)
    gsub(/,/, "", words)
    print "_touchable_words[" command "]='" words "'"
}
/^  -/ {
    head = substr($0, 3)
    sub(/\t.*/, "", head)
    sub(/ (Excludes|Needs): .*/, "", head)
    count = split(head, part, " ")
    names = split(part[1], name, ",")
    for (k = 1; k <= names; ++k) {
        options = options " " name[k]
        if (count == 1) continue
        value = part[2]
        if (match(value, /\{[^}]*\}/)) value = substr(value, RSTART, RLENGTH)
        else if (value ~ /FOLDER/) value = "FOLDER"
        else if (value ~ /FILE/) value = "FILE"
        else value = "anything"
        print "_touchable_values['" command " " name[k] "']='" value "'"
    }
}
END { print "_touchable_options[" command "]='" substr(options, 2) "'" }
