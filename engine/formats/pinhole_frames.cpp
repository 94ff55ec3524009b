// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/pinhole_frames.hpp"

#include <limits>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/camera_sidecar.hpp"

namespace touchable {
namespace {

constexpr float nothing_there = std::numeric_limits<float>::max();
constexpr int beside_surface = 4;  // pixels; a hole so near to a surface takes its depth
constexpr double widest = 100;     // from a camera's axis, at distance 1: no picture reaches so far

/// Relative difference of depths that are `cells` apart on a surface that is 80 degrees steep.
float steepest_margin(double focal_length, double cells) {
    constexpr double slope = 5.67, most = 0.2;
    return static_cast<float>(std::min(cells * slope / focal_length, most));
}

/// For each pixel of the clip's camera, the pixel of a picture by camera `stored`, behind the lens, that
/// shows the same ray; -1: none.
std::vector<std::int32_t> stored_pixels(const Scene& scene, const LensDistortion& lens,
                                        const Camera& stored) {
    const Camera& camera = scene.camera;
    const bool bends = lens.any();
    const double reach = bends ? lens.reach() : std::numeric_limits<double>::infinity();
    std::vector<std::int32_t> from;
    from.reserve(pixel_count(scene.width, scene.height));
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            const LensDistortion::Point point{(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy};
            const LensDistortion::Point shown = bends ? lens.distorted(point) : point;
            const double column = std::floor(stored.fx * shown.x + stored.cx + 0.5),
                         row = std::floor(stored.fy * shown.y + stored.cy + 0.5);
            const bool is_there = point.x * point.x + point.y * point.y <= reach * reach && column >= 0 &&
                                  row >= 0 && column < scene.width && row < scene.height;
            from.push_back(is_there ? static_cast<std::int32_t>(row) * scene.width +
                                          static_cast<std::int32_t>(column)
                                    : -1);
        }
    return from;
}

/// A stored sample that is no depth; nothing if every sample is a depth.
std::optional<std::uint16_t> no_depth_code(const Scene& scene) {
    if (scene.depth.kind == DepthCodingKind::hue) return std::uint16_t{0};  // black
    for (int code = 0; code < (1 << scene.depth_bits); ++code)
        if (!scene.depth.is_valid(static_cast<std::uint16_t>(code))) return static_cast<std::uint16_t>(code);
    return {};
}

class PinholeReader final : public ChangedClip {
public:
    explicit PinholeReader(std::unique_ptr<ClipReader> clip)
        : ChangedClip(std::move(clip)), lens_(scene_.lens), cameras_(inner().frame_cameras()) {
        no_depth_ = no_depth_code(scene_);
        if (scene_.colour_camera) registration_.emplace(scene_);
        scene_.lens = {};
        scene_.colour_camera.reset();
        if (scene_.folder) scene_.folder->cameras.clear();
        if (scene_.folder) scene_.folder->camera_numbers = {};
    }

    /// Adds notes for a person, by frame 0.
    Result<void> open() {
        TRY(look_at_cameras());
        if (lens_.any())
            notes_.emplace_back(
                "the lens of the depth camera is undone: each pixel has the depth of the nearest "
                "one that was stored");
        const bool has_colour =
            std::ranges::count(tracks(), role_name(PlaneRole::colour), &TrackInfo::role) > 0;
        if (!registration_ || !has_colour || is_live()) return {};
        TRY_ASSIGN(const auto first, next());
        if (auto back = rewind(); !back || !first) return back;
        registration_->look_at(first->depth);  // it may be read without its colour
        const auto per_cent = [](double share) { return short_number(std::round(1000 * share) / 10) + " %"; };
        notes_.push_back(
            "colour is brought onto depth's pixels: in frame 0 its camera does not see " +
            per_cent(registration_->unseen_share()) + " of those with depth; " +
            per_cent(registration_->grey_share()) +
            " of all pixels, with depth or without, are grey: hidden from it, or beyond its picture");
        return {};
    }

    std::span<const Camera> frame_cameras() const override { return {}; }

private:
    Result<void> change(RawFrame& raw) override {
        const auto number = static_cast<std::size_t>(raw.number);
        take_pixels_of(number < cameras_.size() ? cameras_[number] : scene_.camera);
        if (!from_.empty())
            for (const PlaneRole role : all_roles) {
                const bool is_its_own = role == PlaneRole::colour && registration_.has_value();
                if (plane_of(raw, role).empty() || is_its_own) continue;
                add_plane(raw, role,
                          unbent(plane_of(raw, role), role == PlaneRole::depth ? no_depth_.value_or(0) : 0));
            }
        if (registration_ && !raw.colour.empty())
            add_plane(raw, PlaneRole::colour, plane_from(registration_->registered(raw.depth, raw.colour)));
        return {};
    }

