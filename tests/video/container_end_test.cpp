// SPDX-License-Identifier: Apache-2.0
// Recordings whose files go on where they end: zeros that a recorder had asked for, or what is written still.

#include "engine/base/threads.hpp"
#include "engine/clip/containers.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/input.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/video/remuxed_clip.hpp"

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
    /// The program is asked to stop while this is read for the n-th time.
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

TEST(ContainerEnd, ExcludesTrailingZeros) {
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

TEST(ContainerEnd, IsMissingWhereCut) {
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

TEST(ContainerEnd, HidesTheRestFromFfmpeg) {
    const TemporaryFolder folder;
    const std::string clip = clip_bytes(folder);
    auto source = std::make_unique<ZeroTail>(clip);
    const ZeroTail& file = *source;
    auto demuxer = must(Demuxer::open(std::move(source), clip.size(), "NAME", "matroska", "Matroska"));
    EXPECT_EQ(*count_packets(*demuxer), 3);
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

TEST(ContainerEndDeathTest, StopsFfmpegOnRequest) {
    const TemporaryFolder folder;
    const std::string clip = clip_bytes(folder);
    EXPECT_EXIT(stop_among_zeros(clip), ::testing::ExitedWithCode(0), "");
}

/// A disk that is gone in the middle of a recording; waiting for it is interrupted.
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

TEST(ContainerEnd, ReportsInterruptedReadAsSuch) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "large.mkv", small_scene(640, 480, 16), 3, {})), "");
    const std::string clip = read_bytes(folder / "large.mkv");
    auto demuxer = must(Demuxer::open(std::make_unique<LostDisk>(clip, clip.size() * 2 / 3), clip.size(),
                                      "NAME", "matroska", "Matroska"));
    const auto packets = count_packets(*demuxer);
    ASSERT_FALSE(packets);
    EXPECT_EQ(packets.error().kind, ErrorKind::interrupted);
    EXPECT_EQ(packets.error().message, "NAME: cannot be read further: interrupted while it was read");
    const auto never =
        Demuxer::open(std::make_unique<LostDisk>(clip, 0), clip.size(), "NAME", "matroska", "Matroska");
    EXPECT_TRUE(is_refused(never, "", ErrorKind::interrupted));
}

