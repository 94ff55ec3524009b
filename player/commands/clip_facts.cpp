#include "player/commands/clip_facts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/stop_request.hpp"
#include "engine/base/trigonometry.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/known_camera.hpp"
#include "engine/scene/stored_code.hpp"
#include "engine/scene/terraces.hpp"
#include "engine/stream/stream_url.hpp"
#include "player/commands/setting_words.hpp"

namespace touchable {
namespace {

/// Angle that `pixels` span, seen from the centre `c` at focal length `f`.
double field_of_view_degrees(int pixels, double c, double f) {
    return (arctangent((c + 0.5) / f) + arctangent((pixels - 0.5 - c) / f)) * 180.0 / pi;
}

Kappa kappa_at(const Scene& scene, double depth) {
    return {depth, kappa_of_depth(scene, depth)};
}

/// Share of invalid stored values and the range of the valid ones, in the first frame.
void add_first_frame(const RawFrame& frame, ClipFacts& facts) {
    const DepthCoding& coding = facts.scene.depth;
    std::int64_t invalid = 0;
    std::uint16_t least = 65535, greatest = 0;
    for (int y = 0; y < frame.depth.height && !stop_requested(); ++y)
        for (int x = 0; x < frame.depth.width; ++x) {
            const std::uint16_t code = stored_code(frame.depth, coding, x, y);
            if (!coding.is_valid(code)) {
                ++invalid;
                continue;
            }
            least = std::min(least, code);
            greatest = std::max(greatest, code);
        }
    const auto pixels = static_cast<double>(frame.depth.width) * frame.depth.height;
    facts.invalid_pct = 100.0 * static_cast<double>(invalid) / pixels;
    if (least > greatest) return;
    facts.nearest = coding.depth(coding.deeper_is_higher() ? least : greatest);
    facts.farthest = coding.depth(coding.deeper_is_higher() ? greatest : least);
}

}  // namespace

bool ClipFacts::has_track(const std::string& role) const {
    return std::any_of(tracks.begin(), tracks.end(),
                       [&](const TrackInfo& track) { return track.role == role; });
}

Result<ClipFacts> clip_facts(const ClipChoice& choice) {
    TRY_ASSIGN(auto clip, open_chosen(choice, Colour::left_out));
    ClipFacts facts;
    facts.clip = without_passphrase(choice.file.string());
    facts.scene = clip.scene;
    facts.chosen = clip.chosen;
    if (facts.chosen) {
        facts.measured = facts.chosen->measured;
    } else {
        TRY_ASSIGN(auto measured, measure_depth(clip.reader, facts.scene));
        facts.measured = std::move(measured.depth);
    }
    TRY_ASSIGN(const auto first, clip.reader->next());
    if (!first) return input_error(facts.clip + " has no frames; a clip needs at least one");
    facts.tracks = clip.reader->tracks();
    facts.frames = clip.reader->frame_count();
    std::vector<Remark> remarks = remarks_of(*clip.reader);
    if (facts.measured)
        if (auto doubt = unit_doubt(facts.measured->median * facts.scene.metres_per_unit,
                                    "a scene file's metres_per_unit and depth say otherwise",
                                    {{Setting::scene_file, "FILE"}})) {
            const auto there = std::find_if(remarks.begin(), remarks.end(), doubts_unit);
            facts.unit_doubt = remark_with_options(there == remarks.end() ? *doubt : *there);
            if (there == remarks.end()) remarks.push_back(std::move(*doubt));
        }
    facts.notes = remarks_with_options(remarks);
    add_first_frame(*first, facts);
    if (stop_requested()) return interrupted_error();

    const Camera& camera = facts.scene.camera;
    facts.fov_x_degrees = field_of_view_degrees(facts.scene.width, camera.cx, camera.fx);
    facts.fov_y_degrees = field_of_view_degrees(facts.scene.height, camera.cy, camera.fy);
    const DepthCoding& coding = facts.scene.depth;
    const double near = coding.near > 0 ? coding.near : facts.nearest > 0 ? facts.nearest : coding.far;
    facts.near = kappa_at(facts.scene, near);
    facts.mid = kappa_at(facts.scene, 0.5 * (near + coding.far));
    facts.far = kappa_at(facts.scene, coding.far);
    return facts;
}

}  // namespace touchable
