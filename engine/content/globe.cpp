// SPDX-License-Identifier: Apache-2.0
// Globes: the bare sphere, the procedural planet on it, and one that is made of maps.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/content/families.hpp"
#include "engine/content/mapped_ground.hpp"
#include "engine/content/scenes.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

/// 0 below `from`, 1 above `to`, between them the cubic that is level at both ends.
double smooth_step(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

// ---- The planet, and the light on it. Colours are linear light, 0 to 1; only the picture, never the touch,
// depends on them.

constexpr double land_share = 0.38;

/// Places spread evenly enough over the sphere, without an angle: grid points of a cube's shell, projected to
/// the sphere and weighted by the area that each stands for.
struct Place {
    glm::dvec3 at;
    double area;
};
std::vector<Place> survey() {
    constexpr int side = 24;
    std::vector<Place> places;
    for (int face = 0; face < 6; ++face)
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j) {
                const double a = (2 * i + 1.0) / side - 1, b = (2 * j + 1.0) / side - 1;
                const double c = face < 3 ? 1 : -1, length = std::sqrt(a * a + b * b + 1);
                const glm::dvec3 on_cube = face % 3 == 0   ? glm::dvec3(c, a, b)
                                           : face % 3 == 1 ? glm::dvec3(a, c, b)
                                                           : glm::dvec3(a, b, c);
                places.push_back({on_cube / length, 1 / (length * length * length)});
            }
    return places;
}

constexpr glm::dvec3 air_colour{0.16, 0.36, 0.75};

glm::dvec3 sea_colour(const Ground& ground) {
    const glm::dvec3 abyss{0.004, 0.017, 0.060}, deep{0.008, 0.042, 0.125}, shelf{0.025, 0.170, 0.235};
    const double depth = -ground.elevation;
    const glm::dvec3 open = glm::mix(deep, abyss, smooth_step(0.10, 0.60, depth));
    return glm::mix(shelf, open, smooth_step(0.0, 0.10, depth));
}

glm::dvec3 land_colour(const Ground& ground) {
    const glm::dvec3 forest{0.030, 0.085, 0.022}, steppe{0.150, 0.150, 0.045}, desert{0.430, 0.285, 0.130};
    const glm::dvec3 rock{0.170, 0.125, 0.090}, beach{0.380, 0.310, 0.190};
    const glm::dvec3 dry = glm::mix(desert, steppe, smooth_step(0.22, 0.48, ground.moisture));
    glm::dvec3 colour = glm::mix(dry, forest, smooth_step(0.42, 0.68, ground.moisture));
    colour = glm::mix(colour, rock, smooth_step(0.28, 0.55, ground.relief));
    return glm::mix(beach, colour, smooth_step(0.0, 0.018, ground.elevation));
}

/// Towards the sun: a unit vector in the world.
constexpr glm::dvec3 sunward{-0.56, 0.42, 0.7141428428542850};

/// Colour in the day of a place whose ground has this colour. `normal` is the unit vector up, `to_eye` one
/// toward the eye; `relief_light` is the ground's brightness relative to level ground.
glm::dvec3 in_daylight(const glm::dvec3& ground, const glm::dvec3& normal, const glm::dvec3& to_eye,
                       double relief_light) {
    // A soft terminator: light reaches a little past the edge of the day.
    const double facing = glm::dot(normal, sunward), day = smooth_step(-0.12, 0.30, facing);
    const double light = 0.012 + 1.55 * day * (0.18 + 0.82 * std::max(0.0, facing)) * relief_light;
    const glm::dvec3 colour = light * ground;

    // The line of sight passes through more air toward the limb.
    const double grazing = 1 - std::max(0.0, glm::dot(normal, to_eye));
    const double air = day * (0.05 + 0.75 * grazing * grazing * grazing);
    return glm::mix(colour, air_colour * (0.35 + 0.65 * std::max(0.0, facing)), std::min(1.0, air));
}

/// Colour of a place of the procedural planet. `normal` and `to_eye` are unit vectors; `slope` is how much
/// the ground rises toward the sun (relief per radius of the planet; 0: level).
glm::dvec3 planet_colour(const Ground& ground, const glm::dvec3& normal, const glm::dvec3& to_eye,
                         double slope) {
    const glm::dvec3 snow{0.80, 0.84, 0.88};
    const glm::dvec3 bare = ground.elevation > 0 ? land_colour(ground) : sea_colour(ground);
    return in_daylight(glm::mix(bare, snow, ground.ice), normal, to_eye, std::clamp(1 + slope, 0.35, 1.9));
}

