#!/bin/bash
# Compares the committed list with what the header and the libraries have now.
#   compare.sh COMMITTED COMPILER HEADER LIBRARY...
set -euo pipefail
here=$(dirname "$0")
committed=$1
shift
now=$("$here/abi_list.sh" "$@")
if ! diff -u --label committed --label now "$committed" <(echo "$now"); then
    echo "touchable.h or its libraries are not what $committed says; tests/abi/README.md tells what may change" >&2
    exit 1
fi
exported=$(sed -n 's/^  \(touch_[a-z0-9_]*\)@@.*/\1/p' <<<"$now" | sort)
declared=$(sed -n '/^functions/,$ s/.*\b\(touch_[a-z0-9_]*\)(.*/\1/p' <<<"$now" | sort)
if ! diff -u --label exported --label declared <(echo "$exported") <(echo "$declared"); then
    echo "the libraries export other functions than touchable.h declares" >&2
    exit 1
fi
