// SPDX-License-Identifier: Apache-2.0
#include "engine/picture/number_pictures.hpp"

#include <tiffio.h>
#include <bit>
#include <concepts>
#include <cstdarg>
#include <cstdio>
#include <limits>
#include <map>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {

namespace {

/// IEEE 754 binary16.
struct Half {
    std::uint16_t bits;
    explicit operator float() const {
        const std::uint32_t sign = (bits & 0x8000U) << 16U, exponent = bits >> 10U & 31U,
                            fraction = bits & 1023U;
        if (exponent == 0) {
            const float size = std::ldexp(static_cast<float>(fraction), -24);
            return sign != 0 ? -size : size;
        }
        const std::uint32_t wide = exponent == 31 ? 255 : exponent + 112;
        return std::bit_cast<float>(sign | wide << 23U | fraction << 13U);
    }
};

template <class Number>
Number number_at(const char* from, bool swapped) {
    std::array<char, sizeof(Number)> bytes;
    std::copy_n(from, sizeof(Number), bytes.begin());
    if (swapped) std::ranges::reverse(bytes);
    return std::bit_cast<Number>(bytes);
}

template <class Number>
float as_float(Number number) {
    return static_cast<float>(number);
}
/// A number beyond the range of float becomes infinite: too far to be touched.
float as_float(double number) {
    if (std::abs(number) > std::numeric_limits<float>::max())
        return std::copysign(std::numeric_limits<float>::infinity(), static_cast<float>(number > 0 ? 1 : -1));
    return static_cast<float>(number);
}

/// Named like FFmpeg's similar formats.
std::string number_format_name(const NumberFormat& format) {
    const bool floating = format.kind == NumberFormat::Kind::floating;
    if (!floating && format.bytes == 1) return "gray";
    return std::string("gray") + (floating ? "f" : "") + std::to_string(8 * format.bytes) +
           (format.big_endian ? "be" : "le");
}

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
    /// -1 if the next word is no whole number of up to nine digits.
    int number() {
        const std::string_view word = next();
        const auto value = word.size() <= 9 ? parsed_as<int>(word) : std::nullopt;
        return std::max(value.value_or(-1), -1);
    }
    /// The data after the one blank that ends a header.
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
        return pixel_count(width, height) * static_cast<std::size_t>(channels);
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

/// Converts numbers written as words to a binary file's bytes: the high one first.
Result<std::string> bytes_of_words(NetpbmWords& words, const NetpbmHeader& header, const std::string& where) {
    // Each takes a digit and a blank.
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

/// Whether red, green and blue are the same: only then colour of 16 bits is read.
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
            return input_error(
                where + ": is in colour of 16 bits; grey of 8 or 16 bits and colour of 8 bits are read");
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

constexpr tmsize_t largest_tile = tmsize_t{64} << 20;
constexpr tmsize_t largest_piece = tmsize_t{256} << 20;  // of one allocation by libtiff

/// A file as libtiff reads it, and the first error in it.
struct TiffBytes {
    ByteSource& bytes;
    std::string_view in_memory{};  // the same bytes, if they are in memory
    toff_t at = 0;
    std::string wrong{};
};

TiffBytes& of_handle(thandle_t handle) {
    return *static_cast<TiffBytes*>(handle);
}
tmsize_t read_tiff(thandle_t handle, void* to, tmsize_t size) {
    TiffBytes& file = of_handle(handle);
    const std::uint64_t all = file.bytes.size(), rest = file.at < all ? all - file.at : 0;
    const auto count =
        static_cast<std::size_t>(std::min(rest, static_cast<std::uint64_t>(std::max<tmsize_t>(size, 0))));
    if (count > 0 && !file.bytes.read(file.at, static_cast<char*>(to), count)) return -1;
    file.at += count;
    return static_cast<tmsize_t>(count);
}
toff_t seek_tiff(thandle_t handle, toff_t offset, int from) {
    TiffBytes& file = of_handle(handle);
    return file.at = offset + (from == SEEK_CUR ? file.at : from == SEEK_END ? file.bytes.size() : 0);
}
int map_tiff(thandle_t handle, void** begin, toff_t* size) {
    const std::string_view bytes = of_handle(handle).in_memory;
    if (bytes.empty()) return 0;
    *begin = const_cast<char*>(bytes.data());  // libtiff only reads it
    *size = bytes.size();
    return 1;
}

[[gnu::format(printf, 4, 0)]] int keep_first_error(TIFF*, void* file, const char*, const char* format,
                                                   std::va_list arguments) {
    char text[256];
    std::vsnprintf(text, sizeof text, format, arguments);
    std::string& wrong = static_cast<TiffBytes*>(file)->wrong;
    if (wrong.empty()) wrong = printable(text, 200);
    return 1;
}

using TiffPtr = std::unique_ptr<TIFF, ReleasedBy<TIFFClose>>;

TiffPtr open_tiff(TiffBytes& file) {
    const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                               TIFFOpenOptionsFree);
    if (!options) return nullptr;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), largest_piece);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_first_error, &file);
    // Warnings are of unknown tags and the like.
    const auto ignore = [](TIFF*, void*, const char*, const char*, std::va_list) { return 1; };
    const auto write = [](thandle_t, void*, tmsize_t) { return tmsize_t{-1}; };
    const auto close = [](thandle_t) { return 0; };
    const auto size = [](thandle_t handle) -> toff_t { return of_handle(handle).bytes.size(); };
    const auto unmap = [](thandle_t, void*, toff_t) {};
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignore, nullptr);
    return TiffPtr(TIFFClientOpenExt("", "r", &file, read_tiff, write, seek_tiff, close, size, map_tiff,
                                     unmap, options.get()));
}

