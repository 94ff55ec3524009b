// SPDX-License-Identifier: Apache-2.0
// Holes get the depth that is behind them where other frames saw it, and nothing else does.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iostream>
#include <stop_token>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/frames.hpp"
#include "tests/clip/made_clip.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t frames = 64;
using Thing = StillScene::Thing;

struct Figures {
    std::int64_t pixels = 0, holes = 0, filled = 0;
    std::int64_t shadows = 0, filled_shadows = 0;  // beside the hand
    std::int64_t in_hand = 0, filled_in_hand = 0;  // holes
    std::int64_t wrongly_marked = 0, changed = 0;
    std::int64_t filled_rim = 0;      // holes at the hand's rim
    std::int64_t sum = 0, worst = 0;  // of the error of what was filled, codes

    double share(std::int64_t part, std::int64_t of) const {
        return static_cast<double>(part) / static_cast<double>(of);
    }
};

/// And that everything else is as it was.
Figures figures_of(ClipReader& clip, const StillScene& scene) {
    Figures figures;
    const auto made = frames_of([scene](std::int64_t) { return scene; });
    for (const RawFrame& frame : must(read_all(clip))) {
        const RawFrame was = made(frame.number);
        for (int y = 0; y < scene.rows; ++y)
            for (int x = 0; x < scene.columns; ++x) {
                const StillScene::Seen seen = scene.at(x, y, frame.number);
                const int code = frame.depth.sample(x, y);
                const bool is_filled = seen.is_hole && code != 0;
                figures.wrongly_marked += is_filled != is_marked(frame, x, y);
                figures.changed += !is_filled && code != was.depth.sample(x, y);
                const bool in_hand = seen.thing == Thing::hand && seen.is_hole;
                const bool is_deep = scene.is_hand(x, y, frame.number, scene.radius - 3);
                if (in_hand && is_filled && !is_deep) ++figures.filled_rim;
                ++figures.pixels;
                figures.holes += seen.is_hole;
                figures.filled += is_filled;
                figures.shadows += seen.is_shadow;
                figures.filled_shadows += seen.is_shadow && is_filled;
                figures.in_hand += in_hand && is_deep;
                figures.filled_in_hand += in_hand && is_deep && is_filled;
                if (!is_filled || in_hand) continue;
                const std::int64_t error = std::abs(code - seen.depth);
                figures.sum += error;
                figures.worst = std::max(figures.worst, error);
            }
    }
    EXPECT_EQ(figures.wrongly_marked, 0);
    EXPECT_EQ(figures.changed, 0);
    return figures;
}

void print(const char* what, const Figures& f) {
    std::cout << what << ": holes " << 100 * f.share(f.holes, f.pixels) << " %, then "
              << 100 * f.share(f.holes - f.filled, f.pixels) << " %; of shadows "
              << 100 * f.share(f.filled_shadows, f.shadows) << " % filled; error " << f.share(f.sum, f.filled)
              << " codes, at most " << f.worst << "; of the hand's holes " << f.filled_in_hand << " of "
              << f.in_hand << " filled, at its rim " << f.filled_rim << "\n";
}

TEST(FilledClip, FillsShadowsWithTable) {
    const StillScene scene;
    const auto clip = filled(clip_of(scene, frames));
    const Figures f = figures_of(*clip, scene);
    print("with colour", f);
    EXPECT_GT(f.share(f.filled_shadows, f.shadows), 0.9);
    EXPECT_LE(f.worst, 3);
    EXPECT_EQ(f.filled_in_hand, 0);
    EXPECT_TRUE(has_words(clip->notes().back(), "holes are filled from frames that saw what is behind: "))
        << "and how many";
}

/// At the hand's rim nothing tells a drop-out from a shadow, and some of those are filled.
TEST(FilledClip, FillsShadowsWithoutColour) {
    StillScene scene;
    scene.has_colour = false;
    const Figures f = figures_of(*filled(clip_of(scene, frames)), scene);
    print("without colour", f);
    EXPECT_GT(f.share(f.filled_shadows, f.shadows), 0.9);
    EXPECT_LE(f.worst, 3);
    EXPECT_EQ(f.filled_in_hand, 0);
    EXPECT_LE(f.filled_rim, 2 * frames);
}

