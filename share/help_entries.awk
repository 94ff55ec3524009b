# What `touchable help COMMAND` prints, with each entry on one line: two spaces, its head, a tab, what it says. There the text
# begins in column 31, or on a line of its own where the head is too long.
function finish() {
    if (entry != "") print "  " head(entry) "\t" substr(entry, 31)
    entry = ""
}

function head(line) {
    line = substr(line, 3, 27)
    sub(/ +$/, "", line)
    return line
}

/^                              [^ ]/ && entry != "" {
    print entry "\t" substr($0, 31)
    entry = ""
    next
}
{ finish() }
/^  [^ ]/ {
    entry = $0
    next
}
{ print }
END { finish() }
