#include "engine/camera/frameset_format.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::array<std::uint8_t, 8> magic{'F', 'R', 'A', 'M', 'E', 'S', 'E', 'T'};
constexpr std::uint32_t frameset_version = 1;
// Where the header's own checksum is; it is of all before.
constexpr std::size_t checksum_at = frameset_header_bytes - 4;
constexpr std::size_t most_strays = std::size_t{256} << 20U;
// How often a byte may be checked, at most of so many at once.
constexpr std::size_t checks_per_byte = 4, most_credit = 8 * 5 * most_frameset_pixels;

std::uint64_t number_at(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {
    std::uint64_t number = 0;
    for (std::size_t k = size; k-- > 0;) number = number << 8U | bytes[at + k];
    return number;
}
std::uint32_t whole_at(std::span<const std::uint8_t> bytes, std::size_t at) {
    return static_cast<std::uint32_t>(number_at(bytes, at, 4));
}
double real_at(std::span<const std::uint8_t> bytes, std::size_t at) {
    return std::bit_cast<double>(number_at(bytes, at, 8));
}

std::uint32_t checksum(std::span<const std::uint8_t> bytes) {
    return static_cast<std::uint32_t>(::crc32_z(0, bytes.data(), bytes.size()));
}

std::string size_text(std::uint32_t width, std::uint32_t height) {
    return std::to_string(width) + "x" + std::to_string(height);
}
std::string lens_text(const FramesetHeader& header) {
    return formatted("fx %.6g, fy %.6g, cx %.6g, cy %.6g", header.fx, header.fy, header.cx, header.cy);
}

bool is_picture_size(std::uint32_t width, std::uint32_t height) {
    constexpr std::uint32_t largest_side = 16384;
    return width >= 1 && height >= 1 && width <= largest_side && height <= largest_side &&
           std::size_t{width} * height <= most_frameset_pixels;
}

/// Of a lens through which somebody sees. False for what is no number, too.
bool is_lens(const FramesetHeader& header) {
    const auto is_length = [](double focal, double side) {
        return focal >= 0.01 * side && focal <= 1000 * side;
    };
    const auto is_place = [](double at, double side) { return at >= -side && at <= 2 * side; };
    return is_length(header.fx, header.width) && is_length(header.fy, header.height) &&
           is_place(header.cx, header.width) && is_place(header.cy, header.height);
}

/// Of bytes that are as the sender meant them.
Result<FramesetHeader> read_header(std::span<const std::uint8_t> bytes) {
    const std::uint32_t version = whole_at(bytes, 8), length = whole_at(bytes, 12);
    if (version != frameset_version || length != frameset_header_bytes)
        return input_error("gives framesets of version " + std::to_string(version) + " with headers of " +
                           std::to_string(length) + " bytes; read are those of version 1 with 100");
    const std::uint32_t width = whole_at(bytes, 32), height = whole_at(bytes, 36);
    const std::uint32_t colour_width = whole_at(bytes, 80), colour_height = whole_at(bytes, 84);
    const std::uint32_t flags = whole_at(bytes, 88);
    if (!is_picture_size(width, height))
        return input_error("gives depth of " + size_text(width, height) +
                           " pixels; right are sides of 1 to 16384, and 16777216 pixels at most");
    const bool has_colour = colour_width != 0 || colour_height != 0;
    if (has_colour && !is_picture_size(colour_width, colour_height))
        return input_error("gives colour of " + size_text(colour_width, colour_height) +
                           " pixels; right are 0x0 for none, or sides of 1 to 16384, and 16777216 pixels "
                           "at most");
    if (flags > 1)
        return input_error("gives framesets with flags " + std::to_string(flags) + "; known are 0 and 1");
    FramesetHeader header;
    header.number = number_at(bytes, 16, 8);
    header.time_ns = static_cast<std::int64_t>(number_at(bytes, 24, 8));
    header.width = static_cast<int>(width);
    header.height = static_cast<int>(height);
    header.metres_per_unit = real_at(bytes, 40);
    header.fx = real_at(bytes, 48);
    header.fy = real_at(bytes, 56);
    header.cx = real_at(bytes, 64);
    header.cy = real_at(bytes, 72);
    header.colour_width = static_cast<int>(colour_width);
    header.colour_height = static_cast<int>(colour_height);
    header.colour_is_registered = flags == 1;
    if (!(header.metres_per_unit >= 1e-7 && header.metres_per_unit <= 1))
        return input_error(
            formatted("gives a unit of %.6g m; right is 0.0000001 to 1, such as 0.001 for millimetres",
                      header.metres_per_unit));
    if (!is_lens(header))
        return input_error("gives a lens with " + lens_text(header) + ", which no picture of " +
                           size_text(width, height) + " has; right are pixels");
    return header;
}

std::string meaning_text(const FramesetHeader& header) {
    return formatted("%dx%d of %.6g m with ", header.width, header.height, header.metres_per_unit) +
           lens_text(header) +
           (header.has_colour() ? " and colour of " + std::to_string(header.colour_width) + "x" +
                                      std::to_string(header.colour_height)
                                : std::string(" without colour"));
}

}  // namespace

