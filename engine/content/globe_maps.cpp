// SPDX-License-Identifier: Apache-2.0
// The check of a globe's maps, and the search for their shore.
#include "engine/content/globe_maps.hpp"

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/content/mapped_ground.hpp"

namespace touchable {
namespace {

Result<void> check_map(const GlobeMap& map, const char* which) {
    const auto refuse = [&](const std::string& what) {
        return input_error(std::string("the ") + which + " map " + what);
    };
    if (map.empty()) return refuse("is missing");
    const double shape = static_cast<double>(map.width) / map.height;
    if (std::fabs(shape - 2) <= 0.02 && map.width >= 4) return {};
    return refuse("is " + size_text(map.width, map.height) +
                  "; must be equirectangular, the whole globe, twice as wide as high");
}

struct Range {
    double least = HUGE_VAL, most = -HUGE_VAL;
};
template <class Value>
Range range_of(const GlobeMap& map, Value&& value) {
    Range range;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const double number = value(x, y);
            if (!std::isfinite(number)) continue;
            range.least = std::min(range.least, number);
            range.most = std::max(range.most, number);
        }
    return range;
}

/// A pixel of the elevation map: its height, whether the mask is bright there, and its area. Areas are whole
/// numbers, so that their sums are exact in any order.
struct Sample {
    float height;
    bool bright;
    std::int64_t area;
};

/// Sorted by height. At most some two million: enough to compare the maps.
std::vector<Sample> samples_of(const GlobeMap& elevation, const GlobeMap& mask, double mask_middle) {
    const int step = (elevation.width + 2047) / 2048;
    std::vector<Sample> samples;
    for (int y = 0; y < elevation.height; y += step) {
        const double south = (y + 0.5) / elevation.height;
        const auto area = static_cast<std::int64_t>(1'000'000 * sine(pi * south));
        const int mask_y = std::min(static_cast<int>(south * mask.height), mask.height - 1);
        for (int x = 0; x < elevation.width; x += step) {
            const double height = elevation.at(x, y, 0);
            if (!std::isfinite(height)) continue;
            const int mask_x =
                std::min(static_cast<int>((x + 0.5) / elevation.width * mask.width), mask.width - 1);
            samples.push_back(
                {static_cast<float>(height), mask_brightness(mask, mask_x, mask_y) > mask_middle, area});
        }
    }
    std::ranges::sort(samples, {}, &Sample::height);
    return samples;
}

/// Areas on both sides of a sea level.
struct Areas {
    std::int64_t bright_above = 0, bright_below = 0, dark_above = 0, dark_below = 0;

    /// -1 to 1: how much more often bright pixels are above the level than dark ones. 0 if mask and elevation
    /// are unrelated, however much more sea there is than land.
    double sense() const {
        const auto share = [](std::int64_t above, std::int64_t below) {
            return static_cast<double>(above) / static_cast<double>(std::max<std::int64_t>(above + below, 1));
        };
        return share(bright_above, bright_below) - share(dark_above, dark_below);
    }
    double agreement(bool bright_is_land) const {
        const double same =
            static_cast<double>(bright_is_land ? bright_above + dark_below : dark_above + bright_below);
        return same / static_cast<double>(bright_above + bright_below + dark_above + dark_below);
    }
};

/// Calls `visit(level, areas)` for each height that occurs, as the sea level.
template <class Visit>
void each_level(const std::vector<Sample>& samples, Visit&& visit) {
    Areas areas;
    for (const Sample& sample : samples)
        (sample.bright ? areas.bright_above : areas.dark_above) += sample.area;
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const Sample& sample = samples[n];
        (sample.bright ? areas.bright_above : areas.dark_above) -= sample.area;
        (sample.bright ? areas.bright_below : areas.dark_below) += sample.area;
        if (n + 1 == samples.size() || samples[n + 1].height > sample.height)
            visit(static_cast<double>(sample.height), areas);
    }
}

/// The areas at the sea level `stated`: those of the last level that is not above it.
Areas areas_at(const std::vector<Sample>& samples, double stated) {
    Areas at;
    for (const Sample& sample : samples) {
        const bool above = sample.height > stated;
        (sample.bright ? (above ? at.bright_above : at.bright_below)
                       : (above ? at.dark_above : at.dark_below)) += sample.area;
    }
    return at;
}

