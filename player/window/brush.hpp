// SPDX-License-Identifier: Apache-2.0
#pragma once

// The brush of materials: the user's tool (HeldBrush), which makes commands from clicks and strokes, and a
// clip's painted materials (KeptBrush), with the files that keep them between windows.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <string_view>

#include "engine/authoring/materials.hpp"
#include "engine/authoring/segments.hpp"
#include "engine/base/result.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

/// The left button's effect over the picture.
enum class BrushTool {
    touch,  ///< presses the finger
    paint,  ///< gives the clicked segment the selected material
    join,   ///< merges the segments of two clicks
    cut     ///< splits a segment along a dragged stroke
};
/// The tools' names in commands and in the panel, in the order of BrushTool.
inline constexpr const char* brush_tools[] = {"touch", "paint", "join", "cut"};
/// nullopt: no tool has that name.
std::optional<BrushTool> brush_tool_of(std::string_view name);

/// The user's brush: makes commands from clicks and drags.
class HeldBrush {
public:
    static constexpr std::size_t most_points = 4096;  ///< of a stroke

    BrushTool tool() const { return tool_; }
    bool is_held() const { return tool_ != BrushTool::touch; }
    /// Selects a tool; drops unfinished input of the previous one.
    void take(BrushTool tool);
    /// Puts the tool away, or takes the last one again; paint at first.
    void take_or_put_away() { take(is_held() ? BrushTool::touch : last_); }
    const std::string& material() const { return material_; }
    void set_material(std::string material) { material_ = std::move(material); }

    /// A place of the window, pixels, and the clip's pixel visible there.
    struct Place {
        glm::dvec2 at{0.0};
        std::optional<PixelOfFrame> pixel{};  ///< nullopt: no surface
    };
    /// The left button goes down; returns the resulting command, if any.
    std::optional<WindowCommand> press(const Place& place);
    /// The pointer moves, with or without the button held.
    void move(const Place& place);
    std::optional<WindowCommand> release();
    /// Drops unfinished input.
    void let_go();
    /// Whether the first of two segments was clicked.
    bool has_first() const { return tool_ == BrushTool::join && !places_.empty(); }
    /// Whether a stroke is being drawn.
    bool is_drawing() const { return is_drawing_; }
    /// The unfinished input as a line in the window; empty: none.
    std::span<const glm::dvec2> line() const { return line_; }

private:
    BrushTool tool_ = BrushTool::touch, last_ = BrushTool::paint;
    std::string material_ = "wood";
    bool is_drawing_ = false;
    std::vector<PixelOfFrame> places_;  // of a stroke, or the first of two segments
    std::vector<glm::dvec2> line_;      // the same in the window, extended to the pointer
};

/// The colour of a material of the palette, RGB; grey for any other name.
std::array<std::uint8_t, 3> material_colour(std::string_view name);

/// Files of the brush of one clip.
struct BrushFiles {
    std::filesystem::path clip;
    std::optional<std::filesystem::path> segments{};  ///< chosen by the user; exists
    std::filesystem::path history_folder{};           ///< empty: no history is kept
    /// Other inputs of its segments (segments_depend_on); empty: none.
    std::string opened_as{};

    /// The file of saved materials: the given one, or CLIP.materials.json beside the clip.
    std::filesystem::path saved() const;
    /// The file of changes, kept between runs: one per clip, by its full path, and per way to open it. Empty:
    /// none is kept.
    std::filesystem::path history() const;
};

/// The material brush of a clip. Continues from the saved materials and the unsaved changes of earlier runs,
/// however those ended. Its owner writes its files; it only renames a broken history.
class KeptBrush {
public:
    /// A history that does not fit is renamed to FILE.broken (set_aside). A history that cannot be read or
    /// renamed, or that another window uses, is left alone, and changes are not kept. `begun_with` reports
    /// either. Fails if the saved file cannot be read or does not fit, and on cancellation.
    static Result<KeptBrush> begin(SegmentStore segments, BrushFiles files);

    MaterialBrush& brush() { return brush_; }
    const MaterialBrush& brush() const { return brush_; }
    const BrushFiles& files() const { return files_; }
    /// The history file to write; empty: none.
    std::filesystem::path history_file() const {
        return keeps_history_ ? files_.history() : std::filesystem::path();
    }
    /// How it began, for the user; empty: with guesses.
    const std::string& begun_with() const { return words_; }
    /// Whether the user has painted any segment; otherwise all materials are guesses.
    bool is_painted() const { return !saved_.empty() || brush_.done() > 0; }

    /// Whether the current materials are in the saved file, or once were.
    bool is_saved() const;
    /// The saved materials' file content. Write the history first.
    std::string save();
    /// The history's file content.
    std::string history() const;

private:
    KeptBrush(MaterialBrush brush, BrushFiles files) : brush_(std::move(brush)), files_(std::move(files)) {}
    Result<void> take_saved(const std::optional<std::string>& text);
    Result<bool> find_history(const std::optional<std::string>& saved);
    Result<void> take_history(const std::string& text, const std::optional<std::string>& saved);
    void set_history_aside(const Error& why);
    void go_without_history(const std::string& why) {
        keeps_history_ = false;
        say(why + "; what is done now is not kept beyond this window, unless it is saved");
    }
    void say(const std::string& words) { words_ += (words_.empty() ? "" : "; ") + words; }

    MaterialBrush brush_;
    BrushFiles files_;
    bool keeps_history_ = true;
    std::shared_ptr<void> held_;  // lock of the history against other windows
    std::string words_;
    std::vector<std::string> saved_;  // hashes of the initial saved text and later ones
};

}  // namespace touchable
