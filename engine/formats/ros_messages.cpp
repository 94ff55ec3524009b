#include "engine/formats/ros_messages.hpp"

#include <bit>
#include <cstring>

namespace touchable {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are read as they are stored");

/// Reads values one after the other. Once the bytes are too few, all that follows is 0.
class Fields {
public:
    explicit Fields(std::string_view bytes) : left_(bytes) {}
    bool ok() const { return ok_; }

    template <class Number>
    Number number() {
        Number value{};
        const std::string_view bytes = take(sizeof value);
        if (ok_) std::memcpy(&value, bytes.data(), sizeof value);
        return value;
    }
    std::string_view text() { return take(number<std::uint32_t>()); }
    template <std::size_t n>
    std::array<double, n> numbers() {
        std::array<double, n> all{};
        for (double& each : all) each = number<double>();
        return all;
    }
    RosHeader header() {
        number<std::uint32_t>();  // of the message among its likes
        const std::int64_t seconds = number<std::uint32_t>();
        const std::int64_t rest = number<std::uint32_t>();
        return {seconds * 1'000'000'000 + rest, text()};
    }
    RosTransform transform() {
        RosTransform read;
        read.translation = numbers<3>();
        read.rotation = numbers<4>();
        return read;
    }
    std::size_t left() const { return left_.size(); }

private:
    std::string_view take(std::size_t count) {
        ok_ = ok_ && count <= left_.size();
        if (!ok_) return {};
        const std::string_view taken = left_.substr(0, count);
        left_.remove_prefix(count);
        return taken;
    }

    std::string_view left_;
    bool ok_ = true;
};

template <class Message>
std::optional<Message> if_whole(const Fields& fields, Message message) {
    if (!fields.ok()) return {};
    return message;
}

}  // namespace

std::optional<std::int64_t> ros_stamp(std::string_view begin) {
    Fields fields(begin);
    fields.number<std::uint32_t>();
    const std::int64_t seconds = fields.number<std::uint32_t>(), rest = fields.number<std::uint32_t>();
    return if_whole(fields, seconds * 1'000'000'000 + rest);
}

std::optional<RosImage> parse_ros_image(std::string_view message) {
    Fields fields(message);
    RosImage image;
    image.header = fields.header();
    image.height = fields.number<std::uint32_t>();
    image.width = fields.number<std::uint32_t>();
    image.encoding = fields.text();
    image.is_big_endian = fields.number<std::uint8_t>() != 0;
    image.step = fields.number<std::uint32_t>();
    image.data = fields.text();
    return if_whole(fields, image);
}

std::optional<RosCompressedImage> parse_ros_compressed_image(std::string_view message) {
    Fields fields(message);
    RosCompressedImage image;
    image.header = fields.header();
    image.format = fields.text();
    image.data = fields.text();
    return if_whole(fields, image);
}

std::optional<RosCameraInfo> parse_ros_camera_info(std::string_view message) {
    Fields fields(message);
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
    info.region.x = fields.number<std::uint32_t>();
    info.region.y = fields.number<std::uint32_t>();
    info.region.height = fields.number<std::uint32_t>();
    info.region.width = fields.number<std::uint32_t>();
    return if_whole(fields, info);
}

std::optional<float> parse_ros_float(std::string_view message) {
    Fields fields(message);
    const auto value = fields.number<float>();
    return if_whole(fields, value);
}

std::optional<RosTransform> parse_ros_transform(std::string_view message) {
    Fields fields(message);
    const RosTransform transform = fields.transform();
    return if_whole(fields, transform);
}

}  // namespace touchable
