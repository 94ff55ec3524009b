// SPDX-License-Identifier: Apache-2.0
#include "tests/import/source_writer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "engine/picture/image.hpp"
#include "tests/import/bag_bytes.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/import/heic_file.hpp"
#include "tests/picture/picture_bytes.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

const std::string measured_columns = "[140.5, 0, 0, 0, 140.7, 0, 79.9, 60.1, 1]";

// Phones and tablets.

std::string apple_matrix() {
    std::string matrix;
    for (const char* number : {"1405", "0", "0", "0", "1407", "0", "803.5", "605.5", "1"})
        matrix += std::string("<rdf:li>") + number + "</rdf:li>";
    return matrix;
}

Made iphone(Writer& w) {
    constexpr double least = 0.4, most = 1.4;
    const auto code = [](int x, int y) {
        return static_cast<int>(std::lround(255 * (1 / room(0, std::max(x, 4), y) - least) / (most - least)));
    };
    HeicFile file;
    file.colour = made_image(2 * wide, 2 * high, 1, 3, [](int x, int y, int c) {
        return c == 0 ? (2 * wide * y + x) % 200 : c == 1 ? 120 : 40;
    });
    file.depth = made_image(wide, high, 1, 1, [&](int x, int y, int) { return code(x, y); });
    file.depth_xmp =
        "<x:xmpmeta><rdf:RDF><rdf:Description><apdi:AuxiliaryImageType>disparity</apdi:AuxiliaryImageType>"
        "<apdi:FloatMinValue>0.4</apdi:FloatMinValue><apdi:FloatMaxValue>1.4</apdi:FloatMaxValue>"
        "<depthData:IntrinsicMatrixReferenceWidth>1600</depthData:IntrinsicMatrixReferenceWidth>"
        "<depthData:IntrinsicMatrixReferenceHeight>1200</depthData:IntrinsicMatrixReferenceHeight>"
        "<depthData:IntrinsicMatrix><rdf:Seq>" +
        apple_matrix() + "</rdf:Seq></depthData:IntrinsicMatrix></rdf:Description></rdf:RDF></x:xmpmeta>";
    const fs::path photo = w / w.name("IMG_1234.HEIC", "a.bin");
    write_bytes(photo, file.bytes());
    return made(
        photo, [=](int, int x, int y) { return 1 / (least + (most - least) * code(x, y) / 255); },
        {140.5, 140.7, (803.5 - 799.5) / 10 + 79.5, (605.5 - 599.5) / 10 + 59.5}, 1, 30, true);
}

/// The disparity is the second JPEG of the file.
Made iphone_jpeg(Writer& w) {
    constexpr double least = 0.4, most = 1.4;
    const std::string map =
        jpeg_of(wide, high, [](int x, int, int plane) { return plane > 0 ? 128 : 16 * (x / 16); });
    w.colour("photo.jpg");
    const std::string photo = read_bytes(w / "photo.jpg"),
                      xmp =
                          "<x:xmpmeta><rdf:RDF><rdf:Description apdi:AuxiliaryImageType='disparity' "
                          "apdi:FloatMinValue='0.4' apdi:FloatMaxValue='1.4' "
                          "depthData:IntrinsicMatrixReferenceWidth='1600' "
                          "depthData:IntrinsicMatrixReferenceHeight='1200'><depthData:IntrinsicMatrix>"
                          "<rdf:Seq>" +
                          apple_matrix() +
                          "</rdf:Seq></depthData:IntrinsicMatrix></rdf:Description></rdf:RDF></x:xmpmeta>";
    fs::remove(w / "photo.jpg");
    const fs::path file = w / w.name("IMG_0042.JPG", "a.bin");
    write_bytes(file, photo + map.substr(0, 2) + xmp_segment(xmp) + map.substr(2));
    Made all = made(
        file, [](int, int x, int) { return 1 / (least + (most - least) * (16 * (x / 16)) / 255); },
        {140.5, 140.7, (803.5 - 799.5) / 10 + 79.5, (605.5 - 599.5) / 10 + 59.5}, 1, 30, true);
    all.lost_codes = 2;
    return all;
}

