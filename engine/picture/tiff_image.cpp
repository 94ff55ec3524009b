#include "engine/picture/tiff_image.hpp"

#include <tiffio.h>

#include <algorithm>
#include <bit>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/picture/number_picture.hpp"

namespace touchable {
namespace {

constexpr tmsize_t largest_tile = tmsize_t{64} << 20;
constexpr tmsize_t largest_piece = tmsize_t{256} << 20;  // of memory that libtiff takes at once

struct CloseTiff {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

/// A file in memory as libtiff reads it, and the first that was wrong with it.
struct TiffBytes {
    std::string_view bytes;
    toff_t at = 0;
    std::string wrong;
};

TiffBytes& of_handle(thandle_t handle) {
    return *static_cast<TiffBytes*>(handle);
}
tmsize_t read_tiff(thandle_t handle, void* to, tmsize_t size) {
    TiffBytes& file = of_handle(handle);
    const auto rest = file.at < file.bytes.size() ? file.bytes.size() - file.at : 0;
    const std::size_t count = std::min(rest, static_cast<std::size_t>(std::max<tmsize_t>(size, 0)));
    if (count > 0) std::memcpy(to, file.bytes.data() + file.at, count);
    file.at += count;
    return static_cast<tmsize_t>(count);
}
tmsize_t write_tiff(thandle_t, void*, tmsize_t) {
    return -1;
}
toff_t seek_tiff(thandle_t handle, toff_t offset, int from) {
    TiffBytes& file = of_handle(handle);
    return file.at = offset + (from == SEEK_CUR ? file.at : from == SEEK_END ? file.bytes.size() : 0);
}
int leave_tiff(thandle_t) {
    return 0;
}
toff_t size_of_tiff(thandle_t handle) {
    return of_handle(handle).bytes.size();
}
int map_tiff(thandle_t handle, void** begin, toff_t* size) {
    *begin = const_cast<char*>(of_handle(handle).bytes.data());  // libtiff only reads it
    *size = of_handle(handle).bytes.size();
    return 1;
}
void unmap_tiff(thandle_t, void*, toff_t) {}

[[gnu::format(printf, 4, 0)]] int keep_first_error(TIFF*, void* file, const char*, const char* format,
                                                   std::va_list arguments) {
    char text[256];
    std::vsnprintf(text, sizeof text, format, arguments);
    std::string& wrong = static_cast<TiffBytes*>(file)->wrong;
    if (wrong.empty()) wrong = printable(text, 200);
    return 1;
}
/// Unknown tags and the like.
int ignore_warning(TIFF*, void*, const char*, const char*, std::va_list) {
    return 1;
}

using TiffPtr = std::unique_ptr<TIFF, CloseTiff>;

TiffPtr open_tiff(TiffBytes& file) {
    const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                               TIFFOpenOptionsFree);
    if (!options) return nullptr;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), largest_piece);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_first_error, &file);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), ignore_warning, nullptr);
    return TiffPtr(TIFFClientOpenExt("", "r", &file, read_tiff, write_tiff, seek_tiff, leave_tiff,
                                     size_of_tiff, map_tiff, unmap_tiff, options.get()));
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

/// What of TIFF's many kinds is not read; empty where this one is.
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

/// Takes pixels where they belong: numbers of grey, or RGB of 8 bits.
class TiffPixels {
public:
    explicit TiffPixels(const TiffLayout& layout) : layout_(layout) {
        const int width = static_cast<int>(layout.width), height = static_cast<int>(layout.height);
        if (!layout.is_rgb() || layout.bits > 8) {
            grey_.emplace(width, height, layout.numbers());
            return;
        }
        rgb_ = {width, height, 1, 3, {}};
        rgb_.samples.resize(std::size_t{layout.width} * layout.height * 3);
    }
    /// `across` is how many pixels a row of them has in memory. False for colour where only grey is read.
    bool put(int x, int y, const char* pixels, int width, int height, int across) {
        const int step = layout_.pixel_bytes();
        const NumberBlock block{pixels, width, height, step, std::ptrdiff_t{step} * across};
        if (!grey_) return put_rgb(x, y, block);
        if (layout_.is_rgb() && !is_grey(block)) return false;
        grey_->put(x, y, block);
        return true;
    }
    StoredImage finish() && {
        if (grey_) return std::move(*grey_).finish("tiff");
        StoredImage stored;
        stored.image = std::move(rgb_);
        stored.codec = "tiff";
        stored.pixel_format = "rgb24";
        return stored;
    }

private:
    bool put_rgb(int x, int y, const NumberBlock& block) {
        for (int row = 0; row < block.height; ++row) {
            const char* from = block.first + block.row_step * row;
            std::uint8_t* to =
                rgb_.samples.data() +
                (static_cast<std::size_t>(y + row) * layout_.width + static_cast<std::size_t>(x)) * 3;
            for (int column = 0; column < block.width; ++column, to += 3, from += block.column_step)
                std::memcpy(to, from, 3);
        }
        return true;
    }
    /// Of 16 bits, red, green and blue the same.
    static bool is_grey(const NumberBlock& block) {
        for (int row = 0; row < block.height; ++row) {
            const char* at = block.first + block.row_step * row;
            for (int column = 0; column < block.width; ++column, at += block.column_step)
                if (std::memcmp(at, at + 2, 4) != 0) return false;
        }
        return true;
    }

