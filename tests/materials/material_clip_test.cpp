// A clip whose segments feel like materials: all its other planes as they were, and what a person says of it.
#include "engine/authoring/materials.hpp"
#include "engine/authoring/segment_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include "engine/base/same_bits.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/materials/colour_segments.hpp"

namespace touchable::test {
namespace {

constexpr int columns = 40, rows = 24, count = 5;
constexpr std::array<std::uint8_t, 3> brown{150, 100, 60}, blue{60, 70, 150}, red{220, 30, 40};

/// Brown to the left and blue to the right of a border that moves by a pixel a frame, red below from frame 2
/// on; without depth in some pixels amid the brown.
RawFrame painted_frame(const Scene& scene, std::int64_t number, bool with_height) {
    struct Memory {
        Image depth{columns, rows, 1, 1, {}}, colour{columns, rows, 1, 3, {}},
            height{columns, rows, 1, 1, {}};
    };
    auto memory = std::make_shared<Memory>();
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const bool is_hole = x >= 4 && x < 8 && y >= 4 && y < 8;
            memory->depth.samples.push_back(is_hole ? 0 : static_cast<std::uint8_t>(100 + x));
            memory->height.samples.push_back(static_cast<std::uint8_t>(6 * x));
            const auto& colour = number >= 2 && y >= 20 ? red : x < 20 + number ? brown : blue;
            memory->colour.samples.insert(memory->colour.samples.end(), colour.begin(), colour.end());
        }
    RawFrame frame;
    frame.number = number;
    frame.time_ns = scene.rate.time_ns(number);
    frame.depth = memory->depth.view();
    frame.colour = memory->colour.view();
    if (with_height) frame.height = memory->height.view();
    frame.storage = std::move(memory);
    return frame;
}

class MaterialClip : public ::testing::Test {
protected:
    MaterialClip() {
        scene_.depth.invalid_code_count = 1;  // 0
        scene_.height_coding.max_height = 0.5;
        derive_valid_range(scene_.depth);
        write("clip.mkv", false);
    }
    void write(const std::string& name, bool with_height) const {
        auto writer = create_clip(folder_ / name, scene_, exact_clip);
        ASSERT_EQ(message(writer), "");
        for (int n = 0; n < count; ++n)
            ASSERT_EQ(message((*writer)->write(painted_frame(scene_, n, with_height))), "");
        ASSERT_EQ(message((*writer)->finish()), "");
    }
    Result<std::unique_ptr<ClipReader>> open(const MaterialSettings& settings,
                                             const std::string& name = "clip.mkv") const {
        auto clip = open_clip(folder_ / name);
        if (!clip) return clip.error();
        return with_materials(std::move(*clip), settings, ColourSegments::begin, report_);
    }
    static NamedSegment named(const std::string& name, const std::string& material, const PixelOfFrame& at) {
        return {name, material, find_material(material)->feel(), {at}, {}, "--at of " + name};
    }
    static std::string felt_at(const ClipReader& clip, const RawFrame& frame, int x, int y) {
        std::string all;
        for (const PaletteMaterial& material : palette()) {
            const auto code = haptic_code(material.feel().properties, clip.scene().haptic);
            if (code[0] == frame.haptic.sample(x, y, 0) && code[1] == frame.haptic.sample(x, y, 1) &&
                code[2] == frame.haptic.sample(x, y, 2))
                all += material.name;
        }
        return all;
    }

    Scene scene_ = small_scene(columns, rows);
    TemporaryFolder folder_;
    std::shared_ptr<MaterialReport> report_ = std::make_shared<MaterialReport>();
};

TEST_F(MaterialClip, HasAGuessForEachSegmentAndAllElseAsItWas) {
    auto plain = open_clip(folder_ / "clip.mkv");
    ASSERT_EQ(message(plain), "");
    const auto before = read_all(**plain);
    auto clip = open({});
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), before->size());
    for (std::size_t n = 0; n < frames->size(); ++n) {
        const RawFrame& frame = (*frames)[n];
        const int border = 20 + static_cast<int>(n);
        EXPECT_EQ(felt_at(**clip, frame, border - 1, 0), "wood") << n;
        EXPECT_EQ(felt_at(**clip, frame, border, 0), "water") << n;
        EXPECT_EQ(felt_at(**clip, frame, 10, 22), n < 2 ? "wood" : "plastic") << n;
        // A hole is what it is in, so that its rim is as hard.
        EXPECT_EQ(felt_at(**clip, frame, 5, 6), "wood") << n;
        RawFrame without = frame;
        without.haptic = {};
        EXPECT_TRUE(same_frame(without, (*before)[n])) << n;
    }
    EXPECT_EQ((*clip)->tracks().back().role, "haptic");
    for (const std::string& note : clip_notes(**clip))
        EXPECT_EQ(note.find("no haptic"), std::string::npos) << note;

    ASSERT_EQ(report_->segments.size(), 3U);
    EXPECT_EQ(report_->segments[0].paint.material, "wood");
    EXPECT_TRUE(report_->segments[0].paint.is_guess);
    EXPECT_EQ(report_->segments[0].colour, brown);
    EXPECT_EQ(report_->segments[0].pixels, 20 * rows - 16);
    EXPECT_EQ(report_->segments[2].at.frame, 2);
    EXPECT_EQ(report_->frames, count);
    // The border's pixels, and once the four lowest rows.
    EXPECT_EQ(report_->changed, rows + (20 + 4 * columns) + 20 + 20);
    EXPECT_EQ(report_->compared, (count - 1) * (columns * rows - 16));
}

