// SPDX-License-Identifier: Apache-2.0
// ZIP archives of pictures, opened as the folders that they unpack to.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zip.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stop_token>

#include "engine/base/threads.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/zip_folder.hpp"
#include "engine/picture/image.hpp"
#include "tests/picture/results.hpp"

namespace {
bool clock_runs_away = false;  // an hour passes between two looks at it
}

/// Replaces the C library's in the whole program.
extern "C" int clock_gettime(clockid_t clock, timespec* now) noexcept {
    static time_t ahead = 0;
    const auto done = static_cast<int>(syscall(SYS_clock_gettime, clock, now));
    if (clock_runs_away) now->tv_sec += ahead += 3600;
    return done;
}

namespace touchable::test {
namespace {

struct Packed {
    std::string name, bytes;
    mode_t mode = S_IFREG | 0644;
    bool is_encrypted = false, is_stored = false;
};

void write_zip(const std::filesystem::path& file, const std::vector<Packed>& members) {
    zip_t* const archive = zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
    ASSERT_NE(archive, nullptr);
    for (const Packed& each : members) {
        zip_source_t* const source = zip_source_buffer(archive, each.bytes.data(), each.bytes.size(), 0);
        const auto index = zip_file_add(archive, each.name.c_str(), source, ZIP_FL_ENC_UTF_8);
        ASSERT_GE(index, 0) << zip_strerror(archive);
        const auto number = static_cast<zip_uint64_t>(index);
        zip_set_file_compression(archive, number, each.is_stored ? ZIP_CM_STORE : ZIP_CM_DEFLATE, 1);
        zip_file_set_external_attributes(archive, number, 0, ZIP_OPSYS_UNIX, each.mode << 16);
        if (each.is_encrypted) zip_file_set_encryption(archive, number, ZIP_EM_TRAD_PKWARE, "secret");
    }
    ASSERT_EQ(zip_close(archive), 0) << zip_strerror(archive);
}

class ZipFolders : public ::testing::Test {
protected:
    ZipFolders() {
        const char* const before = std::getenv("TMPDIR");
        if (before) before_ = before;
        setenv("TMPDIR", temporary.path().c_str(), 1);
        const TemporaryFolder pictures;
        write_in_folder(pictures / "d.png",
                        made_image(16, 12, 2, 1, [](int x, int, int) { return 771 + x % 7; }));
        write_in_folder(pictures / "c.png", made_image(16, 12, 1, 3, [](int x, int y, int c) {
                            return x + y + c == 0 ? 10 : 90;
                        }));
        depth = read_bytes(pictures / "d.png");
        colour = read_bytes(pictures / "c.png");
    }
    ~ZipFolders() override {
        // Nothing is left behind, whatever came of it.
        EXPECT_EQ(temporary.file_count(), 0U);
        if (before_)
            setenv("TMPDIR", before_->c_str(), 1);
        else
            unsetenv("TMPDIR");
    }
    /// The message about an archive of these and a picture of depth. It names no temporary file.
    std::string refusal(std::vector<Packed> members, const std::string& name = "a.zip") const {
        members.push_back({"set/depth/0.png", depth});
        write_zip(folder / name, members);
        return refusal_of(name);
    }
    std::string refusal_of(const std::string& name) const {
        const std::string said = message(open_clip(folder / name));
        EXPECT_EQ(said.find(temporary.path().string() + '/'), std::string::npos) << said;
        EXPECT_TRUE(said.empty() || said.starts_with((folder / name).string())) << said;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        EXPECT_EQ(temporary.file_count(), 0U) << said;
        return said;
    }
    TemporaryFolder temporary, folder;
    std::string depth, colour;

private:
    std::optional<std::string> before_;
};

/// All places of `old` in a file.
void replace_bytes(const std::filesystem::path& file, const std::string& old, const std::string& other) {
    ASSERT_EQ(old.size(), other.size());
    std::string bytes = read_bytes(file);
    int count = 0;
    for (auto at = bytes.find(old); at != std::string::npos; at = bytes.find(old, at + 1), ++count)
        bytes.replace(at, old.size(), other);
    ASSERT_GT(count, 0);
    write_bytes(file, bytes);
}

TEST_F(ZipFolders, OpenAsFolders) {
    write_zip(folder / "scan.zip", {{"set/", "", S_IFDIR | 0755},
                                    {"set/info.json", "{}"},
                                    {"set/thumbnail.jpg", "no picture"},
                                    {"set/frames/depth/0.png", depth},
                                    {"./set/frames/depth/1.png", depth, S_IFREG | 0644, false, true},
                                    {"set/frames/rgb/0.png", colour},
                                    {"set/frames/rgb/1.png", colour},
                                    {"__MACOSX/set/frames/depth/._0.png", "of macOS"},
                                    {"set/frames/depth/.hidden.png", "hidden"}});
    for (int again = 0; again < 2; ++again) {
        auto reader = open_clip(folder / "scan.zip");
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ(temporary.file_count(), 1U);
        struct stat about {};
        const auto unpacked = std::filesystem::directory_iterator(temporary.path())->path();
        ASSERT_EQ(stat(unpacked.c_str(), &about), 0);
        EXPECT_EQ(about.st_mode & 0777, 0700U);
        EXPECT_TRUE(is_noted(**reader, "depth is depth/*.png, colour is rgb/*.png"));
        EXPECT_EQ((*reader)->scene().name, "frames");
        EXPECT_EQ((*reader)->inputs(), std::vector{folder / "scan.zip"});
        for (int pass = 0; pass < 2; ++pass) {
            const auto frames = must(read_all(**reader));
            ASSERT_EQ(frames.size(), 2U);
            EXPECT_EQ(frames.front().colour.sample(0, 0, 0), 10);
            ASSERT_EQ(message((*reader)->rewind()), "");
        }
        reader = input_error("closed");
        EXPECT_EQ(temporary.file_count(), 0U);
    }
    // A folder in it, by name.
    const auto inner = must(open_clip(folder / "scan.zip" / "set" / "frames"));
    EXPECT_EQ(inner->frame_count(), 2);
    EXPECT_EQ(inner->inputs(), std::vector{folder / "scan.zip"});
}

TEST_F(ZipFolders, OpenBySceneFile) {
    const std::string scene = R"({"touchable_scene": 1, "width": 16, "height": 12,
        "camera": {"fx": 77, "fy": 77, "cx": 8, "cy": 6}, "metres_per_unit": 1,
        "depth": {"coding": "metric", "scale": 0.001, "near": 0.5, "far": 8, "invalid": [0]},
        "folder": {"depth": "d/*.png"}})";
    write_zip(folder / "bare.zip", {{"x/d/0.png", depth}, {"x/d/1.png", depth}});
    write_zip(folder / "own.zip", {{"x/d/0.png", depth}, {"x/scene.json", scene}, {"depth/x/0.png", depth}});
    write_bytes(folder / "my.json", scene);
    // The folder that all members are in is x/d, but a person's scene file is of the archive's only folder.
    const auto named = must(open_clip(folder / "bare.zip" / "x", folder / "my.json"));
    EXPECT_EQ(named->scene().camera.fx, 77);
    EXPECT_EQ(named->inputs(), (std::vector{folder / "bare.zip", folder / "my.json"}));
    const auto own = open_clip(folder / "own.zip");
    ASSERT_EQ(message(own), "");
    EXPECT_EQ((*own)->scene().camera.fx, 77);
    EXPECT_EQ((*own)->inputs(), std::vector{folder / "own.zip"});
    const auto guessed = guess_clip(folder / "bare.zip", {});
    EXPECT_TRUE(is_refused(guessed, "is a ZIP file, whose first member is"));
}

