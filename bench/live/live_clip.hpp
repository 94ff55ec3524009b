// SPDX-License-Identifier: Apache-2.0
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

/// A clip of a live case, as described by the case's name.
struct LiveClip {
    std::string scene;  ///< "globe", "moving"
    int width = 1920, height = 1080;
    std::vector<PlaneRole> planes{all_roles.begin(), all_roles.end()};
    int frames = 30;
    Archive archive = Archive::fast;
};

/// The different pictures of a scene; a longer clip repeats them.
struct ScenePictures {
    Scene scene;
    std::vector<RawFrame> frames;

    const RawFrame& of(std::int64_t frame) const {
        return frames[static_cast<std::size_t>(frame) % frames.size()];
    }
};

/// Clips in a temporary folder, removed by the destructor, and their source pictures. Each is made on first
/// use.
class LiveClips {
public:
    explicit LiveClips(int different_frames) : different_frames_(different_frames) {}
    ~LiveClips();
    LiveClips(const LiveClips&) = delete;
    LiveClips& operator=(const LiveClips&) = delete;

    Result<std::filesystem::path> file(const LiveClip& clip);
    /// The source pictures, with only the clip's planes.
    Result<std::shared_ptr<const ScenePictures>> pictures(const LiveClip& clip);
    /// Path for a file of this name in the folder.
    Result<std::filesystem::path> place(const std::string& name);

private:
    int different_frames_;
    std::filesystem::path folder_;
    std::map<std::string, std::filesystem::path> files_;
    std::string scene_name_;  // scene of the cached pictures
    std::shared_ptr<const ScenePictures> scene_;
};

}  // namespace touchable
