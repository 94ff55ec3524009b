#include "engine/authoring/coded_depth.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "engine/scene/stored_code.hpp"

namespace touchable {
namespace {

constexpr double share_of_depth = 1.0 / 64;
constexpr std::int32_t least_tolerance = 2, most_of_codes = 8;

std::int32_t tolerance_of(const DepthCoding& coding, std::uint16_t code) {
    if (coding.valid_min == coding.valid_max) return least_tolerance;
    const auto beside = static_cast<std::uint16_t>(code < coding.valid_max ? code + 1 : code - 1);
    const double depth = coding.depth(code), step = depth - coding.depth(beside);
    const double size = step < 0 ? -step : step;
    const std::int32_t most = std::max<std::int32_t>(least_tolerance, coding.code_max / most_of_codes);
    if (!(size * most > share_of_depth * depth)) return most;
    return std::clamp(static_cast<std::int32_t>(share_of_depth * depth / size), least_tolerance, most);
}

}  // namespace

CodedDepth::CodedDepth(const DepthCoding& coding)
    : coding_(coding), deeper_is_higher_(coding.deeper_is_higher()), tolerance_(65536) {
    for (std::int32_t code = coding.valid_min; code <= coding.valid_max; ++code) {
        const auto word = static_cast<std::uint16_t>(code);
        if (coding.is_valid(word)) tolerance_[word] = tolerance_of(coding, word);
    }
    if (coding.kind != DepthCodingKind::hue) return;
    hue_of_.resize(DepthCoding::hue_circle);
    is_known_.resize(DepthCoding::hue_circle);
}

PlaneView CodedDepth::codes_of(const RawFrame& frame, std::vector<std::uint16_t>& codes) const {
    if (coding_.kind != DepthCodingKind::hue) return frame.depth;
    const PlaneView& depth = frame.depth;
    codes.resize(static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height));
    std::uint16_t* to = codes.data();
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) *to++ = stored_code(depth, coding_, x, y);
    return {reinterpret_cast<const std::uint8_t*>(codes.data()),
            std::ptrdiff_t{2} * depth.width,
            depth.width,
            depth.height,
            2,
            1};
}

void CodedDepth::remember(const RawFrame& frame, const PlaneView& codes) {
    if (coding_.kind != DepthCodingKind::hue) return;
    for (int y = 0; y < codes.height; ++y) {
        const std::uint8_t* rgb = frame.depth.row(y);
        for (int x = 0; x < codes.width; ++x, rgb += 3) {
            const std::uint16_t code = codes.sample(x, y);
            if (code == no_hue || is_known_[code]) continue;
            is_known_[code] = true;
            hue_of_[code] = {rgb[0], rgb[1], rgb[2]};
        }
    }
}

void CodedDepth::put(std::uint16_t code, std::uint8_t* row, int x, int bytes_per_sample) const {
    if (coding_.kind == DepthCodingKind::hue)
        std::memcpy(row + std::ptrdiff_t{3} * x, hue_of_[code].data(), 3);
    else if (bytes_per_sample == 1)
        row[x] = static_cast<std::uint8_t>(code);
    else
        std::memcpy(row + std::ptrdiff_t{2} * x, &code, 2);
}

}  // namespace touchable
