// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "engine/authoring/segment_parts.hpp"

namespace touchable {

namespace {

constexpr std::int32_t straight = 3, diagonal = 4, nowhere = std::numeric_limits<std::int32_t>::max() / 2;

using Point = SegmentCut::Point;
constexpr std::uint16_t not_seen = 0, on_stroke = 1, first_piece = 2;  // marks of pixels; pieces

std::size_t place_of(const Point& point, int width) {
    return pixel_place(point.x, point.y, width);
}

/// Visits all pixels from one to the other, each a neighbour of the last by a side, so that no path of such
/// steps crosses the line.
template <class Visit>
void walk(Point from, const Point& to, const Visit& visit) {
    const int dx = std::abs(to.x - from.x), dy = std::abs(to.y - from.y);
    const int step_x = to.x > from.x ? 1 : -1, step_y = to.y > from.y ? 1 : -1;
    int done_x = 0, done_y = 0;
    visit(from);
    while (done_x < dx || done_y < dy) {
        const bool goes_across = done_y == dy || (done_x < dx && (2 * done_x + 1) * std::int64_t{dy} <
                                                                     (2 * done_y + 1) * std::int64_t{dx});
        (goes_across ? from.x : from.y) += goes_across ? step_x : step_y;
        ++(goes_across ? done_x : done_y);
        visit(from);
    }
}

template <class Visit>
void walk_along(const std::vector<Point>& stroke, const Visit& visit) {
    for (std::size_t k = 1; k < stroke.size(); ++k) walk(stroke[k - 1], stroke[k], visit);
}

/// Whether the stroke's ends are so near each other that a loop is meant.
bool is_loop(const std::vector<Point>& stroke) {
    std::int64_t length = 0;
    const auto distance = [](const Point& a, const Point& b) {
        return std::int64_t{std::max(std::abs(a.x - b.x), std::abs(a.y - b.y))};
    };
    for (std::size_t k = 1; k < stroke.size(); ++k) length += distance(stroke[k - 1], stroke[k]);
    return stroke.size() > 2 && 5 * distance(stroke.front(), stroke.back()) < length;
}

/// A point of the stroke that gives this end's direction: not the nearest, which a hand sets at random.
template <class Iterator>
Point point_before_end(Iterator end, Iterator last) {
    constexpr int far_enough = 8;
    Point point = *end;
    for (auto at = end; at != last; ++at) {
        point = *at;
        if (std::max(std::abs(at->x - end->x), std::abs(at->y - end->y)) >= far_enough) break;
    }
    return point;
}

/// A place beyond any picture, on the line from `from` through `end`.
Point beyond(const Point& from, const Point& end) {
    const int dx = end.x - from.x, dy = end.y - from.y;
    const int times = 40000 / std::max({std::abs(dx), std::abs(dy), 1});
    return {end.x + times * dx, end.y + times * dy};
}

/// Pieces of a segment after the stroke's pixels are taken out of it.
class Pieces {
public:
    Pieces(const std::vector<std::uint16_t>& labels, std::uint16_t label, int width, int height)
        : labels_(labels), label_(label), width_(width), height_(height), pieces_(labels.size(), not_seen) {}

    /// Draws the stroke; unless it is a loop, ends inside the segment go straight on to its border.
    void draw(const SegmentCut& cut) {
        const auto draw_pixel = [&](const Point& point) {
            if (is_in(point)) pieces_[place_of(point, width_)] = on_stroke;
        };
        walk_along(cut.stroke, draw_pixel);
        if (is_loop(cut.stroke)) return walk(cut.stroke.back(), cut.stroke.front(), draw_pixel);
        const auto go_on = [&](const Point& from, const Point& end) {
            bool is_inside = is_in(end);
            walk(end, beyond(from, end), [&](const Point& point) {
                is_inside = is_inside && is_in(point);
                if (is_inside) draw_pixel(point);
            });
        };
        go_on(point_before_end(cut.stroke.begin(), cut.stroke.end()), cut.stroke.front());
        go_on(point_before_end(cut.stroke.rbegin(), cut.stroke.rend()), cut.stroke.back());
    }

