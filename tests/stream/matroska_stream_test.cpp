// SPDX-License-Identifier: Apache-2.0
#include "engine/clip/containers.hpp"
#include "engine/stream/stream_pictures.hpp"
#include "tests/limits.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/sweep.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

constexpr Planes touch_planes{false, true, true, false}, seen_planes{true, true, true, false};

/// A key every 4 frames.
StreamOfFrames saved_stream(const Scene& scene, int frames, const Planes& planes,
                            const std::vector<std::int64_t>& times = {}) {
    return stream_by(open_matroska_stream(scene), scene, frames, planes, {.keys_apart = 4, .times = times});
}

/// A stream in memory.
class HeldBytes final : public StreamBytes {
public:
    explicit HeldBytes(std::string bytes)
        : StreamBytes(std::make_shared<StreamWait>()), bytes_(std::move(bytes)) {}

private:
    std::int64_t some(std::uint8_t* to, std::size_t count) override {
        const std::size_t got = bytes_.copy(reinterpret_cast<char*>(to), count, at_);
        at_ += got;
        return static_cast<std::int64_t>(got);
    }
    const std::string bytes_;
    std::size_t at_ = 0;
};

/// How many of its pictures are torn; how many came of each plane.
struct CameOf {
    std::int64_t torn = 0;
    std::map<PlaneRole, int> pictures;
};
CameOf all_that_came(const std::string& bytes) {
    CameOf all;
    const auto pictures =
        must(open_matroska_pictures(std::make_shared<HeldBytes>(bytes), "held", std::nullopt));
    while (const auto came = must(pictures->next())) {
        all.torn += came->torn;
        for (const StreamPicture& picture : came->pictures) ++all.pictures[picture.role];
    }
    return all;
}

struct MatroskaStream : ::testing::Test {
    const TemporaryFolder folder;
};

TEST_F(MatroskaStream, RejectsTooLargePictures) {
    std::string bytes = saved_stream(small_scene(300, 300, 12), 1, touch_planes).bytes(0);
    const std::string width("\xb0\x82\x01\x2c", 4), height("\xba\x82\x01\x2c", 4);  // 300
    for (const std::string& what : {width, height}) {
        const auto at = bytes.find(what);
        ASSERT_NE(at, std::string::npos);
        bytes.replace(at + 2, 2, what == width ? std::string("\x10\x01", 2) : std::string("\x10\x00", 2));
    }
    const auto pictures = open_matroska_pictures(std::make_shared<HeldBytes>(bytes), "held", std::nullopt);
    EXPECT_TRUE(is_refused(pictures, "4097x4096: a stream's have at most 16777216 pixels"));
}

TEST_F(MatroskaStream, DamagedColourTearsNoFrameset) {
    const auto saved = saved_stream(small_scene(48, 32, 12), 2, seen_planes);
    const std::string bytes = saved.bytes(0);
    int colour_lost = 0, touch_torn = 0;
    for (std::size_t at = saved.header.size() + 60; at < bytes.size() - 8; at += 97) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ 16);
        CameOf all = all_that_came(damaged);
        const bool has_all_touch = all.pictures[PlaneRole::depth] == 2 &&
                                   all.pictures[PlaneRole::haptic] == 2 &&
                                   all.pictures[PlaneRole::height] == 2;
        colour_lost += has_all_touch && all.pictures[PlaneRole::colour] < 2;
        touch_torn += !has_all_touch && all.torn > 0;
        EXPECT_TRUE(!has_all_touch || all.torn == 0) << at;
    }
    EXPECT_GT(colour_lost, 3);
    EXPECT_GT(touch_torn, 3);
}

TEST_F(MatroskaStream, SavesAsExactClip) {
    for (const int bits : {8, 12, 16})
        for (const Planes& planes : {Planes{false, false, false, true}, touch_planes}) {
            const Scene scene = small_scene(53, 37, bits);
            const auto saved = saved_stream(scene, 9, planes);
            write_bytes(folder / "saved.mkv", saved.bytes(0));
            auto reader = must(open_clip(folder / "saved.mkv"));
            EXPECT_EQ(reader->frame_count(), 9);
            EXPECT_EQ(reader->scene().depth, scene.depth);
            EXPECT_EQ(reader->scene().rate.own_times, nullptr);
            EXPECT_TRUE(same_frames(must(read_all(*reader)), saved.frames)) << bits << " bits";
        }
}

