#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace touchable::test {

/// A file or folder of the real recordings, which stand beside the checkout (tests/CMakeLists.txt).
inline std::filesystem::path real_data(const std::filesystem::path& name) {
    return std::filesystem::path(TOUCHABLE_TEST_DATA) / name;
}

}  // namespace touchable::test

/// Ends a test whose recording is not there: skipped, or failed where TOUCHABLE_REQUIRE_DATA is set.
#define TOUCHABLE_NEEDS_DATA(file)                                                             \
    if (!std::filesystem::exists(file)) {                                                      \
        if (std::getenv("TOUCHABLE_REQUIRE_DATA")) GTEST_FAIL() << "no real data at " << file; \
        GTEST_SKIP() << "no real data at " << file;                                            \
    }                                                                                          \
    static_assert(true)
