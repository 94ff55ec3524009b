#include "engine/import/guess/value_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "engine/import/guess/renderer_background.hpp"
#include "engine/import/guess/value_evidence.hpp"

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
    for (const float value : picture.values) {
        if (!(value < 0) || background.is(value)) continue;
        if (found && *found != value) return std::nullopt;
        found = value;
    }
    return found;
}

}  // namespace

EstimatedValues estimate_values(const StoredImage& picture) {
    EstimatedValues values;
    values.is_float = !picture.values.empty();
    values.bits = values.is_float ? 32 : 8 * picture.image.bytes_per_sample;
    const double most = values.is_float ? 1 : 65535;
    const std::size_t pixels =
        static_cast<std::size_t>(picture.image.width) * static_cast<std::size_t>(picture.image.height);
    std::vector<double> all;
    double sums[2] = {0, 0};
    std::size_t counts[2] = {0, 0}, at_least = 0, at_most = 0, beyond = 0, negative = 0;
    const RendererBackground background(picture);
    const auto none = negative_none(picture, background);
    values.has_negative_none = none.has_value();
    for (std::size_t k = 0; k < pixels; ++k) {
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
        if (!std::isfinite(value) || value == 0 || (!values.is_float && value == most)) continue;
        all.push_back(value);
        const std::size_t third = 3 * k / pixels;
        if (third == 1) continue;
        sums[third / 2] += value;
        ++counts[third / 2];
    }
    if (all.empty()) return values;
    values.any = true;
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    values.median = *middle;
    values.negative = static_cast<double>(negative) / static_cast<double>(pixels);
    // All of the range is used, and nothing stands for what was not seen.
    values.is_normalised = values.bits != 8 && !values.has_background && !none && beyond == 0 &&
                           negative == 0 && at_least > 0 && at_most > 0 &&
                           20 * (pixels - all.size()) < pixels;
    values.divisor = common_divisor(picture);
    if (counts[0] > 0) values.upper = sums[0] / static_cast<double>(counts[0]);
    if (counts[1] > 0) values.lower = sums[1] / static_cast<double>(counts[1]);
    return values;
}

}  // namespace touchable
