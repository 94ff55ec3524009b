// A static MPEG-4 scene in one MP4 file: its textures are pictures, each a track with one sample.
#include "engine/formats/formats_read.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "engine/clip/clip.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/encoded_picture.hpp"

namespace touchable::test {
namespace {

constexpr int still_wide = 24, still_high = 16;
constexpr std::uint16_t first_object = 20;  // of depth; those of other planes follow

/// How MP4Box describes a track of PNG pictures of this size: its DecoderSpecificInfo is empty (0500), for
/// which FFmpeg refuses the whole file.
constexpr std::string_view description_by_mp4box =
    "00000000000000010000007b6d703476000000000000000100000000000000000000000000000000001800100048000000480000"
    "00000000000100000000000000000000000000000000000000000000000000000000000000000018ffff00000025657364730000"
    "00000317000000040f6d110110c500088628000886280500060102";

mpeg4::Bytes bytes_of_hex(std::string_view text) {
    mpeg4::Bytes bytes;
    for (std::size_t k = 0; k + 1 < text.size(); k += 2)
        bytes.push_back(static_cast<std::uint8_t>(std::stoi(std::string(text.substr(k, 2)), nullptr, 16)));
    return bytes;
}

/// A file of one sample in each track, in the order of the planes from the last to the first, as FFmpeg
/// writes it.
std::string tracks_of(const std::filesystem::path& file, const std::map<PlaneRole, std::string>& pictures,
                      int samples) {
    AVFormatContext* muxer = nullptr;
    EXPECT_GE(avformat_alloc_output_context2(&muxer, nullptr, "mp4", file.c_str()), 0);
    EXPECT_GE(avio_open(&muxer->pb, file.c_str(), AVIO_FLAG_WRITE), 0);
    for (auto picture = pictures.rbegin(); picture != pictures.rend(); ++picture) {
        AVStream* const stream = avformat_new_stream(muxer, nullptr);
        stream->codecpar->codec_type = AVMEDIA_TYPE_VIDEO;
        stream->codecpar->codec_id = picture->second[0] == '\xff' ? AV_CODEC_ID_MJPEG : AV_CODEC_ID_PNG;
        stream->codecpar->width = still_wide;
        stream->codecpar->height = still_high;
        stream->time_base = {1, 1000};
    }
    EXPECT_GE(avformat_write_header(muxer, nullptr), 0);
    for (int n = 0; n < samples; ++n) {
        int stream = 0;
        for (auto picture = pictures.rbegin(); picture != pictures.rend(); ++picture, ++stream) {
            const PacketPtr packet(av_packet_alloc());
            EXPECT_GE(av_new_packet(packet.get(), static_cast<int>(picture->second.size())), 0);
            std::memcpy(packet->data, picture->second.data(), picture->second.size());
            packet->stream_index = stream;
            packet->pts = packet->dts = av_rescale_q(n, {1, 1}, muxer->streams[stream]->time_base);
            packet->duration = av_rescale_q(1, {1, 1}, muxer->streams[stream]->time_base);
            packet->flags |= AV_PKT_FLAG_KEY;
            EXPECT_GE(av_write_frame(muxer, packet.get()), 0);
        }
    }
    EXPECT_GE(av_write_trailer(muxer), 0);
    avio_closep(&muxer->pb);
    avformat_free_context(muxer);
    return read_bytes(file);
}

class Mp4StillClips : public ::testing::Test {
protected:
    void SetUp() override {
        scene.camera = camera_from_focal_length(50, 1, still_wide, still_high);
        scene.height_coding = {1.5, HeightUnits::levels, 255};
        frame = test_frame(scene, 0, all_planes);
        put(PlaneRole::depth, frame.depth);
        put(PlaneRole::colour, frame.colour);
        put(PlaneRole::haptic, frame.haptic);
        put(PlaneRole::height, frame.height);
    }
    void put(PlaneRole role, const PlaneView& plane) {
        ASSERT_EQ(
            message(write_png_to(folder / "x.png", plane, "x.png", PngEffort::quick, png_colours(role))), "");
        pictures[role] = read_bytes(folder / "x.png");
    }
    /// Nodes as `nodes_of_pictures` has them, their textures objects of the file.
    mpeg4::ClipNodes nodes() const {
        SceneDescription described(scene);
        described.unstated.filters = all_unstated;
        described.scene.folder = FolderSource{.depth = "d", .colour = "c", .haptic = "s", .height = "h"};
        mpeg4::ClipNodes made = mpeg4::nodes_of_pictures(described);
        const auto object = [](PlaneRole role) {
            return mpeg4::ClipNodes::Texture{
                {.object = static_cast<std::uint16_t>(first_object + static_cast<int>(role))}, false};
        };
        made.depth = object(PlaneRole::depth);
        made.colour = object(PlaneRole::colour);
        made.haptic = object(PlaneRole::haptic);
        made.height = object(PlaneRole::height);
        return made;
    }
    std::filesystem::path written(const mpeg4::ClipNodes& nodes, int samples = 1, bool by_mp4box = false) {
        return written(mpeg4::scene_of(nodes, still_wide, still_high), samples, by_mp4box);
    }
    std::filesystem::path written(const mpeg4::SceneTree& tree, int samples, bool by_mp4box) {
        std::string bytes = tracks_of(folder / "tracks.mp4", pictures, samples);
        std::size_t moov = 0;
        for (std::size_t at = 0; at + 8 <= bytes.size();) {
            const std::string size = bytes.substr(at, 4);
            if (bytes.compare(at + 4, 4, "moov") == 0) moov = at;
            std::size_t step = 0;
            for (const char c : size) step = step << 8 | static_cast<unsigned char>(c);
            at += std::max<std::size_t>(step, 8);
        }
        mpeg4::SceneStream stream;
        std::uint32_t track = static_cast<std::uint32_t>(pictures.size());
        for (const auto& [role, picture] : pictures)
            stream.objects[static_cast<std::uint16_t>(first_object + static_cast<int>(role))] = track--;
        stream.config = mpeg4::config_for(tree, still_wide, still_high);
        const auto encoded = mpeg4::encode_scene(tree, stream.config);
        EXPECT_EQ(message(encoded), "");
        stream.scene = *encoded;
        mpeg4::Bytes movie(bytes.begin() + static_cast<std::ptrdiff_t>(moov) + 8, bytes.end());
        constexpr std::string_view description[] = {"trak", "mdia", "minf", "stbl", "stsd"};
        if (by_mp4box) movie = mpeg4::with_content(movie, description, bytes_of_hex(description_by_mp4box));
        const auto made = mpeg4::with_scene_stream(movie, stream, 1, moov);
        EXPECT_EQ(message(made), "");
        write_bytes(folder / "stills.mp4", bytes.substr(0, moov) + std::string(made->begin(), made->end()));
        return folder / "stills.mp4";
    }
    TemporaryFolder folder;
    Scene scene = small_scene(still_wide, still_high, 16);
    RawFrame frame;
    std::map<PlaneRole, std::string> pictures;
};

/// Sixteen bits are in one picture; twelve need more than nodes say.
TEST_F(Mp4StillClips, EveryPlaneComesBackByTheObjectsOfItsScene) {
    for (const int bits : {8, 12, 16}) {
        scene.depth_bits = bits;
        scene.depth.code_max = static_cast<std::uint16_t>((1 << bits) - 1);
        derive_valid_range(scene.depth);
        SetUp();
        EXPECT_EQ(nodes().scene_file.empty(), bits != 12);
        const auto clip = open_clip(written(nodes()));
        ASSERT_EQ(message(clip), "");
        EXPECT_EQ((*clip)->frame_count(), 1);
        Scene read = (*clip)->scene();
        read.name = scene.name;
        EXPECT_EQ(scene_to_json(read), scene_to_json(scene)) << bits;
        EXPECT_EQ((*clip)->tracks().front().codec, "png");
        const auto frames = read_all(**clip);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 1U);
        EXPECT_TRUE(same_frame(frames->front(), frame)) << bits;
    }
    scene.name = "another";
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const auto told = open_clip(folder / "stills.mp4", folder / "scene.json");
    ASSERT_EQ(message(told), "");
    EXPECT_EQ((*told)->scene().name, "another");
    const auto guessed = guess_clip(folder / "stills.mp4", {});
    ASSERT_EQ(message(guessed), "");
    EXPECT_EQ(guessed->scene.depth.far, 200);
}

TEST_F(Mp4StillClips, ReadsTracksOfMp4Box) {
    const auto frames = read_clip(written(nodes(), 1, true));
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 1U);
    EXPECT_TRUE(same_frame(frames->front(), frame));
}

