// Files of other programs that are not opened: each gets one line with what it is and what to do.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <stop_token>

#include "engine/base/threads.hpp"
#include "engine/formats/foreign_files.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/organised_cloud.hpp"
#include "engine/formats/zip_folder.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/picture/hdf5_file.hpp"
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
        {"m.ply", "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nelement face 5\r\nend_header\r\n",
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
    SourceDescription known;
    known.fov = 60;
    for (const Foreign& each : all) {
        text(each.name, each.bytes);
        for (const std::string& said :
             {refusal(each.name), refusal(each.name, known), message(guess_clip(folder / each.name, {}))}) {
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
        EXPECT_EQ(foreign_file(SourceFile(folder / "x.dat")), std::nullopt) << bytes;
    }
    EXPECT_EQ(foreign_file(SourceFile(folder / "missing")), std::nullopt);
    EXPECT_EQ(foreign_folder(folder / "missing"), std::nullopt);
    EXPECT_EQ(foreign_file_below(folder / "missing"), std::nullopt);
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
        std::string pfm = "Pf\n96 48\n-1\n";
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 96; ++x) {
                const auto depth = static_cast<float>(metres(x + 0.5, y + 0.5));
                pfm.append(reinterpret_cast<const char*>(&depth), sizeof depth);
            }
        write_bytes(folder / name, pfm);
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
        const std::string jpeg = encoded("mjpeg", AV_PIX_FMT_YUVJ444P, 48, 32, [](AVFrame& frame) {
            for (int plane = 0; plane < 3; ++plane)
                for (int y = 0; y < 32; ++y)
                    for (int x = 0; x < 48; ++x)
                        frame.data[plane][y * frame.linesize[plane] + x] =
                            static_cast<std::uint8_t>(plane > 0 ? 128 : 5 * x);
        });
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

// Organised clouds of points (PCD, PLY): depth, colour and the camera from a point for each pixel.

constexpr int cloud_width = 16, cloud_height = 12;
constexpr double fx = 20.5, fy = 21, cx = 7.25, cy = 5.75;
using Point = std::array<double, 3>;
using Points = std::vector<Point>;

double cloud_depth(int i, int j) {
    return i == 3 && j == 2 ? std::nan("") : 1 + 0.01 * i + 0.02 * j * j;
}
/// Red, green, blue of a pixel.
std::uint32_t cloud_colour(int i, int j) {
    return static_cast<std::uint32_t>(i + 1) << 16 | static_cast<std::uint32_t>(j) << 8 | 200U;
}

/// Row by row. OpenGL's frame has y up and z backwards.
Points points(bool of_opengl = false) {
    const double sign = of_opengl ? -1 : 1;
    Points all;
    for (int j = 0; j < cloud_height; ++j)
        for (int i = 0; i < cloud_width; ++i) {
            const double z = cloud_depth(i, j);
            all.push_back({(i - cx) / fx * z, sign * (j - cy) / fy * z, sign * z});
        }
    return all;
}

/// A number's bytes, the lowest first, or the highest.
template <class Number>
std::string bytes_of(Number number, bool big_endian = false) {
    std::string bytes(reinterpret_cast<const char*>(&number), sizeof number);
    if (big_endian) std::ranges::reverse(bytes);
    return bytes;
}

std::string pcd_header(const std::string& data, const std::string& fields = "x y z rgb") {
    return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields +
           "\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 16\nHEIGHT 12\nVIEWPOINT 0 0 0 1 0 0 0\n"
           "POINTS 192\nDATA " +
           data + '\n';
}

std::uint32_t colour_of(std::size_t k) {
    return cloud_colour(static_cast<int>(k) % cloud_width, static_cast<int>(k) / cloud_width);
}

std::string pcd_text(const Points& all) {
    std::string text = pcd_header("ascii");
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (const double number : all[k]) text += std::to_string(number) + ' ';
        text += std::to_string(colour_of(k)) + '\n';
    }
    return text;
}

