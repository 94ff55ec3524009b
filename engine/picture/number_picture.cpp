#include "engine/picture/number_picture.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <utility>

#include "engine/base/stop_request.hpp"

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
    if (swapped) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Number>(bytes);
}

template <class Number>
float as_float(Number number) {
    return static_cast<float>(number);
}
/// A number that no float can hold is beyond all that could be touched.
float as_float(double number) {
    if (std::abs(number) > std::numeric_limits<float>::max())
        return std::copysign(std::numeric_limits<float>::infinity(), static_cast<float>(number > 0 ? 1 : -1));
    return static_cast<float>(number);
}

const char* order_name(bool big_endian) {
    return big_endian ? "be" : "le";
}

/// After FFmpeg's names for what is like its formats.
std::string number_format_name(const NumberFormat& format) {
    const bool floating = format.kind == NumberFormat::Kind::floating;
    if (!floating && format.bytes == 1) return "gray";
    return std::string("gray") + (floating ? "f" : "") + std::to_string(8 * format.bytes) +
           order_name(format.big_endian);
}

}  // namespace

NumberPicture::NumberPicture(int width, int height, const NumberFormat& format)
    : format_(format), codes_(format.kind != NumberFormat::Kind::floating) {
    const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    picture_.image = {width, height, 2, 1, {}};
    const auto fill = [&](auto& memory, std::size_t each) {
        memory.reserve(count * each);
        is_whole_ = until_stopped(count, [&](std::size_t, std::size_t last) { memory.resize(last * each); });
    };
    if (stored_as_codes()) {
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
        std::size_t at = static_cast<std::size_t>(y + row) * static_cast<std::size_t>(picture_.image.width) +
                         static_cast<std::size_t>(x);
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
    if (!is_whole_) {  // of which nothing is asked any more
        StoredImage none;
        none.image = {1, 1, 1, 1, {0}};
        return none;
    }
    picture_.codec = codec;
    picture_.bits = 8 * format_.bytes;
    picture_.pixel_format = number_format_name(format_);
    if (stored_as_codes()) return std::move(picture_);
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

}  // namespace touchable
