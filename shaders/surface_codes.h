// SPDX-License-Identifier: Apache-2.0
// Shared by C++ and the kernels that turn stored values into filtered codes. Planes are rows of texels of 16
// bytes, so of 8 codes or 16 stored bytes; bytes beyond the picture's width mean nothing.
// Threads: any; nothing here keeps state.
#ifndef TOUCHABLE_SHADERS_SURFACE_CODES_H
#define TOUCHABLE_SHADERS_SURFACE_CODES_H

#ifdef __cplusplus
#include <cstdint>
namespace touchable {
using uint = std::uint32_t;
#define SURFACE_CODES_FUNCTION constexpr
#else
#define SURFACE_CODES_FUNCTION
#endif

/// Valid codes lie within valid_min to valid_min + valid_span and are none of `excluded`, of which
/// no_such_code excludes nothing.
struct ValidCodes {
    uint valid_min, valid_span;
    uint excluded[4];
};
const uint no_such_code = 65536u;
/// The code of a colour without a hue.
const uint no_hue_code = 65535u;
/// Marks invalid codes between the passes of terrace removal and after them; valid ones are less.
const uint no_finer_code = 65535u;

/// Below valid_min the difference wraps around to something beyond every span.
SURFACE_CODES_FUNCTION bool code_is_in_range(uint code, ValidCodes codes) {
    return code - codes.valid_min <= codes.valid_span;
}
SURFACE_CODES_FUNCTION bool code_is_excluded(uint code, ValidCodes codes) {
    return code == codes.excluded[0] || code == codes.excluded[1] || code == codes.excluded[2] ||
           code == codes.excluded[3];
}

/// Push constants of the kernels that march along strips (strip.h).
struct StripPush {
    uint width, height;        // pixels
    uint in_pitch, out_pitch;  // texels from one row to the next
    uint segments;             // parts of a row that are marched side by side
    uint segment_texels;       // codes of a segment / 8; a multiple of 4
    uint along_x;              // 1: neighbouring lanes are neighbours along x, which suits GPUs
    uint validity_words;       // of a row
    uint pass, groups;         // of fill_holes: which pass this is, and workgroups of each
    uint factor;               // WorkingCodes of filters after the median; unused if they are looked up
    ValidCodes valid;
};

/// The indirect dispatch of a pass of fill_holes: 0 workgroups until the pass before it has filled a hole.
struct FillPass {
    uint groups_x, groups_y, groups_z;
};

// Specialisation constants of those kernels, in order:
//   group_size
//   sample_bytes     of a stored value: 1 or 2
//   may_be_invalid   0 if every stored value is a valid code
//   may_be_excluded  0 if ValidCodes excludes nothing
//   ragged           0 if the width is a multiple of 8 and the height of 2
//   to_finer         1: codes are for filters that need finer ones: working codes, or no_finer_code
//   looked_up        1: working codes are those of a table

/// A length by depth in codes; see engine/scene/scene.hpp.
struct CurvePush {
    uint constant, linear, quadratic, falls, last, shift, from_last;
};

/// Of block.comp: a lane has 4 rows of 8 pixels.
const uint block_lanes_x = 32u, block_lanes_y = 8u;
const uint block_width = 8u * block_lanes_x, block_height = 4u * block_lanes_y;

struct BlockPush {
    uint width, height;        // pixels
    uint in_pitch, out_pitch;  // texels from one row to the next
    uint validity_words;       // of a row
    uint tiles_x, tiles_y;
    uint factor;  // as in StripPush
    ValidCodes valid;
};

// Its specialisation constants, in order: side (of the median's window; 1: codes are only decoded); then, as
// those of strips, sample_bytes, may_be_invalid, may_be_excluded, to_finer, looked_up.

/// Push constants of pack_rows.
struct PackRowsPush {
    uint width, count;  // codes of a row, and of all
    uint pitch;         // words of 4 bytes from one row to the next
};
const uint pack_rows_group = 256u;

/// Push constants of terraces; width to along_x as in StripPush, but a lane has one row.
struct TerracesPush {
    uint width, height, pitch;
    uint segments, segment_texels, along_x;
    CurvePush steps, levels;     // distances of stored codes, and of levels, in working codes
    uint fraction, step, noise;  // TerraceFilter
};

/// Steps of the widest ramp whose pixels are pulled in; pixels farther away are not read.
const uint most_ramp_steps = 12u;

/// Push constants of flying_pixels.
struct FlyingPixelsPush {
    uint width, height;
    uint in_pitch, out_pitch;  // texels from one row to the next
    CurvePush gate;
    ValidCodes valid;
};

/// Push constants of temporal.
struct TemporalPush {
    uint height, pitch;  // pixels; texels from one row to the next
    uint begins;         // 1: nothing is known of the frame before
    CurvePush gate;
    uint none;         // what an invalid code becomes; beyond `valid`
    ValidCodes valid;  // which excludes nothing
};

/// A part of bounds, of a strip of two rows and a tile with the first column of the next one, takes 8 bytes:
/// a word least | greatest << 16 over valid codes, and one that is not 0 if a code is invalid. Those of two
/// tiles, as wide as a word of validity, are a texel.
const uint tile_pair_bytes = 16u;
/// The first word of a part without a valid code.
const uint no_part = 65535u;

/// Push constants of tile_bounds.
struct TileBoundsPush {
    uint width, height;
    uint pitch;          // texels of codes from one row to the next
    uint words, strips;  // pairs of tiles in a row, and pairs of rows
    uint tiles_x, tiles_y;
};

/// Push constants of hue_codes.
struct HueCodesPush {
    uint width, height;
    uint in_pitch;   // words of 4 bytes from one row to the next
    uint out_pitch;  // texels
    uint least_sum;
};

const uint tile_bounds_group = 32u;
const uint hue_codes_group = 32u;
const uint temporal_group = 32u;
const uint flying_pixels_group = 32u;
const uint tile_cells = 16u;
const uint strips_per_tile = 8u;

#ifdef __cplusplus
}  // namespace touchable
#endif
#undef SURFACE_CODES_FUNCTION

#endif
