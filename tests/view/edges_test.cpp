// SPDX-License-Identifier: Apache-2.0
// Where vertices at edges are drawn: along the edge that their pixels tell of, and never across themselves.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "player/draw/cpu_painting.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/overlay_rows.hpp"
#include "player/draw/pictures.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/view.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

/// A lattice and where its vertices are drawn.
struct Drawn {
    int width, height;
    std::vector<float> q;
    float ratio = CUT_RULE_RATIO;
    static constexpr float steepest = 0.015F;
    SurfaceEdges edges{1};

    Drawn(int columns, int rows, const std::function<float(int x, int y)>& q_at, float cut = CUT_RULE_RATIO)
        : width(columns), height(rows), ratio(cut) {
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) q.push_back(q_at(x, y));
        edges.find({q.data(), width, height, width, ratio, steepest});
    }
    float at(int x, int y) const { return q[static_cast<std::size_t>(y * width + x)]; }
    float eroded(int x, int y) const { return edges.eroded_q()[static_cast<std::size_t>(y * width + x)]; }
    glm::dvec2 place(int x, int y) const {
        const auto* edge = edges.at(x, y);
        return edge != nullptr ? glm::dvec2(edge->at_x, edge->at_y) : glm::dvec2(x, y);
    }
    bool is_kept(const std::array<std::array<int, 2>, 3>& corners) const {
        float least = 1e9F, most = 0;
        for (const auto& [x, y] : corners) {
            least = std::min(least, eroded(x, y));
            most = std::max(most, eroded(x, y));
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

TEST(SurfaceEdges, FollowHalfPlane) {
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

TEST(SurfaceEdges, MoveOutwardsLessThanPixel) {
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
    const auto unit = [&engine] { return engine() / 4294967296.0; };
    for (const double holes : {0.02, 0.1, 0.3, 0.6})
        for (int run = 0; run < 20; ++run) {
            // Patches of two surfaces and holes, of all shapes: each pixel is one of them, or as its
            // neighbour.
            std::vector<float> last(80, 0.01F);
            float left = 0.01F;
            const Drawn drawn(80, 60, [&](int x, int) {
                const double dice = unit();
                const float fresh = unit() < holes ? 0.0F : unit() < 0.5 ? 0.01F : 0.0125F;
                left = dice < 0.45 ? left : dice < 0.9 ? last[static_cast<std::size_t>(x)] : fresh;
                last[static_cast<std::size_t>(x)] = left;
                return left == 0.0F ? left : left * (1 + 0.03F * static_cast<float>(unit()));
            });
            int drawn_triangles = 0;
            drawn.for_each_area([&](double area) {
                ++drawn_triangles;
                EXPECT_GT(area, 0.05);
            });
            EXPECT_GT(drawn_triangles, 500);
        }
}

/// Up to two vertices that fall away steeply beside a gap are eroded; so is one of what lies behind a gap.
TEST(SurfaceEdges, ErodeWhatIsSteepBesideGap) {
    for (const float steep : {0.0F, 0.01F, 0.02F, 0.04F, 0.055F}) {
        const Drawn drawn(40, 40, [&](int x, int) {
            return x < 20 ? 0.02F * std::pow(1 - steep, static_cast<float>(x - 19)) : 0.015F;
        });
        for (int x = 0; x < 40; ++x) {
            const bool is_eroded = (steep > Drawn::steepest && (x == 18 || x == 19)) || x == 20;
            EXPECT_EQ(drawn.eroded(x, 20), is_eroded ? -drawn.at(x, 20) : drawn.at(x, 20))
                << steep << ' ' << x;
        }
    }
    const Drawn steep_alone(40, 40,
                            [](int x, int) { return 0.02F * std::pow(0.95F, static_cast<float>(x)); });
    EXPECT_EQ(steep_alone.q, std::vector(steep_alone.edges.eroded_q(), steep_alone.edges.eroded_q() + 1600));
}

/// A ball before something far falls away at its limb, where each vertex by itself would be as deep as the
/// step of the limb that it is in. It ends where it becomes too steep, which is a circle.
TEST(SurfaceEdges, BallEndsInCircle) {
    const double focal = 400, middle = 80.3, radius = 60, across = radius / focal;
    const Drawn drawn(160, 160, [&](int x, int y) {
        const double u = (x - middle) / focal, v = (y - middle) / focal, ray = u * u + v * v + 1;
        const double rest = 1 - ray * (1 - across * across);
        return static_cast<float>(rest > 0 ? ray / (1 - std::sqrt(rest)) : 0.5);
    });
    int compared = 0;
    double nearest = 1e9, farthest = 0, shallowest = 0, deepest = 1e9, before = 0;
    for (int y = 0; y < 160; ++y)
        for (const auto& edge : drawn.edges.row(y)) {
            if (drawn.eroded(edge.x, y) < 0.75F) continue;
            ++compared;
            const double from_middle = std::hypot(edge.at_x - middle, edge.at_y - middle);
            nearest = std::min(nearest, from_middle);
            farthest = std::max(farthest, from_middle);
            shallowest = std::max(shallowest, static_cast<double>(edge.q));
            deepest = std::min(deepest, static_cast<double>(edge.q));
            before = std::max(before, std::hypot(edge.x - middle, y - middle));
        }
    EXPECT_GT(compared, 300);
    EXPECT_LT(farthest - nearest, 0.6) << nearest << " to " << farthest;
    // A twentieth of the radius: 3 pixels from the side, where a step of a pixel at the limb is 11.
    EXPECT_LT(shallowest / deepest, 1 + 0.05 * across);
}

/// A plane aslant goes on as a plane, whatever the pixel at its edge holds.
TEST(SurfaceEdges, ContinueTheirPlane) {
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

TEST(SurfaceEdges, ExcludePictureBorder) {
    const Drawn whole(40, 30, [](int x, int) { return 0.01F + 1e-5F * static_cast<float>(x); });
    for (int y = 0; y < 30; ++y) EXPECT_TRUE(whole.edges.row(y).empty());
    const Drawn half(40, 30, near_where([](int x, int) { return x < 20; }));
    for (int y = 0; y < 30; ++y) {
        ASSERT_EQ(half.edges.row(y).size(), 2U) << y;
        EXPECT_EQ(half.edges.row(y)[0].at_x, 19.5F);
        EXPECT_EQ(half.edges.row(y)[1].at_x, 20.5F) << "one of what lies behind is eroded";
        EXPECT_EQ(half.edges.row(y)[0].at_y, static_cast<float>(y));
    }
}

TEST(SurfaceEdges, AgreeForThreadsAndVectors) {
    for (const char* scene : {"globe", "cliffs", "noise"}) {
        const auto shown = shown_scene(scene, 203, 133);
        const std::vector<float> q = q_of(shown->field());
        std::size_t found = 0;
        for (const int threads : {1, 2})
            for (const VectorUnit unit : usable_vector_units()) {
                SurfaceEdges edges(threads, unit);
                EdgeLattice lattice{q.data(), 203, 133, 203, CUT_RULE_RATIO, 0.01F};
                edges.find(lattice);
                std::vector<float> eroded;
                for (int y = 0; y < 133; ++y)
                    for (int x = 0; x < 203; ++x) eroded.push_back(edge_eroded_q(lattice, {x, y}));
                ASSERT_TRUE(std::ranges::equal(eroded, std::span(edges.eroded_q(), eroded.size()))) << scene;
                EXPECT_GT(std::ranges::count_if(eroded, [](float each) { return each < 0; }), 100) << scene;
                lattice.q = eroded.data();
                for (int y = 0; y < 133; ++y)
                    for (int x = 0; x < 203; ++x) {
                        const EdgeMove move = edge_move(lattice, {x, y});
                        const float here = eroded[static_cast<std::size_t>(y * 203 + x)];
                        const auto* edge = edges.at(x, y);
                        ASSERT_EQ(edge != nullptr, move.by != ivec2(0, 0) || move.q != here)
                            << x << ", " << y;
                        if (edge == nullptr) continue;
                        ++found;
                        ASSERT_EQ(edge->q, move.q);
                        ASSERT_EQ(edge->at_x,
                                  static_cast<float>(x) + static_cast<float>(move.by.x) / EDGE_UNIT);
                        ASSERT_EQ(edge->at_y,
                                  static_cast<float>(y) + static_cast<float>(move.by.y) / EDGE_UNIT);
                    }
            }
        EXPECT_GT(found, 500U) << scene;
    }
}

class GpuEdges : public GpuTest {
protected:
    /// The kernel's output, copied for the CPU: a GPU may have memory of its own.
    GpuBuffer edges_by_kernel(GpuLattices& lattices, const ViewCamera& camera, GpuLattice& lattice) {
        auto commands = must(GpuCommands::begin(gpu, "edges"));
        must(lattices.record_view(commands, !is_own_view(camera), lattice));
        GpuBuffer back =
            must(GpuBuffer::create(*gpu, "edges read back", lattice.edges.bytes(), GpuMemory::readback));
        commands.barrier(GpuStage::compute, GpuStage::transfer);
        commands.copy(lattice.edges, 0, back, 0, back.bytes());
        must(must(std::move(commands).submit()).wait());
        return back;
    }
};

TEST_F(GpuEdges, MatchCpuToTheBit) {
    GpuLattices lattices(gpu);
    for (const char* scene : {"globe", "cliffs", "noise"}) {
        const auto shown = shown_scene(scene, 203, 133);
        const HeightField field = shown->field();
        GpuLattice lattice = must(lattices.lattice_of(make_view_surface(field, {})));
        const ViewCamera camera = view_of(*shown, field, "orbit:az=20,el=5", 90, 60);
        const GpuBuffer written = edges_by_kernel(lattices, camera, lattice);
        const auto words = written.mapped<std::uint32_t>();
        const std::vector<float> q = q_of(field);
        SurfaceEdges edges(1);
        edges.find(edge_lattice(q.data(), 203, 133, 203, 1, static_cast<float>(shown->scene.camera.fx)));
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
                                (steps(edge->at_x, x) & 255U) | (steps(edge->at_y, y) & 255U) << 8};
                others += words[at] != expected[0] || words[at + 1] != expected[1];
            }
        EXPECT_EQ(others, 0U) << scene;
    }
}

/// The painter that others are held against, with 16 samples a pixel: slow and obvious.
PicturePlanes reference_picture(const ViewSurface& surface, const Shown& shown, const HeightField& field,
                                const char* words, int width, int height) {
    constexpr int side = 4;
    PicturePlanes fine = plain_picture(surface, view_of(shown, field, words, side * width, side * height));
    PicturePlanes out{width, height, {}, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::array<unsigned, 3> sums{};
            for (int k = 0; k < side * side; ++k) {
                const std::size_t at = fine.index(side * x + k % side, side * y + k / side);
                const PackedColour colour = fine.z[at] > 0 ? fine.colours[at] : background_colour(y, height);
                for (unsigned channel = 0; channel < 3; ++channel)
                    sums[channel] += colour >> 8 * channel & 255U;
            }
            out.colours.push_back(pack_colour(sums[0] / 16, sums[1] / 16, sums[2] / 16));
        }
    return out;
}

/// The globe's limb, seen from its side, is an ellipse: a step of a pixel there would be one of ten.
TEST(TurnedView, LimbHasNoTeeth) {
    const auto shown = shown_scene("globe", 720, 480);
    const HeightField field = shown->field();
    const ViewSurface surface = make_view_surface(field, {});
    const Viewpoint::Subject subject = subject_of(field);
    Viewpoint viewpoint = *parse_viewpoint("orbit:az=70,el=0");
    viewpoint.zoom = whole_zoom(viewpoint, shown->scene, subject.middle, subject.points, 1280, 800);
    const ViewCamera camera = make_view(viewpoint, shown->scene, subject.middle, 1280, 800);
    const PicturePlanes planes = must(make_cpu_painter()->paint(surface, camera));
    std::vector<glm::dvec2> limb;
    for (int y = 180; y < 620; ++y) {
        int x = planes.width - 1;
        while (x > 0 && !(planes.z[planes.index(x, y)] > 0)) --x;
        limb.emplace_back((x - 1000) / 400.0, (y - 400) / 400.0);
    }
    // x = a + b y + c y^2 + d y^4, which an ellipse is here to a fifth of a pixel, by least squares.
    const auto terms_of = [](double y) { return glm::dvec4(1, y, y * y, y * y * y * y); };
    glm::dmat4 products(0.0);
    glm::dvec4 targets(0.0);
    for (const glm::dvec2& at : limb) {
        products += glm::outerProduct(terms_of(at.y), terms_of(at.y));
        targets += at.x * terms_of(at.y);
    }
    const glm::dvec4 fitted = glm::inverse(products) * targets;
    const auto off = std::ranges::count_if(limb, [&](const glm::dvec2& at) {
        return std::fabs(400 * (glm::dot(fitted, terms_of(at.y)) - at.x)) >= 2;
    });
    EXPECT_LE(off, 5) << "of 440 rows";
}

TEST(Silhouettes, ApproachReference) {
    const auto shown = shown_scene("globe", 360, 240);
    const HeightField field = shown->field();
    const ViewSurface surface = make_view_surface(field, {});
    for (const char* words : {"orbit:az=25,el=10", "orbit:az=-50,el=-20"}) {
        const PicturePlanes reference = reference_picture(surface, *shown, field, words, 480, 300);
        const PicturePlanes hard =
            before_background(plain_picture(surface, view_of(*shown, field, words, 480, 300)));
        std::vector<PackedColour> first;
        for (const VectorUnit unit : usable_vector_units()) {
            PicturePlanes smooth = hard;
            Silhouettes(unit).smooth(smooth.colours, smooth.z, 480, 300);
            if (first.empty()) first = smooth.colours;
            EXPECT_EQ(smooth.colours, first);
        }
        double before = 0, after = 0;
        for (int y = 0; y < 300; ++y)
            for (int x = 0; x + 1 < 480; ++x) {
                const std::size_t at = hard.index(x, y);
                if (first[at] == hard.colours[at]) continue;
                before += std::pow(colour_distance(hard.colours[at], reference.colours[at]), 2);
                after += std::pow(colour_distance(first[at], reference.colours[at]), 2);
            }
        EXPECT_GT(before, 1e5);
        EXPECT_LT(after, 0.4 * before) << words;
    }
}

/// Both ends of a long step are smoothed alike, wherever it lies.
TEST(Silhouettes, SmoothBothEndsOfLongSteps) {
    for (const int length : {1, 2, 40, 127, 128, 129, 400}) {
        PicturePlanes planes{4, length + 20, {}, {}};
        for (int y = 0; y < planes.height; ++y)
            for (int x = 0; x < 4; ++x) {
                const bool is_near = x < (y < 10 ? 1 : y < 10 + length ? 2 : 3);
                planes.z.push_back(is_near ? 0.5F : 0.1F);
                planes.colours.push_back(is_near ? pack_colour(255, 255, 255) : pack_colour(0, 0, 0));
            }
        Silhouettes().smooth(planes.colours, planes.z, planes.width, planes.height);
        const auto white = [&](int y) {  // in a row, pixels
            double sum = 0;
            for (int x = 0; x < 4; ++x) sum += (planes.colours[planes.index(x, y)] & 255U) / 255.0;
            return sum;
        };
        for (int y = 10; y < 10 + length; ++y) {
            EXPECT_NEAR(white(y) + white(19 + length - y), 4, 0.02) << length << ": " << y;
            EXPECT_LE(std::fabs(white(y) - 2), 0.51);
        }
        if (length > 2) {
            EXPECT_NEAR(white(10), 1.5, 0.03) << length;
        }
    }
}

/// A square before a plane: what a turned view uncovers has the plane's colour, and is behind all else.
TEST(TurnedView, FillsGapsFromBehind) {
    auto shown = shown_scene("globe", 120, 80);
    std::vector<double> depths(120 * 80);
    std::vector<std::uint8_t> rgb;
    for (int k = 0; k < 120 * 80; ++k) {
        const bool is_near = k % 120 >= 40 && k % 120 < 80 && k / 120 >= 20 && k / 120 < 60;
        depths[static_cast<std::size_t>(k)] = is_near ? 60 : 100;
        for (const int value : {is_near ? 250 : 30, 40, is_near ? 20 : 200})
            rgb.push_back(static_cast<std::uint8_t>(value));
    }
    shown->prev.vertices = std::make_unique<ExactVertices>(120, 80, depths);
    const HeightField field = shown->field();
    const PlaneView colour{rgb.data(), 360, 120, 80, 1, 3};
    const ViewCamera camera = view_of(*shown, field, "orbit:az=25,el=0", 480, 320);
    const PicturePlanes filled = plain_picture(make_view_surface(field, colour, Lighting::off), camera),
                        empty = plain_picture(make_view_surface(field, colour, Lighting::values), camera);
    int gaps = 0;
    for (std::size_t at = 0; at < filled.z.size(); ++at) {
        if (empty.z[at] > 0) {
            ASSERT_EQ(filled.z[at], empty.z[at]);
            ASSERT_EQ(filled.colours[at], empty.colours[at]);
        } else if (filled.z[at] > 0) {
            ++gaps;
            ASSERT_LT(filled.z[at], 1e-7F);
            ASSERT_EQ(filled.colours[at], pack_colour(30, 40, 200));
        }
    }
    EXPECT_GT(gaps, 1000);
}

// A surface that gives way under fingers, as pictures show it: the plain twin. (The GPU's is compared with it
// in drawing_test.cpp.)

TEST(GivenWay, IsForceByStiffness) {
    // 3 N on 1.5 N/mm are 2 mm of the hand; at 0.5 m of the hand for a unit of the scene 0.004 units.
    const glm::dvec3 way = given_way({0, 0, 3}, 1500, 0.5);
    EXPECT_NEAR(way.z, -0.004, 1e-15);
    EXPECT_EQ(glm::length(given_way({1, 2, 3}, 0, 0.5)), 0) << "no spring";
    EXPECT_EQ(glm::length(given_way({NAN, 2, 3}, 1500, 0.5)), 0);
}

TEST(UnderFinger, FindsFootNormalAndHeight) {
    const auto shown = shown_scene("plane", 96, 64);  // 20 degrees about the picture's vertical
    const HeightField field = shown->field();
    const Camera& camera = shown->scene.camera;
    // Three places of the plane, by its depth alone.
    const auto point = [&](int x, int y) {
        return unproject(camera, x, y,
                         planar_depth(camera, shown->scene.depth.semantics, x, y, field.vertex(x, y).depth));
    };
    const glm::dvec3 at = point(40, 30);
    const glm::dvec3 normal = glm::normalize(glm::cross(point(60, 30) - at, point(40, 10) - at));
    const double high = 0.01 * -at.z;
    const auto under = under_finger(field, at + high * normal, 0.05 * -at.z);
    ASSERT_TRUE(under);
    EXPECT_GT(glm::dot(under->normal, normal), 0.9999);
    EXPECT_NEAR(under->height, high, 0.02 * high);
    EXPECT_LT(glm::distance(under->foot, at), 0.03 * high);
    EXPECT_EQ(under_finger(field, at - high * normal, 0.05 * -at.z)->height, 0) << "behind it";
    EXPECT_FALSE(under_finger(field, {0, 0, 1}, 1)) << "behind the camera";
    EXPECT_FALSE(under_finger(field, unproject(camera, -5, 30, -at.z), 1)) << "beside the picture";
}

/// A plane that faces the camera, seen by it, in colours that tell where they come from: two columns of it
/// differ, and no light is on it.
class DentedPlane : public ::testing::Test {
protected:
    DentedPlane() {
        SceneOptions options;
        options.width = width;
        options.height = height;
        options.tilt_degrees = 0;
        shown_ = shown_scene("plane", options);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (const int value : {x, y, 100}) bytes_.push_back(static_cast<std::uint8_t>(value));
        drawing_.show(shown_->field(), shown_->pair(),
                      PlaneView{bytes_.data(), std::ptrdiff_t{3} * width, width, height, 1, 3},
                      Lighting::values);
        camera_ = own_view(shown_->scene, width, height, 1e-3 * shown_->scene.depth.near);
        const double depth = planar_depth(shown_->scene.camera, shown_->scene.depth.semantics, width / 2,
                                          height / 2, shown_->field().vertex(width / 2, height / 2).depth);
        pixel_ = depth / shown_->scene.camera.fx;
        sizes_ = {20 * pixel_, 40 * pixel_};
    }
    /// Which touches at a pixel and takes the surface along by so many pixels, y upward.
    FingerMark finger_at(double x, double y, const glm::dvec3& pixels) const {
        FingerMark finger;
        const Camera& camera = shown_->scene.camera;
        finger.proxy = finger.goal = unproject(camera, x, y, pixel_ * camera.fx);
        finger.touching = true;
        finger.under = FingerMark::Under{finger.proxy, {0, 0, 1}, 0};
        finger.given_way = pixels * pixel_;
        return finger;
    }
    /// Dents alone: the picture without the fingers that make them.
    LightPicture dented(const std::vector<FingerMark>& fingers) {
        LightPicture picture{width, height, std::vector<float>(bytes_.size() / 3), {}};
        const Image flat = *drawn({});
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint8_t* rgb = &flat.samples[3 * picture.index(x, y)];
                picture.light.push_back(light_of(pack_colour(rgb[0], rgb[1], rgb[2])));
                const auto at =
                    camera_.project(unproject(shown_->scene.camera, x, y, pixel_ * shown_->scene.camera.fx));
                picture.z[picture.index(x, y)] = static_cast<float>(at->z);
            }
        std::vector<SurfaceDent> dents;
        shape_dents(fingers, sizes_, dents);
        draw_dents(dents, camera_, picture);
        return picture;
    }
    const Image* drawn(const std::vector<FingerMark>& fingers) {
        const auto picture = drawing_.draw(camera_, fingers, sizes_);
        EXPECT_TRUE(picture);
        return *picture;
    }
    static glm::vec3 bytes_at(const LightPicture& picture, int x, int y) {
        return 255.0F * brightness_of(picture.light[picture.index(x, y)]);
    }

    static constexpr int width = 240, height = 160;
    std::unique_ptr<Shown> shown_;
    std::vector<std::uint8_t> bytes_;
    CpuDrawing drawing_;
    ViewCamera camera_;
    double pixel_ = 1;  // scene units, at the plane
    MarkSizes sizes_;
};

TEST_F(DentedPlane, ColoursFollowFinger) {
    const LightPicture flat = dented({}), picture = dented({finger_at(120, 80, {6, 0, 0})});
    // The colour moved by 6 pixels; half a reach (26 pixels) away by 6 (1 - 1/4)^3.
    EXPECT_NEAR(bytes_at(picture, 120, 80).x, bytes_at(flat, 120, 80).x - 6, 0.7);
    EXPECT_NEAR(bytes_at(picture, 120, 80).y, bytes_at(flat, 120, 80).y, 0.7);
    EXPECT_NEAR(bytes_at(picture, 120, 54).x, bytes_at(flat, 120, 54).x - 6 * 0.4219, 0.7);
    // Where it does not reach (2.6 radii of 20 pixels) all is as it was, to the bit.
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (std::hypot(x - 120, y - 80) <= 53) continue;
            ASSERT_EQ(picture.light[picture.index(x, y)], flat.light[flat.index(x, y)]) << x << ' ' << y;
        }
}

