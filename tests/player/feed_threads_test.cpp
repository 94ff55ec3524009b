// The threads of a live session's frames when the machine has nothing more to give.
#include "player/session/feed_threads.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <new>
#include <thread>

#include "tests/frame/allocations.hpp"

namespace touchable::test {
namespace {

/// A clip that takes all the memory there is.
class Insatiable final : public ClipReader {
public:
    Insatiable() {
        scene_.width = 720;
        scene_.height = 480;
    }
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return 3; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<void> rewind() override { return {}; }
    Result<std::optional<RawFrame>> next() override {
        refuse_allocations();
        throw std::bad_alloc();
    }

private:
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
};

TEST(FeedThreads, MemoryThatIsGoneIsSaidWithoutMoreOfIt) {
    auto reader = std::make_unique<Insatiable>();
    const Scene scene = reader->scene();
    SurfaceFeed feed(std::move(reader), make_reference_builder(scene), scene);
    FeedThreads threads(feed, [](const RawFrame&) { return false; });
    ASSERT_TRUE(threads.start().ok());
    while (!threads.error()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    threads.stop();
    EXPECT_EQ(threads.error()->kind, ErrorKind::input);
    EXPECT_EQ(threads.error()->message, "memory does not suffice for frames of 720x480 pixels");
}

}  // namespace
}  // namespace touchable::test
