// SPDX-License-Identifier: Apache-2.0
// The program sends, on this machine, at ports that the system chooses.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <thread>

#include "engine/formats/formats_written.hpp"
#include "engine/stream/hls.hpp"
#include "engine/stream/labelled_codec.hpp"
#include "engine/stream/listeners.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/stream/peers.hpp"
#include "tests/stream/relay.hpp"
#include "tests/stream/served_clip.hpp"
#include "tests/stream/servers.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

constexpr Planes served_planes{true, true, true, false};

Scene quick_scene() {
    Scene scene = small_scene(32, 24, 16);
    scene.rate = {100, 1};
    return scene;
}

/// "tcp://127.0.0.1:41234", once the program has said it; empty before.
std::vector<std::string> places_in(const std::string& err) {
    const std::string begin = "listening on ", end = ": touchable play ";
    std::vector<std::string> places;
    for (std::size_t at = 0; (at = err.find(begin, at)) != std::string::npos;) {
        at += begin.size();
        const std::size_t to = err.find(end, at);
        if (to == std::string::npos || err.find('\n', to) == std::string::npos) break;
        places.push_back(err.substr(at, to - at));
    }
    return places;
}

/// The listeners while the program runs.
class Listeners {
public:
    ~Listeners() { wait(); }
    void listen(const std::string& place, std::size_t enough = std::size_t{1} << 40U) {
        auto& heard = *heard_.emplace_back(std::make_unique<std::string>());
        threads_.emplace_back([&heard, place, enough] {
            const StreamPeer peer(place);
            if (!place.starts_with("http")) {
                heard = peer.hear_all(enough);
                return;
            }
            peer.say("GET " + place.substr(place.find('/', 7)) + " HTTP/1.1\r\n\r\n");
            heard = peer.hear_all(enough).substr(http_answer(200).size());
        });
    }
    void wait() {
        for (std::thread& thread : threads_) thread.join();
        threads_.clear();
    }
    std::size_t count() const { return heard_.size(); }
    const std::string& heard(std::size_t listener) const { return *heard_[listener]; }

private:
    std::vector<std::unique_ptr<std::string>> heard_;
    std::vector<std::thread> threads_;
};

class ServeCommand : public ::testing::Test {
protected:
    void SetUp() override { ASSERT_EQ(message(write_clip(clip, quick_scene(), frames, served_planes)), ""); }
    /// Each place is listened to `each` times as soon as it is there.
    nlohmann::json serve(Words words, std::size_t each = 1) {
        words.insert(words.begin(), "serve");
        words.insert(words.end(), {"--json", report, "--overwrite"});
        listeners = std::make_unique<Listeners>();
        const std::size_t places_wanted =
            static_cast<std::size_t>(std::count_if(words.begin(), words.end(), [](const std::string& word) {
                return word.find("//127.0.0.1:0") != std::string::npos;
            }));
        outcome = run_until_it_says(words, [&](const std::string& err) {
            const auto places = places_in(err);
            if (listeners->count() == 0 && places.size() == places_wanted)
                for (const std::string& place : places)
                    for (std::size_t k = 0; k < each; ++k) listeners->listen(place);
            return false;
        });
        listeners->wait();
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return nlohmann::json::parse(read_bytes(report), nullptr, false);
    }
    Result<std::vector<RawFrame>> saved(std::size_t listener) const {
        write_bytes(folder / "saved.mkv", listeners->heard(listener));
        return read_clip(folder / "saved.mkv");
    }
    void expect_whole_clip(std::size_t listener) const {
        const auto read = must(saved(listener));
        ASSERT_EQ(std::ssize(read), frames);
        for (int n = 0; n < frames; ++n)
            EXPECT_TRUE(same_touch_planes(read[static_cast<std::size_t>(n)],
                                          test_frame(quick_scene(), n, served_planes)))
                << n;
    }

