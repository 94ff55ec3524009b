#pragma once

// Organised clouds of points, PCD and PLY: one point for each pixel of a camera, row by row. Their z is a
// picture of depth, colour may be beside it, and where x and y lie tells the camera. Pure functions, for any
// thread.

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
    StoredImage depth;                   ///< floats, NaN where there is no point; `beside` may have colour
    std::optional<Intrinsics> camera{};  ///< that its points are of; none: it has no point
};

/// Whether a name ends as those of clouds do, with rows and columns or without.
bool is_named_cloud(const std::filesystem::path& file);

/// Whether a cloud says that it has rows and columns, by its header, which the first 64 KiB have. A mesh has
/// none.
bool begins_organised_cloud(std::string_view begin);
bool is_organised_cloud(const SourceFile& file);

/// Refused: what is cut or damaged, and points that no pinhole camera sees in rows and columns, as those of a
/// lidar are. Depth is z, or -z where no z is positive (OpenGL). Messages begin with `where`.
Result<OrganisedCloud> decode_organised_cloud(std::string_view bytes, const std::string& where);

}  // namespace touchable
