#include "engine/formats/ros_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/rvl.hpp"
#include "engine/picture/decoded_picture.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/rgb_converter.hpp"

namespace touchable {
namespace {

/// How a pixel is stored.
struct Encoding {
    const char* name;
    RosPictureKind kind;
    int bytes;              ///< of a pixel
    int red = 0, blue = 2;  ///< bytes of a pixel that hold them
    AVPixelFormat yuv = AV_PIX_FMT_NONE;
};
constexpr Encoding encodings[] = {
    {"mono8", RosPictureKind::grey8, 1},
    {"8UC1", RosPictureKind::grey8, 1},
    {"mono16", RosPictureKind::depth16, 2},
    {"16UC1", RosPictureKind::depth16, 2},
    {"Z16", RosPictureKind::depth16, 2},
    {"32FC1", RosPictureKind::depth_floats, 4},
    {"rgb8", RosPictureKind::colour, 3},
    {"bgr8", RosPictureKind::colour, 3, 2, 0},
    {"8UC3", RosPictureKind::colour, 3, 2, 0},
    {"rgba8", RosPictureKind::colour, 4},
    {"bgra8", RosPictureKind::colour, 4, 2, 0},
    {"8UC4", RosPictureKind::colour, 4, 2, 0},
    {"yuv422", RosPictureKind::colour, 2, 0, 0, AV_PIX_FMT_UYVY422},
    {"UYVY", RosPictureKind::colour, 2, 0, 0, AV_PIX_FMT_UYVY422},
    {"yuv422_yuy2", RosPictureKind::colour, 2, 0, 0, AV_PIX_FMT_YUYV422},
    {"YUYV", RosPictureKind::colour, 2, 0, 0, AV_PIX_FMT_YUYV422},
    {"yuyv", RosPictureKind::colour, 2, 0, 0, AV_PIX_FMT_YUYV422},
};

const Encoding* encoding_named(std::string_view name) {
    const auto* const found = std::find_if(std::begin(encodings), std::end(encodings),
                                           [&](const Encoding& each) { return name == each.name; });
    return found == std::end(encodings) ? nullptr : found;
}

const char* row_of(const RosImage& image, int y) {
    return image.data.data() + std::size_t{image.step} * static_cast<std::size_t>(y);
}

void swap_bytes(std::uint8_t* values, std::size_t count, std::size_t size) {
    for (std::size_t k = 0; k < count; ++k) std::reverse(values + k * size, values + (k + 1) * size);
}

Result<Image> rgb_of_yuv(const RosImage& image, AVPixelFormat format, const std::string& where) {
    FramePtr frame(av_frame_alloc());
    if (frame) {
        frame->format = format;
        frame->width = static_cast<int>(image.width);
        frame->height = static_cast<int>(image.height);
    }
    if (!frame || av_frame_get_buffer(frame.get(), 0) < 0)
        return Error{ErrorKind::internal, where + ": no memory"};
    for (int y = 0; y < frame->height; ++y)
        std::memcpy(frame->data[0] + std::ptrdiff_t{frame->linesize[0]} * y, row_of(image, y),
                    2 * std::size_t{image.width});
    auto rgb = rgb_converted(*frame);
    if (!rgb) return error_at(where, rgb.error());
    return rgb;
}

Image rgb_of(const RosImage& image, const Encoding& encoding) {
    Image rgb{static_cast<int>(image.width), static_cast<int>(image.height), 1, 3, {}};
    rgb.samples.resize(3 * std::size_t{image.width} * image.height);
    std::uint8_t* to = rgb.samples.data();
    for (int y = 0; y < rgb.height; ++y) {
        const auto* from = reinterpret_cast<const std::uint8_t*>(row_of(image, y));
        for (int x = 0; x < rgb.width; ++x, from += encoding.bytes, to += 3) {
            to[0] = from[encoding.red];
            to[1] = from[1];
            to[2] = from[encoding.blue];
        }
    }
    return rgb;
}

/// Grey and floats: rows without padding, in host order.
template <class Values>
void copy_rows(const RosImage& image, int bytes, Values& values) {
    const std::size_t row = static_cast<std::size_t>(bytes) * image.width;
    auto* const to = reinterpret_cast<std::uint8_t*>(values.data());
    for (std::size_t y = 0; y < image.height; ++y)
        std::memcpy(to + row * y, row_of(image, static_cast<int>(y)), row);
    if (image.is_big_endian && bytes > 1)
        swap_bytes(to, std::size_t{image.width} * image.height, static_cast<std::size_t>(bytes));
}

/// What stands before depth that is packed by compressed_depth_image_transport: which kind, a, b.
constexpr std::size_t packed_head = 12;

/// Columns, rows, and then RVL. Some cameras leave out what compressed_depth_image_transport writes before
/// it.
Result<StoredImage> rvl_picture(std::string_view bytes, const std::string& where) {
    // A run of pixels that are 0 takes a few bytes, however long it is; others take half a byte and more.
    constexpr std::size_t size_bytes = 8, largest_ratio = 50, always_possible = std::size_t{1} << 23;
    for (const std::size_t head : {packed_head, std::size_t{0}}) {
        if (bytes.size() < head + size_bytes) continue;
        std::uint32_t size[2] = {0, 0};
        std::memcpy(size, bytes.data() + head, sizeof size);
        const auto [columns, rows] = size;
        const std::uint64_t pixels = std::uint64_t{columns} * rows;
        if (!check_picture_size(columns, rows, where) ||
            pixels > std::max(largest_ratio * bytes.size(), always_possible))
            continue;
        const auto depths = unpack_rvl(bytes.substr(head + size_bytes), static_cast<std::size_t>(pixels));
        if (!depths) continue;
        StoredImage picture;
        picture.codec = "rvl";
        picture.pixel_format = "gray16le";
        picture.bits = 16;
        picture.image = {static_cast<int>(columns), static_cast<int>(rows), 2, 1, {}};
        picture.image.samples.resize(2 * depths->size());
        std::memcpy(picture.image.samples.data(), depths->data(), picture.image.samples.size());
        return picture;
    }
    return input_error(where + ": is damaged: is not the RVL of a picture");
}

/// PNG of reciprocals: depth = a / (code - b), 0 is none.
void make_floats(StoredImage& picture, float a, float b) {
    const Image& image = picture.image;
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    picture.values.resize(pixels);
    for (std::size_t k = 0; k < pixels; ++k) {
        std::uint16_t code = 0;
        std::memcpy(&code, image.samples.data() + 2 * k, 2);
        picture.values[k] =
            code == 0 ? std::numeric_limits<float>::quiet_NaN() : a / (static_cast<float>(code) - b);
    }
    picture.image.samples.clear();
}

}  // namespace

RosPictureKind ros_picture_kind(std::string_view encoding) {
    const Encoding* const found = encoding_named(encoding);
    return found ? found->kind : RosPictureKind::none;
}

RosPictureKind ros_compressed_kind(std::string_view format) {
    if (format.starts_with("32FC1")) return RosPictureKind::depth_floats;
    if (format.starts_with("16UC1") || format.starts_with("mono16")) return RosPictureKind::depth16;
    if (format.find("ompressedDepth") != std::string_view::npos) return RosPictureKind::depth16;
    return format.find("jp") != std::string_view::npos || format.find("png") != std::string_view::npos
               ? RosPictureKind::colour
               : RosPictureKind::none;
}

Result<StoredImage> ros_picture(const RosImage& image, const std::string& where) {
    const Encoding* const encoding = encoding_named(image.encoding);
    if (encoding == nullptr)
        return input_error(where + ": is of encoding " + in_quotes(image.encoding) +
                           ": must be mono8, mono16, 16UC1, 32FC1, rgb8, bgr8, rgba8, bgra8 or yuv422");
    TRY(check_picture_size(image.width, image.height, where));
    const std::uint64_t row = std::uint64_t{image.width} * static_cast<std::uint64_t>(encoding->bytes);
    if (image.step < row || image.data.size() < std::uint64_t{image.step} * (image.height - 1) + row)
        return input_error(where + ": is damaged: has " + std::to_string(image.data.size()) + " bytes for " +
                           std::to_string(image.width) + "x" + std::to_string(image.height) + " pixels of " +
                           std::string(encoding->name));
    StoredImage picture;
    picture.codec = "ros";
    picture.pixel_format = encoding->name;
    picture.image = {static_cast<int>(image.width), static_cast<int>(image.height), 1, 1, {}};
    const std::size_t pixels = std::size_t{image.width} * image.height;
    if (encoding->yuv != AV_PIX_FMT_NONE) {
        TRY_ASSIGN(auto rgb, rgb_of_yuv(image, encoding->yuv, where));
        picture.image = std::move(rgb);
    } else if (encoding->kind == RosPictureKind::colour) {
        picture.image = rgb_of(image, *encoding);
    } else if (encoding->kind == RosPictureKind::depth_floats) {
        picture.values.resize(pixels);
        copy_rows(image, encoding->bytes, picture.values);
    } else {
        picture.image.bytes_per_sample = encoding->bytes;
        picture.bits = 8 * encoding->bytes;
        picture.image.samples.resize(pixels * static_cast<std::size_t>(encoding->bytes));
        copy_rows(image, encoding->bytes, picture.image.samples);
    }
    return picture;
}

Result<StoredImage> ros_picture(const RosCompressedImage& image, const std::string& where) {
    std::string_view bytes = image.data;
    float quantum[2] = {0, 0};  // a and b of depths in floats
    const bool is_packed_depth = image.format.find("ompressedDepth") != std::string_view::npos;
    const bool is_rvl = is_packed_depth && image.format.find("rvl") != std::string_view::npos;
    if (is_packed_depth) {
        if (bytes.size() < packed_head) return input_error(where + ": is damaged: is cut");
        std::memcpy(quantum, bytes.data() + 4, sizeof quantum);
        if (!is_rvl) bytes.remove_prefix(packed_head);
        if (!is_rvl && picture_kind(bytes) != "PNG")
            return input_error(where + ": is packed as " + in_quotes(image.format) +
                               ": of compressedDepth PNG and RVL are read");
    }
    auto picture = is_rvl ? rvl_picture(bytes, where) : decode_stored_image(std::string(bytes), where);
    if (!picture || !is_packed_depth || !image.format.starts_with("32FC1")) return picture;
    if (picture->image.bytes_per_sample != 2 || picture->image.channels != 1 || !picture->values.empty())
        return input_error(where + ": is damaged: depth is no grey of 16 bits");
    make_floats(*picture, quantum[0], quantum[1]);
    return picture;
}

}  // namespace touchable
