// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reading a stream's pictures from its container: Matroska (matroska_pictures.cpp), MPEG-TS and HTTP Live
// Streaming (labelled_pictures.cpp).

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/stream/stream_bytes.hpp"

namespace touchable {

/// A decoded picture of a stream.
struct StreamPicture {
    PlaneRole role = PlaneRole::depth;
    std::int64_t number = 0;    ///< of the first frame that shows it
    std::int64_t frames = 1;    ///< number of frames that show it
    std::int64_t taken_ns = 0;  ///< of that frame, by the sender's clock; 0: unknown
    Plane plane{};
    std::int64_t step = 1;  ///< from one sent frame to the next, frames
};

/// Limits: pixels of a picture, and bytes of all pictures that wait for others.
inline constexpr std::int64_t most_stream_pixels = std::int64_t{1} << 24U;
inline constexpr std::size_t most_bytes_waiting = std::size_t{512} << 20U;

/// Limits: bytes read for a header, and later up to the next packet.
inline constexpr std::uint64_t most_of_a_header = std::uint64_t{2} << 20U,
                               most_of_a_packet = std::uint64_t{256} << 20U;

/// The facts and the pictures of a stream, in any container.
class StreamPictures {
public:
    virtual ~StreamPictures() = default;
    /// Its scene, and the text that described it. A rate that the text leaves open is `rate`.
    virtual const SceneDescription& described() const = 0;
    virtual const std::string& scene_text() const = 0;
    virtual const FrameRate& rate() const = 0;
    /// The roles of its planes, as far as known.
    virtual std::vector<PlaneRole> roles() const = 0;
    /// The tracks of which a picture has come.
    virtual std::vector<TrackInfo> tracks() const = 0;
    virtual void leave_out_colour() = 0;

    struct Came {
        std::vector<StreamPicture> pictures{};  ///< planes as they were sent
        std::int64_t torn = 0;                  ///< damaged pictures, such as with a wrong checksum
    };
    /// The next pictures, possibly none; nothing after the sender's end.
    virtual Result<std::optional<Came>> next() = 0;
    /// After its end: how it ended, such as "closed the connection", and whether that was too early.
    virtual std::string how_it_ended() const = 0;
    virtual bool was_lost() const = 0;
    /// The levels that were read, if there is a choice.
    virtual std::optional<StreamFigures::Levels> levels() const { return std::nullopt; }
};

/// Pictures in our clips' own form; one without a label is identified by its time. `described`: replaces the
/// stream's own scene.
Result<std::unique_ptr<StreamPictures>> open_matroska_pictures(
    std::shared_ptr<StreamBytes> bytes, const std::string& name,
    const std::optional<SceneDescription>& described);

/// Labelled pictures (PictureMessage) of MPEG-TS.
Result<std::unique_ptr<StreamPictures>> open_transport_stream(
    std::shared_ptr<StreamBytes> bytes, const std::string& name,
    const std::optional<SceneDescription>& described);

/// Labelled pictures of HTTP Live Streaming. `now_ns`: as in HlsInput::open.
Result<std::unique_ptr<StreamPictures>> open_hls_stream(const StreamUrl& url,
                                                        std::shared_ptr<StreamWait> wait,
                                                        const std::optional<SceneDescription>& described,
                                                        std::function<std::int64_t()> now_ns = {});

struct MatroskaHead;

/// Filter between a stream in Matroska and FFmpeg, which allocates memory for every element before it checks
/// any. FFmpeg gets a header with each part at most once and no larger than a clip's (16 tracks), and
/// clusters of blocks, each whole and of bounded size. Anything else between and in clusters is left out.
/// After missing or damaged bytes it goes on with the next cluster.
class MatroskaGate final : public Demuxer::ByteFlow {
public:
    explicit MatroskaGate(std::shared_ptr<Demuxer::ByteFlow> source) : source_(std::move(source)) {}
    Result<std::size_t> read(std::uint8_t* to, std::size_t count) override;
    /// Whether it has ended within an element, which was not passed on.
    bool is_cut() const { return has_ended_ && there() > 0; }

private:
    enum class Place { before, segment, clusters };
    Result<bool> step();
    Result<bool> pass_beginning(const MatroskaHead& head);
    Result<bool> pass_header(const MatroskaHead& head);
    Result<bool> pass_block(const MatroskaHead& head);
    Result<bool> begin_cluster(const MatroskaHead& head);
    Result<bool> find_cluster(std::size_t from);
    Result<bool> look_back();
    Result<bool> leave_out(const MatroskaHead& head);
    Result<bool> fill(std::size_t bytes);
    std::size_t there() const { return in_.size() - at_; }
    std::optional<std::size_t> cluster_in(std::size_t from, std::size_t end) const;
    void give(std::size_t bytes) {
        const auto from = in_.begin() + static_cast<std::ptrdiff_t>(at_);
        out_.insert(out_.end(), from, from + static_cast<std::ptrdiff_t>(bytes));
        at_ += bytes;
    }
    Result<std::optional<MatroskaHead>> head();

    const std::shared_ptr<Demuxer::ByteFlow> source_;
    Place place_ = Place::before;
    std::vector<std::uint8_t> in_, out_;
    std::size_t at_ = 0, given_ = 0;  // bytes of them that were processed
    std::size_t cluster_at_ = 0;      // behind the last cluster's head
    std::uint64_t header_bytes_ = 0;
    std::array<bool, 4> seen_{};  // by part of a header
    bool has_ended_ = false;
};

}  // namespace touchable