TEST_F(ZipFolders, NameSeveralFolders) {
    write_zip(folder / "a.zip", {{"one/a/depth/0.png", depth}, {"two/a/depth/0.png", depth}});
    EXPECT_TRUE(
        has_words(refusal_of("a.zip"), "touchable play " + (folder / "a.zip/one").string() + " (one of 2"));
    EXPECT_EQ(message(open_clip(folder / "a.zip/one")), "");
    EXPECT_TRUE(is_refused(open_clip(folder / "a.zip/three"), "a.zip: has no folder \"three\""));
}

TEST_F(ZipFolders, RefuseNamesThatLeadOut) {
    const std::string outside = (folder / "outside.png").string();
    for (const std::string& name :
         {std::string("../escaped.png"), std::string("set/../../escaped.png"), outside,
          std::string("set\\depth\\1.png"), std::string("set/de\tpth.png")}) {
        const std::string said = refusal({{name, colour}});
        EXPECT_TRUE(has_words(said, "a.zip: its member \"")) << name << ": " << said;
    }
    EXPECT_FALSE(std::filesystem::exists(outside));
    EXPECT_FALSE(std::filesystem::exists(temporary.path().parent_path() / "escaped.png"));
    // The archive's own name leads nowhere either.
    EXPECT_EQ(refusal({}, "...zip"), "");
}

