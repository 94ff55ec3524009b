// SPDX-License-Identifier: Apache-2.0
#include "player/view/drawn_surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/base/same_bits.hpp"
#include "shaders/blend_rule.h"
#include "shaders/surface_light.h"

namespace touchable {
namespace {

/// Area-weighted sums of the triangle normals at each vertex. Cut triangles do not count.
std::vector<glm::vec3> vertex_normals(const Camera& camera, const ViewSurface& surface) {
    std::vector<glm::vec3> normals(surface.q.size(), glm::vec3(0.0F));
    auto point = [&](int x, int y) {
        return unproject(camera, x, y, 1.0 / static_cast<double>(surface.q[surface.index(x, y)]));
    };
    auto add = [&](std::array<glm::ivec2, 3> at) {
        const std::size_t a = surface.index(at[0].x, at[0].y), b = surface.index(at[1].x, at[1].y),
                          c = surface.index(at[2].x, at[2].y);
        if (triangle_is_cut(surface.q[a], surface.q[b], surface.q[c])) return;
        const glm::dvec3 origin = point(at[0].x, at[0].y);
        const glm::vec3 normal =
            glm::cross(point(at[1].x, at[1].y) - origin, point(at[2].x, at[2].y) - origin);
        for (const std::size_t vertex : {a, b, c}) normals[vertex] += normal;
    };
    for (int y = 0; y + 1 < surface.height; ++y)
        for (int x = 0; x + 1 < surface.width; ++x) {
            add({{{x, y}, {x + 1, y + 1}, {x + 1, y}}});
            add({{{x, y}, {x, y + 1}, {x + 1, y + 1}}});
        }
    return normals;
}

/// Replaces each of `count` values by the sum over those at most n away.
template <class At>
void box_sum(int count, int n, At at) {
    std::vector<glm::vec3> values(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) values[static_cast<std::size_t>(k)] = at(k);
    for (int k = 0; k < count; ++k) {
        glm::vec3 sum(0.0F);
        for (int other = std::max(0, k - n); other <= std::min(count - 1, k + n); ++other)
            sum += values[static_cast<std::size_t>(other)];
        at(k) = sum;
    }
}

/// Averages normals over 5x5 vertices, so that a depth camera's quantisation steps do not look like relief.
void smooth(const ViewSurface& surface, std::vector<glm::vec3>& normals) {
    constexpr int reach = 2;
    for (int y = 0; y < surface.height; ++y)
        box_sum(surface.width, reach, [&](int x) -> glm::vec3& { return normals[surface.index(x, y)]; });
    for (int x = 0; x < surface.width; ++x)
        box_sum(surface.height, reach, [&](int y) -> glm::vec3& { return normals[surface.index(x, y)]; });
}

PackedColour packed(const glm::vec3& colour) {
    const glm::uvec3 byte(colour + 0.5F);
    return pack_colour(byte.r, byte.g, byte.b);
}

// Okabe and Ito's colours, in the order of the plots (player/plot/style.py): distinct with any colour vision.
// Three of Tol's follow, for ten different fingers.
constexpr std::array<PackedColour, 10> finger_colours{pack_colour(0, 114, 178),   pack_colour(230, 159, 0),
                                                      pack_colour(0, 158, 115),   pack_colour(213, 94, 0),
                                                      pack_colour(204, 121, 167), pack_colour(86, 180, 233),
                                                      pack_colour(240, 228, 66),  pack_colour(51, 34, 136),
                                                      pack_colour(136, 34, 85),   pack_colour(153, 153, 51)};

/// Linear light of sRGB's primaries (OKLab: Ottosson 2020).
glm::dvec3 linear_rgb(double lightness, double a, double b) {
    const auto cube = [](double x) { return x * x * x; };
    const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b),
                 m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b),
                 s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
            -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
            -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

std::uint32_t byte_of_light(double light_share) {
    const double x = std::clamp(light_share, 0.0, 1.0);
    const double srgb = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return static_cast<std::uint32_t>(255 * srgb + 0.5);
}

}  // namespace

float cut_ratio(int step) {
    float ratio = CUT_RULE_RATIO;
    for (; step > 1; step /= 2) ratio *= ratio;
    return ratio;
}

EdgeLattice edge_lattice(const float* q, int width, int height, int pitch, int step, float focal_length) {
    return {q, width, height, pitch, cut_ratio(step), 0.312F / std::sqrt(focal_length)};
}

ViewCamera decimated(ViewCamera camera, int step) {
    camera.clip_from_lattice[0] *= step;
    camera.clip_from_lattice[1] *= step;
    return camera;
}

float blend_reach(const HeightField& field) {
    const auto longest = static_cast<double>(BLEND_RULE_SECONDS);
    const double seconds = std::min(field.frame_interval().value_or(longest), longest);
    return static_cast<float>(static_cast<double>(BLEND_RULE_SPEED) * seconds /
                              field.scene().metres_per_unit);
}

double height_per_code(const Scene& scene) {
    return largest_height(scene.height_coding, scene.depth) / scene.height_coding.code_max;
}

