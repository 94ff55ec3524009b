# Of what `touchable help COMMAND` prints: three entries of Bash's tables.
#   _touchable_options[COMMAND]            all options
#   _touchable_values[COMMAND --option]    what its value is: FILE, FOLDER, {word,word}, or anything
#   _touchable_words[COMMAND]              words that stand in the place of its first argument
/^[A-Z].*:$/ {
    positional = $0 == "Positionals:"
    next
}
positional && match($0, /  one of [a-z, ]+/) {
    words = substr($0, RSTART + 9, RLENGTH - 9)
    gsub(/,/, "", words)
    print "_touchable_words[" command "]='" words "'"
}
/^  -/ {
    head = substr($0, 3)
    if (substr($0, 29, 2) == "  ") head = substr($0, 3, 26)
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
