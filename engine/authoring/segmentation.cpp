// SPDX-License-Identifier: Apache-2.0
#include "engine/authoring/segmentation.hpp"

#include <cstdlib>

#include "engine/authoring/regions.hpp"

namespace touchable {

/// A region of a frame that needs a label.
struct RegionLook {
    std::int64_t pixels = 0;
    std::int32_t x = 0, y = 0;                                               ///< mean place
    std::int32_t brightness = 0, red_green = 0, yellow_blue = 0, depth = 0;  ///< means
};

namespace {

/// Number of labels that are remembered, the newest.
constexpr std::size_t most_known = 512;
/// Alike: within 16 levels of colour and a fifth of the depth, and not twice as large.
constexpr std::int64_t colour_alike = 64 * 64, depth_alike = PixelFeatures::depth_per_octave / 4;
constexpr std::int64_t size_alike = 2;
/// And at most an eighth of the picture's diagonal away.
constexpr std::int64_t place_alike = 8;

std::int64_t colour_distance(const RegionLook& a, const RegionLook& b) {
    return squared(a.brightness - b.brightness) + squared(a.red_green - b.red_green) +
           squared(a.yellow_blue - b.yellow_blue);
}

/// Texture is the deviation from a mean over 9x9 pixels, all of one segment.
constexpr int blur_reach = 4, blur_side = 2 * blur_reach + 1;
/// Pixels; a place this far from other segments is inside.
constexpr int inside = 2;
constexpr std::int64_t outside = std::int64_t{1} << 40;  // farther than any place
constexpr std::uint32_t no_place = std::numeric_limits<std::uint32_t>::max();

struct FigureSums {
    std::int64_t pixels = 0, x = 0, y = 0, deviation = 0, textured = 0;
    std::array<std::int64_t, 3> colour{};
};

std::uint16_t label_at(const Segmentation& of, int x, int y) {
    return of.labels[pixel_place(x, y, of.width)];
}

/// Whether the square around a place, judged by its corners and the middles of its sides, is of one segment.
bool is_within(const Segmentation& of, int x, int y, int reach) {
    if (x < reach || y < reach || x >= of.width - reach || y >= of.height - reach) return false;
    for (int dy = -reach; dy <= reach; dy += reach)
        for (int dx = -reach; dx <= reach; dx += reach)
            if (label_at(of, x + dx, y + dy) != label_at(of, x, y)) return false;
    return true;
}

constexpr long usual_superpixels = 1500;
constexpr int smallest_side = 4;
constexpr std::int64_t smallest_permille = 2;  // of the picture's pixels; the smallest segment
constexpr long segmented_pixels_per_thread = 20000;
/// A pixel whose colour changed by more than 12 levels, or whose depth by 2 %, shows something else.
constexpr std::int32_t same_colour = 48, same_depth = 118;

/// Side of a superpixel's cell, so that there are at most about so many superpixels.
int side_for(long pixels, long superpixels) {
    int side = 1;
    while (long{side} * side * superpixels < pixels) ++side;
    return side;
}

int superpixel_side(const Scene& scene) {
    return std::max(side_for(long{scene.width} * scene.height, usual_superpixels), smallest_side);
}

std::int32_t smallest_segment(const Scene& scene) {
    return static_cast<std::int32_t>(
        std::max<std::int64_t>(1, std::int64_t{scene.width} * scene.height * smallest_permille / 1000));
}

}  // namespace

/// Gives regions their labels from frame to frame: the label that most of a region's pixels had, else that of
/// a similar region seen earlier near there, else a new one.
class LabelMemory {
public:
    LabelMemory(int width, int height) : width_(width), height_(height) {}