    /// Fewer than a listener may be behind: nothing is left out, however busy the machine is.
    static constexpr int frames = 12;
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv", report = folder / "report.json";
    std::unique_ptr<Listeners> listeners;
    Outcome outcome;
};

TEST_F(ServeCommand, SendsWholeClip) {
    for (const std::string place : {"tcp://127.0.0.1:0", "http://127.0.0.1:0/live.mkv"}) {
        const auto told = serve({clip, place});
        expect_whole_clip(0);
        EXPECT_EQ(told["framesets"], frames);
        EXPECT_EQ(told["keys"], 1);
        EXPECT_GT(told["bytes_per_frameset"], 0);
        EXPECT_GT(told["cpu_ms_per_frameset"], 0);
        ASSERT_EQ(told["listeners"].size(), 1U);
        EXPECT_EQ(told["listeners"][0]["sent"], frames);
        EXPECT_EQ(told["listeners"][0]["dropped"], 0);
        EXPECT_EQ(told["listeners"][0]["end"], "");
        EXPECT_PRED2(says, outcome.out, "sent 12 framesets");
        EXPECT_PRED2(says, outcome.err, " listens; 1 listener\n");
        EXPECT_PRED2(says, outcome.err, " has all of it: 12 framesets sent");
    }
}

TEST_F(ServeCommand, ListenersGetSameBytes) {
    const auto told = serve({clip, "tcp://127.0.0.1:0", "http://127.0.0.1:0/", "--listeners", "6"}, 3);
    EXPECT_EQ(told["listeners_in_all"], 6);
    for (std::size_t k = 1; k < 6; ++k) EXPECT_EQ(listeners->heard(k), listeners->heard(0));
    expect_whole_clip(0);
}

// A listener of a loop gets it from a key frame on; an interrupt ends the loop.
TEST_F(ServeCommand, LoopRunsUntilInterrupted) {
    constexpr std::size_t some = 100'000;
    listeners = std::make_unique<Listeners>();
    bool has_all = false;
    outcome = run_until_it_says({"serve", clip, "tcp://127.0.0.1:0", "--loop", "--json", report},
                                [&](const std::string& err) {
                                    const auto places = places_in(err);
                                    if (listeners->count() == 0 && !places.empty())
                                        listeners->listen(places.front(), some);
                                    has_all = has_all || err.find(" has gone: ") != std::string::npos;
                                    return has_all;
                                });
    listeners->wait();
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_PRED2(says, outcome.out, "1 listener\n");
    const auto told = nlohmann::json::parse(read_bytes(report), nullptr, false);
    EXPECT_GE(told["framesets"], told["listeners"][0]["sent"]);
    const auto read = must(saved(0));
    EXPECT_GE(read.size(), 3U);
    for (std::size_t n = 1; n < read.size(); ++n)
        EXPECT_EQ((read[n].time_ns - read[n - 1].time_ns) % 10'000'000, 0);
}

TEST_F(ServeCommand, EndsAfterGivenSeconds) {
    const auto told = serve({clip, "tcp://127.0.0.1:0", "--loop", "--listeners", "1", "--seconds", "0.275"});
    EXPECT_EQ(told["framesets"], 28);
    EXPECT_EQ(told["rounds"], 3);
    const auto read = must(saved(0));
    ASSERT_EQ(read.size(), 28U);
    for (int n = 0; n < 28; ++n)
        EXPECT_TRUE(same_touch_planes(read[static_cast<std::size_t>(n)],
                                      test_frame(quick_scene(), n % frames, served_planes)));
}

// A camera's frames are sent, except for those that were missed.
TEST_F(ServeCommand, SendsCameraFrames) {
    const auto told =
        serve({"--camera", "replay:" + clip + ",drop=0.5", "tcp://127.0.0.1:0", "--listeners", "1"});
    EXPECT_EQ(told["listeners"][0]["sent"], told["framesets"]);
    const auto read = must(saved(0));
    EXPECT_EQ(std::ssize(read), told["framesets"]);
    EXPECT_LT(std::ssize(read), frames);
    EXPECT_GE(read.size(), 1U);
    int n = 0;
    for (const RawFrame& frame : read) {
        while (n < frames && !same_touch_planes(frame, test_frame(quick_scene(), n, served_planes))) ++n;
        ASSERT_LT(n, frames) << "frame " << frame.number << " is none that comes after the one before";
        ++n;
    }
}

