// SPDX-License-Identifier: Apache-2.0
// Our MP4 files as others read them: by their boxes, and by FFmpeg alone.

#include <map>

#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/limits.hpp"
#include "tests/sweep.hpp"
#include "tests/video/mp4_boxes.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

constexpr int foreign_frames = 4;

/// A clip of 12 bits with all planes: tracks of colour, depth, haptic, height, and depth's low bits.
class Mp4File : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(message(write_clip(path, scene, foreign_frames, all_planes)), "");
        file = read_bytes(path);
    }
    TemporaryFolder folder;
    std::filesystem::path path = folder / "clip.mp4";
    Scene scene = small_scene(30, 23, 12);
    std::string file;
};

std::vector<std::string> types_of(const std::vector<FoundBox>& boxes) {
    std::vector<std::string> types;
    for (const FoundBox& box : boxes) types.push_back(box.type);
    return types;
}

TEST_F(Mp4File, OrdersBoxesAsMpeg4Systems) {
    const auto boxes = boxes_of(file);
    const auto types = types_of(boxes);
    EXPECT_EQ(types.front(), "ftyp");
    EXPECT_EQ(types.back(), "moov");
    EXPECT_EQ(std::count(types.begin(), types.end(), "mdat"), 2) << "pictures, and the scene";
    EXPECT_EQ(types[types.size() - 2], "mdat");
    const auto in_movie = boxes_between(file, boxes.back().content, boxes.back().end);
    ASSERT_GT(in_movie.size(), 2U);
    EXPECT_EQ(in_movie[0].type, "mvhd");
    EXPECT_EQ(in_movie[1].type, "iods");
    // The initial object descriptor: number 1, no profiles asked for, tracks 6 and 7.
    EXPECT_EQ(hex_digits(bytes_in(file, in_movie[1])), "000000001013004fffffffffff0e04000000060e0400000007");
    EXPECT_EQ(number_in(file, in_movie[0].end - 4, 4), 8U) << "the next track";
}

TEST_F(Mp4File, MarksItsTracks) {
    const auto tracks = tracks_in(file);
    const char* handlers[] = {"vide", "auxv", "auxv", "auxv", "auxv", "sdsm", "odsm"};
    const char* names[] = {"colour", "depth", "haptic", "height", "depth_low"};
    ASSERT_EQ(tracks.size(), std::size(handlers));
    for (std::size_t k = 0; k < tracks.size(); ++k) {
        EXPECT_EQ(handler_of(file, tracks[k]), handlers[k]);
        EXPECT_EQ(id_of(file, tracks[k]), k + 1);
        if (k >= std::size(names)) continue;
        const FoundBox handler = box_at(file, tracks[k], {"mdia", "hdlr"});
        EXPECT_TRUE(has_words(bytes_in(file, handler), names[k]));
        const bool is_enabled = number_in(file, box_at(file, tracks[k], {"tkhd"}).content, 4) & 1;
        EXPECT_EQ(is_enabled, k < 4) << "an object of the scene: " << names[k];
        const auto references = boxes_named(file, tracks[k], "tref");
        EXPECT_EQ(references.empty(), k == 0);
        if (k > 0) {
            EXPECT_EQ(hex_digits(bytes_in(file, box_at(file, tracks[k], {"tref", "vdep"}))), "00000001");
        }
        const FoundBox kinds = box_at(file, tracks[k], {"mdia", "minf", "stbl", "stsd"});
        EXPECT_EQ(file.substr(kinds.content + 12, 4), "avc1");
    }
    EXPECT_EQ(hex_digits(bytes_in(file, box_at(file, tracks[6], {"tref", "mpod"}))),
              "00000001000000020000000300000004");
}

TEST_F(Mp4File, DescribesObjectsAndSceneConfiguration) {
    const auto tracks = tracks_in(file);
    // Descriptors 10 to 13, each the so-manieth track that mpod names.
    EXPECT_EQ(hex_digits(sample_of(file, tracks[6])),
              "0120"
              "1106029f0f020001"
              "110602df0f020002"
              "1106031f0f020003"
              "1106035f0f020004");
    const FoundBox kinds = box_at(file, tracks[5], {"mdia", "minf", "stbl", "stsd"});
    EXPECT_EQ(number_in(file, kinds.content + 4, 4), 1U);
    const FoundBox entry{"stsd", kinds.at, kinds.content + 8, kinds.end};
    const FoundBox mp4s = box_at(file, entry, {"mp4s"});
    const FoundBox esds = box_at(file, {"mp4s", mp4s.at, mp4s.content + 8, mp4s.end}, {"esds"});
    const std::string said = hex_digits(bytes_in(file, esds));
    // BIFS of version 2 (object type 2), a stream of scenes (3 << 2 | 1), and its decoder's configuration:
    // one bit of node numbers, two of prototypes', commands, pixels, 30 x 23.
    EXPECT_TRUE(has_words(said, "020d"));
    EXPECT_TRUE(has_words(said, "050702017001e00170"));
}