    Result<void> look_at_cameras() {
        std::size_t moved = 0;
        double largest = 0;
        for (const Camera& camera : cameras_) {
            const PixelShift shift = shift_between(scene_.camera, camera, scene_.width, scene_.height);
            largest = std::max(largest, shift.length());
            if (!shift.moves()) continue;
            ++moved;
            if (!no_depth_ && !shift.is_inside)
                return input_error(
                    "depth.invalid is []: must have a code that means no depth, because by folder.cameras "
                    "frame " +
                    std::to_string(&camera - cameras_.data()) + " does not see all of the clip's pixels");
        }
        if (moved > 0)
            notes_.push_back("cameras differ: " + std::to_string(moved) + " of " +
                             std::to_string(cameras_.size()) +
                             " frames are brought onto the clip's camera, by up to " + short_number(largest) +
                             " pixels: each pixel has the depth of the nearest one that was stored");
        else if (!cameras_.empty())
            notes_.push_back("cameras differ by at most " + short_number(largest) +
                             " pixels: every pixel stays where it is");
        return {};
    }

    /// Finds each pixel's stored one. Depth, planar or range, keeps its value: a ray meets the same point.
    void take_pixels_of(const Camera& stored) {
        if (from_camera_ == stored) return;
        from_camera_ = stored;
        from_.clear();
        if (lens_.any() || shift_between(scene_.camera, stored, scene_.width, scene_.height).moves())
            from_ = stored_pixels(scene_, lens_, stored);
    }

    Plane unbent(const PlaneView& plane, std::uint16_t beyond) const {
        const int bytes = plane.bytes_per_sample * plane.channels;
        Image image = blank_image(plane.width, plane.height, plane.bytes_per_sample, plane.channels);
        std::uint8_t* to = image.samples.data();
        for (const std::int32_t from : from_) {
            if (from >= 0)
                std::memcpy(to, plane.row(from / plane.width) + std::ptrdiff_t{bytes} * (from % plane.width),
                            static_cast<std::size_t>(bytes));
            else if (plane.channels == 1)
                std::memcpy(to, &beyond, static_cast<std::size_t>(bytes));
            to += bytes;
        }
        return plane_from(std::move(image));
    }

