#include "engine/clip/track_writer.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/clip/clip_tags.hpp"

namespace touchable {
namespace {

std::vector<CodingOffer> offers_for(PlaneRole role, const PlaneView& first, const ClipStorage& storage) {
    using enum TrackCoding;
    if (role == PlaneRole::colour && !storage.exact_colour) return {{h264_visual}};
    const bool fast = storage.archive == Archive::fast, wide = first.bytes_per_sample == 2;
    // What H.264 takes to decode grows with its bytes: at half the bytes of the other it is as quick.
    if (fast && wide) return {{h264_quick, 2}, {rank_zstd}};
    if (fast) return {{h264_quick}};
    if (wide) return {{h264_thrifty}, {ffv1}, {rank_zstd}};
    return {{h264_thrifty}, {ffv1}};
}

}  // namespace

Result<TrackWriter> TrackWriter::open(PlaneRole role, const PlaneView& first, const Scene& scene,
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
    // Whatever is too large for the one is not for the other.
    if (track.codings_.empty()) TRY(open({TrackCoding::ffv1}));
    if (storage.gives_colour && track.coding() == TrackCoding::h264_visual) {
        TRY_ASSIGN(auto reader, ReadAlong::open(track.encoder(), role));
        track.reader_ = std::move(reader);
    }
    return track;
}

/// Whether it is the picture before once more; keeps it otherwise.
bool TrackWriter::stays(const PlaneView& plane) {
    const auto row_bytes = static_cast<std::size_t>(plane.width * plane.channels * plane.bytes_per_sample);
    bool same = !newest_.empty();
    newest_.resize(row_bytes * static_cast<std::size_t>(plane.height));
    for (int y = 0; y < plane.height; ++y) {
        std::uint8_t* kept = newest_.data() + row_bytes * static_cast<std::size_t>(y);
        if (same && std::memcmp(kept, plane.row(y), row_bytes) == 0) continue;
        same = false;
        std::memcpy(kept, plane.row(y), row_bytes);
    }
    return same;
}

Result<void> TrackWriter::add(const PlaneView& plane) {
    const bool access = frames_ % clip_tags::access_interval == 0;
    if (frames_ == clip_tags::access_interval) decide();
    const bool same = stays(plane);
    for (Coding& coding : codings_) {
        if (same && !access) {
            ++coding.pictures.back().frames;
            continue;
        }
        TRY_ASSIGN(auto packet, coding.encoder->encode(plane, access));
        if (reader_)
            if (auto read = reader_->add(*packet); !read) return read;
        coding.bytes += packet->size;
        coding.pictures.push_back({std::move(packet), frames_});
    }
    ++frames_;
    return {};
}

void TrackWriter::end() {
    ended_ = true;
    decide();
}

/// The first of those that are equally small.
void TrackWriter::decide() {
    const auto least = std::min_element(
        codings_.begin(), codings_.end(),
        [](const Coding& a, const Coding& b) { return a.bytes * a.offer.weight < b.bytes * b.offer.weight; });
    if (least != codings_.begin()) std::swap(*codings_.begin(), *least);
    codings_.erase(codings_.begin() + 1, codings_.end());
}

const StoredPicture* TrackWriter::oldest() const {
    const auto& pictures = codings_.front().pictures;
    return pictures.empty() ? nullptr : &pictures.front();
}

bool TrackWriter::oldest_is_complete() const {
    return ended_ || codings_.front().pictures.size() > 1;
}

StoredPicture TrackWriter::take_oldest() {
    auto& pictures = codings_.front().pictures;
    StoredPicture picture = std::move(pictures.front());
    pictures.pop_front();
    return picture;
}

}  // namespace touchable
