// SPDX-License-Identifier: Apache-2.0
// Files of other programs that are not opened: each gets one line with what it is and what to do.

#include <gtest/gtest.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/picture/results.hpp"

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
        write_in_folder(folder / name, even_image(16, 12, 2, 1, 771));
    }
    void text(const std::string& name, const std::string& bytes) const {
        write_in_folder(folder / name, bytes);
    }
    TemporaryFolder folder;
};

TEST_F(ForeignFiles, AreNamedWithRemedy) {
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
        {"o.mat", "MATLAB 5.0 MAT-file, Platform: PCWIN", "MATLAB file:", "o.mat')['NAME'])"},
        {"i.geometric.bin", "160&120&1&" + zeros, "is a depth map of COLMAP (160x120)", "read_array("},
        {"n.bin", "160&120&3&" + zeros, "map of normals of COLMAP", "depth_maps"},
        {"points3D.bin", zeros, "sparse model of COLMAP", "patch_match_stereo"},
        {"c.ply", "ply\nformat ascii 1.0\nelement vertex 17\nproperty float x\nend_header\n",
         "is a PLY cloud of 17 points", "project_to_depth_image"},
        {"m.ply",
         "ply\r\nformat ascii 1.0\r\ncomment width 1\r\ncomment height 3\r\nelement vertex 3\r\nelement face "
         "5\r\nend_header\r\n",
         "is a PLY mesh of 5 faces", "RaycastingScene"},
        {"c.pcd", pcd_fields + "WIDTH 213\nHEIGHT 1\nDATA ascii\n", "is a PCD cloud of 213 points",
         "project_to_depth_image"},
        {"o.pcd", pcd_fields + "WIDTH 4\nHEIGHT 3\nDATA ascii\n", "is cut short", ""},
        {"a.tar", tar, "is a tar archive", "tar xf"},
        {"a.png.gz", "\x1f\x8b" + zeros, "is packed by gzip", "unpack it"},
        {"a.zip", zip_head + std::string("\3\0\0\0", 4) + "a/b", "is damaged", ""},
        {"a.las", "LASF" + zeros, "cloud of points (LAS)", "render it"},
        {"t.r3d", "what it begins with", "is a recording of Record3D", "t.r3d'); m = json.loads("},
        {"0.depth", "bvx2" + zeros, "is a picture of Record3D", "liblzfse.decompress((z / "},
        {"t.pt", std::string("\x80\2\x8a\n", 4) + zeros, "is a file of PyTorch",
         "t.pt', map_location='cpu')"},
        {"d.pickle", "\x80\4\x95" + zeros, "is a pickle of Python", "d.pickle', allow_pickle=True))"},
        {"n.nii", zeros + std::string(280, '\0') + std::string("n+1\0", 4), "is NIfTI", "nibabel.load('"},
        {"n.nii.gz", "\x1f\x8b" + zeros, "is NIfTI", "n.nii.gz').get_fdata().squeeze().T)"},
        {"w.png", std::string("RIFF\0\0\0\0WEBPVP8L", 16) + zeros, "is WebP", "w.png').save('"},
        {"a.jp2", std::string("\0\0\0\14jP  \r\n\x87\n", 12) + zeros, "is JPEG 2000", "a.png') in Python"},
        {"a.bmp", "BM" + zeros, "is BMP", "PIL.Image.open('"},
        {"a.tga", zeros, "is TGA", "PIL.Image.open('"},
        {"a.hdr", "#?RADIANCE\n" + zeros, "is Radiance HDR", "a.hdr', -1)[..., 0])"},
        {"f.flo", std::string("PIEH\2\0\0\0\1\0\0\0", 12) + std::string(16, 'x'), "is optical flow", ""},
        {"f.dpt", std::string("PIEH\2\0\0\0\1\0\0\0", 12) + "1234", "is cut short", ""},
        {"short.dpt", "PIEH", "is cut short", ""},
    };
    for (const Foreign& each : all) {
        text(each.name, each.bytes);
        for (const std::string& said :
             {refusal(each.name), refusal(each.name, stated(&SourceDescription::fov, 60)),
              message(guess_clip(folder / each.name, {}))}) {
            EXPECT_TRUE(has_words(said, each.what)) << each.name << ": " << said;
            EXPECT_TRUE(has_words(said, each.way)) << each.name << ": " << said;
            EXPECT_TRUE(said.starts_with((folder / each.name).string() + ": ")) << said;
            EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        }
    }
}

