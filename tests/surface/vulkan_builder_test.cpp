#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>
#include <cmath>
#include <filesystem>

#include <cstring>

#include "engine/gpu/surface_kernels.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

TEST(ValidCodes, AreTheCodingsForEveryCode) {
    for (const int bits : {8, 10, 16})
        for (const Marking marking : all_markings) {
            const Scene scene = depth_scene(1, 1, bits, marking);
            const ValidCodes codes = valid_codes_of(scene.depth);
            for (int code = 0; code <= 65535; ++code) {
                const auto c = static_cast<std::uint16_t>(code);
                ASSERT_EQ(code_is_in_range(c, codes) && !code_is_excluded(c, codes), scene.depth.is_valid(c))
                    << code << " of " << bits << " bits, marking " << static_cast<int>(marking);
            }
        }
}

TEST(ValidCodes, AreNoneWhereNoCodeIsValid) {
    Scene scene = depth_scene(1, 1, 8, Marking::none);
    scene.depth.valid_min = 1;
    scene.depth.valid_max = 0;
    for (int code = 0; code <= 65535; ++code)
        ASSERT_FALSE(code_is_in_range(static_cast<std::uint32_t>(code), valid_codes_of(scene.depth)));
}

TEST(VulkanBuilder, LeavesFramesInMappedMemoryThatARecycledSlotKeeps) {
    const Scene scene = depth_scene(64, 40, 16, Marking::zero, {3, 0});
    const auto builder = test_vulkan_builder(scene);
    SurfaceFrame slot, reference;
    ASSERT_TRUE(builder->build(noisy_plane(scene, Fill::blob, 1).frame(), slot));
    EXPECT_TRUE(slot.codes.adopted() && slot.validity.adopted() && slot.tiles.adopted());
    const auto* codes = slot.codes.data();
    const auto* validity = slot.validity.data();
    const auto* tiles = slot.tiles.data();
    const StoredPlane second = noisy_plane(scene, Fill::few_holes, 2);
    ASSERT_TRUE(builder->build(second.frame(), slot));
    EXPECT_TRUE(slot.codes.data() == codes && slot.validity.data() == validity && slot.tiles.data() == tiles);
    ASSERT_TRUE(make_reference_builder(scene)->build(second.frame(), reference));
    EXPECT_EQ(first_difference(reference, slot), "");
}

TEST(VulkanBuilder, FramesOutliveTheirBuilder) {
    const Scene scene = depth_scene(64, 40, 16, Marking::zero, {3, 0});
    const StoredPlane plane = noisy_plane(scene, Fill::blob, 1);
    SurfaceFrame frame, reference;
    ASSERT_TRUE(test_vulkan_builder(scene)->build(plane.frame(), frame));
    ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
    EXPECT_EQ(first_difference(reference, frame), "");
}

/// Memory between two pages that nobody may read.
class GuardedMemory {
public:
    explicit GuardedMemory(std::size_t pages)
        : page_(static_cast<std::size_t>(sysconf(_SC_PAGESIZE))),
          whole_((pages + 2) * page_),
          start_(static_cast<std::uint8_t*>(
              mmap(nullptr, whole_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))) {
        mprotect(start_ + page_, pages * page_, PROT_READ | PROT_WRITE);
    }
    ~GuardedMemory() { munmap(start_, whole_); }
    GuardedMemory(const GuardedMemory&) = delete;
    GuardedMemory& operator=(const GuardedMemory&) = delete;
    std::uint8_t* begin() const { return start_ + page_; }
    std::uint8_t* end() const { return start_ + whole_ - page_; }

private:
    const std::size_t page_, whole_;
    std::uint8_t* const start_;
};

