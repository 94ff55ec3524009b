// SPDX-License-Identifier: Apache-2.0
// Writes clips in Matroska: each track in the coding that suits its first pictures, unchanged pictures stored
// once, and tracks copied from another clip.
#include <algorithm>
#include <cstring>
#include <deque>
#include <limits>

#include "engine/base/try.hpp"
#include "engine/clip/containers.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

/// A picture as stored, and for how many frames it stays.
struct StoredPicture {
    PacketPtr packet;
    std::int64_t frame = 0;   ///< first frame that shows it
    std::int64_t frames = 1;  ///< number of frames that show it
};

/// A candidate coding of a track; candidates are compared by bytes times `weight`.
struct CodingOffer {
    TrackCoding coding;
    int weight = 1;
};

std::vector<CodingOffer> offers_for(PlaneRole role, const PlaneView& first, const ClipStorage& storage) {
    using enum TrackCoding;
    if (role == PlaneRole::colour && !storage.exact_colour) return {{h264_visual}};
    const bool fast = storage.archive == Archive::fast, wide = first.bytes_per_sample == 2;
    // H.264's decoding time grows with its bytes: at half the bytes of the other it is as quick.
    if (fast && wide) return {{h264_quick, 2}, {rank_zstd}};
    if (fast) return {{h264_quick}};
    if (wide) return {{h264_thrifty}, {rank_zstd_thrifty}};
    return {{h264_thrifty}, {ffv1}};
}

/// One track of a clip being written: unchanged pictures are stored once, and among several codings the one
/// whose first pictures take the fewest weighted bytes is chosen.
class TrackWriter {
public:
    /// `first`: a plane like all to come. An error of kind usage if no coding supports its size.
    static Result<TrackWriter> open(PlaneRole role, const PlaneView& first, const Scene& scene,
                                    const ClipStorage& storage) {
        TrackWriter track;
        track.role_ = role;
        const auto open = [&](const CodingOffer& offer) -> Result<void> {
            TRY_ASSIGN(auto encoder, TrackEncoder::open(role, offer.coding, first, scene));
            track.codings_.push_back({offer, std::move(encoder)});
            return {};
        };
        for (const CodingOffer& offer : offers_for(role, first, storage))
            if (auto opened = open(offer); !opened && opened.error().kind != ErrorKind::usage)
                return opened.error();
        // FFV1 supports sizes that are too large for H.264.
        if (track.codings_.empty()) TRY(open({TrackCoding::ffv1}));
        return track;
    }

    PlaneRole role() const { return role_; }
    /// Adds the next frame's plane; returns its packet, null if it is as before.
    Result<const AVPacket*> add(const PlaneView& plane) {
        const bool access = frames_ % clip_tags::access_interval == 0;
        if (frames_ == clip_tags::access_interval) decide();
        const bool same = stays(plane);
        for (Coding& coding : codings_) {
            if (same && !access) {
                ++coding.pictures.back().frames;
                continue;
            }
            TRY_ASSIGN(auto packet, coding.encoder->encode(plane, access));
            coding.bytes += packet->size;
            coding.pictures.push_back({std::move(packet), frames_});
        }
        ++frames_;
        return same && !access ? nullptr : codings_.front().pictures.back().packet.get();
    }

    /// Ends the track: no more frames.
    void end() {
        ended_ = true;
        decide();
    }

    /// Whether the track's coding is chosen.
    bool decided() const { return codings_.size() == 1; }
    TrackCoding coding() const { return codings_.front().offer.coding; }
    const TrackEncoder& encoder() const { return *codings_.front().encoder; }
    /// The oldest picture, once decided; null if there is none.
    const StoredPicture* oldest() const {
        const auto& pictures = codings_.front().pictures;
        return pictures.empty() ? nullptr : &pictures.front();
    }

    /// Whether it is known how long the oldest picture stays.
    bool oldest_is_complete() const { return ended_ || codings_.front().pictures.size() > 1; }

