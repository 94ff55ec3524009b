#pragma once

// What readers of cameras have in common: what depth means, and what a camera that is open says of its clip.

#include <cstdint>
#include <filesystem>
#include <span>

#include "engine/base/result.hpp"
#include "engine/camera/v4l2_stream.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a camera's depth means, and as its remarks what was assumed.
struct DepthMeaning {
    Scene scene;  ///< far plane and all, but for the rate
    UnstatedFilters unstated_filters{};
    std::vector<std::filesystem::path> inputs{};  ///< files that were read for it
};

/// By what is known of the camera, and by its first pictures, of 16 bits in host order: as guess_camera, but
/// that Z16 is millimetres unless `known` says otherwise. The far plane is well behind what they show, for
/// what is not seen yet. Errors begin with the node.
Result<DepthMeaning> meaning_of_depth(const NodeFacts& facts, std::uint32_t format,
                                      std::span<const PlaneView> first, const SourceDescription& known);

/// By a scene file, whose size is that of the pictures.
Result<DepthMeaning> meaning_in_file(const NodeFacts& facts, std::span<const PlaneView> first,
                                     const std::filesystem::path& scene_file);

/// A camera as a clip without an end; a derived class takes its frames.
class CameraReader : public ClipReader {
public:
    const Scene& scene() const final { return scene_; }
    UnstatedFilters unstated_filters() const final { return unstated_filters_; }
    const std::vector<TrackInfo>& tracks() const final { return tracks_; }
    std::optional<std::int64_t> frame_count() const final { return std::nullopt; }
    const std::vector<std::string>& notes() const final { return notes_; }
    Result<void> rewind() final { return seek(0); }
    Result<void> seek(std::int64_t frame) final { return run_.seek(frame); }
    bool is_live() const final { return true; }
    void interrupt() final { run_.interrupt(); }

protected:
    /// `name`: of the camera, in messages.
    explicit CameraReader(std::string name) : run_(std::move(name)) {}
    void take_meaning(DepthMeaning meaning, const FrameRate& rate) {
        scene_ = std::move(meaning.scene);
        scene_.interpolation = FrameInterpolation::hold;
        scene_.rate = rate;
        unstated_filters_ = meaning.unstated_filters;
        for (const auto& input : meaning.inputs) add_input(input);
    }

    CameraRun run_;
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;

private:
    UnstatedFilters unstated_filters_;
};

}  // namespace touchable
