#include "engine/formats/depth_photo.hpp"

#include <gtest/gtest.h>

#include "engine/picture/ffmpeg.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/jpeg_with_xmp.hpp"

namespace touchable::test {
namespace {

TEST(Base64, DecodesTheExamplesOfRfc4648) {
    EXPECT_EQ(decode_base64(""), "");
    EXPECT_EQ(decode_base64("Zg=="), "f");
    EXPECT_EQ(decode_base64("Zm8="), "fo");
    EXPECT_EQ(decode_base64("Zm9v"), "foo");
    EXPECT_EQ(decode_base64("Zm9vYg=="), "foob");
    EXPECT_EQ(decode_base64(" Zm9v\r\nYm\tFy\n"), "foobar");
}

TEST(Base64, ComesBackWhateverTheBytes) {
    Numbers numbers(3);
    for (int length = 0; length < 200; ++length) {
        std::string bytes;
        for (int k = 0; k < length; ++k) bytes += static_cast<char>(numbers.below(256));
        ASSERT_EQ(decode_base64(encode_base64(bytes)), bytes) << length;
    }
}

TEST(Base64, RefusesAnythingElse) {
    for (const char* text :
         {"Z", "Zg", "Zg=", "Zg===", "Zg==Zg==", "Z=g=", "====", "=", "Zm9v!", "Zm9-", "Zm&v"})
        EXPECT_FALSE(decode_base64(text)) << text;
}

TEST(Xmp, PropertiesAreAttributesOrElements) {
    const auto entries = parse_xmp_entries(R"(<?xpacket begin="" id="x>"?><!-- a="1" <b> -->
        <x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:Description a:One = "1" a:Two='it"s'
          a:Long="AB&amp;"><a:Three>3.5</a:Three><a:Empty/><a:Nested><b:Li>4</b:Li></a:Nested>
        </rdf:Description></x:xmpmeta><?xpacket end="w"?>)");
    ASSERT_TRUE(entries);
    const XmpProperties expected{{"xmlns:x", "adobe:ns:meta/"}, {"a:One", "1"},     {"a:Two", "it\"s"},
                                 {"a:Long", "AB&amp;"},         {"a:Three", "3.5"}, {"b:Li", "4"}};
    EXPECT_EQ(properties_of(*entries), expected);
}

TEST(Xmp, BrokenTagsAreRefused) {
    for (const char* text :
         {"<", "<a", "<a b", "<a b=", "<a b=c>", "<a b=\"c>", "<a b=\"c\"", "<a ='c'>", "<!-- a", "<? a",
          "</a", "< a>", "<a <b>>", "<a \"b\">", "<a>", "<a></b>", "<a><b></a></b>"})
        EXPECT_FALSE(parse_xmp_entries(text)) << text;
    EXPECT_TRUE(parse_xmp_entries("")->empty());
    EXPECT_TRUE(parse_xmp_entries("no tag at all")->empty());
}

TEST(Xmp, TakesElementsOfAnyDepth) {
    constexpr std::size_t depth = 200'000;  // far more than a stack has room for
    std::string text;
    for (std::size_t k = 0; k < depth; ++k) text += "<a>";
    text += "1";
    for (std::size_t k = 0; k < depth; ++k) text += "</a>";
    const auto entries = parse_xmp_entries(text);
    ASSERT_TRUE(entries);
    EXPECT_EQ(entries->size(), depth + 1);
    EXPECT_EQ(entries->back().value, "1");
}

std::string packet(const std::string& attributes) {
    return "<x:xmpmeta><rdf:Description " + attributes + "/></x:xmpmeta>";
}
std::string main_packet() {
    return xmp_segment(packet(std::string("a:Near='1' xmpNote:HasExtendedXMP='") + guid + "'"));
}

TEST(JpegXmp, IsPutTogetherFromPiecesInAnyOrder) {
    const std::string extended = packet("a:Data='" + std::string(1000, 'Q') + "' a:Near='2'");
    const std::string first = extension_segment(guid, extended, 0, 400);
    const std::string second = extension_segment(guid, extended, 400, extended.size());
    const std::string foreign = extension_segment(std::string(32, 'F'), packet("a:Other='1'"), 0, 10);
    for (const std::string& segments :
         {main_packet() + first + second, second + foreign + main_packet() + first,
          segment('\xe0', "JFIF") + foreign + second + first + main_packet() + "\xff"}) {
        const auto xmp = read_jpeg_xmp(jpeg_around(segments), "x.jpg");
        ASSERT_EQ(message(xmp), "");
        EXPECT_EQ(xmp->at("a:Data"), std::string(1000, 'Q'));
        EXPECT_EQ(xmp->at("a:Near"), "1") << "the packet itself wins";
        EXPECT_EQ(xmp->count("a:Other"), 0U);
    }
}

TEST(JpegXmp, OfAJpegWithoutAnyIsEmpty) {
    for (const std::string& segments : {std::string(), segment('\xe1', std::string("Exif\0\0MM", 8)),
                                        extension_segment(guid, packet("a:Near='2'"), 0, 10)}) {
        const auto xmp = read_jpeg_xmp(jpeg_around(segments), "x.jpg");
        ASSERT_EQ(message(xmp), "");
        EXPECT_TRUE(xmp->empty());
    }
}

TEST(JpegXmp, PiecesThatDoNotFitAreRefused) {
    const std::string extended = packet("a:Data='" + std::string(100, 'Q') + "'");
    const auto piece = [&](std::size_t from, std::size_t to) {
        return extension_segment(guid, extended, from, to);
    };
    const std::size_t end = extended.size();
    const std::pair<std::string, const char*> cases[] = {
        {"", "that is not in the file"},
        {extension_segment(std::string(32, 'F'), extended, 0, end), "that is not in the file"},
        {segment('\xe1', std::string(extension_header()) + guid + "1234567"), "that is not in the file"},
        {piece(0, 50), "is 50 bytes, not"},
        {piece(50, end), "a gap at byte 0"},
        {piece(0, 50) + piece(60, end), "a gap at byte 50"},
        {piece(0, 50) + piece(40, end), "overlap at byte 40"},
        {piece(0, end) + piece(0, end), "overlap at byte 0"},
        {piece(0, end) + piece(end, end) + extension_segment(guid, extended + "x", end, end), "disagree"},
        {extension_segment(guid, extended, 0, 50, 0xFFFFFFFF), "is 50 bytes, not 4294967295"},
        {extension_segment(guid, "<a b=", 0, 5), "not well-formed"},
    };
    for (const auto& [segments, word] : cases) {
        const auto xmp = read_jpeg_xmp(jpeg_around(main_packet() + segments), "x.jpg");
        ASSERT_FALSE(xmp) << word;
        EXPECT_EQ(xmp.error().kind, ErrorKind::input);
        EXPECT_TRUE(message(xmp).starts_with("x.jpg: ")) << message(xmp);
        EXPECT_TRUE(is_refused(xmp, word));
    }
}

}  // namespace
}  // namespace touchable::test