    StoredPicture take_oldest() {
        auto& pictures = codings_.front().pictures;
        StoredPicture picture = std::move(pictures.front());
        pictures.pop_front();
        return picture;
    }

private:
    struct Coding {
        CodingOffer offer;
        std::unique_ptr<TrackEncoder> encoder;
        std::deque<StoredPicture> pictures{};
        std::int64_t bytes = 0;
    };
    TrackWriter() = default;
    /// Whether the plane equals the one before; stores it otherwise.
    bool stays(const PlaneView& plane) {
        const std::size_t row_bytes = plane.row_bytes();
        bool same = !newest_.empty();
        newest_.resize(plane.bytes());
        for (int y = 0; y < plane.height; ++y) {
            std::uint8_t* kept = newest_.data() + row_bytes * static_cast<std::size_t>(y);
            if (same && std::memcmp(kept, plane.row(y), row_bytes) == 0) continue;
            same = false;
            std::memcpy(kept, plane.row(y), row_bytes);
        }
        return same;
    }

    /// Chooses the smallest coding, the first of equal ones.
    void decide() {
        const auto least = std::ranges::min_element(codings_, [](const Coding& a, const Coding& b) {
            return a.bytes * a.offer.weight < b.bytes * b.offer.weight;
        });
        if (least != codings_.begin()) std::swap(*codings_.begin(), *least);
        codings_.erase(codings_.begin() + 1, codings_.end());
    }

    PlaneRole role_ = PlaneRole::depth;
    std::vector<Coding> codings_;       // remaining candidates
    std::vector<std::uint8_t> newest_;  // samples of the picture before
    std::int64_t frames_ = 0;
    bool ended_ = false;
};

/// Copies tracks of a Matroska clip into a clip of the same frames: nothing is decoded or encoded, and lossy
/// colour loses nothing more.
class TrackCopy {
public:
    /// Null if they cannot be copied: the file is not Matroska, lacks one of these roles, or another program
    /// wrote it.
    static Result<std::unique_ptr<TrackCopy>> open(const std::filesystem::path& file,
                                                   std::vector<PlaneRole> roles) {
        const SourceFile source(file);
        const auto container = matroska_container(source);
        auto demuxer = container->open();
        if (!demuxer && demuxer.error().kind == ErrorKind::interrupted) return demuxer.error();
        if (!demuxer || !container->rate(**demuxer)) return std::unique_ptr<TrackCopy>();
        const auto tracks = container->tracks(**demuxer, Scene{});
        if (!tracks) return std::unique_ptr<TrackCopy>();
        std::unique_ptr<TrackCopy> copy(new TrackCopy);
        copy->file_ = file.string();
        for (const PlaneRole role : roles) {
            const auto found = std::ranges::find(*tracks, role, &ClipContainer::Track::role);
            if (found == tracks->end()) return std::unique_ptr<TrackCopy>();
            (*demuxer)->select(found->stream);
            copy->streams_.push_back(found->stream);
        }
        copy->demuxer_ = std::move(*demuxer);
        copy->roles_ = std::move(roles);
        copy->frames_.resize(copy->roles_.size());
        // Without additions it is unknown how long a picture stays.
        for (const int stream : copy->streams_) {
            TRY_ASSIGN(const auto packet, copy->demuxer_->peek(stream));
            if (!packet || !block_addition_of(*packet)) return std::unique_ptr<TrackCopy>();
        }
        return copy;
    }

    std::size_t count() const { return streams_.size(); }
    bool has(PlaneRole role) const { return std::ranges::find(roles_, role) != roles_.end(); }
    PlaneRole role(std::size_t track) const { return roles_[track]; }
    const AVStream& stream(std::size_t track) const {
        return *demuxer_->container().streams[streams_[track]];
    }

