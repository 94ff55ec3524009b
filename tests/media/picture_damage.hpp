#pragma once

#include <gtest/gtest.h>

#include <string>

#include "engine/media/stored_image.hpp"
#include "tests/media/clip_fixture.hpp"

namespace touchable::test {

/// What went wrong says so on one line, and where; what did not is a whole picture.
inline void expect_error_or_picture(const Result<StoredImage>& stored) {
    if (!stored) {
        EXPECT_TRUE(stored.error().message.starts_with("picture: ")) << stored.error().message;
        EXPECT_EQ(stored.error().message.find('\n'), std::string::npos) << stored.error().message;
        return;
    }
    const Image& image = stored->image;
    const auto pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (!stored->values.empty()) {
        EXPECT_EQ(stored->values.size(), pixels);
        EXPECT_TRUE(image.samples.empty());
    } else {
        EXPECT_EQ(image.samples.size(), pixels * static_cast<std::size_t>(image.channels) *
                                            static_cast<std::size_t>(image.bytes_per_sample));
    }
}

/// Cut anywhere, it is refused; the last bytes may say nothing of the picture.
inline void expect_cuts_refused(const std::string& whole, std::size_t needless = 0) {
    ASSERT_EQ(message(decode_stored_image(whole, "picture")), "");
    for (std::size_t length = 0; length < whole.size() - needless; ++length) {
        const auto stored = decode_stored_image(whole.substr(0, length), "picture");
        ASSERT_FALSE(stored.ok()) << length << " of " << whole.size();
        expect_error_or_picture(stored);
    }
}

/// Up to four bytes changed, 2000 times.
inline void expect_changes_survived(const std::string& whole, std::uint64_t seed) {
    Numbers numbers(seed);
    int read = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        std::string damaged = whole;
        for (int k = numbers.below(4); k >= 0; --k)
            damaged[static_cast<std::size_t>(numbers.below(static_cast<int>(whole.size())))] =
                static_cast<char>(numbers.below(256));
        const auto stored = decode_stored_image(damaged, "picture");
        expect_error_or_picture(stored);
        read += stored.ok() ? 1 : 0;
    }
    EXPECT_GT(read, 0);
    EXPECT_LT(read, 2000);
}

}  // namespace touchable::test