    LensDistortion lens_;
    std::span<const Camera> cameras_;      // of the frames; empty: the scene's
    std::optional<Camera> from_camera_{};  // for which from_ was made
    std::vector<std::int32_t> from_{};     // stored pixel of each pixel; empty: the same one
    std::optional<std::uint16_t> no_depth_{};
    std::optional<ColourRegistration> registration_;
};

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
      margin_(1 + steepest_margin(camera_.fx, 1.5)),
      wide_margin_(1 + steepest_margin(camera_.fx, 2.5)),
      cells_x_(static_cast<int>(colour_.width / cell_) + 2),
      cells_y_(static_cast<int>(colour_.height / cell_) + 2) {
    depth_of_code_.resize(std::size_t{coding_.code_max} + 1);
    for (std::size_t code = 0; code < depth_of_code_.size(); ++code)
        if (coding_.is_valid(static_cast<std::uint16_t>(code)))
            depth_of_code_[code] = coding_.depth(static_cast<std::uint16_t>(code));
}

ColourRegistration::Place ColourRegistration::place_of(int x, int y, double length) const {
    const auto& r = colour_.from_depth.rotation;
    const auto& t = colour_.from_depth.translation;
    const Camera& to = colour_.camera;
    const double u = (x - camera_.cx) / camera_.fx, v = (y - camera_.cy) / camera_.fy;
    const double ahead = (r[6] * u + r[7] * v + r[8]) * length + t[2];
    if (!(length > 0) || !(ahead > 0)) return {};
    LensDistortion::Point point{((r[0] * u + r[1] * v + r[2]) * length + t[0]) / ahead,
                                ((r[3] * u + r[4] * v + r[5]) * length + t[1]) / ahead};
    if (!(point.x * point.x + point.y * point.y <= reach_ * reach_)) return {};
    if (colour_.lens.any()) point = colour_.lens.distorted(point);
    return {static_cast<float>(to.fx * point.x + to.cx), static_cast<float>(to.fy * point.y + to.cy),
            static_cast<float>(ahead)};
}

void ColourRegistration::place_all(const PlaneView& depth) {
    std::size_t at = 0;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x, ++at) {
            const std::size_t code = stored_code(depth, coding_, x, y);
            const double length = code < depth_of_code_.size() ? depth_of_code_[code] : 0;
            has_depth_[at] = length > 0;
            depth_[at] = static_cast<float>(planar_depth(camera_, coding_.semantics, x, y, length));
            places_[at] = place_of(x, y, static_cast<double>(depth_[at]));
        }
}

/// Places pixels without depth that lie, in their row, between two with depth, or beside one.
void ColourRegistration::place_holes() {
    for (int y = 0; y < height_; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
        for (int x = 0; x < width_;) {
            const int begin = x;
            while (x < width_ && !has_depth_[row + static_cast<std::size_t>(x)]) ++x;
            const float left = begin > 0 ? depth_[row + static_cast<std::size_t>(begin) - 1] : 0,
                        right = x < width_ ? depth_[row + static_cast<std::size_t>(x)] : 0;
            for (int k = begin; k < x; ++k) {
                const bool from_left = left > 0 && (!(right > 0) || k - begin < x - 1 - k);
                const bool is_beside = (from_left ? k - begin : x - 1 - k) < beside_surface;
                const float farther = std::max(left, right), beside = from_left ? left : right;
                place_hole(k, y, {is_beside ? beside : farther, farther, std::min(left, right)});
            }
            ++x;
        }
    }
}

/// Places a pixel at the first of these depths at which the colour camera sees it.
void ColourRegistration::place_hole(int x, int y, const std::array<float, 3>& depths) {
    const std::size_t at = pixel_place(x, y, width_);
    for (const float depth : depths) {
        if (!(depth > 0)) continue;
        depth_[at] = depth;
        places_[at] = place_of(x, y, static_cast<double>(depth));
        if (sight_of(places_[at]) == Sight::seen) return;
    }
}

/// Each point covers the four cells around it, so that no surface has gaps between its pixels. Surfaces go on
/// into holes beside them, which hide as well what is behind.
void ColourRegistration::find_nearest() {
    std::ranges::fill(nearest_, nothing_there);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const std::size_t at = pixel_place(x, y, width_);
            if (has_depth_[at]) {
                cover(places_[at]);
                continue;
            }
            for (const int side : {-1, 1}) {
                int beside = x + side;
                while (beside >= 0 && beside < width_ && std::abs(beside - x) < beside_surface &&
                       !has_depth_[pixel_place(beside, y, width_)])
                    beside += side;
                if (beside < 0 || beside >= width_) continue;
                if (const float depth = depth_[pixel_place(beside, y, width_)]; depth > 0)
                    cover(place_of(x, y, static_cast<double>(depth)));
            }
        }
}

void ColourRegistration::cover(const Place& place) {
    const float x = (place.x + 0.5F) * scale_ - 0.5F, y = (place.y + 0.5F) * scale_ - 0.5F;
    if (!(place.depth > 0) ||
        !(x > -1 && y > -1 && x < static_cast<float>(cells_x_) && y < static_cast<float>(cells_y_)))
        return;
    const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
    for (int j = std::max(top, 0); j <= std::min(top + 1, cells_y_ - 1); ++j)
        for (int i = std::max(left, 0); i <= std::min(left + 1, cells_x_ - 1); ++i) {
            float& nearest = nearest_[static_cast<std::size_t>(j * cells_x_ + i)];
            nearest = std::min(nearest, place.depth);
        }
}

/// Finds the nearest depth of each cell and the eight around it.
void ColourRegistration::spread_nearest() {
    const auto at = [this](int i, int j) { return pixel_place(i, j, cells_x_); };
    std::vector<float> row(static_cast<std::size_t>(cells_x_));  // least of three rows
    for (int j = 0; j < cells_y_; ++j) {
        const float *above = &nearest_[at(0, std::max(j - 1, 0))], *here = &nearest_[at(0, j)],
                    *below = &nearest_[at(0, std::min(j + 1, cells_y_ - 1))];
        for (std::size_t i = 0; i < row.size(); ++i) row[i] = std::min({above[i], here[i], below[i]});
        float* const to = &nearest_around_[at(0, j)];
        for (std::size_t i = 0; i < row.size(); ++i)
            to[i] = std::min({row[i - (i > 0)], row[i], row[std::min(i + 1, row.size() - 1)]});
    }
}