std::string pcd_binary(const Points& all) {
    std::string bytes = pcd_header("binary");
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (const double number : all[k]) bytes += bytes_of(static_cast<float>(number));
        bytes += bytes_of(colour_of(k));
    }
    return bytes;
}

/// Fields one behind the other, packed by LZF: literals, and where a byte is the one before, references.
std::string pcd_packed(const Points& all) {
    std::string planes;
    for (const std::size_t axis : {0U, 1U, 2U})
        for (const Point& point : all) planes += bytes_of(static_cast<float>(point[axis]));
    for (std::size_t k = 0; k < all.size(); ++k) planes += bytes_of(colour_of(k));
    planes.resize(planes.size() - 4);
    std::string packed;
    for (std::size_t at = 0; at < planes.size(); at += 32) {
        const std::string some = planes.substr(at, 32);
        packed += static_cast<char>(some.size() - 1) + some;
    }
    packed += std::string("\x20\x03", 2);  // 3 bytes again, of 4 before
    packed += std::string("\0\0", 2);      // and one, 0
    return pcd_header("binary_compressed") + bytes_of(static_cast<std::uint32_t>(packed.size())) +
           bytes_of(static_cast<std::uint32_t>(planes.size() + 4)) + packed;
}

std::string ply_header(const std::string& format, const std::string& size, std::size_t count,
                       const std::string& type, const std::string& more = "") {
    std::string text = "ply\nformat " + format + " 1.0\n" + size + "element vertex " + std::to_string(count);
    for (const char* axis : {"x", "y", "z"}) text += "\nproperty " + type + ' ' + axis;
    for (const char* colour : {"red", "green", "blue"}) text += std::string("\nproperty uchar ") + colour;
    return text + '\n' + more + "end_header\n";
}

const std::string num_cols = "obj_info num_cols 16\nobj_info num_rows 12\n",
                  comments = "comment width 16\ncomment height 12\n",
                  grid_of_points = "element range_grid 192\nproperty list uchar int vertex_indices\n";

std::string ply_colour(std::size_t k) {
    const std::uint32_t rgb = colour_of(k);
    return {static_cast<char>(rgb >> 16), static_cast<char>(rgb >> 8), static_cast<char>(rgb)};
}

template <class Number>
std::string ply_binary(const Points& all, bool big_endian, const std::string& size) {
    std::string bytes = ply_header(big_endian ? "binary_big_endian" : "binary_little_endian", size,
                                   all.size(), sizeof(Number) == 8 ? "double" : "float32");
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (const double number : all[k]) bytes += bytes_of(static_cast<Number>(number), big_endian);
        bytes += ply_colour(k);
    }
    return bytes;
}

std::string ply_text(const Points& all) {
    std::string text = ply_header("ascii", num_cols, all.size(), "float");
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (const double number : all[k]) text += std::to_string(number) + ' ';
        for (const char colour : ply_colour(k))
            text += std::to_string(static_cast<unsigned char>(colour)) + ' ';
        text += '\n';
    }
    return text;
}

/// Only pixels with depth have a point, and a list says which.
std::string ply_range_grid(const Points& all) {
    std::string seen, grid;
    std::int32_t count = 0;
    for (std::size_t k = 0; k < all.size(); ++k) {
        if (std::isnan(all[k][2])) {
            grid += '\0';
            continue;
        }
        for (const double number : all[k]) seen += bytes_of(static_cast<float>(number));
        seen += ply_colour(k);
        grid += '\1' + bytes_of(count++);
    }
    return ply_header("binary_little_endian", num_cols, static_cast<std::size_t>(count), "float",
                      grid_of_points) +
           seen + grid;
}

/// The last row first.
Points from_below(const Points& all) {
    Points turned;
    for (int j = cloud_height; j-- > 0;)
        turned.insert(turned.end(), all.begin() + j * cloud_width, all.begin() + (j + 1) * cloud_width);
    return turned;
}