/// Frames of depth that a receiver of the folder has, each as it was sent.
int frames_of_depth(const std::filesystem::path& master, const Scene& scene, int round) {
    auto input = HlsInput::open(master.string());
    EXPECT_EQ(message(input), "");
    LabelledDecoder decoder(1 << 22);
    std::map<std::pair<bool, int>, std::size_t> tracks;
    int depths = 0;
    while (input) {
        const auto packet = (*input)->next();
        EXPECT_EQ(message(packet), "");
        if (!packet || !*packet) break;
        const std::pair which{(*packet)->is_touch, (*packet)->stream->index};
        if (!tracks.contains(which)) tracks[which] = *decoder.add_track(*(*packet)->stream, "folder");
        const auto pictures = decoder.add(tracks[which], *(*packet)->packet);
        for (const LabelledPicture& picture : *pictures) {
            if (picture.role != PlaneRole::depth) continue;
            const RawFrame sent = test_frame(scene, picture.label.frame % round, served_planes);
            EXPECT_TRUE(same_plane(picture.plane.view, sent.depth)) << picture.label.frame;
            ++depths;
        }
    }
    EXPECT_EQ(decoder.damaged(), 0);
    return depths;
}

// As fast as it can be encoded: the clip's times are not waited for.
TEST_F(ServeCommand, HlsFolderHoldsWholeClip) {
    const auto web = folder / "web";
    const auto told = serve({clip, "--hls", web.string()}, 0);
    EXPECT_EQ(told["framesets"], frames);
    EXPECT_EQ(told["hls"]["segments"], 1);
    EXPECT_NEAR(told["hls"]["seconds"], 0.12, 1e-9);
    EXPECT_GT(told["hls"]["colour_bytes_per_second"], 0);
    EXPECT_GT(told["hls"]["touch_bytes_per_second"], 0);
    EXPECT_PRED2(says, read_bytes(web / "touch.m3u8"), "#EXT-X-PLAYLIST-TYPE:VOD");
    EXPECT_EQ(frames_of_depth(web / "master.m3u8", quick_scene(), frames), frames);
}

TEST_F(ServeCommand, HlsFolderHasLowLevel) {
    const auto web = folder / "web";
    const auto told = serve({clip, "--hls", web.string(), "--hls-low", "on"}, 0);
    const auto& hls = told["hls"];
    EXPECT_GT(hls["low_touch_bytes_per_second"], 0);
    EXPECT_LT(hls["low_touch_bytes_per_second"], hls["touch_bytes_per_second"]);
    EXPECT_LT(hls["low_colour_bytes_per_second"], hls["colour_bytes_per_second"]);
    EXPECT_PRED2(says, read_bytes(web / "master.m3u8"), "touch-low.m3u8");
    EXPECT_EQ(frames_of_depth(web / "master.m3u8", quick_scene(), frames), frames);
}

// Beside the listeners, at the clip's own times.
TEST_F(ServeCommand, HlsFolderKeepsLoopWindow) {
    const auto web = folder / "web";
    const auto told = serve({clip, "tcp://127.0.0.1:0", "--hls", web.string(), "--hls-segment", "0.5",
                             "--loop", "--hls-window", "3", "--listeners", "1", "--seconds", "1.75"});
    EXPECT_EQ(told["framesets"], 175);
    EXPECT_EQ(told["hls"]["segments"], 4);
    EXPECT_NEAR(told["hls"]["requests_per_second"], 16 / 1.75, 1e-6);
    const auto& listener = told["listeners"][0];
    EXPECT_GT(listener["sent"], 0);
    EXPECT_EQ(listener["sent"].get<int>() + listener["dropped"].get<int>(), 175);
    EXPECT_EQ(read_bytes(web / "touch.m3u8").find("#EXT-X-PLAYLIST-TYPE:VOD"), std::string::npos);
    EXPECT_EQ(frames_of_depth(web / "master.m3u8", quick_scene(), frames), 175);
}

