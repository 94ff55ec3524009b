#include "engine/import/open_clip.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <system_error>

#include "engine/import/bare_picture.hpp"
#include "engine/import/depthkit_clip.hpp"
#include "engine/import/gdepth_image.hpp"
#include "engine/import/image_folder.hpp"
#include "engine/media/matroska_reader.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {
namespace {

constexpr const char* own_scene_file = "scene.json";  // of a folder that describes itself

bool is_scene_file(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return extension == ".json";
}

using Opened = Result<std::unique_ptr<ClipReader>>;

/// A file that may be a clip.
struct Candidate {
    const std::filesystem::path& file;
    const std::string begin;            ///< its first bytes
    const std::optional<Scene>& scene;  ///< to replace its own
};

bool is_jpeg(const Candidate& candidate) {
    return candidate.begin.starts_with("\xff\xd8\xff");
}
bool is_png(const Candidate& candidate) {
    return candidate.begin == "\x89PNG\r\n\x1a\n";
}
/// Also one that is cut to nearly nothing, of which its reader tells best what is wrong.
bool is_matroska(const Candidate& candidate) {
    return candidate.begin.starts_with("\x1a\x45\xdf\xa3") || candidate.begin.size() < 4;
}
bool is_depthkit(const Candidate& candidate) {
    return depthkit_metadata_of(candidate.file).has_value();
}

Opened open_described_png(const Candidate& candidate) {
    return candidate.scene ? open_bare_picture(candidate.file, *candidate.scene)
                           : Opened(no_description(candidate.file));
}

/// The first that recognises a file opens it.
struct Format {
    bool (*recognises)(const Candidate&);
    Opened (*open)(const Candidate&);
};
constexpr Format formats[] = {
    {is_matroska, [](const Candidate& c) { return open_matroska_clip(c.file, c.scene); }},
    {is_jpeg, [](const Candidate& c) { return open_gdepth_image(c.file, c.scene); }},
    {is_png, open_described_png},
    {is_depthkit,
     [](const Candidate& c) { return open_depthkit_clip(c.file, *depthkit_metadata_of(c.file), c.scene); }},
};

Candidate candidate_of(const std::filesystem::path& file, const std::optional<Scene>& scene) {
    std::array<char, 8> first{};
    std::ifstream in(file, std::ios::binary);
    in.read(first.data(), first.size());
    return {file, std::string(first.data(), static_cast<std::size_t>(in.gcount())), scene};
}

Opened open_file(const std::filesystem::path& file, const std::optional<Scene>& scene) {
    const Candidate candidate = candidate_of(file, scene);
    for (const Format& format : formats)
        if (format.recognises(candidate)) return format.open(candidate);
    return input_error(file.string() +
                       ": is not a Matroska file, nor a PNG or JPEG, nor a Depthkit video with " +
                       depthkit_metadata_name(file).string() + " beside it");
}

/// A single depth picture, of a camera that somebody names.
Result<std::unique_ptr<ClipReader>> open_picture(const std::filesystem::path& file,
                                                 const PictureCamera& camera) {
    const std::optional<Scene> none;
    const Candidate candidate = candidate_of(file, none);
    if (!is_png(candidate) && !is_jpeg(candidate))
        return usage_error(file.string() +
                           ": is no PNG or JPEG, so --intrinsics says nothing of it: leave it out");
    auto scene = bare_picture_scene(file, camera);
    if (!scene) return scene.error();
    return open_bare_picture(file, std::move(*scene));
}

Result<std::unique_ptr<ClipReader>> open_described(const std::filesystem::path& path,
                                                   const std::filesystem::path& scene_file) {
    auto scene = read_scene_file(scene_file);
    if (!scene) return scene.error();
    std::error_code ignored;
    const bool is_file = std::filesystem::is_regular_file(path, ignored);
    auto reader = is_file ? open_file(path, *scene) : open_image_folder(path, *scene);
    if (reader) (*reader)->add_input(scene_file);
    return reader;
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_clip(const std::filesystem::path& path,
                                              const std::optional<std::filesystem::path>& scene_file,
                                              const std::optional<PictureCamera>& camera) {
    std::error_code failure;
    const auto status = std::filesystem::status(path, failure);
    if (!std::filesystem::exists(status)) return input_error(path.string() + ": does not exist");
    const bool is_folder = std::filesystem::is_directory(status);
    if (!is_folder && !std::filesystem::is_regular_file(status))
        return input_error(path.string() + ": is neither a file nor a folder");
    if (camera) {
        if (scene_file)
            return usage_error(path.string() + ": has --scene and --intrinsics: must be one of them");
        return open_picture(path, *camera);
    }
    if (is_folder && !scene_file) {
        const auto own = path / own_scene_file;
        if (std::filesystem::is_regular_file(own, failure)) return open_clip(own);
        return input_error(path.string() + ": is a folder without a " + own_scene_file +
                           ": describe its images with --scene FILE");
    }
    if (!is_folder && is_scene_file(path)) {
        if (scene_file) return usage_error(path.string() + ": is a scene file itself: leave --scene out");
        return open_described(path.parent_path(), path);
    }
    if (!scene_file) return open_file(path, std::nullopt);
    return open_described(path, *scene_file);
}

}  // namespace touchable
