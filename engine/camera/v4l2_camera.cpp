// Cameras of V4L2 as clips: depth, and the colour of a camera beside it.
#include "engine/camera/v4l2_camera.hpp"

#include <bit>
#include <cerrno>
#include <cstdlib>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/camera/camera_reader.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {
namespace {

AVPixelFormat pixels_as_ffmpeg_has_them(std::uint32_t code) {
    switch (code) {
        case V4L2_PIX_FMT_RGB24:
            return AV_PIX_FMT_RGB24;
        case V4L2_PIX_FMT_BGR24:
            return AV_PIX_FMT_BGR24;
        case V4L2_PIX_FMT_YUYV:
            return AV_PIX_FMT_YUYV422;
        case V4L2_PIX_FMT_UYVY:
            return AV_PIX_FMT_UYVY422;
        case V4L2_PIX_FMT_NV12:
            return AV_PIX_FMT_NV12;
        default:
            return AV_PIX_FMT_NONE;
    }
}

/// Around the bytes, which stay the picture's.
Result<FramePtr> frame_around(const TakenPicture& picture, const StreamFormat& format) {
    FramePtr frame(av_frame_alloc());
    if (!frame) return Error{ErrorKind::internal, "out of memory"};
    frame->format = pixels_as_ffmpeg_has_them(format.code);
    frame->width = format.width;
    frame->height = format.height;
    frame->data[0] = picture.bytes->data();
    frame->linesize[0] = static_cast<int>(format.stride);
    if (format.code == V4L2_PIX_FMT_NV12) {
        frame->data[1] = frame->data[0] + format.stride * format.height;
        frame->linesize[1] = frame->linesize[0];
    }
    return frame;
}

Result<FramePtr> decoded(const TakenPicture& picture) {
    const auto* const bytes = reinterpret_cast<const char*>(picture.bytes->data());
    return decode_picture({bytes, picture.bytes->size()}, "its picture");
}

/// As many pixels as the depth has, as nearly as the format offers them.
ModeWish wish_beside(const NodeFormat& format, const StreamFormat& depth,
                     const std::optional<FrameRate>& rate) {
    ModeWish wish;
    if (rate) wish.rate = per_second(*rate);
    const std::int64_t wanted = std::int64_t{depth.width} * depth.height;
    const auto nearest = std::ranges::min_element(format.modes, {}, [wanted](const NodeMode& mode) {
        return std::abs(std::int64_t{mode.width} * mode.height - wanted);
    });
    if (nearest == format.modes.end()) return wish;
    wish.width = nearest->width;
    wish.height = nearest->height;
    return wish;
}

/// The colour camera beside one of depth: its newest pictures, of which the one nearest in time is shown.
/// One thread.
class ColourBeside {
public:
    /// A stream of a size near the depth's, at a rate near it. An error names the node.
    static Result<std::unique_ptr<ColourBeside>> open(const std::shared_ptr<VideoSystem>& system,
                                                      const std::string& node, const StreamFormat& depth,
                                                      const std::optional<FrameRate>& rate) {
        TRY_ASSIGN(const auto facts, look_at_node(*system, node));
        const auto format = std::ranges::find_if(facts.formats, is_colour_format, &NodeFormat::code);
        if (format == facts.formats.end()) {
            std::string there;
            for (const NodeFormat& each : facts.formats)
                there += (there.empty() ? "" : ", ") + format_text(each.code);
            return input_error(node + ": gives no colour that can be shown (" +
                               (there.empty() ? "nothing" : there) +
                               "); colour= takes a node of RGB3, BGR3, YUYV, UYVY, NV12 or MJPG");
        }
        TRY_ASSIGN(auto stream, V4l2Stream::open(system, facts, *format, wish_beside(*format, depth, rate)));
        return std::unique_ptr<ColourBeside>(new ColourBeside(std::move(stream), node));
    }
    const TrackInfo& track() const { return track_; }
    int descriptor() const { return stream_->descriptor(); }
    /// Takes what is there. An error, once, when no more will come: what happened.
    Result<void> look() {
        TRY_ASSIGN(auto taken, stream_->take(V4l2Stream::Which::newest));
        if (!taken) return {};
        // A few: depth may come later than the colour of its moment.
        constexpr std::size_t most = 4;
        if (recent_.size() == most) recent_.erase(recent_.begin());
        recent_.push_back(std::move(*taken));
        return {};
    }
    /// Of the scene's size; nothing before the first picture that can be read.
    std::optional<Plane> nearest(std::int64_t at_ns, const Scene& scene) {
        if (recent_.empty()) return plane_;
        const auto nearest = std::ranges::min_element(
            recent_, {}, [at_ns](const TakenPicture& picture) { return std::abs(picture.at_ns - at_ns); });
        if (plane_ && plane_at_ns_ == nearest->at_ns) return plane_;
        auto rgb = converter_.rgb(*nearest, stream_->format());
        if (rgb) rgb = fit_plane(PlaneRole::colour, std::move(*rgb), scene, node_);
        plane_at_ns_ = nearest->at_ns;
        if (rgb) plane_ = std::move(*rgb);  // otherwise the one before
        return plane_;
    }

private:
    ColourBeside(std::unique_ptr<V4l2Stream> stream, std::string node)
        : stream_(std::move(stream)), node_(std::move(node)) {
        const StreamFormat& format = stream_->format();
        track_ = {"colour", "v4l2", format_text(format.code), format.width, format.height};
    }