TEST_F(ServeCommand, KeepsForeignFolder) {
    expect_failure({"serve", clip, "--hls", folder.path().string()}, 3, "clip.mkv");
    EXPECT_EQ(folder.file_count(), 1U);
}

TEST_F(ServeCommand, RejectsInvalidOptions) {
    const auto refused = [&](const Words& words, const std::string& why) {
        expect_failure(plus({"serve"}, words), 2, why);
    };
    refused({}, "what is to be sent?");
    refused({clip}, "no destination: add a URL after CLIP, such as tcp://0.0.0.0:7000, or --hls FOLDER");
    refused({clip, "--camera", "replay:" + clip, "tcp://127.0.0.1:0"}, "leave one of them out");
    refused({"--camera", "replay:" + clip, "tcp://127.0.0.1:0", "--loop"}, "--loop is for clips");
    refused({clip, "tcp://127.0.0.1"}, "with a port");
    refused({clip, "tcp://example.org:1"}, "an address of this machine");
    refused({clip, "https://127.0.0.1:0/"}, "must be http://");
    refused({clip, "tcp://127.0.0.1:0", "--detail", "1"}, "filters are for --filtered");
    for (const char* place : {"-", "udp://127.0.0.1:5000"})
        refused({clip, place}, "must be tcp://, http:// or srt://");
    refused({clip, "srt://127.0.0.1:0"}, "needs a port");
    refused({clip, "srt://:5000?mode=caller"}, "names no host");
    refused({clip, "srt://127.0.0.1:5000?mode=both"}, "mode is caller or listener");
    refused({clip, "srt://127.0.0.1:5000?latency=1s"}, "latency is milliseconds");
    refused({clip, "tcp://127.0.0.1:0", "--mpegts"}, "--mpegts is for srt://");
    refused({clip, "tcp://127.0.0.1:0", "--listeners", "65"}, "0 to 64");
    refused({clip, "tcp://127.0.0.1:0", "--hls-window", "5"}, "are for --hls DIR");
    refused({clip, "tcp://127.0.0.1:0", "--hls-low", "on"}, "are for --hls DIR");
    refused({clip, "--hls", folder / "web", "--hls-segment", "0.1"}, "0.5 to 10");
    const std::string place = "http://127.0.0.1:0", one = "--page is for one address, such as http://";
    refused({clip, "tcp://127.0.0.1:0", "--page"}, one);
    refused({clip, "srt://127.0.0.1:5000", "--page"}, one);
    refused({clip, place + "/clip.mkv", "--page"}, one);
    refused({clip, place, place, "--page"}, one);
    refused({clip, place, "--page", "--hls", folder / "web"}, one);
    refused({clip, place, "--page", "--loop"}, "--page needs no --loop");
    EXPECT_EQ(run_touchable({"serve", folder / "none.mkv", "tcp://127.0.0.1:0"}).code, 3);
}

// A page for browsers.

