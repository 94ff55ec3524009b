#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tests: ./run test [--ci | --all]. CONTRIBUTING.md says what each of them runs; CMakePresets.json has the presets.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

jobs=$(nproc)
results=build/results
presets=()

# Builds what a test preset runs, and notes how long that took. If it fails, the other builds and tests still run.
build() {  # test_preset preset [-Dname=value...] [target...]
    local name=$1 started=$SECONDS status=0
    shift
    ./run build "$@" || status=$?
    if ((status == 0)); then echo $((SECONDS - started)) >"$results/$name.built"; else echo failed >"$results/$name.built"; fi
}

# Two more tests run than there are cores: those of sessions and windows wait for their clocks most of the time.
run_tests() {  # test_preset
    presets+=("$1")
    [[ ! -e $results/$1.built || $(<"$results/$1.built") != failed ]] || return 0
    printf '\n== testing %s\n' "$1"
    ctest --preset "$1" -j "$((jobs + 2))" </dev/null || true
}

# As on a machine of half the speed: with a busy loop on each core, which ends with this script at the latest.
run_tests_at_half_speed() {  # test_preset
    local loops=() core
    for ((core = 0; core < jobs; ++core)); do
        (while kill -0 $$ 2>/dev/null; do :; done) &
        loops+=($!)
    done
    run_tests "$1"
    kill "${loops[@]}"
    wait "${loops[@]}" 2>/dev/null || true
}

case ${1:-} in
    '') ./run install tests ;;
    --ci) ./run install sanitizers ;;
    --all) ./run install everything ;;
    *) echo "test.sh: '$1' is neither --ci nor --all" >&2; exit 2 ;;
esac
rm -rf "$results"
mkdir -p "$results"
case ${1:-} in
    '')
        build every-change release every_change
        run_tests every-change ;;
    --ci)
        build every-change release -DTOUCHABLE_WERROR=ON every_change test_bench
        # The builds with sanitizers go on beside these tests, which wait for their clocks part of the time: as a process group
        # of its own, so that it ends with this script.
        set -m
        {
            renice -n 10 "$BASHPID" >/dev/null
            build every-change-asan-ubsan asan-ubsan every_change
            build every-change-tsan tsan every_change
        } </dev/null >build/sanitizers.log 2>&1 &
        set +m
        sanitizers=$!
        trap 'kill -- "-$sanitizers" 2>/dev/null || true' EXIT
        run_tests every-change
        run_tests bench
        printf '\n== waiting for the builds with sanitizers\n'
        wait "$sanitizers"
        cat build/sanitizers.log
        run_tests every-change-asan-ubsan
        run_tests every-change-tsan ;;
    --all)
        # Where there are recordings, a test without its own fails.
        if [[ -d ../shared/data ]]; then export TOUCHABLE_REQUIRE_DATA=1; fi
        build everything release -DTOUCHABLE_WERROR=ON
        run_tests everything
        run_tests_at_half_speed half-speed
        for preset in asan-ubsan tsan clang; do
            build "everything-$preset" "$preset"
            run_tests "everything-$preset"
        done
        build everything-debug debug test_{scene,content,device,haptics,golden,player,commands,judged_touch}
        run_tests everything-debug ;;
esac
tests/totals.py "$results" "$SECONDS" "${presets[@]}"