std::string grey_png(const std::function<int(int, int)>& code) {
    const Image image = made_image(wide, high, 1, 1, [&](int x, int y, int) { return code(x, y); });
    return must(png_bytes(image.view(), PngEffort::quick));
}
/// GDepth's and DepthMap's RangeInverse: 0 is far, 255 near.
int range_inverse(int x, int y) {
    return static_cast<int>(std::lround(255 * (2.5 - 2.5 * 0.5 / room(0, std::max(x, 4), y)) / (2.5 - 0.5)));
}
Depth of_range_inverse() {
    return [](int, int x, int y) { return 2.5 * 0.5 / (2.5 - range_inverse(x, y) / 255.0 * (2.5 - 0.5)); };
}
std::string photo_bytes(Writer& w) {
    w.colour("photo.jpg");
    const std::string bytes = read_bytes(w / "photo.jpg");
    fs::remove(w / "photo.jpg");
    return bytes;
}

Made dynamic_depth(Writer& w) {
    const std::string map = grey_png(range_inverse), photo = photo_bytes(w);
    const std::string xmp =
        "<x:xmpmeta><rdf:RDF><rdf:Description><Device:Container><Container:Directory><rdf:Seq>"
        "<rdf:li><Container:Item Item:Mime='image/jpeg' Item:Length='0' Item:DataURI='primary_image'/>"
        "</rdf:li><rdf:li><Container:Item Item:Mime='image/png' Item:Length='" +
        std::to_string(map.size()) +
        "' Item:DataURI='android/depthmap'/></rdf:li></rdf:Seq></Container:Directory></Device:Container>"
        "<Device:Cameras><rdf:Seq><rdf:li><Device:Camera><Camera:DepthMap DepthMap:Format='RangeInverse' "
        "DepthMap:Near='0.5' DepthMap:Far='2.5' DepthMap:Units='Meters' "
        "DepthMap:DepthURI='android/depthmap'/><Camera:ImagingModel ImagingModel:FocalLengthX='140.5' "
        "ImagingModel:FocalLengthY='140.7' ImagingModel:ImageWidth='160' ImagingModel:ImageHeight='120' "
        "ImagingModel:PrincipalPointX='80' ImagingModel:PrincipalPointY='60'/></Device:Camera></rdf:li>"
        "</rdf:Seq></Device:Cameras></rdf:Description></rdf:RDF></x:xmpmeta>";
    const fs::path file = w / w.name("PXL_20200101_portrait.jpg", "a.bin");
    write_bytes(file, photo.substr(0, 2) + xmp_segment(xmp) + photo.substr(2) + map);
    return made(file, of_range_inverse(), {140.5, 140.7, 80, 60}, 1, 30, true);
}

Made gdepth(Writer& w) {
    const std::string photo = photo_bytes(w), extended = "<x><rdf:Description GDepth:Data=\"" +
                                                         encode_base64(grey_png(range_inverse)) + "\"/></x>";
    std::string segments = xmp_segment("<x><rdf:Description xmpNote:HasExtendedXMP='" + std::string(guid) +
                                       "' GDepth:Format='RangeInverse' GDepth:Near='0.5' GDepth:Far='2.5' "
                                       "GDepth:Mime='image/png'/></x>");
    for (std::size_t from = 0; from < extended.size(); from += 60000)
        segments += extension_segment(guid, extended, from, std::min(from + 60000, extended.size()));
    const fs::path file = w / w.name("IMG_0001.jpg", "a.bin");
    write_bytes(file, photo.substr(0, 2) + segments + photo.substr(2));
    return made(file, of_range_inverse(), seen(60), 1, 30, true);
}

