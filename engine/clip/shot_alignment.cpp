// SPDX-License-Identifier: Apache-2.0
// Frames as cells, robust lines through pairs of their depths, and from these one scale for each shot.
#include "engine/clip/shot_alignment.hpp"

#include <cstdlib>
#include <numeric>

#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

constexpr int usual_cells = 4800, least_side = 4;
/// A cell whose codes differ by more than 1/8 of the frame's range holds two surfaces.
constexpr int two_surfaces_share = 8;
constexpr int least_texture = 24;  // levels of brightness, from the darkest pixel to the brightest

int side_of_cells(int width, int height) {
    int side = least_side;
    while ((width / side) * (height / side) > usual_cells) ++side;
    return side;
}

struct CellDepths {
    std::int64_t sum = 0;
    std::int32_t least = std::numeric_limits<std::int32_t>::max(), most = 0;
    bool is_whole = true;
};

template <class Sample>
CellDepths depths_of(const PlaneView& plane, const DepthCoding& coding, int x0, int y0, int side) {
    CellDepths depths;
    for (int y = y0; y < y0 + side; ++y) {
        const auto* row = reinterpret_cast<const Sample*>(plane.row(y)) + x0;
        for (int x = 0; x < side; ++x) {
            const std::int32_t code = row[x];
            depths.sum += code;
            depths.least = std::min(depths.least, code);
            depths.most = std::max(depths.most, code);
        }
    }
    if (coding.all_valid(static_cast<std::uint16_t>(depths.least), static_cast<std::uint16_t>(depths.most)))
        return depths;
    // A pixel has no depth: the others still give the frame's range.
    depths = {.is_whole = false};
    for (int y = y0; y < y0 + side; ++y)
        for (int x = x0; x < x0 + side; ++x)
            if (const std::uint16_t code = plane.sample(x, y); coding.is_valid(code)) {
                depths.least = std::min<std::int32_t>(depths.least, code);
                depths.most = std::max<std::int32_t>(depths.most, code);
            }
    return depths;
}

void read_luma(const PlaneView& colour, int x0, int y0, int side, CellPicture::Cell& cell) {
    std::int64_t sum = 0;
    std::int32_t least = std::numeric_limits<std::int32_t>::max(), most = 0;
    for (int y = y0; y < y0 + side; ++y) {
        const std::uint8_t* rgb = colour.row(y) + 3 * std::ptrdiff_t{x0};
        for (int x = 0; x < side; ++x, rgb += 3) {
            const std::int32_t luma = 77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2];  // 256 per level
            sum += luma;
            least = std::min(least, luma);
            most = std::max(most, luma);
        }
    }
    cell.luma = static_cast<std::int32_t>(sum * CellPicture::per_level / (256 * std::int64_t{side} * side));
    cell.is_textured = most - least >= 256 * least_texture;
}

/// Marks cells beside much darker or brighter ones, which change too if anything moves.
void mark_borders(std::vector<CellPicture::Cell>& cells, int columns) {
    constexpr std::int32_t step = least_texture * CellPicture::per_level;
    const auto across = static_cast<std::size_t>(columns);
    const auto part = [&](CellPicture::Cell& a, CellPicture::Cell& b) {
        if (a.luma - b.luma >= step || b.luma - a.luma >= step) a.is_textured = b.is_textured = true;
    };
    for (std::size_t k = 0; k < cells.size(); ++k) {
        if (k % across + 1 < across) part(cells[k], cells[k + 1]);
        if (k + across < cells.size()) part(cells[k], cells[k + across]);
    }
}

constexpr std::size_t fewest_points = 8, judging_points = 256;
constexpr int pair_trials = 96, refinements = 6;
constexpr double per_median = 1.4826;  // standard deviation of normal noise / median distance
constexpr double most_scale = 16;      // its reciprocal is the least
constexpr double least_spread = 16;    // of `from`, times the noise: below it no scale is fitted

