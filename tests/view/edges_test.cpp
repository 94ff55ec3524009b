// Where vertices at edges are drawn: along the edge that their pixels tell of, and never across themselves.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "player/draw/cpu_painting.hpp"
#include "player/draw/drawn_surface.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/pictures.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

/// A lattice and where its vertices are drawn.
struct Drawn {
    int width, height;
    std::vector<float> q;
    float ratio = CUT_RULE_RATIO;
    SurfaceEdges edges{1};

    Drawn(int columns, int rows, const std::function<float(int x, int y)>& q_at, float cut = CUT_RULE_RATIO)
        : width(columns), height(rows), ratio(cut) {
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) q.push_back(q_at(x, y));
        edges.find(q.data(), width, height, width, ratio);
    }
    float at(int x, int y) const { return q[static_cast<std::size_t>(y * width + x)]; }
    glm::dvec2 place(int x, int y) const {
        const auto* edge = edges.at(x, y);
        return edge != nullptr ? glm::dvec2(edge->at_x, edge->at_y) : glm::dvec2(x, y);
    }
    bool is_kept(const std::array<std::array<int, 2>, 3>& corners) const {
        float least = 1e9F, most = 0;
        for (const auto& [x, y] : corners) {
            least = std::min(least, at(x, y));
            most = std::max(most, at(x, y));
        }
        return least > 0 && most <= ratio * least;
    }
    /// Calls look(area in halves of a cell) for every triangle that is drawn.
    void for_each_area(const std::function<void(double)>& look) const {
        for (int y = 0; y + 1 < height; ++y)
            for (int x = 0; x + 1 < width; ++x)
                for (const auto& corners :
                     {std::array<std::array<int, 2>, 3>{{{x, y}, {x + 1, y}, {x + 1, y + 1}}},
                      std::array<std::array<int, 2>, 3>{{{x, y}, {x + 1, y + 1}, {x, y + 1}}}}) {
                    if (!is_kept(corners)) continue;
                    const glm::dvec2 a = place(corners[0][0], corners[0][1]),
                                     b = place(corners[1][0], corners[1][1]) - a,
                                     c = place(corners[2][0], corners[2][1]) - a;
                    look(b.x * c.y - b.y * c.x);
                }
    }
};

/// Something near before something far, where `is_near` says so.
std::function<float(int, int)> near_where(const std::function<bool(int, int)>& is_near) {
    return [is_near](int x, int y) { return is_near(x, y) ? 0.02F : 0.01F; };
}

struct Deviation {
    double before, after;
};
/// Root of the mean square of how far vertices of what is near, where pixels below are of what is far, lie
/// from a line through the lattice, before and after they are moved; the mean taken off of both.
Deviation deviation(const Drawn& drawn, double slope, double start) {
    const double across = 1 / std::sqrt(1 + slope * slope);
    double sum[2] = {0, 0}, squares[2] = {0, 0};
    int count = 0;
    for (int y = 8; y + 8 < drawn.height; ++y)
        for (int x = 8; x + 8 < drawn.width; ++x) {
            if (drawn.at(x, y) < 0.015F || drawn.at(x, y + 1) > 0.015F) continue;
            ++count;
            const glm::dvec2 places[2] = {{x, y}, drawn.place(x, y)};
            for (int k = 0; k < 2; ++k) {
                const double off = (places[k].y - start - slope * places[k].x) * across;
                sum[k] += off;
                squares[k] += off * off;
            }
        }
    EXPECT_GT(count, 80);
    // In the middle the line is where it should be, and not only straight. What is parallel to the rows tells
    // no more than that it is between two.
    if (slope != 0) {
        EXPECT_NEAR(sum[1] / count, 0, 0.08) << slope;
    }
    const auto rms = [&](int k) { return std::sqrt(squares[k] / count - sum[k] * sum[k] / count / count); };
    return {rms(0), rms(1)};
}