void expect_camera(const Scene& scene) {
    EXPECT_NEAR(scene.camera.fx, fx, 0.01);
    EXPECT_NEAR(scene.camera.fy, fy, 0.01);
    EXPECT_NEAR(scene.camera.cx, cx, 0.01);
    EXPECT_NEAR(scene.camera.cy, cy, 0.01);
}

void expect_depth(const Scene& scene, const RawFrame& frame) {
    for (int j = 0; j < cloud_height; ++j)
        for (int i = 0; i < cloud_width; ++i) {
            const auto code = frame.depth.sample(i, j);
            ASSERT_EQ(scene.depth.is_valid(code), !std::isnan(cloud_depth(i, j)));
            if (std::isnan(cloud_depth(i, j))) continue;
            ASSERT_NEAR(scene.depth.depth(code) * scene.metres_per_unit, cloud_depth(i, j), 1e-3);
        }
}

using OrganisedCloud = FolderTest;

TEST_F(OrganisedCloud, GivesDepthColourAndCamera) {
    const std::pair<const char*, std::string> all[] = {
        {"text.pcd", pcd_text(points())},
        {"binary.pcd", pcd_binary(points())},
        {"packed.pcd", pcd_packed(points())},
        {"opengl.pcd", pcd_binary(points(true))},
        {"text.ply", ply_text(points())},
        {"little.ply", ply_binary<float>(points(), false, comments)},
        {"big.ply", ply_binary<double>(points(), true, num_cols)},
        {"grid.ply", ply_range_grid(points(true))},
    };
    for (const auto& [name, bytes] : all) {
        SCOPED_TRACE(name);
        write_bytes(folder / name, bytes);
        auto reader = must(open_clip(folder / name));
        EXPECT_TRUE(is_noted(*reader, std::string("the camera is that of ") + name));
        const auto frames = must(read_all(*reader));
        ASSERT_EQ(frames.size(), 1U);
        expect_camera(reader->scene());
        expect_depth(reader->scene(), frames.front());
        const PlaneView& colour = frames.front().colour;
        ASSERT_FALSE(colour.empty());
        for (const auto& [i, j] : {std::pair{0, 0}, {15, 0}, {5, 7}, {14, 11}})
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_EQ(colour.sample(i, j, channel), cloud_colour(i, j) >> (16 - 8 * channel) & 255U);
    }
}

TEST_F(OrganisedCloud, TurnsRowsFromBelow) {
    write_bytes(folder / "cloud.ply", ply_binary<float>(from_below(points(true)), false, num_cols));
    const auto [reader, frames] = must_read(open_clip(folder / "cloud.ply"));
    expect_camera(reader->scene());
    expect_depth(reader->scene(), frames.front());
}

TEST_F(OrganisedCloud, TakesStatedCamera) {
    write_bytes(folder / "cloud.pcd", pcd_binary(points()));
    SourceDescription known;
    known.intrinsics = Intrinsics{.fx = 30, .fy = 31};
    const auto reader = must(open_clip(folder / "cloud.pcd", {}, known));
    EXPECT_DOUBLE_EQ(reader->scene().camera.fx, 30);
    EXPECT_FALSE(is_noted(*reader, "the camera is that of cloud.pcd"));
}

/// The first one has no point.
TEST_F(OrganisedCloud, OpensSeveralAsFrames) {
    write_bytes(folder / "cloud_0.pcd", pcd_binary(Points(cloud_width * cloud_height, Point{0, 0, 0})));
    for (const char* name : {"cloud_1.pcd", "cloud_2.pcd"}) write_bytes(folder / name, pcd_binary(points()));
    // A mesh is none, nor does it keep the others from being opened.
    write_bytes(folder / "depth_mesh.ply",
                "ply\nformat ascii 1.0\nelement vertex 3\nelement face 1\nend_header\n");
    auto reader = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(*reader, "depth is cloud_*.pcd, colour is in the same files"));
    EXPECT_TRUE(is_noted(*reader, "the camera is that of cloud_0.pcd"));
    const auto frames = must(read_all(*reader));
    ASSERT_EQ(frames.size(), 3U);
    expect_camera(reader->scene());
    expect_depth(reader->scene(), frames[2]);
}

