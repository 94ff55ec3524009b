#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>

#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"

// A builder that builds only what has changed leaves in every slot the bits of the whole frame.
namespace touchable::test {
namespace {

enum class Edit { none, pixel, row, column, corner, border, flicker, patch, scattered, all };
constexpr int edit_count = static_cast<int>(Edit::all) + 1;

/// A clip of depth, haptic and height planes that changes a little from frame to frame.
class Film {
public:
    Film(const Scene& scene, std::uint64_t seed)
        : scene_(scene),
          random_(seed),
          codes_(fill_picture(scene, seed % 2 == 0 ? Fill::ramp : Fill::few_holes, random_)) {
        haptic_.assign(codes_.size() * 3, 9);
        heights_.assign(codes_.size(), 4);
    }

    void edit(Edit edit) {
        const int width = scene_.width, height = scene_.height;
        const int x = random_.below(width), y = random_.below(height);
        const int column = std::min(x / 32 * 32 + 31 * random_.below(2), width - 1),
                  row = std::min(y / 16 * 16 + 15 * random_.below(2), height - 1);
        switch (edit) {
            case Edit::none:
                break;
            case Edit::pixel:
                change({x, y, x + 1, y + 1});
                break;
            case Edit::row:
                change({0, row, width, row + 1});
                break;
            case Edit::column:
                change({column, 0, column + 1, height});
                break;
            case Edit::corner:
                change({column, row, column + 1, row + 1});
                break;
            case Edit::border:
                change({0, 0, width, 1});
                change({width - 1, 0, width, height});
                break;
            case Edit::flicker:
                at(x, y) = scene_.depth.is_valid(at(x, y)) ? 0 : some_code();
                break;
            case Edit::patch:
                flatten(std::max(x / 32 * 32 + random_.below(5) - 2, 0),
                        std::max(y / 16 * 16 + random_.below(5) - 2, 0));
                break;
            case Edit::scattered:
                for (int n = 0; n < 4; ++n) this->edit(Edit::pixel);
                break;
            case Edit::all:
                change({0, 0, width, height});
                break;
        }
        if (random_.below(6) == 0) haptic_[static_cast<std::size_t>(random_.below(width * height))] ^= 1;
        if (random_.below(6) == 0) heights_[static_cast<std::size_t>(random_.below(width * height))] ^= 1;
    }
    Edit any_edit() {
        return random_.below(40) == 0 ? Edit::all : static_cast<Edit>(random_.below(edit_count - 1));
    }
    int below(int n) { return random_.below(n); }

    /// In memory of its own, as awkward as a decoder's.
    RawFrame frame() {
        struct Planes {
            StoredPlane depth, haptic, height;
        };
        const int width = scene_.width, height = scene_.height, bytes = scene_.depth_bits / 8;
        auto planes = std::make_shared<Planes>();
        const auto layout = [&](int of_sample) {
            return Layout{of_sample, random_.below(3), random_.below(4) == 0};
        };
        planes->depth = store_plane(width, height, codes_, layout(bytes));
        planes->haptic = store_plane(3 * width, height, haptic_, layout(1));
        planes->height = store_plane(width, height, heights_, layout(1));
        RawFrame raw = planes->depth.frame();
        raw.haptic = planes->haptic.view;
        raw.haptic.width = width;
        raw.haptic.channels = 3;
        raw.height = planes->height.view;
        raw.storage = std::move(planes);
        return raw;
    }

private:
    std::uint16_t& at(int x, int y) {
        return codes_[static_cast<std::size_t>(y) * static_cast<std::size_t>(scene_.width) +
                      static_cast<std::size_t>(x)];
    }
    std::uint16_t some_code() { return static_cast<std::uint16_t>(random_.below(1 << scene_.depth_bits)); }
    struct Box {
        int left, top, right, bottom;
    };
    void change(const Box& box) {
        for (int y = box.top; y < box.bottom; ++y)
            for (int x = box.left; x < box.right; ++x) at(x, y) = some_code();
    }

    /// A step near a block's corner, which bounds of all tiles around it show.
    void flatten(int left, int top) {
        const std::uint16_t code = random_.below(2) == 0 ? scene_.depth.valid_max : scene_.depth.valid_min;
        for (int y = top; y < std::min(top + 20, scene_.height); ++y)
            for (int x = left; x < std::min(left + 40, scene_.width); ++x) at(x, y) = code;
    }

