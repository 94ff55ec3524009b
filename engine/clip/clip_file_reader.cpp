// SPDX-License-Identifier: Apache-2.0
// Reads our clips from files of any container: decodes tracks in parallel, checks frames against their times
// and the file's stated length, and seeks by the file's index as far as it leads.
#include <cmath>
#include <deque>
#include <functional>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/clip/readers.hpp"
#include "engine/picture/decoding.hpp"

namespace touchable {
namespace {

/// Packets of a track in flight: one being decoded, one waiting.
constexpr std::size_t packets_ahead = 2;
/// Pictures of at least this many pixels are decoded on a thread.
constexpr std::int64_t pixels_for_thread = 50'000;

/// Decodes a track of a file ahead of its reader: large pictures on a separate thread, small ones on demand.
/// Both ways give the same pictures and errors in the same order.
class TrackThread : NonCopyable {
public:
    /// Converts each decoded plane; `where`: its place, for messages.
    using Fit = std::function<Result<Plane>(Plane, const std::string& where)>;
    TrackThread(TrackDecoder decoder, int stream, Fit fit)
        : decoder_(std::move(decoder)),
          stream_(stream),
          name_(decoder_.name()),
          fit_(std::move(fit)),
          threaded_(decoder_.pixels() >= pixels_for_thread) {}

    /// Waits until the picture being decoded is done.
    ~TrackThread() { stop_thread(mutex_, stopping_, changed_, thread_); }

    PlaneRole role() const { return decoder_.role(); }
    int stream() const { return stream_; }
    /// Complete after the first picture.
    const TrackInfo& info() const { return decoder_.info(); }
    /// Whether its packets state how long their pictures stay; known after the first picture.
    bool has_additions() const { return decoder_.has_additions(); }
    /// "clip.mkv: track depth".
    std::string name() const { return name_; }

    /// Queues packets for the thread, so that it works while other tracks are read.
    void fill(Demuxer& file) {
        while (threaded_ && has_room()) push(file);
    }

    /// Waits for the next picture; nullopt after the last. If all samples are the same, its plane is the one
    /// before.
    Result<std::optional<TrackDecoder::Picture>> next(Demuxer& file) {
        while (!final_) {
            if (auto outcome = take()) {
                if (*outcome && **outcome) return std::move(*outcome);
                final_ = std::move(outcome);
            } else {
                push(file);
            }
        }
        return *final_;
    }

    /// Leaves out the planes of later packets if that saves decoding.
    void leave_out() { left_out_ = true; }
    /// Forgets all packets and pictures: the next packet holds this frame.
    void restart(std::int64_t frame) {
        std::unique_lock lock(mutex_);
        jobs_.clear();
        changed_.wait(lock, [this] { return !working_; });
        if (thrown_) {  // the exception has ended the thread
            lock.unlock();
            thread_.join();
            lock.lock();
            thrown_ = nullptr;
        }
        outcomes_.clear();
        decoder_.restart(frame);
        final_.reset();
        all_read_ = false;
    }

private:
    using Outcome = Result<std::optional<TrackDecoder::Picture>>;
    struct Job {
        Result<PacketPtr> packet;  ///< null: end of the track
        bool left_out = false;
    };
    bool has_room() {
        if (all_read_) return false;
        const std::lock_guard lock(mutex_);
        return jobs_.size() + outcomes_.size() + (working_ ? 1 : 0) < packets_ahead;
    }

    void push(Demuxer& file) {
        auto packet = file.next(stream_);
        all_read_ = !packet || !*packet;
        std::unique_lock lock(mutex_);
        jobs_.push_back({std::move(packet), left_out_});
        lock.unlock();
        changed_.notify_all();
        if (!threaded_ || thread_.joinable()) return;
        if (auto started = start_thread(thread_, "track-decoder", "that decodes a track", [this] { run(); });
            !started)
            give(started.error());
    }

    /// Returns nullopt if a further packet is needed.
    std::optional<Outcome> take() {
        std::unique_lock lock(mutex_);
        if (!threaded_ && outcomes_.empty() && !jobs_.empty()) {
            const Job job = std::move(jobs_.front());
            jobs_.pop_front();
            lock.unlock();
            work(job);
            lock.lock();
        }
        changed_.wait(lock, [this] { return !outcomes_.empty() || thrown_ || (jobs_.empty() && !working_); });
        if (!outcomes_.empty()) {
            auto outcome = std::move(outcomes_.front());
            outcomes_.pop_front();
            return outcome;
        }
        if (thrown_) std::rethrow_exception(thrown_);
        return std::nullopt;
    }