/// Texts and numbers that only begin alike are nothing that is known.
TEST_F(ForeignFiles, IgnoreSimilarBeginnings) {
    for (const char* bytes :
         {"", "version https://example.org", "ply", "160&120&", "160&120", "&&&", "1&2&&", "16a&120&1&",
          "VERSION 1\n", "# .PCD v0.7\nWIDTH x\nHEIGHT\n", "MATLA", "\x89HDF"}) {
        text("x.dat", bytes);
        const std::string said = refusal("x.dat");
        EXPECT_TRUE(said.ends_with(": is empty") || said.ends_with(": is not a Matroska file") ||
                    has_words(said, "is of no kind that is known"))
            << said;
    }
}

TEST_F(ForeignFiles, IncludeZarrFolders) {
    const std::array<const char*, 3> marks[] = {
        {"a.zarr/.zgroup", "{}", ")['NAME'][:])"},
        {"b.zarr/zarr.json", R"({"node_type": "group"})", ")['NAME'][:])"},
        {"c.zarr/.zarray", "{}", ")[:])"},
        {"d.zarr/zarr.json", R"({"node_type": "array"})", ")[:])"}};
    for (const auto& [mark, bytes, taken] : marks) {
        text(mark, bytes);
        const std::string name = std::filesystem::path(mark).parent_path().string();
        const std::string place = (folder / name).replace_extension().string();
        EXPECT_TRUE(has_words(refusal(name), "is a Zarr store: numpy.save('" + place + ".npy', zarr.open('" +
                                                 place + ".zarr'" + taken));
    }
    EXPECT_TRUE(is_refused(open_clip(folder.path()), ".zarr is a Zarr store"));
}

/// Names as Python and a shell read them.
TEST_F(ForeignFiles, AreQuotedInCommands) {
    text("it's \\ here.jp2", "\xff\x4f\xff\x51" + std::string(64, '\0'));
    const std::string said = refusal("it's \\ here.jp2");
    EXPECT_TRUE(has_words(said, "it\\'s \\\\ here.jp2').save('"));
    EXPECT_TRUE(has_words(said, "it'\\''s \\ here.png'"));
}

TEST_F(ForeignFiles, IncludeTorchsZip) {
    const std::filesystem::path file = folder / "t.pth";
    zip_t* const archive = zip_open(file.c_str(), ZIP_CREATE, nullptr);
    zip_file_add(archive, "archive/data.pkl", zip_source_buffer(archive, "abc", 3, 0), 0);
    zip_close(archive);
    EXPECT_TRUE(has_words(refusal("t.pth"), "is a file of PyTorch"));
}

/// What reads them goes by their separators, their headings and what their lines end in.
TEST_F(ForeignFiles, IncludeTablesOfNumbers) {
    const auto rows = [](const std::string& between, const std::string& end, int count = 40) {
        std::string all;
        for (int row = 0; row < 30; ++row) {
            for (int n = 0; n < count; ++n) all += (n > 0 ? between : "") + std::to_string(1000 + n) + ".25";
            all += end;
        }
        return all;
    };
    const std::pair<std::string, const char*> all[] = {
        {rows(",", "\n"), "x.csv', delimiter=','))"},
        {rows("; ", "\r\n"), "x.csv', delimiter=';'))"},
        {rows("\t", "\n"), "x.csv'))"},
        {rows("  ", " \n"), "x.csv'))"},
        {rows(",", ",\n"), "x.csv', delimiter=',')[:, :-1])"},
        {"frame 3\nwidth, 40\n" + rows(",", "\n"), "x.csv', delimiter=',', skip_header=2))"},
        {rows(",", "\n", 4000), "x.csv', delimiter=','))"},
    };
    for (const auto& [bytes, way] : all) {
        text("x.csv", bytes);
        EXPECT_TRUE(has_words(refusal("x.csv"), "is text, a row of numbers a line"));
        EXPECT_TRUE(has_words(refusal("x.csv"), way));
    }
    text("x.asc", "ncols 40\nnrows 30\n" + rows(" ", "\n"));
    EXPECT_TRUE(has_words(refusal("x.asc"), "is a grid of heights (ESRI; what is high is near"));
    // Poses, a camera and words are no rows of pixels.
    for (const std::string& bytes :
         {rows(" ", "\n", 16), std::string("525 525 319.5 239.5\n"), rows(" word ", "\n")}) {
        text("x.csv", bytes);
        EXPECT_TRUE(has_words(refusal("x.csv"), "is of no kind that is known"));
    }
}

