// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numeric>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/camera/camera.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

namespace {

constexpr std::string_view replay_kind = "replay:", plugged_kind = "v4l2:", pipe_kind = "pipe:",
                           tcp_kind = "tcp://", stream_kind = "stream:";

constexpr std::array plugged_keys{
    KeyedValues::Key{.name = "size", .unit = "", .kind = KeyedValues::Key::Kind::words},
    KeyedValues::Key{.name = "fps", .unit = "frames/s", .least = 0.1, .greatest = 1000, .standard = 30},
    KeyedValues::Key{.name = "colour", .unit = "", .kind = KeyedValues::Key::Kind::words}};

constexpr std::array replay_keys{
    KeyedValues::Key{.name = "fps", .unit = "frames/s", .least = 0.1, .greatest = 1000, .standard = 30},
    KeyedValues::Key{.name = "jitter", .unit = "ms", .least = 0, .greatest = 1000, .standard = 0},
    KeyedValues::Key{.name = "drop", .unit = "of the frames", .least = 0, .greatest = 0.99, .standard = 0},
    KeyedValues::Key{.name = "stall", .unit = "s", .least = 0, .greatest = 1e6, .standard = 0},
    KeyedValues::Key{.name = "resume", .unit = "s", .least = 0, .greatest = 1e6, .standard = 0}};

/// Rounded to thousandths, so that cameras' 29.97 stays exact.
FrameRate rate_of(double per_second) {
    constexpr std::int64_t thousand = 1000;
    const std::int64_t thousandths = std::llround(per_second * thousand);
    const std::int64_t common = std::gcd(thousandths, thousand);
    return {thousandths / common, thousand / common};
}

/// The words after the kind: a file name and, after the first comma, keys.
struct CameraParts {
    std::string file, keys;
};
CameraParts parts_of(const std::string& words, std::string_view kind) {
    const std::size_t comma = words.find(',');
    if (comma == std::string::npos) return {words.substr(kind.size()), ""};
    return {words.substr(kind.size(), comma - kind.size()), words.substr(comma + 1)};
}

/// "640x480".
bool read_size(std::string_view words, V4l2Choice& choice) {
    constexpr int largest_side = 16384;
    choice.width = parsed_as<int>(cut_part(words, 'x')).value_or(0);
    choice.height = parsed_as<int>(words).value_or(0);
    return std::min(choice.width, choice.height) >= 1 &&
           std::max(choice.width, choice.height) <= largest_side;
}

Result<ClipChoice::LiveCamera> read_plugged(const std::string& words) {
    const auto [node, keys] = parts_of(words, plugged_kind);
    if (node.empty())
        return usage_error(
            "camera 'v4l2' needs a node, such as v4l2:/dev/video0; touchable cameras lists those that are "
            "there");
    TRY_ASSIGN(const auto given, KeyedValues::parse("camera 'v4l2'", keys, plugged_keys));
    V4l2Choice choice{node};
    if (given.given("size") && !read_size(given.words("size"), choice))
        return usage_error("camera 'v4l2': size=" + printable(given.words("size")) +
                           " is not allowed; must be WIDTHxHEIGHT, such as size=640x480");
    if (given.given("fps")) choice.rate = given.number("fps");
    choice.colour = given.words("colour");
    return ClipChoice::LiveCamera{std::move(choice), {}, {}};
}

Result<ClipChoice::LiveCamera> read_sender(const std::string& words) {
    FramesetChoice choice;
    if (words.starts_with(tcp_kind)) {
        choice.address = words.substr(tcp_kind.size());
        TRY(check_address(choice.address));
        return ClipChoice::LiveCamera{std::move(choice), {}, {}};
    }
    choice.command = words.substr(pipe_kind.size());
    if (choice.command.find_first_not_of(" \t") == std::string::npos)
        return usage_error(
            "camera 'pipe' needs a command that writes framesets, such as \"pipe:python3 realsense.py\" "
            "(docs/streaming.md)");
    return ClipChoice::LiveCamera{std::move(choice), {}, {}};
}

Result<ClipChoice::LiveCamera> read_stream(const std::string& words) {
    TRY_ASSIGN(auto url, read_stream_url(words.substr(stream_kind.size())));
    return ClipChoice::LiveCamera{StreamSource{.url = std::move(url)}, {}, {}};
}

Result<ClipChoice::LiveCamera> read_replay(const std::string& words) {
    const auto [recording, keys] = parts_of(words, replay_kind);
    if (recording.empty())
        return usage_error("camera 'replay' needs a recording: replay:PATH, with a clip or folder of images");
    TRY_ASSIGN(const auto given, KeyedValues::parse("camera 'replay'", keys, replay_keys));
    ClipChoice::LiveCamera camera{{}, typed_path(recording), {}};
    CameraDelivery& delivery = camera.delivery;
    if (given.given("fps")) delivery.rate = rate_of(given.number("fps"));
    delivery.jitter_ns = nanoseconds_of(given.number("jitter") * 1e-3);
    delivery.drop = given.number("drop");
    if (given.given("stall")) delivery.stall_ns = nanoseconds_of(given.number("stall"));
    if (given.given("resume")) delivery.resume_ns = nanoseconds_of(given.number("resume"));
    if (delivery.resume_ns && !(delivery.stall_ns && *delivery.stall_ns < *delivery.resume_ns))
        return usage_error(
            "camera 'replay': resume must be a moment after stall, which begins the time without frames");
    return camera;
}

// Frames; about a second. A disk that stalls for longer costs camera frames.
constexpr std::size_t most_waiting = 30;

class KeptCamera final : public ReaderAround {
public:
    KeptCamera(std::unique_ptr<ClipReader> camera, std::shared_ptr<CameraCapture> film)
        : ReaderAround(std::move(camera)), film_(std::move(film)) {}

private:
    Result<void> change(RawFrame& frame) override { return film_->keep(frame); }

