#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/media/image_file.hpp"
#include "engine/result.hpp"

namespace touchable {

/// An image with how it was stored.
struct StoredImage {
    Image image;
    std::string codec;  ///< "png" or "mjpeg"
    std::string pixel_format;
    int bits = 8;             ///< of a sample as stored: of grey also 2 and 4
    bool interlaced = false;  ///< then a picture that lacks data is not found out
    /// Of a picture of floats: row-major; then the image has a size and no samples.
    std::vector<float> values{};
};

/// All of a picture's file, up to 256 MiB.
Result<std::string> read_picture_bytes(const std::filesystem::path& file);

/// What `read_image` reads, and how the file had it.
Result<StoredImage> read_stored_image(const std::filesystem::path& file);
/// The same of a file's bytes; messages begin with `where`.
Result<StoredImage> decode_stored_image(std::string_view bytes, const std::string& where);

}  // namespace touchable
