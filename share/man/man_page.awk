# SPDX-License-Identifier: Apache-2.0
# Manual pages (roff) of what `touchable --list-options` prints: a file in `folder` for the program and for each command.
#   awk -F '\t' -v version=0.2.0 -v folder=man -v description=... -v ending=... -f man_page.awk table

function plain(text) {  # as roff takes it: no dash that becomes a hyphen, no dot or quote that begins a request
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    gsub(/\^/, "\\(ha", text)
    gsub(/'/, "\\(aq", text)
    sub(/^\./, "\\\\\\&.", text)
    return text
}

function out(line) { print line > file }

function finish(    line) {
    if (file == "") return
    if (examples != "" && command != "") out(".SH EXAMPLES\n.nf\n" plain(examples) ".fi")
    if (command != "") {
        out(".SH NOTES\nFiles that are called docs/... here lie in the folder share/doc/touchable beside the folder of the program.")
        out(".SH SEE ALSO\n.BR touchable (1)")
    } else {
        out(".SH COMMANDS\n" commands)
        while ((getline line < ending) > 0) out(line)
    }
    close(file)
}

# A pass over the whole table for the commands, which the program's own page lists first.
{ kind[NR] = $1; name[NR] = $2; third[NR] = $3; fourth[NR] = $4; value[NR] = $5; text[NR] = $7 }

$1 == "command" && $2 != "touchable" { commands = commands ".TP\n\\fBtouchable\\-" plain($2) "\\fR(1)\n" plain($3) "\n" }

function begin(row,    page, line) {
    finish()
    sub(/\.$/, "", third[row])
    command = name[row] == "touchable" ? "" : name[row]
    page = command == "" ? "touchable" : "touchable-" command
    file = folder "/" page ".1"
    topic = examples = ""
    out(".TH " plain(toupper(page)) " 1 \"\" \"touchable " version "\" \"User Commands\"")
    out(".SH NAME\n" plain(page) " \\- " plain(tolower(substr(third[row], 1, 1)) substr(third[row], 2)))
    out(".SH SYNOPSIS")
    if (command == "") {
        out(".B touchable\n\\fIFILE\\fR [\\fIOPTIONS\\fR]\n.br")
        out(".B touchable\n\\fICOMMAND\\fR [\\fIOPTIONS\\fR] ...")
        out(".SH DESCRIPTION")
        while ((getline line < description) > 0) out(line)
    } else {
        out(".B touchable " command "\n" plain(substr(fourth[row], length("touchable " command) + 2)))
    }
}

function option(row) {
    if (topic != third[row]) {
        if (third[row] == "Arguments") out(".SH ARGUMENTS")
        else if (topic == "" || topic == "Arguments") out(".SH OPTIONS")
        if (third[row] != "Arguments") out(".SS " plain(third[row]))
        topic = third[row]
    }
    out(".TP")
    out((topic == "Arguments" ? "\\fI" : "\\fB") plain(fourth[row]) "\\fR" (value[row] == "" ? "" : " \\fI" plain(value[row]) "\\fR"))
    out(plain(text[row]))
}

END {
    for (row = 1; row <= NR; ++row) {
        if (kind[row] == "command") begin(row)
        else if (kind[row] == "option") option(row)
        else if (kind[row] == "example") examples = examples third[row] "\n"
    }
    finish()
}
