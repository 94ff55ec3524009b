#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/base/stop_request.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

/// What renderers write into pictures of floats where they see nothing, in whatever unit: infinity, 1e9 and
/// beyond (Blender: 1e10), and the largest number of 16 bits, 65504, which is what files of halves have in
/// their place. Halves become floats of 32 bits in other programs. So 65504 is background in any picture of
/// floats, but not where that has a depth farther than it. Of either sign. Codes have no background.
class RendererBackground {
public:
    explicit RendererBackground(const StoredImage& picture) {
        float farthest = 0;
        until_stopped(picture.values.size(), [&](std::size_t first, std::size_t last) {
            for (std::size_t k = first; k < last; ++k) {
                const float size = std::abs(picture.values[k]);
                farthest = std::max(farthest, size < endless ? size : 0.0F);
            }
        });
        has_largest_half_ = farthest == largest_half;
    }
    /// Whether a value of the picture is none that it saw. (NaN is no value.)
    bool is(double value) const {
        const double size = std::abs(value);
        return size >= double{endless} || (has_largest_half_ && size == double{largest_half});
    }

private:
    static constexpr float endless = 1e9F, largest_half = 65504;
    bool has_largest_half_ = false;
};

}  // namespace touchable
