#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/files.hpp"
#include "engine/clip/clip.hpp"
#include "engine/formats/depth_photo.hpp"
#include "engine/formats/source_description.hpp"

struct heif_depth_representation_info;

namespace touchable {

// HEIC, HEIF and AVIF photographs with an auxiliary picture of depth, as iPhones write portraits. libheif
// decodes them; what it hides or would trip over is read of the file's boxes here.

/// Whether a file is one of these, by its first 12 bytes.
bool is_heif(std::string_view begin);

/// A clip of one frame as of open_depth_photo.
Result<std::unique_ptr<ClipReader>> open_heic_image(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    const SourceDescription& known);

/// How each picture of a HEIF file is turned and mirrored, by its number; those without such properties are
/// left out. libheif applies them and does not tell. Of a file that is cut, what is there.
std::map<std::uint32_t, Orientation> read_heif_turns(std::string_view file);

struct CodedSize {
    std::uint32_t width = 0, height = 0;
};
/// Sizes that the decoder of H.265 is set up for, of all pictures and tiles: it takes memory for these,
/// whatever else the file says.
std::vector<CodedSize> read_heif_coded_sizes(std::string_view file);

/// How pictures of a file are put together of others.
struct HeifParts {
    std::map<std::uint32_t, std::vector<std::uint32_t>> tiles;  ///< of a picture, by their numbers
    bool has_layers = false;  ///< one is another one once more (iden), or several over each other (iovl)
};
HeifParts read_heif_parts(std::string_view file);

/// What a HEIF file's depth stands for, into `photo`'s coding, camera (of pictures as stored) and notes.
/// `depth` of the photo is there. `info` of the codec's: may be null. `xmp` of the depth picture, where Apple
/// writes range and camera: may be empty, or of anything.
void describe_heif_depth(const heif_depth_representation_info* info, const std::string& xmp,
                         DepthPhoto& photo);

}  // namespace touchable
