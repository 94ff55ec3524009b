#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# libtouchable.a is whole, and defines no name that could be another program's.
#   archive_test.sh ARCHIVE COMPILER SOURCE_DIR
set -euo pipefail
archive=$1 compiler=$2 sources=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# T, D, B, R: code and data that may be there once in a program. Templates of others are weak, or unique.
foreign=$(nm --defined-only --extern-only "$archive" | awk '$2 ~ /^[TDBR]$/ && $3 !~ /^touch_/ { print $3 }' | sort -u |
    c++filt | grep -v -E '(^|[ (*&])touchable::|^(vtable|typeinfo|typeinfo name|guard variable) for touchable::' || true)
if [[ -n $foreign ]]; then
    printf '%s\n' "$archive defines names outside of namespace touchable:" "$foreign" >&2
    exit 1
fi

# With all of its objects, a C program needs nothing but the C++ runtime.
"$compiler" -x c -std=c11 -I "$sources/capi" "$sources/examples/c/touch_hill.c" -x none \
    -Wl,--whole-archive "$archive" -Wl,--no-whole-archive -lm -o "$work/hill"
"$work/hill" | grep -q touching
