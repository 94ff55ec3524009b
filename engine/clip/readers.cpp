// SPDX-License-Identifier: Apache-2.0
// Readers around a clip that change which frames, pixels or planes it has: a part of it, and planes that are
// the same under every frame.
#include "engine/clip/readers.hpp"

#include <numeric>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

PlaneView cropped(PlaneView plane, const ClipPart::Crop& box) {
    if (plane.empty()) return plane;
    plane.data =
        plane.row(box.y) + static_cast<std::ptrdiff_t>(box.x) * plane.channels * plane.bytes_per_sample;
    plane.width = box.width;
    plane.height = box.height;
    return plane;
}

/// The frame rate of a part.
FrameRate rate_of_part(const FrameRate& rate, const ClipPart& part) {
    const std::int64_t common = std::gcd(rate.num, part.every);
    const FrameRate slower{rate.num / common, rate.den * (part.every / common)};
    if (!rate.own_times) return slower;
    std::vector<std::int64_t> times_ns;
    const auto known = static_cast<std::int64_t>(rate.own_times->size());
    for (std::int64_t n = part.first; n <= part.last.value_or(known - 1) && n < known; n += part.every)
        times_ns.push_back(rate.time_ns(n));
    return rate_of_own_times(std::move(times_ns)).value_or(slower);
}

Scene scene_of_part(Scene scene, const ClipPart& part) {
    scene.rate = rate_of_part(scene.rate, part);
    if (scene.path)
        scene.path = std::make_shared<const CameraPath>(scene.path->part(part.first, part.last, part.every));
    if (!part.crop) return scene;
    scene.width = part.crop->width;
    scene.height = part.crop->height;
    scene.camera.cx -= part.crop->x;
    scene.camera.cy -= part.crop->y;
    return scene;
}

class PartReader final : public ReaderAround {
public:
    PartReader(std::unique_ptr<ClipReader> clip, const ClipPart& part)
        : ReaderAround(std::move(clip)), part_(part), scene_(scene_of_part(inner().scene(), part)) {}

    const Scene& scene() const override { return scene_; }
    std::optional<std::int64_t> frame_count() const override {
        const auto whole = ReaderAround::frame_count();
        if (!whole && !part_.last) return std::nullopt;
        std::int64_t end = whole.value_or(std::numeric_limits<std::int64_t>::max());
        if (part_.last) end = std::min(end, *part_.last + 1);
        return end > part_.first ? (end - part_.first - 1) / part_.every + 1 : 0;
    }

    Result<void> seek(std::int64_t frame) override {
        const auto frames = frame_count(), whole = ReaderAround::frame_count();
        if (frame < 0 || (frames && frame > *frames))
            return usage_error("frame " + std::to_string(frame) + " is not of this part of the clip");
        // The end of a part may lie beyond the clip's.
        const std::int64_t wanted = part_.first + frame * part_.every;
        TRY(ReaderAround::seek(whole ? std::min(wanted, *whole) : wanted));
        number_ = frame;
        at_ = wanted;
        return {};
    }
    std::int64_t access_point(std::int64_t frame) const override {
        const std::int64_t point = ReaderAround::access_point(part_.first + frame * part_.every);
        return point <= part_.first ? 0 : (point - part_.first) / part_.every;
    }

    Result<std::optional<RawFrame>> next() override {
        if (at_ < 0) TRY(seek(0));
        const std::int64_t wanted = part_.first + number_ * part_.every;
        if (part_.last && wanted > *part_.last) return std::optional<RawFrame>();
        while (true) {
            auto frame = ReaderAround::next();
            if (!frame || !*frame) return frame;
            if (at_++ < wanted) continue;
            (*frame)->number = number_;
            (*frame)->time_ns = scene_.rate.time_ns(number_);
            ++number_;
            if (!part_.crop) return frame;
            (*frame)->filled.reset();  // it is for the whole picture
            for (const PlaneRole role : all_roles)
                plane_of(**frame, role) = cropped(plane_of(**frame, role), *part_.crop);
            return frame;
        }
    }

private:
    ClipPart part_;
    Scene scene_;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    std::int64_t at_ = -1;     // the clip's frame that comes next; -1: not begun
};

