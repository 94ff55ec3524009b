// SPDX-License-Identifier: Apache-2.0
// HDF5 files and folders of them, opened as clips.

#include <gtest/gtest.h>

#include <cstdlib>

#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "tests/picture/hdf5_file.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

class Hdf5Clip : public ::testing::Test {
protected:
    void SetUp() override {
        if (std::system("command -v h5import h5ls h5dump >/dev/null 2>&1") != 0)
            GTEST_SKIP() << "needs h5import (Debian: hdf5-tools)";
    }
    void add(const std::string& name, const Hdf5Numbers& of, int first) const {
        std::filesystem::create_directories((folder_ / name).parent_path());
        ASSERT_TRUE(add_data_set(folder_ / name, of, first)) << name;
    }
    Result<std::unique_ptr<ClipReader>> open(const std::string& name, const std::string& dataset = "",
                                             const std::string& channel = "") const {
        SourceDescription known;
        known.dataset = dataset;
        known.channel = channel;
        return open_clip(folder_ / name, {}, known);
    }
    TemporaryFolder folder_;
};

/// The first pixel's depth in all frames.
std::vector<int> first_codes(ClipReader& clip) {
    std::vector<int> codes;
    while (true) {
        const auto frame = clip.next();
        EXPECT_EQ(message(frame), "");
        if (!frame || !*frame) return codes;
        codes.push_back((*frame)->depth.sample(0, 0));
    }
}

TEST_F(Hdf5Clip, OpensFolderOfFrames) {
    for (const int number : {0, 1, 2, 10})
        add("scene/frame.00" + std::string(number < 10 ? "0" : "") + std::to_string(number) +
                ".depth_meters.hdf5",
            {"dataset", {16, 20}}, 1000 + number);
    const auto clip = must(open("scene"));
    EXPECT_EQ(clip->scene().depth.semantics, DepthSemantics::range) << "as the name says";
    EXPECT_EQ(first_codes(*clip), (std::vector{1000, 1001, 1002, 1010}));
    EXPECT_EQ(message(open("scene", "dataset")), "");
    EXPECT_TRUE(is_refused(open("scene", "depth"), "has no data set \"depth\", but /dataset of 16x20"));
}

/// Cameras and colour in the same file, those of depth's own group first.
TEST_F(Hdf5Clip, ReadsOwnCamera) {
    const auto doubles = [](std::vector<double> numbers) {
        return std::string(reinterpret_cast<const char*>(numbers.data()), 8 * numbers.size());
    };
    add("d.h5", {"a/depth", {2, 16, 20}}, 1000);
    add("d.h5", {"a/colors", {2, 16, 20, 3}, "UIN", 8}, 0);
    ASSERT_TRUE(
        add_data_set(folder_ / "d.h5", {"B/K", {3, 3}, "FP", 64}, doubles({99, 0, 9, 0, 99, 8, 0, 0, 1})));
    ASSERT_TRUE(add_data_set(folder_ / "d.h5", {"a/intrinsics", {2, 3, 3}, "FP", 64},
                             doubles({21, 0, 9, 0, 22, 8, 0, 0, 1, 21, 0, 9, 0, 22, 8, 0, 0, 1})));
    ASSERT_TRUE(add_data_set(folder_ / "d.h5", {"a/depth_scale", {1}, "FP", 64}, doubles({0.0005})));
    const auto clip = must(open("d.h5"));
    EXPECT_EQ(clip->scene().camera.fx, 21);
    EXPECT_EQ(clip->scene().camera.fy, 22);
    EXPECT_TRUE(is_noted(*clip, "the camera is that of d.h5 (intrinsics)"));
    EXPECT_TRUE(is_noted(*clip, "a code is 0.5 mm, as d.h5 says"));
    EXPECT_TRUE(is_noted(*clip, "depth is the data set /a/depth; left out: /a/colors"));
    EXPECT_TRUE(is_noted(*clip, "guessed: 30 frames a second"));
    ASSERT_TRUE(add_data_set(folder_ / "d.h5", {"a/timestamps", {2}, "FP", 64}, doubles({5, 5.0625})));
    EXPECT_EQ(must(open("d.h5"))->scene().rate.per_second(), 16);
}

/// A name stands for the words of an attribute, which h5import cannot write: h5dump prints both. Its data set
/// is too large to be read.
TEST_F(Hdf5Clip, TakesRateOfRobomimic) {
    add("r.h5", {"a/depth", {2, 16, 20}}, 1000);
    add("r.h5", {"a/_control_freq_:20,_b", {70000}, "UIN", 8}, 0);
    std::string bytes = read_bytes(folder_ / "r.h5");
    bytes.replace(bytes.find("_control_freq_"), 14, "\"control_freq\"");
    write_bytes(folder_ / "r.h5", bytes);
    EXPECT_EQ(must(open("r.h5"))->scene().rate.per_second(), 20);
}

/// By their first bytes, whatever their names end with.
TEST_F(Hdf5Clip, OpensFolderOfOtherNames) {
    for (const int number : {1, 2})
        add("0001/disp1_left/disp1_left_000" + std::to_string(number) + ".dsp5", {"disparity", {16, 20}},
            100 + number);
    write_bytes(folder_ / "0001/notes.txt", "1 2 3");
    const auto clip = must(open("0001"));
    EXPECT_EQ(clip->frame_count(), 2);
    EXPECT_TRUE(is_noted(*clip, "depth is disparities, as the name says"));
}

TEST_F(Hdf5Clip, RefusesDataSetOfOthers) {
    add("d.h5", {"depth", {16, 20}}, 1000);
    Image still{2, 2, 2, 1, {1, 2, 3, 4, 5, 6, 7, 8}};
    ASSERT_EQ(message(write_png(folder_ / "d.png", still.view())), "");
    EXPECT_EQ(
        message(open("d.png", "depth")),
        (folder_ / "d.png").string() + ": is no HDF5 file and no .npz, of which a data set could be named");
    EXPECT_EQ(message(open("d.h5", "", "Z")),
              (folder_ / "d.h5").string() + ": is no OpenEXR file, of which a channel could be named");
}

}  // namespace
}  // namespace touchable::test