/// The surroundings of a hole decide then.
TEST(FilledClip, LeavesHolesOfCamouflagedHand) {
    StillScene scene;
    scene.hand_has_colour_of_table = true;
    const Figures f = figures_of(*filled(clip_of(scene, frames)), scene);
    print("a hand like the table", f);
    EXPECT_GT(f.share(f.filled_shadows, f.shadows), 0.9);
    EXPECT_LE(f.worst, 3);
    EXPECT_EQ(f.filled_in_hand, 0);
}

/// Half of the hand has no depth, up to the table beside it. Colour tells only where it lies on depth's
/// pixels.
TEST(FilledClip, LeavesHolesOfMovingSleeve) {
    for (const int shift : {0, 8, 24}) {
        StillScene scene;
        scene.hand_has_sleeve = true;
        scene.colour_shift = shift;
        const auto clip = filled(clip_of(scene, frames));
        const Figures f = figures_of(*clip, scene);
        print(("a sleeve, its colour " + std::to_string(shift) + " pixels beside it").c_str(), f);
        EXPECT_LT(f.filled_in_hand + f.filled_rim, f.in_hand / 50);
        EXPECT_EQ(clip->notes().back().find("colour is not used") != std::string::npos, shift > 0)
            << clip->notes().back();
        EXPECT_GT(f.share(f.filled_shadows, f.shadows), 0.9);
    }
}

/// It is nearly as deep, and there for long.
TEST(FilledClip, IgnoresRestingHand) {
    StillScene scene;
    scene.rests_from = 40;
    const Figures f = figures_of(*filled(clip_of(scene, frames)), scene);
    print("a hand that rests", f);
    EXPECT_GT(f.share(f.filled_shadows, f.shadows), 0.9);
    EXPECT_LE(f.worst, 3);
}

TEST(FilledClip, FillsEachShotSeparately) {
    for (const bool has_colour : {true, false}) {
        StillScene before, after;
        before.has_colour = after.has_colour = has_colour;
        after.table = 1;
        const auto of = [=](std::int64_t n) { return n < frames / 2 ? before : after; };
        const auto clip = filled(clip_of(frames, frames_of(of)));
        std::int64_t shadows = 0, right = 0;
        for (const RawFrame& frame : must(read_all(*clip)))
            for (int y = 0; y < StillScene::rows; ++y)
                for (int x = 0; x < StillScene::columns; ++x) {
                    const auto seen = of(frame.number).at(x, y, frame.number);
                    if (!seen.is_shadow) continue;
                    ++shadows;
                    const int code = frame.depth.sample(x, y);
                    EXPECT_LE(code == 0 ? 0 : std::abs(code - seen.depth), 3);
                    right += code != 0;
                }
        EXPECT_GT(static_cast<double>(right), 0.8 * static_cast<double>(shadows)) << has_colour;
    }
}

std::uint64_t hash_of(const RawFrame& frame) {
    ByteHash hash;
    const auto row_bytes =
        static_cast<std::size_t>(frame.depth.width * frame.depth.channels * frame.depth.bytes_per_sample);
    for (int y = 0; y < frame.depth.height; ++y) hash.add(frame.depth.row(y), row_bytes);
    if (frame.filled) hash.add(frame.filled->data(), 4 * frame.filled->size());
    return hash.value();
}

TEST(FilledClip, GivesSameFrameAfterSeeks) {
    const auto clip = filled(clip_of(StillScene{}, frames));
    std::vector<std::uint64_t> played;
    ByteHash all;
    while (auto frame = std::move(*clip->next())) {
        played.push_back(hash_of(*frame));
        all.add(&played.back(), 8);
    }
    ASSERT_EQ(played.size(), static_cast<std::size_t>(frames));
    EXPECT_EQ(all.value(), 10233008938834327891U);
    for (const std::int64_t number : {50, 3, 63, 0, 17, 18, 4}) {
        must(clip->seek(number));
        EXPECT_EQ(hash_of(**clip->next()), played[static_cast<std::size_t>(number)]) << number;
    }
    clip->leave_out_colour();  // which still tells what is behind
    must(clip->rewind());
    EXPECT_EQ(hash_of(**clip->next()), played.front());
}

/// Hues of full saturation, 255 to a sector, half a millimetre each.
std::array<std::uint8_t, 3> hue_of(int millimetres) {
    const int place = 2 * (millimetres - 600), sector = place / 255;
    const auto up = static_cast<std::uint8_t>(place % 255), down = static_cast<std::uint8_t>(255 - up);
    const std::array<std::uint8_t, 3> hues[] = {{255, up, 0},   {down, 255, 0}, {0, 255, up},
                                                {0, down, 255}, {up, 0, 255},   {255, 0, down}};
    return hues[sector];
}