Result<void> check_frames_of_part(const ClipPart& part, const std::optional<std::int64_t>& frames) {
    if (part.first < 0 || part.every < 1 || (part.last && *part.last < part.first))
        return usage_error("a part of a clip must begin before it ends, with one frame at least");
    if (!frames) return {};
    const auto beyond = [&](std::int64_t frame) {
        return usage_error("frame " + std::to_string(frame) + " is beyond the clip's end: it has " +
                           std::to_string(*frames) + " frames, 0 to " + std::to_string(*frames - 1));
    };
    if (part.first >= *frames) return beyond(part.first);
    if (part.last && *part.last >= *frames) return beyond(*part.last);
    return {};
}

Result<void> check_crop(const ClipPart::Crop& box, const Scene& scene) {
    const bool fits = box.x >= 0 && box.y >= 0 && box.width >= 1 && box.height >= 1 &&
                      box.x <= scene.width - box.width && box.y <= scene.height - box.height;
    if (fits) return {};
    return usage_error("what is cut out, " + size_text(box.width, box.height) + " pixels from column " +
                       std::to_string(box.x) + ", row " + std::to_string(box.y) +
                       ", is not within the clip's " + size_text(scene.width, scene.height));
}

class StillPlanesReader final : public ChangedClip {
public:
    using ChangedClip::ChangedClip;
    Result<void> lay(StillPlane still) {
        const std::string file = still.files.front().string();
        const bool replaces = replace_track(still.role, still.info);
        notes_.push_back(file + " is " + std::string(role_name(still.role)) +
                         (still.at ? ", frame by frame" : " of every frame") +
                         (replaces ? ", in place of the clip's own" : ""));
        std::move(still.notes.begin(), still.notes.end(), std::back_inserter(notes_));
        const TrackInfo& stored = still.info;
        if (stored.width != scene_.width || stored.height != scene_.height)
            notes_.push_back(resampling_note(still.role, stored.width, stored.height, scene_));
        TRY_ASSIGN(still.plane, fit_plane(still.role, std::move(still.plane), scene_, file));
        for (auto& input : still.files) add_input(std::move(input));
        planes_.push_back(std::move(still));
        return {};
    }

    Result<void> change(RawFrame& frame) override {
        for (const StillPlane& still : planes_) {
            TRY_ASSIGN(auto plane,
                       still.at ? still.at(frame.number, frame.time_ns) : Result<Plane>(still.plane));
            add_plane(frame, still.role, std::move(plane));
        }
        return {};
    }

private:
    std::vector<StillPlane> planes_;
};

}  // namespace

bool ChangedClip::replace_track(PlaneRole role, TrackInfo track) {
    const auto role_of = [](const TrackInfo& each) {
        return role_named(each.role).value_or(PlaneRole::height);
    };
    track.role = role_name(role);
    std::erase_if(notes_, [role](const ClipNote& note) { return note.plane == role; });
    const bool had_one =
        std::erase_if(tracks_, [&](const TrackInfo& each) { return each.role == track.role; });
    const auto after = std::ranges::find_if(tracks_, [&](const auto& each) { return role_of(each) > role; });
    tracks_.insert(after, std::move(track));
    return had_one;
}

Result<std::unique_ptr<ClipReader>> part_of_clip(std::unique_ptr<ClipReader> clip, const ClipPart& part) {
    if (part.is_whole()) return clip;
    TRY(check_frames_of_part(part, clip->frame_count()));
    if (part.crop) TRY(check_crop(*part.crop, clip->scene()));
    if (auto valid = validate(scene_of_part(clip->scene(), part)); !valid)
        return usage_error("that part of the clip: " + valid.error().message);
    return std::make_unique<PartReader>(std::move(clip), part);
}

Result<std::unique_ptr<ClipReader>> with_still_planes(std::unique_ptr<ClipReader> clip,
                                                      std::vector<StillPlane> planes, const Scene& scene) {
    if (planes.empty()) return clip;
    TRY(error_at(planes.front().files.front().string(), validate(scene)));
    auto reader = std::make_unique<StillPlanesReader>(std::move(clip), scene);
    for (StillPlane& plane : planes) TRY(reader->lay(std::move(plane)));
    return reader;
}

}  // namespace touchable
