// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/stored_clip.hpp"

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/formats/depth_values.hpp"
#include "engine/formats/value_evidence.hpp"

namespace touchable {
namespace {

/// A palette is a way to store 8-bit RGB: a picture of few colours may have one, and the next not.
bool is_same_format(const std::string& a, const std::string& b) {
    const auto is_rgb = [](const std::string& format) { return format == "rgb24" || format == "pal8"; };
    return a == b || (is_rgb(a) && is_rgb(b));
}

class StoredClipReader final : public ClipReader {
public:
    explicit StoredClipReader(StoredClip clip) : clip_(std::move(clip)), values_(clip_.described) {
        for (const PlaneRole role : clip_.roles) tracks_.push_back({role});
        for (const auto& file : clip_.inputs) add_input(file);
    }

    Result<void> open() {
        TRY_ASSIGN(scene_, error_at(clip_.name, settle(clip_.described, clip_.found)));
        if (std::ranges::count(clip_.cameras, scene_.camera) == std::ssize(clip_.cameras))
            clip_.cameras.clear();
        for (Track& track : tracks_) TRY(read_first(track));
        note(no_depth_note(frame_of_newest(), scene_.depth));
        note(default_touch_note(std::ranges::count(clip_.roles, PlaneRole::haptic) > 0, scene_));
        return {};
    }

    bool leaves_far_open() const { return values_.leaves_far_open(); }

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return clip_.described.unstated.filters; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return clip_.count; }
    const std::vector<ClipNote>& notes() const override { return clip_.notes; }
    std::span<const Camera> frame_cameras() const override { return clip_.cameras; }

    Result<std::optional<RawFrame>> next() override {
        if (number_ == clip_.count) return std::optional<RawFrame>{};
        TRY(read_all(number_));
        RawFrame frame = frame_of_newest();
        ++number_;
        return std::optional(std::move(frame));
    }

    Result<void> rewind() override { return seek(0); }

    Result<void> seek(std::int64_t frame) override {
        if (frame < 0 || frame > clip_.count)
            return usage_error(clip_.name + ": has no frame " + std::to_string(frame) +
                               ": must be from 0 to " + std::to_string(clip_.count - 1));
        number_ = frame;
        return {};
    }

    std::int64_t access_point(std::int64_t frame) const override {
        return clip_.pictures->access_point(frame);
    }
    void leave_out_colour() override { with_colour_ = false; }

private:
    struct Track {
        PlaneRole role;
        std::int64_t number = -1;  // of the newest picture that was read
        Plane newest{};
    };

    void note(std::optional<ClipNote> said) {
        if (said) clip_.notes.push_back(std::move(*said));
    }

    /// Reads a track's frame 0, whose storage all later ones must share.
    Result<void> read_first(Track& track) {
        TRY_ASSIGN(auto picture, clip_.pictures->picture(track.role, 0));
        const StoredImage& stored = picture.image;
        const Image& image = stored.image;
        infos_.push_back({std::string(role_name(track.role)), stored.codec, stored.pixel_format, image.width,
                          image.height, picture.lossless});
        const bool is_depth = track.role == PlaneRole::depth;
        if (!is_depth && (image.width != scene_.width || image.height != scene_.height))
            note(resampling_note(track.role, image.width, image.height, scene_));
        if (!picture.lossless) note(lossy_note(track.role, stored.codec));
        if (is_depth && picture.lent.view.empty() && values_.needs_looks(stored)) TRY(look_at_some(stored));
        if (track.role == PlaneRole::haptic && image.channels == 1) note(take_grey_haptic(scene_));
        return take(track, 0, std::move(picture));
    }

    /// For depth that is not codes yet: its range in the telling frames settles the codes. A later frame that
    /// is damaged is skipped.
    Result<void> look_at_some(const StoredImage& first) {
        values_.look(first);
        for (const std::int64_t frame : telling_frames(clip_.count)) {
            if (stop_requested()) return interrupted_error();
            if (frame == 0) continue;
            auto picture = clip_.pictures->picture(PlaneRole::depth, frame);
            if (!picture && picture.error().kind == ErrorKind::interrupted) return picture.error();
            if (!picture) continue;
            values_.look(picture->image);
            if (frame < first_frames) clip_.pictures->keep(frame, std::move(picture->image));
        }
        if (stop_requested()) return interrupted_error();
        TRY_ASSIGN(auto said, error_at(clip_.name, values_.settle(scene_)));
        note(std::move(said));
        return {};
    }

    /// Reads a frame's tracks. The error is that of the first track with one, in any order of reading.
    Result<void> read_all(std::int64_t frame) {
        std::vector<Result<void>> outcomes(tracks_.size());
        const auto read_one = [&](std::size_t n) {
            if (with_colour_ || tracks_[n].role != PlaneRole::colour) outcomes[n] = read(tracks_[n], frame);
        };
        if (clip_.pictures->reads_side_by_side()) {
            side_by_side_.for_each_band(static_cast<int>(tracks_.size()), 1, [&](const RowBand& band) {
                for (int n = band.first; n < band.last; ++n) read_one(static_cast<std::size_t>(n));
            });
        } else {
            for (std::size_t n = 0; n < tracks_.size(); ++n) {
                read_one(n);
                if (!outcomes[n]) break;
            }
        }
        for (Result<void>& outcome : outcomes)
            if (!outcome) return std::move(outcome);
        return {};
    }

