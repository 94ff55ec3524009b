#include "capi/open_clips.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "capi/clip_words.hpp"

namespace touchable::capi {
namespace {

std::vector<std::string> notes_of(const ClipReader& reader) {
    std::vector<std::string> notes;
    for (const Remark& remark : remarks_of(reader)) notes.push_back(note_with_members(remark));
    return notes;
}

/// Also where the program goes to another folder.
std::vector<std::filesystem::path> absolute(const std::vector<std::filesystem::path>& files) {
    std::vector<std::filesystem::path> whole;
    for (const std::filesystem::path& file : files) {
        std::error_code failure;
        whole.push_back(std::filesystem::absolute(file, failure));
    }
    return whole;
}

}  // namespace

HandleTable<ClipObject>& clips() {
    static auto& table = *new HandleTable<ClipObject>(4, Forked::refused);
    return table;
}

ClipObject::ClipObject(std::unique_ptr<ClipReader> opened)
    : described(opened->described()),
      tracks(opened->tracks()),
      notes(notes_of(*opened)),
      frames(opened->frame_count()),
      inputs(absolute(opened->inputs())),
      reader(std::move(opened)) {}

bool ClipObject::has(const char* role) const {
    return std::any_of(tracks.begin(), tracks.end(),
                       [&](const TrackInfo& track) { return track.role == role; });
}

bool is_read_by_an_open_clip(const std::filesystem::path& path) {
    bool is_read = false;
    clips().for_each([&](const ClipObject& clip) {
        for (const std::filesystem::path& input : clip.inputs) {
            std::error_code absent;
            is_read = is_read || std::filesystem::equivalent(input, path, absent) ||
                      std::filesystem::equivalent(input.parent_path(), path, absent);
        }
    });
    return is_read;
}

}  // namespace touchable::capi
