#include "engine/authoring/clip_quality.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/authoring/pumping.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/far_plane.hpp"
#include "engine/scene/terraces.hpp"
#include "engine/scene/valid_pixel.hpp"
#include "engine/surface/code_picture.hpp"

namespace touchable {
namespace {

/// Where a flat place steps up or down by one level: pixels of one code on the one side, of another on the
/// other.
std::vector<std::uint8_t> level_steps(const CodePicture& codes, const Scene& scene) {
    std::vector<std::uint8_t> marks(codes.codes.size());
    const auto depth = [&](int code) { return scene.depth.depth(static_cast<std::uint16_t>(code)); };
    for (int y = 0; y < codes.height; ++y) {
        const int* row = codes.row(y);
        for (int x = 1; x + 2 < codes.width; ++x) {
            if (row[x] < 0 || row[x + 1] < 0 || row[x] == row[x + 1]) continue;
            if (row[x - 1] != row[x] || row[x + 2] != row[x + 1]) continue;
            const double step = std::abs(depth(row[x + 1]) - depth(row[x]));
            if (step < 1.6 * level_distance(scene, depth(row[x])))
                marks[static_cast<std::size_t>(y) * static_cast<std::size_t>(codes.width) +
                      static_cast<std::size_t>(x)] = 1;
        }
    }
    return marks;
}

Image picture_of(const RawFrame& frame, const CodePicture& codes, const Scene& scene) {
    Image image{codes.width, codes.height, 1, 3, {}};
    image.samples.reserve(codes.codes.size() * 3);
    for (int y = 0; y < codes.height; ++y)
        for (int x = 0; x < codes.width; ++x) {
            if (!frame.colour.empty()) {
                const std::uint8_t* rgb = frame.colour.row(y) + std::ptrdiff_t{3} * x;
                image.samples.insert(image.samples.end(), rgb, rgb + 3);
                continue;
            }
            const int code = codes.row(y)[x];
            const double depth = code < 0 ? 0 : scene.depth.depth(static_cast<std::uint16_t>(code));
            const double grey = code < 0 ? 0 : 255 * scene.depth.nearest_depth() / depth;
            image.samples.insert(image.samples.end(), 3, static_cast<std::uint8_t>(grey));
        }
    return image;
}

}  // namespace

Result<ClipQuality> measure_quality(ClipReader& clip, const Scene& scene,
                                    const std::function<void(std::int64_t)>& progress) {
    FrameTimesEstimator times;
    PumpingEstimator pumping(scene.depth);
    ColourEdges colour(scene);
    HapticValuesEstimator haptic(scene);
    bool has_haptic = false;
    ClipQuality quality;
    // What belongs to a picture and not to its change is looked at in some of them.
    const auto telling = telling_frames(clip.frame_count().value_or(first_frames));
    for (std::int64_t read = 0;; ++read) {
        if (stop_requested()) return interrupted_error();
        TRY_ASSIGN(const auto next, clip.next());
        if (!next) break;
        const RawFrame& frame = *next;
        times.add(frame);
        pumping.add(frame);
        if (!has_valid_pixel(frame.depth, scene.depth) && quality.blank++ == 0)
            quality.first_blank = frame.number;
        if (read == 0) {
            const CodePicture codes = code_picture(frame.depth, scene.depth);
            quality.where.picture = picture_of(frame, codes, scene);
            quality.where.level_steps = level_steps(codes, scene);
            quality.where.colour_edges.assign(codes.codes.size(), 0);
        }
        if (std::binary_search(telling.begin(), telling.end(), read)) {
            if (!frame.colour.empty()) colour.add(frame, read == 0 ? &quality.where.colour_edges : nullptr);
            if (!frame.haptic.empty()) haptic.add(frame, read == 0 ? &quality.where.haptic : nullptr);
            has_haptic = has_haptic || !frame.haptic.empty();
        }
        progress(read + 1);
    }
    quality.times = times.times();
    quality.pumping = pumping.share();
    quality.colour = colour.fit();
    if (has_haptic) quality.haptic = haptic.values();
    return quality;
}

}  // namespace touchable
