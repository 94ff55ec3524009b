// SPDX-License-Identifier: Apache-2.0
// Materials painted by a person: joined, cut, undone, saved, and brought back.

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/authoring/materials.hpp"
#include "engine/authoring/segment_parts.hpp"
#include "engine/base/same_bits.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/materials/segment_colours.hpp"

namespace touchable::test {
namespace {

using Paint = MaterialBrush::Paint;
using Join = MaterialBrush::Join;
constexpr std::array<std::uint8_t, 3> brown{150, 100, 60}, blue{60, 70, 150}, red{220, 30, 40};

class Brush : public ::testing::Test {
protected:
    static MaterialBrush begun(const SegmentNames& names = {}) {
        return must(
            MaterialBrush::begin(stored({{"aaaabbcc", "aaaabbcc"}, {"aaaabbcc", "aaaaddcc"}}), names));
    }
    static std::string material(const MaterialBrush& brush, int x, int y, std::int64_t frame = 0) {
        const auto painted = brush.painted();
        return painted->by_label.at(painted->segments->label_at(frame, x, y)).material;
    }
    static void expect_done(MaterialBrush& brush, const MaterialBrush::Edit& edit) {
        EXPECT_EQ(message(brush.edit(edit)), "");
    }
};

TEST_F(Brush, PaintsSegmentInAllFrames) {
    MaterialBrush brush = begun();
    EXPECT_TRUE(brush.painted()->by_label.at(1).is_guess);
    const auto said = must(brush.edit(Paint{{1, 1, 1}, "foam"}));
    EXPECT_EQ(said, "segment 1 is foam");
    EXPECT_EQ(material(brush, 3, 0), "foam");
    EXPECT_FALSE(brush.painted()->by_label.at(1).is_guess);
    EXPECT_EQ(brush.painted()->by_label.at(1).feel, find_material("foam")->feel());
    EXPECT_TRUE(brush.painted()->by_label.at(2).is_guess);
    const auto late = must(brush.edit(Paint{{4, 1, 1}, "felt"}));
    EXPECT_EQ(late, "segment 4 is felt; only frame 1 has it");
    EXPECT_EQ(message(brush.undo()), "");
    expect_done(brush, Paint{{0, 0, 0}, "stone"});
    EXPECT_EQ(material(brush, 3, 0), "stone");
    EXPECT_EQ(brush.names().segments.size(), 1U) << "one segment, one name";
}

TEST_F(Brush, UndoesAndRedoes) {
    MaterialBrush brush = begun();
    const auto before = brush.painted();
    EXPECT_NE(message(brush.undo()), "");
    expect_done(brush, Paint{{0, 0, 0}, "foam"});
    expect_done(brush, Paint{{5, 0, 0}, "stone"});
    EXPECT_EQ(message(brush.undo()), "");
    EXPECT_EQ(material(brush, 0, 0), "foam");
    EXPECT_NE(material(brush, 5, 0), "stone");
    EXPECT_EQ(message(brush.undo()), "");
    EXPECT_EQ(brush.painted(), before);
    EXPECT_EQ(message(brush.redo()), "");
    EXPECT_EQ(message(brush.redo()), "");
    EXPECT_NE(message(brush.redo()), "");
    EXPECT_EQ(material(brush, 5, 0), "stone");
    EXPECT_EQ(message(brush.undo()), "");
    expect_done(brush, Paint{{5, 0, 0}, "felt"});
    EXPECT_NE(message(brush.redo()), "") << "another way was gone";
    EXPECT_EQ(brush.edits(), 2U);
}

TEST_F(Brush, JoinsSegments) {
    MaterialBrush brush = begun();
    expect_done(brush, Paint{{5, 0, 0}, "stone"});
    expect_done(brush, Join{{0, 0, 0}, {5, 0, 0}});
    EXPECT_EQ(material(brush, 0, 0), "stone") << "what a person said counts";
    expect_done(brush, Join{{7, 0, 0}, {1, 1, 1}});
    expect_done(brush, Paint{{7, 1, 1}, "felt"});
    for (const int x : {0, 5, 7}) EXPECT_EQ(material(brush, x, 0), "felt") << x;
    EXPECT_NE(material(brush, 4, 1, 1), "felt");
    EXPECT_EQ(brush.names().segments.size(), 1U);
    EXPECT_EQ(brush.names().segments[0].at.size(), 3U);
    expect_error(brush.edit(Join{{0, 0, 0}, {7, 0, 0}}), "one already");
    expect_error(brush.edit(Join{{0, 0, 0}, {1, 0, 0}}), "both places");
}

TEST_F(Brush, JoinsGuessesUnderTheFirst) {
    MaterialBrush brush = begun();
    const std::string first = material(brush, 0, 0);
    expect_done(brush, Join{{0, 0, 0}, {5, 0, 0}});
    EXPECT_EQ(material(brush, 5, 0), first);
    EXPECT_TRUE(brush.painted()->by_label.at(2).is_guess);
}

TEST_F(Brush, KeepsFeelOfCutParts) {
    MaterialBrush brush = begun();
    expect_done(brush, Paint{{0, 0, 0}, "foam"});
    expect_done(brush, SegmentCut{0, {{1, 0}, {1, 1}}});
    EXPECT_EQ(material(brush, 0, 0), "foam");
    EXPECT_EQ(material(brush, 3, 0), "foam");
    expect_done(brush, Paint{{3, 0, 0}, "glass"});
    EXPECT_EQ(material(brush, 0, 0), "foam");
    EXPECT_EQ(material(brush, 3, 1, 1), "glass");
    ASSERT_EQ(brush.names().segments.size(), 2U);
    EXPECT_NE(brush.names().segments[0].name, brush.names().segments[1].name);
    EXPECT_EQ(message(brush.undo()), "");
    EXPECT_EQ(message(brush.undo()), "");
    EXPECT_EQ(brush.painted()->by_label.size(), 4U);
}

TEST_F(Brush, ChangesNothingWhenRefusing) {
    MaterialBrush brush = begun();
    const auto before = brush.painted();
    expect_error(brush.edit(Paint{{0, 0, 0}, "woood"}), "wood");
    expect_error(brush.edit(Paint{{8, 0, 0}, "wood"}), "beyond");
    expect_error(brush.edit(Paint{{0, -1, 0}, "wood"}), "beyond");
    expect_error(brush.edit(Paint{{0, 0, 2}, "wood"}), "beyond");
    EXPECT_NE(message(brush.edit(MaterialBrush::Otherwise{"woood"})), "");
    EXPECT_NE(message(brush.edit(SegmentCut{0, {{7, 0}, {7, 1}}})), "");
    EXPECT_EQ(brush.painted(), before);
    EXPECT_EQ(brush.edits(), 0U);
}

/// A brush with one edit of each kind, and one undone.
MaterialBrush used(MaterialBrush brush) {
    EXPECT_EQ(message(brush.edit(MaterialBrush::Otherwise{"felt"})), "");
    EXPECT_EQ(message(brush.edit(Paint{{0, 0, 0}, "foam"})), "");
    EXPECT_EQ(message(brush.edit(SegmentCut{1, {{1, 0}, {1, 1}}})), "");
    EXPECT_EQ(message(brush.edit(Join{{0, 0, 0}, {5, 0, 0}})), "");
    EXPECT_EQ(message(brush.edit(Paint{{7, 0, 0}, "glass"})), "");
    EXPECT_EQ(message(brush.undo()), "");
    return brush;
}

TEST_F(Brush, RepeatsItsHistory) {
    SegmentNames names;
    names.segments = {{"lamp", "glass", find_material("glass")->feel(), {{4, 1, 1}}}};
    const MaterialBrush brush = used(begun(names));
    MaterialBrush later = begun();
    must(later.repeat(brush.history(), "h.json"));
    EXPECT_EQ(later.history(), brush.history());
    EXPECT_EQ(segment_names_to_json(later.names()), segment_names_to_json(brush.names()));
    for (const auto& [label, paint] : brush.painted()->by_label)
        EXPECT_EQ(later.painted()->by_label.at(label).feel, paint.feel) << label;
    EXPECT_EQ(later.painted()->by_label.at(4).name, "lamp");
    EXPECT_EQ(message(later.redo()), "");
    EXPECT_EQ(material(later, 7, 0), "glass");
}

TEST_F(Brush, RejectsForeignHistory) {
    MaterialBrush brush = used(begun());
    const std::string text = brush.history();
    const auto refused = [&](const std::string& from, const std::string& to, const std::string& why) {
        std::string changed = text;
        const std::size_t at = changed.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        changed.replace(at, from.size(), to);
        MaterialBrush other = begun();
        const std::string said = message(other.repeat(changed, "h.json"));
        EXPECT_EQ(said.rfind("h.json: ", 0), 0U) << said;
        EXPECT_NE(said.find(why), std::string::npos) << said;
        EXPECT_EQ(other.edits(), 0U);
    };
    refused("\"segments\": \"", "\"segments\": \"0", "other segments");
    refused("\"touchable_brush\": 1", "\"touchable_brush\": 2", "touchable_brush");
    refused("\"done\": 4", "\"done\": 6", "done");
    refused("\"paint\":[0,0,0]", "\"paint\":[0,0,9]", "edits[1]");
    refused("\"join\"", "\"joint\"", "edits[3]");
    refused("}", "", "");
}

/// Endless painting loses only the oldest undo steps.
TEST_F(Brush, ForgetsOldestEdits) {
    MaterialBrush brush = begun();
    expect_done(brush, SegmentCut{0, {{1, 0}, {1, 1}}});
    const std::size_t labels = brush.painted()->by_label.size();
    for (std::size_t k = 0; k <= MaterialBrush::most_edits; ++k)
        expect_done(brush, Paint{{3, 0, 0}, k % 2 == 0 ? "glass" : "foam"});
    EXPECT_EQ(brush.edits(), MaterialBrush::most_edits);
    while (brush.undo()) continue;
    EXPECT_EQ(brush.done(), 0U);
    EXPECT_EQ(brush.painted()->by_label.size(), labels) << "the cut is older, and stays";
    EXPECT_EQ(material(brush, 3, 0), "glass");
    MaterialBrush later = begun();
    must(later.repeat(brush.history(), "h.json"));
    EXPECT_EQ(later.history(), brush.history());
}

/// As a file may have it, where both feel the same.
TEST_F(Brush, PaintsSegmentWithTwoNames) {
    SegmentNames names;
    const Feel felt = find_material("felt")->feel();
    names.segments = {{"table", "felt", felt, {{0, 0, 0}, {5, 0, 0}}},
                      {"again", "felt", felt, {{1, 1, 1}, {7, 0, 0}}}};
    MaterialBrush brush = begun(names);
    EXPECT_EQ(brush.names().segments.size(), 1U);
    expect_done(brush, Paint{{0, 0, 0}, "glass"});
    for (const int x : {0, 5, 7}) EXPECT_EQ(material(brush, x, 0), "glass") << x;
    expect_done(brush, Join{{4, 1, 1}, {0, 0, 0}});
    EXPECT_EQ(material(brush, 4, 1, 1), "glass");
    EXPECT_EQ(material(brush, 7, 0), "glass");
}

/// Saved names, given on the command line, make the same clip.
TEST_F(Brush, SavesWhatWasFelt) {
    Scene scene = small_scene(12, 8);
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    TemporaryFolder folder;
    auto writer = must(create_clip(folder / "clip.mkv", scene, exact_clip));
    for (int n = 0; n < 3; ++n) {
        Image depth{12, 8, 1, 1, std::vector<std::uint8_t>(96, 100)}, colours{12, 8, 1, 3, {}};
        for (int k = 0; k < 96; ++k) {
            const auto& colour = k % 12 < 5 + n ? brown : blue;
            colours.samples.insert(colours.samples.end(), colour.begin(), colour.end());
        }
        RawFrame frame;
        frame.number = n;
        frame.time_ns = scene.rate.time_ns(n);
        add_plane(frame, PlaneRole::depth, plane_from(std::move(depth)));
        add_plane(frame, PlaneRole::colour, plane_from(std::move(colours)));
        must(writer->write(frame));
    }
    must(writer->finish());

    auto clip = must(open_clip(folder / "clip.mkv"));
    auto brush = must(MaterialBrush::begin(must(read_segments(*clip, ColourSegments::begin, {}))));
    expect_done(brush, SegmentCut{1, {{0, 3}, {5, 3}}});
    expect_done(brush, Paint{{0, 0, 0}, "foam"});
    expect_done(brush, Paint{{0, 7, 1}, "glass"});
    must(clip->rewind());
    auto felt = must(with_painted_segments(std::move(clip), brush.painted()));
    const auto of_brush = must(read_all(*felt));

    MaterialSettings settings;
    settings.names = must(parse_segment_names(segment_names_to_json(brush.names()), "n.json"));
    auto command = must(with_materials(must(open_clip(folder / "clip.mkv")), settings, ColourSegments::begin,
                                       std::make_shared<MaterialReport>()));
    const auto of_command = must(read_all(*command));
    ASSERT_EQ(of_command.size(), of_brush.size());
    for (std::size_t n = 0; n < of_brush.size(); ++n)
        EXPECT_TRUE(same_frame(of_command[n], of_brush[n])) << n;
    EXPECT_NE(of_brush[0].haptic.sample(0, 0), of_brush[0].haptic.sample(0, 7));
    must(felt->seek(2));
    const auto last = must(felt->next());
    EXPECT_TRUE(same_frame(*last, of_brush.back()));
}

// A clip whose segments feel like materials: all its other planes as they were, and what a person says of it.

constexpr int columns = 40, rows = 24, count = 5;

/// Brown to the left and blue to the right of a border that moves by a pixel a frame, red below from frame 2
/// on; without depth in some pixels amid the brown.
RawFrame painted_frame(const Scene& scene, std::int64_t number, bool with_height) {
    Image depth{columns, rows, 1, 1, {}}, colours{columns, rows, 1, 3, {}}, heights{columns, rows, 1, 1, {}};
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const bool is_hole = x >= 4 && x < 8 && y >= 4 && y < 8;
            depth.samples.push_back(is_hole ? 0 : static_cast<std::uint8_t>(100 + x));
            heights.samples.push_back(static_cast<std::uint8_t>(6 * x));
            const auto& colour = number >= 2 && y >= 20 ? red : x < 20 + number ? brown : blue;
            colours.samples.insert(colours.samples.end(), colour.begin(), colour.end());
        }
    RawFrame frame;
    frame.number = number;
    frame.time_ns = scene.rate.time_ns(number);
    add_plane(frame, PlaneRole::depth, plane_from(std::move(depth)));
    add_plane(frame, PlaneRole::colour, plane_from(std::move(colours)));
    if (with_height) add_plane(frame, PlaneRole::height, plane_from(std::move(heights)));
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
        auto writer = must(create_clip(folder_ / name, scene_, exact_clip));
        for (int n = 0; n < count; ++n) must(writer->write(painted_frame(scene_, n, with_height)));
        must(writer->finish());
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

TEST_F(MaterialClip, GuessesEachSegmentsMaterial) {
    auto plain = must(open_clip(folder_ / "clip.mkv"));
    const auto before = must(read_all(*plain));
    auto clip = must(open({}));
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), before.size());
    for (std::size_t n = 0; n < frames.size(); ++n) {
        const RawFrame& frame = frames[n];
        const int border = 20 + static_cast<int>(n);
        EXPECT_EQ(felt_at(*clip, frame, border - 1, 0), "wood") << n;
        EXPECT_EQ(felt_at(*clip, frame, border, 0), "water") << n;
        EXPECT_EQ(felt_at(*clip, frame, 10, 22), n < 2 ? "wood" : "plastic") << n;
        // A hole is what it is in, so that its rim is as hard.
        EXPECT_EQ(felt_at(*clip, frame, 5, 6), "wood") << n;
        RawFrame without = frame;
        without.haptic = {};
        EXPECT_TRUE(same_frame(without, before[n])) << n;
    }
    EXPECT_EQ(clip->tracks().back().role, "haptic");
    for (const std::string& note : clip_notes(*clip))
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

TEST_F(MaterialClip, FollowsNamedSegments) {
    MaterialSettings settings;
    settings.names.segments = {named("table", "leather", {3, 3, 1}), named("mat", "rubber", {12, 23, 3})};
    settings.names.otherwise = "felt";
    auto clip = must(open(settings));
    const auto frames = must(read_all(*clip));
    for (std::size_t n = 0; n < frames.size(); ++n) {
        EXPECT_EQ(felt_at(*clip, frames[n], 0, 0), "leather") << n;
        EXPECT_EQ(felt_at(*clip, frames[n], columns - 1, 0), "felt") << n;
        EXPECT_EQ(felt_at(*clip, frames[n], 12, 22), n < 2 ? "leather" : "rubber") << n;
    }
    EXPECT_EQ(report_->segments[0].paint.name, "table");
    EXPECT_FALSE(report_->segments[0].paint.is_guess);
    EXPECT_EQ(report_->segments[1].paint.name, "");
    EXPECT_FALSE(report_->segments[1].paint.is_guess);
}

TEST_F(MaterialClip, IsSameFromAnyFrame) {
    auto clip = must(open({}));
    const auto once = must(read_all(*clip));
    must(clip->rewind());
    clip->leave_out_colour();
    const auto again = must(read_all(*clip));
    for (std::size_t n = 0; n < once.size(); ++n) EXPECT_TRUE(same_frame(once[n], again[n])) << n;
    for (const std::int64_t frame : {3, 1, 4}) {
        must(clip->seek(frame));
        const RawFrame there = must(clip->next()).value();
        EXPECT_TRUE(same_frame(there, once[static_cast<std::size_t>(frame)])) << frame;
        EXPECT_EQ(report_->frames, frame + 1);  // segments are followed from the first one on
        EXPECT_EQ(report_->segments.back().at.frame, frame < 2 ? 0 : 2);
    }
    EXPECT_FALSE(clip->seek(count + 1));
}

TEST_F(MaterialClip, TakesMapOfFirstFrame) {
    MaterialSettings settings;
    settings.map = SegmentMap{"map.png", {columns, rows, 1, 1, std::vector<std::uint8_t>(columns * rows, 9)}};
    // Index 7 on most of the brown, and beyond it.
    for (int y = 0; y < rows; ++y)
        for (int x = 6; x < 22; ++x)
            settings.map->indices.samples[static_cast<std::size_t>(y * columns + x)] = 7;
    settings.names.segments = {{"table", "stone", find_material("stone")->feel(), {}, 7, "n.json"}};
    settings.names.otherwise = "fur";
    auto clip = must(open(settings));
    const RawFrame first = must(clip->next()).value();
    EXPECT_EQ(felt_at(*clip, first, 0, 0), "stone");
    EXPECT_EQ(felt_at(*clip, first, 21, 0), "fur");
    EXPECT_EQ(report_->segments[0].paint.name, "table");

    settings.names.segments.push_back(named("mat", "foam", {0, 0, 0}));  // says it more exactly
    clip = must(open(settings));
    EXPECT_EQ(felt_at(*clip, must(clip->next()).value(), 0, 0), "foam");
}

TEST_F(MaterialClip, ScalesHeightsByRelief) {
    write("relief.mkv", true);
    MaterialSettings settings;
    settings.scale_relief = true;
    settings.names.segments = {named("table", "brick", {0, 0, 0}), named("mat", "glass", {39, 0, 0})};
    auto clip = must(open(settings, "relief.mkv"));
    const RawFrame first = must(clip->next()).value();
    for (int x = 0; x < 20; ++x)
        EXPECT_EQ(first.height.sample(x, 3), std::clamp(128 + (6 * x - 128) * 3 / 2, 0, 255)) << x;
    for (int x = 20; x < columns; ++x) EXPECT_EQ(first.height.sample(x, 3), 128) << x;
    settings.scale_relief = false;
    clip = must(open(settings, "relief.mkv"));
    EXPECT_EQ(must(clip->next()).value().height.sample(7, 3), 42);
}

TEST_F(MaterialClip, RejectsImpossibleNames) {
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
    // Typed names win over those of a file, whichever is looked for first.
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

    must(write_clip(folder_ / "grey.mkv", scene_, 2, {}));
    for (const auto& [name, why] : {std::pair{"grey.mkv", "has no colour"}, {"clip.mkv", "has no heights"}}) {
        MaterialSettings scaled;
        scaled.scale_relief = true;
        const auto clip = must(open(scaled, name));
        expect_error(clip->next(), why);
    }
}

TEST_F(MaterialClip, ReplacesGuessByStatement) {
    MaterialSettings settings;
    settings.names.segments = {named("segment 1", "wood", {0, 0, 0}), named("table", "foam", {1, 1, 0}),
                               named("segment 2", "fur", {39, 0, 0})};
    settings.names.segments[0].is_guess = settings.names.segments[2].is_guess = true;
    for (int turn = 0; turn < 2; ++turn) {
        auto clip = must(open(settings));
        const RawFrame first = must(clip->next()).value();
        EXPECT_EQ(felt_at(*clip, first, 0, 0), "foam");
        EXPECT_FALSE(report_->segments[0].paint.is_guess);
        EXPECT_TRUE(report_->segments[1].paint.is_guess);
        std::swap(settings.names.segments[0], settings.names.segments[1]);
    }
}

/// By GCC and Clang, with and without optimisation.
TEST_F(MaterialClip, HasSameBitsEverywhere) {
    auto clip = must(open({}));
    const auto frames = read_all(*clip);
    ByteHash hash;
    for (const RawFrame& frame : *frames)
        for (int y = 0; y < rows; ++y) hash.add(frame.haptic.row(y), 3 * columns);
    EXPECT_EQ(hash.value(), 8102963754664857749U);
}

}  // namespace
}  // namespace touchable::test
