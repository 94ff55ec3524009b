// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/camera_sidecar.hpp"

#include <cctype>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <sstream>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/sidecar_text.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

struct CameraCandidate {
    fs::path file;
    bool is_named = false;  // as a camera's file
    bool is_own = false;    // the picture's own, by its stem or number
    bool is_text = false;   // neither named so nor of members: a camera in it must name its numbers
};

/// Whether a file has a name that programs give a camera's file. Files of poses do not count.
bool is_named_camera(const std::string& name, const std::string& stem) {
    if (has_word(name, {"extrinsic", "pose", "trajector", "groundtruth"})) return false;
    const bool is_numbered_cam =
        stem.starts_with("cam") && stem.find_first_not_of("0123456789", 3) == std::string::npos;
    return has_word(name, {"camera", "intrinsic", "calib", "camchain"}) || is_numbered_cam ||
           stem.starts_with("cam_") || stem.ends_with("_cam") || is_any_of(stem, {"k", "camk", "fov"}) ||
           is_any_of(name, {"metadata", "metadata.json", "transforms.json"});
}

/// Whether a file is of pictures or poses, which have own readers, written by this program, or no camera's.
bool is_of_others(const std::string& name) {
    return is_any_of(name,
                     {"scene.json", "poses.txt", "groundtruth.txt", "trajectory.log", "depth.txt", "rgb.txt",
                      "associations.txt", "associate.txt", "metadata.json", "depth_m_color.txt"}) ||
           has_word(name, {"readme", "license", "extrinsic"});
}

constexpr std::size_t most_looked_at = 1'000'000;  // entries of a folder

bool is_arrays(const std::string& extension) {
    return is_any_of(extension, {".npy", ".npz"});
}

/// A folder's entries by name, but pictures (not arrays) and videos, whose stems go to `picture_stems`.
std::vector<fs::path> texts_in(const fs::path& folder, std::vector<std::string>& picture_stems) {
    std::vector<fs::path> texts;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        const std::string extension = small_letters(entry.path().extension().string());
        const std::string name = entry.path().filename().string();
        if (name.starts_with('.')) continue;
        const bool is_picture =
            is_any_of(extension, {".png", ".exr", ".tif", ".tiff", ".pgm", ".pfm", ".npy", ".npz", ".jpg",
                                  ".jpeg", ".heic", ".mkv", ".mp4", ".mov", ".avi"});
        if (texts.size() + picture_stems.size() >= most_looked_at || stop_requested()) break;
        if (is_picture) picture_stems.push_back(small_letters(entry.path().stem().string()));
        if (!is_picture || is_arrays(extension)) texts.push_back(entry.path());
    }
    std::ranges::sort(texts);
    std::ranges::sort(picture_stems);
    return texts;
}

bool is_small_text(const std::string& extension) {
    return is_any_of(extension, {".json", ".jsonl", ".yaml", ".yml", ".xml", ".txt", ".csv", ".ini", ".toml",
                                 ".cfg", ".conf", ".cal"});
}

bool has_digit(std::string_view text) {
    return std::ranges::any_of(text, is_digit);
}

/// The words of a name, with the numbers behind them: cam2 and depth of depth_cam_02.
std::set<std::string> words_of(const std::string& name) {
    std::set<std::string> words;
    const std::string letters = small_letters(name) + '.';
    std::string word;
    for (std::size_t k = 0; k < letters.size(); ++k) {
        const bool is_letter = letters[k] >= 'a' && letters[k] <= 'z';
        if (is_digit(letters[k])) {
            const auto end = letters.find_first_not_of("0123456789", k);
            const std::string number = number_in(letters.substr(k, end - k), 0);
            if (!word.empty()) words.insert(word + number);
            word.clear();
            k = end - 1;
        } else if (is_letter) {
            word += letters[k];
        } else if (!is_digit(letters[std::min(k + 1, letters.size() - 1)])) {
            if (!word.empty()) words.insert(word);
            word.clear();
        }
    }
    return words;
}

/// The pictures whose camera is sought, with what their names tell.
struct Sought : PicturesOfCamera {
    std::vector<std::string> stems{};  // of the frames, or of pictures named as this one is, at most 64
    int telling = 0;                   // their telling_number
    FrameKey key{};                    // of a single picture
    std::set<std::string> words{};     // of depth's folders' names; tell cameras apart
    std::string below{};               // subfolder that the search came from, small letters
    bool needs_camera = false;         // ignore files without one, unless named as a camera's
};

/// Whether no letter or number of a name stands at this place.
bool ends_word(const std::string& name, std::size_t at) {
    return at == name.size() || std::isalnum(static_cast<unsigned char>(name[at])) == 0;
}

/// Number of letters of the whole words with which both stems begin.
std::size_t same_words(const std::string& picture, const std::string& stem) {
    std::size_t same = 0;
    for (std::size_t k = 0; k <= std::min(picture.size(), stem.size()); ++k) {
        if (ends_word(picture, k) && ends_word(stem, k)) same = k;
        if (k == picture.size() || k == stem.size() || picture[k] != stem[k]) break;
    }
    return same;
}

/// Whether two stems begin with the same words, with a number among them, and the second has no further
/// number: v2_depth and v2_K.
bool has_stem_of(const std::string& picture, const std::string& stem) {
    const std::size_t same = same_words(picture, stem);
    return has_digit(stem.substr(0, same)) && !has_digit(stem.substr(same));
}

/// The last word of a picture's name with the mark before it; empty: the name is one word.
std::string last_word(const std::string& stem) {
    return stem.substr(std::min(stem.find_last_of("_-. "), stem.size()));
}

