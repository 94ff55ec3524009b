// SPDX-License-Identifier: Apache-2.0
#include <poll.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/picture/sound.hpp"
#include "engine/stream/sending.hpp"
#include "engine/stream/stream_url.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/reports.hpp"
#include "player/run/run_files.hpp"
#include "player/run/terminal.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {
namespace {

/// The clip to send and its destinations.
struct ServeOptions {
    ClipChoice clip;        ///< its filters are ignored unless `filtered`
    bool filtered = false;  ///< depth is sent as filters leave it
    std::vector<StreamUrl> urls;
    bool loop = false;
    int listeners = 0;  ///< listeners to wait for before sending begins
    std::optional<std::int64_t> longest_ns;
    bool mpegts = false;  ///< over SRT: MPEG-TS, readable by stock tools
    bool page = false;    ///< to browsers: the page, and the clip's packed form
    std::optional<HlsWriter::Settings> hls;
    JsonOutput json;
};

constexpr std::chrono::milliseconds serve_look_again{5};

/// The name, beside the page, of a live source's frames.
constexpr const char* page_stream = "live";

/// Skips the line if stderr is blocked, so that listeners need not wait.
void say_served(const std::string& line) {
    constexpr std::size_t longest = 500;
    pollfd errors{STDERR_FILENO, POLLOUT, 0};
    if (poll(&errors, 1, 0) != 1) return;
    std::cerr << printable(line, longest) + '\n';
}

/// The address for a listener to use: HOST in place of "all addresses of this machine".
std::string to_be_played(std::string address) {
    for (const std::string_view any : {"//0.0.0.0:", "//[::]:", "//:"})
        if (const auto at = address.find(any); at != std::string::npos)
            return address.replace(at, any.size(), "//HOST:");
    return address;
}

/// Whether a numeric address is reachable from this machine only.
bool is_own_machine(const std::string& address) {
    for (const std::string_view own : {"//127.", "//localhost:", "//[::1]:", "//[::ffff:127."})
        if (address.find(own) != std::string::npos) return true;
    return false;
}

/// Warns, after the "listening on" line, if any machine may connect.
void say_who_may_listen(const std::string& address) {
    if (is_own_machine(address)) return;
    say_served(address +
               " is open to ANY machine that reaches it: each program that connects gets all that "
               "is sent (127.0.0.1 keeps it on this machine)");
}

/// A stream of one form.
struct ServedForm {
    StreamRing ring;
    std::unique_ptr<StreamMuxer> muxer;  // until passed to the sender
};

std::filesystem::path page_folder() {
    return folder_from_program(TOUCHABLE_WEB_FROM_PROGRAM);
}

/// The frames of a live source as the page reads them (docs/web.md): for each the sizes of four packets, its
/// time, and the packets.
class PageStream final : public StreamMuxer {
public:
    /// `begun` is called when the first frame has told what clip.json says, which is in `folder` by then.
    PageStream(SceneDescription described, std::filesystem::path folder, std::function<void()> begun)
        : described_(std::move(described)), folder_(std::move(folder)), begun_(std::move(begun)) {}

    std::span<const std::uint8_t> header() const override { return {}; }
    Result<Block> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                      bool is_key) override {
        if (begun_) TRY(begin(frame));
        if (is_key) packer_.forget();
        TRY_ASSIGN(const auto packets, packer_.pack(frame));
        Block block{label.frame, true, {}};
        std::string head, body;
        for (const PlaneRole role :
             {PlaneRole::depth, PlaneRole::haptic, PlaneRole::height, PlaneRole::colour}) {
            const std::string& packet = packets[static_cast<std::size_t>(role)];
            append(head, static_cast<std::uint32_t>(packet.size()));
            body += packet;
            // A listener can begin with any frame of which no plane is left out.
            block.is_key = block.is_key && (plane_of(frame, role).empty() || !packet.empty());
        }
        append(head, static_cast<double>(time_ns));
        head += body;
        block.bytes.assign(head.begin(), head.end());
        return block;
    }

private:
    Result<void> begin(const RawFrame& first) {
        NewFile file(folder_ / packed_clip_name);
        TRY(file.write(packed_live_json(described_, first, page_stream)));
        TRY(file.commit());
        std::exchange(begun_, nullptr)();
        return {};
    }
    static void append(std::string& bytes, auto number) {
        bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    }

    const SceneDescription described_;
    const std::filesystem::path folder_;
    std::function<void()> begun_;  // until it is called
    FramePacker packer_{1};        // quickly
};

