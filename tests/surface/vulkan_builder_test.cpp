// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>

#include "engine/gpu/surface_kernels.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/must.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"
#include "tests/sweep.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

TEST(ValidCodes, MatchCodingForEveryCode) {
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

TEST(ValidCodes, AreEmptyWithoutValidCode) {
    Scene scene = depth_scene(1, 1, 8, Marking::none);
    scene.depth.valid_min = 1;
    scene.depth.valid_max = 0;
    for (int code = 0; code <= 65535; ++code)
        ASSERT_FALSE(code_is_in_range(static_cast<std::uint32_t>(code), valid_codes_of(scene.depth)));
}

TEST(VulkanBuilder, ReusesMappedMemoryOfSlot) {
    const Scene scene = depth_scene(64, 40, 16, Marking::zero, {3, 0});
    const auto builder = test_vulkan_builder(scene);
    SurfaceFrame slot;
    ASSERT_TRUE(builder->build(noisy_plane(scene, Fill::blob, 1).frame(), slot));
    EXPECT_TRUE(slot.codes.adopted() && slot.validity.adopted() && slot.tiles.adopted());
    const auto* codes = slot.codes.data();
    const auto* validity = slot.validity.data();
    const auto* tiles = slot.tiles.data();
    const StoredPlane second = noisy_plane(scene, Fill::few_holes, 2);
    ASSERT_TRUE(builder->build(second.frame(), slot));
    EXPECT_TRUE(slot.codes.data() == codes && slot.validity.data() == validity && slot.tiles.data() == tiles);
    EXPECT_EQ(reference_difference(scene, second.frame(), slot), "");
}

TEST(VulkanBuilder, LeavesFramesThatOutliveIt) {
    const Scene scene = depth_scene(64, 40, 16, Marking::zero, {3, 0});
    const StoredPlane plane = noisy_plane(scene, Fill::blob, 1);
    SurfaceFrame frame;
    ASSERT_TRUE(test_vulkan_builder(scene)->build(plane.frame(), frame));
    EXPECT_EQ(reference_difference(scene, plane.frame(), frame), "");
}

/// Memory between two pages that may not be read.
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

TEST(VulkanBuilder, ReadsOnlyThePlane) {
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

TEST(VulkanBuilder, EqualsReferenceInAnyGroups) {
    const Scene scene = depth_scene(331, 97, 16, Marking::zero, {3, 1});
    const StoredPlane plane = noisy_plane(scene, Fill::blob, 5);
    SurfaceFrame reference, frame;
    ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
    for (const std::uint32_t group_size : {1U, 32U, 64U, 250U})
        for (const std::uint32_t segment_texels : {0U, 4U, 20U})
            for (const bool along_x : {false, true}) {
                const SurfacePlan plan{group_size, segment_texels, along_x, false};
                auto builder = must(make_vulkan_builder(scene, test_kernels(), plan));
                ASSERT_TRUE(builder->build(plane.frame(), frame));
                EXPECT_EQ(first_difference(reference, frame), "") << plan_text(plan);
            }
}

/// More frames than are in flight, some of them in slots that hold another builder's; filters that remember
/// see them in order.
TEST(VulkanBuilder, KeepsFramesInFlightOrdered) {
    FilterSettings remembering{3, 1, TerraceRemoval::on};
    remembering.temporal = true;
    remembering.temporal_noise = {4, 0};
    for (const FilterSettings& filter : {FilterSettings{3, 0}, FilterSettings{0, 2}, remembering})
        for (const SurfacePlan& plan : all_plans) {
            const Scene scene = depth_scene(83, 45, 16, Marking::zero, filter);
            auto made = must(make_vulkan_builder(scene, test_kernels(), plan));
            SurfaceBuilder& builder = *made;
            EXPECT_EQ(builder.frames_in_flight(), 3);
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
                must(builder.finish(slots[n % 4]));
                EXPECT_EQ(first_difference(reference, slots[n % 4]), "")
                    << plan_text(plan) << ", frame " << n;
                // The frames before are not written over.
                if (n == 0 || FilterPlan(scene).remembers()) continue;
                EXPECT_EQ(reference_difference(scene, frame(n - 1), slots[(n - 1) % 4]), "")
                    << plan_text(plan);
            }
        }
}

/// With rows of every padding, in memory that is lent again. A block that is imported has an owner more.
TEST(VulkanBuilder, ReadsPlanesInPlace) {
    const SurfacePlan& plan = all_plans[2];
    for (const int width : {83, 96}) {
        const Scene scene = depth_scene(width, 31, 16, Marking::zero, {3, 0});
        auto made = must(make_vulkan_builder(scene, test_kernels(), plan));
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
            SurfaceFrame frame;
            ASSERT_TRUE(made->build(raw, frame));
            EXPECT_EQ(reference_difference(scene, raw, frame), "") << width << " wide, stride " << stride;
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

TEST(BuilderRace, RunsOncePerDevice) {
    const TemporaryFolder folder;
    GpuFacts::Measured first;
    {
        const auto device = seeming_card(folder.path());
        EXPECT_LT(device->facts().measured.cpu_ms, 0);
        measure_builders(device);
        first = device->facts().measured;
    }
    for (const double ms : {first.cpu_ms, first.vulkan_ms}) {
        EXPECT_GT(ms, 0);
        EXPECT_LT(ms, 60'000) << "with the right bits";
    }
    const auto again = seeming_card(folder.path());
    measure_builders(again);
    const GpuFacts::Measured& kept = again->facts().measured;
    EXPECT_EQ(kept.cpu_ms, first.cpu_ms);
    EXPECT_EQ(kept.vulkan_ms, first.vulkan_ms);
}

TEST(SurfacePlan, FollowsKindOfDevice) {
    GpuFacts facts = test_kernels()->device()->facts();
    EXPECT_FALSE(plan_for(facts).blocks) << "a software Vulkan";
    facts.kind = GpuKind::discrete;
    facts.unified_memory = false;
    EXPECT_TRUE(plan_for(facts).blocks && plan_for(facts).copies);
    facts.unified_memory = true;
    EXPECT_TRUE(plan_for(facts).blocks && !plan_for(facts).copies);
}

/// For every plan: a device whose limits just suffice makes the builder; one less of any limit refuses it.
TEST(VulkanBuilder, RejectsFramesBeyondDeviceLimits) {
    auto device = must(GpuDevice::open());
    const auto kernels = std::make_shared<SurfaceKernels>(device);
    const Scene scene = depth_scene(640, 400, 16, Marking::zero, {3, 0});
    constexpr std::uint32_t row_texels = 80, texels = row_texels * 400, strips = 200;
    GpuFacts::Limits& limits = device->vulkan()->facts.limits;
    const GpuFacts::Limits whole = limits;
    for (const SurfacePlan& plan : {all_plans[0], all_plans[1], plan_for(device->facts())}) {
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
            expect_error(made, ErrorKind::gpu, "640x400");
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

TEST(VulkanBuilder, ReportsItsStages) {
    EXPECT_EQ(stages_of({0, 0}), "decode bounds ");
    EXPECT_EQ(stages_of({3, 2}), "fill median bounds ");
    FilterSettings all{3, 1, TerraceRemoval::on};
    all.temporal = true;
    all.temporal_noise = {1, 0};
    EXPECT_EQ(stages_of(all), "fill median temporal terraces decode bounds ");
}

// Terrace removal on pictures of 8 bits: a level is 126 codes, the gate 157, no code moves by more than 126,
// and in the end codes are doubled. In what is worked out by hand, 0 is an invalid pixel.

using Codes = std::vector<std::uint16_t>;
constexpr FilterSettings removal{.terraces = TerraceRemoval::on};

StoredPlane stored_plane(const Scene& scene, const Codes& stored) {
    return store_plane(scene.width, scene.height, stored, {.bytes_per_sample = scene.depth_bits > 8 ? 2 : 1});
}

/// By every builder, which must agree.
std::unique_ptr<const SurfaceFrame> levelled(const Scene& scene, const Codes& stored) {
    const StoredPlane plane = stored_plane(scene, stored);
    auto made = std::make_unique<SurfaceFrame>();
    EXPECT_TRUE(make_reference_builder(scene)->build(plane.frame(), *made));
    EXPECT_EQ(BuilderComparison().difference(scene, plane.frame(), *made), "");
    return made;
}

Scene scene_of(int width, int height) {
    return depth_scene(width, height, 8, Marking::zero, removal);
}

void expect_levelled(int width, int height, const Codes& stored, const Codes& expected) {
    EXPECT_EQ(levelled(scene_of(width, height), stored)->codes, expected);
}

Codes finer(Codes codes) {
    for (auto& code : codes) code = static_cast<std::uint16_t>(code * 252);
    return codes;
}

/// `level` of each pixel.
template <class Level>
Codes picture(int width, int height, Level&& level) {
    Codes codes;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) codes.push_back(static_cast<std::uint16_t>(level(x, y)));
    return codes;
}

TEST(TerraceFilter, LeavesPlanesUntouched) {
    for (const auto& [a, b] : {std::pair{1, 2}, {0, 0}, {3, 0}, {-2, 4}}) {
        const Codes plane = picture(33, 29, [i = a, j = b](int x, int y) { return 100 + i * x + j * y; });
        expect_levelled(33, 29, plane, finer(plane));
    }
}

// Three pixels have pairs at distance 1 only, so two passes. The first: 10 + 11 levels - 2 x 10 = 126, within
// the gate: 2 x 126 + 8 over 16 is 16. The second: 1260 + 1386 - 2 x 1276 = 94: (2 x 94 + 4)/8 is 24, added
// to twice 1276.
TEST(TerraceFilter, SmoothsOneLevelSteps) {
    expect_levelled(3, 1, {10, 10, 11}, {2520, 2 * 1276 + 24, 2772});
    expect_levelled(1, 3, {10, 10, 11}, {2520, 2 * 1276 + 24, 2772});
}

// 252 is between the gate and twice it: what counts is 2 x 157 - 252 = 62, and (124 + 8)/16 is 8 at the foot;
// at the head (-124 + 8)/16, downward: -8. Then 1260 + 1504 - 2 x 1268 = 228, of which 86 count: (172 + 4)/8
// is 22; at the head (-172 + 4)/8: -21.
TEST(TerraceFilter, BarelySmoothsTwoLevelSteps) {
    expect_levelled(4, 1, {10, 10, 12, 12}, {2520, 2 * 1268 + 22, 2 * 1504 - 21, 3024});
}

TEST(TerraceFilter, KeepsThreeLevelSteps) {
    const Codes step = picture(40, 36, [](int x, int) { return x < 17 ? 10 : 13; });
    expect_levelled(40, 36, step, finer(step));
}

// Around the centre each pair has 2 x 11 - 2 x 10 levels = 252, of which 62 count, with weights 2 + 2 + 1 +
// 1: 380/16 is 23. Then 2 x 1386 - 2 x 1283 = 206, of which 108 count: 652/8 is 81. On the rim only pairs
// along it are inside, and those are flat.
TEST(TerraceFilter, WeighsDiagonalsHalf) {
    const Codes dent = {11, 11, 11,  //
                        11, 10, 11,  //
                        11, 11, 11};
    Codes expected = finer(dent);
    expected[4] = 2 * 1283 + 81;
    expect_levelled(3, 3, dent, expected);
}

// One diagonal alone: 10 + 11 - 2 x 10 levels, weight 1: (126 + 8)/16 is 8; then 1260 + 1386 - 2 x 1268 =
// 110: 14.
TEST(TerraceFilter, CountsEachDiagonal) {
    for (const bool rising : {false, true}) {
        Codes codes(9, 0);
        codes[4] = 10;
        codes[rising ? 2 : 0] = 10;
        codes[rising ? 6 : 8] = 11;
        Codes expected = finer(codes);
        expected[4] = 2 * 1268 + 14;
        expect_levelled(3, 3, codes, expected);
    }
}

TEST(TerraceFilter, IgnoresPairsWithInvalidPixel) {
    expect_levelled(3, 1, {0, 10, 11}, {0, 2520, 2772});
    expect_levelled(3, 1, {10, 0, 11}, {2520, 0, 2772});
    // At distance 2 the pair of the middle one is whole: 10 + 11 - 2 x 10 levels make 16 in its pass, the
    // last two find invalid neighbours.
    expect_levelled(5, 1, {10, 0, 10, 0, 11}, {2520, 0, 2 * 1276, 0, 2772});
}

TEST(TerraceFilter, KeepsSilhouettesUnchanged) {
    const Codes slopes = picture(48, 40, [](int x, int y) { return x + y < 44 ? 60 + x : 200 - y; });
    expect_levelled(48, 40, slopes, finer(slopes));
}

TEST(TerraceFilter, KeepsSpikes) {
    Codes codes(25 * 25, 40);
    codes[25 * 12 + 12] = 44;
    expect_levelled(25, 25, codes, finer(codes));
}

/// Farthest of the inner pixels from the plane that was quantised, in levels, at most.
double farthest_from_plane(const SurfaceFrame& frame, double level, double a, double b) {
    double farthest = 0;
    for (int y = 24; y < frame.height - 24; ++y)
        for (int x = 24; x < frame.width - 24; ++x) {
            const double code = frame.codes[frame.index(x, y)] / level;
            farthest = std::max(farthest, std::fabs(code - (40 + a * x + b * y)));
        }
    return farthest;
}

TEST(TerraceFilter, RestoresQuantisedPlanes) {
    for (const auto& [a, b] : {std::pair{0.125, 0.0}, std::pair{0.0, 0.25}, std::pair{0.19, 0.11}}) {
        Scene scene = scene_of(96, 96);
        const Codes stored =
            picture(96, 96, [i = a, j = b](int x, int y) { return std::lround(40 + i * x + j * y); });
        const auto made = levelled(scene, stored);
        const SurfaceFrame& frame = *made;
        EXPECT_LT(farthest_from_plane(frame, 252, a, b), 0.15);
        scene.filter = {};
        EXPECT_GT(farthest_from_plane(*levelled(scene, stored), 1, a, b), 0.4);
    }
}

/// Mean over the rows of the jump from column 47 to 48, in levels, on a slope that has a step there.
double jump_of_step(int levels) {
    const Codes stored = picture(
        96, 128, [&](int x, int y) { return std::lround(60 + 0.13 * x + 0.07 * y + (x < 48 ? 0 : levels)); });
    const auto made = levelled(scene_of(96, 128), stored);
    const SurfaceFrame& frame = *made;
    double sum = 0;
    for (int y = 20; y < 108; ++y)
        sum += (frame.codes[frame.index(48, y)] - frame.codes[frame.index(47, y)]) / 252.0;
    return sum / 88;
}

TEST(TerraceFilter, KeepsStepsOnSlopes) {
    EXPECT_GT(jump_of_step(3), 2.5);
    EXPECT_GT(jump_of_step(4), 3.8);
    for (const int levels : {6, 12, 100}) EXPECT_NEAR(jump_of_step(levels), levels + 0.13, 0.1) << levels;
}

// Second differences of these leave 16 bits.
TEST(TerraceFilter, KeepsLargestSteps) {
    for (const int period : {1, 2, 3, 9}) {
        Scene scene = depth_scene(53, 41, 8, Marking::none, removal);
        const Codes stored =
            picture(53, 41, [&](int x, int y) { return (x / period + y / period) % 2 == 0 ? 0 : 255; });
        for (const double noise : {0.0, 4.0}) {
            scene.filter.terrace_noise = noise;
            EXPECT_EQ(levelled(scene, stored)->codes, finer(stored));
        }
    }
}

TEST(TerraceFilter, LimitsMovesOfCodes) {
    Random random(8);
    for (const double noise : {0.0, 1.0, 4.0}) {
        Scene scene = scene_of(61, 45);
        scene.filter.terrace_noise = noise;
        const int most = terrace_filter(scene)->most_at(0);
        const Codes stored = picture(61, 45, [&](int x, int) { return 60 + x / 9 + random.below(6); });
        const auto made = levelled(scene, stored);
        const SurfaceFrame& frame = *made;
        int farthest = 0;
        for (std::size_t k = 0; k < stored.size(); ++k)
            farthest = std::max(farthest, std::abs(frame.codes[k] - 252 * stored[k]));
        EXPECT_LE(farthest, 2 * most);
        EXPECT_GT(farthest, 200);
    }
}

TEST(TerraceFilter, RefinesMillimetreCodes) {
    Scene scene = metric_scene(64, 40, {32, 32, 32, 20}, 4000);
    scene.filter = removal;
    scene.depth.near = 300;
    derive_valid_range(scene.depth);
    const Codes stored = picture(64, 40, [](int x, int y) { return 900 + (x + 2 * y) / 7; });
    const auto made = levelled(scene, stored);
    const SurfaceFrame& frame = *made;
    EXPECT_EQ(frame.coding.scale, 1.0 / 16);
    EXPECT_EQ(frame.codes[frame.index(0, 0)] >> 4, 900);
    EXPECT_NE(frame.codes[frame.index(32, 20)] & 15, 0);
}

TEST(TerraceFilter, ChangesNothingWithoutRoom) {
    for (const auto terraces : {TerraceRemoval::automatic, TerraceRemoval::off}) {
        const Scene scene = depth_scene(40, 30, 16, Marking::zero, {.terraces = terraces});
        const Codes stored = picture(40, 30, [](int x, int y) { return 900 + (x + 2 * y) / 7; });
        EXPECT_EQ(levelled(scene, stored)->codes, stored);
    }
}

// Terrace removal that reaches farther than 16 pixels: contours of large pictures of few levels.

constexpr int reaches[] = {16, 32, 64, 128};

FilterSettings removal_within(int reach) {
    return {.terraces = TerraceRemoval::on, .terrace_reach = reach};
}

/// By hand: half of the reach, and halves of that.
TEST(WideTerraceFilter, HalvesTapsEachPass) {
    const std::vector<int> taps[] = {
        {8, 4, 2, 1, 1}, {16, 8, 4, 2, 1, 1}, {32, 16, 8, 4, 2, 1, 1}, {64, 32, 16, 8, 4, 2, 1, 1}};
    for (std::size_t n = 0; n < std::size(reaches); ++n) {
        const auto filter = terrace_filter(depth_scene(40, 30, 8, Marking::none, removal_within(reaches[n])));
        ASSERT_TRUE(filter);
        std::vector<int> passes;
        int sum = 0;
        for (int pass = 0; pass < filter->passes(); ++pass) {
            passes.push_back(filter->tap_of(pass));
            sum += passes.back();
        }
        EXPECT_EQ(passes, taps[n]);
        EXPECT_EQ(sum, reaches[n]);
        EXPECT_LE(filter->passes(), most_terrace_passes);
    }
}

/// All builders on one picture, at one reach.
void expect_same_bits(const Scene& scene, Fill fill, std::uint64_t seed) {
    Random random(seed);
    const Codes stored = fill_picture(scene, fill, random);
    const auto made = levelled(scene, stored);
    SurfaceFrame cpu;
    for (const VectorUnit unit : usable_vector_units()) {
        ASSERT_TRUE(make_cpu_builder(scene, {3, unit})->build(stored_plane(scene, stored).frame(), cpu));
        ASSERT_EQ(first_difference(*made, cpu), "") << "3 threads";
    }
}

TEST(WideTerraceFilter, AgreesAcrossBuilders) {
    constexpr std::pair<int, int> sizes[] = {{1, 1}, {7, 150}, {150, 7}, {129, 33}, {64, 64}, {203, 141}};
    constexpr Fill fills[] = {Fill::ramp,       Fill::random,   Fill::few_holes,   Fill::blob,
                              Fill::half_holes, Fill::extremes, Fill::silhouettes, Fill::slanted_edges};
    std::uint64_t seed = 1;
    for (const int reach : reaches)
        for (const auto& [width, height] : sizes)
            for (const Fill fill : fills) {
                if (++seed % std::min<std::size_t>(sweep_step(), 3) != 0) continue;
                FilterSettings filter = removal_within(reach);
                if (seed % 4 == 0) filter.levels = {seed % 8 == 0 ? 6.0 : 0.0, 3e-6};
                if (seed % 5 == 0) filter.terrace_noise = 1;
                if (seed % 6 == 0) filter.median = 3;
                SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height) + ", reach " +
                             std::to_string(reach) + ", seed " + std::to_string(seed));
                expect_same_bits(
                    depth_scene(width, height, seed % 3 == 0 ? 16 : 8, all_markings[seed % 4], filter), fill,
                    seed);
                if (HasFailure()) return;
            }
}

/// A hill of hundreds of pixels, in levels.
double hill(double x, double y) {
    const double u = (x - 330) / 260, v = (y - 250) / 210;
    return 100 + 9 * std::exp(-u * u - v * v) + 0.004 * x;
}

constexpr int hill_width = 640, hill_height = 480;

int at(const std::vector<std::uint16_t>& codes, int x, int y) {
    return codes[static_cast<std::size_t>(y * hill_width + x)];
}

/// A picture's codes with terraces removed, by the CPU builder.
std::vector<std::uint16_t> wide_levelled(const FilterSettings& filter,
                                         const std::function<double(int, int)>& stored) {
    const Scene scene = depth_scene(hill_width, hill_height, 8, Marking::none, filter);
    const Codes codes =
        picture(hill_width, hill_height, [&](int x, int y) { return std::lround(stored(x, y)); });
    SurfaceFrame frame;
    EXPECT_TRUE(make_cpu_builder(scene)->build(
        store_plane(hill_width, hill_height, codes, {.bytes_per_sample = 1}).frame(), frame));
    return {frame.codes.begin(), frame.codes.end()};
}

/// RMS, degrees, of faces against those of the hill, where a level is `kappa` pixels' widths deep;
/// `per_level`: the frame's codes.
double faces_off_deg(const std::vector<std::uint16_t>& codes, double per_level, double kappa) {
    const auto code = [&](int x, int y) { return at(codes, x, y) / per_level; };
    double sum = 0;
    int faces = 0;
    for (int y = 0; y + 1 < hill_height; y += 3)
        for (int x = 0; x + 1 < hill_width; x += 3) {
            const double ax = kappa * (code(x + 1, y) - code(x, y)),
                         ay = kappa * (code(x, y + 1) - code(x, y));
            const double bx = kappa * (hill(x + 1, y) - hill(x, y)),
                         by = kappa * (hill(x, y + 1) - hill(x, y));
            const double cosine =
                (ax * bx + ay * by + 1) / std::sqrt((ax * ax + ay * ay + 1) * (bx * bx + by * by + 1));
            const double angle = std::acos(std::min(cosine, 1.0)) * 57.29577951308232;
            sum += angle * angle;
            ++faces;
        }
    return std::sqrt(sum / faces);
}

TEST(WideTerraceFilter, RestoresNormalsOfHill) {
    const auto off = [](int reach) {
        return faces_off_deg(wide_levelled(removal_within(reach), hill), 252, 6);
    };
    EXPECT_GT(off(16), 6);
    EXPECT_LT(off(64), 2.5);
    EXPECT_LT(off(128), 2.3);
}

/// Mean over the rows of the jump from column 319 to 320, in levels, on a slope with contours of 77 pixels.
double jump_of_wide_step(int levels, int reach) {
    const std::vector<std::uint16_t> made = wide_levelled(removal_within(reach), [&](int x, int y) {
        return 60 + 0.013 * x + 0.007 * y + (x < 320 ? 0 : levels);
    });
    double sum = 0;
    for (int y = 130; y < hill_height - 130; ++y) sum += (at(made, 320, y) - at(made, 319, y)) / 252.0;
    return sum / (hill_height - 260);
}

TEST(WideTerraceFilter, KeepsThreeLevelSteps) {
    for (const int reach : reaches) {
        EXPECT_GT(jump_of_wide_step(3, reach), 2.6) << reach;
        EXPECT_GT(jump_of_wide_step(4, reach), 3.8) << reach;
        for (const int levels : {6, 12}) EXPECT_NEAR(jump_of_wide_step(levels, reach), levels, 0.1) << reach;
    }
}

/// Levels of four codes, and between them ramps of three pixels, as phones enlarge their depth.
double enlarged(int x, int y) {
    double sum = 0;
    for (int dx = -1; dx <= 1; ++dx) sum += std::round(hill(x + dx, y) / 4) * 4;
    return sum / 3;
}

TEST(WideTerraceFilter, RemovesFourCodeLevels) {
    FilterSettings filter = removal_within(128);
    const Scene scene = depth_scene(hill_width, hill_height, 8, Marking::none, {});
    const auto off = [&] {
        const Scene filtered = depth_scene(hill_width, hill_height, 8, Marking::none, filter);
        return faces_off_deg(wide_levelled(filter, enlarged), 2.0 * terrace_filter(filtered)->working.factor,
                             6);
    };
    const double as_codes = off();
    filter.levels = code_step(scene.depth).times(4);
    const double as_levels = off();
    EXPECT_GT(as_codes, 13);
    EXPECT_LT(as_levels, 6);
}

}  // namespace
}  // namespace touchable::test
