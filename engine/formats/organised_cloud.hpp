// SPDX-License-Identifier: Apache-2.0
#pragma once

// Organised point clouds, PCD and PLY: one point for each pixel of a camera, row by row. Their z is a depth
// picture, colour may be beside it, and x and y tell the camera. Pure functions, for any thread.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"

namespace touchable {

struct OrganisedCloud {
    StoredImage depth;                   ///< floats, NaN for pixels without a point; `beside` may have colour
    std::optional<Intrinsics> camera{};  ///< the camera of the points; nothing: there is no point
};

/// Whether a name ends in .pcd or .ply, as clouds with rows and columns and other clouds do.
bool is_named_cloud(const std::filesystem::path& file);

/// Whether a cloud's header, within its first 64 KiB, states rows and columns. Always false for a mesh.
bool begins_organised_cloud(std::string_view begin);
bool is_organised_cloud(const SourceFile& file);

/// Decodes a cloud. Depth is z, or -z if no z is positive (OpenGL). An error if the bytes are cut or damaged,
/// or if the rows and columns are not the pixels of one pinhole camera (a lidar's are not). Messages begin
/// with `where`.
Result<OrganisedCloud> decode_organised_cloud(std::string_view bytes, const std::string& where);

}  // namespace touchable