    /// Fills each piece with its own number, and the stroke's pixels with that of the nearest piece. False:
    /// fewer than two pieces are beside the stroke.
    bool find() {
        std::uint16_t number = first_piece;
        std::int64_t largest = 0, pieces_beside = 0;
        std::size_t largest_number = 0;
        is_part_.assign(65536, false);
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) {
                if (!is_in({x, y}) || pieces_[place_of({x, y}, width_)] != not_seen || number == 65535)
                    continue;
                bool is_beside = false;
                const std::int64_t pixels = fill({x, y}, number, is_beside);
                if (is_beside) {
                    ++pieces_beside;
                    is_part_[number] = true;
                    if (pixels > largest) {
                        largest = pixels;
                        largest_number = number;
                    }
                }
                ++number;
            }
        is_part_[largest_number] = false;
        for (std::uint16_t& piece : pieces_)
            if (piece == on_stroke) piece = not_seen;
        NearestLabel().fill(pieces_, width_, height_);
        return pieces_beside > 1;
    }

    /// Whether the pixel belongs to a piece beside the stroke that is not the largest.
    bool is_smaller(std::size_t at) const { return is_part_[pieces_[at]]; }

private:
    bool is_in(const Point& point) const {
        return point.x >= 0 && point.y >= 0 && point.x < width_ && point.y < height_ &&
               labels_[place_of(point, width_)] == label_;
    }
    /// Gives all pixels connected to the seed this number; returns how many.
    std::int64_t fill(const Point& seed, std::uint16_t number, bool& is_beside) {
        std::vector<Point> open{seed};
        pieces_[place_of(seed, width_)] = number;
        std::int64_t pixels = 0;
        while (!open.empty()) {
            const Point at = open.back();
            open.pop_back();
            ++pixels;
            for (const Point& next :
                 {Point{at.x - 1, at.y}, {at.x + 1, at.y}, {at.x, at.y - 1}, {at.x, at.y + 1}}) {
                if (!is_in(next)) continue;
                std::uint16_t& piece = pieces_[place_of(next, width_)];
                is_beside = is_beside || piece == on_stroke;
                if (piece != not_seen) continue;
                piece = number;
                open.push_back(next);
            }
        }
        return pixels;
    }

    const std::vector<std::uint16_t>& labels_;
    const std::uint16_t label_;
    const int width_, height_;
    std::vector<std::uint16_t> pieces_;
    std::vector<bool> is_part_;  // by piece
};

}  // namespace

/// Chamfer distances with weights of 3 and 4: one pass from the upper left and one back.
void NearestLabel::fill(std::vector<std::uint16_t>& labels, int columns, int rows) {
    const std::ptrdiff_t width = columns, height = rows;
    if (std::ranges::find(labels, 0) == labels.end()) return;
    distances_.resize(labels.size());
    std::transform(labels.begin(), labels.end(), distances_.begin(),
                   [](std::uint16_t label) { return label == 0 ? nowhere : 0; });
    const auto pass = [&](std::ptrdiff_t step) {
        const auto count = static_cast<std::ptrdiff_t>(labels.size());
        for (std::ptrdiff_t k = step > 0 ? 0 : count - 1; k >= 0 && k < count; k += step) {
            const auto at = static_cast<std::size_t>(k);
            if (distances_[at] == 0) continue;
            const std::ptrdiff_t x = k % width, y = k / width;
            const auto look = [&](std::ptrdiff_t dx, std::ptrdiff_t dy, std::int32_t weight) {
                if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height) return;
                const auto from = static_cast<std::size_t>(k + dy * width + dx);
                if (distances_[from] + weight >= distances_[at]) return;
                distances_[at] = distances_[from] + weight;
                labels[at] = labels[from];
            };
            look(-step, 0, straight);
            look(0, -step, straight);
            look(-step, -step, diagonal);
            look(step, -step, diagonal);
        }
    };
    pass(1);
    pass(-1);
}

std::uint16_t label_under(const SegmentCut& cut, const std::vector<std::uint16_t>& labels, int width) {
    std::map<std::uint16_t, std::int64_t> counts;
    walk_along(cut.stroke, [&](const Point& point) { ++counts[labels[place_of(point, width)]]; });
    counts.erase(0);
    const auto most = std::ranges::max_element(counts, {}, [](const auto& count) { return count.second; });
    return most == counts.end() ? std::uint16_t{0} : most->first;
}

void CutFollower::Box::hold(const Box& other) {
    *this = {std::min(left, other.left), std::min(top, other.top), std::max(right, other.right),
             std::max(bottom, other.bottom)};
}