    /// Catches every exception: `next` throws it again.
    void run() {
        std::unique_lock lock(mutex_);
        while (true) {
            changed_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
            if (stopping_) return;
            const Job job = std::move(jobs_.front());
            jobs_.pop_front();
            working_ = true;
            lock.unlock();
            std::exception_ptr thrown;
            try {
                work(job);
            } catch (...) {
                thrown = std::current_exception();
            }
            lock.lock();
            working_ = false;
            thrown_ = thrown;
            changed_.notify_all();
            if (thrown_) return;
        }
    }

    void work(const Job& job) {
        if (!job.packet) return give(job.packet.error());
        const AVPacket* packet = job.packet->get();
        if (packet && job.left_out && decoder_.is_one_packet_each()) {
            auto skipped = decoder_.skip(*packet);
            return give(skipped ? Outcome(std::optional(std::move(*skipped))) : Outcome(skipped.error()));
        }
        if (auto sent = decoder_.send(packet); !sent) return give(sent.error());
        while (true) {
            auto decoded = decoder_.receive();
            if (!decoded) return give(decoded.error());
            if (!*decoded) break;
            give(fitted(std::move(**decoded)));
        }
        if (!packet) give(std::optional<TrackDecoder::Picture>());
    }

    void give(Outcome outcome) {
        {
            const std::lock_guard lock(mutex_);
            outcomes_.push_back(std::move(outcome));
        }
        changed_.notify_all();
    }

    Outcome fitted(TrackDecoder::Picture picture) {
        TRY_ASSIGN(auto plane,
                   fit_(std::move(picture.plane), name_ + ", frame " + std::to_string(picture.number)));
        if (!same_samples(plane.view, newest_.view)) newest_ = std::move(plane);
        picture.plane = newest_;
        return std::optional(std::move(picture));
    }

    TrackDecoder decoder_;  // used by the worker thread, as is newest_
    const int stream_;
    const std::string name_;
    const Fit fit_;
    const bool threaded_;
    Plane newest_;
    // Used by the reading thread.
    bool left_out_ = false;
    bool all_read_ = false;         // true also if reading failed
    std::optional<Outcome> final_;  // the end or the error that was given

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Job> jobs_;  // guarded by mutex_, as are all below
    std::deque<Outcome> outcomes_;
    std::exception_ptr thrown_;
    bool working_ = false, stopping_ = false;
    std::thread thread_;
};

constexpr double ns_per_second = 1e9, latest_seconds = 4e9;

class ClipFileReader final : public ClipReader {
public:
    ClipFileReader(const SourceFile& source, std::unique_ptr<ClipContainer> container)
        : file_(source.string()), container_(std::move(container)) {
        add_input(source.path());
    }
    Result<void> open(const std::optional<SceneDescription>& replacement) {
        TRY(open_file());
        TRY_ASSIGN(recorded_rate_, container_->rate(*demuxer_));
        TRY_ASSIGN(whole_, container_->whole_part(*demuxer_));
        TRY(read_scene(replacement));
        TRY(start());
        return describe();
    }

    bool leaves_far_open() const { return unstated_.far; }

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return unstated_.filters; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return promised_; }
    const std::vector<ClipNote>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override {
        if (first_) return std::exchange(first_, std::nullopt);
        return read();
    }

    Result<void> rewind() override { return seek(0); }
    /// Seeks by the file's index; if that does not lead there, reads on from the first byte.
    Result<void> seek(std::int64_t frame) override {
        if (frame < 0)
            return usage_error("frame " + std::to_string(frame) + " is before the clip's first, 0");
        first_.reset();
        TRY_ASSIGN(index_leads_, begin_at(frame));
        if (!index_leads_) {
            TRY(open_file());
            TRY(start());
        }
        while ((first_ ? 0 : number_) < frame) {
            TRY_ASSIGN(const auto passed, next());
            if (!passed)
                return usage_error(file_ + ": has no frame " + std::to_string(frame) + ": its last is " +
                                   std::to_string(number_ - 1));
        }
        return {};
    }

