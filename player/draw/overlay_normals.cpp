#include "player/draw/overlay_normals.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "shaders/cut_rule.h"

// Compiled without errno and traps: the loops below become vectors by themselves.

namespace touchable {
namespace {

/// What q gains from one pixel to the next, by those of the two neighbours that are of the same surface.
[[gnu::always_inline]] inline float slope(float before, float here, float after) {
    const auto joined = [here](float other) __attribute__((always_inline)) {
        const float least = other < here ? other : here, greatest = other < here ? here : other;
        return least > 0.0F && greatest <= CUT_RULE_RATIO * least ? 1.0F : 0.0F;
    };
    const float with_before = joined(before), with_after = joined(after), count = with_before + with_after;
    const float sum = with_before * (here - before) + with_after * (after - here);
    return count > 1.5F ? 0.5F * sum : sum;
}

}  // namespace

PackedColour normal_colour(const glm::dvec3& normal) {
    const glm::uvec3 byte(127.5 * normal + 128.0);
    return pack_colour(byte.r, byte.g, byte.b);
}

NormalRows::NormalRows(const Camera& camera, int width, int height, const float* q)
    : camera_(camera), width_(width), height_(height), q_(q) {
    const auto columns = static_cast<std::size_t>(width);
    u_.resize(columns);
    along_x_.resize(columns);
    along_y_.resize(columns);
    for (int x = 0; x < width; ++x) u_[static_cast<std::size_t>(x)] = static_cast<float>(camera.u(x));
}

void NormalRows::paint(int y, std::uint8_t* rgb) {
    const float* here = q_ + std::ptrdiff_t{y} * width_;
    const float* above = y > 0 ? here - width_ : here;
    const float* below = y + 1 < height_ ? here + width_ : here;
    float *along_x = along_x_.data(), *along_y = along_y_.data();
    const float* u = u_.data();
    // At the picture's edge the only neighbour counts, and not half of it.
    const float edge = above == here || below == here ? 2.0F : 1.0F;
    for (int x = 0; x < width_; ++x) along_y[x] = edge * slope(above[x], here[x], below[x]);
    for (int x = 1; x < width_ - 1; ++x) along_x[x] = slope(here[x - 1], here[x], here[x + 1]);
    along_x[0] = width_ > 1 ? slope(0.0F, here[0], here[1]) : 0.0F;
    along_x[width_ - 1] = width_ > 1 ? slope(here[width_ - 2], here[width_ - 1], 0.0F) : 0.0F;
    const auto fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    const auto v = static_cast<float>(camera_.v(y));
    for (int x = 0; x < width_; ++x) {
        // A plane's points P have n P = 1; q = n (u, v, -1). The normal towards the camera is -n.
        const float nx = -fx * along_x[x], ny = fy * along_y[x], nz = here[x] + nx * u[x] + ny * v;
        const float length = std::sqrt(nx * nx + ny * ny + nz * nz);
        const float scale = 127.5F / (length > 1e-30F ? length : 1e-30F);
        rgb[3 * x] = static_cast<std::uint8_t>(static_cast<int>(nx * scale + 128.0F));
        rgb[3 * x + 1] = static_cast<std::uint8_t>(static_cast<int>(ny * scale + 128.0F));
        rgb[3 * x + 2] = static_cast<std::uint8_t>(static_cast<int>(nz * scale + 128.0F));
    }
}

}  // namespace touchable
