// A surface that the CPU draws for a window, from the clip's own view and from any other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "player/draw/cpu_painting.hpp"
#include "player/draw/drawn_surface.hpp"
#include "player/draw/gpu_painting.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/plain_picture.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

/// Lattices are a device's.
class LatticePicture : public GpuTest {};

MappedLattice mapped(const GpuLattice& lattice) {
    return {lattice.q.mapped<float>().data(), lattice.colours.mapped<PackedColour>().data(), lattice.width,
            lattice.height, lattice.pitch};
}

TEST_F(LatticePicture, OwnViewIsTheSameByAllVectors) {
    const auto shown = shown_scene("globe", 203, 133);
    const HeightField field = shown->field();
    const ViewCamera camera =
        make_view(*parse_viewpoint("own"), shown->scene, subject_of(field).middle, 301, 200);
    ASSERT_TRUE(OwnViewPicture::draws(camera));
    GpuLattices lattices(gpu);
    const GpuLattice lattice = must(lattices.lattice_of(make_view_surface(field, shown->raw_prev.colour)));
    const std::vector<PackedColour> background(200, 7);
    std::vector<PackedColour> first;
    std::vector<float> first_z;
    for (const VectorUnit unit : usable_vector_units()) {
        std::vector<PackedColour> colours(304 * 200);
        std::vector<float> z(colours.size());
        OwnViewPicture(unit).draw(mapped(lattice), camera, background, 304, colours, z);
        if (first.empty()) {
            first = colours;
            first_z = z;
        }
        EXPECT_EQ(colours, first);
        EXPECT_EQ(z, first_z);
    }
    EXPECT_GT(std::count(first.begin(), first.end(), 7U), 1000);
    EXPECT_GT(std::count_if(first_z.begin(), first_z.end(), [](float z) { return z > 0; }), 10'000);
}

TEST_F(LatticePicture, OwnViewIsThePlainOneAcrossDepthSteps) {
    for (const char* scene : {"globe", "cliffs", "noise"}) {
        const auto shown = shown_scene(scene, 203, 133);
        const ViewSurface surface = make_view_surface(shown->field(), shown->raw_prev.colour);
        GpuLattices lattices(gpu);
        const GpuLattice lattice = must(lattices.lattice_of(surface));
        const ViewCamera camera = own_view(shown->scene, 301, 200, 1);
        ASSERT_TRUE(OwnViewPicture::draws(camera));
        const PicturePlanes expected = plain_picture(surface, camera);
        std::vector<PackedColour> colours(304 * 200);
        std::vector<float> z(colours.size());
        OwnViewPicture().draw(mapped(lattice), camera, std::vector<PackedColour>(200, 7), 304, colours, z);
        std::size_t drawn = 0, others = 0;
        for (int y = 0; y < 200; ++y)
            for (int x = 0; x < 301; ++x) {
                const std::size_t at = static_cast<std::size_t>(y) * 304 + static_cast<std::size_t>(x);
                const std::size_t pixel = expected.index(x, y);
                drawn += z[at] > 0;
                others += (z[at] > 0) != (expected.z[pixel] > 0);
                if (!(z[at] > 0) || !(expected.z[pixel] > 0)) continue;
                others += std::fabs(z[at] - expected.z[pixel]) > 1e-4F * z[at];
                for (const unsigned shift : {0U, 8U, 16U})
                    others += std::abs(static_cast<int>(colours[at] >> shift & 255U) -
                                       static_cast<int>(expected.colours[pixel] >> shift & 255U)) > 1;
            }
        EXPECT_EQ(others, 0U) << scene;
        EXPECT_GT(drawn, 10'000U) << scene;
    }
}

/// From the side, from behind, from so near that cells are large and reach before the eye.
TEST_F(LatticePicture, AnyViewIsThePlainOneToTheBit) {
    for (const char* scene : {"globe", "cliffs", "noise", "rows without surface"}) {
        const bool has_gap = std::string_view(scene) == "rows without surface";
        const auto shown = shown_scene(has_gap ? "globe" : scene, 203, 133);
        const HeightField field = shown->field();
        const Viewpoint::Subject subject = subject_of(field);
        ViewSurface surface = make_view_surface(field, shown->raw_prev.colour);
        if (has_gap) std::fill(surface.q.begin() + 40 * 203, surface.q.begin() + 60 * 203, 0.0F);
        GpuLattices lattices(gpu);
        const GpuLattice lattice = must(lattices.lattice_of(surface));
        for (const char* words :
             {"own", "orbit:az=7,el=3", "orbit:az=70,el=5", "orbit:az=-60,el=30,zoom=2", "orbit:az=180,el=0",
              "orbit:az=25,el=10,zoom=8", "orbit:az=80,el=0,zoom=20"}) {
            const ViewCamera camera =
                make_view(*parse_viewpoint(words), shown->scene, subject.middle, 301, 200);
            const PicturePlanes expected = plain_picture(surface, camera);
            SurfaceEdges edges(1);
            if (!is_own_view(camera))
                edges.find(surface.q.data(), surface.width, surface.height, surface.width);
            const std::vector<PackedColour> background(200, 7);
            std::vector<std::pair<int, VectorUnit>> ways{{2, usable_vector_units().front()}};
            for (const VectorUnit unit : usable_vector_units()) ways.emplace_back(1, unit);
            for (const auto& [threads, unit] : ways) {
                std::vector<PackedColour> colours(304 * 200);
                std::vector<float> z(colours.size(), 9);
                LatticeRaster(threads, unit)
                    .draw(mapped(lattice), edges, camera, background, 304, colours, z);
                std::size_t others = 0;
                for (int y = 0; y < 200; ++y)
                    for (int x = 0; x < 301; ++x) {
                        const std::size_t at =
                            static_cast<std::size_t>(y) * 304 + static_cast<std::size_t>(x);
                        const std::size_t pixel = expected.index(x, y);
                        const bool is_empty = !(expected.z[pixel] > 0);
                        others += z[at] != expected.z[pixel] ||
                                  colours[at] != (is_empty ? 7U : expected.colours[pixel]);
                    }
                EXPECT_EQ(others, 0U) << scene << ", " << words << ", by " << threads;
            }
            EXPECT_GT(std::count_if(expected.z.begin(), expected.z.end(), [](float z) { return z > 0; }), 50)
                << scene << ", " << words;
        }
    }
}

/// As before the first frame of a camera.
TEST(LatticeRaster, WithoutVerticesDrawsTheBackground) {
    const auto shown = shown_scene("globe", 203, 133);
    const ViewCamera camera = make_view(*parse_viewpoint("orbit:az=70,el=5"), shown->scene,
                                        subject_of(shown->field()).middle, 20, 10);
    const std::vector<PackedColour> background(10, 7);
    std::vector<PackedColour> colours(20 * 10);
    std::vector<float> z(colours.size(), 9);
    LatticeRaster(1).draw({nullptr, nullptr, 0, 0, 0}, SurfaceEdges(1), camera, background, 20, colours, z);
    EXPECT_EQ(std::ranges::count(colours, PackedColour{7}), 200);
    EXPECT_EQ(std::ranges::count(z, 0.0F), 200);
}

/// What a wider lattice left beyond the width of the next is not drawn.
TEST_F(LatticePicture, AnyViewIsTheSameAfterAWiderLattice) {
    GpuLattices lattices(gpu);
    const auto wide = shown_scene("globe", 230, 133), narrow = shown_scene("globe", 203, 133);
    const std::vector<PackedColour> background(200, 7);
    struct Picture {
        std::vector<PackedColour> colours = std::vector<PackedColour>(304 * 200);
        std::vector<float> z = std::vector<float>(304 * 200);
    };
    const auto draw = [&](LatticeRaster& raster, const Shown& shown) {
        const HeightField field = shown.field();
        const ViewCamera camera = make_view(*parse_viewpoint("orbit:az=30,el=5,zoom=0.5"), shown.scene,
                                            subject_of(field).middle, 301, 200);
        const GpuLattice lattice = must(lattices.lattice_of(make_view_surface(field, shown.raw_prev.colour)));
        SurfaceEdges edges(1);
        edges.find(lattice.q.mapped<float>().data(), lattice.width, lattice.height, lattice.pitch);
        Picture picture;
        raster.draw(mapped(lattice), edges, camera, background, 304, picture.colours, picture.z);
        return picture;
    };
    for (const VectorUnit unit : usable_vector_units()) {
        LatticeRaster fresh(1, unit), used(1, unit);
        const Picture wanted = draw(fresh, *narrow);
        draw(used, *wide);
        const Picture is = draw(used, *narrow);
        EXPECT_EQ(is.z, wanted.z);
        EXPECT_EQ(is.colours, wanted.colours);
    }
}

}  // namespace
}  // namespace touchable::test
