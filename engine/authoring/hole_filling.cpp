#include "engine/authoring/hole_filling.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "engine/clip/plane_role.hpp"

namespace touchable {
namespace {

/// A shadow of a depth camera is a narrow strip: at most this share of the picture's width.
constexpr int narrow_share = 16, least_narrow = 8;
constexpr std::size_t most_nearer = 4;
/// Without colour: a hole that is narrow in parts only is no shadow. Those parts touch the rest in less than
/// this share of the places in which they touch what is behind.
constexpr std::size_t left_share = 4;
/// Of a registered recording of a person 16 % look like what is behind, of hands whose colour lies 24 pixels
/// beside them 40 to 100 %. So few pixels say nothing.
constexpr double most_alike = 0.25;
constexpr std::int64_t least_nearer = 100;

Rgb colour_at(const PlaneView& colour, int x, int y) {
    const std::uint8_t* rgb = colour.row(y) + std::ptrdiff_t{3} * x;
    return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace

/// `colour` may be empty.
void HoleFilling::find_places(const PlaneView& codes, const PlaneView& colour, const Background& background) {
    width_ = codes.width;
    height_ = codes.height;
    places_.resize(background.size());
    holes_.clear();
    std::size_t pixel = 0;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x, ++pixel) {
            const std::uint16_t code = codes.sample(x, y);
            if (!depth_.is_valid(code)) {
                places_[pixel] = Place::hole;
                holes_.push_back(pixel);
                continue;
            }
            const BackgroundPixel& behind = background[pixel];
            const std::int32_t deeper = depth_.deeper_by(code, behind.code);
            const std::int32_t apart = 2 * depth_.tolerance(code);
            places_[pixel] = !behind.is_known || deeper > apart ? Place::other
                             : deeper < -apart                  ? Place::nearer
                                                                : Place::behind;
            if (places_[pixel] != Place::nearer || colour.empty() || behind.is_ambiguous) continue;
            ++nearer_;
            nearer_but_alike_ += agree(colour_at(colour, x, y), behind.colour);
        }
}

bool HoleFilling::is_misled_by_colour() const {
    return nearer_ >= least_nearer &&
           static_cast<double>(nearer_but_alike_) > most_alike * static_cast<double>(nearer_);
}

/// Along a row or a column (`step`), in which the pixel has this place of so many.
bool HoleFilling::has_end_behind(std::size_t pixel, std::ptrdiff_t step, int place, int places) const {
    const int most = std::max(least_narrow, width_ / narrow_share);
    int length = 1;
    bool any = false;
    const auto go = [&](std::ptrdiff_t by, int left) {
        for (auto at = static_cast<std::ptrdiff_t>(pixel) + by; left > 0 && length <= most;
             --left, at += by) {
            const Place there = places_[static_cast<std::size_t>(at)];
            if (there != Place::hole && there != Place::candidate) {
                any = any || there == Place::behind;
                return;
            }
            ++length;
        }
    };
    go(-step, place);
    go(step, places - 1 - place);
    return any && length <= most;
}

bool HoleFilling::is_beside_what_is_behind(std::size_t pixel) const {
    const auto columns = static_cast<std::size_t>(width_);
    return has_end_behind(pixel, 1, static_cast<int>(pixel % columns), width_) ||
           has_end_behind(pixel, width_, static_cast<int>(pixel / columns), height_);
}

/// The pixel itself, and more of the 3x3 around it than not: a single one may look alike by chance, and at
/// the edge of a nearer thing some are that thing's.
bool HoleFilling::is_coloured_as_behind(const PlaneView& colour, const Background& background,
                                        std::size_t pixel) const {
    const int x = static_cast<int>(pixel) % width_, y = static_cast<int>(pixel) / width_;
    const auto agrees = [&](int u, int v) {
        return agree(colour_at(colour, u, v), background[static_cast<std::size_t>(v * width_ + u)].colour);
    };
    if (!agrees(x, y)) return false;
    int alike = 0, other = 0;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height_ - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width_ - 1); ++u)
            if (background[static_cast<std::size_t>(v * width_ + u)].is_known)
                ++(agrees(u, v) ? alike : other);
    return alike > other;
}

