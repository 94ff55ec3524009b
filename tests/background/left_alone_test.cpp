// What is not a clip of a camera at rest stays as it is, and says why.
#include <gtest/gtest.h>

#include <stop_token>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/open_clip.hpp"
#include "tests/background/still_scene.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {
namespace {

std::string note_of(const ClipReader& clip) {
    return clip.notes().back();
}

void expect_untouched(ClipReader& clip, const StillScene& scene, std::int64_t begin, std::int64_t end) {
    for (std::int64_t n = begin; n < end; ++n) {
        ASSERT_EQ(message(clip.seek(n)), "");
        const auto frame = clip.next();
        ASSERT_EQ(message(frame), "");
        EXPECT_TRUE(same_samples((*frame)->depth, scene.frame(n).depth)) << n;
        EXPECT_EQ((*frame)->filled, nullptr);
    }
}

TEST(LeftAlone, AClipWhoseCameraMoves) {
    StillScene slow, fast, rising;
    slow.pan = 2;  // a pixel in eight frames
    fast.pan = 32;
    rising.rise = 24;
    rising.has_colour = false;
    for (const StillScene& scene : {slow, fast, rising}) {
        const auto clip = filled(clip_of(scene, 64));
        EXPECT_EQ(note_of(*clip),
                  "no hole is filled from motion, because the camera moves: the clip is left as it is");
        expect_untouched(*clip, scene, 0, 64);
    }
}

TEST(LeftAlone, ARealRecordingByHand) {
    const auto folder = real_data("castel_sr300");
    TOUCHABLE_NEEDS_DATA(folder);
    SourceDescription known;
    known.preset = "realsense";
    auto opened = open_clip(folder, {}, known);
    ASSERT_EQ(message(opened), "");
    EXPECT_EQ(note_of(*filled(std::move(*opened))),
              "no hole is filled from motion, because the camera moves: the clip is left as it is");
}

/// It moves for sixteen frames and stands still for the rest.
TEST(LeftAlone, FramesInWhichTheCameraMoves) {
    StillScene moving, still;
    moving.pan = 32;
    const auto clip = filled(clip_of(80, frames_of([=](std::int64_t n) { return n < 16 ? moving : still; })));
    EXPECT_NE(note_of(*clip).find("; 16 frames of 80, in which the camera moves, are left as they are"),
              std::string::npos)
        << note_of(*clip);
    expect_untouched(*clip, moving, 0, 16);
    ASSERT_EQ(message(clip->seek(40)), "");
    EXPECT_NE((**clip->next()).filled, nullptr);
}

TEST(LeftAlone, AClipOfFewFrames) {
    const auto clip = filled(clip_of(StillScene{}, 3));
    EXPECT_EQ(note_of(*clip),
              "no hole is filled from motion, because it takes 4 frames to tell that a camera stands still");
    expect_untouched(*clip, StillScene{}, 0, 3);
}

TEST(LeftAlone, AClipWithoutHoles) {
    const auto whole = [](std::int64_t n) {
        RawFrame frame = StillScene{}.frame(n);
        Image image{StillScene::columns, StillScene::rows, 2, 1, {}};
        image.samples.assign(std::size_t{2} * StillScene::columns * StillScene::rows, 3);
        add_plane(frame, PlaneRole::depth, plane_from(std::move(image), 16));
        return frame;
    };
    const auto clip = filled(clip_of(16, whole));
    EXPECT_EQ(note_of(*clip),
              "holes are filled from frames that saw what is behind, but the 16 frames that were measured "
              "have none");
}

class Around final : public ReaderAround {
public:
    Around(std::unique_ptr<ClipReader> clip, bool is_live, std::int64_t damaged)
        : ReaderAround(std::move(clip)), is_live_(is_live), damaged_(damaged) {}
    bool is_live() const override { return is_live_; }
    Result<std::optional<RawFrame>> next() override {
        auto frame = ReaderAround::next();
        if (frame && *frame && (*frame)->number == damaged_) return input_error("made: frame is damaged");
        return frame;
    }

private:
    bool is_live_;
    std::int64_t damaged_;
};

TEST(LeftAlone, LiveCamerasAreRefused) {
    const auto refused = with_filled_holes(std::make_unique<Around>(clip_of(StillScene{}, 8), true, -1));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    EXPECT_EQ(refused.error().message,
              "made: is a live camera, of which no later frame can tell what is behind a hole");
}

/// Whoever reads on learns of the damage; what was before it is filled.
TEST(LeftAlone, FramesFromADamagedOneOn) {
    const auto clip = filled(std::make_unique<Around>(clip_of(StillScene{}, 64), false, 40));
    ASSERT_EQ(message(clip->seek(30)), "");
    EXPECT_NE((**clip->next()).filled, nullptr);
    ASSERT_EQ(message(clip->seek(40)), "");
    EXPECT_EQ(message(clip->next()), "made: frame is damaged");
    expect_untouched(*clip, StillScene{}, 41, 44);
}

TEST(LeftAlone, AClipThatSomebodyGaveUp) {
    std::stop_source person;
    auto clip = clip_of(64, [&](std::int64_t n) {
        if (n == 20) person.request_stop();
        EXPECT_LE(n, 20);
        return StillScene{}.frame(n);
    });
    const StopScope until(person.get_token());
    const auto given_up = with_filled_holes(std::move(clip));
    ASSERT_FALSE(given_up);
    EXPECT_EQ(given_up.error().kind, ErrorKind::interrupted);
}

}  // namespace
}  // namespace touchable::test