TEST_F(ForeignFiles, IncludeRawNumbers) {
    const std::vector<float> floats(2 * 256 * 192, 1.25F);
    const std::string bytes(reinterpret_cast<const char*>(floats.data()), 4 * floats.size());
    text("1000.bin", bytes);
    EXPECT_TRUE(has_words(refusal("1000.bin"), "1000.bin', 'f4').reshape(-1, 192, 256).squeeze())"));
    text("1000.bin", bytes.substr(4));
    EXPECT_TRUE(has_words(refusal("1000.bin"), "'f4').reshape(-1, HEIGHT, WIDTH)"));
    const std::vector<double> doubles(320 * 240, 0.3);
    text("d.dat", std::string(reinterpret_cast<const char*>(doubles.data()), 8 * doubles.size()));
    EXPECT_TRUE(has_words(refusal("d.dat"), "d.dat', 'f8').reshape(-1, 240, 320)"));
    std::string codes;
    for (int k = 0; k < 640 * 480; ++k) codes += std::string("\xe8\3", 2);
    text("d.raw", codes);
    EXPECT_TRUE(has_words(refusal("d.raw"), "d.raw', 'u2').reshape(-1, 480, 640)"));
    text("session/depth/7.bin", bytes);
    EXPECT_TRUE(
        has_words(refusal("session"), "but depth/7.bin is raw numbers without a header, 393216 bytes"));
}

/// The folder's message has the way, instead of one to a message that has it.
TEST_F(ForeignFiles, IncludeRecord3dInFolders) {
    text("take/take.r3d", "PK");
    EXPECT_TRUE(has_words(refusal("take"), "but take.r3d is a recording of Record3D"));
    text("unzipped/rgbd/0.depth", "bvx2 and more");
    text("unzipped/rgbd/0.conf", "bvx2 and more");
    EXPECT_TRUE(has_words(refusal("unzipped"), "but rgbd/0.depth is a picture of Record3D"));
    EXPECT_TRUE(
        has_words(refusal("unzipped"), "z = pathlib.Path('" + (folder / "unzipped/").string() + "')"));
    EXPECT_TRUE(has_words(refusal("unzipped"), "reshape(m['dh'], m['dw'])"));
}

// Panoramas, which no pinhole camera sees.

using Panorama = ForeignFiles;

TEST_F(Panorama, IsNamedByItsNameAndShape) {
    const Image wide_one = made_image(64, 32, 2, 1, [](int x, int y, int) { return 1000 + 10 * x + y; });
    const Image other = made_image(64, 30, 2, 1, [](int x, int y, int) { return 1000 + 10 * x + y; });
    const auto said = [&](const std::string& name, const Image& image) {
        write_in_folder(folder / name, image);
        return refusal(name);
    };
    for (const char* name : {"a/panorama_depth.png", "a/room-equirectangular.png", "b/ERP_depth.png",
                             "pano/1/d.png", "c/depth_360cam.png", "c/360_depth.png", "spherical/d.png",
                             "KITTI-360/d.png", "d/Pano2_depth.png"}) {
        const std::string refused = said(name, wide_one);
        EXPECT_TRUE(has_words(refused, "is an equirectangular panorama (as its name says; ")) << name;
        EXPECT_TRUE(has_words(refused, "py360convert.e2p(cv2.imread('" + (folder / name).string() +
                                           "', -1), 90, 0, 0, (21, 21), mode='nearest'))"));
        EXPECT_EQ(said(name, other), "") << name;
    }
    for (const char* name : {"a/depth_360.png", "a/depth_003600.png", "a/depth_360p.png", "companions/d.png",
                             "a/panoptic_d.png"})
        EXPECT_EQ(said(name, wide_one), "") << name;
}

