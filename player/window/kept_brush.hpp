#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/authoring/material_brush.hpp"
#include "engine/authoring/segment_store.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// Files of the brush of one clip.
struct BrushFiles {
    std::filesystem::path clip;
    std::optional<std::filesystem::path> segments{};  ///< that a person gave, which is there
    std::filesystem::path history_folder{};           ///< empty: no history is kept
    std::string
        opened_as{};  ///< what else its segments depend on (segments_depend_on); empty: as it is by itself

    /// What segments are like, saved: the one that was given, or CLIP.materials.json beside the clip.
    std::filesystem::path saved() const;
    /// All that was done, from one run of the program to the next: a file for each clip by its whole name,
    /// and for each way to open it. Empty where none is kept.
    std::filesystem::path history() const;
};

/// The material brush of a clip, which begins where it was left: by what was saved, and by what was done
/// since in earlier runs, however these ended. Whoever has it writes its files; it sets a history aside.
class KeptBrush {
public:
    /// A history that does not fit is set aside, as FILE.broken or a number more, and said. Where it cannot
    /// be read or set aside, or another window goes on with it, it stays as it is; that is said, and what is
    /// done here is not kept. Refused where the saved file cannot be read or does not fit, and when asked to
    /// stop.
    static Result<KeptBrush> begin(SegmentStore segments, BrushFiles files);

    MaterialBrush& brush() { return brush_; }
    const MaterialBrush& brush() const { return brush_; }
    const BrushFiles& files() const { return files_; }
    /// Where its history is to be kept; empty: nowhere.
    std::filesystem::path history_file() const;
    /// With what it began, for a person; empty: with guesses.
    const std::string& begun_with() const { return words_; }
    /// Whether a person said anything of a segment; otherwise all are guessed.
    bool is_painted() const { return !saved_.empty() || brush_.done() > 0; }

    /// Whether what a person said is in the saved file, or was.
    bool is_saved() const;
    /// For the file of saved materials. Whoever writes it writes the history before.
    std::string save();
    /// For the file of the history.
    std::string history() const;

private:
    KeptBrush(MaterialBrush brush, BrushFiles files) : brush_(std::move(brush)), files_(std::move(files)) {}
    Result<void> take_saved(const std::optional<std::string>& text);
    Result<bool> find_history(const std::optional<std::string>& saved);
    Result<void> take_history(const std::string& text, const std::optional<std::string>& saved);
    void set_history_aside(const Error& why);
    void go_without_history(const std::string& why);
    void say(const std::string& words);

    MaterialBrush brush_;
    BrushFiles files_;
    bool keeps_history_ = true;
    std::shared_ptr<void> held_;  // the history: no other window goes on with it
    std::string words_;
    std::vector<std::string> saved_;  // hashes of what it began with, and of what was saved since
};

}  // namespace touchable
