// SPDX-License-Identifier: Apache-2.0
#pragma once

// A kiosk: a window in a public place, which runs unattended. Declares its additions to a window: detecting
// visits (KioskWatch), the inputs allowed to visitors, the finger that demonstrates touching, all texts for
// visitors, in their language, labels of places of the clip, shown and played when a finger rests there, and
// a usage log. Everything belongs to the window's thread.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/checked_json.hpp"
#include "player/view/pointer.hpp"
#include "player/window/background_writer.hpp"
#include "player/window/persistent_device.hpp"

namespace touchable {

/// Seconds without input until a kiosk invites visitors, and until it resets.
struct KioskTimes {
    double invite_s = 20, reset_s = 60;
};

/// Tracks whether a visitor is present. Times are the window's, seconds, monotonic.
class KioskWatch {
public:
    explicit KioskWatch(const KioskTimes& times) : times_(times) {}

    /// Call on visitor input.
    void came(double now_s) {
        if (!is_there_) began_s_ = now_s;
        is_there_ = true;
        last_s_ = input_s_ = now_s;
        was_visited_ = true;
    }
    /// Call while a finger is pressed: extends the visit without other input, but no longer than reset_s, as
    /// a button may be stuck.
    void holds(double now_s) {
        if (is_there_ && now_s - input_s_ < times_.reset_s) last_s_ = now_s;
    }
    /// Whether a visit has begun and not ended.
    bool is_there() const { return is_there_; }
    /// Whether there was a visit since the window opened or reset.
    bool was_visited() const { return was_visited_; }
    struct Visit {
        double came_s = 0, seconds = 0;  ///< from the first input to the last
    };
    /// Returns a visit that has ended, once: after invite_s without input.
    std::optional<Visit> ended(double now_s) {
        return now_s - last_s_ < times_.invite_s ? std::nullopt : end();
    }
    /// Ends a current visit, as the window closes.
    std::optional<Visit> end() {
        if (!std::exchange(is_there_, false)) return std::nullopt;
        return Visit{began_s_, last_s_ - began_s_};
    }
    /// Seconds since the window began to invite; nullopt: a visitor is present.
    std::optional<double> invites(double now_s) const {
        const double since = now_s - last_s_ - times_.invite_s;
        return since >= 0 ? std::optional(since) : std::nullopt;
    }
    /// Whether to reset now: true once after each visit.
    bool begins_anew(double now_s);

private:
    KioskTimes times_;
    double began_s_ = 0, input_s_ = 0, last_s_ = 0;
    bool is_there_ = false, was_visited_ = false;
};

/// Whether visitors may do this. They may not close the window, open or write files, or change settings.
bool is_for_visitors(const InputEvent& event);
/// Whether the event shows that a visitor is present.
bool is_a_visit(const InputEvent& event);

/// The demonstrating finger, `seconds` after its start: its distance from the middle of the visible scene, in
/// shares of the picture's width and height, and whether it presses. It comes down, strokes, and leaves,
/// repeatedly.
struct ShownStroke {
    glm::dvec2 off{0.0};
    bool pressed = false;
};
ShownStroke stroke_at(double seconds);

/// The visitors' input device.
enum class TouchedBy { mouse, touch_screen, device };

/// All texts that a kiosk shows to visitors, English by default.
struct KioskTexts {
    std::string language = "en";  ///< the first choice for captions and sounds of labels
    std::string invitation, how_by_mouse, how_by_touch_screen, how_by_device;
    std::string force_is_off, again_by_mouse, again_by_touch_screen;
    std::string device_is_on, device_is_off, device_is_away, device_has_no_force, device_is_moved, come_out;
    std::string turn_back, pause, play, colours, next;  ///< buttons
    std::string touch, turn;                            ///< buttons: the new effect of dragging
    std::string limit;                                  ///< of the largest force
    std::string depth, stiffness, friction, height;     ///< meaning of colours
    std::string everywhere;
    std::string study_begin, study_continue, study_wait, study_not_kept;