/// A cloud that was made of them, of the same number of frames, is not read in their place.
TEST_F(OrganisedCloud, GivesWayToPictures) {
    for (const char* name : {"0", "1"}) {
        write_in_folder(folder / (std::string(name) + ".png"), even_image(16, 12, 2, 1, 771));
        write_bytes(folder / (std::string("a") + name + ".pcd"), pcd_binary(points()));
    }
    const auto reader = must(open_clip(folder.path()));
    EXPECT_TRUE(is_noted(*reader, "depth is *.png"));
}

TEST_F(OrganisedCloud, IsGuessed) {
    write_bytes(folder / "cloud.pcd", pcd_binary(points()));
    const auto guessed = must(guess_clip(folder / "cloud.pcd", {}));
    EXPECT_NEAR(guessed.scene.camera.fx, fx, 0.01);
    EXPECT_EQ(guessed.scene.folder->depth, "cloud.pcd");
}

TEST_F(OrganisedCloud, RefusesDamage) {
    const auto refusal = [](const std::string& bytes) { return message(decode_organised_cloud(bytes, "c")); };
    const std::string binary = pcd_binary(points()), packed = pcd_packed(points()), text = pcd_text(points()),
                      ply = ply_binary<float>(points(), false, num_cols), grid = ply_range_grid(points()),
                      ply_words = ply_text(points());
    const auto with = [](std::string bytes, const std::string& old, const std::string& other) {
        return bytes.replace(bytes.find(old), old.size(), other);
    };
    for (const std::string& whole : {binary, packed, text, ply, grid, ply_words}) {
        EXPECT_EQ(refusal(whole), "");
        EXPECT_TRUE(
            has_words(refusal(whole.substr(0, whole.size() - 25)), "has fewer points than its header"))
            << refusal(whole.substr(0, whole.size() - 25));
    }
    std::string none = ply_header("ascii", num_cols, 0, "float", grid_of_points) + '0';
    for (std::size_t k = 1; k < points().size(); ++k) none += " 0";
    EXPECT_EQ(refusal(none), "") << "no pixel has a point, and the last one ends the file";
    const std::pair<std::string, const char*> damaged[] = {
        {pcd_header("binary", "x y w rgb"), "has no fields x, y and z"},
        {with(binary, "TYPE F", "TYPE Q"), "has no fields x, y and z"},
        {with(binary, "SIZE 4", "SIZE 3"), "has no fields x, y and z"},
        {pcd_header("ascii2"), "are \"ascii2\""},
        {"# .PCD v0.7\nWIDTH 2", "its header is not that of a PCD file"},
        {with(binary, "POINTS 192", "POINTS 191"), "has 191 points: must be 192"},
        {with(binary, "WIDTH 16", "WIDTH 99999999"), "is 99999999x12 pixels"},
        {with(with(binary, "WIDTH 16", "WIDTH 16384"), "POINTS 192", "#"), "has fewer points"},
        {with(with(packed, "WIDTH 16", "WIDTH 9216"), "POINTS 192", "#"), "are said to unpack to 3072 bytes"},
        {with(text, "DATA ascii\n", "DATA ascii\ntwo "), "point 0 has \"two\": must be a number"},
        {with(ply, "element vertex 192", "element vertex 191"), "its header is not that of a PLY"},
        {with(ply, "format binary_little_endian", "format text"), "its format is \"text\""},
        {with(ply, "property float32 z", "property float32 w"), "have no x, y and z"},
        {with(grid, "element range_grid 192", "element range_grid 193"), "its header is not that of a PLY"},
        {grid.substr(0, grid.size() - 4) + std::string(4, '\x7f'), "pixel 191 has point 2139062143 of 191"},
    };
    for (const auto& [bytes, why] : damaged) EXPECT_TRUE(has_words(refusal(bytes), why));
    std::string bad = packed;
    bad[bad.size() - 3] = '\x7f';  // what is so far back is not there, or not what follows
    bad[bad.size() - 4] = '\x3f';
    EXPECT_TRUE(has_words(refusal(bad), "cannot be unpacked"));
    // A gigabyte is stated of a few bytes.
    std::string bomb = pcd_header("binary_compressed");
    bomb = with(with(with(bomb, "WIDTH 16", "WIDTH 8192"), "HEIGHT 12", "HEIGHT 8192"), "POINTS 192", "#");
    bomb += bytes_of(std::uint32_t{64}) + bytes_of(std::uint32_t{1} << 30) + std::string(64, '\0');
    EXPECT_TRUE(has_words(refusal(bomb), "is damaged, or too large"));
}

