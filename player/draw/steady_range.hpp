#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// From least to greatest of something that is shown.
struct ValueRange {
    double least = 0, greatest = 0;
    bool operator==(const ValueRange&) const = default;
};

/// The range of a scale that does not flicker with what it is of: it widens at once, and narrows in the
/// course of seconds of the clip's time. Another epoch begins anew.
class SteadyRange {
public:
    static constexpr double narrowing_s = 2;  ///< to this part of the way is left: 1 - dt / this, each frame

    const ValueRange& update(const ValueRange& seen, const HeightField& field) {
        const double passed_s = 1e-9 * (field.moment_ns() - moment_ns_);
        const double share = std::clamp(passed_s / narrowing_s, 0.0, 1.0);
        if (!range_ || field.epoch() != epoch_ || passed_s < 0) range_ = seen;
        range_->least = std::min(seen.least, range_->least + share * (seen.least - range_->least));
        range_->greatest =
            std::max(seen.greatest, range_->greatest + share * (seen.greatest - range_->greatest));
        moment_ns_ = field.moment_ns();
        epoch_ = field.epoch();
        return *range_;
    }

private:
    std::optional<ValueRange> range_;
    double moment_ns_ = 0;
    std::uint64_t epoch_ = 0;
};

}  // namespace touchable
