// Recordings whose files go on where they end: zeros that a recorder had asked for, or what is written still.
#include "engine/picture/input.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "engine/base/threads.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/sound.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/quicktime.hpp"
#include "tests/video/sounding_clip.hpp"

namespace touchable::test {
namespace {

constexpr std::uint64_t eight_gibibytes = std::uint64_t{8} << 30U;

/// A file of these bytes, and zeros up to 8 GiB. Knows how far it was read.
class ZeroTail final : public ByteSource {
public:
    explicit ZeroTail(std::string begin) : begin_(std::move(begin)) {}
    std::uint64_t size() const override { return eight_gibibytes; }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (at > size() || count > size() - at) return input_error("is cut short");
        std::memset(to, 0, count);
        if (at < begin_.size())
            std::memcpy(to, begin_.data() + at, std::min<std::uint64_t>(count, begin_.size() - at));
        ++reads_;
        farthest_ = std::max(farthest_, at + count);
        if (reads_ == stops_at_) request_stop();
        return {};
    }
    int reads() const { return reads_; }
    std::uint64_t farthest() const { return farthest_; }
    /// Somebody asks the program to stop while this is read for the n-th time.
    void stop_at(int reads) { stops_at_ = reads; }

private:
    std::string begin_;
    int reads_ = 0, stops_at_ = 0;
    std::uint64_t farthest_ = 0;
};

std::string clip_bytes(const TemporaryFolder& folder) {
    EXPECT_EQ(message(write_clip(folder / "whole.mkv", small_scene(40, 30), 3, {})), "");
    return read_bytes(folder / "whole.mkv");
}

std::string box(const std::string& type, std::size_t size) {
    std::string bytes(size, 'x');
    for (int k = 0; k < 4; ++k) bytes[static_cast<std::size_t>(k)] = static_cast<char>(size >> (24 - 8 * k));
    return bytes.replace(4, 4, type);
}
std::string chunk(const std::string& name, std::uint32_t size) {
    std::string bytes(8 + size, 'x');
    std::memcpy(bytes.data() + 4, &size, 4);
    return bytes.replace(0, 4, name);
}

TEST(ContainerEnd, ZerosBehindItAreNoneOfIt) {
    const TemporaryFolder folder;
    const std::string boxes = box("ftyp", 24) + box("mdat", 1000);
    const std::string chunks = chunk("RIFF", 500) + chunk("RIFF", 100);
    const std::string clip = clip_bytes(folder);
    ZeroTail quicktime(boxes), avi(chunks), matroska(clip);
    EXPECT_EQ(**end_of_boxes(quicktime), boxes.size());
    EXPECT_EQ(**end_of_riff(avi), chunks.size());
    EXPECT_EQ(check_matroska(matroska, "NAME")->at, clip.size());
    for (const ZeroTail* each : {&quicktime, &avi, &matroska}) {
        EXPECT_LT(each->reads(), 1000);
        EXPECT_LE(each->farthest(), 16 + std::max({boxes.size(), chunks.size(), clip.size()}));
    }
    ZeroTail again(clip), sound(chunks), nothing("");
    EXPECT_EQ(*end_of_container(again, "NAME"), clip.size());
    EXPECT_EQ(*end_of_container(sound, "NAME"), chunks.size());
    EXPECT_EQ(**end_of_boxes(nothing), eight_gibibytes) << "one box that goes to the end of the file";
}

TEST(ContainerEnd, IsNowhereInWhatIsCut) {
    const std::string boxes = box("ftyp", 24) + box("mdat", 1000),
                      chunks = chunk("RIFF", 500) + chunk("RIFF", 100);
    const auto of_boxes = [](const std::string& bytes) { return *end_of_boxes(*bytes_in_memory(bytes)); };
    const auto of_riff = [](const std::string& bytes) { return *end_of_riff(*bytes_in_memory(bytes)); };
    EXPECT_EQ(of_boxes(boxes), boxes.size());
    EXPECT_EQ(of_boxes(boxes + "{\"intrinsicMatrix\": []}"), boxes.size());
    EXPECT_EQ(of_boxes(boxes.substr(0, boxes.size() - 1)), std::nullopt);
    EXPECT_EQ(of_boxes(""), std::nullopt);
    EXPECT_EQ(of_riff(chunks), chunks.size());
    EXPECT_EQ(of_riff(chunks + "x"), chunks.size());
    EXPECT_EQ(of_riff(chunks.substr(0, chunks.size() - 1)), std::nullopt);
    EXPECT_EQ(of_riff(chunks.substr(0, 400)), std::nullopt);
    EXPECT_EQ(of_riff(chunk("RIFF", 0) + std::string(100, 'x')), std::nullopt);
    EXPECT_EQ(of_riff(""), std::nullopt);
}

/// All packets of the only stream.
Result<int> count_packets(Demuxer& demuxer) {
    demuxer.select(0);
    for (int packets = 0;; ++packets) {
        const auto packet = demuxer.next(0);
        if (!packet) return packet.error();
        if (!*packet) return packets;
    }
}

TEST(ContainerEnd, FfmpegSeesNothingBehindIt) {
    const TemporaryFolder folder;
    const std::string clip = clip_bytes(folder);
    auto source = std::make_unique<ZeroTail>(clip);
    const ZeroTail& file = *source;
    auto demuxer = Demuxer::open(std::move(source), clip.size(), "NAME", "matroska", "Matroska");
    ASSERT_EQ(message(demuxer), "");
    EXPECT_EQ(*count_packets(**demuxer), 3);
    EXPECT_EQ(file.farthest(), clip.size());
}

/// What FFmpeg looks for in zeros that are said to be the recording's: the first bytes of the next cluster.
[[noreturn]] void stop_among_zeros(const std::string& clip) {
    alarm(120);
    auto source = std::make_unique<ZeroTail>(clip);
    ZeroTail& file = *source;
    auto demuxer = Demuxer::open(std::move(source), eight_gibibytes, "NAME", "matroska", "Matroska");
    if (!demuxer) std::_Exit(2);
    file.stop_at(file.reads() + 20);
    const int allowed = file.reads() + 20;
    const auto packets = count_packets(**demuxer);
    if (packets || packets.error().kind != ErrorKind::interrupted) std::_Exit(3);
    std::_Exit(file.reads() == allowed ? 0 : 4);
}

TEST(ContainerEndDeathTest, FfmpegIsGivenNothingMoreOnceSomebodyAsksToStop) {
    const TemporaryFolder folder;
    const std::string clip = clip_bytes(folder);
    EXPECT_EXIT(stop_among_zeros(clip), ::testing::ExitedWithCode(0), "");
}

/// A disk that is gone in the middle of a recording, and somebody who does not want to wait for it.
class LostDisk final : public ByteSource {
public:
    LostDisk(std::string bytes, std::uint64_t lost_at) : bytes_(std::move(bytes)), lost_at_(lost_at) {}
    std::uint64_t size() const override { return bytes_.size(); }
    Result<void> read(std::uint64_t at, char* to, std::size_t count) override {
        if (at + count > lost_at_) return Error{ErrorKind::interrupted, "interrupted while it was read"};
        std::memcpy(to, bytes_.data() + at, count);
        return {};
    }

private:
    std::string bytes_;
    std::uint64_t lost_at_;
};

TEST(ContainerEnd, AnInterruptedReadIsNoFaultOfTheFile) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "large.mkv", small_scene(640, 480, 16), 3, {})), "");
    const std::string clip = read_bytes(folder / "large.mkv");
    auto demuxer = Demuxer::open(std::make_unique<LostDisk>(clip, clip.size() * 2 / 3), clip.size(), "NAME",
                                 "matroska", "Matroska");
    ASSERT_EQ(message(demuxer), "");
    const auto packets = count_packets(**demuxer);
    ASSERT_FALSE(packets);
    EXPECT_EQ(packets.error().kind, ErrorKind::interrupted);
    EXPECT_EQ(packets.error().message, "NAME: cannot be read further: interrupted while it was read");
    const auto never =
        Demuxer::open(std::make_unique<LostDisk>(clip, 0), clip.size(), "NAME", "matroska", "Matroska");
    ASSERT_FALSE(never);
    EXPECT_EQ(never.error().kind, ErrorKind::interrupted);
}

