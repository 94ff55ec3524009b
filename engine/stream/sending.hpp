// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sending: a clip, or a camera, as a stream for any number of receivers.
//
//   StreamSender --frames--> StreamMuxer --blocks--> StreamRing --> StreamServer: TCP and HTTP
//                                                               --> SrtOutput
//                   HlsWriter: a folder for web servers (HLS)
//
// A StreamSender reads the clip, waits for each frame's time, and passes it to a muxer for each form of the
// stream: Matroska for our own programs, MPEG-TS for stock tools, HLS. So each form is encoded once, however
// many receive it. A ring keeps a form's newest framesets; its listeners take them from there, each at the
// pace of its link, and a slow or hostile listener costs the others nothing. StreamAudience counts the
// listeners and writes one line for people whenever one comes or goes.
//
// To send: make the muxers, a ring for each, the audience; `StreamServer::open` and `SrtOutput::create` for
// the URLs, then `start` each; run the StreamSender on its own thread. `StreamSender::end` ends the rings,
// and with them the listeners, after each has got the rest. HlsWriter::finish writes the last segment.
//
// Threads: StreamSender::run, its muxers and HlsWriter belong to one thread. StreamRing and StreamAudience
// may be called by any thread, but each ring cursor by one. Servers and outputs have threads of their own;
// create, start and destroy them on one thread. Rings, audience and StreamSender::Time outlive all that
// refers to them.

#include <deque>
#include <filesystem>
#include <functional>
#include <span>

#include "engine/base/threads.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/containers.hpp"
#include "engine/picture/sound.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

// --- Forms of a stream

/// Makes the bytes of a stream, once for all listeners. Used by one thread. Touch planes are lossless, each
/// picture is labelled and can be checked; the scene goes with each beginning.
class StreamMuxer {
public:
    /// A frameset in a container: bytes that may follow those of any frameset before. A listener may begin
    /// with any block that is a key.
    struct Block {
        std::int64_t frame = 0;  ///< its number in the stream
        bool is_key = false;     ///< decoding of all planes begins here
        std::vector<std::uint8_t> bytes;
        /// Bytes at the end that are its colour. A listener without them stays without colour until a key.
        std::size_t colour_bytes = 0;

        std::span<const std::uint8_t> given(bool with_colour) const {
            return std::span(bytes).first(bytes.size() - (with_colour ? 0 : colour_bytes));
        }
    };

    virtual ~StreamMuxer() = default;
    /// The bytes that every listener gets first; available after the first frame was added.
    virtual std::span<const std::uint8_t> header() const = 0;
    /// A few meaningless bytes, which may follow any block.
    virtual std::span<const std::uint8_t> padding() const { return {}; }
    /// Adds the next frame, shown `time_ns` after the stream's beginning; planes like those of the first one.
    virtual Result<Block> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                              bool is_key) = 0;
};

/// A stream in our clips' own form, Matroska: tracks with their roles, the scene attached, and for each
/// frameset one picture of every plane, labelled (BlockAddition), in its own clusters. Touch is lossless,
/// colour as good as the eye can tell. `sound`, if any, is included, and begins anew with each frame of
/// another epoch (RawFrame::epoch): a loop's next round. The header and all blocks from any key block on are
/// a clip.
///
/// Refused: a scene that no clip can have, sound that cannot be stored; by the first `add`
/// (ErrorKind::usage), pictures of a size that cannot be encoded.
Result<std::unique_ptr<StreamMuxer>> open_matroska_stream(const SceneDescription& described,
                                                          const std::optional<SoundPart>& sound = {});

/// Framesets as MPEG-TS, for stock tools: each plane is an H.264 track with labelled pictures
/// (LabelledEncoder), colour first. There is no header: each key block has everything that a listener needs.
/// A block is whole packets of 188 bytes. Refused: a scene that no clip can have.
Result<std::unique_ptr<StreamMuxer>> make_mpegts_muxer(const SceneDescription& described);

// --- HTTP Live Streaming

/// The playlist in an HlsWriter's folder that players open.
inline constexpr std::string_view hls_master_name = "master.m3u8";