struct TiffLayout {
    std::uint32_t width = 0, height = 0;
    std::uint16_t bits = 1, samples = 1, format = SAMPLEFORMAT_UINT, photometric = PHOTOMETRIC_MINISBLACK,
                  planes = PLANARCONFIG_CONTIG, compression = COMPRESSION_NONE,
                  orientation = ORIENTATION_TOPLEFT;

    bool is_rgb() const { return photometric == PHOTOMETRIC_RGB; }
    int bytes() const { return bits / 8; }
    int pixel_bytes() const { return planes == PLANARCONFIG_CONTIG ? bytes() * samples : bytes(); }
    NumberFormat numbers() const {
        using Kind = NumberFormat::Kind;
        return {format == SAMPLEFORMAT_IEEEFP ? Kind::floating
                : format == SAMPLEFORMAT_INT  ? Kind::signed_integer
                                              : Kind::unsigned_integer,
                bytes(), std::endian::native == std::endian::big};
    }
};

TiffLayout layout_of(TIFF* tiff) {
    TiffLayout layout;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &layout.width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &layout.height);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &layout.photometric);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &layout.bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &layout.samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &layout.format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &layout.planes);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &layout.compression);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &layout.orientation);
    return layout;
}

/// Why a TIFF of this kind is not read; empty if it is.
std::string refusal_of(const TiffLayout& layout) {
    const auto is = [](const char* what, int number, const char* right) {
        return std::string(what) + " " + std::to_string(number) + ": must be " + right;
    };
    if (layout.photometric != PHOTOMETRIC_MINISBLACK && !layout.is_rgb())
        return is("has photometric interpretation", layout.photometric, "1 (grey, black is 0) or 2 (RGB)");
    const bool floats = layout.format == SAMPLEFORMAT_IEEEFP;
    if (!(layout.bits == 16 || layout.bits == 32 || layout.bits == 64 || (layout.bits == 8 && !floats)))
        return is("has bits a sample", layout.bits, "8, 16, 32 or 64");
    if (layout.format > SAMPLEFORMAT_VOID) return is("has sample format", layout.format, "1 to 4");
    if (layout.samples > 4) return is("has samples a pixel", layout.samples, "1 to 4");
    if (layout.is_rgb() && (layout.bits > 16 || floats || layout.samples < 3))
        return "is in colour that is not of 8 bits: must be grey, or RGB of 8 bits";
    if (layout.is_rgb() && layout.planes != PLANARCONFIG_CONTIG)
        return "has a plane for each colour: must have all of a pixel together";
    if (layout.compression == COMPRESSION_JPEG || layout.compression == COMPRESSION_OJPEG)
        return "is compressed as JPEG: must be without loss";
    if (layout.orientation != ORIENTATION_TOPLEFT)
        return is("is to be turned, orientation", layout.orientation, "1, the upper left first");
    return "";
}

/// Collects pixels: numbers of grey, or RGB of 8 bits.
class TiffPixels {
public:
    TiffPixels(const TiffLayout& layout, const std::string& where) : layout_(layout), where_(where) {
        const int width = static_cast<int>(layout.width), height = static_cast<int>(layout.height);
        if (!layout.is_rgb() || layout.bits > 8) {
            grey_.emplace(width, height, layout.numbers());
            return;
        }
        rgb_ = blank_image(width, height, 1, 3);
    }
    /// `across`: pixels of a row in memory. Refuses colour of 16 bits.
    Result<void> put(int x, int y, const char* pixels, int width, int height, int across) {
        const int step = layout_.pixel_bytes();
        const NumberBlock block{pixels, width, height, step, std::ptrdiff_t{step} * across};
        if (layout_.is_rgb() && grey_ && !is_grey(block))
            return input_error(where_ + ": is in colour of 16 bits: must be grey, or RGB of 8 bits");
        if (grey_)
            grey_->put(x, y, block);
        else
            put_rgb(x, y, block);
        return {};
    }
    StoredImage finish(bool floats_anyway) && {
        if (grey_) return std::move(*grey_).finish("tiff", floats_anyway);
        return {std::move(rgb_), "tiff", "rgb24"};
    }

private:
    void put_rgb(int x, int y, const NumberBlock& block) {
        for (int row = 0; row < block.height; ++row) {
            const char* from = block.first + block.row_step * row;
            std::uint8_t* to = rgb_.samples.data() + 3 * pixel_place(x, y + row, rgb_.width);
            for (int column = 0; column < block.width; ++column, to += 3, from += block.column_step)
                std::memcpy(to, from, 3);
        }
    }
    /// Whether red, green and blue of 16 bits are the same.
    static bool is_grey(const NumberBlock& block) {
        for (int row = 0; row < block.height; ++row) {
            const char* at = block.first + block.row_step * row;
            for (int column = 0; column < block.width; ++column, at += block.column_step)
                if (std::memcmp(at, at + 2, 4) != 0) return false;
        }
        return true;
    }