    KioskTexts();
    bool operator==(const KioskTexts&) const = default;

    /// All texts concatenated, to find the glyphs that they need.
    std::string all() const;
    const std::string& how(TouchedBy by) const {
        if (by == TouchedBy::device) return how_by_device;
        return by == TouchedBy::mouse ? how_by_mouse : how_by_touch_screen;
    }
    const std::string& again(TouchedBy by) const {
        return by == TouchedBy::touch_screen ? again_by_touch_screen : again_by_mouse;
    }
    /// A device's state for visitors; HandState's words are for the operator.
    const std::string& of_device(HandState::What what) const;
};

/// Maximum file size, bytes.
inline constexpr std::size_t largest_kiosk_texts = std::size_t{64} << 10;

/// Parses an object of KioskTexts members and "touchable_kiosk_texts": 1; missing texts are English. Each
/// text is one line (read_plain_line). Fails with ErrorKind::input; the message begins with `where`.
Result<KioskTexts> parse_kiosk_texts(std::string_view json, std::string_view where);

using checked_json::read_checked;

/// A line of text for visitors: not empty, up to 200 bytes of UTF-8, no control characters. Throws
/// checked_json::Refusal.
std::string read_plain_line(const checked_json::Node& node);
/// A text, or an object with a text for each language; "" is any language. `read` reads one text. Throws
/// checked_json::Refusal.
std::map<std::string, std::string> read_by_language(const checked_json::Node& node,
                                                    std::string (*read)(const checked_json::Node&));
/// The value for a language; otherwise that for English, for any, or the first. Null if the map is empty.
template <class Said>
const Said* said_in(const std::map<std::string, Said>& by_language, const std::string& language) {
    for (const std::string& tried : {language, std::string("en"), std::string()})
        if (const auto found = by_language.find(tried); found != by_language.end()) return &found->second;
    return by_language.empty() ? nullptr : &by_language.begin()->second;
}
/// Whether the word is a language code: "de", "pt-BR": two or three small letters, optionally a hyphen and
/// another part.
bool is_language(const std::string& word);
/// The logged-in user's language, such as "de", from LC_ALL, LC_MESSAGES or LANG; "en" if these name no
/// language.
std::string own_language();

/// A labelled place of a clip.
struct TouchLabel {
    std::map<std::string, std::string> captions;          ///< by language; "" is any
    std::map<std::string, std::filesystem::path> sounds;  ///< by language; may be empty
    std::vector<glm::dvec2> corners;  ///< of a polygon, pixels of the clip's depth; if empty:
    std::string segment;              ///< the name of a segment
    std::int64_t first = 0, last = std::numeric_limits<std::int64_t>::max();  ///< frames
};
/// The labels of a clip. As JSON:
/// {"touchable_labels": 1, "labels": [
///  {"caption": {"en": "Africa", "de": "Afrika"}, "sound": {"en": "africa.wav", "de": "afrika.wav"},
///   "rectangle": [300, 120, 420, 260], "frames": [0, 119]},
///  {"caption": "Etna", "polygon": [[10, 10], [40, 12], [25, 30]]},
///  {"caption": "a bell", "segment": "bell"}]}
/// A rectangle is its left, top, right and bottom pixel. Frames are the first and the last; default: all. A
/// segment's name comes from a file of segments (engine/authoring/segments.hpp). Where labels overlap, the
/// first counts.
struct TouchLabels {
    std::vector<TouchLabel> labels;
    std::string said_by;  ///< the file, for messages

