// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/formats_read.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "engine/base/threads.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/sidecar_text.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view zip_magic = "PK\x03\x04";
/// Enough for the user block of a MATLAB 7.3 file, and for the header of most clouds.
constexpr std::size_t telling_bytes = 4096;

/// A text in quotes as Python reads it.
std::string python_text(std::string_view text) {
    std::string quoted = "'";
    for (const char c : text) quoted += (c == '\'' || c == '\\' ? "\\" : "") + std::string(1, c);
    return one_line(quoted + "'");
}

/// The first bytes of a file and its name.
struct Look {
    const fs::path& path;
    std::string_view begin;

    std::string extension() const { return small_letters(path.extension().string()); }
    std::string name() const { return small_letters(path.filename().string()); }
    std::string shell_name() const { return shell_word(path.string()); }
    std::string python_name() const { return python_text(path.string()); }
    bool is_named(std::initializer_list<std::string_view> extensions) const {
        return std::ranges::count(extensions, extension()) > 0;
    }
};

std::string after_play(const std::string& what) {
    return ", then: touchable play " + what;
}

/// How Python saves what it reads of a file (`before` and `after` the file's name) as an array beside it,
/// under its name, which may tell the unit and colour.
std::string saved(const fs::path& file, const std::string& before, const std::string& after) {
    const std::string array = fs::path(file).replace_extension(".npy").string();
    return ": numpy.save(" + python_text(array) + ", " + before + python_text(file.string()) + after +
           ") in Python makes an array of it" + after_play(shell_word(array));
}