    /// Frames covered by the track's pictures so far.
    std::int64_t frames(std::size_t track) const { return frames_[track]; }
    /// A track's next picture, with its BlockAddition; `packet` is null after the last.
    Result<StoredPicture> next(std::size_t track) {
        TRY_ASSIGN(auto packet, demuxer_->next(streams_[track]));
        if (!packet) return StoredPicture{};
        const auto addition = block_addition_of(*packet);
        if (!addition || !addition->sound)
            return input_error(file_ + ", " + std::string(role_name(roles_[track])) + ", frame " +
                               std::to_string(frames_[track]) + ": is damaged: its checksum is another");
        const std::int64_t frame = std::exchange(frames_[track], frames_[track] + addition->frames);
        return StoredPicture{std::move(packet), frame, addition->frames};
    }

private:
    TrackCopy() = default;

    std::string file_;
    std::unique_ptr<Demuxer> demuxer_;
    std::vector<PlaneRole> roles_;
    std::vector<int> streams_;
    std::vector<std::int64_t> frames_;  // covered by each track's pictures so far
};

constexpr std::int64_t no_frame = std::numeric_limits<std::int64_t>::max();  // after all frames

class MatroskaWriter final : public MuxedClipWriter {
public:
    MatroskaWriter(const std::filesystem::path& path, const SceneDescription& described,
                   const ClipStorage& storage, Existing existing)
        : MuxedClipWriter(path, described, storage, existing, "matroska") {}

private:
    Result<void> add(const RawFrame& frame) override {
        if (tracks_.empty()) TRY(open_tracks(frame));
        for (TrackWriter& track : tracks_) {
            TRY_ASSIGN(const AVPacket* const packet, track.add(plane_of(frame, track.role())));
            if (packet && track.role() == PlaneRole::colour) TRY(read_again(*packet));
        }
        return write_complete();
    }

    Result<void> add_rest() override {
        for (TrackWriter& track : tracks_) track.end();
        TRY(write_complete());
        TRY(copy_until(check_.frames()));
        for (std::size_t k = 0; copy_ && k < copy_->count(); ++k)
            if (copy_->frames(k) < check_.frames())
                return input_error(storage_.copied->file.string() + ": its " +
                                   std::string(role_name(copy_->role(k))) + " ends at frame " +
                                   std::to_string(copy_->frames(k)) + ", before the others");
        return {};
    }

    Result<void> open_tracks(const RawFrame& first) {
        if (storage_.copied)
            TRY(assign(copy_, TrackCopy::open(storage_.copied->file, storage_.copied->roles)));
        for (const auto& [role, plane] : planes_of(first)) {
            if (copy_ && copy_->has(role)) continue;
            TRY_ASSIGN(auto track, TrackWriter::open(role, plane, scene_, storage_));
            TRY(read_along(track.encoder(), track.coding()));
            tracks_.push_back(std::move(track));
        }
        return {};
    }

    Result<void> begin_file() {
        for (const TrackWriter& track : tracks_)
            TRY(add_plane_stream(*muxer_, track.encoder(), track.role(), track.coding(), check_, scene_));
        for (std::size_t k = 0; copy_ && k < copy_->count(); ++k)
            TRY(add_copied_track(copy_->stream(k), copy_->role(k)));
        TRY(add_sound_stream());
        TRY(attach_scene());
        add_clip_tags(*muxer_, scene_.rate, clip_format_version);
        begun_ = true;
        return write_header();
    }

    Result<void> add_copied_track(const AVStream& from, PlaneRole role) {
        AVStream* stream = avformat_new_stream(muxer_.get(), nullptr);
        if (!stream || avcodec_parameters_copy(stream->codecpar, from.codecpar) < 0)
            return refuse("out of memory");
        stream->time_base = {1, 1000};
        stream->avg_frame_rate = from.avg_frame_rate;
        for (const char* tag : {clip_tags::role_tag, "title", clip_tags::lossless_tag, clip_tags::bits_tag})
            if (const AVDictionaryEntry* const entry = av_dict_get(from.metadata, tag, nullptr, 0))
                av_dict_set(&stream->metadata, tag, entry->value, 0);
        stream->disposition = is_shown_by_players(role, check_) ? AV_DISPOSITION_DEFAULT : 0;
        return {};
    }

