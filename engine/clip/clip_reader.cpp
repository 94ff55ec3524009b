#include "engine/clip/clip_reader.hpp"

#include <string>

#include "engine/base/try.hpp"

namespace touchable {

std::vector<Remark> remarks_of(const ClipReader& clip) {
    std::vector<Remark> remarks = clip.scene().remarks;
    for (const std::string& note : clip.notes()) remarks.push_back({note});
    return remarks;
}

std::vector<std::string> clip_notes(const ClipReader& clip) {
    std::vector<std::string> told;
    for (const Remark& remark : remarks_of(clip)) told.push_back(remark_in_words(remark));
    return told;
}

const std::filesystem::path& sound_file_of(const ClipReader& clip) {
    static const std::filesystem::path none;
    return clip.inputs().empty() || clip.scene().folder ? none : clip.inputs().front();
}

/// The way that is right for every format: reading up to there.
Result<void> ClipReader::seek(std::int64_t frame) {
    if (frame < 0) return usage_error("frame " + std::to_string(frame) + " is before the clip's first, 0");
    if (auto back = rewind(); !back.ok()) return back;
    for (std::int64_t number = 0; number < frame; ++number) {
        TRY_ASSIGN(const auto passed, next());
        if (!passed)
            return usage_error("the clip has no frame " + std::to_string(frame) + ": its last is " +
                               std::to_string(number - 1));
    }
    return {};
}

}  // namespace touchable
