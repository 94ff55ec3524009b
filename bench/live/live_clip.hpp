#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/content/scenes.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// A clip that a live case plays: what its name tells.
struct LiveClip {
    std::string scene;  ///< "globe", "moving"
    int width = 1920, height = 1080;
    std::vector<PlaneRole> planes{all_roles.begin(), all_roles.end()};
    int frames = 30;
    Archive archive = Archive::fast;
};

/// The pictures of a scene, as many as differ; a longer clip repeats them.
struct ScenePictures {
    Scene scene;
    std::vector<RawFrame> frames;

    const RawFrame& of(std::int64_t frame) const {
        return frames[static_cast<std::size_t>(frame) % frames.size()];
    }
};

/// Clips in a folder that goes with this, and the pictures they were made of. Each is made when it is first
/// asked for.
class LiveClips {
public:
    explicit LiveClips(int different_frames) : different_frames_(different_frames) {}
    ~LiveClips();
    LiveClips(const LiveClips&) = delete;
    LiveClips& operator=(const LiveClips&) = delete;

    Result<std::filesystem::path> file(const LiveClip& clip);
    /// With the planes of the clip alone.
    Result<std::shared_ptr<const ScenePictures>> pictures(const LiveClip& clip);
    /// A place for a file of this name.
    Result<std::filesystem::path> place(const std::string& name);

private:
    int different_frames_;
    std::filesystem::path folder_;
    std::map<std::string, std::filesystem::path> files_;
    std::string scene_name_;  // of the pictures that are kept
    std::shared_ptr<const ScenePictures> scene_;
};

}  // namespace touchable
