// `touchable plot`.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

class Plot : public ::testing::Test {
protected:
    void SetUp() override {
        if (std::system("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null") != 0)
            GTEST_SKIP() << "needs Python with matplotlib (Debian: python3-matplotlib)";
        ASSERT_EQ(run_touchable({"make", "globe", clip(), "--size", "72x48", "--frames", "6"}).code, 0);
        ASSERT_EQ(
            run_touchable({"touch", clip(), "--fingers", "3", "--seconds", "0.3", "--forces", forces()}).code,
            0);
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string forces() const { return folder / "forces.csv"; }
    std::string picture() const { return folder / "plot.png"; }
    /// Nothing was drawn, and one line says why.
    void expect_refused(const std::vector<std::string>& words, int code, const std::string& why) const {
        const auto before = names_in(folder.path());
        const Outcome outcome = run_touchable(words);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
        EXPECT_EQ(names_in(folder.path()), before);
    }

    TemporaryFolder folder;
};

TEST_F(Plot, DrawsForcesAndWays) {
    ASSERT_EQ(run_touchable({"plot", forces(), picture()}).code, 0);
    const auto over_time = read_image(picture());
    ASSERT_TRUE(over_time);
    EXPECT_GT(over_time->width, 800);
    ASSERT_EQ(run_touchable({"export", clip(), "--frame", "2", "--out", folder / "frame"}).code, 0);
    const Outcome again =
        run_touchable({"plot", forces(), picture(), "--over", folder / "frame", "--overwrite"});
    ASSERT_EQ(again.code, 0) << again.err;
    const auto over_depth = read_image(picture());
    ASSERT_TRUE(over_depth);
    EXPECT_NE(over_depth->samples, over_time->samples);
}

/// As a window records them: five fingers, of which one was led.
TEST_F(Plot, LeavesOutFingersThatNobodyLed) {
    const auto write = [&](const std::string& file, int fingers) {
        std::ofstream out(folder / file);
        out << "tick,time_s,finger,goal_x,goal_y,goal_z,force_x,force_y,force_z,contact,pixel_x,pixel_y,"
               "guard\n";
        for (int tick = 0; tick < 20; ++tick)
            for (int finger = 0; finger < fingers; ++finger) {
                out << tick << ',' << 0.001 * tick << ',' << finger << ',' << (finger == 0 ? tick : 0)
                    << ",0,0,0," << (finger == 0 ? 0.1 * tick : 0) << ",0,"
                    << (finger == 0 && tick > 9 ? 1 : 0) << ",3,4,0\n";
            }
    };
    write("one.csv", 1);
    write("five.csv", 5);
    ASSERT_EQ(run_touchable({"plot", folder / "one.csv", folder / "one.png"}).code, 0);
    ASSERT_EQ(run_touchable({"plot", folder / "five.csv", folder / "five.png"}).code, 0);
    const auto one = read_image(folder / "one.png"), five = read_image(folder / "five.png");
    ASSERT_TRUE(one && five);
    EXPECT_EQ(one->samples, five->samples);
}

TEST_F(Plot, KeepsWhatIsThere) {
    std::ofstream(picture()) << "mine";
    expect_refused({"plot", forces(), picture()}, 2, "--overwrite");
    EXPECT_EQ(file_contents(picture()), "mine");
    expect_refused({"plot", forces(), forces(), "--overwrite"}, 2, ".png");
}

TEST_F(Plot, SaysWhatIsWrongWithItsInputOnOneLine) {
    expect_refused({"plot", folder / "none.csv", picture()}, 3, "none.csv");
    expect_refused({"plot", clip(), picture()}, 3, "clip.mkv: holds bytes that are no text");
    std::ofstream(folder / "half.csv") << file_contents(forces()).substr(0, 700);
    expect_refused({"plot", folder / "half.csv", picture()}, 3, "half.csv: line");
    expect_refused({"plot", forces(), picture(), "--over", folder / "nothing"}, 3, "scene.json");
}

}  // namespace
}  // namespace touchable::test
