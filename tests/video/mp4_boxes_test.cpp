// Our MP4 files as others read them: by their boxes, and by FFmpeg alone.
#include <gtest/gtest.h>

#include <map>
#include <memory>

#include "engine/clip/clip_file.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/mp4_boxes.hpp"

namespace touchable::test {
namespace {

constexpr int foreign_frames = 4;

/// A clip of 12 bits with all planes: tracks of colour, depth, haptic, height, and depth's low bits.
class Mp4File : public ::testing::Test {
protected:
    void SetUp() override {
        auto writer = create_mp4_clip(path, scene, exact_clip);
        ASSERT_EQ(message(writer), "");
        for (int n = 0; n < foreign_frames; ++n)
            ASSERT_EQ(message((*writer)->write(test_frame(scene, n, all_planes))), "");
        ASSERT_EQ(message((*writer)->finish()), "");
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

TEST_F(Mp4File, BoxesStandAsMpeg4Systems) {
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

TEST_F(Mp4File, TracksAreMarkedForEveryPlayer) {
    const auto tracks = tracks_in(file);
    const char* handlers[] = {"vide", "auxv", "auxv", "auxv", "auxv", "sdsm", "odsm"};
    const char* names[] = {"colour", "depth", "haptic", "height", "depth_low"};
    ASSERT_EQ(tracks.size(), std::size(handlers));
    for (std::size_t k = 0; k < tracks.size(); ++k) {
        EXPECT_EQ(handler_of(file, tracks[k]), handlers[k]);
        EXPECT_EQ(id_of(file, tracks[k]), k + 1);
        if (k >= std::size(names)) continue;
        const FoundBox handler = box_at(file, tracks[k], {"mdia", "hdlr"});
        EXPECT_NE(bytes_in(file, handler).find(names[k]), std::string::npos);
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

TEST_F(Mp4File, ObjectsAreTheTracksOfTheSceneAndItsConfigurationIsSaid) {
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
    EXPECT_NE(said.find("020d"), std::string::npos) << said;
    EXPECT_NE(said.find("050702017001e00170"), std::string::npos) << said;
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

/// What a track of one byte a sample has there: depth's high bits, height, or depth's low bits.
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

TEST_F(Mp4File, FfmpegAloneDecodesEveryTrackToTheBit) {
    const auto container = opened_by_ffmpeg(path);
    ASSERT_EQ(container->nb_streams, 7U);
    const AVDictionaryEntry* const version = av_dict_get(container->metadata, "T3D_VERSION", nullptr, 0);
    ASSERT_TRUE(version);
    EXPECT_EQ(std::string(version->value), "3");
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

/// FFmpeg's decoder gives grey as 4:2:0, and whoever converts that squeezes it into 16 to 235 where the
/// stream does not say that it has the full range.
TEST_F(Mp4File, GreyStreamsSayTheirFullRange) {
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

TEST_F(Mp4File, FfmpegGivesTheSceneAndItsObjectsAsDataToTheBit) {
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
    const auto tree = mpeg4::decode_scene(mpeg4::Bytes(scene_bytes.begin(), scene_bytes.end()),
                                          {.node_id_bits = 1, .prototype_id_bits = 2});
    ASSERT_EQ(message(tree), "");
    const auto nodes = mpeg4::clip_nodes_of(*tree);
    ASSERT_EQ(message(nodes), "");
    EXPECT_EQ(nodes->depth.url.object, 11);
    EXPECT_EQ(nodes->height->url.object, 13);
    EXPECT_EQ(nodes->near, scene.depth.near);
}

/// As another program writes it anew, which knows nothing of MPEG-4 Systems: pictures and tags.
TEST_F(Mp4File, OneThatFfmpegWroteAgainIsTheSameClip) {
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
    const auto frames = read_clip(folder / "again.mp4");
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), static_cast<std::size_t>(foreign_frames));
    for (int n = 0; n < foreign_frames; ++n)
        EXPECT_TRUE(same_frame((*frames)[static_cast<std::size_t>(n)], test_frame(scene, n, all_planes)));
}

}  // namespace
}  // namespace touchable::test
