#include "engine/mpeg4/boxes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/mpeg4/example_scenes.hpp"

namespace touchable::mpeg4 {
namespace {

constexpr std::uint64_t moov_at = 5000;

void put_zeros(Bytes& to, std::size_t count) {
    to.insert(to.end(), count, 0);
}

Bytes movie_header(std::uint32_t duration_ms) {
    Bytes head;
    put_zeros(head, 12);
    put_number(head, 1000, 4);
    put_number(head, duration_ms, 4);
    put_zeros(head, 76);
    put_number(head, 1, 4);  // the next track's number, wrong
    return box_of("mvhd", head);
}

/// As a muxer writes one, as far as it matters here.
Bytes track(std::uint32_t id, std::string_view handler) {
    Bytes head, kind;
    put_zeros(head, 12);
    put_number(head, id, 4);
    put_zeros(head, 68);
    put_zeros(kind, 8);
    for (const char letter : handler) kind.push_back(static_cast<std::uint8_t>(letter));
    put_zeros(kind, 13);
    Bytes content = box_of("tkhd", head);
    put_box(content, "mdia", box_of("hdlr", kind));
    return box_of("trak", content);
}

Bytes movie() {
    Bytes moov = movie_header(2500);
    for (std::uint32_t id = 1; id <= 4; ++id) put_bytes(moov, track(id, "vide"));
    put_bytes(moov, track(5, "soun"));
    put_box(moov, "udta", {});
    return moov;
}

SceneStream stream() {
    const SceneTree scene = scene_from(prototype_scene);
    const BifsConfig config = config_for(scene, 64, 48);
    return {config, *encode_scene(scene, config), {{10, 1}, {11, 2}, {12, 3}, {13, 4}}};
}

std::vector<Box> parsed(BytesView bytes) {
    auto boxes = boxes_in(bytes);
    EXPECT_TRUE(boxes);
    return boxes ? *boxes : std::vector<Box>();
}

std::vector<std::string> types(BytesView bytes) {
    std::vector<std::string> names;
    for (const Box& box : parsed(bytes)) names.push_back(box.type);
    return names;
}

std::string hex_of(BytesView bytes) {
    return hex({bytes.begin(), bytes.end()});
}

class Written : public ::testing::Test {
protected:
    void SetUp() override {
        const Bytes before = movie();
        auto made = with_scene_stream(before, stream(), 1, moov_at);
        ASSERT_TRUE(made) << made.error().message;
        bytes = std::move(*made);
        boxes = parsed(bytes);
        ASSERT_EQ(boxes.size(), 2);
        moov = boxes[1].content;
    }
    Result<Bytes> read(std::uint64_t at, std::uint64_t count) const {
        EXPECT_GE(at, moov_at);
        EXPECT_LE(at + count, moov_at + bytes.size());
        return Bytes(bytes.begin() + static_cast<std::ptrdiff_t>(at - moov_at),
                     bytes.begin() + static_cast<std::ptrdiff_t>(at - moov_at + count));
    }
    Result<std::optional<SceneStream>> read_again(BytesView from) const {
        return read_scene_stream(from,
                                 [this](std::uint64_t at, std::uint64_t count) { return read(at, count); });
    }

