#pragma once

// Touch as other programs describe it: surfaces of X3D and haptic materials of glTF, whose properties are
// pictures or videos each, become one haptic plane of a clip.

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

/// A file that another one names by a URL, or holds.
struct LinkedFile {
    std::filesystem::path file;                ///< empty: its bytes are in the other one
    std::shared_ptr<const std::string> bytes;  ///< these
    std::string name;                          ///< for messages
    bool operator==(const LinkedFile&) const = default;
};
/// Whether a URL leads neither into the network nor to any other place that is no file.
bool is_local_link(std::string_view url);
/// What `url` means in the file `holder`: a path relative to its folder, also up and out of it; file:; or
/// data: in base64. Everything else is refused. A name with %XX is taken as it stands where such a file is
/// there, otherwise decoded.
Result<LinkedFile> follow_link(std::string_view url, const std::filesystem::path& holder);
/// Up to 257 MiB.
Result<std::shared_ptr<const std::string>> bytes_of(const LinkedFile& link);

/// Properties of touch, in the order of a haptic plane's red, green and blue.
inline constexpr std::array<std::string_view, 3> property_names{"stiffness", "static friction",
                                                                "dynamic friction"};
/// What the surface of another program says of one property.
struct HapticLayer {
    std::optional<LinkedFile> picture;  ///< nothing: the same everywhere
    PropertyRange range{};              ///< at black and white; both the same without a picture
    int channel = 0;                    ///< of a picture in colour: red, green or blue
};
/// Its stiffness (N/mm), static and dynamic friction.
struct HapticLayers {
    std::array<HapticLayer, 3> properties;
    std::vector<std::string> notes{};
    std::vector<Remark> remarks{};               ///< what was assumed of their values
    std::vector<std::filesystem::path> files{};  ///< that were read for it, its own first
};

/// The first HapticTexturesSurface (H3DAPI) with maps in an X3D file in XML, whose text this is. Stiffness in
/// N/m, or relative: then 1 is the upper end of the scene's haptic.stiffness. Fields that are left out have
/// H3DAPI's defaults. Textures are DEF'd anywhere in the file; the first of their URLs that leads to a file
/// here counts.
Result<HapticLayers> read_x3d_surface(const std::filesystem::path& file, std::string_view text,
                                      const Scene& scene);
/// The haptic material that a glTF file's first mesh with one names, or the first in the file; `bytes`: of
/// .gltf or .glb. The extension has no units: black and white are the ends of the scene's haptic ranges where
/// the file states no range. A property without a texture is as in the scene's default_properties.
Result<HapticLayers> read_gltf_material(const std::filesystem::path& file, std::string_view bytes,
                                        const Scene& scene);

/// A map of a whole clip (StillMaps). `scene` gets the ranges that the file states; a scene without heights
/// gets some, white being one level of depth high.
Result<StillPlane> read_haptic_map(const std::filesystem::path& file, Scene& scene);
Result<StillPlane> read_height_map(const std::filesystem::path& file, Scene& scene);

/// Where one property of touch is: a channel of a video, or of a picture that serves all frames.
struct TouchSource {
    std::filesystem::path video{};         ///< empty: `picture`
    std::optional<std::uint32_t> track{};  ///< its number in that file; nothing: the file's first of pictures
    LinkedFile picture{};
    int channel = 0;  ///< red, green or blue
};
/// Of each property; nothing: the same everywhere.
using TouchSources = std::array<std::optional<TouchSource>, 3>;
/// The clip with a haptic plane of these under every frame, in place of its own: of each video the picture of
/// the frame's number, or where it has not as many frames the one that is nearest in time. The clip's scene
/// says what black and white are.
Result<std::unique_ptr<ClipReader>> with_touch_videos(Result<std::unique_ptr<ClipReader>> clip,
                                                      const TouchSources& sources);

/// Whether a name is that of X3D or glTF rather than of a picture.
bool is_surface_file(const std::filesystem::path& file);

}  // namespace touchable
