#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>

namespace touchable {

/// XXH64 (seed 0) over guarded forces as little-endian doubles fx, fy, fz (newtons, world axes), -0 written
/// as +0, ticks outer, fingers inner: equal hashes mean equal forces to the last bit.
class ForceHash {
public:
    ForceHash();
    ~ForceHash();
    ForceHash(const ForceHash&) = delete;
    ForceHash& operator=(const ForceHash&) = delete;

    void add(const glm::dvec3& force);
    std::uint64_t value() const;
    std::string hex() const;  ///< 16 digits

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace touchable
