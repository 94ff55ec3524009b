#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "engine/clip/clip_reader.hpp"
#include "engine/formats/orientation.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/stored_image.hpp"
#include "engine/scene/remark.hpp"

namespace touchable {

/// A phone's photograph with depth: what its file holds and says.
struct DepthPhoto {
    StoredImage depth;                        ///< grey
    StoredImage colour;                       ///< of any size, but of the same view
    Orientation depth_turn{}, colour_turn{};  ///< what makes each upright
    DepthCoding coding;  ///< but for what is derived; without a scale, no `near` and `far`
    bool has_scale = true;
    double metres_per_unit = 1;
    std::optional<Intrinsics> camera{};  ///< of upright pictures of the size that it names
    double film_focal_length = 0;        ///< mm (ExifFacts)
    std::vector<Remark> remarks{};       ///< of what is guessed there
};

/// A clip of one frame, of depth's size. Camera: as known, by the file's, by its focal length, or 60 degrees
/// wide. What is guessed is noted. `described` replaces the scene made from the photograph.
Result<std::unique_ptr<ClipReader>> open_depth_photo(const std::filesystem::path& file, DepthPhoto photo,
                                                     const std::optional<SceneDescription>& described,
                                                     const SourceDescription& known);

}  // namespace touchable