    TiffLayout layout_;
    std::string where_;
    std::optional<NumberPicture> grey_;
    Image rgb_;
};

Error tiff_damage(const TiffBytes& file, const std::string& where) {
    if (stop_requested()) return interrupted_error();  // which makes reads fail
    return input_error(where + ": is damaged" + (file.wrong.empty() ? "" : ": " + file.wrong));
}

Result<void> read_tiles(TIFF* tiff, const TiffBytes& file, const TiffLayout& layout, TiffPixels& pixels,
                        const std::string& where) {
    std::uint32_t across = 0, down = 0;
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &across);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &down);
    const tmsize_t size = TIFFTileSize(tiff);
    const auto needed = std::uint64_t{across} * down * static_cast<std::uint64_t>(layout.pixel_bytes());
    if (size < 1 || size > largest_tile || static_cast<std::uint64_t>(size) != needed)
        return tiff_damage(file, where);
    std::vector<char> tile(static_cast<std::size_t>(size));
    for (std::uint32_t y = 0; y < layout.height; y += down)
        for (std::uint32_t x = 0; x < layout.width; x += across) {
            if (stop_requested()) return interrupted_error();
            if (TIFFReadEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, 0), tile.data(), size) != size)
                return tiff_damage(file, where);
            TRY(pixels.put(static_cast<int>(x), static_cast<int>(y), tile.data(),
                           static_cast<int>(std::min(across, layout.width - x)),
                           static_cast<int>(std::min(down, layout.height - y)), static_cast<int>(across)));
        }
    return {};
}

Result<void> read_rows(TIFF* tiff, const TiffBytes& file, const TiffLayout& layout, TiffPixels& pixels,
                       const std::string& where) {
    const tmsize_t size = TIFFScanlineSize(tiff);
    if (size != static_cast<tmsize_t>(layout.width) * layout.pixel_bytes()) return tiff_damage(file, where);
    std::vector<char> row(static_cast<std::size_t>(size));
    const int width = static_cast<int>(layout.width);
    for (std::uint32_t y = 0; y < layout.height; ++y) {
        if (stop_requested()) return interrupted_error();
        if (TIFFReadScanline(tiff, row.data(), y, 0) != 1) return tiff_damage(file, where);
        TRY(pixels.put(0, static_cast<int>(y), row.data(), width, 1, width));
    }
    return {};
}

/// Refuses a page that is not read, before memory is taken for it.
Result<TiffLayout> checked_layout(TIFF* tiff, std::uint64_t packed, const std::string& where) {
    const TiffLayout layout = layout_of(tiff);
    TRY(check_picture_size(layout.width, layout.height, where));
    if (const std::string refusal = refusal_of(layout); !refusal.empty())
        return input_error(where + ": " + refusal);
    // A page of one strip and its picture, mostly floats, are in memory at once.
    const auto needed = static_cast<std::uint64_t>(layout.pixel_bytes()) +
                        (layout.bytes() > 2 || layout.format != SAMPLEFORMAT_UINT ? 4 : layout.bytes());
    TRY(check_expansion(std::uint64_t{layout.width} * layout.height * needed, packed, where));
    return layout;
}

/// Reads the current page of libtiff.
Result<StoredImage> tiff_page(TIFF* tiff, const TiffBytes& file, const std::string& where,
                              bool floats_anyway = false) {
    TRY_ASSIGN(const auto layout, checked_layout(tiff, file.bytes.size(), where));
    TiffPixels pixels(layout, where);
    TRY(TIFFIsTiled(tiff) ? read_tiles(tiff, file, layout, pixels, where)
                          : read_rows(tiff, file, layout, pixels, where));
    return std::move(pixels).finish(floats_anyway);
}

/// The tags that decide how a page's pixels are stored, as the file has them. Pages with the same tags are
/// frames of one clip; no page is unpacked to find that out.
struct TiffPage {
    using Entry = std::pair<std::uint64_t, std::uint64_t>;  // count, and the value if there is only one
    std::uint64_t at = 0;                                   // of its directory
    std::map<std::uint16_t, Entry> tags{};
    bool is_another_view = false;  // a smaller copy, or a mask of another page