/// The scene says what is wrong, not FFmpeg.
TEST_F(Mp4StillClips, SaysWhyMp4BoxSceneIsNoClip) {
    mpeg4::SceneTree tree = mpeg4::scene_of(nodes(), still_wide, still_high);
    tree.prototypes.back().fields[1].name = "pixelBreadth";
    const auto& shape = std::get<mpeg4::NodePtr>(tree.root->fields[0].values[0]);
    std::get<mpeg4::NodePtr>(shape->fields.back().values[0])->fields[1].name = "pixelBreadth";
    const std::string refused = message(open_clip(written(tree, 1, true)));
    EXPECT_NE(refused.find("its MPEG-4 scene is no touchable clip: Depth: must have a field pixelWidth"),
              std::string::npos)
        << refused;
}

TEST_F(Mp4StillClips, JpegAndLaterPicturesAreReadAndSaid) {
    pictures[PlaneRole::colour] = pictures[PlaneRole::haptic] =
        encoded("mjpeg", AV_PIX_FMT_YUVJ420P, still_wide, still_high, [](AVFrame& made) {
            for (int plane = 0; plane < 3; ++plane)
                for (int y = 0; y < still_high / (plane > 0 ? 2 : 1); ++y)
                    std::memset(made.data[plane] + y * made.linesize[plane], plane > 0 ? 128 : 77,
                                still_wide / (plane > 0 ? 2 : 1));
        });
    const auto clip = open_clip(written(nodes(), 2));
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "haptic is stored as mjpeg, which changes values"));
    EXPECT_FALSE(is_noted(**clip, "colour is stored as"));
    EXPECT_TRUE(is_noted(**clip, "track depth has 2 pictures; its ImageTexture is the first"));
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 1U);
    EXPECT_EQ(frames->front().colour.sample(3, 2, 1), 77);
    EXPECT_TRUE(same_plane(frames->front().depth, frame.depth));
}

