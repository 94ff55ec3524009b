// SPDX-License-Identifier: Apache-2.0
// Clips packed for pages: what was written comes back, and what was cut or changed is refused with its place.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/formats/formats_written.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "tests/picture/results.hpp"

namespace {
std::string lost_name;  // its flush fails; empty: none does
int lost_by = 0;
}  // namespace

/// These replace the C library's in the whole program.
extern "C" int fsync(int file) {
    std::error_code failure;
    const auto name = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file), failure);
    errno = lost_by;
    return lost_name.empty() || !name.string().ends_with(lost_name) ? 0 : -1;
}
/// What other programs lost.
extern "C" int syncfs(int) noexcept {
    errno = EIO;
    return -1;
}

namespace touchable::test {
namespace {

using Json = nlohmann::ordered_json;

std::string contents(const std::filesystem::path& file) {
    return must(read_given_file(file, "", "a file", std::size_t{1} << 24));
}

class PackedClip : public FolderTest {
protected:
    static constexpr int frames = 4;
    PackedClip() { scene.name = "packed"; }

    void pack(const std::vector<RawFrame>& given) {
        write_frames(create_packed_clip(folder / "clip", scene, {}, Existing::replace), given);
    }
    void pack(const Planes& planes = all_planes) { pack(test_frames(scene, frames, planes)); }
    std::filesystem::path file(const std::string& name) const { return folder / "clip" / name; }
    std::filesystem::path plane(const std::string& role) const {
        return file(Json::parse(contents(file("clip.json")))["planes"][role]["file"]);
    }
    std::set<std::string> names() const {
        std::set<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder / "clip"))
            names.insert(entry.path().filename());
        return names;
    }
    /// Changes clip.json, and returns why the clip is refused.
    std::string refusal(const std::function<void(Json&)>& change) const {
        const std::string before = contents(file("clip.json"));
        Json json = Json::parse(before);
        change(json);
        write_bytes(file("clip.json"), json.dump());
        const std::string why = message(read_clip(file("clip.json")));
        write_bytes(file("clip.json"), before);
        return why;
    }

    Scene scene = small_scene(24, 18, 16);
};

TEST_F(PackedClip, KeepsWhatIsFelt) {
    for (const bool noisy : {true, false})
        for (const int bits : {8, 16}) {
            scene = small_scene(24, 18, bits);
            scene.height_coding = {1.5, HeightUnits::levels, static_cast<std::uint16_t>((1 << bits) - 1)};
            const auto given = test_frames(scene, frames, {true, true, true, noisy});
            pack(given);
            const auto [clip, read] = must_read(open_clip(folder / "clip"));
            ASSERT_EQ(read.size(), given.size());
            for (std::size_t n = 0; n < read.size(); ++n) {
                EXPECT_TRUE(same_plane(read[n].depth, given[n].depth)) << n;
                EXPECT_TRUE(same_plane(read[n].haptic, given[n].haptic)) << n;
                EXPECT_TRUE(same_plane(read[n].height, given[n].height)) << n;
                EXPECT_EQ(read[n].time_ns, given[n].time_ns);
            }
            ASSERT_EQ(message(clip->seek(2)), "");
            EXPECT_TRUE(same_plane(must(clip->next())->depth, given[2].depth));
        }
}

TEST_F(PackedClip, StoresUnchangedPicturesOnce) {
    auto given = test_frames(scene, frames, all_planes);
    for (RawFrame& frame : given) frame.haptic = given[0].haptic;
    given[2].depth = given[1].depth;
    pack(given);
    const Json planes = Json::parse(contents(file("clip.json")))["planes"];
    for (int n = 0; n < frames; ++n) {
        EXPECT_EQ(planes["haptic"]["sizes"][n] == 0, n > 0) << n;
        EXPECT_EQ(planes["depth"]["sizes"][n] == 0, n == 2) << n;
    }
    EXPECT_EQ(std::filesystem::file_size(plane("haptic")), planes["haptic"]["sizes"][0].get<std::size_t>());
    const auto [clip, read] = must_read(open_clip(file("clip.json")));
    EXPECT_TRUE(same_plane(read[2].depth, given[1].depth));
    EXPECT_TRUE(same_plane(read[3].haptic, given[0].haptic));
}