/// The program as it is installed, with a page that is a stand-in, and with temporary files of its own.
class ServePage : public ServeCommand {
protected:
    void SetUp() override {
        ServeCommand::SetUp();
        std::filesystem::create_directories(web);
        write_bytes(web / "index.html", "a page");
        if (const char* const typed = std::getenv("TMPDIR")) before = typed;
        setenv("TMPDIR", temporary.path().c_str(), 1);
    }
    void TearDown() override {
        EXPECT_EQ(temporary.file_count(), 0U) << "temporary files are left";
        before ? setenv("TMPDIR", before->c_str(), 1) : unsetenv("TMPDIR");
    }
    /// Serves the page, and interrupts that when `visit` is back, which gets the address.
    void serve_page(Words words, const std::function<void(const std::string& place)>& visit) {
        words.insert(words.begin(), "serve");
        words.insert(words.end(), {"http://127.0.0.1:0", "--page"});
        std::chrono::steady_clock::time_point left;
        const std::string begin = "listening on ", end = ": open in a browser ";
        outcome = run_until_it_says(
            words,
            [&](const std::string& err) {
                const std::size_t at = err.find(begin), to = err.find(end);
                if (to == std::string::npos || err.find('\n', to) == std::string::npos) return false;
                visit(err.substr(at + begin.size(), to - at - begin.size()));
                left = std::chrono::steady_clock::now();
                return true;
            },
            program);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_LT(std::chrono::steady_clock::now() - left, std::chrono::seconds(2));
    }
    static std::string fetched(const std::string& place, const std::string& name,
                               const std::string& fields = "") {
        const StreamPeer peer(place);
        peer.say("GET /" + name + " HTTP/1.1\r\n" + fields + "\r\n");
        const std::string heard = peer.hear_all();
        return heard.substr(std::min(heard.size(), heard.find("\r\n\r\n") + 4));
    }

    const std::filesystem::path program = install_program(folder.path()),
                                web = folder / "share/touchable/web";
    const TemporaryFolder temporary;
    std::optional<std::string> before;
};

TEST_F(ServePage, ServesPackedClip) {
    const TemporaryFolder saved;
    serve_page({clip}, [&](const std::string& place) {
        EXPECT_EQ(fetched(place, ""), "a page");
        const std::string text = fetched(place, "clip.json");
        write_bytes(saved / "clip.json", text);
        const auto told = nlohmann::json::parse(text);
        for (const auto& [role, plane] : told.at("planes").items()) {
            const std::string name = plane.at("file"), whole = fetched(place, name);
            write_bytes(saved / name, whole);
            EXPECT_EQ(fetched(place, name, "Range: bytes=3-9\r\n"), whole.substr(3, 7)) << name;
        }
        EXPECT_EQ(fetched(place, "live"), "");
    });
    const auto read = must(read_clip(saved / "clip.json"));
    ASSERT_EQ(std::ssize(read), frames);
    for (int n = 0; n < frames; ++n)
        EXPECT_TRUE(
            same_touch_planes(read[static_cast<std::size_t>(n)], test_frame(quick_scene(), n, served_planes)))
            << n;
    EXPECT_EQ(outcome.err.find("is open to ANY machine"), std::string::npos) << outcome.err;
}

/// A frame as a page gets it.
struct PageFrame {
    std::array<std::string, 4> packets;  ///< depth, haptic, height, colour
    double time_ns = 0;
};

/// The whole frames at the beginning of a stream.
std::vector<PageFrame> page_frames(std::string_view bytes) {
    std::vector<PageFrame> frames;
    while (true) {
        constexpr std::size_t head = 24;
        std::array<std::uint32_t, 4> sizes{};
        if (bytes.size() < head) return frames;
        std::memcpy(sizes.data(), bytes.data(), sizeof sizes);
        if (bytes.size() < head + std::accumulate(sizes.begin(), sizes.end(), std::size_t{0})) return frames;
        PageFrame& frame = frames.emplace_back();
        std::memcpy(&frame.time_ns, bytes.data() + sizeof sizes, sizeof frame.time_ns);
        bytes.remove_prefix(head);
        for (std::size_t k = 0; k < sizes.size(); ++k) {
            frame.packets[k] = bytes.substr(0, sizes[k]);
            bytes.remove_prefix(sizes[k]);
        }
    }
}