/// Colour beside the planet: night, faint stars, and a glow on the lit side of the limb. `outward` is the
/// unit vector from the planet's centre to the nearest point of the line of sight, `altitude` that point's
/// distance from the limb in radii, at least 0.
glm::dvec3 sky_colour(int column, int row, int picture_width, const glm::dvec3& outward, double altitude) {
    const int grain = std::max(1, picture_width / 720);  // a star's side in pixels
    SplitMix64 random(
        mix64(static_cast<std::uint64_t>(column / grain) << 32 | static_cast<std::uint64_t>(row / grain)));
    glm::dvec3 colour{0.0012, 0.0016, 0.0040};
    if (random.unit() < 0.0025) {
        const double strength = random.unit(), warmth = random.unit();
        colour +=
            0.30 * strength * strength * strength * glm::dvec3(0.8 + 0.2 * warmth, 0.9, 1.0 - 0.2 * warmth);
    }
    const double thickness = 0.030, thin = 1 / (1 + altitude / thickness);
    const double glow = thin * thin * thin * smooth_step(-0.35, 0.75, glm::dot(outward, sunward));
    return colour + 0.75 * glow * air_colour;
}

/// Linear light as the bytes of a picture, gamma 2.
std::array<std::uint8_t, 3> to_bytes(const glm::dvec3& colour) {
    std::array<std::uint8_t, 3> bytes{};
    for (int channel = 0; channel < 3; ++channel)
        bytes[static_cast<std::size_t>(channel)] = static_cast<std::uint8_t>(
            std::floor(255 * std::sqrt(std::clamp(colour[channel], 0.0, 1.0)) + 0.5));
    return bytes;
}

// ---- Globes

/// Axes of a turning globe in the world: the pole leans to the right and a little toward the camera, and the
/// side that faces the camera moves to the right.
class GlobeAxes {
public:
    GlobeAxes(const glm::dvec3& pole, double angle)
        : pole_(pole), east_(glm::normalize(glm::cross(pole_, glm::dvec3(0, 0, 1)))) {
        const glm::dvec3 toward = glm::cross(east_, pole_);
        const double c = cosine(angle), s = sine(angle);
        x_ = c * east_ - s * toward;
        z_ = s * east_ + c * toward;
    }
    /// A world direction in the globe's own frame: +Y its north pole, +Z longitude 0.
    glm::dvec3 place(const glm::dvec3& direction) const {
        return {glm::dot(direction, x_), glm::dot(direction, pole_), glm::dot(direction, z_)};
    }
    /// The inverse of `place`.
    glm::dvec3 world(const glm::dvec3& place) const { return place.x * x_ + place.y * pole_ + place.z * z_; }

private:
    glm::dvec3 pole_, east_, x_, z_;
};

/// How a globe leans and turns. Options that are left out are as for the procedural planet.
class GlobeMotion {
public:
    explicit GlobeMotion(const SceneOptions& options)
        : seconds_per_turn_(options.seconds_per_turn),
          first_turn_(options.first_longitude_degrees ? -*options.first_longitude_degrees / 360 : 0.2) {
        if (!options.axial_tilt_degrees) return;
        // The same direction as the planet's pole leans to: 0.36 to the right and 0.25 toward the camera.
        const double lean = *options.axial_tilt_degrees * pi / 180;
        const glm::dvec3 way = glm::normalize(glm::dvec3(0.36, 0, 0.25));
        pole_ = sine(lean) * way + glm::dvec3(0, cosine(lean), 0);
    }
    GlobeAxes axes(double t) const {
        const double turns = first_turn_ + t / seconds_per_turn_;
        return {pole_, 2 * pi * (turns - std::floor(turns))};
    }

private:
    glm::dvec3 pole_ = glm::normalize(glm::dvec3(0.36, 0.90, 0.25));
    double seconds_per_turn_, first_turn_;
};

/// Touch of a globe: land is stiffer and rougher than the sea; a coast leads from one to the other.
constexpr HapticProperties sea_feel{400, 0.15, 0.10}, land_feel{1200, 0.60, 0.45},
    beyond_feel{800, 0.30, 0.20};
constexpr HapticRanges globe_ranges{{0.1, 2}, {0, 1}, {0, 1}};

