// SPDX-License-Identifier: Apache-2.0
#include "engine/authoring/relief_filter.hpp"

#include <cmath>
#include <cstdlib>
#include <numeric>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

namespace {

/// Each blur goes on from the one before: variances, (side^2 - 1) / 12 of a box, add up.
constexpr std::array<std::array<int, 2>, DifferenceOfGaussians::bands + 1> box_sides{
    {{3, 1}, {5, 3}, {11, 9}, {23, 23}}};

/// Divides a sum over `side` numbers of 24 bits by `side` as a product: exact, since rounding this reciprocal
/// up adds less than sum / 2^38, which is less than 1 / side.
constexpr int reciprocal_bits = 38;
constexpr std::uint64_t reciprocal_of(int side) {
    return ((std::uint64_t{1} << reciprocal_bits) + static_cast<std::uint64_t>(side) - 1) /
           static_cast<std::uint64_t>(side);
}
inline std::int32_t rounded_share(std::uint32_t sum, std::uint32_t half, std::uint64_t reciprocal) {
    return static_cast<std::int32_t>(((sum + half) * reciprocal) >> reciprocal_bits);
}

constexpr int luma_per_level = 16;
/// Brightness of 255 at which shadow ends and highlight begins; weights change from the first to the second.
constexpr int shadow_from = 6, shadow_to = 24, highlight_from = 238, highlight_to = 253;
/// Neighbours whose depths differ by more than this share are two surfaces.
constexpr float step_share = 0.02F;
/// Colour bleeds over a step of depth by so many pixels on either side.
constexpr int bleeding = 2;

/// BT.601, in sixteenths of a level.
std::int32_t luma(const std::uint8_t* rgb) {
    return (77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2] + 8) / luma_per_level;
}

/// 0 up to `from`, 1 (most_weight) from `to` on, linear between.
std::int32_t ramp(std::int32_t value, std::int32_t from, std::int32_t to) {
    return std::clamp((value - from) * DifferenceOfGaussians::most_weight / (to - from), 0,
                      DifferenceOfGaussians::most_weight);
}

/// A hole is depth 0.
bool are_apart(float a, float b) {
    return std::fabs(a - b) > step_share * std::min(a, b);
}

/// Cuts a row or a column, whose pixels are `step` apart in memory, into runs of one surface each.
/// `at_end(k)`: pixel k is the last of one, and k + 1 the first of another.
template <class AtEnd>
void cut_line(const float* depths, std::ptrdiff_t step, int length, SurfaceRuns::Run* runs, AtEnd&& at_end) {
    for (int first = 0, k = 0; k < length; ++k) {
        const bool is_last = k + 1 == length;
        if (!is_last && !are_apart(depths[k * step], depths[(k + 1) * step])) continue;
        const SurfaceRuns::Run run{static_cast<std::int16_t>(first), static_cast<std::int16_t>(k)};
        for (; first <= k; ++first) runs[first * step] = run;
        if (!is_last) at_end(k);
    }
}

constexpr std::int32_t counts_from = DifferenceOfGaussians::most_weight / 2;

/// The number that `share` per mille of all do not exceed; nullopt for an empty histogram.
std::optional<std::int32_t> quantile(const std::vector<std::int64_t>& histogram, int share) {
    const std::int64_t all = std::accumulate(histogram.begin(), histogram.end(), std::int64_t{0});
    if (all == 0) return std::nullopt;
    std::int64_t passed = 0;
    for (std::size_t number = 0; number < histogram.size(); ++number) {
        passed += histogram[number];
        if (passed * 1000 >= all * share) return static_cast<std::int32_t>(number);
    }
    return std::nullopt;
}

constexpr std::int32_t per_code = 256, level = 128 * per_code, top = 255 * per_code;
/// A change that may be noise is taken on by this part with each frame.
constexpr std::int32_t slowness = 8;
/// A code stays while the height is within this of it: with half a code it would flicker between two.
constexpr std::int32_t stays_within = 3 * per_code / 4;

Result<void> check_relief_colour(const RawFrame& frame, const ClipReader& clip) {
    if (!frame.colour.empty()) return {};
    return input_error(clip.name() + ": frame " + std::to_string(frame.number) +
                       " has no colour, which relief is made of");
}