    bool is_in_colour() const {
        const auto found = tags.find(TIFFTAG_PHOTOMETRIC);
        return found != tags.end() &&
               (found->second.second == PHOTOMETRIC_RGB || found->second.second == PHOTOMETRIC_YCBCR);
    }
};

/// The page that all frames are like: the first, or if that is in colour the first in grey of more than 8
/// bits, if there is one.
std::size_t first_frame_of(const std::vector<TiffPage>& pages) {
    if (!pages.front().is_in_colour()) return 0;
    const auto depth = std::ranges::find_if(pages, [](const TiffPage& page) {
        const auto bits = page.tags.find(TIFFTAG_BITSPERSAMPLE);
        return !page.is_another_view && !page.is_in_colour() && bits != page.tags.end() &&
               bits->second.first == 1 && bits->second.second > 8;
    });
    return depth == pages.end() ? 0 : static_cast<std::size_t>(depth - pages.begin());
}

/// Walks a TIFF's directories, classic or BigTIFF, without reading what they point to.
class TiffDirectories {
public:
    TiffDirectories(ByteSource& bytes, const std::string& where) : bytes_(bytes), where_(where) {}

    Result<std::vector<TiffPage>> pages() {
        const std::string begin = first_bytes(bytes_, 16);
        is_big_endian_ = begin.starts_with("MM");
        is_wide_ = begin.size() > 3 && (begin[2] == '+' || begin[3] == '+');
        if (begin.size() < (is_wide_ ? 16U : 8U)) return damage();
        std::uint64_t at = number(begin, is_wide_ ? 8 : 4, is_wide_ ? 8 : 4);
        std::vector<TiffPage> found;
        // Directories do not overlap, so all together are no larger than the file, unless their list is
        // circular.
        for (std::uint64_t taken = 0; at != 0;) {
            if (stop_requested()) return interrupted_error();
            TRY_ASSIGN(auto page, page_at(at, taken));
            if (taken > bytes_.size()) return damage();
            if (found.size() == most_pages)
                return input_error(where_ + ": has more than " + std::to_string(most_pages) + " pages");
            found.push_back(std::move(page));
            at = next_;
        }
        if (found.empty()) return damage();
        return found;
    }

private:
    /// Reads a directory; adds its bytes to `taken`.
    Result<TiffPage> page_at(std::uint64_t at, std::uint64_t& taken) {
        const std::size_t wide = is_wide_ ? 8 : 4, count_bytes = is_wide_ ? 8 : 2,
                          entry_bytes = is_wide_ ? 20 : 12;
        TRY_ASSIGN(const auto counted, bytes_at(at, count_bytes));
        const std::uint64_t count = number(counted, 0, count_bytes);
        if (count == 0 || count > most_entries) return damage();
        const std::size_t entries = static_cast<std::size_t>(count) * entry_bytes;
        taken += count_bytes + entries + wide;
        TRY_ASSIGN(const auto directory, bytes_at(at + count_bytes, entries + wide));
        TiffPage page{at};
        for (std::size_t entry = 0; entry < entries; entry += entry_bytes) {
            const auto tag = static_cast<std::uint16_t>(number(directory, entry, 2));
            const std::uint64_t type = number(directory, entry + 2, 2),
                                values = number(directory, entry + 4, wide);
            const std::size_t own = type == TIFF_BYTE    ? 1
                                    : type == TIFF_SHORT ? 2
                                    : type == TIFF_LONG8 ? 8
                                                         : 4,
                              size = std::min(own, wide);
            const std::uint64_t value = values == 1 ? number(directory, entry + 4 + wide, size) : 0;
            if (std::ranges::count(telling_tags, tag) > 0) page.tags[tag] = {values, value};
            if (tag == TIFFTAG_SUBFILETYPE)
                page.is_another_view = (value & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
        }
        next_ = number(directory, entries, wide);
        return page;
    }
    Result<std::string> bytes_at(std::uint64_t at, std::size_t count) {
        if (at > bytes_.size() || bytes_.size() - at < count) return damage();
        std::string read(count, '\0');
        TRY(error_at(where_, bytes_.read(at, read.data(), count)));
        return read;
    }
    std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t size) const {
        return number_in_bytes(bytes.substr(at, size), is_big_endian_);
    }
    Error damage() const { return input_error(where_ + ": is damaged: its list of pages is cut"); }

    static constexpr std::uint64_t most_entries = 4096;
    static constexpr std::size_t most_pages = 100'000;
    static constexpr std::uint16_t telling_tags[] = {TIFFTAG_IMAGEWIDTH,      TIFFTAG_IMAGELENGTH,
                                                     TIFFTAG_BITSPERSAMPLE,   TIFFTAG_PHOTOMETRIC,
                                                     TIFFTAG_SAMPLESPERPIXEL, TIFFTAG_SAMPLEFORMAT};
    ByteSource& bytes_;
    const std::string& where_;
    bool is_big_endian_ = false, is_wide_ = false;
    std::uint64_t next_ = 0;
};

