#include "engine/authoring/label_memory.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <tuple>

namespace touchable {
namespace {

/// Of what was seen before, so many are remembered, the newest.
constexpr std::size_t most_known = 512;
/// Alike: within 16 levels of colour and a fifth of the depth, and not twice as large.
constexpr std::int64_t colour_alike = 64 * 64, depth_alike = PixelFeatures::depth_per_octave / 4;
constexpr std::int64_t size_alike = 2;
/// And an eighth of the picture away at most.
constexpr std::int64_t place_alike = 8;

std::int64_t colour_distance(const RegionLook& a, const RegionLook& b) {
    return squared(a.brightness - b.brightness) + squared(a.red_green - b.red_green) +
           squared(a.yellow_blue - b.yellow_blue);
}

}  // namespace

bool LabelMemory::are_alike(const RegionLook& a, const RegionLook& b) const {
    const std::int64_t away = squared(a.x - b.x) + squared(a.y - b.y);
    return colour_distance(a, b) <= colour_alike && std::abs(a.depth - b.depth) <= depth_alike &&
           std::max(a.pixels, b.pixels) <= size_alike * std::min(a.pixels, b.pixels) &&
           away * squared(place_alike) <= squared(width_) + squared(height_);
}

/// Pairs of a region and a label, those that share most pixels first. A pair has to share more than half of
/// the smaller one.
void LabelMemory::take_by_overlap(const std::vector<RegionLook>& looks,
                                  const std::vector<std::uint16_t>& regions,
                                  const std::vector<std::uint16_t>& labels, bool follows,
                                  std::vector<std::uint16_t>& names) {
    constexpr std::uint32_t unknown = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> place_of(std::size_t{newest_} + 1, unknown);
    for (std::size_t k = 0; k < known_.size(); ++k) place_of[known_[k].label] = static_cast<std::uint32_t>(k);
    std::vector<std::int64_t> shared(looks.size() * known_.size()), label_pixels(known_.size());
    for (std::size_t k = 0; k < labels.size(); ++k) {
        if (labels[k] == 0 || place_of[labels[k]] == unknown) continue;
        ++label_pixels[place_of[labels[k]]];
        if (regions[k] < looks.size()) ++shared[regions[k] * known_.size() + place_of[labels[k]]];
    }
    struct Pair {
        std::int64_t shared;
        std::size_t region, known;
    };
    std::vector<Pair> pairs;
    for (std::size_t region = 0; region < looks.size(); ++region)
        for (std::size_t known = 0; known < known_.size(); ++known) {
            const std::int64_t both = shared[region * known_.size() + known];
            if (both * 2 > std::min(looks[region].pixels, label_pixels[known]) &&
                (follows || are_alike(looks[region], known_[known].look)))
                pairs.push_back({both, region, known});
        }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
        return std::tie(b.shared, a.region, a.known) < std::tie(a.shared, b.region, b.known);
    });
    for (const Pair& pair : pairs) {
        if (names[pair.region] != 0 || known_[pair.known].is_taken) continue;
        names[pair.region] = known_[pair.known].label;
        known_[pair.known].is_taken = true;
    }
}

void LabelMemory::take_by_look(const std::vector<RegionLook>& looks, std::vector<std::uint16_t>& names) {
    struct Pair {
        std::int64_t away;
        std::size_t region, known;
    };
    std::vector<Pair> pairs;
    for (std::size_t region = 0; region < looks.size(); ++region)
        for (std::size_t known = 0; known < known_.size(); ++known) {
            const RegionLook &look = looks[region], &before = known_[known].look;
            if (names[region] == 0 && !known_[known].is_taken && are_alike(look, before))
                pairs.push_back(
                    {squared(look.x - before.x) + squared(look.y - before.y) + colour_distance(look, before),
                     region, known});
        }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
        return std::tie(a.away, a.region, a.known) < std::tie(b.away, b.region, b.known);
    });
    for (const Pair& pair : pairs) {
        if (names[pair.region] != 0 || known_[pair.known].is_taken) continue;
        names[pair.region] = known_[pair.known].label;
        known_[pair.known].is_taken = true;
    }
}

void LabelMemory::remember(const std::vector<RegionLook>& looks, const std::vector<std::uint16_t>& names) {
    for (std::size_t region = 0; region < looks.size(); ++region) {
        if (names[region] == 0) continue;
        const auto at =
            std::lower_bound(known_.begin(), known_.end(), names[region],
                             [](const Known& one, std::uint16_t label) { return one.label < label; });
        if (at != known_.end() && at->label == names[region])
            *at = {names[region], looks[region], frame_, false};
        else
            known_.insert(at, {names[region], looks[region], frame_, false});
    }
    while (known_.size() > most_known) {
        const auto oldest = std::min_element(known_.begin(), known_.end(),
                                             [](const Known& a, const Known& b) { return a.seen < b.seen; });
        if (oldest->seen == frame_) break;
        known_.erase(oldest);
    }
}

std::vector<std::uint16_t> LabelMemory::name(const std::vector<RegionLook>& looks,
                                             const std::vector<std::uint16_t>& regions,
                                             const std::vector<std::uint16_t>& labels, bool follows) {
    ++frame_;
    std::vector<std::uint16_t> names(looks.size());
    for (Known& known : known_) known.is_taken = false;
    take_by_overlap(looks, regions, labels, follows, names);
    take_by_look(looks, names);
    // After 65,535 segments there are no more labels: what is new then has none.
    for (std::uint16_t& name : names)
        if (name == 0 && newest_ < std::numeric_limits<std::uint16_t>::max()) name = ++newest_;
    remember(looks, names);
    return names;
}

}  // namespace touchable