/// Whether one of these sorted names begins with these words.
bool is_beginning(const std::string& words, const std::vector<std::string>& names) {
    // The next character is no letter or number: the ranges between those in ASCII.
    constexpr std::pair<const char*, const char*> ends[] = {{"", "0"}, {":", "A"}, {"[", "a"}, {"{", "\xff"}};
    return std::ranges::any_of(ends, [&](const auto& end) {
        const auto at = std::ranges::lower_bound(names, words + end.first);
        return at != names.end() && *at < words + end.second;
    });
}

/// Whether a file's name assigns it to another picture: chair_camera to chair_depth, and not to table_depth.
/// `others`: the names of the pictures that end with the same word as this one, sorted.
bool is_of_another(const std::string& picture, const std::string& stem,
                   const std::vector<std::string>& others) {
    for (std::size_t k = same_words(picture, stem) + 1; k <= stem.size(); ++k)
        if (ends_word(stem, k) && is_beginning(stem.substr(0, k), others)) return true;
    return false;
}

/// Files of a folder that may be a camera's, the picture's own first, then by name. Leaves out other
/// pictures' own files, and those named as a subfolder, unless the search came from it.
std::vector<CameraCandidate> candidates_in(const fs::path& folder, const Sought& pictures) {
    constexpr std::size_t most_named = 100, most_others = 16;  // more are something else
    constexpr std::uintmax_t longest_other = 1 << 20, longest_text = 1 << 22;
    std::vector<std::string> picture_stems;
    std::vector<CameraCandidate> named, others;
    const std::vector<fs::path> texts = texts_in(folder, picture_stems);
    const std::string own_stem = small_letters(pictures.stem);
    std::vector<std::string> stems_alike;  // that end with the same word, as depth's pictures do
    if (const std::string last = last_word(own_stem); !last.empty())
        std::ranges::copy_if(picture_stems, std::back_inserter(stems_alike),
                             [&](const std::string& stem) { return stem.ends_with(last); });
    for (const fs::path& file : texts) {
        if (stop_requested()) return {};
        const std::string name = small_letters(file.filename().string()),
                          stem = small_letters(file.stem().string()),
                          extension = small_letters(file.extension().string());
        if (!is_file(file)) continue;
        std::error_code failure;
        if (!pictures.below.empty() && stem != pictures.below &&
            fs::is_directory(folder / file.stem(), failure))
            continue;
        // Arrays beside those of frames, whose names have numbers: PointOdyssey's anno.npz.
        const bool is_npz = extension == ".npz" && !has_digit(stem) && stem != own_stem;
        const bool has_members = is_npz || is_any_of(extension, {".json", ".jsonl", ".yaml", ".yml", ".xml"});
        const bool is_own = !stem.empty() && (stem == own_stem || has_stem_of(own_stem, stem));
        if (!is_own && !pictures.is_whole_folder && is_of_another(own_stem, stem, stems_alike)) continue;
        if (is_named_camera(name, stem)) {
            if (is_small_text(extension) || is_arrays(extension) ||
                is_any_of(extension, {"", ".bin", ".mat", ".pincam"}))
                if (named.size() < most_named) named.push_back({file, true, is_own});
        } else if ((is_small_text(extension) || is_npz) && !is_of_others(name)) {
            // For one picture of a folder: a file that is no other picture's may serve all.
            const std::string before_dot = stem.substr(0, stem.rfind('.'));  // robot.info beside robot.mp4
            const bool is_shared = is_npz || (!std::ranges::binary_search(picture_stems, stem) &&
                                              !std::ranges::binary_search(picture_stems, before_dot));
            if (!is_own && (others.size() > most_others || (!pictures.is_whole_folder && !is_shared)))
                continue;
            const auto longest = extension == ".jsonl" || is_npz ? std::numeric_limits<std::uintmax_t>::max()
                                 : has_members                   ? longest_other
                                                                 : longest_text;
            if (fs::file_size(file, failure) <= longest && !failure && named.size() < most_named)
                (is_own ? named : others).push_back({file, false, is_own, !has_members});
        }
    }
    if (others.size() <= most_others) named.insert(named.end(), others.begin(), others.end());
    std::ranges::sort(named, [](const CameraCandidate& one, const CameraCandidate& other) {
        return one.is_own != other.is_own ? one.is_own : one.file < other.file;
    });
    return named;
}

/// Which number, counted from the end, is different in all these stems: 16 in 0001_depth16 is not.
int telling_number(std::span<const std::string> stems) {
    constexpr int most_numbers = 8;
    for (int from_end = 0; from_end < most_numbers; ++from_end) {
        std::set<std::string> numbers;
        for (const std::string& stem : stems) numbers.insert(number_in(stem, from_end));
        if (numbers.size() == stems.size()) return from_end;
    }
    return 0;
}

constexpr std::size_t most_frames_read = 64;

bool is_folder_of_cameras(const fs::path& folder) {
    return has_word(small_letters(folder.filename().string()), {"intrinsic", "calib", "camera_param"});
}

/// A stem with # for each of its numbers.
std::string shape_of(const std::string& stem) {
    std::string shape;
    for (const char c : stem)
        if (!is_digit(c) || !shape.ends_with('#')) shape += is_digit(c) ? '#' : c;
    return shape;
}

