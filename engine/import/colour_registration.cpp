#include "engine/import/colour_registration.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/frame/stored_code.hpp"
#include "engine/frame/unseen_colour.hpp"

namespace touchable {
namespace {

constexpr float nothing_there = std::numeric_limits<float>::max();
constexpr double widest = 100;  // from a camera's axis, at distance 1: no picture reaches so far

/// Neighbours in depth, up to one and a half cells apart, of a surface that is 80 degrees steep.
double steepest(double focal_length) {
    constexpr double cells = 1.5, slope = 5.67, most = 0.2;
    return std::min(cells * slope / focal_length, most);
}

}  // namespace

ColourRegistration::ColourRegistration(const Scene& scene)
    : width_(scene.width),
      height_(scene.height),
      camera_(scene.camera),
      coding_(scene.depth),
      colour_(*scene.colour_camera),
      reach_(scene.colour_camera->lens.any() ? scene.colour_camera->lens.reach() : widest),
      cell_(std::max(1.0, std::max(colour_.camera.fx / camera_.fx, colour_.camera.fy / camera_.fy))),
      scale_(static_cast<float>(1 / cell_)),
      margin_(static_cast<float>(1 + steepest(camera_.fx))),
      cells_x_(static_cast<int>(colour_.width / cell_) + 2),
      cells_y_(static_cast<int>(colour_.height / cell_) + 2) {
    depth_of_code_.resize(std::size_t{coding_.code_max} + 1);
    for (std::size_t code = 0; code < depth_of_code_.size(); ++code)
        if (coding_.is_valid(static_cast<std::uint16_t>(code)))
            depth_of_code_[code] = coding_.depth(static_cast<std::uint16_t>(code));
}

void ColourRegistration::make_room() {
    const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    has_depth_.resize(pixels);
    depth_.resize(pixels);
    places_.resize(pixels);
    sights_.resize(pixels);
    nearest_.resize(static_cast<std::size_t>(cells_x_) * static_cast<std::size_t>(cells_y_));
}

void ColourRegistration::find_depths(const PlaneView& depth) {
    std::size_t at = 0;
    for (int y = 0; y < height_; ++y) {
        const std::size_t begin = at;
        for (int x = 0; x < width_; ++x, ++at) {
            const std::size_t code = stored_code(depth, coding_, x, y);
            const double length = code < depth_of_code_.size() ? depth_of_code_[code] : 0;
            has_depth_[at] = length > 0;
            depth_[at] = static_cast<float>(planar_depth(camera_, coding_.semantics, x, y, length));
        }
        // Between its neighbours with depth, a pixel without is as far away as the farther of them.
        for (std::size_t k = begin; k < at;) {
            if (has_depth_[k]) {
                ++k;
                continue;
            }
            std::size_t end = k;
            while (end < at && !has_depth_[end]) ++end;
            const float before = k > begin ? depth_[k - 1] : 0, behind = end < at ? depth_[end] : 0;
            std::fill(depth_.begin() + static_cast<std::ptrdiff_t>(k),
                      depth_.begin() + static_cast<std::ptrdiff_t>(end), std::max(before, behind));
            k = end;
        }
    }
}

void ColourRegistration::place_all() {
    const auto& r = colour_.from_depth.rotation;
    const auto& t = colour_.from_depth.translation;
    const Camera& to = colour_.camera;
    std::size_t at = 0;
    for (int y = 0; y < height_; ++y) {
        const double v = (y - camera_.cy) / camera_.fy;
        const double along[3] = {r[1] * v + r[2], r[4] * v + r[5], r[7] * v + r[8]};
        for (int x = 0; x < width_; ++x, ++at) {
            Place& place = places_[at];
            place.depth = 0;
            const double length = depth_[at], u = (x - camera_.cx) / camera_.fx;
            const double ahead = (r[6] * u + along[2]) * length + t[2];
            if (!(length > 0) || !(ahead > 0)) continue;
            LensPoint point{((r[0] * u + along[0]) * length + t[0]) / ahead,
                            ((r[3] * u + along[1]) * length + t[1]) / ahead};
            if (!(point.x * point.x + point.y * point.y <= reach_ * reach_)) continue;
            if (colour_.lens.any()) point = colour_.lens.distorted(point);
            place = {static_cast<float>(to.fx * point.x + to.cx), static_cast<float>(to.fy * point.y + to.cy),
                     static_cast<float>(ahead)};
        }
    }
}

/// Each point covers the four cells around it, so that no surface has gaps between its pixels.
void ColourRegistration::find_nearest() {
    std::fill(nearest_.begin(), nearest_.end(), nothing_there);
    for (std::size_t at = 0; at < places_.size(); ++at) {
        const Place& place = places_[at];
        if (!has_depth_[at] || !(place.depth > 0)) continue;
        const float x = (place.x + 0.5F) * scale_ - 0.5F, y = (place.y + 0.5F) * scale_ - 0.5F;
        if (!(x > -1 && y > -1 && x < static_cast<float>(cells_x_) && y < static_cast<float>(cells_y_)))
            continue;
        const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
        for (int j = std::max(top, 0); j <= std::min(top + 1, cells_y_ - 1); ++j)
            for (int i = std::max(left, 0); i <= std::min(left + 1, cells_x_ - 1); ++i) {
                float& nearest = nearest_[static_cast<std::size_t>(j * cells_x_ + i)];
                nearest = std::min(nearest, place.depth);
            }
    }
}

ColourRegistration::Sight ColourRegistration::sight_of(const Place& place) const {
    if (!(place.depth > 0) || !(place.x >= -0.5F && place.y >= -0.5F) ||
        !(place.x < static_cast<float>(colour_.width) - 0.5F &&
          place.y < static_cast<float>(colour_.height) - 0.5F))
        return Sight::outside;
    const int i = static_cast<int>((place.x + 0.5F) * scale_),
              j = static_cast<int>((place.y + 0.5F) * scale_);
    const float nearest = nearest_[static_cast<std::size_t>(j * cells_x_ + i)];
    return nearest == nothing_there || place.depth <= nearest * margin_ ? Sight::seen : Sight::hidden;
}

void ColourRegistration::fill_unseen(Image& picture) {
    std::size_t grey = 0;
    std::uint8_t* const to = picture.samples.data();
    const auto width = static_cast<std::size_t>(width_);
    for (std::size_t begin = 0; begin < sights_.size(); begin += width)
        for (std::size_t k = begin; k < begin + width;) {
            if (sights_[k] == Sight::seen) {
                ++k;
                continue;
            }
            std::size_t end = k;
            while (end < begin + width && sights_[end] != Sight::seen) ++end;
            const bool has_left = k > begin, has_right = end < begin + width;
            const std::size_t from = has_left && (!has_right || depth_[k - 1] >= depth_[end]) ? k - 1 : end;
            for (; k < end; ++k) {
                if (sights_[k] == Sight::hidden && (has_left || has_right))
                    std::memcpy(to + 3 * k, to + 3 * from, 3);
                else
                    std::memset(to + 3 * k, unseen_colour, 3), ++grey;
            }
        }
    grey_share_ = static_cast<double>(grey) / static_cast<double>(sights_.size());
}

Image ColourRegistration::registered(const PlaneView& depth, const PlaneView& colour) {
    make_room();
    find_depths(depth);
    place_all();
    find_nearest();
    Image picture{width_, height_, 1, 3, {}};
    picture.samples.resize(3 * places_.size());
    std::size_t deep = 0, unseen = 0;
    for (std::size_t at = 0; at < places_.size(); ++at) {
        const Place& place = places_[at];
        sights_[at] = sight_of(place);
        const bool is_seen = sights_[at] == Sight::seen;
        deep += has_depth_[at];
        unseen += has_depth_[at] && !is_seen;
        if (!is_seen) continue;
        const int x = static_cast<int>(place.x + 0.5F), y = static_cast<int>(place.y + 0.5F);
        const std::uint8_t* const from = colour.row(y) + std::ptrdiff_t{3} * x;
        std::copy(from, from + 3, picture.samples.begin() + static_cast<std::ptrdiff_t>(3 * at));
    }
    unseen_share_ = deep > 0 ? static_cast<double>(unseen) / static_cast<double>(deep) : 0;
    fill_unseen(picture);
    return picture;
}

}  // namespace touchable
