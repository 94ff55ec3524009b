#pragma once

#include <cstddef>
#include <vector>

#include "engine/scene/depth_coding.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// The stored codes of a depth plane, row by row; of invalid pixels `invalid`.
struct CodePicture {
    static constexpr int invalid = -1;

    int width = 0, height = 0;
    std::vector<int> codes;

    const int* row(int y) const {
        return codes.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
};
CodePicture code_picture(const PlaneView& depth, const DepthCoding& coding);

/// Codes of about the same depth are looked at together: 64, or an eighth of the first one where that is
/// more. The code after those that begin with `first`.
constexpr int end_of_window(int first) {
    const int width = first / 8 > 64 ? first / 8 : 64;
    return first + width < 65536 ? first + width : 65536;
}

}  // namespace touchable
