#include "engine/import/pinhole_frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "engine/import/colour_registration.hpp"
#include "engine/import/number_words.hpp"
#include "engine/media/plane_role.hpp"
#include "engine/media/reader_around.hpp"

namespace touchable {
namespace {

/// For each pixel of a pinhole's picture, the one that the lens showed it in; -1: none.
std::vector<std::int32_t> unbent_pixels(const Scene& scene) {
    const Camera& camera = scene.camera;
    const double reach = scene.lens.reach();
    std::vector<std::int32_t> from;
    from.reserve(static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height));
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            const LensPoint point{(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy};
            const LensPoint shown = scene.lens.distorted(point);
            const double column = std::floor(camera.fx * shown.x + camera.cx + 0.5),
                         row = std::floor(camera.fy * shown.y + camera.cy + 0.5);
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
        : ReaderAround(std::move(clip)), scene_(inner().scene()), notes_(inner().notes()) {
        if (scene_.lens.any()) from_ = unbent_pixels(scene_);
        no_depth_ = no_depth_code(scene_).value_or(0);
        if (scene_.colour_camera) registration_.emplace(scene_);
        scene_.lens = {};
        scene_.colour_camera.reset();
    }
    Result<void> open();

    const Scene& scene() const override { return scene_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;

private:
    Plane unbent(const PlaneView& plane, std::uint16_t beyond) const;

    Scene scene_;
    std::vector<std::string> notes_;
    std::vector<std::int32_t> from_;  // of each pixel; empty: itself
    std::uint16_t no_depth_ = 0;
    std::optional<ColourRegistration> registration_;
};

/// What a person should know, by frame 0.
Result<void> PinholeReader::open() {
    if (!from_.empty())
        notes_.push_back(
            "the lens of the depth camera is undone: each pixel has the depth of the nearest "
            "one that was stored");
    const bool has_colour = std::any_of(tracks().begin(), tracks().end(), [](const TrackInfo& track) {
        return track.role == role_name(PlaneRole::colour);
    });
    if (!registration_ || !has_colour || is_live()) return {};
    const auto first = next();
    if (!first) return first.error();
    if (auto back = rewind(); !back || !*first) return back;
    notes_.push_back(
        "colour is brought onto depth's pixels: in frame 0 its camera does not see " +
        short_number(std::round(1000 * registration_->unseen_share()) / 10) +
        " % of those with depth: they have the colour beside them, or are grey where its picture ends");
    return {};
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
    if (!from_.empty())
        for (const PlaneRole role : all_roles) {
            const bool is_its_own = role == PlaneRole::colour && registration_.has_value();
            if (plane_of(raw, role).empty() || is_its_own) continue;
            add_plane(raw, role, unbent(plane_of(raw, role), role == PlaneRole::depth ? no_depth_ : 0));
        }
    if (registration_ && !raw.colour.empty())
        add_plane(raw, PlaneRole::colour, plane_from(registration_->registered(raw.depth, raw.colour)));
    return frame;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> with_pinhole_frames(std::unique_ptr<ClipReader> clip) {
    if (!clip->scene().lens.any() && !clip->scene().colour_camera) return clip;
    auto reader = std::make_unique<PinholeReader>(std::move(clip));
    if (auto opened = reader->open(); !opened) return opened.error();
    return std::unique_ptr<ClipReader>(std::move(reader));
}

}  // namespace touchable
