#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "engine/content/families.hpp"
#include "engine/content/globe_motion.hpp"
#include "engine/content/globe_touch.hpp"
#include "engine/content/planet_look.hpp"
#include "engine/content/presets.hpp"
#include "engine/content/smooth.hpp"

namespace touchable {
namespace {

/// The bare sphere before the far plane.
class Globe : public AnalyticScene {
public:
    Globe(Scene scene, const GlobeSphere& sphere) : AnalyticScene(std::move(scene)), sphere_(sphere) {}

    /// Range r = b - sqrt(b^2 - c) with b = ray . centre and c = |centre|^2 - R^2; the far plane beside the
    /// sphere.
    double depth(double x, double y, double /*t*/) const override {
        const double distance = -sphere_.centre.z;
        const double b = distance / scene().camera.ray_length(x, y);
        const double under_root = b * b - (distance * distance - sphere_.radius * sphere_.radius);
        return under_root > 0 ? b - std::sqrt(under_root) : scene().depth.far;
    }

    std::optional<SurfaceTruth> closest(const glm::dvec3& goal, const glm::dvec3& start,
                                        double /*t*/) const override {
        glm::dvec3 outward = goal - sphere_.centre;
        if (glm::dot(outward, outward) == 0) outward = start - sphere_.centre;
        if (glm::dot(outward, outward) == 0) outward = {0, 0, 1};
        outward /= std::sqrt(glm::dot(outward, outward));
        return SurfaceTruth{sphere_.centre + sphere_.radius * outward, outward};
    }

protected:
    GlobeSphere sphere_;
};

/// The globe with the procedural planet on it.
class PlanetGlobe final : public Globe {
public:
    PlanetGlobe(Scene scene, const GlobeSphere& sphere, const SceneOptions& options)
        : Globe(std::move(scene), sphere), motion_(options), planet_(options.seed) {}

    /// The relief on the sphere has no closed form.
    std::optional<SurfaceTruth> closest(const glm::dvec3&, const glm::dvec3&, double) const override {
        return {};
    }

private:
    /// One line of sight: how much of the pixel the disc covers, and what it meets there (or at the limb).
    struct Sight {
        double coverage, altitude;
        glm::dvec3 normal, to_eye;
        Ground ground;
    };

    bool moves() const override { return true; }
    void paint(double t, const std::vector<double>& depths, RowBands& rows,
               FramePlanes& planes) const override;
    Sight look(int x, int y, const GlobeAxes& axes) const;
    std::vector<Sight> look_along(int y, const GlobeAxes& axes) const;
    void colour_row(const std::vector<Sight>& above, const std::vector<Sight>& row,
                    const std::vector<Sight>& below, int y, FramePlanes& planes) const;
    void touch(const Sight& sight, std::size_t pixel, FramePlanes& planes) const;

