#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "engine/clip/track_decoder.hpp"
#include "engine/picture/demuxer.hpp"

namespace touchable {

/// Decodes a track of a file ahead of who reads it: large pictures on a thread of its own, small ones when
/// they are asked for. The same pictures and errors in the same order either way.
class TrackThread {
public:
    /// What is made of each decoded plane; `where` it is, for messages.
    using Fit = std::function<Result<Plane>(Plane, const std::string& where)>;
    TrackThread(TrackDecoder decoder, int stream, Fit fit);
    ~TrackThread();  ///< ends once the picture being decoded is done
    TrackThread(const TrackThread&) = delete;
    TrackThread& operator=(const TrackThread&) = delete;

    PlaneRole role() const { return decoder_.role(); }
    int stream() const { return stream_; }
    /// Complete once a picture was given.
    const TrackInfo& info() const { return decoder_.info(); }
    /// Likewise: whether its packets say how long their pictures stay.
    bool has_additions() const { return decoder_.has_additions(); }
    /// "clip.mkv: track depth".
    std::string name() const { return name_; }

    /// Gives it packets to work on while others are read.
    void fill(Demuxer& file);
    /// The next picture, whose plane is the one before where all samples are the same; nothing after the
    /// last. Waits for it.
    Result<std::optional<TrackDecoder::Picture>> next(Demuxer& file);
    /// From the packets on that come from now on, planes are left out where that saves decoding.
    void leave_out() { left_out_ = true; }
    /// Forgets all packets and pictures: the next packet holds this frame.
    void restart(std::int64_t frame);

private:
    using Outcome = Result<std::optional<TrackDecoder::Picture>>;
    struct Job {
        Result<PacketPtr> packet;  ///< null: there is none any more
        bool left_out = false;
    };
    bool has_room();
    void push(Demuxer& file);
    std::optional<Outcome> take();
    void run();
    void work(const Job& job);
    void give(Outcome outcome);
    Outcome fitted(TrackDecoder::Picture picture);

    TrackDecoder decoder_;  // the worker's, as is newest_
    const int stream_;
    const std::string name_;
    const Fit fit_;
    const bool threaded_;
    Plane newest_;
    // The reader's.
    bool left_out_ = false;
    bool all_read_ = false;         // or reading failed
    std::optional<Outcome> final_;  // the end or the error that was given

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Job> jobs_;  // guarded by mutex_, as are all below
    std::deque<Outcome> outcomes_;
    std::exception_ptr thrown_;
    bool working_ = false, stopping_ = false;
    std::thread thread_;
};

}  // namespace touchable
