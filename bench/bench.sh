#!/usr/bin/env bash
# Runs all benchmarks with --quick, into out/bench/: ./run bench (README.md)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

./run install tests
./run build release touchable-bench
mkdir -p out/bench
for suite in touch surface gpu loop paper live play targets; do
    printf '\n== benchmark %s\n' "$suite"
    build/release/bench/touchable-bench "$suite" --quick --json "out/bench/$suite.json"
done
/usr/bin/python3 bench/plot.py gpu out/bench/gpu.json out/bench/gpu.html