    const Scene scene_;
    Random random_;
    std::vector<std::uint16_t> codes_, haptic_, heights_;
};

std::string difference(const SurfaceFrame& expected, const SurfaceFrame& actual) {
    if (const std::string codes = first_difference(expected, actual); !codes.empty()) return codes;
    if (expected.haptic != actual.haptic || expected.heights != actual.heights) return "touch planes differ";
    if (actual.vertices->read_from() != &actual) return "vertices read another frame";
    return {};
}

constexpr FilterSettings filters[] = {{0, 0},
                                      {3, 0},
                                      {5, 0},
                                      {0, 2},
                                      {3, 1},
                                      {5, 5},
                                      {0, 0, TerraceRemoval::on},
                                      {3, 2, TerraceRemoval::on},
                                      {.terraces = TerraceRemoval::on, .terrace_reach = 32}};

std::string text(const FilterSettings& filter) {
    return "median " + std::to_string(filter.median) + ", fill_holes " + std::to_string(filter.fill_holes) +
           (filter.terraces == TerraceRemoval::on ? ", terraces removed" : "");
}

/// In part wherever it is known what has changed, even where that takes longer.
constexpr CpuPlan in_part{.threads = 1, .break_even = 1e9};

class ChangedFrames : public testing::TestWithParam<FilterSettings> {};

TEST_P(ChangedFrames, HaveTheBitsOfWholeOnes) {
    for (int kind = 0; kind < edit_count; ++kind)
        for (const Marking marking : {Marking::zero, Marking::largest}) {
            const Scene scene = depth_scene(107, 70, 8, marking, GetParam());
            Film film(scene, 11 + static_cast<std::uint64_t>(kind));
            const auto builder = make_cpu_builder(scene, in_part), obvious = make_reference_builder(scene);
            SurfaceFrame slot, whole;
            ASSERT_TRUE(builder->build(film.frame(), slot));
            EXPECT_EQ(builder->built_share(), 1);
            for (int n = 0; n < 2; ++n) {
                film.edit(static_cast<Edit>(kind));
                const RawFrame raw = film.frame();
                ASSERT_TRUE(builder->build(raw, slot));
                ASSERT_TRUE(obvious->build(raw, whole));
                ASSERT_EQ(difference(whole, slot), "") << text(GetParam()) << ", edit " << kind;
            }
            const Edit edit = static_cast<Edit>(kind);
            EXPECT_EQ(builder->built_share() == 0, edit == Edit::none);
            const bool small = edit == Edit::pixel || edit == Edit::corner || edit == Edit::flicker;
            EXPECT_TRUE(!small || builder->built_share() < 1);
            EXPECT_TRUE(edit != Edit::all || builder->built_share() == 1);
        }
}

using Slots = std::array<std::unique_ptr<SurfaceFrame>, 4>;
Slots fresh_slots() {
    Slots slots;
    for (auto& slot : slots) slot = std::make_unique<SurfaceFrame>();
    return slots;
}

/// Slots come back in any order, after any number of frames, and between times others build into them.
TEST_P(ChangedFrames, HaveThemInSlotsOfAnyAge) {
    int patched = 0, whole_again = 0;
    for (const auto& [width, height] : {std::pair{171, 130}, {33, 17}, {64, 90}})
        for (const int threads : {1, 2}) {
            const int bits = GetParam().terraces == TerraceRemoval::on ? 8 : 16;
            const Scene scene = depth_scene(width, height, bits, Marking::zero, GetParam());
            Film film(scene, static_cast<std::uint64_t>(width + threads));
            CpuPlan plan = in_part;
            plan.threads = threads;
            const auto builder = make_cpu_builder(scene, plan), twin = make_cpu_builder(scene, in_part);
            Slots slots = fresh_slots();
            for (int n = 0; n < 60; ++n) {
                film.edit(film.any_edit());
                RawFrame raw = film.frame();
                if (film.below(12) == 0) raw.storage = nullptr;  // and the memory is gone after this round
                const RawFrame held = film.frame();
                if (!raw.storage) raw.depth = held.depth, raw.haptic = held.haptic, raw.height = held.height;
                // As a timeline does, mostly the slot before last.
                std::unique_ptr<SurfaceFrame>& slot =
                    slots[static_cast<std::size_t>(film.below(3) > 0 ? n % 2 : film.below(4))];
                const int other = film.below(20);
                ASSERT_TRUE(other != 0 || twin->build(raw, *slot));
                ASSERT_TRUE(other != 1 || make_lazy_builder(scene)->build(raw, *slot));
                if (other == 2) slot = std::make_unique<SurfaceFrame>();
                if (other == 4) std::swap(slots[0], slots[1]);
                if (other == 3) continue;  // a frame that this builder never sees
                ASSERT_TRUE(builder->build(raw, *slot));
                SurfaceFrame whole;
                ASSERT_TRUE(make_cpu_builder(scene, {1})->build(raw, whole));
                ASSERT_EQ(difference(whole, *slot), "")
                    << text(GetParam()) << ", " << width << "x" << height << ", frame " << n;
                patched += builder->built_share() < 1;
                whole_again += n > 4 && builder->built_share() == 1;
            }
        }
    EXPECT_GT(patched, 50);
    EXPECT_GT(whole_again, 20);
}

/// Planes are uploaded as a whole or in part; and what kernels leave for the next frame is of another slot.
TEST(ChangedFramesByVulkan, HaveTheBitsOfWholeOnes) {
    int patched = 0, whole_again = 0, nothing = 0;
    for (const int median : {0, 3, 5})
        for (const auto& [width, height] : {std::pair{171, 130}, {64, 70}})
            for (SurfacePlan plan : all_plans) {
                plan.break_even = 1;
                const Scene scene = depth_scene(width, height, 16, Marking::zero, {median, 0});
                Film film(scene, static_cast<std::uint64_t>(width + median));
                auto builder = make_vulkan_builder(scene, test_kernels(), plan),
                     twin = make_vulkan_builder(scene, test_kernels(), plan);
                ASSERT_TRUE(builder && twin);
                Slots slots = fresh_slots();
                for (int n = 0; n < 25; ++n) {
                    film.edit(film.any_edit());
                    const RawFrame raw = film.frame();
                    std::unique_ptr<SurfaceFrame>& slot =
                        slots[static_cast<std::size_t>(film.below(3) > 0 ? n % 2 : film.below(4))];
                    const int other = film.below(20);
                    ASSERT_TRUE(other != 0 || (*twin)->build(raw, *slot));
                    ASSERT_TRUE(other != 1 || make_cpu_builder(scene, in_part)->build(raw, *slot));
                    if (other == 2) slot = std::make_unique<SurfaceFrame>();
                    if (other == 4) std::swap(slots[0], slots[1]);
                    if (other == 3) continue;
                    ASSERT_TRUE((*builder)->build(raw, *slot));
                    SurfaceFrame whole;
                    ASSERT_TRUE(make_cpu_builder(scene, {1})->build(raw, whole));
                    ASSERT_EQ(difference(whole, *slot), "")
                        << "median " << median << ", " << plan_text(plan) << ", " << width << "x" << height
                        << ", frame " << n;
                    const double share = (*builder)->built_share();
                    patched += share > 0 && share < 1;
                    whole_again += n > 4 && share == 1;
                    nothing += share == 0;
                }
            }
    EXPECT_GT(patched, 50);
    EXPECT_GT(whole_again, 50);
    EXPECT_GT(nothing, 0);
}

/// Rows are uploaded in part from planes of whatever stride, over what was uploaded from another.
TEST(ChangedFramesByVulkan, ReadNoRowThatIsOlderThanTheSlot) {
    const Scene scene = depth_scene(64, 70, 16, Marking::zero, {3, 0});
    Random random(1);
    std::vector<std::uint16_t> codes = fill_picture(scene, Fill::random, random);
    const auto frame = [&](int padding) {
        auto memory = std::make_shared<const StoredPlane>(store_plane(64, 70, codes, {2, padding, false}));
        RawFrame raw = memory->frame();
        raw.storage = memory;
        return raw;
    };
    auto builder = make_vulkan_builder(scene, test_kernels(), all_plans[0]);
    ASSERT_TRUE(builder);
    SurfaceFrame slot, whole;
    ASSERT_TRUE((*builder)->build(frame(2), slot));
    for (int x = 0; x < 64; ++x) codes[static_cast<std::size_t>(15 * 64 + x)] ^= 0x4000;
    ASSERT_TRUE((*builder)->build(frame(0), slot));
    codes[20 * 64 + 40] ^= 0x4000;
    const RawFrame last = frame(2);
    ASSERT_TRUE((*builder)->build(last, slot));
    EXPECT_LT((*builder)->built_share(), 0.2);
    ASSERT_TRUE(make_reference_builder(scene)->build(last, whole));
    EXPECT_EQ(first_difference(whole, slot), "");
}

INSTANTIATE_TEST_SUITE_P(Filters, ChangedFrames, testing::ValuesIn(filters), [](const auto& test) {
    return "Median" + std::to_string(test.param.median) + "Fill" + std::to_string(test.param.fill_holes) +
           (test.param.terraces == TerraceRemoval::on ? "Terraces" : "") +
           (test.param.terrace_reach > 16 ? std::to_string(test.param.terrace_reach) : "");
});

TEST(ChangedHue, HasTheBitsOfTheWholeFrame) {
    Scene scene = depth_scene(130, 70, 8, Marking::none, {3, 1});
    scene.depth.kind = DepthCodingKind::hue;
    scene.depth.code_max = 1535;
    derive_valid_range(scene.depth);
    Random random(8);
    std::vector<std::uint16_t> samples(130 * 70 * 3);
    for (std::uint16_t& sample : samples) sample = static_cast<std::uint16_t>(random.below(256));
    const auto builder = make_cpu_builder(scene, in_part);
    SurfaceFrame slot;
    for (int n = 0; n < 30; ++n) {
        for (int k = random.below(4); k > 0; --k)
            samples[static_cast<std::size_t>(random.below(130 * 70 * 3))] ^= 255;
        auto memory = std::make_shared<StoredPlane>(store_plane(130 * 3, 70, samples, {1, n % 2, false}));
        RawFrame raw = memory->frame();
        raw.depth.width = 130;
        raw.depth.channels = 3;
        raw.storage = memory;
        ASSERT_TRUE(builder->build(raw, slot));
        SurfaceFrame whole;
        ASSERT_TRUE(make_reference_builder(scene)->build(raw, whole));
        ASSERT_EQ(first_difference(whole, slot), "") << n;
        EXPECT_EQ(builder->built_share() == 1, n == 0);
    }
}

}  // namespace
}  // namespace touchable::test