TEST(SurfaceEdges, OfAHalfPlaneLieOnItsLine) {
    for (const int step : {1, 2, 4})
        for (const double slope : {0.0, 0.07, 0.13, 0.21, 0.37, 0.5, 0.8, -0.11, -0.29, -0.6}) {
            const double start = 60.3 - 60 * slope;
            const Drawn drawn(120, 120, near_where([&](int x, int y) { return y <= start + slope * x; }),
                              cut_ratio(step));
            const Deviation d = deviation(drawn, slope, start);
            RecordProperty("slope " + std::to_string(slope),
                           std::to_string(d.before) + " " + std::to_string(d.after));
            if (slope == 0.0) continue;
            EXPECT_LT(d.after, 0.45 * d.before) << "slope " << slope << ", before " << d.before;
            EXPECT_LT(d.after, 0.13) << "slope " << slope << ", before " << d.before;
        }
}

TEST(SurfaceEdges, MoveOutwardsByLessThanAPixel) {
    const Drawn drawn(60, 60, near_where([](int x, int y) { return std::hypot(x - 30.2, y - 29.7) < 20; }));
    int moved = 0;
    for (int y = 0; y < 60; ++y)
        for (const auto& edge : drawn.edges.row(y)) {
            ++moved;
            const double out =
                std::hypot(edge.at_x - 30.2, edge.at_y - 29.7) - std::hypot(edge.x - 30.2, y - 29.7);
            EXPECT_GT(drawn.at(edge.x, y) > 0.015F ? out : -out, -1e-9) << edge.x << ", " << y;
            EXPECT_LT(std::fabs(edge.at_x - static_cast<float>(edge.x)), 0.9F);
            EXPECT_LT(std::fabs(edge.at_y - static_cast<float>(y)), 0.9F);
        }
    EXPECT_GT(moved, 150);
}

/// Cameras at the ends of long thin things see one or two pixels of them.
TEST(SurfaceEdges, LeaveThinThingsTheirWidth) {
    for (const double slope : {0.0, 0.2, 0.45, 1.0, -0.3})
        for (const int wide : {2, 3}) {
            double areas = 0, bare = 0;
            const auto is_near = [&](int x, int y) {
                const double first = 30 + slope * (x - 30);
                return y >= first && y < first + wide;
            };
            const Drawn drawn(60, 60, [&](int x, int y) { return is_near(x, y) ? 0.02F : 0.0F; });
            drawn.for_each_area([&](double area) {
                areas += area;
                bare += 1;
                EXPECT_GT(area, 0.2) << slope;
            });
            EXPECT_GT(areas, bare) << slope << ", " << wide;
            EXPECT_GT(bare, 20);
        }
}

TEST(SurfaceEdges, TurnNoTriangleOver) {
    std::mt19937 engine(37);
    const struct {
        std::mt19937& engine;
        double unit() const { return engine() / 4294967296.0; }
    } random{engine};
    for (const double holes : {0.02, 0.1, 0.3, 0.6})
        for (int run = 0; run < 20; ++run) {
            // Patches of two surfaces and holes, of all shapes: each pixel is one of them, or as its
            // neighbour.
            std::vector<float> last(80, 0.01F);
            float left = 0.01F;
            const Drawn drawn(80, 60, [&](int x, int) {
                const double dice = random.unit();
                const float fresh = random.unit() < holes ? 0.0F : random.unit() < 0.5 ? 0.01F : 0.0125F;
                left = dice < 0.45 ? left : dice < 0.9 ? last[static_cast<std::size_t>(x)] : fresh;
                last[static_cast<std::size_t>(x)] = left;
                return left == 0.0F ? left : left * (1 + 0.03F * static_cast<float>(random.unit()));
            });
            int drawn_triangles = 0;
            drawn.for_each_area([&](double area) {
                ++drawn_triangles;
                EXPECT_GT(area, 0.05);
            });
            EXPECT_GT(drawn_triangles, 500);
        }
}

/// What a camera sees at a grazing angle ends in the dark, what it sees from the front as it is.
TEST(SurfaceEdges, AreDarkWhereTheyAreSteep) {
    float last = 1;
    for (const float steep : {0.0F, 0.01F, 0.02F, 0.03F, 0.04F, 0.055F}) {
        const Drawn drawn(40, 40, [&](int x, int) {
            return x < 20 ? 0.02F * std::pow(1 - steep, static_cast<float>(x - 10)) : 0.0F;
        });
        const auto* edge = drawn.edges.at(19, 20);
        ASSERT_NE(edge, nullptr);
        EXPECT_LE(edge->light, last) << steep;
        last = edge->light;
        if (steep <= 0.01F) {
            EXPECT_EQ(last, 1.0F) << steep;
        }
        SurfaceEdges values(1);
        values.find(drawn.q.data(), 40, 40, 40, CUT_RULE_RATIO, true);
        EXPECT_EQ(values.at(19, 20)->light, 1.0F);
    }
    EXPECT_LT(last, 0.25F);
}