class ReliefReader final : public ChangedClip {
public:
    ReliefReader(std::unique_ptr<ClipReader> clip, const Scene& scene, const ReliefSettings& settings,
                 const ReliefRange& range, std::vector<std::string> notes)
        : ChangedClip(std::move(clip), scene),
          filter_(settings, scene.depth),
          heights_(range, settings.amount) {
        replace_track(PlaneRole::height, {"", "relief of colour", "gray", scene.width, scene.height, true});
        std::move(notes.begin(), notes.end(), std::back_inserter(notes_));
    }

    Result<std::optional<RawFrame>> next() override {
        auto frame = ReaderAround::next();
        if (frame && !*frame) add_flicker();
        if (!frame || !*frame) return frame;
        RawFrame& raw = **frame;
        TRY(check_relief_colour(raw, inner()));
        if (!before_ || !before_->is_before(raw) || raw.number != before_->number + 1) heights_.forget();
        before_.emplace(raw);
        Image image{scene_.width, scene_.height, 1, 1, heights_.next(filter_.apply(raw))};
        add_plane(raw, PlaneRole::height, plane_from(std::move(image), 8));
        return frame;
    }

    /// Relief needs colour.
    void leave_out_colour() override {}

private:
    ReliefFilter filter_;
    ReliefHeights heights_;
    std::optional<RawFrame::Place> before_;
    bool has_told_flicker_ = false;

    /// Adds a note after the last frame.
    void add_flicker() {
        const auto flicker = heights_.flicker();
        if (!flicker || has_told_flicker_) return;
        has_told_flicker_ = true;
        notes_.push_back("relief: where colour changes no more than by noise, heights change by " +
                         short_number(flicker->mean, 3) + " of 255 levels a frame, and " +
                         short_number(100 * flicker->more_than_one, 3) + " % of them by more than one");
    }
};

/// The strength of relief in the telling frames.
Result<ReliefRange> look(Prefetch& ahead, const ReliefSettings& settings) {
    ReliefFilter filter(settings, ahead.clip().scene().depth);
    ReliefEstimator estimator;
    std::optional<std::int64_t> newest;
    const auto add = [&](const RawFrame& frame) -> Result<void> {
        if (stop_requested()) return interrupted_error();
        TRY(check_relief_colour(frame, ahead.clip()));
        const NumberField& relief = filter.apply(frame);
        estimator.add(relief, filter.confidence(), newest && frame.number == *newest + 1);
        newest = frame.number;
        return {};
    };
    for (std::int64_t k = 0; k < first_frames; ++k) {
        TRY_ASSIGN(const auto frame, ahead.next());
        if (!frame) return estimator.range();
        TRY(add(*frame));
    }
    for (const std::int64_t wanted : telling_frames(ahead.clip().frame_count().value_or(0))) {
        if (wanted < first_frames) continue;
        const auto frame = ahead.at(wanted);
        if (!frame && frame.error().kind == ErrorKind::interrupted) return frame.error();
        if (!frame || !*frame) break;  // damaged: reading the clip reports it
        TRY(add(**frame));
    }
    return estimator.range();
}

/// Returns the scene with such heights, and adds notes about them.
Scene with_heights(Scene scene, double max_height, std::vector<std::string>& notes) {
    DepthCoding& depth = scene.depth;
    if (depth.kind == DepthCodingKind::metric && depth.near < 2 * max_height) {
        depth.near = 2 * max_height;
        derive_valid_range(depth);
        notes.push_back("depths below " + short_number(depth.near * scene.metres_per_unit * 1000, 3) +
                        " mm are taken for none, so that heights have room before the camera");
    }
    const double room = depth.nearest_depth() / 2;
    if (max_height > room)
        notes.push_back("heights reach half of the nearest depth, " +
                        short_number(room * scene.metres_per_unit * 1000, 3) +
                        " mm: more would leave no room before the camera");
    scene.height_coding = {std::min(max_height, room), HeightUnits::world, 255};
    return scene;
}

