#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/content/families.hpp"
#include "engine/content/globe_motion.hpp"
#include "engine/content/globe_touch.hpp"
#include "engine/content/mapped_ground.hpp"
#include "engine/content/planet_look.hpp"
#include "engine/content/presets.hpp"

namespace touchable {
namespace {

/// A globe of maps: a sphere that rises where mountains are, before the far plane.
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
    std::optional<SurfaceTruth> closest(const glm::dvec3&, const glm::dvec3&, double) const override {
        return {};
    }

private:
    /// The globe's axes at a time, and the camera in its frame, in radii.
    struct View {
        GlobeAxes axes;
        glm::dvec3 camera;
    };
    /// What a line of sight meets.
    struct Sight {
        glm::dvec3 normal, to_eye;  ///< of the bare sphere there; unit vectors in the world
        glm::dvec3 place;           ///< the normal in the globe's own frame
        double facing;              ///< cosine between both
        double width;               ///< radians that a pixel would cover if it faced the camera
    };
    using Look = CubePyramid<5>::Values;

    bool moves() const override { return true; }
    void paint(double t, const std::vector<double>& depths, RowBands& rows,
               FramePlanes& planes) const override;
    void paint_row(const View& view, int y, const std::vector<double>& depths, FramePlanes& planes) const;

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
    Sight sight(const View& view, double x, double y, double depth) const;
    template <class Mean>
    auto mean_of_pixel(const View& view, const Sight& sight, Mean&& mean) const;
    double relief_light(const View& view, const Sight& sight) const;
    glm::dvec3 ground_colour(const View& view, const Sight& sight, const Look& look) const;
    glm::dvec3 sky(int column, int row, double x, double y) const;
    glm::dvec3 limb_colour(const View& view, int column, int row) const;
    void touch(const View& view, const Sight& sight, const Look& look, std::size_t pixel,
               FramePlanes& planes) const;

    GlobeSphere sphere_;
    GlobeMotion motion_;
    std::unique_ptr<const MappedGround> ground_;
};

MapGlobe::Sight MapGlobe::sight(const View& view, double x, double y, double depth) const {
    const glm::dvec3 along = ray(x, y), outward = depth * along - sphere_.centre;
    Sight sight{};
    sight.normal = outward / std::sqrt(glm::dot(outward, outward));
    sight.to_eye = -along;
    sight.place = view.axes.place(sight.normal);
    sight.facing = std::max(0.0, glm::dot(sight.normal, sight.to_eye));
    sight.width = depth / (scene().camera.fx * scene().camera.ray_length(x, y) * sphere_.radius);
    return sight;
}

/// Over all that a pixel covers, which is drawn out where the ground is seen at a slant: means side by side.
template <class Mean>
auto MapGlobe::mean_of_pixel(const View& view, const Sight& sight, Mean&& mean) const {
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

/// Of the slope of all relief, as if it were as high as it is felt.
double MapGlobe::relief_light(const View& view, const Sight& sight) const {
    const auto height = [&](const glm::dvec3& place) {
        return ground_->relief * ground_->look.mean(place, sight.width, MappedGround::elevation);
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

glm::dvec3 MapGlobe::ground_colour(const View& view, const Sight& sight, const Look& look) const {
    return in_daylight({look[MappedGround::red], look[MappedGround::green], look[MappedGround::blue]},
                       sight.normal, sight.to_eye, relief_light(view, sight));
}

glm::dvec3 MapGlobe::sky(int column, int row, double x, double y) const {
    const glm::dvec3 along = ray(x, y), nearest = glm::dot(sphere_.centre, along) * along - sphere_.centre;
    const double passing = std::sqrt(glm::dot(nearest, nearest));
    return sky_colour(column, row, scene().width, nearest / passing,
                      std::max(0.0, passing / sphere_.radius - 1));
}

/// A pixel that the globe covers in part: the mean of many lines of sight.
glm::dvec3 MapGlobe::limb_colour(const View& view, int column, int row) const {
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

void MapGlobe::touch(const View& view, const Sight& sight, const Look& look, std::size_t pixel,
                     FramePlanes& planes) const {
    if (ground_->touch) {
        const auto codes = mean_of_pixel(
            view, sight, [&](const glm::dvec3& at) { return ground_->touch->mean(at, sight.width); });
        for (std::size_t c = 0; c < 3; ++c)
            planes.haptic[3 * pixel + c] = static_cast<std::uint8_t>(255 * codes[c] + 0.5);
    } else {
        put_feel(globe_feel(look[MappedGround::land]), &planes.haptic[3 * pixel]);
    }
    if (ground_->largest_height == 0) return;
    const double height = ground_->relief * look[MappedGround::elevation] - ground_->shape.rise(sight.place);
    planes.height[pixel] =
        static_cast<std::uint8_t>(255 * std::clamp(height / ground_->largest_height, 0.0, 1.0) + 0.5);
}

void MapGlobe::paint_row(const View& view, int y, const std::vector<double>& depths,
                         FramePlanes& planes) const {
    const int width = scene().width, height = scene().height;
    const auto beside = [&](int column, int row) {
        const int i = std::clamp(column, 0, width - 1), j = std::clamp(row, 0, height - 1);
        return is_beside(depths[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(i)]);
    };
    const auto is_limb = [&](int x, bool outside) {
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i)
                if (beside(x + i, y + j) != outside) return true;
        return false;
    };
    for (int x = 0; x < width; ++x) {
        const std::size_t pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
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

void MapGlobe::paint(double t, const std::vector<double>& depths, RowBands& rows, FramePlanes& planes) const {
    const View view = view_at(t);
    planes.colour.resize(3 * depths.size());
    planes.haptic.resize(3 * depths.size());
    if (ground_->largest_height > 0) planes.height.resize(depths.size());
    rows.for_each_band(scene().height, 1, [&](const RowBand& band) {
        for (int y = band.first; y < band.last; ++y) paint_row(view, y, depths, planes);
    });
}

}  // namespace

MadeScene make_map_globe(Scene scene, const GlobeSphere& sphere, const SceneOptions& options) {
    const double distance = -sphere.centre.z, nearest = distance - sphere.radius * (1 + options.maps->relief);
    if (nearest < scene.depth.near)
        return usage_error("scene 'globe': mountains of " + std::to_string(options.maps->relief) +
                           " radii would reach before the near plane");
    RowBands rows(threads_for_pixels(options.threads, 1 << 20));  // maps are large
    TRY_ASSIGN(auto ground, map_ground(*options.maps, nearest / (scene.camera.fx * sphere.radius), rows));
    if (ground->largest_height > 0)
        scene.height_coding = {ground->largest_height * sphere.radius, HeightUnits::world, 255};
    return std::unique_ptr<AnalyticScene>(
        std::make_unique<MapGlobe>(std::move(scene), sphere, options, std::move(ground)));
}

}  // namespace touchable
