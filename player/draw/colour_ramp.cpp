#include "player/draw/colour_ramp.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace touchable {
namespace {

// In OKLab: lightness of the ends, and a curve of second order through colour, whose middle control point is
// green. All of it is within what screens show.
constexpr double dark = 0.28, light = 0.95;
constexpr glm::dvec2 blue(0.03, -0.13), green(-0.13, 0), yellow(-0.035, 0.12);

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

std::array<PackedColour, 256> make_ramp() {
    std::array<PackedColour, 256> ramp;
    for (std::size_t k = 0; k < ramp.size(); ++k) {
        const double share = static_cast<double>(k) / 255, rest = 1 - share;
        const glm::dvec2 ab = rest * rest * blue + 2 * share * rest * green + share * share * yellow;
        const glm::dvec3 rgb = linear_rgb(glm::mix(dark, light, share), ab.x, ab.y);
        ramp[k] = pack_colour(byte_of_light(rgb.r), byte_of_light(rgb.g), byte_of_light(rgb.b));
    }
    return ramp;
}

}  // namespace

const std::array<PackedColour, 256>& colour_ramp() {
    static const std::array<PackedColour, 256> ramp = make_ramp();
    return ramp;
}

PackedColour ramp_colour(double share) {
    return colour_ramp()[static_cast<std::size_t>(255 * std::clamp(share, 0.0, 1.0) + 0.5)];
}

}  // namespace touchable