// Each client begins with a whole frame, and none waits for another.
TEST_F(ServePage, ServesCameraFrames) {
    const std::string moving = folder / "moving.mkv";
    ASSERT_EQ(message(write_clip(moving, quick_scene(), 2000, served_planes)), "");
    std::set<std::string> depths;
    FramePacker packer(1);
    for (const RawFrame& frame : must(read_clip(moving)))
        if (const auto packets = must(packer.pack(frame)); !packets[0].empty()) depths.insert(packets[0]);
    serve_page({"--camera", "replay:" + moving}, [&](const std::string& place) {
        const auto told = nlohmann::json::parse(fetched(place, "clip.json"));
        EXPECT_EQ(told.at("live"), "live");
        EXPECT_FALSE(told.contains("frames"));
        const StreamPeer stuck(place, 4096);
        stuck.say("GET /live HTTP/1.1\r\n\r\n");
        double begin_ns = 0;
        for (int client = 0; client < 2; ++client) {
            const StreamPeer peer(place);
            peer.say("GET /live HTTP/1.1\r\n\r\n");
            const std::string heard = peer.hear_all(100'000);
            const auto got = page_frames(std::string_view(heard).substr(heard.find("\r\n\r\n") + 4));
            ASSERT_GE(got.size(), 3U);
            EXPECT_TRUE(has_words(heard, "\r\nContent-Type: application/octet-stream\r\n"));
            for (const std::size_t felt_or_seen : {0U, 1U, 3U})
                EXPECT_NE(got.front().packets[felt_or_seen], "") << felt_or_seen;
            EXPECT_GE(got.front().time_ns, begin_ns) << "a later client begins with a newer frame";
            begin_ns = got.front().time_ns;
            for (std::size_t n = 0; n < got.size(); ++n) {
                EXPECT_TRUE(got[n].packets[0].empty() || depths.contains(got[n].packets[0])) << n;
                EXPECT_TRUE(n == 0 || got[n].time_ns > got[n - 1].time_ns) << n;
            }
        }
        EXPECT_EQ(fetched(place, ""), "a page");
    });
    EXPECT_PRED2(says, outcome.out, "3 listeners\n");
}

TEST_F(ServePage, NeedsPage) {
    std::filesystem::remove(web / "index.html");
    outcome = run_until_it_says(
        {"serve", clip, "http://127.0.0.1:0", "--page"}, [](const std::string&) { return false; }, program);
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.err, "touchable: the page was not built into this program: ./run web\n");
}

/// What came of a stream cannot be had again.
class SavedStream : public ::testing::Test {
protected:
    void expect_saved(const Outcome& run, std::size_t least) const {
        const auto frames = must(read_clip(out));
        EXPECT_GE(frames.size(), least);
        for (std::size_t n = 0; n < frames.size(); ++n)
            EXPECT_TRUE(same_touch_planes(frames[n], sent.frames[n])) << n;
        EXPECT_PRED2(says, run.err,
                     "; " + out + " has what came, " + std::to_string(frames.size()) + " frame");
    }

    const StreamOfFrames sent = make_stream(quick_scene(), 8, served_planes);
    const TemporaryFolder folder;
    const std::string out = folder / "out.mkv";
};

TEST_F(SavedStream, IsKeptWhenInterrupted) {
    const LoopbackSender sender([&](const LoopbackSender::Listener& to, int) {
        (void)to.send(sent.bytes());
        to.stay();
    });
    const Outcome run = run_on_terminal({"convert", sender.url(), out}, [](const std::string& said) {
        return says(said, "converting frame");
    });
    EXPECT_EQ(run.code, 130);
    EXPECT_PRED2(says, run.err, "interrupted; ");
    expect_saved(run, 1);
}

TEST_F(SavedStream, SaysWhatWasLost) {
    const auto label = [](std::int64_t number) { return stream_label(number < 4 ? number : number + 1); };
    const LoopbackSender sender(
        stream_by(open_matroska_stream(quick_scene()), quick_scene(), 8, served_planes, {.label = label})
            .bytes());
    const Outcome run = succeed({"convert", sender.url(), out});
    EXPECT_EQ(must(read_clip(out)).size(), 9U);
    // The frame behind the gap cannot be decoded either.
    for (const char* note : {"  note    2 of the stream's framesets were lost on the way\n",
                             "  note    in place of them the one before was held, for 2 frames\n"})
        EXPECT_PRED2(says, run.out, note);
}