struct Coded {
    const char* what;
    int channels;
    DepthCoding coding;
    std::function<std::array<std::uint8_t, 3>(int)> of;  ///< millimetres; none: 0
};

/// In hue, and in 8 bits that are less the farther away.
TEST(FilledClip, CopiesCodesOfEveryKind) {
    DepthCoding hue;
    hue.kind = DepthCodingKind::hue;
    hue.near = 600;
    hue.far = 1368;
    hue.near_is_high = false;
    hue.code_max = DepthCoding::hue_circle - 1;
    hue.least_sum = 77;
    derive_valid_range(hue);
    DepthCoding grey;
    grey.kind = DepthCodingKind::inverse;
    grey.near = 600;
    grey.far = 1368;
    grey.invalid_code_count = 1;
    derive_valid_range(grey);
    const auto hue_pixel = [](int mm) { return mm == 0 ? std::array<std::uint8_t, 3>{} : hue_of(mm); };
    const auto grey_pixel = [&](int mm) {
        return std::array{static_cast<std::uint8_t>(mm == 0 ? 0 : grey.code(mm)), std::uint8_t{},
                          std::uint8_t{}};
    };
    for (const Coded& coded : {Coded{"hue", 3, hue, hue_pixel}, Coded{"grey", 1, grey, grey_pixel}}) {
        const StillScene scene;
        auto made = clip_of(frames / 2, [=, grey_frames = frames_of([=](std::int64_t) { return scene; })](
                                            std::int64_t n) {
            RawFrame frame = grey_frames(n);
            Image image{StillScene::columns, StillScene::rows, 1, coded.channels, {}};
            for (int y = 0; y < image.height; ++y)
                for (int x = 0; x < image.width; ++x) {
                    const auto pixel = coded.of(frame.depth.sample(x, y));
                    image.samples.insert(image.samples.end(), pixel.begin(), pixel.begin() + coded.channels);
                }
            add_plane(frame, PlaneRole::depth, plane_from(std::move(image), 8));
            return frame;
        });
        made->scene().depth = coded.coding;
        made->scene().depth_bits = 8;
        const auto clip = filled(std::move(made));
        std::int64_t shadows = 0, filled_shadows = 0;
        for (const RawFrame& frame : must(read_all(*clip)))
            for (int y = 0; y < StillScene::rows; ++y)
                for (int x = 0; x < StillScene::columns; ++x) {
                    const auto seen = scene.at(x, y, frame.number);
                    const std::uint16_t code = stored_code(frame.depth, coded.coding, x, y);
                    const bool has_depth = coded.coding.is_valid(code);
                    EXPECT_TRUE(seen.is_hole || has_depth);
                    shadows += seen.is_shadow;
                    filled_shadows += seen.is_shadow && has_depth;
                    if (!seen.is_shadow || !has_depth) continue;
                    EXPECT_NEAR(coded.coding.depth(code), seen.depth, 6) << coded.what;
                }
        EXPECT_GT(static_cast<double>(filled_shadows), 0.9 * static_cast<double>(shadows)) << coded.what;
    }
}

/// A person who types, before a camera whose room lies beyond its range.
TEST(FilledClip, FillsHolesOfRealRecording) {
    const auto file = real_data("depthkit_typing/Test.mov");
    TOUCHABLE_NEEDS_DATA(file);
    const auto clip = filled(must(open_clip(file)));
    std::cout << clip->notes().back() << "\n";
    EXPECT_TRUE(has_words(clip->notes().back(),
                          "holes are filled from frames that saw what is behind: 67.8 % of depth was "
                          "holes, 67.3 % is"));
}

