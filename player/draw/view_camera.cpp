#include "player/draw/view_camera.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <set>
#include <string_view>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/trigonometry.hpp"

namespace touchable {
namespace {

constexpr double degree = pi / 180.0;

/// Share of the distance to what is looked at that lies before the near plane. As small as that of the clip's
/// own view, or what is near would be cut off as soon as that is turned; nearness of z is as precise at any.
constexpr double near_share = 1e-3;

/// Rows to the columns that GLM wants.
glm::dmat4 from_rows(const glm::dvec4& x, const glm::dvec4& y, const glm::dvec4& z, const glm::dvec4& w) {
    return glm::transpose(glm::dmat4(x, y, z, w));
}

/// (x, y, 1, q) -> homogeneous world point ((x - cx)/fx, -(y - cy)/fy, -1, q).
glm::dmat4 world_from_lattice(const Camera& camera) {
    return from_rows({1.0 / camera.fx, 0, -camera.cx / camera.fx, 0},
                     {0, -1.0 / camera.fy, camera.cy / camera.fy, 0}, {0, 0, -1, 0}, {0, 0, 0, 1});
}

/// Lens of the focal lengths and centre given, all in pixels of the picture.
glm::dmat4 lens(glm::dvec2 focal, glm::dvec2 centre, int width, int height, double near) {
    const glm::dvec2 half(width / 2.0, height / 2.0);
    return from_rows({focal.x / half.x, 0, 1.0 - centre.x / half.x, 0},
                     {0, -focal.y / half.y, 1.0 - centre.y / half.y, 0}, {0, 0, 0, near}, {0, 0, -1, 0});
}

double fit(const Scene& scene, int width, int height) {
    return std::min(static_cast<double>(width) / scene.width, static_cast<double>(height) / scene.height);
}

/// Where the clip's camera has its axis in the clip's own view, pixels.
glm::dvec2 axis_of(const Scene& scene, int width, int height) {
    const double scale = fit(scene, width, height);
    const glm::dvec2 margin((width - scale * scene.width) / 2.0, (height - scale * scene.height) / 2.0);
    return margin + scale * glm::dvec2(scene.camera.cx + 0.5, scene.camera.cy + 0.5);
}

/// An eye, before which the world's points are `eye_from_world`'s, and its lens.
struct Sight {
    glm::dmat4 eye_from_world{1.0};
    glm::dvec3 eye{0.0};
    glm::dvec2 focal, centre;  // pixels
    double near;               // scene units
};

ViewCamera view_of(const Sight& sight, const Scene& scene, int width, int height) {
    ViewCamera view;
    view.clip_from_world = lens(sight.focal, sight.centre, width, height, sight.near) * sight.eye_from_world;
    view.clip_from_lattice = view.clip_from_world * world_from_lattice(scene.camera);
    view.eye = sight.eye;
    view.width = width;
    view.height = height;
    view.near = sight.near;
    view.focal = std::max(sight.focal.x, sight.focal.y);
    return view;
}

/// Of an orbit's eye: unit vectors to the right, up, and back to the eye from what it looks at.
struct Axes {
    glm::dvec3 right, up, back;
};

Axes orbit_axes(const Viewpoint& viewpoint) {
    const double az = viewpoint.azimuth * degree, el = viewpoint.elevation * degree;
    const glm::dvec3 back(sine(az) * cosine(el), sine(el), cosine(az) * cosine(el));
    const glm::dvec3 right(cosine(az), 0, -sine(az));
    return {right, glm::cross(back, right), back};
}

/// Pixels.
glm::dvec2 orbit_focal(const Viewpoint& viewpoint, const Scene& scene, int width, int height) {
    if (!viewpoint.fov) return glm::dvec2(scene.camera.fx, scene.camera.fy) * fit(scene, width, height);
    const double half = *viewpoint.fov * 0.5 * degree;
    return glm::dvec2(height / 2.0 * cosine(half) / sine(half));
}

ViewCamera orbit_view(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre, int width,
                      int height) {
    const auto [right, up, back] = orbit_axes(viewpoint);
    const double distance = -centre.z / viewpoint.zoom.value_or(1.0);
    const glm::dvec3 eye = centre + distance * back;
    const glm::dmat4 eye_from_world = from_rows({right, -glm::dot(right, eye)}, {up, -glm::dot(up, eye)},
                                                {back, -glm::dot(back, eye)}, {0, 0, 0, 1});
    const glm::dvec2 focal = orbit_focal(viewpoint, scene, width, height);
    const glm::dvec2 middle =
        viewpoint.keeps_axis ? axis_of(scene, width, height) : glm::dvec2(width / 2.0, height / 2.0);
    return view_of({eye_from_world, eye, focal, middle, near_share * distance}, scene, width, height);
}

/// What is wrong with "key=value" of an orbit; nothing where it is right. `read`: the keys before it.
std::optional<std::string> read_orbit(std::string_view word, Viewpoint& viewpoint,
                                      std::set<std::string_view>& read) {
    double zoom = 0, fov = 0;
    const struct {
        std::string_view key;
        double least, most;
        double* value;
    } keys[] = {{"az", -180, 180, &viewpoint.azimuth},
                {"el", -89, 89, &viewpoint.elevation},
                {"zoom", 0.1, 20, &zoom},
                {"fov", 5, 120, &fov}};
    const std::size_t equals = word.find('=');
    for (const auto& key : keys) {
        if (equals == std::string_view::npos || word.substr(0, equals) != key.key) continue;
        if (!read.insert(key.key).second) return std::string(key.key) + " is given twice; give it once";
        const std::string_view digits = word.substr(equals + 1);
        const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), *key.value);
        if (failure == std::errc() && end == digits.data() + digits.size() && *key.value >= key.least &&
            *key.value <= key.most) {
            if (key.value == &fov) viewpoint.fov = fov;
            if (key.value == &zoom) viewpoint.zoom = zoom;
            return std::nullopt;
        }
        return std::string(key.key) + formatted(" must be a number from %g to %g", key.least, key.most);
    }
    return std::string("'").append(word).append("' is none of az=, el=, zoom=, fov=");
}

}  // namespace