Made cinematic(Writer& w) {
    const RelativeDepth depth{255};
    const auto value = depth.values();
    ForeignVideo colour{"libx265", AV_PIX_FMT_YUV420P, wide, high, 2, {24, 1}};
    write_video(w / "c.mov", colour, [](AVFrame& frame, int n) {
        for (int plane = 0; plane < 3; ++plane)
            fill_plane(frame, plane, [&](int x, int) { return plane ? 90 + x / 2 : 60 + x / 2 + n; });
    });
    ForeignVideo disparity = colour;
    disparity.range = AVCOL_RANGE_JPEG;
    write_video(w / "d.mov", disparity, [&](AVFrame& frame, int) {
        for (int plane = 0; plane < 3; ++plane)
            fill_plane(frame, plane,
                       [&](int x, int y) { return plane ? 128 : static_cast<int>(value(0, x, y)); });
    });
    const fs::path file = w / w.name("IMG_0001.MOV", "a.mov");
    join_cinematic(w / "c.mov", w / "d.mov", file);
    fs::remove(w / "c.mov");
    fs::remove(w / "d.mov");
    return made(
        file, [=, z = depth.metres()](int, int x, int y) { return z(0, x, y); }, seen(60), 2, 24, true);
}

Made iphone_tiff(Writer& w) {
    const auto depth = [](int n, int x, int y) {
        return std::round(4096 * room(n, std::max(x, 4), y)) / 4096;
    };
    write_tiff(w / "1721362630.651355_depth.tiff", floats_of(depth, 0));
    w.colour("1721362630.651355_image.jpg", 2 * wide, 2 * high);
    return made(w / "1721362630.651355_depth.tiff", depth, seen(60), 1, 30, true);
}

Made depth16(Writer& w) {
    const fs::path file = w / w.name("depth.png", "a.png");
    w.png16(file.filename(), [](int x, int y) { return room_code(1000, 0, x, y) | ((x + y) % 8) << 13; });
    return made(file, room_in(1000), seen(60));
}

Made record3d(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), rgb = w.name("rgb/", "b/");
    for (int n = 0; n < 3; ++n) {
        write_exr(w / (depth + std::to_string(n) + ".exr"), {{"R", floats_of(room, 0, n)}});
        w.colour(rgb + std::to_string(n) + ".jpg");
    }
    w.text(w.name("metadata.json", "m.json"),
           R"({"h": 120, "w": 160, "fps": 60, "K": )" + measured_columns +
               R"(, "poses": [[0,0,0,1,0,0,0], [0,0,0,1,0,0,0.1], [0,0,0,1,0,0,0.2]]})");
    return made(w.folder(), room, measured, 3, 60, true);
}

/// Red, green and blue of a hue, 0 to 1535: the fully saturated colour that is nearest.
std::array<int, 3> rgb_of(int code) {
    const int up = static_cast<int>(std::lround(code % 256 * 255 / 256.0)), down = 255 - up;
    switch (code / 256) {
        case 0:
            return {255, up, 0};
        case 1:
            return {down, 255, 0};
        case 2:
            return {0, 255, up};
        case 3:
            return {0, down, 255};
        case 4:
            return {up, 0, 255};
        default:
            return {255, 0, down};
    }
}

Made record3d_video(Writer& w) {
    const auto depth = [](int, int x, int y) { return room_in(512)(0, x, y); };
    const fs::path file = w / w.name("export.mp4", "a.mp4");
    ForeignVideo video{"libx264rgb", AV_PIX_FMT_RGB24, 2 * wide, high, 2};
    write_video(file, video, [&](AVFrame& frame, int) {
        fill_rgb(frame, [&](int x, int y) {
            const double z = x < wide ? depth(0, x, y) : 0;
            if (x >= wide) return std::array{x / 2, 90, 200};
            return std::isnan(z) ? std::array{0, 0, 0} : rgb_of(static_cast<int>(std::lround(512 * z)));
        });
    });
    const std::string bytes = read_bytes(file);
    fs::remove(file);
    write_bytes(file,
                bytes + R"({"intrinsicMatrix":)" + measured_columns + R"(,"rangeOfEncodedDepth":[0,3]})");
    Made film = made(file, depth, measured, 2, 30, true);
    film.lost_codes = 1;  // 1530 of 1536 hues are colours of 8 bits
    return film;
}