    /// The label at a place of the surface. `segment`: the name of the segment there.
    std::optional<std::size_t> at(const glm::dvec2& pixel, std::int64_t frame,
                                  std::string_view segment) const;
    /// Fails (ErrorKind::input) if a label is outside a clip of this many pixels and frames; 0: unknown.
    Result<void> fits(int width, int height, std::int64_t frames) const;
    /// Fails (ErrorKind::input) if a label's segment has none of these names.
    Result<void> has_segments(const std::vector<std::string>& names) const;
};

inline constexpr std::size_t most_labels = 1000;
/// Maximum file size, bytes.
inline constexpr std::size_t largest_labels = std::size_t{1} << 20;

/// `folder`: base of sounds' file names. Fails with ErrorKind::input; the message begins with `where`.
Result<TouchLabels> parse_touch_labels(std::string_view json, std::string_view where,
                                       const std::filesystem::path& folder);

/// The place that a finger touches now.
struct LabelledFinger {
    glm::dvec2 pixel{0.0};               ///< of the clip
    std::optional<std::size_t> label{};  ///< of that place; nullopt: the finger touches no label
};

/// Announces a label once a finger has rested on it, and again only after that finger has left it. Times are
/// the window's, seconds, monotonic.
class RestingFingers {
public:
    static constexpr double rests_s = 0.5;  ///< until a label is announced
    static constexpr double grace_s = 0.2;  ///< a shorter absence does not count as leaving
    static constexpr double stays_s = 1.5;  ///< time a label stays visible after its finger has left

    /// `reach`: pixels that a finger may move during rests_s and still rest.
    explicit RestingFingers(double reach) : reach_(reach) {}

    /// A label to announce now, once.
    std::optional<std::size_t> take(std::span<const LabelledFinger> fingers, double now_s);
    /// The label to display.
    std::optional<std::size_t> shown() const { return shown_; }

private:
    struct Finger {
        std::optional<std::size_t> label{};
        glm::dvec2 at{0.0};
        double since_s = 0, met_s = 0;  // start of resting; time of the last contact
        bool is_said = false;
    };
    bool rests(Finger& finger, const LabelledFinger& now, double now_s) const;

    static constexpr std::size_t most_fingers = 16;
    double reach_;
    std::array<Finger, most_fingers> fingers_{};
    std::optional<std::size_t> shown_{};
    double shown_until_s_ = 0;
};

/// A kiosk's usage log: a table (CSV) of starts, visits, faults and ends, appended as each happens. It
/// contains no personal data. Rows are written on a separate thread, each synced to disk before the next: a
/// disk that hangs or is full, or a killed program, loses only the rows of that time. Only `finish` waits for
/// the disk, for a limited time.
class UseLog : NonCopyable {
public:
    using Time = std::chrono::system_clock::time_point;
    using WriteRow = std::function<int(int out, std::string_view row)>;  ///< as append_durably
    static constexpr const char* header = "time,event,visitor,seconds,words\n";

    /// Appends to an existing log. Fails (ErrorKind::input) if the file is no log, is not writable, or is
    /// open in another program. `write`: replaces the disk in tests.
    static Result<std::unique_ptr<UseLog>> open(const std::filesystem::path& file,
                                                WriteRow write = append_durably);
    /// The last call, once: writes queued rows, for `longest` at most. Fails if rows are missing.
    Result<void> finish(std::chrono::milliseconds longest = std::chrono::seconds(2));

    void start(Time now) { add(now, "start,,,"); }
    /// A visitor came then, and stayed for `seconds`. Visitors are numbered from 1, since `open`.
    void visit(Time came, double seconds) {
        add(came, formatted("visit,%lld,%.1f,", static_cast<long long>(++visitors_), seconds));
    }
    void fault(Time now, const std::string& words);
    void end(Time now) { add(now, "end,,,"); }

    /// The reason of the first missing row; nullopt: none is missing.
    std::optional<Error> missing();

private:
    using Append = std::function<int(std::string_view row)>;  // owns the open file
    UseLog(std::filesystem::path file, Append append) : file_(std::move(file)), append_(std::move(append)) {}
    void add(Time time, const std::string& rest);

    const std::filesystem::path file_;
    const Append append_;
    BackgroundWriter writer_{"use-log", "rows of the log of use", 1000};
    std::optional<Error> missing_;
    std::int64_t visitors_ = 0;
};

/// "2026-11-24T10:00:00Z": UTC, to the second.
std::string in_universal_time(std::chrono::system_clock::time_point time);

}  // namespace touchable