TEST_F(PackedClip, KeepsTimesOfFrames) {
    scene.rate = *rate_of_own_times(uneven_times(frames));
    pack();
    const auto [clip, read] = must_read(open_clip(file("clip.json")));
    for (int n = 0; n < frames; ++n)
        EXPECT_EQ(read[static_cast<std::size_t>(n)].time_ns, scene.rate.time_ns(n));
}

TEST_F(PackedClip, RefusesChangedText) {
    pack();
    EXPECT_EQ(refusal([](Json&) {}), "");
    const std::pair<std::function<void(Json&)>, const char*> changes[] = {
        {[](Json& json) { json["touchable_packed"] = 3; }, "touchable_packed"},
        {[](Json& json) { json["numbers"]["camera.fx"] = 1e3; }, "one of the two was changed"},
        {[](Json& json) { json["numbers"].erase("camera.fx"); }, "one of the two was changed"},
        {[](Json& json) { json["scene"].erase("camera"); }, "camera"},
        {[](Json& json) { json["frames"] = 5; }, "a size for each frame"},
        {[](Json& json) { json["frames"] = 0; }, "frames"},
        {[](Json& json) { json["planes"]["depth"]["sizes"][0] = 0; }, "sizes[0]"},
        {[](Json& json) { json["planes"]["depth"]["sizes"][1] = -1; }, "sizes[1]"},
        {[](Json& json) { json["planes"]["depth"]["file"] = "../depth.bin"; }, "depth-HASH.bin"},
        {[](Json& json) { json["planes"]["haptic"]["channels"] = 2; }, "channels"},
        {[](Json& json) { json["planes"].erase("depth"); }, "depth"},
        {[](Json& json) {
             json["times_ns"] = {0, 5, 4, 6};
         },
         "times that increase"},
        {[](Json& json) { json["live"] = "live"; }, "live"}};
    for (const auto& [change, why] : changes) {
        const std::string told = refusal(change);
        EXPECT_TRUE(has_words(told, why));
        EXPECT_TRUE(has_words(told, "clip.json"));
    }
}

TEST_F(PackedClip, RefusesFlippedBits) {
    pack();
    Random random(107);
    for (const char* role : {"depth", "haptic", "height", "colour"}) {
        const auto file = plane(role);
        const std::string whole = contents(file);
        const auto refused = [&](const std::string& bytes) {
            write_bytes(file, bytes);
            return has_words(message(read_clip(folder / "clip")), file.filename());
        };
        for (int n = 0; n < 40; ++n) {
            const int bit = random.below(8 * static_cast<int>(whole.size()));
            std::string changed = whole;
            changed[static_cast<std::size_t>(bit / 8)] ^= static_cast<char>(1 << bit % 8);
            EXPECT_TRUE(refused(changed)) << role << ", bit " << bit;
        }
        for (const std::size_t kept : {std::size_t{0}, whole.size() / 2, whole.size() - 1})
            EXPECT_TRUE(refused(whole.substr(0, kept))) << role << ", byte " << kept;
        write_bytes(file, whole);
    }
}

TEST_F(PackedClip, ReplacesWholeClip) {
    pack();
    const auto before = must(read_clip(folder / "clip"));
    write_bytes(folder / "page.html", "a page");
    const auto replace = [&] {
        return write_all(
            create_packed_clip(folder / "clip", scene, {folder / "page.html"}, Existing::replace),
            test_frames(scene, 1, {}));
    };
    // A name that cannot be taken ends it between two names, as a kill does.
    std::filesystem::create_directories(file("page.html/full"));
    EXPECT_TRUE(has_words(message(replace()), "page.html"));
    EXPECT_TRUE(same_frames(must(read_clip(folder / "clip")), before));
    std::filesystem::remove_all(file("page.html"));
    EXPECT_EQ(message(replace()), "");
    EXPECT_EQ(names(), (std::set<std::string>{"clip.json", "page.html", plane("depth").filename()}));
    EXPECT_EQ(std::ssize(must(read_clip(folder / "clip"))), 1);
}