    std::shared_ptr<CameraCapture> film_;
};

class CapturedCamera final : public ReaderAround {
public:
    CapturedCamera(std::unique_ptr<ClipReader> film, CameraCapture::Frames frames)
        : ReaderAround(std::move(film)), frames_(std::move(frames)) {}
    std::optional<std::int64_t> frame_count() const override { return std::nullopt; }
    std::int64_t access_point(std::int64_t) const override { return 0; }
    std::optional<std::int64_t> taken_at(std::int64_t frame) const override {
        const auto found = place_of(frame);
        return found != frames_.end() && found->number == frame ? std::optional(found->time_ns)
                                                                : std::nullopt;
    }
    Result<void> seek(std::int64_t frame) override {
        next_ = place_of(frame) - frames_.begin();
        return inner().seek(next_);
    }
    Result<std::optional<RawFrame>> next() override {
        if (next_ == std::ssize(frames_)) return std::optional<RawFrame>();
        auto frame = inner().next();
        if (!frame || !*frame) return frame;
        const CameraCapture::Frame& taken = frames_[static_cast<std::size_t>(next_++)];
        (*frame)->number = taken.number;
        (*frame)->time_ns = taken.time_ns;
        return frame;
    }

private:
    CameraCapture::Frames::const_iterator place_of(std::int64_t frame) const {
        return std::ranges::lower_bound(frames_, frame, {}, &CameraCapture::Frame::number);
    }

    CameraCapture::Frames frames_;
    std::ptrdiff_t next_ = 0;  // frame of the film
};

}  // namespace

std::vector<std::string> camera_words() {
    std::vector<std::string> words;
    for (const auto& [kind, place] : {std::pair{plugged_kind, "/dev/videoN"},
                                      {pipe_kind, "CMD"},
                                      {tcp_kind, "HOST:PORT"},
                                      {stream_kind, "ADDRESS"},
                                      {replay_kind, "PATH"}})
        words.push_back(std::string(kind) + place);
    return words;
}

