#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Proves what device/force_gate.h promises, for all doubles, and checks that no promise is proved of a gate that breaks it: ./run prove
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

if ! command -v frama-c >/dev/null && ! grep -qs '^VERSION_ID="12"' /etc/os-release; then
    echo "prove.sh: Frama-C is not installed, and of Debian's releases only 12 has it (frama-c-base): the gate of forces is not proved here" >&2
    exit 77
fi
command -v frama-c >/dev/null || ./run install proof

gates=$(mktemp -d)
trap 'rm -r "$gates"' EXIT
claims=(1 2 3 4 5 6 7 8)

# Whether a claim of tests/proof/force_gate.c holds of the gate in a folder. What Frama-C's simplifier, Qed, cannot show counts as
# not proved; what it cannot read ends this script.
proves() {  # folder claim
    local log=$1/$2.log
    frama-c -inline-calls force_gate "-cpp-extra-args=-I$1 -DCLAIM=$2" tests/proof/force_gate.c \
        -wp -wp-fct claim -wp-model Typed+float -warn-special-float none -wp-prover qed >"$log" 2>&1 || true
    if grep -q '\[Qed\] Goal typed_claim_check_holds : Valid' "$log"; then return 0; fi
    if grep -q '\[Failed\] Goal typed_claim_check_holds$' "$log"; then return 1; fi
    echo "prove.sh: Frama-C did not say whether claim $2 holds:" >&2
    cat "$log" >&2
    exit 1
}

# Each changes the gate, by a rule of sed, so that the claim with that number is wrong of it.
mutants=(
    '1:no lower end of the ceiling:s/0 <= most && //'
    '1:no upper end of the ceiling:s/ && most <= 1e9//'
    '1:the limit where the ceiling is no number:s/most = 0;/most = limit;/'
    '1:it returns the old ceiling:s/return most/return ceiling/'
    '2:no limit:s/risen < limit ? risen : limit/risen/; s/most <= limit && //'
    '2:it returns what has risen:s/return most/return risen/'
    '3:no ramp:s/risen < limit ? risen : limit/limit/; s/most <= risen && //'
    '3:the ramp twice:s/ceiling + ramp;/ceiling + 2 * ramp;/'
    '4:no upper end of x:s/x <= most && -x/-x/'
    '4:the last test is turned around:s/if (!(x \* x/if ((x * x/'
    '5:y is not written:s/newtons\[1\] = y;//'
    '5:a sign of y is wrong:s/-y <= most/y <= most/'
    '6:z is not set to 0:s/x = y = z = 0/x = y = 0/'
    '6:no lower end of z:s/-z <= most/1/'
    '7:no test of the length:s/x \* x + y \* y + z \* z <= most \* most &&/1 \&\&/; s/1 - 0x1p-49/1/'
    '7:a sign of a square is wrong:s/x \* x + y \* y/x * x - y * y/'
    '8:each force is shortened:s/(!(square <= most \* most))/(1)/'
    '8:the limit of each axis is half of it:s/x <= most \&\& -x/x <= most \/ 2 \&\& -x/'
)

cp device/force_gate.h "$gates"
for claim in "${claims[@]}"; do
    proves "$gates" "$claim" || { echo "prove.sh: claim $claim of tests/proof/force_gate.c is not proved" >&2; exit 1; }
done
echo "the gate of forces: ${#claims[@]} claims proved, for all doubles"

if proves "$gates" 9; then
    echo "prove.sh: claim 9 is wrong, and proved: this Frama-C knows nothing of what is not a number" >&2
    exit 1
fi
for mutant in "${mutants[@]}"; do
    IFS=: read -r claim what rule <<<"$mutant"
    mkdir "$gates/mutant"
    sed "$rule" device/force_gate.h >"$gates/mutant/force_gate.h"
    if cmp -s device/force_gate.h "$gates/mutant/force_gate.h"; then
        echo "prove.sh: nothing to change in device/force_gate.h: $what ($rule)" >&2
        exit 1
    fi
    if proves "$gates/mutant" "$claim"; then
        echo "prove.sh: claim $claim is proved of a gate that breaks it: $what ($rule)" >&2
        exit 1
    fi
    rm -r "$gates/mutant"
done
echo "${#mutants[@]} gates that break a claim: none is proved"
