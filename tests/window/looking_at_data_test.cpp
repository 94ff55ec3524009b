// Looking at the data of a clip: lines between two places, pixels as they are stored, legends that explain.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/draw/overlays.hpp"
#include "player/window/measure.hpp"
#include "tests/clip/clip_fixture.hpp"
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

class LookingAtData : public ::testing::Test {
protected:
    Outcome run(const std::string& script, const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{clip_.string()};
        words.insert(words.end(), more.begin(), more.end());
        return run_scripted(words, script, folder_.path(), "960x640");
    }
    Image shot(const std::string& script, const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{"--screenshot", (folder_ / "shot.png").string(), "--at", "0.6",
                                       "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome done = run(script, words);
        EXPECT_EQ(done.code, 0) << done.err;
        EXPECT_EQ(done.err, "");
        auto image = read_image(folder_ / "shot.png");
        EXPECT_TRUE(image);
        return image ? *image : Image{960, 640, 1, 3, std::vector<std::uint8_t>(960 * 640 * 3)};
    }
    static glm::ivec3 colour(const Image& image, int x, int y) {
        const auto at = static_cast<std::size_t>((y * image.width + x) * 3);
        return {image.samples[at], image.samples[at + 1], image.samples[at + 2]};
    }
    const TemporaryFolder folder_;
    const std::filesystem::path clip_ = folder_ / "clip.mkv";
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

TEST_F(LookingAtData, AScriptMeasuresInMillimetresOfTheScene) {
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {slope}));
    const Outcome done = run("0 measure 20,32 70,10\n0.1 quit\n");
    ASSERT_EQ(done.code, 0) << done.err;
    const auto measured = measured_in(done.out);
    ASSERT_EQ(measured.size(), 1U) << done.out;
    const int from = slope(20, 32), to = slope(70, 10);
    const glm::dvec3 a = place_of(20, 32, from), b = place_of(70, 10, to);
    EXPECT_NEAR(measured[0].mm, glm::distance(a, b), 0.06);
    EXPECT_EQ(measured[0].from_code, from);
    EXPECT_EQ(measured[0].to_code, to);
    EXPECT_NEAR(measured[0].from_z, -a.z / 1000, 6e-5);
    EXPECT_NEAR(measured[0].to_z, -b.z / 1000, 6e-5);
    EXPECT_EQ(measured[0].to_x, 70);
    EXPECT_EQ(measured[0].to_y, 10);
}

/// Ten pixels of the window to one of the clip.
TEST_F(LookingAtData, TwoClicksOrOneStrokeMeasureWhatACommandDoes) {
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {slope}));
    const std::string click = "press left\n0 release left\n";
    const Outcome clicks = run("0 key t\n0 move 205 325\n0 " + click + "0.1 move 705 105\n0.1 " +
                               "press left\n0.1 release left\n0.3 quit\n");
    const Outcome stroke =
        run("0 measure\n0 move 205 325\n0 press left\n0.1 move 500 200\n0.1 move 705 105\n0.1 release "
            "left\n0.3 quit\n");
    for (const Outcome* done : {&clicks, &stroke}) {
        ASSERT_EQ(done->code, 0) << done->err;
        EXPECT_EQ(done->err, "");
        const auto measured = measured_in(done->out);
        ASSERT_EQ(measured.size(), 1U) << done->out;
        EXPECT_EQ(measured[0].from_x, 20);
        EXPECT_EQ(measured[0].from_y, 32);
        EXPECT_EQ(measured[0].to_x, 70);
        EXPECT_EQ(measured[0].to_y, 10);
        EXPECT_NEAR(measured[0].mm,
                    glm::distance(place_of(20, 32, slope(20, 32)), place_of(70, 10, slope(70, 10))), 0.06);
    }
}

TEST_F(LookingAtData, ALineThatCannotBeIsRefusedWithTheReason) {
    ASSERT_NO_FATAL_FAILURE(write_frames(clip_, {[](int x, int y) { return x > 60 ? 0 : slope(x, y); }}));
    const Outcome done = run("0 measure 20,32 70,32\n0 measure 20,32 96,32\n0.1 quit\n");
    EXPECT_EQ(done.code, 0);
    EXPECT_NE(done.err.find("pixel 70, 32 has no depth in frame 0"), std::string::npos) << done.err;
    EXPECT_NE(done.err.find("no pixel 96, 32; the depth has 96x64"), std::string::npos) << done.err;
    EXPECT_TRUE(measured_in(done.out).empty()) << done.out;
}