TEST_F(DentedPlane, LightFollowsSlopes) {
    const LightPicture flat = dented({}), picture = dented({finger_at(120, 80, {0, 0, -12})});
    const auto light = [&](int x, int y) { return bytes_at(picture, x, y).z / bytes_at(flat, x, y).z; };
    // 12 pixels deep, 52 wide: at 26 pixels the slope is 6 (12/52) (3/4)^2 (1/2) = 0.389, and twice that in
    // the light, which comes from the upper left. By hand from shaders/surface_light.h and dents.h, of 100.
    EXPECT_NEAR(light(120, 80), 1, 0.01) << "the ground is level";
    EXPECT_NEAR(light(120, 106), 1.443, 0.01);
    EXPECT_NEAR(light(120, 54), 0.554, 0.01);
    EXPECT_NEAR(light(146, 80), 1.120, 0.01);
    EXPECT_NEAR(light(94, 80), 0.716, 0.01);
}

TEST_F(DentedPlane, DepthIsLimited) {
    std::vector<SurfaceDent> dents;
    shape_dents(std::vector{finger_at(120, 80, {0, 0, -300})}, sizes_, dents);
    ASSERT_EQ(dents.size(), 1U);
    EXPECT_NEAR(glm::length(dents[0].moved), 1.3 * sizes_.finger_radius, 1e-9 * pixel_);
    auto free = finger_at(120, 80, {0, 0, -3});
    free.touching = false;
    auto firm = finger_at(120, 80, {0, 0, 0});
    shape_dents(std::vector{free, firm}, sizes_, dents);
    EXPECT_TRUE(dents.empty());
}