Made stray(Writer& w) {
    const std::string depth = w.name("depth/", "a/");
    std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
    for (int n = 0; n < 4; ++n) {
        w.room16(depth + six_digits(n) + ".png", 1000, n);
        w.grey("confidence/" + six_digits(n) + ".png", [](int x, int) { return x % 3; });
        odometry += std::to_string(7300.5 + n / 60.0) + ", " + six_digits(n) + ", 0.0, 0, 0, 0, 0, 0, 1\n";
    }
    write_film(w / w.name("rgb.mp4", "b.mp4"), 4, {60, 1});
    w.text(w.name("odometry.csv", "o.csv"), odometry);
    w.text("imu.csv", "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n7300.5, 0, 9.8, 0, 0, 0, 0\n");
    w.text(w.name("camera_matrix.csv", "k.csv"), "1600.5, 0.0, 957.25\n0.0, 1600.5, 717.75\n0.0, 0.0, 1.0\n");
    return made(w.folder(), room_in(1000),
                {1600.5 / 12, 1600.5 / 12, (957.25 - 959.5) / 12 + 79.5, (717.75 - 719.5) / 12 + 59.5}, 4, 60,
                true);
}

Made polycam(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), images = w.name("images/", "b/");
    for (int n = 0; n < 2; ++n) {
        const std::string stamp = std::to_string(97834526345 + 233467LL * n);
        w.room16("keyframes/" + depth + stamp + ".png", 1000, n);
        w.colour("keyframes/" + images + stamp + ".jpg", 2 * wide, 2 * high);
        w.grey("keyframes/confidence/" + stamp + ".png", [](int, int) { return 255; });
        w.text("keyframes/cameras/" + stamp + ".json",
               R"({"fx": 281, "fy": 281.5, "cx": 159.9, "cy": 120.1, "width": 320, "height": 240,
                   "blur_score": 200.1, "center_depth": 1.1, "neighbors": [], "timestamp": )" +
                   stamp +
                   R"(, "t_00": 1, "t_01": 0, "t_02": 0, "t_03": 0, "t_10": 0, "t_11": 1, "t_12": 0,
                   "t_13": 0, "t_20": 0, "t_21": 0, "t_22": 1, "t_23": 0})");
    }
    w.text("mesh_info.json", R"({"alignmentTransform": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]})");
    return made(w.folder() / "keyframes", room_in(1000),
                {140.5, 140.75, (159.9 - 159.5) / 2 + 79.5, (120.1 - 119.5) / 2 + 59.5}, 2, 30, true);
}

Made nerf(Writer& w) {
    const std::string end = w.name(".depth.png", ".d.png");
    std::string frames;
    for (int n = 0; n < 3; ++n) {
        const std::string image = "images/" + std::to_string(n);
        w.room16(image + end, 6553.5, n);
        w.colour(image + ".png");
        frames += (n ? ", " : "") + std::string(R"({"transform_matrix": [[1,0,0,0], [0,1,0,0], [0,0,1,0],
            [0,0,0,1]], "file_path": ")") +
                  image + R"(", "fl_x": 140.5, "fl_y": 140.7, "cx": 79.9,
            "cy": 60.1, "w": 160, "h": 120, "depth_path": ")" +
                  image + end + "\"}";
    }
    w.text("transforms.json", R"({"fl_x": 140.5, "fl_y": 140.7, "cx": 79.9, "cy": 60.1, "w": 160, "h": 120,
        "integer_depth_scale": 0.00015259021896696422, "frames": [)" +
                                  frames + "]}");
    return made(w.folder(), room_in(6553.5), measured, 3, 30, true);
}

