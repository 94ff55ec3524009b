#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/clip/clip.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

// What photographs with depth have in common, in whatever file a phone wrote them: how they are turned, what
// EXIF and XMP say, and the clip that is made of one.

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
std::optional<XmpProperties> parse_xmp(std::string_view packet);

/// The last of each name.
XmpProperties properties_of(const XmpEntries& entries);

/// A property that is a number; nothing where it is none, or absent.
std::optional<double> xmp_number(const XmpProperties& xmp, std::string_view name);

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
/// wide. What is guessed is noted. `described` replaces the scene made from the photograph.
Result<std::unique_ptr<ClipReader>> open_depth_photo(const std::filesystem::path& file, DepthPhoto photo,
                                                     const std::optional<SceneDescription>& described,
                                                     const SourceDescription& known);

}  // namespace touchable
