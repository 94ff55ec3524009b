#include <gtest/gtest.h>
#include <cmath>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "device/hand.hpp"
#include "engine/clip/clip.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/commands/run_options.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/run_record.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

// A session over a clip during which the GPU is lost.
namespace touchable::test {
namespace {

constexpr std::int64_t frames = 20, ticks = 900;

enum class Doom { lost, hangs };

/// Its device is lost, or hangs, just before a frame.
class DoomedBuilder final : public SurfaceBuilder {
public:
    DoomedBuilder(const Scene& scene, std::shared_ptr<GpuDevice> device, Doom doom, std::int64_t at)
        : device_(std::move(device)), doom_(doom), at_(at) {
        auto made = make_vulkan_builder(scene, device_);
        if (!made) throw std::runtime_error(made.error().message);
        builder_ = std::move(*made);
    }
    std::string_view name() const override { return builder_->name(); }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (raw.number == at_ && doom_ == Doom::lost) device_->lose();
        if (raw.number == at_ && doom_ == Doom::hangs) {
            device_->set_patience(std::chrono::milliseconds(20));
            blockade_.emplace(*device_);
        }
        return builder_->build(raw, out);
    }

private:
    std::shared_ptr<GpuDevice> device_;
    Doom doom_;
    std::int64_t at_;
    std::optional<Blockade> blockade_;  // lifted after the builder has ended
    std::unique_ptr<SurfaceBuilder> builder_;
};

struct Touched {
    std::string force_hash;
    std::int64_t frames = 0, ticks = 0;
};

/// The scene's own filter, but a median of 3x3.
Scene scene_in(const ClipReader& reader) {
    Scene scene = reader.scene();
    scene.filter.median = 3;
    return scene;
}

Touched touched_with(std::unique_ptr<ClipReader> reader, std::unique_ptr<SurfaceBuilder> builder) {
    const Scene scene = scene_in(*reader);
    SurfaceFeed feed(std::move(reader), std::move(builder), scene);
    const auto first = feed.pair_at(0);
    EXPECT_TRUE(first);
    const HeightField field(scene, *first);
    TouchSessionSettings settings;
    settings.fingers = 3;
    settings.ticks = ticks;
    const Workspace workspace = default_workspace(scene.width, scene.camera.fx, scene.depth.near);
    settings.touch.metres_per_scene_unit = workspace.metres_per_scene_unit;
    auto hand = make_hand("wander", settings.fingers, workspace, FieldProbe(field));
    EXPECT_TRUE(hand);
    const auto solver = TouchSolver::create(scene, settings.touch);
    EXPECT_TRUE(solver);
    TouchFigures figures;
    const std::array<TouchSink*, 1> sinks{&figures};
    const auto ran = TouchSession(scene, feed, **hand, *solver, settings).run(sinks);
    EXPECT_TRUE(ran) << ran.error().message;
    EXPECT_GT(figures.to_json()["finger_contact_pct"].get<double>(), 20) << "hardly a test of forces";
    return {figures.force_hash(), feed.frames(), figures.ticks()};
}

TEST(LostGpu, CostsNeitherFrameNorForce) {
    const TemporaryFolder folder;
    // Of a scene whose depth stands still nothing would be asked of the GPU.
    make_clip("moving", folder / "clip.mkv", {"--size", "160x120", "--frames", std::to_string(frames)});
    const auto reader = [&] {
        auto opened = open_clip(folder / "clip.mkv", std::nullopt);
        EXPECT_TRUE(opened);
        return std::move(*opened);
    };
    auto whole = reader();
    const Scene scene = scene_in(*whole);
    const Touched expected = touched_with(std::move(whole), make_cpu_builder(scene));
    EXPECT_EQ(expected.ticks, ticks);

    for (const auto& [doom, lost_at] : {std::pair(Doom::lost, std::int64_t{0}),
                                        {Doom::lost, 7},
                                        {Doom::lost, frames - 1},
                                        {Doom::hangs, 0},
                                        {Doom::hangs, 11}}) {
        auto device = GpuDevice::open();
        ASSERT_TRUE(device) << device.error().message;
        std::vector<std::string> told;
        const Touched run = touched_with(
            reader(), make_fallback_builder(std::make_unique<DoomedBuilder>(scene, *device, doom, lost_at),
                                            make_cpu_builder(scene),
                                            [&](const std::string& line) { told.push_back(line); }));
        EXPECT_EQ(run.force_hash, expected.force_hash) << "lost at frame " << lost_at;
        EXPECT_EQ(run.frames, expected.frames);
        EXPECT_EQ(run.ticks, expected.ticks);
        ASSERT_EQ(told.size(), 1U) << "at frame " << lost_at << (doom == Doom::lost ? ", lost" : ", hangs");
        EXPECT_EQ(told[0].rfind("frame " + std::to_string(lost_at) + ": ", 0), 0U) << told[0];
    }
}

TEST(LostGpu, IsHandedOutToNobodyElse) {
    RunGpu gpu("auto");
    const auto first = gpu.open();
    ASSERT_TRUE(first) << first.error().message;
    EXPECT_EQ(*gpu.open(), *first) << "one for all";
    (*first)->lose();
    const auto second = gpu.open();
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_FALSE((*second)->lost());
    EXPECT_EQ(*gpu.open(), *second);
    EXPECT_EQ(gpu.name(), (*second)->facts().name);
}

TEST(LostGpu, ByMeasuringItIsOpenedAnewAndNotMeasuredAgain) {
    RunGpu gpu("auto");
    int measured = 0;
    const auto measure = [&](const std::shared_ptr<GpuDevice>& device) {
        GpuFacts::Measured& figures = device->vulkan()->facts.measured;
        if (figures.over_bus_ms >= 0) return;
        ++measured;
        figures.over_bus_ms = HUGE_VAL;
        device->lose();
    };
    for (int n = 0; n < 2; ++n) {
        const auto device = gpu.open_measured(measure);
        ASSERT_TRUE(device) << device.error().message;
        EXPECT_FALSE((*device)->lost());
        EXPECT_EQ((*device)->facts().measured.over_bus_ms, HUGE_VAL);
        (*device)->lose();
    }
    EXPECT_EQ(measured, 1);
}

/// A software GPU still compiles then, on a thread of the program.
TEST(LostGpu, GivenUpAtWorkLetsTheProgramEnd) {
    const TemporaryFolder folder;
    make_clip("moving", folder / "clip.mkv", {"--size", "96x64", "--frames", "3"});
    setenv("LD_PRELOAD", TOUCHABLE_IMPATIENT_GPU, 1);
    setenv("MESA_SHADER_CACHE_DISABLE", "1", 1);
    const Outcome run = run_touchable({"touch", folder / "clip.mkv", "--builder", "vulkan", "--median", "5",
                                       "--hand", "wander", "--seconds", "0.001"});
    unsetenv("LD_PRELOAD");
    unsetenv("MESA_SHADER_CACHE_DISABLE");
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.err.find("is given up; the cpu builder goes on"), std::string::npos) << run.err;
}