constexpr double steps_of_range = 4096;  // smaller differences are noise
constexpr std::int32_t same_luma = 5 * CellPicture::per_level / 2, other_luma = 24 * CellPicture::per_level;
constexpr double share_of_cut = 0.5;  // share of cells that change brightness at a cut
constexpr double noise_of_cut = 0.1;  // fit noise at a cut, share of the range
constexpr double noise_of_still = 1.0 / 64;
constexpr double still_frames = 0.9;        // share of a shot that makes it a still one
constexpr std::size_t telling_texture = 6;  // one cell in this many must be textured to show motion
constexpr int settled_age = 4, calm_frames = 24;
constexpr double reference_frames = 32;  // frames over which a reference is averaged
constexpr int moving_radius = 15;        // frames before and after, if the camera moves
constexpr std::size_t most_resting = 96;

/// The median, the lower of two; reorders `numbers`.
double median_of(std::vector<double>& numbers) {
    return sorted_element(numbers, (numbers.size() - 1) / 2);
}

/// Random numbers that are the same on every machine.
class PairDraw {
public:
    std::size_t below(std::size_t count) {
        state_ = state_ * 6364136223846793005U + 1442695040888963407U;
        return static_cast<std::size_t>((state_ >> 33) % count);
    }

private:
    std::uint64_t state_ = 88172645463325252U;
};

class MedianFit {
public:
    MedianFit(const std::vector<LinePoint>& points, double least_noise)
        : points_(points), least_noise_(least_noise) {
        std::vector<double> from;
        from.reserve(points.size());
        for (const LinePoint& point : points) from.push_back(point.from);
        spread_ =
            sorted_element(from, from.size() - 1 - from.size() / 10) - sorted_element(from, from.size() / 10);
    }
    LineFit make() {
        LineFit fit;
        fit.line = has_scale() ? by_pairs() : shifted();
        for (int k = 0; k < refinements; ++k) {
            fit.noise = noise_of(fit.line);
            fit.line = refined(fit.line, fit.noise);
        }
        fit.noise = noise_of(fit.line);
        return fit;
    }

private:
    static double distance(const Line& line, const LinePoint& point) {
        return std::abs(point.to - line.at(point.from));
    }
    bool has_scale() const { return spread_ > least_spread * least_noise_; }
    double noise_of(const Line& line) const {
        std::vector<double> distances;
        distances.reserve(points_.size());
        for (const LinePoint& point : points_) distances.push_back(distance(line, point));
        return std::max(least_noise_, per_median * median_of(distances));
    }
    /// The median line of scale 1.
    Line shifted() const {
        std::vector<double> shifts;
        shifts.reserve(points_.size());
        for (const LinePoint& point : points_) shifts.push_back(point.to - point.from);
        return {1, median_of(shifts)};
    }
    /// The line with the least median distance.
    Line by_pairs() const {
        PairDraw draw;
        const std::size_t step = std::max<std::size_t>(1, points_.size() / judging_points);
        Line best = shifted();
        double least = -1;
        std::vector<double> distances;
        for (int trial = 0, tried = 0; trial < pair_trials && tried < 8 * pair_trials; ++tried) {
            const LinePoint &a = points_[draw.below(points_.size())],
                            &b = points_[draw.below(points_.size())];
            if (std::abs(a.from - b.from) < spread_ / 4) continue;
            ++trial;
            Line line;
            line.scale = (a.to - b.to) / (a.from - b.from);
            if (!(line.scale >= 1 / most_scale && line.scale <= most_scale)) continue;
            line.shift = a.to - line.scale * a.from;
            distances.clear();
            for (std::size_t k = 0; k < points_.size(); k += step)
                distances.push_back(distance(line, points_[k]));
            const double middle = median_of(distances);
            if (least >= 0 && middle >= least) continue;
            least = middle;
            best = line;
        }
        return best;
    }
    /// Least squares, weighted by 1/(1 + (distance / two noises)^2)^2: outliers do not count.
    Line refined(const Line& line, double noise) const {
        double weights = 0, from = 0, to = 0;
        std::vector<double> each;
        each.reserve(points_.size());
        for (const LinePoint& point : points_) {
            const double share = distance(line, point) / (2 * noise), fall = 1 + share * share;
            const double weight = 1 / (fall * fall);
            each.push_back(weight);
            weights += weight;
            from += weight * point.from;
            to += weight * point.to;
        }
        if (!has_scale()) return {1, (to - from) / weights};
        const double middle = from / weights, height = to / weights;
        double together = 0, alone = 0;
        for (std::size_t k = 0; k < points_.size(); ++k) {
            const double x = points_[k].from - middle;
            together += each[k] * x * (points_[k].to - height);
            alone += each[k] * x * x;
        }
        const double scale = together / alone;
        if (!(scale >= 1 / most_scale && scale <= most_scale)) return line;
        return {scale, height - scale * middle};
    }

