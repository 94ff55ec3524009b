#include "engine/media/far_plane.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "engine/stop_request.hpp"

namespace touchable {
namespace {

constexpr std::int64_t stray_of = 10'000;  // one valid pixel in so many may be stray
constexpr double margin = 1.05;

/// The next frame's depth, if there is one.
Result<bool> look(ClipReader& clip, FarPlaneEstimator& estimator) {
    if (stop_requested())
        return Error{ErrorKind::interrupted, "interrupted while the clip's far plane was searched"};
    const auto frame = clip.next();
    if (!frame) return frame.error();
    if (*frame) estimator.add((*frame)->depth);
    return frame->has_value();
}

}  // namespace

std::vector<std::int64_t> telling_frames(std::int64_t count) {
    std::vector<std::int64_t> frames;
    for (std::int64_t k = 0; k < std::min(count, first_frames); ++k) frames.push_back(k);
    const std::int64_t rest = count - first_frames;
    for (std::int64_t k = 1; k <= std::min(rest, spread_frames); ++k)
        frames.push_back(first_frames + rest * k / std::min(rest, spread_frames) - 1);
    return frames;
}

void FarPlaneEstimator::add(const PlaneView& depth) {
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x) ++pixels_[static_cast<std::size_t>(depth.sample(x, y))];
    ++frames_;
}

Result<std::string> FarPlaneEstimator::settle(Scene& scene) const {
    std::int64_t valid = 0;
    const auto is_valid = [&](int code) { return coding_.is_valid(static_cast<std::uint16_t>(code)); };
    for (int code = 0; code < 65536; ++code)
        if (is_valid(code)) valid += pixels_[static_cast<std::size_t>(code)];
    if (valid == 0) return input_error("no frame has a valid depth: give depth.far in the scene file");
    std::int64_t beyond = 0;
    int deepest = 65535;
    for (;; --deepest) {
        if (!is_valid(deepest)) continue;
        const std::int64_t here = pixels_[static_cast<std::size_t>(deepest)];
        if (beyond + here > valid / stray_of) break;
        beyond += here;
    }
    const double depth = coding_.depth(static_cast<std::uint16_t>(deepest));
    scene.depth.far = depth * margin;
    scene.far_from_frames = false;
    derive_valid_range(scene.depth);
    if (auto settled = validate(scene); !settled) return settled.error();
    // Some of the strays are within the margin.
    std::int64_t lost = 0;
    for (int code = deepest + 1; code < 65536; ++code)
        if (is_valid(code) && !scene.depth.is_valid(static_cast<std::uint16_t>(code)))
            lost += pixels_[static_cast<std::size_t>(code)];
    std::array<char, 160> words{};
    std::snprintf(words.data(), words.size(),
                  "depth.far is %.6g, 5 %% beyond the depth that 1 pixel in %d exceeds at most (%d frame%s)",
                  scene.depth.far, static_cast<int>(stray_of), frames_, frames_ == 1 ? "" : "s");
    std::string note = words.data();
    if (lost == 0) return note;
    std::snprintf(words.data(), words.size(), "; %.2g %% of the pixels lie beyond it and count as holes",
                  100 * static_cast<double>(lost) / static_cast<double>(valid));
    note += words.data();
    return note;
}

Result<std::string> find_far_plane(ClipReader& clip, Scene& scene) {
    FarPlaneEstimator estimator(scene.depth);
    const auto is_fatal = [](const Error& error) { return error.kind == ErrorKind::interrupted; };
    std::int64_t looked = 0;  // frames in a row
    for (bool more = true; more && looked < first_frames;) {
        const auto there = look(clip, estimator);
        if (!there && (looked == 0 || is_fatal(there.error()))) return there.error();
        more = there && *there;
        looked += more;
    }
    for (const std::int64_t wanted : telling_frames(clip.frame_count().value_or(0))) {
        const std::int64_t frame = clip.access_point(wanted);
        if (wanted < looked || frame < looked) continue;
        if (auto sought = clip.seek(frame); !sought) continue;
        looked = frame + 1;
        if (const auto there = look(clip, estimator); !there && is_fatal(there.error())) return there.error();
    }
    auto note = estimator.settle(scene);
    if (!note) return note;
    if (auto back = clip.rewind(); !back) return back.error();
    return note;
}

}  // namespace touchable