/// Series of files in a folder, with one for each of the pictures' stems: of the same stem, or of the same
/// number in names that are alike but for their numbers. Only kinds with a file for every picture.
std::vector<std::vector<fs::path>> series_in(const fs::path& folder, const Sought& pictures) {
    std::vector<std::string> ignored;
    using Files = std::map<std::string, fs::path>;
    std::map<std::string, Files> by_extension, by_shape;
    for (const fs::path& file : texts_in(folder, ignored)) {
        const std::string extension = small_letters(file.extension().string());
        if (!is_any_of(extension, {".json", ".yaml", ".yml", ".xml", ".txt", ".npy", ".npz"})) continue;
        const std::string stem = file.stem().string();
        by_extension[extension].emplace(stem, file);
        by_shape[extension + shape_of(stem)].emplace(stem, file);
    }
    std::vector<std::vector<fs::path>> series;
    const auto add = [&](const Files& files, auto key_of) {
        std::vector<fs::path> found;
        for (const std::string& stem : pictures.stems)
            if (const auto file = files.find(key_of(stem)); file != files.end())
                found.push_back(file->second);
        constexpr std::size_t most = 8;
        if (found.size() == pictures.stems.size() && series.size() < most) series.push_back(std::move(found));
    };
    for (const auto& [extension, files] : by_extension) add(files, std::identity());
    for (const auto& [shape, files] : by_shape) {
        if (files.size() < 2) continue;
        std::vector<std::string> stems;
        for (const auto& [stem, file] : files) stems.push_back(stem);
        const int telling = telling_number(stems);
        Files by_number;
        for (const auto& [stem, file] : files)
            // cam0 and cam1 are two cameras of all frames.
            if (const std::string number = number_in(stem, telling);
                !number.empty() && stem != "cam" + number)
                by_number.emplace(number, file);
        add(by_number, [&](const std::string& stem) { return number_in(stem, pictures.telling); });
    }
    return series;
}

/// Cameras of a folder in which each frame has a file of its own, of the same name or number.
struct OwnCameras {
    CameraFile median;
    fs::path first;
    std::string files;  ///< "*.json"
};
std::optional<OwnCameras> cameras_of_frames(const fs::path& folder, const Sought& pictures) {
    if (pictures.frames.size() < 2) return {};
    // In other folders, four or six numbers without names may be anything.
    const bool is_of_cameras = is_folder_of_cameras(folder);
    std::vector<std::vector<fs::path>> all = series_in(folder, pictures);
    std::stable_partition(all.begin(), all.end(), [](const std::vector<fs::path>& files) {
        return has_word(files.front().filename().string(), {"depth"});
    });
    for (const std::vector<fs::path>& files : all) {
        std::vector<CameraFile> cameras;
        for (const fs::path& file : files) {
            if (stop_requested()) return {};
            auto said = read_camera_text(file);
            if (!said || said->cameras.size() != 1) break;
            if (said->cameras.front().is_bare && !is_of_cameras) break;
            cameras.push_back(std::move(said->cameras.front()));
        }
        if (cameras.size() != files.size()) continue;
        OwnCameras own{median_camera_file(cameras), files.front(), '*' + files.front().extension().string()};
        own.median.frames = pictures.frames.size();
        own.median.is_of_files = true;
        return own;
    }
    return {};
}

/// The candidates of a single picture, its own files first; those of the pictures beside it are left out.
std::vector<CameraCandidate> candidates_of_picture(const fs::path& folder, const Sought& pictures) {
    std::vector<CameraCandidate> candidates = candidates_in(folder, pictures);
    if (pictures.is_whole_folder || pictures.stems.size() < 2) return candidates;
    const auto own = std::ranges::find(pictures.stems, pictures.stem) - pictures.stems.begin();
    for (const std::vector<fs::path>& files : series_in(folder, pictures)) {
        const fs::path& file = files[static_cast<std::size_t>(own)];
        const std::string name = small_letters(file.filename().string());
        const bool is_named =
            is_folder_of_cameras(folder) || is_named_camera(name, small_letters(file.stem().string()));
        if (stop_requested()) return {};
        if (!is_named && is_of_others(name)) continue;
        const auto said = read_camera_text(file);
        if (!said || (said->cameras.empty() && said->codes_per_metre == 0)) continue;
        std::erase_if(candidates, [&](const CameraCandidate& each) {
            return each.file.extension() == file.extension() &&
                   shape_of(each.file.stem().string()) == shape_of(file.stem().string());
        });
        const bool is_text = !is_named && name.ends_with(".txt");
        candidates.insert(candidates.begin(), {file, is_named, true, is_text});
    }
    return candidates;
}

/// Distance of a point from the middle of a side, as a share of the side.
double off_middle(double at, int side) {
    return std::abs((at + 0.5) / side - 0.5);
}
constexpr double far_off = 0.2;

/// How well a camera fits depth's pictures, what counts most first. If two differ only behind the first
/// `sure_marks`, the choice is not sure.
using CameraMark = std::array<double, 9>;
constexpr std::size_t sure_marks = 7;
CameraMark mark_of(const CameraCandidate& candidate, const CameraFile& camera, const Sought& pictures) {
    const std::string name =
        small_letters(camera.name) + ' ' + small_letters(candidate.file.filename().string());
    const bool is_of_depth = has_word(name, {"depth"}),
               is_of_colour = !is_of_depth && has_word(name, {"color", "colour", "rgb"});
    const bool shares_word = std::ranges::any_of(
        words_of(name), [&](const std::string& word) { return pictures.words.contains(word); });
    const Intrinsics& of = camera.intrinsics;
    constexpr double middle = 0.1, most_apart = 0.01;
    enum SizeFit { of_another_shape, unknown, of_this_shape, by_principal_point, of_this_size };
    SizeFit fit = unknown;
    double nearness = 0;
    if (pictures.width > 0 && pictures.height > 0) {
        const double across = static_cast<double>(of.width) / pictures.width,
                     down = static_cast<double>(of.height) / pictures.height;
        if (of.width <= 0 || of.height <= 0) {
            const bool is_there = of.cx && of.cy && off_middle(*of.cx, pictures.width) < middle &&
                                  off_middle(*of.cy, pictures.height) < middle;
            fit = is_there ? by_principal_point : unknown;
        } else if (across == 1 && down == 1) {
            fit = of_this_size;
        } else {
            fit = std::abs(across - down) <= most_apart * across ? of_this_shape : of_another_shape;
            nearness = -std::max(across, 1 / across);
        }
    }
    return {double(candidate.is_own),
            double(is_of_depth),
            double(fit == of_this_size),
            double(shares_word),
            double(candidate.is_named),
            static_cast<double>(fit),
            nearness,
            double(!is_of_colour),
            double(!camera.has_distortion)};
}