std::string percent(double share) {
    return trimmed_number(std::floor(1000 * share + 0.5) / 10) + " %";
}

}  // namespace

double mask_brightness(const GlobeMap& mask, int x, int y) {
    double sum = 0;
    for (int channel = 0; channel < mask.channels; ++channel) sum += mask.at(x, y, channel);
    return sum;
}

bool is_land(const GlobeMap& mask, const GlobeMaps::Shore& shore, int x, int y) {
    return (mask_brightness(mask, x, y) > shore.mask_middle) == shore.bright_is_land;
}

Result<void> check_globe_maps(const GlobeMaps& maps) {
    // Before the mask, which is made from the elevation map if it is missing.
    if (!maps.elevation.empty() && maps.elevation.channels != 1)
        return input_error("the elevation map has colours; must be grey");
    for (const auto& [map, which] : {std::pair{&maps.colour, "colour"},
                                     std::pair{&maps.elevation, "elevation"}, std::pair{&maps.mask, "mask"}})
        TRY(check_map(*map, which));
    if (!maps.haptic.empty()) TRY(check_map(maps.haptic, "haptic"));
    if (!maps.colour.values.empty() || !maps.haptic.values.empty())
        return input_error(std::string("the ") + (maps.colour.values.empty() ? "haptic" : "colour") +
                           " map holds numbers; must be a picture of 8 or 16 bits");
    if (!maps.haptic.empty() && maps.haptic.channels != 3)
        return input_error("the haptic map is grey; must be RGB: stiffness, static and dynamic friction");
    if (!(maps.relief > 0 && maps.relief <= 0.1))
        return usage_error("a relief of " + trimmed_number(maps.relief) +
                           " radii is impossible; must be above 0, and 0.1 at most");
    if (!(maps.smoothing_degrees >= 0 && maps.smoothing_degrees <= 10))
        return usage_error("smoothing over " + trimmed_number(maps.smoothing_degrees) +
                           " degrees is impossible; must be 0 to 10");
    return {};
}

Result<GlobeMaps::Shore> find_shore(const GlobeMap& elevation, const GlobeMap& mask,
                                    std::optional<double> given) {
    const Range light = range_of(mask, [&](int x, int y) { return mask_brightness(mask, x, y); });
    const Range heights = range_of(elevation, [&](int x, int y) { return elevation.at(x, y, 0); });
    if (!(light.least < light.most))
        return input_error("the mask map is the same everywhere; must tell land from ocean");
    if (!(heights.least < heights.most)) return input_error("the elevation map is level everywhere");
    GlobeMaps::Shore shore;
    shore.mask_middle = 0.5 * (light.least + light.most);
    shore.top = heights.most;
    const std::vector<Sample> samples = samples_of(elevation, mask, shore.mask_middle);
    if (samples.empty())
        return input_error(
            "the elevation map has too few numbers to find land by; must have them all over the globe");

    double sense = 0;
    if (given) {
        shore.sea_level = *given;
        sense = areas_at(samples, shore.sea_level).sense();
    } else {
        each_level(samples, [&](double, const Areas& areas) {
            if (std::fabs(areas.sense()) > std::fabs(sense)) sense = areas.sense();
        });
        each_level(samples, [&](double level, const Areas& areas) {
            if (const double agreement = areas.agreement(sense > 0); agreement > shore.agreement) {
                shore.agreement = agreement;
                shore.sea_level = level;
            }
        });
    }
    shore.bright_is_land = sense > 0;
    shore.agreement = areas_at(samples, shore.sea_level).agreement(shore.bright_is_land);
    const std::string level = trimmed_number(shore.sea_level);
    constexpr double least_sense = 0.6;
    if (std::fabs(sense) < least_sense)
        return input_error(
            std::string("the elevation map and the mask do not agree where land is: at ") +
            (given ? "" : "the best ") + "sea level, " + level + ", on " + percent(shore.agreement) +
            " of the globe; must both have longitude -180 to 180 degrees from left to right, and north up");
    if (!(shore.top > shore.sea_level))
        return input_error("nothing is above sea level " + level + " in the elevation map, which goes from " +
                           trimmed_number(heights.least) + " to " + trimmed_number(heights.most));
    return shore;
}

}  // namespace touchable
