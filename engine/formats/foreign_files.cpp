#include "engine/formats/foreign_files.hpp"
#include "engine/picture/image.hpp"

#include <algorithm>
#include <array>
#include <charconv>
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

/// The first bytes of a file and its name.
struct Look {
    const fs::path& path;
    std::string_view begin;

    std::string extension() const { return small_letters(path.extension().string()); }
    std::string name() const { return small_letters(path.filename().string()); }
    std::string shell_name() const { return shell_word(path.string()); }
    /// In quotes for a command in Python; only right for a name without quotes.
    std::string python_name() const { return "'" + printable(path.filename().string()) + "'"; }
};

std::string after_play(const std::string& what) {
    return ", then: touchable play " + what;
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

/// How to open a Zarr store; `name`: for Python.
std::string zarr_words(const std::string& name) {
    return ": numpy.save('depth.npy', zarr.open(" + name +
           ")['NAME'][:]) in Python makes an array of one of its depths" + after_play("depth.npy");
}

std::optional<std::string> zip_file(const Look& look) {
    if (!look.begin.starts_with(zip_magic) || look.extension() == ".npz" || look.extension() == ".usdz")
        return {};
    const std::string_view member = first_member(look.begin);
    if (member.ends_with(".npy")) return {};
    if (look.name().ends_with(".zarr.zip"))
        return "is a Zarr store in a ZIP file" + zarr_words(look.python_name());
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
    return "is a MATLAB file: numpy.save('depth.npy', scipy.io.loadmat(" + look.python_name() +
           ")['NAME']) in Python makes an array of its variable of depth" + after_play("depth.npy");
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
    return "is a depth map of COLMAP (" + size + "): numpy.save('depth.npy', read_array(" +
           look.python_name() +
           ")) in Python, with read_array of COLMAP's scripts/python/read_write_dense.py, makes an array of "
           "it" +
           after_play("depth.npy");
}

std::optional<std::string> colmap_model(const Look& look) {
    constexpr std::string_view names[] = {"cameras.bin", "images.bin", "points3d.bin", "frames.bin",
                                          "rigs.bin"};
    if (std::ranges::count(names, look.name()) == 0) return {};
    return std::string(
        "is a sparse model of COLMAP, which has no pictures of depth: colmap "
        "patch_match_stereo makes them (stereo/depth_maps)");
}

std::optional<std::string> ply(const Look& look) {
    if (!look.begin.starts_with("ply\n") && !look.begin.starts_with("ply\r\n")) return {};
    const std::uint64_t points = whole_number(line_after(look.begin, "element vertex ").value_or("")),
                        faces = whole_number(line_after(look.begin, "element face ").value_or(""));
    const std::string what = faces > 0 ? "mesh of " + std::to_string(faces) + " faces"
                                       : "cloud of " + std::to_string(points) + " points";
    const std::string way = faces > 0
                                ? "cast a ray for each pixel of a camera (t.geometry.RaycastingScene of "
                                  "Open3D) and save t_hit by numpy.save"
                                : "project it into a camera (t.geometry.PointCloud.project_to_depth_image of "
                                  "Open3D) and save that picture";
    return "is a PLY " + what + ", which has no rows and columns of pixels: " + way + after_play("depth.npy");
}

std::optional<std::string> pcd(const Look& look) {
    if (!look.begin.starts_with("# .PCD") && !look.begin.starts_with("VERSION ")) return {};
    const std::uint64_t width = whole_number(line_after(look.begin, "WIDTH ").value_or("")),
                        height = whole_number(line_after(look.begin, "HEIGHT ").value_or(""));
    if (width == 0 || line_after(look.begin, "FIELDS ").value_or("").empty()) return {};
    if (height > 1)
        return "is a PCD cloud of " + size_text(width, height) +
               " points, whose own message tells more: touchable play " + look.shell_name();
    return "is a PCD cloud of " + std::to_string(width) +
           " points, which has no rows and columns of pixels: project it into a camera "
           "(t.geometry.PointCloud.project_to_depth_image of Open3D) and save that picture" +
           after_play("depth.npy");
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

using Recognise = std::optional<std::string> (*)(const Look&);
/// Tried in this order.
constexpr Recognise known_kinds[] = {git_lfs, svo,        zip_file,     packed, sens, oni,           matlab,
                                     hdf5,    colmap_map, colmap_model, ply,    pcd,  other_geometry};
constexpr Recognise misleading_kinds[] = {git_lfs, svo, zip_file, other_geometry};

std::optional<std::string> first_said(std::span<const Recognise> kinds, const SourceFile& file,
                                      std::size_t bytes) {
    const std::string begin = first_bytes(file, bytes);
    const Look look{file.path(), begin};
    for (const Recognise kind : kinds)
        if (auto said = kind(look)) return said;
    return {};
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
    const bool may_be = begin.starts_with("version https:") || svo({file.path(), begin}) ||
                        (begin.starts_with(zip_magic) && is_whole_zip(file));
    return may_be ? first_said(misleading_kinds, file, telling_bytes) : std::nullopt;
}

std::optional<std::string> foreign_folder(const fs::path& folder) {
    if (!is_there(folder / ".zgroup") && !is_there(folder / ".zarray") && !is_there(folder / "zarr.json"))
        return {};
    return "is a Zarr store" + zarr_words("'" + printable(folder.filename().string()) + "'");
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
