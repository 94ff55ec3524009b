#pragma once

// A kiosk: a window in a public place, which runs unattended. Here is what it needs beside a window: when a
// visit begins and ends (KioskWatch), which inputs a visitor may use, the finger that shows how to touch, all
// texts that visitors read, in their language, labels of places of the clip, which are shown and played when
// a finger rests there, and a log of how the kiosk is used. Everything belongs to the window's thread.

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
#include "player/window/background_writer.hpp"
#include "player/window/input_event.hpp"
#include "player/window/persistent_device.hpp"

namespace touchable {

/// After how many seconds without input a kiosk invites to touch it, and after how many it begins anew.
struct KioskTimes {
    double invite_s = 20, reset_s = 60;
};

/// Whether a visitor is there. Times are the window's own, seconds, and do not go backward.
class KioskWatch {
public:
    explicit KioskWatch(const KioskTimes& times) : times_(times) {}

    /// A visitor did something.
    void came(double now_s) {
        if (!is_there_) began_s_ = now_s;
        is_there_ = true;
        last_s_ = input_s_ = now_s;
        was_visited_ = true;
    }
    /// A finger is still pressed: a visitor is there even without input, until it lasts so long that a button
    /// may be stuck.
    void holds(double now_s) {
        if (is_there_ && now_s - input_s_ < times_.reset_s) last_s_ = now_s;
    }
    /// Whether a visit has begun and not ended.
    bool is_there() const { return is_there_; }
    /// Whether there was a visit since the window began, or began anew.
    bool was_visited() const { return was_visited_; }
    struct Visit {
        double came_s = 0, seconds = 0;  ///< from the first input to the last
    };
    /// The visit that has ended, once: there was no input for as long as until the kiosk invites.
    std::optional<Visit> ended(double now_s) {
        return now_s - last_s_ < times_.invite_s ? std::nullopt : end();
    }
    /// Ends the visit that goes on, as the window closes.
    std::optional<Visit> end() {
        if (!std::exchange(is_there_, false)) return std::nullopt;
        return Visit{began_s_, last_s_ - began_s_};
    }
    /// For how many seconds the window has been inviting; nothing: a visitor is there.
    std::optional<double> invites(double now_s) const {
        const double since = now_s - last_s_ - times_.invite_s;
        return since >= 0 ? std::optional(since) : std::nullopt;
    }
    /// Whether to begin anew now: once after each visit.
    bool begins_anew(double now_s);

private:
    KioskTimes times_;
    double began_s_ = 0, input_s_ = 0, last_s_ = 0;
    bool is_there_ = false, was_visited_ = false;
};

/// Whether a visitor may do this. A visitor may not close the window, open or write files, or change
/// settings.
bool is_for_visitors(const InputEvent& event);
/// Whether it shows that a visitor is there.
bool is_a_visit(const InputEvent& event);

/// The finger that shows a visitor how to touch, so many seconds after it began: its distance from the middle
/// of what there is to see, in shares of the picture's width and height, and whether it presses. It comes
/// down, strokes, and leaves, again and again.
struct ShownStroke {
    glm::dvec2 off{0.0};
    bool pressed = false;
};
ShownStroke stroke_at(double seconds);

/// What a visitor touches a kiosk by.
enum class TouchedBy { mouse, touch_screen, device };

/// All words that a kiosk shows to visitors, in English by default.
struct KioskTexts {
    std::string language = "en";  ///< the first choice for captions and sounds of labels
    std::string invitation = "Touch the picture";
    std::string how_by_mouse = "Move, hold the button, and feel";
    std::string how_by_touch_screen = "One finger touches, two turn it";
    std::string how_by_device = "Take the handle, and feel";
    std::string force_is_off = "Force is off";
    std::string again_by_mouse = "Press to feel again";
    std::string again_by_touch_screen = "Touch to feel again";
    std::string device_is_on = "You feel what you touch";
    std::string device_is_off = "Forces are off: press the button of the handle, or F";
    std::string device_is_away = "The device is away: one moment, please";
    std::string device_has_no_force = "You see what you touch";
    std::string device_is_moved = "No force while the handle is moved back";
    std::string come_out = "Lift the finger off the surface: then you feel it";
    std::string turn_back = "Turn it back";  ///< of a button, as are the next
    std::string touch = "Touch";             ///< what dragging does from then on
    std::string turn = "Turn";
    std::string pause = "Pause";
    std::string play = "Play";
    std::string colours = "Colours";
    std::string next = "Next";    ///< clip
    std::string limit = "limit";  ///< of the largest force
    std::string depth = "Depth";  ///< what colours may mean, as are the next
    std::string stiffness = "Stiffness";
    std::string friction = "Friction";
    std::string height = "Height";
    std::string everywhere = "the same everywhere";
    std::string study_begin = "Begin";
    std::string study_continue = "Continue";
    std::string study_wait = "One moment, please";
    std::string study_not_kept = "Answers cannot be kept. Please call the staff.";
    bool operator==(const KioskTexts&) const = default;

