// SPDX-License-Identifier: Apache-2.0
// Texts of MPEG-4 scenes, and the pictures or videos that they name, as clips (SceneTextClip).

#include "engine/formats/formats_read.hpp"

#include <algorithm>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/mpeg4/clip_scene.hpp"

namespace touchable {
namespace {

using PlaneTexture = mpeg4::ClipNodes::Texture;

constexpr std::size_t longest_scene_text = std::size_t{1} << 20;

/// Editors of some systems begin a text in UTF-8 with its byte order mark.
std::string_view without_mark(std::string_view text) {
    constexpr std::string_view mark = "\xef\xbb\xbf";
    return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

/// Opens a scene's text and the planes that it names; errors begin with the file's name.
class SceneTextClip {
public:
    explicit SceneTextClip(const Candidate& file) : file_(file), folder_(file.home()) {}

    Opened open() {
        TRY(read_nodes());
        TRY_ASSIGN(auto described, describe());
        if (described.scene.name.empty()) described.scene.name = source_.path().stem().string();
        if (file_.scene) {
            SceneDescription other = *file_.scene;
            other.scene.folder = described.scene.folder;
            other.scene.video = described.scene.video;
            described = std::move(other);
        }
        const auto open_planes = described.scene.video ? open_videos : open_image_folder;
        auto reader = open_planes(
            folder_, {std::move(described), {}, {notes_.begin(), notes_.end()}, pictures_, video_},
            file_.wanted.colour, DepthAlignment::automatic);
        if (reader) (*reader)->add_input(source_.path());
        return reader;
    }

private:
    Error refuse(const std::string& what) const { return input_error(source_.string() + ": " + what); }

    Result<void> read_nodes() {
        TRY_ASSIGN(const auto bytes, bytes_of_file(source_));
        if (bytes->size() > longest_scene_text)
            return refuse("is no MPEG-4 scene: its text has more than 1 MiB");
        const std::string text = first_bytes(*bytes, longest_scene_text);
        TRY_ASSIGN(const auto scene, error_at(source_.string(), mpeg4::parse_scene_text(without_mark(text))));
        return error_at(source_.string() + ": its MPEG-4 scene is no touchable clip",
                        assign(nodes_, mpeg4::clip_nodes_of(scene)));
    }

    /// The file of a texture, in the scene's folder or below.
    Result<std::string> file_of(const PlaneTexture& texture, PlaneRole role) const {
        const std::string of_plane = "the texture of " + std::string(role_name(role));
        if (texture.url.object > 0)
            return refuse(of_plane + " is object " + std::to_string(texture.url.object) +
                          " of an MP4 file: open that file, or name a picture beside this text");
        const std::filesystem::path named = std::filesystem::path(texture.url.file).lexically_normal();
        if (named.empty() || named.is_absolute() || *named.begin() == ".." ||
            texture.url.file.find("://") != std::string::npos)
            return refuse(of_plane + " is " + in_quotes(texture.url.file) +
                          ": must be a file beside this text or in a folder below");
        return named.string();
    }

    Result<SceneDescription> with_pictures(FolderSource pictures) {
        TRY_ASSIGN(const auto first, pictures_->look(folder_ / pictures.depth));
        const Image& image = first->image;
        TRY_ASSIGN(auto described,
                   error_at(source_.string(), mpeg4::described_by_pictures(nodes_, image.width, image.height,
                                                                           first->bits, notes_)));
        pictures.haptic_may_be_lossy = true;  // the paper's own example is lossy
        described.scene.folder = std::move(pictures);
        return described;
    }

    Result<SceneDescription> with_videos(const FolderSource& files) {
        TRY_ASSIGN(video_, VideoFile::open(SourceFile(folder_ / files.depth), PlaneRole::depth));
        TRY_ASSIGN(const auto first, video_->next());
        if (!first) return refuse(files.depth + " has no pictures");
        constexpr int bits = 8;
        TRY_ASSIGN(auto described, error_at(source_.string(),
                                            mpeg4::described_by(nodes_, first->width, first->height, bits)));
        TRY(video_->seek(0));
        VideoSource source{files.depth, files.colour};
        source.haptic = files.haptic;
        source.height = files.height;
        described.scene.video = std::move(source);
        return described;
    }

    Result<SceneDescription> describe() {
        FolderSource files;
        TRY_ASSIGN(files.depth, file_of(nodes_.depth, PlaneRole::depth));
        for (const auto& [texture, role] : {std::pair{&nodes_.colour, PlaneRole::colour},
                                            {&nodes_.haptic, PlaneRole::haptic},
                                            {&nodes_.height, PlaneRole::height}})
            if (*texture) TRY(assign(pattern_of(files, role), file_of(**texture, role)));
        for (const auto& [texture, plane] : {std::pair{&nodes_.haptic, "haptic"}, {&nodes_.height, "height"}})
            if (*texture && (*texture)->is_movie)
                return refuse(std::string("the texture of ") + plane +
                              " is a MovieTexture in a file of its own, which is not read: must be an "
                              "ImageTexture, or a track of an MP4 file");
        const bool is_movie = nodes_.depth.is_movie;
        if (nodes_.colour && nodes_.colour->is_movie != is_movie)
            return refuse("depth and colour must both be an ImageTexture, or both a MovieTexture");
        for (const PlaneRole role : all_roles)
            if (const auto& name = pattern_of(files, role); !name.empty() && !is_still(name))
                return refuse(in_quotes(name) +
                              " has a % or * in its name, which stand for numbers: rename it");
        return is_movie ? with_videos(files) : with_pictures(std::move(files));
    }

    const Candidate& file_;
    const SourceFile& source_ = file_.source;
    std::filesystem::path folder_;
    mpeg4::ClipNodes nodes_;
    std::shared_ptr<ReadPictures> pictures_ = std::make_shared<ReadPictures>();
    std::shared_ptr<VideoFile> video_;
    std::vector<std::string> notes_;
};

}  // namespace

bool is_scene_text(const Candidate& file) {
    constexpr std::size_t looked_at = 4096;
    constexpr std::array<std::string_view, 6> words{"PROTO", "EXTERNPROTO",  "DEF",
                                                    "Group", "OrderedGroup", "Shape"};
    const std::string bytes = first_bytes(file.source, looked_at);
    const std::string_view begin = without_mark(bytes);
    std::size_t at = 0;
    while (at < begin.size() && (begin[at] == '#' || begin[at] == ' ' || begin[at] == '\t' ||
                                 begin[at] == '\r' || begin[at] == '\n'))
        at = begin[at] == '#' ? std::min(begin.find('\n', at), begin.size()) : at + 1;
    const std::string_view text = begin.substr(at);
    return std::any_of(words.begin(), words.end(), [text](std::string_view word) {
        return text.starts_with(word) && text.size() > word.size() &&
               std::string_view(" \t\r\n{").find(text[word.size()]) != std::string_view::npos;
    });
}

Opened open_scene_text(const Candidate& file) {
    return SceneTextClip(file).open();
}

}  // namespace touchable
