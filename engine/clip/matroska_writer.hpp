#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_writer.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/picture/stored_sound.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

inline constexpr int clip_format_version = 2;

/// What a clip's tracks are to be good at (docs/codecs.md).
enum class Archive {
    fast,   ///< quick to decode
    small,  ///< few bytes: for each plane the coding that takes fewer
};

/// Tracks of a clip, and the file that has them.
struct CopiedTracks {
    std::filesystem::path file;
    std::vector<PlaneRole> roles;
};

/// How a clip's pictures are stored. Depth, haptic and height always keep every value.
struct ClipStorage {
    Archive archive = Archive::fast;
    bool exact_colour = false;  ///< otherwise colour is as good as the eye can tell
    bool gives_colour = false;  ///< whoever writes asks for ClipWriter::stored_colour; costs decoding it
    bool fragmented = false;    ///< readable while it is written, and up to where it was cut: MP4 only
    /// Matroska: tracks of another clip that have the pictures of these frames already. They are copied as
    /// they are stored, where that can be done (TrackCopy), and only planes of other roles are encoded.
    std::optional<CopiedTracks> copied{};
};

/// Refuses a scene that no clip of ours can have, whatever its container. Errors name the file to be written.
Result<void> check_storable(const std::filesystem::path& path, const SceneDescription& described);

/// A touchable clip: Matroska, one track per plane tagged with its role, the scene attached as JSON; filters
/// may be left open there. A size that no clip can hold is told by the first `write`, as an error of kind
/// usage.
Result<std::unique_ptr<ClipWriter>> create_clip(const std::filesystem::path& path,
                                                const SceneDescription& described,
                                                const ClipStorage& storage = {},
                                                Existing existing = Existing::replace,
                                                const std::optional<SoundPart>& sound = {});

}  // namespace touchable
