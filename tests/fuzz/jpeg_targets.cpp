// What stands in a JPEG beside its picture: segments, EXIF, XMP, a depth map.
#include <cmath>

#include "engine/formats/depth_photo.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "tests/fuzz/fuzz_target.hpp"
#include "tests/import/jpeg_with_xmp.hpp"

namespace touchable::fuzz {
namespace {

bool parse_segments(std::string_view bytes) {
    const auto segments = app1_segments(bytes);
    std::size_t held = 0;
    for (const std::string_view segment : segments.value_or(std::vector<std::string_view>())) {
        require(
            segment.data() >= bytes.data() && segment.data() + segment.size() <= bytes.data() + bytes.size(),
            "a segment lies outside its file");
        held += segment.size();
    }
    require(held <= bytes.size(), "segments hold more than their file");
    const auto length = jpeg_length(bytes);
    require(!length || *length <= bytes.size(), "a picture is longer than its file");
    (void)is_taken(read_jpeg_xmp(bytes, "photo.jpg"));
    const auto entries = read_jpeg_xmp_entries(bytes, "photo.jpg");
    if (is_taken(entries)) (void)is_taken(dynamic_depth_map(bytes, *entries, "photo.jpg"));
    return segments && length;
}

void require_camera(const ExifFacts& facts) {
    require(facts.orientation >= 1 && facts.orientation <= 8, "an orientation that there is none");
    require(std::isfinite(facts.film_focal_length) && facts.film_focal_length >= 0, "no focal length");
}

bool parse_exif_facts(std::string_view bytes) {
    const ExifFacts facts = parse_exif(bytes);
    require_camera(facts);
    require_camera(read_jpeg_exif(bytes));
    return facts.orientation > 1 || facts.film_focal_length > 0;
}

bool parse_xmp_packet(std::string_view bytes) {
    const auto entries = parse_xmp_entries(bytes);
    if (entries) (void)dynamic_depth_camera(properties_of(*entries));
    (void)decode_base64(bytes);
    require(decode_base64(test::encode_base64(bytes)) == bytes, "bytes in base64 come back others");
    return entries.has_value();
}

bool parse_jpeg_depth(std::string_view bytes) {
    const auto file = file_of(bytes, "photo.jpg");
    return has_jpeg_depth(file) && is_clip(open_jpeg_depth({file}));
}

const Registered segments_target{{.name = "jpeg_segments", .parse = parse_segments}};
const Registered exif_target{{.name = "exif", .parse = parse_exif_facts, .most_bytes = 512}};
const Registered xmp_target{{.name = "xmp", .parse = parse_xmp_packet}};
const Registered jpeg_depth_target{
    {.name = "jpeg_depth", .parse = parse_jpeg_depth, .cuts_are_refused = true, .changes = 120}};

}  // namespace
}  // namespace touchable::fuzz
