// A file of a clip is opened once, whoever finds out what it is and whoever plays it.
#include "tests/opened_files.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/kept_clips.hpp"

namespace touchable::test {
namespace {

class OpenedOnce : public ::testing::Test {
protected:
    void write_pictures(const std::string& name, int count, int bytes, int channels) const {
        for (int n = 0; n < count; ++n) {
            Image image{16, 12, bytes, channels, {}};
            for (int k = 0; k < 16 * 12 * bytes * channels; ++k)
                image.samples.push_back(static_cast<std::uint8_t>(bytes == 2 && k % 2 == 1 ? 3 : 7 * n + k));
            ASSERT_EQ(message(write_png(folder / (name + std::to_string(100 + n) + ".png"), image.view())),
                      "");
        }
    }
    void write_floats(const std::string& name, int count) const {
        for (int n = 0; n < count; ++n) {
            std::string bytes = "Pf\n16 12\n-1.0\n";
            for (int k = 0; k < 16 * 12; ++k) {
                const float metres = 1.0F + 0.01F * static_cast<float>(k + n);
                bytes.append(reinterpret_cast<const char*>(&metres), sizeof metres);
            }
            write_bytes(folder / (name + std::to_string(100 + n) + ".pfm"), bytes);
        }
    }
    std::map<std::string, int> counts_of(const std::filesystem::path& clip) const {
        OpenedFiles opened(folder.path());
        auto reader = open_clip(clip);
        EXPECT_EQ(message(reader), "") << clip;
        if (!reader) return {};
        EXPECT_EQ(message(read_all(**reader)), "") << clip;
        return opened.counts();
    }
    /// Of so many frames some are looked at for the far plane.
    void expect_folder_read_once(int frames, const std::vector<std::string>& planes) const {
        const auto counts = counts_of(folder.path());
        EXPECT_EQ(counts.size(), planes.size() * static_cast<std::size_t>(frames));
        for (const std::string& plane : planes) {
            int again = 0;
            for (int n = 0; n < frames; ++n) {
                const auto found = std::find_if(counts.begin(), counts.end(), [&](const auto& each) {
                    return each.first.starts_with(plane + std::to_string(100 + n));
                });
                ASSERT_NE(found, counts.end());
                EXPECT_LE(found->second, n < 16 ? 1 : 2) << found->first;
                again += found->second - 1;
            }
            EXPECT_LE(again, 16) << plane;
        }
    }
    TemporaryFolder folder;
};

TEST_F(OpenedOnce, PicturesOfAFolderThatIsGuessed) {
    write_pictures("depth_", 40, 2, 1);
    write_pictures("image_", 40, 1, 3);
    expect_folder_read_once(40, {"depth_", "image_"});
}

TEST_F(OpenedOnce, PicturesWhoseRangeIsLookedFor) {
    write_floats("depth_", 40);
    expect_folder_read_once(40, {"depth_"});
}

TEST_F(OpenedOnce, FilesOfEveryKind) {
    for (const std::string& kept : kept_clips) {
        SCOPED_TRACE(kept);
        for (const auto& [name, count] : counts_of(copied_clip(kept, folder.path())))
            EXPECT_EQ(count, 1) << name;
    }
}

TEST_F(OpenedOnce, WhatIsReadAgainFromItsBeginning) {
    for (const std::string& kept : kept_clips) {
        if (kept.ends_with(".png") || kept.ends_with(".tif")) continue;  // pictures are not kept open
        SCOPED_TRACE(kept);
        const auto clip = copied_clip(kept, folder.path());
        OpenedFiles opened(folder.path());
        auto reader = open_clip(clip);
        ASSERT_EQ(message(reader), "");
        for (int round = 0; round < 2; ++round) {
            ASSERT_EQ(message(read_all(**reader)), "");
            ASSERT_EQ(message((*reader)->rewind()), "");
        }
        for (const auto& [name, count] : opened.counts()) EXPECT_EQ(count, 1) << name;
    }
}

}  // namespace
}  // namespace touchable::test