/// On a disk, through everything that opens a clip: pictures and sound end where they did.
TEST(ContainerEnd, ReadsClipInLargerFile) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "silent.mkv", small_scene(40, 30), 3, {})), "");
    const auto heard = tone(440, 0.1);
    write_sounding_clip(folder / "clip.mkv", heard, folder / "silent.mkv");
    const auto before = must(read_clip(folder / "clip.mkv"));
    std::filesystem::resize_file(folder / "clip.mkv", eight_gibibytes);
    alarm(120);  // looking through all of it takes minutes
    const auto after = must(read_clip(folder / "clip.mkv"));
    ASSERT_EQ(after.size(), before.size());
    for (std::size_t k = 0; k < after.size(); ++k) EXPECT_TRUE(same_frame(before[k], after[k]));
    auto sound = must(SoundTrack::open(folder / "clip.mkv"));
    ASSERT_TRUE(sound);
    std::vector<StereoSample> samples(2 * heard.size());
    sound->read(samples);
    EXPECT_NE(samples[heard.size() / 2].left, 0);
    EXPECT_EQ(samples.back().left, 0);
    auto stored = must(StoredSound::open({folder / "clip.mkv", 0, 1'000'000'000}));
    int packets = 0;
    for (auto packet = stored->next(1000); packet && *packet; packet = stored->next(1000)) ++packets;
    EXPECT_GT(packets, 0);
    alarm(0);
}

// Clips whose disk becomes full: a writer that stops when that is said has a whole one.

namespace fs = std::filesystem;

TEST(ReservedOutput, KeepsClipOnFullDisk) {
    struct Case {
        const char* name;
        std::uintmax_t room;
        ClipStorage storage;
    };
    for (const auto& [name, room, storage] :
         {Case{"clip.mkv", 600'000, {}}, Case{"clip.mp4", 600'000, {}},
          Case{"fragments.mp4", 1'500'000, {Archive::fast, true, false, true}}}) {
        const TemporaryFolder folder;
        const Scene scene = small_scene(64, 48, 16);
        int written = 0;
        {
            const FullDisk full(room);
            const auto clip = must(create_clip(folder / name, scene, storage));
            while (!clip->is_full()) {
                ASSERT_EQ(message(clip->write(test_frame(scene, written, {}))), "") << written;
                ASSERT_LT(++written, 1000) << "the disk is larger than it is";
            }
            ASSERT_EQ(message(clip->finish()), "");
        }
        EXPECT_LE(fs::file_size(folder / name), room);
        EXPECT_GT(fs::file_size(folder / name), room / 2) << "most of the room is for pictures";
        EXPECT_TRUE(same_frames(must(read_clip(folder / name)), test_frames(scene, written, {})));
    }
}

TEST(ReservedOutput, ReturnsUnusedSpace) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(8, 8);
    const auto clip = create_clip(folder / "clip.mkv", scene);
    ASSERT_TRUE(clip);
    ASSERT_TRUE((*clip)->write(test_frame(scene, 0, {})));
    EXPECT_FALSE((*clip)->is_full());
    ASSERT_TRUE((*clip)->finish());
    EXPECT_LT(fs::file_size(folder / "clip.mkv"), 4096U) << "what was reserved is given back";
}

// A clip read from any frame gives what reading up to there gives.

constexpr int seek_frames = 40;

/// Reads two frames from each of many places, in an order that goes to and fro; the last place is the end.
void expect_same_from_everywhere(const std::filesystem::path& file) {
    auto reader = must(open_clip(file));
    const auto whole = must(read_all(*reader));
    ASSERT_EQ(whole.size(), static_cast<std::size_t>(seek_frames));
    for (const int from : {7, 0, 1, 14, 15, 39, 16, 30, 29, 31, 3, 38}) expect_seek_to(*reader, from, whole);
    ASSERT_EQ(message(reader->next()), "");
    EXPECT_FALSE(reader->next()->has_value());  // after 38 and 39 the end
}

struct Seek : ::testing::Test {
    const TemporaryFolder folder;
};

TEST_F(Seek, IsExactInBothArchives) {
    for (const Archive archive : {Archive::fast, Archive::small})
        for (const int width : {40, 320}) {  // on the caller's thread, and on one for each track
            const auto file = folder / "clip.mkv";
            ASSERT_EQ(message(write_clip(file, small_scene(width, 160, 16), seek_frames,
                                         {true, true, true, false}, {archive, true})),
                      "");
            expect_same_from_everywhere(file);
        }
}

TEST_F(Seek, IsExactAtRoundedRates) {
    for (const FrameRate& rate : {FrameRate{30000, 1001}, {997, 1}, {1, 7}}) {
        Scene scene = small_scene(16, 16, 10);
        scene.rate = rate;
        ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, seek_frames, all_planes)), "");
        expect_same_from_everywhere(folder / "clip.mkv");
    }
}

TEST_F(Seek, IsExactWithOwnTimes) {
    const auto times_ns = uneven_times(seek_frames);
    Scene scene = small_scene(16, 16, 10);
    scene.rate = *rate_of_own_times(times_ns);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, seek_frames, all_planes)), "");
    expect_same_from_everywhere(folder / "clip.mkv");
    auto reader = must(open_clip(folder / "clip.mkv"));
    EXPECT_EQ(*reader->scene().rate.own_times, times_ns);
    EXPECT_EQ(reader->frame_count(), seek_frames);
    EXPECT_EQ(read_all(*reader)->back().time_ns, times_ns.back());
}

/// As the first version of the format had it: every picture on its own, no additions.
TEST_F(Seek, IsExactWithoutAccessPoints) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), seek_frames, {true})), "");
    remux(folder / "clip.mkv", folder / "mjpeg.mkv",
          {.transcoded = {{"depth", "mjpeg"}, {"colour", "mjpeg"}}});
    expect_same_from_everywhere(folder / "mjpeg.mkv");
}

/// The index becomes an element that readers pass over.
std::string without_index(std::string bytes) {
    const auto cues = bytes.rfind("\x1C\x53\xBB\x6B");
    EXPECT_NE(cues, std::string::npos);
    const std::size_t rest = bytes.size() - cues;  // the index is the file's end
    constexpr std::size_t head = 9;                // an identifier of one byte and a size of eight
    bytes[cues] = '\xEC';
    bytes[cues + 1] = '\x01';
    for (std::size_t k = 0; k < 7; ++k)
        bytes[cues + 2 + k] = static_cast<char>((rest - head) >> (8 * (6 - k)) & 0xFF);
    return bytes;
}

TEST_F(Seek, NeedsNoIndex) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30, 16), seek_frames, all_planes)), "");
    write_bytes(folder / "bare.mkv", without_index(read_bytes(folder / "clip.mkv")));
    expect_same_from_everywhere(folder / "bare.mkv");
}