    /// 0 for clips re-encoded by other programs, whose access points are not known.
    std::int64_t access_point(std::int64_t frame) const override {
        if (!index_leads_) return 0;
        if (container_->has_whole_index()) return indexed_access_point(frame);
        const auto is_ours = [](const Track& track) { return track.pictures->has_additions(); };
        if (std::ranges::all_of(tracks_, is_ours)) return frame - frame % clip_tags::access_interval;
        const auto is_ffv1 = [](const Track& track) { return track.pictures->info().codec == "ffv1"; };
        return std::ranges::all_of(tracks_, is_ffv1) ? frame : 0;
    }

    void leave_out_colour() override { with_colour_ = false; }

private:
    struct Track {
        std::unique_ptr<TrackThread> pictures;
        std::unique_ptr<TrackThread> low{};  // low bits; null: all bits are in `pictures`
        int low_bits = 0;
        bool is_lossless = false;
        Plane newest{};
        std::int64_t until = 0;  // first frame that needs another picture
    };

    Error refuse(const std::string& what, Hints hints = {}) const {
        return input_error(file_ + ": " + what, std::move(hints));
    }
    Result<void> open_file() {
        TRY_ASSIGN(auto demuxer, container_->open());
        tracks_.clear();
        demuxer_ = std::move(demuxer);
        return {};
    }

    /// Opens the tracks of a file just opened and reads frame 0.
    Result<void> start() {
        number_ = 0;
        first_.reset();
        TRY(open_tracks());
        TRY_ASSIGN(auto frame, read());
        if (!frame) return refuse(why_without_frames(whole_ && whole_->is_cut));
        first_ = std::move(*frame);
        return {};
    }

    Result<void> read_scene(const std::optional<SceneDescription>& replacement) {
        TRY_ASSIGN(auto described, replacement ? Result<SceneDescription>(*replacement)
                                               : container_->scene(*demuxer_, recorded_rate_));
        notes_.insert(notes_.end(), container_->notes().begin(), container_->notes().end());
        if (!described.unstated.rate)
            if (auto note = clip_tags::rate_note(described.scene.rate, recorded_rate_))
                notes_.push_back(std::move(*note));
        TRY_ASSIGN(scene_, error_at(file_, settle(described, {.rate = recorded_rate_})));
        unstated_ = described.unstated;
        return read_poses();
    }

    /// Pose times are those at which the frames were recorded.
    Result<void> read_poses() {
        const auto text = container_->poses(*demuxer_);
        if (!text) return {};
        TRY_ASSIGN(const auto poses, parse_timed_poses(*text, file_ + ": poses.txt", scene_.metres_per_unit));
        scene_.path = std::make_shared<const CameraPath>(path_of_timed_poses(poses, recorded_rate_));
        return {};
    }

    Result<void> open_tracks() {
        TRY_ASSIGN(const auto found, container_->tracks(*demuxer_, scene_));
        const auto halves = std::ranges::count_if(
            found, [](const ClipContainer::Track& track) { return track.low_stream.has_value(); });
        const std::size_t tracks = found.size() + static_cast<std::size_t>(halves);
        for (const ClipContainer::Track& track : found) {
            const PlaneRole role = track.role;
            const auto open = [&](int stream, TrackThread::Fit fit) -> Result<std::unique_ptr<TrackThread>> {
                TRY_ASSIGN(auto decoder,
                           TrackDecoder::open(*demuxer_->container().streams[stream], role, file_, tracks));
                demuxer_->select(stream);
                return std::make_unique<TrackThread>(std::move(decoder), stream, std::move(fit));
            };
            const auto fit = [this, role](Plane plane, const std::string& where) {
                return fit_plane(role, std::move(plane), scene_, where);
            };
            const auto leave = [](Plane plane, const std::string&) {
                return Result<Plane>(std::move(plane));
            };
            TRY_ASSIGN(auto pictures, open(track.stream, track.low_stream ? TrackThread::Fit(leave)
                                                                          : TrackThread::Fit(fit)));
            Track& made = tracks_.emplace_back(Track{.pictures = std::move(pictures)});
            made.low_bits = track.low_bits;
            made.is_lossless = track.is_lossless;
            if (!track.low_stream) continue;
            TRY_ASSIGN(made.low, open(*track.low_stream, leave));
        }
        return {};
    }

