// Files of other programs that are not opened: each gets one line with what it is and what to do.
#include "engine/formats/foreign_files.hpp"

#include <gtest/gtest.h>

#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

const std::string lfs_pointer =
    "version https://git-lfs.github.com/spec/v1\n"
    "oid sha256:4665a5ea423c2713d436b5ee50593a9640e0018c1550b5a0002f74190d6caea8\nsize 12\n";

struct Foreign {
    const char* name;
    std::string bytes;
    const char *what, *way;
};

class ForeignFiles : public ::testing::Test {
protected:
    std::string refusal(const std::string& name, const SourceDescription& known = {}) const {
        return message(open_clip(folder / name, {}, known));
    }
    void depth(const std::string& name) const {
        std::filesystem::create_directories((folder / name).parent_path());
        Samples memory(2 * 16 * 12, 3);
        ASSERT_EQ(message(write_png(folder / name, PlaneView{memory.data(), 32, 16, 12, 2, 1})), "");
    }
    void text(const std::string& name, const std::string& bytes) const {
        std::filesystem::create_directories((folder / name).parent_path());
        write_bytes(folder / name, bytes);
    }
    TemporaryFolder folder;
};

TEST_F(ForeignFiles, SayWhatTheyAreAndTheWay) {
    const std::string zeros(64, '\0'), hdf5 = "\x89HDF\r\n\x1a\n" + zeros;
    const std::string user_block = "Simulation 12" + std::string(499, ' ');
    const std::string pcd_fields = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\n";
    const std::string zip_head = std::string("PK\x03\x04", 4) + std::string(22, '\0');
    std::string tar(257, 'a');
    tar += "ustar";
    const Foreign all[] = {
        {"depth.png", lfs_pointer, "is a Git LFS pointer", "git lfs pull"},
        {"clip.mkv", lfs_pointer, "is a Git LFS pointer", "git lfs pull"},
        {"s.sens", std::string("\4\0\0\0", 4) + zeros, "ScanNet", "--export_depth_images"},
        {"c.oni", "NI10" + zeros, "OpenNI", "cv2.CAP_OPENNI2"},
        {"z.svo", zeros, "ZED", "svo_export.py"},
        {"z.svo2", "\x89MCAP0\r\n" + zeros, "ZED", "svo_export.py"},
        {"u.h5", user_block + hdf5, "is an HDF5 file behind a user block", "h5unjam -i "},
        {"o.mat", "MATLAB 5.0 MAT-file, Platform: PCWIN", "MATLAB file:", "scipy.io.loadmat('o.mat')"},
        {"i.geometric.bin", "160&120&1&" + zeros, "is a depth map of COLMAP (160x120)", "read_array("},
        {"n.bin", "160&120&3&" + zeros, "map of normals of COLMAP", "depth_maps"},
        {"points3D.bin", zeros, "sparse model of COLMAP", "patch_match_stereo"},
        {"c.ply", "ply\nformat ascii 1.0\nelement vertex 17\nproperty float x\nend_header\n",
         "is a PLY cloud of 17 points", "project_to_depth_image"},
        {"m.ply", "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nelement face 5\r\nend_header\r\n",
         "is a PLY mesh of 5 faces", "RaycastingScene"},
        {"c.pcd", pcd_fields + "WIDTH 213\nHEIGHT 1\nDATA ascii\n", "is a PCD cloud of 213 points",
         "project_to_depth_image"},
        {"o.pcd", pcd_fields + "WIDTH 4\nHEIGHT 3\nDATA ascii\n", "is cut short", ""},
        {"a.tar", tar, "is a tar archive", "tar xf"},
        {"a.png.gz", "\x1f\x8b" + zeros, "is packed by gzip", "unpack it"},
        {"a.zip", zip_head + std::string("\3\0\0\0", 4) + "a/b", "is damaged", ""},
        {"a.las", "LASF" + zeros, "cloud of points (LAS)", "render it"},
    };
    SourceDescription known;
    known.fov = 60;
    for (const Foreign& each : all) {
        text(each.name, each.bytes);
        for (const std::string& said :
             {refusal(each.name), refusal(each.name, known), message(guess_clip(folder / each.name, {}))}) {
            EXPECT_NE(said.find(each.what), std::string::npos) << each.name << ": " << said;
            EXPECT_NE(said.find(each.way), std::string::npos) << each.name << ": " << said;
            EXPECT_TRUE(said.starts_with((folder / each.name).string() + ": ")) << said;
            EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        }
    }
}