TEST_F(MatroskaStream, StartsAtAnyKey) {
    const Scene scene = small_scene(32, 24, 16);
    const auto saved = saved_stream(scene, 10, seen_planes);
    write_bytes(folder / "late.mkv", saved.bytes(4));
    const auto read = must(read_clip(folder / "late.mkv"));
    ASSERT_EQ(read.size(), 6U);
    for (std::size_t n = 0; n < 6; ++n) {
        const RawFrame sent = test_frame(scene, static_cast<std::int64_t>(n) + 4, seen_planes);
        EXPECT_TRUE(same_touch_planes(read[n], sent)) << n;
        EXPECT_TRUE(same_form(read[n].colour, sent.colour));
    }
}

TEST_F(MatroskaStream, CutLeavesWholeFrames) {
    const Scene scene = small_scene(16, 12, 12);
    const auto saved = saved_stream(scene, 5, touch_planes);
    const std::string bytes = saved.bytes(0);
    std::size_t whole = saved.header.size();
    for (std::size_t n = 0; n < saved.blocks.size(); ++n) {
        const std::size_t next = whole + saved.blocks[n].size();
        for (const std::size_t at : {whole + 3, (whole + next) / 2, next - 1}) {
            write_bytes(folder / "cut.mkv", bytes.substr(0, at));
            auto reader = open_clip(folder / "cut.mkv");
            if (n == 0) {
                EXPECT_FALSE(reader);
                continue;
            }
            ASSERT_EQ(message(reader), "") << n;
            EXPECT_EQ((*reader)->frame_count(), static_cast<std::int64_t>(n));
            const auto notes = (*reader)->notes();
            EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
                return note.find("is cut") != std::string::npos ||
                       note.find("end at different frames") != std::string::npos;
            })) << n;
            const auto read = must(read_all(**reader));
            EXPECT_EQ(read.size(), n);
        }
        whole = next;
    }
}

TEST_F(MatroskaStream, KeepsTimesOfCamera) {
    const Scene scene = small_scene(16, 12, 12);
    const std::vector<std::int64_t> times{0, 31'000'000, 140'000'000, 155'000'000};
    write_bytes(folder / "camera.mkv", saved_stream(scene, 4, touch_planes, times).bytes(0));
    const auto read = must(read_clip(folder / "camera.mkv"));
    ASSERT_EQ(read.size(), 4U);
    for (std::size_t n = 0; n < 4; ++n) EXPECT_EQ(read[n].time_ns, times[n]);
}

TEST_F(MatroskaStream, LabelsEveryPicture) {
    const auto saved = saved_stream(small_scene(32, 24, 16), 6, seen_planes);
    write_bytes(folder / "saved.mkv", saved.bytes(0));
    const auto demuxer = must(Demuxer::open_matroska(folder / "saved.mkv", true));
    for (int stream = 0; stream < 4; ++stream) demuxer->select(stream);
    for (std::int64_t n = 0; n < 6; ++n)
        for (int stream = 0; stream < 4; ++stream) {
            const auto packet = must(demuxer->next(stream));
            ASSERT_TRUE(packet);
            const auto addition = block_addition_of(*packet);
            ASSERT_TRUE(addition && addition->label);
            EXPECT_TRUE(addition->sound);
            EXPECT_EQ(addition->frames, 1);
            EXPECT_EQ(*addition->label, stream_label(n));
            const bool is_key = (packet->flags & AV_PKT_FLAG_KEY) != 0;
            EXPECT_TRUE(is_key || n % 4 != 0) << "decoding of all planes begins with each key";
        }
}

