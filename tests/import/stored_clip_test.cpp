// What every stored clip promises, whatever its pictures come from.
#include "engine/formats/stored_clip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <stop_token>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int fake_wide = 8, fake_high = 6;

/// What was asked of a source, in words: "depth 0", "colour 3".
using Asked = std::vector<std::string>;

std::string in_words(PlaneRole role, std::int64_t frame) {
    return std::string(role_name(role)) + " " + std::to_string(frame);
}

StoredImage picture_of(PlaneRole role, std::int64_t number, int width = fake_wide) {
    const int channels = role == PlaneRole::depth ? 1 : 3;
    StoredImage stored{{width, fake_high, 1, channels, {}}, "png", channels == 1 ? "gray" : "rgb24"};
    stored.image.samples.assign(static_cast<std::size_t>(width * fake_high * channels),
                                static_cast<std::uint8_t>(10 + number));
    return stored;
}

class FakePictures final : public FrameSource {
public:
    explicit FakePictures(Asked& asked) : asked_(asked) {}
    std::function<Result<TrackPicture>(PlaneRole, std::int64_t)> made =
        [](PlaneRole role, std::int64_t frame) { return TrackPicture{picture_of(role, frame)}; };
    std::function<std::int64_t(PlaneRole, std::int64_t)> number = [](PlaneRole, std::int64_t frame) {
        return frame;
    };

    std::string where(PlaneRole role, std::int64_t frame) const override { return in_words(role, frame); }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        asked_.push_back(in_words(role, frame));
        return made(role, frame);
    }
    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        return number(role, frame);
    }
    std::int64_t access_point(std::int64_t frame) const override { return frame - frame % 4; }
    void keep(std::int64_t frame, StoredImage) override { asked_.push_back("keep " + std::to_string(frame)); }

private:
    Asked& asked_;
};

class StoredClips : public ::testing::Test {
protected:
    Result<std::unique_ptr<ClipReader>> opened(std::int64_t count = 5) {
        StoredClip clip{"the clip", described};
        clip.count = count;
        clip.roles = {PlaneRole::depth, PlaneRole::colour};
        clip.pictures = std::move(pictures);
        return open_stored_clip(std::move(clip));
    }
    Asked taken() { return std::exchange(asked, {}); }

    Asked asked;
    std::unique_ptr<FakePictures> pictures = std::make_unique<FakePictures>(asked);
    SceneDescription described{small_scene(fake_wide, fake_high)};
};

TEST_F(StoredClips, EveryPictureIsAskedForOnce) {
    auto clip = opened(3);
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ(taken(), (Asked{"depth 0", "colour 0"}));
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    EXPECT_EQ(taken(), (Asked{"depth 1", "colour 1", "depth 2", "colour 2"}));
    for (const std::int64_t n : {0, 1, 2}) {
        const RawFrame& frame = (*frames)[static_cast<std::size_t>(n)];
        EXPECT_EQ(frame.number, n);
        EXPECT_EQ(frame.time_ns, described.scene.rate.time_ns(n));
        EXPECT_EQ(frame.depth.sample(0, 0), 10 + n);
        EXPECT_EQ(frame.colour.sample(fake_wide - 1, fake_high - 1, 2), 10 + n);
    }
    ASSERT_EQ(message((*clip)->seek(2)), "");
    EXPECT_TRUE(same_frame(**(*clip)->next(), frames->back()));
    EXPECT_EQ(taken(), Asked{}) << "the newest is at hand";
    ASSERT_EQ(message((*clip)->rewind()), "");
    EXPECT_TRUE(same_frame(**(*clip)->next(), frames->front()));
    EXPECT_EQ(taken(), (Asked{"depth 0", "colour 0"}));
}

TEST_F(StoredClips, ASeekLeadsToTheEndAndNotBeyond) {
    auto clip = opened();
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->frame_count(), 5);
    EXPECT_EQ((*clip)->access_point(3), 0);
    EXPECT_EQ((*clip)->access_point(4), 4);
    ASSERT_EQ(message((*clip)->seek(5)), "");
    const auto end = (*clip)->next();
    ASSERT_EQ(message(end), "");
    EXPECT_FALSE(*end);
    for (const std::int64_t beyond : {6, -1}) {
        const auto refused = (*clip)->seek(beyond);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
        EXPECT_EQ(refused.error().message,
                  "the clip: has no frame " + std::to_string(beyond) + ": must be from 0 to 4");
    }
    for (const std::int64_t n : {3, 1, 4}) {
        ASSERT_EQ(message((*clip)->seek(n)), "");
        EXPECT_EQ((**(*clip)->next()).number, n);
    }
}

