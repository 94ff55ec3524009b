// HDF5 files and folders of them, opened as clips.
#include <cstdlib>

#include "engine/formats/open_clip.hpp"
#include "tests/picture/hdf5_file.hpp"

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

TEST_F(Hdf5Clip, AStackIsAClip) {
    add("demos.hdf5", {"data/demo_0/obs/agentview_depth", {3, 16, 20, 1}}, 1000);
    add("demos.hdf5", {"data/demo_1/obs/agentview_depth", {2, 16, 20, 1}}, 5000);
    EXPECT_NE(message(open("demos.hdf5")).find("has several data sets that may be depth: /data/demo_0/obs/"),
              std::string::npos);
    const auto clip = open("demos.hdf5", "data/demo_1/obs/agentview_depth");
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().width, 20);
    EXPECT_EQ((*clip)->tracks().front().codec, "hdf5");
    EXPECT_EQ(first_codes(**clip), (std::vector{5000, 5320}));
}

TEST_F(Hdf5Clip, AFolderOfFramesIsAClip) {
    for (const int number : {0, 1, 2, 10})
        add("scene/frame.00" + std::string(number < 10 ? "0" : "") + std::to_string(number) +
                ".depth_meters.hdf5",
            {"dataset", {16, 20}}, 1000 + number);
    const auto clip = open("scene");
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().depth.semantics, DepthSemantics::range) << "as the name says";
    EXPECT_EQ(first_codes(**clip), (std::vector{1000, 1001, 1002, 1010}));
    EXPECT_EQ(message(open("scene", "dataset")), "");
    EXPECT_NE(message(open("scene", "depth")).find("has no data set \"depth\", but /dataset of 16x20"),
              std::string::npos);
}

TEST_F(Hdf5Clip, ADataSetIsNamedOfHdf5Alone) {
    add("d.h5", {"depth", {16, 20}}, 1000);
    Image still{2, 2, 2, 1, {1, 2, 3, 4, 5, 6, 7, 8}};
    ASSERT_EQ(message(write_png(folder_ / "d.png", still.view())), "");
    EXPECT_EQ(
        message(open("d.png", "depth")),
        (folder_ / "d.png").string() + ": is no HDF5 file and no .npz, of which a data set could be named");
    EXPECT_EQ(message(open("d.h5", "", "Z")),
              (folder_ / "d.h5").string() + ": is no OpenEXR file, of which a channel could be named");
}

TEST_F(Hdf5Clip, WithoutDepthItSaysWhatItHas) {
    add("c.h5", {"colors", {16, 20, 3}, "UIN", 8}, 0);
    EXPECT_EQ(message(open("c.h5")),
              (folder_ / "c.h5").string() +
                  ": is an HDF5 file without a data set of pictures of depth (height x "
                  "width, or count x height x width): it has /colors of 16x20x3");
}

}  // namespace
}  // namespace touchable::test
