#include "engine/surface/contour_estimator.hpp"

#include <algorithm>
#include <cstdlib>

#include "engine/scene/working_codes.hpp"

namespace touchable {
namespace {

/// Lines that are looked at, of rows and of columns.
constexpr int line_step = 4;
/// Pixels: shorter runs are no treads, and two treads that are farther apart have no step between them.
constexpr int least_tread = 8, widest_step = 8;
/// Wider ones count as this.
constexpr int most_width = 4096;
/// Steps from the nearest terrace that goes on to the farthest. A picture with fewer has no slope, only a few
/// flat things, such as a card before a wall.
constexpr int least_levels = 2;

}  // namespace

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
    // What lies beside a higher step is no part of a slope of terraces, and may be as wide as it likes.
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