    /// Sets frame count, tracks and notes, once frame 0 is read.
    Result<void> describe() {
        if (whole_) {
            promised_ = whole_->frames;
            if (recorded_rate_.own_times && std::ssize(*recorded_rate_.own_times) < promised_)
                return refuse_times();
            if (whole_->is_cut)
                notes_.push_back("the file is cut: its first " +
                                 counted(promised_, "frame is", "frames are") + " whole");
            else if (whole_->is_uneven)
                notes_.push_back("its tracks end at different frames: the first " +
                                 counted(promised_, "has all", "have all"));
            return describe_tracks();
        }
        // A Matroska file gets its duration when it is completed, so one that ends sooner is not whole.
        const std::optional<double> end_s = demuxer_->pictures_end();
        if (!end_s) return refuse("was never completed: it has no duration");
        constexpr double rounding = 0.002;
        if (!recorded_rate_.own_times) {
            promised_ = std::llround((*end_s - origin_seconds_) * recorded_rate_.per_second());
            return describe_tracks();
        }
        promised_ = std::ssize(*recorded_rate_.own_times);
        const double left = *end_s - origin_seconds_ - seconds_of(promised_ - 1);  // for the last frame
        if (left < -rounding) return refuse_times();
        if (left > longest_gap() + rounding && pictures_of_depth() > promised_) return refuse_times();
        return describe_tracks();
    }

    Result<void> describe_tracks() {
        for (const Track& track : tracks_) {
            TrackInfo& info = infos_.emplace_back(track.pictures->info());
            info.lossless = info.lossless || track.is_lossless;
            if (track.low) info.pixel_format = std::to_string(8 + track.low_bits) + " bits in two tracks";
        }
        const auto notes = describe_planes(infos_, *first_, scene_);
        notes_.insert(notes_.end(), notes.begin(), notes.end());
        return {};
    }

    std::vector<int> streams() const {
        std::vector<int> all;
        for (const Track& track : tracks_) {
            all.push_back(track.pictures->stream());
            if (track.low) all.push_back(track.low->stream());
        }
        return all;
    }

    /// The last frame at or before this one that is a keyframe in every track, by the index. In some tracks
    /// every picture is a keyframe: the others decide.
    std::int64_t indexed_access_point(std::int64_t frame) const {
        std::int64_t target = frame, before = frame + 1;
        while (target < before) {  // a keyframe of one track need not be one of another
            before = target;
            for (const int stream : streams()) {
                if (container_->has_whole_index()) {
                    target = std::min(target, demuxer_->key_picture(stream, target));
                    continue;
                }
                const auto key = demuxer_->key_before(stream, timestamp_of(stream, target));
                if (const auto begins = key ? frame_of(stream, *key) : std::nullopt)
                    target = std::min(target, *begins);
            }
        }
        return target;
    }

    /// The frame of the next keyframe packet. FFmpeg seeks the other tracks to the time at which the first
    /// decodes a frame, which may be before it is shown: packets before `least` are skipped.
    std::optional<std::int64_t> key_packet(int stream, std::int64_t least) {
        while (true) {
            const auto packet = demuxer_->peek(stream);
            if (!packet || !*packet) return std::nullopt;
            const bool is_key = ((*packet)->flags & AV_PKT_FLAG_KEY) != 0;
            const auto begins = frame_of(stream, (*packet)->pts);
            if (is_key && (!begins || *begins >= least)) return begins;
            if (least == 0 || !demuxer_->next(stream)) return std::nullopt;
        }
    }

    /// Seeks to the last frame at or before this one that is a keyframe in every track; false if the index
    /// leads to no such frame.
    Result<bool> begin_at(std::int64_t frame) {
        const int depth = tracks_.front().pictures->stream();
        const auto go_to = [&](std::int64_t to) { return demuxer_->seek(depth, timestamp_of(depth, to)); };
        const bool is_whole = container_->has_whole_index();
        // In Matroska the first search reads the index.
        if (!is_whole && !go_to(frame)) return false;
        const std::int64_t target = indexed_access_point(frame);
        if ((is_whole || target < frame) && !go_to(target)) return false;
        std::optional<std::int64_t> there;
        for (const int stream : streams()) {
            const auto begins = key_packet(stream, is_whole ? target : 0);
            if (!begins || (there && *there != *begins) || *begins > frame) return false;
            there = begins;
        }
        // Pictures of an open group are shown before its keyframe.
        if (is_whole && *there != target) return false;
        number_ = *there;
        for (Track& track : tracks_) {
            track.pictures->restart(number_);
            if (track.low) track.low->restart(number_);
            track.until = number_;
        }
        return true;
    }