/// Whether a text has a number in its first 64 KiB.
bool has_number(const fs::path& file) {
    constexpr std::size_t enough = 1 << 16;
    return !is_arrays(small_letters(file.extension().string())) &&
           has_digit(first_bytes(SourceFile(file), enough));
}

/// Takes the cameras of a folder in which each frame has its own.
void take_frames(const fs::path& folder, const Sought& pictures, CameraBeside& beside) {
    auto own = cameras_of_frames(folder, pictures);
    if (!own) return;
    beside.codes_per_metre.add(own->median.codes_per_metre, own->first);
    const fs::path within = folder.lexically_relative(pictures.folder);
    beside.file = own->first;
    if (own->median.differs && !within.empty() && *within.begin() != "..") {
        // The pattern is that of an extension, and matches other files as well if there are more than frames.
        std::vector<std::string> ignored;
        const auto texts = texts_in(folder, ignored);
        const auto alike = std::ranges::count(texts, own->first.extension(), &fs::path::extension);
        if (static_cast<std::size_t>(alike) == pictures.frames.size())
            beside.frame_cameras = (within == "." ? fs::path(own->files) : within / own->files).string();
    }
    beside.camera = std::move(own->median);
}

/// The depth camera of an Azure Kinect's calibration, whose numbers are shares of its sensor.
std::optional<CameraFile> azure_kinect_camera(const fs::path& file, const Sought& pictures) {
    constexpr std::size_t longest = 1 << 18;
    const auto text = read_given_file(file, file.string(), "a camera's file", longest);
    if (!text || text->find("\"ModelParameters\"") == std::string::npos) return {};
    const auto read = parse_azure_kinect_calibration(*text, {pictures.width, pictures.height}, {}, "");
    if (!read || !(read->depth.fx > 0) || !(read->depth.fy > 0)) return {};
    const Camera& camera = read->depth;
    return CameraFile{.intrinsics = {camera.fx, camera.fy, camera.cx, camera.cy},
                      .has_distortion = read->depth_lens.any()};
}

/// What a candidate says, without cameras that are too doubtful; nothing if it cannot be read.
CameraText said_by(const CameraCandidate& candidate, const Sought& pictures) {
    auto read = read_camera_text(candidate.file, pictures.key);
    if (!read) return {};
    CameraText said = std::move(*read);
    if (said.cameras.empty() && candidate.is_named)
        if (auto found = azure_kinect_camera(candidate.file, pictures)) said.cameras = {std::move(*found)};
    // A camera names its numbers, or is a whole matrix; four or six bare numbers may be anything.
    if (candidate.is_text) std::erase_if(said.cameras, &CameraFile::is_bare);
    // Beside a single picture an angle alone, in a file of any name, may be that of a window.
    if (!pictures.is_whole_folder && !candidate.is_named && !candidate.is_own)
        std::erase_if(said.cameras, [](const CameraFile& camera) { return camera.intrinsics.fx == 0; });
    if (said.cameras.empty() && pictures.needs_camera && !candidate.is_named) return {};
    return said;
}

/// The focal length of a camera for pictures of this size.
double focal_length(const CameraFile& camera, const Sought& pictures) {
    std::string ignored;
    const int width = std::max(pictures.width, 1), height = std::max(pictures.height, 1);
    return scaled_camera(trusted_intrinsics(camera.intrinsics, width, height, ignored), width, height).fx;
}

/// The cameras that fit the pictures as surely as the best of them.
struct LikelyCameras {
    CameraMark mark{};  // of the best
    std::size_t count = 0;
    double least = 0, most = 0;  // focal lengths
    /// Counts another camera; returns whether it is better than those before it.
    bool take(const CameraMark& of_other, double focal) {
        const bool is_better = count == 0 || of_other > mark;
        const bool is_as_sure =
            count > 0 && std::equal(mark.begin(), mark.begin() + sure_marks, of_other.begin());
        if (!is_better && !is_as_sure) return false;
        if (!is_as_sure) *this = {of_other, 0, focal, focal};
        if (is_better) mark = of_other;
        ++count;
        least = std::min(least, focal);
        most = std::max(most, focal);
        return is_better;
    }
};