TEST_F(MaterialClip, FeelsAsAPersonSaysWhereverThatSegmentGoes) {
    MaterialSettings settings;
    settings.names.segments = {named("table", "leather", {3, 3, 1}), named("mat", "rubber", {12, 23, 3})};
    settings.names.otherwise = "felt";
    auto clip = open(settings);
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    for (std::size_t n = 0; n < frames->size(); ++n) {
        EXPECT_EQ(felt_at(**clip, (*frames)[n], 0, 0), "leather") << n;
        EXPECT_EQ(felt_at(**clip, (*frames)[n], columns - 1, 0), "felt") << n;
        EXPECT_EQ(felt_at(**clip, (*frames)[n], 12, 22), n < 2 ? "leather" : "rubber") << n;
    }
    EXPECT_EQ(report_->segments[0].paint.name, "table");
    EXPECT_FALSE(report_->segments[0].paint.is_guess);
    EXPECT_EQ(report_->segments[1].paint.name, "");
    EXPECT_FALSE(report_->segments[1].paint.is_guess);
}

TEST_F(MaterialClip, IsTheSameAgainAndFromAnyFrameOn) {
    auto clip = open({});
    ASSERT_EQ(message(clip), "");
    const auto once = read_all(**clip);
    ASSERT_EQ(message((*clip)->rewind()), "");
    (*clip)->leave_out_colour();
    const auto again = read_all(**clip);
    ASSERT_EQ(message(again), "");
    for (std::size_t n = 0; n < once->size(); ++n) EXPECT_TRUE(same_frame((*once)[n], (*again)[n])) << n;
    for (const std::int64_t frame : {3, 1, 4}) {
        ASSERT_EQ(message((*clip)->seek(frame)), "");
        const auto there = (*clip)->next();
        ASSERT_TRUE(there && *there);
        EXPECT_TRUE(same_frame(**there, (*once)[static_cast<std::size_t>(frame)])) << frame;
        EXPECT_EQ(report_->frames, frame + 1);  // segments are followed from the first one on
        EXPECT_EQ(report_->segments.back().at.frame, frame < 2 ? 0 : 2);
    }
    EXPECT_FALSE((*clip)->seek(count + 1));
}

TEST_F(MaterialClip, TakesTheMapOfItsFirstFrame) {
    MaterialSettings settings;
    settings.map = SegmentMap{"map.png", {columns, rows, 1, 1, std::vector<std::uint8_t>(columns * rows, 9)}};
    // Index 7 on most of the brown, and beyond it.
    for (int y = 0; y < rows; ++y)
        for (int x = 6; x < 22; ++x)
            settings.map->indices.samples[static_cast<std::size_t>(y * columns + x)] = 7;
    settings.names.segments = {{"table", "stone", find_material("stone")->feel(), {}, 7, "n.json"}};
    settings.names.otherwise = "fur";
    auto clip = open(settings);
    ASSERT_EQ(message(clip), "");
    const auto first = (*clip)->next();
    ASSERT_TRUE(first && *first);
    EXPECT_EQ(felt_at(**clip, **first, 0, 0), "stone");
    EXPECT_EQ(felt_at(**clip, **first, 21, 0), "fur");
    EXPECT_EQ(report_->segments[0].paint.name, "table");

    settings.names.segments.push_back(named("mat", "foam", {0, 0, 0}));  // says it more exactly
    clip = open(settings);
    ASSERT_EQ(message(clip), "");
    const auto otherwise = (*clip)->next();
    EXPECT_EQ(felt_at(**clip, **otherwise, 0, 0), "foam");
}

TEST_F(MaterialClip, ScalesHeightsByTheMaterialsRelief) {
    write("relief.mkv", true);
    MaterialSettings settings;
    settings.scale_relief = true;
    settings.names.segments = {named("table", "brick", {0, 0, 0}), named("mat", "glass", {39, 0, 0})};
    auto clip = open(settings, "relief.mkv");
    ASSERT_EQ(message(clip), "");
    const auto first = (*clip)->next();
    ASSERT_TRUE(first && *first);
    for (int x = 0; x < 20; ++x)
        EXPECT_EQ((*first)->height.sample(x, 3), std::clamp(128 + (6 * x - 128) * 3 / 2, 0, 255)) << x;
    for (int x = 20; x < columns; ++x) EXPECT_EQ((*first)->height.sample(x, 3), 128) << x;
    settings.scale_relief = false;
    clip = open(settings, "relief.mkv");
    const auto as_it_was = (*clip)->next();
    EXPECT_EQ((*as_it_was)->height.sample(7, 3), 42);
}