/// The pages of a TIFF, each unpacked on demand.
class TiffStack final : public ImageStack {
public:
    TiffStack(std::unique_ptr<ByteSource> bytes, std::string where, std::vector<TiffPage> pages,
              std::string left_out)
        : ImageStack(std::move(where), std::move(left_out), "page"),
          bytes_(std::move(bytes)),
          pages_(std::move(pages)) {}

    Result<void> open() {
        tiff_ = open_tiff(file_);
        if (!tiff_ || TIFFSetSubDirectory(tiff_.get(), pages_.front().at) != 1)
            return tiff_damage(file_, where_);
        TRY_ASSIGN(layout_, checked_layout(tiff_.get(), bytes_->size(), where_));
        return layout_.numbers().is_decided() ? Result<void>{} : find_floats();
    }

    std::int64_t count() const override { return std::ssize(pages_); }
    int width() const override { return static_cast<int>(layout_.width); }
    int height() const override { return static_cast<int>(layout_.height); }

private:
    Result<StoredImage> read(std::int64_t number, bool floats_anyway) override {
        const std::string where = where_ + ": page " + std::to_string(number);
        file_.wrong.clear();
        if (TIFFSetSubDirectory(tiff_.get(), pages_[static_cast<std::size_t>(number)].at) != 1)
            return tiff_damage(file_, where);
        const TiffLayout layout = layout_of(tiff_.get());
        if (layout.width != layout_.width || layout.height != layout_.height)  // by a duplicate tag
            return tiff_damage(file_, where);
        return tiff_page(tiff_.get(), file_, where, floats_anyway);
    }

    std::unique_ptr<ByteSource> bytes_;
    std::vector<TiffPage> pages_;
    TiffBytes file_{*bytes_};
    TiffLayout layout_;
    TiffPtr tiff_;  // reads by file_
};

/// A name with a star for its last run of digits, and that number, without leading zeros.
std::pair<std::string, std::string> numbered_name(const std::string& name) {
    constexpr const char* digits = "0123456789";
    const auto last = name.find_last_of(digits);
    if (last == std::string::npos) return {name, ""};
    const auto before = name.find_last_not_of(digits, last);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    std::string number = name.substr(begin, last + 1 - begin);
    number.erase(0, std::min(number.find_first_not_of('0'), number.size()));
    return {name.substr(0, begin) + "*" + name.substr(last + 1), number};
}

/// The last part of a name, in small letters.
std::string short_name(const NamedArray& array) {
    return small_letters(array.name.substr(array.name.rfind('/') + 1));
}

bool has_any(const std::string& name, std::initializer_list<std::string_view> words) {
    return std::ranges::any_of(words,
                               [&](std::string_view word) { return name.find(word) != std::string::npos; });
}

/// Whether a name means something else than depth. Names with depth in them may also have words for colour
/// and cameras: depth_image, camera_depth.
bool names_no_depth(const NamedArray& array) {
    const std::string name = short_name(array);
    const bool has_normal = name.find("normal") != std::string::npos && !has_any(name, {"normali"});
    if (has_normal) return true;
    return !has_depth_in_name(array) &&
           has_any(name, {"intrinsic", "extrinsic", "pose", "rgb", "color", "colour", "image", "camera",
                          "c2w", "w2c", "point", "xyz", "label", "segm", "semantic", "instance", "_ids"});
}

/// Arrays of one picture each, of one size and type, whose names differ only by a number, in the order of the
/// numbers. Empty unless all are in one such row, or one row of several has depth in its name.
std::vector<std::size_t> row_among(std::span<const NamedArray> arrays,
                                   const std::vector<std::size_t>& places) {
    std::map<std::string, std::vector<std::size_t>> rows;
    for (const std::size_t place : places) rows[numbered_name(arrays[place].name).first].push_back(place);
    if (rows.size() > 1)
        std::erase_if(rows, [](const auto& row) { return !has_any(small_letters(row.first), {"depth"}); });
    if (rows.size() != 1 || rows.begin()->second.size() < 2) return {};
    std::vector<std::size_t>& row = rows.begin()->second;
    const NamedArray& first = arrays[row.front()];
    const bool are_alike = std::ranges::all_of(row, [&](std::size_t place) {
        const NamedArray& own = arrays[place];
        return own.shape == first.shape && own.format->kind == first.format->kind &&
               own.format->bytes == first.format->bytes && pictures_of_array(own.shape, "")->count == 1;
    });
    if (!are_alike) return {};
    std::ranges::stable_sort(row, {}, [&](std::size_t place) {
        const std::string number = numbered_name(arrays[place].name).second;
        return std::pair(number.size(), number);
    });
    return std::move(row);
}

}  // namespace

bool has_depth_in_name(const NamedArray& array) {
    return has_any(short_name(array), {"depth"});
}

bool is_trust_of_depth(const NamedArray& array) {
    const std::string name = short_name(array);
    return array.is_boolean || has_any(name, {"conf", "mask"}) ||
           (has_any(name, {"valid"}) && !has_depth_in_name(array));
}

