#include "engine/camera/frameset_camera.hpp"

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/camera/depth_meaning.hpp"
#include "engine/camera/frameset_format.hpp"
#include "engine/camera/live_bytes.hpp"
#include "engine/clip/camera_run.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/clip/sender_clock.hpp"

namespace touchable {
namespace {

struct TakenFrameset {
    Frameset frameset;
    std::int64_t at_ns = 0;  ///< of std::chrono::steady_clock
};

std::int64_t ns_now() {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// By the middle one of the sender's times from frame to frame; 30 where they cannot be.
FrameRate rate_of(const std::vector<TakenFrameset>& taken) {
    std::vector<double> apart_ns;
    for (std::size_t k = 1; k < taken.size(); ++k)
        apart_ns.push_back(static_cast<double>(taken[k].frameset.header.time_ns) -
                           static_cast<double>(taken[k - 1].frameset.header.time_ns));
    std::sort(apart_ns.begin(), apart_ns.end());
    const double rate = 1e9 / apart_ns[apart_ns.size() / 2];
    if (!(rate >= 0.1 && rate <= 1000)) return {30, 1};
    return {std::llround(1000 * rate), 1000};
}

class FramesetCamera final : public ClipReader {
public:
    explicit FramesetCamera(FramesetChoice choice)
        : choice_(std::move(choice)), name_(printable(choice_.name())), run_(name_) {}
    Result<void> open(const SourceDescription& known, const std::optional<std::filesystem::path>& scene_file);

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return unstated_filters_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return std::nullopt; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override { return run_.seek(frame); }
    void leave_out_colour() override { shows_colour_ = false; }
    bool is_live() const override { return true; }
    Result<void> begin(std::chrono::steady_clock::time_point zero) override;
    void interrupt() override { run_.interrupt(); }
    std::vector<std::string> remarks() const override;

private:
    enum class Which { oldest, newest };
    Result<void> look_first(SourceDescription known, const std::optional<std::filesystem::path>& scene_file);
    Result<std::optional<TakenFrameset>> take(Which which);
    Result<std::optional<TakenFrameset>> wait_for_frameset();
    void wait(std::chrono::milliseconds longest) const;
    std::optional<RawFrame> frame_of(const TakenFrameset& taken);

    const FramesetChoice choice_;
    const std::string name_;
    CameraRun run_;
    std::unique_ptr<LiveBytes> source_;
    FramesetParser parser_;
    SenderClock clock_;
    std::vector<std::uint8_t> chunk_ = std::vector<std::uint8_t>(std::size_t{1} << 18U);
    bool has_said_anything_ = false, shows_colour_ = true;
    Scene scene_;
    UnstatedFilters unstated_filters_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    std::atomic<std::int64_t> damaged_{0}, repeated_{0};
};

/// What is there; nothing where no whole one is. An error once no more will come: what happened.
Result<std::optional<TakenFrameset>> FramesetCamera::take(Which which) {
    constexpr std::size_t most_at_once = std::size_t{16} << 20U;  // then somebody may have told it to end
    std::optional<TakenFrameset> best;
    for (std::size_t read = 0; read < most_at_once;) {
        auto whole = parser_.next();
        damaged_ = parser_.damaged();
        repeated_ = parser_.repeated();
        if (!whole && best) break;  // it will say so again
        if (!whole) return whole.error();
        if (*whole) {
            const std::int64_t sent_ns = (*whole)->header.time_ns;
            best = TakenFrameset{std::move(**whole), clock_.taken_at(sent_ns, ns_now())};
            if (which == Which::oldest) break;
            continue;
        }
        const auto got = source_->read(chunk_);
        if (!got && best) break;
        if (!got) return input_error(source_->how_it_ended());
        if (*got == 0) break;
        has_said_anything_ = true;
        read += *got;
        parser_.take(std::span(chunk_).first(*got));
    }
    return best;
}

/// The oldest before the run, the newest in it; nothing once it has ended.
Result<std::optional<TakenFrameset>> FramesetCamera::wait_for_frameset() {
    const auto begun = std::chrono::steady_clock::now();
    std::optional<std::chrono::steady_clock::time_point> heard;
    while (!run_.is_gone()) {
        if (auto end = run_.told_to_end()) return *end;
        auto taken = take(run_.has_begun() ? Which::newest : Which::oldest);
        if (!taken) {
            run_.gone(taken.error().message);
            break;
        }
        if (*taken) return taken;
        const auto now = std::chrono::steady_clock::now();
        if (has_said_anything_ && !heard) heard = now;
        const auto until = heard ? *heard + choice_.patience : begun + choice_.first_patience;
        if (!run_.has_begun() && now > until)
            return input_error(name_ + (heard ? ": sent no whole frameset in " : ": sent nothing in ") +
                               std::to_string((heard ? choice_.patience : choice_.first_patience).count()) +
                               " ms" + (damaged_ > 0 ? ", but damaged ones" : ""));
        constexpr std::chrono::milliseconds look_again(100), ever(-1);
        wait(run_.has_begun() ? ever : look_again);
    }
    return std::optional<TakenFrameset>();
}

void FramesetCamera::wait(std::chrono::milliseconds longest) const {
    const auto sources = source_->waits();
    std::array<pollfd, 3> all{pollfd{run_.descriptor(), POLLIN, 0}, sources[0], sources[1]};
    (void)::poll(all.data(), all.size(), static_cast<int>(longest.count()));
}

/// What it sends, and what that means.
Result<void> FramesetCamera::look_first(SourceDescription known,
                                        const std::optional<std::filesystem::path>& scene_file) {
    constexpr int first_framesets = 8;
    std::vector<TakenFrameset> taken;
    std::vector<PlaneView> views;
    for (int k = 0; k < first_framesets; ++k) {
        TRY_ASSIGN(auto frameset, wait_for_frameset());
        if (!frameset) return input_error(run_.remarks().back());
        views.push_back(frameset->frameset.depth());
        taken.push_back(std::move(*frameset));
    }
    const FramesetHeader& sent = taken.front().frameset.header;
    if (!known.intrinsics && !known.fov && known.preset.empty())
        known.intrinsics = Intrinsics{sent.fx, sent.fy, sent.cx, sent.cy, sent.width, sent.height};
    if (!known.metres_per_code && known.preset.empty()) known.metres_per_code = sent.metres_per_unit;
    NodeFacts facts;
    facts.node = name_;
    facts.card = "a sender of framesets";
    TRY_ASSIGN(auto meaning, scene_file ? meaning_in_file(facts, views, *scene_file)
                                        : meaning_of_depth(facts, V4L2_PIX_FMT_Z16, views, known));
    scene_ = std::move(meaning.scene);
    unstated_filters_ = meaning.unstated_filters;
    scene_.interpolation = FrameInterpolation::hold;
    scene_.rate = rate_of(taken);
    for (const auto& input : meaning.inputs) add_input(input);
    notes_.push_back(name_ + " sends depth of " +
                     formatted("%dx%d, %.6g m a code, fx %.6g, fy %.6g, at %.4g frames/s", sent.width,
                               sent.height, sent.metres_per_unit, sent.fx, sent.fy, per_second(scene_.rate)));
    if (sent.time_ns == 0)
        notes_.emplace_back("the sender does not say when frames are taken: they count from their arrival");
    tracks_.push_back({"depth", "frameset", "gray16le", sent.width, sent.height, true});
    if (!sent.has_colour()) return {};
    tracks_.push_back({"colour", "frameset", "rgb24", sent.colour_width, sent.colour_height, true});
    if (!sent.colour_is_registered)
        notes_.emplace_back(
            "its colour is as another camera sees it: it is not moved to where depth is seen from");
    return {};
}

Result<void> FramesetCamera::open(const SourceDescription& known,
                                  const std::optional<std::filesystem::path>& scene_file) {
    if (run_.descriptor() < 0) return Error{ErrorKind::internal, "no event can be made to wait for"};
    TRY_ASSIGN(auto source,
               choice_.command.empty() ? connect_to(choice_.address) : start_command(choice_.command));
    source_ = std::move(source);
    return look_first(known, scene_file);
}

/// Nothing: it was taken before the run.
std::optional<RawFrame> FramesetCamera::frame_of(const TakenFrameset& taken) {
    const Frameset& frameset = taken.frameset;
    const auto place = run_.place(static_cast<std::uint32_t>(frameset.header.number), taken.at_ns);
    if (!place) return std::nullopt;
    RawFrame frame;
    frame.number = place->number;
    frame.time_ns = place->time_ns;
    add_plane(frame, PlaneRole::depth, {frameset.depth(), frameset.payload, 16});
    if (!shows_colour_ || !frameset.header.has_colour()) return frame;
    auto colour = fit_plane(PlaneRole::colour, {frameset.colour(), frameset.payload, 8}, scene_, name_);
    if (colour) add_plane(frame, PlaneRole::colour, std::move(*colour));
    return frame;
}

Result<std::optional<RawFrame>> FramesetCamera::next() {
    while (true) {
        TRY_ASSIGN(const auto taken, wait_for_frameset());
        if (!taken && !run_.has_begun()) return input_error(run_.remarks().back());
        if (!taken) return std::optional<RawFrame>();
        if (auto frame = frame_of(*taken)) return frame;
    }
}

Result<void> FramesetCamera::begin(std::chrono::steady_clock::time_point zero) {
    run_.begin(zero);
    // Those that wait are of before. How it ended it will say again.
    if (!run_.is_gone()) (void)take(Which::newest);
    return {};
}

std::vector<std::string> FramesetCamera::remarks() const {
    std::vector<std::string> all = run_.remarks();
    const auto tell = [&all](std::int64_t count, const char* what) {
        if (count > 0) all.insert(all.begin(), std::to_string(count) + " of the camera's frames " + what);
    };
    tell(repeated_, "came twice, and were left out once");
    tell(damaged_, "were damaged or cut short, and left out");
    return all;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_frameset_camera(
    const FramesetChoice& choice, const std::optional<SourceDescription>& known,
    const std::optional<std::filesystem::path>& scene_file) {
    auto camera = std::make_unique<FramesetCamera>(choice);
    TRY(camera->open(known.value_or(SourceDescription()), scene_file));
    return std::unique_ptr<ClipReader>(std::move(camera));
}

}  // namespace touchable
