#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "player/draw/drawn_surface.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/pictures.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/coded_frames.hpp"
#include "tests/view/many_colours.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

class SurfaceLight : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        lattices.emplace(gpu);
        kernel.emplace(gpu);
    }
    void TearDown() override {
        lattices.reset();
        kernel.reset();
        GpuTest::TearDown();
    }

    /// Rows of 4 bytes a vertex, without what lies beyond the width.
    template <class T>
    static std::vector<T> rows_in(const GpuLattice& lattice, const GpuBuffer& buffer) {
        std::vector<T> values;
        for (int y = 0; y < lattice.height; ++y) {
            const auto row = buffer.mapped<T>().subspan(static_cast<std::size_t>(y * lattice.pitch),
                                                        static_cast<std::size_t>(lattice.width));
            values.insert(values.end(), row.begin(), row.end());
        }
        return values;
    }

    struct Lit {
        std::vector<float> q;
        std::vector<PackedColour> colours;
    };
    Lit light(const HeightField& field, const FramePair& pair, const PlaneView& colour, Lighting lighting) {
        GpuLattice lattice;
        auto commands = must(GpuCommands::begin(gpu, "light"));
        must(lattices->record(commands, field, pair, lattice));
        must(lattices->reserve_colours(lattice));
        must(kernel->record(commands, field, lattice, colour, lighting));
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        const auto back = [&](const GpuBuffer& buffer) {
            auto made = must(GpuBuffer::create(*gpu, "back", buffer.bytes(), GpuMemory::readback));
            commands.copy(buffer, 0, made, 0, buffer.bytes());
            return made;
        };
        const GpuBuffer q = back(lattice.q), colours = back(lattice.colours);
        must(must(std::move(commands).submit()).wait());
        return {rows_in<float>(lattice, q), rows_in<PackedColour>(lattice, colours)};
    }

    /// Against `lit_colours` of the same q.
    void compare(const HeightField& field, const FramePair& pair, const PlaneView& colour) {
        Lit lit = light(field, pair, colour, Lighting::lit);
        ViewSurface surface;
        surface.width = field.width();
        surface.height = field.height();
        surface.q = std::move(lit.q);
        const std::vector<PackedColour> twin = lit_colours(field.scene().camera, surface, colour);
        int worst = 0;
        for (std::size_t k = 0; k < twin.size(); ++k) {
            ASSERT_EQ(lit.colours[k] >> 24, 255U) << "vertex " << k;
            for (const unsigned shift : {0U, 8U, 16U})
                worst = std::max(worst, std::abs(static_cast<int>(lit.colours[k] >> shift & 255U) -
                                                 static_cast<int>(twin[k] >> shift & 255U)));
        }
        EXPECT_LE(worst, 2) << field.width() << "x" << field.height();
    }

    std::optional<GpuLattices> lattices;
    std::optional<SurfaceLighting> kernel;
};

TEST_F(SurfaceLight, AgreesWithItsTwinOnScenes) {
    for (const char* name : {"globe", "step", "noise"}) {
        SCOPED_TRACE(name);
        const auto shown = shown_scene(name, 171, 133);
        const ManyColours colours(171, 133);
        for (const double blend : {0.0, 0.4}) {
            compare(shown->field(blend), shown->pair(blend), colours.view());
            compare(shown->field(blend), shown->pair(blend), {});
        }
    }
}

TEST_F(SurfaceLight, AgreesWhereThereIsATriangleHereAndThere) {
    const Codes codes(coding_of(DepthCodingKind::inverse, DepthSemantics::range, true), 90, 70, true);
    const FramePair pair{{0, 0, &codes.prev}, {1, 1'000'000, &codes.next}, 0.3};
    const ManyColours colours(90, 70);
    compare(HeightField(codes.scene, pair), pair, colours.view());
}

TEST_F(SurfaceLight, AgreesOnSurfacesOfAnySize) {
    const int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {3, 2}, {7, 65}, {8, 64}, {33, 17}, {24, 130}};
    for (const auto& [width, height] : sizes) {
        const Codes codes(coding_of(DepthCodingKind::linear, DepthSemantics::planar, true), width, height,
                          false);
        const FramePair pair{{0, 0, &codes.prev}, {1, 1'000'000, &codes.next}, 0};
        const ManyColours colours(width, height);
        compare(HeightField(codes.scene, pair), pair, colours.view());
    }
}

TEST_F(SurfaceLight, LeavesPlainColoursAsTheyAre) {
    const auto shown = shown_scene("globe", 67, 45);
    const ManyColours colours(67, 45);
    const Lit lit = light(shown->field(), shown->pair(), colours.view(), Lighting::plain);
    for (std::size_t k = 0; k < lit.colours.size(); ++k)
        ASSERT_EQ(lit.colours[k],
                  pack_colour(colours.bytes[3 * k], colours.bytes[3 * k + 1], colours.bytes[3 * k + 2]));
}

TEST_F(SurfaceLight, LightsFramesWithoutCodes) {
    auto shown = shown_scene("globe", 96, 64);
    std::vector<double> depths(96 * 64, 0.8 * shown->scene.depth.far);
    depths[1000] = NAN;
    shown->prev.vertices = std::make_unique<ExactVertices>(96, 64, depths);
    shown->prev.codes.clear();
    compare(shown->field(), shown->pair(), {});
}

TEST_F(SurfaceLight, RefusesColoursOfAnotherSize) {
    const auto shown = shown_scene("globe", 67, 45);
    const ManyColours colours(67, 44);
    EXPECT_THROW(light(shown->field(), shown->pair(), colours.view(), Lighting::lit), std::runtime_error);
}

}  // namespace
}  // namespace touchable::test
