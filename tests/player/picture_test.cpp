#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "engine/gpu/gpu_device.hpp"
#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

/// `touch --picture` and `export --picture` over a small globe.
class Picture : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(run_touchable({"make", "globe", clip(), "--size", "72x48", "--frames", "6"}).code, 0);
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string file() const { return folder / "scene.png"; }
    Outcome touch(const std::vector<std::string>& more) const {
        std::vector<std::string> words{"touch", clip(),      "--seconds", "0.5",        "--fingers",
                                       "3",     "--picture", file(),      "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        return run_touchable(words);
    }
    Outcome draw(const std::vector<std::string>& more) const {
        std::vector<std::string> words{"export", clip(), "--frame", "3", "--picture", file(), "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        return run_touchable(words);
    }
    Image image() const {
        auto read = read_image(file());
        EXPECT_TRUE(read);
        return read ? *read : Image{};
    }
    /// Nothing was drawn, and one line says why.
    void expect_refused(const Outcome& outcome, int code, const std::string& why) const {
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
        EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"clip.mkv"});
    }

    TemporaryFolder folder;
};

TEST_F(Picture, IsDrawnOfTheSizeAskedFor) {
    const Outcome done = touch({"--picture-size", "96x54", "--verbose"});
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(image().width, 96);
    EXPECT_EQ(image().height, 54);
    EXPECT_NE(done.out.find("picture: " + file()), std::string::npos) << done.out;
}

TEST_F(Picture, IsTheSameFromRunToRunAndWhenReplayed) {
    ASSERT_EQ(touch({"--picture-size", "96x54", "--record", folder / "run.rec"}).code, 0);
    const std::string first = file_contents(file());
    ASSERT_EQ(touch({"--picture-size", "96x54"}).code, 0);
    EXPECT_EQ(file_contents(file()), first);
    ASSERT_EQ(run_touchable({"touch", "--replay", folder / "run.rec", "--picture", file(), "--picture-size",
                             "96x54", "--overwrite"})
                  .code,
              0);
    EXPECT_EQ(file_contents(file()), first);
}

TEST_F(Picture, IsTheSameByCpuAndCompute) {
    ASSERT_EQ(draw({"--painter", "cpu", "--picture-size", "96x54"}).code, 0);
    const Image cpu = image();
    for (const char* painter : {"raster", "mesh"}) {
        ASSERT_EQ(draw({"--painter", painter, "--picture-size", "96x54"}).code, 0);
        const Image other = image();
        int far_off = 0;
        for (std::size_t k = 0; k < cpu.samples.size(); ++k)
            far_off += std::abs(int{cpu.samples[k]} - int{other.samples[k]}) > 4;
        EXPECT_LE(far_off, 96 * 54 * 3 / 500) << painter;
    }
}

TEST_F(Picture, IsTheSameOfFramesThatAreOnTheGpuAlready) {
    const std::vector<std::string> uploaded{"--painter", "raster"};
    const std::vector<std::string> there{"--painter", "raster", "--builder", "vulkan"};
    ASSERT_EQ(touch(uploaded).code, 0);
    const std::string touched = file_contents(file());
    ASSERT_EQ(touch(there).code, 0);
    EXPECT_EQ(file_contents(file()), touched);
    ASSERT_EQ(draw(uploaded).code, 0);
    const std::string drawn = file_contents(file());
    ASSERT_EQ(draw(there).code, 0);
    EXPECT_EQ(file_contents(file()), drawn);
}

TEST_F(Picture, IsDrawnOnTheGpuAskedFor) {
    const Outcome done = touch({"--painter", "raster", "--gpu", "0", "--verbose"});
    EXPECT_EQ(done.code, 0) << done.err;
    const auto gpus = list_gpus();
    ASSERT_TRUE(gpus);
    EXPECT_NE(done.out.find("by the raster painter on " + gpus->at(0).name), std::string::npos) << done.out;
    const auto report =
        test::touch({clip(), "--seconds", "0.5", "--picture", file(), "--painter", "raster", "--gpu", "0"});
    EXPECT_EQ(report["painter"], "raster");
    EXPECT_EQ(report["painter_device_name"], gpus->at(0).name);
    EXPECT_EQ(report["device_name"], report["cpu_name"]);
    EXPECT_EQ(touch({"--painter", "cpu", "--builder", "cpu", "--gpu", "0"}).code, 2);  // for what?
    fs::remove(file());
    for (const char* painter : {"auto", "raster", "mesh"})
        expect_refused(touch({"--painter", painter, "--gpu", "no such device"}), 4, "no such device");
}