/// Texts and numbers that only begin alike are nothing that is known.
TEST_F(ForeignFiles, OthersAreNotMistaken) {
    for (const char* bytes :
         {"", "version https://example.org", "ply", "160&120&", "160&120", "&&&", "1&2&&", "16a&120&1&",
          "VERSION 1\n", "# .PCD v0.7\nWIDTH x\nHEIGHT\n", "MATLA", "\x89HDF"}) {
        text("x.dat", bytes);
        EXPECT_EQ(foreign_file(SourceFile(folder / "x.dat")), std::nullopt) << bytes;
    }
    EXPECT_EQ(foreign_file(SourceFile(folder / "missing")), std::nullopt);
    EXPECT_EQ(foreign_folder(folder / "missing"), std::nullopt);
    EXPECT_EQ(foreign_file_below(folder / "missing"), std::nullopt);
}

TEST_F(ForeignFiles, ZarrStoresAreFolders) {
    for (const char* mark : {"a.zarr/.zgroup", "b.zarr/zarr.json", "c.zarr/.zarray"}) {
        text(mark, "{}");
        const std::string name = std::filesystem::path(mark).parent_path().string();
        EXPECT_NE(refusal(name).find("is a Zarr store: numpy.save('depth.npy', zarr.open('" + name + "')"),
                  std::string::npos)
            << refusal(name);
    }
    EXPECT_NE(message(open_clip(folder.path())).find(".zarr is a Zarr store"), std::string::npos);
}

TEST_F(ForeignFiles, AreNamedWhereAFolderHasNoDepth) {
    text("stereo/depth_maps/i.jpg.geometric.bin", "160&120&1&");
    const std::string said = message(open_clip(folder.path()));
    EXPECT_NE(said.find("no pictures of depth were found (there are no pictures), but "
                        "stereo/depth_maps/i.jpg.geometric.bin is a depth map of COLMAP"),
              std::string::npos)
        << said;
}

TEST_F(ForeignFiles, PointersOfAFolderAreNotPassedOver) {
    // All of it.
    for (const char* name : {"a/depth/0.png", "a/depth/1.png", "a/rgb/0.jpg", "a/rgb/1.jpg"})
        text(name, lfs_pointer);
    EXPECT_NE(refusal("a").find("0.png: is a Git LFS pointer"), std::string::npos) << refusal("a");
    // Where no name says which is depth.
    text("n/left/0.png", lfs_pointer);
    EXPECT_NE(refusal("n").find("left/0.png is a Git LFS pointer"), std::string::npos) << refusal("n");
    // Colour alone: depth opens, and colour is told.
    for (const char* name : {"b/depth/0.png", "b/depth/1.png"}) depth(name);
    for (const char* name : {"b/rgb/0.jpg", "b/rgb/1.jpg"}) text(name, lfs_pointer);
    const auto reader = open_clip(folder / "b");
    ASSERT_EQ(message(reader), "");
    EXPECT_TRUE(is_noted(**reader, "left out: rgb/*.jpg, whose first is a Git LFS pointer"));
    // One frame of depth.
    text("b/depth/1.png", lfs_pointer);
    const auto cut = open_clip(folder / "b");
    const std::string said = cut ? message(read_all(**cut)) : message(cut);
    EXPECT_NE(said.find("1.png: is a Git LFS pointer"), std::string::npos) << said;
}

}  // namespace
}  // namespace touchable::test
