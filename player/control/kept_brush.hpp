#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/content/materials/material_brush.hpp"
#include "engine/content/materials/segment_store.hpp"
#include "engine/result.hpp"

namespace touchable {

/// Files of the brush of one clip.
struct BrushFiles {
    std::filesystem::path clip;
    std::optional<std::filesystem::path> segments{};  ///< that a person gave, which is there
    std::filesystem::path history_folder{};           ///< empty: no history is kept

    /// What segments are like, saved: the one that was given, or CLIP.materials.json beside the clip.
    std::filesystem::path saved() const;
    /// All that was done, from one run of the program to the next: a file for each clip by its whole name.
    /// Empty where none is kept.
    std::filesystem::path history() const;
};

/// The material brush of a clip, which begins where it was left: by what was saved, and by what was done
/// since in earlier runs, however these ended. It reads files and writes none.
class KeptBrush {
public:
    /// A history that does not fit is set aside, as FILE.broken, and said. Refused where the saved file
    /// cannot be read or does not fit.
    static Result<KeptBrush> begin(SegmentStore segments, BrushFiles files);

    MaterialBrush& brush() { return brush_; }
    const MaterialBrush& brush() const { return brush_; }
    const BrushFiles& files() const { return files_; }
    /// With what it began, for a person; empty: with guesses.
    const std::string& begun_with() const { return words_; }
    /// Whether a person said anything of a segment; otherwise all are guessed.
    bool is_painted() const { return !saved_.empty() || brush_.done() > 0; }

    /// For the file of saved materials. Whoever writes it writes the history before.
    std::string save();
    /// For the file of the history.
    std::string history() const;

private:
    KeptBrush(MaterialBrush brush, BrushFiles files) : brush_(std::move(brush)), files_(std::move(files)) {}
    Result<void> take_saved(const std::optional<std::string>& text);
    Result<void> take_history(const std::filesystem::path& file, const std::optional<std::string>& saved);
    void say(const std::string& words);

    MaterialBrush brush_;
    BrushFiles files_;
    std::string words_;
    std::vector<std::string> saved_;  // hashes of what it began with, and of what was saved since
};

}  // namespace touchable