struct ForeignCloser {
    void operator()(AVFormatContext* container) const { avformat_close_input(&container); }
};
using ForeignInput = std::unique_ptr<AVFormatContext, ForeignCloser>;

ForeignInput opened_by_ffmpeg(const std::filesystem::path& path) {
    AVFormatContext* container = nullptr;
    EXPECT_GE(avformat_open_input(&container, path.c_str(), nullptr, nullptr), 0);
    EXPECT_GE(avformat_find_stream_info(container, nullptr), 0);
    return ForeignInput(container);
}

std::vector<std::string> packets_of(AVFormatContext& container, int stream) {
    std::vector<std::string> packets;
    EXPECT_GE(avformat_seek_file(&container, -1, INT64_MIN, 0, INT64_MAX, 0), 0);
    const PacketPtr packet(av_packet_alloc());
    while (av_read_frame(&container, packet.get()) >= 0) {
        if (packet->stream_index == stream)
            packets.emplace_back(reinterpret_cast<const char*>(packet->data),
                                 static_cast<std::size_t>(packet->size));
        av_packet_unref(packet.get());
    }
    return packets;
}

std::vector<FramePtr> pictures_of(AVFormatContext& container, int stream) {
    const AVCodecParameters& stored = *container.streams[stream]->codecpar;
    const CodecPtr codec(avcodec_alloc_context3(avcodec_find_decoder(stored.codec_id)));
    EXPECT_GE(avcodec_parameters_to_context(codec.get(), &stored), 0);
    EXPECT_GE(avcodec_open2(codec.get(), nullptr, nullptr), 0);
    std::vector<FramePtr> pictures;
    const auto take = [&] {
        for (FramePtr picture(av_frame_alloc()); avcodec_receive_frame(codec.get(), picture.get()) >= 0;
             picture.reset(av_frame_alloc()))
            pictures.push_back(std::move(picture));
    };
    const PacketPtr packet(av_packet_alloc());
    for (const std::string& bytes : packets_of(container, stream)) {
        EXPECT_GE(av_new_packet(packet.get(), static_cast<int>(bytes.size())), 0);
        std::memcpy(packet->data, bytes.data(), bytes.size());
        EXPECT_GE(avcodec_send_packet(codec.get(), packet.get()), 0);
        av_packet_unref(packet.get());
        take();
    }
    avcodec_send_packet(codec.get(), nullptr);
    take();
    return pictures;
}

/// The sample of a track of one byte a sample: depth's high bits, height, or depth's low bits.
int grey_of(const RawFrame& frame, int track, int x, int y) {
    if (track == 3) return frame.height.sample(x, y);
    const int code = frame.depth.sample(x, y);
    return track == 1 ? code >> 4 : code & 15;
}

/// As its own bytes, which of RGB are planes of green, blue and red.
bool is_stored(const AVFrame& picture, const RawFrame& frame, int track, int x, int y) {
    const auto sample = [&](int plane) {
        return int{picture.data[plane][std::ptrdiff_t{picture.linesize[plane]} * y + x]};
    };
    if (track != 0 && track != 2) return sample(0) == grey_of(frame, track, x, y);
    const PlaneView& rgb = track == 0 ? frame.colour : frame.haptic;
    return sample(2) == rgb.sample(x, y, 0) && sample(0) == rgb.sample(x, y, 1) &&
           sample(1) == rgb.sample(x, y, 2);
}

TEST_F(Mp4File, DecodesExactlyByFfmpegAlone) {
    const auto container = opened_by_ffmpeg(path);
    ASSERT_EQ(container->nb_streams, 7U);
    const AVDictionaryEntry* const version = av_dict_get(container->metadata, "T3D_VERSION", nullptr, 0);
    ASSERT_TRUE(version);
    EXPECT_EQ(std::string(version->value), "4");
    for (int k = 0; k < 5; ++k) {
        const AVStream& stream = *container->streams[k];
        ASSERT_EQ(stream.codecpar->codec_type, AVMEDIA_TYPE_VIDEO) << k;
        EXPECT_EQ(stream.codecpar->codec_id, AV_CODEC_ID_H264);
        EXPECT_EQ(stream.id, k + 1);
        EXPECT_EQ((stream.disposition & AV_DISPOSITION_DEFAULT) != 0, k < 4);
        const auto pictures = pictures_of(*container, k);
        ASSERT_EQ(pictures.size(), static_cast<std::size_t>(foreign_frames));
        for (int n = 0; n < foreign_frames; ++n) {
            const AVFrame& picture = *pictures[static_cast<std::size_t>(n)];
            const RawFrame exact = test_frame(scene, n, all_planes);
            ASSERT_EQ(picture.width, 30);
            ASSERT_EQ(picture.height, 23);
            for (int y = 0; y < 23; ++y)
                for (int x = 0; x < 30; ++x)
                    ASSERT_TRUE(is_stored(picture, exact, k, x, y)) << k << ' ' << n << ' ' << x << ' ' << y;
        }
    }
}

