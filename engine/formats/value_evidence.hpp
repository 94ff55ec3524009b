#pragma once

#include <string>

#include "engine/formats/presets.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

/// What the integers of a picture of 16 bits show of how they were stored. 0 and 65535 say nothing, and one
/// pixel in a thousand may differ. Fewer than 20 values that differ are no evidence. Where it is asked to
/// stop meanwhile they show nothing, and the caller looks for that.

/// The largest number to 1000 of which all are multiples; 1: they have none, or are no evidence.
int common_divisor(const StoredImage& picture);

/// Whose data set stores depth like this: raw disparities with their bytes swapped (nyu), bits rotated by 3
/// (sun). Null: no evidence of any.
struct EvidentPreset {
    const Preset* preset = nullptr;
    std::string why{};  ///< "its values ...", in words
};
EvidentPreset evident_preset(const StoredImage& picture);

}  // namespace touchable
