#include "engine/formats/camera_beside.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <system_error>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/formats/camera_file.hpp"
#include "engine/formats/picture_groups.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

struct CameraCandidate {
    fs::path file;
    bool is_named = false;  // as a camera's file is
};

std::string lower_case(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

/// What programs call a camera's file. Poses are none.
bool is_named_camera(const std::string& name, const std::string& stem) {
    if (has_word(name, {"extrinsic", "pose", "trajector", "groundtruth"})) return false;
    const bool is_numbered_cam =
        stem.starts_with("cam") && stem.find_first_not_of("0123456789", 3) == std::string::npos;
    return has_word(name, {"camera", "intrinsic", "calib", "camchain"}) || stem == "k" || is_numbered_cam ||
           name == "metadata.json";
}

bool is_one_of(const std::string& extension, std::initializer_list<const char*> known) {
    return std::find(known.begin(), known.end(), extension) != known.end();
}

/// Files of a folder that may be a camera's, named ones first.
std::vector<CameraCandidate> candidates_in(const fs::path& folder, const PicturesOfCamera& pictures) {
    constexpr std::size_t most_named = 100, most_others = 16;  // more are of something else
    constexpr std::uintmax_t longest_other = 1 << 20;
    std::vector<CameraCandidate> named, others;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        const std::string name = lower_case(entry.path().filename().string()),
                          stem = lower_case(entry.path().stem().string()),
                          extension = lower_case(entry.path().extension().string());
        std::error_code failure;
        if (name.starts_with('.') || !entry.is_regular_file(failure)) continue;
        const bool has_members = is_one_of(extension, {".json", ".yaml", ".yml", ".xml"});
        if (is_named_camera(name, stem)) {
            if (has_members || is_one_of(extension, {"", ".txt", ".ini", ".toml", ".cfg", ".conf", ".cal",
                                                     ".bin", ".mat", ".csv", ".pincam"}))
                if (named.size() < most_named) named.push_back({entry.path(), true});
        } else if (has_members && others.size() <= most_others && name != "scene.json" &&
                   (pictures.is_whole_folder || (!stem.empty() && stem == lower_case(pictures.stem)))) {
            if (entry.file_size(failure) <= longest_other && !failure) others.push_back({entry.path()});
        }
    }
    if (others.size() <= most_others) named.insert(named.end(), others.begin(), others.end());
    std::sort(named.begin(), named.end(),
              [](const CameraCandidate& a, const CameraCandidate& b) { return a.file < b.file; });
    return named;
}

/// How well a camera goes with depth's pictures, what counts most first.
std::array<bool, 5> mark_of(const CameraCandidate& candidate, const CameraFile& camera,
                            const PicturesOfCamera& pictures) {
    const std::string name = lower_case(camera.name) + ' ' + lower_case(candidate.file.filename().string());
    const bool is_of_depth = has_word(name, {"depth"}),
               is_of_colour = !is_of_depth && has_word(name, {"color", "colour", "rgb"});
    return {candidate.is_named, is_of_depth,
            camera.intrinsics.width == pictures.width && camera.intrinsics.height == pictures.height,
            !is_of_colour, !camera.has_distortion};
}

void look_in(const fs::path& folder, const PicturesOfCamera& pictures, bool tells, CameraBeside& beside) {
    std::array<bool, 5> best{};
    for (const CameraCandidate& candidate : candidates_in(folder, pictures)) {
        auto said = read_camera_text(candidate.file);
        const bool has_camera = said && !said->cameras.empty();
        if (!has_camera && candidate.is_named && tells &&
            lower_case(candidate.file.filename().string()) != "metadata.json")
            beside.not_understood.push_back(candidate.file.filename().string());
        if (!said) continue;
        if (beside.frames_per_second == 0 && said->frames_per_second > 0 &&
            (candidate.is_named || has_camera)) {
            beside.frames_per_second = said->frames_per_second;
            beside.rate_file = candidate.file;
        }
        const bool is_one = said->cameras.size() == 1;
        for (CameraFile& camera : said->cameras) {
            const auto mark = mark_of(candidate, camera, pictures);
            if (beside.camera && mark <= best) continue;
            if (is_one) camera.name.clear();
            best = mark;
            beside.camera = std::move(camera);
            beside.file = candidate.file;
        }
    }
}

/// How far a point is from the middle of a side, of which it is a share.
double off_middle(double at, int side) {
    return std::abs((at + 0.5) / side - 0.5);
}

}  // namespace

CameraBeside camera_beside(const PicturesOfCamera& pictures) {
    CameraBeside beside;
    std::error_code failure;
    fs::path here = fs::weakly_canonical(pictures.folder.empty() ? "." : pictures.folder, failure);
    if (failure) here = pictures.folder;
    std::vector<fs::path> folders{here};
    if (!pictures.within.empty()) folders.push_back((here / pictures.within).lexically_normal());
    folders.push_back(here / "sparse" / "0");
    for (const fs::path& folder : folders)
        if (!beside.camera) look_in(folder, pictures, true, beside);
    if (!beside.camera) {
        PicturesOfCamera above = pictures;
        above.is_whole_folder = false;
        look_in(here.parent_path(), above, false, beside);
    }
    if (beside.camera)
        beside.camera->intrinsics =
            trusted_intrinsics(beside.camera->intrinsics, pictures.width, pictures.height, beside.doubt);
    return beside;
}

Intrinsics trusted_intrinsics(Intrinsics camera, int width, int height, std::string& doubt) {
    if (!camera.cx || !camera.cy || width <= 0 || height <= 0) return camera;
    const double cx = *camera.cx, cy = *camera.cy;
    const auto is_share = [](double at) { return at > 0 && at < 1; };
    constexpr double longest_share = 10, far_off = 0.2, near_middle = 0.1, most_apart = 0.1;
    if (camera.fx < longest_share && camera.fy < longest_share && is_share(cx) && is_share(cy)) {
        doubt = "whose numbers are shares of a picture";
        return {camera.fx * width, camera.fy * height, cx * width - 0.5, cy * height - 0.5, width, height};
    }
    const bool says_size = camera.width > 0 && camera.height > 0;
    if (says_size && (camera.width != width || camera.height != height)) {
        const bool is_theirs =
            off_middle(cx, width) <= near_middle && off_middle(cy, height) <= near_middle &&
            (off_middle(cx, camera.width) > far_off || off_middle(cy, camera.height) > far_off);
        if (!is_theirs) return camera;
        doubt = "which says that its pictures have " + std::to_string(camera.width) + "x" +
                std::to_string(camera.height) + " pixels, but whose principal point is the middle of these";
        camera.width = camera.height = 0;
    } else if (!says_size && (off_middle(cx, width) > far_off || off_middle(cy, height) > far_off)) {
        const double across = (2 * cx + 1) / width, down = (2 * cy + 1) / height;
        if (!(across > 0.01 && down > 0.01) || std::abs(across - down) > most_apart * across) return camera;
        const double times = 0.5 * (across + down);
        camera.width = static_cast<int>(std::lround(std::min(times * width, 1e6)));
        camera.height = static_cast<int>(std::lround(std::min(times * height, 1e6)));
        doubt =
            "whose principal point is the middle of pictures " + short_number(times, 3) + " times as large";
    }
    return camera;
}

}  // namespace touchable
