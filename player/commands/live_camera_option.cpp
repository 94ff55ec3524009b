#include "player/commands/live_camera_option.hpp"

#include <cmath>
#include <variant>

#include "engine/base/try.hpp"
#include "engine/stream/http_source.hpp"
#include "engine/stream/live_stream.hpp"
#include "player/commands/number_option.hpp"
#include "player/commands/whole_option.hpp"
#include "player/session/camera_words.hpp"

namespace touchable {

CLI::Option* add_live_camera_option(CLI::App& sub, SessionOptions& session) {
    return sub.add_option(
        "--camera", session.camera,
        "live, in place of CLIP: v4l2:/dev/videoN[,key=value,...], a camera that is plugged in; pipe:CMD or "
        "tcp://HOST:PORT, a program that sends framesets; stream:ADDRESS, as CLIP may be; or "
        "replay:PATH[,key=value,...], a recording that "
        "behaves like one (docs/camera.md)");
}

CLI::Option* add_stale_after_option(CLI::App& sub, std::optional<double>& milliseconds) {
    return add_number_option(
        sub, "--stale-after", milliseconds,
        "ms: a live surface that no newer frame has renewed for so long is not felt any more, "
        "until one comes; 0: it stays as it is (otherwise 250 of a stream, 0 of a camera)",
        0, 3'600'000);
}

CLI::Option* add_latency_option(CLI::App& sub, SessionOptions& session) {
    return add_whole_option(sub, "--latency", session.stream_latency_ms,
                            "live, of a stream: the longest that framesets wait until nearly all come in "
                            "time, ms; they wait no longer than its jitter",
                            1, 5000)
        ->type_name("MS")
        ->capture_default_str();
}

namespace {

Result<void> take_stream(SessionOptions& session) {
    const std::string words = session.clip.file.string();
    if (session.camera || !session.live || !is_stream_url(words)) return {};
    TRY_ASSIGN(auto url, read_stream_url(words));
    StreamChoice choice{.url = url};
    if (url.transport == StreamTransport::http && !url.is_playlist()) {
        TRY_ASSIGN(auto found, open_http(url));
        if (found.file) return {};
        choice.connection = std::move(found.stream);
    }
    session.camera = "stream:" + url.name();
    session.clip.take({std::move(choice), {}, {}});
    return {};
}

}  // namespace

Result<void> read_live_stream(bool has_latency, SessionOptions& session) {
    if (auto taken = take_stream(session); !taken.ok()) return taken;
    auto& plugged = session.clip.plugged;
    auto* const stream = plugged ? std::get_if<StreamChoice>(&*plugged) : nullptr;
    if (stream) stream->latency = std::chrono::milliseconds(session.stream_latency_ms);
    if (stream || !has_latency) return {};
    return usage_error(
        "--latency is for a stream that is touched live, such as touchable touch --live tcp://HOST:PORT");
}

Result<void> read_live_camera(bool has_clip, const std::optional<double>& stale_after_ms,
                              SessionOptions& session) {
    if (stale_after_ms) session.stale_after_ns = std::llround(*stale_after_ms * 1e6);
    if (!session.camera) return {};
    if (has_clip) return usage_error("CLIP and --camera are two things to touch; leave one of them out");
    TRY_ASSIGN(const auto camera, read_live_camera(*session.camera));
    session.clip.take(camera);
    return {};
}

}  // namespace touchable