TEST_F(DentedPlane, OverlappingDentsCommute) {
    const FingerMark left = finger_at(100, 80, {4, 3, -8}), right = finger_at(140, 80, {-5, 2, -9});
    const LightPicture one = dented({left, right}), other = dented({right, left});
    for (std::size_t k = 0; k < one.light.size(); ++k)
        ASSERT_LT(glm::distance(one.light[k], other.light[k]), 1e-5F);
    const LightPicture alone = dented({left});
    EXPECT_GT(glm::distance(one.light[one.index(120, 80)], alone.light[one.index(120, 80)]), 0.005F);
}

/// A dent is on the surface alone.
TEST_F(DentedPlane, BackgroundStays) {
    LightPicture empty{width, height, std::vector<float>(bytes_.size() / 3, 0.0F),
                       std::vector<glm::vec3>(bytes_.size() / 3, glm::vec3(0.5F))};
    std::vector<SurfaceDent> dents;
    shape_dents(std::vector{finger_at(120, 80, {9, 0, -9})}, sizes_, dents);
    draw_dents(dents, camera_, empty);
    for (const glm::vec3& light : empty.light) ASSERT_EQ(light, glm::vec3(0.5F));
}

// Between two frames of a thing that moves, nothing is drawn in the air where its edge has travelled.