TEST_F(Mp4StillClips, WhatIsMissingOrWrongIsNamed) {
    const auto refusal = [&](const mpeg4::ClipNodes& changed) {
        return message(open_clip(written(changed)));
    };
    mpeg4::ClipNodes changed = nodes();
    changed.colour->is_movie = true;
    EXPECT_NE(
        refusal(changed).find("stills.mp4: its MPEG-4 scene has depth in an ImageTexture and colour in a "
                              "MovieTexture: must all be one or the other"),
        std::string::npos)
        << refusal(changed);
    changed = nodes();
    changed.height->url.object = 77;
    EXPECT_NE(refusal(changed).find("stills.mp4: its MPEG-4 scene: height is object 77, which is no track"),
              std::string::npos)
        << refusal(changed);
    changed = nodes();
    changed.far = 5;
    EXPECT_NE(refusal(changed).find("stills.mp4: its MPEG-4 scene: depth.near"), std::string::npos)
        << refusal(changed);
    for (const PlaneRole role : all_roles) {
        const std::string whole = pictures[role];
        for (const std::size_t length : {whole.size() - 20, std::size_t{40}}) {
            pictures[role].resize(length);
            EXPECT_NE(
                refusal(nodes()).find("stills.mp4: track " + std::string(role_name(role)) + ": is cut short"),
                std::string::npos)
                << refusal(nodes());
        }
        pictures[role] = whole;
    }
    const Samples grey(2 * 7 * 5);
    put(PlaneRole::haptic, PlaneView{grey.data(), 14, 7, 5, 2, 1});
    EXPECT_NE(refusal(nodes()), "") << "stiffness of 16 bits is none";
    put(PlaneRole::haptic, PlaneView{grey.data(), 7, 7, 5, 1, 1});
    const auto clip = open_clip(written(nodes()));
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "haptic is 7x5: resampled"));
}

/// Cut anywhere it is refused in one line, but for the zero behind the scene's samples and for tags.
TEST_F(Mp4StillClips, CutAnywhereItIsOneLine) {
    const std::string whole = read_bytes(written(nodes()));
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 150) {
        write_bytes(folder / "cut.mp4", whole.substr(0, length));
        const auto clip = open_clip(folder / "cut.mp4");
        ASSERT_FALSE(clip) << length;
        EXPECT_EQ(message(clip).find('\n'), std::string::npos);
    }
}

}  // namespace
}  // namespace touchable::test
