#include "player/draw/gpu_painting.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "engine/content/seeded_noise.hpp"
#include "shaders/cut_rule.h"
#include "shaders/tile_lists.h"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/plain_surface.hpp"

namespace touchable::test {
namespace {

class TileListsOnGpu : public GpuTest {
protected:
    /// Lists by the kernels and by their twin, which are the same.
    ViewSurface::Tiles compare(int width, int height, const std::function<float()>& next_q) {
        GpuLattice lattice;
        lattice.width = width;
        lattice.height = height;
        lattice.pitch = SurfaceUnproject::pitch(width);
        lattice.q =
            must(GpuBuffer::create(*gpu, "q", SurfaceUnproject::q_bytes(width, height), GpuMemory::shared));
        lattice.tiles = must(
            GpuBuffer::create(*gpu, "tiles", GpuLattices::tile_list_bytes(width, height), GpuMemory::shared));
        std::vector<float> q;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < lattice.pitch; ++x) {
                float& stored = lattice.q.mapped<float>()[static_cast<std::size_t>(y * lattice.pitch + x)];
                stored = x < width ? next_q() : NAN;  // nothing depends on what lies beyond the width
                if (x < width) q.push_back(stored);
            }
        GpuLattices lattices(gpu);
        auto commands = must(GpuCommands::begin(gpu, "tile lists"));
        must(lattices.record_tiles(commands, lattice));
        must(must(std::move(commands).submit()).wait());
        const ViewSurface::Tiles tiles = read_tiles(lattice.tiles);
        EXPECT_EQ(tiles, classify_tiles(width, height, q)) << width << "x" << height;
        return tiles;
    }

    SplitMix64 random{11};
};

TEST_F(TileListsOnGpu, AreThoseOfTheirTwinWhateverTheQ) {
    const float edge = 0.01F * CUT_RULE_RATIO;
    const std::vector<float> about_the_edge{0.01F,
                                            edge,
                                            std::nextafter(edge, 0.0F),
                                            std::nextafter(edge, 1.0F),
                                            std::nextafter(0.01F, 0.0F),
                                            std::nextafter(0.01F, 1.0F)};
    ViewSurface::Tiles all;
    for (const double holes : {0.0, 0.0005, 0.3, 1.0})
        for (const double odd : {0.0, 0.002, 0.5}) {
            const ViewSurface::Tiles tiles = compare(331, 203, [&] {
                if (random.unit() < holes) return 0.0F;
                return random.unit() < odd ? about_the_edge[random.next() % about_the_edge.size()] : 0.01F;
            });
            all.whole.insert(all.whole.end(), tiles.whole.begin(), tiles.whole.end());
            all.mixed.insert(all.mixed.end(), tiles.mixed.begin(), tiles.mixed.end());
        }
    EXPECT_GT(all.whole.size(), 500U);
    EXPECT_GT(all.mixed.size(), 500U);
}

TEST_F(TileListsOnGpu, AreThoseOfTheirTwinAtAnySize) {
    for (const int width : {1, 2, 15, 16, 17, 18, 31, 32, 33, 34, 49, 64, 65, 66})
        for (const int height : {1, 2, 16, 17, 18, 33, 40})
            compare(width, height, [&] {
                const double u = random.unit();
                return u < 0.001 ? 0.0F : (u < 0.003 ? 0.02F : 0.01F);
            });
}

TEST_F(TileListsOnGpu, OfManyTiles) {
    const ViewSurface::Tiles tiles = compare(1920, 1080, [&] { return random.unit() < 0.002 ? 0.0F : 1.0F; });
    EXPECT_GT(tiles.whole.size(), 1000U);
    EXPECT_GT(tiles.mixed.size(), 1000U);
}

TEST(TileListsHeader, HasAGroupForEveryTileAndRowsThatEveryDeviceTakes) {
    for (const std::uint32_t whole : {0U, 1U, 5U, 32768U, 100'000U})
        for (const std::uint32_t mixed : {0U, 1U, 32767U, 32768U, 162'144U}) {
            const TileListsHeader header = tile_lists_header(whole, mixed);
            EXPECT_LE(header.groups_x, 65535U);
            EXPECT_GE(header.groups_x * header.groups_y, whole + mixed);
            EXPECT_LE(header.groups_y, 1 + (whole + mixed) / 32768);
        }
}

}  // namespace
}  // namespace touchable::test