Made nerfstudio(Writer& w) {
    const std::string depth = w.name("depth/", "a/");
    std::string frames;
    for (int n = 0; n < 2; ++n) {
        const std::string name = "frame_0000" + std::to_string(n + 1) + ".png";
        w.room16(depth + name, 1000, n);
        w.colour("images/" + name);
        w.colour("images_2/" + name, wide / 2, high / 2);
        frames += (n ? ", " : "") + std::string(R"({"file_path": "images/)") + name +
                  R"(", "depth_file_path": ")" + depth + name +
                  R"(", "transform_matrix": [[1,0,0,0], [0,1,0,0], [0,0,1,0], [0,0,0,1]]})";
    }
    w.text("transforms.json", R"({"w": 160, "h": 120, "fl_x": 140.5, "fl_y": 140.7, "cx": 79.9, "cy": 60.1,
        "k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0, "camera_model": "OPENCV", "frames": [)" +
                                  frames + "]}");
    return made(w.folder(), room_in(1000), measured, 2, 30, true);
}

Made arkitscenes(Writer& w) {
    for (int n = 0; n < 3; ++n) {
        const std::string stamp = "41048190_3379." + std::to_string(143 + 100 * n);
        w.room16("lowres_depth/" + stamp + ".png", 1000, n);
        w.colour("lowres_wide/" + stamp + ".png");
        w.text("lowres_wide_intrinsics/" + stamp + ".pincam", "160 120 140.5 140.7 79.9 60.1\n");
    }
    w.text("lowres_wide.traj", "3379.143 0.1 0.2 0.3 0 0 0\n");
    return made(w.folder(), room_in(1000), measured, 3, 10, true);
}

// Depth cameras.

Made realsense(Writer& w) {
    std::string codes;
    for (int k = 0; k < wide * high; ++k) put(codes, room_code(1000, 0, k % wide, k / wide));
    w.text("snap_Depth.raw", codes);
    w.text("snap_Depth_metadata.csv",
           "Frame Info: \nType,Depth\nFormat,Z16\nFrame Number,141\nTimestamp (ms),1700000000000.00\n"
           "Resolution x,160\nResolution y,120\nBytes per pixel,2\n\nIntrinsic:,\nFx,140.5\nFy,140.7\n"
           "PPx,79.9\nPPy,60.1\nDistorsion,Brown Conrady\n");
    w.colour("snap_Color.png");
    w.colour("snap_Depth.png");
    return made(w / "snap_Depth.raw", room_in(1000), measured, 1, 30, true);
}