    /// Returns the labels of regions 0 to size - 1. `regions`: of each pixel, beyond the last: none.
    /// `labels`: of the last frame. `follows`: this frame follows it; else labels need a similar region.
    std::vector<std::uint16_t> name(const std::vector<RegionLook>& looks,
                                    const std::vector<std::uint16_t>& regions,
                                    const std::vector<std::uint16_t>& labels, bool follows) {
        ++frame_;
        std::vector<std::uint16_t> names(looks.size());
        for (Known& known : known_) known.is_taken = false;
        take_by_overlap(looks, regions, labels, follows, names);
        take_by_look(looks, names);
        // After 65,535 segments there are no more labels: new regions then have none.
        for (std::uint16_t& name : names)
            if (name == 0 && newest_ < std::numeric_limits<std::uint16_t>::max()) name = ++newest_;
        remember(looks, names);
        return names;
    }

private:
    struct Known {
        std::uint16_t label;
        RegionLook look;
        std::int64_t seen;  ///< number of the frame
        bool is_taken;
    };
    struct Pair {
        std::int64_t distance;  ///< the closest pair has the least
        std::size_t region, known;
        auto operator<=>(const Pair&) const = default;
    };
    /// Gives regions their paired labels, the closest pair first, if neither is taken.
    void take(std::vector<Pair>& pairs, std::vector<std::uint16_t>& names) {
        std::ranges::sort(pairs);
        for (const Pair& pair : pairs) {
            if (names[pair.region] != 0 || known_[pair.known].is_taken) continue;
            names[pair.region] = known_[pair.known].label;
            known_[pair.known].is_taken = true;
        }
    }

    /// Pairs regions with labels, most shared pixels first. Pairs share more than half of the smaller one.
    void take_by_overlap(const std::vector<RegionLook>& looks, const std::vector<std::uint16_t>& regions,
                         const std::vector<std::uint16_t>& labels, bool follows,
                         std::vector<std::uint16_t>& names) {
        constexpr std::uint32_t unknown = std::numeric_limits<std::uint32_t>::max();
        std::vector<std::uint32_t> place_of(std::size_t{newest_} + 1, unknown);
        for (std::size_t k = 0; k < known_.size(); ++k)
            place_of[known_[k].label] = static_cast<std::uint32_t>(k);
        std::vector<std::int64_t> shared(looks.size() * known_.size()), label_pixels(known_.size());
        for (std::size_t k = 0; k < labels.size(); ++k) {
            if (labels[k] == 0 || place_of[labels[k]] == unknown) continue;
            ++label_pixels[place_of[labels[k]]];
            if (regions[k] < looks.size()) ++shared[regions[k] * known_.size() + place_of[labels[k]]];
        }
        std::vector<Pair> pairs;
        for (std::size_t region = 0; region < looks.size(); ++region)
            for (std::size_t known = 0; known < known_.size(); ++known) {
                const std::int64_t both = shared[region * known_.size() + known];
                if (both * 2 > std::min(looks[region].pixels, label_pixels[known]) &&
                    (follows || are_alike(looks[region], known_[known].look)))
                    pairs.push_back({-both, region, known});
            }
        take(pairs, names);
    }

    void take_by_look(const std::vector<RegionLook>& looks, std::vector<std::uint16_t>& names) {
        std::vector<Pair> pairs;
        for (std::size_t region = 0; region < looks.size(); ++region)
            for (std::size_t known = 0; known < known_.size(); ++known) {
                const RegionLook &look = looks[region], &before = known_[known].look;
                if (names[region] == 0 && !known_[known].is_taken && are_alike(look, before))
                    pairs.push_back({squared(look.x - before.x) + squared(look.y - before.y) +
                                         colour_distance(look, before),
                                     region, known});
            }
        take(pairs, names);
    }

    bool are_alike(const RegionLook& a, const RegionLook& b) const {
        const std::int64_t away = squared(a.x - b.x) + squared(a.y - b.y);
        return colour_distance(a, b) <= colour_alike && std::abs(a.depth - b.depth) <= depth_alike &&
               std::max(a.pixels, b.pixels) <= size_alike * std::min(a.pixels, b.pixels) &&
               away * squared(place_alike) <= squared(width_) + squared(height_);
    }

    void remember(const std::vector<RegionLook>& looks, const std::vector<std::uint16_t>& names) {
        for (std::size_t region = 0; region < looks.size(); ++region) {
            if (names[region] == 0) continue;
            const auto at = std::ranges::lower_bound(known_, names[region], {}, &Known::label);
            if (at != known_.end() && at->label == names[region])
                *at = {names[region], looks[region], frame_, false};
            else
                known_.insert(at, {names[region], looks[region], frame_, false});
        }
        while (known_.size() > most_known) {
            const auto oldest = std::ranges::min_element(known_, {}, &Known::seen);
            if (oldest->seen == frame_) break;
            known_.erase(oldest);
        }
    }

