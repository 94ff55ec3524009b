#include "haptics_cpu/force_hash.hpp"

#include <array>
#include <bit>

namespace touchable {

void ForceHash::add(const glm::dvec3& force) {
    std::array<std::uint8_t, 24> bytes;
    std::size_t at = 0;
    for (const double component : {force.x, force.y, force.z}) {
        const auto bits = std::bit_cast<std::uint64_t>(component == 0 ? 0.0 : component);
        for (int shift = 0; shift < 64; shift += 8) bytes[at++] = static_cast<std::uint8_t>(bits >> shift);
    }
    hash_.add(bytes.data(), bytes.size());
}

}  // namespace touchable
