// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/surface_case.hpp"

#include <cstring>

namespace touchable {

std::string name_of(const SurfaceCase& c) {
    return std::to_string(c.width) + "x" + std::to_string(c.height) + "-" + std::to_string(c.bits) +
           (c.holes_pct > 0 ? "-holes" + std::to_string(c.holes_pct) : "");
}

Error wrong(const SurfaceCase& c, const std::string& what) {
    return {ErrorKind::check, name_of(c) + ": " + what};
}

Picture::Picture(const SurfaceCase& c) {
    scene.width = c.width;
    scene.height = c.height;
    scene.depth_bits = c.bits;
    scene.camera = {0.9 * c.width, 0.9 * c.width, c.width / 2.0, c.height / 2.0};
    scene.depth.near = 500;
    scene.depth.far = 1000;
    scene.depth.code_max = static_cast<std::uint16_t>((1 << c.bits) - 1);
    scene.depth.invalid_code_count = c.holes_pct > 0 ? 1 : 0;
    derive_valid_range(scene.depth);
    const int bytes = c.bits > 8 ? 2 : 1;
    memory.resize(static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height * bytes));
    std::uint64_t state = 7;
    const auto random = [&state] {
        return (state = state * 6364136223846793005U + 1442695040888963407U) >> 33;
    };
    const std::uint64_t codes = scene.depth.code_max;
    for (int y = 0; y < c.height; ++y)
        for (int x = 0; x < c.width; ++x) {
            const std::uint64_t slope = (codes - 1) * static_cast<std::uint64_t>(x + y) /
                                        static_cast<std::uint64_t>(c.width + c.height);
            auto code = static_cast<std::uint16_t>(1 + (slope + random() % 20) % codes);
            if (static_cast<int>(random() % 100) < c.holes_pct) code = 0;
            std::memcpy(memory.data() + (static_cast<std::ptrdiff_t>(y) * c.width + x) * bytes, &code,
                        static_cast<std::size_t>(bytes));
        }
    raw.depth = {memory.data(), std::ptrdiff_t{c.width} * bytes, c.width, c.height, bytes, 1};
}

}  // namespace touchable
