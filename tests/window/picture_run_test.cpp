// SPDX-License-Identifier: Apache-2.0
// Looking at the data of a clip: lines between two places, pixels as they are stored, legends that explain.

#include <gtest/gtest.h>
#include <imgui.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/draw/overlays.hpp"
#include "player/window/imgui_layer.hpp"
#include "player/window/measure.hpp"
#include "player/window/window_picture.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/player/program.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

constexpr int depth_width = 96, depth_height = 64;

/// 16 bits from 10 mm to 60 m, with hardly any perspective; code 0 is a hole.
Scene wide_scene() {
    Scene scene = small_scene(depth_width, depth_height, 16);
    scene.camera = {400, 400, 47.5, 31.5};
    scene.metres_per_unit = 0.001;
    scene.depth.far = 60'000;
    scene.depth.invalid_codes[0] = 0;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    return scene;
}

using CodeAt = std::function<int(int x, int y)>;

/// A frame of these codes; `stiffness`: a haptic picture, or none.
RawFrame frame_of(const Scene& scene, std::int64_t number, const CodeAt& code_at,
                  const CodeAt& stiffness = {}) {
    struct Memory {
        std::vector<std::uint16_t> depth;
        std::vector<std::uint8_t> haptic;
    };
    auto memory = std::make_shared<Memory>();
    for (int y = 0; y < depth_height; ++y)
        for (int x = 0; x < depth_width; ++x) {
            memory->depth.push_back(static_cast<std::uint16_t>(code_at(x, y)));
            if (stiffness)
                memory->haptic.insert(memory->haptic.end(), 3, static_cast<std::uint8_t>(stiffness(x, y)));
        }
    RawFrame frame;
    frame.number = number;
    frame.time_ns = scene.rate.time_ns(number);
    frame.depth = {reinterpret_cast<const std::uint8_t*>(memory->depth.data()),
                   2 * depth_width,
                   depth_width,
                   depth_height,
                   2,
                   1};
    if (stiffness) frame.haptic = {memory->haptic.data(), 3 * depth_width, depth_width, depth_height, 1, 3};
    frame.storage = std::move(memory);
    return frame;
}

void write_frames(const std::filesystem::path& file, const std::vector<CodeAt>& frames,
                  const CodeAt& stiffness = {}) {
    const Scene scene = wide_scene();
    auto writer = create_clip(file, scene, exact_clip);
    ASSERT_TRUE(writer) << writer.error().message;
    for (std::size_t n = 0; n < frames.size(); ++n) {
        const auto written =
            (*writer)->write(frame_of(scene, static_cast<std::int64_t>(n), frames[n], stiffness));
        ASSERT_TRUE(written) << written.error().message;
    }
    ASSERT_TRUE((*writer)->finish());
}

/// The nearest code to a range, mm, by the definition of the coding; and back.
int code_of(double range) {
    return static_cast<int>(std::lround(65535 * (60'000 - range) / (60'000 - 10.0)));
}
double range_of(int code) {
    return 60'000 - (60'000 - 10.0) * code / 65535;
}
/// A place in the scene, mm, as the clip's pinhole camera sees it at a pixel.
glm::dvec3 place_of(int x, int y, int code) {
    return range_of(code) * glm::normalize(glm::dvec3((x - 47.5) / 400, (31.5 - y) / 400, -1));
}

/// A slope to the right, from 500 to 1450 mm.
int slope(int x, int) {
    return code_of(500 + 10 * x);
}

class DataInspection : public ScriptedClipTest {
protected:
    DataInspection() : ScriptedClipTest("960x640", "0.6") {}
    static glm::ivec3 colour(const Image& image, int x, int y) {
        const auto rgb = colour_at(image, x, y);
        return {rgb[0], rgb[1], rgb[2]};
    }
};