std::uint64_t whole_number(std::string_view text) {
    std::uint64_t number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

// --- What each is

std::optional<std::string> git_lfs(const Look& look) {
    if (!is_git_lfs_pointer(look.begin)) return {};
    return std::string(git_lfs_words);
}

std::optional<std::string> svo(const Look& look) {
    if (look.extension() != ".svo" && look.extension() != ".svo2") return {};
    return "is a recording of a ZED camera, which only Stereolabs' SDK reads: its sample svo_export.py "
           "exports pictures (--mode 4, --input_svo_file " +
           look.shell_name() + ", --output_path_dir FOLDER)" + after_play("FOLDER");
}

/// The name of the first member of a ZIP file.
std::string_view first_member(std::string_view begin) {
    constexpr std::size_t head = 30, place_of_length = 26;
    if (begin.size() < head) return {};
    const auto low = static_cast<unsigned char>(begin[place_of_length]),
               high = static_cast<unsigned char>(begin[place_of_length + 1]);
    return begin.substr(head, std::size_t{low} + 256 * std::size_t{high});
}

constexpr const char* array_of_zarr = ")['NAME'][:]";

std::string torch_words(const Look& look) {
    return "is a file of PyTorch (of a dict, add ['NAME'] after torch.load(...))" +
           saved(look.path, "torch.load(", ", map_location='cpu').numpy()");
}

/// Record3D's recording, a ZIP file, or a picture of depth in it, unzipped; both are packed by LZFSE.
std::optional<std::string> record3d(const Look& look) {
    const bool is_picture = look.is_named({".depth"}) && look.begin.starts_with("bvx");
    if (!is_picture && !look.is_named({".r3d"})) return {};
    const std::string app =
        " of Record3D in its own format, which its app exports as EXR + RGB, a folder that opens, and "
        "pyliblzfse reads";
    const fs::path folder = look.path.parent_path().parent_path();
    const std::string arrays =
        (is_picture ? folder / "depth.npz" : fs::path(look.path).replace_extension(".npz")).string();
    return (is_picture ? "is a picture" : "is a recording") + app +
           (is_picture ? ": z = pathlib.Path(" + python_text((folder / "").string())
                       : ": z = zipfile.Path(" + look.python_name()) +
           "); m = json.loads((z / 'metadata').read_text()); numpy.savez(" + python_text(arrays) +
           ", depth=[numpy.frombuffer(liblzfse.decompress((z / f'rgbd/{n}.depth').read_bytes()), "
           "'f4').reshape(m['dh'], m['dw']) for n in range(sum(i.name.endswith('.depth') for i in (z / "
           "'rgbd').iterdir()))], intrinsics=numpy.reshape(m['K'], (3, 3)).T * [[m['dw'] / m['w']], [m['dh'] "
           "/ "
           "m['h']], [1]]) in Python makes arrays of it" +
           after_play(shell_word(arrays));
}

std::optional<std::string> zip_file(const Look& look) {
    if (!look.begin.starts_with(zip_magic) || look.extension() == ".npz" || look.extension() == ".usdz")
        return {};
    const std::string_view member = first_member(look.begin);
    if (member.ends_with(".npy")) return {};
    if (member.ends_with("/data.pkl")) return torch_words(look);
    if (look.name().ends_with(".zarr.zip"))
        return "is a Zarr store in a ZIP file" + saved(look.path, "zarr.open(", array_of_zarr);
    const std::string stem = look.path.stem().string();
    return "is a ZIP file, whose first member is " + in_quotes(member) + ": unzip " + look.shell_name() +
           " -d " + shell_word(stem) + after_play(shell_word(stem));
}

/// Whether a ZIP file has its end; one that is cut is damaged, whatever else it is.
bool is_whole_zip(const SourceFile& file) {
    constexpr std::size_t end_of_zip = 22;
    const auto bytes = bytes_of_file(file);
    char end[end_of_zip] = {};
    return bytes && (*bytes)->size() >= end_of_zip &&
           (*bytes)->read((*bytes)->size() - end_of_zip, end, end_of_zip) &&
           std::string_view(end, 4) == "PK\x05\x06";
}

std::optional<std::string> packed(const Look& look) {
    constexpr std::pair<std::string_view, const char*> kinds[] = {
        {"\x1f\x8b", "gzip"},    {"BZh", "bzip2"},
        {"\xfd\x37zXZ", "xz"},   {"7z\xbc\xaf\x27\x1c", "7-Zip"},
        {"Rar!\x1a\x07", "RAR"}, {"\x28\xb5\x2f\xfd", "zstd"}};
    for (const auto& [magic, name] : kinds)
        if (look.begin.starts_with(magic))
            return std::string("is packed by ") + name + ": unpack it, then open what was in it";
    constexpr std::size_t place_of_ustar = 257;
    if (look.begin.size() > place_of_ustar && look.begin.substr(place_of_ustar).starts_with("ustar"))
        return "is a tar archive: tar xf " + look.shell_name() + ", then open the folder that was in it";
    return {};
}

std::optional<std::string> sens(const Look& look) {
    if (look.extension() != ".sens") return {};
    return "is a recording of ScanNet, whose SensReader exports pictures: python reader.py --filename " +
           look.shell_name() +
           " --output_path FOLDER --export_depth_images --export_color_images --export_intrinsics" +
           after_play("FOLDER");
}

std::optional<std::string> oni(const Look& look) {
    if (!look.begin.starts_with("NI10") && look.extension() != ".oni") return {};
    return "is a recording of OpenNI: OpenCV built with OpenNI2 reads it (cv2.VideoCapture(" +
           look.python_name() +
           ", cv2.CAP_OPENNI2), retrieve with cv2.CAP_OPENNI_DEPTH_MAP); write each frame as a PNG of 16 "
           "bits" +
           after_play("FOLDER");
}

std::optional<std::string> matlab(const Look& look) {
    if (!look.begin.starts_with("MATLAB ") || picture_kind(look.begin) == "HDF5") return {};
    return "is a MATLAB file" + saved(look.path, "scipy.io.loadmat(", ")['NAME']");
}

/// A file that begins as HDF5 can be opened; others have a block of another program before it.
std::optional<std::string> hdf5(const Look& look) {
    if (picture_kind(look.begin) == "HDF5") return "is an HDF5 file: touchable play " + look.shell_name();
    constexpr std::string_view magic("\x89HDF\r\n\x1a\n");
    constexpr std::size_t places[] = {512, 1024, 2048};
    if (std::ranges::none_of(places, [&](std::size_t at) {
            return at < look.begin.size() && look.begin.substr(at).starts_with(magic);
        }))
        return {};
    return "is an HDF5 file behind a user block: h5unjam -i " + look.shell_name() +
           " -o depth.h5 makes one without it" + after_play("depth.h5");
}

/// "160&120&1&" and floats: COLMAP's dense maps.
std::optional<std::string> colmap_map(const Look& look) {
    std::array<std::uint64_t, 3> sizes{};
    std::string_view rest = look.begin;
    for (std::uint64_t& size : sizes) {
        const std::size_t end = rest.substr(0, 8).find('&');
        if (end == std::string_view::npos || end == 0) return {};
        const std::string_view digits = rest.substr(0, end);
        if (!is_digits(digits)) return {};
        size = whole_number(digits);
        rest.remove_prefix(end + 1);
    }
    const std::string size = size_text(sizes[0], sizes[1]);
    if (sizes[2] != 1) return "is a map of normals of COLMAP (" + size + "): its depth is in depth_maps";
    return "is a depth map of COLMAP (" + size +
           "), which read_array of its scripts/python/read_write_dense.py reads" +
           saved(look.path, "read_array(", ")");
}

std::optional<std::string> colmap_model(const Look& look) {
    constexpr std::string_view names[] = {"cameras.bin", "images.bin", "points3d.bin", "frames.bin",
                                          "rigs.bin"};
    if (std::ranges::count(names, look.name()) == 0) return {};
    return std::string(
        "is a sparse model of COLMAP, which has no pictures of depth: colmap "
        "patch_match_stereo makes them (stereo/depth_maps)");
}

/// A cloud of points without a grid, or a mesh.
std::string cloud_words(const std::string& kind, std::uint64_t points, std::uint64_t faces = 0) {
    return "is a " + kind + (faces > 0 ? " mesh of " : " cloud of ") +
           std::to_string(faces > 0 ? faces : points) + (faces > 0 ? " faces" : " points") +
           ", which has no rows and columns of pixels: " +
           (faces > 0
                ? "cast a ray for each pixel of a camera (t.geometry.RaycastingScene of Open3D) and save "
                  "t_hit by numpy.save"
                : "project it into a camera (t.geometry.PointCloud.project_to_depth_image of Open3D) and "
                  "save that picture") +
           after_play("depth.npy");
}

std::optional<std::string> ply(const Look& look) {
    if (!look.begin.starts_with("ply\n") && !look.begin.starts_with("ply\r\n")) return {};
    return cloud_words("PLY", whole_number(line_after(look.begin, "element vertex ").value_or("")),
                       whole_number(line_after(look.begin, "element face ").value_or("")));
}

std::optional<std::string> pcd(const Look& look) {
    if (!look.begin.starts_with("# .PCD") && !look.begin.starts_with("VERSION ")) return {};
    const std::uint64_t width = whole_number(line_after(look.begin, "WIDTH ").value_or("")),
                        height = whole_number(line_after(look.begin, "HEIGHT ").value_or(""));
    if (width == 0 || line_after(look.begin, "FIELDS ").value_or("").empty()) return {};
    if (height > 1)
        return "is a PCD cloud of " + size_text(width, height) +
               " points, whose own message tells more: touchable play " + look.shell_name();
    return cloud_words("PCD", width);
}

/// Points and surfaces without pictures, by their first bytes or their name.
std::optional<std::string> other_geometry(const Look& look) {
    const std::string extension = look.extension();
    const char* const what = look.begin.starts_with("LASF")          ? "a cloud of points (LAS)"
                             : look.begin.starts_with("ASTM-E57")    ? "scans (E57)"
                             : extension == ".obj"                   ? "a mesh (OBJ)"
                             : extension == ".stl"                   ? "a mesh (STL)"
                             : extension == ".xyz"                   ? "a cloud of points (XYZ)"
                             : extension == ".usdz"                  ? "a model (USDZ)"
                             : look.begin.starts_with("Kaydara FBX") ? "a model (FBX)"
                                                                     : nullptr;
    if (what == nullptr) return {};
    return std::string("is ") + what +
           ", which has no rows and columns of pixels: render it as a picture of depth (OpenEXR by Blender, "
           "Open3D)" +
           after_play("depth.exr");
}

/// Kinds that a library of Python makes an array or a picture of.
std::optional<std::string> of_python(const Look& look) {
    const std::string_view begin = look.begin;
    const auto has_at = [&](std::size_t place, std::string_view magic) {
        return begin.size() >= place && begin.substr(place).starts_with(magic);
    };
    if (has_at(344, "n+1") || look.name().ends_with(".nii.gz"))
        return "is NIfTI" + saved(look.path, "nibabel.load(", ").get_fdata().squeeze().T");
    const bool is_pickle = begin.size() > 2 && begin[0] == '\x80' && begin[1] >= 2 && begin[1] <= 5;
    if (is_pickle && look.is_named({".pt", ".pth"})) return torch_words(look);
    if (is_pickle || look.is_named({".pickle", ".pkl"}))
        return "is a pickle of Python, which can run code (open only what you trust; of a flat array, add "
               ".reshape(HEIGHT, WIDTH) after numpy.load(...))" +
               saved(look.path, "numpy.load(", ", allow_pickle=True)");
    if (has_at(0, "#?RADIANCE") || has_at(0, "#?RGBE"))
        return "is Radiance HDR" + saved(look.path, "cv2.imread(", ", -1)[..., 0]");
    const char* const picture = has_at(0, "RIFF") && has_at(8, "WEBP")                   ? "WebP"
                                : has_at(4, "jP  \r\n") || has_at(0, "\xff\x4f\xff\x51") ? "JPEG 2000"
                                : has_at(0, "BM") && look.is_named({".bmp", ".dib"})     ? "BMP"
                                : look.is_named({".tga"})                                ? "TGA"
                                                                                         : nullptr;
    if (picture == nullptr) return {};
    const std::string png = fs::path(look.path).replace_extension(".png").string();
    return std::string("is ") + picture + ": PIL.Image.open(" + look.python_name() + ").save(" +
           python_text(png) + ") in Python makes a PNG of it" + after_play(shell_word(png));
}

/// Numbers without a header: by their bytes floats, otherwise perhaps of 16 bits; of the largest usual size
/// that they are whole pictures of.
std::optional<std::string> raw_numbers(const Look& look) {
    constexpr std::pair<std::uint64_t, std::uint64_t> usual[] = {
        {1920, 1080}, {1280, 720}, {848, 480}, {640, 576}, {640, 480}, {640, 360}, {512, 424},
        {424, 240},   {320, 288},  {320, 240}, {256, 192}, {224, 172}, {160, 120}};
    if (look.begin.size() < 64 ||
        !look.is_named({".bin", ".raw", ".dat", ".data", ".depth", ".float", ".f32", ".u16", ".z16"}) ||
        std::ranges::none_of(look.begin, [](signed char c) { return c < '\t'; }))
        return {};
    const auto are = [&]<class Number>(Number number) {
        bool are_all = look.begin.size() >= sizeof number;
        for (std::size_t at = 0; at + sizeof number <= look.begin.size() && are_all; at += sizeof number) {
            std::memcpy(&number, look.begin.data() + at, sizeof number);
            are_all = !(std::abs(number) > 1e6) && (number == 0 || !(std::abs(number) < 1e-6));
        }
        return are_all;
    };
    const int each = are(0.0F) ? 4 : are(0.0) ? 8 : 2;
    std::error_code failure;
    const std::uint64_t bytes = fs::file_size(look.path, failure);
    const std::string type = (each > 2 ? "f" : "u") + std::to_string(each);
    std::string what = (each > 2 ? "floats of " : "of ") + std::to_string(8 * each) + " bits",
                shape = "HEIGHT, WIDTH";
    const auto* const size = std::ranges::find_if(usual, [&](const auto& one) {
        return bytes % (static_cast<std::uint64_t>(each) * one.first * one.second) == 0;
    });
    if (size != std::end(usual)) {
        what += ", " + size_text(size->first, size->second);
        shape = std::to_string(size->second) + ", " + std::to_string(size->first);
    }
    return "is raw numbers without a header, " + std::to_string(bytes) + " bytes (perhaps " + what + ")" +
           saved(look.path, "numpy.fromfile(", ", '" + type + "').reshape(-1, " + shape + ").squeeze()");
}

/// Depth as text: rows of at least 32 numbers, perhaps below a heading.
std::optional<std::string> table(const Look& look) {
    constexpr int most_headings = 8;
    constexpr std::size_t fewest = 32;
    std::string_view rest = look.begin;
    for (int headings = 0; headings < most_headings && !rest.empty(); ++headings) {
        const bool is_whole = rest.find('\n') != std::string_view::npos;
        std::string_view line = trimmed(cut_line(rest));
        const auto mark = line.find_first_of(",;");
        const std::string between = mark == std::string_view::npos ? " \t" : std::string(1, line[mark]);
        const bool ends_in_mark = is_whole && line.ends_with(between);
        std::size_t numbers = 0;
        bool are_numbers = true;
        while (!line.empty() && are_numbers) {
            const std::string_view word = line.substr(0, line.find_first_of(between));
            line.remove_prefix(std::min(line.size(), word.size() + 1));
            if (trimmed(word).empty()) continue;
            are_numbers = parsed_real(trimmed(word)).has_value() || (!is_whole && line.empty());
            ++numbers;
        }
        if (!are_numbers || numbers < fewest) continue;
        std::string how;
        if (between.size() == 1) how += ", delimiter='" + between + "'";
        if (headings > 0) how += ", skip_header=" + std::to_string(headings);
        return (look.begin.starts_with("ncols")
                    ? "is a grid of heights (ESRI; what is high is near, if the array is named as one: dem)"
                    : "is text, a row of numbers a line") +
               saved(look.path, "numpy.genfromtxt(", how + (ends_in_mark ? ")[:, :-1]" : ")"));
    }
    return {};
}

using Recognise = std::optional<std::string> (*)(const Look&);
/// Tried in this order.
constexpr Recognise known_kinds[] = {git_lfs, svo, record3d,       zip_file, of_python,  packed,
                                     sens,    oni, matlab,         hdf5,     colmap_map, colmap_model,
                                     ply,     pcd, other_geometry, table,    raw_numbers};
constexpr Recognise misleading_kinds[] = {git_lfs, svo, record3d, zip_file, other_geometry};

std::optional<std::string> first_said(std::span<const Recognise> kinds, const SourceFile& file,
                                      std::size_t bytes) {
    const std::string begin = first_bytes(file, bytes);
    const Look look{file.path(), begin};
    for (const Recognise kind : kinds)
        if (auto said = kind(look)) return said;
    return {};
}

/// Whether the names of a file and its folders say that it is a panorama: by a word, or by 360, which at the
/// end of a file's may be a frame's number.
bool names_panorama(const std::string& name) {
    const std::size_t at = std::min(name.find("360"), name.size()), end = at + 3;
    return (end < name.size() && name[end] != 'p' && !is_digit(name[end]) &&
            (at == 0 || !is_digit(name[at - 1]))) ||
           has_beginning(name, {"erp ", "pano ", "panos ", "panoram", "equirect", "spheric", "latlon"});
}

/// Whether depth is as of a whole sphere: the points above and below are a row each, the sides meet, and
/// between them the camera sees farther. Where a pinhole sees a floor, rows differ more.
bool is_of_sphere(const StoredImage& depth) {
    const int width = depth.image.width, last = depth.image.height - 1, inner = last / 16;
    const auto at = [&](int x, int y) {
        const auto k = pixel_count(width, y) + static_cast<std::size_t>(x);
        return depth.values.empty() ? sample_at(depth.image, k) : double{depth.values[k]};
    };
    const auto alike = [](double a, double b, double share) { return a > 0 && std::abs(a - b) <= share * a; };
    const double up = at(0, 0), down = at(0, last);
    if (inner == 0 || !alike(up, at(0, inner), 0.05) || !alike(down, at(0, last - inner), 0.05)) return false;
    int meeting = 0, even = 0;
    double farthest = 0;
    for (int y = 0; y <= last; ++y) meeting += alike(at(0, y), at(width - 1, y), 0.02) ? 1 : 0;
    for (int x = 0; x < width; ++x) {
        even += alike(up, at(x, 0), 0.01) && alike(down, at(x, last), 0.01) ? 1 : 0;
        farthest = std::max(farthest, at(x, last / 2));
    }
    return 20 * meeting > 19 * last && even == width && farthest > 1.1 * std::max(up, down);
}

bool is_there(const fs::path& file) {
    std::error_code ignored;
    return fs::exists(file, ignored);
}

}  // namespace