TEST_F(MaterialClip, RefusesWhatCannotBe) {
    const auto refused = [&](const MaterialSettings& settings, ErrorKind kind, const std::string& why,
                             const std::string& name = "clip.mkv") {
        const auto clip = open(settings, name);
        ASSERT_FALSE(clip) << why;
        EXPECT_EQ(clip.error().kind, kind);
        EXPECT_NE(clip.error().message.find(why), std::string::npos) << clip.error().message;
    };
    const auto one = [&](const PixelOfFrame& at) {
        MaterialSettings settings;
        settings.names.segments = {named("table", "wood", at)};
        return settings;
    };
    refused(one({5, 5, 0}), ErrorKind::usage, "--at of table: there is no surface at pixel 5,5 of frame 0");
    refused(one({columns, 0, 0}), ErrorKind::usage, "outside of the picture, which has 40x24");
    refused(one({0, rows, 0}), ErrorKind::usage, "outside of the picture");
    refused(one({0, 0, count}), ErrorKind::usage, "frame 5 is beyond the clip, whose last one is 4");
    auto both = one({0, 0, 0});
    both.names.segments.push_back(named("chair", "foam", {1, 1, 4}));
    refused(both, ErrorKind::usage, "same segment as --at of table, which is \"table\"");
    both.names.segments[1] = named("again", "wood", {1, 1, 4});
    EXPECT_TRUE(open(both));
    // What is typed counts before what stands in a file, whichever is looked for first.
    for (const std::int64_t frame : {0, 4}) {
        auto file_too = one({0, 0, 2});
        file_too.names.segments.push_back(named("chair", "foam", {1, 1, frame}));
        file_too.names.segments.back().kind = ErrorKind::input;
        ASSERT_TRUE(open(file_too));
        const auto clip = open(file_too);
        EXPECT_EQ(message((*clip)->next()), "");
        EXPECT_EQ(report_->segments[0].paint.material, "wood");
    }

    MaterialSettings indexed;
    indexed.names.segments = {{"a", "wood", {}, {}, 3, "n.json: segments[0]", ErrorKind::input}};
    refused(indexed, ErrorKind::input, "n.json: segments[0]: has an index, but there is no map");
    indexed.map = SegmentMap{"map.png", {2, 2, 1, 1, std::vector<std::uint8_t>(4)}};
    refused(indexed, ErrorKind::input, "map.png: has 2x2 pixels");
    indexed.map->indices = {columns, rows, 1, 1, std::vector<std::uint8_t>(columns * rows)};
    refused(indexed, ErrorKind::input,
            "segments[0]: no segment has most of its pixels where map.png has index 3");
    indexed.map->indices.samples.assign(columns * rows, 3);
    EXPECT_TRUE(open(indexed));
    indexed.names.segments.push_back(indexed.names.segments[0]);
    refused(indexed, ErrorKind::input, "named twice");
    indexed.names.segments.clear();
    refused(indexed, ErrorKind::usage, "the map map.png does nothing");

    ASSERT_EQ(message(write_clip(folder_ / "grey.mkv", scene_, 2, {})), "");
    for (const auto& [name, why] : {std::pair{"grey.mkv", "has no colour"}, {"clip.mkv", "has no heights"}}) {
        MaterialSettings scaled;
        scaled.scale_relief = true;
        const auto clip = open(scaled, name);
        ASSERT_EQ(message(clip), "");
        const auto frame = (*clip)->next();
        ASSERT_FALSE(frame);
        EXPECT_NE(frame.error().message.find(why), std::string::npos) << frame.error().message;
    }
}

TEST_F(MaterialClip, TakesWhatAPersonSaysOfASegmentThatWasGuessed) {
    MaterialSettings settings;
    settings.names.segments = {named("segment 1", "wood", {0, 0, 0}), named("table", "foam", {1, 1, 0}),
                               named("segment 2", "fur", {39, 0, 0})};
    settings.names.segments[0].is_guess = settings.names.segments[2].is_guess = true;
    for (int turn = 0; turn < 2; ++turn) {
        auto clip = open(settings);
        ASSERT_EQ(message(clip), "");
        const auto first = (*clip)->next();
        ASSERT_TRUE(first && *first);
        EXPECT_EQ(felt_at(**clip, **first, 0, 0), "foam");
        EXPECT_FALSE(report_->segments[0].paint.is_guess);
        EXPECT_TRUE(report_->segments[1].paint.is_guess);
        std::swap(settings.names.segments[0], settings.names.segments[1]);
    }
}

/// Of GCC, Clang, with and without optimisation.
TEST_F(MaterialClip, HasTheSameBitsEverywhere) {
    auto clip = open({});
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ByteHash hash;
    for (const RawFrame& frame : *frames)
        for (int y = 0; y < rows; ++y) hash.add(frame.haptic.row(y), 3 * columns);
    EXPECT_EQ(hash.value(), 8102963754664857749U);
}

}  // namespace
}  // namespace touchable::test