    const std::vector<LinePoint>& points_;
    double least_noise_, spread_ = 0;
};

/// Which cells kept their brightness, `before`(k), up to a common gain; CellPicture::none if unknown.
template <class Before>
std::vector<bool> unchanged(const CellPicture& picture, Before&& before) {
    std::vector<std::int32_t> changes;
    for (std::size_t k = 0; k < picture.cells.size(); ++k)
        if (before(k) != CellPicture::none) changes.push_back(picture.cells[k].luma - before(k));
    // The median gain in brightness: a change of the camera's exposure.
    const std::int32_t gain = changes.empty() ? 0 : sorted_element(changes, changes.size() / 2);
    std::vector<bool> same(picture.cells.size(), true);
    for (std::size_t k = 0; k < same.size(); ++k)
        same[k] =
            before(k) != CellPicture::none && std::abs(picture.cells[k].luma - before(k) - gain) <= same_luma;
    return same;
}

double mean_of(const std::vector<double>& numbers) {
    return std::accumulate(numbers.begin(), numbers.end(), 0.0) / static_cast<double>(numbers.size());
}

/// Rejects lines that a chain through frames with nothing in common can lead to.
bool is_likely(const Line& line) {
    constexpr double most_scale_of_all = 64, most_shift = 1e8;
    return line.scale >= 1 / most_scale_of_all && line.scale <= most_scale_of_all &&
           line.shift >= -most_shift && line.shift <= most_shift;
}

/// Value at place 0 of the regression line through numbers at places first, first + 1, ...
double regressed_at_zero(const std::vector<double>& numbers, double first) {
    const double middle = first + (static_cast<double>(numbers.size()) - 1) / 2, mean = mean_of(numbers);
    double together = 0, alone = 0;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        const double place = first + static_cast<double>(k) - middle;
        together += place * numbers[k];
        alone += place * place;
    }
    return alone > 0 ? mean - together / alone * middle : mean;
}

}  // namespace

CellPicture cell_picture(const RawFrame& frame, const DepthCoding& coding) {
    const PlaneView& plane = frame.depth;
    const int side = std::min({side_of_cells(plane.width, plane.height), plane.width, plane.height});
    const int columns = plane.width / side, rows = plane.height / side;
    CellPicture picture;
    picture.has_colour =
        !frame.colour.empty() && frame.colour.width == plane.width && frame.colour.height == plane.height;
    picture.cells.resize(pixel_count(columns, rows));
    std::vector<std::int32_t> spreads(picture.cells.size());
    std::int32_t least = std::numeric_limits<std::int32_t>::max(), most = -1;
    for (std::size_t k = 0; k < picture.cells.size(); ++k) {
        const int x = side * (static_cast<int>(k) % columns), y = side * (static_cast<int>(k) / columns);
        const CellDepths depths = plane.bytes_per_sample == 1
                                      ? depths_of<std::uint8_t>(plane, coding, x, y, side)
                                      : depths_of<std::uint16_t>(plane, coding, x, y, side);
        CellPicture::Cell& cell = picture.cells[k];
        if (depths.most >= depths.least) {
            least = std::min(least, depths.least);
            most = std::max(most, depths.most);
            spreads[k] = depths.most - depths.least;
        }
        if (depths.is_whole)
            cell.depth =
                static_cast<std::int32_t>(depths.sum * CellPicture::per_code / (std::int64_t{side} * side));
        if (picture.has_colour) read_luma(frame.colour, x, y, side, cell);
    }
    if (picture.has_colour) mark_borders(picture.cells, columns);
    if (most < least) return picture;
    picture.least = static_cast<std::uint16_t>(least);
    picture.most = static_cast<std::uint16_t>(most);
    for (std::size_t k = 0; k < picture.cells.size(); ++k)
        if (two_surfaces_share * spreads[k] > most - least + 2 * two_surfaces_share)
            picture.cells[k].depth = CellPicture::none;
    return picture;
}

std::optional<LineFit> fit_line(const std::vector<LinePoint>& points, double least_noise) {
    if (points.size() < fewest_points) return std::nullopt;
    return MedianFit(points, least_noise).make();
}

