// MP4 clips that are cut or changed: an error of one line, or frames; of those that are cut, all or none.
#include <gtest/gtest.h>

#include "engine/clip/clip_file.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/sweep.hpp"
#include "tests/video/mp4_boxes.hpp"

namespace touchable::test {
namespace {

/// A clip as bytes, and a place for damaged copies.
struct Mp4Subject {
    Mp4Subject() {
        auto writer = create_mp4_clip(folder / "whole.mp4", scene, exact_clip);
        EXPECT_EQ(message(writer), "");
        for (int n = 0; n < frames; ++n)
            EXPECT_EQ(message((*writer)->write(test_frame(scene, n, planes))), "");
        EXPECT_EQ(message((*writer)->finish()), "");
        bytes = read_bytes(folder / "whole.mp4");
    }
    /// Nothing where it opened and was read to its end; otherwise the error, of one line.
    std::string error_of(const std::string& damaged) {
        std::filesystem::remove(folder / "damaged.mp4");
        write_bytes(folder / "damaged.mp4", damaged);
        const auto read = read_clip(folder / "damaged.mp4");
        if (read) {
            EXPECT_FALSE(read->empty());
            EXPECT_LE(read->size(), static_cast<std::size_t>(frames));
            return "";
        }
        EXPECT_EQ(read.error().message.find('\n'), std::string::npos) << read.error().message;
        EXPECT_EQ(read.error().message.find((folder / "damaged.mp4").string() + ": "), 0U)
            << read.error().message;
        EXPECT_EQ(read.error().kind, ErrorKind::input) << read.error().message;
        return read.error().message;
    }
    static constexpr int frames = 2;
    static constexpr Planes planes{false, true};
    TemporaryFolder folder;
    Scene scene = small_scene(8, 8, 12);
    std::string bytes;
};

TEST(Mp4Damage, OneThatIsCutIsRefusedWhereverItIs) {
    Mp4Subject subject;
    EXPECT_EQ(subject.error_of(subject.bytes), "");
    for (std::size_t length = 0; length < subject.bytes.size(); length += sweep_step())
        EXPECT_NE(subject.error_of(subject.bytes.substr(0, length)), "") << length;
}

TEST(Mp4Damage, AChangedByteOfItsMovieBoxIsAnErrorOrLeavesFrames) {
    Mp4Subject subject;
    const FoundBox movie = boxes_of(subject.bytes).back();
    int refused = 0;
    for (const int change : {0x01, 0x80, 0xFF})
        for (std::size_t at = movie.at + static_cast<std::size_t>(change % 3); at < movie.end;
             at += 3 * sweep_step()) {
            std::string damaged = subject.bytes;
            damaged[at] = static_cast<char>(damaged[at] ^ change);
            refused += subject.error_of(damaged).empty() ? 0 : 1;
        }
    EXPECT_GT(refused, 100);
}

TEST(Mp4Damage, AChangedByteOfItsSceneIsAnErrorOrIsTold) {
    Mp4Subject subject;
    const auto boxes = boxes_of(subject.bytes);
    const FoundBox& scene = boxes[boxes.size() - 2];
    int refused = 0, tried = 0;
    for (std::size_t at = scene.at; at < scene.end; at += sweep_step()) {
        std::string damaged = subject.bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
        refused += subject.error_of(damaged).empty() ? 0 : 1;
        ++tried;
    }
    EXPECT_GT(4 * refused, tried);
}

}  // namespace
}  // namespace touchable::test
