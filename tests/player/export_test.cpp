// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

Image image_of(const std::string& file) {
    auto image = read_image(file);
    EXPECT_TRUE(image) << file;
    return image ? *image : Image{};
}

int differing(const PlaneView& a, const PlaneView& b) {
    if (a.width != b.width || a.height != b.height || a.channels != b.channels) return a.width * a.height + 1;
    int count = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x)
            for (int c = 0; c < a.channels; ++c) count += a.sample(x, y, c) != b.sample(x, y, c);
    return count;
}

class Export : public ::testing::Test {
protected:
    void make(const std::string& scene, int frames, const std::vector<std::string>& more = {}) {
        succeed(plus(
            {"make", scene, clip(), "--overwrite", "--size", "72x48", "--frames", std::to_string(frames)},
            more));
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string out(const std::string& name = "") const { return folder / ("out/" + name); }
    RawFrame frame(int number) const {
        auto reader = open_clip(clip());
        for (int n = 0; n < number; ++n) EXPECT_TRUE((*reader)->next());
        return (*reader)->next()->value();
    }

    TemporaryFolder folder;
};

TEST_F(Export, WritesEveryPlaneExactly) {
    make("globe", 3);
    succeed({"export", clip(), "--frame", "2", "--out", out()});
    EXPECT_EQ(names_in(out()),
              (std::vector<std::string>{"codes.json", "codes.png", "colour.png", "depth.png", "errors.png",
                                        "haptic.png", "height.png", "mesh.ply", "scene.json", "valid.png"}));
    const RawFrame raw = frame(2);
    EXPECT_EQ(differing(image_of(out("depth.png")).view(), raw.depth), 0);
    EXPECT_EQ(differing(image_of(out("colour.png")).view(), raw.colour), 0);
    EXPECT_EQ(differing(image_of(out("haptic.png")).view(), raw.haptic), 0);
    EXPECT_EQ(differing(image_of(out("height.png")).view(), raw.height), 0);
    EXPECT_EQ(image_of(out("codes.png")).bytes_per_sample, 2);
}

TEST_F(Export, UnfilteredCodesAreStoredValues) {
    make("noise", 1, {"--bits", "8"});
    succeed({"export", clip(), "--frame", "0", "--out", out()});
    EXPECT_EQ(differing(image_of(out("codes.png")).view(), frame(0).depth), 0);
    EXPECT_EQ(image_of(out("depth.png")).bytes_per_sample, 1);
    const Image valid = image_of(out("valid.png"));
    for (const std::uint8_t sample : valid.samples) ASSERT_EQ(sample, 255);
    EXPECT_EQ(names_in(out()), (std::vector<std::string>{"codes.json", "codes.png", "depth.png", "errors.png",
                                                         "mesh.ply", "scene.json", "valid.png"}));
}

TEST_F(Export, WritesErrorBars) {
    succeed({"make", "globe", clip(), "--size", "192x128", "--frames", "3"});
    succeed({"export", clip(), "--frame", "2", "--out", out()});
    const auto written = must(read_scene_file(out("scene.json")));
    const RawFrame raw = frame(2);
    SurfaceFrame built;
    ASSERT_TRUE(with_error_bars(make_reference_builder(written.scene), written.scene)->build(raw, built));
    const Image errors = image_of(out("errors.png"));
    ASSERT_EQ(errors.bytes_per_sample, 2);
    int known = 0;
    for (int y = 0; y < built.height; ++y)
        for (int x = 0; x < built.width; ++x) {
            const double degrees = built.signs.bar_at(x, y).degrees;
            const int sample = errors.view().sample(x, y);
            if (!built.is_valid(x, y) || std::isnan(degrees))
                ASSERT_EQ(sample, 65535);
            else
                ASSERT_NEAR(sample, 100 * degrees, 0.51);
            known += sample != 65535;
        }
    EXPECT_GT(known, 1000);
}

// SUN RGB-D rotates the bits of its depth. What is exported are codes, and comes back as they are.
TEST_F(Export, WritesRotatedDepthAsCodes) {
    std::vector<std::uint16_t> words(72 * 48);
    for (std::size_t k = 0; k < words.size(); ++k)
        words[k] = static_cast<std::uint16_t>((800 + k % 500) << 3);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(words.data());
    ASSERT_TRUE(write_png(folder / "sun.png", PlaneView{bytes, 144, 72, 48, 2, 1}));
    succeed({"export", folder / "sun.png", "--preset", "sun", "--frame", "0", "--out", out()});
    EXPECT_EQ(image_of(out("depth.png")).view().sample(7, 0), 807);
    auto again = must(open_clip(out()));
    EXPECT_EQ(again->next()->value().depth.sample(7, 0), 807);
    EXPECT_EQ(file_contents(out("codes.json")).find("rotated"), std::string::npos);
}

TEST_F(Export, AppliesFilterOptions) {
    make("noise", 1);
    for (const char* builder : {"cpu", "reference", "vulkan"}) {
        succeed({"export", clip(), "--frame", "0", "--out", out(), "--median", "5", "--fill-holes", "2",
                 "--builder", builder, "--overwrite"});
        const auto written = must(read_scene_file(out("scene.json")));
        const Scene& scene = written.scene;
        EXPECT_EQ(scene.filter, (FilterSettings{5, 2}));
        SurfaceFrame built;
        ASSERT_TRUE(make_reference_builder(scene)->build(frame(0), built));
        const Image codes = image_of(out("codes.png"));
        int different = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 72; ++x)
                different += codes.view().sample(x, y) != built.codes[built.index(x, y)];
        EXPECT_EQ(different, 0) << builder;
        EXPECT_GT(differing(codes.view(), frame(0).depth), 1000);
    }
}

