// Framesets found in bytes that are whole, cut, damaged, or none.
#include "engine/camera/frameset_camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "engine/clip/readers.hpp"
#include "tests/camera/frameset_bytes.hpp"

namespace touchable::test {
namespace {

FramesetBytes numbered(std::uint64_t number) {
    FramesetBytes made;
    made.number = number;
    made.time_ns = static_cast<std::int64_t>(1000 * number);
    return made;
}

std::string several(std::uint64_t from, std::uint64_t to) {
    std::string all;
    for (std::uint64_t k = from; k < to; ++k) all += numbered(k).bytes();
    return all;
}

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
        const FramesetBytes written = numbered(header.number);
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

TEST(FramesetParser, ReadsWhatIsWrittenInPiecesOfAnySize) {
    const std::string all = several(3, 9);
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

TEST(FramesetParser, ReadsTheHeaderAndColour) {
    FramesetBytes written = numbered(77);
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

/// Whatever byte is damaged, what is shown is whole, and all others are found.
TEST(FramesetParser, GoesOnBehindEveryDamagedByte) {
    const std::size_t length = numbered(0).bytes().size();
    for (std::size_t at = 0; at < length; ++at) {
        std::string all = several(0, 5);
        all[2 * length + at] = static_cast<char>(all[2 * length + at] ^ 0x41);
        FramesetParser parser;
        give(parser, all);
        EXPECT_EQ(found_in(parser), (Numbers{0, 1, 3, 4})) << at;
        EXPECT_EQ(parser.damaged(), 1) << at;
    }
}

TEST(FramesetParser, GoesOnWhereBytesAreMissingOrTooMany) {
    const std::size_t length = numbered(0).bytes().size();
    for (std::size_t lost = 1; lost < length; ++lost)
        for (const std::size_t at : {std::size_t{0}, (length - lost) / 2, length - lost}) {
            std::string all = several(0, 5);
            all.erase(2 * length + at, lost);
            FramesetParser parser;
            give(parser, all);
            EXPECT_EQ(found_in(parser), (Numbers{0, 1, 3, 4})) << lost << " at " << at;
            EXPECT_EQ(parser.damaged(), 1) << lost << " at " << at;
        }
    FramesetParser parser;
    give(parser, several(0, 2) + "FRAMESFRAMESETFRAMES" + several(2, 4));
    EXPECT_EQ(found_in(parser), (Numbers{0, 1, 2, 3}));
    EXPECT_EQ(parser.damaged(), 1);
}

TEST(FramesetParser, BeginsAnywhere) {
    const std::string all = several(0, 4);
    const std::size_t length = all.size() / 4;
    for (std::size_t from = 1; from <= length; ++from) {
        FramesetParser parser;
        give(parser, all.substr(from));
        EXPECT_EQ(found_in(parser), (Numbers{1, 2, 3})) << from;
        EXPECT_EQ(parser.damaged(), 0) << from;
    }
}

TEST(FramesetParser, CountsThoseThatComeAgain) {
    FramesetParser parser;
    give(parser, several(0, 3) + several(2, 5) + several(4, 5) + several(0, 1));
    EXPECT_EQ(found_in(parser), (Numbers{0, 1, 2, 3, 4, 0})) << "a count may begin anew";
    EXPECT_EQ(parser.repeated(), 2);
}

TEST(FramesetParser, RefusesWhatIsNoFramesetInOneLine) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinite = std::numeric_limits<double>::infinity();
    struct Case {
        void (*change)(FramesetBytes&, double);
        double value;
        const char* says;
    };
    for (const Case& wrong :
         std::vector<Case>{{[](FramesetBytes&of, double) { of.version = 2; }, 0, "framesets of version 2"},
                           {[](FramesetBytes&of, double) { of.width = 0; }, 0, "depth of 0x6 pixels"},
                           {[](FramesetBytes&of, double) { of.colour_width = 2; }, 0, "colour of 2x0 pixels"},
                           {[](FramesetBytes&of, double) { of.flags = 2; }, 0, "flags 2"},
                           {[](FramesetBytes&of, double to) { of.unit = to; }, nan, "a unit of"},
                           {[](FramesetBytes&of, double to) { of.unit = to; }, 0, "a unit of 0 m"},
                           {[](FramesetBytes&of, double to) { of.unit = to; }, infinite, "a unit of inf m"},
                           {[](FramesetBytes&of, double to) { of.fx = to; }, nan, "a lens with fx"},
                           {[](FramesetBytes&of, double to) { of.fy = to; }, -7, "fy -7"},
                           {[](FramesetBytes&of, double to) { of.cx = to; }, infinite, "cx inf"},
                           {[](FramesetBytes&of, double to) { of.cy = to; }, 1e300, "cy 1e+300"}}) {
        FramesetBytes made = numbered(0);
        wrong.change(made, wrong.value);
        FramesetParser parser;
        give(parser, made.bytes());
        for (int again = 0; again < 2; ++again) {
            const auto found = parser.next();
            ASSERT_FALSE(found) << wrong.says;
            EXPECT_NE(found.error().message.find(wrong.says), std::string::npos) << found.error().message;
            EXPECT_EQ(found.error().message.find('\n'), std::string::npos);
        }
    }
    // Of a picture that would be too large the header is enough, and no memory is asked for.
    FramesetBytes huge = numbered(0);
    std::string head = huge.bytes().substr(0, 96);
    head[34] = head[38] = 0x7f;
    const std::uint32_t crc = plain_crc32(head);
    for (int byte = 0; byte < 4; ++byte) head += static_cast<char>(crc >> (8 * byte) & 0xff);
    FramesetParser parser;
    give(parser, head);
    const auto found = parser.next();
    ASSERT_FALSE(found);
    EXPECT_NE(found.error().message.find("16777216 pixels at most"), std::string::npos);
}

TEST(FramesetParser, EndsWhereTheMeaningChanges) {
    for (void (*change)(FramesetBytes&) :
         {+[](FramesetBytes& of) { of.width = 6; }, +[](FramesetBytes& of) { of.height = 5; },
          +[](FramesetBytes& of) { of.unit = 0.002; }, +[](FramesetBytes& of) { of.fx = 8; },
          +[](FramesetBytes& of) { of.cy = 3; }, +[](FramesetBytes& of) { of.flags = 0; },
          +[](FramesetBytes& of) { of.colour_width = of.colour_height = 1; }}) {
        FramesetBytes other = numbered(2);
        change(other);
        FramesetParser parser;
        give(parser, several(0, 2) + other.bytes());
        ASSERT_TRUE(parser.next());
        ASSERT_TRUE(parser.next());
        const auto found = parser.next();
        ASSERT_FALSE(found);
        EXPECT_NE(found.error().message.find("; a new run takes it as it is now"), std::string::npos)
            << found.error().message;
    }
}

TEST(FramesetParser, GivesUpWhatIsGarbageForEver) {
    FramesetParser parser;
    const std::string garbage(std::size_t{1} << 20U, 'F');
    bool is_given_up = false;
    for (int mebibytes = 0; mebibytes <= 257 && !is_given_up; ++mebibytes) {
        give(parser, garbage);
        const auto found = parser.next();
        is_given_up = !found;
        EXPECT_EQ(is_given_up, mebibytes > 255) << mebibytes;
        if (is_given_up) {
            EXPECT_NE(found.error().message.find("256 MiB in which no whole frameset is"), std::string::npos);
        }
    }
    EXPECT_TRUE(is_given_up);
}

/// Headers that each promise megabytes, one in the other: each would be checked up to the end.
TEST(FramesetParser, ManyHeadersInEachOtherDoNotKeepItBusy) {
    FramesetBytes large = numbered(1);
    large.width = large.height = 1024;
    large.fx = large.fy = 1000;
    const std::string head = large.bytes().substr(0, frameset_header_bytes);
    std::string all;
    while (all.size() < (std::size_t{8} << 20U)) all += head;
    FramesetParser parser;
    give(parser, all);  // 84,000 headers of 2 MiB each would be 170 GiB to check
    EXPECT_EQ(found_in(parser), Numbers());
    EXPECT_LT(parser.damaged(), 10);
    give(parser, several(5, 7));
    EXPECT_EQ(found_in(parser), (Numbers{5, 6})) << "it goes on";
}

/// As a camera of framesets has it: no way longer than 0.1 s is believed, and none waits for others.
TEST(FramesetClock, FollowsASendersClockAndNoneOfItsJumps) {
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
