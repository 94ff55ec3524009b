#include "engine/stream/stream_url.hpp"

#include <gtest/gtest.h>

namespace touchable {
namespace {

TEST(StreamUrl, PartsOfOne) {
    const auto srt = read_stream_url("srt://192.168.0.5:7000?mode=caller&latency=60000");
    ASSERT_TRUE(srt) << srt.error().message;
    EXPECT_EQ(srt->transport, StreamTransport::srt);
    EXPECT_EQ(srt->host, "192.168.0.5");
    EXPECT_EQ(srt->port, 7000);
    EXPECT_EQ(srt->value("mode"), "caller");
    EXPECT_EQ(srt->value("latency"), "60000");
    EXPECT_EQ(srt->value("late"), "");
    EXPECT_EQ(srt->protocols(), "") << "FFmpeg has no part in it";
    const auto web = read_stream_url("https://example.org/a/clip.m3u8?key=1");
    ASSERT_TRUE(web) << web.error().message;
    EXPECT_EQ(web->path, "/a/clip.m3u8");
    EXPECT_EQ(web->port, 443);
    EXPECT_EQ(read_stream_url("http://example.org")->port, 80);
    EXPECT_EQ(read_stream_url("http://0.0.0.0:0/live")->port, 0);
    EXPECT_EQ(web->protocols(), "https,tls,tcp");
    const auto six = read_stream_url("tcp://[::1]:0");
    ASSERT_TRUE(six) << six.error().message;
    EXPECT_EQ(six->host, "::1");
    EXPECT_EQ(read_stream_url("-")->text, "pipe:0");
    EXPECT_EQ(read_stream_url("pipe:3")->text, "pipe:3");
}

TEST(StreamUrl, ItsNameKeepsItsPassphrase) {
    EXPECT_EQ(read_stream_url("srt://h:1?passphrase=0123456789&latency=5")->name(),
              "srt://h:1?passphrase=...&latency=5");
    EXPECT_EQ(without_passphrase("srt://h:1?latency=5&passphrase=latency=50"),
              "srt://h:1?latency=5&passphrase=...");
    EXPECT_EQ(without_passphrase("srt://h?Passphrase=0123456789"), "srt://h?Passphrase=...");
    EXPECT_EQ(without_passphrase("http://me:secret@h/a.mkv"), "http://...@h/a.mkv");
    for (const char* const words :
         {"srt://h:99999?passphrase=0123456789", "srt://h:1?passphrase=012345", "http://me:0123456789@h/"}) {
        const auto url = read_stream_url(words);
        ASSERT_FALSE(url) << words;
        EXPECT_EQ(url.error().message.find("01234"), std::string::npos) << url.error().message;
    }
    EXPECT_EQ(without_passphrase("clip.mkv"), "clip.mkv");
}

TEST(StreamUrl, WhatIsNoneIsRefused) {
    for (const char* const words :
         {"tcp://host", "tcp://host:", "tcp://host:65536", "tcp://host:-1", "tcp://host:1x", "tcp://host:1/a",
          "tcp://[::1:5", "tcp://[]:5", "tcp://a b:5", "tcp://u@h:5", "http://", "http:///a", "pipe:x",
          "pipe:-1", "srt://h:5?mode=caller&foo=1", "udp://h:5?latency=1", "tcp://h:5?listen=1", "file:/a",
          "rtmp://h/a"}) {
        const auto url = read_stream_url(words);
        ASSERT_FALSE(url) << words;
        EXPECT_EQ(url.error().kind, ErrorKind::usage) << words;
    }
    EXPECT_FALSE(is_stream_url("clip.mkv"));
    EXPECT_FALSE(is_stream_url("folder/tcp"));
    EXPECT_TRUE(is_stream_url("tcp://anything"));
}

}  // namespace
}  // namespace touchable
