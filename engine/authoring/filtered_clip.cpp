// SPDX-License-Identifier: Apache-2.0
// A clip whose depth is what its scene's filters leave, frame by frame.
#include <algorithm>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/readers.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

class FilteredClip final : public ChangedClip {
public:
    FilteredClip(std::unique_ptr<ClipReader> clip, const Scene& scene, const std::string& filters)
        : ChangedClip(std::move(clip), filtered_scene(scene)),
          no_depth_(code_of_no_depth(scene_.depth).value_or(0)),
          warm_up_(scene.filter.temporal ? temporal_warm_up_frames : 0),
          builder_(make_cpu_builder(scene)) {
        add_remark(scene_.remarks, {"depth was filtered: " + filters});
        for (TrackInfo& track : tracks_)
            if (track.role == role_name(PlaneRole::depth))
                track = {track.role, "filtered", "gray16", scene.width, scene.height, true};
    }

    UnstatedFilters unstated_filters() const override { return {}; }

    Result<void> seek(std::int64_t frame) override {
        ++epoch_;
        const std::int64_t from = std::max<std::int64_t>(0, frame - warm_up_);
        TRY(inner().seek(from));
        for (std::int64_t number = from; number < frame; ++number) {
            if (stop_requested()) return interrupted_error();
            TRY_ASSIGN(auto before, inner().next());
            if (!before) break;
            TRY(build(*before));
        }
        return {};
    }

private:
    Result<void> build(const RawFrame& raw) {
        RawFrame of_epoch = raw;
        of_epoch.epoch = epoch_;
        return builder_->build(of_epoch, built_);
    }

    Result<void> change(RawFrame& raw) override {
        TRY(build(raw));
        struct Storage {
            std::shared_ptr<const void> stored;  // of the other planes
            std::vector<std::uint16_t> codes;
        };
        auto storage = std::make_shared<Storage>();
        storage->stored = std::move(raw.storage);
        storage->codes.resize(built_.codes.size());
        copy_codes(built_, no_depth_, storage->codes.data());
        raw.depth = plane_of_codes(storage->codes.data(), built_.width, built_.height);
        raw.depth.content = new_content_number();
        raw.storage = std::move(storage);
        return {};
    }

    const std::uint16_t no_depth_;
    const std::int64_t warm_up_;
    std::unique_ptr<SurfaceBuilder> builder_;
    SurfaceFrame built_;
    std::uint64_t epoch_ = 0;
};

}  // namespace

std::unique_ptr<ClipReader> with_filtered_depth(std::unique_ptr<ClipReader> clip, const Scene& scene,
                                                const std::string& filters) {
    return std::make_unique<FilteredClip>(std::move(clip), scene, filters);
}

}  // namespace touchable