/// "measured" as the program tells it.
struct Measured {
    double mm = 0, from_z = 0, to_z = 0;
    int from_x = 0, from_y = 0, from_code = 0, to_x = 0, to_y = 0, to_code = 0, frame = 0;
};
std::vector<Measured> measured_in(const std::string& out) {
    std::vector<Measured> all;
    for (std::size_t at = out.find("measured "); at != std::string::npos;
         at = out.find("measured ", at + 1)) {
        Measured m;
        const int read = std::sscanf(out.c_str() + at,
                                     "measured %lf mm from pixel %d, %d (z %lf m, code %d) to pixel %d, %d "
                                     "(z %lf m, code %d), frame %d",
                                     &m.mm, &m.from_x, &m.from_y, &m.from_z, &m.from_code, &m.to_x, &m.to_y,
                                     &m.to_z, &m.to_code, &m.frame);
        EXPECT_EQ(read, 10) << out;
        all.push_back(m);
    }
    return all;
}

glm::dvec3 place_on_slope(int x, int y) {
    return place_of(x, y, slope(x, y));
}

/// One line, on the slope from pixel 20, 32 to pixel 70, 10.
Measured only_measure_of(const Outcome& done) {
    EXPECT_EQ(done.code, 0) << done.err;
    const auto measured = measured_in(done.out);
    EXPECT_EQ(measured.size(), 1U) << done.out;
    if (measured.empty()) return {};
    EXPECT_EQ(measured[0].from_x, 20);
    EXPECT_EQ(measured[0].from_y, 32);
    EXPECT_EQ(measured[0].to_x, 70);
    EXPECT_EQ(measured[0].to_y, 10);
    EXPECT_NEAR(measured[0].mm, glm::distance(place_on_slope(20, 32), place_on_slope(70, 10)), 0.06);
    return measured[0];
}

TEST_F(DataInspection, MeasuresInSceneMillimetres) {
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {slope}));
    const Measured measured = only_measure_of(run("0 measure 20,32 70,10\n0.1 quit\n"));
    EXPECT_EQ(measured.from_code, slope(20, 32));
    EXPECT_EQ(measured.to_code, slope(70, 10));
    EXPECT_NEAR(measured.from_z, -place_on_slope(20, 32).z / 1000, 6e-5);
    EXPECT_NEAR(measured.to_z, -place_on_slope(70, 10).z / 1000, 6e-5);
}

/// Ten pixels of the window to one of the clip.
TEST_F(DataInspection, ClicksAndStrokesMeasure) {
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {slope}));
    const Outcome clicks =
        run("0 key t\n0 move 205 325\n0 press left\n0 release left\n0.1 move 705 105\n0.1 press left\n"
            "0.1 release left\n0.3 quit\n");
    const Outcome stroke =
        run("0 measure\n0 move 205 325\n0 press left\n0.1 move 500 200\n0.1 move 705 105\n0.1 release "
            "left\n0.3 quit\n");
    for (const Outcome* done : {&clicks, &stroke}) {
        EXPECT_EQ(done->err, "");
        only_measure_of(*done);
    }
}

TEST_F(DataInspection, RejectsInvalidLine) {
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {[](int x, int y) { return x > 60 ? 0 : slope(x, y); }}));
    const Outcome done = run("0 measure 20,32 70,32\n0 measure 20,32 96,32\n0.1 quit\n");
    EXPECT_EQ(done.code, 0);
    EXPECT_TRUE(contains(done.err, "pixel 70, 32 has no depth in frame 0"));
    EXPECT_TRUE(contains(done.err, "no pixel 96, 32; the depth has 96x64"));
    EXPECT_TRUE(measured_in(done.out).empty()) << done.out;
}

