// SPDX-License-Identifier: Apache-2.0
#pragma once

// Phones' photographs with depth: their orientation, EXIF and XMP, the clip that is made of one
// (depth_photo.cpp), and their files, JPEG (jpeg_depth.cpp) and HEIC (heic_image.cpp).

#include <map>

#include "engine/formats/formats_read.hpp"
#include "engine/picture/image.hpp"

struct heif_depth_representation_info;

namespace touchable {

/// How a stored picture becomes upright: it is transposed first, then flipped left-right and top-bottom.
struct Orientation {
    bool transposed = false, flipped_x = false, flipped_y = false;
    /// This orientation, followed by `next`.
    Orientation then(const Orientation& next) const;
    bool operator==(const Orientation&) const = default;
};

/// The orientation of EXIF's number, 1 to 8; other numbers count as 1.
Orientation exif_orientation(int number);

Image upright(const Image& stored, const Orientation& orientation);
/// The camera of pictures turned by `orientation`.
Intrinsics upright(const Intrinsics& stored, const Orientation& orientation);

/// What a picture's EXIF says of its camera.
struct ExifFacts {
    int orientation = 1;           ///< 1 to 8
    double film_focal_length = 0;  ///< mm, equivalent on 35 mm film; 0: not stated
};

/// Parses EXIF's TIFF structure, which begins with its byte order. Values that are missing, cut or invalid
/// keep their defaults: none is essential.
ExifFacts parse_exif(std::string_view tiff);

/// A property by its qualified name, "GDepth:Near", its value as written, or the beginning of an element (no
/// value).
struct XmpEntry {
    std::string name;
    std::optional<std::string> value;
};
/// In document order, for lists, whose items have properties of the same names.
using XmpEntries = std::vector<XmpEntry>;

/// Parses a packet's properties: attributes, and elements that hold only text (an empty one has no value).
/// Nothing if the packet is not well-formed.
std::optional<XmpEntries> parse_xmp_entries(std::string_view packet);

/// The last value of a property; null: there is none.
const std::string* xmp_value(const XmpEntries& xmp, std::string_view name);

/// A property as a number; nothing if it is none, or absent.
std::optional<double> xmp_number(const XmpEntries& xmp, std::string_view name);
/// Whether a number can be a picture's width or height, pixels.
inline bool is_xmp_side(const std::optional<double>& side) {
    return side && *side >= 1 && *side < 1e6;
}

/// A phone's photograph with depth: what its file holds and says.
struct DepthPhoto {
    StoredImage depth;                        ///< grey
    StoredImage colour;                       ///< of any size, but of the same view
    Orientation depth_turn{}, colour_turn{};  ///< make each upright
    DepthCoding coding;  ///< without derived members; without a scale, no `near` and `far`
    bool has_scale = true;
    double metres_per_unit = 1;
    std::optional<Intrinsics> camera{};  ///< for upright pictures of the size that it states
    double film_focal_length = 0;        ///< mm (ExifFacts)
    std::vector<Remark> remarks{};       ///< on what is guessed
};

/// Opens a clip of one frame, of depth's size. Camera: as stated, the file's, from its focal length, or 60
/// degrees wide; guesses are remarks. `file.scene` replaces the scene made from the photograph.
Opened open_depth_photo(const Candidate& file, DepthPhoto photo);

// --- JPEG

// JPEG files with a depth map, as phones write them: in their XMP ("GDepth"), or as a picture after their own
// that their XMP describes ("Dynamic Depth"), or its own (Apple's).

/// Whether a JPEG's XMP mentions a depth map, complete or not.
bool has_jpeg_depth(const SourceFile& file);

/// Opens a clip of one frame (open_depth_photo); the JPEG's own picture is its colour.
Opened open_jpeg_depth(const Candidate& file);

/// The contents of a JPEG's APP1 segments before its picture. Nothing if a segment is cut.
std::optional<std::vector<std::string_view>> app1_segments(std::string_view jpeg);

/// Length in bytes of a file's first picture, which others may follow. Nothing if its end is missing.
std::optional<std::size_t> jpeg_length(std::string_view file);

/// What a JPEG's EXIF says (parse_exif).
ExifFacts read_jpeg_exif(std::string_view jpeg);

/// Reads a JPEG file's XMP, in order: the extended packet that its packet names, joined from its pieces, and
/// the packet. Empty if the file has none. Prefixes are kept as written; namespaces are ignored. Messages
/// begin with `where`.
Result<XmpEntries> read_jpeg_xmp(std::string_view jpeg, const std::string& where);
/// The bytes of a Dynamic Depth JPEG's depth map, a picture after its own, found by the directory in its XMP,
/// which lists the pictures and their lengths. Messages begin with `where`.
Result<std::string_view> dynamic_depth_map(std::string_view jpeg, const XmpEntries& xmp,
                                           const std::string& where);

/// The camera in Dynamic Depth's XMP, for the picture as stored. Nothing if the XMP has none.
std::optional<Intrinsics> dynamic_depth_camera(const XmpEntries& xmp);

// --- HEIC

// HEIC, HEIF and AVIF photographs with an auxiliary picture of depth, as iPhones write portraits. libheif
// decodes them; what it hides or mishandles is read from the file's boxes here.

/// Whether a file is HEIC, HEIF or AVIF, by its first 12 bytes.
bool is_heif(const Candidate& file);

/// Opens a clip of one frame (open_depth_photo).
Opened open_heic_image(const Candidate& file);

/// How each picture of a HEIF file is turned and mirrored, by its number; pictures without such properties
/// are left out. libheif applies them without reporting them. A file that is cut is read up to the cut.
std::map<std::uint32_t, Orientation> read_heif_turns(std::string_view file);

struct CodedSize {
    std::uint32_t width = 0, height = 0;
};
/// Sizes in the H.265 parameters of all pictures and tiles: the decoder allocates memory for these, whatever
/// else the file says.
std::vector<CodedSize> read_heif_coded_sizes(std::string_view file);

/// How a file's pictures are made of others.
struct HeifParts {
    std::map<std::uint32_t, std::vector<std::uint32_t>> tiles;  ///< a picture's tiles, by number
    bool has_layers = false;  ///< a picture repeats another (iden) or overlays several (iovl)
};
HeifParts read_heif_parts(std::string_view file);

/// Finds what a HEIF file's depth stands for; sets `photo`'s coding, camera (of pictures as stored) and
/// remarks. `photo.depth` has to be set already. `info` is the codec's; it may be null. `xmp` is the depth
/// picture's, in which Apple writes range and camera, in JPEG too; it may be empty or hold anything.
void describe_heif_depth(const heif_depth_representation_info* info, const XmpEntries& xmp,
                         DepthPhoto& photo);

}  // namespace touchable
