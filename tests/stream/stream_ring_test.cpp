#include "engine/stream/sending.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "engine/stream/listeners.hpp"

namespace touchable {
namespace {

constexpr std::chrono::milliseconds long_enough{60'000};

void add_blocks(StreamRing& ring, std::int64_t from, std::int64_t to, std::int64_t keys = 15,
                std::size_t bytes = 10) {
    for (std::int64_t n = from; n < to; ++n)
        ring.add({n, n % keys == 0, std::vector<std::uint8_t>(bytes, static_cast<std::uint8_t>(n))});
}

std::int64_t next_frame(const StreamRing& ring, StreamRing::Cursor& cursor) {
    const auto block = ring.next(cursor);
    return block ? block->frame : -1;
}

TEST(StreamRing, WhoIsThereFromTheBeginningHasAll) {
    StreamRing ring;
    auto cursor = ring.join();
    EXPECT_EQ(ring.header(), nullptr);
    EXPECT_EQ(ring.next(cursor), nullptr);
    const std::vector<std::uint8_t> header{1, 2, 3};
    ring.begin(header);
    EXPECT_EQ(*ring.header(), header);
    add_blocks(ring, 0, 30);  // none was taken meanwhile, and a key passed by
    for (std::int64_t n = 0; n < 30; ++n) EXPECT_EQ(next_frame(ring, cursor), n);
    EXPECT_EQ(ring.next(cursor), nullptr);
    EXPECT_FALSE(ring.is_over(cursor));
    add_blocks(ring, 30, 31);
    ring.end();
    EXPECT_FALSE(ring.is_over(cursor));
    EXPECT_EQ(next_frame(ring, cursor), 30);
    EXPECT_TRUE(ring.is_over(cursor));
    EXPECT_EQ(cursor.dropped(), 0);
}

TEST(StreamRing, WhoJoinsLateBeginsWithTheNewestKey) {
    for (std::int64_t there = 1; there < 100; ++there) {
        StreamRing ring;
        add_blocks(ring, 0, there);
        auto cursor = ring.join();
        add_blocks(ring, there, there + 3);
        const auto first = ring.next(cursor);
        ASSERT_TRUE(first);
        EXPECT_TRUE(first->is_key);
        EXPECT_LT(there - 1 - first->frame, 15);
        EXPECT_EQ(next_frame(ring, cursor), first->frame + 1);
        EXPECT_EQ(cursor.dropped(), 0);
    }
}

TEST(StreamRing, GoesToNewestKeyThatIsAhead) {
    StreamRing ring;
    add_blocks(ring, 0, 18);
    auto cursor = ring.join();  // 15
    EXPECT_FALSE(ring.go_to_newest_key(cursor));
    EXPECT_EQ(next_frame(ring, cursor), 15);
    EXPECT_FALSE(ring.go_to_newest_key(cursor));
    add_blocks(ring, 18, 32);
    EXPECT_TRUE(ring.has_next(cursor));
    EXPECT_TRUE(ring.go_to_newest_key(cursor));
    EXPECT_EQ(cursor.dropped(), 14);
    EXPECT_EQ(next_frame(ring, cursor), 30);
    EXPECT_EQ(next_frame(ring, cursor), 31);
    EXPECT_FALSE(ring.has_next(cursor));
}

// One that is behind by more than the bound goes on with the newest key, and the others do not notice.
TEST(StreamRing, WhoIsTooFarBehindMissesWholeFramesets) {
    StreamRing ring({.framesets = 20, .bytes = 1'000'000});
    auto quick = ring.join(), slow = ring.join();
    for (std::int64_t n = 0; n < 20; ++n) {
        add_blocks(ring, n, n + 1);
        EXPECT_EQ(next_frame(ring, quick), n);
    }
    EXPECT_EQ(next_frame(ring, slow), 0);
    add_blocks(ring, 20, 47);
    EXPECT_EQ(next_frame(ring, slow), 45);
    EXPECT_EQ(slow.dropped(), 44);
    EXPECT_EQ(next_frame(ring, slow), 46);
    EXPECT_EQ(next_frame(ring, quick), 45) << "it had taken nothing for 27 either";
    EXPECT_EQ(quick.dropped(), 25);
}

TEST(StreamRing, BytesAreBoundedToo) {
    StreamRing ring({.framesets = 1000, .bytes = 10'000});
    auto cursor = ring.join();
    add_blocks(ring, 0, 10, 5, 1000);
    EXPECT_EQ(next_frame(ring, cursor), 0);
    add_blocks(ring, 10, 13, 5, 1000);
    EXPECT_EQ(next_frame(ring, cursor), 10);
    EXPECT_EQ(cursor.dropped(), 9);
    // From the newest key on everything is kept, however large, so that decoding can begin.
    auto late = ring.join();
    add_blocks(ring, 13, 15, 5, 50'000);
    for (std::int64_t n = 10; n < 15; ++n) EXPECT_EQ(next_frame(ring, late), n);
    std::weak_ptr<const StreamMuxer::Block> old;
    {
        auto first = ring.join();
        old = ring.next(first);
    }
    EXPECT_FALSE(old.expired());
    add_blocks(ring, 15, 16, 5, 1000);
    EXPECT_TRUE(old.expired()) << "a key more, and what is before it goes";
}

TEST(StreamRing, WhoWaitsIsWoken) {
    StreamRing ring;
    int woken = 0;
    ring.watch([&woken] { ++woken; });
    std::thread sender([&ring] {
        add_blocks(ring, 0, 3);
        ring.end();
    });
    auto cursor = ring.join();
    for (std::int64_t n = 0; n < 3; ++n) {
        const auto block = ring.wait_next(cursor, long_enough);
        ASSERT_TRUE(block);
        EXPECT_EQ(block->frame, n);
    }
    EXPECT_EQ(ring.wait_next(cursor, long_enough), nullptr);
    EXPECT_TRUE(ring.is_over(cursor));
    sender.join();
    EXPECT_EQ(woken, 4);
}

int status_of(std::string_view request, std::size_t at_once = 1000) {
    HttpRequest asked("/live.mkv");
    for (; !request.empty(); request.remove_prefix(std::min(at_once, request.size())))
        asked.take(request.substr(0, at_once));
    return asked.status();
}

TEST(HttpRequest, OnlyTheStreamIsGiven) {
    for (const std::size_t at_once : {1U, 2U, 3U, 1000U}) {
        EXPECT_EQ(status_of("GET /live.mkv HTTP/1.1\r\nHost: a\r\n\r\n", at_once), 200);
        EXPECT_EQ(status_of("GET /live.mkv?x=1 HTTP/1.0\n\n", at_once), 200);
        EXPECT_EQ(status_of("HEAD /live.mkv HTTP/1.1\r\n\r\n", at_once), 200);
        EXPECT_EQ(status_of("GET /live.mkv HTTP/1.1\r\nHost: a\r\n", at_once), 0);
        EXPECT_EQ(status_of("GET / HTTP/1.1\r\n\r\n", at_once), 404);
        EXPECT_EQ(status_of("GET /live.mkv/../a HTTP/1.1\r\n\r\n", at_once), 404);
        EXPECT_EQ(status_of("POST /live.mkv HTTP/1.1\r\n\r\n", at_once), 405);
        EXPECT_EQ(status_of("GET live.mkv HTTP/1.1\r\n\r\n", at_once), 400);
        EXPECT_EQ(status_of("GET /live.mkv HTTP/9\r\n\r\n", at_once), 400);
        EXPECT_EQ(status_of("GET /live.mkv HTTP/1.1 x\r\n\r\n", at_once), 400);
        EXPECT_EQ(status_of("GET /live.mkv\r\n\r\n", at_once), 400);
        EXPECT_EQ(status_of("\r\n\r\n", at_once), 400);
        EXPECT_EQ(status_of(std::string(10, '\0') + "\n\n", at_once), 400);
    }
    EXPECT_EQ(status_of("GET /live.mkv HTTP/1.1\r\nA: " + std::string(8000, 'a')), 0);
    EXPECT_EQ(status_of("GET /live.mkv HTTP/1.1\r\nA: " + std::string(9000, 'a')), 400);
    EXPECT_EQ(status_of("GET /live.mkv HTTP/1.1\r\nA: " + std::string(9000, 'a') + "\r\n\r\n"), 400);
    HttpRequest head("/"), get("/");
    head.take("HEAD / HTTP/1.1\r\n\r\nGET / HTTP/1.1\r\n\r\n");
    get.take("GET / HTTP/1.1\r\n\r\n");
    EXPECT_TRUE(head.is_head());
    EXPECT_FALSE(get.is_head());
}

}  // namespace
}  // namespace touchable
