// Every option and word that names a file to read, given what is none: told at once, in a line.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/sanitizers.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

using Words = std::vector<std::string>;

class GivenFiles : public ::testing::Test {
protected:
    GivenFiles() { make_clip("plane", clip, {"--size", "48x32", "--frames", "3"}); }

    /// What stands for a file whose name ends so.
    Words stand_ins(const std::string& ending) const {
        const fs::path pipe = folder / ("pipe" + ending), device = folder / ("zero" + ending),
                       endless = folder / ("large" + ending), files = folder / ("folder" + ending);
        if (!fs::exists(pipe)) {
            EXPECT_EQ(mkfifo(pipe.c_str(), 0600), 0);
            fs::create_symlink("/dev/zero", device);
            std::ofstream(endless, std::ios::binary).put('\0');
            fs::resize_file(endless, std::uintmax_t{8} << 30U);
            fs::create_directory(files);
        }
        return {pipe, device, endless, files};
    }

    /// `@` in `words` stands for the file.
    void expect_told(const std::string& ending, Words words) const {
        for (const std::string& file : stand_ins(ending)) {
            Words given = words;
            for (std::string& word : given)
                if (const auto at = word.find('@'); at != std::string::npos) word.replace(at, 1, file);
#ifdef TOUCHABLE_SANITIZED
            const Outcome run = run_touchable(given);  // sanitizers map terabytes of their own
#else
            const Outcome run = run_in_memory(given, 1024);
#endif
            std::string all;
            for (const std::string& word : given) all += word + ' ';
            SCOPED_TRACE(all);
            EXPECT_GT(run.code, 0);
            EXPECT_TRUE(run.one_line_of_error()) << run.err;
            EXPECT_NE(run.err.find(file), std::string::npos) << run.err;
            EXPECT_EQ(run.err.find("memory does not suffice"), std::string::npos) << run.err;
            EXPECT_EQ(run.err.find("internal fault"), std::string::npos) << run.err;
        }
    }

    TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv", out = folder / "out";
};

TEST_F(GivenFiles, OfWhichAClipIsMade) {
    alarm(600);  // who opens a pipe waits for a writer
    expect_told("", {"info", "@"});
    expect_told(".mkv", {"info", "@"});
    expect_told(".json", {"touch", "@", "--seconds", "0.1"});
    expect_told(".png", {"init-scene", "@", "--out", out});
    expect_told(".mp4", {"convert", "@", out + ".mkv"});
    expect_told(".bag", {"export", "@", "--frame", "0", "--out", out});
    expect_told(".json", {"info", clip, "--scene", "@"});
    expect_told(".json", {"info", clip, "--intrinsics", "@"});
    expect_told(".png", {"info", clip, "--haptic", "@"});
    expect_told(".x3d", {"info", clip, "--haptic", "@"});
    expect_told(".gltf", {"info", clip, "--haptic", "@"});
    expect_told(".glb", {"info", clip, "--haptic", "@"});
    expect_told(".png", {"info", clip, "--height", "@"});
    expect_told(".mkv", {"touch", "--live", "--camera", "replay:@", "--seconds", "0.1"});
    alarm(0);
}

TEST_F(GivenFiles, ThatLeadARun) {
    alarm(600);
    expect_told("", {"touch", clip, "--play", "@", "--seconds", "0.1"});
    expect_told(".csv", {"touch", clip, "--hand", "csv:@:columns=z", "--seconds", "0.1"});
    expect_told(".rec", {"touch", clip, "--hand", "rec:@", "--seconds", "0.1"});
    expect_told(".rec", {"touch", "--replay", "@"});
    expect_told(".csv", {"touch", clip, "--live", "--device", "recorded:@", "--seconds", "0.1"});
    expect_told(".bin", {"touch", clip, "--live", "--device", "falcon:firmware=@", "--seconds", "0.1"});
    expect_told(".json", {"touch", clip, "--live", "--device", "woodenhaptics:file=@", "--seconds", "0.1"});
    expect_told("", {"touch", clip, "--live", "--device", "network:port=0", "--world-from-camera", "@",
                     "--seconds", "0.1"});
    expect_told("", {"play", clip, "--headless", "--script", "@"});
    alarm(0);
}

TEST_F(GivenFiles, OfWhichARunIsJudged) {
    alarm(600);
    const std::string forces = folder / "forces.csv";
    ASSERT_EQ(run_touchable({"touch", clip, "--seconds", "0.1", "--forces", forces}).code, 0);
    expect_told(".csv", {"compare", "@", forces});
    expect_told(".csv", {"compare", forces, "@"});
    expect_told(".csv", {"plot", "@", out + ".png"});
    expect_told("", {"plot", forces, out + ".png", "--over", "@"});
    alarm(0);
}

}  // namespace
}  // namespace touchable::test
