#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/given_file.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/image_file.hpp"

namespace touchable {

/// Pixels of a picture's width or height, at most.
inline constexpr int largest_picture_side = 16384;

struct BesideDepth;

/// An image with how it was stored.
struct StoredImage {
    Image image;               ///< of a picture of floats its size, and no samples
    std::string codec;         ///< "png", "mjpeg", "pgm", "ppm", "pfm", "npy", "tiff", "exr"
    std::string pixel_format;  ///< as FFmpeg names it: "gray16be", "grayf32le"
    /// Of a sample as stored: of grey PNG also 1, 2 and 4, of PGM those its greatest value needs; 16 where
    /// larger integers all fit.
    int bits = 8;
    bool interlaced = false;  ///< then a picture that lacks data is not found out
    /// Of a picture of floats: width * height, row by row; also NaN and infinity.
    std::vector<float> values{};
    /// What a rendering has beside its depth, where that was wanted and is there; null otherwise.
    std::shared_ptr<BesideDepth> beside{};
};

/// Other pictures of an OpenEXR rendering, of the same pixels as its depth.
struct BesideDepth {
    struct Wanted {
        bool colour = false, materials = false;
    };
    std::optional<StoredImage> colour{};     ///< sRGB of 8 bits
    std::optional<StoredImage> materials{};  ///< indices: integers, or floats that are whole
    // What the file calls them, for messages.
    std::string depth_name{}, colour_name{}, materials_name{};
    int depths = 1;  ///< of how many this is the first (that has colour)
};

/// All of a picture's file, up to 257 MiB: 8192x8192 floats fit.
Result<std::string> read_picture_bytes(const SourceFile& file);

/// What a picture's first bytes say that it is: "PNG", "PGM" ...; empty for what no reader here knows.
std::string_view picture_kind(std::string_view begin);

/// A picture of any kind that its first bytes tell.
Result<StoredImage> read_stored_image(const SourceFile& file);
/// The same of a file's bytes; messages begin with `where`.
Result<StoredImage> decode_stored_image(std::string bytes, const std::string& where);

/// Makes a picture of the bytes of its file; messages begin with `where`.
using DecodePicture = std::function<Result<StoredImage>(std::string_view bytes, const std::string& where)>;
/// What `decode` makes of these bytes. It may take as long as it does: a stop is obeyed meanwhile.
Result<StoredImage> decode_unless_stopped(std::string bytes, const std::string& where, DecodePicture decode);

/// Refuses pictures of more than 64 MiB in files of less than a 4096th of that, before memory is taken for
/// them.
Result<void> check_expansion(std::uint64_t unpacked, std::uint64_t packed, const std::string& where);
/// Refuses sides of 0 and beyond `largest_picture_side`.
Result<void> check_picture_size(std::int64_t width, std::int64_t height, const std::string& where);

}  // namespace touchable
