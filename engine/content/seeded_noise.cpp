// Gradient noise.
#include "engine/content/seeded_noise.hpp"

#include <cmath>
#include <utility>

namespace touchable {
namespace {

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

}  // namespace touchable
