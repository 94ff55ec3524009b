#pragma once

#include "engine/picture/stored_image.hpp"

namespace touchable {

/// What the values of a picture tell of their unit.
struct EstimatedValues {
    bool is_float = false;
    bool has_background = false;  ///< a renderer's (RendererBackground)
    bool any = false;  ///< is neither 0, background nor, of 16 bits, the largest; what follows is of these
    int bits = 16;
    double median = 0;
    double upper = 0, lower = 0;  ///< means of the upper and the lower third of the picture
    double negative = 0;          ///< share of all; 0 where all of them are one number, which is none then
    bool has_negative_none = false;
    bool is_normalised = false;  ///< from the least that can be stored (floats: 0) to the most (1)
    int divisor = 1;             ///< of integers of 16 bits (common_divisor)
    /// Of 8 bits, which somebody stretched to 16.
    bool is_of_bytes() const { return divisor == 256 || divisor == 257; }
};
/// Unfinished where it is asked to stop meanwhile, which the caller looks for.
EstimatedValues estimate_values(const StoredImage& picture);

}  // namespace touchable
