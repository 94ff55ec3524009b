// SPDX-License-Identifier: Apache-2.0
// Cameras of V4L2 as clips: depth, and the colour of a camera beside it.
#include "engine/camera/v4l2_camera.hpp"

#include <bit>
#include <cerrno>
#include <cstdlib>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {
namespace {

AVPixelFormat pixels_as_ffmpeg_has_them(std::uint32_t code) {
    constexpr std::pair<std::uint32_t, AVPixelFormat> formats[] = {{V4L2_PIX_FMT_RGB24, AV_PIX_FMT_RGB24},
                                                                   {V4L2_PIX_FMT_BGR24, AV_PIX_FMT_BGR24},
                                                                   {V4L2_PIX_FMT_YUYV, AV_PIX_FMT_YUYV422},
                                                                   {V4L2_PIX_FMT_UYVY, AV_PIX_FMT_UYVY422},
                                                                   {V4L2_PIX_FMT_NV12, AV_PIX_FMT_NV12}};
    for (const auto& [known, pixels] : formats)
        if (code == known) return pixels;
    return AV_PIX_FMT_NONE;
}

/// FFmpeg's frame around the bytes, which the picture still owns.
Result<FramePtr> frame_around(const TakenPicture& picture, const StreamFormat& format) {
    FramePtr frame = bare_picture(pixels_as_ffmpeg_has_them(format.code), format.width, format.height);
    if (!frame) return memory_error();
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

/// The mode whose number of pixels is nearest to depth's.
ModeWish wish_beside(const NodeFormat& format, const StreamFormat& depth,
                     const std::optional<FrameRate>& rate) {
    ModeWish wish;
    if (rate) wish.rate = rate->per_second();
    const std::int64_t wanted = std::int64_t{depth.width} * depth.height;
    const auto nearest = std::ranges::min_element(format.modes, {}, [wanted](const NodeMode& mode) {
        return std::abs(std::int64_t{mode.width} * mode.height - wanted);
    });
    if (nearest == format.modes.end()) return wish;
    wish.width = nearest->width;
    wish.height = nearest->height;
    return wish;
}

/// The colour camera beside a depth camera: its newest pictures, of which the one nearest in time is shown.
/// Used by one thread.
class ColourBeside {
public:
    /// Opens a stream of a size and a rate near the depth's. An error names the node.
    static Result<std::unique_ptr<ColourBeside>> open(const std::shared_ptr<VideoSystem>& system,
                                                      const std::string& node, const StreamFormat& depth,
                                                      const std::optional<FrameRate>& rate) {
        TRY_ASSIGN(const auto facts, look_at_node(*system, node));
        const auto format = std::ranges::find_if(facts.formats, is_colour_format, &NodeFormat::code);
        if (format == facts.formats.end())
            return input_error(node + ": gives no colour that can be shown (" + formats_text(facts) +
                               "); colour= takes a node of RGB3, BGR3, YUYV, UYVY, NV12 or MJPG");
        TRY_ASSIGN(auto stream, V4l2Stream::open(system, facts, *format, wish_beside(*format, depth, rate)));
        return std::unique_ptr<ColourBeside>(new ColourBeside(std::move(stream), node));
    }
    const TrackInfo& track() const { return track_; }
    int descriptor() const { return stream_->descriptor(); }
    /// Takes the newest picture, if any. An error, once, when no more will come: what happened.
    Result<void> look() {
        TRY_ASSIGN(auto taken, stream_->take(V4l2Stream::Which::newest));
        if (!taken) return {};
        // A few: depth may come later than the colour of its moment.
        constexpr std::size_t most = 4;
        if (recent_.size() == most) recent_.erase(recent_.begin());
        recent_.push_back(std::move(*taken));
        return {};
    }
    /// The picture nearest in time, of the scene's size; nullopt before the first that can be read.
    std::optional<Plane> nearest(std::int64_t at_ns, const Scene& scene) {
        if (recent_.empty()) return plane_;
        const auto nearest = std::ranges::min_element(
            recent_, {}, [at_ns](const TakenPicture& picture) { return std::abs(picture.at_ns - at_ns); });
        if (plane_ && plane_at_ns_ == nearest->at_ns) return plane_;
        auto rgb = rgb_of(*nearest, stream_->format(), converter_);
        if (rgb) rgb = fit_plane(PlaneRole::colour, std::move(*rgb), scene, node_);
        plane_at_ns_ = nearest->at_ns;
        if (rgb) plane_ = std::move(*rgb);  // otherwise keep the one before
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
    RgbConverter converter_;
    std::optional<Plane> plane_;  // of the one that was shown last
    std::int64_t plane_at_ns_ = 0;
};

/// Brings samples of depth into host order.
void put_in_host_order(const TakenPicture& picture, const StreamFormat& format) {
    const bool is_big = format.code == V4L2_PIX_FMT_Y16_BE;
    if (is_big == (std::endian::native == std::endian::big)) return;
    std::vector<std::uint8_t>& bytes = *picture.bytes;
    for (std::size_t k = 0; k + 1 < format.least; k += 2) std::swap(bytes[k], bytes[k + 1]);
}

// Timeout for a frame before a run.
constexpr std::chrono::seconds patience(5);

class V4l2Camera final : public LiveReader {
public:
    explicit V4l2Camera(const V4l2Choice& choice)
        : LiveReader(choice.node), choice_(choice), system_(choice.system ? choice.system : system_video()) {}
    Result<void> open(const SourceDescription& known,
                      const std::optional<std::filesystem::path>& scene_file) {
        TRY(open_depth(scene_file));
        TRY(look_first(known, scene_file));
        return open_colour();
    }

    void leave_out_colour() override {
        colour_.reset();
        last_colour_.reset();
    }

private:
    Result<void> open_depth(const std::optional<std::filesystem::path>& scene_file) {
        TRY_ASSIGN(facts_, look_at_node(*system_, choice_.node));
        TRY_ASSIGN(const auto format, depth_of_node(facts_));
        ModeWish wish{choice_.width, choice_.height, choice_.rate};
        if (scene_file && wish.width == 0) {
            TRY_ASSIGN(const auto described, read_scene_file(*scene_file));
            wish.width = described.scene.width;
            wish.height = described.scene.height;
        }
        return assign(depth_, V4l2Stream::open(system_, facts_, *format, wish));
    }

    /// Finds the stream's form and meaning by its first frames.
    Result<void> look_first(const SourceDescription& known,
                            const std::optional<std::filesystem::path>& scene_file) {
        constexpr int looked_at = 8;
        std::vector<RawFrame> frames;
        for (int k = 0; k < looked_at; ++k) {
            TRY_ASSIGN(auto first, first_frame());
            frames.push_back(std::move(first.frame));
        }
        const StreamFormat& format = depth_->format();
        TRY_ASSIGN(auto meaning, meaning_of_depth(facts_, format.code, frames, known, scene_file));
        meaning.scene.rate = depth_->rate().value_or(FrameRate{30, 1});
        take_meaning(std::move(meaning));
        const bool sized = choice_.width > 0 || scene_file;
        notes_.push_back(printable(facts_.card) + ": " + format_text(format.code) + ", " +
                         size_text(format.width, format.height) + " at " +
                         (depth_->rate() ? rate_text(*depth_->rate()) : std::string("an unknown number of")) +
                         " frames/s" + (sized ? "" : " (size=WxH and fps=N choose another)"));
        if (choice_.rate && depth_->rate() &&
            std::abs(depth_->rate()->per_second() / *choice_.rate - 1) > 0.01)
            notes_.push_back("the camera gives " + rate_text(*depth_->rate()) +
                             " frames/s of that size; fps= asked for another rate");
        if (!is_timed_by_driver_)
            notes_.emplace_back(
                "the camera's driver does not say when frames are taken: they count from their arrival");
        tracks_.push_back({"depth", "v4l2", format_text(format.code), format.width, format.height, true});
        return {};
    }

    Result<void> open_colour() {
        if (choice_.colour.empty()) return {};
        TRY_ASSIGN(colour_, ColourBeside::open(system_, choice_.colour, depth_->format(), depth_->rate()));
        const auto until = std::chrono::steady_clock::now() + patience;
        while (colour_ && !colour_->nearest(0, scene_) && std::chrono::steady_clock::now() < until)
            TRY(first_frame());
        if (!colour_ || !colour_->nearest(0, scene_))
            return input_error(choice_.colour + ": gave no picture of colour in " +
                               std::to_string(patience.count()) + " s; leave colour= out");
        const TrackInfo& track = colour_->track();
        tracks_.push_back(track);
        notes_.push_back("colour is " + choice_.colour + " (" + track.pixel_format + ", " +
                         size_text(track.width, track.height) +
                         "), as that camera sees it: it is not moved to where depth is seen from");
        return {};
    }

    MaybeTaken poll() override {
        using Which = V4l2Stream::Which;
        TRY(look_at_colour());
        auto picture = depth_->take(has_begun() ? Which::newest : Which::oldest);
        damaged_ = depth_->damaged();
        if (!picture) return gone(picture.error().message);
        if (!*picture) return std::optional<Taken>();
        const auto& [bytes, sequence, at_ns, timed_by_driver] = **picture;
        is_timed_by_driver_ = timed_by_driver;
        const StreamFormat& format = depth_->format();
        put_in_host_order(**picture, format);
        const PlaneView depth{bytes->data(), format.stride, format.width, format.height, 2, 1};
        Taken taken{sequence, at_ns};
        add_plane(taken.frame, PlaneRole::depth, {depth, bytes});
        if (colour_)
            if (auto colour = colour_->nearest(at_ns, scene_)) last_colour_ = std::move(colour);
        if (last_colour_) add_plane(taken.frame, PlaneRole::colour, *last_colour_);
        return std::optional(std::move(taken));
    }

    void wait() override {
        std::array<pollfd, 2> waits{pollfd{depth_->descriptor(), POLLIN, 0}, {-1, POLLIN, 0}};
        if (colour_) waits[1].fd = colour_->descriptor();
        const int ready = system_->poll(waits, static_cast<int>(stop_look.count()));
        // A driver that reports a fault gives the cause when the next picture is taken; if it never does, it
        // is given up.
        const auto is_wrong = [](const pollfd& waited) {
            return (waited.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 && (waited.revents & POLLIN) == 0;
        };
        const bool wrong = ready < 0 ? errno != EINTR : is_wrong(waits[0]) || is_wrong(waits[1]);
        wrong_in_a_row_ = wrong ? wrong_in_a_row_ + 1 : 0;
        if (wrong_in_a_row_ < most_faults_in_a_row) return;
        if (ready >= 0 && !is_wrong(waits[0])) {
            remark("the camera of colour, " + choice_.colour + ", stopped");
            colour_.reset();
            wrong_in_a_row_ = 0;
            return;
        }
        (void)gone("stopped: its driver says that something is wrong, and not what");
    }

    std::optional<Error> nothing_came(Moment since) const override {
        if (std::chrono::steady_clock::now() <= since + patience) return std::nullopt;
        return input_error(choice_.node + ": gave no frame in " + std::to_string(patience.count()) + " s" +
                           (damaged_ > 0 ? " that was whole, " + std::to_string(damaged_) +
                                               " damaged ones: is its cable or port too slow?"
                                         : ": is it in use, or does it wait for something?"));
    }

    Result<void> look_at_colour() {
        if (!colour_) return {};
        const auto looked = colour_->look();
        if (looked) return {};
        if (!has_begun()) return input_error(choice_.colour + ": " + looked.error().message);
        remark("the camera of colour, " + choice_.colour + ", " + looked.error().message);
        colour_.reset();
        return {};
    }

    const V4l2Choice choice_;
    std::shared_ptr<VideoSystem> system_;
    NodeFacts facts_;
    std::unique_ptr<V4l2Stream> depth_;
    std::unique_ptr<ColourBeside> colour_;  // null: none, or it has stopped
    std::optional<Plane> last_colour_;      // kept if that camera stops: a film has it in every frame
    bool is_timed_by_driver_ = false;       // of the last picture
    int wrong_in_a_row_ = 0;                // failed polls
};

}  // namespace

Result<Plane> rgb_of(const TakenPicture& picture, const StreamFormat& format, RgbConverter& converter) {
    const bool coded = format.code == V4L2_PIX_FMT_MJPEG || format.code == V4L2_PIX_FMT_JPEG;
    TRY_ASSIGN(const auto frame, coded ? decoded(picture) : frame_around(picture, format));
    TRY_ASSIGN(auto made, converter.converted(*frame));
    const AVFrame& rgb = *made;
    const PlaneView view{rgb.data[0], rgb.linesize[0], rgb.width, rgb.height, 1, 3};
    return Plane{view, std::shared_ptr<const AVFrame>(std::move(made))};
}

Result<std::unique_ptr<ClipReader>> open_v4l2_camera(const V4l2Choice& choice, const SourceDescription& known,
                                                     const std::optional<std::filesystem::path>& scene_file) {
    return opened_as<ClipReader>(std::make_unique<V4l2Camera>(choice), known, scene_file);
}

}  // namespace touchable
