// The brush of materials in a window, by scripts: what it shows, saves, and finds again.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "engine/authoring/materials.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "player/session/clip_choice.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/two_surfaces.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

class BrushScript : public ::testing::Test {
protected:
    void SetUp() override { ASSERT_NO_FATAL_FAILURE(write_two_surfaces(clip_, 4)); }
    Outcome run(const std::string& script, const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{clip_.string()};
        words.insert(words.end(), more.begin(), more.end());
        return run_scripted(words, script, folder_.path());
    }
    /// What the window shows once the script is done; drawn by the CPU, without words.
    Image shot(const std::string& script, const std::vector<std::string>& more = {}) {
        std::vector<std::string> words{"--screenshot", (folder_ / "shot.png").string(),
                                       "--at",         "2",
                                       "--painter",    "cpu",
                                       "--builder",    "cpu",
                                       "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome done = run(script, words);
        EXPECT_EQ(done.code, 0) << done.err;
        EXPECT_EQ(done.err, "");
        auto image = read_image(folder_ / "shot.png");
        EXPECT_TRUE(image);
        return image ? *image : Image{320, 240, 1, 3, std::vector<std::uint8_t>(320 * 240 * 3)};
    }
    static std::vector<int> colour(const Image& image, int x, int y) {
        const auto at = static_cast<std::size_t>((y * image.width + x) * 3);
        return {image.samples[at], image.samples[at + 1], image.samples[at + 2]};
    }
    std::string saved() const { return file_contents(folder_ / "saved.json"); }
    std::string save() const { return "0 save-materials " + (folder_ / "saved.json").string() + "\n"; }
    const std::string quit_ = "0 quit\n";
    const TemporaryFolder folder_;
    const fs::path clip_ = folder_ / "wall.mkv";
};

// Of the window, on either half of the wall.
constexpr int left = 80, right = 240, row = 120;

TEST_F(BrushScript, WhatIsPaintedIsFeltAndComparedByOneKey) {
    const std::string overlay = "0 overlay stiffness\n", paint =
                                                             "0 material water\n0 paint 20,32\n"
                                                             "0 material brick\n0 paint 70,32,3\n";
    const Image before = shot(overlay), painted = shot(overlay + paint),
                compared = shot(overlay + paint + "0.2 key b\n"),
                again = shot(overlay + paint + "0.2 key b\n0.5 key b\n"),
                undone = shot(overlay + paint + "0.2 undo\n0.2 undo\n0.2 tool touch\n");
    EXPECT_EQ(colour(before, left, row), colour(before, right, row)) << "the clip is the same everywhere";
    EXPECT_NE(colour(painted, left, row), colour(painted, right, row));
    EXPECT_EQ(colour(again, left, row), colour(painted, left, row));
    EXPECT_EQ(colour(again, right, row), colour(painted, right, row));
    for (const Image* image : {&compared, &undone}) {
        EXPECT_EQ(colour(*image, left, row), colour(before, left, row));
        EXPECT_EQ(colour(*image, right, row), colour(before, right, row));
    }
}

TEST_F(BrushScript, AToolInTheHandTintsThePicture) {
    const std::string paint = "0 material grass\n0 paint 20,32\n0 material water\n0 paint 70,32\n";
    const Image tinted = shot(paint), away = shot(paint + "0.2 tool touch\n"), plain = shot("");
    EXPECT_GT(colour(tinted, left, row)[1], colour(tinted, left, row)[0] + 30) << "green";
    EXPECT_GT(colour(tinted, right, row)[2], colour(tinted, right, row)[1] + 30) << "blue";
    EXPECT_EQ(colour(away, left, row), colour(plain, left, row));
}

/// In a window that is so large that the panel, which comes with the tool, covers neither place.
TEST_F(BrushScript, ClicksAndStrokesDoWhatCommandsDo) {
    const std::string large = "0 size 960x640\n", click = "0 press left\n0 release left\n",
                      on_left = "0 move 240 320\n" + click, on_right = "0 move 560 320\n" + click;
    const Outcome done =
        run(large + "0 material felt\n" + on_left + "0 tool join\n" + on_left + on_right + save() + quit_);
    ASSERT_EQ(done.code, 0);
    EXPECT_EQ(done.err, "");
    const auto joined = parse_segment_names(saved(), "saved");
    ASSERT_TRUE(joined) << joined.error().message;
    ASSERT_EQ(joined->segments.size(), 1U);
    EXPECT_EQ(joined->segments[0].material, "felt");
    EXPECT_EQ(joined->segments[0].at.size(), 2U);
    std::string stroke = "0 tool cut\n0 move 10 500\n0 press left\n";
    for (int x = 20; x <= 560; x += 10) stroke += "0 move " + std::to_string(x) + " 500\n";
    ASSERT_EQ(run(large + stroke + "0 release left\n" + save() + quit_).code, 0);
    const auto cut = parse_segment_names(saved(), "saved");
    ASSERT_TRUE(cut) << cut.error().message;
    ASSERT_EQ(cut->cuts.size(), 1U);
    EXPECT_GT(cut->cuts[0].stroke.size(), 10U);
}

TEST_F(BrushScript, WhatIsSavedMakesTheClipThatWasFelt) {
    ASSERT_EQ(run("0 material foam\n0 paint 20,32\n0 cut 40,30 95,30\n0 paint 70,5\n0 otherwise brick\n" +
                  save() + quit_)
                  .code,
              0);
    const fs::path out = folder_ / "out.mkv";
    const Outcome made = run_touchable(
        {"materials", clip_.string(), out.string(), "--segments", (folder_ / "saved.json").string()});
    ASSERT_EQ(made.code, 0) << made.err;
    ClipChoice felt;
    felt.file = clip_;
    auto segments = read_chosen_segments(felt, {});
    ASSERT_TRUE(segments);
    const auto names = parse_segment_names(saved(), "saved");
    ASSERT_TRUE(names) << names.error().message;
    auto brush = MaterialBrush::begin(std::move(*segments), *names);
    ASSERT_TRUE(brush) << brush.error().message;
    felt.painted = brush->painted();
    auto of_window = felt.open();
    auto of_command = open_clip(out);
    ASSERT_TRUE(of_window && of_command);
    for (int n = 0; n < 4; ++n) {
        const auto a = (*of_window)->next(), b = (*of_command)->next();
        ASSERT_TRUE(a && b && *a && *b) << n;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 96; ++x)
                for (int c = 0; c < 3; ++c)
                    ASSERT_EQ((*a)->haptic.sample(x, y, c), (*b)->haptic.sample(x, y, c)) << x << ' ' << y;
    }
}

