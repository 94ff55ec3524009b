#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Every parser, or one TARGET, under libFuzzer, AddressSanitizer and UBSan: ./run fuzz [MINUTES [TARGET]]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

die() { printf 'run: %s\n' "$*" >&2; exit 2; }

# A row of the table from a target's log: runs, runs per second, edges reached, most MiB, and the file that a fault left. No run is a fault.
fuzz_row() {  # target log cuts
    awk -v target="$1" -v cuts="$3" '
        /^#[0-9]+/ { for (k = 1; k < NF; ++k) if ($k == "cov:") edges = $(k + 1) }
        /^stat::number_of_executed_units:/ { runs = $2 }
        /^stat::average_exec_per_sec:/ { rate = $2 }
        /^stat::peak_rss_mb:/ { memory = $2 }
        /Test unit written to/ { fault = $NF }
        END { printf "%-16s %8s %10d %8d %7d %5d %6d  %s\n", target, cuts, runs, rate, edges, memory, fault != "" || !runs, fault }' "$2"
}

# Every seed of a target cut at every length, and then libFuzzer from its seeds and from what earlier runs found. Memory: a target may
# take 512 MiB beyond the 64 MiB of a picture that a small file may hold, plus its own and AddressSanitizer's.
fuzz_target() {  # program target most_bytes most_mebibytes seconds
    local program=$1 target=$2 log=$PWD/out/fuzz/logs/$2 cuts
    mkdir -p "out/fuzz/corpus/$target" out/fuzz/faults
    # On a fault or a timeout the input in hand is written to out/fuzz/faults.
    if ! cuts=$(cd out/fuzz/faults && ASAN_OPTIONS=handle_abort=1 timeout --signal ABRT 600 "$program" "--cuts=$target" 2>"$log"); then
        echo "Test unit written to out/fuzz/faults/cut-of-$target" >>"$log"
        fuzz_row "$target" "$log" fault
        return
    fi
    # A small quarantine: libFuzzer counts freed blocks that AddressSanitizer keeps as memory of the target.
    ASAN_OPTIONS=quarantine_size_mb=4:allocator_release_to_os_interval_ms=-1 nice -n 10 \
        "$program" "--target=$target" -max_total_time="$5" -max_len="$3" -timeout=60 -report_slow_units=60 -malloc_limit_mb="$4" -rss_limit_mb=900 -print_final_stats=1 -print_funcs=0 -entropic=0 \
        -artifact_prefix="out/fuzz/faults/$target-" "out/fuzz/corpus/$target" "tests/fuzz/seeds/$target" >"$log" 2>&1 || true
    fuzz_row "$target" "$log" "$cuts"
}

minutes=${1:-4} only=${2:-} program=$PWD/build/fuzz/tests/fuzz/touchable-fuzz jobs=$(nproc)
[[ $minutes =~ ^[0-9]+$ && $minutes -gt 0 ]] || die "'$minutes' is not a number of minutes; must be a whole number, such as ./run fuzz 30"
./run install sanitizers
echo 'int main() {}' | clang++ -x c++ -fsanitize=fuzzer-no-link,address - -o /dev/null ||
    die "clang++ has no libFuzzer; on Debian: apt-get install --no-install-recommends libclang-rt-dev"
./run build fuzz touchable-fuzz
mkdir -p out/fuzz/logs
list=$("$program" --list | awk -v only="$only" 'only == "" || $1 == only')
[[ -n $list ]] || die "there is no target '$only'; there are $("$program" --list | cut -d ' ' -f 1 | xargs)"
seconds=$((minutes * 60 * jobs / $(wc -l <<<"$list")))
((seconds > 0)) || seconds=1
printf '\n== fuzzing, %d s each\n' "$seconds"
export -f fuzz_target fuzz_row
# shellcheck disable=SC2016  # the inner bash expands these
xargs -P "$jobs" -L 1 bash -c 'fuzz_target "$0" "$2" "$3" "$4" "$1"' "$program" "$seconds" <<<"$list" | tee out/fuzz/table
printf '\n== summary\n%-16s %8s %10s %8s %7s %5s %6s\n' target cuts runs runs/s edges MiB faults
sort out/fuzz/table
! awk '$7 != 0' out/fuzz/table | grep -q .