bool are_mixed(const HeightField& field, const FieldVertex& prev, const FieldVertex& next) {
    return prev.valid && next.valid &&
           depths_mix(static_cast<float>(prev.depth), static_cast<float>(next.depth), blend_reach(field));
}

FieldVertex drawn_vertex(const HeightField& field, std::int64_t i, std::int64_t j) {
    const auto [prev, next] = field.vertices_of_frames(i, j);
    if (are_mixed(field, prev, next)) return {prev.depth + (next.depth - prev.depth) * field.blend(), true};
    return field.blend() >= 0.5 ? next : prev;
}

float drawn_q(const HeightField& field, int x, int y) {
    const Scene& scene = field.scene();
    const FieldVertex vertex = drawn_vertex(field, x, y);
    const double depth = planar_depth(scene.camera, scene.depth.semantics, x, y, vertex.depth);
    return vertex.valid ? static_cast<float>(1.0 / depth) : 0.0F;
}

std::vector<float> q_of(const HeightField& field) {
    std::vector<float> q;
    q.reserve(pixel_count(field.width(), field.height()));
    for (int y = 0; y < field.height(); ++y)
        for (int x = 0; x < field.width(); ++x) q.push_back(drawn_q(field, x, y));
    return q;
}

ViewSurface make_view_surface(const HeightField& field, std::vector<float> q, const PlaneView& colour,
                              Lighting lighting) {
    ViewSurface surface;
    surface.width = field.width();
    surface.height = field.height();
    surface.focal_length = static_cast<float>(field.scene().camera.fx);
    surface.fills_gaps = fills_gaps(colour, lighting);
    surface.q = std::move(q);
    surface.colours = lit_colours(field.scene().camera, surface, colour, lighting);
    return surface;
}

UsualQ usual_q(int width, int height, const std::function<float(int x, int y)>& q_at) {
    // A few thousand vertices suffice; always the same ones, so that static surfaces keep their shade.
    constexpr double enough = 8192;
    const int step = 1 + static_cast<int>(std::sqrt(static_cast<double>(width) * height / enough));
    std::vector<float> valid;
    for (int y = 0; y < height; y += step)
        for (int x = 0; x < width; x += step)
            if (const float q = q_at(x, y); q > 0) valid.push_back(q);
    if (valid.empty()) return {0, 1};
    auto quantile = [&valid](std::size_t percent) {
        return sorted_element(valid, (valid.size() - 1) * percent / 100);
    };
    return {quantile(4), quantile(96)};
}

std::vector<PackedColour> lit_colours(const Camera& camera, const ViewSurface& surface,
                                      const PlaneView& colour, Lighting lighting) {
    std::vector<glm::vec3> normals = vertex_normals(camera, surface);
    smooth(surface, normals);
    const auto [farthest_q, nearest_q] =
        usual_q(surface.width, surface.height, [&](int x, int y) { return surface.q[surface.index(x, y)]; });
    const float q_range = std::max(nearest_q - farthest_q, 1e-30F);

    std::vector<PackedColour> colours;
    colours.reserve(surface.q.size());
    for (int y = 0; y < surface.height; ++y)
        for (int x = 0; x < surface.width; ++x) {
            const std::size_t at = surface.index(x, y);
            const double length = glm::length(glm::dvec3(normals[at]));
            const glm::dvec3 normal = length > 0 ? glm::dvec3(normals[at]) / length : glm::dvec3(0, 0, 1);
            const float light = light_on(glm::vec3(normal));
            if (!colour.empty()) {
                const std::uint8_t* rgb = colour.row(y) + std::ptrdiff_t{3} * x;
                colours.push_back(
                    packed(lit_colour(glm::vec3(rgb[0], rgb[1], rgb[2]), light, light_strength(lighting))));
                continue;
            }
            colours.push_back(packed(lit_clay((surface.q[at] - farthest_q) / q_range, light)));
        }
    return colours;
}

const std::array<PackedColour, 256>& colour_ramp() {
    static const std::array<PackedColour, 256> ramp = [] {
        // In OKLab: lightness of the ends, and a quadratic curve through colour, whose middle control point
        // is green. Every colour is within sRGB.
        constexpr double dark = 0.28, light = 0.95;
        constexpr glm::dvec2 blue(0.03, -0.13), green(-0.13, 0), yellow(-0.035, 0.12);
        std::array<PackedColour, 256> made;
        for (std::size_t k = 0; k < made.size(); ++k) {
            const double share = static_cast<double>(k) / 255, rest = 1 - share;
            const glm::dvec2 ab = rest * rest * blue + 2 * share * rest * green + share * share * yellow;
            const glm::dvec3 rgb = linear_rgb(glm::mix(dark, light, share), ab.x, ab.y);
            made[k] = pack_colour(byte_of_light(rgb.r), byte_of_light(rgb.g), byte_of_light(rgb.b));
        }
        return made;
    }();
    return ramp;
}

PackedColour ramp_colour(double share) {
    return colour_ramp()[static_cast<std::size_t>(255 * std::clamp(share, 0.0, 1.0) + 0.5)];
}

PackedColour finger_colour(std::size_t finger) {
    return finger_colours[finger % finger_colours.size()];
}

}  // namespace touchable