TEST(VulkanBuilder, ReadsAPlaneWhereverItLiesAndNothingBesideIt) {
    const GuardedMemory memory(4);
    for (const int bits : {8, 16})
        for (const int width : {96, 83}) {
            const Scene scene = depth_scene(width, 31, bits, Marking::zero, {3, 0});
            const StoredPlane plane = noisy_plane(scene, Fill::few_holes, 3);
            const auto builder = test_vulkan_builder(scene);
            SurfaceFrame reference, frame;
            ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
            const std::ptrdiff_t row = std::ptrdiff_t{width} * plane.view.bytes_per_sample;
            for (const std::ptrdiff_t stride : {row, (row + 15) / 16 * 16, -(row + 32) / 16 * 16}) {
                const std::ptrdiff_t bytes = 30 * std::abs(stride) + row;
                for (std::uint8_t* at : {memory.begin(), memory.begin() + 16, memory.begin() + 2,
                                         memory.end() - bytes, memory.end() - bytes / 16 * 16 - 16}) {
                    RawFrame raw = plane.frame();
                    raw.storage = std::shared_ptr<const void>(std::shared_ptr<void>(), memory.begin());
                    raw.depth.data = stride > 0 ? at : at - 30 * stride;
                    raw.depth.stride = stride;
                    for (int y = 0; y < 31; ++y)
                        std::memcpy(at + (stride > 0 ? y * stride : (y - 30) * stride), plane.view.row(y),
                                    static_cast<std::size_t>(row));
                    ASSERT_TRUE(builder->build(raw, frame));
                    EXPECT_EQ(first_difference(reference, frame), "")
                        << bits << " bits, " << width << " wide, stride " << stride;
                }
            }
        }
}

TEST(VulkanBuilder, GroupsAndSegmentsOfAnySizeGiveTheSameBits) {
    const Scene scene = depth_scene(331, 97, 16, Marking::zero, {3, 1});
    const StoredPlane plane = noisy_plane(scene, Fill::blob, 5);
    SurfaceFrame reference, frame;
    ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
    for (const std::uint32_t group_size : {1U, 32U, 64U, 250U})
        for (const std::uint32_t segment_texels : {0U, 4U, 20U})
            for (const bool along_x : {false, true}) {
                const SurfacePlan plan{group_size, segment_texels, along_x, false};
                auto builder = make_vulkan_builder(scene, test_kernels(), plan);
                ASSERT_TRUE(builder) << builder.error().message;
                ASSERT_TRUE((*builder)->build(plane.frame(), frame));
                EXPECT_EQ(first_difference(reference, frame), "") << plan_text(plan);
            }
}

/// More frames than are in flight, some of them in slots that hold another builder's; filters that remember
/// see them in order.
TEST(VulkanBuilder, GivesFramesThatAreInFlightInTheirOrder) {
    FilterSettings remembering{3, 1, TerraceRemoval::on};
    remembering.temporal = true;
    remembering.temporal_noise = {4, 0};
    for (const FilterSettings& filter : {FilterSettings{3, 0}, FilterSettings{0, 2}, remembering})
        for (const SurfacePlan& plan : all_plans) {
            const Scene scene = depth_scene(83, 45, 16, Marking::zero, filter);
            auto made = make_vulkan_builder(scene, test_kernels(), plan);
            ASSERT_TRUE(made) << made.error().message;
            SurfaceBuilder& builder = **made;
            EXPECT_EQ(builder.frames_in_flight(), plan.builds_in_part() ? 1 : 3);
            const auto twin = make_reference_builder(scene);
            std::vector<std::shared_ptr<StoredPlane>> planes;
            for (std::uint64_t n = 0; n < 12; ++n) {
                planes.push_back(std::make_shared<StoredPlane>(noisy_plane(scene, Fill::blob, n)));
            }
            const auto frame = [&](std::size_t n) {
                RawFrame raw = planes[n]->frame();
                raw.number = static_cast<std::int64_t>(n);
                raw.storage = planes[n];
                return raw;
            };
            SurfaceFrame slots[4];
            ASSERT_TRUE(make_cpu_builder(scene)->build(frame(0), slots[1]));
            std::size_t begun = 0;
            for (std::size_t n = 0; n < planes.size(); ++n) {
                for (; begun < planes.size() &&
                       begun < n + static_cast<std::size_t>(builder.frames_in_flight());
                     ++begun)
                    ASSERT_TRUE(builder.begin(frame(begun)));
                SurfaceFrame reference;
                ASSERT_TRUE(twin->build(frame(n), reference));
                const auto finished = builder.finish(slots[n % 4]);
                ASSERT_TRUE(finished) << finished.error().message;
                EXPECT_EQ(first_difference(reference, slots[n % 4]), "")
                    << plan_text(plan) << ", frame " << n;
                // The frames before are not written over.
                if (n == 0) continue;
                ASSERT_TRUE(make_reference_builder(scene)->build(frame(n - 1), reference));
                if (!FilterPlan(scene).remembers()) {
                    EXPECT_EQ(first_difference(reference, slots[(n - 1) % 4]), "") << plan_text(plan);
                }
            }
        }
}