class Serving : NonCopyable {
public:
    explicit Serving(const ServeOptions& options) : options_(options) {}
    ~Serving() {
        if (sender_) sender_->end();
        if (thread_.joinable()) thread_.join();
    }

    /// Sends until the clip's end, the time limit or a stop request, which is no error; then reports what was
    /// sent to which listeners.
    Result<void> run() {
        TRY(open_clip());
        TRY(open_forms());
        TRY(open_places());
        if (page_ && !is_live_) return serve_packed();
        const auto sent = send();
        if (!sent && !stop_requested()) return sent;
        for (const auto& output : outputs_) output->end();
        server_.reset();
        if (!sender_) return sent;
        outputs_.clear();
        TRY(report());
        if (auto lost = lost_camera()) return std::move(*lost);
        const bool has_no_end = !options_.longest_ns && (options_.loop || is_live_);
        return has_no_end ? Result<void>{} : sent;
    }

private:
    Result<void> open_clip() {
        if (options_.page || options_.filtered) {  // the page measures nothing: its filters are chosen here
            const auto open_it = options_.filtered ? open_filtered : open_chosen;
            TRY_ASSIGN(auto opened, open_it(options_.clip, Colour::wanted));
            clip_ = std::move(opened.reader);
            described_ = std::move(opened.scene);
            described_.error_bars_to = error_bars_to(opened.chosen, described_.scene.filter);
        } else {
            TRY_ASSIGN(clip_, options_.clip.open());
            described_ = clip_->described();
        }
        is_live_ = clip_->is_live();
        notes_ = remarks_with_options(remarks_of(*clip_));
        if (!options_.json.file) return {};
        TRY(options_.json.check(inputs_of(options_.clip, *clip_)));
        return assign(json_, OutputFile::create("--json", *options_.json.file, options_.json.existing));
    }

    Result<void> open_forms() {
        if (options_.page) return open_page();
        bool has_matroska = false, has_mpegts = false;
        for (const StreamUrl& url : options_.urls) {
            const bool is_mpegts = options_.mpegts && url.transport == StreamTransport::srt;
            (is_mpegts ? has_mpegts : has_matroska) = true;
        }
        if (has_mpegts) TRY(assign(mpegts_.emplace().muxer, make_mpegts_muxer(described_)));
        const auto heard = sound();
        if (options_.hls) TRY(assign(hls_, HlsWriter::open(*options_.hls, described_, heard)));
        return has_matroska ? assign(matroska_.emplace().muxer, open_matroska_stream(described_, heard))
                            : Result<void>();
    }

    /// A page gets a clip's packed form, or the frames of a live source as they come.
    Result<void> open_page() {
        TRY_ASSIGN(packed_, ScratchFolder::create("page"));
        auto& [ring, muxer] = page_.emplace();
        if (is_live_) {
            muxer = std::make_unique<PageStream>(described_, packed_->path(), [this] { say_where(); });
        } else {  // no frames are sent
            ring.begin({});
            ring.end();
        }
        return {};
    }

    /// Packs the clip, then serves it until a stop is requested, or the time limit.
    Result<void> serve_packed() {
        TRY_ASSIGN(const auto writer, create_packed_clip(packed_->path(), described_, {}, Existing::keep));
        std::optional<Progress> progress(std::in_place, "packing frame", clip_->frame_count().value_or(0));
        for (std::int64_t done = 0;; progress->at(++done)) {
            if (stop_requested()) return interrupted_error();
            TRY_ASSIGN(const auto frame, clip_->next());
            if (!frame) break;
            TRY(writer->write(*frame));
        }
        progress.reset();
        TRY(writer->complete());
        TRY(writer->finish());
        TRY(server_->start());
        say_where();
        const std::chrono::nanoseconds longest(options_.longest_ns.value_or(0));
        (void)wait_unless_stopped(options_.longest_ns ? std::chrono::steady_clock::now() + longest
                                                      : StopScope::never);
        return {};
    }