    /// All texts, one after the other, to find the letters that they need.
    std::string all() const;
    const std::string& how(TouchedBy by) const {
        if (by == TouchedBy::device) return how_by_device;
        return by == TouchedBy::mouse ? how_by_mouse : how_by_touch_screen;
    }
    const std::string& again(TouchedBy by) const {
        return by == TouchedBy::touch_screen ? again_by_touch_screen : again_by_mouse;
    }
    /// The state of a device, in place of HandState's words, which are for the person who set it up.
    const std::string& of_device(HandState::What what) const;
};

/// A longer file is refused, bytes.
inline constexpr std::size_t largest_kiosk_texts = std::size_t{64} << 10;

/// An object of the members of KioskTexts, and "touchable_kiosk_texts": 1; what is left out is English. Each
/// text is one line (read_plain_line). Refused with ErrorKind::input; the message begins with `where`.
Result<KioskTexts> parse_kiosk_texts(std::string_view json, std::string_view where);

using checked_json::read_checked;

/// A line of text for visitors: not empty, up to 200 bytes of UTF-8, no control characters. Throws
/// checked_json::Refusal.
std::string read_plain_line(const checked_json::Node& node);
/// A text, or an object with a text for each language; "" is any language. `read` reads one text. Throws
/// checked_json::Refusal.
std::map<std::string, std::string> read_by_language(const checked_json::Node& node,
                                                    std::string (*read)(const checked_json::Node&));
/// The value for a language; if there is none, that for English, for any, or the first. Null: there are none.
template <class Said>
const Said* said_in(const std::map<std::string, Said>& by_language, const std::string& language) {
    for (const std::string& tried : {language, std::string("en"), std::string()})
        if (const auto found = by_language.find(tried); found != by_language.end()) return &found->second;
    return by_language.empty() ? nullptr : &by_language.begin()->second;
}
/// Whether the word is a language: "de", "pt-BR", two or three small letters, and perhaps a part behind a
/// hyphen.
bool is_language(const std::string& word);
/// "de" of the person who is logged in, by the environment's LC_ALL, LC_MESSAGES or LANG; "en" if these name
/// no language.
std::string own_language();

/// A place of a clip and what it is called.
struct TouchLabel {
    std::map<std::string, std::string> captions;          ///< by language; "" is any
    std::map<std::string, std::filesystem::path> sounds;  ///< by language; may be empty
    std::vector<glm::dvec2> corners;  ///< of a polygon, pixels of the clip's depth; or none:
    std::string segment;              ///< the name of a segment
    std::int64_t first = 0, last = std::numeric_limits<std::int64_t>::max();  ///< frames
};
/// The labels of a clip. As JSON:
/// {"touchable_labels": 1, "labels": [
///  {"caption": {"en": "Africa", "de": "Afrika"}, "sound": {"en": "africa.wav", "de": "afrika.wav"},
///   "rectangle": [300, 120, 420, 260], "frames": [0, 119]},
///  {"caption": "Etna", "polygon": [[10, 10], [40, 12], [25, 30]]},
///  {"caption": "a bell", "segment": "bell"}]}
/// A rectangle is its left, top, right and bottom pixel. Frames are the first and the last; left out: all.
/// The name of a segment is that of a file of segments (engine/authoring/segments.hpp). Of labels that lie
/// over each other the first counts.
struct TouchLabels {
    std::vector<TouchLabel> labels;
    std::string said_by;  ///< the file, for messages

