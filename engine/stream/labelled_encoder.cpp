#include "engine/stream/labelled_encoder.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/clip_muxing.hpp"
#include "engine/clip/mp4_writer.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/stream/picture_message.hpp"

namespace touchable {
namespace {

constexpr PlaneRole labelled_order[] = {PlaneRole::colour, PlaneRole::depth, PlaneRole::haptic,
                                        PlaneRole::height};

/// Of frames at times of their own the mean rate: each picture says when it was taken.
std::string sent_scene(const SceneDescription& described) {
    SceneDescription said = said_of_clip(described);
    said.scene.rate.own_times = nullptr;
    return scene_to_json(said);
}

bool fits(const PlaneView& plane, const PlaneView& form) {
    return !plane.empty() && plane.width == form.width && plane.height == form.height &&
           plane.channels == form.channels && plane.bytes_per_sample == form.bytes_per_sample;
}

bool is_begin_of_plane(PlaneRole role, PlanePart part) {
    return role == PlaneRole::depth && part != PlanePart::low;
}

}  // namespace

std::string LabelledEncoder::name(std::size_t track) const {
    const Track& named = tracks_[track];
    return std::string(role_name(named.role)) + (named.part == PlanePart::low ? low_track_suffix : "");
}

Result<void> LabelledEncoder::describe(std::size_t track, AVCodecParameters& stored) const {
    return tracks_[track].encoder->describe(stored);
}

Result<void> LabelledEncoder::add_track(Track track, const RawFrame& first, const Scene& scene,
                                        TrackCoding coding) {
    const PlaneView& plane = plane_of(first, track.role);
    track.form = plane;
    TRY_ASSIGN(auto encoder,
               TrackEncoder::open(track.role, coding, part_of(plane, track.part, track.bits - 8, track.bytes),
                                  scene));
    track.encoder = std::move(encoder);
    tracks_.push_back(std::move(track));
    return {};
}

Result<LabelledEncoder> LabelledEncoder::open(const RawFrame& first, const SceneDescription& described,
                                              TrackCoding touch, TrackCoding colour) {
    silence_ffmpeg();
    LabelledEncoder made;
    made.scene_sei_ = sei_of_scene(sent_scene(described));
    const Scene& scene = described.scene;
    for (const PlanePart part : {PlanePart::high, PlanePart::low})
        for (const PlaneRole role : labelled_order) {
            const PlaneView& plane = plane_of(first, role);
            const bool is_wide = plane.bytes_per_sample == 2;
            if (plane.empty() || (part == PlanePart::low && !is_wide)) continue;
            const int bits =
                role == PlaneRole::depth ? scene.depth_bits : std::max(8, height_bits(scene.height_coding));
            Track track{role, is_wide ? part : PlanePart::whole, is_wide ? bits : 8};
            const TrackCoding coding = role == PlaneRole::colour ? colour : touch;
            TRY(made.add_track(std::move(track), first, scene, coding));
        }
    return made;
}

Result<std::vector<PacketPtr>> LabelledEncoder::encode(const RawFrame& frame, const PictureLabel& label,
                                                       bool is_key) {
    std::vector<PacketPtr> packets;
    for (Track& track : tracks_) {
        const PlaneView& plane = plane_of(frame, track.role);
        if (!fits(plane, track.form))
            return input_error("frame " + std::to_string(frame.number) + ": its plane " +
                               std::string(role_name(track.role)) + " is not like that of the first frame");
        const PlaneView part = part_of(plane, track.part, track.bits - 8, track.bytes);
        std::vector<std::string> messages{sei_of({track.role, track.part, track.bits, label}, part)};
        if (is_key && is_begin_of_plane(track.role, track.part)) messages.push_back(scene_sei_);
        TRY_ASSIGN(auto packet, track.encoder->encode(part, is_key, messages));
        packets.push_back(std::move(packet));
    }
    return packets;
}

}  // namespace touchable
