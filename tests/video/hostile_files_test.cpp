#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/jpeg_with_xmp.hpp"
#include "tests/limited_memory.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

constexpr std::uint64_t gibibyte = std::uint64_t{1} << 30;

/// A file of this beginning, and from there holes up to `size` bytes.
std::filesystem::path sparse(const TemporaryFolder& folder, const std::string& begin, std::uint64_t size) {
    write_bytes(folder / "large", begin);
    std::filesystem::resize_file(folder / "large", size);
    return folder / "large";
}

/// What opening says in little memory.
std::string refusal_in(const std::filesystem::path& file, rlim_t mebibytes) {
    const LimitedMemory little(mebibytes);
    return message(open_clip(file));
}

/// An element's size in eight bytes.
std::string element(const std::string& id, std::uint64_t size) {
    return id + '\1' + big_endian(size, 7);
}
const std::string segment_id = "\x18\x53\x80\x67", head = "\x1a\x45\xdf\xa3\x80";

TEST(HostileFiles, AnElementWhoseHeaderLeavesItsSegment) {
    const TemporaryFolder folder;
    const std::string clip = head + segment_id + '\x81' + element("\x81", 8 * gibibyte);
    ASSERT_EQ(clip.size(), 19U);
    write_bytes(folder / "clip.mkv", clip);
    EXPECT_NE(refusal_in(folder / "clip.mkv", 256).find("is damaged near byte 10"), std::string::npos);
}

TEST(HostileFiles, LargeElementsAreNotReadWhole) {
    const TemporaryFolder folder;
    const auto of_one = [&](const std::string& id) {
        const std::string begin =
            head + element(segment_id, 5 * gibibyte + id.size() + 8) + element(id, 5 * gibibyte);
        return refusal_in(sparse(folder, begin, begin.size() + 5 * gibibyte), 256);
    };
    EXPECT_NE(of_one("\xec").find("is not a "),
              std::string::npos);  // padding alone: not a clip, or no Matroska
    EXPECT_NE(of_one("\x19\x41\xa4\x69").find("larger than 64 MiB together"), std::string::npos);
}

TEST(HostileFiles, AFileThatBeginsLikeAJpeg) {
    const TemporaryFolder folder;
    EXPECT_NE(refusal_in(sparse(folder, "\xff\xd8\xff\xe1", 5 * gibibyte), 256).find("larger than 257 MiB"),
              std::string::npos);
    EXPECT_TRUE(is_refused(read_image(folder / "large"), "larger than 257 MiB"));
}

TEST(HostileFiles, LargePicturesAreReadUpToTheSizeThatIsSaid) {
    const TemporaryFolder folder;
    const std::string head_of_floats = "Pf\n8192 8192\n-1.0\n";
    const std::uint64_t values = std::uint64_t{4} * 8192 * 8192;
    const auto floats = read_picture_bytes(sparse(folder, head_of_floats, head_of_floats.size() + values));
    EXPECT_EQ(message(floats), "");
    const std::uint64_t most = std::uint64_t{257} << 20U;
    EXPECT_EQ(message(read_picture_bytes(sparse(folder, head_of_floats, most))), "");
    EXPECT_EQ(message(read_picture_bytes(sparse(folder, head_of_floats, most + 1))),
              (folder / "large").string() + ": is larger than 257 MiB; right would be a picture");
}

TEST(HostileFiles, ASceneFileIsAFile) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 1, {})), "");
    ASSERT_EQ(mkfifo((folder / "pipe.json").c_str(), 0600), 0);
    alarm(30);  // a reader waits for ever for a writer
    const std::pair<std::filesystem::path, std::string> kinds[] = {
        {folder / "pipe.json", "a pipe, no ordinary file"},
        {folder.path(), "a folder"},
        {"/dev/zero", "a device, no ordinary file"}};
    for (const auto& [file, kind] : kinds)
        EXPECT_EQ(
            message(open_clip(folder / "clip.mkv", file)),
            file.string() + ": is " + kind + "; right would be a scene file (JSON, docs/scene_file.md)");
    alarm(0);
}

TEST(HostileFiles, OnlyCodecsThatAreNeededAreRead) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "good.mkv", small_scene(64, 48), 2, {true})), "");
    remux(folder / "good.mkv", folder / "clip.mkv", {.transcoded = {{"colour", "msmpeg4v2"}}});
    EXPECT_TRUE(is_refused(open_clip(folder / "clip.mkv"),
                           "track colour: has codec msmpeg4v2: must be one of ffv1,"));
}

TEST(HostileFiles, WhatIsQuotedIsShortAndOnOneLine) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "good.mkv", small_scene(16, 16), 1, {})), "");
    const std::string tag = "1\n\x1b[31m" + std::string(100'000, 'x');
    remux(folder / "good.mkv", folder / "clip.mkv", {.file_tags = {{"T3D_RATE", tag}}});
    const std::string refusal = message(open_clip(folder / "clip.mkv"));
    EXPECT_NE(refusal.find("is \"1\\n\\x1b[31mxxx"), std::string::npos) << refusal;
    EXPECT_LT(refusal.size(), 300U);
}

}  // namespace
}  // namespace touchable::test