/// With rows of every padding, in memory that is lent again. A block that is imported has an owner more.
TEST(VulkanBuilder, ReadsPlanesInTheMemoryThatTheyLieIn) {
    for (const auto& [width, plan] :
         {std::pair{83, all_plans[2]}, {96, all_plans[2]}, {83, all_plans[3]}, {96, all_plans[3]}}) {
        const Scene scene = depth_scene(width, 31, 16, Marking::zero, {3, 0});
        auto made = make_vulkan_builder(scene, test_kernels(), plan);
        ASSERT_TRUE(made) << made.error().message;
        std::vector<std::shared_ptr<std::uint8_t>> leases;
        for (std::uint64_t n = 0; n < 80; ++n) {
            if (n == 40) leases.clear();  // what follows is in blocks that are imported
            const StoredPlane plane = noisy_plane(scene, Fill::few_holes, n);
            const std::size_t row = std::size_t{2} * static_cast<std::size_t>(width),
                              stride = aligned_bytes(row, 64) + 64 * (n % 3) + (n % 5 == 4 ? 2 : 0),
                              bytes = 31 * stride;
            leases.push_back(take_plane_memory(bytes));
            RawFrame raw = plane.frame();
            raw.storage = leases.back();
            raw.depth.data = leases.back().get();
            raw.depth.stride = static_cast<std::ptrdiff_t>(stride);
            for (int y = 0; y < 31; ++y)
                std::memcpy(leases.back().get() + static_cast<std::size_t>(y) * stride, plane.view.row(y),
                            row);
            const auto owners = [&] { return plane_block_of(raw.depth.data, bytes).use_count(); };
            const long before = owners();
            SurfaceFrame reference, frame;
            ASSERT_TRUE(make_reference_builder(scene)->build(raw, reference));
            ASSERT_TRUE((*made)->build(raw, frame));
            EXPECT_EQ(first_difference(reference, frame), "") << width << " wide, stride " << stride;
            // Rows that are not whole texels the CPU copies.
            EXPECT_TRUE(n >= 40 || (owners() > before) == (n % 5 != 4)) << stride;
        }
    }
}

/// A software Vulkan that says it is a graphics card.
std::shared_ptr<GpuDevice> seeming_card(const std::filesystem::path& folder) {
    GpuOptions options;
    options.cache_folder = folder;
    auto device = GpuDevice::open(options);
    if (!device) throw std::runtime_error(device.error().message);
    GpuFacts& facts = (*device)->vulkan()->facts;
    facts.kind = GpuKind::discrete;
    facts.unified_memory = false;
    return *device;
}