/// A stream as a folder of files that any web server delivers to any number of viewers (HTTP Live Streaming,
/// RFC 8216): two renditions in fragmented MP4, colour (with sound) and the touch planes, cut at the same
/// frames, and a master playlist in which ordinary players find the colour alone. The low level has both once
/// more: colour of half the bit rate, and the planes of every second frameset of a segment. Pictures are
/// labelled (LabelledEncoder). Each file appears whole; a segment is deleted some time after the last
/// playlist that names it. As a StreamMuxer, its blocks have no bytes, and decoding begins where its segments
/// do.
class HlsWriter : public StreamMuxer {
public:
    struct Settings {
        std::filesystem::path folder;
        std::int64_t segment_ns = 1'000'000'000;  ///< from 0.5 s to 10 s
        /// Live: duration of the stream that the playlists hold, which are written after each segment. 0: all
        /// of it, and they are written at the end.
        std::int64_t window_ns = 0;
        bool has_low = false;  ///< a second level of about half the bytes, for narrow links
    };

    /// Figures of what was written, and thus of what each viewer fetches.
    struct Figures {
        std::int64_t segments = 0, duration_ns = 0;              ///< of the segments that are complete
        std::int64_t colour_bytes = 0, touch_bytes = 0;          ///< of these segments
        std::int64_t low_colour_bytes = 0, low_touch_bytes = 0;  ///< in their place, on a narrow link
        /// Both media playlists at present; a live stream's are fetched once a segment.
        std::int64_t playlist_bytes = 0;
    };

    /// Refused: a folder with other files, a scene that no clip can have, a length that is out of range
    /// (ErrorKind::usage). Sound that is not AAC is left out with a note.
    static Result<std::unique_ptr<HlsWriter>> open(const Settings& settings,
                                                   const SceneDescription& described,
                                                   const std::optional<SoundPart>& sound = {});

    std::span<const std::uint8_t> header() const final { return {}; }
    /// Writes the last segment, and the end of the playlists.
    virtual Result<void> finish() = 0;
    /// Remarks for people, available after the first frame was added.
    virtual const std::vector<std::string>& notes() const = 0;
    virtual const Figures& figures() const = 0;
};

// --- Listeners and what they are sent

/// A stream's header and its newest framesets, shared by all listeners. Keeps as many framesets as the bounds
/// allow, and always those from the newest key on. Any thread may call it, but each cursor belongs to one.
class StreamRing {
public:
    /// How far behind the newest frameset a listener may be, before whole framesets are left out for it.
    struct Bounds {
        std::int64_t framesets = 30;
        std::size_t bytes = std::size_t{64} << 20U;
    };

    using Block = std::shared_ptr<const StreamMuxer::Block>;
    using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;

    /// The position of one listener.
    class Cursor {
    public:
        std::int64_t dropped() const { return dropped_; }  ///< framesets left out for it

    private:
        friend class StreamRing;
        std::int64_t next_ = 0;  // counted from the stream's first block
        std::int64_t dropped_ = 0;
    };

    StreamRing() : StreamRing(Bounds{}) {}
    explicit StreamRing(const Bounds& bounds) : bounds_(bounds) {}
    /// `wake` is called after each change, on the thread that made it. Call this before others use the ring.
    void watch(std::function<void()> wake) { watchers_.push_back(std::move(wake)); }

    /// Sets header and padding (StreamMuxer), before the first block.
    void begin(std::span<const std::uint8_t> header, std::span<const std::uint8_t> padding = {});
    void add(StreamMuxer::Block block);
    /// To be called after the last block.
    void end() {
        {
            const std::lock_guard lock(mutex_);
            is_over_ = true;
        }
        changed();
    }