    std::unique_ptr<V4l2Stream> stream_;
    std::string node_;
    TrackInfo track_;
    std::vector<TakenPicture> recent_;  // the newest last
    ColourConverter converter_;
    std::optional<Plane> plane_;  // of the one that was shown last
    std::int64_t plane_at_ns_ = 0;
};

using std::chrono::steady_clock;

// Frames that are looked at to find out what depth means.
constexpr int first_frames = 8;
// A camera that gives nothing for so long before a run does not work.
constexpr std::chrono::seconds patience(5);
constexpr int most_wrong = 100;  // polls in a row

class V4l2Camera final : public CameraReader {
public:
    explicit V4l2Camera(const V4l2Choice& choice)
        : CameraReader(choice.node),
          choice_(choice),
          system_(choice.system ? choice.system : system_video()) {}
    Result<void> open(const SourceDescription& known, const std::optional<std::filesystem::path>& scene_file);

    Result<std::optional<RawFrame>> next() override;
    void leave_out_colour() override {
        colour_.reset();
        last_colour_.reset();
    }
    Result<void> begin(steady_clock::time_point zero) override;
    std::vector<std::string> remarks() const override;

private:
    Result<void> open_depth(const std::optional<std::filesystem::path>& scene_file);
    Result<void> look_first(const SourceDescription& known,
                            const std::optional<std::filesystem::path>& scene_file);
    Result<void> open_colour();
    Result<TakenPicture> first_picture();
    Result<std::optional<TakenPicture>> wait_for_picture();
    void wait(std::chrono::milliseconds longest);
    Result<void> look_at_colour();
    std::optional<RawFrame> frame_of(TakenPicture picture);
    PlaneView depth_of(const TakenPicture& picture) const;