ColourRegistration::Sight ColourRegistration::sight_of(const Place& place) const {
    if (!(place.depth > 0) || !(place.x >= -0.5F && place.y >= -0.5F) ||
        !(place.x < static_cast<float>(colour_.width) - 0.5F &&
          place.y < static_cast<float>(colour_.height) - 0.5F))
        return Sight::outside;
    const int i = static_cast<int>((place.x + 0.5F) * scale_),
              j = static_cast<int>((place.y + 0.5F) * scale_);
    const auto cell = static_cast<std::size_t>(j * cells_x_ + i);
    const bool is_seen =
        place.depth <= nearest_[cell] * margin_ && place.depth <= nearest_around_[cell] * wide_margin_;
    return is_seen ? Sight::seen : Sight::hidden;
}

/// Fills the gaps of a row, or those that are left in a column.
void ColourRegistration::fill_line(std::size_t first, std::size_t step, std::size_t count) {
    const auto at = [first, step](std::size_t n) { return first + n * step; };
    for (std::size_t k = 0; k < count;) {
        if (sights_[at(k)] == Sight::seen) {
            ++k;
            continue;
        }
        const std::size_t begin = k;
        while (k < count && sights_[at(k)] != Sight::seen) ++k;
        const bool has_before = begin > 0, has_behind = k < count;
        if (k - begin > most_filled || (!has_before && !has_behind)) continue;
        const bool from_before = has_before && (!has_behind || depth_[at(begin - 1)] >= depth_[at(k)]);
        const std::size_t beside = at(from_before ? begin - 1 : k);
        for (std::size_t n = begin; n < k; ++n)
            if (sights_[at(n)] == Sight::hidden && from_[at(n)] < 0)
                from_[at(n)] = static_cast<std::int32_t>(beside);
    }
}

void ColourRegistration::fill_gaps() {
    for (std::size_t k = 0; k < from_.size(); ++k)
        from_[k] = sights_[k] == Sight::seen ? static_cast<std::int32_t>(k) : -1;
    const auto columns = static_cast<std::size_t>(width_), rows = static_cast<std::size_t>(height_);
    for (std::size_t y = 0; y < rows; ++y) fill_line(y * columns, 1, columns);
    for (std::size_t x = 0; x < columns; ++x) fill_line(x, columns, rows);
}

void ColourRegistration::look_at(const PlaneView& depth) {
    const std::size_t pixels = pixel_count(width_, height_);
    has_depth_.resize(pixels);
    depth_.resize(pixels);
    places_.resize(pixels);
    sights_.resize(pixels);
    from_.resize(pixels);
    nearest_.resize(pixel_count(cells_x_, cells_y_));
    nearest_around_.resize(nearest_.size());
    place_all(depth);
    find_nearest();
    spread_nearest();
    place_holes();
    std::size_t deep = 0, unseen = 0;
    for (std::size_t at = 0; at < places_.size(); ++at) {
        sights_[at] = sight_of(places_[at]);
        deep += has_depth_[at];
        unseen += has_depth_[at] && sights_[at] != Sight::seen;
    }
    fill_gaps();
    unseen_share_ = deep > 0 ? static_cast<double>(unseen) / static_cast<double>(deep) : 0;
    grey_share_ =
        static_cast<double>(std::count(from_.begin(), from_.end(), -1)) / static_cast<double>(from_.size());
}

Image ColourRegistration::registered(const PlaneView& depth, const PlaneView& colour) {
    look_at(depth);
    Image picture{width_, height_, 1, 3, {}};
    picture.samples.assign(3 * from_.size(), unseen_colour);
    std::uint8_t* to = picture.samples.data();
    for (const std::int32_t from : from_) {
        if (from >= 0) {
            const Place& place = places_[static_cast<std::size_t>(from)];
            const int x = static_cast<int>(place.x + 0.5F), y = static_cast<int>(place.y + 0.5F);
            std::memcpy(to, colour.row(y) + std::ptrdiff_t{3} * x, 3);
        }
        to += 3;
    }
    return picture;
}

Result<std::unique_ptr<ClipReader>> with_pinhole_frames(std::unique_ptr<ClipReader> clip) {
    if (!clip->scene().lens.any() && !clip->scene().colour_camera && clip->frame_cameras().empty())
        return clip;
    return opened_as<ClipReader>(std::make_unique<PinholeReader>(std::move(clip)));
}

}  // namespace touchable
