#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/formats/xmp.hpp"

namespace touchable {

/// The bytes of a Dynamic Depth JPEG's depth map, a picture after its own: found by the directory of its XMP,
/// which lists the pictures and their lengths. Messages begin with `where`.
Result<std::string_view> dynamic_depth_map(std::string_view jpeg, const XmpEntries& xmp,
                                           const std::string& where);

/// Its camera, of the picture as stored. Nothing where the XMP has none.
std::optional<Intrinsics> dynamic_depth_camera(const XmpProperties& xmp);

}  // namespace touchable
