#include "engine/formats/cdr_message.hpp"

#include <cstdint>
#include <cstring>
#include <utility>

namespace touchable {
namespace {

/// Values one after the other, each copied from CDR, where a number stands at a multiple of its size behind
/// the four bytes that say what kind of CDR it is. Once the bytes are too few, nothing more is copied.
class Copy {
public:
    explicit Copy(std::string_view values) : from_(values) {}
    std::string take() { return std::move(to_); }

    std::uint32_t number() {
        align(sizeof(std::uint32_t));
        const std::string_view bytes = next(sizeof(std::uint32_t));
        to_ += bytes;
        return value_of(bytes);
    }
    void bytes(std::size_t count) { to_ += next(count); }
    void doubles(std::size_t count) {
        if (count == 0) return;
        align(sizeof(double));
        bytes(count * sizeof(double));
    }
    /// Which ends with a zero in CDR.
    void text() {
        align(sizeof(std::uint32_t));
        const std::uint32_t length = value_of(next(sizeof(std::uint32_t)));
        const std::string_view words = next(length);
        if (is_over_) return;
        const auto shown = length > 0 ? length - 1 : 0;
        to_.append(reinterpret_cast<const char*>(&shown), sizeof shown);
        to_ += words.substr(0, shown);
    }
    void header() {
        to_.append(sizeof(std::uint32_t), '\0');
        number();
        number();
        text();
    }

private:
    /// 0 where there are no bytes.
    static std::uint32_t value_of(std::string_view bytes) {
        std::uint32_t value = 0;
        std::memcpy(&value, bytes.data(), bytes.size());
        return value;
    }
    void align(std::size_t size) {
        const std::size_t beyond = at_ % size;
        if (beyond > 0) next(size - beyond);
    }
    /// All of them, or none.
    std::string_view next(std::size_t count) {
        is_over_ = is_over_ || count > from_.size() - at_;
        const std::string_view bytes = from_.substr(at_, is_over_ ? 0 : count);
        at_ += bytes.size();
        return bytes;
    }

    std::string_view from_;
    std::string to_;
    std::size_t at_ = 0;
    bool is_over_ = false;
};

}  // namespace

std::optional<RosType> ros2_type(std::string name) {
    constexpr std::string_view between = "/msg/";
    if (const auto place = name.find(between); place != std::string::npos)
        name.replace(place, between.size(), "/");
    for (const RosType& known : {ros_image, ros_compressed_image, ros_camera_info})
        if (name == known.name) return known;
    return {};
}

std::string ros1_of_cdr(std::string_view cdr, const RosType& type) {
    constexpr std::string_view plain_low_byte_first("\0\1", 2);
    constexpr std::size_t kind_bytes = 4;
    if (cdr.size() < kind_bytes || !cdr.starts_with(plain_low_byte_first)) return {};
    Copy copy(cdr.substr(kind_bytes));
    copy.header();
    if (type == ros_image) {
        copy.number();
        copy.number();
        copy.text();
        copy.bytes(1);
        copy.number();
        copy.bytes(copy.number());
    } else if (type == ros_compressed_image) {
        copy.text();
        copy.bytes(copy.number());
    } else if (type == ros_camera_info) {
        copy.number();
        copy.number();
        copy.text();
        copy.doubles(copy.number());
        copy.doubles(9 + 9 + 12);
        for (int part = 0; part < 6; ++part) copy.number();
        copy.bytes(1);
    } else {
        return {};
    }
    return copy.take();
}

}  // namespace touchable
