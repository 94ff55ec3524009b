#include "engine/camera/colour_beside.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/camera/node_facts.hpp"

namespace touchable {
namespace {

/// As many pixels as the depth has, as nearly as the format offers them.
ModeWish wish_beside(const NodeFormat& format, const StreamFormat& depth,
                     const std::optional<FrameRate>& rate) {
    ModeWish wish;
    if (rate) wish.rate = per_second(*rate);
    const std::int64_t wanted = std::int64_t{depth.width} * depth.height;
    const auto distance = [wanted](const NodeMode& mode) {
        return std::abs(std::int64_t{mode.width} * mode.height - wanted);
    };
    const auto nearest =
        std::min_element(format.modes.begin(), format.modes.end(),
                         [&](const NodeMode& a, const NodeMode& b) { return distance(a) < distance(b); });
    if (nearest == format.modes.end()) return wish;
    wish.width = nearest->width;
    wish.height = nearest->height;
    return wish;
}

}  // namespace

ColourBeside::ColourBeside(std::unique_ptr<V4l2Stream> stream, std::string node)
    : stream_(std::move(stream)), node_(std::move(node)) {
    const StreamFormat& format = stream_->format();
    track_ = {"colour", "v4l2", format_text(format.code), format.width, format.height};
}

Result<std::unique_ptr<ColourBeside>> ColourBeside::open(const std::shared_ptr<VideoSystem>& system,
                                                         const std::string& node, const StreamFormat& depth,
                                                         const std::optional<FrameRate>& rate) {
    TRY_ASSIGN(const auto facts, look_at_node(*system, node));
    const auto format = std::find_if(facts.formats.begin(), facts.formats.end(),
                                     [](const NodeFormat& each) { return is_colour_format(each.code); });
    if (format == facts.formats.end()) {
        std::string there;
        for (const NodeFormat& each : facts.formats)
            there += (there.empty() ? "" : ", ") + format_text(each.code);
        return input_error(node + ": gives no colour that can be shown (" +
                           (there.empty() ? "nothing" : there) +
                           "); colour= takes a node of RGB3, BGR3, YUYV, UYVY, NV12 or MJPG");
    }
    TRY_ASSIGN(auto stream, V4l2Stream::open(system, facts, *format, wish_beside(*format, depth, rate)));
    return std::unique_ptr<ColourBeside>(new ColourBeside(std::move(stream), node));
}

Result<void> ColourBeside::look() {
    TRY_ASSIGN(auto taken, stream_->take(V4l2Stream::Which::newest));
    if (!taken) return {};
    // A few: depth may come later than the colour of its moment.
    constexpr std::size_t most = 4;
    if (recent_.size() == most) recent_.erase(recent_.begin());
    recent_.push_back(std::move(*taken));
    return {};
}

std::optional<Plane> ColourBeside::nearest(std::int64_t at_ns, const Scene& scene) {
    if (recent_.empty()) return plane_;
    const auto distance = [at_ns](const TakenPicture& picture) { return std::abs(picture.at_ns - at_ns); };
    const auto nearest = std::min_element(
        recent_.begin(), recent_.end(),
        [&](const TakenPicture& a, const TakenPicture& b) { return distance(a) < distance(b); });
    if (plane_ && plane_at_ns_ == nearest->at_ns) return plane_;
    auto rgb = converter_.rgb(*nearest, stream_->format());
    if (rgb) rgb = fit_plane(PlaneRole::colour, std::move(*rgb), scene, node_);
    plane_at_ns_ = nearest->at_ns;
    if (rgb) plane_ = std::move(*rgb);  // otherwise the one before
    return plane_;
}

}  // namespace touchable
