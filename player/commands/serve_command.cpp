#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/stream/stream_audience.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/file_option.hpp"
#include "player/commands/number_option.hpp"
#include "player/commands/outputs.hpp"
#include "player/commands/serve_run.hpp"
#include "player/commands/whole_option.hpp"
#include "player/session/camera_words.hpp"

namespace touchable {
namespace {

struct ServeTyped {
    ClipTyped clip;
    std::vector<std::string> urls;
    std::optional<std::string> camera;
    std::optional<int> listeners;
    std::optional<double> seconds;
    std::optional<std::filesystem::path> hls;
    std::optional<double> hls_segment, hls_window;
    std::string hls_low;
    ServeOptions options;
};

Error no_clip() {
    return usage_error(
        "what is to be sent? right would be touchable serve CLIP URL, or touchable serve "
        "--camera WORDS URL");
}

/// With a camera the first word is a URL as well.
Result<std::vector<std::string>> read_words(const ServeTyped& typed, ServeOptions& options) {
    std::vector<std::string> urls = typed.urls;
    if (!typed.camera) {
        if (typed.clip.choice.file.empty()) return no_clip();
        return urls;
    }
    const std::string first = typed.clip.choice.file.string();
    if (!first.empty() && !is_stream_url(first))
        return usage_error("CLIP and --camera are two things to send; leave one of them out");
    if (!first.empty()) urls.insert(urls.begin(), first);
    TRY_ASSIGN(const auto camera, read_live_camera(*typed.camera));
    options.clip.take(camera);
    if (typed.options.loop) return usage_error("--loop is for clips; a camera does not end");
    return urls;
}

Result<void> check_url(const StreamUrl& url) {
    if (url.is_tls)
        return usage_error(in_quotes(url.name()) +
                           ": https is for a web server in front of this one; right would be http://");
    const auto is_plain = [](char letter) { return letter > ' ' && letter < 127 && letter != '%'; };
    if (!std::all_of(url.path.begin(), url.path.end(), is_plain))
        return usage_error(
            in_quotes(url.name()) +
            ": right would be a name of plain letters and digits behind the port, such as /clip.mkv");
    if (url.transport == StreamTransport::pipe || url.transport == StreamTransport::udp)
        return usage_error(in_quotes(url.name()) +
                           ": right would be tcp://, http:// or srt://, and an address to send at");
    return {};
}

/// A clip that comes to its end is there as a whole; what goes on is there for a while.
Result<void> read_hls(const ServeTyped& typed, ServeOptions& options) {
    if (!typed.hls) {
        if (typed.hls_segment || typed.hls_window || !typed.hls_low.empty())
            return usage_error("--hls-segment, --hls-window and --hls-low are for --hls DIR");
        return {};
    }
    HlsSettings& hls = options.hls.emplace();
    hls.folder = *typed.hls;
    if (typed.hls_segment) hls.segment_ns = std::llround(*typed.hls_segment * 1e9);
    hls.has_low = typed.hls_low == "on";
    constexpr double usual_window_s = 20;
    const bool goes_on = options.loop || options.clip.is_camera();
    const double window_s = typed.hls_window.value_or(goes_on ? usual_window_s : 0);
    hls.window_ns = std::llround(window_s * 1e9);
    return {};
}

Result<ServeOptions> read_options(const ServeTyped& typed) {
    ServeOptions options = typed.options;
    TRY_ASSIGN(const auto choice, read_clip(typed.clip));
    options.clip = choice;
    TRY_ASSIGN(const auto words, read_words(typed, options));
    if (words.empty() && !typed.hls)
        return usage_error(
            "where is it to be sent? right would be, for one, tcp://0.0.0.0:7000 behind CLIP, or --hls DIR");
    TRY(read_hls(typed, options));
    bool has_srt = false;
    for (const std::string& each : words) {
        TRY_ASSIGN(auto url, read_stream_url(each));
        TRY(check_url(url));
        has_srt = has_srt || url.transport == StreamTransport::srt;
        options.urls.push_back(std::move(url));
    }
    if (options.mpegts && !has_srt)
        return usage_error("--mpegts is for srt://; tcp:// and http:// carry Matroska");
    const bool waits_for_nobody = options.loop || options.clip.is_camera() || options.urls.empty();
    options.listeners = typed.listeners.value_or(waits_for_nobody ? 0 : 1);
    if (typed.seconds) options.longest_ns = std::llround(*typed.seconds * 1e9);
    return options;
}

}  // namespace

void add_serve_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("serve", "send a clip, or a camera, to whoever listens");
    auto typed = std::make_shared<ServeTyped>();
    add_clip_options(*sub, typed->clip);
    sub->add_option(
        "URL", typed->urls,
        "where it is sent: tcp://HOST:PORT, http://HOST:PORT/NAME or srt://HOST:PORT, at which several "
        "may listen (HOST is this machine's; port 0 of tcp and http: any that is free); srt:// with "
        "?mode=caller calls");
    sub->add_option("--camera", typed->camera,
                    "sent in place of CLIP: v4l2:/dev/videoN[,key=value,...], pipe:CMD, tcp://HOST:PORT or "
                    "replay:PATH[,key=value,...] (docs/camera.md)");
    add_camera_options(*sub, typed->clip.camera);
    sub->add_flag("--loop", typed->options.loop, "the clip from its beginning again and again");
    add_whole_option(*sub, "--listeners", typed->listeners,
                     "that are there before it begins, 0 to 64; otherwise 1, and with --loop or --camera 0",
                     0, StreamAudience::most_listeners);
    add_number_option(*sub, "--seconds", typed->seconds, "end after so many", 0.001, 1e8)->type_name("S");
    sub->add_flag("--mpegts", typed->options.mpegts,
                  "over srt:// as MPEG-TS, whose colour stock programs show, in place of Matroska");
    add_file_option(
        *sub, "--hls", typed->hls,
        "a folder, new or of a stream before, for any web server: segments and playlists (HLS), in "
        "which ordinary players find the colour; a whole clip as fast as it can be encoded")
        ->type_name("FOLDER");
    add_number_option(*sub, "--hls-segment", typed->hls_segment, "length of a segment, 0.5 to 10 (default 1)",
                      0.5, 10)
        ->type_name("S");
    add_number_option(
        *sub, "--hls-window", typed->hls_window,
        "live: so much of the stream is in the playlists, 3 to 86400 (default 20 with --loop or "
        "--camera; otherwise all of the clip)",
        3, 86400)
        ->type_name("S");
    sub->add_option(
           "--hls-low", typed->hls_low,
           "on or off (default): a second level of about half the bytes, which viewers read where the "
           "link is narrow: coarser colour, and every second frameset")
        ->check(CLI::IsMember({"on", "off"}));
    add_file_option(*sub, "--json", typed->options.json, "write the report there; - is standard output");
    add_overwrite_option(*sub, typed->options.existing);
    sub->callback([typed, &command] {
        command = [typed]() -> Result<void> {
            TRY_ASSIGN(const auto options, read_options(*typed));
            return run_serve(options);
        };
    });
}

}  // namespace touchable
