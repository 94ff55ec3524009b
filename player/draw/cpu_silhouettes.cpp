// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <cstring>

#include "player/draw/cpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "shaders/cut_rule.h"

// Silhouettes of a picture with a sample a pixel are stairs. The lengths of their steps tell where the edge
// crosses each pixel, and so how much of it each side covers (as in Reshetov, Morphological Antialiasing,
// 2009, but by depth: the clip's own picture on the surface stays sharp).

namespace touchable {
namespace {

enum Side : std::uint8_t { none, first_nearer, second_nearer };

/// Which of two neighbouring pixels lies before the other, by their z (0: nothing is there).
[[gnu::always_inline]] inline std::uint8_t side_of(float first, float second) {
    return static_cast<std::uint8_t>(static_cast<int>(first > CUT_RULE_RATIO * second) * first_nearer |
                                     static_cast<int>(second > CUT_RULE_RATIO * first) * second_nearer);
}

/// The share of `other` that is added to a colour, 0 to 256.
PackedColour mixed(PackedColour colour, PackedColour other, int share) {
    PackedColour out = 0xff000000U;
    for (const int shift : {0, 8, 16}) {
        const auto at = static_cast<int>(colour >> shift & 255U),
                   to = static_cast<int>(other >> shift & 255U);
        out |= static_cast<PackedColour>(at + (to - at) * share / 256) << shift;
    }
    return out;
}

}  // namespace

void Silhouettes::smooth(std::span<PackedColour> colours, std::span<const float> z, int width, int height) {
    sides_.assign(pixel_count(width, height), none);
    const auto rows = [&](auto) __attribute__((always_inline)) {
        for (int y = 0; y < height; ++y) {
            const float* const row = z.data() + static_cast<std::ptrdiff_t>(y) * width;
            std::uint8_t* const to = sides_.data() + static_cast<std::ptrdiff_t>(y) * width;
            for (int x = 0; x + 1 < width; ++x) to[x] = side_of(row[x], row[x + 1]);
        }
    };
    run_vectors(unit_, rows);
    smooth_steps({1, width - 1, width, height}, colours);
    const auto columns = [&](auto) __attribute__((always_inline)) {
        for (int y = 0; y < height; ++y) {
            const float* const row = z.data() + static_cast<std::ptrdiff_t>(y) * width;
            std::uint8_t* const to = sides_.data() + static_cast<std::ptrdiff_t>(y) * width;
            for (int x = 0; x < width && y + 1 < height; ++x) to[x] = side_of(row[x], row[x + width]);
            if (y + 1 == height) std::fill(to, to + width, static_cast<std::uint8_t>(none));
        }
    };
    run_vectors(unit_, columns);
    smooth_steps({width, height - 1, 1, width}, colours);
}

void Silhouettes::smooth_steps(const Steps& steps, std::span<PackedColour> colours) const {
    const int across = steps.across, most_across = steps.most_across, along = steps.along,
              most_along = steps.most_along;
    constexpr int longest = 128;  // pixels; of longer steps the ends are smoothed
    const auto count = static_cast<std::ptrdiff_t>(sides_.size());
    const std::uint8_t* const sides = sides_.data();
    for (const std::uint8_t* found = sides; (found = find_side(found, sides + count)) != nullptr; ++found) {
        const std::ptrdiff_t start = found - sides;
        const auto place_along = static_cast<int>(along == 1 ? start % across : start / along),
                   place_across = static_cast<int>(along == 1 ? start / across : start % along);
        const std::uint8_t side = *found;
        if (place_along > 0 && sides[start - along] == side) continue;  // within a step
        int length = 1;
        while (place_along + length < most_along && sides[start + length * along] == side) ++length;
        // To which side the silhouette goes on at either end: -1, 1, or 0.
        const auto turn = [&](int n) {
            if (place_along + n < 0 || place_along + n >= most_along) return 0;
            const std::ptrdiff_t at = start + n * along;
            if (place_across > 0 && sides[at - across] == side) return -1;
            return place_across + 1 < most_across && sides[at + across] == side ? 1 : 0;
        };
        const int before = turn(-1), after = turn(length), smoothed = std::min(length, longest);
        for (int n = 0; n < length; ++n) {
            // From half a pixel aside at an end to none in the middle; in halves of a pixel along.
            const int of_begin = smoothed - 2 * n - 1, of_end = smoothed - 2 * (length - n) + 1;
            const int share = std::max(of_begin, 0) * before + std::max(of_end, 0) * after;
            if (share == 0) continue;
            const std::ptrdiff_t at = start + n * along;
            PackedColour &first = colours[static_cast<std::size_t>(at)],
                         &second = colours[static_cast<std::size_t>(at + across)];
            if (share > 0)
                second = mixed(second, first, 128 * share / smoothed);
            else
                first = mixed(first, second, -128 * share / smoothed);
        }
    }
}

/// The first place with a side, or null.
const std::uint8_t* Silhouettes::find_side(const std::uint8_t* from, const std::uint8_t* end) {
    std::uint64_t eight = 0;
    while (from + 8 <= end && (std::memcpy(&eight, from, 8), eight == 0)) from += 8;
    while (from < end && *from == none) ++from;
    return from < end ? from : nullptr;
}

}  // namespace touchable