std::size_t FramesetHeader::depth_bytes() const {
    return std::size_t{2} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

std::size_t FramesetHeader::payload_bytes() const {
    return depth_bytes() +
           std::size_t{3} * static_cast<std::size_t>(colour_width) * static_cast<std::size_t>(colour_height);
}

bool FramesetHeader::means_the_same_as(const FramesetHeader& other) const {
    return width == other.width && height == other.height && metres_per_unit == other.metres_per_unit &&
           fx == other.fx && fy == other.fy && cx == other.cx && cy == other.cy &&
           colour_width == other.colour_width && colour_height == other.colour_height &&
           colour_is_registered == other.colour_is_registered;
}

PlaneView Frameset::depth() const {
    return {
        payload->data(), 2 * static_cast<std::ptrdiff_t>(header.width), header.width, header.height, 2, 1};
}

PlaneView Frameset::colour() const {
    if (!header.has_colour()) return {};
    return {payload->data() + header.depth_bytes(),
            3 * static_cast<std::ptrdiff_t>(header.colour_width),
            header.colour_width,
            header.colour_height,
            1,
            3};
}

void FramesetParser::take(std::span<const std::uint8_t> bytes) {
    if (begin_ > 0 && begin_ >= bytes_.size() / 2) {
        bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin_));
        begin_ = 0;
    }
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    credit_ = std::min(credit_ + checks_per_byte * bytes.size(), most_credit);
}

void FramesetParser::pass_over(std::size_t count) {
    begin_ += count;
    strays_ += count;
    if (count > 0 && !is_lost_) ++damaged_;
    is_lost_ = is_lost_ || count > 0;
}

/// False: bytes that say again and again that a frameset begins here, and none does, would keep this busy.
/// What waits is passed over.
bool FramesetParser::may_check(std::size_t count) {
    if (count <= credit_) {
        credit_ -= count;
        return true;
    }
    pass_over(rest().size());
    return false;
}

/// Passes over what is none. False: more bytes are needed.
bool FramesetParser::find_header() {
    while (true) {
        const auto left = rest();
        const void* const found =
            left.empty() ? nullptr : ::memmem(left.data(), left.size(), magic.data(), magic.size());
        if (found == nullptr) {
            // Of a magic number that goes on in the next bytes.
            const std::size_t kept = std::min(left.size(), magic.size() - 1);
            pass_over(left.size() - kept);
            return false;
        }
        pass_over(static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - left.data()));
        const auto header = rest();
        if (header.size() < frameset_header_bytes) return false;
        if (checksum(header.first(checksum_at)) == whole_at(header, checksum_at)) return true;
        pass_over(magic.size());
    }
}

Result<std::optional<Frameset>> FramesetParser::next() {
    while (find_header()) {
        TRY_ASSIGN(const auto header, read_header(rest()));
        const std::size_t length = header.payload_bytes();
        if (rest().size() < frameset_header_bytes + length) break;
        if (!may_check(length)) continue;
        const auto payload = rest().subspan(frameset_header_bytes, length);
        if (checksum(payload) != whole_at(rest(), checksum_at - 4)) {
            pass_over(magic.size());
            continue;
        }
        if (first_ && !first_->means_the_same_as(header))
            return input_error("gives " + meaning_text(header) + " where it gave " + meaning_text(*first_) +
                               "; a new run takes it as it is now");
        begin_ += frameset_header_bytes + length;
        strays_ = 0;
        is_lost_ = false;
        if (first_ && header.number == last_number_) {
            ++repeated_;
            continue;
        }
        if (!first_) first_ = header;
        last_number_ = header.number;
        Frameset whole{header, std::make_shared<std::vector<std::uint8_t>>(payload.begin(), payload.end())};
        if constexpr (std::endian::native == std::endian::big)
            for (std::size_t k = 0; k < header.depth_bytes(); k += 2)
                std::swap((*whole.payload)[k], (*whole.payload)[k + 1]);
        return std::optional(std::move(whole));
    }
    if (strays_ > most_strays)
        return input_error("gave " + std::to_string(most_strays >> 20U) +
                           " MiB in which no whole frameset is (docs/camera.md has what one is)");
    return std::optional<Frameset>();
}

}  // namespace touchable
