#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

namespace touchable {

/// Smooth seeded noise in space: 0 at lattice points, about -0.8 to 0.8 between, two continuous derivatives,
/// a period of 256 per axis. The same bits on every machine.
class GradientNoise {
public:
    explicit GradientNoise(std::uint64_t seed);

    double at(const glm::dvec3& p) const;
    /// Sum of `count` octaves, each about twice as fine and half as strong as the one before.
    double octaves(glm::dvec3 p, int count) const;
    /// The same with sharp crests where an octave crosses zero; each finer one grows on the crests above it.
    /// 0 to about 1.
    double ridges(glm::dvec3 p, int count) const;

private:
    double corner(int x, int y, int z, const glm::dvec3& offset) const;
    std::array<std::uint8_t, 512> permutation_;
};

}  // namespace touchable
