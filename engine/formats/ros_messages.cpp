// SPDX-License-Identifier: Apache-2.0
// Messages of ROS 1 and ROS 2, and the pictures in them.

#include "engine/formats/ros_messages.hpp"

#include <bit>
#include <limits>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/picture/decoding.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are read as they are stored");

/// In CDR, a number is aligned to its size, counted from behind the four bytes that state the kind of CDR,
/// and a text ends with a zero.
class MessageFields : public RosFields {
public:
    explicit MessageFields(const RosMessage& message) : RosFields(message.bytes), is_cdr_(message.is_cdr) {
        constexpr std::string_view plain_low_byte_first("\0\1", 2);
        constexpr std::size_t kind_bytes = 4;
        ok_ = !is_cdr_ || take(kind_bytes).starts_with(plain_low_byte_first);
        values_ = left();
    }
    template <class Number>
    Number number() {
        const std::size_t beyond = (values_ - left()) % sizeof(Number);
        if (is_cdr_ && beyond > 0) take(sizeof(Number) - beyond);
        return RosFields::number<Number>();
    }
    template <std::size_t n>
    std::array<double, n> numbers() {
        std::array<double, n> all{};
        for (double& each : all) each = number<double>();
        return all;
    }
    std::string_view data() { return take(number<std::uint32_t>()); }
    std::string_view text() {
        const std::string_view text = data();
        return text.substr(0, text.size() - (is_cdr_ && !text.empty() ? 1 : 0));
    }
    std::int64_t stamp_ns() {
        if (!is_cdr_) number<std::uint32_t>();  // sequence number
        const std::int64_t seconds = number<std::uint32_t>(), rest = number<std::uint32_t>();
        return seconds * 1'000'000'000 + rest;
    }
    RosHeader header() {
        const std::int64_t stamp = stamp_ns();
        return {stamp, text()};
    }

private:
    bool is_cdr_;
    std::size_t values_ = 0;  // bytes of all values
};

template <class Message>
std::optional<Message> if_whole(const MessageFields& fields, Message message) {
    if (!fields.ok()) return {};
    return message;
}

/// Reads groups of four bits from 32-bit words, low byte first, the highest group of a word first.
class RvlNibbles {
public:
    explicit RvlNibbles(std::string_view words) : words_(words) {}
    /// Reads a number: three bits a group, the lowest first; the fourth bit says that another group follows.
    std::uint32_t number() {
        std::uint32_t value = 0;
        for (int bits = 0; bits < 32; bits += 3) {
            const std::uint32_t group = next();
            value |= (group & 7) << bits;
            if ((group & 8) == 0) return value;
        }
        is_over_ = true;
        return 0;
    }
    bool is_over() const { return is_over_; }

private:
    std::uint32_t next() {
        if (left_ == 0) {
            is_over_ = is_over_ || words_.size() < sizeof word_;
            if (is_over_) return 0;
            std::memcpy(&word_, words_.data(), sizeof word_);
            words_.remove_prefix(sizeof word_);
            left_ = 8;
        }
        const std::uint32_t group = word_ >> 28;
        word_ <<= 4;
        --left_;
        return group;
    }

    std::string_view words_;
    std::uint32_t word_ = 0;
    int left_ = 0;  // groups left in the word
    bool is_over_ = false;
};