    TiffLayout layout_;
    std::optional<NumberPicture> grey_;
    Image rgb_;
};

enum class TiffOutcome { read, damaged, coloured, interrupted };

TiffOutcome read_tiles(TIFF* tiff, const TiffLayout& layout, TiffPixels& pixels) {
    std::uint32_t across = 0, down = 0;
    TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &across);
    TIFFGetField(tiff, TIFFTAG_TILELENGTH, &down);
    const tmsize_t size = TIFFTileSize(tiff);
    const auto needed = std::uint64_t{across} * down * static_cast<std::uint64_t>(layout.pixel_bytes());
    if (size < 1 || size > largest_tile || static_cast<std::uint64_t>(size) != needed)
        return TiffOutcome::damaged;
    std::vector<char> tile(static_cast<std::size_t>(size));
    for (std::uint32_t y = 0; y < layout.height; y += down)
        for (std::uint32_t x = 0; x < layout.width; x += across) {
            if (stop_requested()) return TiffOutcome::interrupted;
            if (TIFFReadEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, 0), tile.data(), size) != size)
                return TiffOutcome::damaged;
            if (!pixels.put(static_cast<int>(x), static_cast<int>(y), tile.data(),
                            static_cast<int>(std::min(across, layout.width - x)),
                            static_cast<int>(std::min(down, layout.height - y)), static_cast<int>(across)))
                return TiffOutcome::coloured;
        }
    return TiffOutcome::read;
}

TiffOutcome read_rows(TIFF* tiff, const TiffLayout& layout, TiffPixels& pixels) {
    const tmsize_t size = TIFFScanlineSize(tiff);
    if (size != static_cast<tmsize_t>(layout.width) * layout.pixel_bytes()) return TiffOutcome::damaged;
    std::vector<char> row(static_cast<std::size_t>(size));
    const int width = static_cast<int>(layout.width);
    for (std::uint32_t y = 0; y < layout.height; ++y) {
        if (stop_requested()) return TiffOutcome::interrupted;
        if (TIFFReadScanline(tiff, row.data(), y, 0) != 1) return TiffOutcome::damaged;
        if (!pixels.put(0, static_cast<int>(y), row.data(), width, 1, width)) return TiffOutcome::coloured;
    }
    return TiffOutcome::read;
}

Error tiff_damage(const TiffBytes& file, const std::string& where) {
    return input_error(where + ": is damaged" + (file.wrong.empty() ? "" : ": " + file.wrong));
}

}  // namespace

bool is_tiff(std::string_view begin) {
    using namespace std::string_view_literals;
    for (const auto magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv})
        if (begin.starts_with(magic)) return true;
    return false;
}

Result<StoredImage> decode_tiff(std::string_view bytes, const std::string& where) {
    TiffBytes file{bytes, 0, {}};
    const TiffPtr tiff = open_tiff(file);
    if (!tiff) return tiff_damage(file, where);
    const TiffLayout layout = layout_of(tiff.get());
    TRY(check_picture_size(layout.width, layout.height, where));
    if (const std::string refusal = refusal_of(layout); !refusal.empty())
        return input_error(where + ": " + refusal);
    const auto needed =
        std::uint64_t{layout.width} * layout.height * static_cast<std::uint64_t>(layout.pixel_bytes());
    TRY(check_expansion(needed, bytes.size(), where));
    TiffPixels pixels(layout);
    switch (TIFFIsTiled(tiff.get()) ? read_tiles(tiff.get(), layout, pixels)
                                    : read_rows(tiff.get(), layout, pixels)) {
        case TiffOutcome::damaged:
            return tiff_damage(file, where);
        case TiffOutcome::coloured:
            return input_error(where + ": is in colour of 16 bits: must be grey, or RGB of 8 bits");
        case TiffOutcome::interrupted:
            return Error{ErrorKind::interrupted, "interrupted while " + where + " was read"};
        case TiffOutcome::read:
            break;
    }
    return std::move(pixels).finish();
}

}  // namespace touchable
