#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Whether programs that are built already go on working with the libraries as they are now (README.md).
#   abi.sh check|write COMPILER HEADER RECORDED LIBRARY...
# abidiff (Debian: abigail-tools) compares the header's functions, structs and constants with the recorded ones. The libraries must
# export exactly the header's functions.
set -euo pipefail
export LC_ALL=C
what=$1 compiler=$2 header=$3 recorded=$4
shift 4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# A library in C of the header alone: each stable function with an empty body, constants as an enumeration.
{
    printf '#include "%s"\nenum touch_constants {\n' "$header"
    "$compiler" -x c -std=c11 -E -dM "$header" |
        sed -n 's/^#define \(TOUCH_[A-Z0-9_]*\) .*/\1/p' | grep -vx -e TOUCH_API -e TOUCH_VERSION | sort | sed 's/.*/    VALUE_OF_& = &,/'
    printf '};\nvoid touch_constants(enum touch_constants value);\nvoid touch_constants(enum touch_constants value) { (void)value; }\n'
    awk '
        /\/\*/ { comment = "" }
        { if (/\/\*/ || within) comment = comment " " $0 }
        /\/\*/ { within = 1 }
        /\*\// { within = 0 }
        /^TOUCH_API/ { declaration = ""; reading = 1 }
        reading { declaration = declaration " " $0 }
        reading && /;/ {
            reading = 0
            sub(/;.*/, " { for (;;) {} }", declaration)
            gsub(/[ *]+/, " ", comment)  # the words may stand on two lines
            if (comment !~ /Not yet stable/) print declaration
        }' "$header"
} >"$work/header.c"
(cd "$work" && "$compiler" -x c -std=c11 -g -w -fPIC -shared -nostdlib -Wl,-soname,libtouchable.so.0 header.c -o libtouchable.so)

if [[ $what == write ]]; then
    abidw --no-corpus-path --no-comp-dir-path --no-show-locs "$work/libtouchable.so" >"$recorded"
    exit
fi
nm -D --defined-only "$@" | sed -n 's/.* T \(touch_[a-z0-9_]*\)@@.*/\1/p' | sort >"$work/exported"
"$compiler" -x c -std=c11 -E -P "$header" | grep -oE '\btouch_[a-z0-9_]+ ?\(' | tr -d ' (' | sort -u >"$work/declared"
diff -u --label exported --label declared "$work/exported" "$work/declared" || {
    echo "the libraries export other functions than touchable.h declares" >&2
    exit 1
}
abidiff --no-added-syms --no-show-locs "$recorded" "$work/libtouchable.so" || {
    echo "touchable.h is not what $recorded says; tests/abi/README.md says what may change" >&2
    exit 1
}