    const int width_, height_;
    std::vector<Known> known_;  ///< by label, ascending
    std::uint16_t newest_ = 0;
    std::int64_t frame_ = 0;
};

/// Fills in `segments` from `labels` and their frame.
class SegmentFigures {
public:
    void find(const RawFrame& frame, Segmentation& of, RowBands& bands) {
        if (!frame.colour.empty()) find_deviations(frame.colour, of.width, of.height, bands);
        list_segments(of);
        find_means(frame.colour, of);
        find_middles(of);
        for (const Segment& segment : of.segments) place_of_[segment.label] = no_place;
    }

private:
    void find_deviations(const PlaneView& colour, int width, int height, RowBands& bands) {
        const auto pixels = pixel_count(width, height);
        brightness_.resize(pixels);
        deviations_.assign(pixels, 0);
        const auto row_of = [&](auto& plane, int y) { return plane.data() + pixel_place(0, y, width); };
        bands.for_each_band(height, 1, [&](const RowBand& band) {
            for (int y = band.first; y < band.last; ++y)
                for (int x = 0; x < width; ++x) {
                    const std::uint8_t* rgb = colour_at(colour, x, y, width, height);
                    row_of(brightness_, y)[x] =
                        static_cast<std::uint16_t>((77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2] + 8) / 16);
                }
        });
        bands.for_each_band(height, 1, [&](const RowBand& band) {
            std::vector<std::int32_t> columns(static_cast<std::size_t>(width));
            for (int y = std::max(band.first, blur_reach); y < std::min(band.last, height - blur_reach);
                 ++y) {
                std::fill(columns.begin(), columns.end(), 0);
                for (int from = y - blur_reach; from <= y + blur_reach; ++from)
                    for (int x = 0; x < width; ++x)
                        columns[static_cast<std::size_t>(x)] += row_of(brightness_, from)[x];
                std::int32_t sum = 0;
                for (int x = 0; x < width; ++x) {
                    sum += columns[static_cast<std::size_t>(x)];
                    if (x < blur_side - 1) continue;
                    const int middle = x - blur_reach;
                    row_of(deviations_, y)[middle] = static_cast<std::uint16_t>(
                        std::abs(row_of(brightness_, y)[middle] - sum / (blur_side * blur_side)));
                    sum -= columns[static_cast<std::size_t>(x - blur_side + 1)];
                }
            }
        });
    }

    /// Lists segments by label; `place_of_` has the index of each.
    void list_segments(Segmentation& of) {
        place_of_.resize(std::size_t{1} << 16, no_place);
        of.segments.clear();
        for (const std::uint16_t label : of.labels) {
            if (label == 0 || place_of_[label] != no_place) continue;
            place_of_[label] = 0;
            of.segments.push_back({label, 0, {}, 0, 0, 0});
        }
        std::ranges::sort(of.segments, {}, &Segment::label);
        for (std::size_t k = 0; k < of.segments.size(); ++k)
            place_of_[of.segments[k].label] = static_cast<std::uint32_t>(k);
    }