TEST_F(StoredClips, ColourThatNobodyLooksAtIsNotRead) {
    auto clip = opened(3);
    ASSERT_EQ(message(clip), "");
    (*clip)->leave_out_colour();
    taken();
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    EXPECT_EQ(taken(), (Asked{"depth 1", "depth 2"}));
    for (const RawFrame& frame : *frames) EXPECT_TRUE(frame.colour.empty());
    EXPECT_EQ((*clip)->tracks().size(), 2U) << "it is stored all the same";
}

TEST_F(StoredClips, APictureThatStaysIsReadOnce) {
    pictures->number = [](PlaneRole role, std::int64_t frame) {
        return role == PlaneRole::depth ? frame : frame / 2;
    };
    auto clip = opened(4);
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    EXPECT_EQ(taken(), (Asked{"depth 0", "colour 0", "depth 1", "depth 2", "colour 2", "depth 3"}));
    EXPECT_EQ((*frames)[1].colour.data, (*frames)[0].colour.data);
    EXPECT_EQ((*frames)[3].colour.sample(0, 0), 12);
}

TEST_F(StoredClips, ALaterPictureOfAnotherSizeOrFormatIsRefusedByItsName) {
    for (const PlaneRole role : {PlaneRole::depth, PlaneRole::colour}) {
        const std::string other = role == PlaneRole::depth ? "pal8" : "yuvj444p";
        for (const bool is_wider : {true, false}) {
            pictures = std::make_unique<FakePictures>(asked);
            pictures->made = [&, role, is_wider](PlaneRole asked_for, std::int64_t frame) {
                const bool differs = asked_for == role && frame == 2;
                StoredImage stored =
                    picture_of(asked_for, frame, differs && is_wider ? fake_wide + 1 : fake_wide);
                if (differs && !is_wider) stored.pixel_format = other;
                return TrackPicture{std::move(stored)};
            };
            auto clip = opened();
            ASSERT_EQ(message(clip), "");
            const std::string format = role == PlaneRole::depth ? "gray" : "rgb24";
            EXPECT_EQ(message(read_all(**clip)), in_words(role, 2) + ": is " +
                                                     (is_wider ? "9x6 " + format : "8x6 " + other) +
                                                     ", but frame 0 is 8x6 " + format);
        }
    }
}

TEST_F(StoredClips, APictureOfFewColoursMayHaveAPaletteAndTheNextOneNot) {
    pictures->made = [](PlaneRole role, std::int64_t frame) {
        TrackPicture picture{picture_of(role, frame)};
        if (role == PlaneRole::colour && frame % 2 == 1) picture.image.pixel_format = "pal8";
        return picture;
    };
    auto clip = opened(4);
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    for (const RawFrame& frame : *frames) EXPECT_EQ(frame.colour.sample(0, 0), 10 + frame.number);
}

TEST_F(StoredClips, SamplesOfADecoderStayWhereTheyAre) {
    Samples memory;
    const PlaneView lent = test_plane(memory, fake_wide, fake_high, 1, 1, 255, 1, true);
    std::weak_ptr<const int> picture;  // of a decoder, as long as anybody has it
    pictures->made = [&](PlaneRole role, std::int64_t frame) {
        if (role == PlaneRole::colour) return TrackPicture{picture_of(role, frame)};
        EXPECT_TRUE(picture.expired()) << "its memory can serve the next, as nobody looks at it";
        const auto made = std::make_shared<const int>(1);
        picture = made;
        return lent_picture({"depth", "h264", "gray"}, {lent, made});
    };
    auto clip = opened(3);
    ASSERT_EQ(message(clip), "");
    for (int n = 0; n < 3; ++n) {
        const auto frame = (*clip)->next();
        ASSERT_EQ(message(frame), "");
        EXPECT_EQ((**frame).depth.data, lent.data);
        EXPECT_FALSE(picture.expired());
    }
    EXPECT_EQ((*clip)->tracks().front().codec, "h264");
    EXPECT_EQ((*clip)->tracks().front().width, fake_wide);
    EXPECT_TRUE(std::ranges::any_of((*clip)->notes(), [](const std::string& note) {
        return note.find("depth is stored as h264") != std::string::npos;
    }));
}