/// A ball before something far, whose edge falls away: each vertex by itself would be as deep, and as dark,
/// as the edge's step is that it is in.
TEST(SurfaceEdges, OfABallHaveNeitherTeethNorStreaks) {
    const double focal = 400, middle = 80, across = 60 / focal;
    const Drawn drawn(160, 160, [&](int x, int y) {
        const double u = (x - middle) / focal, v = (y - middle) / focal, ray = u * u + v * v + 1;
        const double rest = 1 - ray * (1 - across * across);
        return static_cast<float>(rest > 0 ? ray / (1 - std::sqrt(rest)) : 0.5);
    });
    int steps = 0, pairs = 0;
    double deepest = 1e9, shallowest = 0;
    for (int y = 40; y < 120; ++y)
        for (const auto& edge : drawn.edges.row(y)) {
            if (drawn.at(edge.x, y) < 0.75F || edge.x < 80) continue;
            deepest = std::min(deepest, static_cast<double>(edge.q));
            shallowest = std::max(shallowest, static_cast<double>(edge.q));
            const int aside = edge.at_x > static_cast<float>(edge.x) ? 1 : 0,
                      down = edge.at_y > static_cast<float>(y)   ? 1
                             : edge.at_y < static_cast<float>(y) ? -1
                                                                 : 0;
            if (aside != 0 && down != 0) {
                ++steps;
                const auto *one = drawn.edges.at(edge.x + 1, y), *other = drawn.edges.at(edge.x, y + down);
                ASSERT_TRUE(one != nullptr && other != nullptr);
                EXPECT_NEAR(edge.q, (one->q + other->q) / 2, 1e-6) << edge.x << ", " << y;
                EXPECT_NEAR(edge.light, (one->light + other->light) / 2, 0.02) << edge.x << ", " << y;
            } else if (const auto* next = drawn.edges.at(edge.x, y + 1); next != nullptr) {
                ++pairs;
                EXPECT_NEAR(edge.light, next->light, 0.05) << edge.x << ", " << y;
            }
        }
    EXPECT_GT(steps, 10);
    EXPECT_GT(pairs, 40);
    EXPECT_LT(shallowest / deepest, 1.006);
}

/// A plane aslant goes on as a plane, whatever the pixel at its edge holds.
TEST(SurfaceEdges, GoOnAsThePlaneTheyEnd) {
    const auto plane = [](double x, double y) { return 0.02 + 6e-5 * x - 4e-5 * y; };
    const auto is_near = [](int x, int y) { return y <= 20.4 + 0.3 * x; };
    const Drawn drawn(80, 60, [&](int x, int y) {
        if (!is_near(x, y)) return 0.01F;
        // Half-way to what is behind, as a camera mixes: a hundredth of it.
        return static_cast<float>(plane(x, y) * (is_near(x, y + 1) ? 1.0 : 0.99));
    });
    int compared = 0;
    for (int y = 8; y < 52; ++y)
        for (const auto& edge : drawn.edges.row(y)) {
            if (drawn.at(edge.x, y) < 0.015F || edge.x < 8 || edge.x > 71 || is_near(edge.x, y + 1)) continue;
            ++compared;
            EXPECT_NEAR(edge.q / plane(edge.at_x, edge.at_y), 1, 0.004) << edge.x << ", " << y;
        }
    EXPECT_GT(compared, 40);
}

TEST(SurfaceEdges, APicturesBorderIsNone) {
    const Drawn whole(40, 30, [](int x, int) { return 0.01F + 1e-5F * static_cast<float>(x); });
    for (int y = 0; y < 30; ++y) EXPECT_TRUE(whole.edges.row(y).empty());
    const Drawn half(40, 30, near_where([](int x, int) { return x < 20; }));
    for (int y = 0; y < 30; ++y) {
        ASSERT_EQ(half.edges.row(y).size(), 2U) << y;
        EXPECT_EQ(half.edges.row(y)[0].at_x, 19.5F);
        EXPECT_EQ(half.edges.row(y)[1].at_x, 19.5F);
        EXPECT_EQ(half.edges.row(y)[0].at_y, static_cast<float>(y));
    }
}

