#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "engine/media/bare_picture.hpp"
#include "engine/media/clip.hpp"
#include "engine/media/depthkit_clip.hpp"
#include "engine/media/gdepth_image.hpp"
#include "engine/media/image_folder.hpp"
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

/// What a file begins with.
enum class Begin { matroska, jpeg, png, other };

Begin begin_of(const std::filesystem::path& file) {
    std::array<char, 8> first{};
    std::ifstream in(file, std::ios::binary);
    in.read(first.data(), first.size());
    const std::string_view magic(first.data(), static_cast<std::size_t>(in.gcount()));
    if (magic.starts_with("\xff\xd8\xff")) return Begin::jpeg;
    if (magic == "\x89PNG\r\n\x1a\n") return Begin::png;
    return magic.starts_with("\x1a\x45\xdf\xa3") || magic.size() < 4 ? Begin::matroska : Begin::other;
}

/// Whatever the file is by its first bytes, its name and what lies beside it.
Result<std::unique_ptr<ClipReader>> open_file(const std::filesystem::path& file,
                                              const std::optional<Scene>& scene) {
    switch (begin_of(file)) {
        case Begin::matroska:
            return open_matroska_clip(file, scene);
        case Begin::jpeg:
            return open_gdepth_image(file, scene);
        case Begin::png:
            return scene ? open_bare_picture(file, *scene) : no_description(file);
        case Begin::other:
            break;
    }
    if (const auto metadata = depthkit_metadata_of(file)) return open_depthkit_clip(file, *metadata, scene);
    return input_error(file.string() +
                       ": is not a Matroska file, nor a PNG or JPEG, nor a Depthkit video with " +
                       depthkit_metadata_name(file).string() + " beside it");
}

/// A single depth picture, of a camera that somebody names.
Result<std::unique_ptr<ClipReader>> open_picture(const std::filesystem::path& file,
                                                 const PictureCamera& camera) {
    const Begin begin = begin_of(file);
    if (begin != Begin::png && begin != Begin::jpeg)
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

/// The way that is right for every format: reading up to there.
Result<void> ClipReader::seek(std::int64_t frame) {
    if (frame < 0) return usage_error("frame " + std::to_string(frame) + " is before the clip's first, 0");
    if (auto back = rewind(); !back.ok()) return back;
    for (std::int64_t number = 0; number < frame; ++number) {
        const auto passed = next();
        if (!passed.ok()) return passed.error();
        if (!*passed)
            return usage_error("the clip has no frame " + std::to_string(frame) + ": its last is " +
                               std::to_string(number - 1));
    }
    return {};
}

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