Result<Viewpoint> parse_viewpoint(const std::string& words) {
    Viewpoint viewpoint;
    if (words == "own") {
        viewpoint.own = true;
        return viewpoint;
    }
    std::string_view rest = words;
    if (!rest.starts_with("orbit") || (rest.size() > 5 && rest[5] != ':'))
        return usage_error(
            "view '" + words + "' is not known; there are own, and orbit such as " + usual_viewpoint,
            {{Setting::view}});
    rest.remove_prefix(std::min<std::size_t>(rest.size(), 6));
    std::set<std::string_view> read;
    while (!rest.empty()) {
        const std::size_t comma = std::min(rest.find(','), rest.size());
        if (const auto fault = read_orbit(rest.substr(0, comma), viewpoint, read))
            return usage_error("view " + words + ": " + *fault, {{Setting::view}});
        rest.remove_prefix(std::min(rest.size(), comma + 1));
    }
    return viewpoint;
}

std::optional<glm::dvec3> ViewCamera::project(const glm::dvec3& world) const {
    const glm::dvec4 clip = clip_from_world * glm::dvec4(world, 1.0);
    if (!(clip.z <= clip.w)) return std::nullopt;
    return glm::dvec3((clip.x / clip.w + 1.0) * width / 2.0, (clip.y / clip.w + 1.0) * height / 2.0,
                      clip.z / clip.w);
}

glm::dvec3 ViewCamera::unproject(double x, double y, double z) const {
    const glm::dvec4 ndc(2.0 * x / width - 1.0, 2.0 * y / height - 1.0, z, 1.0);
    const glm::dvec4 world = glm::inverse(clip_from_world) * ndc;
    return glm::dvec3(world) / world.w;
}

glm::dmat4 clip_from_pixel(const ViewCamera& camera) {
    glm::dmat4 matrix(1.0);
    matrix[0][0] = 2.0 / camera.width;
    matrix[1][1] = 2.0 / camera.height;
    matrix[3] = {-1, -1, 0, 1};
    return matrix;
}

std::optional<PixelBounds> bounds_of_ball(const ViewCamera& camera, const glm::dvec3& centre, double radius) {
    const auto middle = camera.project(centre);
    if (!middle) return std::nullopt;
    const double distance = std::max(camera.near / middle->z, radius * 1.01);
    const double pixels = camera.focal * radius / (distance - radius);
    auto clamped = [](double at, int size) {
        return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(size)));
    };
    return PixelBounds{clamped(middle->x - pixels, camera.width), clamped(middle->y - pixels, camera.height),
                       clamped(middle->x + pixels + 1, camera.width),
                       clamped(middle->y + pixels + 1, camera.height)};
}

glm::vec4 clip_bounds(const std::optional<PixelBounds>& bounds, const ViewCamera& camera) {
    if (!bounds) return glm::vec4(0.0F);
    const double w = camera.width, h = camera.height;
    return glm::vec4(2 * bounds->x0 / w - 1, 2 * bounds->y0 / h - 1, 2 * bounds->x1 / w - 1,
                     2 * bounds->y1 / h - 1);
}

ViewCamera own_view(const Scene& scene, int width, int height, double nearest) {
    const Camera& camera = scene.camera;
    const double scale = fit(scene, width, height);
    return view_of({glm::dmat4(1.0), glm::dvec3(0.0), scale * glm::dvec2(camera.fx, camera.fy),
                    axis_of(scene, width, height), nearest},
                   scene, width, height);
}

double whole_zoom(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre,
                  std::span<const glm::dvec3> points, int width, int height) {
    constexpr double margin = 0.93;     // of the picture
    constexpr double outliers = 0.002;  // of the points
    if (points.empty()) return 1;
    const auto [right, up, back] = orbit_axes(viewpoint);
    const glm::dvec2 reach =
        orbit_focal(viewpoint, scene, width, height) / (margin * 0.5 * glm::dvec2(width, height));
    // From how far away each point is in the picture: focal |right| / (distance - back) is at most half of
    // it.
    std::vector<double> distances;
    distances.reserve(points.size());
    for (const glm::dvec3& point : points) {
        const glm::dvec3 from = point - centre;
        distances.push_back(glm::dot(from, back) + std::max(reach.x * std::abs(glm::dot(from, right)),
                                                            reach.y * std::abs(glm::dot(from, up))));
    }
    const auto at =
        distances.end() - 1 - static_cast<std::ptrdiff_t>(outliers * static_cast<double>(distances.size()));
    std::nth_element(distances.begin(), at, distances.end());
    return std::clamp(-centre.z / std::max(*at, -centre.z), 0.1, 1.0);
}

ViewCamera make_view(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre, int width,
                     int height) {
    // Nothing that a clip holds is nearer than a thousandth of its middle.
    if (viewpoint.own) return own_view(scene, width, height, -centre.z * 1e-3);
    return orbit_view(viewpoint, scene, centre, width, height);
}

}  // namespace touchable