TEST_F(DataInspection, LineStaysUntilRemoved) {
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {slope}));
    const std::string line = "0 measure 20,45 70,45\n";
    const Image plain = shot(""), drawn = shot(line), off = shot(line + "0.2 measure off\n"),
                escaped = shot(line + "0.1 key t\n0.2 key escape\n");
    const auto differs = [&](const Image& image) {
        int count = 0;
        for (int x = 220; x < 690; ++x) count += colour(image, x, 455) != colour(plain, x, 455);
        return count;
    };
    EXPECT_GT(differs(drawn), 450);
    EXPECT_EQ(differs(off), 0);
    EXPECT_EQ(differs(escaped), 0) << "and the window is still there";
}

TEST_F(DataInspection, DepthKeepsContrast) {
    ASSERT_NO_FATAL_FAILURE(
        write_frames(clip_, {[](int x, int y) { return y < 8 ? code_of(55'000) : slope(x, y); }}));
    const auto contrast = [&](const char* overlay) {
        const Image image =
            shot(std::string("0 overlay ") + overlay + "\n", {"--painter", "cpu", "--builder", "cpu"});
        const glm::ivec3 off = colour(image, 100, 400) - colour(image, 860, 400);
        return std::abs(off.r) + std::abs(off.g) + std::abs(off.b);
    };
    EXPECT_GT(contrast("depth"), 250);
    EXPECT_LT(contrast("depth-linear"), 30);
}

/// In the lower right, above the bar: a ramp's dark and light ends, where there is one.
TEST_F(DataInspection, ConstantOverlayHasNoRamp) {
    const auto ends_in = [&](const Image& image) {
        int count = 0;
        for (int y = 480; y < 575; ++y)
            for (int x = 560; x < 950; ++x)
                for (const PackedColour end : {colour_ramp()[3], colour_ramp()[252]}) {
                    const glm::ivec3 off =
                        colour(image, x, y) - glm::ivec3(end & 255U, end >> 8 & 255U, end >> 16 & 255U);
                    count += std::max({std::abs(off.r), std::abs(off.g), std::abs(off.b)}) < 12;
                }
        return count;
    };
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {slope}));
    for (const char* overlay : {"stiffness", "friction", "dynamic-friction", "height"})
        EXPECT_EQ(ends_in(shot(std::string("0 overlay ") + overlay + "\n")), 0) << overlay;
    std::filesystem::remove(clip_);
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {slope}, [](int x, int) { return x < 48 ? 60 : 70; }));
    EXPECT_GT(ends_in(shot("0 overlay stiffness\n")), 30);
}

/// A frame and another one, built as the window has them.
struct TwoFrames {
    Scene scene = wide_scene();
    RawFrame raw[2];
    SurfaceFrame built[2];

    TwoFrames(const CodeAt& first, const CodeAt& second) {
        const auto builder = make_cpu_builder(scene);
        for (int k = 0; k < 2; ++k) {
            raw[k] = frame_of(scene, k, k == 0 ? first : second);
            EXPECT_TRUE(builder->build(raw[k], built[k]));
        }
    }
    void show(MeasureTool& tool, int k, std::optional<glm::dvec2> pointer = {}) const {
        const FramePair pair{
            {k, scene.rate.time_ns(k), &built[k]}, {k, scene.rate.time_ns(k), &built[k]}, 0, 0};
        const HeightField field(scene, pair);
        tool.look({.field = field,
                   .pair = pair,
                   .camera = camera(),
                   .stored = raw[k].depth,
                   .frame = k,
                   .pointer = pointer});
    }
    ViewCamera camera() const { return own_view(scene, 960, 640, 5); }
    MeasureFacts facts(const MeasureTool& tool) const { return tool.facts(camera(), scene); }
};

TEST(MeasureTool, EndsFollowMovingSurface) {
    const TwoFrames frames([](int, int) { return code_of(500); },
                           [](int x, int) { return code_of(x < 48 ? 500 : 800); });
    MeasureTool tool;
    tool.set({20, 32}, {70, 32});
    for (int k = 0; k < 2; ++k) {
        frames.show(tool, k);
        const double right =
            glm::distance(place_of(20, 32, code_of(500)), place_of(70, 32, code_of(k == 0 ? 500 : 800)));
        EXPECT_NEAR(std::atof(frames.facts(tool).words.c_str()), right, 0.06) << k;
        const auto facts = frames.facts(tool);
        ASSERT_EQ(facts.ends.size(), 2U);
        EXPECT_NEAR(facts.ends[1].x, 705, 0.1);
        EXPECT_FALSE(facts.is_frozen);
    }
    EXPECT_EQ(tool.take_news().size(), 1U) << "a line is reported once";
}

TEST(MeasureTool, EndWithoutDepthFreezes) {
    const TwoFrames frames([](int, int) { return code_of(500); },
                           [](int x, int) { return x < 48 ? code_of(800) : 0; });
    MeasureTool tool;
    tool.set({20, 32}, {70, 32});
    frames.show(tool, 0);
    frames.show(tool, 1);
    const auto facts = frames.facts(tool);
    EXPECT_TRUE(facts.is_frozen);
    EXPECT_TRUE(contains(facts.words, "frozen"));
    EXPECT_NEAR(std::atof(facts.words.c_str()),
                glm::distance(place_of(20, 32, code_of(800)), place_of(70, 32, code_of(500))), 0.06);
    frames.show(tool, 0);
    EXPECT_FALSE(frames.facts(tool).is_frozen) << "it has depth again";
}

/// Ten pixels of the window to one of the clip: places that are none of a pixel's.
TEST(MeasureTool, PreviewsClickedPixel) {
    const TwoFrames frames(slope, slope);
    MeasureTool tool;
    frames.show(tool, 0, glm::dvec2(208.7, 321.2));
    EXPECT_FALSE(frames.facts(tool).next) << "it is not held";
    tool.hold(true);
    const auto click = [&](const glm::dvec2& at) {
        frames.show(tool, 0, at);
        const MeasureFacts before = frames.facts(tool);
        tool.take({.kind = InputEvent::Kind::pressed, .word = "left"}, at);
        tool.take({.kind = InputEvent::Kind::released, .word = "left"}, at);
        frames.show(tool, 0, at);
        return before;
    };
    const MeasureFacts first = click({208.7, 321.2});
    ASSERT_TRUE(first.next);
    EXPECT_TRUE(first.ends.empty());
    EXPECT_NEAR(first.next->x, 205, 0.1) << "a pixel's middle";
    EXPECT_NEAR(first.next->y, 325, 0.1);
    EXPECT_EQ(frames.facts(tool).ends.at(0), *first.next);
    const MeasureFacts second = click({703.2, 108.4}), after = frames.facts(tool);
    ASSERT_EQ(second.ends.size(), 2U);
    EXPECT_EQ(second.ends, after.ends);
    EXPECT_EQ(second.words, after.words);
    EXPECT_EQ(second.next, after.ends.at(1));
    click({305, 325});
    frames.show(tool, 0);
    EXPECT_EQ(frames.facts(tool).ends.size(), 1U) << "it stays where the pointer went away";
    EXPECT_FALSE(frames.facts(tool).next);
}

TEST(FrameWords, CountAsOptionsDo) {
    EXPECT_EQ(frame_in_words(0, 90), "frame 0 (first 0, last 89)");
    EXPECT_EQ(frame_in_words(89, 90), "frame 89 (first 0, last 89)") << "the end";
    EXPECT_EQ(frame_in_words(7, -1), "frame 7") << "a stream";
}

TEST(PixelWords, TellDepthAndHeight) {
    EXPECT_EQ(pressed_in_words(4), "4.0 deep");
    EXPECT_EQ(pressed_in_words(-4), "4.0 above");
    EXPECT_EQ(pressed_in_words(0), "0.0 deep");
}

TEST(MeasureTool, ThirdClickStartsNewLine) {
    const TwoFrames frames(slope, slope);
    MeasureTool tool;
    const auto click = [&](double x, double y) {
        EXPECT_TRUE(tool.take({.kind = InputEvent::Kind::pressed, .word = "left"}, {x, y}));
        EXPECT_TRUE(tool.take({.kind = InputEvent::Kind::released, .word = "left"}, {x, y}));
        frames.show(tool, 0);
    };
    EXPECT_FALSE(tool.take({.kind = InputEvent::Kind::pressed, .word = "left"}, {205, 325}))
        << "it is not held";
    tool.hold(true);
    EXPECT_FALSE(tool.take({.kind = InputEvent::Kind::pressed, .word = "right"}, {205, 325}));
    click(205, 325);
    EXPECT_TRUE(tool.take_news().empty());
    click(705, 325);
    EXPECT_EQ(tool.take_news().size(), 1U);
    click(305, 325);
    EXPECT_TRUE(tool.take_news().empty());
    click(305, 125);
    const auto news = tool.take_news();
    ASSERT_EQ(news.size(), 1U);
    EXPECT_TRUE(contains(news[0].words, "from pixel 30, 32"));
    tool.hold(false);
    EXPECT_EQ(frames.facts(tool).ends.size(), 2U) << "the line stays";
}

// Letters of a kiosk's texts that the usual typeface lacks: others draw them, or a warning names them.

// Of DejaVu, which every Debian with this program has, Mono alone has the first; the second is no letter yet,
// and letters of mathematics lie beyond 16 bits.
const std::string of_mono = "\u2312", of_none = "\u2fe0", beyond = "\U0001d4d0";
const std::string hebrew = "\u05d0\u05d1";

TEST(FontFallback, FindsTypefaceForMissingLetters) {
    const FontFallback latin = find_fonts("Touch the picture, Größe, Ελλάδα");
    ASSERT_TRUE(latin.usual);
    EXPECT_EQ(latin.unwritten, "");
    const FontFallback both = find_fonts("a" + of_mono + "b" + of_mono);
    EXPECT_EQ(both.usual, latin.usual);
    ASSERT_EQ(both.others.size(), 1U);
    EXPECT_EQ(both.others[0].letters, of_mono);
    EXPECT_NE(both.others[0].face, both.usual);
    EXPECT_EQ(both.unwritten, "");
}

TEST(FontFallback, DrawsFallbackInBothSizes) {
    ImGuiLayer layer(1, "a" + of_mono + of_none);
    for (const double scale : {1.0, 2.0}) {
        if (scale > 1) layer.set_scale(scale);
        const auto& fonts = ImGui::GetIO().Fonts->Fonts;
        ASSERT_EQ(fonts.size(), 2);
        EXPECT_LT(fonts[0]->FontSize, fonts[1]->FontSize);
        for (const ImFont* font : fonts) {
            EXPECT_NE(font->FindGlyphNoFallback(0x2312), nullptr);
            EXPECT_EQ(font->FindGlyphNoFallback(0x2fe0), nullptr);
            ASSERT_NE(font->FallbackGlyph, nullptr);
            EXPECT_TRUE(font->FallbackGlyph->Visible) << "a letter that is not there is seen as a sign";
        }
    }
    EXPECT_EQ(layer.unwritten(), of_none);
}

TEST(FontFallback, NamesUnwrittenLettersOnce) {
    const FontFallback none = find_fonts(of_none + "a" + beyond + of_none);
    EXPECT_TRUE(none.others.empty());
    EXPECT_EQ(none.unwritten, of_none + beyond);
}

TEST(FontFallback, DetectsRightToLeftLetters) {
    EXPECT_EQ(right_to_left_letters("a" + hebrew + " b\u0627" + hebrew), hebrew + "\u0627");
    EXPECT_EQ(right_to_left_letters("Größe, 日本, Ελλάδα"), "");
}

TEST(FontFallback, WarnsKioskOfUnreadableText) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", texts = folder / "texts.json";
    make_clip(clip, "globe", 2);
    const auto told = [&](const std::string& invitation) {
        std::ofstream(texts) << R"({"touchable_kiosk_texts": 1, "language": "he", "invitation": ")"
                             << invitation << "\"}";
        const Outcome kiosk = run_touchable({"play", clip, "--headless", "--kiosk", "--seconds", "0.2",
                                             "--kiosk-texts", texts, "--painter", "cpu"});
        EXPECT_EQ(kiosk.code, 0) << kiosk.err;
        return kiosk.err;
    };
    EXPECT_EQ(told("Touch " + of_mono), "");
    const std::string box = told("Touch " + of_none);
    EXPECT_TRUE(contains(box, "no typeface of this machine has these letters of the kiosk's texts"));
    const std::string reversed = told(hebrew);
    EXPECT_TRUE(
        contains(reversed, "from left to right, and so these letters of the kiosk's texts too: " + hebrew));
}