    /// The label of a place of the surface. `segment`: the name of the segment there.
    std::optional<std::size_t> at(const glm::dvec2& pixel, std::int64_t frame,
                                  std::string_view segment) const;
    /// Refused (ErrorKind::input): a label beyond a clip of that many pixels and frames; 0: not known.
    Result<void> fits(int width, int height, std::int64_t frames) const;
    /// Refused (ErrorKind::input): a label of a segment that has none of these names.
    Result<void> has_segments(const std::vector<std::string>& names) const;
};

inline constexpr std::size_t most_labels = 1000;
/// A longer file is refused, bytes.
inline constexpr std::size_t largest_labels = std::size_t{1} << 20;

/// `folder`: where the names of sounds begin. Refused with ErrorKind::input; the message begins with `where`.
Result<TouchLabels> parse_touch_labels(std::string_view json, std::string_view where,
                                       const std::filesystem::path& folder);

/// What a finger touches now.
struct LabelledFinger {
    glm::dvec2 pixel{0.0};               ///< of the clip
    std::optional<std::size_t> label{};  ///< of that place; nothing: the finger touches no label
};

/// Says a label once a finger has rested on it, and again only once that finger has left it. Times are the
/// window's own, seconds, and do not go backward.
class RestingFingers {
public:
    static constexpr double rests_s = 0.5;  ///< until a label is said
    static constexpr double grace_s = 0.2;  ///< a finger that is away for less has not left
    static constexpr double stays_s = 1.5;  ///< how long a label is shown once its finger has left

    /// `reach`: how far a finger may go in that time and still rests, pixels.
    explicit RestingFingers(double reach) : reach_(reach) {}

    /// The label that is to be said from now on, once.
    std::optional<std::size_t> take(std::span<const LabelledFinger> fingers, double now_s);
    /// The label that is to be read.
    std::optional<std::size_t> shown() const { return shown_; }

private:
    struct Finger {
        std::optional<std::size_t> label{};
        glm::dvec2 at{0.0};
        double since_s = 0, met_s = 0;  // it rests; it was last there
        bool is_said = false;
    };
    bool rests(Finger& finger, const LabelledFinger& now, double now_s) const;

    static constexpr std::size_t most_fingers = 16;
    double reach_;
    std::array<Finger, most_fingers> fingers_{};
    std::optional<std::size_t> shown_{};
    double shown_until_s_ = 0;
};

/// How a kiosk is used: a table (CSV) of its starts, visits, faults and ends, which grows by a row as each
/// happens. It has nothing of persons. Rows are written on a thread of their own, each safe on the disk
/// before the next: a disk that hangs or is full, or a program that is killed, costs the rows of that time
/// and no more. No call waits for the disk but `finish`, for a while.
class UseLog : NonCopyable {
public:
    using Time = std::chrono::system_clock::time_point;
    using WriteRow = std::function<int(int out, std::string_view row)>;  ///< as append_durably
    static constexpr const char* header = "time,event,visitor,seconds,words\n";

    /// Appends to a log that is there. Refused (ErrorKind::input): a file that is no log, one that cannot be
    /// written, one that another program is writing. `write`: a test's disk.
    static Result<std::unique_ptr<UseLog>> open(const std::filesystem::path& file,
                                                WriteRow write = append_durably);
    /// Once, the last call: writes what waits, for that long at most. Fails if rows are missing.
    Result<void> finish(std::chrono::milliseconds longest = std::chrono::seconds(2));

    void start(Time now) { add(now, "start,,,"); }
    /// A visitor came then, and was there for so long. Visitors are numbered from 1, since `open`.
    void visit(Time came, double seconds) {
        add(came, formatted("visit,%lld,%.1f,", static_cast<long long>(++visitors_), seconds));
    }
    void fault(Time now, const std::string& words);
    void end(Time now) { add(now, "end,,,"); }
    std::int64_t visitors() const { return visitors_; }

    /// Why rows are missing, of the first that is; nothing: none is.
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

/// "2026-11-24T10:00:00Z": universal time, to the second.
std::string in_universal_time(std::chrono::system_clock::time_point time);

}  // namespace touchable
