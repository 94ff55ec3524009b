// HEIC: its boxes as we read them ourselves, what its depth stands for, and the whole.
#include <libheif/heif.h>

#include <cmath>

#include "engine/formats/depth_photo.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool parse_heif_boxes(std::string_view bytes) {
    const auto turns = read_heif_turns(bytes);
    const auto sizes = read_heif_coded_sizes(bytes);
    const auto parts = read_heif_parts(bytes);
    require(
        turns.size() <= bytes.size() && sizes.size() <= bytes.size() && parts.tiles.size() <= bytes.size(),
        "more pictures than bytes");
    return !turns.empty() || !sizes.empty() || !parts.tiles.empty();
}

/// Planes as the codec has them, then XMP.
bool parse_heif_depth(std::string_view bytes) {
    Taken taken(bytes);
    heif_depth_representation_info info{};
    const unsigned said = taken.byte();
    info.has_z_near = said & 1U;
    info.has_z_far = said >> 1 & 1U;
    info.has_d_min = said >> 2 & 1U;
    info.has_d_max = said >> 3 & 1U;
    info.depth_representation_type = static_cast<heif_depth_representation_type>(said >> 4 & 3U);
    for (double* number : {&info.z_near, &info.z_far, &info.d_min, &info.d_max}) *number = taken.number();
    DepthPhoto photo;
    photo.depth.image = {2, 2, 1, 1, {1, 2, 3, 4}};
    describe_heif_depth(said & 0x80U ? nullptr : &info, std::string(taken.rest()), photo);
    require(!photo.has_scale || (std::isfinite(photo.coding.near) && photo.coding.near > 0 &&
                                 photo.coding.far > photo.coding.near),
            "depth has impossible planes");
    return photo.has_scale;
}

bool parse_heic(std::string_view bytes) {
    const Candidate file{file_of(bytes, "photo.heic")};
    return is_heif(file) && is_clip(open_heic_image(file));
}

const Registered heif_boxes_target{{.name = "heif_boxes", .parse = parse_heif_boxes}};
const Registered heif_depth_target{{.name = "heif_depth", .parse = parse_heif_depth}};
const Registered heic_target{{.name = "heic", .parse = parse_heic, .cuts_are_refused = true, .changes = 60}};

}  // namespace
}  // namespace touchable::fuzz
