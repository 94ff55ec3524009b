#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/scene/depth_coding.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// A square of pixels.
struct Cell {
    static constexpr std::int32_t per_code = 16, per_level = 16;
    static constexpr std::int32_t none = -1;

    std::int32_t depth = none;  ///< mean code, sixteenths; none: of two surfaces, or a pixel without depth
    std::int32_t luma = none;   ///< mean brightness, sixteenths of 255 levels; none: without colour
    bool is_textured = false;   ///< its brightness tells whether what is there moves
};

/// A frame as some thousand cells, in which noise is averaged out: 640x480 pixels are 80x60.
struct CellPicture {
    std::vector<Cell> cells;
    bool has_colour = false;
    std::uint16_t least = 0, most = 0;  ///< valid codes; 0 and 0 where there are none
};
CellPicture cell_picture(const RawFrame& frame, const DepthCoding& coding);

}  // namespace touchable