/// FFmpeg's decoder gives grey as 4:2:0, and a program that converts that squeezes it into 16 to 235 where
/// the stream does not say that it has the full range.
TEST_F(Mp4File, DeclaresFullRangeOfGrey) {
    const auto container = opened_by_ffmpeg(path);
    for (const int k : {1, 3, 4}) {
        const auto pictures = pictures_of(*container, k);
        ASSERT_FALSE(pictures.empty());
        AVFrame& picture = *pictures.front();
        EXPECT_EQ(picture.color_range, AVCOL_RANGE_JPEG) << k;
        const RawFrame exact = test_frame(scene, 0, all_planes);
        const auto largest_error = [&](int full_range) {
            const ScalerPtr scaler(sws_getContext(30, 23, AV_PIX_FMT_YUV420P, 30, 23, AV_PIX_FMT_GRAY8,
                                                  SWS_POINT | SWS_ACCURATE_RND, nullptr, nullptr, nullptr));
            const int* const matrix = sws_getCoefficients(SWS_CS_DEFAULT);
            sws_setColorspaceDetails(scaler.get(), matrix, full_range, matrix, 1, 0, 1 << 16, 1 << 16);
            std::vector<std::uint8_t> grey(30 * 23 + 64);
            std::uint8_t* rows[] = {grey.data(), nullptr, nullptr, nullptr};
            const int strides[] = {30, 0, 0, 0};
            sws_scale(scaler.get(), picture.data, picture.linesize, 0, 23, rows, strides);
            int largest = 0;
            for (int y = 0; y < 23; ++y)
                for (int x = 0; x < 30; ++x) {
                    const int wanted = grey_of(exact, k, x, y);
                    largest =
                        std::max(largest, std::abs(grey[static_cast<std::size_t>(30 * y + x)] - wanted));
                }
            return largest;
        };
        EXPECT_EQ(largest_error(picture.color_range == AVCOL_RANGE_JPEG ? 1 : 0), 0) << k;
        EXPECT_GT(largest_error(0), 8) << "this test would see it";
    }
}

TEST_F(Mp4File, GivesFfmpegSceneAsData) {
    const auto container = opened_by_ffmpeg(path);
    const auto tracks = tracks_in(file);
    for (const int k : {5, 6}) {
        EXPECT_EQ(container->streams[k]->codecpar->codec_type, AVMEDIA_TYPE_DATA);
        const auto packets = packets_of(*container, k);
        ASSERT_EQ(packets.size(), 1U) << k;
        EXPECT_EQ(packets[0], sample_of(file, tracks[static_cast<std::size_t>(k)]));
    }
    const std::string scene_bytes = packets_of(*container, 5)[0];
    EXPECT_EQ(scene_bytes.back(), '\0') << "some decoders do not read the last byte";
    const auto tree = must(mpeg4::decode_scene(mpeg4::Bytes(scene_bytes.begin(), scene_bytes.end()),
                                               {.node_id_bits = 1, .prototype_id_bits = 2}));
    const auto nodes = must(mpeg4::clip_nodes_of(tree));
    EXPECT_EQ(nodes.depth.url.object, 11);
    EXPECT_EQ(nodes.height->url.object, 13);
    EXPECT_EQ(nodes.near, scene.depth.near);
}

/// As another program writes it anew, which knows nothing of MPEG-4 Systems: pictures and tags.
TEST_F(Mp4File, SurvivesRemuxByFfmpeg) {
    const auto in = opened_by_ffmpeg(path);
    AVFormatContext* out = nullptr;
    ASSERT_GE(avformat_alloc_output_context2(&out, nullptr, "mp4", nullptr), 0);
    av_dict_copy(&out->metadata, in->metadata, 0);
    std::map<int, int> target;
    for (unsigned k = 0; k < 5; ++k) {
        AVStream* const stream = avformat_new_stream(out, nullptr);
        avcodec_parameters_copy(stream->codecpar, in->streams[k]->codecpar);
        av_dict_copy(&stream->metadata, in->streams[k]->metadata, 0);
        stream->time_base = in->streams[k]->time_base;
        target[static_cast<int>(k)] = stream->index;
    }
    ASSERT_GE(avio_open(&out->pb, file_url(folder / "again.mp4").c_str(), AVIO_FLAG_WRITE), 0);
    AVDictionary* options = nullptr;
    av_dict_set(&options, "movflags", "use_metadata_tags", 0);
    ASSERT_GE(avformat_write_header(out, &options), 0);
    av_dict_free(&options);
    const PacketPtr packet(av_packet_alloc());
    while (av_read_frame(in.get(), packet.get()) >= 0) {
        const auto to = target.find(packet->stream_index);
        if (to != target.end()) {
            av_packet_rescale_ts(packet.get(), in->streams[to->first]->time_base,
                                 out->streams[to->second]->time_base);
            packet->stream_index = to->second;
            ASSERT_GE(av_interleaved_write_frame(out, packet.get()), 0);
        }
        av_packet_unref(packet.get());
    }
    ASSERT_GE(av_write_trailer(out), 0);
    avio_closep(&out->pb);
    avformat_free_context(out);
    EXPECT_TRUE(
        same_frames(must(read_clip(folder / "again.mp4")), test_frames(scene, foreign_frames, all_planes)));
}

