#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "engine/scene/camera.hpp"

namespace touchable {

/// How a code becomes a depth in scene units; n = code / code_max where near_is_high, 1 - that otherwise.
/// - linear:  far + (near - far) n                   (Eq. 3)
/// - inverse: 1 / (1/far + (1/near - 1/far) n); with a shift s 1 / (1/(far + s) + (1/(near + s) - 1/(far +
/// s)) n)
///            - s
/// - log:     e^(ln(far + shift) + (ln(near + shift) - ln(far + shift)) n) - shift
/// - metric:  scale * code
/// - hue:     as linear, of the code that shaders/hue_code.h makes from an RGB pixel
enum class DepthCodingKind { linear, inverse, metric, hue, log };

struct DepthCoding {
    static constexpr int max_invalid_codes = 4;
    /// Hue: codes of the whole colour circle; the last that a pixel can have is one less.
    static constexpr std::uint16_t hue_circle = 1536;

    DepthCodingKind kind = DepthCodingKind::linear;
    DepthSemantics semantics = DepthSemantics::range;
    bool near_is_high = true;      ///< all but metric: the largest code is the near plane
    double near = 0;               ///< scene units; for metric the smallest depth that is valid (0: any)
    double far = 0;                ///< scene units, finite; deeper codes are invalid
    double scale = 0;              ///< metric: scene units per code
    double shift = 0;              ///< scene units, added to the depth: see the kinds
    std::uint16_t code_max = 255;  ///< largest native code
    int least_sum = 0;             ///< hue: pixels with R + G + B below this, 0 to 765, are invalid
    std::array<std::uint16_t, max_invalid_codes> invalid_codes{};
    int invalid_code_count = 0;
    /// The least and the greatest valid code, so codes outside are invalid; derived by `derive_valid_range`
    /// from the members above. Least > greatest: none is valid.
    std::uint16_t valid_min = 0, valid_max = 255;

    /// Whether every code from `least` to `greatest` is valid.
    bool all_valid(std::uint16_t least, std::uint16_t greatest) const {
        for (int k = 0; k < invalid_code_count; ++k) {
            const std::uint16_t code = invalid_codes[static_cast<std::size_t>(k)];
            if (least <= code && code <= greatest) return false;
        }
        return least >= valid_min && greatest <= valid_max;
    }
    bool is_valid(std::uint16_t code) const { return all_valid(code, code); }
    /// Depth of a valid code, in scene units, of the coding's own semantics; > 0 and <= far.
    double depth(std::uint16_t code) const {
        if (kind == DepthCodingKind::metric) return scale * code;
        // Share of the way from the far plane (0) to the near plane (1).
        const double value = code, share = (near_is_high ? value : code_max - value) / code_max;
        if (share == 0.0) return far;  // the planes exactly, whatever rounding does between them
        if (share == 1.0) return near;
        const double deep = far + shift;
        const double between = kind == DepthCodingKind::inverse
                                   ? 1.0 / (1.0 / deep + (1.0 / (near + shift) - 1.0 / deep) * share) - shift
                               : kind == DepthCodingKind::log ? log_depth(share)
                                                              : far + (near - far) * share;
        return std::clamp(between, near, far);
    }
    /// Log: the depth at a share of the way from the far plane (0) to the near one (1), unclamped.
    double log_depth(double share) const;
    /// Log: ln((far + shift)/(near + shift)), the way from plane to plane.
    double log_span() const;
    /// Of all valid codes the smallest depth. Needs one.
    double nearest_depth() const { return depth(deeper_is_higher() ? valid_min : valid_max); }
    /// Of all valid codes the largest depth. Needs one.
    double deepest_depth() const { return depth(deeper_is_higher() ? valid_max : valid_min); }
    /// The valid code whose depth is nearest to `depth` (ties: the lower code).
    std::uint16_t code(double depth) const;
    /// True where a larger code is a larger depth.
    bool deeper_is_higher() const { return kind == DepthCodingKind::metric || !near_is_high; }
    /// One *level*: (far - near)/255, the paper's grey level as a length.
    double level() const { return (far - near) / 255.0; }

    bool operator==(const DepthCoding&) const = default;
};

/// Sets valid_min and valid_max to the least and the greatest code with 0 < depth, near <= depth <= far and
/// code <= code_max that is none of the invalid ones. All between them fit too, but for invalid ones.
void derive_valid_range(DepthCoding& coding);

}  // namespace touchable