/// How a pixel is stored.
struct RosEncoding {
    const char* name;
    RosPictureKind kind;
    int bytes;              ///< of a pixel
    int red = 0, blue = 2;  ///< bytes of a pixel that hold them
    AVPixelFormat yuv = AV_PIX_FMT_NONE;
};
constexpr RosEncoding encodings[] = {
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

const RosEncoding* encoding_named(std::string_view name) {
    return named_in(encodings, name, &RosEncoding::name);
}

/// The pixels as bytes, `bytes` each.
PlaneView pixels_of(const RosImage& image, int bytes) {
    return {reinterpret_cast<const std::uint8_t*>(image.data.data()),
            image.step,
            static_cast<int>(image.width),
            static_cast<int>(image.height),
            1,
            bytes};
}

void swap_bytes(std::uint8_t* values, std::size_t count, std::size_t size) {
    for (std::size_t k = 0; k < count; ++k) std::reverse(values + k * size, values + (k + 1) * size);
}

Result<Image> rgb_of_yuv(const RosImage& image, AVPixelFormat format, const std::string& where) {
    const FramePtr frame =
        blank_picture(format, static_cast<int>(image.width), static_cast<int>(image.height));
    if (!frame) return internal_error(where + ": no memory");
    pixels_of(image, 2).copy_rows(frame->data[0], static_cast<std::size_t>(frame->linesize[0]));
    TRY_ASSIGN(const auto rgb, error_at(where, RgbConverter().converted(*frame)));
    return rgb_exact(*rgb);
}

Image rgb_of(const RosImage& image, const RosEncoding& encoding) {
    const PlaneView pixels = pixels_of(image, encoding.bytes);
    Image rgb = blank_image(pixels.width, pixels.height, 1, 3);
    std::uint8_t* to = rgb.samples.data();
    for (int y = 0; y < rgb.height; ++y) {
        const std::uint8_t* from = pixels.row(y);
        for (int x = 0; x < rgb.width; ++x, from += encoding.bytes, to += 3) {
            to[0] = from[encoding.red];
            to[1] = from[1];
            to[2] = from[encoding.blue];
        }
    }
    return rgb;
}

/// Copies rows of grey or floats without padding, in host order.
template <class Values>
void copy_rows(const RosImage& image, int bytes, Values& values) {
    const PlaneView pixels = pixels_of(image, bytes);
    auto* const to = reinterpret_cast<std::uint8_t*>(values.data());
    pixels.copy_rows(to, pixels.row_bytes());
    if (image.is_big_endian && bytes > 1)
        swap_bytes(to, std::size_t{image.width} * image.height, static_cast<std::size_t>(bytes));
}

/// Bytes that compressed_depth_image_transport writes before packed depth: which kind, a, b.
constexpr std::size_t packed_head = 12;

/// Decodes columns, rows, and then RVL. Some cameras leave out compressed_depth_image_transport's head.
Result<StoredImage> rvl_picture(std::string_view bytes, const std::string& where) {
    // A run of pixels that are 0 takes a few bytes, however long it is; others take half a byte and more.
    constexpr std::size_t size_bytes = 8, largest_ratio = 50, always_possible = std::size_t{1} << 23;
    for (const std::size_t head : {packed_head, std::size_t{0}}) {
        if (bytes.size() < head + size_bytes) continue;
        RosFields size(bytes.substr(head));
        const auto columns = size.number<std::uint32_t>(), rows = size.number<std::uint32_t>();
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
        picture.image =
            packed_image(plane_of_codes(depths->data(), static_cast<int>(columns), static_cast<int>(rows)));
        return picture;
    }
    return input_error(where + ": is damaged: is not the RVL of a picture");
}

/// Turns codes of reciprocals into depths, a / (code - b); code 0 is no depth.
void make_floats(StoredImage& picture, float a, float b) {
    const Image& image = picture.image;
    picture.values.resize(pixel_count(image));
    for (std::size_t k = 0; k < picture.values.size(); ++k) {
        const std::uint16_t code = sample_at(image, k);
        picture.values[k] =
            code == 0 ? std::numeric_limits<float>::quiet_NaN() : a / (static_cast<float>(code) - b);
    }
    picture.image.samples.clear();
}

}  // namespace

std::optional<std::int64_t> ros_stamp(const RosMessage& begin) {
    MessageFields fields(begin);
    const std::int64_t stamp = fields.stamp_ns();
    return if_whole(fields, stamp);
}

std::optional<RosImage> parse_ros_image(const RosMessage& message) {
    MessageFields fields(message);
    RosImage image;
    image.header = fields.header();
    image.height = fields.number<std::uint32_t>();
    image.width = fields.number<std::uint32_t>();
    image.encoding = fields.text();
    image.is_big_endian = fields.number<std::uint8_t>() != 0;
    image.step = fields.number<std::uint32_t>();
    image.data = fields.data();
    return if_whole(fields, image);
}

std::optional<RosCompressedImage> parse_ros_compressed_image(const RosMessage& message) {
    MessageFields fields(message);
    RosCompressedImage image;
    image.header = fields.header();
    image.format = fields.text();
    image.data = fields.data();
    return if_whole(fields, image);
}

std::optional<RosCameraInfo> parse_ros_camera_info(const RosMessage& message) {
    MessageFields fields(message);
    RosCameraInfo info;
    info.header = fields.header();
    info.height = fields.number<std::uint32_t>();
    info.width = fields.number<std::uint32_t>();
    info.distortion_model = fields.text();
    const auto count = fields.number<std::uint32_t>();
    if (count > fields.left() / sizeof(double)) return {};
    for (std::uint32_t k = 0; k < count; ++k) info.distortion.push_back(fields.number<double>());
    info.matrix = fields.numbers<9>();
    fields.numbers<9>();  // R: how rectifying turns the camera
    info.projection = fields.numbers<12>();
    fields.number<std::uint32_t>();  // binning, which the size of the picture tells as well
    fields.number<std::uint32_t>();
    for (auto* const term : {&info.region.x, &info.region.y, &info.region.height, &info.region.width})
        *term = fields.number<std::uint32_t>();
    return if_whole(fields, info);
}