TEST(UiScale, GrowsWithWindowInQuarters) {
    EXPECT_EQ(words_scale({640, 400, 1}, false), 1);
    EXPECT_EQ(words_scale({1280, 720, 1}, false), 1);
    EXPECT_EQ(words_scale({1500, 800, 1}, false), 1);
    EXPECT_EQ(words_scale({1920, 1080, 1}, false), 1.25);
    EXPECT_EQ(words_scale({2560, 1440, 1}, false), 1.5);
    EXPECT_EQ(words_scale({3840, 2160, 1}, false), 1.75);
    EXPECT_EQ(words_scale({2560, 720, 1}, false), 1) << "there is no more room from top to bottom";
}

TEST(UiScale, FollowsDisplayInUsualWindow) {
    EXPECT_EQ(words_scale({960, 600, 2}, false), 2);
    EXPECT_EQ(words_scale({2560, 1440, 2}, false), 2);
    EXPECT_EQ(words_scale({3840, 2160, 2}, false), 2.5);
}

TEST(UiScale, KioskKeepsShareOfScreen) {
    EXPECT_EQ(words_scale({1280, 720, 1}, true), 1);
    EXPECT_EQ(words_scale({1920, 1080, 1}, true), 1.5);
    EXPECT_EQ(words_scale({2560, 1440, 1}, true), 2);
    EXPECT_EQ(words_scale({3840, 2160, 2}, true), 3);
    EXPECT_EQ(words_scale({7680, 4320, 1}, true), 4);
}