    Result<void> open_places() {
        std::vector<StreamUrl> listened;
        for (const StreamUrl& url : options_.urls) {
            if (url.transport != StreamTransport::srt) {
                listened.push_back(url);
                continue;
            }
            TRY_ASSIGN(auto output,
                       SrtOutput::create(url, (options_.mpegts ? mpegts_ : matroska_)->ring, audience_));
            outputs_.push_back(std::move(output));
        }
        if (!listened.empty()) {
            StreamServer::Page page;
            if (page_) {
                page = {packed_->path(), page_folder()};
                listened.front().path += page_stream;
            }
            TRY_ASSIGN(server_, StreamServer::open(listened, (page_ ? page_ : matroska_)->ring, audience_, {},
                                                   std::move(page)));
            if (!page_ || is_live_) TRY(server_->start());
        }
        if (!page_) say_where();  // else once there is something to see
        for (const auto& output : outputs_) TRY(output->start());
        return {};
    }

    /// The sound to send along, in Matroska.
    std::optional<SoundPart> sound() {
        const std::filesystem::path file = is_live_ ? std::filesystem::path() : sound_file_of(*clip_);
        const auto found = sound_of(file);
        if (!found) return std::nullopt;
        if (!found->storable || mpegts_)
            notes_.push_back("its sound (" + found->codec + ") " +
                             (found->storable ? "goes along in Matroska, not in MPEG-TS"
                                              : "does not go along: Matroska cannot hold it"));
        if (!found->storable) return std::nullopt;
        const std::int64_t frames = clip_->frame_count().value_or(std::int64_t{1} << 32);
        return SoundPart{file, 0, clip_->scene().rate.time_ns(frames)};
    }

    void say_where() const {
        if (hls_) {
            const auto master = options_.hls->folder / hls_master_name;
            say_served("writing segments for web servers: touchable play " + shell_word(master.string()));
        }
        if (server_)
            for (std::string address : server_->addresses()) {
                if (page_) address.erase(address.rfind('/') + 1);
                say_served("listening on " + address +
                           (page_ ? ": open in a browser " : ": touchable play ") + to_be_played(address));
                say_who_may_listen(address);
            }
        for (const auto& output : outputs_) {
            const std::string& address = output->address();
            say_served(output->calls() ? "sending to " + address
                                       : "listening on " + address + ": touchable play " +
                                             to_be_played(address.substr(0, address.find('?'))));
            if (!output->calls() && !output->is_encrypted()) say_who_may_listen(address);
        }
    }

    Result<void> send() {
        const auto are_there = [this] { return audience_.there() >= options_.listeners; };
        if (!wait_unless_stopped(are_there, serve_look_again)) return interrupted_error();
        std::vector<StreamSender::Channel> channels;
        for (auto* const form : {&matroska_, &mpegts_, &page_})
            if (*form) channels.push_back({std::move((*form)->muxer), (*form)->ring});
        if (hls_) channels.push_back({hls_, nobody_});
        const bool is_paced = !hls_ || options_.hls->window_ns > 0 || !options_.urls.empty();
        const StreamSender::Settings settings{options_.loop, options_.longest_ns, is_paced};
        sender_ = std::make_unique<StreamSender>(std::move(clip_), std::move(channels), settings, time_);
        begin_ns_ = time_.now_ns();
        cpu_ns_ = clock_ns(CLOCK_PROCESS_CPUTIME_ID);
        Result<void> sent;
        std::atomic<bool> is_over{false};
        const auto work = [this, &sent, &is_over] {
            sent = sender_->run();
            is_over = true;
        };
        TRY(start_thread(thread_, "stream-sender", "that reads and encodes", work));
        if (!wait_unless_stopped([&] { return is_over.load(); }, serve_look_again)) sender_->end();
        thread_.join();
        for (const std::string& remark : sender_->remarks()) notes_.push_back(remark);
        if (hls_ && sender_->figures().framesets > 0 && (sent || stop_requested()))
            if (auto finished = hls_->finish(); !finished && sent) sent = finished;
        if (!stop_requested() && sent) wait_for_the_last();
        cpu_ns_ = clock_ns(CLOCK_PROCESS_CPUTIME_ID) - cpu_ns_;
        end_ns_ = time_.now_ns();
        return stop_requested() ? interrupted_error() : std::move(sent);
    }

    /// A real camera's stream never ends by itself, unlike a recording played as a camera.
    std::optional<Error> lost_camera() const {
        if (!options_.clip.plugged || !sender_->figures().clip_ended || stop_requested()) return std::nullopt;
        const auto remarks = sender_->remarks();
        return device_error(remarks.empty() ? "the camera gives no more frames" : remarks.back());
    }

    /// Lets listeners receive the rest, for at most the time that a listener, or SRT with the longest
    /// latency, may take.
    void wait_for_the_last() const {
        const std::chrono::seconds longest{outputs_.empty() ? 10 : 130};
        const StopScope in_time(std::chrono::steady_clock::now() + longest);
        (void)wait_unless_stopped([this] { return is_all_given(); }, serve_look_again);
    }