/// A metre in frame 0, and a centimetre more in each.
class StoredClipsOfFloats : public StoredClips {
protected:
    StoredClipsOfFloats() {
        Scene& scene = described.scene;
        scene.depth.kind = DepthCodingKind::metric;
        scene.depth.semantics = DepthSemantics::planar;
        scene.depth.scale = 1;
        scene.depth.near = 0.1;
        scene.depth.far = 100;
        derive_valid_range(scene.depth);
        described.unstated.far = true;
        pictures->made = [this](PlaneRole role, std::int64_t frame) -> Result<TrackPicture> {
            if (role == PlaneRole::colour) return TrackPicture{picture_of(role, frame)};
            if (const auto found = failures.find(frame); found != failures.end()) return found->second;
            StoredImage stored{{fake_wide, fake_high, 2, 1, {}}, "pfm", "grayf32le"};
            stored.values.assign(fake_wide * fake_high, 1 + 0.01F * static_cast<float>(frame));
            return TrackPicture{std::move(stored)};
        };
    }
    std::map<std::int64_t, Error> failures;
};

TEST_F(StoredClipsOfFloats, TheRangeOfDepthIsFoundInTheTellingFrames) {
    failures[3] = input_error("depth 3: is damaged");
    auto clip = opened(200);
    ASSERT_EQ(message(clip), "");
    Asked looks;
    for (const std::int64_t frame : telling_frames(200)) {
        looks.push_back(in_words(PlaneRole::depth, frame));
        if (frame > 0 && frame < first_frames && frame != 3) looks.push_back("keep " + std::to_string(frame));
    }
    looks.emplace_back("colour 0");
    EXPECT_EQ(taken(), looks) << "and frame 0 is not read twice";
    EXPECT_NEAR((*clip)->scene().depth.far, 1.05 * 2.99, 1e-6) << "found once, not in the codes again";
    const auto first = (*clip)->next();
    ASSERT_EQ(message(first), "");
    const DepthCoding& coding = (*clip)->scene().depth;
    EXPECT_NEAR(coding.depth(static_cast<std::uint16_t>((**first).depth.sample(3, 3))), 1, 1e-4);
    ASSERT_EQ(message((*clip)->seek(3)), "");
    EXPECT_EQ(message((*clip)->next()), "depth 3: is damaged");
}

TEST_F(StoredClipsOfFloats, TheSearchForItsRangeIsGivenUp) {
    failures[5] = {ErrorKind::interrupted, "depth 5: given up"};
    EXPECT_EQ(message(opened(20)), "depth 5: given up");
    pictures = std::make_unique<FakePictures>(asked);
    std::stop_source person;
    pictures->made = [&](PlaneRole, std::int64_t frame) {
        if (frame == 2) person.request_stop();
        StoredImage stored{{fake_wide, fake_high, 2, 1, {}}, "pfm", "grayf32le"};
        stored.values.assign(fake_wide * fake_high, 1);
        return TrackPicture{std::move(stored)};
    };
    taken();
    const StopScope until(person.get_token());
    const auto clip = opened(20);
    ASSERT_FALSE(clip);
    EXPECT_EQ(clip.error().kind, ErrorKind::interrupted);
    EXPECT_EQ(taken(), (Asked{"depth 0", "depth 1", "keep 1", "depth 2", "keep 2"}));
}

TEST_F(StoredClips, FloatsAreDepthAlone) {
    pictures->made = [](PlaneRole role, std::int64_t frame) {
        StoredImage stored = picture_of(role, frame);
        if (role == PlaneRole::colour) stored.values.assign(fake_wide * fake_high, 0.5F);
        return TrackPicture{std::move(stored)};
    };
    EXPECT_EQ(message(opened()), "colour 0: is a picture of floats: must be of integers");
}

TEST_F(StoredClips, WhatTheSourceFoundSettlesWhatTheDescriptionLeavesOpen) {
    const Camera one{50, 50, 4, 3}, other{60, 60, 4, 3};
    for (const auto& [cameras, kept] :
         {std::pair{std::vector{one, one}, 0U}, {std::vector{one, other}, 2U}}) {
        pictures = std::make_unique<FakePictures>(asked);
        StoredClip clip{"the clip", described};
        clip.described.unstated.rate = clip.described.unstated.camera = true;
        clip.count = 2;
        clip.roles = {PlaneRole::depth};
        clip.found = {.rate = FrameRate{25, 1}, .camera = one};
        clip.cameras = cameras;
        clip.inputs = {"some/file"};
        clip.pictures = std::move(pictures);
        auto reader = open_stored_clip(std::move(clip));
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ((*reader)->scene().rate.num, 25);
        EXPECT_EQ((*reader)->frame_cameras().size(), kept) << "none where all are the scene's";
        EXPECT_EQ((*reader)->inputs().front(), "some/file");
    }
    described.unstated.camera = true;
    EXPECT_TRUE(is_refused(opened(), "the clip: camera is missing"));
}

}  // namespace
}  // namespace touchable::test
