#include "engine/picture/netpbm_image.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/picture/number_picture.hpp"

namespace touchable {
namespace {

bool is_blank(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/// The words of a file that begins as text; a comment lasts from # to the end of its line.
class NetpbmWords {
public:
    explicit NetpbmWords(std::string_view bytes) : rest_(bytes) {}
    std::string_view next() {
        while (!rest_.empty() && (is_blank(rest_.front()) || rest_.front() == '#')) {
            const bool comment = rest_.front() == '#';
            rest_.remove_prefix(comment ? std::min(rest_.find_first_of("\r\n"), rest_.size()) : 1);
        }
        std::size_t length = 0;
        while (length < rest_.size() && !is_blank(rest_[length]) && rest_[length] != '#') ++length;
        const std::string_view word = rest_.substr(0, length);
        rest_.remove_prefix(length);
        return word;
    }
    /// -1 where the next word is no whole number, or more than nine digits.
    int number() {
        const std::string_view word = next();
        int value = 0;
        const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
        const bool whole = failure == std::errc() && end == word.data() + word.size() && word.size() <= 9;
        return whole && value >= 0 ? value : -1;
    }
    /// What follows the one blank that ends a header.
    std::string_view data() const { return rest_.empty() ? rest_ : rest_.substr(1); }
    bool at_blank() const { return !rest_.empty() && is_blank(rest_.front()); }

private:
    std::string_view rest_;
};

struct NetpbmHeader {
    int width = 0, height = 0, largest = 0;
    int channels = 1;
    bool text = false;
    int bytes_per_sample() const { return largest > 255 ? 2 : 1; }
    std::size_t sample_count() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
               static_cast<std::size_t>(channels);
    }
};

Error cut_picture(const std::string& where) {
    return input_error(where + ": is cut short: its data end before the picture does");
}

Result<NetpbmHeader> netpbm_header(NetpbmWords& words, const std::string& where) {
    const std::string_view kind = words.next();
    NetpbmHeader header;
    header.text = kind == "P2" || kind == "P3";
    header.channels = kind == "P3" || kind == "P6" ? 3 : 1;
    header.width = words.number();
    header.height = words.number();
    TRY(check_picture_size(header.width, header.height, where));
    header.largest = words.number();
    if (header.largest < 1 || header.largest > 65535)
        return input_error(where + ": has no greatest value from 1 to 65535 after its size");
    if (!words.at_blank()) return cut_picture(where);
    return header;
}

/// Numbers written as words, in the bytes that a binary file would have: the high one first.
Result<std::string> bytes_of_words(NetpbmWords& words, const NetpbmHeader& header, const std::string& where) {
    // A digit and a blank each.
    if (words.data().size() / 2 + 1 < header.sample_count()) return cut_picture(where);
    std::string bytes;
    bytes.reserve(header.sample_count() * static_cast<std::size_t>(header.bytes_per_sample()));
    for (std::size_t k = 0; k < header.sample_count(); ++k) {
        const int number = words.number();
        if (number < 0 || number > header.largest)
            return input_error(where + ": is damaged: number " + std::to_string(k + 1) +
                               " of its samples is none from 0 to " + std::to_string(header.largest));
        if (header.bytes_per_sample() == 2) bytes += static_cast<char>(number >> 8);
        bytes += static_cast<char>(number & 255);
    }
    return bytes;
}

StoredImage grey_picture(std::string_view data, const NetpbmHeader& header, int channels) {
    const int bytes = header.bytes_per_sample(), step = channels * bytes;
    NumberPicture picture(header.width, header.height, {NumberFormat::Kind::unsigned_integer, bytes, true});
    picture.put(0, 0, {data.data(), header.width, header.height, step, std::ptrdiff_t{step} * header.width});
    return std::move(picture).finish(header.channels == 3 ? "ppm" : "pgm");
}

/// Colour of 16 bits is read where it is grey: red, green and blue the same.
bool is_grey16(std::string_view data) {
    for (std::size_t at = 0; at < data.size(); at += 6)
        if (data.compare(at, 2, data, at + 2, 2) != 0 || data.compare(at, 2, data, at + 4, 2) != 0)
            return false;
    return true;
}

Result<StoredImage> netpbm_picture(std::string_view data, const NetpbmHeader& header,
                                   const std::string& where) {
    StoredImage stored;
    if (header.channels == 1) {
        stored = grey_picture(data, header, 1);
    } else if (header.bytes_per_sample() == 2) {
        if (!is_grey16(data))
            return input_error(where +
                               ": is in colour of 16 bits; grey of 8 or 16 bits and colour of 8 bits "
                               "are read");
        stored = grey_picture(data, header, 3);
    } else {
        stored.image = {header.width, header.height, 1, 3, {data.begin(), data.end()}};
        stored.codec = "ppm";
        stored.pixel_format = "rgb24";
        return stored;
    }
    stored.bits = std::bit_width(static_cast<unsigned>(header.largest));
    return stored;
}

}  // namespace

Result<StoredImage> decode_netpbm(std::string_view bytes, const std::string& where) {
    NetpbmWords words(bytes);
    TRY_ASSIGN(const auto header, netpbm_header(words, where));
    const std::size_t needed = header.sample_count() * static_cast<std::size_t>(header.bytes_per_sample());
    if (header.text) {
        const auto samples = bytes_of_words(words, header, where);
        return samples ? netpbm_picture(*samples, header, where) : samples.error();
    }
    if (words.data().size() < needed) return cut_picture(where);
    return netpbm_picture(words.data().substr(0, needed), header, where);
}

Result<StoredImage> decode_pfm(std::string_view bytes, const std::string& where) {
    NetpbmWords words(bytes);
    words.next();
    const int width = words.number(), height = words.number();
    TRY(check_picture_size(width, height, where));
    const std::string_view word = words.next();
    float scale = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), scale);
    if (failure != std::errc() || end != word.data() + word.size() || scale == 0 || !std::isfinite(scale))
        return input_error(where +
                           ": has no scale after its size: must be a number, negative where the "
                           "low byte is first");
    const std::size_t row = static_cast<std::size_t>(width) * 4;
    if (!words.at_blank() || words.data().size() / row < static_cast<std::size_t>(height))
        return cut_picture(where);
    NumberPicture picture(width, height, {NumberFormat::Kind::floating, 4, scale > 0});
    const char* last_row = words.data().data() + row * static_cast<std::size_t>(height - 1);
    picture.put(0, 0, {last_row, width, height, 4, -static_cast<std::ptrdiff_t>(row)});
    return std::move(picture).finish("pfm");
}

}  // namespace touchable
