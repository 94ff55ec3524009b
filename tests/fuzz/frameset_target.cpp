// Framesets that a program sends: any bytes, in pieces of any size.
#include <zlib.h>

#include <string>

#include "engine/camera/frameset_camera.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

unsigned long whole_of(const std::string& bytes, std::size_t at) {
    unsigned long number = 0;
    for (std::size_t k = 4; k-- > 0;) number = number << 8U | static_cast<unsigned char>(bytes[at + k]);
    return number;
}

void put_crc(std::string& bytes, std::size_t of, std::size_t length, std::size_t at) {
    const auto crc = ::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()) + of, length);
    for (std::size_t k = 0; k < 4; ++k) bytes[at + k] = static_cast<char>(crc >> (8 * k) & 0xffU);
}

/// No changed byte would be seen by more than the checksums.
std::string with_right_frameset_checksums(std::string bytes) {
    for (std::size_t at = bytes.rfind("FRAMESET"); at != std::string::npos;
         at = at == 0 ? at : bytes.rfind("FRAMESET", at - 1)) {
        if (bytes.size() - at >= frameset_header_bytes) {
            const std::size_t length = 2 * whole_of(bytes, at + 32) * whole_of(bytes, at + 36) +
                                       3 * whole_of(bytes, at + 80) * whole_of(bytes, at + 84);
            if (length <= bytes.size() - at - frameset_header_bytes)
                put_crc(bytes, at + frameset_header_bytes, length, at + 92);
            put_crc(bytes, at, 96, at + 96);
        }
        if (at == 0) break;
    }
    return bytes;
}

struct Found {
    std::vector<std::uint64_t> numbers;
    std::string refusal;
    std::int64_t damaged = 0;
    bool operator==(const Found&) const = default;
};

Found found_in(const std::string& bytes, std::size_t piece) {
    FramesetParser parser;
    Found found;
    for (std::size_t at = 0; at < bytes.size() && found.refusal.empty(); at += piece) {
        const std::string_view part = std::string_view(bytes).substr(at, piece);
        parser.take({reinterpret_cast<const std::uint8_t*>(part.data()), part.size()});
        while (true) {
            const auto frameset = parser.next();
            if (!is_taken(frameset)) found.refusal = frameset.error().message;
            if (!frameset || !*frameset) break;
            const FramesetHeader& header = (*frameset)->header;
            require((*frameset)->payload->size() == header.payload_bytes(), "not the bytes that it says");
            require(header.metres_per_unit > 0 && header.metres_per_unit <= 1, "a unit cannot be");
            require(header.fx > 0 && header.fy > 0, "a focal length cannot be");
            (void)(*frameset)->depth().sample(header.width - 1, header.height - 1);
            if (header.has_colour())
                (void)(*frameset)->colour().sample(header.colour_width - 1, header.colour_height - 1, 2);
            found.numbers.push_back(header.number);
        }
    }
    found.damaged = parser.damaged();
    return found;
}

/// How many bytes come at once, whether the checksums are made right, and the bytes.
bool parse_framesets(std::string_view input) {
    Taken taken(input);
    const std::size_t piece = taken.byte() + 1;
    const bool is_right = taken.byte() % 2 == 1;
    const std::string rest(taken.rest());
    const std::string bytes = is_right ? with_right_frameset_checksums(rest) : rest;
    const Found found = found_in(bytes, piece);
    // How long it looks through what is damaged depends on how much came with it.
    const Found at_once = found_in(bytes, bytes.size() + 1);
    require(at_once.damaged > 0 || found == at_once, "what is found depends on how the bytes come");
    return !found.numbers.empty();
}

const Registered framesets_target{
    {.name = "framesets", .parse = parse_framesets, .most_bytes = 2048, .most_live_mebibytes = 4}};

}  // namespace
}  // namespace touchable::fuzz
