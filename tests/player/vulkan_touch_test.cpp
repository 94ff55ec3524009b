#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>

#include "engine/gpu/gpu_device.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"

// touch with --builder vulkan: the forces of the other builders, and what it says where it cannot.
namespace touchable::test {
namespace {
namespace fs = std::filesystem;

using Words = std::vector<std::string>;

/// The environment of a machine without a Vulkan driver, while it lives.
class WithoutDriver {
public:
    WithoutDriver() {
        for (const char* name : names) setenv(name, "/nonexistent/driver.json", 1);
    }
    ~WithoutDriver() {
        for (const char* name : names) unsetenv(name);
    }

private:
    static constexpr const char* names[] = {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"};
};

/// The forces of the CPU and the lazy builder, to the bit, and nothing said by the validation layer.
void expect_the_same_forces(Words words) {
    words.insert(words.end(), {"--fingers", "3", "--seconds", "0.5"});
    const auto with = [&](const Words& more) {
        Words all = words;
        all.insert(all.end(), more.begin(), more.end());
        return force_hash(all);
    };
    for (const char* median : {"0", "3", "5"}) {
        const std::string cpu = with({"--median", median, "--builder", "cpu"});
        EXPECT_EQ(with({"--median", median, "--builder", "lazy"}), cpu) << median;
        EXPECT_EQ(with({"--median", median, "--builder", "vulkan"}), cpu) << median;
    }
    const std::string cpu = with({"--median", "3", "--fill-holes", "2", "--builder", "cpu"});
    EXPECT_EQ(with({"--median", "3", "--fill-holes", "2", "--builder", "vulkan"}), cpu);
}

std::string test_name(const ::testing::TestParamInfo<const char*>& test) {
    std::string name = fs::path(test.param).stem();
    std::erase_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; });
    return name;
}

class VulkanTouchGenerated : public ::testing::TestWithParam<const char*> {};

TEST_P(VulkanTouchGenerated, HasTheForcesOfTheOtherBuilders) {
    const TemporaryFolder folder;
    make_clip(GetParam(), folder / "clip.mkv", {"--size", "150x90", "--frames", "9"});
    expect_the_same_forces({folder / "clip.mkv"});
}

INSTANTIATE_TEST_SUITE_P(, VulkanTouchGenerated,
                         ::testing::Values("globe", "bumps", "moving", "noise", "spheres", "cliffs"),
                         test_name);

class VulkanTouchStandIn : public ::testing::TestWithParam<const char*> {};

TEST_P(VulkanTouchStandIn, HasTheForcesOfTheOtherBuilders) {
    const TemporaryFolder folder;
    const std::string scene = write_stand_in(folder.path(), stand_in(GetParam()));
    expect_the_same_forces({folder.path(), "--scene", scene});
}

INSTANTIATE_TEST_SUITE_P(, VulkanTouchStandIn,
                         ::testing::Values("castel_sr300", "visp_cube_realsense", "redwood5", "icl_nuim5"),
                         test_name);

class VulkanTouchReal : public ::testing::TestWithParam<const char*> {};

TEST_P(VulkanTouchReal, HasTheForcesOfTheOtherBuilders) {
    const std::string clip = real_data(GetParam());
    TOUCHABLE_NEEDS_DATA(clip);
    Words words{clip};
    const std::string scene =
        TOUCHABLE_SOURCE_DIR "/tests/scenes/" + fs::path(GetParam()).filename().string() + ".json";
    if (fs::exists(scene)) words.insert(words.end(), {"--scene", scene});
    expect_the_same_forces(words);
}

INSTANTIATE_TEST_SUITE_P(, VulkanTouchReal,
                         ::testing::Values("castel_sr300", "visp_cube_realsense", "stills/redwood5",
                                           "stills/icl_nuim5", "stills/lensblur/greek-helmet.jpg",
                                           "depthkit_typing/Test.mov"),
                         test_name);

TEST(VulkanTouch, TheValidationLayerHasNothingToSay) {
    const TemporaryFolder folder;
    make_clip("noise", folder / "clip.mkv", {"--size", "150x90", "--frames", "9"});
    setenv("TOUCHABLE_VULKAN_VALIDATION", "1", 1);
    const Outcome run = run_touchable({"touch", folder / "clip.mkv", "--builder", "vulkan", "--median", "5",
                                       "--fill-holes", "1", "--seconds", "0.3"});
    unsetenv("TOUCHABLE_VULKAN_VALIDATION");
    EXPECT_EQ(run.code, 0);
    EXPECT_EQ(run.err, "");
}

TEST(VulkanTouch, TheReportNamesTheDeviceThatTheSurfaceWasBuiltOn) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "clip.mkv", {"--size", "40x30", "--frames", "2"});
    const auto device = GpuDevice::open();
    ASSERT_TRUE(device);
    const auto on_gpu = touch({folder / "clip.mkv", "--seconds", "0.1", "--builder", "vulkan"});
    const auto on_cpu = touch({folder / "clip.mkv", "--seconds", "0.1"});
    EXPECT_EQ(on_gpu["device_name"], (*device)->facts().name);
    EXPECT_EQ(on_cpu["device_name"], on_cpu["cpu_name"]);
    EXPECT_EQ(on_gpu["cpu_name"], on_cpu["cpu_name"]);
}