    bool is_all_given() const {
        return std::ranges::all_of(outputs_, &SrtOutput::is_over) &&
               (!server_ || server_->connections() == 0);
    }

    /// Traffic per viewer; a live viewer fetches both playlists once per segment.
    nlohmann::ordered_json hls_as_json() const {
        const HlsWriter::Figures& all = hls_->figures();
        const double seconds = static_cast<double>(std::max<std::int64_t>(1, all.duration_ns)) * 1e-9;
        const auto each = [seconds](std::int64_t count) { return static_cast<double>(count) / seconds; };
        const bool is_live = options_.hls->window_ns > 0;
        const std::int64_t renditions = all.colour_bytes > 0 ? 2 : 1;
        nlohmann::ordered_json json{
            {"folder", options_.hls->folder.string()},
            {"segments", all.segments},
            {"seconds", seconds},
            {"colour_bytes_per_second", each(all.colour_bytes)},
            {"touch_bytes_per_second", each(all.touch_bytes)},
            {"playlist_bytes_per_second", is_live ? each(all.segments * all.playlist_bytes) : 0.0},
            {"requests_per_second", each(all.segments * renditions * (is_live ? 2 : 1))}};
        if (options_.hls->has_low) {
            json["low_colour_bytes_per_second"] = each(all.low_colour_bytes);
            json["low_touch_bytes_per_second"] = each(all.low_touch_bytes);
        }
        return json;
    }

    nlohmann::ordered_json report_as_json() const {
        const StreamSender::Figures& sent = sender_->figures();
        const auto each = [&sent](double all) {
            return sent.framesets > 0 ? all / static_cast<double>(sent.framesets) : 0.0;
        };
        constexpr double ms = 1e-6;
        std::int64_t folder_bytes = 0;
        if (hls_) {
            const HlsWriter::Figures& all = hls_->figures();
            folder_bytes = all.colour_bytes + all.touch_bytes + all.low_colour_bytes + all.low_touch_bytes;
        }
        nlohmann::ordered_json report{
            {"format", 1},
            {"clip", options_.clip.file.string()},
            {"notes", notes_},
            {"seconds", static_cast<double>(end_ns_ - begin_ns_) * 1e-9},
            {"framesets", sent.framesets},
            {"keys", sent.keys},
            {"rounds", sent.rounds},
            {"bytes_per_frameset", each(static_cast<double>(sent.bytes + folder_bytes))},
            {"cpu_ms_per_frameset", each(static_cast<double>(cpu_ns_) * ms)},
            {"latest_ms", static_cast<double>(sent.latest_ns) * ms},
            {"held_up_ms", static_cast<double>(sent.held_up_ns) * ms},
            {"listeners_in_all", audience_.all()},
        };
        auto listeners = nlohmann::ordered_json::array();
        for (const StreamAudience::Listener& each_one : audience_.gone()) {
            nlohmann::ordered_json figures{{"name", each_one.name},
                                           {"sent", each_one.sent},
                                           {"dropped", each_one.dropped},
                                           {"without_colour", each_one.without_colour},
                                           {"end", each_one.end}};
            if (each_one.link) figures["link"] = to_json(*each_one.link);
            listeners.push_back(std::move(figures));
        }
        report["listeners"] = std::move(listeners);
        if (hls_) report["hls"] = hls_as_json();
        return report;
    }

    std::string report_in_words() const {
        const auto report = report_as_json();
        const StreamSender::Figures& sent = sender_->figures();
        std::string text;
        for (const std::string& note : notes_) text += "note: " + one_line(note) + '\n';
        text += "sent " + counted(sent.framesets, "frameset") + " in " +
                formatted("%.1f s, ", report["seconds"].get<double>()) +
                formatted("%.1f KB", report["bytes_per_frameset"].get<double>() / 1000) +
                formatted(" and %.2f ms of CPU each; ", report["cpu_ms_per_frameset"].get<double>()) +
                counted(audience_.all(), "listener") + '\n';
        if (sent.held_up_ns > 0)
            text += "warning: they went " + formatted("%.1f s", report["held_up_ms"].get<double>() / 1000) +
                    " later than they were to: this machine encodes them too slowly, or stood still\n";
        if (hls_)
            text +=
                "  " + one_line(options_.hls->folder.string()) + ": " +
                std::to_string(hls_->figures().segments) +
                formatted(" segments; a viewer fetches %.1f KB/s",
                          (report["hls"]["colour_bytes_per_second"].get<double>() +
                           report["hls"]["touch_bytes_per_second"].get<double>() +
                           report["hls"]["playlist_bytes_per_second"].get<double>()) /
                              1000) +
                formatted(" by %.1f requests a second\n", report["hls"]["requests_per_second"].get<double>());
        for (const StreamAudience::Listener& one : audience_.gone())
            text += "  " + one.name + ": " + std::to_string(one.sent) + " sent, " +
                    std::to_string(one.dropped) + " left out\n";
        return text;
    }

