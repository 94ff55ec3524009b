#include "engine/import/guess/camera_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "engine/given_file.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;
using checked_json::Json;

constexpr std::size_t longest_file = 1 << 20;

bool is_side(double pixels) {
    return pixels >= 1 && pixels <= 16384;
}

/// All numbers of a text, whatever stands between them.
std::vector<double> numbers_in(std::string_view text) {
    std::vector<double> numbers;
    const char *at = text.data(), *const end = at + text.size();
    while (at < end) {
        const bool begins = (*at >= '0' && *at <= '9') || *at == '-' || *at == '.';
        const bool in_word = at > text.data() && std::isalnum(static_cast<unsigned char>(at[-1])) != 0;
        double number = 0;
        const auto [after, failure] = std::from_chars(at, end, number);
        if (!begins || in_word || failure != std::errc()) {
            ++at;
            continue;
        }
        numbers.push_back(number);
        at = after;
    }
    return numbers;
}

/// Of 3x3 numbers by rows or by columns, or 4x4 by rows.
std::optional<Intrinsics> from_matrix(const std::vector<double>& m) {
    if (m.size() == 16) return from_matrix({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
    if (m.size() != 9) return {};
    const bool by_rows = m[2] != 0 || m[5] != 0;
    // Other matrices, a rotation or a pose, are no camera's. A pixel's skew moves no place by more than half.
    constexpr double most_skew = 1, least_focal = 1;
    const bool last_is_unit = (by_rows ? m[6] == 0 && m[7] == 0 : m[2] == 0 && m[5] == 0) && m[8] == 1;
    const bool is_camera = last_is_unit && std::abs(m[1]) <= most_skew && std::abs(m[3]) <= most_skew &&
                           m[0] > least_focal && std::abs(m[4]) > least_focal;
    if (!is_camera) return {};
    return Intrinsics{m[0], m[4], by_rows ? m[2] : m[6], by_rows ? m[5] : m[7]};
}

/// Whether the principal point is in the picture, or no farther beside it than half of it.
bool is_near_picture(const Intrinsics& camera) {
    const auto fits = [](const std::optional<double>& at, int side) {
        return !at || side <= 0 || (*at > -0.5 * side && *at < 1.5 * side);
    };
    return fits(camera.cx, camera.width) && fits(camera.cy, camera.height);
}

void flatten(const Json& value, std::vector<double>& numbers) {
    if (value.is_number()) numbers.push_back(value.get<double>());
    if (value.is_array() && numbers.size() <= 16)
        for (const Json& each : value) flatten(each, numbers);
}

double number_of(const Json& object, std::initializer_list<const char*> names) {
    for (const char* name : names)
        if (object.contains(name) && object[name].is_number()) return object[name].get<double>();
    return 0;
}

/// The first object, outermost first, that has focal lengths or a matrix.
std::optional<Intrinsics> in_object(const Json& json, int depth = 0) {
    if (!json.is_object() || depth > 4) return {};
    std::optional<Intrinsics> found;
    const auto centre = [&](std::initializer_list<const char*> names) {
        const double at = number_of(json, names);
        return at == 0 ? std::optional<double>() : std::optional(at);  // the middle where it is not said
    };
    const auto cx = centre({"ppx", "cx"}), cy = centre({"ppy", "cy"});
    const double fx = number_of(json, {"fx", "focal_length_x"}),
                 fy = number_of(json, {"fy", "focal_length_y"});
    if (fx > 0) found = Intrinsics{fx, fy > 0 ? fy : fx, cx, cy};
    for (const char* name : {"intrinsic_matrix", "K", "k", "intrinsicMatrix", "camera_matrix"}) {
        if (found || !json.contains(name)) continue;
        std::vector<double> numbers;
        const Json& matrix = json[name];
        flatten(matrix.is_object() && matrix.contains("data") ? matrix["data"] : matrix, numbers);
        found = from_matrix(numbers);
    }
    if (found) {
        const double width = number_of(json, {"width", "w", "image_width"}),
                     height = number_of(json, {"height", "h", "image_height"});
        if (is_side(width) && is_side(height)) {
            found->width = static_cast<int>(width);
            found->height = static_cast<int>(height);
        }
        return found;
    }
    for (const char* first : {"depth", "depth_intrinsics", "intrinsics", "intrinsic", "camera"})
        if (json.contains(first))
            if (const auto inner = in_object(json[first], depth + 1)) return inner;
    for (const auto& [name, value] : json.items())
        if (const auto inner = in_object(value, depth + 1)) return inner;
    return {};
}

/// The numbers after a word that begins a line, up to the next word.
std::vector<double> numbers_after(const std::string& text, const std::string& word) {
    std::istringstream lines(text);
    std::string found;
    bool is_inside = false;
    for (std::string line; std::getline(lines, line);) {
        const auto begin = line.find_first_not_of(" \t");
        if (begin == std::string::npos) continue;
        const bool is_word = std::isalpha(static_cast<unsigned char>(line[begin])) != 0;
        if (line.compare(begin, word.size(), word) == 0) {
            is_inside = true;
            found += line.substr(begin + word.size()) + '\n';
        } else if (is_inside && is_word && line.compare(begin, 5, "data:") == 0) {
            found = line.substr(begin + 5) + '\n';
        } else if (is_inside && is_word && line.compare(begin, 4, "rows") != 0 &&
                   line.compare(begin, 3, "dt:") != 0 && line.compare(begin, 4, "cols") != 0) {
            break;
        } else if (is_inside && !is_word) {
            found += line + '\n';
        }
    }
    return numbers_in(found);
}

std::optional<CameraFile> from_yaml(const std::string& text) {
    for (const char* word : {"camera_matrix:", "K:", "k:"})
        if (auto found = from_matrix(numbers_after(text, word))) {
            const auto width = numbers_after(text, "image_width:"),
                       height = numbers_after(text, "image_height:");
            if (width.size() == 1 && height.size() == 1 && is_side(width[0]) && is_side(height[0])) {
                found->width = static_cast<int>(width[0]);
                found->height = static_cast<int>(height[0]);
            }
            return CameraFile{*found};
        }
    return {};
}

/// Middlebury: cam0=[f 0 cx; 0 f cy; 0 0 1], doffs=, baseline= (mm), width=, height=.
std::optional<CameraFile> from_calib(const std::string& text) {
    auto found = from_matrix(numbers_after(text, "cam0="));
    const auto baseline = numbers_after(text, "baseline="), offset = numbers_after(text, "doffs=");
    if (!found || baseline.size() != 1) return {};
    const auto width = numbers_after(text, "width="), height = numbers_after(text, "height=");
    if (width.size() == 1 && height.size() == 1 && is_side(width[0]) && is_side(height[0])) {
        found->width = static_cast<int>(width[0]);
        found->height = static_cast<int>(height[0]);
    }
    return CameraFile{*found, baseline[0] / 1000, offset.size() == 1 ? offset[0] : 0};
}

/// COLMAP: id model width height parameters; its pixel centres are at a half.
std::optional<CameraFile> from_colmap(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        long id = 0;
        std::string model;
        Intrinsics found;
        if (!(words >> id >> model >> found.width >> found.height)) continue;
        if (!is_side(found.width) || !is_side(found.height)) continue;
        std::vector<double> p;
        for (double number = 0; words >> number;) p.push_back(number);
        const bool one_focal = model.starts_with("SIMPLE_") || model == "RADIAL";
        if (p.size() < (one_focal ? 3U : 4U) ||
            model.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_") != std::string::npos)
            continue;
        found.fx = p[0];
        found.fy = one_focal ? p[0] : p[1];
        found.cx = p[one_focal ? 1 : 2] - 0.5;
        found.cy = p[one_focal ? 2 : 3] - 0.5;
        return CameraFile{found};
    }
    return {};
}

/// ARKitScenes' .pincam: width height fx fy cx cy.
std::optional<Intrinsics> from_pincam(const std::vector<double>& numbers) {
    if (numbers.size() != 6 || !is_side(numbers[0]) || !is_side(numbers[1])) return {};
    return Intrinsics{numbers[2],
                      numbers[3],
                      numbers[4],
                      numbers[5],
                      static_cast<int>(numbers[0]),
                      static_cast<int>(numbers[1])};
}

std::optional<CameraFile> parsed(const std::string& text) {
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin != std::string::npos && text[begin] == '{') {
        const auto found = intrinsics_in_json(text);
        return found ? std::optional(CameraFile{*found}) : std::nullopt;
    }
    if (auto found = from_calib(text)) return found;
    if (auto found = from_yaml(text)) return found;
    if (auto found = from_colmap(text)) return found;
    if (text.find_first_not_of("0123456789+-.eE, \t\r\n[];") == std::string::npos) {
        if (const auto found = from_matrix(numbers_in(text))) return CameraFile{*found};
        if (const auto found = from_pincam(numbers_in(text))) return CameraFile{*found};
    }
    return {};
}

}  // namespace