bool may_be_depth(const NamedArray& array) {
    constexpr int least_side = 16;
    const auto pictures = pictures_of_array(array.shape, "");
    if (!array.format || !pictures || is_trust_of_depth(array) || names_no_depth(array)) return false;
    // Colour with its channels first.
    if (array.shape.size() == 3 && array.shape[0] == 3 && array.format->bytes == 1) return false;
    return has_depth_in_name(array) || std::min(pictures->width, pictures->height) >= least_side;
}

Result<std::vector<std::size_t>> depth_among(std::span<const NamedArray> arrays, const std::string& what) {
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < arrays.size(); ++k)
        if (may_be_depth(arrays[k])) places.push_back(k);
    constexpr bool (*rules[])(const NamedArray&) = {
        [](const NamedArray& array) { return short_name(array) == "depth"; },
        [](const NamedArray& array) { return short_name(array).starts_with("depth"); }, has_depth_in_name,
        [](const NamedArray&) { return true; }};
    for (const auto& rule : rules) {
        const auto fits = [&](std::size_t place) { return rule(arrays[place]); };
        if (std::ranges::count_if(places, fits) == 1) return std::vector{*std::ranges::find_if(places, fits)};
    }
    if (auto row = row_among(arrays, places); !row.empty() || places.empty()) return row;
    // If any is named depth, only those.
    std::vector<NamedArray> several;
    for (const std::size_t place : places) several.push_back(arrays[place]);
    if (std::ranges::any_of(several, has_depth_in_name))
        std::erase_if(several, std::not_fn(has_depth_in_name));
    return input_error("has several " + what + "s that may be depth: " + some_of(several),
                       {{Setting::dataset, several.front().name}});
}

bool is_colour(const NamedArray& array) {
    return array.shape.size() > 2 && array.shape.back() == 3 && array.format && array.format->bytes == 1;
}

std::string some_of(std::span<const NamedArray> arrays) {
    constexpr std::size_t most_named = 8;
    const std::string more =
        arrays.size() > most_named ? " and " + std::to_string(arrays.size() - most_named) + " more" : "";
    return listed(arrays.first(std::min(arrays.size(), most_named)), &NamedArray::in_words) + more;
}

std::string shape_text(const std::vector<std::int64_t>& shape) {
    const auto text = [](std::int64_t extent) { return std::to_string(extent); };
    return shape.empty() ? "a single number" : listed(shape, text, "x");
}

double stored_number(const char* bytes, const NumberFormat& format) {
    const std::uint64_t bits =
        number_in_bytes({bytes, static_cast<std::size_t>(format.bytes)}, format.big_endian);
    if (format.kind == NumberFormat::Kind::floating)
        return format.bytes == 8   ? std::bit_cast<double>(bits)
               : format.bytes == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(bits))
                                   : std::numeric_limits<double>::quiet_NaN();
    if (format.kind == NumberFormat::Kind::unsigned_integer) return static_cast<double>(bits);
    const int unused = 64 - 8 * format.bytes;
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

Result<ArrayPictures> pictures_of_array(const std::vector<std::int64_t>& extents, const std::string& where) {
    std::vector<std::int64_t> shape = extents;
    if (shape.size() > 2 && shape.back() == 1) shape.pop_back();
    // Networks count batches and colours too: 1 x 1 x height x width, count x 1 x height x width.
    for (auto one = shape.begin(); shape.size() > 3 && one != shape.end() - 2;)
        one = *one == 1 ? shape.erase(one) : one + 1;
    if (shape.size() == 2) shape.insert(shape.begin(), 1);
    if (shape.size() != 3 || shape[0] < 1)
        return input_error(where + ": is an array of " + shape_text(extents) +
                           ": must be height x width, or count x height x width" +
                           (extents.size() == 1 ? ", array.reshape(HEIGHT, WIDTH)" : ""));
    if (shape[2] <= 4 && shape[1] > 4 && shape[0] > 4)
        return input_error(where + ": is an array of " + shape_text(extents) + ", with " +
                           std::to_string(shape[2]) + " numbers a pixel: must have one" +
                           (shape[2] == 3   ? ", of points " + std::string(depth_of_points)
                            : shape[2] == 4 ? ", of RGB-D numpy.save('depth.npy', array[..., 3]) keeps depth"
                                            : ""));
    // Pictures are not so tall, and none would be seen as wrong: they would be slices across all frames.
    constexpr std::int64_t tallest = 3;
    if (extents.size() == 3 && tallest * shape[2] <= std::min(shape[0], shape[1]))
        return input_error(where + ": is an array of " + shape_text(extents) +
                           ", whose last axis seems to count its pictures: must be count x height x width, "
                           "numpy.moveaxis(array, -1, 0)");
    TRY(check_picture_size(shape[2], shape[1], where));
    return ArrayPictures{shape[0], static_cast<int>(shape[2]), static_cast<int>(shape[1])};
}

