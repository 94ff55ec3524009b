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

/// One picture of booleans, as numpy.savez writes them.
std::string boolean_bytes(int ones) {
    std::string bytes = npy_bytes("3, 4", {});
    bytes.replace(bytes.find("<f4"), 3, "|b1");
    for (int k = 0; k < columns * rows; ++k) bytes += k < ones ? '\1' : '\0';
    return bytes;
}

TEST_F(NpzConfidence, MasksAreUsedWhereTheyTell) {
    const std::string depth = npy_bytes("3, 4", std::vector<float>(columns * rows, 2));
    const struct {
        const char* name;
        int ones, missing;
        const char* said;
    } masks[] = {{"valid", 10, 2, "where its array valid is 0 there is no depth"},
                 {"valid_mask", 12, 0, "where its array valid_mask is 0 there is no depth"},
                 {"mask", 4, 0, "its array mask is not used, as most of it is not 1"},
                 {"person_mask", 10, 0, "depth is the array depth; left out: person_mask"}};
    for (const auto& mask : masks) {
        write_npz(folder_ / "m.npz", {{"depth", depth}, {mask.name, boolean_bytes(mask.ones)}});
        auto stack = open_npy_stack(SourceFile(folder_ / "m.npz"));
        ASSERT_EQ(message(stack), "") << mask.name;
        EXPECT_EQ((*stack)->left_out(), mask.said);
        EXPECT_EQ(missing(*(*stack)->image(0)), mask.missing) << mask.name;
        EXPECT_EQ((*stack)->least_confidence(), std::nullopt);
    }
    write_npz(folder_ / "only.npz", {{"depth", boolean_bytes(12)}});
    EXPECT_NE(message(open_npy_stack(SourceFile(folder_ / "only.npz"))).find("is of NumPy's type \"|b1\""),
              std::string::npos);
}

TEST_F(NpzConfidence, OfDepthIsUsedByAnyNameWithConf) {
    const std::string depth = npy_bytes("3, 4", std::vector<float>(columns * rows, 2));
    std::vector<float> low(columns * rows, 8);
    low[5] = 1;
    write_npz(folder_ / "v.npz", {{"depth", depth},
                                  {"depth_conf", npy_bytes("3, 4", low)},
                                  {"world_points_conf", npy_bytes("3, 4", std::vector<float>(12, 9))}});
    auto stack = open_npy_stack(SourceFile(folder_ / "v.npz"));
    ASSERT_EQ(message(stack), "");
    EXPECT_EQ((*stack)->least_confidence(), 4);
    EXPECT_EQ((*stack)->left_out(), "depth is the array depth; left out: world_points_conf");
    EXPECT_EQ(missing(*(*stack)->image(0)), 1);
}

}  // namespace
}  // namespace touchable::test
