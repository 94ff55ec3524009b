// A program that sends framesets, as a camera: a command, or a connection on this machine. What is waited for
// is a frameset or an end; no test depends on a deadline.
#include "engine/camera/frameset_camera.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <future>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "tests/camera/frameset_bytes.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

using Opened = Result<std::unique_ptr<ClipReader>>;

FramesetBytes sent(std::uint64_t number) {
    FramesetBytes made;
    made.number = number;
    made.colour_width = 4;
    made.colour_height = 3;
    made.time_ns = static_cast<std::int64_t>(1'000'000'000 + 10'000'000 * number);
    return made;
}

std::string all_sent(std::uint64_t from, std::uint64_t to) {
    std::string all;
    for (std::uint64_t k = from; k < to; ++k) all += sent(k).bytes();
    return all;
}

/// Listens on a free port, sends to whoever comes.
class Listener {
public:
    Listener() {
        ::sockaddr_in here = loopback(0);
        ::socklen_t length = sizeof here;
        auto* const at = reinterpret_cast<::sockaddr*>(&here);
        EXPECT_EQ(::bind(listens_.get(), at, length), 0);
        EXPECT_EQ(::listen(listens_.get(), 1), 0);
        EXPECT_EQ(::getsockname(listens_.get(), at, &length), 0);
        choice.address = "127.0.0.1:" + std::to_string(ntohs(here.sin_port));
    }
    void send(const std::string& bytes) const {
        for (std::size_t at = 0; at < bytes.size();) {
            const auto gone = ::send(to_.get(), bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
            if (gone < 0) return;
            at += static_cast<std::size_t>(gone);
        }
    }
    void hang_up() { to_.reset(); }
    /// With these bytes to begin with.
    Opened open(const std::string& bytes) {
        auto opening = std::async(std::launch::async, [this] { return open_frameset_camera(choice); });
        to_ = Descriptor(::accept(listens_.get(), nullptr, nullptr));
        send(bytes);
        return opening.get();
    }
    /// One that runs: framesets up to 9 were given, and 10 is next.
    std::unique_ptr<ClipReader> running() {
        auto camera = open(all_sent(0, 10));
        EXPECT_EQ(message(camera), "");
        if (!camera) return nullptr;
        for (int n = 0; n < 2; ++n) EXPECT_EQ((*(*camera)->next())->number, n);
        EXPECT_EQ(message((*camera)->begin(std::chrono::steady_clock::now() - std::chrono::seconds(1))), "");
        return std::move(*camera);
    }

    FramesetChoice choice;

private:
    const Descriptor listens_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    Descriptor to_;
};

RawFrame next_of(ClipReader& camera) {
    auto frame = camera.next();
    EXPECT_EQ(message(frame), "");
    return frame && *frame ? **frame : RawFrame();
}

/// Which frameset a frame is of, as its first pixel tells.
std::uint64_t shown_by(const RawFrame& frame) {
    for (std::uint64_t k = 0; k < 57; ++k)
        if (frame.depth.data && frame.depth.sample(0, 0) == sent(k).depth(0, 0)) return k;
    return 1000;
}

TEST(FramesetCamera, GivesWhatIsSentAsACamera) {
    Listener sender;
    const auto camera = sender.running();
    ASSERT_TRUE(camera);
    const Scene& scene = camera->scene();
    EXPECT_EQ(scene.width, 8);
    EXPECT_EQ(scene.height, 6);
    EXPECT_EQ(scene.camera.fx, 7);
    EXPECT_EQ(scene.camera.fy, 7.5);
    EXPECT_DOUBLE_EQ(scene.depth.scale * scene.metres_per_unit, 0.001);
    EXPECT_EQ(scene.rate.num, 100 * scene.rate.den);
    EXPECT_EQ(scene.interpolation, FrameInterpolation::hold);
    EXPECT_TRUE(camera->is_live());
    ASSERT_EQ(camera->tracks().size(), 2U);
    std::int64_t before = -1, number = 1;
    std::uint64_t last = 9;
    for (std::uint64_t k = 10; k < 20; k += 1 + k % 2) {
        sender.send(sent(k).bytes());
        const RawFrame frame = next_of(*camera);
        EXPECT_EQ(shown_by(frame), k);
        EXPECT_GT(frame.time_ns, before);
        EXPECT_EQ(frame.number - number, k == 10 ? 1 : static_cast<std::int64_t>(k - last)) << k;
        last = k;
        EXPECT_EQ(frame.colour.width, 8) << "of depth's size";
        before = frame.time_ns;
        number = frame.number;
    }
    camera->leave_out_colour();
    sender.send(sent(30).bytes());
    EXPECT_EQ(next_of(*camera).colour.data, nullptr);
    EXPECT_EQ(camera->remarks(), std::vector<std::string>());
}

TEST(FramesetCamera, ShowsOnlyWhatIsWholeAndCountsTheRest) {
    Listener sender;
    const auto camera = sender.running();
    ASSERT_TRUE(camera);
    std::string damaged = sent(11).bytes();
    damaged[130] = static_cast<char>(damaged[130] ^ 1);
    sender.send(sent(10).bytes());
    EXPECT_EQ(shown_by(next_of(*camera)), 10U);
    sender.send(damaged + sent(10).bytes().substr(0, 120) + sent(10).bytes() + sent(12).bytes() +
                sent(12).bytes());
    const RawFrame frame = next_of(*camera);
    EXPECT_EQ(shown_by(frame), 12U);
    sender.send(sent(13).bytes());
    EXPECT_EQ(shown_by(next_of(*camera)), 13U);
    const auto remarks = camera->remarks();
    ASSERT_EQ(remarks.size(), 2U);
    EXPECT_NE(remarks[0].find("of the camera's frames were damaged or cut short"), std::string::npos);
    EXPECT_NE(remarks[1].find("2 of the camera's frames came twice"), std::string::npos) << remarks[1];
}

TEST(FramesetCamera, ThatEndsSaysSo) {
    Listener sender;
    const auto camera = sender.running();
    ASSERT_TRUE(camera);
    sender.send(sent(10).bytes() + sent(11).bytes().substr(0, 150));
    sender.hang_up();
    EXPECT_EQ(shown_by(next_of(*camera)), 10U);
    for (int again = 0; again < 3; ++again) {
        const auto end = camera->next();
        ASSERT_EQ(message(end), "");
        EXPECT_FALSE(*end);
    }
    const auto remarks = camera->remarks();
    ASSERT_EQ(remarks.size(), 1U);
    EXPECT_NE(remarks[0].find("the camera, tcp://127.0.0.1:"), std::string::npos) << remarks[0];
    EXPECT_NE(remarks[0].find(", closed the connection after "), std::string::npos) << remarks[0];
    EXPECT_NE(remarks[0].find("; its last frame stands still"), std::string::npos) << remarks[0];
}

TEST(FramesetCamera, ThatChangesEndsAndSaysSo) {
    Listener sender;
    const auto camera = sender.running();
    ASSERT_TRUE(camera);
    FramesetBytes other = sent(10);
    other.fx = 9;
    sender.send(other.bytes());
    const auto end = camera->next();
    ASSERT_EQ(message(end), "");
    EXPECT_FALSE(*end);
    EXPECT_NE(camera->remarks()[0].find("with fx 9, fy 7.5, cx 3.5, cy 2.5 and colour of 4x3 where it gave "),
              std::string::npos)
        << camera->remarks()[0];
}

TEST(FramesetCamera, AWaitEndsWhenItIsToldTo) {
    Listener sender;
    const auto camera = sender.running();
    ASSERT_TRUE(camera);
    sender.send(sent(10).bytes().substr(0, 90));
    std::stop_source given_up;
    auto waits = std::async(std::launch::async,
                            [&] { return work_until(given_up.get_token(), [&] { return camera->next(); }); });
    given_up.request_stop();
    const auto ended = waits.get();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().kind, ErrorKind::interrupted);
    // Another run goes on with the same connection.
    EXPECT_EQ(message(camera->begin(std::chrono::steady_clock::now() - std::chrono::seconds(1))), "");
    sender.send(sent(10).bytes().substr(90));
    EXPECT_EQ(shown_by(next_of(*camera)), 10U);
}

TEST(FramesetCamera, OpeningEndsWhenItIsGivenUp) {
    for (const bool pipe : {false, true}) {
        Listener sender;
        if (pipe) sender.choice = {.command = "exec sleep 1000"};
        std::stop_source given_up;
        auto opening = std::async(std::launch::async, [&] {
            const StopScope until(given_up.get_token());
            return open_frameset_camera(sender.choice);
        });
        given_up.request_stop();
        const auto opened = opening.get();
        ASSERT_FALSE(opened);
        EXPECT_EQ(opened.error().kind, ErrorKind::interrupted);
    }
}

TEST(FramesetCamera, WhatCannotBeOpenedSaysWhyInOneLine) {
    const TemporaryFolder folder;
    const std::string whole = folder / "whole", absurd = folder / "absurd";
    std::ofstream(whole, std::ios::binary) << all_sent(0, 5);
    FramesetBytes unit = sent(0);
    unit.unit = -1;
    std::ofstream(absurd, std::ios::binary) << unit.bytes();
    FramesetChoice silent{.command = "exec sleep 1000"}, cut{.command = "cat " + whole + "; exec sleep 1000"};
    FramesetChoice garbage{.command = "yes garbage"};
    garbage.patience = std::chrono::hours(1);
    silent.first_patience = cut.patience = std::chrono::milliseconds(50);
    const std::vector<std::pair<FramesetChoice, std::string>> cases{
        {{.command = "echo first >&2; echo no such camera >&2; exit 7"},
         "ended with status 7: no such camera"},
        {{.command = "/no/such/program"}, "ended with status 127: "},
        {{.command = "kill -9 $$"}, "ended by signal 9"},
        {{.command = "cat " + whole}, ", ended"},
        {{.command = "cat " + absurd}, "gives a unit of -1 m"},
        {{.command = "exec 1>&-; exec sleep 1000"}, "closed its standard output"},
        {garbage, "gave 256 MiB in which no whole frameset is"},
        {silent, "pipe:exec sleep 1000: sent nothing in 50 ms"},
        {cut, ": sent no whole frameset in 50 ms"},
        {{.address = "127.0.0.1:1"}, "tcp://127.0.0.1:1: no connection: "},
        {{.address = "example.org:7000"}, "right would be an address in numbers or localhost, and a port"}};
    for (const auto& [choice, says] : cases) {
        const auto opened = open_frameset_camera(choice);
        ASSERT_FALSE(opened) << says;
        EXPECT_NE(opened.error().message.find(says), std::string::npos) << opened.error().message;
        EXPECT_EQ(opened.error().message.find('\n'), std::string::npos) << opened.error().message;
    }
}

/// Whether a process is there, and no corpse that waits for its parent.
bool is_alive(::pid_t process) {
    std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
    std::string line;
    if (!std::getline(stat, line)) return false;
    const std::size_t state = line.rfind(") ");
    return state != std::string::npos && line[state + 2] != 'Z' && line[state + 2] != 'X';
}

TEST(FramesetCamera, ItsCommandAndAllThatItStartedEndWithIt) {
    const TemporaryFolder folder;
    const std::string frames = folder / "frames", child = folder / "child";
    std::ofstream(frames, std::ios::binary) << all_sent(0, 8);
    for (const std::string trap : {"", "trap '' TERM; "}) {
        std::filesystem::remove(child);
        FramesetChoice choice;
        choice.command = trap + "sleep 1000 & echo $! $$ >" + child + "; cat " + frames + "; wait";
        auto camera = open_frameset_camera(choice);
        ASSERT_EQ(message(camera), "");
        ::pid_t sleeper = 0, shell = 0;
        std::ifstream(child) >> sleeper >> shell;
        ASSERT_GT(sleeper, 1);
        EXPECT_TRUE(is_alive(sleeper));
        EXPECT_NE(::getpgid(sleeper), ::getpgrp()) << "Ctrl-C on a terminal is for the program";
        camera->reset();
        for (int looks = 0; looks < 10'000 && is_alive(sleeper); ++looks)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        EXPECT_FALSE(is_alive(sleeper)) << trap;
        EXPECT_FALSE(is_alive(shell)) << trap;
        EXPECT_FALSE(std::filesystem::exists("/proc/" + std::to_string(shell))) << "it is waited for";
    }
}

TEST(FramesetCamera, ItsCommandHasNothingOfTheProgram) {
    const TemporaryFolder folder;
    const std::string said = folder / "said";
    const int open_here = ::open("/dev/null", O_RDONLY);  // on purpose not closed on exec
    const auto opened = open_frameset_camera(
        {.command = "ls /proc/self/fd | tr '\\n' ' ' >" + said + "; head -c 1 | wc -c >>" + said});
    ::close(open_here);
    EXPECT_FALSE(opened);
    std::ifstream in(said);
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "0 1 2 3 0") << "3 is the folder that ls reads; standard input is empty";
}

TEST(FramesetCamera, AddressesAreReadOrRefused) {
    for (const char* right : {"127.0.0.1:7000", "localhost:1", "[::1]:65535", "192.168.0.5:80"})
        EXPECT_EQ(message(check_address(right)), "") << right;
    for (const char* wrong :
         {"", ":", "127.0.0.1", "127.0.0.1:", ":7000", "127.0.0.1:0", "127.0.0.1:65536", "127.0.0.1:7x",
          "127.0.0.1:-1", "name:7000", "127.0.0.1:99999999999999999999"}) {
        const auto refused = check_address(wrong);
        ASSERT_FALSE(refused) << wrong;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    }
}

}  // namespace
}  // namespace touchable::test
