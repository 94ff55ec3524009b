// SPDX-License-Identifier: Apache-2.0
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

/// The brush of materials in a window. Segments are read, and changed one command after another, on a
/// separate thread, while the clip continues; files are written on another one. No call waits.
class WindowBrush {
public:
    /// `options` must outlive it.
    explicit WindowBrush(const PlayOptions& options) : options_(options) {}

    /// Switches to a clip, which must live until the next: pending work for the previous clip is dropped
    /// (is_changing).
    void go_to(OpenedClip& clip);
    /// Queues a command of the brush.
    void take(WindowCommand command);
    /// `pointer`: window, pixels. Returns whether the selected tool uses the event, instead of the finger.
    bool take(const InputEvent& event, const glm::dvec2& pointer, bool is_of_panel, const ScreenSize& size);
    /// Once a turn of the window.
    void go_on(const ScreenSize& size);

    /// Messages and requests for the window since the last call.
    struct News {
        struct Remark {
            std::string words;
            Tone tone = Tone::remark;
            bool is_change = false;  ///< to be felt if materials are on
        };
        std::vector<Remark> remarks{};
        bool has_begun = false;   ///< a clip's segments are loaded
        bool is_another = false;  ///< what is to be felt may have changed
    };
    News take_news() { return std::exchange(news_, {}); }

    /// Whether work is in progress or pending.
    bool is_at_work() const { return work_.is_busy() || !asked_.empty() || !for_tool_.empty(); }
    /// Whether there are changes that would be lost with the clip.
    bool is_changing() const { return brush_ && !asked_.empty(); }
    bool is_held() const { return tool_.is_held(); }
    /// Materials to be felt: painted ones, and all guesses while a tool is selected. Null: the clip's own.
    std::shared_ptr<const PaintedSegments> felt() const {
        return is_held() || is_painted_ ? painted_ : nullptr;
    }
    /// Replaces the clip's colours; null: the clip's own.
    std::shared_ptr<const PaintedSegments> tint() const { return is_held() ? painted_ : nullptr; }
    /// Work in progress, if it takes long.
    std::string words() const;
    BrushFacts facts() const;
    /// The segment at a pixel of the depth plane, and its material; empty if none is shown or felt.
    std::string segment_words(const WatchedMoment& moment, int x, int y) const;

    /// The name of the segment at a pixel; empty if it has none.
    std::string segment_name(const WatchedMoment& moment, const glm::dvec2& pixel) const;

    /// Unsaved materials at the end, and their location; empty: none.
    std::string unsaved_words() const;
    /// Cancels its work, and waits for its files for a limited time. Their faults are still reported as news;
    /// the result is why the last requested save failed.
    Result<void> finish();

private:
    std::string why_none() const;
    /// Whether this is the clip that the window was opened with, to which a given file of segments belongs.
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
    std::vector<ToolInput> for_tool_;                         // waits for a first picture
    bool is_pressed_ = false, holds_clip_ = false;            // holds_clip_: the clip is paused for a stroke
    std::shared_ptr<KeptBrush> brush_;                        // null: none yet; in use by `work_` while that
                                                              // is busy
    std::shared_ptr<const PaintedSegments> painted_;          // as shown
    bool is_painted_ = false;                                 // by the user
    BrushFacts state_;                                        // the shown part of the state
    std::deque<WindowCommand> asked_;                         // waiting commands, and the one in progress
    std::shared_ptr<std::atomic<std::int64_t>> frames_read_;  // while reading segments
    BackgroundWriter files_{"text-files", "what is painted"};
    std::filesystem::path lost_history_;   // its newest text is not written
    std::set<std::string> faults_;         // of histories, already reported
    std::optional<Error> save_fault_;      // of the last requested save
    std::optional<Error> segments_fault_;  // of the given file
    /// The result of a command, or of beginning.
    struct Work {
        std::shared_ptr<KeptBrush> brush;
        Result<std::string> said;
        std::string history{};  // if it changed
    };
    LongWork<Work> work_{"brush", "that reads and changes segments"};
};

}  // namespace touchable
