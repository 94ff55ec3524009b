#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engine/clip/picture_label.hpp"
#include "engine/clip/plane_part.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/scene/plane_view.hpp"

namespace touchable {

/// What a picture of H.264 says of itself, so that it is known in any container: an unregistered SEI message
/// (ISO/IEC 14496-10, D.1.7) of our own UUID. Its text is
///   touchable=1 role=depth part=high bits=16 frame=12 taken_ns=1700000000000000000 xxh64=0123456789abcdef
/// part: whole, high or low; bits: of the plane's samples, of which the high part has the upper eight;
/// xxh64 (seed 0): of the text before " xxh64=" and of the part's samples as they decode, row by row, of
/// three channels red, green, blue. Colour, which no codec here keeps, has that of the text alone.
struct PictureMessage {
    PlaneRole role = PlaneRole::depth;
    PlanePart part = PlanePart::whole;
    int bits = 8;  ///< 8 to 16; 8 where the part is whole
    PictureLabel label;
    bool operator==(const PictureMessage&) const = default;
};

/// With the UUID. `samples`: of the part, one byte each.
std::string sei_of(const PictureMessage& message, const PlaneView& samples);
/// The description of the scene, which goes with keyframes of depth, whole or high; likewise:
///   touchable_scene=1 xxh64=0123456789abcdef {...}
/// the hash being of the JSON behind it.
std::string sei_of_scene(std::string_view json);

/// One of both, taken apart.
struct ReadSei {
    std::optional<PictureMessage> picture;  ///< whose hash is not judged yet
    std::string hashed;                     ///< of a picture: the text before its hash
    std::string hash;                       ///< 16 digits where it is right
    std::optional<std::string> scene;       ///< JSON, as it was sent
};
/// Nothing where it is neither, or is damaged: numbers out of range, words that are not known, a scene whose
/// hash is wrong.
std::optional<ReadSei> read_sei(std::span<const std::uint8_t> content);
/// Whether the message and its samples are what was sent.
bool is_sound(const ReadSei& sei, const PlaneView& samples);

}  // namespace touchable
