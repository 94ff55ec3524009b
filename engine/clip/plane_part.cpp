#include "engine/clip/plane_part.hpp"

#include <cstring>

namespace touchable {

PlaneView part_of(const PlaneView& plane, PlanePart part, int low_bits, std::vector<std::uint8_t>& memory) {
    if (part == PlanePart::whole) return plane;
    const auto width = static_cast<std::size_t>(plane.width);
    memory.resize(width * static_cast<std::size_t>(plane.height));
    const unsigned low = (1U << low_bits) - 1;
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* from = plane.row(y);
        std::uint8_t* to = memory.data() + width * static_cast<std::size_t>(y);
        for (std::size_t x = 0; x < width; ++x) {
            std::uint16_t sample;
            std::memcpy(&sample, from + 2 * x, 2);
            to[x] = static_cast<std::uint8_t>(part == PlanePart::high ? sample >> low_bits : sample & low);
        }
    }
    return {memory.data(), plane.width, plane.width, plane.height, 1, 1};
}

}  // namespace touchable
