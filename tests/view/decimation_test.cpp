#include "player/draw/pictures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "player/draw/gpu_painting.hpp"
#include "player/draw/view.hpp"
#include "tests/stand_ins.hpp"
#include "tests/view/many_colours.hpp"
#include "tests/view/shown.hpp"

namespace touchable::test {
namespace {

/// Where a vertex of the decimated lattice is in the whole one.
int whole_at(int n, int step, int vertices) {
    return std::min(n * step, vertices - 1);
}

/// One vertex after the other.
void expect_every(const Shown& shown, double blend, int step, VectorUnit unit) {
    const HeightField whole = shown.field(blend);
    const FramePair pair = shown.pair(blend);
    ASSERT_TRUE(SurfaceUnproject::has_codes(whole, pair));
    Decimation decimation(2, unit);
    decimation.make(whole, pair, {}, step);
    const HeightField& part = decimation.field();
    ASSERT_GE((part.width() - 1) * step, whole.width() - 1) << "nothing is missing at the right";
    ASSERT_GE((part.height() - 1) * step, whole.height() - 1);
    ASSERT_LT((part.width() - 2) * step, whole.width() - 1) << "and nothing is there twice";
    EXPECT_EQ(part.blend(), whole.blend());
    int valid = 0;
    for (int y = 0; y < part.height(); ++y)
        for (int x = 0; x < part.width(); ++x) {
            const int at_x = whole_at(x, step, whole.width()), at_y = whole_at(y, step, whole.height());
            const FieldVertex wanted = whole.vertex(at_x, at_y), is = part.vertex(x, y);
            ASSERT_EQ(is.valid, wanted.valid) << x << ", " << y;
            if (!is.valid) continue;
            ASSERT_EQ(is.depth, wanted.depth) << x << ", " << y;
            ++valid;
            if (at_x == x * step) {
                ASSERT_NEAR(part.scene().camera.u(x), whole.scene().camera.u(at_x), 1e-12);
            }
        }
    EXPECT_GT(valid, 20);
}

TEST(Decimation, HasEverySecondVertexAndEveryFourth) {
    for (const auto& [width, height] : {std::pair{172, 133}, {65, 34}, {127, 128}})
        for (const char* scene : {"globe", "noise", "grain"}) {
            SCOPED_TRACE(std::string(scene) + " " + std::to_string(width));
            const auto shown = shown_scene(scene, width, height);
            for (const VectorUnit unit : usable_vector_units())
                for (const int step : {2, 4, 8}) expect_every(*shown, step == 4 ? 0.25 : 0, step, unit);
        }
}

TEST(Decimation, TellsHolesAndHeights) {
    for (const char* recording : {"castel_sr300", "redwood5"}) {
        const auto shown = shown_stand_in(recording);
        ASSERT_NE(shown, nullptr);
        for (const int step : {2, 4}) expect_every(*shown, 0.5, step, usable_vector_units().front());
    }
}

void expect_means(int width, int height, int threads, VectorUnit unit) {
    const auto shown = shown_scene("globe", width, height);
    const ManyColours colours(width, height);
    const PlaneView from = colours.view();
    Decimation decimation(threads, unit);
    decimation.make(shown->field(), shown->pair(), from, 2);
    const PlaneView& half = decimation.colour();
    ASSERT_EQ(half.width, decimation.field().width());
    ASSERT_EQ(half.height, decimation.field().height());
    for (int y = 0; y < half.height; ++y)
        for (int x = 0; x < half.width; ++x)
            for (int channel = 0; channel < 3; ++channel) {
                int sum = 0;
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx)
                        sum += (2 - std::abs(dx)) * (2 - std::abs(dy)) *
                               from.sample(std::clamp(2 * x + dx, 0, width - 1),
                                           std::clamp(2 * y + dy, 0, height - 1), channel);
                ASSERT_EQ(half.sample(x, y, channel), (sum + 8) / 16) << x << ", " << y;
            }
    decimation.make(shown->field(), shown->pair(), from, 4);
    EXPECT_EQ(decimation.colour().width, decimation.field().width());
    EXPECT_EQ(decimation.colour().height, decimation.field().height());
}

TEST(Decimation, MeansColoursAroundEachVertex) {
    for (const VectorUnit unit : usable_vector_units())
        for (const int threads : {1, 2})
            for (const auto& [width, height] : {std::pair{37, 22}, {130, 71}})
                expect_means(width, height, threads, unit);
}

TEST(Decimation, IsOfWhatAWindowDoesNotTellApart) {
    EXPECT_EQ(SurfaceDrawing::step_for(1280.0 / 720), 1);
    EXPECT_EQ(SurfaceDrawing::step_for(0.76), 1);
    EXPECT_EQ(SurfaceDrawing::step_for(1280.0 / 1920), 2);
    EXPECT_EQ(SurfaceDrawing::step_for(0.5), 2);
    EXPECT_EQ(SurfaceDrawing::step_for(0.3), 4);
    EXPECT_EQ(SurfaceDrawing::step_for(1e-9), 8);
}

TEST(Decimation, LooksFromTheSamePlace) {
    const auto shown = shown_scene("globe", 64, 48);
    const ViewCamera camera =
        make_view(*parse_viewpoint("orbit:az=30,el=10"), shown->scene, {0, 0, -0.7}, 320, 200);
    const ViewCamera coarse = decimated(camera, 4);
    for (const glm::dvec2 at : {glm::dvec2(0, 0), glm::dvec2(12, 7)}) {
        const glm::dvec4 one = camera.clip_from_lattice * glm::dvec4(4.0 * at, 1, 2),
                         other = coarse.clip_from_lattice * glm::dvec4(at, 1, 2);
        for (int k = 0; k < 4; ++k) EXPECT_NEAR(one[k], other[k], 1e-9);
    }
}

}  // namespace
}  // namespace touchable::test
