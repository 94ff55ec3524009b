// A clip in MP4, or as a glTF scene, is felt as the same clip in Matroska, to the bit.
#include <gtest/gtest.h>

#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

class Mp4Touch : public ::testing::TestWithParam<int> {};

TEST_P(Mp4Touch, ForcesAreTheSameInMatroskaInMp4AndThereAndBack) {
    const TemporaryFolder folder;
    const auto at = [&](const char* name) { return std::string(folder / name); };
    const std::string hand = zigzag_hand(at("zigzag.csv"));
    const auto forces = [&](const char* name) {
        return force_hash({at(name), "--hand", hand, "--fingers", "2", "--seconds", "0.25"});
    };
    for (const char* name : {"made.mkv", "made.mp4"})
        make_clip("globe", at(name),
                  {"--size", "320x240", "--frames", "6", "--bits", std::to_string(GetParam())});
    const std::string known = forces("made.mkv");
    EXPECT_EQ(forces("made.mp4"), known);
    for (const auto& [from, to] : {std::pair{"made.mkv", "converted.mp4"},
                                   {"converted.mp4", "scene.gltf"},
                                   {"scene.gltf", "back.mkv"}}) {
        const Outcome run = run_touchable({"convert", at(from), at(to)});
        ASSERT_EQ(run.code, 0) << run.err;
        EXPECT_EQ(forces(to), known) << to;
    }
}

INSTANTIATE_TEST_SUITE_P(Bits, Mp4Touch, ::testing::Values(8, 10, 12, 16));

}  // namespace
}  // namespace touchable::test