/// `dry`: 0 at sea, 1 on land.
HapticProperties globe_feel(double dry) {
    return {sea_feel.stiffness + dry * (land_feel.stiffness - sea_feel.stiffness),
            sea_feel.static_friction + dry * (land_feel.static_friction - sea_feel.static_friction),
            sea_feel.dynamic_friction + dry * (land_feel.dynamic_friction - sea_feel.dynamic_friction)};
}

/// The three codes of a haptic pixel of `globe_ranges`.
void put_feel(const HapticProperties& felt, std::uint8_t* pixel) {
    pixel[0] = globe_ranges.stiffness.nearest(felt.stiffness / 1000);
    pixel[1] = globe_ranges.static_friction.nearest(felt.static_friction);
    pixel[2] = globe_ranges.dynamic_friction.nearest(felt.dynamic_friction);
}

/// The bare sphere in front of the far plane.
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

protected:
    GlobeSphere sphere_;
};

/// The globe with the procedural planet on it.
class PlanetGlobe final : public Globe {
public:
    PlanetGlobe(Scene scene, const GlobeSphere& sphere, const SceneOptions& options)
        : Globe(std::move(scene), sphere), motion_(options), planet_(options.seed) {}

private:
    /// One line of sight: the disc's share of the pixel, and what the line meets there (or at the limb).
    struct Sight {
        double coverage, altitude;
        glm::dvec3 normal, to_eye;
        Ground ground;
    };

