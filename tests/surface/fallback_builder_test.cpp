#include <gtest/gtest.h>

#include "engine/gpu/vulkan_builder.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/gpu/blockade.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"

namespace touchable::test {
namespace {

/// Fails at one frame; until then it gives what another builder gives.
class FailingBuilder final : public SurfaceBuilder {
public:
    FailingBuilder(const Scene& scene, std::int64_t at, Error error)
        : builder_(make_cpu_builder(scene)), at_(at), error_(std::move(error)) {}
    std::string_view name() const override { return "failing"; }
    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (raw.number >= at_) return error_;
        return builder_->build(raw, out);
    }

private:
    std::unique_ptr<SurfaceBuilder> builder_;
    std::int64_t at_;
    Error error_;
};

// Rows are whole texels, so that a software Vulkan reads planes where they lie.
const Scene scene = depth_scene(72, 45, 16, Marking::zero, {3, 1});

RawFrame stored(std::int64_t number) {
    Random random(static_cast<std::uint64_t>(number) + 1);
    const auto plane = std::make_shared<StoredPlane>(
        store_plane(scene.width, scene.height, fill_picture(scene, Fill::blob, random), {}));
    RawFrame raw = plane->frame();
    raw.number = number;
    raw.storage = plane;
    return raw;
}

/// Builds frame `number` into `slot`, and fails the test where it is not as the reference's.
void expect_built(SurfaceBuilder& builder, std::int64_t number, SurfaceFrame& slot) {
    const RawFrame raw = stored(number);
    SurfaceFrame reference;
    ASSERT_TRUE(make_reference_builder(scene)->build(raw, reference));
    const auto built = builder.build(raw, slot);
    ASSERT_TRUE(built) << built.error().message;
    EXPECT_EQ(first_difference(reference, slot), "") << number;
    EXPECT_EQ(first_vertex_difference(reference, *slot.vertices), "") << number;
}

TEST(FallbackBuilder, BuildsTheFrameThatFailedAndAllLaterOnesWithTheSecond) {
    std::vector<std::string> told;
    const auto builder = make_fallback_builder(
        std::make_unique<FailingBuilder>(scene, 3, Error{ErrorKind::gpu, "the cable is out"}),
        make_cpu_builder(scene), [&](const std::string& line) { told.push_back(line); });
    SurfaceFrame slots[2];
    for (std::int64_t number = 0; number < 8; ++number) {
        EXPECT_EQ(builder->name(), number <= 3 ? "failing" : "cpu");
        expect_built(*builder, number, slots[number % 2]);
    }
    EXPECT_EQ(told, std::vector<std::string>{"frame 3: the cable is out; the cpu builder goes on"});
}

TEST(FallbackBuilder, PassesOtherErrorsOn) {
    const auto builder = make_fallback_builder(
        std::make_unique<FailingBuilder>(scene, 0, Error{ErrorKind::input, "no such plane"}),
        make_cpu_builder(scene), [](const std::string& line) { FAIL() << line; });
    SurfaceFrame slot;
    const auto built = builder->build(stored(0), slot);
    ASSERT_FALSE(built);
    EXPECT_EQ(built.error().kind, ErrorKind::input);
    EXPECT_EQ(builder->name(), "failing");
}

TEST(FallbackBuilder, GoesOnWhereTheGpuIsLost) {
    auto opened = GpuDevice::open();  // of its own, to be lost
    ASSERT_TRUE(opened) << opened.error().message;
    auto vulkan = make_vulkan_builder(scene, *opened);
    ASSERT_TRUE(vulkan) << vulkan.error().message;
    std::vector<std::string> told;
    const auto builder = make_fallback_builder(std::move(*vulkan), make_cpu_builder(scene),
                                               [&](const std::string& line) { told.push_back(line); });
    SurfaceFrame slots[3];
    for (std::int64_t number = 0; number < 9; ++number) {
        if (number == 4) (*opened)->lose();
        expect_built(*builder, number, slots[number % 3]);
        EXPECT_EQ(builder->name(), number < 4 ? "vulkan" : "cpu");
        // What the solver still reads of the lost device's frames stays as it was.
        if (number == 4)
            for (const std::int64_t earlier : {2, 3}) {
                SurfaceFrame reference;
                ASSERT_TRUE(make_reference_builder(scene)->build(stored(earlier), reference));
                EXPECT_EQ(first_difference(reference, slots[earlier % 3]), "");
            }
    }
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].rfind("frame 4: ", 0), 0U) << told[0];
}

/// Three are in flight when the GPU is lost, and none is.
TEST(FallbackBuilder, BuildsWhatWasInFlightWithTheSecond) {
    auto opened = GpuDevice::open();
    ASSERT_TRUE(opened) << opened.error().message;
    auto vulkan = make_vulkan_builder(scene, std::make_shared<SurfaceKernels>(*opened), all_plans[2]);
    ASSERT_TRUE(vulkan) << vulkan.error().message;
    std::vector<std::string> told;
    const auto builder = make_fallback_builder(std::move(*vulkan), make_cpu_builder(scene),
                                               [&](const std::string& line) { told.push_back(line); });
    EXPECT_EQ(builder->frames_in_flight(), 3);
    SurfaceFrame slot, reference;
    std::int64_t begun = 0;
    for (std::int64_t number = 0; number < 9; ++number) {
        for (; begun < number + builder->frames_in_flight() && begun < 9; ++begun)
            ASSERT_TRUE(builder->begin(stored(begun)));
        if (number == 4) (*opened)->lose();
        ASSERT_TRUE(make_reference_builder(scene)->build(stored(number), reference));
        ASSERT_TRUE(builder->finish(slot));
        EXPECT_EQ(first_difference(reference, slot), "") << number;
        EXPECT_EQ(builder->name(), number < 4 ? "vulkan" : "cpu");
    }
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].rfind("frame 4: ", 0), 0U) << told[0];
}

TEST(FallbackBuilder, GoesOnWhereTheGpuHangs) {
    auto opened = GpuDevice::open();
    ASSERT_TRUE(opened) << opened.error().message;
    std::shared_ptr<GpuDevice> device = std::move(*opened);
    auto vulkan = make_vulkan_builder(scene, device);
    ASSERT_TRUE(vulkan) << vulkan.error().message;
    std::vector<std::string> told;
    auto builder = make_fallback_builder(std::move(*vulkan), make_cpu_builder(scene),
                                         [&](const std::string& line) { told.push_back(line); });
    SurfaceFrame slots[3];
    for (std::int64_t number = 0; number < 3; ++number) expect_built(*builder, number, slots[number]);
    Blockade blockade(*device);
    device->set_patience(std::chrono::milliseconds(20));
    device.reset();  // the builder's alone, and so destroyed when that gives up
    for (std::int64_t number = 3; number < 9; ++number) expect_built(*builder, number, slots[number % 3]);
    EXPECT_EQ(builder->name(), "cpu");
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("is given up; the cpu builder goes on"), std::string::npos) << told[0];
    // Where the GPU goes on after all, it writes what nobody reads.
    blockade.lift();
    for (std::int64_t number = 6; number < 9; ++number) {
        SurfaceFrame reference;
        ASSERT_TRUE(make_reference_builder(scene)->build(stored(number), reference));
        EXPECT_EQ(first_difference(reference, slots[number % 3]), "");
    }
    EXPECT_TRUE(GpuDevice::open());  // frees what was left behind
}

}  // namespace
}  // namespace touchable::test