TEST_F(BrushScript, AnotherWindowHasWhatThisOneDid) {
    const std::vector<std::string> history{"--brush-history", (folder_ / "state").string()};
    ASSERT_EQ(run("0 material foam\n0 paint 20,32\n0 material glass\n0 paint 70,32\n" + quit_, history).code,
              0);
    EXPECT_EQ(names_in(folder_ / "state").size(), 1U);
    ASSERT_EQ(run("0 undo\n" + save() + quit_, history).code, 0);
    const auto names = parse_segment_names(saved(), "saved");
    ASSERT_TRUE(names) << names.error().message;
    ASSERT_EQ(names->segments.size(), 1U);
    EXPECT_EQ(names->segments[0].material, "foam");
    // Without one, and without a window, nothing of it is known.
    const Outcome none = run("0 undo\n" + quit_);
    EXPECT_NE(none.err.find("nothing to undo"), std::string::npos) << none.err;
}

TEST_F(BrushScript, SavesBesideTheClipAndInThePlaceOfNothingElse) {
    ASSERT_EQ(run("0 material foam\n0 paint 20,32\n0 save-materials\n" + quit_).code, 0);
    EXPECT_TRUE(fs::exists(folder_ / "wall.mkv.materials.json"));
    // It is where the next one begins, and a file that is given counts before it.
    ASSERT_EQ(run(save() + quit_).code, 0);
    EXPECT_EQ(saved(), file_contents(folder_ / "wall.mkv.materials.json"));
    std::ofstream(folder_ / "given.json") << R"({"touchable_segments": 1, "segments":
        [{"name": "left", "material": "carpet", "at": [20, 32]}]})";
    const std::vector<std::string> given{"--segments", (folder_ / "given.json").string()};
    ASSERT_EQ(run(save() + quit_, given).code, 0);
    EXPECT_NE(saved().find("carpet"), std::string::npos) << saved();
    // What is given is felt once segments are read, though no tool is in the hand.
    const Image felt = shot("0 overlay friction\n", given), own = shot("0 overlay friction\n");
    EXPECT_NE(colour(felt, left, row), colour(felt, right, row));
    EXPECT_EQ(colour(own, left, row), colour(own, right, row)) << "the file beside it is the brush's alone";
    std::ofstream(folder_ / "saved.json") << "my diary";
    const Outcome refused = run("0 material foam\n" + save() + quit_);
    EXPECT_NE(refused.err.find("not saved in its place"), std::string::npos) << refused.err;
    EXPECT_EQ(refused.code, 3);
    EXPECT_EQ(saved(), "my diary");
    const std::string good = "0 save-materials " + (folder_ / "good.json").string() + "\n";
    EXPECT_EQ(run("0 material foam\n" + save() + good + quit_).code, 0) << "what was saved last is there";
    EXPECT_EQ(run("0 material foam\n" + good + save() + quit_).code, 3);
    EXPECT_NE(run(save() + quit_, {"--record", (folder_ / "hand.touch").string()}).code, 0);
}