TEST(UiScale, FollowsGrowingWindowUnlessStated) {
    const std::string clip = made_clip("bumps", 1).string(), grown = "0.2 size 1920x1080\n0.5 move 20 20\n";
    const auto height = [&](const std::vector<std::string>& words, const std::string& script) {
        return bar_height(played_by(words, script, "0.9").image);
    };
    const int usual = height({clip, "--scale", "1"}, grown);
    EXPECT_GT(usual, 20);
    EXPECT_NEAR(height({clip}, grown), 1.25 * usual, 2);
    EXPECT_NEAR(height({clip}, grown + "0.6 size 1280x720\n"), usual, 2) << "and back";
}

TEST(Screenshot, LeavesOutItsMessage) {
    const TemporaryFolder folder;
    const std::string script = "0.5 screenshot a.png\n1.5 screenshot b.png\n1.6 quit\n";
    const Outcome run = run_scripted({made_clip("bumps", 1).string()}, script, folder.path());
    EXPECT_EQ(run.code, 0) << run.err;
    const auto first = read_image(folder / "a.png"), second = read_image(folder / "b.png");
    ASSERT_TRUE(first && second);
    EXPECT_EQ(differences(*first, *second, {0, 0, 320, 240}), 0);
}

// What the front view tells of a finger: how near the surface is, how hard it is pressed, how the surface
// gives way. By the figures of docs/play.md, on pictures of the window, whose plane is seen from the
// front: there the force's arrow is a point.

