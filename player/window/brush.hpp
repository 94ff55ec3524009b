#pragma once

// The brush of materials: the tool in a person's hand (HeldBrush), which makes commands of clicks and
// strokes, and what has been painted of a clip (KeptBrush), with the files that keep it from one window to
// the next.

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

/// What the left button does over the picture.
enum class BrushTool {
    touch,  ///< it presses the finger
    paint,  ///< the segment that is clicked gets the material in hand
    join,   ///< the segment that is clicked first and the next one are one
    cut     ///< a stroke that is dragged parts its segment
};
/// Its name in commands and in the panel.
const char* name_of(BrushTool tool);
/// All tools, in the order of the panel.
std::span<const BrushTool> brush_tools();
/// Nothing: no tool has that name.
std::optional<BrushTool> brush_tool_of(std::string_view name);

/// The brush in a person's hand: makes commands of clicks and drags.
class HeldBrush {
public:
    static constexpr std::size_t most_points = 4096;  ///< of a stroke

    BrushTool tool() const { return tool_; }
    bool is_held() const { return tool_ != BrushTool::touch; }
    /// What was begun with the tool before is dropped.
    void take(BrushTool tool);
    /// Away, or the last one again; the first is paint.
    void take_or_put_away() { take(is_held() ? BrushTool::touch : last_); }
    const std::string& material() const { return material_; }
    void set_material(std::string material) { material_ = std::move(material); }

    /// A place of the window, pixels, and what of the clip is seen there.
    struct Place {
        glm::dvec2 at{0.0};
        std::optional<PixelOfFrame> pixel{};  ///< nothing: no surface
    };
    /// The left button goes down; the command, if that asks for one.
    std::optional<WindowCommand> press(const Place& place);
    /// The pointer moves, with the button held or not.
    void move(const Place& place);
    std::optional<WindowCommand> release();
    /// Drops what was begun.
    void let_go();
    /// Whether the first of two segments was clicked.
    bool has_first() const { return tool_ == BrushTool::join && !places_.empty(); }
    /// Whether a stroke is being drawn.
    bool is_drawing() const { return is_drawing_; }
    /// What was begun, a line in the window; empty: nothing.
    std::span<const glm::dvec2> line() const { return line_; }

private:
    BrushTool tool_ = BrushTool::touch, last_ = BrushTool::paint;
    std::string material_ = "wood";
    bool is_drawing_ = false;
    std::vector<PixelOfFrame> places_;  // of a stroke, or the first of two segments
    std::vector<glm::dvec2> line_;      // the same in the window, and to the pointer
};

/// The colour that stands for a material of the palette, RGB; grey for any other name.
std::array<std::uint8_t, 3> material_colour(std::string_view name);

/// Files of the brush of one clip.
struct BrushFiles {
    std::filesystem::path clip;
    std::optional<std::filesystem::path> segments{};  ///< given by the person; exists
    std::filesystem::path history_folder{};           ///< empty: no history is kept
    /// What else its segments depend on (segments_depend_on); empty: nothing.
    std::string opened_as{};

    /// The file of saved materials: the one that was given, or CLIP.materials.json beside the clip.
    std::filesystem::path saved() const;
    /// The file of the changes, kept between runs of the program: one for each clip, by its whole name, and
    /// for each way to open it. Empty: none is kept.
    std::filesystem::path history() const;
};

/// The material brush of a clip. It begins where it was left: with what was saved, and with the changes that
/// earlier runs made since, however these ended. Its owner writes its files; it renames a broken history.
class KeptBrush {
public:
    /// A history that does not fit is renamed to FILE.broken (set_aside), and `begun_with` says so. A history
    /// that cannot be read or renamed, or that another window is using, stays as it is; `begun_with` says so,
    /// and changes are not kept. Fails if the saved file cannot be read or does not fit, and when asked to
    /// stop.
    static Result<KeptBrush> begin(SegmentStore segments, BrushFiles files);

    MaterialBrush& brush() { return brush_; }
    const MaterialBrush& brush() const { return brush_; }
    const BrushFiles& files() const { return files_; }
    /// Where to keep its history; empty: nowhere.
    std::filesystem::path history_file() const {
        return keeps_history_ ? files_.history() : std::filesystem::path();
    }
    /// What it began with, in words; empty: with guesses.
    const std::string& begun_with() const { return words_; }
    /// Whether a person has painted any segment; otherwise all materials are guesses.
    bool is_painted() const { return !saved_.empty() || brush_.done() > 0; }

    /// Whether what is painted now is in the saved file, or was once.
    bool is_saved() const;
    /// The text of the file of saved materials. The history has to be written first.
    std::string save();
    /// The text of the file of the history.
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
    std::shared_ptr<void> held_;  // the history: no other window goes on with it
    std::string words_;
    std::vector<std::string> saved_;  // hashes of what it began with, and of what was saved since
};

}  // namespace touchable