/// A note on the strength of relief, and whether it is mostly noise, or absent.
std::string range_in_words(const ReliefRange& range) {
    if (range.full <= 1)
        return "relief: nothing of it can be felt: colour is even, in deep shadow, in highlights, or not "
               "seen by its camera";
    const auto levels = [](std::int32_t number) { return short_number(number / 16.0, 3); };
    std::string words = "relief: the largest height stands for details of " + levels(range.full) +
                        " of 255 levels of brightness";
    if (!range.noise) return words;
    words += "; noise from frame to frame is " + levels(*range.noise);
    // 99 % of mere noise is within 2.6 deviations.
    if (range.full < 4 * *range.noise)
        words += ", so most of what is felt is noise: a smaller amount or height lessens it";
    return words;
}

}  // namespace

SurfaceRuns::SurfaceRuns(int columns, int rows) : width(columns), height(rows) {
    const auto pixels = pixel_count(columns, rows);
    across.assign(pixels, {0, static_cast<std::int16_t>(columns - 1)});
    down.assign(pixels, {0, static_cast<std::int16_t>(rows - 1)});
}

void BoxFilter::apply(NumberField& field, int side, const SurfaceRuns& runs) {
    if (side == 1) return;
    const int reach = side / 2, width = field.width, height = field.height;
    const auto half = static_cast<std::uint32_t>(reach);
    const std::uint64_t reciprocal = reciprocal_of(side);
    const auto columns = static_cast<std::size_t>(width);
    row_sums_.resize(columns + 1);
    column_sums_.resize(columns * (static_cast<std::size_t>(height) + 1));
    std::fill_n(column_sums_.begin(), columns, 0U);
    for (int y = 0; y < height; ++y) {
        const std::int32_t* from = field.row(y);
        for (std::size_t x = 0; x < columns; ++x)
            row_sums_[x + 1] = row_sums_[x] + static_cast<std::uint32_t>(from[x]);
        const SurfaceRuns::Run* run = runs.across.data() + static_cast<std::size_t>(y) * columns;
        const std::uint32_t* above = column_sums_.data() + static_cast<std::size_t>(y) * columns;
        std::uint32_t* below = column_sums_.data() + (static_cast<std::size_t>(y) + 1) * columns;
        for (int x = 0; x < width; ++x) {
            const int first = std::max(x - reach, static_cast<int>(run[x].first)),
                      last = std::min(x + reach, static_cast<int>(run[x].last));
            const std::uint32_t sum =
                row_sums_[static_cast<std::size_t>(last) + 1] - row_sums_[static_cast<std::size_t>(first)];
            below[x] = above[x] + static_cast<std::uint32_t>(rounded_share(sum, half, reciprocal));
        }
    }
    for (int y = 0; y < height; ++y) {
        const SurfaceRuns::Run* run = runs.down.data() + static_cast<std::size_t>(y) * columns;
        std::int32_t* to = field.row(y);
        for (int x = 0; x < width; ++x) {
            const int first = std::max(y - reach, static_cast<int>(run[x].first)),
                      last = std::min(y + reach, static_cast<int>(run[x].last));
            const std::uint32_t sum =
                column_sums_[(static_cast<std::size_t>(last) + 1) * columns + static_cast<std::size_t>(x)] -
                column_sums_[static_cast<std::size_t>(first) * columns + static_cast<std::size_t>(x)];
            to[x] = rounded_share(sum, half, reciprocal);
        }
    }
}

void DifferenceOfGaussians::blur(std::size_t step, const SurfaceRuns& runs) {
    for (const int side : box_sides[step]) {
        box_.apply(weighted_, side, runs);
        box_.apply(weights_, side, runs);
    }
    if (wider_.width != weights_.width || wider_.height != weights_.height)
        wider_ = NumberField(weights_.width, weights_.height);
    // With almost no weight the mean would be all rounding.
    constexpr std::int32_t least_weight = most_weight / 64;
    for (std::size_t k = 0; k < wider_.numbers.size(); ++k) {
        const std::int32_t weight = weights_.numbers[k];
        wider_.numbers[k] = weight < least_weight ? -1 : (weighted_.numbers[k] + weight / 2) / weight;
    }
}