NumberPicture::NumberPicture(int width, int height, const NumberFormat& format)
    : format_(format), codes_(format.kind != NumberFormat::Kind::floating) {
    const auto count = pixel_count(width, height);
    picture_.image = {width, height, 2, 1, {}};
    const auto fill = [&](auto& memory, std::size_t each) {
        memory.reserve(count * each);
        is_whole_ = until_stopped(count, [&](std::size_t, std::size_t last) { memory.resize(last * each); });
    };
    if (format_.is_codes()) {
        picture_.image.bytes_per_sample = format.bytes;
        fill(picture_.image.samples, static_cast<std::size_t>(format.bytes));
    } else {
        fill(picture_.values, 1);
    }
}

template <class Number>
void NumberPicture::put_as(int x, int y, const NumberBlock& block) {
    constexpr bool is_code = std::same_as<Number, std::uint8_t> || std::same_as<Number, std::uint16_t>;
    const bool swapped = format_.big_endian != (std::endian::native == std::endian::big);
    for (int row = 0; row < block.height; ++row) {
        const char* from = block.first + block.row_step * row;
        std::size_t at = pixel_place(x, y + row, picture_.image.width);
        for (int column = 0; column < block.width; ++column, ++at, from += block.column_step) {
            const auto number = number_at<Number>(from, swapped);
            if constexpr (is_code) {
                std::memcpy(picture_.image.samples.data() + at * sizeof(Number), &number, sizeof(Number));
            } else {
                picture_.values[at] = as_float(number);
                if constexpr (std::integral<Number>) codes_ = codes_ && std::in_range<std::uint16_t>(number);
            }
        }
    }
}

void NumberPicture::put(int x, int y, const NumberBlock& block) {
    if (!is_whole_) return;
    using Kind = NumberFormat::Kind;
    const auto is = [this](Kind kind, int bytes) { return format_.kind == kind && format_.bytes == bytes; };
    if (is(Kind::unsigned_integer, 1)) return put_as<std::uint8_t>(x, y, block);
    if (is(Kind::unsigned_integer, 2)) return put_as<std::uint16_t>(x, y, block);
    if (is(Kind::unsigned_integer, 4)) return put_as<std::uint32_t>(x, y, block);
    if (is(Kind::unsigned_integer, 8)) return put_as<std::uint64_t>(x, y, block);
    if (is(Kind::signed_integer, 1)) return put_as<std::int8_t>(x, y, block);
    if (is(Kind::signed_integer, 2)) return put_as<std::int16_t>(x, y, block);
    if (is(Kind::signed_integer, 4)) return put_as<std::int32_t>(x, y, block);
    if (is(Kind::signed_integer, 8)) return put_as<std::int64_t>(x, y, block);
    if (is(Kind::floating, 2)) return put_as<Half>(x, y, block);
    if (is(Kind::floating, 4)) return put_as<float>(x, y, block);
    if (is(Kind::floating, 8)) return put_as<double>(x, y, block);
}

StoredImage NumberPicture::finish(const std::string& codec, bool floats_anyway) && {
    constexpr bool host_is_big = std::endian::native == std::endian::big;
    if (!is_whole_) {  // stopped: the result is not used
        StoredImage none;
        none.image = {1, 1, 1, 1, {0}};
        return none;
    }
    picture_.codec = codec;
    picture_.bits = 8 * format_.bytes;
    picture_.pixel_format = number_format_name(format_);
    if (format_.is_codes()) return std::move(picture_);
    if (codes_ && !floats_anyway) {
        std::vector<float>& values = picture_.values;
        std::vector<std::uint8_t>& samples = picture_.image.samples;
        samples.reserve(values.size() * 2);  // which takes memory as it is filled
        until_stopped(values.size(), [&](std::size_t first, std::size_t last) {
            samples.resize(2 * last);
            for (std::size_t k = first; k < last; ++k) {
                const auto code = static_cast<std::uint16_t>(values[k]);
                std::memcpy(samples.data() + 2 * k, &code, 2);
            }
            give_back(values.data() + first, (last - first) * sizeof(float));
        });
        samples.resize(values.size() * 2);
        values = {};
        picture_.bits = 16;
        picture_.pixel_format = number_format_name({NumberFormat::Kind::unsigned_integer, 2, host_is_big});
    } else if (format_.kind != NumberFormat::Kind::floating) {
        picture_.pixel_format = number_format_name({NumberFormat::Kind::floating, 4, host_is_big});
    }
    return std::move(picture_);
}

Result<StoredImage> ImageStack::image(std::int64_t number) {
    if (number < 0 || number >= count())
        return usage_error(where_ + ": has no " + unit_ + ' ' + std::to_string(number) +
                           ": must be from 0 to " + std::to_string(count() - 1));
    auto picture = read(number, floats_);
    return stop_requested() ? interrupted_error() : std::move(picture);
}