void HoleFilling::find_candidates(const PlaneView& colour, const Background& background) {
    for (const std::size_t pixel : holes_) {
        const BackgroundPixel& behind = background[pixel];
        if (!behind.is_known) continue;
        const bool has_its_colour = colour.empty() || is_coloured_as_behind(colour, background, pixel);
        const bool colour_tells = !colour.empty() && !behind.is_ambiguous;
        if (has_its_colour && (colour_tells || is_beside_what_is_behind(pixel)))
            places_[pixel] = Place::candidate;
    }
}

/// Group by group of candidates that touch.
void HoleFilling::leave_those_of_nearer_things(bool colour_tells) {
    const auto columns = static_cast<std::size_t>(width_);
    fills_.clear();
    for (const std::size_t first : holes_) {
        if (places_[first] != Place::candidate) continue;
        std::size_t behind = 0, nearer = 0, left = 0;
        group_.assign(1, first);
        places_[first] = Place::looked_at;
        const auto look = [&](std::size_t pixel) {
            Place& place = places_[pixel];
            behind += place == Place::behind;
            nearer += place == Place::nearer;
            left += place == Place::hole;
            if (place != Place::candidate) return;
            place = Place::looked_at;
            group_.push_back(pixel);
        };
        for (std::size_t k = 0; k < group_.size(); ++k) {
            const std::size_t pixel = group_[k], x = pixel % columns;
            if (x > 0) look(pixel - 1);
            if (x + 1 < columns) look(pixel + 1);
            if (pixel >= columns) look(pixel - columns);
            if (pixel + columns < places_.size()) look(pixel + columns);
        }
        const bool is_whole = colour_tells || left_share * left <= behind;
        if (behind > 0 && nearer <= most_nearer * behind && is_whole)
            fills_.insert(fills_.end(), group_.begin(), group_.end());
    }
}

void HoleFilling::write(RawFrame& frame, const Background& background) {
    const PlaneView stored = frame.depth;
    Image image{stored.width, stored.height, stored.bytes_per_sample, stored.channels, {}};
    const auto row_bytes = static_cast<std::size_t>(stored.width * stored.channels * stored.bytes_per_sample);
    const auto columns = static_cast<std::size_t>(stored.width);
    image.samples.resize(row_bytes * static_cast<std::size_t>(stored.height));
    for (int y = 0; y < stored.height; ++y)
        std::memcpy(image.samples.data() + static_cast<std::size_t>(y) * row_bytes, stored.row(y), row_bytes);
    const std::size_t words = (columns + 31) / 32;
    auto filled =
        std::make_shared<std::vector<std::uint32_t>>(words * static_cast<std::size_t>(stored.height));
    for (const std::size_t pixel : fills_) {
        const std::size_t x = pixel % columns, y = pixel / columns;
        depth_.put(background[pixel].code, image.samples.data() + y * row_bytes, static_cast<int>(x),
                   stored.bytes_per_sample);
        (*filled)[y * words + x / 32] |= 1U << (x % 32);
    }
    add_plane(frame, PlaneRole::depth, plane_from(std::move(image)));
    frame.filled = std::move(filled);
}

void HoleFilling::fill(RawFrame& frame, const Background& background, bool uses_colour) {
    filled_ = 0;
    const bool has_colour =
        frame.colour.width == frame.depth.width && frame.colour.height == frame.depth.height;
    const PlaneView colour = uses_colour && has_colour ? frame.colour : PlaneView{};
    find_places(depth_.codes_of(frame, hue_codes_), colour, background);
    if (holes_.empty()) return;
    find_candidates(colour, background);
    leave_those_of_nearer_things(!colour.empty());
    filled_ = static_cast<std::int64_t>(fills_.size());
    if (filled_ > 0) write(frame, background);
}

}  // namespace touchable