TEST_F(Picture, ShowsTheMomentAskedFor) {
    ASSERT_EQ(touch({"--picture-at", "0.3"}).code, 0);
    const std::string usual_moment = file_contents(file());  // 60 % of half a second
    ASSERT_EQ(touch({}).code, 0);
    EXPECT_EQ(file_contents(file()), usual_moment);
    ASSERT_EQ(touch({"--picture-at", "0.45"}).code, 0);
    EXPECT_NE(file_contents(file()), usual_moment);
}

TEST_F(Picture, ShowsTheViewAskedFor) {
    ASSERT_EQ(draw({}).code, 0);
    const std::string usual = file_contents(file());
    ASSERT_EQ(draw({"--view", "own"}).code, 0);
    EXPECT_NE(file_contents(file()), usual);
}

TEST_F(Picture, ShowsWhatTheSurfaceIsMadeOf) {
    std::set<std::string> pictures;
    for (const char* what : {"colour", "depth", "stiffness", "friction", "dynamic-friction", "height",
                             "normals", "tiles", "validity"}) {
        ASSERT_EQ(draw({"--show", what, "--painter", "cpu", "--picture-size", "96x54"}).code, 0) << what;
        EXPECT_TRUE(pictures.insert(file_contents(file())).second) << what << " looks like another";
    }
    ASSERT_EQ(draw({"--painter", "cpu", "--picture-size", "96x54"}).code, 0);
    EXPECT_TRUE(pictures.contains(file_contents(file()))) << "colour, where nobody says";
    EXPECT_EQ(touch({"--show", "depth"}).code, 0);
}

TEST_F(Picture, OfAFrameNeedsNoFolder) {
    ASSERT_EQ(draw({}).code, 0);
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"clip.mkv", "scene.png"}));
    ASSERT_EQ(draw({"--out", folder / "out"}).code, 0);
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"clip.mkv", "out", "scene.png"}));
}

TEST_F(Picture, OfManyFramesIsRefused) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"export", clip(), "--frames", "0-2", "--picture", file()},
          std::vector<std::string>{"export", clip(), "--picture", file()}})
        expect_refused(run_touchable(words), 2, "right would be --frame N");
    expect_refused(run_touchable({"export", clip(), "--frame", "0"}), 2, "--out FOLDER, or --picture FILE");
}

TEST_F(Picture, RefusesWhatItCannotDrawBeforeTheRun) {
    expect_refused(touch({"--view", "above"}), 2,
                   "--view 'above' is not allowed; must be own, or orbit such");
    expect_refused(touch({"--view", "orbit:az=1,el=2,az=3"}), 2, "az is given twice");
    expect_refused(touch({"--view", "orbit:zoom=99"}), 2, "zoom must be a number from 0.1 to 20");
    for (const char* size : {"10", "0x10", "10x", "10x9000", "1e2x10", "-5x5"})
        expect_refused(touch({"--picture-size", size}), 2, std::string("--picture-size: ") + size);
    expect_refused(run_touchable({"touch", clip(), "--seconds", "0.1", "--picture", folder / "no/where.png"}),
                   3, "--picture");
    const TemporaryFolder elsewhere;
    fs::create_directory(elsewhere / "folder.png");
    expect_refused(
        run_touchable({"touch", clip(), "--seconds", "0.1", "--picture", elsewhere / "folder.png"}), 3,
        "--picture");
    EXPECT_EQ(touch({"--painter", "oils"}).code, 2);
    EXPECT_EQ(run_touchable({"touch", clip(), "--view", "own"}).code, 2);  // of what?
    EXPECT_EQ(run_touchable({"touch", clip(), "--show", "depth"}).code, 2);
    expect_refused(
        touch({"--show", "smell"}), 2,
        "unknown overlay 'smell'; must be one of colour, depth, depth-linear, stiffness, friction,");
    EXPECT_EQ(run_touchable({"touch", clip(), "--picture-at", "1"}).code, 2);
}

TEST_F(Picture, RefusesAMomentAfterTheEnd) {
    expect_refused(touch({"--picture-at", "0.5"}), 2, "beyond the run's end");
}

}  // namespace
}  // namespace touchable::test