Result<void> ImageStack::find_floats() {
    for (std::int64_t number = 0; number < count() && count() > 1 && !floats_; ++number) {
        TRY_ASSIGN(const auto picture, read(number, false));
        floats_ = !picture.values.empty();
    }
    return {};
}

Result<StoredImage> decode_netpbm(std::string_view bytes, const std::string& where) {
    NetpbmWords words(bytes);
    TRY_ASSIGN(const auto header, netpbm_header(words, where));
    const std::size_t needed = header.sample_count() * static_cast<std::size_t>(header.bytes_per_sample());
    if (header.text) {
        TRY_ASSIGN(const auto samples, bytes_of_words(words, header, where));
        return netpbm_picture(samples, header, where);
    }
    if (words.data().size() < needed) return cut_picture(where);
    return netpbm_picture(words.data().substr(0, needed), header, where);
}

Result<StoredImage> decode_pfm(std::string_view bytes, const std::string& where) {
    NetpbmWords words(bytes);
    words.next();
    const int width = words.number(), height = words.number();
    TRY(check_picture_size(width, height, where));
    const float scale = parsed_as<float>(words.next()).value_or(0);
    if (scale == 0 || !std::isfinite(scale))
        return input_error(
            where + ": has no scale after its size: must be a number, negative where the low byte is first");
    const std::size_t row = static_cast<std::size_t>(width) * 4;
    if (!words.at_blank() || words.data().size() / row < static_cast<std::size_t>(height))
        return cut_picture(where);
    NumberPicture picture(width, height, {NumberFormat::Kind::floating, 4, scale > 0});
    const char* last_row = words.data().data() + row * static_cast<std::size_t>(height - 1);
    picture.put(0, 0, {last_row, width, height, 4, -static_cast<std::ptrdiff_t>(row)});
    return std::move(picture).finish("pfm");
}

Result<StoredImage> decode_dpt(std::string_view bytes, const std::string& where) {
    constexpr std::size_t head = 12;
    if (bytes.size() < head) return cut_picture(where);
    const auto side = [&](std::size_t at) {
        return static_cast<std::int64_t>(number_in_bytes(bytes.substr(at, 4), false));
    };
    TRY(check_picture_size(side(4), side(8), where));
    const auto width = static_cast<int>(side(4)), height = static_cast<int>(side(8));
    const std::size_t row = static_cast<std::size_t>(width) * 4, all = row * static_cast<std::size_t>(height);
    bytes.remove_prefix(head);
    if (bytes.size() < all) return cut_picture(where);
    if (bytes.size() >= 2 * all) return input_error(where + ": is optical flow, which is no depth");
    NumberPicture picture(width, height, {NumberFormat::Kind::floating, 4});
    picture.put(0, 0, {bytes.data(), width, height, 4, static_cast<std::ptrdiff_t>(row)});
    return std::move(picture).finish("dpt");
}

bool is_tiff(std::string_view begin) {
    using namespace std::string_view_literals;
    for (const auto magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv})
        if (begin.starts_with(magic)) return true;
    return false;
}

Result<StoredImage> decode_tiff(std::string_view bytes, const std::string& where) {
    const auto source = bytes_in_memory(bytes);
    TiffBytes file{*source, bytes};
    const TiffPtr tiff = open_tiff(file);
    if (!tiff) return tiff_damage(file, where);
    TiffDirectories directories(*source, where);
    if (const auto pages = directories.pages(); pages && pages->size() > 1)
        if (const std::size_t place = first_frame_of(*pages); place > 0)
            if (TIFFSetSubDirectory(tiff.get(), (*pages)[place].at) != 1) return tiff_damage(file, where);
    return tiff_page(tiff.get(), file, where);
}

Result<std::shared_ptr<ImageStack>> open_tiff_stack(const SourceFile& file) {
    TRY_ASSIGN(auto bytes, bytes_of_file(file));
    std::string where = file.string();
    TiffDirectories directories(*bytes, where);
    TRY_ASSIGN(auto pages, directories.pages());
    if (pages.size() == 1) return std::shared_ptr<ImageStack>();
    const std::size_t place = first_frame_of(pages);
    const TiffPage first = pages[place];
    std::size_t left_out = 0;
    std::erase_if(pages, [&](const TiffPage& page) {
        const bool is_frame = page.at == first.at || (!page.is_another_view && page.tags == first.tags);
        left_out += is_frame || page.is_another_view ? 0 : 1;
        return !is_frame;
    });
    std::string told;
    if (place > 0)
        told = "depth is page " + std::to_string(place) + ", as page 0 is in colour; " +
               counted(left_out, "page is", "pages are") + " left out";
    else if (left_out > 0)
        told = counted(left_out, "page is", "pages are") +
               " of another size or kind than the first, and left out";
    auto stack =
        std::make_shared<TiffStack>(std::move(bytes), std::move(where), std::move(pages), std::move(told));
    TRY(stack->open());
    return std::shared_ptr<ImageStack>(std::move(stack));
}

}  // namespace touchable
