#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "engine/clip/clip_reader.hpp"
#include "engine/clip/matroska_writer.hpp"
#include "engine/clip/read_along.hpp"
#include "engine/clip/track_encoder.hpp"

namespace touchable {

/// A picture as stored, and for how many frames it stays.
struct StoredPicture {
    PacketPtr packet;
    std::int64_t frame = 0;   ///< the first that shows it
    std::int64_t frames = 1;  ///< that show it
};

/// A coding that a track may have. Where there are others, its bytes count so many times.
struct CodingOffer {
    TrackCoding coding;
    int weight = 1;
};

/// One track of a clip that is written: pictures that do not change are stored once, and where there is a
/// choice of codings, the one whose first pictures take the fewest bytes, by weight, is taken.
class TrackWriter {
public:
    /// `first`: a plane as all will be. An error of kind usage where no coding has pictures of its size.
    static Result<TrackWriter> open(PlaneRole role, const PlaneView& first, const Scene& scene,
                                    const ClipStorage& storage);

    PlaneRole role() const { return role_; }
    /// The plane of the next frame.
    Result<void> add(const PlaneView& plane);
    /// That plane as readers will be given it, where the coding changes values and ClipStorage::gives_colour
    /// asked for it; empty otherwise.
    PlaneView as_read() const { return reader_ ? reader_->picture() : PlaneView{}; }
    /// No frame comes any more.
    void end();

    /// Whether it is known by now how the track is coded.
    bool decided() const { return codings_.size() == 1; }
    TrackCoding coding() const { return codings_.front().offer.coding; }
    const TrackEncoder& encoder() const { return *codings_.front().encoder; }
    /// The oldest picture, once decided; null where there is none.
    const StoredPicture* oldest() const;
    /// Whether it is known how long that stays.
    bool oldest_is_complete() const;
    StoredPicture take_oldest();

private:
    struct Coding {
        CodingOffer offer;
        std::unique_ptr<TrackEncoder> encoder;
        std::deque<StoredPicture> pictures{};
        std::int64_t bytes = 0;
    };
    TrackWriter() = default;
    bool stays(const PlaneView& plane);
    void decide();

    PlaneRole role_ = PlaneRole::depth;
    std::vector<Coding> codings_;       // those that are still to choose from
    std::vector<std::uint8_t> newest_;  // samples of the picture before
    std::int64_t frames_ = 0;
    bool ended_ = false;
    std::unique_ptr<ReadAlong> reader_;  // null: nobody asked
};

}  // namespace touchable