TEST_F(Export, RangeWritesFolderPerFrame) {
    make("moving", 4);
    const Outcome some = succeed({"export", clip(), "--frames", "1-2", "--out", out()});
    EXPECT_EQ(names_in(out()), (std::vector<std::string>{"1", "2"}));
    const std::size_t files = names_in(out("1")).size() + names_in(out("2")).size();
    EXPECT_EQ(some.out,
              out() + " is written: frames 1 to 2, a folder each, " + std::to_string(files) + " files\n");
    const Outcome one = run_touchable(
        {"export", clip(), "--frame", "3", "--out", folder / "one", "--picture", folder / "p.png"});
    EXPECT_EQ(one.out, (folder / "one").string() + " is written: frame 3, " +
                           std::to_string(names_in(folder / "one").size()) + " files; and " +
                           (folder / "p.png").string() + '\n');
    expect_failure({"export", clip(), "--frame", "0-3", "--out", folder / "two"}, 2,
                   "several are --frames A-B");
    EXPECT_EQ(differing(image_of(out("2/depth.png")).view(), frame(2).depth), 0);
    EXPECT_FALSE(std::filesystem::exists(out("2/mesh.ply")));
    succeed({"export", clip(), "--frames", "all", "--out", out(), "--mesh", "--overwrite"});
    EXPECT_EQ(names_in(out()), (std::vector<std::string>{"0", "1", "2", "3"}));
    EXPECT_TRUE(std::filesystem::exists(out("3/mesh.ply")));
}

TEST_F(Export, KeepsFramesBeforeFailure) {
    make("moving", 4);
    std::filesystem::create_directory(out());
    std::ofstream(out("2")) << "no folder\n";
    const Outcome run = run_touchable({"export", clip(), "--frames", "all", "--out", out()});
    EXPECT_EQ(run.code, 3);
    EXPECT_TRUE(run.err.ends_with("; frames 0 to 1 are whole in " + out() + "\n")) << run.err;
    EXPECT_EQ(names_in(out()), (Words{"0", "1", "2"}));
}

TEST_F(Export, RejectsInvalidSettings) {
    make("plane", 3);
    const std::string range = " is not allowed; must be 0 to 2; " + clip() + " has 3 frames\n";
    std::vector<std::tuple<Words, std::string>> wrong{{{"--frame", "3"}, "--frame: 3" + range},
                                                      {{"--frame", "-1"}, "--frame: -1" + range},
                                                      {{"--frames", "1-3"}, ": 3" + range},
                                                      {{"--frame", ""}, "''"}};
    for (const char* frame : {"1.5", "0x1", "first", "9223372036854775807", "99999999999999999999"})
        wrong.push_back({{"--frame", frame}, frame});
    for (const char* frames : {"", "2-1", "a-b", "1-", "-1"}) wrong.push_back({{"--frames", frames}, ""});
    for (const Words& more :
         {Words{"--median", "4"}, {"--fill-holes", "17"}, {"--fill-holes", "-1"}, {"--builder", "fast"}})
        wrong.push_back({plus({"--frame", "0"}, more), more[0]});
    for (const auto& [words, part] : wrong) {
        expect_failure(plus({"export", clip(), "--out", out()}, words), 2, part);
        EXPECT_FALSE(std::filesystem::exists(out()));
    }
}