TEST(VulkanTouch, WithoutADriverEndsWithExitCode4AndSaysWhatIsMissing) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "clip.mkv", {"--size", "40x30", "--frames", "2"});
    const WithoutDriver none;
    const Outcome run = run_touchable({"touch", folder / "clip.mkv", "--builder", "vulkan"});
    EXPECT_EQ(run.code, 4);
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
    EXPECT_NE(run.err.find("install a driver"), std::string::npos) << run.err;
}

TEST(VulkanTouch, WhereAutoTookAGpuThatWillNotDoTheCpuBuilderDoesItsWork) {
    RunGpu none("no such device");
    Scene scene;
    scene.width = 40;
    scene.height = 30;
    const auto asked_for = make_builder({.name = "vulkan"}, scene, none);
    ASSERT_FALSE(asked_for);
    EXPECT_EQ(asked_for.error().kind, ErrorKind::gpu);
    const auto picked = make_builder({.name = "vulkan", .gpu_fallback = true}, scene, none);
    ASSERT_TRUE(picked) << picked.error().message;
    EXPECT_EQ((*picked)->name(), "cpu");
}

TEST(VulkanTouch, ADeviceThatIsNotThereIsRefusedWithThoseThatAre) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "clip.mkv", {"--size", "40x30", "--frames", "2"});
    const Outcome run =
        run_touchable({"touch", folder / "clip.mkv", "--builder", "vulkan", "--gpu", "no such device"});
    EXPECT_EQ(run.code, 4);
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
    EXPECT_NE(run.err.find("no such device"), std::string::npos) << run.err;
}

TEST(VulkanTouch, AutoMayTakeTheGpuThatIsNamedWhichHasToBeThere) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "clip.mkv", {"--size", "40x30", "--frames", "2"});
    const Words words{folder / "clip.mkv", "--seconds", "0.1"};
    Words named = words;
    named.insert(named.end(), {"--gpu", "0"});
    const auto report = touch(named);
    EXPECT_EQ(report["builder"], "cpu") << "small frames are not worth a GPU";
    EXPECT_EQ(report["force_hash"], force_hash(words));
    const Outcome none = run_touchable({"touch", folder / "clip.mkv", "--gpu", "no such device"});
    EXPECT_EQ(none.code, 4) << none.err;
    EXPECT_TRUE(none.one_line_of_error()) << none.err;
}

TEST(VulkanTouch, GpuOptionsNeedTheVulkanBuilder) {
    const TemporaryFolder folder;
    make_clip("bumps", folder / "clip.mkv", {"--size", "40x30", "--frames", "2"});
    for (const Words& words :
         {Words{"--builder", "cpu", "--gpu", "0"}, {"--builder", "lazy", "--gpu", "0"}}) {
        Words all{"touch", folder / "clip.mkv"};
        all.insert(all.end(), words.begin(), words.end());
        const Outcome run = run_touchable(all);
        EXPECT_EQ(run.code, 2) << words.back();
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
    }
}

}  // namespace
}  // namespace touchable::test