/// Adds to `beside` what files of one folder say. `tells`: also names those that are not understood.
void look_in(const fs::path& folder, const Sought& pictures, bool tells, CameraBeside& beside) {
    LikelyCameras best;
    bool is_any_angle = false;  // in a file of any name, so perhaps a window's
    if (!beside.camera) take_frames(folder, pictures, beside);
    const bool is_known = beside.camera.has_value();
    if (is_known && !tells) return;
    for (const CameraCandidate& candidate : candidates_of_picture(folder, pictures)) {
        if (stop_requested()) return;
        const std::string name = candidate.file.filename().string();
        if (const double rate = rate_in_file_of_times(candidate.file, pictures.frames.size()); rate > 0) {
            beside.frames_per_second.add(rate, candidate.file);
            continue;
        }
        CameraText said = said_by(candidate, pictures);
        const bool has_camera = !said.cameras.empty(), is_odometry = said.timed_rows > 0;
        const bool may_say_rate = candidate.is_named || has_camera || is_odometry || !candidate.is_text;
        const double rate = may_say_rate ? said.frames_per_second : 0, scale = said.codes_per_metre,
                     unit = said.metres_per_value;
        const bool is_silent = !has_camera && rate <= 0 && scale <= 0 && unit <= 0 && said.far <= 0;
        if (is_silent && candidate.is_named && tells && !small_letters(name).starts_with("metadata")) {
            constexpr std::size_t enough = 64;
            const bool is_pointer = is_git_lfs_pointer(first_bytes(SourceFile(candidate.file), enough));
            beside.not_understood.push_back(is_pointer ? name + ", which " + git_lfs_words : name);
        } else if (is_silent && tells && pictures.is_whole_folder && has_number(candidate.file)) {
            beside.not_used.push_back(name);
        }
        beside.frames_per_second.add(rate, candidate.file);
        beside.codes_per_metre.add(scale, candidate.file);
        beside.metres_per_value.add(unit, candidate.file);
        beside.near.add(said.near, candidate.file);
        beside.far.add(said.far, candidate.file);
        const bool is_one = said.cameras.size() == 1;
        for (CameraFile& camera : said.cameras) {
            if (is_known) break;
            if (!best.take(mark_of(candidate, camera, pictures), focal_length(camera, pictures))) continue;
            if (is_one) camera.name = pictures.key.stem.empty() ? "" : camera.frame;
            beside.camera = std::move(camera);
            beside.file = candidate.file;
            const Intrinsics& taken = beside.camera->intrinsics;
            is_any_angle = !candidate.is_named && !candidate.is_own && taken.fx == 0 &&
                           (taken.fov_x == 0 || taken.fov_y == 0);
        }
    }
    std::string which = printable(beside.file.filename().string());
    if (is_any_angle)
        beside.guesses.push_back("the camera is an angle in " + which +
                                 ", which may be that of another view");
    constexpr double most_alike = 1.03;
    if (best.most <= most_alike * best.least) return;
    if (!beside.camera->name.empty()) which += " (" + printable(beside.camera->name, 60) + ')';
    beside.guesses.push_back("the camera is one of " + std::to_string(best.count) + " that differ, " + which);
}

/// Whether a folder is named as a part of a recording, to which the folder above then belongs as well.
bool is_part_by_name(const fs::path& folder) {
    const std::string name = small_letters(folder.filename().string());
    return has_word(name, {"depth", "disp", "camera", "cam_", "frames", "image", "rgb", "color", "colour",
                           "data", "keyframes", "left", "right", "results", "ground"}) ||
           is_digits(name);
}

/// Texts whose names say colour, sorted.
std::vector<fs::path> texts_of_colour(const fs::path& folder) {
    constexpr std::size_t most = 1000;
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
        if (has_word(entry.path().extension().string(), {".txt", ".json", ".yaml", ".yml"}) &&
            has_word(entry.path().stem().string(), {"color", "colour", "rgb"}) && files.size() < most)
            files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
}

/// A matrix of three or four rows; nothing if the file has none, or the unit matrix.
std::optional<CameraPose> movement_of(const fs::path& file) {
    constexpr std::size_t longest = 1 << 12;
    auto text = read_given_file(file, file.string(), "a matrix", longest);
    if (!text) return {};
    std::istringstream words(std::move(*text));
    std::vector<double> numbers;
    for (double number = 0; words >> number;) numbers.push_back(number);
    if (!words.eof() || (numbers.size() != 12 && numbers.size() != 16)) return {};
    CameraPose pose;
    bool moves = false;
    for (std::size_t k = 0; k < 12; ++k) {
        moves = moves || std::abs(numbers[k] - (k % 5 == 0 ? 1 : 0)) > 1e-6;
        (k % 4 == 3 ? pose.translation[k / 4] : pose.rotation[k / 4 * 3 + k % 4]) = numbers[k];
    }
    return moves ? std::optional(pose) : std::nullopt;
}

/// The camera, for pictures of this size if it states none.
Intrinsics sized(Intrinsics camera, int width, int height) {
    if (camera.width <= 0 || camera.height <= 0) camera.width = width, camera.height = height;
    return camera;
}

/// Whether the cameras differ by more than two hundredths of the focal lengths or of the picture.
bool differs(const Camera& a, const Camera& b, const Scene& scene) {
    constexpr double share = 0.02;
    return std::abs(a.fx - b.fx) > share * b.fx || std::abs(a.fy - b.fy) > share * b.fy ||
           std::abs(a.cx - b.cx) > share * scene.width || std::abs(a.cy - b.cy) > share * scene.height;
}

/// Sets words, stems, telling number and key by the names of the pictures, or of those beside a single one.
void know_names(const fs::path& of_depth, Sought& pictures) {
    for (const fs::path& folder : {pictures.folder, of_depth})
        for (const std::string& word : words_of(folder.filename().string()))
            if (!is_any_of(
                    word, {"depth",  "depths", "disparity",  "camera", "cameras",     "cam",  "rgb",  "color",
                           "colour", "image",  "images",     "frame",  "frames",      "data", "json", "txt",
                           "yaml",   "scene",  "intrinsics", "calib",  "calibration", "k"}))
                pictures.words.insert(word);
    std::vector<std::string> stems;
    for (const fs::path& frame : pictures.frames) stems.push_back(frame.stem().string());
    if (stems.empty() && !pictures.stem.empty()) {
        std::error_code ignored;
        std::set<std::string> extensions, alike;
        std::size_t looked = 0;
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(pictures.folder, ignored)) {
            if (++looked > most_looked_at || stop_requested()) break;
            if (shape_of(entry.path().stem().string()) == shape_of(pictures.stem))
                files.push_back(entry.path());
        }
        for (const fs::path& file : files)
            if (file.stem().string() == pictures.stem &&
                !is_small_text(small_letters(file.extension().string())))
                extensions.insert(file.extension().string());
        for (const fs::path& file : files)
            if (extensions.contains(file.extension().string())) alike.insert(file.stem().string());
        stems.assign(alike.begin(), alike.end());
    }
    pictures.telling = telling_number(stems);
    if (pictures.frames.empty() && !pictures.stem.empty())
        pictures.key = {pictures.stem, number_in(pictures.stem, pictures.telling), stems.size()};
    const std::size_t count = std::min(stems.size(), most_frames_read);
    for (std::size_t n = 0; n < count; ++n) pictures.stems.push_back(stems[n * stems.size() / count]);
    if (!pictures.stem.empty() && std::ranges::count(pictures.stems, pictures.stem) == 0)
        pictures.stems.push_back(pictures.stem);
}