    GlobeMotion motion_;
    Planet planet_;
};

PlanetGlobe::Sight PlanetGlobe::look(int x, int y, const GlobeAxes& axes) const {
    const Camera& camera = scene().camera;
    const glm::dvec3 ray = glm::dvec3(camera.u(x), camera.v(y), -1) / camera.ray_length(x, y);
    const double distance = -sphere_.centre.z, b = glm::dot(ray, sphere_.centre);
    const double passing = std::sqrt(std::max(0.0, distance * distance - b * b));  // of the centre
    const double pixel = distance / camera.fx;
    const double depth = std::max(0.0, sphere_.radius * sphere_.radius - passing * passing);
    const glm::dvec3 outward = (b - std::sqrt(depth)) * ray - sphere_.centre;
    Sight sight{};
    sight.coverage = std::clamp(0.5 + (sphere_.radius - passing) / pixel, 0.0, 1.0);
    sight.altitude = passing / sphere_.radius - 1;
    sight.normal = outward / std::sqrt(glm::dot(outward, outward));
    sight.to_eye = -ray;
    if (sight.coverage > 0) sight.ground = planet_.ground(axes.place(sight.normal));
    return sight;
}

std::vector<PlanetGlobe::Sight> PlanetGlobe::look_along(int y, const GlobeAxes& axes) const {
    std::vector<Sight> row;
    row.reserve(static_cast<std::size_t>(scene().width));
    for (int x = 0; x < scene().width; ++x) row.push_back(look(x, y, axes));
    return row;
}

void PlanetGlobe::colour_row(const std::vector<Sight>& above, const std::vector<Sight>& row,
                             const std::vector<Sight>& below, int y, FramePlanes& planes) const {
    const auto first = static_cast<std::size_t>(y) * row.size();
    const double radius_pixels = scene().camera.fx * sphere_.radius / -sphere_.centre.z;
    for (std::size_t x = 0; x < row.size(); ++x) {
        const Sight& sight = row[x];
        glm::dvec3 colour =
            sky_colour(static_cast<int>(x), y, scene().width, sight.normal, std::max(0.0, sight.altitude));
        if (sight.coverage > 0) {
            // The ground's rise per radius across the picture, foreshortened back, toward the sun.
            const Sight &left = row[x == 0 ? 0 : x - 1], &right = row[std::min(x + 1, row.size() - 1)];
            const double rise_x = 0.5 * (right.ground.relief - left.ground.relief);
            const double rise_y = 0.5 * (above[x].ground.relief - below[x].ground.relief);
            const double facing = std::max(0.0, glm::dot(sight.normal, sight.to_eye));
            const double slope = -(rise_x * sunward.x + rise_y * sunward.y) * radius_pixels * facing;
            const double exaggeration = 0.16;
            const glm::dvec3 surface =
                planet_colour(sight.ground, sight.normal, sight.to_eye, exaggeration * slope);
            colour += sight.coverage * (surface - colour);
        }
        const std::array<std::uint8_t, 3> bytes = to_bytes(colour);
        std::copy(bytes.begin(), bytes.end(), &planes.colour[3 * (first + x)]);
    }
}

void PlanetGlobe::touch(const Sight& sight, std::size_t pixel, FramePlanes& planes) const {
    const bool ball = sight.altitude < 0;
    put_feel(ball ? globe_feel(smooth_step(-0.012, 0.012, sight.ground.elevation)) : beyond_feel,
             &planes.haptic[3 * pixel]);
    planes.height[pixel] =
        ball ? static_cast<std::uint8_t>(std::floor(255 * sight.ground.relief + 0.5)) : std::uint8_t{0};
}

void PlanetGlobe::paint(double t, const std::vector<double>& depths, RowBands& rows,
                        FramePlanes& planes) const {
    const GlobeAxes axes = motion_.axes(t);
    const auto width = static_cast<std::size_t>(scene().width);
    planes.colour.resize(3 * depths.size());
    planes.haptic.resize(3 * depths.size());
    planes.height.resize(depths.size());
    // A row's relief is lit by its neighbours'; three rows at a time keep a large picture small in memory.
    rows.for_each_band(scene().height, 1, [&](const RowBand& band) {
        std::vector<Sight> row = look_along(band.first, axes);
        std::vector<Sight> above = band.first > 0 ? look_along(band.first - 1, axes) : row;
        for (int y = band.first; y < band.last; ++y) {
            std::vector<Sight> below = y + 1 < scene().height ? look_along(y + 1, axes) : row;
            colour_row(above, row, below, y, planes);
            for (std::size_t x = 0; x < width; ++x)
                touch(row[x], static_cast<std::size_t>(y) * width + x, planes);
            above = std::move(row);
            row = std::move(below);
        }
    });
}

}  // namespace

MadeScene make_globe(std::string_view name, const SceneOptions& options) {
    Scene scene = blank_scene(name, options);
    apply_preset(options.preset, scene);
    const GlobeSphere sphere = globe_sphere(options.preset, options.width, options.height);
    if (-sphere.centre.z - sphere.radius < scene.depth.near)
        return usage_error("scene 'globe': a picture of " + std::to_string(options.width) + "x" +
                           std::to_string(options.height) +
                           " is too tall: a globe of 80 % of its height would reach before the near plane");
    scene.device_metres_per_unit = globe_device_radius / sphere.radius;
    scene.default_properties = {1000, 0, 0};
    if (!options.properties)
        return std::unique_ptr<AnalyticScene>(std::make_unique<Globe>(std::move(scene), sphere));
    scene.haptic = globe_ranges;
    if (options.maps) return make_map_globe(std::move(scene), sphere, options);
    scene.height_coding = {1, HeightUnits::levels, 255};
    return std::unique_ptr<AnalyticScene>(std::make_unique<PlanetGlobe>(std::move(scene), sphere, options));
}

}  // namespace touchable
