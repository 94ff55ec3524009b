#!/bin/bash
# What programs that are built already rely on, to standard output: the symbols of the libraries, size and offsets (bytes)
# of structs, constants, and functions as they are declared.
#   abi_list.sh COMPILER HEADER LIBRARY...
set -euo pipefail
export LC_ALL=C
compiler=$1 header=$2
shift 2
here=$(dirname "$0")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

echo "# Made by: cmake --build build/release --target abi_list. A change here breaks programs: see tests/abi/README.md."
for library in "$@"; do
    printf '\n%s\n' "$(readelf -d "$library" | sed -n 's/.*Library soname: \[\(.*\)\]/\1/p')"
    nm -D --defined-only "$library" | awk '$2 != "A" { print "  " $3 }' | sort
done

printf '\nstructs: member offset size\n'
"$compiler" -x c -std=c11 -E -P "$header" >"$work/header.c"
awk -f "$here/struct_layout.awk" "$work/header.c" >"$work/layout.c"
"$compiler" -x c -std=c11 -I "$(dirname "$header")" "$work/layout.c" -o "$work/layout"
"$work/layout"

printf '\nconstants\n'
"$compiler" -x c -std=c11 -E -dM "$header" | awk '$2 ~ /^TOUCH_/ && $2 != "TOUCH_API" && $2 != "TOUCH_VERSION" { print "  " $2 " " $3 }' | sort

printf '\nfunctions; those that are marked "Not yet stable" in the header may change\n'
# In the order of the header; its comments are read for the mark, its declarations for all else.
awk '
    /\/\*/ { comment = "" }
    { if (/\/\*/ || within) comment = comment " " $0 }
    /\/\*/ { within = 1 }
    /\*\// { within = 0 }
    /^TOUCH_API/ { declaration = ""; reading = 1; unstable = comment ~ /Not yet stable/ }
    reading { declaration = declaration " " $0 }
    reading && /;/ {
        gsub(/ +/, " ", declaration)
        sub(/^ TOUCH_API /, "", declaration)
        sub(/;.*/, "", declaration)
        print "  " declaration (unstable ? "    [not yet stable]" : "")
        reading = 0
    }
' "$header"
