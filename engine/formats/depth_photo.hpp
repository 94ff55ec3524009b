#pragma once

// Photographs with depth, in whatever file a phone wrote them: how they are turned, what EXIF and XMP say,
// the clip that is made of one (depth_photo.cpp), and their files, JPEG (jpeg_depth.cpp) and HEIC
// (heic_image.cpp).

#include <map>

#include "engine/formats/formats_read.hpp"
#include "engine/picture/image.hpp"

struct heif_depth_representation_info;

namespace touchable {

/// How a stored picture becomes upright: its columns become rows first, then left and right, and top and
/// bottom, change places.
struct Orientation {
    bool transposed = false, flipped_x = false, flipped_y = false;
    /// This one first, then `next`.
    Orientation then(const Orientation& next) const;
    bool operator==(const Orientation&) const = default;
};

/// By EXIF's number, 1 to 8; others are as 1.
Orientation exif_orientation(int number);

Image upright(const Image& stored, const Orientation& orientation);
/// The camera of the pictures that were turned so.
Intrinsics upright(const Intrinsics& stored, const Orientation& orientation);

/// What a picture's EXIF tells of its camera.
struct ExifFacts {
    int orientation = 1;           ///< 1 to 8
    double film_focal_length = 0;  ///< mm, of a lens with this view before 35 mm film; 0: not said
};

/// Of EXIF's TIFF structure, which begins with its order of bytes. What is absent, cut or odd is left at its
/// default: nothing that is needed hangs on it.
ExifFacts parse_exif(std::string_view tiff);

/// Properties by qualified name, "GDepth:Near"; values as written.
using XmpProperties = std::map<std::string, std::string, std::less<>>;

/// A property, or the beginning of an element, which has no value.
struct XmpEntry {
    std::string name;
    std::optional<std::string> value;
};
/// In the order in which they stand: for lists, whose items have properties of the same names.
using XmpEntries = std::vector<XmpEntry>;

/// Properties of one packet: attributes, and elements that hold nothing but text (an empty one has no
/// value). Nothing where it is not well-formed.
std::optional<XmpEntries> parse_xmp_entries(std::string_view packet);

/// The last of each name.
XmpProperties properties_of(const XmpEntries& entries);

/// A property that is a number; nothing where it is none, or absent.
std::optional<double> xmp_number(const XmpProperties& xmp, std::string_view name);
/// Whether such a number can be a side of a picture, pixels.
inline bool is_xmp_side(const std::optional<double>& side) {
    return side && *side >= 1 && *side < 1e6;
}

/// A phone's photograph with depth: what its file holds and says.
struct DepthPhoto {
    StoredImage depth;                        ///< grey
    StoredImage colour;                       ///< of any size, but of the same view
    Orientation depth_turn{}, colour_turn{};  ///< what makes each upright
    DepthCoding coding;  ///< but for what is derived; without a scale, no `near` and `far`
    bool has_scale = true;
    double metres_per_unit = 1;
    std::optional<Intrinsics> camera{};  ///< of upright pictures of the size that it names
    double film_focal_length = 0;        ///< mm (ExifFacts)
    std::vector<Remark> remarks{};       ///< of what is guessed there
};

/// A clip of one frame, of depth's size. Camera: as known, by the file's, by its focal length, or 60 degrees
/// wide. What is guessed is noted. The file's scene replaces the one made from the photograph.
Opened open_depth_photo(const Candidate& file, DepthPhoto photo);

// --- JPEG

// JPEG files with a depth map, as phones write them: in their XMP ("GDepth"), or as a picture after their own
// that their XMP describes ("Dynamic Depth").

/// Whether a JPEG's XMP speaks of a depth map, be it whole or not.
bool has_jpeg_depth(const SourceFile& file);

/// A clip of one frame as of open_depth_photo; the JPEG's own picture is its colour.
Opened open_jpeg_depth(const Candidate& file);

/// The contents of a JPEG's segments APP1, up to its picture. Nothing where a segment is cut.
std::optional<std::vector<std::string_view>> app1_segments(std::string_view jpeg);

/// Bytes of the first picture in a file, which others may follow. Nothing where its end is missing.
std::optional<std::size_t> jpeg_length(std::string_view file);

/// What a JPEG's EXIF says (parse_exif).
ExifFacts read_jpeg_exif(std::string_view jpeg);

/// The XMP of a JPEG file: its packet, and the extended packet that it names, put together from its pieces.
/// Empty where the file has none. Prefixes are taken as they stand, without their namespaces. Messages begin
/// with `where`.
Result<XmpProperties> read_jpeg_xmp(std::string_view jpeg, const std::string& where);
/// The same in order, the extended packet first.
Result<XmpEntries> read_jpeg_xmp_entries(std::string_view jpeg, const std::string& where);

/// The bytes of a Dynamic Depth JPEG's depth map, a picture after its own: found by the directory of its XMP,
/// which lists the pictures and their lengths. Messages begin with `where`.
Result<std::string_view> dynamic_depth_map(std::string_view jpeg, const XmpEntries& xmp,
                                           const std::string& where);

/// Its camera, of the picture as stored. Nothing where the XMP has none.
std::optional<Intrinsics> dynamic_depth_camera(const XmpProperties& xmp);

// --- HEIC

// HEIC, HEIF and AVIF photographs with an auxiliary picture of depth, as iPhones write portraits. libheif
// decodes them; what it hides or would trip over is read of the file's boxes here.

/// Whether a file is one of these, by its first 12 bytes.
bool is_heif(const Candidate& file);

/// A clip of one frame as of open_depth_photo.
Opened open_heic_image(const Candidate& file);

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