    /// A listener that joins begins with the newest key; if there is no block yet, with the first.
    Cursor join() const {
        const std::lock_guard lock(mutex_);
        Cursor cursor;
        cursor.next_ = newest_key_;
        return cursor;
    }
    /// Null before `begin`.
    Bytes header() const {
        const std::lock_guard lock(mutex_);
        return header_;
    }
    /// Empty before `begin`.
    std::vector<std::uint8_t> padding() const {
        const std::lock_guard lock(mutex_);
        return padding_;
    }
    /// The listener's next frameset: the one after its last or, if it is too far behind, the newest key.
    /// Null: there is none yet.
    Block next(Cursor& cursor) const {
        const std::lock_guard lock(mutex_);
        return advance(cursor);
    }
    /// `next`, after waiting at most `longest` for a frameset.
    Block wait_next(Cursor& cursor, std::chrono::milliseconds longest) const {
        std::unique_lock lock(mutex_);
        there_is_more_.wait_for(lock, longest, [&] { return is_over_ || cursor.next_ < end_of_kept(); });
        return advance(cursor);
    }
    /// Whether `next` would return one.
    bool has_next(const Cursor& cursor) const {
        const std::lock_guard lock(mutex_);
        return cursor.next_ < end_of_kept();
    }
    /// Makes the newest key the listener's next frameset and leaves out those before it. False: there is none
    /// to leave out.
    bool go_to_newest_key(Cursor& cursor) const {
        const std::lock_guard lock(mutex_);
        if (cursor.next_ >= newest_key_) return false;
        cursor.dropped_ += newest_key_ - cursor.next_;
        cursor.next_ = newest_key_;
        return true;
    }
    /// Whether `next` will return nothing more for it.
    bool is_over(const Cursor& cursor) const {
        const std::lock_guard lock(mutex_);
        return is_over_ && cursor.next_ >= end_of_kept();
    }
    /// Whether `end` was called.
    bool is_ended() const {
        const std::lock_guard lock(mutex_);
        return is_over_;
    }

private:
    struct Kept {
        Block block;
        std::size_t bytes_before;  // of the stream, up to this block
    };
    /// A cursor whose next block is no longer kept goes on with the newest key.
    Block advance(Cursor& cursor) const {
        if (cursor.next_ < first_) {
            cursor.dropped_ += newest_key_ - cursor.next_;
            cursor.next_ = newest_key_;
        }
        if (cursor.next_ >= end_of_kept()) return nullptr;
        return kept_[static_cast<std::size_t>(cursor.next_++ - first_)].block;
    }
    std::int64_t end_of_kept() const { return first_ + std::ssize(kept_); }
    void changed() {
        there_is_more_.notify_all();
        for (const auto& wake : watchers_) wake();
    }

    const Bounds bounds_;
    std::vector<std::function<void()>> watchers_;
    mutable std::mutex mutex_;
    mutable std::condition_variable there_is_more_;
    // Guarded by mutex_.
    Bytes header_;
    std::vector<std::uint8_t> padding_;
    std::deque<Kept> kept_;
    std::int64_t first_ = 0;  // number of kept_'s first block
    std::int64_t newest_key_ = 0;
    std::size_t bytes_ = 0;  // of all blocks so far
    bool is_over_ = false;
};

/// The listeners of a stream, present and past, and what they were sent. Any thread.
class StreamAudience {
public:
    /// Figures of one listener.
    struct Listener {
        std::string name;                           ///< "tcp://192.168.0.5:41234"
        std::int64_t sent = 0, dropped = 0;         ///< framesets
        std::int64_t without_colour = 0;            ///< of those sent, because its link is narrow
        std::string end{};                          ///< why it left; empty: it had all of the stream
        std::optional<StreamFigures::Link> link{};  ///< of its connection, if the transport counts (SRT)
    };

    static constexpr int most_listeners = 64;

    /// `say` gets one line for each listener that comes or goes, from one thread at a time.
    explicit StreamAudience(std::function<void(const std::string&)> say) : say_(std::move(say)) {}

    void came(const std::string& name);
    void went(Listener figures);
    /// Says that a listener's link is too narrow for the colour.
    void goes_without_colour(const std::string& name) {
        remark(name + ": its link is too narrow; colour is left out for it until it keeps up");
    }
    /// Another line for a person about the listeners.
    void remark(const std::string& line) {
        const std::lock_guard lock(mutex_);
        say_(line);
    }