/// `spoil` makes a GPU, which the picture was to be drawn on, one that cannot.
void expect_a_picture_by_any_painter(const std::function<void(GpuDevice&)>& spoil) {
    const TemporaryFolder folder;
    make_clip("globe", folder / "clip.mkv", {"--size", "72x48", "--frames", "1"});
    auto reader = open_clip(folder / "clip.mkv", std::nullopt);
    ASSERT_TRUE(reader);
    const auto raw = (*reader)->next();
    ASSERT_TRUE(raw && *raw);
    const Scene& scene = (*reader)->scene();
    SurfaceFrame surface;
    ASSERT_TRUE(make_cpu_builder(scene)->build(**raw, surface));
    const FramePair still{{0, 0, &surface}, {0, 0, &surface}, 0};
    for (const char* painter : {"auto", "raster"}) {
        RunGpu gpu("auto");
        PictureOptions options;
        options.file = folder / (std::string(painter) + ".png");
        options.painter = painter;
        options.size = "96x54";
        auto order = order_picture(options, Existing::keep, {}, gpu);
        ASSERT_TRUE(order && *order);
        EXPECT_FALSE((*order)->painter->gpu_name().empty());
        spoil(**gpu.open());
        const auto drawn = (*order)->deliver(HeightField(scene, still), still, (*raw)->colour, {});
        const bool any = options.painter == "auto";
        EXPECT_EQ(bool(drawn), any);
        EXPECT_EQ(std::filesystem::exists(*options.file), any);
        if (any) {
            EXPECT_EQ((*order)->painter->name(), "cpu");
        } else {
            EXPECT_EQ(drawn.error().kind, ErrorKind::gpu);
        }
    }
}

TEST(LostGpu, CostsNoPictureThatAnyPainterMayDraw) {
    expect_a_picture_by_any_painter([](GpuDevice& gpu) { gpu.lose(); });
}

TEST(SmallGpu, CostsNoPictureThatAnyPainterMayDraw) {
    expect_a_picture_by_any_painter(
        [](GpuDevice& gpu) { gpu.vulkan()->facts.limits.max_texel_buffer_elements = 1; });
}

}  // namespace
}  // namespace touchable::test
