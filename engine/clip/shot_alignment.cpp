#include "engine/clip/shot_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace touchable {
namespace {

constexpr double steps_of_range = 4096;  // differences below one tell nothing
constexpr std::int32_t same_luma = 5 * Cell::per_level / 2, other_luma = 24 * Cell::per_level;
constexpr double share_of_cut = 0.5;  // of the cells have another brightness then
constexpr double noise_of_cut = 0.1;  // of the range, without colour
constexpr double noise_of_still = 1.0 / 64;
constexpr double still_frames = 0.9;        // of a shot, in which things stand still
constexpr std::size_t telling_texture = 6;  // of so many cells one must be textured to tell of the camera
constexpr int settled_age = 4, calm_frames = 24;
constexpr double memory = 32;  // frames over which a reference is averaged
constexpr int radius = 15;     // frames before and after, of a moving camera
constexpr std::size_t most_resting = 96;

std::int32_t size_of(std::int32_t number) {
    return number < 0 ? -number : number;
}

/// Brightness that all cells gained: a camera's exposure.
std::int32_t gained(std::vector<std::int32_t> changes) {
    if (changes.empty()) return 0;
    const auto middle = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 2);
    std::nth_element(changes.begin(), middle, changes.end());
    return *middle;
}

/// Which cells have the brightness that they had, by `before`(k), Cell::none where there was nothing.
template <class Before>
std::vector<bool> unchanged(const CellPicture& picture, Before&& before) {
    std::vector<std::int32_t> changes;
    for (std::size_t k = 0; k < picture.cells.size(); ++k)
        if (before(k) != Cell::none) changes.push_back(picture.cells[k].luma - before(k));
    const std::int32_t gain = gained(changes);
    std::vector<bool> same(picture.cells.size(), true);
    for (std::size_t k = 0; k < same.size(); ++k)
        same[k] = before(k) != Cell::none && size_of(picture.cells[k].luma - before(k) - gain) <= same_luma;
    return same;
}

double mean_of(const std::vector<double>& numbers) {
    double sum = 0;
    for (const double number : numbers) sum += number;
    return sum / static_cast<double>(numbers.size());
}

/// Of frames that show nothing of each other a chain of lines may lead anywhere.
bool is_likely(const Line& line) {
    constexpr double most_scale = 64, most_shift = 1e8;
    return line.scale >= 1 / most_scale && line.scale <= most_scale && line.shift >= -most_shift &&
           line.shift <= most_shift;
}

/// The straight line through numbers at places first, first + 1, ..., at place 0.
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

/// Share of the cells that are much brighter or darker than before.
double ShotAlignment::changed(const CellPicture& picture) const {
    if (!picture.has_colour) return 0;
    std::size_t others = 0;
    for (std::size_t k = 0; k < picture.cells.size(); ++k)
        others += size_of(picture.cells[k].luma - before_.cells[k].luma) > other_luma;
    return static_cast<double>(others) / static_cast<double>(picture.cells.size());
}

/// By what has the same colour; by all where that is little.
LineFit ShotAlignment::fit_to_before(const CellPicture& picture, RestingCells& resting) {
    std::vector<bool> same(picture.cells.size(), true);
    if (picture.has_colour) same = unchanged(picture, [&](std::size_t k) { return before_.cells[k].luma; });
    std::vector<LinePoint> all, still;
    for (std::size_t k = 0; k < same.size(); ++k) {
        const Cell &now = picture.cells[k], &then = before_.cells[k];
        if (now.depth == Cell::none || then.depth == Cell::none) continue;
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

/// Cells whose colour is that of the reference must be many, and the depths of most of them on one line.
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
        const Cell& cell = picture.cells[k];
        if (reference.age < 0 || cell.depth == Cell::none) continue;
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

/// What stays where it was is averaged; what is there now in place of something else is as new.
void ShotAlignment::remember(const CellPicture& picture, const std::vector<bool>& same, const Line& line,
                             double tolerance) {
    for (std::size_t k = 0; k < picture.cells.size(); ++k) {
        const Cell& cell = picture.cells[k];
        Reference& reference = references_[k];
        reference.calm = same[k] ? reference.calm + 1 : 0;
        reference.luma = same[k] ? reference.luma + (cell.luma - reference.luma) / memory : cell.luma;
        if (cell.depth == Cell::none) continue;
        const double depth = line.at(cell.depth), apart = depth - reference.depth;
        const bool stays = same[k] && reference.age >= 0 && std::fabs(apart) <= tolerance;
        reference.depth = stays ? reference.depth + apart / memory : depth;
        reference.age = stays ? reference.age + 1 : 0;
    }
}

void ShotAlignment::begin_shot(const CellPicture& picture) {
    end_shot();
    range_ = std::max(1.0, static_cast<double>(picture.most - picture.least) * Cell::per_code);
    least_noise_ = std::max(1.0, range_ / steps_of_range);
    references_.assign(picture.cells.size(), {});
    remember(picture, std::vector<bool>(picture.cells.size()), {}, 0);
    shot_.push_back({{}, {}, true});
    resting_.emplace_back();
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

/// Of which the mean leaves codes as they are.
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

/// Through the scales of the frames around each, as they are seen from there, a straight line.
std::vector<Line> ShotAlignment::lines_of_moving() const {
    std::vector<Line> lines;
    const auto count = static_cast<std::ptrdiff_t>(shot_.size());
    const auto fitted = [&](std::ptrdiff_t k) -> const Fitted& { return shot_[static_cast<std::size_t>(k)]; };
    for (std::ptrdiff_t n = 0; n < count; ++n) {
        const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, n - radius),
                             last = std::min(count - 1, n + radius);
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
    const auto still = static_cast<double>(
        std::count_if(shot_.begin(), shot_.end(), [](const Fitted& f) { return f.is_still; }));
    const bool is_still = still >= still_frames * count;
    still_shots_ += is_still;
    for (const Line& line : is_still ? lines_of_still() : lines_of_moving())
        lines_.push_back(is_likely(line) ? line : Line{});
    shot_.clear();
}

std::vector<Line> ShotAlignment::finish() {
    end_shot();
    return std::move(lines_);
}

double ShotAlignment::pumping() const {
    return pairs_ > 0 ? std::sqrt(moved_ / static_cast<double>(pairs_)) : 0;
}

double ShotAlignment::unexplained() const {
    return pairs_ > 0 ? std::sqrt(unexplained_ / static_cast<double>(pairs_)) : 0;
}

}  // namespace touchable
