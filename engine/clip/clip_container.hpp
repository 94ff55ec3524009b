#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/given_file.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_file_reader.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/picture/demuxer.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable {

/// Which stream of a file is which plane.
struct ClipTrack {
    PlaneRole role;
    int stream = 0;
    std::optional<int> low_stream{};  ///< has the low bits of its samples; the high eight are in `stream`
    int low_bits = 0;
    bool is_lossless = false;  ///< so the file says of the whole track; of a picture its own bytes may
};

/// Of a file that is read up to where it ends, wherever that is: the frames that have all their pictures, and
/// whether there is a part of more.
struct WholePart {
    std::int64_t frames = 0;
    bool is_cut = false;
    bool is_uneven = false;  ///< tracks end at different frames
};

/// How a kind of container calls what describes a clip, in messages, and its newest format that is read.
struct ContainerWords {
    const char* scene;  ///< "scene.json"
    const char* times;  ///< "timestamps.txt"
    int newest_version;
};

/// How a kind of container holds a touchable clip. Errors name the file.
class ClipContainer {
public:
    virtual ~ClipContainer() = default;
    /// The file, from its first byte.
    virtual Result<std::unique_ptr<Demuxer>> open() = 0;
    /// The rate at which it was recorded.
    virtual Result<FrameRate> rate(const Demuxer& file) = 0;
    /// What it says of itself, its rate left open.
    virtual Result<SceneDescription> scene(const Demuxer& file, const FrameRate& recorded) = 0;
    /// Where its camera stood (timed_poses_text), if the file says it.
    virtual std::optional<std::string> poses(const Demuxer& /*file*/) { return std::nullopt; }
    /// Depth is the first. `scene`: that describes them.
    virtual Result<std::vector<ClipTrack>> tracks(const Demuxer& file, const Scene& scene) = 0;
    /// Whether a file just opened knows all its pictures.
    virtual bool has_whole_index() const { return false; }
    /// Nothing where the file promises how long it is.
    virtual Result<std::optional<WholePart>> whole_part(const Demuxer& /*file*/) {
        return std::optional<WholePart>();
    }
    /// What a person should know of all that, once it was asked for.
    const std::vector<std::string>& notes() const { return notes_; }
    const ContainerWords& words() const { return words_; }

protected:
    ClipContainer(const SourceFile& source, ContainerWords words);
    Error refuse(const std::string& what, Hints hints = {}) const;
    /// By the file's tags and, of frames at times of their own, this text. An error where it is no clip of
    /// ours, or of a version to come.
    Result<FrameRate> tagged_rate(const Demuxer& file, const std::optional<std::string>& own_times) const;
    /// As this text describes it. An error where its rate is not the recorded one; that of the frames' own
    /// times it does not say.
    Result<SceneDescription> described_by(const std::string& json, const FrameRate& recorded) const;

    SourceFile source_;
    std::string file_;
    ContainerWords words_;
    std::vector<std::string> notes_;
};

std::unique_ptr<ClipContainer> matroska_container(const SourceFile& file);
/// `told`: which tracks are which plane, whatever the file says of that itself.
std::unique_ptr<ClipContainer> mp4_container(const SourceFile& file,
                                             const std::optional<PlaneTracks>& told = {});

}  // namespace touchable
