// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "engine/base/result.hpp"

namespace touchable::test {

/// By builtins of the compiler: Clang 14 has no std::source_location.
[[noreturn]] inline void fail_at(const char* file, int line, const Error& error) {
    throw std::runtime_error(file + (":" + std::to_string(line)) + ": " + error.message);
}

/// The value; without one, the test fails with the reason and the line of the call.
template <class T>
T must(Result<T> result, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    if (!result) fail_at(file, line, result.error());
    return std::move(*result);
}

inline void must(const Result<void>& result, const char* file = __builtin_FILE(),
                 int line = __builtin_LINE()) {
    if (!result) fail_at(file, line, result.error());
}

/// Fails unless it is an error whose message has these words.
template <class T>
void expect_error(const Result<T>& result, const std::string& words) {
    ASSERT_FALSE(result) << words;
    EXPECT_NE(result.error().message.find(words), std::string::npos) << result.error().message;
}

template <class T>
void expect_error(const Result<T>& result, ErrorKind kind, const std::string& words) {
    expect_error(result, words);
    EXPECT_TRUE(result || result.error().kind == kind) << static_cast<int>(kind);
}

}  // namespace touchable::test
