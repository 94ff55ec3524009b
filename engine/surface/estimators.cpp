// SPDX-License-Identifier: Apache-2.0
// Statistics of levels and contours.
#include "engine/surface/estimators.hpp"

#include <cstdlib>
#include <numeric>

namespace touchable {
namespace {

/// Value and weight.
using Weighted = std::pair<double, std::int64_t>;

/// The value below which there is this share of the weight, in hundredths.
double weighted_percentile(std::vector<Weighted> values, int hundredths) {
    std::ranges::sort(values);
    std::int64_t all = 0, sum = 0;
    for (const Weighted& value : values) all += value.second;
    for (const Weighted& value : values)
        if (sum += value.second; 100 * sum >= hundredths * all) return value.first;
    return 0;
}

/// The median, if three quarters of the weight are within a fifth of it.
std::optional<double> common_value(const std::vector<Weighted>& values) {
    const double middle = weighted_percentile(values, 50);
    std::int64_t all = 0, near = 0;
    for (const Weighted& value : values) {
        all += value.second;
        if (std::fabs(value.first - middle) <= 0.2 * middle) near += value.second;
    }
    if (4 * near < 3 * all) return std::nullopt;
    return middle;
}

/// Distance of the rows, and of the columns, that are measured.
constexpr int line_step = 4;
/// Pixels: shorter runs are no treads, and two treads that are farther apart have no step between them.
constexpr int least_tread = 8, widest_step = 8;
/// Wider treads count as this wide.
constexpr int most_width = 4096;
/// Steps between the nearest and the farthest terrace that goes on. A picture with fewer has no slope, only a
/// few flat things, such as a card before a wall.
constexpr int least_levels = 2;

}  // namespace

void LevelEstimator::add(const CodePicture& picture) {
    for (int y = 0; y < picture.height; ++y) {
        const int* row = picture.row(y);
        const int* above = y > 0 ? picture.row(y - 1) : nullptr;
        for (int x = 0; x < picture.width; ++x) {
            if (row[x] == CodePicture::invalid) continue;
            CodeCount& count = counts_[static_cast<std::size_t>(row[x])];
            ++count.pixels;
            if (x + 1 < picture.width && row[x + 1] != CodePicture::invalid) {
                ++count.right;
                count.same_right += row[x] == row[x + 1];
            }
            if (above && above[x] != CodePicture::invalid) {
                ++count.above;
                count.same_above += row[x] == above[x];
            }
        }
    }
}

std::optional<double> LevelEstimator::depth_of_share(int hundredths) const {
    std::vector<Weighted> depths, background;
    for (int code = 0; code < 65536; ++code) {
        const std::int64_t pixels = counts_[static_cast<std::size_t>(code)].pixels;
        if (pixels == 0) continue;
        const double depth = coding_.depth(static_cast<std::uint16_t>(code));
        (depth < 0.999 * coding_.far ? depths : background).emplace_back(depth, pixels);
    }
    if (depths.empty()) depths = std::move(background);
    if (depths.empty()) return std::nullopt;
    return weighted_percentile(std::move(depths), hundredths);
}

/// Nothing if the window's codes are no levels, or too few to tell.
std::optional<LevelEstimator::Window> LevelEstimator::window(int first, int end) const {
    std::int64_t pixels = 0, occupied = 0;
    for (int code = first; code < end; ++code) {
        pixels += counts_[static_cast<std::size_t>(code)].pixels;
        occupied += counts_[static_cast<std::size_t>(code)].pixels > 0;
    }
    if (occupied < 4 || pixels < 20 * occupied) return std::nullopt;
    // Stray codes are no levels.
    const std::int64_t least = std::max<std::int64_t>(1, pixels / (20 * occupied));
    CodeCount sum;
    std::vector<Weighted> gaps;
    int last = -1, least_code = -1, divisor = 0;
    std::int64_t levels = 0;
    for (int code = first; code < end; ++code) {
        const CodeCount& count = counts_[static_cast<std::size_t>(code)];
        if (count.pixels < least) continue;
        if (last >= 0)
            gaps.emplace_back(code - last,
                              std::min(count.pixels, counts_[static_cast<std::size_t>(last)].pixels));
        else
            least_code = code;
        last = code;
        divisor = std::gcd(divisor, code);
        ++levels;
        sum.pixels += count.pixels;
        sum.right += count.right;
        sum.same_right += count.same_right;
        sum.above += count.above;
        sum.same_above += count.same_above;
    }
    if (levels < 4) return std::nullopt;
    const std::int64_t span = last - least_code;
    // If all codes are multiples of a step, they are levels, like those of floats, whose finest step it is.
    if (coding_.kind != DepthCodingKind::metric || divisor < 2 || levels < 8) {
        // If every code were a level, this many pixels would meet at least half of the codes.
        if (span * sum.pixels < 2 * levels * (span + sum.pixels)) return std::nullopt;
        // A slope that takes another code at every pixel of a row has gaps, but no terraces.
        if (7 * sum.same_right < sum.right || 7 * sum.same_above < sum.above) return std::nullopt;
    }
    const int middle = (least_code + last) / 2;
    const double gap = weighted_percentile(std::move(gaps), 50);
    const auto at = [&](double code) { return coding_.depth(static_cast<std::uint16_t>(code)); };
    return Window{sum.pixels, at(middle),
                  std::fabs(at(last) - at(least_code)) / static_cast<double>(span) * gap};
}

std::vector<LevelEstimator::Window> LevelEstimator::windows() const {
    std::vector<Window> found;
    for (int first = 0; first < 65536; first = end_of_window(first))
        if (const auto one = window(first, end_of_window(first))) found.push_back(*one);
    return found;
}

DepthLength LevelEstimator::levels() const {
    const std::vector<Window> found = windows();
    if (found.size() < 3) return {};
    std::vector<Weighted> constant, quadratic;
    for (const Window& one : found) {
        constant.emplace_back(one.distance, one.pixels);
        quadratic.emplace_back(one.distance / (one.depth * one.depth), one.pixels);
    }
    if (const auto q = common_value(quadratic)) return {0, *q};
    if (const auto c = common_value(constant)) return {*c, 0};
    return levels_of_floats(found);
}

/// A number with m binary digits behind its first one is 2^m to 2^(m + 1) of its steps, in any unit: its step
/// doubles at each power of two.
DepthLength LevelEstimator::levels_of_floats(const std::vector<Window>& found) {
    const auto digits_of = [](const Window& one) { return std::ilogb(one.depth / one.distance); };
    std::vector<Weighted> digits;
    for (const Window& one : found) digits.emplace_back(digits_of(one), one.pixels);
    const double usual = weighted_percentile(digits, 50);
    std::int64_t all = 0, like = 0;
    double nearest = found.back().depth, deepest = 0;
    for (const Window& one : found) {
        all += one.pixels;
        int doublings = 0;
        const double share = std::frexp(one.distance / found.front().distance, &doublings);  // 0.5 to 1
        if (digits_of(one) != usual || (share > 0.535 && share < 0.935)) continue;
        like += one.pixels;
        nearest = std::min(nearest, one.depth);
        deepest = std::max(deepest, one.depth);
    }
    if (4 * like < 3 * all || !(nearest < deepest)) return {};
    return length_along_depth(std::ldexp(1.0, -static_cast<int>(usual)), 0, nearest, deepest);
}

int Contours::reach() const {
    int reach = least_terrace_reach;
    if (are_wide())
        while (reach < width && reach < most_terrace_reach) reach *= 2;
    return reach;
}

DepthLength Contours::levels(const DepthCoding& coding) const {
    return height > 1 ? code_step(coding).times(height) : DepthLength{};
}

void ContourEstimator::add(const CodePicture& picture) {
    for (int y = 0; y < picture.height; y += line_step) add_line(picture.row(y), 1, picture.width);
    for (int x = 0; x < picture.width; x += line_step)
        add_line(picture.codes.data() + x, picture.width, picture.height);
}

void ContourEstimator::add_line(const int* codes, std::ptrdiff_t stride, int count) {
    const auto at = [&](int n) { return codes[stride * n]; };
    treads_.clear();
    for (int first = 0, end = 0; first < count; first = end) {
        while (end < count && at(end) == at(first)) ++end;
        if (at(first) == CodePicture::invalid) continue;
        if (end - first >= least_tread)
            treads_.push_back({first, end, at(first)});
        else
            narrow_ += end - first;
    }
    int before = 0;  // the step that leads to a tread, codes; 0: none
    for (std::size_t k = 0; k < treads_.size(); ++k) {
        int after = 0;
        if (k + 1 < treads_.size()) {
            const Tread &here = treads_[k], &next = treads_[k + 1];
            bool is_step = next.first - here.end <= widest_step;
            for (int n = here.end; is_step && n < next.first; ++n) is_step = at(n) != CodePicture::invalid;
            if (is_step) after = next.code - here.code;
        }
        if (after != 0) ++steps_[static_cast<std::size_t>(std::abs(after))];
        if (before != 0 && after != 0)
            terraces_.push_back({treads_[k].end - treads_[k].first,
                                 std::max(std::abs(before), std::abs(after)), treads_[k].code,
                                 (before > 0) == (after > 0)});
        before = after;
    }
}

/// The median of all steps.
int ContourEstimator::height() const {
    std::int64_t all = 0, sum = 0;
    for (const std::int64_t count : steps_) all += count;
    for (int step = 1; all > 0 && step < 65536; ++step)
        if (sum += steps_[static_cast<std::size_t>(step)]; 2 * sum >= all) return step;
    return 0;
}

Contours ContourEstimator::contours() const {
    Contours contours;
    const int height = this->height();
    if (height == 0) return contours;
    std::int64_t steps = 0;
    for (const std::int64_t count : steps_) steps += count;
    if (2 * steps_[static_cast<std::size_t>(height)] >= steps) contours.height = height;
    // A terrace beside a higher step is no part of a slope of terraces, and its width does not count.
    std::vector<std::int64_t> pixels(most_width + 1);
    std::int64_t all = narrow_;
    int nearest = 65536, farthest = 0;
    for (const Terrace& terrace : terraces_) {
        if (2 * terrace.step > 3 * height) continue;
        pixels[static_cast<std::size_t>(std::min(terrace.width, most_width))] += terrace.width;
        all += terrace.width;
        if (!terrace.goes_on) continue;
        nearest = std::min(nearest, terrace.code);
        farthest = std::max(farthest, terrace.code);
    }
    if (farthest - nearest < least_levels * height) return contours;
    std::int64_t wider = 0;
    for (int width = most_width; width > 0; --width)
        if (wider += pixels[static_cast<std::size_t>(width)]; 4 * wider >= all) {
            contours.width = width;
            break;
        }
    return contours;
}

}  // namespace touchable
