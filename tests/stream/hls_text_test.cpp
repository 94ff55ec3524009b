#include "engine/stream/hls.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace touchable {
namespace {

TEST(HlsText, AWindowOfALiveStream) {
    HlsMedia media;
    media.target_s = 1;
    media.first = 7;
    media.header = "touch-init.mp4";
    media.segments = {{"touch-7.m4s", 1'000'000'000, 1'700'000'000'250'000'000},
                      {"touch-8.m4s", 966'666'667, 0, true}};
    const std::string head =
        "#EXTM3U\n#EXT-X-VERSION:7\n## written by touchable\n#EXT-X-INDEPENDENT-SEGMENTS\n"
        "#EXT-X-TARGETDURATION:1\n#EXT-X-MEDIA-SEQUENCE:7\n";
    const std::string rest =
        "#EXT-X-MAP:URI=\"touch-init.mp4\"\n"
        "#EXT-X-PROGRAM-DATE-TIME:2023-11-14T22:13:20.250Z\n#EXTINF:1.000000,\ntouch-7.m4s\n"
        "#EXT-X-DISCONTINUITY\n#EXTINF:0.966667,\ntouch-8.m4s\n";
    EXPECT_EQ(text_of(media), head + rest);
    EXPECT_EQ(next_segment_of(text_of(media)), 9);
    media.is_whole = media.has_ended = true;
    EXPECT_EQ(text_of(media), head + "#EXT-X-PLAYLIST-TYPE:VOD\n" + rest + "#EXT-X-ENDLIST\n");
}

TEST(HlsText, NextSegmentOfNoPlaylistIsTheFirst) {
    EXPECT_EQ(next_segment_of(""), 0);
    EXPECT_EQ(next_segment_of("#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:-5\n"), 0);
    EXPECT_EQ(next_segment_of("#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:99999999999999999999\n"), 0);
}

TEST(HlsText, AMasterNamesWhatPlayersShowAndWhereTouchIs) {
    EXPECT_EQ(master_text({"colour.m3u8", 2'500'000, "avc1.64001f,mp4a.40.2", 640, 480, 30000.0 / 1001}),
              "#EXTM3U\n#EXT-X-VERSION:7\n## written by touchable\n#EXT-X-INDEPENDENT-SEGMENTS\n"
              "#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes\",VALUE=\"touch.m3u8\"\n"
              "#EXT-X-STREAM-INF:BANDWIDTH=2500000,CODECS=\"avc1.64001f,mp4a.40.2\",RESOLUTION=640x480,"
              "FRAME-RATE=29.970\ncolour.m3u8\n");
}

TEST(HlsText, MasterNamesTheLowLevel) {
    const HlsShown full{"colour.m3u8", 2'500'000, "avc1.64001f", 640, 480, 30},
        low{"colour-low.m3u8", 1'250'000, "avc1.64001e", 640, 480, 30};
    EXPECT_EQ(master_text(full, low),
              "#EXTM3U\n#EXT-X-VERSION:7\n## written by touchable\n#EXT-X-INDEPENDENT-SEGMENTS\n"
              "#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes\",VALUE=\"touch.m3u8\"\n"
              "#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes.low\",VALUE=\"touch-low.m3u8\"\n"
              "#EXT-X-STREAM-INF:BANDWIDTH=2500000,CODECS=\"avc1.64001f\",RESOLUTION=640x480,"
              "FRAME-RATE=30.000\ncolour.m3u8\n"
              "#EXT-X-STREAM-INF:BANDWIDTH=1250000,CODECS=\"avc1.64001e\",RESOLUTION=640x480,"
              "FRAME-RATE=30.000\ncolour-low.m3u8\n");
}

TEST(HlsText, NamesOfCodecs) {
    constexpr std::array<std::uint8_t, 12> header{0, 0, 0, 1, 0x67, 0x64, 0x00, 0x1f, 0xac, 0, 0, 1};
    EXPECT_EQ(avc_codec_name(header), "avc1.64001f");
    EXPECT_FALSE(avc_codec_name(std::span(header).first(7)));
    EXPECT_FALSE(avc_codec_name({}));
}

}  // namespace
}  // namespace touchable
