#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "engine/authoring/material_brush.hpp"
#include "engine/base/result.hpp"
#include "engine/camera/plugged_camera.hpp"
#include "engine/camera/shared_camera.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/replay_camera.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/still_maps.hpp"
#include "engine/scene/scene_description.hpp"
#include "player/session/camera_capture.hpp"
#include "player/session/camera_words.hpp"
#include "player/session/chosen_filters.hpp"
#include "player/session/relief_choice.hpp"
#include "player/session/shared_clip.hpp"

namespace touchable {

/// The temporal filter as a person wants it.
struct TemporalChoice {
    bool on = false;
    std::optional<DepthLength> noise;  ///< of the depth, scene units; nothing: what the scene says
};

/// All filters at once. Those that are unstated are chosen by measurement.
struct FiltersChoice {
    FilterSettings settings;  ///< of which levels and terrace_noise do not count
    UnstatedFilters unstated{};
};

/// A clip, and what a person wants of it instead of what it says itself. Nothing: the clip's own.
struct ClipChoice {
    std::filesystem::path file;
    std::optional<std::filesystem::path> scene_file;
    std::optional<SourceDescription> camera;  ///< of pictures without a scene file
    StillMaps maps;                           ///< in place of what it has itself
    std::optional<FiltersChoice> filters;     ///< before what follows, one by one
    std::optional<int> median, fill_holes;
    std::optional<TerraceRemoval> terraces;
    std::optional<TemporalChoice> temporal;
    std::optional<FrameInterpolation> interpolation;
    DepthAlignment alignment = DepthAlignment::automatic;  ///< of depth without a scale
    bool fill_from_motion = false;                         ///< holes, from frames that saw what is behind
    std::optional<ReliefChoice> relief;  ///< made of its colour, in place of the heights that it has
    /// What its segments feel like, in place of what it says itself; null: as it says.
    std::shared_ptr<const PaintedSegments> painted;
    std::optional<MeasuredFrames> measured;   ///< what its first frames said before; nothing: look again
    std::optional<CameraDelivery> as_camera;  ///< the clip is the recording that behaves like one
    std::optional<PluggedChoice> plugged;     ///< the clip is a camera, and `file` its name
    // What stays open from run to run; nothing: each opens its own.
    std::shared_ptr<SharedCamera> shared_camera;  ///< of `plugged`
    std::shared_ptr<SharedClip> shared_clip;      ///< of a clip that is no camera; as it was first opened
    std::shared_ptr<ReliefMemory> relief_memory;  ///< of the shared clip
    std::optional<CapturedFrames> filmed;  ///< the clip is the film of a camera, which had these frames

    /// What is touched is a camera.
    void take(const LiveCamera& camera);
    bool is_camera() const { return plugged || as_camera; }
    /// From now on, and for copies of this choice, the clip is opened once; does nothing of a camera.
    void share_clip();
    /// The clip, from its beginning.
    Result<std::unique_ptr<ClipReader>> open(Colour colour = Colour::wanted) const;

private:
    Result<std::unique_ptr<ClipReader>> open_relief(Colour colour) const;
    Result<std::unique_ptr<ClipReader>> open_stored(Colour colour) const;
    Result<std::unique_ptr<ClipReader>> open_anew(Colour colour) const;
};

struct OpenClip {
    std::unique_ptr<ClipReader> reader;
    Scene scene;                            ///< as the run applies it
    std::optional<ChosenFilters> chosen{};  ///< nothing: all filters were stated
};
/// The clip at its beginning; colour that nobody looks at is not decoded. Refused (ErrorKind::usage) where
/// what is wanted does not go with the clip. An error of kind interrupted soon after it was `given_up`,
/// whatever is read or waited for.
Result<OpenClip> open_chosen(const ClipChoice& choice, Colour colour, const std::stop_token& given_up = {});

}  // namespace touchable
