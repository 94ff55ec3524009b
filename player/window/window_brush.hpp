#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "player/window/brush.hpp"
#include "player/window/long_work.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/panel_facts.hpp"
#include "player/window/play_window.hpp"
#include "player/window/screen.hpp"
#include "player/window/window_files.hpp"

namespace touchable {

/// The brush of materials in a window. Segments are read, and changed one command after the other, on a
/// thread of its own, while the clip goes on; its files are written on another one. Nothing here waits.
class WindowBrush {
public:
    /// `options` outlive it.
    explicit WindowBrush(const PlayOptions& options) : options_(options) {}

    /// Another clip from now on, which is there until the next: whatever was on its way for the one before is
    /// let go of (is_changing).
    void go_to(OpenedClip& clip);
    /// A command of the brush.
    void take(WindowCommand command);
    /// `pointer`: window, pixels. Whether the tool in hand has the event, and not the finger.
    bool take(const InputEvent& event, const glm::dvec2& pointer, bool is_of_panel, const ScreenSize& size);
    /// Once a turn of the window.
    void go_on(const ScreenSize& size);

    /// What the window is to say and to do since it last asked.
    struct News {
        struct Remark {
            std::string words;
            Tone tone = Tone::remark;
            bool is_change = false;  ///< that is felt where materials are
        };
        std::vector<Remark> remarks{};
        bool has_begun = false;   ///< with a clip's segments
        bool is_another = false;  ///< what is to be felt, perhaps
    };
    News take_news() { return std::exchange(news_, {}); }

    /// Whether it is at anything.
    bool is_at_work() const { return work_.is_busy() || !asked_.empty() || !for_tool_.empty(); }
    /// Whether it is at changes that would be lost with the clip.
    bool is_changing() const { return brush_ && !asked_.empty(); }
    bool is_held() const { return tool_.is_held(); }
    /// What is to be felt: what a person painted, and all guesses as long as a tool is in hand. Null: as the
    /// clip says.
    std::shared_ptr<const PaintedSegments> felt() const {
        return is_held() || is_painted_ ? painted_ : nullptr;
    }
    /// In place of the clip's colours; null: those.
    std::shared_ptr<const PaintedSegments> tint() const { return is_held() ? painted_ : nullptr; }
    /// What it is at, where that takes long.
    std::string words() const;
    BrushFacts facts() const;
    /// The segment at a pixel of the depth plane, and what it is; empty where none is shown or felt.
    std::string segment_words(const WatchedMoment& moment, int x, int y) const;

    /// The name of the segment at a pixel; empty where it has none.
    std::string segment_name(const WatchedMoment& moment, const glm::dvec2& pixel) const;

    /// What is not saved, at the end, and where it is then; empty: nothing was painted, or all is saved.
    std::string unsaved_words() const;
    /// Gives up what it is at, and waits for its files, but not for ever. What went wrong with them is still
    /// to be told: the result is why what a person wanted to be saved last is not.
    Result<void> finish();

private:
    std::string why_none() const;
    /// With which the window was opened, and for which a file of segments may be given.
    bool is_first_clip() const { return clip_->choice().file == options_.session.clip.file; }
    void take_tool(const WindowCommand& command);
    void begin();
    void do_next();
    void take_made();
    void do_with_tool(const ScreenSize& size);
    HeldBrush::Place place_at(const glm::dvec2& at, const WatchedMoment& moment,
                              const ScreenSize& size) const;
    void hold_still(bool still);
    void note_state();
    void note_files();
    void keep_history(std::string history) {
        if (const auto file = brush_->history_file(); !file.empty())
            files_.give(text_file(file, std::move(history)));
    }
    void save(const std::filesystem::path& file);
    void refuse_all(const Error& why);
    bool drop_asked(const Error& why);
    void refuse(const WindowCommand& command, const std::string& why) {
        if (command.verb == WindowVerb::save_materials) save_fault_ = usage_error(why);
        say(why, Tone::refusal);
    }
    void say(std::string words, Tone tone = Tone::remark) {
        news_.remarks.push_back({std::move(words), tone});
    }

    const PlayOptions& options_;
    OpenedClip* clip_ = nullptr;
    News news_;
    HeldBrush tool_;
    struct ToolInput {
        InputEvent::Kind kind;
        glm::dvec2 at;  // window
    };
    std::vector<ToolInput> for_tool_;                         // that waits until something is shown
    bool is_pressed_ = false, holds_clip_ = false;            // the clip waits for a stroke
    std::shared_ptr<KeptBrush> brush_;                        // null: none yet; lent while `work_` is busy
    std::shared_ptr<const PaintedSegments> painted_;          // by it, as shown
    bool is_painted_ = false;                                 // by a person
    BrushFacts state_;                                        // what of the brush is shown
    std::deque<WindowCommand> asked_;                         // that wait for it, and the one it is at
    std::shared_ptr<std::atomic<std::int64_t>> frames_read_;  // of segments
    BackgroundWriter files_{"text-files", "what is painted"};
    std::filesystem::path lost_history_;   // whose newest text is not written
    std::set<std::string> faults_;         // of histories that were told
    std::optional<Error> save_fault_;      // of the last that was to be saved
    std::optional<Error> segments_fault_;  // of the file that was given
    /// What became of a command, or of beginning.
    struct Work {
        std::shared_ptr<KeptBrush> brush;
        Result<std::string> said;
        std::string history{};  // where it changed
    };
    LongWork<Work> work_{"brush", "that reads and changes segments"};
};

}  // namespace touchable