std::optional<std::string> foreign_file(const SourceFile& file) {
    return first_said(known_kinds, file, telling_bytes);
}

std::optional<std::string> misleading_file(const SourceFile& file, std::string_view begin) {
    const Look look{file.path(), begin};
    const bool may_be = begin.starts_with("version https:") || svo(look) || record3d(look) ||
                        (begin.starts_with(zip_magic) && is_whole_zip(file));
    return may_be ? first_said(misleading_kinds, file, telling_bytes) : std::nullopt;
}

std::optional<std::string> foreign_folder(const fs::path& folder) {
    if (!is_there(folder / ".zgroup") && !is_there(folder / ".zarray") && !is_there(folder / "zarr.json"))
        return {};
    const bool is_array =
        is_there(folder / ".zarray") ||
        first_bytes(SourceFile(folder / "zarr.json"), telling_bytes).find("\"array\"") != std::string::npos;
    return "is a Zarr store" + saved(folder, "zarr.open(", is_array ? ")[:]" : array_of_zarr);
}

std::optional<Projection> projection_of(const StoredImage& picture, const fs::path& depth,
                                        const fs::path& colour, bool has_xmp, bool has_camera) {
    std::error_code ignored;
    const fs::path file = fs::weakly_canonical(depth, ignored), folder = file.parent_path();
    const std::string name = (folder.parent_path().filename() / folder.filename() / file.stem()).string();
    const int width = picture.image.width, height = picture.image.height, face = std::gcd(width, height);
    const bool is_strip = std::max(width, height) == 6 * face, is_wide = std::abs(width - 2 * height) <= 1,
               is_named = is_wide && names_panorama(name),
               is_sphere = is_wide && !is_named && !has_xmp && is_of_sphere(picture);
    Projection found{.evidence = has_xmp ? "as its XMP says" : is_sphere ? "" : "as its name says"};
    std::string before, after;
    if (has_xmp || is_named || is_sphere) {
        const std::string side = std::to_string(width / 3);  // about as many pixels an angle
        found.name = "an equirectangular panorama";
        found.hints = {{Setting::field_of_view, "90"}, {Setting::depth_kind, "range"}};
        before = "py360convert.e2p(";
        after = ", 90, 0, 0, (" + side + ", " + side + "), mode='nearest')";
    } else if (width != height && width / face * (height / face) <= 12 &&
               has_beginning(name, {"cubemap", "skybox", is_strip ? "cube " : "cubemap"})) {
        const int top = height / face / 3 * face;  // of a cross, the row of four
        found.name = "a cube map";
        found.hints = {{Setting::field_of_view, "90"}};
        after =
            '[' + std::to_string(top) + ':' + std::to_string(top + face) + ", :" + std::to_string(face) + ']';
    } else if (!has_camera &&
               has_beginning(name, {"fisheye", "omnidir", width > 3 * height ? "cylind" : "omnidir"})) {
        found.name = "a fisheye's or a cylinder's picture";
        found.hints = {{Setting::intrinsics, "FX,FY,CX,CY"}};
        before = "cv2.remap(";
        after = ", *MAPS, cv2.INTER_NEAREST)";
        found.way = "with MAPS of its calibration (a fisheye's: cv2.fisheye.initUndistortRectifyMap) ";
    } else {
        return {};
    }
    const auto view = [&](const fs::path& of) {
        const std::string text = python_text(of.string()), extension = of.extension().string();
        return before +
               (extension == ".npy"   ? "numpy.load(" + text + ")"
                : extension == ".npz" ? "numpy.load(" + text + ")['NAME']"
                : extension == ".exr" ? "OpenEXR.File(" + text + ").channels()['NAME'].pixels"
                                      : "cv2.imread(" + text + ", -1)") +
               after + ')';
    };
    found.way += "numpy.save('view.npy', " + view(depth) +
                 (colour.empty() || colour == depth ? "" : " and cv2.imwrite('view.png', " + view(colour)) +
                 " in Python make a view of it" + after_play("view.npy");
    return found;
}

std::optional<std::string> foreign_file_below(const fs::path& folder) {
    constexpr int deepest = 3;
    constexpr std::size_t most_entries = 10'000, most_opened = 64;
    std::set<fs::path> files;
    std::size_t entries = 0;
    std::error_code failure;
    for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, failure),
         end;
         !failure && at != end && ++entries < most_entries && !stop_requested(); at.increment(failure)) {
        std::error_code ignored;
        if (at.depth() >= deepest) at.disable_recursion_pending();
        const bool is_folder = at->is_directory(ignored);
        if (is_folder ? foreign_folder(at->path()).has_value() : at->is_regular_file(ignored)) {
            files.insert(at->path());
            if (files.size() > most_opened) files.erase(std::prev(files.end()));
        }
    }
    for (const fs::path& file : files)
        if (const auto what =
                fs::is_directory(file, failure) ? foreign_folder(file) : foreign_file(SourceFile(file)))
            return printable(file.lexically_relative(folder).string()) + ' ' + *what;
    return {};
}

}  // namespace touchable
