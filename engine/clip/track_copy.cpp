#include "engine/clip/track_copy.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/block_addition.hpp"
#include "engine/clip/clip_container.hpp"
#include "engine/clip/clip_tags.hpp"

namespace touchable {

Result<std::unique_ptr<TrackCopy>> TrackCopy::open(const std::filesystem::path& file,
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
        const auto found = std::find_if(tracks->begin(), tracks->end(),
                                        [&](const ClipTrack& track) { return track.role == role; });
        if (found == tracks->end()) return std::unique_ptr<TrackCopy>();
        (*demuxer)->select(found->stream);
        copy->streams_.push_back(found->stream);
    }
    copy->demuxer_ = std::move(*demuxer);
    copy->roles_ = std::move(roles);
    copy->frames_.resize(copy->roles_.size());
    // Without its additions it is not known how long a picture stays.
    for (const int stream : copy->streams_) {
        TRY_ASSIGN(const auto packet, copy->demuxer_->peek(stream));
        if (!packet || !block_addition_of(*packet)) return std::unique_ptr<TrackCopy>();
    }
    return copy;
}

const AVStream& TrackCopy::stream(std::size_t track) const {
    return *demuxer_->container().streams[streams_[track]];
}

Result<StoredPicture> TrackCopy::next(std::size_t track) {
    TRY_ASSIGN(auto packet, demuxer_->next(streams_[track]));
    if (!packet) return StoredPicture{};
    const auto addition = block_addition_of(*packet);
    if (!addition || !addition->sound)
        return input_error(file_ + ", " + std::string(role_name(roles_[track])) + ", frame " +
                           std::to_string(frames_[track]) + ": is damaged: its checksum is another");
    const std::int64_t frame = std::exchange(frames_[track], frames_[track] + addition->frames);
    return StoredPicture{std::move(packet), frame, addition->frames};
}

}  // namespace touchable