TEST_F(SavedStream, CanGetRelief) {
    const LoopbackSender sender(sent.bytes());
    succeed({"relief", sender.url(), out});
    EXPECT_FALSE(must(read_clip(out)).at(0).height.empty());
}

TEST_F(SavedStream, IsKeptWhenConnectionBreaks) {
    const std::string whole = sent.bytes();
    const LoopbackSender sender(whole.substr(0, whole.size() - sent.blocks.back().size() / 2));
    const Outcome run = expect_failure({"convert", sender.url(), out}, 3,
                                       "frame 7: the sender closed the connection in the middle of it; ");
    expect_saved(run, 7);
}

TEST_F(ServeCommand, WarnsAboutOpenAddress) {
    const std::string open = " is open to ANY machine that reaches it: ";
    const auto is_open = [&](const std::string& place) {
        const Outcome run = succeed({"serve", clip, place, "--loop", "--seconds", "0.05"});
        EXPECT_PRED2(says, run.err, ": touchable play ");
        return run.err.find(open) != std::string::npos;
    };
    const std::string port = std::to_string(unused_port()), key = "?passphrase=";
    for (const std::string& place : Words{"tcp://0.0.0.0:0", "tcp://:0", "http://0.0.0.0:0/live.mkv",
                                          "srt://0.0.0.0:" + port, "srt://0.0.0.0:" + port + key})
        EXPECT_TRUE(is_open(place)) << place;
    for (const std::string& place :
         Words{"tcp://127.0.0.1:0", "tcp://localhost:0", "http://127.0.0.1:0/", "srt://127.0.0.1:" + port,
               "srt://0.0.0.0:" + port + key + "0123456789abc"})
        EXPECT_FALSE(is_open(place)) << place;
}

TEST_F(ServeCommand, WaitingIsInterruptible) {
    const Outcome run = run_until_it_says({"serve", clip, "tcp://127.0.0.1:0"},
                                          [](const std::string& err) { return !places_in(err).empty(); });
    EXPECT_EQ(run.code, 130);
    EXPECT_EQ(run.out, "");
}

// A clip that one program sends and another touches, by every transport, and over a network that fails.

class ServedTouch : public ::testing::Test {
protected:
    ServedTouch() { make_clip("moving", clip, {"--size", "64x48", "--frames", "20", "--rate", "100"}); }
    std::unique_ptr<ServedClip> serve(std::vector<std::string> options) const {
        auto served = ServedClip::start(clip, std::move(options), folder / "served.json");
        EXPECT_TRUE(served) << served.error().message;
        return served ? std::move(*served) : nullptr;
    }
    std::string hash_of(const std::string& what) const {
        return force_hash({what, "--fingers", "2", "--seconds", "0.19"});
    }

    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
};

TEST_F(ServedTouch, MatchesFileOnEveryTransport) {
    const std::string expected = hash_of(clip);
    const std::string srt = "srt://127.0.0.1:" + std::to_string(unused_port());
    const std::string ts = "srt://127.0.0.1:" + std::to_string(unused_port());
    for (const std::vector<std::string>& options : {std::vector<std::string>{"tcp://127.0.0.1:0"},
                                                    {"tcp://127.0.0.1:0", "--filtered"},
                                                    {"http://127.0.0.1:0/clip.mkv"},
                                                    {srt},
                                                    {ts, "--mpegts"}}) {
        const auto served = serve(options);
        ASSERT_TRUE(served);
        EXPECT_EQ(hash_of(served->address()), expected) << options.front();
    }
}

TEST_F(ServedTouch, MatchesFileInSegments) {
    const std::string web = folder / "web";
    succeed({"serve", clip, "--hls", web});
    const WebServer server([&](const std::string& path) { return reply_with_file(web, path); });
    const std::string expected = hash_of(clip);
    EXPECT_EQ(hash_of(server.url("/master.m3u8")), expected);
    EXPECT_EQ(hash_of(web + "/master.m3u8"), expected);
}

