#include "engine/formats/pinhole_frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/clip/reader_around.hpp"
#include "engine/formats/colour_registration.hpp"
#include "engine/formats/frame_cameras.hpp"

namespace touchable {
namespace {

std::int32_t nearest_pixel(double at) {
    return static_cast<std::int32_t>(std::clamp(std::floor(at + 0.5), -1.0, 1e6));
}

/// For each pixel of the clip's camera, the one of a picture by another that shows the same ray; -1: none.
/// Columns depend on columns alone, and rows on rows.
std::vector<std::int32_t> shifted_pixels(const Scene& scene, const Camera& stored) {
    const Camera& camera = scene.camera;
    std::vector<std::int32_t> columns, from;
    for (int x = 0; x < scene.width; ++x) {
        const std::int32_t column = nearest_pixel(stored.fx * ((x - camera.cx) / camera.fx) + stored.cx);
        columns.push_back(column < scene.width ? column : -1);
    }
    from.reserve(static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height));
    for (int y = 0; y < scene.height; ++y) {
        const std::int32_t row = nearest_pixel(stored.fy * ((y - camera.cy) / camera.fy) + stored.cy);
        const bool is_there = row >= 0 && row < scene.height;
        for (const std::int32_t column : columns)
            from.push_back(is_there && column >= 0 ? row * scene.width + column : -1);
    }
    return from;
}

/// The same where the pictures are by a lens that bends.
std::vector<std::int32_t> unbent_pixels(const Scene& scene, const LensDistortion& lens,
                                        const Camera& stored) {
    const Camera& camera = scene.camera;
    const double reach = lens.reach();
    std::vector<std::int32_t> from;
    from.reserve(static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height));
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            const LensPoint point{(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy};
            const LensPoint shown = lens.distorted(point);
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

/// Stored samples that are no depth; nothing where every one is.
std::optional<std::uint16_t> no_depth_code(const Scene& scene) {
    if (scene.depth.kind == DepthCodingKind::hue) return std::uint16_t{0};  // black
    for (int code = 0; code < (1 << scene.depth_bits); ++code)
        if (!scene.depth.is_valid(static_cast<std::uint16_t>(code))) return static_cast<std::uint16_t>(code);
    return {};
}

class PinholeReader final : public ReaderAround {
public:
    explicit PinholeReader(std::unique_ptr<ClipReader> clip)
        : ReaderAround(std::move(clip)),
          scene_(inner().scene()),
          notes_(inner().notes()),
          lens_(scene_.lens),
          cameras_(inner().frame_cameras()) {
        no_depth_ = no_depth_code(scene_);
        if (scene_.colour_camera) registration_.emplace(scene_);
        scene_.lens = {};
        scene_.colour_camera.reset();
        if (scene_.folder) scene_.folder->cameras.clear();
        if (scene_.folder) scene_.folder->camera_numbers = {};
    }
    Result<void> open();

    const Scene& scene() const override { return scene_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    std::span<const Camera> frame_cameras() const override { return {}; }
    Result<std::optional<RawFrame>> next() override;

private:
    Result<void> look_at_cameras();
    void take_pixels_of(const Camera& stored);
    Plane unbent(const PlaneView& plane, std::uint16_t beyond) const;

    Scene scene_;
    std::vector<std::string> notes_;
    LensDistortion lens_;
    std::span<const Camera> cameras_;      // of the frames; empty: the scene's
    std::optional<Camera> from_camera_{};  // that from_ is of
    std::vector<std::int32_t> from_{};     // of each pixel; empty: itself
    std::optional<std::uint16_t> no_depth_{};
    std::optional<ColourRegistration> registration_;
};

/// What a person should know, by frame 0.
Result<void> PinholeReader::open() {
    if (auto able = look_at_cameras(); !able) return able;
    if (lens_.any())
        notes_.push_back(
            "the lens of the depth camera is undone: each pixel has the depth of the nearest "
            "one that was stored");
    const bool has_colour = std::any_of(tracks().begin(), tracks().end(), [](const TrackInfo& track) {
        return track.role == role_name(PlaneRole::colour);
    });
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

Result<void> PinholeReader::look_at_cameras() {
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

/// Depth stays what it is, planar or range: the same ray from the same place meets the same point.
void PinholeReader::take_pixels_of(const Camera& stored) {
    if (from_camera_ == stored) return;
    from_camera_ = stored;
    from_.clear();
    if (lens_.any())
        from_ = unbent_pixels(scene_, lens_, stored);
    else if (shift_between(scene_.camera, stored, scene_.width, scene_.height).moves())
        from_ = shifted_pixels(scene_, stored);
}

Plane PinholeReader::unbent(const PlaneView& plane, std::uint16_t beyond) const {
    const int bytes = plane.bytes_per_sample * plane.channels;
    Image image{plane.width, plane.height, plane.bytes_per_sample, plane.channels, {}};
    image.samples.resize(from_.size() * static_cast<std::size_t>(bytes));
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

Result<std::optional<RawFrame>> PinholeReader::next() {
    auto frame = inner().next();
    if (!frame || !*frame) return frame;
    RawFrame& raw = **frame;
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
    return frame;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> with_pinhole_frames(std::unique_ptr<ClipReader> clip) {
    if (!clip->scene().lens.any() && !clip->scene().colour_camera && clip->frame_cameras().empty())
        return clip;
    auto reader = std::make_unique<PinholeReader>(std::move(clip));
    TRY(reader->open());
    return std::unique_ptr<ClipReader>(std::move(reader));
}

}  // namespace touchable
