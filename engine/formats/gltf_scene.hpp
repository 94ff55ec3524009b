#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/clip/plane_role.hpp"
#include "engine/formats/fallback_mesh.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// A track of the clip's MP4 file.
struct GltfTrack {
    std::uint32_t number = 0;
    std::string codecs;  ///< RFC 6381: "avc1.640028"
};

/// How a plane is stored: as tracks, the high bits of its samples first, or as a picture.
struct GltfPlane {
    std::vector<std::size_t> tracks;  ///< of GltfClipFiles::tracks; empty: a picture
    std::string picture;              ///< a file's name
};

/// The files that a glTF scene is of, all in its folder.
struct GltfClipFiles {
    std::string video;              ///< MP4; empty: pictures
    std::vector<GltfTrack> tracks;  ///< that it has
    std::string poster;             ///< what is drawn of it where videos are not known
    std::string mesh;               ///< bytes_of_mesh
    std::array<std::optional<GltfPlane>, all_roles.size()> planes;
};

/// A touchable clip as glTF 2.0 (docs/mpeg4.md): extensions of MPEG, all of which a program may leave unread,
/// and in "extras" of the mesh, under "touchable", the scene file. Indented JSON.
std::string gltf_scene(const SceneDescription& described, const GltfClipFiles& files,
                       const FallbackMesh& mesh);

/// Indices, positions and texture coordinates as its buffer has them, little-endian.
std::string bytes_of_mesh(const FallbackMesh& mesh);

}  // namespace touchable