void DifferenceOfGaussians::split(const NumberField& values, const NumberField& weights,
                                  const SurfaceRuns& runs) {
    weights_ = weights;
    weighted_ = values;
    for (std::size_t k = 0; k < weighted_.numbers.size(); ++k) weighted_.numbers[k] *= weights.numbers[k];
    blur(0, runs);
    std::swap(mean_, wider_);
    for (std::size_t step = 1; step < box_sides.size(); ++step) {
        blur(step, runs);
        if (step == 1) confidence_ = weights_;
        NumberField& band = bands_[step - 1];
        if (band.width != values.width || band.height != values.height)
            band = NumberField(values.width, values.height);
        for (std::size_t k = 0; k < band.numbers.size(); ++k) {
            const std::int32_t narrow = mean_.numbers[k], wide = wider_.numbers[k];
            band.numbers[k] = narrow < 0 || wide < 0 ? 0 : narrow - wide;
        }
        std::swap(mean_, wider_);
    }
}

void ReliefFilter::read_luma(const PlaneView& colour) {
    if (luma_.width != colour.width || luma_.height != colour.height) {
        luma_ = NumberField(colour.width, colour.height);
        weights_ = relief_ = luma_;
        runs_ = SurfaceRuns(colour.width, colour.height);
    }
    for (int y = 0; y < colour.height; ++y) {
        const std::uint8_t* rgb = colour.row(y);
        std::int32_t *luma_row = luma_.row(y), *weight_row = weights_.row(y);
        for (int x = 0; x < colour.width; ++x, rgb += 3) {
            luma_row[x] = luma(rgb);
            weight_row[x] =
                is_unseen_colour(rgb)
                    ? 0
                    : std::min(ramp(luma_row[x], shadow_from * luma_per_level, shadow_to * luma_per_level),
                               ramp(-luma_row[x], -highlight_to * luma_per_level,
                                    -highlight_from * luma_per_level));
        }
    }
}

/// Surfaces end at holes and steps of depth. Pixels to which colour may have bled over a step have no weight.
void ReliefFilter::part_surfaces(const RawFrame& frame) {
    const CodePicture codes = code_picture(frame.depth, depth_);
    const int width = codes.width, height = codes.height;
    std::vector<float> depths(codes.codes.size());
    for (std::size_t k = 0; k < depths.size(); ++k) {
        const bool is_hole = codes.codes[k] == CodePicture::invalid;
        depths[k] =
            is_hole ? 0.0F : static_cast<float>(depth_.depth(static_cast<std::uint16_t>(codes.codes[k])));
        if (is_hole) weights_.numbers[k] = 0;
    }
    /// Clears weights of columns [x0, x1) and rows [y0, y1), as far as the picture goes.
    const auto forget = [&](int x0, int x1, int y0, int y1) {
        for (int y = std::max(0, y0); y < std::min(height, y1); ++y)
            std::fill(weights_.row(y) + std::max(0, x0), weights_.row(y) + std::min(width, x1), 0);
    };
    for (int y = 0; y < height; ++y) {
        const std::size_t row = pixel_place(0, y, width);
        cut_line(&depths[row], 1, width, &runs_.across[row],
                 [&](int x) { forget(x + 1 - bleeding, x + 1 + bleeding, y + 1 - bleeding, y + bleeding); });
    }
    for (int x = 0; x < width; ++x)
        cut_line(&depths[static_cast<std::size_t>(x)], width, height,
                 &runs_.down[static_cast<std::size_t>(x)],
                 [&](int y) { forget(x + 1 - bleeding, x + bleeding, y + 1 - bleeding, y + 1 + bleeding); });
}

const NumberField& ReliefFilter::apply(const RawFrame& frame) {
    read_luma(frame.colour);
    part_surfaces(frame);
    split_.split(luma_, weights_, runs_);
    std::array<std::int32_t, 3> shares = settings_.bands;
    for (std::int32_t& share : shares) share *= settings_.invert ? -1 : 1;
    const NumberField& confidence = split_.confidence();
    for (std::size_t k = 0; k < relief_.numbers.size(); ++k) {
        const std::int32_t sum = shares[0] * split_.band(0).numbers[k] +
                                 shares[1] * split_.band(1).numbers[k] +
                                 shares[2] * split_.band(2).numbers[k];
        relief_.numbers[k] = static_cast<std::int32_t>(std::int64_t{sum} * confidence.numbers[k] /
                                                       (100 * DifferenceOfGaussians::most_weight));
    }
    return relief_;
}