/// Cube maps, fisheye pictures and cylinders are refused by their names and shapes.
TEST_F(Panorama, HasOtherProjections) {
    const auto said = [&](const std::string& name, int width, int height) {
        write_in_folder(folder / name,
                        made_image(width, height, 2, 1, [](int x, int y, int) { return 1000 + 10 * x + y; }));
        return refusal(name);
    };
    EXPECT_TRUE(has_words(said("cubemap_depth.png", 96, 16), ", -1)[0:16, :16])"));
    EXPECT_TRUE(has_words(said("a/skybox.png", 64, 48), ", -1)[16:32, :16])"));
    EXPECT_TRUE(has_words(said("cube/0.png", 96, 16), "is a cube map (as its name says"));
    EXPECT_TRUE(has_words(said("fisheye_depth.png", 40, 40), "cv2.remap(cv2.imread('"));
    EXPECT_TRUE(has_words(said("b/cylinder_depth.png", 96, 24),
                          "is a fisheye's or a cylinder's picture (as its name says"));
    // A face of a cube map is a pinhole's; things have these shapes too.
    for (const auto& [name, width] :
         {std::pair{"a/skybox1.png", 48}, {"a/cube.png", 64}, {"a/cylinder.png", 64}})
        EXPECT_EQ(said(name, width, 48), "") << name;
}

/// Depth of a box from its middle, all around; and of a floor and a ceiling as a pinhole sees them.
TEST_F(Panorama, IsDoubtedByItsValues) {
    const auto doubted = [&](const std::string& name, const auto& metres) {
        write_bytes(folder / name, pfm_of(96, 48, [&](int x, int y) { return metres(x + 0.5, 47.5 - y); }));
        const auto clip = must(open_clip(folder / name));
        EXPECT_FALSE(is_noted(*clip, "though they are larger in the lower third")) << name;
        return is_noted(*clip,
                        "the camera is a pinhole, though the picture may be an equirectangular panorama");
    };
    constexpr double pi = 3.14159265358979;
    const auto sphere = [](double x, double y) {
        const double turn = x / 48 * pi, up = (0.5 - y / 48) * pi;
        return 1 / std::max({std::abs(std::sin(up)) / 1.2, std::abs(std::cos(up) * std::sin(turn)) / 3,
                             std::abs(std::cos(up) * std::cos(turn)) / 2});
    };
    const auto corridor = [](double x, double y) {
        return 40 / std::max({std::abs(y - 24), std::abs(x - 48) / 1.5, 4.0});
    };
    EXPECT_TRUE(doubted("a.pfm", sphere));
    EXPECT_FALSE(doubted("b.pfm", corridor));
    EXPECT_FALSE(doubted("c.pfm", [](double x, double) { return std::abs(x - 48) < 9 ? 1.5 : 2.0; }));
}

TEST_F(Panorama, IsNamedInFolders) {
    for (const char* name : {"pano/depth/0.png", "pano/depth/1.png"})
        write_in_folder(folder / name,
                        made_image(64, 32, 2, 1, [](int x, int y, int) { return 1000 + 10 * x + y; }));
    for (const char* name : {"pano/rgb/0.png", "pano/rgb/1.png"})
        write_in_folder(folder / name,
                        made_image(64, 32, 1, 3, [](int x, int, int c) { return x + 50 * c; }));
    const std::string said = refusal("pano");
    EXPECT_TRUE(has_words(said, "/pano/depth/0.png', -1), 90"));
    EXPECT_TRUE(has_words(said, "cv2.imwrite('view.png', py360convert.e2p(cv2.imread('"));
    EXPECT_TRUE(has_words(said, "/pano/rgb/0.png', -1), 90"));
}

