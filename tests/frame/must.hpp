#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "engine/base/result.hpp"

namespace touchable::test {

/// The value; without one, the test fails with the reason.
template <class T>
T must(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
}

inline void must(const Result<void>& result) {
    if (!result) throw std::runtime_error(result.error().message);
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
