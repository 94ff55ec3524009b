#include "engine/formats/exif.hpp"

#include <cstddef>
#include <cstdint>

#include "engine/formats/jpeg_segments.hpp"

namespace touchable {
namespace {

using namespace std::string_view_literals;

constexpr std::uint32_t orientation_tag = 0x0112, exif_directory_tag = 0x8769, film_focal_length_tag = 0xa405;
constexpr std::uint32_t of_16_bits = 3, of_32_bits = 4;  // types of a value
constexpr std::size_t entry_bytes = 12;

class Tiff {
public:
    explicit Tiff(std::string_view bytes) : bytes_(bytes), big_endian_(bytes.starts_with("MM\0*"sv)) {}
    bool is_tiff() const { return big_endian_ || bytes_.starts_with("II*\0"sv); }
    std::uint32_t first_directory() const { return number(4, 4); }

    /// The single number of an entry of a directory; 0 where there is none.
    std::uint32_t find(std::size_t directory, std::uint32_t tag) const {
        const std::size_t count = number(directory, 2);
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t entry = directory + 2 + entry_bytes * k;
            if (entry + entry_bytes > bytes_.size()) return 0;
            if (number(entry, 2) != tag) continue;
            const std::uint32_t type = number(entry + 2, 2);
            return type == of_16_bits ? number(entry + 8, 2) : type == of_32_bits ? number(entry + 8, 4) : 0;
        }
        return 0;
    }

private:
    std::uint32_t number(std::size_t at, std::size_t length) const {
        if (at > bytes_.size() || length > bytes_.size() - at) return 0;
        std::uint32_t value = 0;
        for (std::size_t k = 0; k < length; ++k)
            value = value << 8 | static_cast<unsigned char>(bytes_[at + (big_endian_ ? k : length - 1 - k)]);
        return value;
    }

    std::string_view bytes_;
    bool big_endian_;
};

}  // namespace

ExifFacts parse_exif(std::string_view bytes) {
    ExifFacts facts;
    const Tiff tiff(bytes);
    if (!tiff.is_tiff()) return facts;
    const std::uint32_t first = tiff.first_directory();
    const std::uint32_t orientation = tiff.find(first, orientation_tag);
    if (orientation >= 1 && orientation <= 8) facts.orientation = static_cast<int>(orientation);
    if (const std::uint32_t exif = tiff.find(first, exif_directory_tag); exif > 0)
        facts.film_focal_length = tiff.find(exif, film_focal_length_tag);
    return facts;
}

ExifFacts read_jpeg_exif(std::string_view jpeg) {
    constexpr auto header = "Exif\0\0"sv;
    if (const auto segments = app1_segments(jpeg))
        for (const std::string_view segment : *segments)
            if (segment.starts_with(header)) return parse_exif(segment.substr(header.size()));
    return {};
}

}  // namespace touchable