    /// Finds all figures, with the mean place.
    void find_means(const PlaneView& colour, Segmentation& of) const {
        const int width = of.width, height = of.height;
        std::vector<FigureSums> all(of.segments.size());
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint16_t label = label_at(of, x, y);
                if (label == 0) continue;
                FigureSums& sums = all[place_of_[label]];
                ++sums.pixels;
                sums.x += x;
                sums.y += y;
                if (colour.empty()) continue;
                const std::uint8_t* rgb = colour_at(colour, x, y, width, height);
                for (std::size_t c = 0; c < 3; ++c) sums.colour[c] += rgb[c];
                if (!is_within(of, x, y, blur_reach)) continue;
                ++sums.textured;
                sums.deviation += deviations_[pixel_place(x, y, width)];
            }
        for (std::size_t k = 0; k < all.size(); ++k) {
            const FigureSums& sums = all[k];
            Segment& segment = of.segments[k];
            segment.pixels = static_cast<std::int32_t>(sums.pixels);
            segment.x = static_cast<std::int32_t>(sums.x / sums.pixels);
            segment.y = static_cast<std::int32_t>(sums.y / sums.pixels);
            for (std::size_t c = 0; c < 3; ++c)
                segment.colour[c] =
                    static_cast<std::uint8_t>((sums.colour[c] + sums.pixels / 2) / sums.pixels);
            if (sums.textured > 0)
                segment.contrast =
                    static_cast<std::int32_t>((sums.deviation + sums.textured / 2) / sums.textured);
        }
    }

    /// Replaces the mean place by the nearest pixel of the segment, an inner one if there is any.
    void find_middles(Segmentation& of) const {
        struct Nearest {
            std::int64_t rank = std::numeric_limits<std::int64_t>::max();
            std::int32_t x = 0, y = 0;
        };
        std::vector<Nearest> all(of.segments.size());
        for (int y = 0; y < of.height; ++y)
            for (int x = 0; x < of.width; ++x) {
                const std::uint16_t label = label_at(of, x, y);
                if (label == 0) continue;
                Nearest& nearest = all[place_of_[label]];
                const Segment& segment = of.segments[place_of_[label]];
                const std::int64_t dx = x - segment.x, dy = y - segment.y, away = dx * dx + dy * dy;
                if (away >= nearest.rank) continue;
                const std::int64_t rank = away + (is_within(of, x, y, inside) ? 0 : outside);
                if (rank < nearest.rank) nearest = {rank, x, y};
            }
        for (std::size_t k = 0; k < all.size(); ++k) {
            of.segments[k].x = all[k].x;
            of.segments[k].y = all[k].y;
        }
    }

    std::vector<std::uint16_t> brightness_, deviations_;
    std::vector<std::uint32_t> place_of_;
};

/// What is known from frame to frame.
struct Segmenter {
    Segmenter(const Scene& scene, int threads)
        : bands(threads > 0 ? threads
                            : threads_for(long{scene.width} * scene.height, segmented_pixels_per_thread)),
          reader(scene),
          superpixels(scene.width, scene.height, superpixel_side(scene)),
          merging(scene.camera, smallest_segment(scene)),
          memory(scene.width, scene.height),
          smallest(smallest_segment(scene)) {
        out.width = scene.width;
        out.height = scene.height;
        out.labels.assign(superpixels.of_pixels().size(), 0);
        known.assign(out.labels.size(), 0);
    }

    /// Pixels that changed have no known label.
    void find_known(bool follows) {
        if (!follows || before.depth.size() != now.depth.size()) {
            std::fill(known.begin(), known.end(), std::uint16_t{0});
            return;
        }
        for (std::size_t k = 0; k < known.size(); ++k) {
            const bool is_same = std::abs(now.brightness[k] - before.brightness[k]) <= same_colour &&
                                 std::abs(now.red_green[k] - before.red_green[k]) <= same_colour &&
                                 std::abs(now.yellow_blue[k] - before.yellow_blue[k]) <= same_colour &&
                                 std::abs(now.depth[k] - before.depth[k]) <= same_depth;
            known[k] = is_same ? out.labels[k] : std::uint16_t{0};
        }
    }

    /// The label that most of a superpixel's pixels had, if that is more than half of them.
    std::vector<std::uint16_t> labels_of_superpixels() const {
        struct Vote {
            std::uint16_t label = 0;
            std::int32_t lead = 0, count = 0;
        };
        const std::vector<std::uint16_t>& of_pixels = superpixels.of_pixels();
        std::vector<Vote> votes(superpixels.all().size());
        for (std::size_t k = 0; k < of_pixels.size(); ++k) {
            if (of_pixels[k] == Superpixels::none) continue;
            Vote& vote = votes[of_pixels[k]];
            if (vote.lead == 0) vote.label = known[k];
            vote.lead += vote.label == known[k] ? 1 : -1;
        }
        for (std::size_t k = 0; k < of_pixels.size(); ++k)
            if (of_pixels[k] != Superpixels::none && votes[of_pixels[k]].label == known[k])
                ++votes[of_pixels[k]].count;
        std::vector<std::uint16_t> labels(votes.size());
        for (std::size_t k = 0; k < votes.size(); ++k)
            if (votes[k].count * 2 > superpixels.all()[k].pixels) labels[k] = votes[k].label;
        return labels;
    }

