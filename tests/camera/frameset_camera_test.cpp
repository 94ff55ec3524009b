// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <fcntl.h>

#include <bit>
#include <csignal>
#include <future>
#include <limits>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/camera/frameset_camera.hpp"
#include "engine/clip/readers.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

void put(std::string& to, std::uint64_t value, int size) {
    for (int k = 0; k < size; ++k) to += static_cast<char>(value >> (8 * k) & 0xff);
}

/// Bit by bit, as the standard has it (IEEE 802.3).
std::uint32_t plain_crc32(const std::string& bytes) {
    std::uint32_t crc = 0xffffffff;
    for (const char byte : bytes) {
        crc ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
    }
    return ~crc;
}

/// A frameset as docs/streaming.md has it, written once more.
struct FramesetBytes {
    std::uint64_t number = 0;
    std::int64_t time_ns = 0;
    std::uint32_t version = 1, width = 8, height = 6;
    double unit = 0.001, fx = 7, fy = 7.5, cx = 3.5, cy = 2.5;
    std::uint32_t colour_width = 0, colour_height = 0, flags = 1;

    /// Depth at a pixel, mm; every frameset has another.
    std::uint16_t depth(std::uint32_t x, std::uint32_t y) const {
        return static_cast<std::uint16_t>(500 + 7 * number % 400 + 3 * x + y);
    }
    /// With the right checksums.
    std::string bytes() const {
        std::string shown, head = "FRAMESET";
        for (std::uint32_t y = 0; y < height; ++y)
            for (std::uint32_t x = 0; x < width; ++x) put(shown, depth(x, y), 2);
        for (std::uint32_t k = 0; k < 3 * colour_width * colour_height; ++k) put(shown, k % 251, 1);
        put(head, version, 4);
        put(head, 100, 4);
        put(head, number, 8);
        put(head, static_cast<std::uint64_t>(time_ns), 8);
        put(head, width, 4);
        put(head, height, 4);
        for (const double value : {unit, fx, fy, cx, cy}) put(head, std::bit_cast<std::uint64_t>(value), 8);
        for (const std::uint32_t value : {colour_width, colour_height, flags, plain_crc32(shown)})
            put(head, value, 4);
        put(head, plain_crc32(head), 4);
        return head + shown;
    }
};

// A program that sends framesets, as a camera: a command, or a connection on this machine. What is waited for
// is a frameset or an end; no test depends on a deadline.

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

/// Listens on a free port, sends to the camera that connects.
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
    /// A running camera: framesets up to 9 were given, and 10 is next.
    std::unique_ptr<ClipReader> running() {
        auto camera = must(open(all_sent(0, 10)));
        for (int n = 0; n < 2; ++n) EXPECT_EQ(next_of(*camera).number, n);
        EXPECT_EQ(message(camera->begin(std::chrono::steady_clock::now() - std::chrono::seconds(1))), "");
        return camera;
    }

    FramesetChoice choice;

private:
    const Descriptor listens_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    Descriptor to_;
};

/// Which frameset a frame is of, as its first pixel tells.
std::uint64_t shown_by(const RawFrame& frame) {
    for (std::uint64_t k = 0; k < 57; ++k)
        if (frame.depth.data && frame.depth.sample(0, 0) == sent(k).depth(0, 0)) return k;
    return 1000;
}