    Result<void> read(Track& track, std::int64_t frame) {
        if (track.number == clip_.pictures->picture_number(track.role, frame)) return {};
        track = {track.role};  // freed first, so that its memory can serve the next
        TRY_ASSIGN(auto picture, clip_.pictures->picture(track.role, frame));
        const TrackInfo& first = infos_[static_cast<std::size_t>(&track - tracks_.data())];
        const StoredImage& stored = picture.image;
        const Image& image = stored.image;
        if (image.width != first.width || image.height != first.height ||
            !is_same_format(stored.pixel_format, first.pixel_format))
            return input_error(clip_.pictures->where(track.role, frame) + ": is " +
                               size_text(image.width, image.height) + ' ' + stored.pixel_format +
                               ", but frame 0 is " + size_text(first.width, first.height) + ' ' +
                               first.pixel_format);
        return take(track, frame, std::move(picture));
    }

    /// Makes a picture the newest of its track.
    Result<void> take(Track& track, std::int64_t frame, TrackPicture picture) {
        const std::string where = clip_.pictures->where(track.role, frame);
        const bool is_depth = track.role == PlaneRole::depth;
        StoredImage& stored = picture.image;
        if (!is_depth && !stored.values.empty())
            return input_error(where + ": is a picture of floats: must be of integers");
        Plane plane = std::move(picture.lent);
        if (plane.view.empty()) {
            const bool makes_codes = is_depth && values_.makes_codes();
            const int bits = makes_codes ? 16 : stored.bits;
            Image codes = makes_codes ? values_.codes(std::move(stored)) : std::move(stored.image);
            if (stop_requested()) return interrupted_error();
            plane = plane_from(std::move(codes), bits);
        }
        TRY_ASSIGN(track.newest, fit_plane(track.role, std::move(plane), scene_, where));
        track.number = clip_.pictures->picture_number(track.role, frame);
        return {};
    }

    /// The frame `number_`.
    RawFrame frame_of_newest() const {
        RawFrame frame;
        frame.number = number_;
        frame.time_ns = scene_.rate.time_ns(number_);
        for (const Track& track : tracks_)
            if (with_colour_ || track.role != PlaneRole::colour) add_plane(frame, track.role, track.newest);
        return frame;
    }

    StoredClip clip_;
    Scene scene_;
    std::vector<Track> tracks_;
    std::vector<TrackInfo> infos_;  // of each track
    DepthValues values_;
    RowBands side_by_side_{2};  // a row is a track
    std::int64_t number_ = 0;   // of the frame that `next` gives
    bool with_colour_ = true;
};

}  // namespace

Result<TrackPicture> track_picture(StoredImage stored, PlaneRole role, const StillRules& rules,
                                   const std::string& where) {
    if (role == PlaneRole::depth && rules.packed != Packing::none && !unpack_depth(stored, rules.packed)) {
        if (stop_requested()) return interrupted_error();
        return input_error(where + ": is not RGB of 8 bits (floats: RGBA), which packed depth is");
    }
    const bool is_grey =
        (role == PlaneRole::depth && rules.depth != DepthCodingKind::hue) || role == PlaneRole::height;
    if (is_grey && stored.image.channels == 3)
        if (auto grey = as_grey(stored.image)) stored.image = std::move(*grey);
    if (stop_requested()) return interrupted_error();
    if (role == PlaneRole::haptic && stored.codec == "mjpeg" && !rules.haptic_may_be_lossy)
        return input_error(where + ": is JPEG, which mixes materials; haptic is PNG");
    if (role != PlaneRole::colour && stored.interlaced)
        return input_error(where + ": is an interlaced PNG: must be a plain one to be touched");
    return TrackPicture{std::move(stored)};
}

TrackPicture lent_picture(const TrackInfo& track, Plane plane) {
    const PlaneView& view = plane.view;
    return {{{view.width, view.height, view.bytes_per_sample, view.channels, {}},
             track.codec,
             track.pixel_format},
            std::move(plane),
            track.lossless};
}

Result<std::unique_ptr<ClipReader>> open_stored_clip(StoredClip clip, Colour colour) {
    const std::string name = clip.name;
    const bool has_no_scale =
        clip.has_no_scale || clip.described.scene.stored.kind == StoredDepth::Kind::relative;
    const DepthAlignment alignment =
        clip.alignment == DepthAlignment::automatic && !has_no_scale ? DepthAlignment::off : clip.alignment;
    auto reader = std::make_unique<StoredClipReader>(std::move(clip));
    TRY(reader->open());
    const bool far_is_open = reader->leaves_far_open();
    // Alignment uses colour, even if colour is left out afterwards.
    TRY_ASSIGN(auto aligned, with_aligned_depth(std::move(reader), alignment));
    if (colour == Colour::left_out) aligned->leave_out_colour();
    return with_far_plane(std::move(aligned), far_is_open, name);
}

}  // namespace touchable