    const V4l2Choice choice_;
    std::shared_ptr<VideoSystem> system_;
    NodeFacts facts_;
    std::unique_ptr<V4l2Stream> depth_;
    std::unique_ptr<ColourBeside> colour_;  // null: none, or it has stopped
    std::optional<Plane> last_colour_;      // stays where that camera stops: a film has it in every frame
    int wrong_in_a_row_ = 0;
    std::atomic<std::int64_t> damaged_{0};
};

Result<void> V4l2Camera::open_depth(const std::optional<std::filesystem::path>& scene_file) {
    TRY_ASSIGN(facts_, look_at_node(*system_, choice_.node));
    TRY_ASSIGN(const auto format, depth_of_node(facts_));
    ModeWish wish{choice_.width, choice_.height, choice_.rate};
    if (scene_file && wish.width == 0) {
        TRY_ASSIGN(const auto described, read_scene_file(*scene_file));
        wish.width = described.scene.width;
        wish.height = described.scene.height;
    }
    TRY_ASSIGN(depth_, V4l2Stream::open(system_, facts_, *format, wish));
    return {};
}

/// What the stream is, and what it means.
Result<void> V4l2Camera::look_first(const SourceDescription& known,
                                    const std::optional<std::filesystem::path>& scene_file) {
    std::vector<TakenPicture> pictures;
    std::vector<PlaneView> views;
    for (int k = 0; k < first_frames; ++k) {
        TRY_ASSIGN(auto picture, first_picture());
        views.push_back(depth_of(picture));
        pictures.push_back(std::move(picture));
    }
    const StreamFormat& format = depth_->format();
    TRY_ASSIGN(auto meaning, scene_file ? meaning_in_file(facts_, views, *scene_file)
                                        : meaning_of_depth(facts_, format.code, views, known));
    take_meaning(std::move(meaning), depth_->rate().value_or(FrameRate{30, 1}));
    const bool sized = choice_.width > 0 || scene_file;
    notes_.push_back(printable(facts_.card) + ": " + format_text(format.code) + ", " +
                     std::to_string(format.width) + "x" + std::to_string(format.height) + " at " +
                     (depth_->rate() ? rate_text(*depth_->rate()) : std::string("an unknown number of")) +
                     " frames/s" + (sized ? "" : " (size=WxH and fps=N choose another)"));
    if (choice_.rate && depth_->rate() && std::abs(per_second(*depth_->rate()) / *choice_.rate - 1) > 0.01)
        notes_.push_back("the camera gives " + rate_text(*depth_->rate()) +
                         " frames/s of that size; fps= asked for another rate");
    if (!pictures.back().timed_by_driver)
        notes_.emplace_back(
            "the camera's driver does not say when frames are taken: they count from their arrival");
    tracks_.push_back({"depth", "v4l2", format_text(format.code), format.width, format.height, true});
    return {};
}

Result<void> V4l2Camera::open_colour() {
    if (choice_.colour.empty()) return {};
    TRY_ASSIGN(colour_, ColourBeside::open(system_, choice_.colour, depth_->format(), depth_->rate()));
    const auto until = steady_clock::now() + patience;
    while (colour_ && !colour_->nearest(0, scene_) && steady_clock::now() < until) TRY(first_picture());
    if (!colour_ || !colour_->nearest(0, scene_))
        return input_error(choice_.colour + ": gave no picture of colour in " +
                           std::to_string(patience.count()) + " s; leave colour= out");
    const TrackInfo& track = colour_->track();
    tracks_.push_back(track);
    notes_.push_back("colour is " + choice_.colour + " (" + track.pixel_format + ", " +
                     std::to_string(track.width) + "x" + std::to_string(track.height) +
                     "), as that camera sees it: it is not moved to where depth is seen from");
    return {};
}

Result<void> V4l2Camera::open(const SourceDescription& known,
                              const std::optional<std::filesystem::path>& scene_file) {
    if (run_.descriptor() < 0) return Error{ErrorKind::internal, "no event can be made to wait for"};
    TRY(open_depth(scene_file));
    TRY(look_first(known, scene_file));
    return open_colour();
}

/// One that has to come, before a run.
Result<TakenPicture> V4l2Camera::first_picture() {
    TRY_ASSIGN(auto picture, wait_for_picture());
    if (!picture) return input_error(remarks().back());
    return std::move(*picture);
}

/// The oldest before the run, the newest in it; nothing once the camera is gone.
Result<std::optional<TakenPicture>> V4l2Camera::wait_for_picture() {
    const auto until = steady_clock::now() + patience;
    while (!run_.is_gone()) {
        if (auto end = run_.told_to_end()) return *end;
        TRY(look_at_colour());
        auto taken = depth_->take(run_.has_begun() ? V4l2Stream::Which::newest : V4l2Stream::Which::oldest);
        damaged_ = depth_->damaged();
        if (!taken) {
            run_.gone(taken.error().message);
            break;
        }
        if (*taken) return taken;
        if (!run_.has_begun() && steady_clock::now() > until)
            return input_error(choice_.node + ": gave no frame in " + std::to_string(patience.count()) +
                               " s" +
                               (damaged_ > 0 ? " that was whole, " + std::to_string(damaged_) +
                                                   " damaged ones: is its cable or port too slow?"
                                             : ": is it in use, or does it wait for something?"));
        // A run is interrupted by the thread that ends it; before that only a signal does so.
        constexpr std::chrono::milliseconds look_again(100), ever(-1);
        wait(run_.has_begun() ? ever : look_again);
    }
    return std::optional<TakenPicture>();
}

void V4l2Camera::wait(std::chrono::milliseconds longest) {
    std::array<pollfd, 3> waits{
        pollfd{run_.descriptor(), POLLIN, 0}, {depth_->descriptor(), POLLIN, 0}, {-1, POLLIN, 0}};
    if (colour_) waits[2].fd = colour_->descriptor();
    const int ready = system_->poll(waits, static_cast<int>(longest.count()));
    // A driver that says that something is wrong says what when it is asked for a picture; it is not asked
    // for ever.
    const auto is_wrong = [](const pollfd& waited) {
        return (waited.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 && (waited.revents & POLLIN) == 0;
    };
    const bool wrong = ready < 0 ? errno != EINTR : is_wrong(waits[1]) || is_wrong(waits[2]);
    wrong_in_a_row_ = wrong ? wrong_in_a_row_ + 1 : 0;
    if (wrong_in_a_row_ < most_wrong) return;
    if (ready >= 0 && !is_wrong(waits[1])) {
        run_.remark("the camera of colour, " + choice_.colour + ", stopped");
        colour_.reset();
        wrong_in_a_row_ = 0;
        return;
    }
    run_.gone("stopped: its driver says that something is wrong, and not what");
}

Result<void> V4l2Camera::look_at_colour() {
    if (!colour_) return {};
    const auto looked = colour_->look();
    if (looked) return {};
    if (!run_.has_begun()) return input_error(choice_.colour + ": " + looked.error().message);
    run_.remark("the camera of colour, " + choice_.colour + ", " + looked.error().message);
    colour_.reset();
    return {};
}

PlaneView V4l2Camera::depth_of(const TakenPicture& picture) const {
    const StreamFormat& format = depth_->format();
    const bool big = format.code == V4L2_PIX_FMT_Y16_BE;
    if (big != (std::endian::native == std::endian::big)) {
        std::vector<std::uint8_t>& bytes = *picture.bytes;
        for (std::size_t k = 0; k + 1 < format.least; k += 2) std::swap(bytes[k], bytes[k + 1]);
    }
    return {picture.bytes->data(), format.stride, format.width, format.height, 2, 1};
}

/// Nothing: it was taken before the run.
std::optional<RawFrame> V4l2Camera::frame_of(TakenPicture picture) {
    const auto place = run_.place(picture.sequence, picture.at_ns);
    if (!place) return std::nullopt;
    RawFrame frame;
    frame.number = place->number;
    frame.time_ns = place->time_ns;
    add_plane(frame, PlaneRole::depth, {depth_of(picture), picture.bytes, 16});
    if (colour_)
        if (auto colour = colour_->nearest(picture.at_ns, scene_)) last_colour_ = std::move(colour);
    if (last_colour_) add_plane(frame, PlaneRole::colour, *last_colour_);
    return frame;
}

Result<std::optional<RawFrame>> V4l2Camera::next() {
    while (true) {
        TRY_ASSIGN(auto picture, wait_for_picture());
        if (!picture && !run_.has_begun()) return input_error(remarks().back());
        if (!picture) return std::optional<RawFrame>();
        if (auto frame = frame_of(std::move(*picture))) return frame;
    }
}

Result<void> V4l2Camera::begin(steady_clock::time_point zero) {
    run_.begin(zero);
    // Those that wait are of before. What is wrong with the camera it will say again.
    (void)depth_->take(V4l2Stream::Which::newest);
    return {};
}

std::vector<std::string> V4l2Camera::remarks() const {
    std::vector<std::string> all = run_.remarks();
    if (const std::int64_t damaged = damaged_; damaged > 0)
        all.insert(all.begin(), std::to_string(damaged) +
                                    " of the camera's frames were damaged or cut short, "
                                    "and left out");
    return all;
}

}  // namespace

Result<Plane> ColourConverter::rgb(const TakenPicture& picture, const StreamFormat& format) {
    const bool coded = format.code == V4L2_PIX_FMT_MJPEG || format.code == V4L2_PIX_FMT_JPEG;
    TRY_ASSIGN(const auto frame, coded ? decoded(picture) : frame_around(picture, format));
    TRY_ASSIGN(auto made, converter_.converted(*frame));
    const AVFrame& rgb = *made;
    const PlaneView view{rgb.data[0], rgb.linesize[0], rgb.width, rgb.height, 1, 3};
    return Plane{view, std::shared_ptr<const AVFrame>(std::move(made))};
}

Result<std::unique_ptr<ClipReader>> open_v4l2_camera(const V4l2Choice& choice,
                                                     const std::optional<SourceDescription>& known,
                                                     const std::optional<std::filesystem::path>& scene_file) {
    auto camera = std::make_unique<V4l2Camera>(choice);
    TRY(camera->open(known.value_or(SourceDescription()), scene_file));
    return std::unique_ptr<ClipReader>(std::move(camera));
}

}  // namespace touchable