/// On a disk, through everything that opens a clip: pictures and sound end where they did.
TEST(ContainerEnd, AClipInALargerFileIsTheSameClip) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "silent.mkv", small_scene(40, 30), 3, {})), "");
    const auto heard = tone(440, 0.1);
    write_sounding_clip(folder / "clip.mkv", heard, folder / "silent.mkv");
    const auto before = read_clip(folder / "clip.mkv");
    ASSERT_EQ(message(before), "");
    std::filesystem::resize_file(folder / "clip.mkv", eight_gibibytes);
    alarm(120);  // looking through all of it takes minutes
    const auto after = read_clip(folder / "clip.mkv");
    ASSERT_EQ(message(after), "");
    ASSERT_EQ(after->size(), before->size());
    for (std::size_t k = 0; k < after->size(); ++k) EXPECT_TRUE(same_frame((*before)[k], (*after)[k]));
    auto sound = SoundTrack::open(folder / "clip.mkv");
    ASSERT_EQ(message(sound), "");
    ASSERT_TRUE(*sound);
    std::vector<StereoSample> samples(2 * heard.size());
    (*sound)->read(samples);
    EXPECT_NE(samples[heard.size() / 2].left, 0);
    EXPECT_EQ(samples.back().left, 0);
    auto stored = StoredSound::open({folder / "clip.mkv", 0, 1'000'000'000});
    ASSERT_EQ(message(stored), "");
    int packets = 0;
    for (auto packet = (*stored)->next(1000); packet && *packet; packet = (*stored)->next(1000)) ++packets;
    EXPECT_GT(packets, 0);
    alarm(0);
}

}  // namespace
}  // namespace touchable::test
