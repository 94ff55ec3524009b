// Archives with a picture in each of several arrays, as numpy.savez writes a list.
#include <gtest/gtest.h>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/npy_bytes.hpp"

namespace touchable::test {
namespace {

std::string picture_of(float value, const std::string& shape = "16, 20") {
    return npy_bytes(shape, std::vector<float>(320, value));
}

TEST(NpzRow, FramesInOrderOfNumbers) {
    const TemporaryFolder folder;
    std::vector<std::pair<std::string, std::string>> arrays;
    for (const int n : {10, 2, 0, 1}) arrays.emplace_back("arr_" + std::to_string(n), picture_of(0.5F + n));
    write_npz(folder / "list.npz", arrays);
    const auto stack = open_npy_stack(SourceFile(folder / "list.npz"));
    ASSERT_EQ(message(stack), "");
    ASSERT_EQ((*stack)->count(), 4);
    EXPECT_EQ((*stack)->width(), 20);
    EXPECT_EQ((*stack)->height(), 16);
    constexpr int numbers[] = {0, 1, 2, 10};
    for (const int n : {3, 0, 2, 1}) {
        const auto picture = (*stack)->image(n);
        ASSERT_EQ(message(picture), "");
        EXPECT_EQ(picture->values.at(11), 0.5F + static_cast<float>(numbers[n]));
    }
    EXPECT_NE(message((*stack)->image(4)).find("has no picture 4: must be from 0 to 3"), std::string::npos);
}

TEST(NpzRow, PrefersDepthToOtherRows) {
    const TemporaryFolder folder;
    write_npz(folder / "rows.npz", {{"depth_1", picture_of(1.5F)},
                                    {"depth_2", picture_of(2.5F)},
                                    {"normal_1", picture_of(0.5F)},
                                    {"normal_2", picture_of(0.5F)}});
    const auto stack = open_npy_stack(SourceFile(folder / "rows.npz"));
    ASSERT_EQ(message(stack), "");
    ASSERT_EQ((*stack)->count(), 2);
    EXPECT_EQ((*stack)->image(1)->values.at(0), 2.5F);
}

TEST(NpzRow, OtherSizesAndRowsAreRefused) {
    const TemporaryFolder folder;
    const auto refusal = [&](const std::vector<std::pair<std::string, std::string>>& arrays) {
        write_npz(folder / "other.npz", arrays);
        return message(open_npy_stack(SourceFile(folder / "other.npz")));
    };
    EXPECT_NE(refusal({{"a_1", picture_of(1)}, {"a_2", picture_of(1, "20, 16")}}).find("has several arrays"),
              std::string::npos);
    EXPECT_NE(refusal({{"a_1", picture_of(1)}, {"a_2", picture_of(1)}, {"b", picture_of(1)}})
                  .find("has several arrays"),
              std::string::npos);
}

TEST(NpzRow, OtherPicturesAreSaid) {
    const TemporaryFolder folder;
    write_npz(folder / "two.npz",
              {{"depth", picture_of(1)}, {"disparity", picture_of(2)}, {"mask", picture_of(0)}});
    const auto stack = open_npy_stack(SourceFile(folder / "two.npz"));
    ASSERT_EQ(message(stack), "");
    EXPECT_EQ((*stack)->left_out(), "depth is the array depth; left out: disparity, mask");
}

/// Beside what networks and renderers write.
TEST(NpzRow, DepthIsFoundByWhatOthersAreNot) {
    const TemporaryFolder folder;
    const std::string matrix = npy_bytes("3, 3", std::vector<float>(9, 1)),
                      colour = npy_bytes("3, 16, 20", std::vector<float>(960, 1)), picture = picture_of(1);
    const struct {
        std::vector<std::pair<std::string, std::string>> others;
        const char* depth;
    } rows[] = {{{{"K", matrix}}, "pred_depth"},
                {{{"K", matrix}}, "Depth"},
                {{{"K", matrix}}, "z"},
                {{{"cam_c2w", npy_bytes("4, 4", std::vector<float>(16, 1))}}, "distance"},
                {{{"depth_conf", picture}, {"world_points", colour}}, "range"},
                {{{"normals", colour}, {"rgb", picture}, {"valid", picture}}, "data"},
                {{{"extrinsics", matrix}, {"image", picture}}, "depth_image"},
                {{{"z", picture}, {"left", picture}}, "metric_depth"},
                {{{"depth_mm", picture}, {"pred_depth", picture}}, "depth"}};
    for (const auto& row : rows) {
        auto arrays = row.others;
        arrays.emplace_back(row.depth, picture_of(2));
        write_npz(folder / "d.npz", arrays);
        const auto stack = open_npy_stack(SourceFile(folder / "d.npz"));
        ASSERT_EQ(message(stack), "") << row.depth;
        EXPECT_EQ((*stack)->array(), row.depth);
        EXPECT_EQ((*stack)->count(), 1) << row.depth;
    }
}

TEST(NpzRow, ANameTakesAnyArray) {
    const TemporaryFolder folder;
    const auto file = folder / "d.npz";
    write_npz(file, {{"pred", picture_of(1)}, {"gt", picture_of(2)}});
    const std::string several = message(open_npy_stack(SourceFile(file)));
    EXPECT_NE(several.find("has several arrays that may be depth: pred of 16x20, gt of 16x20"),
              std::string::npos)
        << several;
    const auto stack = open_npy_stack(SourceFile(file), {}, "gt");
    ASSERT_EQ(message(stack), "");
    EXPECT_EQ((*stack)->image(0)->values.at(0), 2);
    EXPECT_NE(
        message(open_npy_stack(SourceFile(file), {}, "x")).find("has no array \"x\", but pred of 16x20"),
        std::string::npos);
    write_npz(file, {{"K", npy_bytes("3, 3", std::vector<float>(9, 1))}, {"rgb", picture_of(1)}});
    EXPECT_NE(
        message(open_npy_stack(SourceFile(file)))
            .find("has no array of pictures of depth (height x width, or count x height x width): it has K "
                  "of 3x3, rgb of 16x20"),
        std::string::npos);
}

}  // namespace
}  // namespace touchable::test