TEST(FramesetCamera, GivesSentFramesets) {
    Listener sender;
    const auto camera = sender.running();
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

// From 0.1 to 1000 a second; 30 where the sender's times say less, more or nothing.
TEST(FramesetCamera, TakesRateFromTimes) {
    for (const auto& [apart_ns, rate] : {std::pair<std::int64_t, double>{1'000'000, 1000},
                                         {999'999, 30},
                                         {10'000'000'000, 0.1},
                                         {10'000'000'001, 30},
                                         {0, 30}}) {
        std::string all;
        for (std::int64_t k = 0; k < 8; ++k) {
            FramesetBytes each = sent(static_cast<std::uint64_t>(k));
            each.time_ns = k * apart_ns;
            all += each.bytes();
        }
        Listener sender;
        EXPECT_EQ(must(sender.open(all))->scene().rate.per_second(), rate) << apart_ns;
    }
}

TEST(FramesetCamera, ShowsOnlyWholeFramesets) {
    Listener sender;
    const auto camera = sender.running();
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
    EXPECT_TRUE(has_words(remarks[0], "of the camera's frames were damaged or cut short"));
    EXPECT_TRUE(has_words(remarks[1], "2 of the camera's frames came twice"));
}

TEST(FramesetCamera, RemarksOnClosedConnection) {
    Listener sender;
    const auto camera = sender.running();
    sender.send(sent(10).bytes() + sent(11).bytes().substr(0, 150));
    sender.hang_up();
    EXPECT_EQ(shown_by(next_of(*camera)), 10U);
    for (int again = 0; again < 3; ++again) {
        const auto end = must(camera->next());
        EXPECT_FALSE(end);
    }
    const auto remarks = camera->remarks();
    ASSERT_EQ(remarks.size(), 1U);
    EXPECT_TRUE(has_words(remarks[0], "the camera, tcp://127.0.0.1:"));
    EXPECT_TRUE(has_words(remarks[0], ", closed the connection after "));
    EXPECT_TRUE(has_words(remarks[0], "; its last frame stands still"));
}

TEST(FramesetCamera, EndsWhenLensChanges) {
    Listener sender;
    const auto camera = sender.running();
    FramesetBytes other = sent(10);
    other.fx = 9;
    sender.send(other.bytes());
    const auto end = must(camera->next());
    EXPECT_FALSE(end);
    EXPECT_TRUE(has_words(camera->remarks()[0],
                          "with fx 9, fy 7.5, cx 3.5, cy 2.5 and colour of 4x3 where it gave "));
}

TEST(FramesetCamera, StopsWaitingOnRequest) {
    Listener sender;
    const auto camera = sender.running();
    sender.send(sent(10).bytes().substr(0, 90));
    std::stop_source given_up;
    auto waits = std::async(std::launch::async,
                            [&] { return work_until(given_up.get_token(), [&] { return camera->next(); }); });
    given_up.request_stop();
    EXPECT_TRUE(is_refused(waits.get(), "", ErrorKind::interrupted));
    // Another run goes on with the same connection.
    EXPECT_EQ(message(camera->begin(std::chrono::steady_clock::now() - std::chrono::seconds(1))), "");
    sender.send(sent(10).bytes().substr(90));
    EXPECT_EQ(shown_by(next_of(*camera)), 10U);
}

TEST(FramesetCamera, StopsOpeningOnRequest) {
    for (const bool pipe : {false, true}) {
        Listener sender;
        if (pipe) sender.choice = {.command = "exec sleep 1000"};
        std::stop_source given_up;
        auto opening = std::async(std::launch::async, [&] {
            const StopScope until(given_up.get_token());
            return open_frameset_camera(sender.choice);
        });
        given_up.request_stop();
        EXPECT_TRUE(is_refused(opening.get(), "", ErrorKind::interrupted));
    }
}

TEST(FramesetCamera, SaysWhyOpeningFails) {
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
        {garbage, "sent 256 MiB without a whole frameset"},
        {silent, "pipe:exec sleep 1000: sent nothing in 50 ms"},
        {cut, ": sent no whole frameset in 50 ms"},
        {{.address = "127.0.0.1:1"}, "tcp://127.0.0.1:1: no connection: "},
        {{.address = "example.org:7000"}, "must be an address in numbers or localhost, and a port"}};
    for (const auto& [choice, says] : cases) {
        const auto opened = open_frameset_camera(choice);
        EXPECT_TRUE(is_refused(opened, says));
        EXPECT_EQ(message(opened).find('\n'), std::string::npos) << message(opened);
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

TEST(FramesetCamera, EndsCommandAndChildren) {
    const TemporaryFolder folder;
    const std::string frames = folder / "frames", child = folder / "child";
    std::ofstream(frames, std::ios::binary) << all_sent(0, 8);
    for (const std::string trap : {"", "trap '' TERM; "}) {
        std::filesystem::remove(child);
        FramesetChoice choice;
        choice.command = trap + "sleep 1000 & echo $! $$ >" + child + "; cat " + frames + "; wait";
        auto camera = must(open_frameset_camera(choice));
        ::pid_t sleeper = 0, shell = 0;
        std::ifstream(child) >> sleeper >> shell;
        ASSERT_GT(sleeper, 1);
        EXPECT_TRUE(is_alive(sleeper));
        EXPECT_NE(::getpgid(sleeper), ::getpgrp()) << "Ctrl-C on a terminal is for the program";
        camera.reset();
        for (int looks = 0; looks < 10'000 && is_alive(sleeper); ++looks)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        EXPECT_FALSE(is_alive(sleeper)) << trap;
        EXPECT_FALSE(is_alive(shell)) << trap;
        EXPECT_FALSE(std::filesystem::exists("/proc/" + std::to_string(shell))) << "it is waited for";
    }
}

TEST(FramesetCamera, IsolatesItsCommand) {
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

TEST(FramesetCamera, ChecksAddresses) {
    for (const char* right : {"127.0.0.1:7000", "localhost:1", "[::1]:65535", "192.168.0.5:80"})
        EXPECT_EQ(message(check_address(right)), "") << right;
    for (const char* wrong :
         {"", ":", "127.0.0.1", "127.0.0.1:", ":7000", "127.0.0.1:0", "127.0.0.1:65536", "127.0.0.1:7x",
          "127.0.0.1:-1", "name:7000", "127.0.0.1:99999999999999999999"}) {
        EXPECT_TRUE(is_refused(check_address(wrong), "", ErrorKind::usage)) << wrong;
    }
}

// Framesets found in bytes that are whole, cut, damaged, or none.

void give(FramesetParser& parser, const std::string& bytes) {
    parser.take({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

/// Numbers of the framesets that are found, each of which has to be as it was written.
std::vector<std::uint64_t> found_in(FramesetParser& parser) {
    std::vector<std::uint64_t> numbers;
    while (true) {
        const auto found = parser.next();
        EXPECT_TRUE(found) << found.error().message;
        if (!found || !*found) return numbers;
        const FramesetHeader& header = (*found)->header;
        const FramesetBytes written = sent(header.number);
        EXPECT_EQ(header.time_ns, written.time_ns);
        const PlaneView depth = (*found)->depth();
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 8; ++x)
                EXPECT_EQ(depth.sample(x, y),
                          written.depth(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)));
        numbers.push_back(header.number);
    }
}

using Numbers = std::vector<std::uint64_t>;

TEST(FramesetParser, ReadsPiecesOfAnySize) {
    const std::string all = all_sent(3, 9);
    for (std::size_t piece = 1; piece < all.size(); piece += piece < 20 ? 1 : 37) {
        FramesetParser parser;
        Numbers numbers;
        for (std::size_t at = 0; at < all.size(); at += piece) {
            give(parser, all.substr(at, piece));
            for (const std::uint64_t number : found_in(parser)) numbers.push_back(number);
        }
        EXPECT_EQ(numbers, (Numbers{3, 4, 5, 6, 7, 8})) << piece;
        EXPECT_EQ(parser.damaged(), 0);
    }
}

TEST(FramesetParser, ReadsHeaderAndColour) {
    FramesetBytes written = sent(77);
    written.colour_width = 5;
    written.colour_height = 3;
    written.flags = 0;
    written.time_ns = -5;
    FramesetParser parser;
    give(parser, written.bytes());
    const auto found = parser.next();
    ASSERT_TRUE(found && *found);
    const FramesetHeader& header = (*found)->header;
    EXPECT_EQ(header.number, 77U);
    EXPECT_EQ(header.time_ns, -5);
    EXPECT_EQ(header.metres_per_unit, 0.001);
    EXPECT_EQ(header.fx, 7);
    EXPECT_EQ(header.fy, 7.5);
    EXPECT_EQ(header.cx, 3.5);
    EXPECT_EQ(header.cy, 2.5);
    EXPECT_FALSE(header.colour_is_registered);
    const PlaneView colour = (*found)->colour();
    ASSERT_EQ(colour.width, 5);
    ASSERT_EQ(colour.height, 3);
    EXPECT_EQ(colour.sample(4, 2, 2), 44);
}

/// With any byte damaged, all other framesets are found, whole.
TEST(FramesetParser, SkipsDamagedFrameset) {
    const std::size_t length = sent(0).bytes().size();
    for (std::size_t at = 0; at < length; ++at) {
        std::string all = all_sent(0, 5);
        all[2 * length + at] = static_cast<char>(all[2 * length + at] ^ 0x41);
        FramesetParser parser;
        give(parser, all);
        EXPECT_EQ(found_in(parser), (Numbers{0, 1, 3, 4})) << at;
        EXPECT_EQ(parser.damaged(), 1) << at;
    }
}

TEST(FramesetParser, SkipsMissingAndSurplusBytes) {
    const std::size_t length = sent(0).bytes().size();
    for (std::size_t lost = 1; lost < length; ++lost)
        for (const std::size_t at : {std::size_t{0}, (length - lost) / 2, length - lost}) {
            std::string all = all_sent(0, 5);
            all.erase(2 * length + at, lost);
            FramesetParser parser;
            give(parser, all);
            EXPECT_EQ(found_in(parser), (Numbers{0, 1, 3, 4})) << lost << " at " << at;
            EXPECT_EQ(parser.damaged(), 1) << lost << " at " << at;
        }
    FramesetParser parser;
    give(parser, all_sent(0, 2) + "FRAMESFRAMESETFRAMES" + all_sent(2, 4));
    EXPECT_EQ(found_in(parser), (Numbers{0, 1, 2, 3}));
    EXPECT_EQ(parser.damaged(), 1);
}

TEST(FramesetParser, BeginsAnywhere) {
    const std::string all = all_sent(0, 4);
    const std::size_t length = all.size() / 4;
    for (std::size_t from = 1; from <= length; ++from) {
        FramesetParser parser;
        give(parser, all.substr(from));
        EXPECT_EQ(found_in(parser), (Numbers{1, 2, 3})) << from;
        EXPECT_EQ(parser.damaged(), 0) << from;
    }
}

TEST(FramesetParser, CountsRepeatedFramesets) {
    FramesetParser parser;
    give(parser, all_sent(0, 3) + all_sent(2, 5) + all_sent(4, 5) + all_sent(0, 1));
    EXPECT_EQ(found_in(parser), (Numbers{0, 1, 2, 3, 4, 0})) << "a count may begin anew";
    EXPECT_EQ(parser.repeated(), 2);
}

TEST(FramesetParser, RejectsInvalidHeaders) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinite = std::numeric_limits<double>::infinity();
    struct Case {
        void (*change)(FramesetBytes&, double);
        double value;
        const char* says;
    };
    for (const Case& wrong :
         std::vector<Case>{{[](auto&of, double) { of.version = 2; }, 0, "framesets of version 2"},
                           {[](auto&of, double) { of.width = 0; }, 0, "depth of 0x6 pixels"},
                           {[](auto&of, double) { of.colour_height = 0; }, 0, "colour of 4x0 pixels"},
                           {[](auto&of, double) { of.flags = 2; }, 0, "flags 2"},
                           {[](auto&of, double to) { of.unit = to; }, nan, "a unit of"},
                           {[](auto&of, double to) { of.unit = to; }, 0, "a unit of 0 m"},
                           {[](auto&of, double to) { of.unit = to; }, infinite, "a unit of inf m"},
                           {[](auto&of, double to) { of.fx = to; }, nan, "a lens with fx"},
                           {[](auto&of, double to) { of.fy = to; }, -7, "fy -7"},
                           {[](auto&of, double to) { of.cx = to; }, infinite, "cx inf"},
                           {[](auto&of, double to) { of.cy = to; }, 1e300, "cy 1e+300"}}) {
        FramesetBytes made = sent(0);
        wrong.change(made, wrong.value);
        FramesetParser parser;
        give(parser, made.bytes());
        for (int again = 0; again < 2; ++again) {
            const auto found = parser.next();
            EXPECT_TRUE(is_refused(found, wrong.says));
            EXPECT_EQ(message(found).find('\n'), std::string::npos);
        }
    }
    // A too large picture is refused by its header alone: no memory is asked for.
    std::string head = sent(0).bytes().substr(0, 96);
    head[34] = head[38] = 0x7f;
    put(head, plain_crc32(head), 4);
    FramesetParser parser;
    give(parser, head);
    EXPECT_TRUE(is_refused(parser.next(), "16777216 pixels at most"));
}

TEST(FramesetParser, EndsWhenFormatChanges) {
    for (void (*change)(FramesetBytes&) :
         {+[](FramesetBytes& of) { of.width = 6; }, +[](FramesetBytes& of) { of.height = 5; },
          +[](FramesetBytes& of) { of.unit = 0.002; }, +[](FramesetBytes& of) { of.fx = 8; },
          +[](FramesetBytes& of) { of.cy = 3; }, +[](FramesetBytes& of) { of.flags = 0; },
          +[](FramesetBytes& of) { of.colour_width = of.colour_height = 1; }}) {
        FramesetBytes other = sent(2);
        change(other);
        FramesetParser parser;
        give(parser, all_sent(0, 2) + other.bytes());
        ASSERT_TRUE(parser.next());
        ASSERT_TRUE(parser.next());
        EXPECT_TRUE(is_refused(parser.next(), "; a new run takes it as it is now"));
    }
}

TEST(FramesetParser, GivesUpOnEndlessGarbage) {
    FramesetParser parser;
    const std::string garbage(std::size_t{1} << 20U, 'F');
    bool is_given_up = false;
    for (int mebibytes = 0; mebibytes <= 257 && !is_given_up; ++mebibytes) {
        give(parser, garbage);
        const auto found = parser.next();
        is_given_up = !found;
        EXPECT_EQ(is_given_up, mebibytes > 255) << mebibytes;
        if (is_given_up) {
            EXPECT_TRUE(is_refused(found, "256 MiB without a whole frameset"));
        }
    }
    EXPECT_TRUE(is_given_up);
}

/// Headers that each promise megabytes, one in the other: each would be checked up to the end.
TEST(FramesetParser, BoundsWorkOfNestedHeaders) {
    FramesetBytes large = sent(1);
    large.width = large.height = 1024;
    large.fx = large.fy = 1000;
    const std::string head = large.bytes().substr(0, frameset_header_bytes);
    std::string all;
    while (all.size() < (std::size_t{8} << 20U)) all += head;
    FramesetParser parser;
    give(parser, all);  // 84,000 headers of 2 MiB each would be 170 GiB to check
    EXPECT_EQ(found_in(parser), Numbers());
    EXPECT_LT(parser.damaged(), 10);
    give(parser, all_sent(5, 7));
    EXPECT_EQ(found_in(parser), (Numbers{5, 6})) << "it goes on";
}

/// As a camera of framesets has it: no way longer than 0.1 s is believed, and none waits for others.
TEST(FramesetClock, FollowsClockWithoutItsJumps) {
    constexpr std::int64_t ms = 1'000'000, hour = 3'600'000 * ms;
    JitterBuffer clock(0, 100 * ms);
    // Taken every 10 ms, on the way for 2 ms or 7: the times are even.
    std::int64_t before = 0;
    for (int k = 1; k < 100; ++k) {
        const std::int64_t sent = 40 * hour + 10 * ms * k, arrived = 10 * ms * k + (k % 3 == 1 ? 2 : 7) * ms;
        const std::int64_t at = clock.add(sent, arrived).taken_ns;
        EXPECT_LE(at, arrived);
        EXPECT_NEAR(static_cast<double>(at), static_cast<double>(10 * ms * k + 2 * ms), 0.05 * ms);
        if (k > 1) {
            EXPECT_NEAR(static_cast<double>(at - before), 10.0 * ms, 0.05 * ms);
        }
        before = at;
    }
    // Set forward, set back, standing still, not there, absurd: its frames count from their arrival.
    std::int64_t arrived = 2000 * ms;
    const std::int64_t most = std::numeric_limits<std::int64_t>::max();
    for (const std::int64_t sent :
         {41 * hour, 2 * hour, 2 * hour, std::int64_t{0}, -hour, most, -most, hour}) {
        arrived += 10 * ms;
        EXPECT_EQ(clock.add(sent, arrived).taken_ns, arrived) << sent;
    }
    // A clock that runs a hundredth too slow is at most 0.1 s behind.
    for (int k = 1; k < 10'000; ++k) {
        const std::int64_t at = clock.add(hour + 9'900'000 * std::int64_t{k}, arrived + 10 * ms * k).taken_ns;
        EXPECT_LE(at, arrived + 10 * ms * k);
        EXPECT_GE(at, arrived + 10 * ms * k - 100 * ms);
    }
}

}  // namespace
}  // namespace touchable::test
