// How far the faces of a structured-light recording are off the planes around them: with and without its
// levels.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "engine/formats/open_clip.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

constexpr int reach = 15;  // windows of 31x31 pixels

/// The plane 1 / depth = at + right (x - x0) + down (y - y0) of the pixels around (x0, y0).
struct Plane {
    double at = 0, right = 0, down = 0;
    double residual = 0;  // RMS
};

glm::dvec3 normal_of(const Plane& plane, const Camera& camera, int x, int y) {
    return glm::normalize(
        glm::dvec3(plane.right * camera.fx, plane.down * camera.fy,
                   plane.at - plane.right * (x - camera.cx) - plane.down * (y - camera.cy)));
}

/// Nothing where a pixel of the window is invalid.
std::optional<Plane> plane_around(const RawFrame& raw, const DepthCoding& coding, int x0, int y0) {
    double sum = 0, along_x = 0, along_y = 0, square = 0, steps = 0;
    for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
            const std::uint16_t code = raw.depth.sample(x0 + dx, y0 + dy);
            if (!coding.is_valid(code)) return std::nullopt;
            const double q = 1 / coding.depth(code);
            sum += q;
            along_x += dx * q;
            along_y += dy * q;
            square += q * q;
            steps += dx * dx;
        }
    const double count = (2 * reach + 1) * (2 * reach + 1);
    Plane plane{sum / count, along_x / steps, along_y / steps, 0};
    const double rest = square - sum * plane.at - (plane.right * along_x + plane.down * along_y);
    plane.residual = std::sqrt(std::max(rest, 0.0) / count);
    return plane;
}

/// Degrees RMS between the faces of the surface and the planes around them, over what is flat to half a
/// level.
double off_the_planes(const RawFrame& raw, const Scene& scene, double level) {
    SurfaceFrame surface;
    EXPECT_TRUE(make_cpu_builder(scene)->build(raw, surface));
    double sum = 0;
    int faces = 0;
    const auto q = [&](int x, int y) { return 1 / sample_of(surface, x, y).depth; };
    for (int y = reach; y < scene.height - reach; y += 5)
        for (int x = reach; x < scene.width - reach; x += 5) {
            const auto plane = plane_around(raw, scene.depth, x, y);
            if (!plane || plane->residual > 0.45 * level) continue;
            const Plane face{q(x, y), q(x + 1, y) - q(x, y), q(x + 1, y + 1) - q(x + 1, y), 0};
            const double cosine =
                glm::dot(normal_of(face, scene.camera, x, y), normal_of(*plane, scene.camera, x, y));
            const double angle = std::acos(std::min(cosine, 1.0)) * 57.29577951308232;
            sum += angle * angle;
            ++faces;
        }
    EXPECT_GT(faces, 1000);
    return std::sqrt(sum / faces);
}

/// Degrees RMS: at least with levels in, at most without them.
struct Off {
    double stored, millimetres, measured;
};

void expect_faces_on_planes(const std::filesystem::path& folder, const std::filesystem::path& scene_file,
                            const Off& limits) {
    auto reader = open_clip(folder, scene_file);
    ASSERT_TRUE(reader) << reader.error().message;
    Scene scene = (*reader)->scene();
    DepthEstimator estimator(scene);
    const auto first = (*reader)->next();
    ASSERT_TRUE(first && *first);
    estimator.add(**first);
    const DepthLength levels = estimator.measured()->levels;
    scene.filter.fill_holes = 0;
    scene.filter.median = 0;
    const double stored = off_the_planes(**first, scene, levels.quadratic);
    scene.filter.median = 5;
    const double median = off_the_planes(**first, scene, levels.quadratic);
    scene.filter.terraces = TerraceRemoval::on;
    const double millimetres = off_the_planes(**first, scene, levels.quadratic);
    scene.filter.levels = levels;
    const double measured = off_the_planes(**first, scene, levels.quadratic);
    std::printf("degrees RMS: stored %.1f, median %.1f, terraces of millimetres %.1f, of levels %.1f\n",
                stored, median, millimetres, measured);
    EXPECT_GT(stored, limits.stored);
    EXPECT_GT(millimetres, limits.millimetres) << "which is what levels are for";
    EXPECT_LT(measured, limits.measured);
}

TEST(RealLevels, FacesOfACameraThatStoresMillimetresLieOnThePlanesAroundThem) {
    TOUCHABLE_NEEDS_DATA(real_data("stills/redwood5"));
    expect_faces_on_planes(real_data("stills/redwood5"),
                           std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes/redwood5.json",
                           {40, 30, 3});
}

TEST(StandInLevels, FacesOfACameraThatStoresMillimetresLieOnThePlanesAroundThem) {
    const TemporaryFolder folder;
    StandIn what = stand_in("redwood5");
    what.hole_share = 0;  // planes are sought where nothing is missing
    what.frames = 1;
    expect_faces_on_planes(folder.path(), write_stand_in(folder.path(), what), {20, 20, 1});
}

}  // namespace
}  // namespace touchable::test