void ReliefEstimator::add(const NumberField& relief, const NumberField& confidence, bool follows) {
    const auto count = [](std::vector<std::int64_t>& histogram, std::int32_t number) {
        ++histogram[std::min(static_cast<std::size_t>(std::abs(number)), most - 1)];
    };
    for (std::size_t k = 0; k < relief.numbers.size(); ++k) {
        if (confidence.numbers[k] < counts_from) continue;
        count(sizes_, relief.numbers[k]);
        if (follows) count(changes_, relief.numbers[k] - before_.numbers[k]);
    }
    before_ = relief;
}

ReliefRange ReliefEstimator::range() const {
    // Most of a picture does not move; the median of the changes there is 0.67 of sqrt(2) deviations.
    const std::optional<std::int32_t> change = quantile(changes_, 500), full = quantile(sizes_, 990);
    ReliefRange range{std::max(1, full.value_or(1))};
    if (change) range.noise = (*change * 105 + 99) / 100;
    return range;
}

const std::vector<std::uint8_t>& ReliefHeights::next(const NumberField& relief) {
    const auto target = [&](std::int32_t number) {
        const std::int64_t height =
            std::int64_t{number} * amount_ * (127 * per_code) / (std::int64_t{100} * range_.full);
        return static_cast<std::int32_t>(std::clamp<std::int64_t>(level + height, 0, top));
    };
    const std::int32_t gate = static_cast<std::int32_t>(
        std::min<std::int64_t>(std::int64_t{3} * range_.noise.value_or(0) * amount_ * (127 * per_code) /
                                   (std::int64_t{100} * range_.full),
                               top));
    const bool begins = states_.size() != relief.numbers.size();
    states_.resize(relief.numbers.size());
    codes_.resize(relief.numbers.size());
    for (std::size_t k = 0; k < states_.size(); ++k) {
        const std::int32_t wanted = target(relief.numbers[k]);
        std::int32_t& state = states_[k];
        const std::int32_t change = wanted - state, size = std::abs(change);
        if (begins || size >= 2 * gate)
            state = wanted;
        else if (size <= gate)
            state += change / slowness;
        else  // between both, without a jump
            state +=
                static_cast<std::int32_t>(std::int64_t{change} * ((size - gate) * (slowness - 1) + gate) /
                                          (std::int64_t{gate} * slowness));
        const std::uint8_t before = codes_[k];
        if (begins || std::abs(state - before * per_code) > stays_within)
            codes_[k] = static_cast<std::uint8_t>((state + per_code / 2) / per_code);
        if (begins || size > gate) continue;
        const int by = std::abs(codes_[k] - before);
        ++still_;
        changes_ += by;
        larger_ += by > 1 ? 1 : 0;
    }
    return codes_;
}

std::optional<ReliefHeights::Flicker> ReliefHeights::flicker() const {
    if (still_ == 0) return std::nullopt;
    const auto still = static_cast<double>(still_);
    return Flicker{static_cast<double>(changes_) / still, static_cast<double>(larger_) / still};
}

Result<LookedAt> look_at_relief(std::unique_ptr<ClipReader> clip, const ReliefSettings& settings) {
    Prefetch ahead(std::move(clip));
    TRY_ASSIGN(const auto range, look(ahead, settings));
    TRY_ASSIGN(auto again, ahead.finish());
    return LookedAt{std::move(again), range};
}

Result<std::unique_ptr<ClipReader>> with_relief(std::unique_ptr<ClipReader> clip,
                                                const ReliefSettings& settings, const ReliefRange& range,
                                                double max_height, std::vector<std::string> notes) {
    const Scene scene = with_heights(clip->scene(), max_height, notes);
    TRY(validate(scene));
    notes.push_back(range_in_words(range));
    return std::make_unique<ReliefReader>(std::move(clip), scene, settings, range, std::move(notes));
}

}  // namespace touchable
