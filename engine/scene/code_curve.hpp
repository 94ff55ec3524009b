#pragma once

#include <algorithm>
#include <cstdint>

#include "engine/scene/depth_coding.hpp"

namespace touchable {

/// A length that grows with depth z: constant + quadratic z^2, scene units.
struct DepthLength {
    double constant = 0, quadratic = 0;

    double at(double depth) const { return constant + quadratic * depth * depth; }
    DepthLength times(double factor) const { return {factor * constant, factor * quadratic}; }
    bool operator==(const DepthLength&) const = default;
};

/// Such a length in the place of one that grows as depth does, `share` (z + shift): of those that are off it
/// by the same factor at both ends of a range and in between. Of near:far 1:3 that factor is 1.07, 1:8 1.23,
/// 1:30 1.5.
DepthLength length_along_depth(double share, double shift, double near, double far);

/// So twice as much has 16 bits.
inline constexpr int code_curve_most = 32767;

/// Such a length at a code, told in codes, in integers (docs/conventions.md): a polynomial of second degree
/// in the code's distance from one end. For inverse depth w it is constant w^2 + quadratic. For log codes it
/// equals the length at both planes and in the middle. It is not negative. Of its coefficients only the
/// linear one can be, for log codes and where codes have a shift; then it can be least between the ends.
struct CodeCurve {
    std::uint16_t constant = 0, linear = 0, quadratic = 0;  ///< each at most a third of 65535
    bool falls = false;                                     ///< the linear coefficient counts as negative
    std::uint16_t last = 0;                                 ///< largest code
    int shift = 0;                                          ///< by which a distance fills 16 bits
    bool from_last = false;                                 ///< distances are taken from `last`, not from 0

    /// At most code_curve_most.
    int at(std::uint16_t code) const {
        const std::uint32_t n = static_cast<std::uint32_t>(from_last ? last - code : code) << shift;
        const std::uint32_t sloped = linear * n >> 16;
        std::uint32_t value = constant + (quadratic * (n * n >> 16) >> 16);
        value = falls ? value - std::min(value, sloped) : value + sloped;
        return static_cast<int>(std::min<std::uint32_t>(value, code_curve_most));
    }
    bool is_zero() const { return (constant | linear | quadratic) == 0; }
    bool operator==(const CodeCurve&) const = default;
};
/// `times` the length, in codes of `coding`.
CodeCurve code_curve(const DepthCoding& coding, const DepthLength& length, double times);

}  // namespace touchable