/// What was asked for before another clip comes is done before the clip goes, and is kept as this clip's.
TEST_F(BrushScript, AClipGoesOnceItsBrushIsDone) {
    const fs::path other = folder_ / "other.mkv";
    ASSERT_NO_FATAL_FAILURE(write_two_surfaces(other, 4));
    const std::vector<std::string> history{"--brush-history", (folder_ / "state").string()};
    const Outcome done =
        run("0 material foam\n0 drop " + other.string() + "\n0 cut 40,30 95,30\n0.2 quit\n", history);
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    ASSERT_EQ(run(save() + quit_, history).code, 0);
    const auto names = parse_segment_names(saved(), "saved");
    ASSERT_TRUE(names) << names.error().message;
    EXPECT_EQ(names->cuts.size(), 1U);
}

/// What is painted while it is not felt changes nothing that is felt: no session is begun for it.
TEST_F(BrushScript, WhatIsNotFeltBeginsNothingAnew) {
    const auto frames_after = [this](const std::string& feel) {
        std::string script = "0 material foam\n0.1 " + feel + "\n";
        for (int k = 0; k < 10; ++k)
            script += std::to_string(1 + k) + "e-1" + (k % 2 ? " undo\n" : " paint 20,32\n");
        const Outcome done = run(script + "1.5 quit\n");
        EXPECT_EQ(done.code, 0) << done.err;
        const std::size_t at = done.out.find("\nframes   ");
        return at == std::string::npos
                   ? -1
                   : std::atoi(done.out.c_str() + done.out.find_first_of("0123456789", at));
    };
    const int unfelt = frames_after("materials off"), felt = frames_after("materials on");
    EXPECT_GT(unfelt, 0);
    EXPECT_LT(unfelt + 1, felt) << "of ten changes, each felt";
}

TEST_F(BrushScript, WhatCannotBeIsSaidInALine) {
    const Outcome done = run("0 paint 20,32,9\n0 join 20,32 21,32\n0 materials off\n0 redo\n" + quit_);
    EXPECT_EQ(done.code, 0);
    for (const char* words :
         {"beyond the clip", "both places are on segment", "nothing is painted", "nothing to do again"})
        EXPECT_NE(done.err.find(words), std::string::npos) << words << " in " << done.err;
    const Outcome recorded = run("0 paint 20,32\n" + quit_, {"--record", (folder_ / "hand.touch").string()});
    EXPECT_NE(recorded.err.find("not recorded"), std::string::npos) << recorded.err;
    const Outcome camera = run_touchable({"play", "--camera", "replay:" + clip_.string(), "--headless",
                                          "--script", (folder_ / "script").string()});
    EXPECT_EQ(camera.code, 0);
    EXPECT_NE(camera.err.find("this is a camera"), std::string::npos) << camera.err;
    std::ofstream(folder_ / "bad.json") << R"({"touchable_segments": 1, "segments": [{}]})";
    const Outcome bad = run(quit_, {"--segments", (folder_ / "bad.json").string()});
    EXPECT_EQ(bad.code, 3);
    EXPECT_TRUE(bad.one_line_of_error()) << bad.err;
    const Outcome both = run(quit_, {"--segments", (folder_ / "bad.json").string(), "--record", "r.touch"});
    EXPECT_EQ(both.code, 2) << both.err;
}

TEST_F(BrushScript, TheTerminalSaysWhatIsNotSaved) {
    const std::string paint = "0 material water\n0 paint 20,32\n",
                      not_saved = "what was painted is not saved";
    const auto told = [&](const std::string& script, const std::vector<std::string>& more = {}) {
        const Outcome done = run(script + quit_, more);
        EXPECT_EQ(done.code, 0) << done.err;
        return done.out;
    };
    EXPECT_NE(told(paint).find(not_saved + ", and is lost"), std::string::npos);
    EXPECT_NE(told(paint, {"--brush-history", (folder_ / "kept").string()}).find("for the next window"),
              std::string::npos);
    EXPECT_EQ(told(paint + save()).find(not_saved), std::string::npos);
    EXPECT_EQ(told("0 tool paint\n").find(not_saved), std::string::npos);
}

TEST_F(BrushScript, SegmentsThatDoNotFitTheClipAreAnError) {
    const fs::path file = folder_ / "other.json";
    std::ofstream(file) << R"({"touchable_segments": 1, "segments": [
        {"name": "a", "material": "wood", "at": [9000, 1]}]})";
    const Outcome done = run("0 tool paint\n" + quit_, {"--segments", file.string()});
    EXPECT_EQ(done.code, 3) << done.out;
    EXPECT_NE(done.err.find("outside of the picture"), std::string::npos) << done.err;
}

}  // namespace
}  // namespace touchable::test
