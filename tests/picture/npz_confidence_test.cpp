// Arrays with a confidence beside depth, as Depth Anything 3 writes them.
#include <gtest/gtest.h>
#include <zip.h>

#include <cmath>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/npy_bytes.hpp"

namespace touchable::test {
namespace {

constexpr int columns = 4, rows = 3, count = 2;

/// Depth 1, 2, ...; confidence 1 to 12 of the first picture, and 0.5 everywhere of the second.
class NpzConfidence : public ::testing::Test {
protected:
    std::string write(const std::string& name, const std::string& shape = "2, 3, 4") const {
        std::vector<float> depth, confidence;
        for (int k = 0; k < count * columns * rows; ++k) {
            depth.push_back(static_cast<float>(k + 1));
            confidence.push_back(k < columns * rows ? static_cast<float>(k + 1) : 0.5F);
        }
        write_npz(folder_ / name,
                  {{"depth", npy_bytes("2, 3, 4", depth)}, {"conf", npy_bytes(shape, confidence)}});
        return folder_ / name;
    }
    static int missing(const StoredImage& picture) {
        int missing = 0;
        for (const float value : picture.values) missing += std::isnan(value);
        return missing;
    }
    TemporaryFolder folder_;
};

TEST_F(NpzConfidence, WhatIsNotTrustedIsNoDepth) {
    auto stack = open_npy_stack(SourceFile(write("da3.npz")));
    ASSERT_EQ(message(stack), "");
    EXPECT_EQ((*stack)->least_confidence(), 3.5);  // the median is 7
    const auto first = (*stack)->image(0), second = (*stack)->image(1), again = (*stack)->image(0);
    ASSERT_EQ(message(first) + message(second) + message(again), "");
    EXPECT_EQ(missing(*first), 3);
    EXPECT_EQ(first->values[3], 4);
    EXPECT_EQ(missing(*second), columns * rows);
    EXPECT_EQ(missing(*again), 3);
    auto strict = open_npy_stack(SourceFile(write("da3.npz")), 12);
    EXPECT_EQ(missing(*(*strict)->image(0)), 11);
}

TEST_F(NpzConfidence, OfOtherPicturesIsRefused) {
    EXPECT_NE(message(open_npy_stack(SourceFile(write("other.npz", "2, 4, 3"))))
                  .find("conf: is of 2 pictures of 3x4, but depth of 2 of 4x3"),
              std::string::npos);
}

}  // namespace
}  // namespace touchable::test
