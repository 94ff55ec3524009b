// SPDX-License-Identifier: Apache-2.0
// The table "Where people's depth comes from": what each row's source writes is opened by the row's own
// command. Depths are held against what was stored, to half a code.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "engine/scene/frames.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "tests/clip_notes.hpp"
#include "tests/import/source_writer.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

/// What the row's command says of `file`, which is in the place of its example.
SourceDescription said_by(const DepthSource& source, const fs::path& file) {
    std::istringstream in(source.command);
    std::vector<std::string> words{std::istream_iterator<std::string>(in), {}};
    EXPECT_EQ(words.at(0), "touchable");
    words.at(1) = file.string();
    words.erase(words.begin());
    std::ranges::reverse(words);  // as CLI11 takes them
    CLI::App app;
    ClipTyped typed;
    add_clip_options(app, typed);
    add_camera_options(app, typed.camera);
    app.parse(words);
    return must(read_camera(typed.camera));
}

/// What the remarks say is guessed, in the words of the table. Which files are which, and which values are no
/// depth, is said of all clips, and is in no row.
std::string guessed_of(const std::vector<Remark>& remarks) {
    const std::pair<const char*, const char*> beginnings[] = {
        {"the camera sees ", "camera"},
        {"a code is ", "unit"},
        {"depth codes are ", "unit"},
        {"values are ", "unit"},
        {"lengths are metres", "unit"},
        {"depth has no scale", "scale"},
        {"depth goes along", "planar"},
        {"depth is as preset", "coding"},
        {"depth is disparities, as the name says", "coding"},
        {"as Record3D exports it", "coding"},
        {"left out: ", ""},
        {"depth is ", ""},
        {"colour is ", ""},
        {"0 ", ""}};
    std::map<std::string, bool> found;
    for (const Remark& remark : remarks) {
        if (!remark.is_guess) continue;
        std::string word = "not known: " + remark.what;
        for (const auto& [beginning, of_table] : beginnings)
            if (remark.what.starts_with(beginning)) {
                word = of_table;
                break;
            }
        if (remark.what.find(" frames a second") != std::string::npos) word = "rate";
        found[word] = true;
    }
    std::string all;
    for (const char* word : {"camera", "unit", "scale", "rate", "planar", "coding"})
        if (found.erase(word) > 0) all += (all.empty() ? "" : ", ") + std::string(word);
    found.erase("");
    for (const auto& [word, _] : found) all += "; " + word;
    return all.empty() ? "nothing" : all;
}

/// Depths, codes beside them and holes of a frame.
void expect_depth(const RawFrame& frame, const Scene& scene, const Made& made, int n) {
    int holes = 0;
    for (int y = 0; y < scene.height; y += 3)
        for (int x = 0; x < scene.width; x += 3) {
            const std::uint16_t code = stored_code(frame.depth, scene.depth, x, y);
            const double truth = made.metres(n, x, y);
            ASSERT_EQ(scene.depth.is_valid(code), !std::isnan(truth)) << n << ": " << x << ", " << y;
            holes += std::isnan(truth) ? 1 : 0;
            if (std::isnan(truth)) continue;
            const double z = scene.depth.depth(code) * scene.metres_per_unit;
            double step = 0;
            for (const int beside : {code - 1, code + 1})
                if (beside >= 0 && beside <= scene.depth.code_max)
                    step = std::max(step, std::abs(scene.depth.depth(static_cast<std::uint16_t>(beside)) *
                                                       scene.metres_per_unit -
                                                   z));
            ASSERT_NEAR(z, truth, (0.505 + made.lost_codes) * step + 2e-6 * truth)
                << n << ": " << x << ", " << y;
        }
    EXPECT_LT(holes, scene.width * scene.height / 9);
}

void expect_opened(ClipReader& clip, const Made& made, std::vector<RawFrame>& frames) {
    const Scene& scene = clip.scene();
    ASSERT_EQ(scene.width, made.width);
    ASSERT_EQ(scene.height, made.height);
    EXPECT_EQ(scene.depth.semantics, made.semantics);
    EXPECT_NEAR(scene.camera.fx, made.camera.fx, 1e-6 * made.camera.fx);
    EXPECT_NEAR(scene.camera.fy, made.camera.fy, 1e-6 * made.camera.fy);
    EXPECT_NEAR(scene.camera.cx, made.camera.cx, 1e-5);
    EXPECT_NEAR(scene.camera.cy, made.camera.cy, 1e-5);
    frames = must(read_all(clip));
    ASSERT_EQ(std::ssize(frames), made.frames);
    if (made.frames > 1) {
        EXPECT_NEAR(scene.rate.per_second(), made.rate, 0.01 * made.rate);
    }
    for (int n = 0; n < made.frames; ++n) {
        const RawFrame& frame = frames[static_cast<std::size_t>(n)];
        EXPECT_EQ(!frame.colour.empty(), made.has_colour);
        expect_depth(frame, scene, made, n);
        if (::testing::Test::HasFatalFailure()) return;
    }
}