    /// Writes the copied pictures that are shown before this frame, in their order.
    Result<void> copy_until(std::int64_t frame) {
        if (!copy_) return {};
        for (std::size_t k = ahead_.size(); k < copy_->count(); ++k) {
            TRY_ASSIGN(auto first, copy_->next(k));
            ahead_.push_back(std::move(first));
        }
        const auto frame_of = [](const StoredPicture& each) { return each.packet ? each.frame : no_frame; };
        while (true) {
            const auto next = std::ranges::min_element(ahead_, {}, frame_of);
            if (next == ahead_.end() || frame_of(*next) >= frame) return {};
            const auto track = static_cast<std::size_t>(next - ahead_.begin());
            TRY(write_picture_of(tracks_.size() + track, *next));
            TRY_ASSIGN(*next, copy_->next(track));
        }
    }

    /// Writes pictures in the order of frames, then of tracks, up to the first that may still stay longer.
    Result<void> write_complete() {
        const auto decided = [](const TrackWriter& track) { return track.decided(); };
        if (!std::ranges::all_of(tracks_, decided)) return {};
        if (!begun_) TRY(begin_file());
        const auto frame_of = [](const TrackWriter& track) {
            const StoredPicture* const picture = track.oldest();
            return picture ? picture->frame : no_frame;
        };
        while (true) {
            const auto next = std::ranges::min_element(tracks_, {}, frame_of);
            if (next == tracks_.end() || !next->oldest() || !next->oldest_is_complete()) return {};
            TRY(write_stored(static_cast<std::size_t>(next - tracks_.begin())));
        }
    }

    Result<void> write_stored(std::size_t track) {
        const StoredPicture picture = tracks_[track].take_oldest();
        TRY(copy_until(picture.frame));
        const AVCodecID codec = muxer_->streams[track]->codecpar->codec_id;
        TRY(add_block_addition(*picture.packet, codec, picture.frames));
        return write_picture_of(track, picture);
    }

    /// Writes a picture that has its addition.
    Result<void> write_picture_of(std::size_t stream, const StoredPicture& picture) {
        AVPacket* packet = picture.packet.get();
        packet->pts = packet->dts = time_ms(picture.frame);
        TRY(write_sound(packet->pts));
        packet->duration = time_ms(picture.frame + picture.frames) - time_ms(picture.frame);
        return write_picture(*packet, stream, {1, 1000});
    }

    Result<void> attach_scene() {
        TRY(attach_text(*muxer_, clip_tags::scene_file, "application/json",
                        scene_to_json(said_of_clip(described_))));
        if (scene_.path)
            TRY(attach_text(*muxer_, clip_tags::poses_file, "text/plain",
                            timed_poses_text(*scene_.path, scene_.rate, scene_.metres_per_unit)));
        if (!scene_.rate.own_times) return {};
        return attach_text(*muxer_, clip_tags::times_file, "text/plain", frame_times_text(scene_.rate));
    }

    std::vector<TrackWriter> tracks_;   // track k is stream k
    std::unique_ptr<TrackCopy> copy_;   // its streams follow those of tracks_; null: none
    std::vector<StoredPicture> ahead_;  // by copied track: the picture to write next
    bool begun_ = false;                // the header is written: all codings are chosen
};

}  // namespace

std::unique_ptr<MuxedClipWriter> matroska_writer(const std::filesystem::path& path,
                                                 const SceneDescription& described,
                                                 const ClipStorage& storage, Existing existing) {
    return std::make_unique<MatroskaWriter>(path, described, storage, existing);
}

}  // namespace touchable
