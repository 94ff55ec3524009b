#pragma once

// Random numbers that are the same on every machine: single ones, and smooth noise in space.
//
// SplitMix64 returns numbers one by one from a seed, mix64 one for a given number, so that pixels can be
// drawn in any order. GradientNoise is smooth in space, in octaves or with ridges. A SplitMix64 is used by
// one thread, a GradientNoise by any number.

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

namespace touchable {

/// Spreads 64 bits over 64 bits, one to one (splitmix64's finaliser).
constexpr std::uint64_t mix64(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
}

/// splitmix64: the same numbers from a seed on every machine.
class SplitMix64 {
public:
    explicit constexpr SplitMix64(std::uint64_t seed) : state_(seed) {}

    constexpr std::uint64_t next() { return mix64(state_ += 0x9e3779b97f4a7c15U); }
    /// In [0, 1), 53 bits.
    constexpr double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    /// In [low, high).
    constexpr double within(double low, double high) { return low + (high - low) * unit(); }

private:
    std::uint64_t state_;
};

/// 0 below `from`, 1 above `to`, between them the cubic that is level at both ends.
inline double smooth_step(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// Smooth seeded noise in space: 0 at lattice points, about -0.8 to 0.8 between, two continuous derivatives,
/// a period of 256 per axis. The same bits on every machine.
class GradientNoise {
public:
    explicit GradientNoise(std::uint64_t seed);

    double at(const glm::dvec3& p) const;
    /// Sum of `count` octaves, each about twice as fine and half as strong as the one before.
    double octaves(glm::dvec3 p, int count) const;
    /// The same with sharp crests where an octave crosses zero; each finer octave grows on the crests of the
    /// coarser ones. 0 to about 1.
    double ridges(glm::dvec3 p, int count) const;

private:
    double corner(int x, int y, int z, const glm::dvec3& offset) const;
    std::array<std::uint8_t, 512> permutation_;
};

}  // namespace touchable
