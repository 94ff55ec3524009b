// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pass an error on to the caller, in one line, in functions that return a Result themselves:
//
//     TRY(check_size(width, height));
//     TRY_ASSIGN(auto bytes, file.read("a picture", most));
//     TRY_ASSIGN(scene.camera, camera_of(bytes));
//
// The value is moved out of the Result. TRY_ASSIGN is three statements: TRY(assign(x, f())) is the
// body of a loop or an if. For .cpp files only: a macro has no namespace, and headers of the solver are
// installed.
// Threads: any; the macros keep no state.

#include <memory>
#include <utility>

#include "engine/base/result.hpp"

/// TRY(f()); returns the error of a failed Result from the function around it.
#define TRY(...) \
    if (auto tried_ = (__VA_ARGS__); !tried_) return tried_.error()

/// TRY_ASSIGN(auto x, f()); does the same, and otherwise gives x the value of the Result.
#define TRY_ASSIGN(declaration, ...) TRY_ASSIGN_ON_LINE_(__LINE__, declaration, __VA_ARGS__)
#define TRY_ASSIGN_ON_LINE_(line, declaration, ...) TRY_ASSIGN_NAMED_(line, declaration, __VA_ARGS__)
#define TRY_ASSIGN_NAMED_(line, declaration, ...)   \
    auto tried_##line = __VA_ARGS__;                \
    if (!tried_##line) return tried_##line.error(); \
    declaration = std::move(*tried_##line)

namespace touchable {

/// Calls the `open` of an object just made; returns the object, as its base, if that succeeds.
template <class Base, class Made, class... How>
Result<std::unique_ptr<Base>> opened_as(std::unique_ptr<Made> made, How&&... how) {
    TRY(made->open(std::forward<How>(how)...));
    return made;
}

}  // namespace touchable
