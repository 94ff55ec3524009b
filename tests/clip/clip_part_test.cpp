// A part of a clip as a clip.
#include "engine/clip/readers.hpp"

#include <gtest/gtest.h>

#include "engine/clip/clip.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int part_width = 24, part_height = 18, part_frames = 10;

class PartOfAClip : public ::testing::Test {
protected:
    PartOfAClip() {
        Scene scene = small_scene(part_width, part_height, 12);
        scene.rate = {30000, 1001};
        EXPECT_EQ(message(write_clip(folder_ / "clip.mkv", scene, part_frames, all_planes)), "");
        const auto frames = read_clip(folder_ / "clip.mkv");
        EXPECT_EQ(message(frames), "");
        whole_ = *frames;
    }
    Result<std::unique_ptr<ClipReader>> open(const ClipPart& part) const {
        auto clip = open_clip(folder_ / "clip.mkv");
        EXPECT_EQ(message(clip), "");
        return part_of_clip(std::move(*clip), part);
    }
    TemporaryFolder folder_;
    std::vector<RawFrame> whole_;
};

TEST_F(PartOfAClip, HasEachNthFrameFromOneToAnother) {
    for (const ClipPart& part : {ClipPart{2}, ClipPart{0, 0}, ClipPart{1, 8, 3}, ClipPart{1, 7, 3},
                                 ClipPart{0, std::nullopt, 4}, ClipPart{9}, ClipPart{3, 3, 100}}) {
        auto reader = open(part);
        ASSERT_EQ(message(reader), "");
        std::vector<RawFrame> expected;
        for (std::int64_t n = part.first; n <= part.last.value_or(part_frames - 1); n += part.every) {
            expected.push_back(whole_[static_cast<std::size_t>(n)]);
            expected.back().number = std::ssize(expected) - 1;
            // n/every frames later at a rate that is so much lower.
            expected.back().time_ns = FrameRate{30000, 1001 * part.every}.time_ns(expected.back().number);
        }
        EXPECT_EQ((*reader)->frame_count(), std::ssize(expected));
        for (const bool again : {false, true}) {
            const auto frames = read_all(**reader);
            ASSERT_EQ(message(frames), "");
            ASSERT_EQ(frames->size(), expected.size());
            for (std::size_t n = 0; n < expected.size(); ++n)
                EXPECT_TRUE(same_frame((*frames)[n], expected[n]))
                    << part.first << " " << part.every << " " << n;
            const auto back = again ? Result<void>{} : (*reader)->rewind();
            ASSERT_EQ(message(back), "");
        }
        const std::int64_t last = std::ssize(expected) - 1;
        ASSERT_EQ(message((*reader)->seek(last)), "");
        EXPECT_LE((*reader)->access_point(last), last);
        const auto frame = (*reader)->next();
        ASSERT_EQ(message(frame), "");
        EXPECT_TRUE(same_frame(**frame, expected.back()));
        EXPECT_NE(message((*reader)->seek(last + 2)), "");
    }
}

TEST_F(PartOfAClip, KeepsEveryVertexWhereItWasWhenCropped) {
    const ClipPart::Crop box{5, 3, 11, 9};
    auto whole = open_clip(folder_ / "clip.mkv");
    auto reader = open({0, std::nullopt, 1, box});
    ASSERT_EQ(message(reader), "");
    const Scene &before = (*whole)->scene(), &now = (*reader)->scene();
    EXPECT_EQ(now.width, 11);
    EXPECT_EQ(now.height, 9);
    const auto frame = (*reader)->next();
    ASSERT_EQ(message(frame), "");
    for (int y = 0; y < box.height; ++y)
        for (int x = 0; x < box.width; ++x) {
            for (const PlaneRole role : all_roles)
                ASSERT_EQ(plane_of(**frame, role).sample(x, y),
                          plane_of(whole_[0], role).sample(x + 5, y + 3));
            for (const DepthSemantics semantics : {DepthSemantics::planar, DepthSemantics::range}) {
                const auto vertex = [&](const Camera& camera, double i, double j) {
                    return unproject(camera, i, j, planar_depth(camera, semantics, i, j, 123.4));
                };
                const glm::dvec3 was = vertex(before.camera, x + 5, y + 3), is = vertex(now.camera, x, y);
                for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(is[axis], was[axis], 1e-12 * 123.4);
            }
        }
}

TEST_F(PartOfAClip, IsRefusedWhereTheClipHasNoSuchFrameOrPixel) {
    for (const ClipPart& part :
         {ClipPart{10}, ClipPart{0, 10}, ClipPart{3, 2}, ClipPart{-1}, ClipPart{0, std::nullopt, 0},
          ClipPart{0, std::nullopt, 1, ClipPart::Crop{20, 0, 5, 5}},
          ClipPart{0, std::nullopt, 1, ClipPart::Crop{0, 0, 0, 5}},
          ClipPart{0, std::nullopt, 1, ClipPart::Crop{0, 14, 5, 5}}}) {
        const auto refused = open(part);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    }
}

}  // namespace
}  // namespace touchable::test
