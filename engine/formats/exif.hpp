#pragma once

#include <string_view>

namespace touchable {

/// What a picture's EXIF tells of its camera.
struct ExifFacts {
    int orientation = 1;           ///< 1 to 8
    double film_focal_length = 0;  ///< mm, of a lens with this view before 35 mm film; 0: not said
};

/// Of EXIF's TIFF structure, which begins with its order of bytes. What is absent, cut or odd is left at its
/// default: nothing that is needed hangs on it.
ExifFacts parse_exif(std::string_view tiff);

/// Of a JPEG file's.
ExifFacts read_jpeg_exif(std::string_view jpeg);

}  // namespace touchable