    Result<void> report() {
        if (hls_) notes_.insert(notes_.end(), hls_->notes().begin(), hls_->notes().end());
        (options_.json.replaces_words() ? std::cerr : std::cout)
            << on_terminal(report_in_words()) << std::flush;
        return json_ ? write_report(report_as_json(), *json_) : Result<void>();
    }

    const ServeOptions& options_;
    std::unique_ptr<OutputFile> json_;
    std::unique_ptr<ClipReader> clip_;
    SceneDescription described_;
    bool is_live_ = false;
    std::vector<std::string> notes_;
    StreamAudience audience_{say_served};
    std::optional<ServedForm> matroska_, mpegts_, page_;
    std::unique_ptr<ScratchFolder> packed_;  // clip.json, and a clip's packets
    std::shared_ptr<HlsWriter> hls_;
    StreamRing nobody_;  // empty ring for the segments written to a folder
    std::unique_ptr<StreamServer> server_;
    std::vector<std::unique_ptr<SrtOutput>> outputs_;
    StreamSender::SystemTime time_;
    std::unique_ptr<StreamSender> sender_;
    std::thread thread_;
    std::int64_t cpu_ns_ = 0, begin_ns_ = 0, end_ns_ = 0;
};

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

/// With a camera the first word is also a URL.
Result<std::vector<std::string>> read_words(const ServeTyped& typed, ServeOptions& options) {
    std::vector<std::string> urls = typed.urls;
    const std::string first = typed.clip.choice.file.string();
    if (!typed.camera && first.empty())
        return usage_error(
            "what is to be sent? use touchable serve CLIP URL, or touchable serve --camera WORDS URL");
    if (!typed.camera) return urls;
    if (!first.empty() && !is_stream_url(first))
        return usage_error("CLIP and --camera are two things to send; leave one of them out");
    if (!first.empty()) urls.insert(urls.begin(), first);
    TRY_ASSIGN(const auto camera, read_live_camera(*typed.camera));
    options.clip.choose(camera);
    if (typed.options.loop) return usage_error("--loop is for clips; a camera does not end");
    return urls;
}

Result<void> check_url(const StreamUrl& url) {
    if (url.is_tls)
        return usage_error(in_quotes(url.name()) +
                           ": https is for a web server in front of this one; must be http://");
    const auto is_plain = [](char letter) { return letter > ' ' && letter < 127 && letter != '%'; };
    if (!std::ranges::all_of(url.path, is_plain))
        return usage_error(
            in_quotes(url.name()) +
            ": must have a name of plain letters and digits behind the port, such as /clip.mkv");
    if (url.transport == StreamTransport::pipe || url.transport == StreamTransport::udp)
        return usage_error(in_quotes(url.name()) +
                           ": must be tcp://, http:// or srt://, and an address to send at");
    return {};
}

/// A clip that ends stays in the playlists as a whole; an endless stream only for a window of time.
Result<void> read_hls(const ServeTyped& typed, ServeOptions& options) {
    if (!typed.hls) {
        if (typed.hls_segment || typed.hls_window || !typed.hls_low.empty())
            return usage_error("--hls-segment, --hls-window and --hls-low are for --hls DIR");
        return {};
    }
    HlsWriter::Settings& hls = options.hls.emplace();
    hls.folder = *typed.hls;
    if (typed.hls_segment) hls.segment_ns = std::llround(*typed.hls_segment * 1e9);
    hls.has_low = typed.hls_low == "on";
    constexpr double usual_window_s = 20;
    const bool goes_on = options.loop || options.clip.is_camera();
    const double window_s = typed.hls_window.value_or(goes_on ? usual_window_s : 0);
    hls.window_ns = std::llround(window_s * 1e9);
    return {};
}