constexpr int width = 96, height = 40;
using Millimetres = std::function<int(int x)>;

/// Two frames of metric codes of a millimetre, 1/30 s apart, each the same in all rows.
struct TwoFrames {
    TwoFrames(const Millimetres& before, const Millimetres& after) {
        scene.width = width;
        scene.height = height;
        scene.metres_per_unit = 1;
        scene.camera = {90, 90, 0.5 * (width - 1), 0.5 * (height - 1)};
        scene.depth.kind = DepthCodingKind::metric;
        scene.depth.semantics = DepthSemantics::planar;
        scene.depth.scale = 0.001;
        scene.depth.far = 60;
        scene.depth.code_max = 65535;
        derive_valid_range(scene.depth);
        make(prev, before);
        make(next, after);
    }
    void make(SurfaceFrame& frame, const Millimetres& millimetres) {
        frame.width = width;
        frame.height = height;
        frame.coding = scene.depth;
        for (int k = 0; k < width * height; ++k)
            frame.codes.push_back(static_cast<std::uint16_t>(millimetres(k % width)));
        frame.validity.assign(
            static_cast<std::size_t>(frame.validity_words_per_row()) * static_cast<std::size_t>(height), ~0U);
        const TileGrid tiles = TileGrid::of(width, height);
        const auto [least, greatest] = std::minmax_element(frame.codes.begin(), frame.codes.end());
        for (int k = 0; k < tiles.tiles_x * tiles.tiles_y; ++k) frame.tiles.push_back({*least, *greatest});
        frame.vertices = std::make_unique<FilteredVertices>(frame);
    }
    FramePair pair(double blend) const { return {{0, 0, &prev}, {1, 33'333'333, &next}, blend}; }

