# A manual page (roff) of what help_entries.awk makes of `touchable help COMMAND`, or, without `command`, of `touchable -h`.
#   awk -v command=touch -v version=0.2.0 -f man_page.awk entries > touchable-touch.1

function plain(text) {  # as roff takes it: no dash that becomes a hyphen, no dot or quote that begins a request
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    gsub(/\^/, "\\(ha", text)
    gsub(/'/, "\\(aq", text)
    sub(/^\./, "\\\\\\&.", text)
    return text
}

# "--a --b": in bold, with commas.
function names(list) {
    gsub(/ /, ", ", list)
    return "\\fB" plain(list) "\\fR"
}

function section(title) {
    if (title == "Positionals") print ".SH ARGUMENTS"
    else if (title == "Options") print ".SH OPTIONS"
    else if (title == "Subcommands") print ".SH COMMANDS"
    else print ".SS " plain(title)
    within = title
}

# --name TYPE=default ... REQUIRED Needs: --a Excludes: --b --c
function entry(head, text,    name, type, needs, excludes, value) {
    if (match(head, / Excludes: .*/)) {
        excludes = substr(head, RSTART + 11)
        head = substr(head, 1, RSTART - 1)
    }
    if (match(head, / Needs: .*/)) {
        needs = substr(head, RSTART + 8)
        head = substr(head, 1, RSTART - 1)
    }
    sub(/ REQUIRED$/, "", head)
    name = head
    sub(/ .*/, "", name)
    type = substr(head, length(name) + 2)
    if (match(type, /^(TEXT|FLOAT|FILE|WORD|MS|N)(:\{[^}]*\})?=/)) {
        value = substr(type, RLENGTH + 1)
        type = substr(type, 1, RLENGTH - 1)
    }
    if (type ~ / x 2$/) {
        sub(/ x 2$/, "", type)
        type = type " " type
    }
    if (type ~ /:\{.*\}/) {
        sub(/^[A-Z]*:\{/, "", type)
        sub(/\}/, "", type)
        gsub(/,/, "|", type)
    }
    gsub(/,/, ", ", name)
    print ".TP"
    if (within == "Positionals") print "\\fI" plain(name) "\\fR"
    else if (within == "Subcommands") print "\\fBtouchable\\-" plain(name) "\\fR(1)"
    else print "\\fB" plain(name) "\\fR" (type == "" ? "" : " \\fI" plain(type) "\\fR")
    text = plain(text)
    if (value != "" && text !~ /\(default /) text = text " (default " plain(value) ")"
    print text (needs excludes == "" ? "" : ".")
    if (needs != "") print "Only with " names(needs) "."
    if (excludes != "") print "Not with " names(excludes) "."
}

NR == 1 {
    page = command == "" ? "touchable" : "touchable-" command
    title = toupper(page)
    print ".TH " plain(title) " 1 \"\" \"touchable " version "\" \"User Commands\""
    print ".SH NAME"
    sub(/\.$/, "")
    print plain(page) " \\- " plain(tolower(substr($0, 1, 1)) substr($0, 2))
    next
}
/^Usage: / {
    print ".SH SYNOPSIS"
    sub(/^Usage: /, "")
    if (command == "") {
        print ".B touchable\n\\fIFILE\\fR [\\fIOPTIONS\\fR]\n.br"
        print ".B touchable\n\\fICOMMAND\\fR [\\fIOPTIONS\\fR] ..."
        print ".SH DESCRIPTION"
        while ((getline line < description) > 0) print line
        next
    }
    words = "touchable " command
    print ".B " words "\n" plain(substr($0, length(words) + 2))
    next
}
/^[A-Z].*:$/ {
    section(substr($0, 1, length($0) - 1))
    next
}
/^  [^ ]/ {
    split(substr($0, 3), part, "\t")
    entry(part[1], part[2])
}
END {
    if (command != "") {
        print ".SH NOTES\nFiles that are called docs/... here lie in the folder share/doc/touchable beside the folder of the program."
        print ".SH SEE ALSO\n.BR touchable (1)"
    } else {
        while ((getline line < ending) > 0) print line
    }
}