/// Whether a folder has folders or pictures in it, as recordings have.
bool has_pictures(const fs::path& folder) {
    std::vector<std::string> picture_stems;
    std::error_code ignored;
    const std::vector<fs::path> others = texts_in(folder, picture_stems);
    return !picture_stems.empty() ||
           std::ranges::any_of(others, [&](const fs::path& file) { return fs::is_directory(file, ignored); });
}

/// Adds the folders in `base` that are named for cameras.
void add_camera_folders(const fs::path& base, std::vector<fs::path>& folders) {
    constexpr std::size_t most_taken = 16;
    constexpr const char* known[] = {
        "cameras",           "camera", "intrinsics", "intrinsic", "calib", "calibration",
        "corrected_cameras", "cam",    "cams",       "k",         "poses", "pose"};
    std::vector<fs::path> found;
    std::error_code ignored;
    std::size_t looked = 0;
    for (const auto& entry : fs::directory_iterator(base, ignored)) {
        if (++looked > most_looked_at || found.size() > most_taken || stop_requested()) break;
        const std::string name = small_letters(entry.path().filename().string());
        const bool is_known = std::ranges::find(known, name) != std::end(known);
        if (!is_known && !is_folder_of_cameras(entry.path())) continue;
        if (entry.is_directory(ignored) && (is_known || !has_pictures(entry.path())))
            found.push_back(entry.path());
    }
    std::ranges::sort(found, {}, [&](const fs::path& folder) {
        const auto at = std::ranges::find(known, small_letters(folder.filename().string()));
        return std::pair(at - std::begin(known), folder);
    });
    if (found.size() > most_taken) found.resize(most_taken);
    folders.insert(folders.end(), found.begin(), found.end());
}

/// For a camera of pictures of another shape: says how these pictures were probably made of those. The same
/// shape on its side is turned; of others scaled_camera takes the middle. Empty: the same shape.
std::string guess_shape(Intrinsics& camera, int width, int height) {
    if (camera.width <= 0 || camera.height <= 0 || width <= 0 || height <= 0) return "";
    constexpr double most_apart = 0.02;
    const double theirs = static_cast<double>(camera.width) / camera.height,
                 ours = static_cast<double>(width) / height;
    const auto is_near = [](double a, double b) { return std::abs(a - b) <= most_apart * b; };
    if (is_near(theirs, ours)) return "";
    const std::string sizes = size_text(camera.width, camera.height) + " pixels, and these pictures have " +
                              size_text(width, height);
    if (!is_near(1 / theirs, ours))
        return "for the middle of its pictures: it is of " + sizes +
               ", taken as cut to that and not stretched";
    const Intrinsics of = camera;
    const double cx = of.cx.value_or(0), cy = of.cy.value_or(0);
    camera.width = of.height;
    camera.height = of.width;
    if (of.cx && of.cy &&
        off_middle(cx, of.height) + off_middle(cy, of.width) <
            off_middle(cx, of.width) + off_middle(cy, of.height))
        return "with its sides the other way round, as its principal point is: it says " + sizes;
    camera.fx = of.fy;
    camera.fy = of.fx;
    std::swap(camera.fov_x, camera.fov_y);
    camera.cx = of.cy;
    if (of.cx) camera.cy = of.width - 1 - cx;
    return "turned by a quarter: it is of " + sizes;
}

/// A usual picture size with the shape of these and a width at most a thirtieth off; nothing: there is none.
std::optional<std::pair<int, int>> usual_size(double near_width, int width, int height) {
    constexpr std::pair<int, int> usual[] = {
        {320, 240},   {480, 360},   {512, 384},   {512, 424},   {640, 360},   {640, 480},
        {640, 576},   {720, 960},   {848, 480},   {960, 540},   {960, 720},   {1024, 576},
        {1024, 768},  {1080, 1440}, {1280, 720},  {1280, 800},  {1280, 960},  {1280, 1024},
        {1440, 1080}, {1440, 1920}, {1600, 1200}, {1920, 1080}, {1920, 1440}, {2048, 1536},
        {2560, 1440}, {2560, 1920}, {3024, 4032}, {3840, 2160}, {4032, 3024}, {4096, 3072}};
    std::optional<std::pair<int, int>> best;
    double nearest = near_width / 30;
    for (const auto& [w, h] : usual) {
        const bool is_of_shape = std::abs(double(w) * height - double(h) * width) < 0.01 * w * height;
        if (!is_of_shape || std::abs(w - near_width) > nearest) continue;
        nearest = std::abs(w - near_width);
        best = {w, h};
    }
    return best;
}

}  // namespace

std::string guessed_field_of_view(double degrees) {
    constexpr double more = 10;  // degrees
    const auto width = [](double whole) { return sine(whole * pi / 360) / cosine(whole * pi / 360); };
    const double other = std::min(degrees + more, 175.0);
    return "the camera sees " + short_number(degrees) + " degrees from left to right; if it sees " +
           short_number(other) + ", all shapes are " +
           short_number(100 * (1 - width(degrees) / width(other)), 2) + " % too narrow";
}