    Scene scene;
    SurfaceFrame prev, next;
};

/// A box of 30 columns at 1 m before a wall at 2 m.
Millimetres box_from(int left) {
    return [left](int x) { return x >= left && x < left + 30 ? 1000 : 2000; };
}

/// Planar depths of what is drawn, m, by every painter and reader.
class MovingEdge : public GpuTest {
protected:
    std::vector<std::vector<double>> drawn(const TwoFrames& two, double blend) {
        const FramePair pair = two.pair(blend);
        const HeightField field(two.scene, pair);
        std::vector<std::vector<double>> all;
        const auto of_q = [&](const std::vector<float>& q) {
            auto& depths = all.emplace_back();
            for (const float each : q) depths.push_back(1 / static_cast<double>(each));
        };
        GpuLattices lattices(gpu);
        of_q(q_of(field));
        of_q(surface_of(field, pair, {}, Lighting::full).q);
        of_q(q_by_kernel(gpu, lattices, field, pair));
        std::vector<double> values, rows;
        ScalarRows reads;
        reads.begin(Scalar::depth, field, pair);
        std::vector<float> row(width);
        for (int y = 0; y < height; ++y) {
            reads.read(y, row.data());
            rows.insert(rows.end(), row.begin(), row.end());
            for (int x = 0; x < width; ++x) values.push_back(values_at(field, pair, x, y).depth);
        }
        all.push_back(values);
        all.push_back(rows);
        return all;
    }