TEST_F(LookingAtData, TheLineIsDrawnUntilItIsTakenAway) {
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

TEST_F(LookingAtData, DepthHasContrastThoughSomeOfItIsFarAway) {
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
TEST_F(LookingAtData, TheLegendOfWhatIsTheSameEverywhereHasNoRamp) {
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
    std::string words(const MeasureTool& tool) const { return tool.facts(camera(), scene).words; }
};

TEST(MeasureTool, EndsStayOnASurfaceThatMoves) {
    const TwoFrames frames([](int, int) { return code_of(500); },
                           [](int x, int) { return code_of(x < 48 ? 500 : 800); });
    MeasureTool tool;
    tool.set({20, 32}, {70, 32});
    for (int k = 0; k < 2; ++k) {
        frames.show(tool, k);
        const double right =
            glm::distance(place_of(20, 32, code_of(500)), place_of(70, 32, code_of(k == 0 ? 500 : 800)));
        EXPECT_NEAR(std::atof(frames.words(tool).c_str()), right, 0.06) << k;
        const auto facts = tool.facts(frames.camera(), frames.scene);
        ASSERT_EQ(facts.ends.size(), 2U);
        EXPECT_NEAR(facts.ends[1].x, 705, 0.1);
        EXPECT_FALSE(facts.is_frozen);
    }
    EXPECT_EQ(tool.take_news().size(), 1U) << "a line is told once";
}

TEST(MeasureTool, AnEndWithoutDepthStaysWhereItWasAndIsSaidToBeFrozen) {
    const TwoFrames frames([](int, int) { return code_of(500); },
                           [](int x, int) { return x < 48 ? code_of(800) : 0; });
    MeasureTool tool;
    tool.set({20, 32}, {70, 32});
    frames.show(tool, 0);
    frames.show(tool, 1);
    const auto facts = tool.facts(frames.camera(), frames.scene);
    EXPECT_TRUE(facts.is_frozen);
    EXPECT_NE(facts.words.find("frozen"), std::string::npos) << facts.words;
    EXPECT_NEAR(std::atof(facts.words.c_str()),
                glm::distance(place_of(20, 32, code_of(800)), place_of(70, 32, code_of(500))), 0.06);
    frames.show(tool, 0);
    EXPECT_FALSE(tool.facts(frames.camera(), frames.scene).is_frozen) << "it has depth again";
}

/// Ten pixels of the window to one of the clip: places that are none of a pixel's.
TEST(MeasureTool, ShowsUnderThePointerWhatAClickTakes) {
    const TwoFrames frames(slope, slope);
    const auto facts = [&](const MeasureTool& tool) { return tool.facts(frames.camera(), frames.scene); };
    MeasureTool tool;
    frames.show(tool, 0, glm::dvec2(208.7, 321.2));
    EXPECT_FALSE(facts(tool).next) << "it is not held";
    tool.hold(true);
    const auto click = [&](const glm::dvec2& at) {
        frames.show(tool, 0, at);
        const MeasureFacts before = facts(tool);
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
    EXPECT_EQ(facts(tool).ends.at(0), *first.next);
    const MeasureFacts second = click({703.2, 108.4}), after = facts(tool);
    ASSERT_EQ(second.ends.size(), 2U);
    EXPECT_EQ(second.ends, after.ends);
    EXPECT_EQ(second.words, after.words);
    EXPECT_EQ(second.next, after.ends.at(1));
    click({305, 325});
    frames.show(tool, 0);
    EXPECT_EQ(facts(tool).ends.size(), 1U) << "it stays where the pointer went away";
    EXPECT_FALSE(facts(tool).next);
}

TEST(PixelWords, SayHowDeepAFingerIsMeantToBeOrHowFarAbove) {
    EXPECT_EQ(pressed_in_words(4), "4.0 in");
    EXPECT_EQ(pressed_in_words(-4), "4.0 above");
    EXPECT_EQ(pressed_in_words(0), "0.0 in");
}

TEST(MeasureTool, TheThirdClickBeginsAnother) {
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
    EXPECT_NE(news[0].words.find("from pixel 30, 32"), std::string::npos) << news[0].words;
    tool.hold(false);
    EXPECT_EQ(tool.facts(frames.camera(), frames.scene).ends.size(), 2U) << "the line stays";
}

}  // namespace
}  // namespace touchable::test
