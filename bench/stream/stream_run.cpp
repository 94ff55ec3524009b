// SPDX-License-Identifier: Apache-2.0
#include "bench/stream/stream_run.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/clocks.hpp"
#include "bench/stream/felt_stream.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/stream/served_clip.hpp"
#include "tests/unused_port.hpp"

namespace touchable {
namespace {

double share_pct(double part, double whole) {
    return whole > 0 ? 100 * part / whole : 0;
}

std::string scheme_of(const StreamCase& stream) {
    return stream.transport == "ts" ? "srt" : stream.transport;
}

std::string address(const StreamCase& stream, int port) {
    return scheme_of(stream) + "://127.0.0.1:" + std::to_string(port) +
           (stream.transport == "http" ? "/clip.mkv" : "");
}

Result<std::unique_ptr<test::ServedClip>> serve(const StreamCase& stream, int port, LiveClips& clips) {
    const auto file = clips.file(stream.clip);
    if (!file) return file.error();
    const auto report = clips.place("served.json");
    if (!report) return report.error();
    std::vector<std::string> options{address(stream, port), "--loop"};
    if (stream.transport == "ts") options.emplace_back("--mpegts");
    return test::ServedClip::start(*file, std::move(options), *report);
}

/// Sets up touching a live source for `ticks`.
Result<std::unique_ptr<TouchSetup>> touch_live(const std::string& camera, std::int64_t ticks) {
    SessionOptions options;
    options.live = true;
    options.fingers = 5;
    options.ticks = ticks;
    options.camera = camera;
    const auto source = read_live_camera(camera);
    if (!source) return source.error();
    options.clip.choose(*source);
    return setup_from_options(options);
}

void add_network_figures(const StreamFigures& came, Figures& figures) {
    const auto sent = static_cast<double>(came.whole + came.late + came.lost + came.torn);
    const auto add = [&](const char* name, double value, const char* unit) {
        figures.push_back({name, value, unit});
    };
    add("framesets", sent, "");
    add("whole", static_cast<double>(came.whole), "");
    add("lost", static_cast<double>(came.lost), "");
    add("torn", static_cast<double>(came.torn), "");
    add("late_pct", share_pct(static_cast<double>(came.late), sent), "%");
    add("connections", static_cast<double>(came.connections), "");
    add("jitter_buffer_ms", came.delay_ms, "ms");
}

/// Measures the run, with any transport.
Result<void> measure_touch(TouchSetup& setup, Figures& figures) {
    TouchFigures touched;
    FeltStream felt;
    const std::vector<TouchSink*> sinks{&touched, &felt};
    const auto hand = make_port(*setup.hand);
    TouchSessionSettings settings = setup.options;
    settings.ticks = setup.ticks();
    LiveSession session(*setup.feed, *hand, *setup.solver, settings);
    const std::int64_t cpu = process_cpu_ns();
    if (auto ran = session.run(sinks); !ran) return ran;
    const auto cpu_ns = static_cast<double>(process_cpu_ns() - cpu);
    const LiveFacts& facts = session.facts();
    if (facts.failure) return *facts.failure;
    if (facts.interrupted) return Error{ErrorKind::interrupted, "interrupted"};
    if (!facts.camera) return Error{ErrorKind::check, "what was touched was no live source"};
    const auto shown = static_cast<double>(facts.camera->frames_shown);
    const auto due = static_cast<double>(facts.loop.ticks + facts.loop.skipped);
    const auto add = [&](const char* name, double value, const char* unit) {
        figures.push_back({name, value, unit});
    };
    add("felt", shown, "");
    add("longest_hold_ms", felt.longest_hold_ms(), "ms");
    add("sent_to_force_ms_p50", facts.camera->exposure_to_force_ms.p50, "ms");
    add("sent_to_force_ms_p99", facts.camera->exposure_to_force_ms.p99, "ms");
    add("force_step_n", felt.largest_step_before(), "N");
    add("force_step_guarded_n", felt.largest_step_after(), "N");
    add("late_ticks_pct", share_pct(static_cast<double>(facts.loop.late), due), "%");
    add("tick_late_us_p99", touched.late_us().p99, "us");
    add("receiver_cpu_ms", cpu_ns * 1e-6 / std::max(1.0, shown), "ms");
    return {};
}

std::int64_t ticks_of(const LiveClip& clip) {
    return std::int64_t{1000} * clip.frames / 30;
}

}  // namespace

Result<void> measure_without_network(const LiveClip& clip, LiveClips& clips, Figures& figures) {
    const auto file = clips.file(clip);
    if (!file) return file.error();
    const auto setup = touch_live("replay:" + file->string(), ticks_of(clip));
    return setup ? measure_touch(**setup, figures) : setup.error();
}

Result<void> measure_stream(const StreamCase& stream, LiveClips& clips, Figures& figures) {
    const int port = test::unused_port();
    if (port == 0) return Error{ErrorKind::check, "no port of this machine is free"};
    const bool has_datagrams = scheme_of(stream) == "srt";
    const auto relay = test::Relay::open(has_datagrams ? test::Relay::Kind::udp : test::Relay::Kind::tcp,
                                         port, stream.faults);
    if (!relay) return relay.error();
    auto served = serve(stream, port, clips);
    if (!served) return served.error();
    const auto setup = touch_live("stream:" + address(stream, (*relay)->port()), ticks_of(stream.clip));
    if (!setup) return setup.error();
    if (auto touched = measure_touch(**setup, figures); !touched) return touched;
    const auto came = (*setup)->feed->reader().stream_figures();
    const auto report = (*served)->end();
    if (!report) return report.error();
    if (!came || came->whole == 0) return Error{ErrorKind::check, "no whole frameset came"};
    add_network_figures(*came, figures);
    figures.push_back({"sender_cpu_ms", report->at("cpu_ms_per_frameset").get<double>(), "ms"});
    figures.push_back({"kb_per_frameset", report->at("bytes_per_frameset").get<double>() * 1e-3, "KB"});
    return {};
}

namespace {

/// Receives and discards everything.
class Drains {
public:
    explicit Drains(int count, int port) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        for (int k = 0; k < count; ++k) {
            const int one = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
            if (::connect(one, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
                all_.push_back({one, POLLIN, 0});
            else
                ::close(one);
        }
    }
    ~Drains() {
        for (const pollfd& one : all_) ::close(one.fd);
    }
    Drains(const Drains&) = delete;
    Drains& operator=(const Drains&) = delete;
    int count() const { return static_cast<int>(all_.size()); }

    double drain_for(std::int64_t ns) {
        std::vector<char> bytes(std::size_t{1} << 18U);
        double taken = 0;
        for (const std::int64_t until = monotonic_ns() + ns; monotonic_ns() < until;) {
            ::poll(all_.data(), all_.size(), 10);
            for (const pollfd& one : all_)
                if ((one.revents & POLLIN) != 0)
                    taken += static_cast<double>(
                        std::max<ssize_t>(0, ::recv(one.fd, bytes.data(), bytes.size(), MSG_DONTWAIT)));
        }
        return taken;
    }

private:
    std::vector<pollfd> all_;
};

}  // namespace

Result<void> measure_listeners(int listeners, const LiveClip& clip, LiveClips& clips, Figures& figures) {
    const int port = test::unused_port();
    if (port == 0) return Error{ErrorKind::check, "no port of this machine is free"};
    auto served = serve({"tcp", clip}, port, clips);
    if (!served) return served.error();
    Drains drains(listeners, port);
    if (drains.count() != listeners) return Error{ErrorKind::check, "not all listeners were let in"};
    const std::int64_t second = 1'000'000'000, length = second * clip.frames / 30;
    drains.drain_for(second);
    const std::int64_t cpu = (*served)->cpu_ns();
    const double taken = drains.drain_for(length);
    const auto cpu_ms = static_cast<double>((*served)->cpu_ns() - cpu) * 1e-6;
    const auto report = (*served)->end();
    if (!report) return report.error();
    std::int64_t dropped = 0;
    for (const auto& one : report->at("listeners")) dropped += one.at("dropped").get<std::int64_t>();
    figures.push_back({"sender_cpu_ms", cpu_ms / clip.frames, "ms"});
    figures.push_back({"dropped", static_cast<double>(dropped), ""});
    figures.push_back({"mb_per_s", taken * 1e-6 / (static_cast<double>(length) * 1e-9), "MB/s"});
    return {};
}

}  // namespace touchable
