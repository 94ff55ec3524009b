#include "engine/formats/value_estimator.hpp"

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "engine/base/stop_request.hpp"
#include "engine/formats/renderer_background.hpp"
#include "engine/formats/value_evidence.hpp"

namespace touchable {
namespace {

double value_at(const StoredImage& picture, std::size_t k) {
    if (!picture.values.empty()) return picture.values[k];
    if (picture.image.bytes_per_sample == 1) return picture.image.samples[k];
    std::uint16_t word = 0;
    std::memcpy(&word, picture.image.samples.data() + 2 * k, 2);
    return word;
}

/// The one negative number that stands for no depth: -1 in most arrays.
std::optional<double> negative_none(const StoredImage& picture, const RendererBackground& background) {
    std::optional<double> found;
    bool is_one = true;
    until_stopped(picture.values.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last && is_one; ++k) {
            const float value = picture.values[k];
            if (!(value < 0) || background.is(value)) continue;
            is_one = !found || *found == value;
            found = value;
        }
    });
    return is_one ? found : std::nullopt;
}

/// The median of many finite floats, exactly, in memory for none of them: they are given twice, and counted
/// by the upper half of their bits first, then by the lower half where the upper one is the median's.
class MedianCounts {
public:
    MedianCounts() : counts_(halves) {}
    void add(float value) { ++counts_[ordered_bits(value) >> 16U]; }
    /// Once all were added. Of an even number the upper one of both in the middle.
    void begin_again(std::size_t count) {
        left_ = count / 2;
        for (upper_ = 0; left_ >= counts_[upper_]; ++upper_) left_ -= counts_[upper_];
        counts_.assign(halves, 0);
    }
    void add_again(float value) {
        const std::uint32_t bits = ordered_bits(value);
        if (bits >> 16U == upper_) ++counts_[bits & 0xffffU];
    }
    float median() const {
        std::size_t left = left_;
        std::uint32_t lower = 0;
        for (; lower + 1 < halves && left >= counts_[lower]; ++lower) left -= counts_[lower];
        const std::uint32_t bits = upper_ << 16U | lower;
        return std::bit_cast<float>((bits & sign) != 0 ? bits ^ sign : ~bits);
    }

private:
    static constexpr std::uint32_t sign = 0x80000000U;
    static constexpr std::size_t halves = 65536;
    /// In the order of the floats.
    static std::uint32_t ordered_bits(float value) {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        return (bits & sign) != 0 ? ~bits : bits ^ sign;
    }

    std::vector<std::size_t> counts_;
    std::size_t left_ = 0;     // values of the upper half below the median
    std::uint32_t upper_ = 0;  // half of its bits
};

}  // namespace

EstimatedValues estimate_values(const StoredImage& picture) {
    EstimatedValues values;
    values.is_float = !picture.values.empty();
    values.bits = values.is_float ? 32 : 8 * picture.image.bytes_per_sample;
    const double most = values.is_float ? 1 : 65535;
    const std::size_t pixels =
        static_cast<std::size_t>(picture.image.width) * static_cast<std::size_t>(picture.image.height);
    MedianCounts median;
    double sums[2] = {0, 0};
    std::size_t counts[2] = {0, 0}, at_least = 0, at_most = 0, beyond = 0, negative = 0, usable = 0;
    const RendererBackground background(picture);
    const auto none = negative_none(picture, background);
    values.has_negative_none = none.has_value();
    const auto is_usable = [&](double value) {
        return std::isfinite(value) && value != 0 && (values.is_float || value != most);
    };
    until_stopped(pixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const double value = value_at(picture, k);
            if (values.is_float && background.is(value)) {
                values.has_background = true;
                continue;
            }
            if (value == none) continue;
            at_least += value >= 0 && value < 0.02 * most;
            at_most += value > 0.98 * most && value <= most;
            beyond += value > most;
            negative += value < 0;
            if (!is_usable(value)) continue;
            median.add(static_cast<float>(value));
            ++usable;
            const std::size_t third = 3 * k / pixels;
            if (third == 1) continue;
            sums[third / 2] += value;
            ++counts[third / 2];
        }
    });
    if (usable == 0) return values;
    values.any = true;
    median.begin_again(usable);
    until_stopped(pixels, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const double value = value_at(picture, k);
            if (is_usable(value) && value != none && !(values.is_float && background.is(value)))
                median.add_again(static_cast<float>(value));
        }
    });
    values.median = median.median();
    values.negative = static_cast<double>(negative) / static_cast<double>(pixels);
    // All of the range is used, and nothing stands for what was not seen.
    values.is_normalised = values.bits != 8 && !values.has_background && !none && beyond == 0 &&
                           negative == 0 && at_least > 0 && at_most > 0 && 20 * (pixels - usable) < pixels;
    values.divisor = common_divisor(picture);
    if (counts[0] > 0) values.upper = sums[0] / static_cast<double>(counts[0]);
    if (counts[1] > 0) values.lower = sums[1] / static_cast<double>(counts[1]);
    return values;
}

}  // namespace touchable
