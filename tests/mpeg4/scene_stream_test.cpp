// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <limits>
#include <optional>

#include "engine/base/files.hpp"
#include "engine/mpeg4/bifs.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "tests/mpeg4/example_scenes.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::mpeg4 {
namespace {

using test::must;

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
Bytes track(std::uint32_t id, std::string_view handler, BytesView more_of_media = {}) {
    Bytes head, kind;
    put_zeros(head, 12);
    put_number(head, id, 4);
    put_zeros(head, 68);
    put_zeros(kind, 8);
    for (const char letter : handler) kind.push_back(static_cast<std::uint8_t>(letter));
    put_zeros(kind, 13);
    Bytes content = box_of("tkhd", head);
    Bytes media = box_of("hdlr", kind);
    put_bytes(media, more_of_media);
    put_box(content, "mdia", media);
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
    return must(boxes_in(bytes));
}

std::vector<std::string> types(BytesView bytes) {
    std::vector<std::string> names;
    for (const Box& box : parsed(bytes)) names.push_back(box.type);
    return names;
}

class SceneBoxes : public ::testing::Test {
protected:
    void SetUp() override {
        const Bytes before = movie();
        auto made = must(with_scene_stream(before, stream(), 1, moov_at));
        bytes = std::move(made);
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

TEST_F(SceneBoxes, FollowMpeg4) {
    EXPECT_EQ(types(bytes), (std::vector<std::string>{"mdat", "moov"}));
    EXPECT_EQ(types(moov), (std::vector<std::string>{"mvhd", "iods", "trak", "trak", "trak", "trak", "trak",
                                                     "trak", "trak", "udta"}));
    EXPECT_EQ(hex(content_at(moov, {"iods"})), "000000001013004fffffffffff0e04000000060e0400000007");
    EXPECT_EQ(number_at(content_at(moov, {"mvhd"}), 96, 4), 8);
    const auto parts = parsed(moov);
    const BytesView scene = parts[7].content, objects = parts[8].content;
    EXPECT_EQ(types(scene), (std::vector<std::string>{"tkhd", "mdia"}));
    EXPECT_EQ(types(objects), (std::vector<std::string>{"tkhd", "tref", "mdia"}));
    EXPECT_EQ(hex(content_at(objects, {"tref", "mpod"})), "00000001000000020000000300000004");
    EXPECT_EQ(types(content_at(scene, {"mdia", "minf", "stbl"})),
              (std::vector<std::string>{"stsd", "stts", "stsc", "stsz", "co64"}));
}

TEST_F(SceneBoxes, HoldSceneAndObjects) {
    const std::string samples = hex(boxes[0].content);
    EXPECT_EQ(samples, std::string(prototype_bytes) + "00" +
                           "0120"
                           "1106029f0f020001"
                           "110602df0f020002"
                           "1106031f0f020003"
                           "1106035f0f020004");
    const auto parts = parsed(moov);
    const std::string esds =
        hex(content_at(content_at(parts[7].content, {"mdia", "minf", "stbl", "stsd"}).subspan(8), {"mp4s"})
                .subspan(16));
    EXPECT_NE(esds.find("020d000184"), std::string::npos) << esds;  // BIFS of version 2, a scene, 388 bytes
    EXPECT_NE(esds.find("050702017004000300"), std::string::npos) << esds;  // its configuration
}

TEST_F(SceneBoxes, MarkOtherPicturesAsAuxiliary) {
    const auto parts = parsed(moov);
    const auto handler = [](const Box& trak) {
        const BytesView box = content_at(trak.content, {"mdia", "hdlr"});
        return std::string(box.begin() + 8, box.begin() + 12);
    };
    EXPECT_EQ(handler(parts[2]), "vide");
    EXPECT_TRUE(content_at(parts[2].content, {"tref"}).empty());
    for (const std::size_t k : {3, 4, 5}) {
        EXPECT_EQ(handler(parts[k]), "auxv");
        EXPECT_EQ(hex(content_at(parts[k].content, {"tref", "vdep"})), "00000001");
    }
    EXPECT_EQ(handler(parts[6]), "soun");
}

/// MPEG-4 Systems know no object whose track is not.
TEST_F(SceneBoxes, EnableObjects) {
    const auto parts = parsed(moov);
    for (std::size_t k = 2; k < parts.size() - 1; ++k)
        EXPECT_EQ(number_at(content_at(parts[k].content, {"tkhd"}), 0, 4), k == 6 ? 0U : 1U) << k;
}

TEST_F(SceneBoxes, FindFirstSamples) {
    const auto scene = must(first_sample_of(moov, 6));
    EXPECT_EQ(scene.at, moov_at + 8);
    EXPECT_EQ(scene.bytes, prototype_bytes.size() / 2 + 1);
    EXPECT_EQ(scene.count, 1);
    for (const auto& [track, words] :
         {std::pair{1, "track 1 (\"vide\") has no sample"}, {9, "has no track 9"}}) {
        const auto none = first_sample_of(moov, static_cast<std::uint32_t>(track));
        ASSERT_FALSE(none);
        EXPECT_EQ(none.error().message, words);
    }
}

TEST_F(SceneBoxes, RoundTrip) {
    const auto again = must(read_again(moov));
    ASSERT_TRUE(again.has_value());
    EXPECT_EQ(again->objects, stream().objects);
    EXPECT_EQ(encode_config(again->config), encode_config(stream().config));
    const auto scene = must(decode_scene(again->scene, again->config));
    EXPECT_EQ(scene_text(scene), scene_text(scene_from(prototype_scene)));
}

TEST_F(SceneBoxes, SurviveDamage) {
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

TEST(SceneStream, IsAbsentInPlainMovie) {
    const auto none = read_scene_stream(
        movie(), [](std::uint64_t, std::uint64_t) { return Result<Bytes>(input_error("nothing")); });
    ASSERT_TRUE(none);
    EXPECT_FALSE(none->has_value());
}

std::vector<std::uint8_t> encoded(const SceneTree& scene) {
    return must(encode_scene(scene, config_for(scene, 64, 48)));
}

/// Encoded, decoded and written again.
std::string through_bits(std::string_view text) {
    const SceneTree scene = scene_from(text);
    return scene_text(must(decode_scene(encoded(scene), config_for(scene, 64, 48))));
}
std::string as_written(std::string_view text) {
    return scene_text(scene_from(text));
}

TEST(Bifs, EncodesPrototypesAsGpac) {
    const SceneTree scene = scene_from(prototype_scene);
    EXPECT_EQ(hex(encoded(scene)), prototype_bytes);
    EXPECT_EQ(hex(encode_config(config_for(scene, 64, 48))), "02017004000300");
}

TEST(Bifs, EncodesDepthImageAsGpac) {
    const SceneTree scene = scene_from(depth_image_scene);
    EXPECT_EQ(hex(encoded(scene)), depth_image_bytes);
    EXPECT_EQ(hex(encode_config(config_for(scene, 64, 48))), "083802000180");
}

/// Of the node's fields, children and order, the second is left out: a mask of 1, the children, 0.
TEST(Bifs, EncodesOrderedGroup) {
    std::string text(depth_image_scene), bytes(depth_image_bytes);
    text.replace(text.find("Group"), 5, "OrderedGroup");
    ASSERT_EQ(bytes.substr(0, 6), "c085a0");  // Group: number 1 of 3 bits
    bytes.replace(0, 6, "c091a0");            // OrderedGroup: number 4
    const SceneTree scene = scene_from(text);
    EXPECT_EQ(hex(encoded(scene)), bytes);
    const auto decoded = [&](std::string_view from) {
        return must(decode_scene(bytes_of_hex(from), config_for(scene, 64, 48)));
    };
    SceneTree read = decoded(bytes);
    EXPECT_EQ(read.root->type, "OrderedGroup");
    read.root->type = "Group";
    EXPECT_EQ(scene_text(read), scene_text(decoded(depth_image_bytes)));
}

TEST(Bifs, EncodesStillsAsGpac) {
    const SceneTree still = scene_from(still_scene), image = scene_from(depth_image_still_scene);
    EXPECT_EQ(hex(encoded(still)), still_bytes);
    EXPECT_EQ(hex(encode_config(config_for(still, 720, 480))), "0201702d001e00");
    EXPECT_EQ(hex(encoded(image)), depth_image_still_bytes);
    EXPECT_EQ(hex(encode_config(config_for(image, 720, 480))), "083816800f00");
}

/// As GPAC encodes the same two without names.
TEST(Bifs, NamesPrototypesByTheirFields) {
    const auto decoded = [](std::string_view bytes, const BifsConfig& config) {
        return must(decode_scene(bytes_of_hex(bytes), config));
    };
    const BifsConfig still{.prototype_id_bits = 2}, image{.version = 1};
    EXPECT_FALSE(decoded(nameless_still_bytes, still).has_names);
    EXPECT_EQ(scene_text(decoded(nameless_still_bytes, still)), scene_text(decoded(still_bytes, still)));
    EXPECT_EQ(scene_text(decoded(nameless_depth_image_still_bytes, image)),
              scene_text(decoded(depth_image_still_bytes, image)));
}

TEST(Bifs, RoundTripsScenes) {
    EXPECT_EQ(through_bits(prototype_scene), as_written(prototype_scene));
    for (
        const std::string_view text : {
            // a prototype that is elsewhere
            R"(EXTERNPROTO Depth [ exposedField SFFloat farPlane exposedField MFString names exposedField SFNode texture ]
                  ["urn:touchable:depth"]
                Group { children [ Shape { geometry Depth { farPlane 3 names ["a" "b"] texture ImageTexture { url "d.png" } } } ] })",
            // pictures that do not move
            R"(Group { children [ WorldInfo { info ["one" "two"] title "a clip" }
                  Shape { appearance Appearance { texture ImageTexture { url ["c.png"] repeatS FALSE } } } ] })",
            // a node that is used again, and lists long enough to be counted
            R"(Group { children [ Shape { appearance DEF look Appearance { texture DEF movie MovieTexture { url [1 2 3 4 5 6 7 8 9 10 11 12] } } }
                  Shape { appearance USE look } Shape { appearance Appearance { texture USE movie } } ] })",
            // a root that draws in an order, and one below it
            R"(OrderedGroup { children [ OrderedGroup { children [ WorldInfo {} ] } Shape {} ] order [2 1] })",
            // one of each type of field, in a prototype
            R"(PROTO All [ field SFBool a TRUE field SFFloat b 0.25 field SFTime c 1.5 field SFString d "say \"hi\"" field SFInt32 e -3
                  field SFVec3f f 1 2 3 field SFVec2f g 4 5 field SFColor h 0.5 0.25 1 field SFRotation i 0 1 0 2 field SFURL j "x.png"
                  field MFFloat k [1 2 3 4 5 6 7 8 9] field MFInt32 l [] field MFURL m [7 "y.png"] field MFNode n [] ] { WorldInfo { title IS d } }
                Group { children [ All { a FALSE b 1e-6 c 1e9 d "" e 2147483647 f 0 0 1 g -1 0 h 0 0 0 i 1 0 0 3 j 1023
                  k [0.1] l [1 2] m [] n [WorldInfo {} All {}] } ] })",
        })
        EXPECT_EQ(through_bits(text), as_written(text));
}

