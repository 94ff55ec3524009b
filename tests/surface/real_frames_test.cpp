#include <gtest/gtest.h>

#include <filesystem>

#include "engine/picture/image.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/surface/test_gpu.hpp"
#include "tests/temporary_folder.hpp"

// Depth cameras and scanners as they are: the fast and the lazy builder against the reference.
namespace touchable::test {
namespace {

struct RealFrame {
    const char* name;
    const char* file;
    int far_code;  // deeper codes become invalid
};

std::ostream& operator<<(std::ostream& out, const RealFrame& frame) {
    return out << frame.file;
}

/// Codes deeper than `far_code` become invalid.
void expect_the_same_bits_of_a_picture(const std::filesystem::path& file, int far_code) {
    const Result<Image> image = read_image(file);
    ASSERT_TRUE(image) << image.error().message;
    ASSERT_EQ(image.value().channels, 1);

    Scene scene = depth_scene(image.value().width, image.value().height, 8 * image.value().bytes_per_sample,
                              Marking::none);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 1;
    scene.depth.near = 0;
    scene.depth.far = far_code;
    derive_valid_range(scene.depth);
    ASSERT_FALSE(scene.depth.is_valid(0));
    RawFrame raw;
    raw.depth = image.value().view();

    SurfaceFrame unfiltered, reference, cpu, lazy, vulkan;
    ASSERT_TRUE(make_reference_builder(scene)->build(raw, unfiltered));
    for (const FilterSettings& filter : {FilterSettings{0, 0}, {3, 0}, {5, 2}}) {
        SCOPED_TRACE("median " + std::to_string(filter.median) + ", fill_holes " +
                     std::to_string(filter.fill_holes));
        scene.filter = filter;
        ASSERT_TRUE(make_reference_builder(scene)->build(raw, reference));
        ASSERT_TRUE(make_cpu_builder(scene)->build(raw, cpu));
        ASSERT_TRUE(make_lazy_builder(scene)->build(raw, lazy));
        ASSERT_TRUE(test_vulkan_builder(scene)->build(raw, vulkan));
        ASSERT_EQ(first_difference(reference, cpu), "");
        ASSERT_EQ(first_difference(reference, vulkan), "");
        ASSERT_EQ(first_vertex_difference(reference, *lazy.vertices), "");
        ASSERT_EQ(first_tile_not_enclosed(reference, *lazy.vertices), "");
        EXPECT_EQ(reference.codes == unfiltered.codes, filter == FilterSettings{})
            << "did the filter do anything?";
        long valid = 0;
        for (int y = 0; y < reference.height; ++y)
            for (int x = 0; x < reference.width; ++x) valid += reference.is_valid(x, y);
        EXPECT_GT(valid, scene.width * scene.height / 10);
    }
}

class RealFrames : public testing::TestWithParam<RealFrame> {};

TEST_P(RealFrames, GiveTheSameBitsFromEveryBuilder) {
    const std::filesystem::path file = real_data(GetParam().file);
    TOUCHABLE_NEEDS_DATA(file);
    expect_the_same_bits_of_a_picture(file, GetParam().far_code);
}

TEST(StandInFrames, GiveTheSameBitsFromEveryBuilder) {
    const std::pair<const char*, int> frames[] = {{"castel_sr300/depth_0000.png", 20000},
                                                  {"visp_cube_realsense/depth_0000.png", 60000},
                                                  {"redwood5/depth_00000.png", 60000},
                                                  {"icl_nuim5/depth_1.png", 65535}};
    const TemporaryFolder folder;
    for (const auto& [file, far_code] : frames) {
        SCOPED_TRACE(file);
        const std::filesystem::path path = folder / file;
        StandIn what = stand_in(path.parent_path().filename());
        what.frames = 1;
        write_stand_in(path.parent_path(), what);
        expect_the_same_bits_of_a_picture(path, far_code);
        if (HasFailure()) return;
    }
}

INSTANTIATE_TEST_SUITE_P(Data, RealFrames,
                         testing::Values(RealFrame{"Castel", "castel_sr300/depth_0010.png", 20000},
                                         RealFrame{"Cube", "visp_cube_realsense/depth_0003.png", 60000},
                                         RealFrame{"Redwood", "stills/redwood5/depth_00002.png", 60000},
                                         RealFrame{"Icl", "stills/icl_nuim5/depth_1.png", 65535}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace touchable::test