TEST_F(Export, TerraceRemovalRefinesCodes) {
    succeed({"make", "globe", clip(), "--size", "96x64", "--frames", "1", "--bits", "8"});
    succeed({"export", clip(), "--frame", "0", "--out", out(), "--terraces", "auto"});
    const auto written = must(read_scene_file(out("scene.json")));
    const Scene& scene = written.scene;
    EXPECT_EQ(scene.filter.terraces, TerraceRemoval::on) << "what the clip's first frames decided";
    SurfaceFrame built;
    ASSERT_TRUE(make_reference_builder(scene)->build(frame(0), built));
    const Image codes = image_of(out("codes.png"));
    int finer = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 96; ++x) {
            ASSERT_EQ(codes.view().sample(x, y), built.codes[built.index(x, y)]) << x << ", " << y;
            finer += built.codes[built.index(x, y)] % 252 != 0;
        }
    EXPECT_GT(finer, 1000);
    const Words hand{"--hand", zigzag_hand(folder / "zigzag.csv")};
    EXPECT_EQ(force_hash({out(), hand[0], hand[1]}),
              force_hash({clip(), "--terraces", "on", hand[0], hand[1]}));
}

TEST_F(Export, FolderKeepsFrameForces) {
    make("globe", 1);
    succeed({"export", clip(), "--frame", "0", "--out", out(), "--median", "3"});
    const Words hand{"--hand", zigzag_hand(folder / "zigzag.csv")};
    const auto hash = [&](Words words) {
        words.insert(words.end(), hand.begin(), hand.end());
        return force_hash(words);
    };
    const std::string felt = hash({clip(), "--median", "3"});
    EXPECT_EQ(hash({out()}), felt);
    EXPECT_EQ(hash({out("scene.json")}), felt);
    EXPECT_NE(hash({clip()}), felt) << "the filter is part of it";
    succeed({"export", out(), "--frame", "0", "--out", folder / "again"});
    for (const std::string& name : names_in(out()))
        EXPECT_EQ(file_contents(folder / ("again/" + name)), file_contents(out(name))) << name;
}

/// Codes of 8 bits: a step in the middle that is the same for all `around`.
Image step_in_the_middle(std::uint8_t around) {
    Image image{72, 48, 1, 1, {}};
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 72; ++x) {
            const bool middle = x > 20 && x < 52 && y > 12 && y < 36;
            image.samples.push_back(middle ? static_cast<std::uint8_t>(100 + x / 4) : around);
        }
    return image;
}

// The clip says nothing of the device, so that its frame 0 settles how far one moves. Frame 1 alone, whose
// median depth is another, would settle something else.
TEST_F(Export, KeepsDeviceScaleOfClip) {
    make("plane", 1, {"--bits", "8"});
    auto scene = scene_of(clip());
    scene.erase("device_metres_per_unit");
    scene["interpolation"] = "hold";
    scene["rate"] = {1000, 1};  // a hand begins far above, and finds frame 1
    scene["folder"] = {{"depth", "d%d.png"}};
    std::ofstream(folder / "two.json") << scene;
    ASSERT_TRUE(write_png(folder / "d0.png", step_in_the_middle(20).view()));
    ASSERT_TRUE(write_png(folder / "d1.png", step_in_the_middle(220).view()));
    const Words hand{"--hand", "press:depth=3", "--seconds", "0.9", "--fingers", "2"};
    const auto hash = [&](const std::string& touched) {
        const auto report = touch(plus({touched}, hand));
        EXPECT_GT(report["contact_ticks"], 200);
        return report["force_hash"];
    };
    for (const Words& which : {Words{"--frame", "1"}, Words{"--frames", "1-1"}}) {
        succeed(plus({"export", folder / "two.json", "--out", out()}, which));
    }
    const auto felt = hash(folder / "two.json");
    EXPECT_EQ(hash(out()), felt);
    EXPECT_EQ(hash(out("1")), felt);
    EXPECT_EQ(file_contents(out("scene.json")), file_contents(out("1/scene.json")));
    scene["folder"] = {{"depth", "d1.png"}};
    std::ofstream(folder / "alone.json") << scene;
    EXPECT_NE(hash(folder / "alone.json"), felt) << "no test of the scale";
}