/// A page is for one server alone, which begins at once.
Result<void> check_page(const ServeTyped& typed, ServeOptions& options) {
    if (!options.page) return {};
    const bool is_http =
        options.urls.size() == 1 && !typed.hls && options.urls.front().transport == StreamTransport::http;
    if (!is_http || options.urls.front().path != "/")
        return usage_error(
            "--page is for one address, such as http://0.0.0.0:8000, without a name and without --hls");
    if (options.loop || typed.listeners || options.json.file)
        return usage_error("--page needs no --loop and no --listeners, and makes no --json report");
    if (access((page_folder() / "index.html").c_str(), R_OK) != 0)
        return input_error("the page was not built into this program: ./run web");
    return choose_stream(options.clip);
}

Result<ServeOptions> read_options(const ServeTyped& typed) {
    ServeOptions options = typed.options;
    TRY_ASSIGN(options.clip, read_clip(typed.clip));
    options.filtered = typed.clip.filtered;
    TRY_ASSIGN(const auto words, read_words(typed, options));
    if (words.empty() && !typed.hls)
        return usage_error(
            "no destination: add a URL after CLIP, such as tcp://0.0.0.0:7000, or --hls FOLDER");
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
    TRY(check_page(typed, options));
    const bool waits_for_nobody = options.loop || options.clip.is_camera() || options.urls.empty();
    options.listeners = typed.listeners.value_or(waits_for_nobody ? 0 : 1);
    if (typed.seconds) options.longest_ns = std::llround(*typed.seconds * 1e9);
    return options;
}

}  // namespace

void add_serve_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("serve", "send a clip or a live camera over the network");
    auto typed = std::make_shared<ServeTyped>();
    add_clip_options(*sub, typed->clip);
    sub->add_option("URL", typed->urls,
                    "where to send: tcp://HOST:PORT, http://HOST:PORT/NAME or srt://HOST:PORT. HOST is this "
                    "machine's address; several may listen; port 0 of tcp and http is any free one; srt:// "
                    "with ?mode=caller calls");
    add_camera_options(*sub, typed->clip.camera);
    sub->add_option("--camera", typed->camera,
                    "send a live camera instead of CLIP. v4l2 and replay take ,key=value,... "
                    "(docs/streaming.md)")
        ->type_name(type_with_words("CAMERA", camera_words()));
    begin_topic(*sub, "Sending");
    sub->add_flag("--loop", typed->options.loop, "send the clip again and again");
    add_whole_option(*sub, "--listeners", typed->listeners,
                     "listeners to wait for before it begins, 0 to 64. By default 1; with --loop or --camera "
                     "0",
                     0, StreamAudience::most_listeners);
    add_number_option(*sub, "--seconds", typed->seconds, "end after so many seconds", 0.001, 1e8)
        ->type_name("SECONDS");
    sub->add_flag("--mpegts", typed->options.mpegts,
                  "send MPEG-TS over srt://, in place of Matroska. Stock programs show its colour");
    sub->add_flag("--page", typed->options.page,
                  "serve a page at http://HOST:PORT, in which browsers show the clip or the camera and let "
                  "people touch it");
    add_filtered_options(*sub, typed->clip, "send");
    begin_topic(*sub, "HLS");
    add_file_option(
        *sub, "--hls", typed->hls,
        "write HLS (segments and playlists) into a folder, for any web server. New or of an earlier "
        "stream; ordinary players show the colour; a whole clip as fast as it can be encoded")
        ->type_name("FOLDER");
    add_number_option(*sub, "--hls-segment", typed->hls_segment, "length of a segment, 0.5 to 10 (default 1)",
                      0.5, 10)
        ->type_name("SECONDS");
    add_number_option(
        *sub, "--hls-window", typed->hls_window,
        "how much of the stream the playlists hold, 3 to 86400. 20 by default with --loop or --camera; "
        "otherwise all of the clip",
        3, 86400)
        ->type_name("SECONDS");
    add_word_option(*sub, "--hls-low", typed->hls_low,
                    "add a second level of about half the bytes, for slow links. Coarser colour, and every "
                    "second frame; off by default",
                    {"on", "off"});
    begin_topic(*sub, files_topic);
    add_json_option(*sub, typed->options.json.file, "write the report as JSON", true);
    add_overwrite_option(*sub, typed->options.json.existing);
    set_work(*sub, command, [typed]() -> Result<void> {
        TRY_ASSIGN(const auto options, read_options(*typed));
        return Serving(options).run();
    });
}

}  // namespace touchable