    int there() const { return there_; }
    bool has_room() const { return there_ < most_listeners; }
    /// Past listeners, the earliest first, the last 256; `all` counts every listener so far.
    std::vector<Listener> gone() const {
        const std::lock_guard lock(mutex_);
        return gone_;
    }
    std::int64_t all() const {
        const std::lock_guard lock(mutex_);
        return all_;
    }

private:
    mutable std::mutex mutex_;
    std::function<void(const std::string&)> say_;  // guarded by mutex_, as are the next members
    std::vector<Listener> gone_;
    std::int64_t all_ = 0;
    std::atomic<int> there_{0};
};

// --- Outputs

/// Sends a stream to every client that connects by TCP or HTTP, to each at its own pace.
class StreamServer {
public:
    static constexpr int most_connections = 96;
    /// ns since any beginning; never backward. Empty: std::chrono::steady_clock.
    using Clock = std::function<std::int64_t()>;
    /// Folders of files that HTTP serves beside the stream (served_file in listeners.hpp). Empty: the stream
    /// alone.
    using Page = std::vector<std::filesystem::path>;

    /// Listens at tcp:// and http:// names; port 0: any free one. Refused: (ErrorKind::usage) a host that is
    /// no numeric address, and (ErrorKind::input) an address that is not available.
    static Result<std::unique_ptr<StreamServer>> open(const std::vector<StreamUrl>& urls, StreamRing& ring,
                                                      StreamAudience& audience, Clock clock = {},
                                                      Page page = {});
    /// Closes everything at once.
    virtual ~StreamServer() = default;

    /// Where it listens: "tcp://0.0.0.0:7000".
    virtual std::vector<std::string> addresses() const = 0;
    /// Starts its thread, which takes turns until the server is destroyed.
    virtual Result<void> start() = 0;
    /// Waits at most `longest` for work, and does it. Not while its thread runs.
    virtual void turn(std::chrono::milliseconds longest) = 0;
    /// Connections, including those that do not listen yet or any more.
    virtual int connections() const = 0;
};

/// A stream sent to one srt:// URL, by its own thread. It accepts several callers, each at its own pace, or
/// (mode=caller) calls, and calls again when the other end has gone; an end that goes within a second is
/// called again like one that does not answer.
class SrtOutput {
public:
    /// A listener binds its port here. Refused (ErrorKind::usage): another transport, a port 0, and a setting
    /// that SRT does not have; (ErrorKind::input) a port that is not available. The ring and the audience
    /// outlive it.
    static Result<std::unique_ptr<SrtOutput>> create(const StreamUrl& url, const StreamRing& ring,
                                                     StreamAudience& audience);
    /// Ends all of its work, within a tenth of a second.
    virtual ~SrtOutput() = default;

    virtual Result<void> start() = 0;
    /// Any thread: nothing more is sent, not even what is under way.
    virtual void end() = 0;
    /// Whether the stream is over, and all of it was sent, or there is no listener.
    virtual bool is_over() const = 0;
    /// Whether this end calls; otherwise it listens.
    virtual bool calls() const = 0;

    /// "srt://0.0.0.0:7000", as it was given, without the passphrase.
    std::string address() const { return url_.name(); }
    /// Whether only a program that knows the passphrase can receive it.
    bool is_encrypted() const { return !url_.value("passphrase").empty(); }

protected:
    explicit SrtOutput(const StreamUrl& url) : url_(url) {}
    const StreamUrl url_;
};

// --- The sender

/// Sends a clip at its own times, or a camera's frames as they are taken: each is encoded once in every form.
/// Frame numbers and times continue through the rounds of a loop. Decoding of all planes can begin at least
/// every half second, and every 15 frames.
class StreamSender {
public:
    /// A sender's clock and its waits.
    class Time {
    public:
        virtual ~Time() = default;
        /// The time of std::chrono::steady_clock, ns.
        virtual std::int64_t now_ns() = 0;
        /// The time since 1970 (UTC), ns; it may be stepped.
        virtual std::int64_t utc_ns() = 0;
        /// False: a stop of the thread was requested before (stop_requested).
        virtual bool wait_until(std::int64_t at_ns) = 0;
    };
    /// The clock and waits of this machine.
    class SystemTime final : public Time {
    public:
        std::int64_t now_ns() override;
        std::int64_t utc_ns() override {
            return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
        }
        bool wait_until(std::int64_t at_ns) override {
            return wait_unless_stopped(
                std::chrono::steady_clock::time_point(std::chrono::nanoseconds(at_ns)));
        }
    };