TEST_F(Export, RejectsFileAsFolder) {
    make("plane", 1);
    const std::string before = file_contents(clip());
    for (const std::string& place : {clip(), clip() + "/deeper"}) {
        expect_failure({"export", clip(), "--frame", "0", "--out", place}, 3);
    }
    EXPECT_EQ(file_contents(clip()), before);
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"clip.mkv"});
}

TEST_F(Export, FailsForReadOnlyFolder) {
    if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
    make("plane", 1);
    std::filesystem::create_directory(out());
    ASSERT_EQ(chmod(out().c_str(), 0500), 0);
    EXPECT_EQ(run_touchable({"export", clip(), "--frame", "0", "--out", out()}).code, 3);
    EXPECT_TRUE(names_in(out()).empty());
}

TEST_F(Export, OverwriteRemovesEarlierPlanes) {
    make("globe", 1);
    succeed({"export", clip(), "--frame", "0", "--out", out()});
    make("noise", 1);
    succeed({"export", clip(), "--frame", "0", "--out", out(), "--overwrite"});
    EXPECT_FALSE(std::filesystem::exists(out("haptic.png")));
    EXPECT_TRUE(std::filesystem::exists(out("depth.png")));
}

// A clip that ffmpeg made alone, by the command that docs/formats.md gives.

namespace fs = std::filesystem;

/// The page's only block of shell commands.
std::string command_of_the_page() {
    const std::string page = file_contents(fs::path(TOUCHABLE_SOURCE_DIR) / "docs/formats.md");
    const std::string fence = "```sh\n";
    const auto begin = page.find(fence);
    EXPECT_NE(begin, std::string::npos);
    const auto from = begin + fence.size();
    return page.substr(from, page.find("\n```", from) - from);
}

TEST(FfmpegClip, DocumentedCommandKeepsEveryValue) {
    if (std::system("command -v ffmpeg >/dev/null") != 0)
        GTEST_SKIP() << "there is no program ffmpeg here (Debian: ffmpeg)";
    const TemporaryFolder folder;
    const fs::path pictures = folder / "pictures";
    make_clip("globe", folder / "globe.mkv", {"--size", "64x48", "--frames", "7", "--bits", "16"});
    succeed({"convert", folder / "globe.mkv", pictures});
    // One map for the whole video, as the page has it.
    fs::rename(pictures / "haptic_000003.png", pictures / "haptic.png");
    const std::string run = "cd '" + pictures.string() + "' && " + command_of_the_page();
    ASSERT_EQ(std::system((run + " >ffmpeg.log 2>&1").c_str()), 0) << file_contents(pictures / "ffmpeg.log");

    const auto made = must(open_clip(pictures / "clip.mkv")), before = must(open_clip(folder / "globe.mkv"));
    EXPECT_EQ(made->frame_count(), 7);
    const auto map = must(read_image(pictures / "haptic.png"));
    for (int n = 0; n < 7; ++n) {
        const auto is = must(made->next()), was = must(before->next());
        ASSERT_TRUE(is && was);
        EXPECT_EQ(is->time_ns, was->time_ns);
        EXPECT_TRUE(same_samples(is->depth, was->depth)) << n;
        EXPECT_TRUE(same_samples(is->haptic, map.view())) << n;
        EXPECT_FALSE(is->colour.empty());
    }
    EXPECT_FALSE(made->next()->has_value());
}

// Every option and word that names a file to read, given what is none: told at once, in a line.

class InputFiles : public ::testing::Test {
protected:
    InputFiles() { make_clip("plane", clip, {"--size", "48x32", "--frames", "3"}); }

    /// Paths that stand for a file whose name ends so.
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
            EXPECT_PRED2(says, run.err, file);
            EXPECT_EQ(run.err.find("memory does not suffice"), std::string::npos) << run.err;
            EXPECT_EQ(run.err.find("internal fault"), std::string::npos) << run.err;
        }
    }

    TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv", out = folder / "out";
};

TEST_F(InputFiles, RejectSpecialFilesAsClip) {
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

TEST_F(InputFiles, RejectSpecialFilesAsHand) {
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

TEST_F(InputFiles, RejectSpecialFilesAsForces) {
    alarm(600);
    const std::string forces = folder / "forces.csv";
    succeed({"touch", clip, "--seconds", "0.1", "--forces", forces});
    expect_told(".csv", {"compare", "@", forces});
    expect_told(".csv", {"compare", forces, "@"});
    expect_told(".csv", {"plot", "@", out + ".png"});
    expect_told("", {"plot", forces, out + ".png", "--over", "@"});
    alarm(0);
}

}  // namespace
}  // namespace touchable::test
