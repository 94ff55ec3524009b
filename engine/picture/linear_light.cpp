#include "engine/picture/linear_light.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <limits>

namespace touchable {
namespace {

/// By Newton's method, of a number between 0.01 and 1.1.
double fifth_root(double number) {
    double root = 1;
    for (int step = 0; step < 30; ++step) root = (4 * root + number / (root * root * root * root)) / 5;
    return root;
}

double light_of(double srgb) {
    if (srgb <= 0.04045) return srgb / 12.92;
    const double base = (srgb + 0.055) / 1.055, root = fifth_root(base);
    return base * base * root * root;  // to the power of 2.4
}

/// A float's upper 16 bits lead to a sample that is the right one or next to it.
struct SrgbTable {
    std::array<float, 257> least{};  // light of each sample, and one that none has
    std::array<std::uint8_t, 0x3f80> first{};

    SrgbTable() {
        for (std::size_t k = 1; k < 256; ++k)
            least[k] = static_cast<float>(light_of((static_cast<double>(k) - 0.5) / 255));
        least[256] = std::numeric_limits<float>::infinity();
        for (std::size_t k = 0, sample = 0; k < first.size(); ++k) {
            const auto light = std::bit_cast<float>(static_cast<std::uint32_t>(k) << 16U);
            while (light >= least[sample + 1]) ++sample;
            first[k] = static_cast<std::uint8_t>(sample);
        }
    }
};

/// Of every float of 16 bits that is not negative and below 1.
struct HalfTable {
    std::array<std::uint8_t, 0x3c00> sample{};

    HalfTable() {
        double light = 0, step = 1.0 / (1 << 24);  // halves of an exponent are evenly spaced
        for (std::size_t bits = 0; bits < sample.size(); ++bits, light += step) {
            if (bits >= 2048 && bits % 1024 == 0) step *= 2;
            sample[bits] = srgb_sample(static_cast<float>(light));
        }
    }
};

}  // namespace

std::uint8_t srgb_sample(std::uint16_t half) {
    static const HalfTable table;
    if (half < table.sample.size()) return table.sample[half];
    return half <= 0x7c00 ? 255 : 0;  // 1 to infinity; NaN, or negative
}

std::uint8_t srgb_sample(float light) {
    static const SrgbTable table;
    if (!(light > 0)) return 0;
    if (light >= 1) return 255;
    std::size_t sample = table.first[std::bit_cast<std::uint32_t>(light) >> 16U];
    while (light >= table.least[sample + 1]) ++sample;
    return static_cast<std::uint8_t>(sample);
}

}  // namespace touchable