fs::path seed(Writer& w, const std::string& kept, const std::string& own) {
    const fs::path file = w / w.name(own, "a" + fs::path(own).extension().string());
    fs::copy_file(fs::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds" / kept, file);
    return file;
}

Made realsense_bag(Writer& w) {
    return made(
        seed(w, "bag/realsense_lz4.bag", "20230101_120000.bag"),
        [](int n, int x, int y) { return 0.00025 * (500 + 10 * n + 3 * x + 40 * y); }, {20, 21, 7.75, 5.25},
        3, 15, true, 16, 12);
}
Made ros1(Writer& w) {
    return made(
        seed(w, "bag/tum_bz2.bag", "rgbd_dataset_freiburg1_xyz.bag"),
        [](int n, int x, int y) { return 0.001 * (500 + 10 * n + 3 * x + 40 * y); }, {21, 22, 7.75, 5.25}, 4,
        30, true, 16, 12);
}
Made ros2(Writer& w) {
    const fs::path file = w / w.name("rosbag2_2023_01_01-12_00_00_0.mcap", "a.mcap");
    write_bytes(file, mcap_file(ros2_recording(), {.has_chunks = false}));
    return made(
        file,
        [](int n, int x, int y) { return (x + y) % 5 == 0 ? none : 0.001 * (700 + 10 * n + 3 * x + 20 * y); },
        {20, 21, 7.75, 5.25}, 3, 10, true, 16, 12);
}
Made azure_kinect(Writer& w) {
    return made(
        seed(w, "k4a/with_colour.mkv", "output.mkv"), [](int n, int, int) { return 0.9 + 0.05 * n; },
        {250.88, 250.88, 159.5, 165.5}, 2, 30, true, 320, 288);
}

Made kinect2(Writer& w) {
    const fs::path file = w / w.name("depth.npy", "a.npy");
    write_bytes(file, npy_bytes(shape_of_room(), floats_of(millimetres(room), 0)));
    return made(file, room, seen(70.6));
}

int kinect_disparity(int n, int x, int y) {
    const double z = room(n, x, y);
    const bool is_shadow = x > 40 && x < 50 && y > 40 && y < 85;  // beside the box
    return std::isnan(z) || is_shadow ? 2047 : static_cast<int>(std::lround(1092.5 - 351.3 / z));
}
double of_kinect_disparity(int n, int x, int y) {
    return kinect_disparity(n, x, y) == 2047 ? none : 351.3 / (1092.5 - kinect_disparity(n, x, y));
}
constexpr Camera kinect_depth{582.62 / 4, 582.69 / 4, (313.04 - 319.5) / 4 + 79.5,
                              (238.44 - 239.5) / 4 + 59.5};

Made kinect_raw(Writer& w) {
    const std::string depth = w.name("raw_depth_", "a_"), rgb = w.name("rgb_", "b_");
    for (int n = 0; n < 3; ++n) {
        w.png16(depth + six_digits(n) + ".png", [=](int x, int y) { return kinect_disparity(n, x, y); });
        w.colour(rgb + six_digits(n) + ".png");
    }
    return made(w.folder(), of_kinect_disparity, kinect_depth, 3, 30, true);
}
Made nyu(Writer& w) {
    const std::string depth = w.name("d-", "a-"), rgb = w.name("r-", "b-");
    for (int n = 0; n < 3; ++n) {
        std::ostringstream stamp;
        stamp << std::fixed << std::setprecision(6) << 1294886360.208451 + 0.1 * n << '-'
              << 2996770081 + 6000000LL * n;
        write_pgm(w / (depth + stamp.str() + ".pgm"), true,
                  [=](int x, int y) { return static_cast<std::uint16_t>(kinect_disparity(n, x, y)); });
        std::string picture = "P6 160 120 255\n";
        for (int k = 0; k < wide * high; ++k)
            picture += {static_cast<char>(k % 100), 60, static_cast<char>(90)};
        w.text(rgb + stamp.str() + ".ppm", picture);
    }
    w.text("INDEX.txt", "a-1294886359.9-2990000000.dump\n");
    return made(w.folder(), of_kinect_disparity, kinect_depth, 3, 10, true);
}
Made kinect_sdk1(Writer& w) {
    const std::string name = w.name("depth_0001.png", "a.png");
    w.png16(name, [](int x, int y) { return room_code(1000, 0, x, y) << 3 | (x > 60 && x < 90 ? 2 : 0); });
    return made(w / name, room_in(1000), seen(58.5));
}
Made zed(Writer& w) {
    const std::string depth = w.name("depth", "a"), left = w.name("left", "b");
    for (int n = 0; n < 2; ++n) {
        w.room16(depth + six_digits(n) + ".png", 1000, n);
        w.colour(left + six_digits(n) + ".png");
    }
    return made(w.folder(), room_in(1000), seen(60), 2, 30, true);
}
Made oak(Writer& w) {
    const std::string depth = w.name("depth_", "a_"), rgb = w.name("rgb_", "b_");
    for (int n = 0; n < 2; ++n) {
        w.room16(depth + std::to_string(n) + ".png", 1000, n);
        w.colour(rgb + std::to_string(n) + ".png");
    }
    return made(w.folder(), room_in(1000), seen(72), 2, 30, true);
}
Made depthkit(Writer& w) {
    const std::string stem = w.name("Take", "a");
    const auto code = [](int x, int y) {
        const double z = room(0, x, y);
        return std::isnan(z) ? -1 : static_cast<int>(std::lround((z - 0.5) / 2 * 1536));
    };
    const Image picture = made_image(wide, 2 * high, 1, 3, [&](int x, int y, int c) {
        const int hue = y < high ? -1 : code(x, y - high);
        const std::array<int, 3> rgb = y < high  ? std::array{x, 100, 220 - y}
                                       : hue < 0 ? std::array{0, 0, 0}
                                                 : rgb_of(hue);
        return rgb[static_cast<std::size_t>(c)];
    });
    write_quicktime(w / (stem + ".mov"), {picture, picture}, {24, 1});
    w.text(stem + ".Metadata.asset",
           "%YAML 1.1\n--- !u!114 &11400000\nMonoBehaviour:\n  m_Name: Take.Metadata\n  depthkitMetadata:\n"
           "    _versionMajor: 0\n    format: perpixel\n    textureWidth: 160\n    textureHeight: 240\n"
           "    perspectives:\n    - depthImageSize: {x: 160, y: 120}\n"
           "      depthPrincipalPoint: {x: 79.9, y: 60.1}\n      depthFocalLength: {x: 140.5, y: 140.7}\n"
           "      farClip: 2.5\n      nearClip: 0.5\n      crop: {x: 0, y: 0, z: 1, w: 1}\n");
    return made(
        w / (stem + ".mov"),
        [=](int, int x, int y) { return code(x, y) < 0 ? none : 0.5 + 2.0 * code(x, y) / 1536; }, measured, 2,
        24, true);
}

// Renderers and simulators.

/// Linear light.
std::map<std::string, std::vector<float>> colour_channels(const std::string& layer) {
    const std::vector<float> one(wide * high, 0.2F), other(wide * high, 0.6F);
    return {{layer + "R", one}, {layer + "G", other}, {layer + "B", one}, {layer + "A", other}};
}

Made blender(Writer& w) {
    const fs::path file = w / w.name("Image0001.exr", "a.exr");
    auto channels = colour_channels("ViewLayer.Combined.");
    channels["ViewLayer.Depth.Z"] = floats_of(room, 1e10);
    write_exr(file, channels);
    return made(file, room, seen(39.6), 1, 30, true);
}
Made unreal(Writer& w) {
    const Depth centimetres = [](int n, int x, int y) { return 100 * room(n, x, y); };
    const fs::path file = w / w.name("Shot.0001.exr", "a.exr");
    auto channels = colour_channels("");
    const std::string layer = "FinalImageMovieRenderQueue_WorldDepth.";
    for (const char* own : {"R", "G", "B"}) channels[layer + own] = floats_of(centimetres, 65504);
    channels[layer + "A"] = std::vector<float>(wide * high, 0);
    write_exr(file, channels);
    return made(file, room, seen(90), 1, 30, true);
}
Made carla(Writer& w) {
    const std::string depth = w.name("depth/", "a/"), rgb = w.name("rgb/", "b/");
    const auto code = [](int n, int x, int y) {
        return std::lround((std::isnan(room(n, x, y)) ? 1 : 0.008 * room(n, x, y)) * 0xffffff);
    };
    for (int n = 0; n < 2; ++n) {
        const std::string name = "0001234" + std::to_string(5 + n) + ".png";
        write_bytes(w / (depth + name), rgba_png(wide, high, [&](int x, int y, int k) {
                        return k == 3 ? 255 : code(n, x, y) >> 8 * k & 255;
                    }));
        w.colour(rgb + name);
    }
    return made(
        w.folder(),
        [=](int n, int x, int y) {
            return std::isnan(room(n, x, y)) ? none : 1000.0 * static_cast<double>(code(n, x, y)) / 0xffffff;
        },
        seen(90), 2, 30, true);
}
Made unity(Writer& w) {
    const fs::path file = w / w.name("depth.png", "a.png");
    // EncodeFloatRGBA, rounded to bytes; 1 is the far plane, where nothing is.
    write_bytes(
        file, rgba_png(wide, high, [](int x, int y, int k) -> int {
            if (std::isnan(room(0, x, y)) || k == 3) return 255;
            const double share = room(0, x, y) / 10,
                         next = k < 2 ? std::fmod(share * std::pow(255, k + 1), 1) / 255 : 0;
            return static_cast<int>(std::lround(255 * (std::fmod(share * std::pow(255, k), 1) - next)));
        }));
    return made(file, room, seen(60));
}
Made airsim(Writer& w) {
    const fs::path file = w / w.name("depth.npy", "a.npy");
    write_bytes(file, npy_bytes(shape_of_room(), floats_of(room, 65504)));
    return made(file, room, seen(90));
}
Made isaac(Writer& w) {
    constexpr double f = 24 / 20.955 * wide;
    const Camera camera{f, f, 79.5, 59.5};
    for (int n = 0; n < 2; ++n) {
        const std::string end = "_000" + std::to_string(n);
        w.text("distance_to_image_plane" + end + ".npy",
               npy_bytes(shape_of_room(), floats_of(room, INFINITY, n)));
        w.colour("rgb" + end + ".png");
        w.text("camera_params" + end + ".json",
               R"({"cameraAperture": [20.955, 15.71625], "cameraApertureOffset": [0.0, 0.0],
                   "cameraFisheyeMaxFOV": 0.0, "cameraFocalLength": 24.0, "cameraFocusDistance": 400.0,
                   "cameraModel": "pinhole", "cameraNearFar": [1.0, 1000000.0],
                   "cameraProjection": [2.29, 0, 0, 0, 0, 3.05, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0],
                   "cameraViewTransform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1],
                   "metersPerSceneUnit": 1.0, "renderProductResolution": [160, 120]})");
    }
    return made(w.folder(), room, camera, 2, 30, true);
}

}  // namespace