TEST(Bifs, RejectsNodesOfThePaper) {
    const auto refusal = [](std::string_view text) {
        const SceneTree scene = scene_from(text);
        return message(encode_scene(scene, config_for(scene, 64, 48)));
    };
    EXPECT_EQ(refusal("Group { children [ Shape { geometry Depth {} } ] }"),
              "Group: Shape: Depth: MPEG-4 has no such node; a PROTO could define it");
    EXPECT_EQ(refusal("Group { children [ Shape { appearance Appearance { hapticSurface HapticTextureSurface "
                      "{} } } ] }"),
              "Group: Shape: Appearance.hapticSurface: MPEG-4 has no such field; a PROTO could define it");
    EXPECT_EQ(refusal("Shape {}"), "Shape: MPEG-4 has no such node there");
}

TEST(Bifs, RejectsCutScene) {
    const SceneTree scene = scene_from(prototype_scene);
    const auto bytes = encoded(scene);
    for (std::size_t length = 0; length + 1 < bytes.size(); ++length) {
        const auto decoded = decode_scene(std::span(bytes).first(length), config_for(scene, 64, 48));
        ASSERT_FALSE(decoded) << length;
        EXPECT_EQ(decoded.error().kind, ErrorKind::input);
    }
    auto longer = bytes;
    longer.push_back(0);
    EXPECT_TRUE(decode_scene(longer, config_for(scene, 64, 48)));
}

