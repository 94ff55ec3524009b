#include "bench/media/force_loss.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "bench/clocks.hpp"
#include "bench/media/av_codec.hpp"
#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"

namespace touchable {
namespace {

constexpr int frames_sent = 15;

class ClipInMemory final : public ClipReader {
public:
    ClipInMemory(const Scene& scene, const std::vector<RawFrame>& frames) : scene_(scene), frames_(frames) {}
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return std::ssize(frames_); }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override {
        if (at_ == frames_.size()) return std::optional<RawFrame>();
        return std::optional(frames_[at_++]);
    }
    Result<void> rewind() override {
        at_ = 0;
        return {};
    }

private:
    Scene scene_;
    const std::vector<RawFrame>& frames_;
    std::size_t at_ = 0;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
};

Result<FeltClip> felt(Scene scene, std::vector<RawFrame> frames) {
    FeltClip clip{std::move(scene), std::move(frames), {}};
    auto stroke = standard_stroke(std::make_unique<ClipInMemory>(clip.scene, clip.frames));
    if (!stroke) return stroke.error();
    clip.stroke = std::move(*stroke);
    return clip;
}

/// A plane with its own memory.
struct Kept {
    PlaneView view;
    std::vector<std::uint8_t> samples;
};

Kept kept(const PlaneView& plane) {
    Kept copy{plane, {}};
    const auto row_bytes = static_cast<std::size_t>(plane.width) * static_cast<std::size_t>(plane.channels);
    for (int y = 0; y < plane.height; ++y)
        copy.samples.insert(copy.samples.end(), plane.row(y), plane.row(y) + row_bytes);
    copy.view.data = copy.samples.data();
    copy.view.stride = static_cast<std::ptrdiff_t>(row_bytes);
    return copy;
}

/// An owner of both.
std::shared_ptr<const void> joined(std::shared_ptr<const void> first, std::shared_ptr<const void> second) {
    return std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(
        std::move(first), std::move(second));
}

/// Rounds each haptic value to the nearest of eight: flat materials, as painted by users.
void flatten(RawFrame& frame) {
    constexpr int step = 36;
    auto copy = std::make_shared<Kept>(kept(frame.haptic));
    for (std::uint8_t& value : copy->samples)
        value = static_cast<std::uint8_t>(std::min(255, (value + step / 2) / step * step));
    frame.haptic = copy->view;
    frame.storage = joined(frame.storage, std::move(copy));
}

Result<FeltClip> felt_globe(bool is_flat) {
    const auto made = make_scene("globe", {.width = 720, .height = 480, .bits = 8, .properties = true});
    if (!made) return made.error();
    std::vector<RawFrame> frames;
    for (int n = 0; n < frames_sent; ++n) {
        frames.push_back((*made)->frame(n));
        if (is_flat) flatten(frames.back());
    }
    return felt((*made)->scene(), std::move(frames));
}

/// Converts depth to 8 bits; 0: no depth.
RawFrame in_8_bits(const RawFrame& frame, const DepthCoding& from, const DepthCoding& to) {
    auto samples = std::make_shared<std::vector<std::uint8_t>>();
    for (int y = 0; y < frame.depth.height; ++y)
        for (int x = 0; x < frame.depth.width; ++x) {
            const auto code = static_cast<std::uint16_t>(frame.depth.sample(x, y));
            const bool is_there =
                from.is_valid(code) && from.depth(code) >= to.near && from.depth(code) <= to.far;
            samples->push_back(is_there ? static_cast<std::uint8_t>(to.code(from.depth(code))) : 0);
        }
    RawFrame made;
    made.number = frame.number;
    made.time_ns = frame.time_ns;
    made.depth = {samples->data(), frame.depth.width, frame.depth.width, frame.depth.height, 1, 1};
    made.storage = std::move(samples);
    return made;
}

Result<FeltClip> felt_castel(const std::filesystem::path& folder) {
    auto reader =
        open_clip(folder, std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes/castel_sr300.json");
    if (!reader) return reader.error();
    (*reader)->leave_out_colour();
    Scene scene = (*reader)->scene();
    const DepthCoding stored = scene.depth;
    DepthCoding& depth = scene.depth;
    depth.kind = DepthCodingKind::linear;
    depth.near_is_high = true;
    depth.near = std::max(stored.near, stored.nearest_depth());
    depth.far = std::min(stored.far, 1.2 / scene.metres_per_unit);  // beyond is only the room
    depth.near = std::max(depth.near, 0.3 / scene.metres_per_unit);
    depth.code_max = 255;
    depth.invalid_codes[0] = 0;
    depth.invalid_code_count = 1;
    derive_valid_range(depth);
    scene.depth_bits = 8;
    scene.folder.reset();
    if (auto valid = validate(scene); !valid) return valid.error();
    std::vector<RawFrame> frames;
    while (std::ssize(frames) < frames_sent) {
        const auto frame = (*reader)->next();
        if (!frame) return frame.error();
        if (!*frame) break;
        frames.push_back(in_8_bits(**frame, stored, depth));
    }
    return felt(std::move(scene), std::move(frames));
}

CodecChoice sent_by_h264(std::string name, const char* encoder, AVPixelFormat format, int quantiser,
                         bool lossless) {
    constexpr int slices = 4, frames_to_access = 15;
    const AvSettings settings{
        encoder,
        {format},
        slices,
        frames_to_access,
        {{"preset", "superfast"}, {"qp", std::to_string(quantiser)}, {"tune", "zerolatency"}}};
    return {std::move(name), lossless,
            [settings](const PlaneView& first) { return open_av_codec(settings, first); }};
}

CodecChoice kept_by_ffmpeg(std::string name, AvSettings settings) {
    return {std::move(name), true, [settings = std::move(settings)](const PlaneView& first) {
                return open_av_codec(settings, first);
            }};
}

int largest_change(const PlaneView& a, const PlaneView& b) {
    int largest = 0;
    for (int y = 0; y < a.height; ++y)
        for (int k = 0; k < a.width * a.channels; ++k)
            largest = std::max(largest, std::abs(a.row(y)[k] - b.row(y)[k]));
    return largest;
}

/// A clip with one plane encoded and decoded, and the costs.
struct SentPlane {
    std::vector<RawFrame> frames;  ///< the clip with the decoded plane
    double bytes = 0, encode_ms = 0, decode_ms = 0;
    int largest_change = 0;
};

Result<SentPlane> send(const FeltClip& clip, PlaneRole role, const CodecChoice& choice) {
    const auto count = static_cast<double>(clip.frames.size());
    auto codec = choice.open(plane_of(clip.frames.front(), role));
    if (!codec) return codec.error();
    SentPlane sent;
    std::vector<Packet> packets(clip.frames.size());
    std::int64_t begin = thread_cpu_ns();
    for (std::size_t n = 0; n < packets.size(); ++n)
        if (auto done = (*codec)->encode(plane_of(clip.frames[n], role), packets[n]); !done)
            return done.error();
    sent.encode_ms = static_cast<double>(thread_cpu_ns() - begin) * 1e-6 / count;
    for (std::size_t n = 0; n < packets.size(); ++n) {
        sent.bytes += static_cast<double>(packets[n].size()) / count;
        begin = thread_cpu_ns();
        if (auto done = (*codec)->decode(packets[n]); !done) return done.error();
        const auto plane = (*codec)->plane();
        if (!plane) return plane.error();
        sent.decode_ms += static_cast<double>(thread_cpu_ns() - begin) * 1e-6 / count;
        auto copy = std::make_shared<Kept>(kept(*plane));
        RawFrame frame = clip.frames[n];
        sent.largest_change =
            std::max(sent.largest_change, largest_change(plane_of(frame, role), copy->view));
        plane_of(frame, role) = copy->view;
        frame.storage = joined(frame.storage, std::move(copy));
        sent.frames.push_back(std::move(frame));
    }
    return sent;
}

}  // namespace

std::vector<FeltSource> felt_sources() {
    std::vector<FeltSource> sources{
        {"globe-720x480-8",
         {PlaneRole::depth, PlaneRole::haptic, PlaneRole::height},
         [] { return felt_globe(false); }},
        {"materials-720x480-8", {PlaneRole::haptic}, [] { return felt_globe(true); }}};
    const std::filesystem::path castel = std::filesystem::path(TOUCHABLE_TEST_DATA) / "castel_sr300";
    if (std::filesystem::exists(castel))
        sources.push_back({"castel-640x480-8", {PlaneRole::depth}, [=] { return felt_castel(castel); }});
    return sources;
}

std::vector<CodecChoice> sent_choices(PlaneRole role, bool has_few_colours) {
    const bool is_rgb = role == PlaneRole::haptic;
    const char* const encoder = is_rgb ? "libx264rgb" : "libx264";
    const AVPixelFormat own = is_rgb ? AV_PIX_FMT_BGR0 : AV_PIX_FMT_GRAY8;
    std::vector<CodecChoice> choices;
    choices.push_back(kept_by_ffmpeg("png", {"png", {is_rgb ? AV_PIX_FMT_RGB24 : AV_PIX_FMT_GRAY8}}));
    if (has_few_colours) choices.push_back(kept_by_ffmpeg("png-indexed", {"png", {AV_PIX_FMT_PAL8}}));
    choices.push_back(
        kept_by_ffmpeg("ffv1", {"ffv1", {own}, 4, 1, {{"slicecrc", "1"}, {"coder", "1"}, {"context", "1"}}}));
    for (const int quantiser : {0, 1, 2, 4, 8, 12, 16, 20, 24})
        choices.push_back(
            sent_by_h264("h264-qp" + std::to_string(quantiser), encoder, own, quantiser, quantiser == 0));
    if (is_rgb)
        for (const int quantiser : {0, 12, 24})
            choices.push_back(sent_by_h264("h264-420-qp" + std::to_string(quantiser), "libx264",
                                           AV_PIX_FMT_YUV420P, quantiser, false));
    return choices;
}

Result<void> measure_force_loss(const FeltClip& clip, PlaneRole role, const CodecChoice& choice,
                                Figures& figures) {
    const auto sent = send(clip, role, choice);
    if (!sent) return sent.error();
    if (choice.lossless && sent->largest_change > 0)
        return Error{ErrorKind::check, "what comes back is not what was sent"};
    const auto felt =
        compare_by_stroke(clip.stroke, std::make_unique<ClipInMemory>(clip.scene, sent->frames));
    if (!felt) return felt.error();
    figures.push_back({"bytes", sent->bytes, ""});
    figures.push_back({"encode_ms", sent->encode_ms, "ms"});
    figures.push_back({"decode_ms", sent->decode_ms, "ms"});
    figures.push_back({"largest_change", static_cast<double>(sent->largest_change), ""});
    figures.push_back({"direction_mean_deg", felt->direction_degrees.mean, "deg"});
    figures.push_back({"direction_p95_deg", felt->direction_degrees.p95, "deg"});
    figures.push_back({"force_mean_n", felt->difference_n.mean, "N"});
    figures.push_back({"force_max_n", felt->difference_n.max, "N"});
    figures.push_back({"contact_ticks", static_cast<double>(felt->only_a + felt->only_b), ""});
    return {};
}

}  // namespace touchable
