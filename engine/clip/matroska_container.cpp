// SPDX-License-Identifier: Apache-2.0
// Where Matroska has a clip's metadata.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

/// Tags give each track's role, attachments the clip's meaning. A saved stream, or a truncated file, is a
/// clip up to its end.
class MatroskaContainer final : public ClipContainer {
public:
    explicit MatroskaContainer(const SourceFile& source)
        : ClipContainer(source, {clip_tags::scene_file, clip_tags::times_file, clip_format_version}) {}
    Result<std::unique_ptr<Demuxer>> open() override {
        auto file = Demuxer::open_matroska(source_, true);
        if (file && (*file)->is_open_ended() && !(*file)->tag(clip_tags::stream_tag))
            return never_completed(file_);
        return file;
    }

    /// A stream's tag cannot tell that its frames will deviate from its rate: their times are checked.
    Result<FrameRate> rate(const Demuxer& file) override {
        auto rate = tagged_rate(file, file.attachment(clip_tags::times_file));
        if (!rate) return rate;
        TRY_ASSIGN(const auto whole, whole_part(file));
        if (!whole) return rate;
        constexpr std::int64_t rounding_ns = 1'000'000;  // of two rounded times
        const bool differs = std::ranges::any_of(times_ns_, [&](const auto& time) {
            return std::abs(time.second - rate->time_ns(time.first)) > rounding_ns;
        });
        // Only completed clips have pictures that stay for several frames, and these state their times.
        if (!differs || std::ssize(times_ns_) != whole->frames) return rate;
        std::vector<std::int64_t> times;
        for (const auto& [frame, ns] : times_ns_) times.push_back(ns);
        if (auto own = rate_of_own_times(std::move(times))) rate->own_times = std::move(own->own_times);
        return rate;
    }

    Result<SceneDescription> scene(const Demuxer& file, const FrameRate& recorded) override {
        if (const auto json = file.attachment(clip_tags::scene_file)) return described_by(*json, recorded);
        return refuse("has no scene.json attached: describe it with a scene file",
                      {{Setting::scene_file, "FILE"}});
    }

    Result<std::vector<Track>> tracks(const Demuxer& file, const Scene& /*scene*/) override {
        std::vector<Track> tracks;
        for (const PlaneRole role : all_roles) {
            for (const auto& [stream, tag] : file.tagged_pictures(clip_tags::role_tag)) {
                const std::string number = "track " + std::to_string(stream->index + 1);
                const auto tagged = role_named(tag);
                if (!tagged)
                    return refuse(number + " has the role " + in_quotes(tag) +
                                  ": must be depth, colour, haptic or height");
                if (*tagged != role) continue;
                if (!tracks.empty() && tracks.back().role == role)
                    return refuse(number + " is a second track of role " + tag + ": must be one");
                tracks.push_back({role, stream->index});
            }
            if (tracks.empty()) return refuse("has no track of role depth (tag T3D_ROLE)");
        }
        return tracks;
    }

    std::optional<std::string> poses(const Demuxer& file) override {
        return file.attachment(clip_tags::poses_file);
    }
    Result<std::optional<WholePart>> whole_part(const Demuxer& file) override {
        if ((file.is_open_ended() || file.is_cut()) && !whole_) TRY(count_pictures(file));
        return whole_;
    }

private:
    /// Reads the whole stream once, without decoding.
    Result<void> count_pictures(const Demuxer& file) {
        TRY_ASSIGN(auto reading, Demuxer::open_matroska(source_, true));
        TRY_ASSIGN(const auto tracks, this->tracks(file, {}));
        for (const Track& track : tracks) reading->select(track.stream);
        const double tick_ns = av_q2d(file.container().streams[tracks.front().stream]->time_base) * 1e9;
        WholePart whole{.is_cut = file.is_cut()};
        std::vector<std::int64_t> ends(tracks.size());  // by track: frames shown by its pictures
        std::int64_t first = 0;
        for (bool is_over = false; !is_over; whole.frames += is_over ? 0 : 1) {
            std::size_t there = 0;
            for (std::size_t k = 0; k < tracks.size(); ++k) {
                if (ends[k] > whole.frames) {
                    ++there;
                    continue;
                }
                TRY_ASSIGN(const auto packet, reading->next(tracks[k].stream));
                if (!packet) continue;
                ++there;
                const auto addition = block_addition_of(*packet);
                ends[k] = whole.frames + (addition && addition->sound ? addition->frames : 1);
                if (tracks[k].role != PlaneRole::depth) continue;
                if (whole.frames == 0) first = packet->pts;
                const auto ticks = static_cast<double>(packet->pts - first);
                times_ns_[whole.frames] = std::llround(std::clamp(ticks * tick_ns, 0.0, 4e18));
            }
            is_over = there < tracks.size();
            whole.is_uneven = is_over && there > 0;
        }
        times_ns_.erase(times_ns_.lower_bound(whole.frames), times_ns_.end());
        whole_ = whole;
        return {};
    }

    std::optional<WholePart> whole_;                 // of a stream or a truncated file, once counted
    std::map<std::int64_t, std::int64_t> times_ns_;  // by frame that has a depth picture, from 0 up
};

}  // namespace

std::unique_ptr<ClipContainer> matroska_container(const SourceFile& file) {
    return std::make_unique<MatroskaContainer>(file);
}

}  // namespace touchable
