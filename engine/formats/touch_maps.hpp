// SPDX-License-Identifier: Apache-2.0
#pragma once

// Touch as other programs describe it: X3D surfaces and glTF haptic materials, each of whose properties is a
// picture or a video, become one haptic plane of a clip.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A file that another file names by a URL or embeds.
struct LinkedFile {
    std::filesystem::path file;                ///< empty: it is embedded
    std::shared_ptr<const std::string> bytes;  ///< of an embedded file; null otherwise
    std::string name;                          ///< for messages
    bool operator==(const LinkedFile&) const = default;
};
/// Whether a URL is a path, file: or data:, not a network address or another scheme.
bool is_local_link(std::string_view url);
/// Resolves `url` in the file `holder`: a path relative to its folder, which may lead out of it; file:; or
/// data: in base64. An error for anything else. A name with %XX is decoded unless a file has it literally.
Result<LinkedFile> follow_link(std::string_view url, const std::filesystem::path& holder);
/// The linked file's bytes, up to 257 MiB.
Result<std::shared_ptr<const std::string>> bytes_of(const LinkedFile& link);

/// Properties of touch, in the order of a haptic plane's red, green and blue.
inline constexpr std::array<std::string_view, 3> property_names{"stiffness", "static friction",
                                                                "dynamic friction"};
/// One property of another program's surface.
struct HapticLayer {
    std::optional<LinkedFile> picture;  ///< nothing: the value is the same everywhere
    PropertyRange range{};              ///< values at black and white; equal without a picture
    int channel = 0;                    ///< of a colour picture: red, green or blue
};
/// A surface's stiffness (N/mm), static and dynamic friction.
struct HapticLayers {
    std::array<HapticLayer, 3> properties;
    std::vector<ClipNote> notes{};
    std::vector<Remark> remarks{};               ///< what was assumed of their values
    std::vector<std::filesystem::path> files{};  ///< files that were read, the surface's own first
};

/// Reads the first HapticTexturesSurface (H3DAPI) with maps in `text`, X3D in XML. Stiffness is in N/m, or
/// relative: then 1 is the upper end of the scene's haptic.stiffness. Missing fields have H3DAPI's defaults.
/// Textures may be DEF'd anywhere in the file; their first URL of an existing local file counts.
Result<HapticLayers> read_x3d_surface(const std::filesystem::path& file, std::string_view text,
                                      const Scene& scene);
/// Reads the haptic material of a glTF file's first mesh with one, or the first in the file. `bytes`: the
/// .gltf or .glb. The extension has no units: if the file states no range, black and white are the ends of
/// the scene's haptic range. A property without a texture has the scene's default_properties.
Result<HapticLayers> read_gltf_material(const std::filesystem::path& file, std::string_view bytes,
                                        const Scene& scene);

/// Reads a map that serves a whole clip (StillMaps). `scene` gets the ranges that the file states; in a scene
/// without heights, white becomes one level of depth high.
Result<StillPlane> read_haptic_map(const std::filesystem::path& file, Scene& scene);
Result<StillPlane> read_height_map(const std::filesystem::path& file, Scene& scene);

/// Source of one property of touch: a channel of a video, or of a picture that serves all frames.
struct TouchSource {
    std::filesystem::path video{};         ///< empty: `picture`
    std::optional<std::uint32_t> track{};  ///< its number in the file; nothing: the first video track
    LinkedFile picture{};
    int channel = 0;  ///< red, green or blue
};
/// A source for each property; nothing: the value is the same everywhere.
using TouchSources = std::array<std::optional<TouchSource>, 3>;
/// Replaces the clip's haptic plane by one made of these sources in every frame: each video's picture of the
/// frame's number, or, if the video has another number of frames, the picture nearest in time. The clip's
/// scene says what black and white are.
Result<std::unique_ptr<ClipReader>> with_touch_videos(Result<std::unique_ptr<ClipReader>> clip,
                                                      const TouchSources& sources);

/// Whether a file is named as X3D or glTF, and not as a picture.
bool is_surface_file(const std::filesystem::path& file);

}  // namespace touchable
