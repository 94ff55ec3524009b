#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs all benchmarks with --quick, into out/bench/, and makes one page of them: ./run bench [--compare OLD] (README.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
out=out/bench

die() { printf 'run bench: %s\n' "$*" >&2; exit 2; }

# What cannot be compared is refused now, not after half an hour of measuring.
if (($#)); then
    [[ $1 == --compare ]] || die "unknown option '$1'; there is only --compare OLD"
    (($# == 2)) || die "--compare needs one file or folder of earlier records: --compare OLD"
    [[ -r $2 ]] || die "--compare '$2' cannot be read; must be a file of records or a folder of such files"
    [[ $(realpath "$2")/ != "$(realpath -m "$out")"/* ]] || die "--compare '$2': this run writes there; copy the earlier records elsewhere first"
fi
./run install tests
(($# == 0)) || /usr/bin/python3 bench/plot.py count "$2"
./run build release touchable-bench
mkdir -p "$out"
failed=() code=0
for suite in touch surface gpu loop paper live play targets; do
    printf '\n== benchmark %s\n' "$suite"
    rm -f "$out/$suite.json"
    build/release/bench/touchable-bench "$suite" --quick --json "$out/$suite.json" || { code=$?; failed+=("$suite"); }
done
/usr/bin/python3 bench/plot.py report "$out" "$out/report.html" "$@"
printf '\n%s/%s/report.html has all of it\n' "$PWD" "$out"
((code == 0)) || printf 'run bench: failed or missed a target: %s; see above\n' "${failed[*]}" >&2
exit $code
