#pragma once

// Depth of an OpenEXR rendering whose channel a person names. Pure functions, for any thread.

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

/// The setting by which a person names depth's channel, for hints.
inline constexpr Setting::Name depth_channel_setting = "channel";

/// As decode_exr, of the channel or the layer of this name; empty: found by the names of all channels. A file
/// without it is refused with the names that it has.
Result<StoredImage> decode_exr_depth(std::string_view bytes, const std::string& where,
                                     const BesideDepth::Wanted& wanted, const std::string& channel);

}  // namespace touchable
