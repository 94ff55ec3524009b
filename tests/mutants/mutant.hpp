// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a source file includes that mutants.py has changed: the switch of its changes. Each change has a
// number; the environment's TOUCHABLE_MUTANT chooses one for a process and its children. Which were asked
// for, and so reached, is kept in memory that a test shares with its children (mutant.cpp).

#include <type_traits>

#pragma GCC visibility push(hidden)
extern "C" {
struct TouchableReached {
    // A type of its own, so that no other store can change it and the compiler keeps its freedom around it.
    int yes;
};
extern TouchableReached* touchable_reached_mutants;
extern int touchable_active_mutant;
}
#pragma GCC visibility pop

/// Whether change `k` is to be made; notes that its place was reached. Any thread. False while compiling.
constexpr bool touchable_mutant(int k) {
    if (std::is_constant_evaluated()) return false;
    if (touchable_reached_mutants[k].yes == 0) touchable_reached_mutants[k].yes = 1;
    return k == touchable_active_mutant;
}