CameraBeside camera_beside(const PicturesOfCamera& pictures_of) {
    constexpr int farthest_above = 4;
    Sought pictures{pictures_of};
    CameraBeside beside;
    std::error_code failure;
    fs::path here = fs::weakly_canonical(pictures.folder.empty() ? "." : pictures.folder, failure);
    if (failure) here = pictures.folder;
    pictures.folder = here;
    if (!pictures.own.cameras.empty()) {
        beside.camera = pictures.own.cameras.front();
        beside.file = pictures.own_file;
    }
    beside.not_used = pictures.own_not_used;
    beside.codes_per_metre.add(pictures.own.codes_per_metre, pictures.own_file);
    beside.frames_per_second.add(pictures.own.frames_per_second, pictures.own_file);
    beside.near.add(pictures.own.near, pictures.own_file);
    beside.far.add(pictures.own.far, pictures.own_file);
    const fs::path of_depth =
        pictures.within.empty() ? here : (here / pictures.within / "").lexically_normal().parent_path();
    know_names(of_depth, pictures);
    std::vector<fs::path> folders{here};
    if (of_depth != here) folders.push_back(of_depth);
    folders.push_back(here / "sparse" / "0");
    add_camera_folders(here, folders);
    if (of_depth.parent_path() != here) add_camera_folders(of_depth.parent_path(), folders);
    for (const fs::path& folder : folders)
        look_in(folder, pictures, folder == here || folder == of_depth, beside);
    Sought above = pictures;
    above.is_whole_folder = false;
    above.stem.clear();
    above.stems.clear();
    above.frames.clear();
    fs::path at = here;
    for (int n = 0; n < farthest_above && !beside.camera && at.has_relative_path(); ++n) {
        const bool goes_on = is_part_by_name(at);
        above.below = small_letters(at.filename().string());
        at = at.parent_path();
        above.needs_camera = !goes_on;
        look_in(at, above, false, beside);
        if (!goes_on) break;
    }
    // A scale in the pictures' own file, or in one named as the picture, goes before the camera's file.
    const fs::path& scale_file = beside.codes_per_metre.file;
    const bool has_own_scale =
        !scale_file.empty() && (scale_file == pictures.own_file ||
                                small_letters(scale_file.stem().string()) == small_letters(pictures.stem));
    if (!beside.camera) return beside;
    if (beside.camera->codes_per_metre > 0 && !has_own_scale)
        beside.codes_per_metre = {beside.camera->codes_per_metre, beside.file};
    Intrinsics& camera = beside.camera->intrinsics;
    camera = trusted_intrinsics(camera, pictures.width, pictures.height, beside.doubt);
    if (auto guess = guess_shape(camera, pictures.width, pictures.height); !guess.empty())
        beside.guesses.push_back("the camera is that of " + printable(beside.file.filename().string()) + ' ' +
                                 guess);
    return beside;
}

Intrinsics in_pixels(Intrinsics camera, int width, int height, std::string& doubt) {
    if (camera.is_ndc) {
        const double half = 0.5 * std::min(width, height);
        doubt = "whose numbers are of PyTorch3D's normalised coordinates";
        return {half * camera.fx, half * camera.fy, 0.5 * (width - 1) - half * camera.cx.value_or(0),
                0.5 * (height - 1) - half * camera.cy.value_or(0)};
    }
    if (camera.width > 0 && camera.height > 0) width = camera.width, height = camera.height;
    // As pixels, a quarter of a side sees 127 degrees.
    constexpr double least_share = 0.2, longest_share = 3, longest_beside_shares = 10, widest = 0.25;
    const auto is_off = [](double at, int side) {
        return std::abs(at) < 1 && off_middle(at, side) > far_off;
    };
    const auto is_share = [&](const std::optional<double>& at, int side) {
        return at && is_off(*at, side) && std::abs(*at - 0.5) <= 0.25;
    };
    const bool of_x = is_share(camera.cx, width), of_y = is_share(camera.cy, height);
    const double longest = of_x && of_y ? longest_beside_shares : longest_share;
    const auto [shorter, longer] = std::minmax({camera.fx, camera.fy});
    const bool of_f = shorter > least_share && longer < std::min(longest, widest * std::min(width, height));
    if (of_f) {
        // One share for both is of the longer side, as pixels are square.
        camera.fx *= shorter == longer ? std::max(width, height) : width;
        camera.fy *= shorter == longer ? std::max(width, height) : height;
    }
    if (of_x) camera.cx = *camera.cx * width - 0.5;
    if (of_y) camera.cy = *camera.cy * height - 0.5;
    if (of_f || of_x || of_y) {
        camera.width = width, camera.height = height;
        doubt = std::string(of_f && of_x && of_y ? "" : "some of ") + "whose numbers are shares of a picture";
    }
    // Zeros, or -1 to 1 from edge to edge.
    if (camera.cx && camera.cy && is_off(*camera.cx, width) && is_off(*camera.cy, height)) {
        camera.cx.reset(), camera.cy.reset();
        doubt += (doubt.empty() ? "whose" : ", and whose") +
                 std::string(" principal point is in a corner, so the middle is taken");
    }
    return camera;
}

Intrinsics trusted_intrinsics(Intrinsics camera, int width, int height, std::string& doubt) {
    if (width <= 0 || height <= 0) return camera;
    camera = in_pixels(camera, width, height, doubt);
    if (!doubt.empty() || !camera.cx || !camera.cy) return camera;
    const double cx = *camera.cx, cy = *camera.cy;
    constexpr double near_middle = 0.1, most_apart = 0.1;
    const bool says_size = camera.width > 0 && camera.height > 0;
    if (says_size && (camera.width != width || camera.height != height)) {
        const bool is_theirs =
            off_middle(cx, width) <= near_middle && off_middle(cy, height) <= near_middle &&
            (off_middle(cx, camera.width) > far_off || off_middle(cy, camera.height) > far_off);
        if (!is_theirs) return camera;
        doubt = "which says that its pictures have " + size_text(camera.width, camera.height) +
                " pixels, but whose principal point is the middle of these";
        camera.width = camera.height = 0;
    } else if (!says_size && (off_middle(cx, width) > far_off || off_middle(cy, height) > far_off)) {
        const double across = (2 * cx + 1) / width, down = (2 * cy + 1) / height;
        if (!(across > 0.01 && down > 0.01) || std::abs(across - down) > most_apart * across) return camera;
        const double times = 0.5 * (across + down);
        camera.width = static_cast<int>(std::lround(std::min(times * width, 1e6)));
        camera.height = static_cast<int>(std::lround(std::min(times * height, 1e6)));
        doubt =
            "whose principal point is the middle of pictures " + short_number(times, 3) + " times as large";
        if (const auto usual = usual_size(times * width, width, height)) {
            camera.width = usual->first;
            camera.height = usual->second;
            doubt += ", which is taken for " + size_text(usual->first, usual->second);
        }
    }
    return camera;
}

