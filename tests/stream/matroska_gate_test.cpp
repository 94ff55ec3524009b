#include "engine/stream/stream_pictures.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/picture/ffmpeg.hpp"
#include "tests/limited_memory.hpp"
#include "tests/stream/stream_of_frames.hpp"

namespace touchable::test {
namespace {

/// Bytes in pieces.
class BytesInPieces final : public Demuxer::ByteFlow {
public:
    BytesInPieces(std::string bytes, std::size_t piece) : bytes_(std::move(bytes)), piece_(piece) {}
    Result<std::size_t> read(std::uint8_t* to, std::size_t count) override {
        const std::size_t some = std::min({count, piece_, bytes_.size() - at_});
        std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), some, to);
        at_ += some;
        return some;
    }

private:
    const std::string bytes_;
    const std::size_t piece_;
    std::size_t at_ = 0;
};

Result<std::string> through_the_gate(const std::string& bytes, std::size_t piece = 1 << 20) {
    MatroskaGate gate(std::make_shared<BytesInPieces>(bytes, piece));
    std::string all;
    std::uint8_t some[1000];
    while (true) {
        const auto got = gate.read(some, sizeof some);
        if (!got) return got.error();
        if (*got == 0) return all;
        all.append(some, some + *got);
    }
}

std::string element(const std::string& id, const std::string& content) {
    std::string head = id + '\x08';
    for (int shift = 48; shift >= 0; shift -= 8) head += static_cast<char>(content.size() >> shift & 0xffU);
    head[id.size()] = '\x01';
    return head + content;
}
const std::string ebml = element("\x1A\x45\xDF\xA3", element("\x42\x82", "matroska")),
                  open_segment_head("\x18\x53\x80\x67\x01\xFF\xFF\xFF\xFF\xFF\xFF\xFF", 12);

TEST(MatroskaGate, WhatAStreamHasComesThroughInPiecesOfAnySize) {
    const auto sent = make_stream(small_scene(64, 48, 16), 6, all_planes);
    const auto whole = through_the_gate(sent.bytes());
    ASSERT_EQ(message(whole), "");
    EXPECT_LE(whole->size(), sent.bytes().size() + 6 * 12);
    for (const std::size_t piece : {1U, 7U, 100U, 65'537U})
        EXPECT_EQ(*through_the_gate(sent.bytes(), piece), *whole);
    EXPECT_EQ(*through_the_gate(*whole), *whole) << "nothing is left to change";
}

TEST(MatroskaGate, WhatIsBetweenClustersIsLeftOut) {
    const auto sent = make_stream(small_scene(64, 48, 16), 4, {});
    const std::string between = element("\x12\x54\xC3\x67", std::string(300'000, '\xEC')) +
                                element("\x16\x54\xAE\x6B", std::string(300'000, '\xAE')) +
                                element("\xEC", std::string(1'000, '\0'));
    std::string bytes = sent.header;
    for (const std::string& block : sent.blocks) bytes += block + between;
    EXPECT_EQ(*through_the_gate(bytes), *through_the_gate(sent.bytes()));
}

TEST(MatroskaGate, AfterDamageItGoesOnWithTheNextCluster) {
    const auto sent = make_stream(small_scene(64, 48, 16), 4, {});
    const std::string last =
        through_the_gate(sent.header + sent.blocks[3])->substr(through_the_gate(sent.header)->size());
    Numbers numbers(5);
    for (int round = 0; round < 200; ++round) {
        std::string harmed = sent.blocks[1] + sent.blocks[2];
        const auto at = static_cast<std::size_t>(numbers.below(static_cast<int>(harmed.size()) - 200));
        if (round % 3 == 0) harmed.erase(at, static_cast<std::size_t>(numbers.below(200)));
        if (round % 3 == 1)
            for (int k = 0; k < 20; ++k)
                harmed[at + static_cast<std::size_t>(k)] = static_cast<char>(numbers.below(256));
        if (round % 3 == 2)
            harmed.insert(at, std::string(static_cast<std::size_t>(numbers.below(300)), '\xff'));
        const auto passed = through_the_gate(sent.header + sent.blocks[0] + harmed + sent.blocks[3], 777);
        ASSERT_EQ(message(passed), "");
        EXPECT_TRUE(passed->ends_with(last)) << round;
    }
}

/// FFmpeg would have made a track of 600 bytes of each of these.
TEST(MatroskaGate, AMillionTracksAndWhatElseIsTooMuchIsRefused) {
    std::string tracks, tags, attachments;
    for (int k = 0; k < 1'000'000; ++k) tracks += "\xAE\x80";
    for (int k = 0; k < 50'000; ++k) tags += "\x73\x73\x80";
    for (int k = 0; k < 1'000'000; ++k) attachments += "\x61\xA7\x80";
    for (const std::string& part :
         {element("\x16\x54\xAE\x6B", tracks), element("\x16\x54\xAE\x6B", tracks.substr(0, 34)),
          element("\x12\x54\xC3\x67", tags), element("\x19\x41\xA4\x69", attachments),
          element("\x15\x49\xA9\x66", std::string(10'000, '\xEC')), std::string("\x16\x54\xAE\x6B\xFF"),
          std::string("\x16\x54\xAE\x6B\x08\xFF\xFF\xFF\xFE"), std::string(100, '\0')}) {
        const LimitedMemory limited(64);
        EXPECT_FALSE(through_the_gate(ebml + open_segment_head + part));
    }
    EXPECT_FALSE(through_the_gate("GET / HTTP/1.1\r\n\r\n"));
    EXPECT_FALSE(through_the_gate(open_segment_head));
    EXPECT_TRUE(through_the_gate("")->empty());
}

TEST(MatroskaGate, ABlockWithAThousandThingsBesideItIsLeftOut) {
    std::string additions;
    for (int k = 0; k < 100'000; ++k) additions += "\xA6\x80";
    const std::string cluster_head("\x1F\x43\xB6\x75\x01\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xE7\x81\x00", 15);
    const std::string block = element("\xA1", "1234"), beside = element("\x75\xA1", additions);
    const auto passed =
        through_the_gate(ebml + open_segment_head + cluster_head + element("\xA0", block + beside) +
                         element("\xA0", block + block) + element("\xA0", beside) + element("\xA0", block));
    ASSERT_EQ(message(passed), "");
    EXPECT_EQ(*passed, ebml + open_segment_head + cluster_head + element("\xA0", block));
}

}  // namespace
}  // namespace touchable::test
