#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/formats/linked_file.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {

/// A video as a texture (MPEG_texture_video), which is tracks of a file.
struct GltfVideo {
    std::string file;                   ///< as its uri says
    std::vector<std::uint32_t> tracks;  ///< their numbers in that file; empty: it does not say which
    std::string format;                 ///< such as "RGB", "DEPTH_COMPONENT"
    int width = 0, height = 0;          ///< pixels
};

/// What a glTF file of version 2 says, .gltf or .glb, and the bytes that it carries. `bytes` has to stay. All
/// of it throws checked_json::Refusal, or an Error of a file that it names.
class GltfFile {
public:
    using Node = checked_json::Node;

    GltfFile(const std::filesystem::path& file, std::string_view bytes);
    GltfFile(const GltfFile&) = delete;
    GltfFile& operator=(const GltfFile&) = delete;

    const std::filesystem::path& file() const { return file_; }
    Node root() const { return {json_, ""}; }
    /// Of one of the arrays at the root, such as textures[2].
    Node element(const char* array, const Node& index) const;
    Node texture(std::size_t number) const;
    /// What a texture shows where its file is read as a picture. `texture`: of the array "textures".
    LinkedFile picture(const Node& texture);
    /// What it shows moving; nothing where it has no MPEG_texture_video. Of the alternatives of a medium the
    /// first that is a file here.
    std::optional<GltfVideo> video(const Node& texture) const;
    /// The others that were read for pictures.
    const std::vector<std::filesystem::path>& read_files() const { return read_files_; }

private:
    LinkedFile linked(const Node& uri) const;
    LinkedFile carried_picture(const Node& view);

    std::filesystem::path file_;
    checked_json::Json json_;
    std::optional<std::string_view> carried_;
    std::vector<std::filesystem::path> read_files_;
};

/// An extension of a node, if it has that.
std::optional<checked_json::Node> gltf_extension(const checked_json::Node& node, const char* name);
/// The most elements that an array may have.
inline constexpr std::size_t most_gltf_elements = 1'000'000;
std::vector<checked_json::Node> gltf_array(const checked_json::Node& array);

}  // namespace touchable
