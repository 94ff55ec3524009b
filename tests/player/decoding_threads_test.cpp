// Tracks of large pictures are decoded on threads of their own: whoever reads may be slow, fast, or gone.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "engine/clip/clip_file.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr Planes ramps{true, false, false, false};
constexpr int clip_frames = 17;

class DecodingThreads : public ::testing::TestWithParam<Archive> {
protected:
    void SetUp() override {
        scene_ = small_scene(320, 160, 16);  // large enough for threads
        ASSERT_EQ(message(write_clip(file(), scene_, clip_frames, ramps, {GetParam(), true})), "");
    }
    std::filesystem::path file() const { return folder_ / "clip.mkv"; }
    std::unique_ptr<ClipReader> open() const {
        auto reader = open_clip(file());
        EXPECT_EQ(message(reader), "");
        return reader ? std::move(*reader) : nullptr;
    }
    void expect_frames(ClipReader& reader, int from, int to) const {
        for (int n = from; n < to; ++n) {
            const auto frame = reader.next();
            ASSERT_EQ(message(frame), "");
            ASSERT_TRUE(frame->has_value()) << n;
            EXPECT_TRUE(same_frame(**frame, test_frame(scene_, n, ramps))) << n;
        }
    }

    TemporaryFolder folder_;
    Scene scene_;
};

TEST_P(DecodingThreads, GiveTheSameToASlowReaderAndToAFastOne) {
    const auto fast = open(), slow = open();
    ASSERT_TRUE(fast && slow);
    expect_frames(*fast, 0, clip_frames);
    for (int n = 0; n < 6; ++n) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        expect_frames(*slow, n, n + 1);
    }
    EXPECT_FALSE((*fast->next()).has_value());
}

TEST_P(DecodingThreads, EndWithTheirReader) {
    for (int read = 0; read < 4; ++read) expect_frames(*open(), 0, read);
}

TEST_P(DecodingThreads, StartAgainWhereTheyAreSent) {
    const auto reader = open();
    for (const int from : {12, 3, 14, 0}) {
        ASSERT_EQ(message(reader->seek(from)), "");
        expect_frames(*reader, from, from + 3);
    }
}

TEST_P(DecodingThreads, TellDamageOfTheFrameThatHasIt) {
    std::string bytes = read_bytes(file());
    bytes[bytes.size() * 9 / 10] ^= 0x08;
    write_bytes(file(), bytes);
    const auto reader = open();
    ASSERT_TRUE(reader);
    const Result<std::vector<RawFrame>> frames = test::read_all(static_cast<ClipReader&>(*reader));
    EXPECT_NE(message(frames).find("is damaged"), std::string::npos) << message(frames);
    EXPECT_NE(message(reader->next()), "");  // and goes on telling
}

INSTANTIATE_TEST_SUITE_P(, DecodingThreads, ::testing::Values(Archive::fast, Archive::small),
                         [](const auto& archive) {
                             return std::string(archive.param == Archive::fast ? "Fast" : "Small");
                         });

}  // namespace
}  // namespace touchable::test
