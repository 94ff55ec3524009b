// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace touchable::test {

/// A file or folder of the real recordings, which stand beside the checkout (tests/CMakeLists.txt) unless the
/// environment names another folder: one that is not there shows what a clone with nothing beside it does.
inline std::filesystem::path real_data(const std::filesystem::path& name) {
    const char* const elsewhere = std::getenv("TOUCHABLE_TEST_DATA");
    return std::filesystem::path(elsewhere ? elsewhere : TOUCHABLE_TEST_DATA) / name;
}

}  // namespace touchable::test

/// Ends a test whose recording is not there: skipped, or failed where TOUCHABLE_REQUIRE_DATA is set and no
/// other folder is named.
#define TOUCHABLE_NEEDS_DATA(file)                                                        \
    if (!std::filesystem::exists(file)) {                                                 \
        if (std::getenv("TOUCHABLE_REQUIRE_DATA") && !std::getenv("TOUCHABLE_TEST_DATA")) \
            GTEST_FAIL() << "no real data at " << file;                                   \
        GTEST_SKIP() << "no real data at " << file;                                       \
    }                                                                                     \
    static_assert(true)
