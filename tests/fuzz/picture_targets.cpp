// Pictures of every kind, in memory.
#include <algorithm>
#include <array>
#include <cstdint>

#include "engine/picture/image.hpp"
#include "engine/picture/number_pictures.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

template <Result<StoredImage> (*decode)(std::string_view, const std::string&)>
bool parse_picture(std::string_view bytes) {
    return is_picture(decode(bytes, "picture"));
}

std::uint32_t big_endian_at(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
    return value;
}

/// PNG's, of zlib's polynomial.
std::uint32_t png_crc(std::string_view bytes) {
    std::uint32_t crc = ~std::uint32_t{0};
    for (const char byte : bytes) {
        crc ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1U ? 0xedb88320U : 0U);
    }
    return ~crc;
}

/// The same with checksums that are right, so that damage is not found by them alone.
std::string with_right_checksums(std::string png) {
    constexpr std::size_t first_chunk = 8, around = 12;  // length, type and checksum
    for (std::size_t at = first_chunk; at + around <= png.size();) {
        const std::size_t size = big_endian_at(png, at);
        if (size > png.size() - at - around) break;
        const std::uint32_t crc = png_crc(std::string_view(png).substr(at + 4, size + 4));
        for (std::size_t k = 0; k < 4; ++k) png[at + 8 + size + k] = static_cast<char>(crc >> (24 - 8 * k));
        at += size + around;
    }
    return png;
}

bool parse_png(std::string_view bytes) {
    (void)is_picture(decode_coded_image(with_right_checksums(std::string(bytes)), "picture"));
    return is_picture(decode_coded_image(bytes, "picture"));
}

const Registered netpbm_target{
    {.name = "netpbm", .parse = parse_picture<decode_netpbm>, .cuts_are_refused = true}};
const Registered pfm_target{{.name = "pfm", .parse = parse_picture<decode_pfm>, .cuts_are_refused = true}};
const Registered npy_target{{.name = "npy", .parse = parse_picture<decode_npy>, .cuts_are_refused = true}};
const Registered npz_target{{.name = "npz", .parse = parse_picture<decode_npz>, .cuts_are_refused = true}};
const Registered tiff_target{
    {.name = "tiff", .parse = parse_picture<decode_tiff>, .cuts_are_refused = true, .needless_bytes = 4}};
const Registered exr_target{{.name = "exr", .parse = parse_picture<decode_exr>, .cuts_are_refused = true}};
/// Tiles stand in any order, and what is cut off may be one that is not needed.
const Registered exr_tiled_target{{.name = "exr_tiled", .parse = parse_picture<decode_exr>}};
/// All of a rendering together, and each by itself.
bool parse_exr_layers(std::string_view bytes) {
    const auto whole = decode_exr(bytes, "picture", {true, true});
    if (whole && whole->beside)
        for (const auto* beside : {&whole->beside->colour, &whole->beside->materials})
            if (*beside) (void)is_picture(Result<StoredImage>(**beside));
    const bool has_colour = is_picture(decode_exr_colour(bytes, "picture"));
    const bool has_materials = is_picture(decode_exr_materials(bytes, "picture"));
    return is_picture(whole) && (has_colour || has_materials);
}
const Registered exr_layers_target{
    {.name = "exr_layers", .parse = parse_exr_layers, .cuts_are_refused = true}};
const Registered png_target{{.name = "png", .parse = parse_png, .cuts_are_refused = true}};
const Registered jpeg_target{
    {.name = "jpeg", .parse = parse_picture<decode_coded_image>, .cuts_are_refused = true}};

}  // namespace
}  // namespace touchable::fuzz
