#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "engine/base/byte_hash.hpp"

namespace touchable {

/// XXH64 (seed 0) over guarded forces as little-endian doubles fx, fy, fz (newtons, world axes), -0 written
/// as +0, ticks outer, fingers inner (docs/conventions.md, Units): equal hashes mean equal forces to the last
/// bit.
class ForceHash {
public:
    void add(const glm::dvec3& force);
    std::uint64_t value() const { return hash_.value(); }
    std::string hex() const { return hash_.hex(); }  ///< 16 digits

private:
    ByteHash hash_;
};

}  // namespace touchable