std::string in_box(const std::string& type, const std::string& content) {
    return word(content.size() + 8) + type + content;
}

std::string tables_refused(const std::string& bytes) {
    return message(check_box_tables(*bytes_in_memory(bytes), bytes.size()));
}

std::string some_video(const TemporaryFolder& folder) {
    std::vector<Image> pictures;
    for (int k = 1; k <= 3; ++k) {  // each of another size in the file
        Image picture{16, 16, 1, 3, {}};
        for (int at = 0; at < 16 * 16 * 3; ++at)
            picture.samples.push_back(static_cast<std::uint8_t>(at < 200 * k ? at * at % 251 : 0));
        pictures.push_back(std::move(picture));
    }
    write_quicktime(folder / "video.mov", pictures, {30, 1});
    return read_bytes(folder / "video.mov");
}

TEST(BoxTables, RejectFalseClaims) {
    const TemporaryFolder folder;
    const std::string video = some_video(folder);
    EXPECT_EQ(tables_refused(video), "");
    for (const char* table : {"stsz", "stco", "stsc"}) {
        std::string hostile = video;
        const std::size_t type = hostile.find(table);
        ASSERT_NE(type, std::string::npos) << table;
        const std::size_t count = type + (std::string(table) == "stsz" ? 12 : 8);
        hostile.replace(count, 4, word(300'000'000));
        EXPECT_TRUE(has_words(tables_refused(hostile),
                              "its table " + std::string(table) + " claims 300000000 entries in "));
        write_bytes(folder / "hostile.mov", hostile);
        const auto opened = Demuxer::open_quicktime(folder / "hostile.mov");
        EXPECT_EQ(message(opened), (folder / "hostile.mov").string() + ": " + tables_refused(hostile));
    }
}

