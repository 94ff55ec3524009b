// SPDX-License-Identifier: Apache-2.0
#include "bench/live/live_clip.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "engine/clip/clip_file.hpp"
#include "player/run/terminal.hpp"

namespace touchable {
namespace {

std::string scene_key(const LiveClip& clip) {
    return clip.scene + "-" + std::to_string(clip.width) + "x" + std::to_string(clip.height);
}

std::string file_key(const LiveClip& clip) {
    std::string key = scene_key(clip) + "-" + std::to_string(clip.frames) +
                      (clip.archive == Archive::small ? "-small" : "");
    for (const PlaneRole role : clip.planes) key.append("-").append(role_name(role));
    return key;
}

/// Removes planes that the clip does not have.
void keep_planes(const LiveClip& clip, RawFrame& frame) {
    for (const PlaneRole role : all_roles)
        if (std::ranges::count(clip.planes, role) == 0) plane_of(frame, role) = {};
}

Result<void> write_clip(const ScenePictures& pictures, const LiveClip& clip,
                        const std::filesystem::path& file) {
    SceneDescription described(pictures.scene);
    described.unstated.filters = all_unstated;  // as in `touchable make`
    auto writer = create_clip(file, described, {.archive = clip.archive});
    if (!writer) return writer.error();
    for (std::int64_t n = 0; n < clip.frames; ++n) {
        if (stop_requested()) return interrupted_error();
        RawFrame frame = pictures.of(n);
        frame.number = n;
        frame.time_ns = pictures.scene.rate.time_ns(n);
        if (auto written = (*writer)->write(frame); !written) return written;
    }
    return (*writer)->finish();
}

}  // namespace

LiveClips::~LiveClips() {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

Result<std::filesystem::path> LiveClips::place(const std::string& name) {
    if (folder_.empty()) {
        std::error_code unknown;
        std::string folder =
            (std::filesystem::temp_directory_path(unknown) / "touchable-bench-XXXXXX").string();
        if (unknown || !mkdtemp(folder.data()))
            return input_error(folder + ": no folder for clips can be made there");
        folder_ = folder;
        catch_interrupts();  // so that an interrupted run removes the folder
    }
    return folder_ / name;
}

Result<std::shared_ptr<const ScenePictures>> LiveClips::pictures(const LiveClip& clip) {
    if (scene_name_ != scene_key(clip)) {
        scene_.reset();
        auto made = make_scene(
            clip.scene, {.width = clip.width, .height = clip.height, .properties = clip.scene == "globe"});
        if (!made) return made.error();
        auto pictures = std::make_shared<ScenePictures>();
        pictures->scene = (*made)->scene();
        for (int n = 0; n < different_frames_ && !stop_requested(); ++n)
            pictures->frames.push_back((*made)->frame(n));
        if (stop_requested()) return interrupted_error();
        scene_ = std::move(pictures);
        scene_name_ = scene_key(clip);
    }
    auto chosen = std::make_shared<ScenePictures>(*scene_);
    for (RawFrame& frame : chosen->frames) keep_planes(clip, frame);
    return std::shared_ptr<const ScenePictures>(std::move(chosen));
}

Result<std::filesystem::path> LiveClips::file(const LiveClip& clip) {
    const std::string key = file_key(clip);
    if (const auto known = files_.find(key); known != files_.end()) return known->second;
    auto file = place(key + ".mkv");
    if (!file) return file;
    const auto source = pictures(clip);
    if (!source) return source.error();
    if (auto written = write_clip(**source, clip, *file); !written) return written.error();
    files_[key] = *file;
    return *file;
}

}  // namespace touchable