    const TwoFrames frames{box_from(30), box_from(37)};  // it moves by seven columns
};

TEST_F(MovingEdge, LeavesNothingInTheAir) {
    for (const double blend : {0.25, 0.5, 0.75}) {
        const auto all = drawn(frames, blend);
        const int left = blend < 0.5 ? 30 : 37;
        for (std::size_t who = 0; who < all.size(); ++who)
            for (int k = 0; k < width * height; ++k)
                ASSERT_NEAR(all[who][static_cast<std::size_t>(k)], 0.001 * box_from(left)(k % width), 1e-5)
                    << "column " << k % width << ", reader " << who << ", blend " << blend;
    }
}

TEST_F(MovingEdge, IsFeltAsRamp) {
    const FramePair pair = frames.pair(0.5);
    EXPECT_DOUBLE_EQ(HeightField(frames.scene, pair).vertex(33, 20).depth, 1.5);
}

TEST_F(MovingEdge, IsPickedAsDrawn) {
    const FramePair pair = frames.pair(0.5);
    const HeightField field(frames.scene, pair);
    const ViewCamera aside =
        make_view(*parse_viewpoint("orbit:az=40,el=0"), frames.scene, {0, 0, -1.5}, 160, 100);
    int boxes = 0, walls = 0;
    for (int x = 0; x < 160; ++x) {
        const auto met = pick(field, aside, x + 0.5, 50);
        if (!met || !met->drawn) continue;
        (met->depth < 1.5 ? boxes : walls) += 1;
        ASSERT_NEAR(met->depth, met->depth < 1.5 ? 1 : 2, 1e-6) << x;
        // From aside edges are half a pixel outside the last vertex.
        ASSERT_EQ(met->depth < 1.5, met->x >= 36.5 && met->x <= 66.5) << x;
    }
    EXPECT_GT(boxes, 10);
    EXPECT_GT(walls, 10);
}