bool CutFollower::begin(const SegmentCut& cut, std::vector<std::uint16_t>& labels) {
    Pieces pieces(labels, label_, width_, height_);
    pieces.draw(cut);
    const auto seen = find(labels);
    if (!seen || !pieces.find()) return false;
    for (std::size_t k = 0; k < labels.size(); ++k)
        if (labels[k] == label_ && pieces.is_smaller(k)) labels[k] = part_;
    remember(labels, *seen);
    return true;
}

std::optional<CutFollower::Seen> CutFollower::find(const std::vector<std::uint16_t>& labels) const {
    Seen seen{{width_, height_, 0, 0}, {}};
    std::int64_t pixels = 0;
    std::size_t k = 0;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x, ++k) {
            if (labels[k] != label_) continue;
            seen.box.hold({x, y, x + 1, y + 1});
            seen.middle.x += x;
            seen.middle.y += y;
            ++pixels;
        }
    if (pixels == 0) return std::nullopt;
    seen.middle = {seen.middle.x / pixels, seen.middle.y / pixels};
    return seen;
}

/// Number of the segment's pixels whose part is known, if the known parts are shifted.
std::int64_t CutFollower::overlap(const std::vector<std::uint16_t>& labels, const Box& box,
                                  const Place& shift) const {
    std::int64_t pixels = 0;
    for (int y = box.top; y < box.bottom; ++y)
        for (int x = box.left; x < box.right; ++x) {
            const std::int64_t from_x = x - shift.x, from_y = y - shift.y;
            if (labels[place_of({x, y}, width_)] != label_ || from_x < 0 || from_y < 0 || from_x >= width_ ||
                from_y >= height_)
                continue;
            pixels += known_[static_cast<std::size_t>(from_y * width_ + from_x)] != 0;
        }
    return pixels;
}

void CutFollower::shift_known(const Place& shift) {
    if (shift.x == 0 && shift.y == 0) return;
    std::vector<std::uint16_t> shifted(known_.size());
    for (int y = known_box_.top; y < known_box_.bottom; ++y)
        for (int x = known_box_.left; x < known_box_.right; ++x) {
            const std::int64_t to_x = x + shift.x, to_y = y + shift.y;
            if (to_x < 0 || to_y < 0 || to_x >= width_ || to_y >= height_) continue;
            shifted[static_cast<std::size_t>(to_y * width_ + to_x)] = known_[place_of({x, y}, width_)];
        }
    known_ = std::move(shifted);
    const auto moved = [](int edge, std::int64_t by, int most) {
        return static_cast<int>(std::clamp<std::int64_t>(edge + by, 0, most));
    };
    known_box_ = {moved(known_box_.left, shift.x, width_), moved(known_box_.top, shift.y, height_),
                  moved(known_box_.right, shift.x, width_), moved(known_box_.bottom, shift.y, height_)};
}

/// The segment moved as its middle did, or stood still behind a passing thing: whichever explains more.
void CutFollower::next(std::vector<std::uint16_t>& labels) {
    const auto seen = find(labels);
    if (!seen) return;
    const Place moved{seen->middle.x - middle_.x, seen->middle.y - middle_.y};
    if (overlap(labels, seen->box, moved) > overlap(labels, seen->box, {})) shift_known(moved);
    Box box = seen->box;
    box.hold(known_box_);
    near_.clear();
    for (int y = box.top; y < box.bottom; ++y)
        for (int x = box.left; x < box.right; ++x) near_.push_back(known_[place_of({x, y}, width_)]);
    nearest_.fill(near_, box.right - box.left, box.bottom - box.top);
    std::size_t k = 0;
    for (int y = box.top; y < box.bottom; ++y)
        for (int x = box.left; x < box.right; ++x, ++k) {
            std::uint16_t& label = labels[place_of({x, y}, width_)];
            if (label == label_ && near_[k] == part_) label = part_;
        }
    remember(labels, *seen);
}

void CutFollower::remember(const std::vector<std::uint16_t>& labels, const Seen& seen) {
    for (std::size_t k = 0; k < labels.size(); ++k)
        if (labels[k] == label_ || labels[k] == part_) known_[k] = labels[k];
    known_box_.hold(seen.box);
    middle_ = seen.middle;
}

}  // namespace touchable