// In a loop, from the beginning with each round.
TEST_F(MatroskaStream, CarriesSound) {
    const Scene scene = small_scene(16, 12);
    constexpr int frames = 15, rounds = 2;  // 0.5 s each
    ASSERT_EQ(message(write_clip(folder / "mute.mkv", scene, frames, {})), "");
    const auto sound = tone(20, 0.8);  // longer than the pictures
    write_sounding_clip(folder / "clip.mkv", sound, folder / "mute.mkv");
    auto muxer = must(open_matroska_stream(scene, SoundPart{folder / "clip.mkv", 0, 1'000'000'000}));
    std::string bytes;
    for (int n = 0; n < frames * rounds; ++n) {
        RawFrame frame = test_frame(scene, n % frames, {});
        frame.epoch = static_cast<std::uint64_t>(n / frames);
        const auto block = must(muxer->add(frame, stream_label(n), scene.rate.time_ns(n), n % frames == 0));
        if (n == 0) bytes.assign(muxer->header().begin(), muxer->header().end());
        bytes.append(block.bytes.begin(), block.bytes.end());
    }
    write_bytes(folder / "saved.mkv", bytes);
    const auto read = must(read_clip(folder / "saved.mkv"));
    EXPECT_EQ(std::ssize(read), frames * rounds);
    auto track = must(SoundTrack::open(folder / "saved.mkv"));
    ASSERT_TRUE(track);
    std::vector<StereoSample> heard(static_cast<std::size_t>(SoundTrack::rate));
    track->read(heard);
    constexpr std::size_t packet = SoundTrack::rate / 50;
    const std::size_t round = static_cast<std::size_t>(SoundTrack::rate) / rounds;
    for (std::size_t k = 0; k + packet < heard.size(); ++k) {
        if (k % round < packet || k % round + 2 * packet > round) continue;  // one packet over another
        ASSERT_NEAR(heard[k].left, sound[k % round].left, 2 * 3.15 * 20 * 0.001) << k;
    }
}

TEST_F(MatroskaStream, RejectsInvalidFrames) {
    const Scene scene = small_scene(16, 12, 12);
    auto muxer = must(open_matroska_stream(scene));
    EXPECT_TRUE(muxer->header().empty());
    ASSERT_EQ(message(muxer->add(test_frame(scene, 7, touch_planes), {}, 0, true)), "");
    EXPECT_FALSE(muxer->header().empty());
    const auto refusal = [](const Result<StreamMuxer::Block>& block) {
        return block ? std::nullopt : std::optional(block.error().kind);
    };
    // One plane fewer; a value that the scene does not allow; a size that no clip has.
    EXPECT_EQ(refusal(muxer->add(test_frame(scene, 8, {}), {}, 1, true)), ErrorKind::internal);
    const RawFrame wide = test_frame(small_scene(16, 12, 16), 8, {false, true, true, true});
    EXPECT_EQ(refusal(muxer->add(wide, {}, 1, true)), ErrorKind::input);
    EXPECT_FALSE(open_matroska_stream(small_scene(16400, 2)));
    EXPECT_FALSE(open_matroska_stream(scene, SoundPart{"/nowhere.wav", 0, 1}));
}

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

TEST(MatroskaGate, PassesStreamInAnyPieces) {
    const auto sent = make_stream(small_scene(64, 48, 16), 6, all_planes);
    const auto whole = must(through_the_gate(sent.bytes()));
    EXPECT_LE(whole.size(), sent.bytes().size() + 6 * 12);
    for (const std::size_t piece : {1U, 7U, 100U, 65'537U})
        EXPECT_EQ(*through_the_gate(sent.bytes(), piece), whole);
    EXPECT_EQ(*through_the_gate(whole), whole) << "nothing is left to change";
}

TEST(MatroskaGate, DropsElementsBetweenClusters) {
    const auto sent = make_stream(small_scene(64, 48, 16), 4, {});
    const std::string between = element("\x12\x54\xC3\x67", std::string(300'000, '\xEC')) +
                                element("\x16\x54\xAE\x6B", std::string(300'000, '\xAE')) +
                                element("\xEC", std::string(1'000, '\0'));
    std::string bytes = sent.header;
    for (const std::string& block : sent.blocks) bytes += block + between;
    EXPECT_EQ(*through_the_gate(bytes), *through_the_gate(sent.bytes()));
}

TEST(MatroskaGate, ResumesAtNextCluster) {
    const auto sent = make_stream(small_scene(64, 48, 16), 4, {});
    const std::string last =
        through_the_gate(sent.header + sent.blocks[3])->substr(through_the_gate(sent.header)->size());
    Random numbers(5);
    for (int round = 0; round < 200; ++round) {
        std::string harmed = sent.blocks[1] + sent.blocks[2];
        const auto at = static_cast<std::size_t>(numbers.below(static_cast<int>(harmed.size()) - 200));
        if (round % 3 == 0) harmed.erase(at, static_cast<std::size_t>(numbers.below(200)));
        if (round % 3 == 1)
            for (int k = 0; k < 20; ++k)
                harmed[at + static_cast<std::size_t>(k)] = static_cast<char>(numbers.below(256));
        if (round % 3 == 2)
            harmed.insert(at, std::string(static_cast<std::size_t>(numbers.below(300)), '\xff'));
        const auto passed =
            must(through_the_gate(sent.header + sent.blocks[0] + harmed + sent.blocks[3], 777));
        EXPECT_TRUE(passed.ends_with(last)) << round;
    }
}

/// FFmpeg would have made a track of 600 bytes of each of these.
TEST(MatroskaGate, RejectsExcessiveHeaders) {
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

TEST(MatroskaGate, DropsBlockWithManyAdditions) {
    std::string additions;
    for (int k = 0; k < 100'000; ++k) additions += "\xA6\x80";
    const std::string cluster_head("\x1F\x43\xB6\x75\x01\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xE7\x81\x00", 15);
    const std::string block = element("\xA1", "1234"), beside = element("\x75\xA1", additions);
    const auto passed = must(
        through_the_gate(ebml + open_segment_head + cluster_head + element("\xA0", block + beside) +
                         element("\xA0", block + block) + element("\xA0", beside) + element("\xA0", block)));
    EXPECT_EQ(passed, ebml + open_segment_head + cluster_head + element("\xA0", block));
}

constexpr int keys_apart = 5;

StreamOfFrames transport_stream(int frames, const Planes& planes) {
    auto stream = make_transport_stream(small_scene(64, 48, 16), frames, planes,
                                        {.keys_apart = keys_apart, .label = sent_label});
    EXPECT_EQ(stream.header, "");
    return stream;
}

TEST(MpegtsStream, BlocksAreWholePackets) {
    const auto stream = transport_stream(11, all_planes);
    for (const std::string& block : stream.blocks) {
        ASSERT_FALSE(block.empty());
        ASSERT_EQ(block.size() % 188, 0U);
        for (std::size_t at = 0; at < block.size(); at += 188) ASSERT_EQ(block[at], 0x47);
    }
}

TEST(MpegtsStream, DemuxesByFfmpegExactly) {
    const auto stream = transport_stream(11, {true, true, false, false});
    const auto all = demuxed(stream.bytes(0), "mpegts", stream.frames);
    EXPECT_EQ(all.tracks, 4);
    EXPECT_EQ(all.came.size(), 3U * 11U);
    EXPECT_EQ(all.damaged, 0);
}

TEST(MpegtsStream, BeginsAtAnyKeyBlock) {
    const auto stream = transport_stream(11, {true, true, false, false});
    const auto all = demuxed(stream.bytes(keys_apart), "mpegts", stream.frames);
    EXPECT_EQ(all.came.size(), 3U * 6U);
    for (const auto& [which, count] : all.came) EXPECT_GE(which.second, keys_apart);
    EXPECT_EQ(all.damaged, 0);
}

/// Packets are lost as by UDP: planes that come are those that were sent.
TEST(MpegtsStream, LossNeverChangesSamples) {
    const auto stream = transport_stream(20, {true, true, false, false});
    const std::string whole = stream.bytes(0);
    std::size_t fewest = 1000;
    for (std::uint64_t seed = 0; seed < 150; seed += sweep_step()) {
        Random numbers(seed);
        std::string damaged;
        for (std::size_t at = 0; at < whole.size(); at += 188)
            if (numbers.below(50) > 0) damaged += whole.substr(at, 188);
        fewest = std::min(fewest, demuxed(damaged, "mpegts", stream.frames).came.size());
    }
    EXPECT_LT(fewest, 40U);
}

}  // namespace
}  // namespace touchable::test