TEST_F(ZipFolders, RefuseDeepAndManyFolders) {
    const auto below = [](std::string top, int folders) {
        for (; folders > 0; --folders) top += "/a";
        return top + "/notes.txt";
    };
    EXPECT_EQ(refusal({{below("a", 63), "64 folders"}}), "");
    const std::string deep = refusal({{below("a", 64), "65 folders"}});
    EXPECT_TRUE(has_words(deep, "a.zip: its member \"a/a/a/"));
    EXPECT_TRUE(has_words(deep, " lies more than 64 folders deep: it is not unpacked"));
    std::vector<Packed> many;
    for (int k = 0; k < 156; ++k) many.push_back({below(std::to_string(k), 63), "64 folders"});
    many.push_back({below("156", 63), "with set/depth more than 10000 folders"});
    EXPECT_TRUE(has_words(refusal(many), "a.zip: has more than 10000 folders: unzip "));
}

TEST_F(ZipFolders, SkipLinksAndDevices) {
    write_zip(folder / "a.zip", {{"set/depth/0.png", depth},
                                 {"set/depth/1.png", "/etc/passwd", S_IFLNK | 0777},
                                 {"set/rgb", "/etc", S_IFLNK | 0777},
                                 {"set/rgb/2.png", colour},
                                 {"set/depth/3.png", "", S_IFIFO | 0644}});
    auto reader = must(open_clip(folder / "a.zip"));
    EXPECT_EQ(reader->frame_count(), 1);
    for (const auto& entry : std::filesystem::recursive_directory_iterator(temporary.path()))
        EXPECT_TRUE(entry.symlink_status().type() == std::filesystem::file_type::directory ||
                    entry.symlink_status().type() == std::filesystem::file_type::regular)
            << entry.path();
}

TEST_F(ZipFolders, RefuseEncryptedMembers) {
    const std::string said = refusal({{"set/depth/1.png", depth, S_IFREG | 0644, true}});
    EXPECT_TRUE(has_words(said, "a.zip/set/depth/1.png: is encrypted"));
    // Members outside the clip may be encrypted.
    EXPECT_EQ(refusal({{"__MACOSX/x.png", depth, S_IFREG | 0644, true}}), "");
}

TEST_F(ZipFolders, NameDamagedMembers) {
    const std::string text = "a text that is stored as it is";
    refusal({{"set/notes.txt", text, S_IFREG | 0644, false, true}});
    replace_bytes(folder / "a.zip", text, "a text that is damaged as it i");
    EXPECT_TRUE(has_words(refusal_of("a.zip"), "a.zip/set/notes.txt: is damaged"));
    // A name occurs twice.
    refusal({{"set/1.txt", "a"}, {"set/2.txt", "b"}});
    replace_bytes(folder / "a.zip", "set/2.txt", "set/1.txt");
    const std::string twice = refusal_of("a.zip");
    EXPECT_TRUE(has_words(twice, "a.zip/set/1.txt: is there twice"));
    // A file where a folder must be.
    const std::string both = refusal({{"set/depth", "a text"}, {"set/x.txt", "b"}});
    EXPECT_TRUE(has_words(both, "a.zip/set/depth/0.png: cannot be unpacked"));
    // A message names an invalid picture by the archive, also as a later frame.
    const std::string later = refusal({{"set/depth/1.png", "no picture"}});
    EXPECT_EQ(later, "");
    auto reader = open_clip(folder / "a.zip");
    ASSERT_EQ(message(reader), "");
    const std::string frames = message(read_all(**reader));
    EXPECT_TRUE(frames.starts_with((folder / "a.zip/set/depth/1.png").string() + ": is no picture"))
        << frames;
    reader = input_error("closed");
    // Cut anywhere.
    const std::string whole = read_bytes(folder / "a.zip");
    for (std::size_t length = 0; length < whole.size(); length += 13) {
        write_bytes(folder / "cut.zip", whole.substr(0, length));
        EXPECT_NE(refusal_of("cut.zip"), "");
    }
}