Result<ClipChoice::LiveCamera> read_live_camera(const std::string& words) {
    if (words.starts_with(plugged_kind)) return read_plugged(words);
    if (words.starts_with(replay_kind)) return read_replay(words);
    if (words.starts_with(pipe_kind) || words.starts_with(tcp_kind)) return read_sender(words);
    if (words.starts_with(stream_kind)) return read_stream(words);
    const bool is_number = is_digits(words);
    if (is_number || words.starts_with("/dev/video"))
        return usage_error("unknown camera '" + printable(words) + "': did you mean v4l2:" +
                           (is_number ? "/dev/video" : "") + printable(words) + "?");
    return usage_error("unknown camera '" + printable(words) +
                       "'; there are v4l2:/dev/videoN, one that is plugged in (touchable cameras lists "
                       "them), pipe:CMD and tcp://HOST:PORT, programs that send framesets, stream:ADDRESS, "
                       "what touchable serve sends, and replay:PATH, a recording that behaves like one");
}

Result<void> CameraCapture::open(const std::filesystem::path& file, Existing existing) {
    TRY_ASSIGN(writer_, create_clip(file, described_, {}, existing));
    file_ = file;
    {
        const std::lock_guard lock(mutex_);
        open_ = true;
    }
    return start_thread(thread_, "camera-capture", "that keeps the camera's frames", [this] {
        try {
            write();
        } catch (const std::exception& fault) {
            const std::lock_guard lock(mutex_);
            failure_ = internal_error(file_.string() + ": cannot be written: " + fault.what());
            is_broken_ = true;
            changed_.notify_all();
        }
    });
}

Result<void> CameraCapture::keep(const RawFrame& frame) {
    std::unique_lock lock(mutex_);
    const auto may_go_on = [this] {
        return !open_ || waiting_.size() < most_waiting || failure_.has_value();
    };
    if (!wait_unless_stopped(changed_, lock, may_go_on))
        return Error{ErrorKind::interrupted, "the camera's film was told to stop"};
    if (failure_) return {};
    waiting_.push_back(frame);
    frames_.push_back({frame.number, frame.time_ns});
    changed_.notify_all();
    return {};
}

void CameraCapture::write() {
    for (std::int64_t number = 0;; ++number) {
        RawFrame frame;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [this] { return ended_ || !waiting_.empty(); });
            if (waiting_.empty()) return;
            frame = std::move(waiting_.front());
            waiting_.pop_front();
            changed_.notify_all();
        }
        frame.number = number;
        frame.time_ns = described_.scene.rate.time_ns(number);
        auto written = writer_->write(frame);
        const std::lock_guard lock(mutex_);
        if (written) ++written_;
        if (written && !writer_->is_full()) continue;
        is_broken_ = !written;
        failure_ = is_broken_ ? written.error() : input_error(file_.string() + ": the disk is full");
        waiting_.clear();
        changed_.notify_all();
        return;
    }
}

std::optional<Error> CameraCapture::fault() const {
    const std::lock_guard lock(mutex_);
    return failure_;
}

void CameraCapture::give_up(const Error& why) {
    const std::lock_guard lock(mutex_);
    failure_ = why;
    waiting_.clear();
}

Result<void> CameraCapture::finish() {
    stop();
    if (failure_) frames_.resize(is_broken_ ? 0 : written_);
    if (failure_ && frames_.empty()) return {};
    return writer_ ? writer_->finish() : Result<void>();
}

std::filesystem::path film_beside(std::filesystem::path record, int part) {
    if (part > 1) record += '.' + std::to_string(part);
    record += ".mkv";
    return record;
}

std::unique_ptr<ClipReader> with_film(std::unique_ptr<ClipReader> camera,
                                      std::shared_ptr<CameraCapture> film) {
    return std::make_unique<KeptCamera>(std::move(camera), std::move(film));
}

Result<std::unique_ptr<ClipReader>> make_filmed_camera(std::unique_ptr<ClipReader> film,
                                                       CameraCapture::Frames frames,
                                                       const std::filesystem::path& file) {
    const auto count = film->frame_count();
    if (count && *count != std::ssize(frames))
        return input_error(file.string() + ": has " + std::to_string(*count) + " frames, the camera gave " +
                           std::to_string(frames.size()) + ": it is not the film of that recording");
    return std::unique_ptr<ClipReader>(std::make_unique<CapturedCamera>(std::move(film), std::move(frames)));
}

}  // namespace touchable