TEST(Bifs, DamageNamesItsBit) {
    const SceneTree scene = scene_from(prototype_scene);
    const auto bytes = encoded(scene);
    int refused = 0, opened = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        auto damaged = bytes;
        damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (128 >> bit % 8));
        const auto decoded = decode_scene(damaged, config_for(scene, 64, 48));
        if (decoded) {
            ++opened;
            EXPECT_TRUE(parse_scene_text(scene_text(*decoded))) << scene_text(*decoded);
        } else {
            ++refused;
            const std::string& why = decoded.error().message;
            EXPECT_TRUE(why.starts_with("bit ") || why == "the scene ends within a node") << why;
        }
    }
    EXPECT_GT(refused, 100);
    EXPECT_GT(opened, 100);  // another number, another letter
}

/// A scene of prototypes and fields that is written to do harm.
TEST(Bifs, LimitsHold) {
    const auto refusal = [](std::vector<std::uint8_t> bytes, BifsConfig config = {.prototype_id_bits = 2}) {
        return message(decode_scene(bytes, config));
    };
    EXPECT_EQ(refusal(std::vector<std::uint8_t>(70'000)),
              "the scene has 70000 bytes: must be 64 KiB at most");
    EXPECT_EQ(refusal({0x40}), "bit 2: an update of a scene: must be one that begins it (SceneReplace)");
    std::string deep;
    for (int k = 0; k < 40; ++k) deep += "Group { children [ ";
    const auto text = parse_scene_text(deep);
    ASSERT_FALSE(text);
    EXPECT_NE(text.error().message.find("more than 32 deep"), std::string::npos) << text.error().message;
    // Group { children [ Group { children [ ..., each 13 bits: new, 3D, 17, unnamed, mask, children, list,
    // value.
    std::string bits = "11000000 1 0 0 001 0 1 1 0 1";
    for (int k = 0; k < 40; ++k) bits += "0 0 010001 0 1 1 0 1";
    std::erase(bits, ' ');
    std::vector<std::uint8_t> bytes((bits.size() + 7) / 8);
    for (std::size_t k = 0; k < bits.size(); ++k)
        if (bits[k] == '1') bytes[k / 8] = static_cast<std::uint8_t>(bytes[k / 8] | (128 >> k % 8));
    EXPECT_NE(refusal(bytes).find("more than 32 deep"), std::string::npos) << refusal(bytes);
}

TEST(Bifs, RejectsNumbersBeyondFourBytes) {
    SceneTree scene = scene_from("Shape { geometry Rectangle { size 3 4 } }");
    auto& size = std::get<NodePtr>(scene.root->fields[0].values[0])->fields[0].values[0];
    size = std::array{1.0F, std::numeric_limits<float>::infinity()};
    scene.root = std::make_shared<Node>(Node{.type = "Group", .fields = {{"children", {scene.root}}}});
    const auto refused = encode_scene(scene, config_for(scene, 64, 48));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message, "Group: Shape: Rectangle: has a number that four bytes cannot hold");
}

TEST(Bifs, AllowsNamedNodesInPrototypes) {
    constexpr std::string_view scene =
        "PROTO Held [ exposedField SFNode inner DEF kept WorldInfo { title \"a\" } ] { WorldInfo {} }\n"
        "Group { children [ Held {} DEF kept WorldInfo { title \"b\" } USE kept ] }";
    EXPECT_EQ(through_bits(scene), as_written(scene));
}

TEST(Bifs, RoundTripsConfigurations) {
    for (const BifsConfig& config :
         {BifsConfig{.version = 1, .node_id_bits = 3, .width = 640, .height = 480},
          BifsConfig{.node_id_bits = 9, .route_id_bits = 2, .prototype_id_bits = 4}}) {
        const auto read = must(decode_config(encode_config(config), config.object_type()));
        EXPECT_EQ(encode_config(read), encode_config(config));
    }
    EXPECT_FALSE(decode_config(std::vector<std::uint8_t>{1}, 2));
    EXPECT_FALSE(decode_config(std::vector<std::uint8_t>{8, 0x38, 2, 0, 1, 0x80}, 3));
}

// Our binary form against GPAC's own encoder, where that is installed (docs/codecs.md): MP4Box on the PATH.

constexpr std::string_view head = R"(
InitialObjectDescriptor { objectDescriptorID 1 esDescr [ ES_Descriptor { ES_ID 1 decConfigDescr DecoderConfigDescriptor {
  objectTypeIndication 2 streamType 3
  decSpecificInfo BIFSv2Config { isCommandStream true pixelMetric true pixelWidth 64 pixelHeight 48 } } } ] }
)";