TEST_F(MovingEdge, IgnoresApproachAtHandSpeed) {
    for (const int distance : {400, 1000, 5000}) {  // 66 mm in 1/30 s are 2 m/s
        const TwoFrames nearer([=](int) { return distance; }, [=](int) { return distance - 66; });
        for (const auto& depths : drawn(nearer, 0.25))
            for (const double depth : depths) ASSERT_NEAR(depth, 0.001 * distance - 0.0165, 1e-5) << distance;
    }
}

TEST_F(MovingEdge, MixesWithinSpeedAndDistance) {
    const struct {
        int before, after;
        bool is_mixed;
    } cases[] = {{1000, 1066, true}, {1000, 1068, false},                      // 2 m/s
                 {2000, 2124, true}, {2000, 2126, false},                      // a sixteenth
                 {100, 124, true},   {100, 126, false},   {126, 100, false}};  // a quarter
    for (const auto& each : cases) {
        const TwoFrames two([&](int) { return each.before; }, [&](int) { return each.after; });
        const double wanted = 0.001 * (each.is_mixed ? 0.75 * each.before + 0.25 * each.after : each.before);
        for (const auto& depths : drawn(two, 0.25))
            ASSERT_NEAR(depths[0], wanted, 1e-5) << each.before << " to " << each.after;
    }
}

TEST_F(MovingEdge, IgnoresSlowClips) {
    FramePair pair = frames.pair(0.5);
    pair.next.time_ns = 2'000'000'000;
    EXPECT_EQ(drawn_vertex(HeightField(frames.scene, pair), 33, 20).depth, 2);
    EXPECT_NEAR(blend_reach(HeightField(frames.scene, pair)), 2 / 24., 1e-6);
}

}  // namespace
}  // namespace touchable::test