std::optional<Intrinsics> intrinsics_in_json(const std::string& text) {
    try {
        return in_object(checked_json::parse(text));
    } catch (const checked_json::Refusal&) {
    } catch (const Json::exception&) {
    }
    return {};
}

namespace {

/// Open3D's word for how many codes a metre has.
double codes_per_metre_in_json(const std::string& text) {
    try {
        return std::max(0.0, number_of(checked_json::parse(text), {"depth_scale"}));
    } catch (const checked_json::Refusal&) {
    } catch (const Json::exception&) {
    }
    return 0;
}

}  // namespace

Result<CameraFile> read_camera_file(const fs::path& file) {
    auto given = read_given_file(file, file.string(), "a camera's file", longest_file);
    if (!given) return given.error();
    std::string& text = *given;
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // a mark that says UTF-8
    const auto found = parsed(text);
    const auto is_length = [](double value) { return std::isfinite(value) && value > 0 && value < 1e6; };
    if (found && !is_near_picture(found->intrinsics))
        return input_error(file.string() +
                           ": its principal point is far beside its picture: must be cx, cy in "
                           "pixels, in the picture or near it");
    if (found && is_length(found->intrinsics.fx) && is_length(std::abs(found->intrinsics.fy))) {
        CameraFile camera = *found;
        camera.codes_per_metre = codes_per_metre_in_json(text);
        camera.intrinsics.fy = std::abs(camera.intrinsics.fy);
        return camera;
    }
    return input_error(
        file.string() +
        ": has no camera that could be read: must have fx, fy, cx, cy (JSON), a matrix K, "
        "intrinsic_matrix or camera_matrix (JSON, YAML), 3x3 numbers, or be COLMAP's cameras.txt, "
        "Middlebury's calib.txt or ARKitScenes' .pincam (width height fx fy cx cy)");
}

std::optional<fs::path> camera_file_in(const fs::path& folder) {
    std::error_code ignored;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        std::string name = entry.path().filename().string();
        std::transform(name.begin(), name.end(), name.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        const bool is_text = name.ends_with(".json") || name.ends_with(".yaml") || name.ends_with(".yml") ||
                             name.ends_with(".txt");
        const bool is_named = name.find("camera") != std::string::npos ||
                              name.find("intrinsic") != std::string::npos ||
                              name.find("calib") != std::string::npos || name == "metadata.json";
        if (is_text && is_named) files.push_back(entry.path());
        if (files.size() > 100) break;
    }
    // Of several, that of depth: of those the name that sorts first.
    std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
        const auto is_of_depth = [](const fs::path& file) {
            return file.filename().string().find("depth") != std::string::npos;
        };
        return is_of_depth(a) != is_of_depth(b) ? is_of_depth(a) : a < b;
    });
    for (const fs::path& file : files)
        if (read_camera_file(file).ok()) return file;
    return {};
}

}  // namespace touchable
