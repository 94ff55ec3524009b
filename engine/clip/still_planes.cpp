#include "engine/clip/still_planes.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/reader_around.hpp"

namespace touchable {
namespace {

class StillPlanesReader final : public ReaderAround {
public:
    StillPlanesReader(std::unique_ptr<ClipReader> clip, const Scene& scene)
        : ReaderAround(std::move(clip)), scene_(scene), tracks_(inner().tracks()), notes_(inner().notes()) {}
    Result<void> lay(StillPlane still);

    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;

private:
    bool replace_track(const StillPlane& still);
    void forget_notes_of(PlaneRole role);

    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    std::vector<StillPlane> planes_;
};

/// Puts its track where the order of roles has it. Whether one of the clip's own went.
bool StillPlanesReader::replace_track(const StillPlane& still) {
    const auto role = [](const TrackInfo& track) {
        return role_named(track.role).value_or(PlaneRole::height);
    };
    const std::string name(role_name(still.role));
    const bool had_one = std::erase_if(tracks_, [&](const TrackInfo& track) { return track.role == name; });
    const auto after = std::find_if(tracks_.begin(), tracks_.end(),
                                    [&](const TrackInfo& track) { return role(track) > still.role; });
    tracks_.insert(after, still.info)->role = name;
    return had_one;
}

/// What was said of a plane that is not there any more, or of there being none.
void StillPlanesReader::forget_notes_of(PlaneRole role) {
    const std::string beginning = std::string(role_name(role)) + " is ";
    const auto of_none =
        role == PlaneRole::haptic ? default_touch_note(false, inner().scene()) : std::nullopt;
    std::erase_if(notes_, [&](const std::string& note) {
        return note.starts_with(beginning) || (of_none && note == *of_none);
    });
}

Result<void> StillPlanesReader::lay(StillPlane still) {
    const std::string file = still.files.front().string();
    forget_notes_of(still.role);
    const bool replaces = replace_track(still);
    notes_.push_back(file + " is " + std::string(role_name(still.role)) +
                     (still.at ? ", frame by frame" : " of every frame") +
                     (replaces ? ", in place of the clip's own" : ""));
    std::move(still.notes.begin(), still.notes.end(), std::back_inserter(notes_));
    const TrackInfo& stored = still.info;
    if (stored.width != scene_.width || stored.height != scene_.height)
        notes_.push_back(resampling_note(still.role, stored.width, stored.height, scene_));
    TRY_ASSIGN(auto fitted, fit_plane(still.role, std::move(still.plane), scene_, file));
    still.plane = std::move(fitted);
    for (auto& input : still.files) add_input(std::move(input));
    planes_.push_back(std::move(still));
    return {};
}

Result<std::optional<RawFrame>> StillPlanesReader::next() {
    auto frame = ReaderAround::next();
    if (!frame || !*frame) return frame;
    for (const StillPlane& still : planes_) {
        TRY_ASSIGN(auto plane,
                   still.at ? still.at((*frame)->number, (*frame)->time_ns) : Result<Plane>(still.plane));
        add_plane(**frame, still.role, std::move(plane));
    }
    return frame;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> with_still_planes(std::unique_ptr<ClipReader> clip,
                                                      std::vector<StillPlane> planes, const Scene& scene) {
    if (planes.empty()) return clip;
    if (auto valid = validate(scene); !valid)
        return input_error(planes.front().files.front().string() + ": " + valid.error().message);
    auto reader = std::make_unique<StillPlanesReader>(std::move(clip), scene);
    for (StillPlane& plane : planes) TRY(reader->lay(std::move(plane)));
    return std::unique_ptr<ClipReader>(std::move(reader));
}

}  // namespace touchable
