// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

#include "engine/base/same_bits.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/real_data.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"

namespace touchable::test {
namespace {

std::vector<std::unique_ptr<SurfaceBuilder>> all_builders(const Scene& scene) {
    std::vector<std::unique_ptr<SurfaceBuilder>> builders;
    builders.push_back(make_reference_builder(scene));
    builders.push_back(make_cpu_builder(scene));
    builders.push_back(make_lazy_builder(scene));
    builders.push_back(test_vulkan_builder(scene));
    return builders;
}

/// A frame with all planes of width x height.
struct FullFrame {
    std::vector<std::uint8_t> colour, haptic;
    std::vector<std::uint8_t> depth, height;
    RawFrame raw;

    FullFrame(int width, int rows) {
        const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(rows);
        colour.assign(3 * pixels, 1);
        haptic.resize(3 * pixels);
        for (std::size_t n = 0; n < haptic.size(); ++n) haptic[n] = static_cast<std::uint8_t>(7 * n);
        depth.assign(2 * pixels, 3);
        height.resize(pixels);
        for (std::size_t n = 0; n < pixels; ++n) height[n] = static_cast<std::uint8_t>(5 * n);
        raw.number = 12;
        raw.depth = {depth.data(), 2 * width, width, rows, 2, 1};
        raw.colour = {colour.data(), 3 * width, width, rows, 1, 3};
        raw.haptic = {haptic.data(), 3 * width, width, rows, 1, 3};
        raw.height = {height.data(), width, width, rows, 1, 1};
    }
};

TEST(Builders, CopyTouchPlanesUnfiltered) {
    const Scene scene = depth_scene(19, 7, 16, Marking::zero, {5, 2});
    FullFrame full(19, 7);
    for (const auto& builder : all_builders(scene)) {
        SurfaceFrame frame;
        ASSERT_TRUE(builder->build(full.raw, frame)) << builder->name();
        EXPECT_EQ(frame.haptic, full.haptic) << builder->name();
        EXPECT_EQ(frame.heights, std::vector<std::uint16_t>(full.height.begin(), full.height.end()));
        full.raw.haptic = full.raw.height = {};
        ASSERT_TRUE(builder->build(full.raw, frame));
        EXPECT_TRUE(frame.haptic.empty() && frame.heights.empty()) << builder->name();
        full = FullFrame(19, 7);
    }
}

TEST(Builders, RejectMismatchedPlanes) {
    const Scene scene = depth_scene(19, 7, 16, Marking::zero);
    const auto expect_refused = [&](const char* what, auto&& spoil) {
        for (const auto& builder : all_builders(scene)) {
            FullFrame full(19, 7);
            SurfaceFrame frame;
            ASSERT_TRUE(builder->build(full.raw, frame));
            const FrameArray<std::uint16_t> codes = frame.codes;
            spoil(full.raw);
            const Result<void> refused = builder->build(full.raw, frame);
            expect_error(refused, ErrorKind::input, "frame 12");
            EXPECT_NE(refused.error().message.find(what), std::string::npos) << refused.error().message;
            EXPECT_EQ(frame.codes, codes) << "the slot was touched";
            EXPECT_EQ(frame.width, 19);
        }
    };
    expect_refused("no depth plane", [](RawFrame& raw) { raw.depth = {}; });
    expect_refused("depth plane is 18x7, the scene says 19x7", [](RawFrame& raw) { raw.depth.width = 18; });
    expect_refused("depth plane is 19x8", [](RawFrame& raw) { raw.depth.height = 8; });
    expect_refused("depth plane has 3 channels", [](RawFrame& raw) { raw.depth.channels = 3; });
    expect_refused("depth plane has samples of 8 bits",
                   [](RawFrame& raw) { raw.depth.bytes_per_sample = 1; });
    expect_refused("depth plane has rows of 38 bytes", [](RawFrame& raw) { raw.depth.stride = 37; });
    expect_refused("colour plane is 19x6", [](RawFrame& raw) { raw.colour.height = 6; });
    expect_refused("haptic plane is 20x7", [](RawFrame& raw) { raw.haptic.width = 20; });
    expect_refused("haptic plane has 1 channels", [](RawFrame& raw) { raw.haptic.channels = 1; });
    expect_refused("haptic plane has samples of 16 bits",
                   [](RawFrame& raw) { raw.haptic.bytes_per_sample = 2; });
    expect_refused("height plane is 1x7", [](RawFrame& raw) { raw.height.width = 1; });
}

TEST(Builders, ReuseAnySlot) {
    Random random(3);
    SurfaceFrame slot;
    std::string last;
    for (int round = 0; round < 60; ++round) {
        const Scene scene = depth_scene(1 + random.below(70), 1 + random.below(50), 16, Marking::zero,
                                        {random.below(2) * 3, random.below(3)});
        const StoredPlane plane = noisy_plane(scene, Fill::few_holes, random.next());
        SurfaceFrame reference;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
        const auto builder = std::move(all_builders(scene)[static_cast<std::size_t>(random.below(4))]);
        ASSERT_TRUE(builder->build(plane.frame(), slot));
        last = std::string(builder->name());
        EXPECT_EQ(first_vertex_difference(reference, *slot.vertices), "") << round << ": " << last;
        EXPECT_EQ(first_tile_not_enclosed(reference, *slot.vertices), "") << round << ": " << last;
        if (last != "lazy") {
            EXPECT_EQ(first_difference(reference, slot), "") << round << ": " << last;
            EXPECT_TRUE(slot.raw.depth.empty()) << "a filtered frame must not hold on to the raw one";
        } else {
            EXPECT_TRUE(slot.codes.empty() && slot.validity.empty() && slot.tiles.empty());
        }
    }
}

// A builder that builds only what has changed leaves in every slot the bits of the whole frame.

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

TEST_P(ChangedFrames, EqualWholeBuilds) {
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

/// The slot to build a frame into next: mostly the one before last, as a timeline does. Between times other
/// builders use slots, or one is replaced, and a frame may never be seen: then there is none.
SurfaceFrame* next_slot(Film& film, Slots& slots, int n, const RawFrame& raw, SurfaceBuilder& twin,
                        SurfaceBuilder& other) {
    std::unique_ptr<SurfaceFrame>& slot =
        slots[static_cast<std::size_t>(film.below(3) > 0 ? n % 2 : film.below(4))];
    const int what = film.below(20);
    EXPECT_TRUE(what > 1 || (what == 0 ? twin : other).build(raw, *slot));
    if (what == 2) slot = std::make_unique<SurfaceFrame>();
    if (what == 4) std::swap(slots[0], slots[1]);
    return what == 3 ? nullptr : slot.get();
}

TEST_P(ChangedFrames, EqualWholeInOldSlots) {
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
                SurfaceFrame* const slot = next_slot(film, slots, n, raw, *twin, *make_lazy_builder(scene));
                if (!slot) continue;
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

INSTANTIATE_TEST_SUITE_P(Filters, ChangedFrames, testing::ValuesIn(filters), [](const auto& test) {
    return "Median" + std::to_string(test.param.median) + "Fill" + std::to_string(test.param.fill_holes) +
           (test.param.terraces == TerraceRemoval::on ? "Terraces" : "") +
           (test.param.terrace_reach > 16 ? std::to_string(test.param.terrace_reach) : "");
});

TEST(ChangedHue, EqualsWholeBuild) {
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
        ASSERT_EQ(reference_difference(scene, raw, slot), "") << n;
        EXPECT_EQ(builder->built_share() == 1, n == 0);
    }
}

// Rows are whole texels, so that a software Vulkan reads planes where they lie.
const Scene stored_scene = depth_scene(72, 45, 16, Marking::zero, {3, 1});

RawFrame stored(std::int64_t number) {
    Random random(static_cast<std::uint64_t>(number) + 1);
    const auto plane = std::make_shared<StoredPlane>(store_plane(
        stored_scene.width, stored_scene.height, fill_picture(stored_scene, Fill::blob, random), {}));
    RawFrame raw = plane->frame();
    raw.number = number;
    raw.storage = plane;
    return raw;
}

/// Builds frame `number` into `slot`, and fails the test where it is not as the reference's.
void expect_built(SurfaceBuilder& builder, std::int64_t number, SurfaceFrame& slot) {
    must(builder.build(stored(number), slot));
    EXPECT_EQ(reference_difference(stored_scene, stored(number), slot), "") << number;
    EXPECT_EQ(first_vertex_difference(slot, *slot.vertices), "") << number;
}

class FallbackBuilder : public testing::Test {
protected:
    /// With the CPU builder as second.
    void use(std::unique_ptr<SurfaceBuilder> first) {
        builder = make_fallback_builder(std::move(first), make_cpu_builder(stored_scene),
                                        [this](const std::string& line) { told.push_back(line); });
    }
    void expect_told_of_frame_4() const {
        ASSERT_EQ(told.size(), 1U);
        EXPECT_EQ(told[0].rfind("frame 4: ", 0), 0U) << told[0];
    }

    std::vector<std::string> told;
    std::unique_ptr<SurfaceBuilder> builder;
};

void expect_reference(std::int64_t number, const SurfaceFrame& slot) {
    EXPECT_EQ(reference_difference(stored_scene, stored(number), slot), "") << number;
}

TEST_F(FallbackBuilder, SwitchesAtFailedFrame) {
    use(std::make_unique<FailingBuilder>(stored_scene, 3, Error{ErrorKind::gpu, "the cable is out"}));
    SurfaceFrame slots[2];
    for (std::int64_t number = 0; number < 8; ++number) {
        EXPECT_EQ(builder->name(), number <= 3 ? "failing" : "cpu");
        expect_built(*builder, number, slots[number % 2]);
    }
    EXPECT_EQ(told, std::vector<std::string>{"frame 3: the cable is out; the cpu builder goes on"});
}

TEST_F(FallbackBuilder, PassesOnOtherErrors) {
    use(std::make_unique<FailingBuilder>(stored_scene, 0, Error{ErrorKind::input, "no such plane"}));
    SurfaceFrame slot;
    const auto built = builder->build(stored(0), slot);
    ASSERT_FALSE(built);
    EXPECT_EQ(built.error().kind, ErrorKind::input);
    EXPECT_EQ(builder->name(), "failing");
    EXPECT_TRUE(told.empty());
}

TEST_F(FallbackBuilder, SurvivesLostGpu) {
    const auto device = must(GpuDevice::open());  // of its own, to be lost
    use(must(make_vulkan_builder(stored_scene, device)));
    SurfaceFrame slots[3];
    for (std::int64_t number = 0; number < 9; ++number) {
        if (number == 4) device->lose();
        expect_built(*builder, number, slots[number % 3]);
        EXPECT_EQ(builder->name(), number < 4 ? "vulkan" : "cpu");
        // The lost device's frames, which the solver still reads, stay as they were.
        if (number == 4)
            for (const std::int64_t earlier : {2, 3}) expect_reference(earlier, slots[earlier % 3]);
    }
    expect_told_of_frame_4();
}

/// Three are in flight when the GPU is lost, and none is.
TEST_F(FallbackBuilder, RebuildsFramesInFlight) {
    const auto device = must(GpuDevice::open());
    use(must(make_vulkan_builder(stored_scene, std::make_shared<SurfaceKernels>(device), all_plans[2])));
    EXPECT_EQ(builder->frames_in_flight(), 3);
    SurfaceFrame slot;
    std::int64_t begun = 0;
    for (std::int64_t number = 0; number < 9; ++number) {
        for (; begun < number + builder->frames_in_flight() && begun < 9; ++begun)
            ASSERT_TRUE(builder->begin(stored(begun)));
        if (number == 4) device->lose();
        ASSERT_TRUE(builder->finish(slot));
        expect_reference(number, slot);
        EXPECT_EQ(builder->name(), number < 4 ? "vulkan" : "cpu");
    }
    expect_told_of_frame_4();
}

TEST_F(FallbackBuilder, SurvivesHungGpu) {
    auto device = must(GpuDevice::open());
    use(must(make_vulkan_builder(stored_scene, device)));
    SurfaceFrame slots[3];
    for (std::int64_t number = 0; number < 3; ++number) expect_built(*builder, number, slots[number]);
    Blockade blockade(*device);
    device->set_patience(std::chrono::milliseconds(20));
    device.reset();  // the builder's alone, and so destroyed when that gives up
    for (std::int64_t number = 3; number < 9; ++number) expect_built(*builder, number, slots[number % 3]);
    EXPECT_EQ(builder->name(), "cpu");
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("is given up; the cpu builder goes on"), std::string::npos) << told[0];
    // If the GPU goes on after all, it writes what is not read any more.
    blockade.lift();
    for (std::int64_t number = 6; number < 9; ++number) expect_reference(number, slots[number % 3]);
    EXPECT_TRUE(GpuDevice::open());  // frees what was left behind
}

// Depth stored as hue: every builder gives the bits of the reference, which are those of the same codes
// stored as grey.

Scene hue_scene(int width, int height, FilterSettings filter) {
    Scene scene = depth_scene(width, height, 8, Marking::none, filter);
    scene.depth.kind = DepthCodingKind::hue;
    scene.depth.near_is_high = false;
    scene.depth.code_max = 1488;
    scene.depth.least_sum = 77;
    scene.depth.invalid_codes = {700};
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    return scene;
}

/// The same codes as 16-bit grey; what is no hue is 65535.
Scene grey_scene(Scene scene) {
    scene.depth.kind = DepthCodingKind::linear;
    scene.depth_bits = 16;
    scene.depth.least_sum = 0;
    derive_valid_range(scene.depth);
    return scene;
}

/// Colours of a slope with noise, and a share that means nothing: black, dark, grey, or any.
std::array<std::uint8_t, 3> colour_at(int x, int y, Random& random) {
    const auto byte = [&](int limit) { return static_cast<std::uint8_t>(random.below(limit)); };
    switch (random.below(12)) {
        case 0:
            return {0, 0, 0};
        case 1:
            return {byte(26), byte(26), byte(26)};
        case 2: {
            const std::uint8_t grey = byte(256);
            return {grey, grey, grey};
        }
        case 3:
            return {byte(256), byte(256), byte(256)};
        default: {
            const auto rising = static_cast<std::uint8_t>((5 * x + 3 * y + random.below(9)) % 256);
            return {rising, static_cast<std::uint8_t>(255 - rising), byte(30)};
        }
    }
}

void expect_the_same_bits(const Scene& scene, const PlaneView& depth) {
    RawFrame hue;
    hue.depth = depth;
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) codes.push_back(stored_code(depth, scene.depth, x, y));
    const StoredPlane grey = store_plane(depth.width, depth.height, codes, {});

