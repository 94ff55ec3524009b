#include "engine/picture/stored_image.hpp"

#include <utility>

#include "engine/base/try.hpp"
#include "engine/base/unless_stopped.hpp"
#include "engine/picture/coded_image.hpp"
#include "engine/picture/exr_image.hpp"
#include "engine/picture/netpbm_image.hpp"
#include "engine/picture/npy_stack.hpp"
#include "engine/picture/npz_file.hpp"
#include "engine/picture/tiff_image.hpp"

namespace touchable {
namespace {

Error picture_error(const std::filesystem::path& file, const std::string& what) {
    return input_error(file.string() + ": " + what);
}

/// The values of 8192x8192 pixels as floats, and what stands around them.
constexpr std::size_t largest_file = std::size_t{257} << 20;

/// P and a letter or digit, and what ends a word.
bool is_netpbm(std::string_view begin, std::string_view kinds) {
    return begin.size() > 2 && begin[0] == 'P' && kinds.find(begin[1]) != std::string_view::npos &&
           std::string_view(" \t\r\n#").find(begin[2]) != std::string_view::npos;
}

Result<StoredImage> refuse_netpbm(std::string_view bytes, const std::string& where) {
    return input_error(where + ": is of Netpbm's kind " + std::string(bytes.substr(0, 2)) +
                       "; P2 and P5 (PGM), P3 and P6 (PPM) and Pf (PFM of one channel) are read");
}

struct PictureKind {
    std::string_view name;
    bool (*is)(std::string_view begin);
    Result<StoredImage> (*decode)(std::string_view bytes, const std::string& where);
};
constexpr PictureKind picture_kinds[] = {
    {"PNG", [](std::string_view begin) { return begin.starts_with("\x89PNG\r\n\x1a\n"); },
     decode_coded_image},
    {"JPEG", [](std::string_view begin) { return begin.starts_with("\xff\xd8\xff"); }, decode_coded_image},
    {"PGM", [](std::string_view begin) { return is_netpbm(begin, "25"); }, decode_netpbm},
    {"PPM", [](std::string_view begin) { return is_netpbm(begin, "36"); }, decode_netpbm},
    {"PFM", [](std::string_view begin) { return is_netpbm(begin, "f"); }, decode_pfm},
    {"TIFF", is_tiff, decode_tiff},
    {"OpenEXR", is_exr, decode_exr},
    {"npy", is_npy, decode_npy},
    {"npz", is_npz, decode_npz},
    {"Netpbm", [](std::string_view begin) { return is_netpbm(begin, "147F"); }, refuse_netpbm},
};

const PictureKind* kind_of(std::string_view begin) {
    for (const PictureKind& kind : picture_kinds)
        if (kind.is(begin)) return &kind;
    return nullptr;
}

/// "PNG, JPEG, PGM": the names of all that is read.
std::string kinds_text() {
    std::string text;
    for (const PictureKind& kind : picture_kinds)
        if (kind.decode != refuse_netpbm) text += (text.empty() ? "" : ", ") + std::string(kind.name);
    return text;
}

}  // namespace

std::string_view picture_kind(std::string_view begin) {
    const PictureKind* kind = kind_of(begin);
    return kind ? kind->name : std::string_view();
}

Result<void> check_picture_size(std::int64_t width, std::int64_t height, const std::string& where) {
    const auto usable = [](std::int64_t side) { return side >= 1 && side <= largest_picture_side; };
    if (usable(width) && usable(height)) return {};
    return input_error(where + ": is " + std::to_string(width) + "x" + std::to_string(height) +
                       " pixels: must be from 1x1 to " + std::to_string(largest_picture_side) + "x" +
                       std::to_string(largest_picture_side));
}

Result<void> check_expansion(std::uint64_t unpacked, std::uint64_t packed, const std::string& where) {
    if (unpacked <= (std::uint64_t{64} << 20) || unpacked / 4096 <= packed) return {};
    return input_error(where + ": is damaged: has " + std::to_string(packed) + " bytes for a picture of " +
                       std::to_string(unpacked));
}

Result<std::string> read_picture_bytes(const SourceFile& file) {
    auto bytes = file.read("a picture", largest_file);
    if (bytes && bytes->empty()) return picture_error(file.path(), "is empty");
    return bytes;
}

Result<StoredImage> read_stored_image(const SourceFile& file) {
    TRY_ASSIGN(auto bytes, read_picture_bytes(file));
    return decode_stored_image(std::move(bytes), file.string());
}

Result<StoredImage> decode_stored_image(std::string bytes, const std::string& where) {
    if (bytes.size() > largest_file)
        return input_error(where + ": is larger than " + in_bytes(largest_file) +
                           ": not a picture this program reads");
    const PictureKind* kind = kind_of(bytes);
    if (!kind) return input_error(where + ": is no picture that is read: " + kinds_text());
    if (kind->decode == decode_coded_image) return decode_coded_image(bytes, where);  // looks for itself
    return decode_unless_stopped(std::move(bytes), where, kind->decode);
}

Result<StoredImage> decode_unless_stopped(std::string bytes, const std::string& where, DecodePicture decode) {
    constexpr std::size_t quick = 4096;  // bytes: what they unpack to is decoded in a few milliseconds
    const Error interrupted{ErrorKind::interrupted, "interrupted while " + where + " was read"};
    if (stop_requested()) return interrupted;
    if (bytes.size() <= quick) return decode(bytes, where);
    auto decoded = unless_stopped(
        [bytes = std::move(bytes), where, decode = std::move(decode)] { return decode(bytes, where); });
    return decoded ? std::move(*decoded) : interrupted;
}

Result<Image> read_image(const std::filesystem::path& file) {
    TRY_ASSIGN(auto stored, read_stored_image(file));
    if (!stored.values.empty())
        return picture_error(file, "is a picture of floats: must be of integers here");
    return std::move(stored.image);
}

}  // namespace touchable