TEST(BuilderRace, IsRunOnceForADevice) {
    const TemporaryFolder folder;
    GpuFacts::Measured first;
    {
        const auto device = seeming_card(folder.path());
        EXPECT_LT(device->facts().measured.cpu_ms, 0);
        measure_builders(device);
        first = device->facts().measured;
    }
    for (const double ms : {first.cpu_ms, first.vulkan_ms, first.over_bus_ms}) {
        EXPECT_GT(ms, 0);
        EXPECT_LT(ms, 60'000) << "with the right bits";
    }
    const auto again = seeming_card(folder.path());
    measure_builders(again);
    const GpuFacts::Measured& kept = again->facts().measured;
    EXPECT_EQ(kept.cpu_ms, first.cpu_ms);
    EXPECT_EQ(kept.vulkan_ms, first.vulkan_ms);
    EXPECT_EQ(kept.over_bus_ms, first.over_bus_ms);
}

TEST(BuilderRace, DecidesWhetherKernelsReachOverTheBus) {
    GpuFacts facts = test_kernels()->device()->facts();
    facts.kind = GpuKind::discrete;
    facts.unified_memory = false;
    EXPECT_FALSE(plan_for(facts).over_bus) << "not known to be right";
    facts.measured = {.cpu_ms = 1, .vulkan_ms = 2, .over_bus_ms = 1};
    EXPECT_TRUE(plan_for(facts).over_bus);
    facts.measured.over_bus_ms = 3;
    EXPECT_FALSE(plan_for(facts).over_bus);
    facts.measured.over_bus_ms = HUGE_VAL;
    EXPECT_FALSE(plan_for(facts).over_bus) << "wrong";
    facts.measured.over_bus_ms = 1;
    facts.unified_memory = true;
    EXPECT_FALSE(plan_for(facts).over_bus) << "nothing is copied there";
    facts.kind = GpuKind::software;
    EXPECT_FALSE(plan_for(facts).blocks);
}

/// For every plan: a device whose limits just suffice makes the builder; one less of any limit refuses it.
TEST(VulkanBuilder, FramesThatDoNotFitTheDeviceAreRefused) {
    auto device = GpuDevice::open();
    ASSERT_TRUE(device) << device.error().message;
    const auto kernels = std::make_shared<SurfaceKernels>(*device);
    const Scene scene = depth_scene(640, 400, 16, Marking::zero, {3, 0});
    constexpr std::uint32_t row_texels = 80, texels = row_texels * 400, strips = 200;
    GpuFacts::Limits& limits = (*device)->vulkan()->facts.limits;
    const GpuFacts::Limits whole = limits;
    for (const SurfacePlan& plan : {all_plans[0], all_plans[1], plan_for((*device)->facts())}) {
        const std::uint32_t segments =
            plan.segment_texels > 0 ? groups_for(row_texels, plan.segment_texels) : 1;
        const auto make_with = [&](std::uint32_t most_texels, std::uint32_t most_bytes,
                                   std::uint32_t most_groups) {
            limits.max_texel_buffer_elements = most_texels;
            limits.max_storage_buffer_range = most_bytes;
            limits.max_group_count[0] = most_groups;
            auto made = make_vulkan_builder(scene, kernels, plan);
            limits = whole;
            return made;
        };
        const std::uint32_t bytes = 16 * texels, groups = groups_for(strips * segments, plan.group_size);
        const auto fitting = make_with(texels, bytes, groups);
        EXPECT_TRUE(fitting) << plan_text(plan) << ": " << fitting.error().message;
        const auto expect_refusal = [&](const Result<std::unique_ptr<VulkanSurfaceBuilder>>& made) {
            ASSERT_FALSE(made) << plan_text(plan);
            EXPECT_EQ(made.error().kind, ErrorKind::gpu);
            EXPECT_NE(made.error().message.find("640x400"), std::string::npos) << made.error().message;
        };
        expect_refusal(make_with(texels - 1, bytes, groups));
        expect_refusal(make_with(texels, bytes - 1, groups));
        expect_refusal(make_with(texels, bytes, groups - 1));
    }
}

std::string stages_of(const FilterSettings& filter) {
    const Scene scene = depth_scene(64, 40, 8, Marking::zero, filter);
    const auto builder = test_vulkan_builder(scene);
    SurfaceFrame slot;
    EXPECT_TRUE(builder->build(noisy_plane(scene, Fill::blob, 1).frame(), slot));
    std::string labels;
    for (const GpuDevice::Time& stage : builder->stages()) {
        EXPECT_GT(stage.ms, 0);
        if (stage.label.rfind("read ", 0) != 0) labels += stage.label + " ";
    }
    return labels;
}

TEST(VulkanBuilder, TellsItsStages) {
    EXPECT_EQ(stages_of({0, 0}), "decode bounds ");
    EXPECT_EQ(stages_of({3, 2}), "fill median bounds ");
    FilterSettings all{3, 1, TerraceRemoval::on};
    all.temporal = true;
    all.temporal_noise = {1, 0};
    EXPECT_EQ(stages_of(all), "fill median temporal terraces decode bounds ");
}

}  // namespace
}  // namespace touchable::test