/// Every eighth pixel of a frame of a desk is made a hole, and comes back as the camera had it.
TEST(FilledClip, GivesRealDepthBack) {
    const auto folder = real_data("visp_cube_realsense");
    TOUCHABLE_NEEDS_DATA(folder);
    auto opened = must(open_clip(folder));
    const auto read = must(read_all(*opened));
    constexpr std::size_t spoilt = 5;
    const PlaneView truth = read[spoilt].depth;
    const auto is_spoilt = [](int x, int y) {
        return StillScene::chance(static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y), 0) % 8 == 0;
    };
    auto made = clip_of(static_cast<std::int64_t>(read.size()), [&](std::int64_t n) {
        RawFrame frame = read[static_cast<std::size_t>(n)];
        if (n != spoilt) return frame;
        Image image{truth.width, truth.height, 2, 1, {}};
        for (int y = 0; y < truth.height; ++y)
            for (int x = 0; x < truth.width; ++x) {
                const int code = is_spoilt(x, y) ? 0 : truth.sample(x, y);
                push_16(image, code);
            }
        add_plane(frame, PlaneRole::depth, plane_from(std::move(image), 16));
        return frame;
    });
    made->scene() = opened->scene();
    const DepthCoding& depth = made->scene().depth;
    const auto clip = filled(std::move(made));
    must(clip->seek(spoilt));
    const RawFrame frame = **clip->next();
    std::int64_t holes = 0;
    std::vector<double> errors;  // shares of the depth
    for (int y = 0; y < truth.height; ++y)
        for (int x = 0; x < truth.width; ++x) {
            const std::uint16_t was = truth.sample(x, y), is = frame.depth.sample(x, y);
            if (!is_spoilt(x, y) || !depth.is_valid(was)) continue;
            ++holes;
            if (depth.is_valid(is)) errors.push_back(std::abs(is - was) / static_cast<double>(was));
        }
    std::sort(errors.begin(), errors.end());
    const double filled_share = static_cast<double>(errors.size()) / static_cast<double>(holes);
    const double median = errors[errors.size() / 2], most = errors[errors.size() * 99 / 100];
    std::cout << holes << " pixels of a desk: " << 100 * filled_share << " % filled; error " << 100 * median
              << " % of the depth in the middle, of 99 in 100 below " << 100 * most << " %\n";
    EXPECT_GT(filled_share, 0.95);
    EXPECT_LT(median, 0.004);
    EXPECT_LT(most, 0.03);
}

// A clip whose camera is not at rest stays as it is, and says why.

std::string note_of(const ClipReader& clip) {
    return clip.notes().back();
}

void expect_untouched(ClipReader& clip, const StillScene& scene, std::int64_t begin, std::int64_t end) {
    for (std::int64_t n = begin; n < end; ++n) {
        must(clip.seek(n));
        const auto frame = must(clip.next());
        EXPECT_TRUE(same_samples(frame->depth, scene.frame(n).depth)) << n;
        EXPECT_EQ(frame->filled, nullptr);
    }
}

TEST(UnfilledClip, IsOneWithMovingCamera) {
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

TEST(UnfilledClip, IsARealHandheldRecording) {
    const auto folder = real_data("castel_sr300");
    TOUCHABLE_NEEDS_DATA(folder);
    EXPECT_EQ(note_of(*filled(must(open_clip(folder, {}, stated(&SourceDescription::preset, "realsense"))))),
              "no hole is filled from motion, because the camera moves: the clip is left as it is");
}

/// It moves for sixteen frames and stands still for the rest.
TEST(UnfilledClip, IncludesFramesOfMotion) {
    StillScene moving, still;
    moving.pan = 32;
    const auto clip = filled(clip_of(80, frames_of([=](std::int64_t n) { return n < 16 ? moving : still; })));
    EXPECT_TRUE(
        has_words(note_of(*clip), "; 16 frames of 80, in which the camera moves, are left as they are"));
    expect_untouched(*clip, moving, 0, 16);
    must(clip->seek(40));
    EXPECT_NE((**clip->next()).filled, nullptr);
}

TEST(UnfilledClip, IsOneOfFewFrames) {
    const auto clip = filled(clip_of(StillScene{}, 3));
    EXPECT_EQ(note_of(*clip),
              "no hole is filled from motion, because it takes 4 frames to tell that a camera stands still");
    expect_untouched(*clip, StillScene{}, 0, 3);
}

TEST(UnfilledClip, IsOneWithoutHoles) {
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

TEST(UnfilledClip, IsNeverLive) {
    const auto refused = with_filled_holes(std::make_unique<Around>(clip_of(StillScene{}, 8), true, -1));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    EXPECT_EQ(refused.error().message,
              "made: is a live camera, of which no later frame can tell what is behind a hole");
}

/// Reading on reports the damage; frames before it are filled.
TEST(UnfilledClip, BeginsAtDamagedFrame) {
    const auto clip = filled(std::make_unique<Around>(clip_of(StillScene{}, 64), false, 40));
    must(clip->seek(30));
    EXPECT_NE((**clip->next()).filled, nullptr);
    must(clip->seek(40));
    EXPECT_EQ(message(clip->next()), "made: frame is damaged");
    expect_untouched(*clip, StillScene{}, 41, 44);
}

TEST(UnfilledClip, IsOneThatWasStopped) {
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
