// Holes of a recording that other frames saw, as somebody asks for them to be filled.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>

#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "tests/background/still_scene.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;
constexpr const char* filled_words = "holes are filled from frames that saw what is behind: ";

/// A hand over a table, in pictures of millimetres and their colour.
class RecordedTable : public ::testing::Test {
protected:
    RecordedTable() {
        for (int n = 0; n < count; ++n) {
            const RawFrame frame = StillScene{}.frame(n);
            write("depth", n, frame.depth);
            write("rgb", n, frame.colour);
        }
        std::ofstream(scene()) << R"({"touchable_scene": 1, "width": 160, "height": 120,
            "camera": {"fx": 150, "fy": 150, "cx": 79.5, "cy": 59.5},
            "depth": {"coding": "metric", "scale": 1, "far": 4000, "invalid": [0]},
            "filter": {"median": 0, "fill_holes": 0, "temporal": "off", "terraces": "off"},
            "folder": {"depth": "depth_%03d.png", "colour": "rgb_%03d.png"}})";
    }
    static constexpr int count = 20;
    std::string scene() const { return folder_ / "scene.json"; }
    void write(const char* name, int number, const PlaneView& plane) const {
        std::array<char, 32> file{};
        std::snprintf(file.data(), file.size(), "%s_%03d.png", name, number);
        EXPECT_TRUE(write_png(folder_ / file.data(), plane));
    }
    Outcome run(Words words, bool filled = true) const {
        if (filled) words.insert(words.end(), {"--fill-from-motion", "on"});
        return run_touchable(words);
    }

    TemporaryFolder folder_;
};

TEST_F(RecordedTable, SaysWhatIsFilled) {
    const Outcome told = run({"info", scene()});
    EXPECT_NE(told.out.find(filled_words), std::string::npos) << told.out << told.err;
    EXPECT_NE(told.out.find("(of 20 frames)"), std::string::npos) << told.out;
    EXPECT_EQ(run({"info", scene()}, false).out.find("filled from"), std::string::npos);
    EXPECT_EQ(run_touchable({"info", scene(), "--fill-from-motion", "off"}).out.find("filled from"),
              std::string::npos);
    const Outcome refused = run_touchable({"info", scene(), "--fill-from-motion", "maybe"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("maybe is not allowed; must be off or on"), std::string::npos) << refused.err;
}

TEST_F(RecordedTable, IsTouchedAndReplayedAsItWas) {
    const Words words{scene(), "--seconds", "0.5", "--hand",
                      "press:x=0.42,y=0.42,depth=30,lift=5,period=0.4"};
    const auto touched = [&](const std::string& fill, const std::string& recording) {
        Words all = words;
        all.insert(all.end(), {"--fill-from-motion", fill, "--record", recording});
        return force_hash(all);
    };
    const std::string on = folder_ / "on.touch", off = folder_ / "off.touch";
    const std::string hash = touched("on", on);
    EXPECT_NE(touched("off", off), hash);
    const Outcome replayed = run_touchable({"touch", "--replay", on, "--verbose"});
    EXPECT_EQ(replayed.code, 0) << replayed.err;
    EXPECT_NE((replayed.out + replayed.err).find(filled_words), std::string::npos)
        << replayed.out << replayed.err;
    EXPECT_EQ(run_touchable({"touch", "--replay", off}).code, 0);
    EXPECT_EQ(run({"touch", "--replay", off}).code, 2);
}

/// Its depth is stored anew, also where the clip could be copied; what was filled stays filled.
TEST_F(RecordedTable, IsConvertedOnceForGood) {
    const std::string raw = folder_ / "raw.mkv", once = folder_ / "once.mkv";
    ASSERT_EQ(run({"convert", scene(), raw}, false).code, 0);
    const Outcome converted = run({"convert", raw, once});
    ASSERT_EQ(converted.code, 0) << converted.err;
    EXPECT_NE((converted.out + converted.err).find(filled_words), std::string::npos)
        << converted.out << converted.err;
    auto opened = open_clip(raw);
    ASSERT_EQ(message(opened), "");
    const auto filled_now = test::read_all(*filled(std::move(*opened)));
    auto written = open_clip(once);
    ASSERT_EQ(message(written), "");
    const auto stored = test::read_all(**written);
    ASSERT_EQ(message(stored), "");
    ASSERT_EQ(stored->size(), filled_now->size());
    for (std::size_t n = 0; n < stored->size(); ++n) {
        EXPECT_TRUE(same_samples((*stored)[n].depth, (*filled_now)[n].depth)) << n;
        EXPECT_FALSE(same_samples((*stored)[n].depth, StillScene{}.frame(static_cast<std::int64_t>(n)).depth))
            << n;
        EXPECT_EQ((*stored)[n].filled, nullptr);
    }
}

/// The clip's own view has a pixel for each pixel; the legend covers a corner.
TEST_F(RecordedTable, ShowsWhatIsFilled) {
    const std::string picture = folder_ / "validity.png";
    for (const std::string builder : {"cpu", "reference"}) {
        const Outcome drawn = run({"export", scene(), "--frame", "9", "--picture", picture, "--view", "own",
                                   "--show", "validity", "--picture-size", "640x480", "--painter", "cpu",
                                   "--builder", builder, "--overwrite"});
        ASSERT_EQ(drawn.code, 0) << drawn.err;
        const auto seen = read_image(picture);
        ASSERT_TRUE(seen);
        auto opened = open_clip(scene());
        ASSERT_EQ(message(opened), "");
        const auto clip = filled(std::move(*opened));
        ASSERT_EQ(message(clip->seek(9)), "");
        const RawFrame frame = **clip->next();
        // Purple has more of red than of green, and of blue; depth that was measured there is blue.
        int purple = 0, marked = 0;
        for (int y = 3; y < 70; ++y)
            for (int x = 3; x < 150; ++x) {
                const std::uint8_t* rgb = seen->view().row(4 * y + 2) + 3 * (4 * x + 2);
                const bool is_purple = rgb[0] > rgb[1] + 30 && rgb[2] > rgb[1] + 15;
                purple += is_purple;
                marked += is_marked(frame, x, y);
            }
        EXPECT_GT(marked, 100);
        EXPECT_NEAR(purple, marked, 0.15 * marked) << builder;
    }
}

TEST_F(RecordedTable, IsRefusedOfACamera) {
    const std::string raw = folder_ / "raw.mkv";
    ASSERT_EQ(run({"convert", scene(), raw}, false).code, 0);
    const Outcome refused = run({"touch", "--live", "--camera", "replay:" + raw, "--seconds", "0.1"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(
        refused.err.find("is touched as a camera, of which no later frame can tell what is behind a hole"),
        std::string::npos)
        << refused.err;
}

}  // namespace
}  // namespace touchable::test