/// Stated sizes, little endian: of the central directory, 20 bytes behind a member's mark there.
void state_sizes(const std::filesystem::path& file, std::uint32_t packed, std::uint32_t unpacked) {
    std::string bytes = read_bytes(file);
    const std::string mark("PK\1\2", 4), big = "big.mp4";
    for (auto at = bytes.find(mark); at != std::string::npos; at = bytes.find(mark, at + 1)) {
        if (bytes.compare(at + 46, 3, "big") != 0) continue;
        std::memcpy(bytes.data() + at + 20, &packed, 4);
        std::memcpy(bytes.data() + at + 24, &unpacked, 4);
    }
    write_bytes(file, bytes);
}

TEST_F(ZipFolders, RefuseBombs) {
    // More than deflate can make of so few.
    refusal({{"set/big.mp4", std::string(1000, 'a')}});
    replace_bytes(folder / "a.zip", "set/big.mp4", "big/set.mp4");
    state_sizes(folder / "a.zip", 100, 0xf0000000);
    std::string said = refusal_of("a.zip");
    EXPECT_TRUE(has_words(said, "a.zip/big/set.mp4: is damaged: 100 bytes are said to unpack to 4026531840"));
    // Members that share their bytes.
    refusal({{"big1.mp4", "a", S_IFREG | 0644, false, true}, {"big2.mp4", "b", S_IFREG | 0644, false, true}});
    state_sizes(folder / "a.zip", 0x40000000, 0x40000000);
    said = refusal_of("a.zip");
    EXPECT_TRUE(has_words(said, "bytes are said to unpack to 21474"));
    // More than is stated.
    refusal({{"big1.txt", std::string(5000, 'a')}});
    state_sizes(folder / "a.zip", 34, 1000);
    said = refusal_of("a.zip");
    EXPECT_TRUE(has_words(said, "a.zip/big1.txt: is damaged"));
    // Possible, and too much.
    const std::string large(std::size_t{18} << 20, '\0');
    std::vector<Packed> many{{"padding", large, S_IFREG | 0644, false, true}};
    for (const char* name : {"big1.mp4", "big2.mp4", "big3.mp4", "big4.mp4", "big5.mp4"})
        many.push_back({name, "a", S_IFREG | 0644, false, true});
    refusal(many);
    state_sizes(folder / "a.zip", 0xd8000000, 0xd8000000);
    said = refusal_of("a.zip");
    EXPECT_TRUE(has_words(said, "a.zip: unpacks to 16.9 GiB, and "));
    EXPECT_TRUE(has_words(said, "unzip "));
}

TEST_F(ZipFolders, LeaveOtherFilesAlone) {
    write_zip(folder / "none.zip", {{"a.txt", "text"}, {"clip.mkv", "no clip"}});
    EXPECT_TRUE(has_words(refusal_of("none.zip"), "is a ZIP file, whose first member is \"a.txt\": unzip"));
    write_zip(folder / "a.zarr.zip", {{"0.png", depth}});
    EXPECT_TRUE(has_words(refusal_of("a.zarr.zip"), "is a Zarr store in a ZIP file"));
    for (const char* path : {"missing.zip", "missing.zip/a", "missing/a.zip"}) {
        EXPECT_FALSE(zip_of_pictures(folder / path));
        EXPECT_TRUE(is_refused(open_clip(folder / path), "does not exist"));
    }
}

TEST_F(ZipFolders, StopUnpackingWhenCancelled) {
    write_zip(folder / "a.zip", {{"depth/0.png", depth}});
    std::stop_source stop;
    stop.request_stop();
    const StopScope scope(stop.get_token());
    const auto folder_of_it = ZipFolder::unpack(folder / "a.zip", {});
    ASSERT_FALSE(folder_of_it);
    EXPECT_EQ(folder_of_it.error().kind, ErrorKind::interrupted);
    EXPECT_EQ(temporary.file_count(), 0U);
}