    bool moves() const override { return true; }
    void paint(double t, const std::vector<double>& depths, RowBands& rows, Planes& planes) const override {
        const GlobeAxes axes = motion_.axes(t);
        const auto width = static_cast<std::size_t>(scene().width);
        planes.colour.resize(3 * depths.size());
        planes.haptic.resize(3 * depths.size());
        planes.height.resize(depths.size());
        // The light on a row's relief depends on the rows beside it; three rows at a time keep a large
        // picture small in memory.
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
    Sight look(int x, int y, const GlobeAxes& axes) const {
        const Camera& camera = scene().camera;
        const glm::dvec3 ray = glm::dvec3(camera.u(x), camera.v(y), -1) / camera.ray_length(x, y);
        const double distance = -sphere_.centre.z, b = glm::dot(ray, sphere_.centre);
        const double passing = std::sqrt(std::max(0.0, distance * distance - b * b));  // centre distance
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
    std::vector<Sight> look_along(int y, const GlobeAxes& axes) const {
        std::vector<Sight> row;
        row.reserve(static_cast<std::size_t>(scene().width));
        for (int x = 0; x < scene().width; ++x) row.push_back(look(x, y, axes));
        return row;
    }
    void colour_row(const std::vector<Sight>& above, const std::vector<Sight>& row,
                    const std::vector<Sight>& below, int y, Planes& planes) const {
        const auto first = static_cast<std::size_t>(y) * row.size();
        const double radius_pixels = scene().camera.fx * sphere_.radius / -sphere_.centre.z;
        for (std::size_t x = 0; x < row.size(); ++x) {
            const Sight& sight = row[x];
            glm::dvec3 colour = sky_colour(static_cast<int>(x), y, scene().width, sight.normal,
                                           std::max(0.0, sight.altitude));
            if (sight.coverage > 0) {
                // Slope toward the sun per radius, from the rise across the picture, without foreshortening.
                const Sight &left = row[x == 0 ? 0 : x - 1], &right = row[std::min(x + 1, row.size() - 1)];
                const double rise_x = 0.5 * (right.ground.relief - left.ground.relief);
                const double rise_y = 0.5 * (above[x].ground.relief - below[x].ground.relief);
                const double facing = std::max(0.0, glm::dot(sight.normal, sight.to_eye));
                const double slope = -(rise_x * sunward.x + rise_y * sunward.y) * radius_pixels * facing;
                const double exaggeration = 0.16;
                // Coasts are narrower than a pixel: the mean over the elevations that it has.
                const double across = right.ground.elevation - left.ground.elevation,
                             down = above[x].ground.elevation - below[x].ground.elevation;
                const double range = 0.5 * std::sqrt(across * across + down * down);
                glm::dvec3 surface(0.0);
                for (const double part : {-0.375, -0.125, 0.125, 0.375}) {
                    Ground ground = sight.ground;
                    ground.elevation += part * range;
                    surface += 0.25 * planet_colour(ground, sight.normal, sight.to_eye, exaggeration * slope);
                }
                colour += sight.coverage * (surface - colour);
            }
            const std::array<std::uint8_t, 3> bytes = to_bytes(colour);
            std::copy(bytes.begin(), bytes.end(), &planes.colour[3 * (first + x)]);
        }
    }
    void touch(const Sight& sight, std::size_t pixel, Planes& planes) const {
        const bool ball = sight.altitude < 0;
        put_feel(ball ? globe_feel(smooth_step(-0.012, 0.012, sight.ground.elevation)) : beyond_feel,
                 &planes.haptic[3 * pixel]);
        planes.height[pixel] =
            ball ? static_cast<std::uint8_t>(std::floor(255 * sight.ground.relief + 0.5)) : std::uint8_t{0};
    }

    GlobeMotion motion_;
    Planet planet_;
};

/// A globe of maps: a sphere with raised mountains, in front of the far plane.
class MapGlobe final : public AnalyticScene {
public:
    MapGlobe(Scene scene, const GlobeSphere& sphere, const SceneOptions& options,
             std::unique_ptr<const MappedGround> ground)
        : AnalyticScene(std::move(scene)), sphere_(sphere), motion_(options), ground_(std::move(ground)) {}

    double depth(double x, double y, double t) const override { return depth_from(view_at(t), x, y); }
    void row_depths(int y, double t, double* depths) const override {
        const View view = view_at(t);
        for (int x = 0; x < scene().width; ++x) depths[x] = depth_from(view, x, y);
    }

private:
    /// The globe's axes at a time, and the camera in its frame, in radii.
    struct View {
        GlobeAxes axes;
        glm::dvec3 camera;
    };
    /// The point that a line of sight meets.
    struct Sight {
        glm::dvec3 normal, to_eye;  ///< of the bare sphere there; unit vectors in the world
        glm::dvec3 place;           ///< the normal in the globe's own frame
        double facing;              ///< cosine of the angle between both
        double width;               ///< radians that a pixel would cover if it faced the camera
    };
    using Look = CubePyramid<5>::Values;

    bool moves() const override { return true; }
    View view_at(double t) const {
        const GlobeAxes axes = motion_.axes(t);
        return {axes, axes.place(-sphere_.centre / sphere_.radius)};
    }
    glm::dvec3 ray(double x, double y) const {
        const Camera& camera = scene().camera;
        return glm::dvec3(camera.u(x), camera.v(y), -1) / camera.ray_length(x, y);
    }
    double depth_from(const View& view, double x, double y) const {
        const auto hit = ground_->shape.first_hit(view.camera, view.axes.place(ray(x, y)));
        return hit ? sphere_.radius * *hit : scene().depth.far;
    }
    bool is_beside(double depth) const { return depth >= scene().depth.far; }

    Sight sight(const View& view, double x, double y, double depth) const {
        const glm::dvec3 along = ray(x, y), outward = depth * along - sphere_.centre;
        Sight sight{};
        sight.normal = outward / std::sqrt(glm::dot(outward, outward));
        sight.to_eye = -along;
        sight.place = view.axes.place(sight.normal);
        sight.facing = std::max(0.0, glm::dot(sight.normal, sight.to_eye));
        sight.width = depth / (scene().camera.fx * scene().camera.ray_length(x, y) * sphere_.radius);
        return sight;
    }

    /// The mean over all that a pixel covers, which is stretched if the ground is seen at a slant: then
    /// several means side by side.
    template <class Mean>
    auto mean_of_pixel(const View& view, const Sight& sight, Mean&& mean) const {
        constexpr double most = 8;
        const double stretch = std::min(1 / std::max(sight.facing, 1e-3), most);
        const int count = static_cast<int>(stretch + 0.5);
        if (count == 1) return mean(sight.place);
        const glm::dvec3 away = sight.facing * sight.normal - sight.to_eye;
        const glm::dvec3 way = view.axes.place(away / std::sqrt(glm::dot(away, away)));
        auto sum = mean(sight.place);
        for (double& value : sum) value = 0;
        for (int k = 0; k < count; ++k) {
            const auto values = mean(sight.place + sight.width * stretch * ((k + 0.5) / count - 0.5) * way);
            for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += values[c] / count;
        }
        return sum;
    }

    /// Brightness of a slope against level ground, with all relief as high as it is felt.
    double relief_light(const View& view, const Sight& sight) const {
        const auto height = [&](const glm::dvec3& place) {
            return ground_->relief * ground_->look.mean(place, sight.width)[MappedGround::elevation];
        };
        const auto [across, down] = tangents(sight.place);
        const double reach = sight.width;
        const double slope_across =
            (height(sight.place + reach * across) - height(sight.place - reach * across)) / (2 * reach);
        const double slope_down =
            (height(sight.place + reach * down) - height(sight.place - reach * down)) / (2 * reach);
        const glm::dvec3 upward = view.axes.world(sight.place - slope_across * across - slope_down * down);
        const auto light = [](double facing) { return 0.18 + 0.82 * std::max(0.0, facing); };
        const double on_relief = light(glm::dot(upward, sunward) / std::sqrt(glm::dot(upward, upward)));
        return std::clamp(on_relief / light(glm::dot(sight.normal, sunward)), 0.35, 1.9);
    }

    glm::dvec3 ground_colour(const View& view, const Sight& sight, const Look& look) const {
        return in_daylight({look[MappedGround::red], look[MappedGround::green], look[MappedGround::blue]},
                           sight.normal, sight.to_eye, relief_light(view, sight));
    }

    glm::dvec3 sky(int column, int row, double x, double y) const {
        const glm::dvec3 along = ray(x, y),
                         nearest = glm::dot(sphere_.centre, along) * along - sphere_.centre;
        const double passing = std::sqrt(glm::dot(nearest, nearest));
        return sky_colour(column, row, scene().width, nearest / passing,
                          std::max(0.0, passing / sphere_.radius - 1));
    }

    /// Colour of a pixel that the globe covers in part: the mean of many lines of sight.
    glm::dvec3 limb_colour(const View& view, int column, int row) const {
        constexpr int side = 4;
        glm::dvec3 sum{0};
        for (int n = 0; n < side * side; ++n) {
            const double x = column + (n % side + 0.5) / side - 0.5, y = row + (n / side + 0.5) / side - 0.5;
            const double depth = depth_from(view, x, y);
            if (is_beside(depth)) {
                sum += sky(column, row, x, y);
                continue;
            }
            const Sight seen = sight(view, x, y, depth);
            sum += ground_colour(view, seen, ground_->look.mean(seen.place, seen.width));
        }
        return sum / static_cast<double>(side * side);
    }

    void touch(const View& view, const Sight& sight, const Look& look, std::size_t pixel,
               Planes& planes) const {
        if (ground_->touch) {
            const auto codes = mean_of_pixel(
                view, sight, [&](const glm::dvec3& at) { return ground_->touch->mean(at, sight.width); });
            for (std::size_t c = 0; c < 3; ++c)
                planes.haptic[3 * pixel + c] = static_cast<std::uint8_t>(255 * codes[c] + 0.5);
        } else {
            put_feel(globe_feel(look[MappedGround::land]), &planes.haptic[3 * pixel]);
        }
        if (ground_->largest_height == 0) return;
        const double height =
            ground_->relief * look[MappedGround::elevation] - ground_->shape.rise(sight.place);
        planes.height[pixel] =
            static_cast<std::uint8_t>(255 * std::clamp(height / ground_->largest_height, 0.0, 1.0) + 0.5);
    }

    void paint(double t, const std::vector<double>& depths, RowBands& rows, Planes& planes) const override {
        const View view = view_at(t);
        planes.colour.resize(3 * depths.size());
        planes.haptic.resize(3 * depths.size());
        if (ground_->largest_height > 0) planes.height.resize(depths.size());
        rows.for_each_band(scene().height, 1, [&](const RowBand& band) {
            for (int y = band.first; y < band.last; ++y) paint_row(view, y, depths, planes);
        });
    }

    void paint_row(const View& view, int y, const std::vector<double>& depths, Planes& planes) const {
        const int width = scene().width, height = scene().height;
        const auto beside = [&](int column, int row) {
            const int i = std::clamp(column, 0, width - 1), j = std::clamp(row, 0, height - 1);
            return is_beside(depths[pixel_place(i, j, width)]);
        };
        const auto is_limb = [&](int x, bool outside) {
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    if (beside(x + i, y + j) != outside) return true;
            return false;
        };
        for (int x = 0; x < width; ++x) {
            const std::size_t pixel = pixel_place(x, y, width);
            const bool outside = is_beside(depths[pixel]), limb = is_limb(x, outside);
            glm::dvec3 colour{0};
            if (outside) {
                put_feel(beyond_feel, &planes.haptic[3 * pixel]);
                if (!limb) colour = sky(x, y, x, y);
            } else {
                const Sight seen = sight(view, x, y, depths[pixel]);
                const Look look = mean_of_pixel(
                    view, seen, [&](const glm::dvec3& at) { return ground_->look.mean(at, seen.width); });
                touch(view, seen, look, pixel, planes);
                if (!limb) colour = ground_colour(view, seen, look);
            }
            if (limb) colour = limb_colour(view, x, y);
            const auto bytes = to_bytes(colour);
            std::copy(bytes.begin(), bytes.end(), &planes.colour[3 * pixel]);
        }
    }

    GlobeSphere sphere_;
    GlobeMotion motion_;
    std::unique_ptr<const MappedGround> ground_;
};

/// Makes a globe of `options.maps`, not null; `scene` has the camera and coding of a globe.
MadeScene make_map_globe(Scene scene, const GlobeSphere& sphere, const SceneOptions& options) {
    const double distance = -sphere.centre.z, nearest = distance - sphere.radius * (1 + options.maps->relief);
    if (nearest < scene.depth.near)
        return refuse_scene("globe", "mountains of " + std::to_string(options.maps->relief) +
                                         " radii would reach before the near plane");
    RowBands rows(threads_for_pixels(options.threads, 1 << 20));  // maps are large
    TRY_ASSIGN(auto ground, map_ground(*options.maps, nearest / (scene.camera.fx * sphere.radius), rows));
    if (ground->largest_height > 0)
        scene.height_coding = {ground->largest_height * sphere.radius, HeightUnits::world, 255};
    return std::make_unique<MapGlobe>(std::move(scene), sphere, options, std::move(ground));
}

// ---- Gradient noise

/// Shifts an octave off the lattice of the one before, so that their zeros do not meet.
constexpr glm::dvec3 octave_shift{17.31, 5.77, 41.93};
constexpr double octave_scale = 2.03;

double fade(double t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}
double mix(double a, double b, double t) {
    return a + t * (b - a);
}

}  // namespace

GradientNoise::GradientNoise(std::uint64_t seed) {
    SplitMix64 random(seed);
    for (std::size_t i = 0; i < 256; ++i) permutation_[i] = static_cast<std::uint8_t>(i);
    for (std::size_t i = 255; i > 0; --i) std::swap(permutation_[i], permutation_[random.next() % (i + 1)]);
    for (std::size_t i = 0; i < 256; ++i) permutation_[256 + i] = permutation_[i];
}

/// A lattice corner's gradient, one of twelve edge directions of a cube, dotted with the offset from it.
double GradientNoise::corner(int x, int y, int z, const glm::dvec3& offset) const {
    static constexpr std::array<glm::dvec3, 12> edges{{{1, 1, 0},
                                                       {-1, 1, 0},
                                                       {1, -1, 0},
                                                       {-1, -1, 0},
                                                       {1, 0, 1},
                                                       {-1, 0, 1},
                                                       {1, 0, -1},
                                                       {-1, 0, -1},
                                                       {0, 1, 1},
                                                       {0, -1, 1},
                                                       {0, 1, -1},
                                                       {0, -1, -1}}};
    const auto index = [](int i) { return static_cast<std::size_t>(i & 255); };
    const std::size_t hash = permutation_[permutation_[permutation_[index(x)] + index(y)] + index(z)];
    const glm::dvec3& edge = edges[hash % edges.size()];
    return edge.x * offset.x + edge.y * offset.y + edge.z * offset.z;
}

double GradientNoise::at(const glm::dvec3& p) const {
    const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
    const glm::dvec3 f{p.x - fx, p.y - fy, p.z - fz};
    const double u = fade(f.x), v = fade(f.y), w = fade(f.z);
    double layer[2];
    for (int k = 0; k < 2; ++k) {
        const double near = mix(corner(x, y, z + k, {f.x, f.y, f.z - k}),
                                corner(x + 1, y, z + k, {f.x - 1, f.y, f.z - k}), u);
        const double far = mix(corner(x, y + 1, z + k, {f.x, f.y - 1, f.z - k}),
                               corner(x + 1, y + 1, z + k, {f.x - 1, f.y - 1, f.z - k}), u);
        layer[k] = mix(near, far, v);
    }
    return mix(layer[0], layer[1], w);
}

double GradientNoise::octaves(glm::dvec3 p, int count) const {
    double sum = 0, strength = 1;
    for (int k = 0; k < count; ++k) {
        sum += strength * at(p);
        strength *= 0.5;
        p = octave_scale * p + octave_shift;
    }
    return sum;
}

double GradientNoise::ridges(glm::dvec3 p, int count) const {
    double sum = 0, strength = 0.6, weight = 1;
    for (int k = 0; k < count; ++k) {
        const double crest = 1 - std::fmin(1, 1.6 * std::fabs(at(p)));
        const double value = crest * crest * weight;
        sum += strength * value;
        weight = std::fmin(1, 1.8 * value);
        strength *= 0.5;
        p = octave_scale * p + octave_shift;
    }
    return sum;
}

Planet::Planet(std::uint64_t seed) : noise_(seed), sea_level_(0) {
    struct Height {
        double height, area;
    };
    std::vector<Height> heights;
    double whole = 0, under = 0;
    for (const Place& place : survey()) {
        heights.push_back({continents(place.at), place.area});
        whole += place.area;
    }
    std::ranges::stable_sort(heights, {}, &Height::height);
    for (const Height& height : heights) {
        sea_level_ = height.height;
        under += height.area;
        if (under >= (1 - land_share) * whole) break;
    }
}

/// Octaves bent by slower ones: coasts that wander, with gulfs and islands.
double Planet::continents(const glm::dvec3& place) const {
    const glm::dvec3 p = 1.15 * place;
    const glm::dvec3 bend{noise_.octaves(2.0 * p + glm::dvec3(3.1, 0.7, 9.2), 2),
                          noise_.octaves(2.0 * p + glm::dvec3(8.3, 2.8, 1.4), 2),
                          noise_.octaves(2.0 * p + glm::dvec3(1.9, 6.5, 4.6), 2)};
    return noise_.octaves(p + 0.16 * bend, 7) +
           0.10 * noise_.octaves(9.0 * place + glm::dvec3(4.4, 1.3, 8.8), 4);
}

Ground Planet::ground(const glm::dvec3& place) const {
    Ground ground{};
    ground.elevation = continents(place) - sea_level_;
    const double inland = smooth_step(0.0, 0.16, ground.elevation);
    if (ground.elevation > 0) {
        const double ranges = noise_.ridges(3.4 * place + glm::dvec3(11.2, 4.1, 7.7), 6);
        const double where = smooth_step(-0.25, 0.30, noise_.at(1.7 * place + glm::dvec3(5.5, 12.5, 2.2)));
        ground.relief = std::clamp(inland * (0.10 + 1.25 * ranges * (0.20 + 0.80 * where)), 0.0, 1.0);
    }
    const double wobble = noise_.octaves(3.1 * place + glm::dvec3(21.4, 9.9, 13.3), 3);
    const double latitude = std::fabs(place.y);  // its sine
    // Wet at the equator, dry at the tropics, wet again at middle latitudes.
    const double belt = smooth_step(0.10, 0.36, latitude) * (1 - smooth_step(0.50, 0.72, latitude));
    ground.moisture = std::clamp(0.80 - 0.55 * belt + 0.70 * wobble - 0.12 * inland, 0.0, 1.0);
    const double cold = latitude + 0.07 * wobble + 0.42 * ground.relief;
    ground.ice = ground.elevation > 0 ? smooth_step(0.87, 0.95, cold) : smooth_step(0.93, 0.955, cold);
    return ground;
}

MadeScene make_globe(std::string_view name, const SceneOptions& options) {
    Scene scene = blank_scene(name, options);
    apply_preset(options.preset, scene);
    const GlobeSphere sphere = globe_sphere(options.preset, options.width, options.height);
    if (-sphere.centre.z - sphere.radius < scene.depth.near)
        return refuse_scene(
            "globe", "a picture of " + size_text(options.width, options.height) +
                         " is too tall: a globe of 80 % of its height would reach before the near plane");
    scene.device_metres_per_unit = globe_device_radius / sphere.radius;
    scene.default_properties = {1000, 0, 0};
    if (!options.properties) return std::make_unique<Globe>(std::move(scene), sphere);
    scene.haptic = globe_ranges;
    if (options.maps) return make_map_globe(std::move(scene), sphere, options);
    scene.height_coding = {1, HeightUnits::levels, 255};
    return std::make_unique<PlanetGlobe>(std::move(scene), sphere, options);
}

}  // namespace touchable