/// The scene stream of what GPAC makes of a text; nothing where it makes nothing.
std::optional<SceneStream> by_gpac(const std::string& text) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "scene.bt") << head << text;
    const std::string made = (folder / "scene.mp4").string();
    const std::string command =
        "MP4Box -mp4 -def '" + (folder / "scene.bt").string() + "' -out '" + made + "' >/dev/null 2>&1";
    if (std::system(command.c_str()) != 0) return std::nullopt;
    const auto file = bytes_of_file(SourceFile(made));
    const auto movie = file ? movie_head_of(**file) : Result<Bytes>(file.error());
    const auto read =
        movie ? read_scene_stream(*movie, [&](std::uint64_t at,
                                              std::uint64_t count) { return bytes_at(**file, at, count); })
              : Result<std::optional<SceneStream>>(movie.error());
    return read ? *read : std::nullopt;
}

TEST(Gpac, EncodesTheSameBytes) {
    if (std::system("command -v MP4Box >/dev/null") != 0) GTEST_SKIP() << "GPAC is not installed";
    const auto paper = clip_nodes_of(scene_from(still_scene));
    ASSERT_TRUE(paper);
    for (const std::string& text :
         {std::string(prototype_scene), std::string(depth_image_scene), still_scene,
          std::string(depth_image_still_scene), scene_text(scene_of(*paper, 64, 48))}) {
        const auto gpac = by_gpac(text);
        ASSERT_TRUE(gpac) << text;
        const SceneTree scene = scene_from(text);
        const auto ours = must(encode_scene(scene, config_for(scene, 64, 48)));
        EXPECT_EQ(hex(gpac->scene), hex(ours)) << text;
    }
}