std::optional<float> parse_ros_float(const RosMessage& message) {
    MessageFields fields(message);
    const auto value = fields.number<float>();
    return if_whole(fields, value);
}

std::optional<RosTransform> parse_ros_transform(const RosMessage& message) {
    MessageFields fields(message);
    RosTransform transform;
    transform.translation = fields.numbers<3>();
    transform.rotation = fields.numbers<4>();
    return if_whole(fields, transform);
}

std::optional<RosType> ros2_type(std::string name) {
    constexpr std::string_view between = "/msg/";
    if (const auto place = name.find(between); place != std::string::npos)
        name.replace(place, between.size(), "/");
    for (const RosType& known : {ros_image, ros_compressed_image, ros_camera_info})
        if (name == known.name) return known;
    return {};
}

std::optional<std::vector<std::uint16_t>> unpack_rvl(std::string_view words, std::size_t pixels) {
    RvlNibbles nibbles(words);
    std::vector<std::uint16_t> depths;
    depths.reserve(pixels);
    std::uint32_t newest = 0;
    while (depths.size() < pixels) {
        const std::size_t zeros = nibbles.number();
        if (nibbles.is_over() || zeros > pixels - depths.size()) return {};
        depths.resize(depths.size() + zeros, 0);
        const std::size_t others = nibbles.number();
        if (nibbles.is_over() || others > pixels - depths.size()) return {};
        // Two empty runs in a row would never end.
        if (zeros == 0 && others == 0) return {};
        for (std::size_t k = 0; k < others; ++k) {
            const std::uint32_t step = nibbles.number();
            if (nibbles.is_over()) return {};
            newest += (step >> 1) ^ (0 - (step & 1));  // 0, -1, 1, -2 ...
            depths.push_back(static_cast<std::uint16_t>(newest));
        }
    }
    return depths;
}

RosPictureKind ros_picture_kind(std::string_view encoding) {
    const RosEncoding* const found = encoding_named(encoding);
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

Result<StoredImage> ros_picture(const RosImage& message, const std::string& where) {
    RosImage image = message;  // copies no pixels
    const RosEncoding* const encoding = encoding_named(image.encoding);
    if (encoding == nullptr)
        return input_error(where + ": is of encoding " + in_quotes(image.encoding) +
                           ": must be mono8, mono16, 16UC1, 32FC1, rgb8, bgr8, rgba8, bgra8 or yuv422");
    TRY(check_picture_size(image.width, image.height, where));
    const std::uint64_t row = std::uint64_t{image.width} * static_cast<std::uint64_t>(encoding->bytes);
    // Some publishers (AirSim's) leave the step at 0. Then rows have no padding.
    if (image.step == 0 && image.data.size() == row * image.height)
        image.step = static_cast<std::uint32_t>(row);
    if (image.step < row || image.data.size() < std::uint64_t{image.step} * (image.height - 1) + row)
        return input_error(where + ": is damaged: has " + std::to_string(image.data.size()) + " bytes for " +
                           size_text(image.width, image.height) + " pixels of " +
                           std::string(encoding->name));
    StoredImage picture;
    picture.codec = "ros";
    picture.pixel_format = encoding->name;
    picture.image = {static_cast<int>(image.width), static_cast<int>(image.height), 1, 1, {}};
    if (encoding->yuv != AV_PIX_FMT_NONE) {
        TRY_ASSIGN(picture.image, rgb_of_yuv(image, encoding->yuv, where));
    } else if (encoding->kind == RosPictureKind::colour) {
        picture.image = rgb_of(image, *encoding);
    } else if (encoding->kind == RosPictureKind::depth_floats) {
        picture.values.resize(pixel_count(picture.image));
        copy_rows(image, encoding->bytes, picture.values);
    } else {
        picture.bits = 8 * encoding->bytes;
        picture.image = blank_image(picture.image.width, picture.image.height, encoding->bytes, 1);
        copy_rows(image, encoding->bytes, picture.image.samples);
    }
    return picture;
}

Result<StoredImage> ros_picture(const RosCompressedImage& image, const std::string& where) {
    std::string_view bytes = image.data;
    float quantum[2] = {0, 0};  // a and b of depths in floats
    const bool is_packed_depth = image.format.find("ompressedDepth") != std::string_view::npos;
    const bool is_rvl = is_packed_depth && image.format.find("rvl") != std::string_view::npos;
    // Some cameras publish the PNG alone, without the head. Integers need nothing of the head.
    const bool has_head = picture_kind(bytes) != "PNG";
    if (is_packed_depth && !has_head && image.format.starts_with("32FC1"))
        return input_error(where +
                           ": has no head of 12 bytes before its PNG, which says what metres its codes are; "
                           "publish it by compressed_depth_image_transport");
    if (is_packed_depth && has_head) {
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