    double tick_of(int stream) const { return av_q2d(demuxer_->container().streams[stream]->time_base); }
    double seconds_of(std::int64_t frame) const {
        return static_cast<double>(recorded_rate_.time_ns(frame)) / ns_per_second;
    }
    // Timestamps are the frames' times rounded to milliseconds; frame 0 is at the origin.
    std::optional<std::int64_t> frame_of(int stream, std::int64_t timestamp) const {
        if (timestamp == AV_NOPTS_VALUE) return std::nullopt;
        const double seconds = static_cast<double>(timestamp) * tick_of(stream) - origin_seconds_;
        if (!(std::fabs(seconds) < latest_seconds)) return std::nullopt;
        return recorded_rate_.nearest(std::llround(seconds * ns_per_second));
    }

    std::int64_t timestamp_of(int stream, std::int64_t frame) const {
        return std::llround((origin_seconds_ + seconds_of(frame)) / tick_of(stream));
    }

    /// Returns false after the last picture.
    Result<bool> read_plane(Track& track, RawFrame& frame) {
        if (number_ >= track.until) {
            TRY_ASSIGN(auto picture, track.pictures->next(*demuxer_));
            if (!picture) return false;
            TRY(check_time(*track.pictures, picture->timestamp));
            track.newest = std::move(picture->plane);
            track.until = number_ + picture->frames;
            if (track.low) TRY(join_low(track));
        }
        if (!track.newest.view.empty()) add_plane(frame, track.pictures->role(), track.newest);
        return true;
    }

    /// Joins the low bits to the newest picture's high bits.
    Result<void> join_low(Track& track) {
        TRY_ASSIGN(auto low, track.low->next(*demuxer_));
        const std::string where = track.pictures->name() + ", frame " + std::to_string(number_);
        if (!low) return input_error(where + ": its low bits are missing");
        TRY(check_time(*track.low, low->timestamp));
        const PlaneView &high = track.newest.view, &below = low->plane.view;
        const auto is_grey = [](const PlaneView& plane) {
            return plane.channels == 1 && plane.bytes_per_sample == 1;
        };
        if (!is_grey(high) || !is_grey(below) || high.width != below.width || high.height != below.height)
            return input_error(where + ": its high and low bits are not two grey pictures of one size");
        FramePtr joined = joined_bytes(high, below, track.low_bits);
        if (!joined) return memory_error();
        TRY_ASSIGN(track.newest, fit_plane(track.pictures->role(),
                                           plane_from(std::move(joined), 8 + track.low_bits), scene_, where));
        return {};
    }

    /// Detects lost or moved frames: a timestamp must be its frame number's time, up to rounding.
    Result<void> check_time(const TrackThread& track, std::int64_t timestamp) {
        const double seconds = static_cast<double>(timestamp) * tick_of(track.stream());
        if (number_ == 0 && track.role() == PlaneRole::depth) origin_seconds_ = seconds;
        const double expected = seconds_of(number_);
        constexpr double rounding = 0.00101;  // seconds; two timestamps, to milliseconds
        if (timestamp != AV_NOPTS_VALUE && std::fabs(seconds - origin_seconds_ - expected) < rounding)
            return {};
        const auto& own = recorded_rate_.own_times;
        if (own && number_ >= static_cast<std::int64_t>(own->size())) return refuse_times();
        return input_error(track.name() + ", frame " + std::to_string(number_) +
                           ": is missing, or not at its time: the picture found there is stamped " +
                           std::to_string(seconds - origin_seconds_) + " s instead of " +
                           std::to_string(expected) + " s");
    }

    double longest_gap() const {
        const auto& times_ns = *recorded_rate_.own_times;
        std::int64_t longest = 0;
        for (std::size_t n = 1; n < times_ns.size(); ++n)
            longest = std::max(longest, times_ns[n] - times_ns[n - 1]);
        return static_cast<double>(longest) / ns_per_second;
    }