/// Force of a pressing finger on a stream, tick by tick, for other threads to watch.
class Watch final : public TouchSink {
public:
    Result<void> consume(const TouchTick& tick) override {
        const GuardedForce& guarded = tick.forces[0];
        const double force = glm::length(guarded.force);
        if (last_tick_ + 1 == tick.tick)
            largest_change = std::max(largest_change, glm::length(guarded.force - last_));
        last_ = guarded.force;
        last_tick_ = tick.tick;
        frame = tick.pair.prev.number;
        is_felt = force > 0.01;
        is_gone = (guarded.reasons & guard_stale) != 0 && force == 0;
        return {};
    }
    std::atomic<bool> is_felt{false}, is_gone{false};
    std::atomic<std::int64_t> frame{-1};
    double largest_change = 0;  // N, from tick to tick

private:
    glm::dvec3 last_{0.0};
    std::int64_t last_tick_ = -2;
};

/// Waits for something that others do; a minute at most.
template <class Condition>
bool comes(const Condition& condition) {
    for (int k = 0; k < 6000 && !condition(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return condition();
}

/// A finger that rests in a plane, of which frames come over a relay.
TEST_F(ServedTouch, NetworkFailureReleasesHand) {
    const std::string plane = folder / "plane.mkv";
    make_clip("globe", plane, {"--size", "64x48", "--frames", "1", "--rate", "30"});
    auto served = must(ServedClip::start(plane, {"tcp://127.0.0.1:0", "--loop"}, folder / "served.json"));
    const std::string address = served->address();
    const int port = std::stoi(address.substr(address.rfind(':') + 1));
    const auto relay = must(Relay::open(Relay::Kind::tcp, port));

    SessionOptions options;
    options.live = options.start_buried = true;
    options.ticks = 300'000;
    options.hand = "press:depth=2,lift=0,period=4";
    options.camera = "stream:tcp://127.0.0.1:" + std::to_string(relay->port());
    options.clip.choose(*read_live_camera(*options.camera));
    const auto setup = must(setup_from_options(options));
    TouchSetup& s = *setup;
    TouchSessionSettings settings = s.options;
    settings.ticks = s.ticks();
    const auto hand = make_port(*s.hand);
    LiveSession session(*s.feed, *hand, *s.solver, settings);
    Watch watch;
    TouchSink* const sinks[]{&watch};
    Result<void> ran;
    std::thread thread([&] { ran = session.run(sinks); });

    const auto& reader = s.feed->reader();
    EXPECT_TRUE(comes([&] { return watch.is_felt.load(); }));
    relay->stall(true);
    EXPECT_TRUE(comes([&] { return watch.is_gone.load(); }));
    EXPECT_EQ(silence_in_words(2'100'000'000, 250'000'000, reader),
              "no frame for 2.1 s: the surface goes soft");
    EXPECT_EQ(silence_in_words(200'000'000, 250'000'000, reader), "");
    relay->stall(false);
    EXPECT_TRUE(comes([&] { return watch.is_felt.load(); })) << "after a network that stood still";
    relay->cut();
    EXPECT_TRUE(comes(
        [&] { return silence_in_words(0, 0, reader).starts_with("the stream has ended: the sender "); }));
    EXPECT_TRUE(comes([&] { return reader.stream_figures()->connections > 1; }));
    const std::int64_t frame = watch.frame;
    EXPECT_TRUE(comes([&] { return watch.frame > frame && watch.is_felt; }))
        << "after a connection that broke";
    session.stop();
    thread.join();
    EXPECT_TRUE(ran) << ran.error().message;
    EXPECT_FALSE(session.facts().failure);
    EXPECT_EQ(reader.stream_figures()->torn, 0);
    EXPECT_LE(watch.largest_change, 0.035 * settings.guard.max_force);
}

}  // namespace
}  // namespace touchable::test