/// Even steps of an angle, as of a lidar; and rays that are parallel.
TEST_F(OrganisedCloud, RefusesOtherCameras) {
    Points ring = points(), parallel = points();
    for (std::size_t k = 0; k < ring.size(); ++k) {
        const auto column = static_cast<double>(k % cloud_width), row = static_cast<double>(k / cloud_width);
        const double angle = column * 2 * 3.14159265 / cloud_width;
        ring[k] = {std::sin(angle), row, std::cos(angle) + 0.01};
        parallel[k] = {column, row, 1 + static_cast<double>(k * k % 17)};
    }
    for (const Points& all : {ring, parallel}) {
        const std::string said = message(decode_organised_cloud(pcd_binary(all), "c"));
        EXPECT_TRUE(has_words(said, "not the pixels of one pinhole camera"));
        EXPECT_TRUE(has_words(said, "project_to_depth_image"));
    }
}

TEST_F(OrganisedCloud, IsRecognisedByHeader) {
    EXPECT_TRUE(begins_organised_cloud(pcd_header("binary")));
    EXPECT_TRUE(begins_organised_cloud(ply_header("ascii", comments, 192, "float")));
    EXPECT_FALSE(begins_organised_cloud("# .PCD v0.7\nFIELDS x y z\nWIDTH 9\nHEIGHT 1\nDATA ascii\n"));
    EXPECT_FALSE(begins_organised_cloud("VERSION of something\n"));
    EXPECT_FALSE(begins_organised_cloud(ply_header("ascii", "", 192, "float")));
    EXPECT_FALSE(begins_organised_cloud(ply_header("ascii", comments, 192, "float", "element face 2\n")));
}

// ZIP archives of pictures, opened as the folders that they unpack to.

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

// HDF5 files and folders of them, opened as clips.

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

TEST_F(Hdf5Clip, OpensStack) {
    add("demos.hdf5", {"data/demo_0/obs/agentview_depth", {3, 16, 20, 1}}, 1000);
    add("demos.hdf5", {"data/demo_1/obs/agentview_depth", {2, 16, 20, 1}}, 5000);
    EXPECT_TRUE(is_refused(open("demos.hdf5"), "has several data sets that may be depth: /data/demo_0/obs/"));
    const auto clip = must(open("demos.hdf5", "data/demo_1/obs/agentview_depth"));
    EXPECT_EQ(clip->scene().width, 20);
    EXPECT_EQ(clip->tracks().front().codec, "hdf5");
    EXPECT_EQ(first_codes(*clip), (std::vector{5000, 5320}));
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

TEST_F(Hdf5Clip, NamesDataSetsWithoutDepth) {
    add("c.h5", {"colors", {16, 20, 3}, "UIN", 8}, 0);
    EXPECT_EQ(message(open("c.h5")),
              (folder_ / "c.h5").string() +
                  ": is an HDF5 file without a data set of pictures of depth (height x "
                  "width, or count x height x width): it has /colors of 16x20x3");
}

}  // namespace
}  // namespace touchable::test