/// The scene file that is written for it gives the same, unless nothing of it is guessed.
void expect_described(const fs::path& file, const SourceDescription& known, const Scene& opened,
                      const std::vector<RawFrame>& frames) {
    const auto guessed = guess_clip(file, known);
    if (!guessed) {
        EXPECT_TRUE(is_refused(guessed, "touchable ")) << "must name another way";
        return;
    }
    const fs::path scene = fs::is_directory(file) ? file / "scene.json" : file.parent_path() / "told.json";
    write_bytes(scene, scene_to_json(*guessed));
    const auto [clip, again] =
        must_read(open_clip(scene, {}, stated(&SourceDescription::dataset, known.dataset)));
    EXPECT_EQ(clip->scene().depth, opened.depth);
    EXPECT_EQ(clip->scene().camera, opened.camera);
    ASSERT_EQ(again.size(), frames.size());
    for (std::size_t n = 0; n < frames.size(); ++n) EXPECT_TRUE(same_frame(again[n], frames[n])) << n;
}

class Source : public ::testing::TestWithParam<const DepthSource*> {
protected:
    /// Opens what the source writes, under its own names or others.
    void open(bool renames) {
        const DepthSource& source = *GetParam();
        const auto maker = source_makers().find(source.name);
        ASSERT_NE(maker, source_makers().end()) << "no test writes what " << source.name << " does";
        Writer writer(folder / (renames ? "other" : source.name), renames);
        fs::create_directories(writer.folder());
        const Made made = maker->second(writer);
        if (HasFailure()) return;
        has_other_names = writer.has_other_names();
        const SourceDescription known = said_by(source, made.file);
        const auto clip = must(open_clip(made.file, {}, known));
        std::string notes;
        for (const std::string& note : clip_notes(*clip)) notes += "\n  " + note;
        SCOPED_TRACE(notes);
        EXPECT_EQ(lost_kinds(clip->described().scene.remarks), "");
        EXPECT_EQ(guessed_of(clip->described().scene.remarks), source.guessed);
        std::vector<RawFrame> frames;
        expect_opened(*clip, made, frames);
        if (!renames && !HasFailure()) expect_described(made.file, known, clip->scene(), frames);
    }
    TemporaryFolder folder;
    bool has_other_names = false;
};

TEST_P(Source, OpensAsItsRowSays) {
    open(false);
}

TEST_P(Source, OpensUnderOtherNames) {
    open(true);
    if (HasFatalFailure()) return;
    const bool needs_names = std::string(GetParam()->read).find("name") != std::string::npos;
    EXPECT_EQ(has_other_names, !needs_names) << "a row says where names are evidence";
}

std::vector<const DepthSource*> all_sources() {
    std::vector<const DepthSource*> all;
    for (const DepthSource& each : depth_sources()) all.push_back(&each);
    return all;
}
INSTANTIATE_TEST_SUITE_P(All, Source, ::testing::ValuesIn(all_sources()), [](const auto& parameter) {
    std::string name = parameter.param->name;
    std::ranges::replace(name, '-', '_');
    return name;
});

/// docs/formats.md, "Where people's depth comes from".
TEST(Sources, MatchTableOfPage) {
    std::string table = "| name | source | files | command | read | guessed |\n|---|---|---|---|---|---|\n";
    for (const DepthSource& row : depth_sources()) {
        if (row.heading) table += "| | **" + std::string(row.heading) + "** | | | | |\n";
        table += "| `" + std::string(row.name) + "` | " + row.what + " | " + row.files + " | `" +
                 row.command + "` | " + row.read + " | " + row.guessed + " |\n";
    }
    const std::string page = read_bytes(fs::path(TOUCHABLE_SOURCE_DIR) / "docs/formats.md");
    EXPECT_TRUE(has_words(page, "\n\n" + table + '\n')) << "must be:\n" << table;
}

/// `touchable formats NAME` gives a preset its own name.
TEST(Sources, ListEachPreset) {
    for (const auto& preset : all_presets()) {
        const bool is_of_many = std::string(preset.name) == "relative-inverse" || !preset.has_values();
        EXPECT_NE(is_of_many, std::ranges::any_of(depth_sources(),
                                                  [&](const DepthSource& row) {
                                                      return std::string(row.name) == preset.name;
                                                  }))
            << preset.name;
    }
}

TEST(Sources, HaveRowForEachMaker) {
    for (const auto& maker : source_makers())
        EXPECT_TRUE(std::ranges::any_of(depth_sources(), [&](const DepthSource& row) {
            return row.name == maker.first;
        })) << maker.first;
    EXPECT_GE(depth_sources().size(), 40U);
}

}  // namespace
}  // namespace touchable::test