/// Share of the cells that are much brighter or darker than before.
double ShotAlignment::changed(const CellPicture& picture) const {
    if (!picture.has_colour) return 0;
    std::size_t others = 0;
    for (std::size_t k = 0; k < picture.cells.size(); ++k)
        others += std::abs(picture.cells[k].luma - before_.cells[k].luma) > other_luma;
    return static_cast<double>(others) / static_cast<double>(picture.cells.size());
}

/// Fits cells of unchanged colour, or all cells if those are few.
LineFit ShotAlignment::fit_to_before(const CellPicture& picture, RestingCells& resting) {
    std::vector<bool> same(picture.cells.size(), true);
    if (picture.has_colour) same = unchanged(picture, [&](std::size_t k) { return before_.cells[k].luma; });
    std::vector<LinePoint> all, still;
    for (std::size_t k = 0; k < same.size(); ++k) {
        const CellPicture::Cell &now = picture.cells[k], &then = before_.cells[k];
        if (now.depth == CellPicture::none || then.depth == CellPicture::none) continue;
        all.push_back({static_cast<double>(now.depth), static_cast<double>(then.depth)});
        if (same[k]) still.push_back(all.back());
    }
    const bool is_enough = 4 * still.size() >= all.size();
    const auto fit = fit_line(is_enough ? still : all, least_noise_);
    if (!fit) return {};
    if (!is_enough) return *fit;
    const std::size_t step = still.size() / most_resting + 1;
    for (std::size_t k = 0; k < still.size(); k += step) {
        const double apart = still[k].to - fit->line.at(still[k].from);
        if (std::fabs(apart) > 3 * fit->noise) continue;
        const double moved = still[k].to - still[k].from;
        moved_ += moved * moved / (range_ * range_);
        unexplained_ += apart * apart / (range_ * range_);
        ++pairs_;
        resting.emplace_back(static_cast<std::int32_t>(still[k].to),
                             static_cast<std::int32_t>(still[k].from));
    }
    return *fit;
}

/// Still if many cells have the reference's colour, and the depths of most of them lie on one line.
void ShotAlignment::fit_to_shot(const CellPicture& picture, Fitted& fitted) {
    std::vector<bool> same(picture.cells.size(), true);
    if (picture.has_colour)
        same = unchanged(picture,
                         [&](std::size_t k) { return static_cast<std::int32_t>(references_[k].luma + 0.5); });
    const int long_calm = std::min(static_cast<int>(shot_.size()), calm_frames) / 2;
    std::size_t known = 0, textured = 0, calm = 0;
    std::vector<LinePoint> settled, any;
    for (std::size_t k = 0; k < same.size(); ++k) {
        const Reference& reference = references_[k];
        const CellPicture::Cell& cell = picture.cells[k];
        if (reference.age < 0 || cell.depth == CellPicture::none) continue;
        ++known;
        textured += cell.is_textured;
        calm += cell.is_textured && same[k] && reference.calm >= long_calm;
        if (!same[k]) continue;
        any.push_back({static_cast<double>(cell.depth), reference.depth});
        if (reference.age >= settled_age) settled.push_back(any.back());
    }
    const bool are_settled = 4 * settled.size() >= known;
    const auto fit = fit_line(are_settled ? settled : any, least_noise_);
    const bool camera_moves = telling_texture * textured >= known && 2 * calm < textured;
    fitted.is_still =
        fit && !camera_moves && 4 * any.size() >= known && fit->noise <= noise_of_still * range_;
    fitted.to_shot = fitted.is_still ? fit->line : fitted.to_before.then(shot_.back().to_shot);
    if (!is_likely(fitted.to_shot)) fitted.to_shot = {};
    const double noise = fit ? fit->noise : least_noise_;
    remember(picture, same, fitted.to_shot, 4 * std::min(noise, noise_of_still * range_));
}

/// Averages cells that stay the same, and begins anew those with new content.
void ShotAlignment::remember(const CellPicture& picture, const std::vector<bool>& same, const Line& line,
                             double tolerance) {
    for (std::size_t k = 0; k < picture.cells.size(); ++k) {
        const CellPicture::Cell& cell = picture.cells[k];
        Reference& reference = references_[k];
        reference.calm = same[k] ? reference.calm + 1 : 0;
        reference.luma =
            same[k] ? reference.luma + (cell.luma - reference.luma) / reference_frames : cell.luma;
        if (cell.depth == CellPicture::none) continue;
        const double depth = line.at(cell.depth), apart = depth - reference.depth;
        const bool stays = same[k] && reference.age >= 0 && std::fabs(apart) <= tolerance;
        reference.depth = stays ? reference.depth + apart / reference_frames : depth;
        reference.age = stays ? reference.age + 1 : 0;
    }
}