TEST_F(Seek, RejectsFramesBeyondTheClip) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(16, 16), 20, all_planes)), "");
    auto reader = must(open_clip(folder / "clip.mkv"));
    EXPECT_TRUE(is_refused(reader->seek(21), "has no frame 21: its last is 19"));
    EXPECT_TRUE(is_refused(reader->seek(-1), "frame -1 is before the clip's first"));
    ASSERT_EQ(message(reader->seek(19)), "");
    EXPECT_EQ((*reader->next())->number, 19);
}

/// Damage before the place, or far behind it, does not matter; damage at the place is reported.
TEST_F(Seek, SkipsDamageElsewhere) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(64, 48), seek_frames, {})), "");
    const auto payloads = packets(folder / "clip.mkv");
    std::string bytes = read_bytes(folder / "clip.mkv");
    const auto at = bytes.find(payloads[20]);
    ASSERT_NE(at, std::string::npos);
    bytes[at + payloads[20].size() / 2] ^= 0x10;
    write_bytes(folder / "damaged.mkv", bytes);
    auto reader = must(open_clip(folder / "damaged.mkv"));
    for (const std::int64_t whole : {19, 30, 2, 39}) {
        ASSERT_EQ(message(reader->seek(whole)), "") << whole;
        EXPECT_EQ((*reader->next())->number, whole);
    }
    EXPECT_TRUE(is_refused(reader->seek(25), "track depth, frame 20: is damaged"));
    EXPECT_EQ(message(reader->seek(5)), "");
}

TEST(FrameTimesText, RoundTripsToTheNanosecond) {
    const std::vector<std::int64_t> times_ns{0, 1'000'000, 33'366'667, 4'000'000'000'000'001};
    const std::string text = frame_times_text(*rate_of_own_times(times_ns));
    EXPECT_EQ(text, "# timestamp format v2\n0.000000\n1.000000\n33.366667\n4000000000.000001\n");
    const auto back = must(parse_frame_times(text, "x"));
    EXPECT_EQ(*back.own_times, times_ns);
}

TEST(FrameTimesText, ReadsFilesOfOtherPrograms) {
    const auto rate =
        must(parse_frame_times("# timecode format v2\r\n40\r\n\r\n# cut here\r\n80.5\r\n100", "x"));
    EXPECT_EQ(*rate.own_times, (std::vector<std::int64_t>{0, 40'500'000, 60'000'000}));
}

TEST(FrameTimesText, NamesFaultyLine) {
    const std::string head = "# timestamp format v2\n";
    const std::pair<std::string, const char*> bad[] = {
        {"", "must be a line \"# timestamp format v2\""},
        {"# timestamp format v1\n1\n2\n", "must be a line"},
        {head, "of 0 frames"},
        {head + "1\n", "of 1 frames"},
        {head + "1\nx\n", "x.txt, line 3: is \"x\": must be the time of a frame"},
        {head + "1 2\n3\n", "line 2"},
        {head + "1\nnan\n", "line 3"},
        {head + "1\n1e300\n", "line 3"},
        {head + "1\n1.5\n", "line 3: is \"1.5\": must be 1 ms or more after"},
        {head + "2\n1\n", "line 3"},
        {head + "-4e12\n4e12\n", "126 years"},
    };
    for (const auto& [text, words] : bad)
        EXPECT_TRUE(is_refused(parse_frame_times(text, "x.txt"), words))
            << text << message(parse_frame_times(text, "x.txt"));
}

/// A clip of `frames` frames with the times of `listed`, 40 ms apart.
std::string refusal_with_times(int listed, int frames) {
    const TemporaryFolder folder;
    std::vector<std::int64_t> times_ns;
    for (int n = 0; n < listed; ++n) times_ns.push_back(40'000'000L * n + (n % 2) * 3'000'000L);
    Scene scene = small_scene(16, 16, 10);
    scene.rate = *rate_of_own_times(times_ns);
    if (auto written = write_clip(folder / "clip.mkv", scene, frames, {}); !written) return message(written);
    const auto reader = open_clip(folder / "clip.mkv");
    return message(reader);
}

TEST(FrameTimesText, NeedsOneTimePerPicture) {
    EXPECT_EQ(refusal_with_times(10, 10), "");
    for (const auto& [listed, words] :
         {std::pair{
              4, "its timestamps.txt has the times of 4 frames, but depth has 10 pictures: must be one time"},
          {9, "the times of 9 frames, but depth has 10 pictures"},
          {13, "the times of 13 frames, but depth has 10 pictures"}})
        EXPECT_TRUE(has_words(refusal_with_times(listed, 10), words));
}

}  // namespace
}  // namespace touchable::test