Bytes fours(std::initializer_list<std::uint32_t> numbers) {
    Bytes bytes;
    for (const std::uint32_t number : numbers) put_number(bytes, number, 4);
    return bytes;
}

/// A fragmented file may begin with samples that its movie box lists, two in one chunk and one in another.
TEST(GatheredMovie, KeepsSamplesOfMovieBox) {
    for (const bool is_far : {false, true}) {
        Bytes tables = box_of("stts", fours({0, 2, 2, 10, 1, 30}));
        put_box(tables, "stsz", fours({0, 0, 3, 5, 6, 7}));
        put_box(tables, "stsc", fours({0, 2, 1, 2, 1, 2, 1, 1}));
        put_box(tables, is_far ? "co64" : "stco",
                is_far ? fours({0, 2, 0, 1000, 0, 2000}) : fours({0, 2, 1000, 2000}));
        Bytes media = box_of("mdhd", fours({0, 0, 0, 1000, 0, 0}));
        put_box(media, "minf", box_of("stbl", tables));
        Bytes content = movie_header(0);
        put_bytes(content, track(1, "vide", media));
        put_box(content, "mvex", {});
        const Bytes bytes = box_of("moov", content);
        const test::TemporaryFile written("a.mp4", std::string(bytes.begin(), bytes.end()));
        auto file = must(GivenFile::open(written.path(), "", "a file"));
        const auto gathered = must(gather_fragments(file));
        ASSERT_TRUE(gathered);
        Bytes plain = gathered->head;
        put_bytes(plain, bytes);
        const BytesView made = content_at(plain, {"moov", "trak", "mdia", "minf", "stbl"});
        for (const char* same : {"stts", "stsz", "stsc"})
            EXPECT_EQ(hex(content_at(made, {same})), hex(content_at(tables, {same})));
        for (const std::size_t k : {0, 1})
            EXPECT_EQ(number_at(content_at(made, {"co64"}), 8 + 8 * k, 8),
                      gathered->head.size() + 1000 * (k + 1));
    }
}

}  // namespace
}  // namespace touchable::mpeg4