Result<std::vector<Camera>> read_frame_cameras(const PictureFiles& files, int width, int height) {
    constexpr double farthest = 1e6;                 // pixels; more is a mistake
    constexpr std::size_t most_frames = 10'000'000;  // each has its camera in memory
    if (files.count() > most_frames)
        return input_error(files.file(0).string() + ": is the camera of " + std::to_string(files.count()) +
                           " frames: at most " + std::to_string(most_frames) + " can have cameras");
    std::vector<Camera> cameras;
    for (std::size_t frame = 0; frame < files.count(); ++frame) {
        const fs::path& path = files.file(frame);
        if (frame > 0 && path == files.file(frame - 1)) {
            cameras.push_back(cameras.back());
            continue;
        }
        if (stop_requested()) return interrupted_error();
        const std::string of_frame = " (camera, frame " + std::to_string(frame) + ")";
        const auto file = read_camera_file(path);
        if (!file) return Error{file.error().kind, file.error().message + of_frame};
        std::string ignored;
        const Camera camera =
            scaled_camera(in_pixels(file->intrinsics, width, height, ignored), width, height);
        if (!(std::abs(camera.cx) < farthest) || !(std::abs(camera.cy) < farthest))
            return input_error(path.string() + of_frame +
                               ": its cx and cy must be pixels, nearer than 1e6 to the picture");
        cameras.push_back(camera);
    }
    return cameras;
}

Camera median_camera(std::span<const Camera> cameras) {
    Camera median;
    for (double Camera::*const term : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy}) {
        std::vector<double> all;
        for (const Camera& camera : cameras) all.push_back(camera.*term);
        median.*term = sorted_element(all, (all.size() - 1) / 2);
    }
    return median;
}

PixelShift shift_between(const Camera& clip, const Camera& stored, int width, int height) {
    // The shift is linear along rows and columns, so the largest is at an edge.
    PixelShift shift;
    const auto along = [&](double clip_f, double clip_c, double stored_f, double stored_c, int size) {
        double largest = 0;
        for (const double edge : {0.0, size - 1.0}) {
            const double there = stored_f * ((edge - clip_c) / clip_f) + stored_c;
            largest = std::max(largest, std::abs(there - edge));
            shift.is_inside &= there >= -0.5 && there < size - 0.5;
        }
        return largest;
    };
    shift.columns = along(clip.fx, clip.cx, stored.fx, stored.cx, width);
    shift.rows = along(clip.fy, clip.cy, stored.fy, stored.cy, height);
    return shift;
}

Result<std::optional<GuessedCameras>> guess_cameras(const fs::path& folder, const std::string& depth_pattern,
                                                    int width, int height) {
    const std::vector<PictureGroup> groups = camera_groups(folder);
    if (groups.empty()) return std::optional<GuessedCameras>();
    const auto fits = [&](const PictureGroup& group) {
        const auto file = read_camera_file(group.first);
        return file && file->intrinsics.width == width && file->intrinsics.height == height;
    };
    const auto fitting = std::ranges::find_if(groups, fits);
    FolderSource source;
    source.depth = depth_pattern;
    source.cameras = (fitting == groups.end() ? groups.front() : *fitting).pattern;
    TRY_ASSIGN(const auto frames, depth_files(folder, source));
    TRY_ASSIGN(const auto files, camera_files(folder, source, frames));
    TRY_ASSIGN(const auto cameras, read_frame_cameras(files, width, height));
    return std::optional(GuessedCameras{source.cameras, median_camera(cameras)});
}

std::optional<fs::path> colour_movement_in(const fs::path& folder) {
    for (const fs::path& file : texts_of_colour(folder))
        if (has_word(file.stem().string(), {"depth", "extrinsic"}) && movement_of(file)) return file;
    return {};
}

std::optional<VispColourCamera> visp_colour_camera(const fs::path& movement, const fs::path& camera_of_depth,
                                                   int width, int height) {
    const std::string stem = camera_of_depth.stem().string(), of_depth = "_depth";
    const auto to_depth = movement_of(movement);
    if (movement.filename() != "depth_M_color.txt" || !stem.ends_with(of_depth) || !to_depth) return {};
    fs::path file = camera_of_depth;
    file.replace_filename(stem.substr(0, stem.size() - of_depth.size()) +
                          camera_of_depth.extension().string());
    auto read = read_camera_file(file);
    if (!read || read->has_distortion) return {};
    return VispColourCamera{{scaled_camera(sized(read->intrinsics, width, height), width, height),
                             width,
                             height,
                             {},
                             to_depth->inverse()},
                            file};
}

std::optional<fs::path> camera_of_colour_in(const fs::path& folder, const Scene& scene, int width,
                                            int height) {
    for (const fs::path& file : texts_of_colour(folder)) {
        if (has_word(file.stem().string(), {"depth"})) continue;
        auto read = read_camera_file(file);
        if (!read) continue;
        const Intrinsics of_colour = sized(read->intrinsics, width, height);
        if (differs(scaled_camera(of_colour, scene.width, scene.height), scene.camera, scene)) return file;
    }
    return {};
}

}  // namespace touchable
