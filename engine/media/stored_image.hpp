#pragma once

#include <filesystem>
#include <string>

#include "engine/media/image_file.hpp"
#include "engine/result.hpp"

namespace touchable {

/// An image with how it was stored.
struct StoredImage {
    Image image;
    std::string codec;  ///< "png" or "mjpeg"
    std::string pixel_format;
};

/// What `read_image` reads, and how the file had it.
Result<StoredImage> read_stored_image(const std::filesystem::path& file);

}  // namespace touchable