constexpr int middle_x = 640, middle_y = 360;
/// Of a finger, pixels: 2 % of the 1080 pixels that the plane is wide there; on this plane 4 mm of the hand.
constexpr double radius = 21.6;

/// What the window shows, once a finger has come there from the camera, with it over the middle of a plane of
/// 0.6 N/mm, `deeper` mm from where it rests at first, 4 mm before it.
Image picture_of(const std::string& deeper, const std::vector<std::string>& more = {}) {
    static const TemporaryFolder folder;
    const std::string clip = (folder / "plane.mkv").string();
    if (!std::filesystem::exists(clip)) {
        const auto made = run_touchable({"make", "plane", clip, "--tilt", "0", "--frames", "1"});
        EXPECT_EQ(made.code, 0) << made.err;
    }
    std::vector<std::string> words{clip, "--painter", "raster"};
    words.insert(words.end(), more.begin(), more.end());
    return played_by(words, "0 move 640 360\n0.1 deeper " + deeper + "\n", "3.6", "1280x720").image;
}

/// A channel at a place relative to the finger's middle, y downward.
int channel_at(const Image& image, double x, double y, int channel) {
    const int i = middle_x + static_cast<int>(std::lround(x)),
              j = middle_y + static_cast<int>(std::lround(y));
    return image.samples[static_cast<std::size_t>((j * image.width + i) * 3 + channel)];
}