    /// Counts the pictures that can be read, in another pass over the whole file.
    std::int64_t pictures_of_depth() const {
        const auto file = container_->open();
        if (!file) return 0;
        const int stream = tracks_.front().pictures->stream();
        (*file)->select(stream);
        std::int64_t count = 0;
        for (auto packet = (*file)->next(stream); packet && *packet; packet = (*file)->next(stream)) ++count;
        return count;
    }

    Error refuse_times() const {
        return refuse("its " + std::string(container_->words().times) + " has the times of " +
                      std::to_string(recorded_rate_.own_times->size()) + " frames, but depth has " +
                      std::to_string(pictures_of_depth()) + " pictures: must be one time for each");
    }

    Result<std::optional<RawFrame>> read() {
        if (whole_ && number_ >= whole_->frames) return std::optional<RawFrame>{};
        RawFrame frame;
        frame.number = number_;
        frame.time_ns = scene_.rate.time_ns(number_);
        for (Track& track : tracks_) {
            // Frame 0 tells each track's format, so it has all planes.
            if (!with_colour_ && number_ > 0 && track.pictures->role() == PlaneRole::colour)
                track.pictures->leave_out();
            track.pictures->fill(*demuxer_);
            if (track.low) track.low->fill(*demuxer_);
        }
        std::vector<std::string> present, ended;
        for (Track& track : tracks_) {
            TRY_ASSIGN(const auto there, read_plane(track, frame));
            (there ? present : ended).push_back(track.pictures->info().role);
        }
        if (!ended.empty()) {
            TRY(check_end(present, ended));
            return std::optional<RawFrame>{};
        }
        ++number_;
        return std::optional(std::move(frame));
    }

    Result<void> check_end(const std::vector<std::string>& present,
                           const std::vector<std::string>& ended) const {
        const std::string where = "track " + ended.front() + ", frame " + std::to_string(number_);
        if (!present.empty())
            return refuse(where + ": is missing, though track " + present.front() + " has it");
        if (number_ == 0 || number_ >= promised_) return {};
        return refuse(where + ": is where the clip ends, but it promises " + std::to_string(promised_) +
                      " frames: it is truncated or damaged");
    }

    std::string file_;
    std::unique_ptr<ClipContainer> container_;
    Scene scene_;
    SceneDescription::Unstated unstated_;  // by its description
    FrameRate recorded_rate_;
    std::vector<TrackInfo> infos_;
    std::vector<ClipNote> notes_;
    std::int64_t promised_ = 0;
    std::optional<ClipContainer::WholePart> whole_;  // of a file that states no length
    bool index_leads_ = true;                        // false: the last seek by the index failed
    bool with_colour_ = true;

    // Reading position, reset by `open_file` and `start`.
    std::unique_ptr<Demuxer> demuxer_;
    std::vector<Track> tracks_;
    std::int64_t number_ = 0;        // of the frame that `read` gives next
    double origin_seconds_ = 0;      // timestamp of frame 0
    std::optional<RawFrame> first_;  // read to learn the tracks' formats, not yet returned
};

Result<std::unique_ptr<ClipReader>> open_clip_file(const SourceFile& file,
                                                   std::unique_ptr<ClipContainer> container,
                                                   const std::optional<SceneDescription>& described,
                                                   Colour colour) {
    auto reader = std::make_unique<ClipFileReader>(file, std::move(container));
    TRY(reader->open(described));
    if (colour == Colour::left_out) reader->leave_out_colour();
    const bool far_is_open = reader->leaves_far_open();
    return with_far_plane(std::move(reader), far_is_open, file.path());
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_matroska_clip(const SourceFile& file,
                                                       const std::optional<SceneDescription>& described,
                                                       Colour colour) {
    return open_clip_file(file, matroska_container(file), described, colour);
}

Result<std::unique_ptr<ClipReader>> open_mp4_clip(const SourceFile& file,
                                                  const std::optional<SceneDescription>& described,
                                                  Colour colour) {
    return open_clip_file(file, mp4_container(file), described, colour);
}

Result<std::unique_ptr<ClipReader>> open_mp4_tracks(const SourceFile& file, const PlaneTracks& tracks,
                                                    const SceneDescription& described, Colour colour) {
    return open_clip_file(file, mp4_container(file, tracks), described, colour);
}

}  // namespace touchable