    SurfaceFrame from_grey, reference;
    ASSERT_TRUE(make_reference_builder(grey_scene(scene))->build(grey.frame(), from_grey));
    ASSERT_TRUE(make_reference_builder(scene)->build(hue, reference));
    EXPECT_TRUE(reference.codes == from_grey.codes && reference.validity == from_grey.validity);
    EXPECT_EQ(BuilderComparison().difference(scene, hue, reference), "");
    const auto valid = std::count_if(codes.begin(), codes.end(),
                                     [&](std::uint16_t code) { return scene.depth.is_valid(code); });
    const std::ptrdiff_t pixels = std::ptrdiff_t{depth.width} * depth.height;
    EXPECT_TRUE(pixels < 100 || (valid > pixels / 10 && valid < pixels)) << valid << " of " << pixels;
}

TEST(HueBuilders, AgreeBitForBit) {
    Random random(31);
    for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {32, 8}, {33, 17}, {97, 50}})
        for (const FilterSettings& filter :
             {FilterSettings{0, 0}, {3, 0}, {5, 2}, {0, 1, TerraceRemoval::on}})
            for (const bool bottom_up : {false, true}) {
                SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
                const std::ptrdiff_t stride = 3 * width + 5;
                std::vector<std::uint8_t> memory(static_cast<std::size_t>(stride * height), 0xEE);
                PlaneView plane{memory.data(), stride, width, height, 1, 3};
                if (bottom_up) plane.data += stride * (height - 1), plane.stride = -stride;
                for (int y = 0; y < height; ++y)
                    for (int x = 0; x < width; ++x) {
                        const auto colour = colour_at(x, y, random);
                        std::copy(colour.begin(), colour.end(), memory.data() + stride * y + 3 * x);
                    }
                expect_the_same_bits(hue_scene(width, height, filter), plane);
                if (HasFailure()) return;
            }
}

TEST(HueBuilders, RejectGreyDepth) {
    const StoredPlane grey = store_plane(4, 2, std::vector<std::uint16_t>(8, 100), {.bytes_per_sample = 1});
    SurfaceFrame out;
    for (const auto& builder :
         {make_reference_builder(hue_scene(4, 2, {})), make_cpu_builder(hue_scene(4, 2, {})),
          make_lazy_builder(hue_scene(4, 2, {}))}) {
        expect_error(builder->build(grey.frame(), out), "the depth plane has 1 channels; must be 3");
    }
}

TEST(HueBuilders, AgreeOnRealClip) {
    const auto video = real_data("depthkit_typing/Test.mov");
    TOUCHABLE_NEEDS_DATA(video);
    auto clip = must(open_clip(video));
    auto frame = clip->next();
    ASSERT_TRUE(frame && *frame);
    Scene scene = clip->scene();
    for (const FilterSettings& filter : {FilterSettings{0, 0}, {3, 1}, scene.filter}) {
        scene.filter = filter;
        expect_the_same_bits(scene, (*frame)->depth);
    }
}

}  // namespace
}  // namespace touchable::test
