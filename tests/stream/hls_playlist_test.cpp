#include "engine/stream/hls.hpp"

#include <gtest/gtest.h>

#include <string>

namespace touchable {
namespace {

const std::string web = "http://host:8080/live/clip/master.m3u8?token=1";
const std::string home = "file:/srv/a b/master.m3u8";

std::string resolved(const std::string& base, const std::string& named) {
    const auto place = resolved_place(base, named);
    return place ? *place : "refused";
}

TEST(HlsPlaylist, PlacesBesideIt) {
    EXPECT_EQ(resolved(web, "touch.m3u8"), "http://host:8080/live/clip/touch.m3u8");
    EXPECT_EQ(resolved(web, "a/b.m4s?x=1"), "http://host:8080/live/clip/a/b.m4s?x=1");
    EXPECT_EQ(resolved(web, "/b.m4s"), "http://host:8080/b.m4s");
    EXPECT_EQ(resolved(web, "../b.m4s"), "http://host:8080/live/b.m4s");
    EXPECT_EQ(resolved(web, "../../../../b.m4s"), "http://host:8080/b.m4s");
    EXPECT_EQ(resolved(web, "/.."), "http://host:8080/");
    EXPECT_EQ(resolved(web, ".."), "http://host:8080/live/");
    EXPECT_EQ(resolved(web, "a/./.?x=1"), "http://host:8080/live/clip/a/?x=1");
    EXPECT_EQ(resolved(web, "?x=2"), "http://host:8080/live/clip/master.m3u8?x=2");
    EXPECT_EQ(resolved(web, "HTTP://Host:8080/b"), "http://host:8080/b");
    EXPECT_EQ(resolved(web, "//host:8080/b"), "http://host:8080/b");
    EXPECT_EQ(resolved("http://host", "b"), "http://host/b");
    EXPECT_EQ(resolved(home, "touch.m3u8"), "file:/srv/a b/touch.m3u8");
    EXPECT_EQ(resolved(home, "sub/x 1.m4s"), "file:/srv/a b/sub/x 1.m4s");
}

TEST(HlsPlaylist, PlacesElsewhereAreRefused) {
    for (const char* const named :
         {"http://other/b", "http://host:8081/b", "https://host:8080/b", "file:/etc/passwd",
          "file:///etc/passwd", "data:text/plain,x", "concat:a|b", "//other/b", "tcp://host:8080", "a b",
          "a\tb", "a\\b", "", "http://host:8080@other/b", "crypto:b", "pipe:0"})
        EXPECT_EQ(resolved(web, named), "refused") << named;
    for (const char* const named :
         {"../x", "a/../../x", "/etc/passwd", "http://host/b", "file:/srv/a b/x", ".."})
        EXPECT_EQ(resolved(home, named), "refused") << named;
    EXPECT_EQ(resolved(web, "https://other/b"), "refused");
    EXPECT_EQ(resolved(web, "file:/etc/passwd"), "refused");
    EXPECT_EQ(resolved(home, "http://other/b"), "refused");
}

TEST(HlsPlaylist, OurMasterLeadsToBoth) {
    const std::string text = master_text({"colour.m3u8", 1000, "avc1.64001f", 640, 480, 30});
    const auto places = places_in_playlist(text, web);
    ASSERT_TRUE(places) << places.error().message;
    EXPECT_EQ(places->touch, "http://host:8080/live/clip/touch.m3u8");
    EXPECT_EQ(places->colour, "http://host:8080/live/clip/colour.m3u8");
    const auto alone =
        places_in_playlist(master_text({"touch.m3u8", 1000, "avc1.64001f", 640, 480, 30}), web);
    ASSERT_TRUE(alone);
    EXPECT_EQ(alone->colour, "");
}

TEST(HlsPlaylist, MasterLeadsToLowLevel) {
    const HlsShown full{"colour.m3u8", 2000, "avc1.64001f", 640, 480, 30},
        low{"low.m3u8", 1000, "", 640, 480, 30};
    const auto places = places_in_playlist(master_text(full, low), web);
    ASSERT_TRUE(places) << places.error().message;
    EXPECT_EQ(places->colour, "http://host:8080/live/clip/colour.m3u8");
    EXPECT_EQ(places->low_touch, "http://host:8080/live/clip/touch-low.m3u8");
    EXPECT_EQ(places->low_colour, "http://host:8080/live/clip/low.m3u8");
    // A second variant alone is no low level.
    const auto others =
        places_in_playlist(master_text(full) + "#EXT-X-STREAM-INF:BANDWIDTH=1\nhttp://other/c.m3u8\n", web);
    ASSERT_TRUE(others) << others.error().message;
    EXPECT_EQ(others->low_touch + others->low_colour, "");
    // Without colour its variants are the planes.
    const HlsShown grey{"touch.m3u8", 2000, "", 640, 480, 30},
        low_grey{"touch-low.m3u8", 1000, "", 640, 480, 15};
    const auto planes = places_in_playlist(master_text(grey, low_grey), web);
    ASSERT_TRUE(planes) << planes.error().message;
    EXPECT_EQ(planes->low_touch, "http://host:8080/live/clip/touch-low.m3u8");
    EXPECT_EQ(planes->colour + planes->low_colour, "");
}

std::string numbered_playlist() {
    return "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXT-X-MEDIA-SEQUENCE:7\n#EXT-X-MAP:URI=\"i.mp4\"\n"
           "#EXTINF:1.000000,\na.m4s\n#EXT-X-DISCONTINUITY\n#EXTINF:0.5,\nb.m4s\n#EXTINF:x,\na.m4s\n"
           "#EXT-X-ENDLIST\n";
}

TEST(HlsPlaylist, FindsSegments) {
    const std::string text = numbered_playlist(), a = "http://host:8080/live/clip/a.m4s";
    const auto first = segment_in(text, web, a, 0);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->number, 7);
    EXPECT_EQ(first->duration_ns, 1'000'000'000);
    const auto again = segment_in(text, web, a, 8);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->number, 9);
    EXPECT_EQ(again->duration_ns, 0);
    EXPECT_FALSE(segment_in(text, web, a, 10));
    EXPECT_FALSE(segment_in(text, web, "http://host:8080/live/clip/c.m4s", 0));
}

TEST(HlsPlaylist, BeginsFromASegment) {
    EXPECT_EQ(playlist_from(numbered_playlist(), 8),
              "#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:8\n#EXT-X-TARGETDURATION:1\n#EXT-X-MAP:URI=\"i.mp4\"\n"
              "#EXT-X-DISCONTINUITY\n#EXTINF:0.5,\nb.m4s\n#EXTINF:x,\na.m4s\n#EXT-X-ENDLIST\n");
    EXPECT_FALSE(playlist_from(numbered_playlist(), 10));
}

TEST(HlsPlaylist, AMediaPlaylistLeadsToItself) {
    HlsMedia media;
    media.header = "init.mp4";
    media.first = 5;
    media.segments = {{"a.m4s", 1}, {"b.m4s", 1}};
    const auto places = places_in_playlist(text_of(media), web);
    ASSERT_TRUE(places);
    EXPECT_EQ(places->touch, web);
    const auto facts = check_hls_media(text_of(media), web);
    ASSERT_TRUE(facts) << facts.error().message;
    EXPECT_EQ(facts->next_segment, 7);
    EXPECT_EQ(facts->header, "http://host:8080/live/clip/init.mp4");
    EXPECT_FALSE(facts->has_ended);
}

TEST(HlsPlaylist, HostileMastersAreRefused) {
    const std::string head = "#EXTM3U\n#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes\",VALUE=\"";
    const std::string colour = "\"\n#EXT-X-STREAM-INF:BANDWIDTH=1\n",
                      low = "t.m3u8\"\n#EXT-X-SESSION-DATA:DATA-ID=\"com.touchable.planes.low\",VALUE=\"";
    for (const std::string& text :
         {std::string(), std::string("#EXTM3U8\n"), std::string("<html>"),
          std::string("#EXTM3U\n#EXT-X-STREAM-INF:BANDWIDTH=1\nvideo.m3u8\n"),
          head + "master.m3u8?token=1" + colour + "c.m3u8\n",
          head + "t.m3u8" + colour + "/live/clip/./master.m3u8?token=1\n",
          head + "http://other/t.m3u8" + colour + "c.m3u8\n", head + "file:/etc/passwd" + colour + "c.m3u8\n",
          head + "t.m3u8" + colour + "ftp://host/c\n",
          head + low + "http://other/l.m3u8" + colour + "c.m3u8\n",
          head + low + "master.m3u8?token=1" + colour + "c.m3u8\n",
          head + low + "l.m3u8" + colour + "c.m3u8\n#EXT-X-STREAM-INF:BANDWIDTH=1\nfile:/etc/passwd\n",
          head + "t.m3u8" + colour + "c.m3u8\n" + std::string(largest_hls_playlist, '\n'),
          head + "t.m3u8" + colour + "c.m3u8\n" + std::string(1, '\0')}) {
        const auto places = places_in_playlist(text, web);
        ASSERT_FALSE(places) << text.substr(0, 200);
        EXPECT_EQ(places.error().kind, ErrorKind::input);
    }
}

TEST(HlsPlaylist, HostileMediaPlaylistsAreRefused) {
    const std::string head = "#EXTM3U\n#EXT-X-TARGETDURATION:1\n", end = "#EXTINF:1,\na.m4s\n";
    ASSERT_TRUE(check_hls_media(head + end, web));
    for (const std::string& line :
         {std::string("#EXT-X-STREAM-INF:BANDWIDTH=1\nb.m3u8\n"),
          std::string("#EXTINF:1,\nmaster.m3u8?token=1\n"),
          std::string("#EXT-X-KEY:METHOD=AES-128,URI=\"key\"\n"), std::string("#EXT-X-KEY:URI=\"key\"\n"),
          std::string("#EXT-X-MAP:URI=\"file:/etc/passwd\"\n"), std::string("#EXT-X-MAP:BYTERANGE=\"1@1\"\n"),
          std::string("#EXT-X-MAP:URI=\"a\"\n#EXT-X-MAP:URI=\"b\"\n"),
          std::string("#EXTINF:1,\nhttp://169.254.169.254/latest\n"),
          std::string("#EXT-X-MEDIA-SEQUENCE:-1\n"), std::string("#EXT-X-MEDIA:TYPE=AUDIO,URI=\"x\"\n")})
        EXPECT_FALSE(check_hls_media(head + line + end, web)) << line;
    EXPECT_FALSE(check_hls_media(head, web)) << "no segment";
}

}  // namespace
}  // namespace touchable
