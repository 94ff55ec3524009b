#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/clip/clip_reader.hpp"
#include "engine/stream/frameset_assembler.hpp"
#include "engine/stream/stream_bytes.hpp"
#include "engine/stream/stream_pictures.hpp"
#include "engine/stream/stream_url.hpp"
#include "engine/stream/stream_wait.hpp"

namespace touchable {

/// Of a stream: what it is, how long it is waited for, and what is wanted of it.
struct StreamSource {
    StreamUrl url;
    StreamPatience patience{};
    std::shared_ptr<StreamWait> wait = std::make_shared<StreamWait>();
    std::optional<SceneDescription> described{};  ///< in place of its own scene
    /// One that is there already, for the first to receive by.
    std::shared_ptr<StreamBytes> connection{};
    /// Of a stream in two levels: the clock by which that is chosen which the link carries; null: the full
    /// one.
    std::function<std::int64_t()> now_ns{};
};

/// A frameset as it came.
struct Received {
    std::int64_t number = 0;
    std::int64_t sent_ns = 0;  ///< by the sender's clock, or by its frames' times; 0: not known
    RawFrame frame;            ///< its planes; number and time are for whoever shows it
};

/// Of its samples.
std::size_t bytes_of_planes(const RawFrame& frame);

/// One connection to a sender: framesets in order, those alone that are whole, each with what `Scene` says.
class StreamReceiver {
public:
    /// Connects, and reads what it sends up to the first whole frameset. Errors name the stream.
    static Result<std::unique_ptr<StreamReceiver>> open(const StreamSource& source);

    const Scene& scene() const { return scene_; }
    const Unstated& unstated() const { return unstated_; }
    const std::vector<TrackInfo>& tracks() const { return tracks_; }
    const std::vector<std::string>& notes() const { return notes_; }
    /// Whether both say the same of scene and planes.
    bool is_like(const StreamReceiver& other) const;

    /// The next whole frameset, within `longest`; nothing once the sender has ended.
    Result<std::optional<Received>> next(std::chrono::milliseconds longest);
    /// Closes the connection, after which there is no `next`.
    void hang_up() {
        pictures_.reset();
        bytes_.reset();
    }
    void leave_out_colour() {
        with_colour_ = false;
        pictures_->leave_out_colour();
        assembler_->leave_out_colour();
    }
    /// What is known of the connection's datagrams, where its transport counts them.
    std::optional<LinkFigures> link() const { return bytes_ ? bytes_->link() : std::nullopt; }
    std::optional<LevelFigures> levels() const { return pictures_->levels(); }
    FramesetCounts counts() const { return assembler_->counts(); }
    /// Once it has ended.
    std::string how_it_ended() const { return pictures_->how_it_ended(); }
    /// Likewise: in the middle of a frameset, or of the connection.
    bool was_broken_off() const { return pictures_->was_lost() || assembler_->has_part(); }

private:
    explicit StreamReceiver(const StreamSource& source) : name_(source.url.name()), wait_(source.wait) {}
    Result<void> connect(const StreamSource& source);
    Result<void> read_first();
    Result<void> take(StreamPictures::Came came);
    Received received(WholeFrameset frameset) const;

    const std::string name_;
    const std::shared_ptr<StreamWait> wait_;
    std::shared_ptr<const StreamBytes> bytes_;  // none: segments
    std::unique_ptr<StreamPictures> pictures_;
    Scene scene_;
    std::string scene_text_;
    Unstated unstated_;
    std::optional<FramesetAssembler> assembler_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    std::optional<Received> first_;
    bool with_colour_ = true, has_ended_ = false;
};

}  // namespace touchable