const std::map<std::string, SourceMaker>& source_makers() {
    static const auto makers = [] {
        std::map<std::string, SourceMaker> all{{"iphone", iphone},
                                               {"iphone-jpeg", iphone_jpeg},
                                               {"cinematic", cinematic},
                                               {"iphone-tiff", iphone_tiff},
                                               {"dynamic-depth", dynamic_depth},
                                               {"gdepth", gdepth},
                                               {"depth16", depth16},
                                               {"record3d", record3d},
                                               {"record3d-video", record3d_video},
                                               {"stray", stray},
                                               {"polycam", polycam},
                                               {"nerf", nerf},
                                               {"nerfstudio", nerfstudio},
                                               {"arkitscenes", arkitscenes},
                                               {"realsense", realsense},
                                               {"realsense-bag", realsense_bag},
                                               {"ros1", ros1},
                                               {"ros2", ros2},
                                               {"azure-kinect", azure_kinect},
                                               {"kinect2", kinect2},
                                               {"kinect-raw", kinect_raw},
                                               {"kinect-sdk1", kinect_sdk1},
                                               {"zed", zed},
                                               {"oak", oak},
                                               {"depthkit", depthkit},
                                               {"blender", blender},
                                               {"unreal", unreal},
                                               {"carla", carla},
                                               {"airsim", airsim},
                                               {"unity", unity},
                                               {"isaac", isaac},
                                               {"nyu", nyu}};
        all.merge(data_set_makers());
        return all;
    }();
    return makers;
}

}  // namespace touchable::test