/// The share of the plane's light that is left there.
double light_left(const Image& image, double x, double y) {
    const auto light = [](int byte) {
        const double share = byte / 255.0;
        return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
    };
    // As far from the middle on the other side of the picture's middle line, for the clay's own shade.
    return light(channel_at(image, x, y, 1)) / light(channel_at(image, 300, y, 1));
}
/// Of the brightness, once the gloss of what is lighter is taken away: 0.2 (left - 1) of 255.
double brightness_left(const Image& image, double x, double y) {
    const double flat = channel_at(image, 300, y, 1), left = channel_at(image, x, y, 1) / flat;
    const double gloss = 0.2 * 255 / flat;
    return left > 1 ? (left + gloss) / (1 + gloss) : left;
}

/// Clockwise from straight up. Clay is never above 215: that is the ring.
int blue_of(const Image& image, double angle, double distance) {
    return channel_at(image, distance * std::sin(angle), -distance * std::cos(angle), 2);
}

/// Of the ring, 12 degrees to the right of straight up, pixels; 0: there is none.
double ring_of(const Image& image) {
    const auto blue_at = [&](double distance) { return blue_of(image, 0.21, distance); };
    int most = channel_at(image, 300, 0, 2) + 30;
    for (double distance = radius + 2; distance < 60; distance += 0.25)
        most = std::max(most, blue_at(distance));
    double sum = 0;
    int count = 0;
    for (double distance = radius + 2; distance < 60; distance += 0.25) {
        if (blue_at(distance) < most - 10) continue;
        sum += distance;
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

/// How much of a turn is drawn strongly, clockwise from straight up.
double strong_share(const Image& image) {
    const double ring = ring_of(image);
    int strong = 0;
    constexpr int steps = 360;
    for (int k = 0; k < steps; ++k)
        strong += blue_of(image, 2 * std::numbers::pi * (k + 0.5) / steps, ring) > 215;
    return strong / static_cast<double>(steps);
}

TEST(FrontView, ShowsHeightAboveSurface) {
    const Image far = picture_of("0"), near = picture_of("3.5");
    EXPECT_NEAR(ring_of(far), 1.95 * radius, 1.5);
    EXPECT_NEAR(ring_of(near), 1.6 * radius, 1.5);
    // The shadow: to the lower right, wide and faint; then below the finger, and dark.
    EXPECT_NEAR(light_left(far, 20, 23), 0.66, 0.03);
    EXPECT_NEAR(light_left(far, 45, 50), 0.94, 0.03);
    EXPECT_NEAR(light_left(far, -20, -20), 1.00, 0.03);
    EXPECT_NEAR(light_left(near, 20, 23), 0.90, 0.03);
    EXPECT_NEAR(light_left(near, 45, 50), 1.00, 0.02);
    EXPECT_NEAR(light_left(near, -20, -20), 0.98, 0.03);
}

TEST(FrontView, ShowsForce) {
    // 1.667 and 5 mm into 0.6 N/mm.
    const Image one = picture_of("5.667"), three = picture_of("9");
    EXPECT_NEAR(ring_of(one), 1.46 * radius, 1.5);
    EXPECT_NEAR(ring_of(three), 1.28 * radius, 1.5);
    // The limit is 10 N.
    EXPECT_NEAR(strong_share(one), 0.1, 0.02);
    EXPECT_NEAR(strong_share(three), 0.3, 0.02);
    // The dent, three quarters of its reach above the middle and below: 1.667 mm deep, and as deep as is
    // drawn.
    EXPECT_NEAR(brightness_left(one, 0, -42), 0.817, 0.03);
    EXPECT_NEAR(brightness_left(one, 0, 42), 1.157, 0.03);
    EXPECT_NEAR(brightness_left(three, 0, -42), 0.532, 0.03);
    EXPECT_NEAR(brightness_left(three, 0, 42), 1.299, 0.03);
}

/// From aside the arrow crosses it. At its limit all of the ring is white.
TEST(FrontView, RingCoversArrow) {
    const Image turned = picture_of("9\n0.2 max-force 1\n0.3 turn -70");
    const auto least_at = [&](double x, double y) {
        int least = 255;
        for (int channel = 0; channel < 3; ++channel)
            least = std::min(least, channel_at(turned, x, y, channel));
        return least;
    };
    // Friction holds the finger beside the middle.
    int left = 60, right = -60;
    for (int x = -60; x <= 60; ++x) {
        if (least_at(x, 0) < 225) continue;
        left = std::min(left, x);
        right = std::max(right, x);
    }
    const double ring = (right - left) / 2.0, middle = (right + left) / 2.0;
    ASSERT_NEAR(ring, 1.1 * radius, 3);
    const double outside = middle + ring + 8;
    EXPECT_GT(channel_at(turned, outside, 0, 2) - channel_at(turned, outside, 0, 0), 100) << "no arrow";
    for (int degrees = 0; degrees < 360; degrees += 5) {
        const double angle = degrees * std::numbers::pi / 180;
        int most = 0;
        for (double distance = ring - 3; distance <= ring + 3; distance += 0.5)
            most = std::max(most, least_at(middle + distance * std::sin(angle), -distance * std::cos(angle)));
        EXPECT_GT(most, 200) << degrees;
    }
}

TEST(FrontView, DentCanBeTurnedOff) {
    const Image off = picture_of("9", {"--dent", "off"}), told = picture_of("9\n0.2 dent off"),
                again = picture_of("9\n0.2 dent off\n0.3 dent on");
    for (const Image* flat : {&off, &told}) {
        EXPECT_NEAR(brightness_left(*flat, 0, -42), 1, 0.01);
        EXPECT_NEAR(brightness_left(*flat, 0, 42), 1, 0.01);
        EXPECT_NEAR(ring_of(*flat), 1.28 * radius, 1.5) << "the ring has nothing to do with it";
    }
    EXPECT_NEAR(brightness_left(again, 0, -42), 0.532, 0.03);
}

TEST(FrontView, OverlayKeepsColoursUnderFinger) {
    const Image depth = picture_of("9\n0.2 overlay stiffness");
    EXPECT_NEAR(brightness_left(depth, 0, -42), 1, 0.01);
    EXPECT_NEAR(brightness_left(depth, 0, 42), 1, 0.01);
}

}  // namespace
}  // namespace touchable::test