    /// A form in which a stream is sent, and where its framesets go.
    struct Channel {
        std::shared_ptr<StreamMuxer> muxer;
        StreamRing& ring;
    };

    struct Settings {
        bool loop = false;                         ///< clips: from the beginning again and again
        std::optional<std::int64_t> longest_ns{};  ///< of the stream
        bool is_paced = true;                      ///< clips; false: as fast as they can be read and encoded
    };

    /// Figures of what was sent, with listeners or without.
    struct Figures {
        std::int64_t framesets = 0, keys = 0, bytes = 0;
        std::int64_t rounds = 0;      ///< of a loop, that were begun
        std::int64_t latest_ns = 0;   ///< largest delay of a frameset
        std::int64_t held_up_ns = 0;  ///< delay that was not made up for
        bool clip_ended = false;      ///< it has no further frame; a camera: it is gone
    };

    /// From `run` to the first frame of a clip, for encoding its first frames.
    static constexpr std::int64_t lead_ns = 100'000'000;

    StreamSender(std::unique_ptr<ClipReader> clip, std::vector<Channel> channels, const Settings& settings,
                 Time& time)
        : clip_(std::move(clip)), channels_(std::move(channels)), settings_(settings), time_(time) {}

    /// Sends from the clip's beginning until its end, `longest_ns`, a call of `end`, or a stop of the thread,
    /// which may be an error of kind interrupted; the rings are over then.
    Result<void> run() {
        const StopScope until(ending_.get_token());
        auto sent = send_all();
        for (const Channel& channel : channels_) channel.ring.end();
        const bool is_ended =
            ending_.stop_requested() && !sent && sent.error().kind == ErrorKind::interrupted;
        return is_ended ? Result<void>{} : std::move(sent);
    }
    /// Any thread.
    void end() { ending_.request_stop(); }
    /// Number of framesets so far; any thread.
    std::int64_t framesets() const { return sent_; }
    /// Remarks for people, such as that the camera was unplugged.
    std::vector<std::string> remarks() const { return clip_->remarks(); }
    /// Available after `run`.
    const Figures& figures() const { return figures_; }

private:
    struct Due {
        std::int64_t time_ns;  ///< of the stream
        std::int64_t at_ns;    ///< by the sender's clock; of a camera's frame, when it was taken
    };
    Result<void> send_all();
    Result<std::optional<RawFrame>> next();
    /// With an even rate the rounds of a loop follow evenly, to the nanosecond.
    Due due(const RawFrame& frame) const {
        const FrameRate& rate = clip_->scene().rate;
        const bool has_own_times = clip_->is_live() || rate.own_times;
        const std::int64_t time_ns =
            has_own_times ? round_ns_ + frame.time_ns : rate.time_ns(figures_.framesets);
        return {time_ns, begin_ns_ + time_ns};
    }
    Result<bool> send(const RawFrame& frame, const Due& due);
    bool is_key(std::int64_t time_ns);
    void give(Channel& channel, StreamMuxer::Block block) {
        if (figures_.framesets == 0) channel.ring.begin(channel.muxer->header(), channel.muxer->padding());
        figures_.bytes += std::ssize(block.bytes);
        channel.ring.add(std::move(block));
    }
    void keep_pace(const Due& due);

    const std::unique_ptr<ClipReader> clip_;
    std::vector<Channel> channels_;
    const Settings settings_;
    Time& time_;
    std::stop_source ending_;
    std::atomic<std::int64_t> sent_{0};
    Figures figures_;
    std::int64_t begin_ns_ = 0;  // time 0 of the stream
    std::int64_t round_ns_ = 0;  // begin of the round, if frames have their own times
    std::int64_t frames_of_round_ = 0;
    std::int64_t key_frame_ = 0, key_time_ns_ = 0;  // of the newest key
};

}  // namespace touchable