void ShotAlignment::begin_shot(const CellPicture& picture) {
    end_shot();
    range_ = std::max(1.0, static_cast<double>(picture.most - picture.least) * CellPicture::per_code);
    least_noise_ = std::max(1.0, range_ / steps_of_range);
    references_.assign(picture.cells.size(), {});
    remember(picture, std::vector<bool>(picture.cells.size()), {}, 0);
    shot_.push_back({{}, {}, true});
    resting_.emplace_back();
}

/// Lines whose mean leaves codes as they are.
std::vector<Line> ShotAlignment::lines_of_still() const {
    std::vector<double> scales, shifts;
    for (const Fitted& fitted : shot_) {
        const Line back = fitted.to_shot.inverse();
        scales.push_back(back.scale);
        shifts.push_back(back.shift);
    }
    const Line mean{mean_of(scales), mean_of(shifts)};
    std::vector<Line> lines;
    for (const Fitted& fitted : shot_) lines.push_back(fitted.to_shot.then(mean));
    return lines;
}

/// For each frame: a straight line through the scales of the frames around it, relative to its own.
std::vector<Line> ShotAlignment::lines_of_moving() const {
    std::vector<Line> lines;
    const auto count = static_cast<std::ptrdiff_t>(shot_.size());
    const auto fitted = [&](std::ptrdiff_t k) -> const Fitted& { return shot_[static_cast<std::size_t>(k)]; };
    for (std::ptrdiff_t n = 0; n < count; ++n) {
        const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, n - moving_radius),
                             last = std::min(count - 1, n + moving_radius);
        std::vector<double> scales(static_cast<std::size_t>(last - first + 1)), shifts(scales.size());
        const auto put = [&](std::ptrdiff_t k, const Line& there) {
            scales[static_cast<std::size_t>(k - first)] = there.scale;
            shifts[static_cast<std::size_t>(k - first)] = there.shift;
        };
        put(n, {});
        Line there;
        for (std::ptrdiff_t k = n; k > first; --k) put(k - 1, there = there.then(fitted(k).to_before));
        there = {};
        for (std::ptrdiff_t k = n + 1; k <= last; ++k)
            put(k, there = there.then(fitted(k).to_before.inverse()));
        const auto place = static_cast<double>(first - n);
        lines.push_back({regressed_at_zero(scales, place), regressed_at_zero(shifts, place)});
    }
    return lines;
}

void ShotAlignment::end_shot() {
    if (shot_.empty()) return;
    ++shots_;
    const auto count = static_cast<double>(shot_.size());
    const auto still =
        static_cast<double>(std::ranges::count_if(shot_, [](const Fitted& f) { return f.is_still; }));
    const bool is_still = still >= still_frames * count;
    still_shots_ += is_still;
    for (const Line& line : is_still ? lines_of_still() : lines_of_moving())
        lines_.push_back(is_likely(line) ? line : Line{});
    shot_.clear();
}

void ShotAlignment::add(CellPicture picture) {
    const bool is_alike =
        before_.cells.size() == picture.cells.size() && before_.has_colour == picture.has_colour;
    const double other_colour = shot_.empty() || !is_alike ? 1 : changed(picture);
    RestingCells resting;
    const LineFit to_before = other_colour > share_of_cut ? LineFit{} : fit_to_before(picture, resting);
    const bool depth_is_other =
        to_before.noise > noise_of_cut * range_ && (!picture.has_colour || other_colour > share_of_cut / 2);
    if (other_colour > share_of_cut || depth_is_other) {
        begin_shot(picture);
    } else {
        Fitted fitted{{}, to_before.line, false};
        fit_to_shot(picture, fitted);
        shot_.push_back(fitted);
        resting_.push_back(std::move(resting));
    }
    before_ = std::move(picture);
}

std::vector<Line> ShotAlignment::finish() {
    end_shot();
    return std::move(lines_);
}

}  // namespace touchable