    Bytes bytes;
    std::vector<Box> boxes;
    BytesView moov;
};

TEST_F(Written, BoxesStandAsMpeg4HasThem) {
    EXPECT_EQ(types(bytes), (std::vector<std::string>{"mdat", "moov"}));
    EXPECT_EQ(types(moov), (std::vector<std::string>{"mvhd", "iods", "trak", "trak", "trak", "trak", "trak",
                                                     "trak", "trak", "udta"}));
    EXPECT_EQ(hex_of(content_at(moov, {"iods"})), "000000001013004fffffffffff0e04000000060e0400000007");
    EXPECT_EQ(number_at(content_at(moov, {"mvhd"}), 96, 4), 8);
    const auto parts = parsed(moov);
    const BytesView scene = parts[7].content, objects = parts[8].content;
    EXPECT_EQ(types(scene), (std::vector<std::string>{"tkhd", "mdia"}));
    EXPECT_EQ(types(objects), (std::vector<std::string>{"tkhd", "tref", "mdia"}));
    EXPECT_EQ(hex_of(content_at(objects, {"tref", "mpod"})), "00000001000000020000000300000004");
    EXPECT_EQ(types(content_at(scene, {"mdia", "minf", "stbl"})),
              (std::vector<std::string>{"stsd", "stts", "stsc", "stsz", "co64"}));
}

TEST_F(Written, SamplesAreTheSceneAndItsObjects) {
    const std::string samples = hex_of(boxes[0].content);
    EXPECT_EQ(samples, std::string(prototype_bytes) + "00" +
                           "0120"
                           "1106029f0f020001"
                           "110602df0f020002"
                           "1106031f0f020003"
                           "1106035f0f020004");
    const auto parts = parsed(moov);
    const std::string esds =
        hex_of(content_at(content_at(parts[7].content, {"mdia", "minf", "stbl", "stsd"}).subspan(8), {"mp4s"})
                   .subspan(16));
    EXPECT_NE(esds.find("020d000184"), std::string::npos) << esds;  // BIFS of version 2, a scene, 388 bytes
    EXPECT_NE(esds.find("050702017004000300"), std::string::npos) << esds;  // its configuration
}

TEST_F(Written, OtherPicturesAreMarkedAsAuxiliary) {
    const auto parts = parsed(moov);
    const auto handler = [](const Box& trak) {
        const BytesView box = content_at(trak.content, {"mdia", "hdlr"});
        return std::string(box.begin() + 8, box.begin() + 12);
    };
    EXPECT_EQ(handler(parts[2]), "vide");
    EXPECT_TRUE(content_at(parts[2].content, {"tref"}).empty());
    for (const std::size_t k : {3, 4, 5}) {
        EXPECT_EQ(handler(parts[k]), "auxv");
        EXPECT_EQ(hex_of(content_at(parts[k].content, {"tref", "vdep"})), "00000001");
    }
    EXPECT_EQ(handler(parts[6]), "soun");
}

/// MPEG-4 Systems know no object whose track is not.
TEST_F(Written, ObjectsAreEnabled) {
    const auto parts = parsed(moov);
    for (std::size_t k = 2; k < parts.size() - 1; ++k)
        EXPECT_EQ(number_at(content_at(parts[k].content, {"tkhd"}), 0, 4), k == 6 ? 0U : 1U) << k;
}

TEST_F(Written, FindsFirstSamples) {
    const auto scene = first_sample_of(moov, 6);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->at, moov_at + 8);
    EXPECT_EQ(scene->bytes, prototype_bytes.size() / 2 + 1);
    EXPECT_EQ(scene->count, 1);
    for (const auto& [track, words] :
         {std::pair{1, "track 1 (\"vide\") has no sample"}, {9, "has no track 9"}}) {
        const auto none = first_sample_of(moov, static_cast<std::uint32_t>(track));
        ASSERT_FALSE(none);
        EXPECT_EQ(none.error().message, words);
    }
}

TEST_F(Written, ComesBack) {
    const auto again = read_again(moov);
    ASSERT_TRUE(again) << again.error().message;
    ASSERT_TRUE(again->has_value());
    EXPECT_EQ((*again)->objects, stream().objects);
    EXPECT_EQ(encode_config((*again)->config), encode_config(stream().config));
    const auto scene = decode_scene((*again)->scene, (*again)->config);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene_text(*scene), scene_text(scene_from(prototype_scene)));
}

TEST_F(Written, DamageIsRefusedOrLeavesAScene) {
    int refused = 0;
    for (std::size_t at = 0; at < moov.size(); ++at) {
        Bytes damaged(moov.begin(), moov.end());
        damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ 0xFF);
        const auto again = read_scene_stream(
            damaged, [](std::uint64_t, std::uint64_t count) { return Result<Bytes>(Bytes(count)); });
        refused += again ? 0 : 1;
    }
    EXPECT_GT(refused, 20);
    for (std::size_t length = 0; length < moov.size(); ++length) {
        const auto again = read_again(moov.first(length));
        EXPECT_TRUE(!again || length >= moov.size() - 8 || !again->has_value() || (*again)->objects.empty())
            << length;
    }
}

TEST(SceneStream, AMovieWithoutOneHasNone) {
    const auto none = read_scene_stream(
        movie(), [](std::uint64_t, std::uint64_t) { return Result<Bytes>(input_error("nothing")); });
    ASSERT_TRUE(none);
    EXPECT_FALSE(none->has_value());
}

}  // namespace
}  // namespace touchable::mpeg4
