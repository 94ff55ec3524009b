#include "player/session/touch_setup.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/content/scenes.hpp"
#include "tests/player/touched.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

bool no_gpu() {
    return false;
}
bool a_gpu() {
    return true;
}
/// Nobody is to open a device for this.
bool never_asked() {
    ADD_FAILURE() << "a GPU was asked for";
    return false;
}

BuilderChoice::Load load_of(int width, int height, int median, int fingers) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    options.bits = 16;
    BuilderChoice::Load load;
    auto source = make_scene("moving", options);
    EXPECT_TRUE(source);
    load.scene = (*source)->scene();
    load.scene.filter.median = median;
    load.fingers = fingers;
    return load;
}
BuilderChoice::Load full_hd(int median, int fingers) {
    return load_of(1920, 1080, median, fingers);
}

TEST(BuilderPick, FewFingersOnLargeFramesAreLazy) {
    for (const int median : {0, 3, 5})
        for (const int fingers : {1, 5})
            EXPECT_EQ(pick_builder(full_hd(median, fingers), never_asked).name, "lazy") << median;
}

TEST(BuilderPick, ManyFingersWantWholeFrames) {
    for (const int median : {3, 5}) {
        EXPECT_EQ(pick_builder(full_hd(median, 100), never_asked).name, "cpu") << median;
        int fingers = 1;
        while (pick_builder(full_hd(median, fingers), never_asked).name == "lazy") ++fingers;
        const BuilderChoice::Load first = full_hd(median, fingers), last = full_hd(median, fingers - 1);
        EXPECT_LT(whole_frames_ms_per_second(first) - lazy_ms_per_second(first), 10);
        EXPECT_GE(whole_frames_ms_per_second(last) - lazy_ms_per_second(last), 10);
    }
}

TEST(BuilderPick, TheFasterFramesComeTheMoreFingersAreLazy) {
    BuilderChoice::Load load = full_hd(5, 30);
    EXPECT_EQ(pick_builder(load, never_asked).name, "cpu");
    load.scene.rate = {120, 1};
    EXPECT_EQ(pick_builder(load, never_asked).name, "lazy");
}

TEST(BuilderPick, SmallFramesAreNotWorthTheirTicks) {
    for (const int median : {0, 3, 5})
        EXPECT_EQ(pick_builder(load_of(320, 240, median, 1), never_asked).name, "cpu") << median;
}

TEST(BuilderPick, ALiveTickDoesNotFilter) {
    BuilderChoice::Load load = full_hd(5, 1);
    load.live = true;
    EXPECT_EQ(pick_builder(load, never_asked).name, "cpu");
}

TEST(BuilderPick, FiltersThatReachFarWantWholeFrames) {
    BuilderChoice::Load filled = full_hd(3, 1), without_terraces = filled, averaged = filled;
    filled.scene.filter.fill_holes = 1;
    without_terraces.scene.depth_bits = 8;
    without_terraces.scene.depth.code_max = 255;
    derive_valid_range(without_terraces.scene.depth);
    EXPECT_EQ(pick_builder(without_terraces, never_asked).name, "lazy");
    without_terraces.scene.filter.terraces = TerraceRemoval::on;
    averaged.scene.filter.temporal = true;
    for (const BuilderChoice::Load* load : {&filled, &without_terraces, &averaged})
        EXPECT_EQ(pick_builder(*load, never_asked).name, "cpu");
}

TEST(BuilderPick, AStillIsBuiltOnce) {
    BuilderChoice::Load load = full_hd(5, 1);
    load.moves = false;
    EXPECT_EQ(pick_builder(load, never_asked).name, "cpu");
}

TEST(BuilderPick, AGpuIsAskedForWhereFramesCostAFifthOfACore) {
    BuilderChoice::Load load = load_of(3840, 2160, 5, 1);
    load.live = true;
    load.scene.rate = {30, 1};
    EXPECT_EQ(pick_builder(load, never_asked).name, "cpu");
    load.scene.rate = {60, 1};
    EXPECT_EQ(pick_builder(load, a_gpu).name, "vulkan");
    EXPECT_EQ(pick_builder(load, no_gpu).name, "cpu");
    load.live = false;
    EXPECT_EQ(pick_builder(load, never_asked).name, "lazy");
}

TEST(BuilderPick, AGpuThatDrawsIsAskedSooner) {
    BuilderChoice::Load load = full_hd(3, 1);
    load.live = true;
    load.scene.rate = {30, 1};
    EXPECT_EQ(pick_builder(load, never_asked).name, "cpu");
    load.drawn = true;
    EXPECT_EQ(pick_builder(load, a_gpu).name, "vulkan");
    EXPECT_EQ(pick_builder(load, no_gpu).name, "cpu");
    load.moves = false;
    EXPECT_EQ(pick_builder(load, never_asked).name, "cpu");
}

TEST(BuilderPick, AGpuIsFastThatWasMeasuredToBe) {
    GpuFacts facts;
    facts.kind = GpuKind::discrete;
    EXPECT_TRUE(is_fast_builder(facts)) << "not measured";
    facts.measured = {.cpu_ms = 1, .vulkan_ms = 2, .over_bus_ms = -1};
    EXPECT_TRUE(is_fast_builder(facts));
    facts.measured.vulkan_ms = 2.1;
    EXPECT_FALSE(is_fast_builder(facts));
    facts.measured.over_bus_ms = 1.5;
    EXPECT_TRUE(is_fast_builder(facts));
    facts.measured.over_bus_ms = facts.measured.vulkan_ms = HUGE_VAL;
    EXPECT_FALSE(is_fast_builder(facts)) << "wrong bits";
    facts.measured = {.cpu_ms = 1, .vulkan_ms = 0.1, .over_bus_ms = -1};
    facts.kind = GpuKind::software;
    EXPECT_FALSE(is_fast_builder(facts));
}

TEST(BuilderPick, CostsGrowWithWhatThereIsToDo) {
    EXPECT_GT(whole_frames_ms_per_second(full_hd(5, 1)), whole_frames_ms_per_second(full_hd(3, 1)));
    EXPECT_GT(whole_frames_ms_per_second(full_hd(3, 1)), whole_frames_ms_per_second(load_of(720, 480, 3, 1)));
    EXPECT_DOUBLE_EQ(lazy_ms_per_second(full_hd(3, 6)), 6 * lazy_ms_per_second(full_hd(3, 1)));
    EXPECT_GT(lazy_ms_per_second(full_hd(5, 1)), lazy_ms_per_second(full_hd(3, 1)));
}

TEST(BuilderPick, SaysWhatItTookAndWhyAndChangesNoForce) {
    const TemporaryFolder folder;
    make_clip("moving", folder / "clip.mkv", {"--size", "1280x720", "--frames", "2"});
    const auto run = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {folder / "clip.mkv", "--seconds", "0.1", "--median", "5"});
        return touch(words);
    };
    const auto by_choice = run({}), cpu = run({"--builder", "cpu"});
    EXPECT_EQ(by_choice["builder"], "lazy");
    EXPECT_NE(by_choice["builder_why"].get<std::string>().find("of CPU time a second"), std::string::npos);
    EXPECT_EQ(cpu["builder_why"], "");
    EXPECT_EQ(by_choice["force_hash"], cpu["force_hash"]);
}

}  // namespace
}  // namespace touchable::test
