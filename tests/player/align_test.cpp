// Depth that a network guessed picture by picture, as somebody has it on disk, under a finger at rest.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "engine/base/same_bits.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "tests/alignment/pumping_clip.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

/// A wall, in pictures to which a network gave a scale each.
class PumpingFolder : public ::testing::Test {
protected:
    PumpingFolder() {
        std::filesystem::create_directory(pictures());
        for (int n = 0; n < 24; ++n) {
            Numbers numbers(static_cast<std::uint64_t>(n) + 5);
            const double scale = 0.9 + 0.01 * numbers.below(40), shift = 0.001 * numbers.below(60);
            const RawFrame frame = guessed_frame({}, {scale, shift}, 2, true, n);
            write("depth_", n, frame.depth);
            write("rgb_", n, frame.colour);
        }
    }
    std::filesystem::path pictures() const { return folder_ / "guessed"; }
    void write(const char* name, int number, const PlaneView& plane) const {
        std::array<char, 32> file{};
        std::snprintf(file.data(), file.size(), "%s%03d.png", name, number);
        EXPECT_TRUE(write_png(pictures() / file.data(), plane));
    }
    /// How much the force changes from frame to frame, RMS, N: 1 s after the finger came to rest.
    double pulse(const std::string& align) const {
        const std::string csv = folder_ / "forces.csv";
        touch({pictures(), "--preset", "relative-inverse", "--align", align, "--filters", "off", "--loop",
               "0", "0.7", "--hand", "press:x=0.3,y=0.6,depth=30,lift=0,period=60", "--seconds", "10",
               "--forces", csv});
        const auto rows = read_forces(csv);
        double sum = 0;
        int count = 0;
        for (std::size_t tick = 8033; tick < rows.size(); tick += 33, ++count) {
            const double changed =
                length(rows[tick].vector("force")) - length(rows[tick - 33].vector("force"));
            sum += changed * changed;
        }
        return std::sqrt(sum / count);
    }

    TemporaryFolder folder_;
};

TEST_F(PumpingFolder, PulsesTwentyTimesLessUnderAFingerAtRest) {
    const double before = pulse("off"), after = pulse("auto");
    std::cout << "a finger at rest: pulse " << before << " N from frame to frame, aligned " << after
              << " N\n";
    EXPECT_GT(before, 0.05);
    EXPECT_GE(before, 20 * after);
}

TEST_F(PumpingFolder, SaysWhatIsDoneAndReplaysAsItWas) {
    const std::vector<std::string> info{"info", pictures(), "--preset", "relative-inverse"};
    const Outcome told = run_touchable(info);
    EXPECT_NE(told.out.find("depth is aligned, as each frame had a scale of its own"), std::string::npos)
        << told.out;
    std::vector<std::string> off = info;
    off.insert(off.end(), {"--align", "off"});
    EXPECT_EQ(run_touchable(off).out.find("depth is aligned"), std::string::npos);
    for (const std::string align : {"off", "auto", "on"}) {
        const std::string recording = folder_ / ("run-" + align + ".touch");
        const Outcome touched = run_touchable({"touch", pictures(), "--preset", "relative-inverse", "--align",
                                               align, "--seconds", "0.5", "--record", recording});
        ASSERT_EQ(touched.code, 0) << touched.err;
        EXPECT_EQ(run_touchable({"touch", "--replay", recording}).code, 0) << align;
        EXPECT_EQ(run_touchable({"touch", "--replay", recording, "--align", "off"}).code, 2);
    }
}

/// Once it is a clip nothing has to be aligned any more; a clip that was made before can be.
TEST_F(PumpingFolder, IsConvertedOnceAndTouchedAsItWas) {
    const std::string clip = folder_ / "aligned.mkv", raw = folder_ / "raw.mkv";
    for (const auto& [file, align] : {std::pair{clip, "auto"}, {raw, "off"}})
        ASSERT_EQ(
            run_touchable({"convert", pictures(), file, "--preset", "relative-inverse", "--align", align})
                .code,
            0);
    const std::string direct = force_hash({pictures(), "--preset", "relative-inverse", "--seconds", "0.5"});
    EXPECT_EQ(force_hash({clip, "--seconds", "0.5"}), direct);
    EXPECT_NE(force_hash({raw, "--seconds", "0.5"}), direct);
    // (Lossy colour tells a little else of what stands still.)
    const Outcome later = run_touchable({"info", raw, "--align", "on"});
    EXPECT_NE(later.out.find("depth is aligned"), std::string::npos) << later.out << later.err;
    EXPECT_EQ(run_touchable({"info", raw}).out.find("depth is aligned"), std::string::npos);
}

/// What writes a clip anew copies the packets of what stays as it is, and aligned depth does not.
TEST_F(PumpingFolder, OfAClipOfOursIsAlignedByWhateverWritesItAnew) {
    const std::string raw = folder_ / "raw.mkv";
    ASSERT_EQ(
        run_touchable({"convert", pictures(), raw, "--preset", "relative-inverse", "--align", "off"}).code,
        0);
    const auto hash_of_depth = [&](const std::string& file, DepthAlignment alignment) {
        auto clip = open_clip(file, {}, {}, Colour::wanted, alignment);
        EXPECT_TRUE(clip) << file;
        ByteHash hash;
        while (clip) {
            const auto frame = (*clip)->next();
            if (!frame || !*frame) break;
            const PlaneView& depth = (*frame)->depth;
            for (int y = 0; y < depth.height; ++y) hash.add(depth.row(y), std::size_t{2} * depth.width);
        }
        return hash.value();
    };
    const std::uint64_t stored = hash_of_depth(raw, DepthAlignment::off);
    const std::uint64_t aligned = hash_of_depth(raw, DepthAlignment::on);
    EXPECT_NE(stored, aligned);
    for (const std::string command : {"convert", "relief", "materials"}) {
        const std::string as_stored = folder_ / (command + "-auto.mkv"), on = folder_ / (command + "-on.mkv");
        ASSERT_EQ(run_touchable({command, raw, as_stored}).code, 0) << command;
        EXPECT_EQ(hash_of_depth(as_stored, DepthAlignment::off), stored) << command;
        const Outcome run = run_touchable({command, raw, on, "--align", "on"});
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(hash_of_depth(on, DepthAlignment::off), aligned) << command;
    }
}

}  // namespace
}  // namespace touchable::test