TEST(SurfaceEdges, AreTheSameByAllThreadsAndVectors) {
    for (const char* scene : {"globe", "cliffs", "noise"}) {
        const auto shown = shown_scene(scene, 203, 133);
        const std::vector<float> q = q_of(shown->field());
        std::size_t found = 0;
        for (const int threads : {1, 2})
            for (const VectorUnit unit : usable_vector_units()) {
                SurfaceEdges edges(threads, unit);
                edges.find(q.data(), 203, 133, 203);
                const EdgeLattice lattice{q.data(), 203, 133, 203, CUT_RULE_RATIO};
                for (int y = 0; y < 133; ++y)
                    for (int x = 0; x < 203; ++x) {
                        const EdgeMove move = edge_move(lattice, {x, y});
                        const float here = q[static_cast<std::size_t>(y * 203 + x)];
                        const auto* edge = edges.at(x, y);
                        ASSERT_EQ(edge != nullptr,
                                  move.by != ivec2(0, 0) || move.q != here || move.shade != EDGE_UNIT)
                            << x << ", " << y;
                        if (edge == nullptr) continue;
                        ++found;
                        ASSERT_EQ(edge->q, move.q);
                        ASSERT_EQ(edge->light, static_cast<float>(move.shade) / EDGE_UNIT);
                        ASSERT_EQ(edge->at_x,
                                  static_cast<float>(x) + static_cast<float>(move.by.x) / EDGE_UNIT);
                        ASSERT_EQ(edge->at_y,
                                  static_cast<float>(y) + static_cast<float>(move.by.y) / EDGE_UNIT);
                    }
            }
        EXPECT_GT(found, 500U) << scene;
    }
}

class EdgesOnAGpu : public GpuTest {
protected:
    /// What the kernel writes, where the CPU reads it: a GPU with memory of its own keeps it there.
    GpuBuffer edges_by_kernel(GpuLattices& lattices, const ViewCamera& camera, GpuLattice& lattice) {
        auto commands = must(GpuCommands::begin(gpu, "edges"));
        must(lattices.record_edges(commands, camera, false, lattice));
        GpuBuffer back =
            must(GpuBuffer::create(*gpu, "edges read back", lattice.edges.bytes(), GpuMemory::readback));
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        commands.copy(lattice.edges, 0, back, 0, back.bytes());
        must(must(std::move(commands).submit()).wait());
        return back;
    }
};

TEST_F(EdgesOnAGpu, AreTheCpusToTheBit) {
    GpuLattices lattices(gpu);
    for (const char* scene : {"globe", "cliffs", "noise"}) {
        const auto shown = shown_scene(scene, 203, 133);
        const HeightField field = shown->field();
        GpuLattice lattice = must(lattices.lattice_of(make_view_surface(field, {})));
        const ViewCamera camera =
            make_view(*parse_viewpoint("orbit:az=20,el=5"), shown->scene, subject_of(field).middle, 90, 60);
        const GpuBuffer written = edges_by_kernel(lattices, camera, lattice);
        const auto words = written.mapped<std::uint32_t>();
        const std::vector<float> q = q_of(field);
        SurfaceEdges edges(1);
        edges.find(q.data(), 203, 133, 203);
        const auto steps = [](float drawn, int pixel) {
            return static_cast<std::uint32_t>(
                static_cast<std::int32_t>((drawn - static_cast<float>(pixel)) * EDGE_UNIT));
        };
        std::size_t others = 0;
        for (int y = 0; y < 133; ++y)
            for (int x = 0; x < 203; ++x) {
                const auto at = 2 * static_cast<std::size_t>(y * lattice.pitch + x);
                const auto* edge = edges.at(x, y);
                std::array<std::uint32_t, 2> expected{0, 0};
                if (edge != nullptr)
                    expected = {std::bit_cast<std::uint32_t>(edge->q),
                                (steps(edge->at_x, x) & 255U) | (steps(edge->at_y, y) & 255U) << 8 |
                                    static_cast<std::uint32_t>(edge->light * EDGE_UNIT) << 16};
                others += words[at] != expected[0] || words[at + 1] != expected[1];
            }
        EXPECT_EQ(others, 0U) << scene;
    }
}

}  // namespace
}  // namespace touchable::test