TEST(BoxTables, AreCheckedInAllBoxes) {
    const std::string zeros(4, '\0'), flags_of_sizes = word(0x200), none = word(0);
    const auto track = [](const std::string& table) {
        return in_box("moov", in_box("trak", in_box("mdia", in_box("minf", in_box("stbl", table)))));
    };
    const auto fragment = [](const std::string& run) { return in_box("moof", in_box("traf", run)); };
    EXPECT_EQ(tables_refused(track(in_box("stss", zeros + word(1) + word(1)))), "");
    EXPECT_NE(tables_refused(track(in_box("stss", zeros + word(2) + word(1)))), "");
    EXPECT_EQ(tables_refused(track(in_box("stz2", zeros + word(4) + word(3) + "xx"))), "");
    EXPECT_NE(tables_refused(track(in_box("stz2", zeros + word(4) + word(5) + "xx"))), "");
    const std::string keys = in_box("keys", zeros + word(1) + word(9) + "mdta"),
                      handler = in_box("hdlr", zeros);
    const std::string hostile_keys = in_box("keys", zeros + word(2) + word(9) + "mdta");
    EXPECT_EQ(tables_refused(in_box("moov", in_box("meta", handler + keys))), "");
    EXPECT_NE(tables_refused(in_box("moov", in_box("meta", handler + hostile_keys))), "");
    EXPECT_NE(tables_refused(in_box("moov", in_box("meta", zeros + handler + hostile_keys))), "");
    const std::string groups_of_two = zeros + "sync" + word(2);
    EXPECT_EQ(tables_refused(track(in_box("sbgp", groups_of_two + std::string(16, 1)))), "");
    EXPECT_NE(tables_refused(track(in_box("sbgp", groups_of_two + std::string(15, 1)))), "");
    EXPECT_NE(tables_refused(track(in_box("sgpd", word(1 << 24) + "sync" + zeros + word(2) + "x"))), "");
    EXPECT_EQ(tables_refused(fragment(in_box("trun", flags_of_sizes + word(1) + zeros))), "");
    EXPECT_NE(tables_refused(fragment(in_box("trun", flags_of_sizes + word(2) + zeros))), "");
    // Free space that FFmpeg takes for the movie's box, and compressed tables.
    const std::string first = in_box("mvhd", ""), hostile = in_box("stss", zeros + word(2) + word(1));
    for (const char* disguise : {"free", "hoov"}) {
        EXPECT_NE(tables_refused(in_box(disguise, first + hostile)), "") << disguise;
        EXPECT_EQ(tables_refused(in_box(disguise, hostile)), "") << disguise;
    }
    EXPECT_TRUE(has_words(tables_refused(in_box("moov", in_box("cmov", ""))), "cmov"));
    // Each edit may play all samples once more.
    const std::string edits = in_box("edts", in_box("elst", std::string(8 + 12 * 100, 0)));
    const auto samples = [&](std::uint32_t count) { return in_box("stsz", zeros + word(1) + word(count)); };
    EXPECT_EQ(tables_refused(track(edits + samples(500))), "");
    EXPECT_TRUE(has_words(tables_refused(track(edits + samples(5000))), "its 100 edits of 5000 samples"));
    // Samples without tables: sound has many in a byte, but not all that can be counted.
    EXPECT_EQ(tables_refused(track(in_box("stsz", zeros + word(1) + word(3000)))), "");
    EXPECT_NE(tables_refused(track(in_box("stsz", zeros + word(1) + word(30'000)))), "");
    EXPECT_NE(tables_refused(fragment(in_box("trun", none + word(30'000)))), "");
}

TEST(BoxTables, TolerateCutFiles) {
    const TemporaryFolder folder;
    const std::string video = some_video(folder);
    const std::size_t tables = video.find("moov");
    for (std::size_t length = tables - 8; length < video.size(); ++length)
        EXPECT_EQ(tables_refused(video.substr(0, length)).find("is cut"), std::string::npos) << length;
}

// Fragmented MP4: as others read it, as it comes back, and as ffmpeg makes it.

namespace fs = std::filesystem;

const ClipStorage in_fragments{.archive = Archive::fast, .exact_colour = true, .fragmented = true};

Result<void> write_fragments(const fs::path& file, const SceneDescription& described, int frames,
                             const Planes& planes = all_planes) {
    return write_clip(file, described, frames, planes, in_fragments);
}

void expect_fragments(const fs::path& file, const Scene& scene, int frames,
                      const Planes& planes = all_planes) {
    expect_round_trip(file, scene, frames, planes, in_fragments);
    EXPECT_TRUE(!planes.haptic || must(open_clip(file))->notes().empty());
}

struct Mp4Fragments : ::testing::Test {
    const TemporaryFolder folder;
};

/// The movie box comes first, with everything that says what the file is; then fragments.
TEST_F(Mp4Fragments, FollowMovieBoxWithTags) {
    const Scene scene = scene_with_heights(30, 23, 12, 8);
    ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, 40)), "");
    const std::string file = read_bytes(folder / "clip.mp4");
    const auto boxes = boxes_of(file);
    ASSERT_GT(boxes.size(), 7U);
    EXPECT_EQ(boxes[0].type, "ftyp");
    EXPECT_EQ(boxes[1].type, "moov");
    for (std::size_t k = 2; k < 8; ++k) EXPECT_EQ(boxes[k].type, k % 2 == 0 ? "moof" : "mdat") << k;
    const std::string movie = bytes_in(file, boxes[1]);
    for (const char* tag : {"T3D_VERSION", "T3D_RATE", "T3D_SCENE"}) EXPECT_TRUE(has_words(movie, tag));
    EXPECT_TRUE(boxes_named(file, boxes[1], "iods").empty());
    const auto tracks = boxes_named(file, boxes[1], "trak");
    const char* names[] = {"colour", "depth", "haptic", "height", "depth_low"};
    ASSERT_EQ(tracks.size(), std::size(names));
    for (std::size_t k = 0; k < tracks.size(); ++k) {
        EXPECT_EQ(handler_of(file, tracks[k]), k == 0 ? "vide" : "auxv");
        EXPECT_TRUE(has_words(bytes_in(file, box_at(file, tracks[k], {"mdia", "hdlr"})), names[k]));
        EXPECT_EQ(boxes_named(file, tracks[k], "tref").empty(), k == 0);
        if (k > 0) {
            EXPECT_EQ(hex_digits(bytes_in(file, box_at(file, tracks[k], {"tref", "vdep"}))), "00000001");
        }
    }
}

std::uint64_t frames_in(const std::string& file, const FoundBox& track_of_fragment) {
    return number_in(file, box_at(file, track_of_fragment, {"trun"}).content + 4, 4);
}

/// Every fragment holds as many frames of every track as half a second has at most.
TEST_F(Mp4Fragments, LastHalfSecondsAtMost) {
    Scene scene = scene_with_heights(16, 12, 12, 8);
    struct Case {
        FrameRate rate;
        std::uint64_t most;
    };
    for (const Case& each :
         {Case{{30, 1}, 15}, Case{{30000, 1001}, 14}, Case{{8, 1}, 4}, Case{{1, 3}, 1}, Case{{100, 1}, 15}}) {
        scene.rate = each.rate;
        constexpr std::uint64_t frames = 32;
        expect_fragments(folder / "clip.mp4", scene, frames);
        const std::string file = read_bytes(folder / "clip.mp4");
        std::uint64_t total = 0, fragments = 0;
        for (const FoundBox& box : boxes_of(file)) {
            if (box.type != "moof") continue;
            ++fragments;
            std::vector<std::uint64_t> counts;
            for (const FoundBox& track : boxes_named(file, box, "traf"))
                counts.push_back(frames_in(file, track));
            ASSERT_EQ(counts.size(), 5U);
            for (const std::uint64_t count : counts) EXPECT_EQ(count, counts[0]);
            EXPECT_LE(counts[0], each.most) << each.rate.num;
            total += counts[0];
        }
        EXPECT_EQ(total, frames);
        EXPECT_EQ(fragments, (frames + each.most - 1) / each.most);
    }
}

TEST_F(Mp4Fragments, RoundTripEveryBit) {
    for (const int bits : {8, 10, 12, 16})
        for (const int height_bits : {8, 16})
            expect_fragments(folder / "clip.mp4", scene_with_heights(63, 47, bits, height_bits), 17);
    expect_fragments(folder / "clip.mp4", scene_with_heights(40, 30, 16, 8), 1, {});
}

std::vector<std::int64_t> own_times(int frames) {
    std::vector<std::int64_t> times_ns;
    for (std::int64_t n = 0; n < frames; ++n) times_ns.push_back(7'000'001 * n + n * n * 777);
    return times_ns;
}

TEST_F(Mp4Fragments, SeekAtAnyRate) {
    constexpr int frames = 40;
    Scene scene = scene_with_heights(16, 12, 12, 16);
    for (const FrameRate& rate : {FrameRate{30, 1}, {1000, 1}, *rate_of_own_times(own_times(frames))}) {
        scene.rate = rate;
        expect_fragments(folder / "clip.mp4", scene, frames);
        auto reader = must(open_clip(folder / "clip.mp4"));
        const auto whole = test_frames(scene, frames, all_planes);
        for (const int n : {frames - 1, 0, frames / 2, 3, frames / 2 + 1, 14, 1, frames - 2}) {
            EXPECT_EQ(reader->access_point(n), n - n % 15);
            expect_seek_to(*reader, n, whole);
            EXPECT_EQ(reader->access_point(n), n - n % 15) << "the index led there";
        }
        EXPECT_TRUE(is_refused(reader->seek(frames + 1), "has no frame"));
    }
}

/// A receiver that joins a sent stream late has such a file.
TEST_F(Mp4Fragments, MayLackTheFirstOnes) {
    const Scene scene = scene_with_heights(16, 12, 12, 8);
    ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, 40)), "");
    std::string file = read_bytes(folder / "clip.mp4");
    const auto boxes = boxes_of(file);
    ASSERT_EQ(boxes[2].type, "moof");
    file.erase(boxes[2].at, boxes[4].at - boxes[2].at);
    write_bytes(folder / "later.mp4", file);
    auto reader = must(open_clip(folder / "later.mp4"));
    EXPECT_EQ(reader->frame_count(), 25);
    for (const int n : {24, 0, 15}) {
        ASSERT_EQ(message(reader->seek(n)), "") << n;
        const auto frame = must(reader->next());
        const RawFrame exact = test_frame(scene, 15 + n, all_planes);
        EXPECT_TRUE(same_plane(frame->depth, exact.depth) && same_plane(frame->haptic, exact.haptic)) << n;
    }
}

TEST_F(Mp4Fragments, AreReproducibleAndMp4Only) {
    const Scene scene = scene_with_heights(40, 30, 16, 8);
    for (const char* name : {"a.mp4", "b.mp4"})
        ASSERT_EQ(message(write_fragments(folder / name, scene, 17)), "");
    EXPECT_EQ(read_bytes(folder / "a.mp4"), read_bytes(folder / "b.mp4"));
    EXPECT_TRUE(is_refused(create_clip(folder / "clip.mkv", scene, in_fragments),
                           "only MP4 is written in fragments"));
}

TEST_F(Mp4Fragments, KeepSoundInStep) {
    write_sounding_film(folder / "film.mp4", tone(20, 3.0));
    const Scene scene = small_scene(16, 12, 12);
    const SoundPart part{folder / "film.mp4", 0, 2'000'000'000};
    ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 60, {}, in_fragments, part)), "");
    expect_clip(folder / "clip.mp4", scene, test_frames(scene, 60, {}));
    const auto track = must(SoundTrack::open(folder / "clip.mp4"));
    const auto source = must(SoundTrack::open(folder / "film.mp4"));
    ASSERT_TRUE(track && source);
    for (const std::int64_t from : {0, 60'000, 10'000}) {
        constexpr std::size_t count = SoundTrack::rate / 2, packet = 2048;  // one is missing at the beginning
        EXPECT_LE(
            largest_difference(heard_in(*track, from, count), heard_in(*source, from, count), packet, 0),
            0.5 * 2 * 3.15 * 20 * 0.001)
            << from;
    }
}

/// Four tracks with handler names, of an encoder that reorders pictures, as ffmpeg's program makes them.
struct FfmpegMp4 : ::testing::Test {
    static constexpr int frames = 40;
    const TemporaryFolder folder;
    Scene scene = scene_with_heights(64, 48, 8, 8);
    const std::vector<RawFrame> made = test_frames(scene, frames, {true, true, true, false});

    void SetUp() override {
        if (std::system("command -v ffmpeg >/dev/null") != 0)
            GTEST_SKIP() << "there is no program ffmpeg here (Debian: ffmpeg)";
        std::map<PlaneRole, std::string> bytes;
        for (const RawFrame& frame : made)
            for (const PlaneRole role : all_roles) {
                const PlaneView& plane = plane_of(frame, role);
                for (int y = 0; y < plane.height; ++y)
                    bytes[role].append(reinterpret_cast<const char*>(plane.row(y)),
                                       static_cast<std::size_t>(plane.width * plane.channels));
            }
        for (const auto& [role, all] : bytes) write_bytes(folder / std::string(role_name(role)), all);
        write_bytes(folder / "scene.json", scene_to_json(scene));
    }
    /// `options`: of all tracks.
    void make(const std::string& options) const {
        std::string command = "cd '" + (folder / "").string() + "' && ffmpeg -y -loglevel error", tracks;
        const char* names[] = {"colour", "depth", "haptic", "height"};
        for (int k = 0; k < 4; ++k) {
            const bool is_grey = k % 2 == 1;
            const std::string track = std::to_string(k);
            command += std::string(" -f rawvideo -s 64x48 -r 30 -pix_fmt ") + (is_grey ? "gray" : "rgb24") +
                       " -i " + names[k];
            tracks += " -map " + track + ":v -c:v:" + track + (is_grey ? " libx264" : " libx264rgb") +
                      " -metadata:s:v:" + track + " handler_name=" + names[k];
        }
        command +=
            tracks + " -qp 0 -bf 2 -g 10 -sc_threshold 0 -color_range pc " + options + " out.mp4 >log 2>&1";
        ASSERT_EQ(std::system(command.c_str()), 0) << read_bytes(folder / "log");
    }
    Result<std::unique_ptr<ClipReader>> open() const {
        return open_clip(folder / "out.mp4", folder / "scene.json");
    }
};

TEST_F(FfmpegMp4, ReadsTracksBySceneFile) {
    for (const char* flags :
         {"frag_keyframe+empty_moov+default_base_moof", "frag_keyframe", "frag_keyframe+empty_moov",
          "frag_keyframe+delay_moov", "frag_keyframe+empty_moov+default_base_moof+dash+global_sidx"}) {
        make(std::string("-movflags ") + flags);
        EXPECT_TRUE(has_words(read_bytes(folder / "out.mp4"), "moof"));
        auto reader = must(open());
        EXPECT_EQ(reader->frame_count(), frames);
        EXPECT_TRUE(same_frames(must(read_all(*reader)), made));
        if (HasFailure()) FAIL() << flags;
    }
    EXPECT_TRUE(is_refused(open_clip(folder / "out.mp4"), "describe it with a scene file"));
}

TEST_F(FfmpegMp4, DescribesItselfByTags) {
    std::string json = scene_to_json(scene);
    std::erase(json, '\n');
    make(
        "-movflags frag_keyframe+empty_moov+default_base_moof+use_metadata_tags -metadata T3D_VERSION=2 "
        "-metadata T3D_RATE=30/1 -metadata T3D_SCENE='" +
        json + "'");
    EXPECT_TRUE(same_frames(must(read_clip(folder / "out.mp4")), made));
}

/// Its tracks end at different frames where it is cut: those that all have are there.
TEST_F(FfmpegMp4, CutLeavesCommonFrames) {
    make("-movflags frag_keyframe+empty_moov+default_base_moof");
    const std::string whole = read_bytes(folder / "out.mp4");
    std::int64_t most = 0;
    int readable = 0;
    for (std::size_t length = whole.size() / 40; length < whole.size(); length += whole.size() / 20) {
        write_anew(folder / "out.mp4", whole.substr(0, length));
        auto reader = open();
        if (!reader) {
            EXPECT_EQ(most, 0) << "where a shorter one was read: " << message(reader);
            continue;
        }
        ++readable;
        const auto read = must(read_all(**reader));
        EXPECT_GE(std::ssize(read), most) << length;
        most = std::ssize(read);
        EXPECT_TRUE(same_frame(read.back(), made.at(read.size() - 1)));
    }
    EXPECT_GE(readable, 8);
    EXPECT_GE(most, frames / 2);
}

/// Pictures are decoded before those that are shown first, and each track has key pictures of its own.
TEST_F(FfmpegMp4, SeeksInReorderedPictures) {
    for (const char* options :
         {"-movflags frag_keyframe+empty_moov+default_base_moof", "", "-g:v:0 15 -bf:v:3 0"}) {
        make(std::string("-qp 2 -b_strategy 0 ") + options);  // what keeps every value is not reordered
        auto reader = must(open());
        const auto in_order = must(read_all(*must(open())));
        ASSERT_EQ(std::ssize(in_order), frames);
        const bool is_mixed = std::string_view(options).starts_with("-g");
        for (const int n : {9, 39, 8, 19, 21, 29, 1, 38, 10, 11, 30, 0}) {
            const int key = is_mixed ? n - n % 30 : n - n % 10;
            EXPECT_EQ(reader->access_point(n), key) << options << ' ' << n;
            expect_seek_to(*reader, n, in_order);
            EXPECT_EQ(reader->access_point(n), key) << options << ": the index led to " << n;
        }
    }
}

/// Frames of the whole fragments that end within a file of so many bytes.
int whole_frames(const std::string& file, std::size_t length) {
    int frames = 0;
    const auto boxes = boxes_of(file);
    for (std::size_t k = 0; k + 1 < boxes.size(); ++k)
        if (boxes[k].type == "moof" && boxes[k + 1].end <= length)
            frames += static_cast<int>(frames_in(file, boxes_named(file, boxes[k], "traf")[0]));
    return frames;
}

TEST_F(Mp4Fragments, CutLeavesWholeFragments) {
    Scene scene = small_scene(8, 8, 12);
    scene.rate = *rate_of_own_times({0, 200'000'000, 500'000'000, 700'000'000, 1'600'000'000});
    constexpr int frames = 5;
    ASSERT_EQ(message(write_fragments(folder / "whole.mp4", scene, frames, {})), "");
    const std::string whole = read_bytes(folder / "whole.mp4");
    ASSERT_EQ(whole_frames(whole, whole.size()), frames);
    int tried = 0, readable = 0;
    for (std::size_t length = 0; length < whole.size(); length += 5 * sweep_step()) {
        write_anew(folder / "cut.mp4", whole.substr(0, length));
        const int there = whole_frames(whole, length);
        ++tried;
        auto reader = open_clip(folder / "cut.mp4");
        if (there == 0) {
            ASSERT_FALSE(reader) << length;
            EXPECT_TRUE(is_one_line_about(folder / "cut.mp4", reader));
            continue;
        }
        ASSERT_EQ(message(reader), "") << length;
        ++readable;
        EXPECT_EQ((*reader)->frame_count(), there);
        EXPECT_TRUE(same_frames(must(read_all(**reader)), test_frames(scene, there, {}))) << length;
        const bool ends_with_a_box =
            std::ranges::any_of(boxes_of(whole), [length](const FoundBox& box) { return box.end == length; });
        EXPECT_NE(has_note((*reader)->notes(), "is cut"), ends_with_a_box) << length;
    }
    EXPECT_GT(4 * readable, tried) << "most of the file is fragments";
}

TEST_F(Mp4Fragments, SurviveChangedBytes) {
    const Scene scene = small_scene(8, 8, 12);
    ASSERT_EQ(message(write_fragments(folder / "whole.mp4", scene, 20, {false, true})), "");
    const std::string whole = read_bytes(folder / "whole.mp4");
    int tried = 0, other = 0;
    for (const FoundBox& box : boxes_of(whole)) {
        if (box.type != "moof") continue;
        for (const int change : {0x01, 0x80, 0xFF})
            for (std::size_t at = box.at + static_cast<std::size_t>(change % 3); at < box.end;
                 at += 3 * sweep_step()) {
                std::string damaged = whole;
                damaged[at] = static_cast<char>(damaged[at] ^ change);
                write_anew(folder / "damaged.mp4", damaged);
                const auto read = read_clip(folder / "damaged.mp4");
                ++tried;
                if (read) {
                    EXPECT_LE(read->size(), 20U) << at;
                    other += read->size() == 20 ? 0 : 1;
                    continue;
                }
                ++other;
                EXPECT_TRUE(is_one_line_about(folder / "damaged.mp4", read));
            }
    }
    EXPECT_GT(2 * other, tried) << "most of a fragment's head matters";
}

}  // namespace
}  // namespace touchable::test