/// A name without a hash is a person's own, unless clip.json is of version 1 and names it.
TEST_F(PackedClip, ReplacesOnlyItsOwnFiles) {
    const std::string page = "style-0123456789abcdef.css", old = "style-fedcba9876543210.css";
    write_bytes(folder / page, "of a page");
    for (const bool is_version_1 : {false, true}) {
        if (is_version_1)
            std::filesystem::copy(TOUCHABLE_SOURCE_DIR "/web/tests/packed_1", folder / "clip");
        else
            pack();
        std::set<std::string> kept{"haptic.bin", "height.bin", "notes.txt", "style.css"};
        for (const std::string& name : kept) write_bytes(file(name), "a person's");
        write_bytes(file(old), "of the page before");
        write_frames(create_packed_clip(folder / "clip", scene, {folder / page}, Existing::replace),
                     test_frames(scene, 1, {}));
        kept.merge(std::set<std::string>{"clip.json", page, plane("depth").filename()});
        for (const char* name : {"haptic.bin", "height.bin"})
            if (is_version_1) kept.erase(name);
        EXPECT_EQ(names(), kept);
        std::filesystem::remove_all(folder / "clip");
    }
}

TEST_F(PackedClip, SaysWhatDiskLoses) {
    struct {
        const char* lost;
        int by;
        const char* told;
        std::ptrdiff_t frames;
    } const rows[] = {{"/clip.json", EIO, "cannot be written: Input/output error", frames},
                      {"/clip", EIO, "clip.json: is there, but its disk may lose it", 1},
                      {"/clip", EOPNOTSUPP, "", 1},
                      {"/clip.json", EINVAL, "", 1}};
    for (const auto& [lost, by, told, count] : rows) {
        pack();
        const auto before = plane("depth");
        lost_name = lost, lost_by = by;
        const std::string why =
            message(write_all(create_packed_clip(folder / "clip", scene, {}, Existing::replace),
                              test_frames(scene, 1, all_planes)));
        lost_name.clear();
        EXPECT_TRUE(*told ? has_words(why, told) : why.empty()) << why;
        EXPECT_EQ(std::ssize(must(read_clip(folder / "clip"))), count) << lost;
        EXPECT_EQ(std::filesystem::exists(before), *told != 0) << "clip.json of either clip finds its files";
    }
}

TEST_F(PackedClip, NumbersAreTheScene) {
    scene = small_scene(24, 18, 16);
    scene.hole_stiffness = 0.25;
    scene.filter.median = 5;
    scene.filter.temporal = true;
    scene.filter.temporal_noise = {0.1, 1e-7};
    std::vector<double> numbers;
    for (const SceneNumber& number : numbers_of(scene)) numbers.push_back(number.value);
    const Scene again = must(scene_of_numbers(numbers));
    EXPECT_EQ(again.depth, scene.depth);
    EXPECT_EQ(again.camera, scene.camera);
    EXPECT_EQ(again.filter, scene.filter);
    EXPECT_EQ(again.hole_stiffness, scene.hole_stiffness);
    EXPECT_EQ(again.device_metres_per_unit, std::nullopt);
    // Any number may come from outside.
    const auto names = numbers_of(scene);
    for (std::size_t k = 0; k < numbers.size(); ++k)
        for (const double wrong : {std::nan(""), -1e300, 1e300, -1.0, 0.5}) {
            std::vector<double> changed = numbers;
            changed[k] = wrong;
            const auto made = scene_of_numbers(changed);
            EXPECT_EQ(made ? message(validate(*made)) : "", "") << names[k].name;
        }
    numbers.pop_back();
    expect_error(scene_of_numbers(numbers), "must be");
}

}  // namespace
}  // namespace touchable::test