/// Google's photo spheres have the projection in their XMP, whatever their names and shapes.
TEST_F(Panorama, IsNamedByXmp) {
    const auto with_xmp = [](const std::string& projection) {
        const std::string jpeg =
            jpeg_of(48, 32, [](int x, int, int plane) { return plane > 0 ? 128 : 5 * x; });
        return jpeg.substr(0, 2) +
               xmp_segment("<x><rdf:Description GPano:ProjectionType='" + projection + "'/></x>") +
               jpeg.substr(2);
    };
    write_bytes(folder / "a.jpg", with_xmp("equirectangular"));
    EXPECT_TRUE(has_words(refusal("a.jpg"), "is an equirectangular panorama (as its XMP says; "));
    write_bytes(folder / "b.jpg", with_xmp("cylindrical"));
    EXPECT_EQ(refusal("b.jpg"), "");
    // Of colour beside depth, named as cameras do.
    write_bytes(folder / "R1.JPG", with_xmp("equirectangular"));
    write_in_folder(folder / "R1_depth.png",
                    made_image(48, 32, 2, 1, [](int x, int y, int) { return 900 + x + y; }));
    EXPECT_TRUE(has_words(refusal("R1_depth.png"), "R1.JPG', -1), 90"));
}

/// A person who states the camera knows better than a name.
TEST_F(Panorama, OpensWithStatedCamera) {
    write_in_folder(folder / "pano_depth.png",
                    made_image(64, 32, 2, 1, [](int x, int y, int) { return 1000 + 10 * x + y; }));
    SourceDescription known;
    known.metres_per_code = 0.001;
    EXPECT_TRUE(has_words(refusal("pano_depth.png", known), "is an equirectangular panorama"));
    known.fov = 90;
    const auto clip = must(open_clip(folder / "pano_depth.png", {}, known));
    EXPECT_NEAR(clip->scene().camera.fx, 32, 1e-9);
    EXPECT_TRUE(is_noted(
        *clip, "the picture may be an equirectangular panorama, and is taken for that of the camera"));
}

TEST_F(ForeignFiles, AreNamedInEmptyFolders) {
    text("stereo/depth_maps/i.jpg.geometric.bin", "160&120&1&");
    const std::string said = message(open_clip(folder.path()));
    EXPECT_TRUE(has_words(said,
                          "no pictures of depth were found (there are no pictures), but "
                          "stereo/depth_maps/i.jpg.geometric.bin is a depth map of COLMAP"));
}

TEST_F(ForeignFiles, IncludePointersInFolders) {
    // All of it.
    for (const char* name : {"a/depth/0.png", "a/depth/1.png", "a/rgb/0.jpg", "a/rgb/1.jpg"})
        text(name, lfs_pointer);
    EXPECT_TRUE(has_words(refusal("a"), "0.png: is a Git LFS pointer"));
    // No name says which is depth.
    text("n/left/0.png", lfs_pointer);
    EXPECT_TRUE(has_words(refusal("n"), "left/0.png is a Git LFS pointer"));
    // Colour alone: depth opens, and a note names colour.
    for (const char* name : {"b/depth/0.png", "b/depth/1.png"}) depth(name);
    for (const char* name : {"b/rgb/0.jpg", "b/rgb/1.jpg"}) text(name, lfs_pointer);
    const auto reader = must(open_clip(folder / "b"));
    EXPECT_TRUE(is_noted(*reader, "left out: rgb/*.jpg, whose first is a Git LFS pointer"));
    // A single frame of depth.
    text("b/depth/1.png", lfs_pointer);
    const auto cut = open_clip(folder / "b");
    EXPECT_TRUE(has_words(cut ? message(read_all(**cut)) : message(cut), "1.png: is a Git LFS pointer"));
}

}  // namespace
}  // namespace touchable::test
