#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "engine/formats/open_clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/real_data.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"

// Depth stored as hue: every builder gives the bits of the reference, which are those of the same codes
// stored as grey.
namespace touchable::test {
namespace {

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

    SurfaceFrame from_grey, reference, cpu, lazy;
    ASSERT_TRUE(make_reference_builder(grey_scene(scene))->build(grey.frame(), from_grey));
    ASSERT_TRUE(make_reference_builder(scene)->build(hue, reference));
    ASSERT_TRUE(make_cpu_builder(scene)->build(hue, cpu));
    ASSERT_TRUE(make_lazy_builder(scene)->build(hue, lazy));
    EXPECT_TRUE(reference.codes == from_grey.codes && reference.validity == from_grey.validity);
    EXPECT_EQ(first_difference(reference, cpu), "");
    for (const SurfacePlan& plan : all_plans) {
        SurfaceFrame vulkan;
        auto builder = make_vulkan_builder(scene, test_kernels(), plan);
        ASSERT_TRUE(builder) << builder.error().message;
        ASSERT_TRUE((*builder)->build(hue, vulkan));
        EXPECT_EQ(first_difference(reference, vulkan), "") << plan_text(plan);
    }
    EXPECT_EQ(first_vertex_difference(reference, *cpu.vertices), "") << "cpu";
    EXPECT_EQ(first_vertex_difference(reference, *lazy.vertices), "") << "lazy";
    EXPECT_EQ(first_tile_not_enclosed(reference, *lazy.vertices), "") << "lazy";
    const auto valid = std::count_if(codes.begin(), codes.end(),
                                     [&](std::uint16_t code) { return scene.depth.is_valid(code); });
    const std::ptrdiff_t pixels = std::ptrdiff_t{depth.width} * depth.height;
    EXPECT_TRUE(pixels < 100 || (valid > pixels / 10 && valid < pixels)) << valid << " of " << pixels;
}

TEST(HueBuilders, GiveTheSameBits) {
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

TEST(HueBuilders, RefuseGreyDepth) {
    const StoredPlane grey = store_plane(4, 2, std::vector<std::uint16_t>(8, 100), {.bytes_per_sample = 1});
    SurfaceFrame out;
    for (const auto& builder :
         {make_reference_builder(hue_scene(4, 2, {})), make_cpu_builder(hue_scene(4, 2, {})),
          make_lazy_builder(hue_scene(4, 2, {}))}) {
        const auto built = builder->build(grey.frame(), out);
        ASSERT_FALSE(built);
        EXPECT_NE(built.error().message.find("the depth plane has 1 channels, 3 would be right"),
                  std::string::npos)
            << built.error().message;
    }
}

TEST(HueBuilders, GiveTheSameBitsOfARealClip) {
    const auto video = real_data("depthkit_typing/Test.mov");
    TOUCHABLE_NEEDS_DATA(video);
    auto clip = open_clip(video);
    ASSERT_TRUE(clip) << clip.error().message;
    auto frame = (*clip)->next();
    ASSERT_TRUE(frame && *frame);
    Scene scene = (*clip)->scene();
    for (const FilterSettings& filter : {FilterSettings{0, 0}, {3, 1}, scene.filter}) {
        scene.filter = filter;
        expect_the_same_bits(scene, (*frame)->depth);
    }
}

}  // namespace
}  // namespace touchable::test