    void find_regions() {
        for (Superpixel& one : superpixels.all()) one.quantum = reader.quantum(one.depth);
        const std::vector<std::uint16_t>& of_superpixels =
            merging.merge(superpixels, labels_of_superpixels());
        const std::vector<std::uint16_t>& of_pixels = superpixels.of_pixels();
        regions.resize(of_pixels.size());
        for (std::size_t k = 0; k < regions.size(); ++k)
            regions[k] =
                of_pixels[k] == Superpixels::none ? RegionCleaning::none : of_superpixels[of_pixels[k]];
        cleaning.clean(regions, out.width, out.height,
                       std::max(2, superpixels.side() * superpixels.side() / 4));
        // Regions that are still too small, because of holes all around them, are no segments.
        std::vector<std::int32_t> pixels(std::size_t{1} << 16);
        for (const std::uint16_t region : regions) ++pixels[region];
        std::vector<std::uint16_t> dense(pixels.size(), RegionCleaning::none);
        region_count = 0;
        for (std::size_t region = 0; region < RegionCleaning::none; ++region)
            if (pixels[region] * 2 >= smallest && pixels[region] > 0)
                dense[region] = static_cast<std::uint16_t>(region_count++);
        for (std::uint16_t& region : regions) region = dense[region];
    }

    std::vector<RegionLook> looks() const {
        struct LookSums {
            std::int64_t x = 0, y = 0, brightness = 0, red_green = 0, yellow_blue = 0, depth = 0;
        };
        std::vector<RegionLook> looks(region_count);
        std::vector<LookSums> all(region_count);
        std::size_t k = 0;
        for (int y = 0; y < out.height; ++y)
            for (int x = 0; x < out.width; ++x, ++k) {
                if (regions[k] == RegionCleaning::none) continue;
                LookSums& sums = all[regions[k]];
                ++looks[regions[k]].pixels;
                sums.x += x, sums.y += y, sums.brightness += now.brightness[k];
                sums.red_green += now.red_green[k], sums.yellow_blue += now.yellow_blue[k];
                sums.depth += now.depth[k];
            }
        for (std::size_t region = 0; region < region_count; ++region) {
            const LookSums& sums = all[region];
            RegionLook& look = looks[region];
            const auto mean = [&](std::int64_t sum) { return static_cast<std::int32_t>(sum / look.pixels); };
            look.x = mean(sums.x), look.y = mean(sums.y), look.brightness = mean(sums.brightness);
            look.red_green = mean(sums.red_green), look.yellow_blue = mean(sums.yellow_blue);
            look.depth = mean(sums.depth);
        }
        return looks;
    }

    void label(bool follows) {
        const std::vector<std::uint16_t> names = memory.name(looks(), regions, out.labels, follows);
        for (std::size_t k = 0; k < regions.size(); ++k)
            out.labels[k] = regions[k] == RegionCleaning::none ? std::uint16_t{0} : names[regions[k]];
        // A superpixel takes the label at its middle.
        for (Superpixel& one : superpixels.all()) {
            const std::size_t middle = now.place(one.x, one.y);
            one.label = one.pixels > 0 ? out.labels[middle] : std::uint16_t{0};
        }
    }

    const Segmentation& next(const RawFrame& frame, bool follows) {
        std::swap(now, before);
        reader.read(frame, now, bands);
        find_known(follows);
        if (!follows) superpixels.forget();
        superpixels.divide(now, known, bands);
        find_regions();
        label(follows);
        figures.find(frame, out, bands);
        return out;
    }

    RowBands bands;
    FeatureReader reader;
    PixelFeatures now, before;
    Superpixels superpixels;
    RegionMerging merging;
    RegionCleaning cleaning;
    LabelMemory memory;
    SegmentFigures figures;
    std::int32_t smallest;
    std::vector<std::uint16_t> known, regions;  // by pixel: label in the last frame; region, dense
    std::size_t region_count = 0;
    Segmentation out;
};

SegmentFrames follow_segments(const Scene& scene, int threads) {
    return [segmenter = std::make_shared<Segmenter>(scene, threads)](const RawFrame& frame,
                                                                     bool follows) -> const Segmentation& {
        return segmenter->next(frame, follows);
    };
}

SegmentFrames begin_segments(const Scene& scene) {
    return follow_segments(scene);
}

}  // namespace touchable