/// However long it takes.
TEST_F(ZipFolders, AreRemovedAfterStop) {
    write_zip(folder / "a.zip", {{"depth/0.png", depth}, {"depth/1.png", depth}, {"notes/a.txt", "text"}});
    const pid_t child = fork();
    if (child == 0) {
        auto unpacked = ZipFolder::unpack(folder / "a.zip", {});
        if (!unpacked) _exit(1);
        request_stop();
        clock_runs_away = true;
        const auto before = std::chrono::steady_clock::now();
        if (std::chrono::steady_clock::now() - before < std::chrono::hours(1)) _exit(2);
        unpacked->reset();
        _exit(0);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
    EXPECT_EQ(temporary.file_count(), 0U);
}

TEST_F(ZipFolders, AreRemovedAfterKilledProcess) {
    write_zip(folder / ".touchable.zip", {{"depth/0.png", depth}, {"notes/a.txt", "text"}});
    const std::filesystem::path archive = folder / ".touchable.zip";
    const pid_t child = fork();
    if (child == 0) {
        const auto unpacked = ZipFolder::unpack(archive, {});
        raise(unpacked ? SIGKILL : SIGTERM);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_EQ(WTERMSIG(status), SIGKILL);
    const auto left = std::filesystem::directory_iterator(temporary.path())->path();
    std::stop_source stop;
    stop.request_stop();
    EXPECT_FALSE(work_until(stop.get_token(), [&] { return ZipFolder::unpack(archive, {}); }));
    EXPECT_TRUE(std::filesystem::exists(left / "archive/notes/a.txt")) << "the removal hears a stop";
    const auto unpacked = must(ZipFolder::unpack(archive, {}));
    EXPECT_FALSE(std::filesystem::exists(left));
    EXPECT_EQ(temporary.file_count(), 1U);
    const auto second = must(ZipFolder::unpack(archive, {}));
    EXPECT_EQ(temporary.file_count(), 2U) << "a folder in use stays";
}

/// In a folder that others may write to, too.
TEST_F(ZipFolders, LeaveFoldersOfOthersAlone) {
    write_zip(folder / "a.zip", {{"depth/0.png", depth}});
    const auto place = [&](const std::filesystem::path& at, bool has_mark) {
        std::filesystem::create_directory(at);
        write_bytes(at / "precious", "a text");
        if (has_mark) write_bytes(at / ".touchable", "");
    };
    place(temporary / "touchable-zip-unmarked", false);
    place(folder / "elsewhere", true);
    std::filesystem::create_directory_symlink(folder / "elsewhere", temporary / "touchable-zip-link");
    place(temporary / "touchable-zip-moved", false);
    std::filesystem::create_symlink(folder / "elsewhere/.touchable",
                                    temporary / "touchable-zip-moved/.touchable");
    place(temporary / "touchable-zip-foreign", true);
    const bool can_give_away = chown((temporary / "touchable-zip-foreign/.touchable").c_str(), 1, 1) == 0;
    place(temporary / "touchable-other", true);
    place(temporary / "touchable-zip-own", true);  // as if its program had been killed
    EXPECT_EQ(message(open_clip(folder / "a.zip")), "");
    EXPECT_FALSE(std::filesystem::exists(temporary / "touchable-zip-own"));
    EXPECT_TRUE(std::filesystem::exists(folder / "elsewhere/precious"));
    for (const char* kept : {"touchable-zip-unmarked", "touchable-zip-link", "touchable-zip-moved",
                             "touchable-zip-foreign", "touchable-other"}) {
        EXPECT_TRUE(std::filesystem::exists(temporary / kept / "precious") ||
                    (!can_give_away && kept == std::string("touchable-zip-foreign")))
            << kept;
        std::filesystem::remove_all(temporary / kept);
    }
}

TEST_F(ZipFolders, NameMissingTemporaryFolder) {
    write_zip(folder / "a.zip", {{"depth/0.png", depth}});
    setenv("TMPDIR", (folder / "missing").c_str(), 1);
    EXPECT_TRUE(
        is_refused(open_clip(folder / "a.zip"), "a.zip: cannot be unpacked: no folder of temporary files"));
    EXPECT_TRUE(is_refused(open_clip(folder / "a.zip"), "can be made in \"" + (folder / "missing").string()));
}

}  // namespace
}  // namespace touchable::test
