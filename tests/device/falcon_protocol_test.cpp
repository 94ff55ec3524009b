// Packets of the Novint Falcon, against letters written by hand from its owners' description.
#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <string>

#include "device/drivers/falcon_device.hpp"

namespace touchable::test {
namespace {

std::string sent(const FalconCommand& command) {
    std::string text;
    for (const std::byte byte : encode(command)) text += static_cast<char>(byte);
    return text;
}

std::optional<FalconReport> read(FalconReader& reader, const std::string& text) {
    std::optional<FalconReport> last;
    for (const char byte : text)
        if (const auto report = reader.take(static_cast<std::byte>(byte))) last = report;
    return last;
}

std::string with_state(const std::string& counts, int state) {
    return "<" + counts + static_cast<char>('A' + state) + "A>";
}

TEST(FalconProtocol, WordsAreFourLettersLowestFirst) {
    // B: the homing bit alone.
    EXPECT_EQ(sent({}), "<AAAAAAAAAAAABA>");
    EXPECT_EQ(sent({{1, 256, -1}, FalconLamp::none}), "<BAAAAABAPPPPBA>");
    EXPECT_EQ(sent({{0x7FFF, -32768, -1447}, FalconLamp::none}), "<PPPHAAAIJFKPBA>");
    EXPECT_EQ(sent({{4096, -4096, 0}, FalconLamp::green}), "<AAABAAAPAAAADA>");
    EXPECT_EQ(sent({{}, FalconLamp::blue}), "<AAAAAAAAAAAAFA>");
    EXPECT_EQ(sent({{}, FalconLamp::red}), "<AAAAAAAAAAAAJA>");
}

// JFKP, 0xFA59, is the example of the public description.
TEST(FalconProtocol, CountsAreReadWithTheirSign) {
    FalconReader reader;
    const auto report = read(reader, "<JFKPAAAIPPPHAA>");
    ASSERT_TRUE(report);
    EXPECT_EQ(report->counts, (std::array<std::int16_t, 3>{-1447, -32768, 32767}));
    EXPECT_EQ(report->buttons, 0);
    EXPECT_FALSE(report->homed);
    EXPECT_EQ(reader.damaged(), 0);
}

TEST(FalconProtocol, HomedIsAllThreeEncodersAndButtonsAreTheGripsFour) {
    for (int state = 0; state < 128; ++state) {
        FalconReader reader;
        const auto report = read(reader, with_state("AAAAAAAAAAAA", state));
        ASSERT_TRUE(report) << state;
        EXPECT_EQ(report->buttons, state % 16);
        EXPECT_EQ(report->homed, state / 16 == 7);
    }
}

// libnifalcon's users saw a packet of 14 bytes as homed and with buttons pressed.
TEST(FalconProtocol, AShortPacketIsNoReportAndCostsNoOther) {
    FalconReader reader;
    EXPECT_FALSE(read(reader, "<AAAAAAAAAAAA>"));
    EXPECT_FALSE(read(reader, "<BAAA"));
    const auto report = read(reader, "<CAAAAAAAAAAAAA>");
    ASSERT_TRUE(report);
    EXPECT_EQ(report->counts[0], 2);
    EXPECT_EQ(reader.damaged(), 2);
}

TEST(FalconProtocol, NoByteThatCannotStandWhereItIsIsBelieved) {
    for (std::size_t place = 0; place < 16; ++place)
        for (int wrong = 0; wrong < 256; ++wrong) {
            std::string packet = "<DAAAEAAAFAAAAA>";
            packet[place] = static_cast<char>(wrong);
            const bool letter = wrong >= 'A' && wrong <= 'P';
            const bool may = place == 0    ? wrong == '<'
                             : place == 15 ? wrong == '>'
                             : place == 13 ? wrong >= 'A' && wrong <= 'A' + 127
                             : place == 14 ? wrong >= 'A'
                                           : letter;
            FalconReader reader;
            EXPECT_EQ(read(reader, packet).has_value(), may) << place << " " << wrong;
            const auto next = read(reader, "<GAAAAAAAAAAAAA>");
            ASSERT_TRUE(next) << place << " " << wrong;
            EXPECT_EQ(next->counts[0], 6);
        }
}

TEST(FalconProtocol, ReportsAreFoundAmongNoise) {
    std::mt19937 random(4);
    FalconReader reader;
    for (int go = 0; go < 2000; ++go) {
        std::string noise;
        for (unsigned left = random() % 40; left > 0; --left) noise += static_cast<char>(random() % 256);
        read(reader, noise);
        const auto report = read(reader, "<HAAAAAAAAAAAAA>");
        ASSERT_TRUE(report) << go;
        EXPECT_EQ(report->counts[0], 7);
    }
}

TEST(Ftdi, CommandsAreAsItsChipsTakeThem) {
    using std::chrono::milliseconds;
    EXPECT_EQ(FtdiCommand::latency(milliseconds(16)), (FtdiCommand{9, 16}));
    EXPECT_EQ(FtdiCommand::divisor(0x4138), (FtdiCommand{3, 0x4138}));
    EXPECT_EQ(FtdiCommand::eight_bits(), (FtdiCommand{4, 8}));
    EXPECT_EQ(FtdiCommand::no_flow_control(), (FtdiCommand{2, 0}));
    EXPECT_EQ(FtdiCommand::dtr(true), (FtdiCommand{1, 0x0101}));
    EXPECT_EQ(FtdiCommand::dtr(false), (FtdiCommand{1, 0x0100}));
    EXPECT_EQ(FtdiCommand::rts(true), (FtdiCommand{1, 0x0202}));
    EXPECT_EQ(FtdiCommand::rts(false), (FtdiCommand{1, 0x0200}));
    EXPECT_EQ(FtdiCommand::purge_received(), (FtdiCommand{0, 1}));
    EXPECT_EQ(FtdiCommand::purge_to_send(), (FtdiCommand{0, 2}));
}

}  // namespace
}  // namespace touchable::test
