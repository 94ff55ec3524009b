// SPDX-License-Identifier: Apache-2.0
#include "player/window/kiosk.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <glm/geometric.hpp>
#include <numbers>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "player/window/command_table.hpp"
#include "player/window/window_command.hpp"

namespace touchable {
namespace {

constexpr struct {
    const char* member;
    std::string KioskTexts::*text;
    const char* english;
} kiosk_texts[] = {
    {"invitation", &KioskTexts::invitation, "Touch the picture"},
    {"how_by_mouse", &KioskTexts::how_by_mouse, "Move, hold the button, and feel"},
    {"how_by_touch_screen", &KioskTexts::how_by_touch_screen, "One finger touches, two turn it"},
    {"how_by_device", &KioskTexts::how_by_device, "Take the handle, and feel"},
    {"force_is_off", &KioskTexts::force_is_off, "Force is off"},
    {"again_by_mouse", &KioskTexts::again_by_mouse, "Press to feel again"},
    {"again_by_touch_screen", &KioskTexts::again_by_touch_screen, "Touch to feel again"},
    {"device_is_on", &KioskTexts::device_is_on, "You feel what you touch"},
    {"device_is_off", &KioskTexts::device_is_off, "Forces are off: press the button of the handle, or F"},
    {"device_is_away", &KioskTexts::device_is_away, "The device is away: one moment, please"},
    {"device_has_no_force", &KioskTexts::device_has_no_force, "You see what you touch"},
    {"device_is_moved", &KioskTexts::device_is_moved, "No force while the handle is moved back"},
    {"come_out", &KioskTexts::come_out, "Lift the finger off the surface: then you feel it"},
    {"turn_back", &KioskTexts::turn_back, "Turn it back"},
    {"touch", &KioskTexts::touch, "Touch"},
    {"turn", &KioskTexts::turn, "Turn"},
    {"pause", &KioskTexts::pause, "Pause"},
    {"play", &KioskTexts::play, "Play"},
    {"colours", &KioskTexts::colours, "Colours"},
    {"next", &KioskTexts::next, "Next"},
    {"limit", &KioskTexts::limit, "limit"},
    {"depth", &KioskTexts::depth, "Depth"},
    {"stiffness", &KioskTexts::stiffness, "Stiffness"},
    {"friction", &KioskTexts::friction, "Friction"},
    {"height", &KioskTexts::height, "Height"},
    {"everywhere", &KioskTexts::everywhere, "the same everywhere"},
    {"study_begin", &KioskTexts::study_begin, "Begin"},
    {"study_continue", &KioskTexts::study_continue, "Continue"},
    {"study_wait", &KioskTexts::study_wait, "One moment, please"},
    {"study_not_kept", &KioskTexts::study_not_kept, "Answers cannot be kept. Please call the staff."}};

KioskTexts read_texts(const checked_json::Node& node) {
    std::vector<std::string> legal{"touchable_kiosk_texts", "language"};
    for (const auto& one : kiosk_texts) legal.emplace_back(one.member);
    node.allow_only(legal);
    node.check_version("touchable_kiosk_texts");
    KioskTexts texts;
    texts.language = node["language"].text();
    if (!is_language(texts.language))
        node["language"].refuse("a language, such as \"en\", \"de\" or \"pt-BR\"");
    for (const auto& one : kiosk_texts)
        if (node.has(one.member)) texts.*one.text = read_plain_line(node[one.member]);
    return texts;
}

using LabelNode = checked_json::Node;

constexpr int largest_side = 16384;
constexpr std::size_t most_corners = 1000;

glm::dvec2 read_corner(const LabelNode& node) {
    const auto numbers = node.elements(2, 2, "a pixel [x, y]");
    return {numbers[0].whole(0, largest_side), numbers[1].whole(0, largest_side)};
}

std::vector<glm::dvec2> read_rectangle(const LabelNode& node) {
    const auto numbers = node.elements(4, 4, "[left, top, right, bottom], pixels");
    double side[4];
    for (std::size_t k = 0; k < 4; ++k) side[k] = numbers[k].whole(0, largest_side);
    if (side[0] > side[2] || side[1] > side[3])
        node.refuse("[left, top, right, bottom], right not before left and bottom not above top");
    return {{side[0], side[1]}, {side[2], side[1]}, {side[2], side[3]}, {side[0], side[3]}};
}

void read_place(const LabelNode& node, TouchLabel& label) {
    if (node.has("rectangle") + node.has("polygon") + node.has("segment") != 1)
        node.refuse("of one place: rectangle, polygon or segment");
    if (node.has("rectangle")) label.corners = read_rectangle(node["rectangle"]);
    if (node.has("segment")) label.segment = read_plain_line(node["segment"]);
    if (!node.has("polygon")) return;
    for (const LabelNode& corner : node["polygon"].elements(3, most_corners, "3 to 1000 pixels [x, y]"))
        label.corners.push_back(read_corner(corner));
}

TouchLabel read_label(const LabelNode& node, const std::filesystem::path& folder) {
    node.allow_only({"caption", "sound", "rectangle", "polygon", "segment", "frames"});
    TouchLabel label;
    label.captions = read_by_language(node["caption"], read_plain_line);
    if (node.has("sound"))
        for (const auto& [language, file] : read_by_language(node["sound"], read_plain_line))
            label.sounds.emplace(language, folder / file);
    read_place(node, label);
    if (!node.has("frames")) return label;
    const auto frames = node["frames"].elements(2, 2, "the first frame and the last, [0, 99]");
    label.first = frames[0].integer(0, std::int64_t{1} << 40);
    label.last = frames[1].integer(0, std::int64_t{1} << 40);
    if (label.last < label.first) node["frames"].refuse("the first frame and the last, in that order");
    return label;
}

/// Counts crossings of a ray to the right with the border; the border itself, half a pixel wide, is inside.
bool is_inside_of(const std::vector<glm::dvec2>& corners, const glm::dvec2& at) {
    constexpr double border = 0.5;
    bool is_inside = false;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const glm::dvec2 a = corners[k], b = corners[(k + 1) % corners.size()], way = b - a, off = at - a;
        const double length2 = way.x * way.x + way.y * way.y;
        const double share =
            length2 > 0 ? std::clamp((off.x * way.x + off.y * way.y) / length2, 0.0, 1.0) : 0.0;
        const glm::dvec2 gap = off - share * way;
        if (gap.x * gap.x + gap.y * gap.y <= border * border) return true;
        if ((a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / way.y * way.x) is_inside = !is_inside;
    }
    return is_inside;
}

std::string name_of_label(const TouchLabels& labels, std::size_t k) {
    return labels.said_by + ": labels[" + std::to_string(k) + "]";
}

/// A quoted CSV field, for text with commas or quotes.
std::string quoted_field(const std::string& words) {
    std::string field = "\"";
    for (const char c : printable(words, 500)) field += c == '"' ? std::string("\"\"") : std::string(1, c);
    return field + "\"";
}

/// Why an open file cannot take rows of the log; nullopt: it can.
std::optional<std::string> why_no_log(int out) {
    struct stat facts {};
    if (fstat(out, &facts) != 0) return std::strerror(errno);
    if (!S_ISREG(facts.st_mode)) return "is no ordinary file";
    if (flock(out, LOCK_EX | LOCK_NB) != 0) return "another program is writing it";
    const std::string_view header = UseLog::header;
    if (facts.st_size == 0) {
        if (const int why = append_durably(out, header)) return std::strerror(why);
        return std::nullopt;
    }
    std::string begin(header.size(), '\0');
    if (pread(out, begin.data(), begin.size(), 0) != static_cast<ssize_t>(begin.size()) || begin != header)
        return "is there, and is no log of use";
    // A power failure may have left a partial row.
    char last = '\n';
    if (pread(out, &last, 1, facts.st_size - 1) == 1 && last != '\n')
        if (const int why = append_durably(out, "\n")) return std::strerror(why);
    return std::nullopt;
}

}  // namespace

bool KioskWatch::begins_anew(double now_s) {
    if (!was_visited_ || now_s - last_s_ < times_.reset_s) return false;
    was_visited_ = false;
    return true;
}

bool is_for_visitors(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    if (event.kind == Kind::close || event.kind == Kind::dropped) return false;
    if (event.kind != Kind::key) return true;
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    return !binding || row_of(binding->verb).has(CommandRow::for_visitors);
}

bool is_a_visit(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    return event.kind == Kind::moved || event.kind == Kind::pressed || event.kind == Kind::wheel ||
           event.kind == Kind::key || event.kind == Kind::touch_began || event.kind == Kind::touch_moved;
}

ShownStroke stroke_at(double seconds) {
    constexpr double round_s = 9, stroke_s = 4.5, down_s = 0.7, up_s = 3.9;
    const double angle = 2 * std::numbers::pi * seconds / round_s;
    const double within = std::fmod(seconds, stroke_s);
    return {{0.17 * std::sin(angle), 0.12 * std::sin(2 * angle)}, within > down_s && within < up_s};
}

KioskTexts::KioskTexts() {
    for (const auto& one : kiosk_texts) this->*one.text = one.english;
}

std::string KioskTexts::all() const {
    std::string words;
    for (const auto& one : kiosk_texts) words += this->*one.text;
    return words;
}

const std::string& KioskTexts::of_device(HandState::What what) const {
    // In the order of HandState::What.
    constexpr std::string KioskTexts::*texts[] = {
        &KioskTexts::device_is_away, &KioskTexts::device_has_no_force, &KioskTexts::device_is_moved,
        &KioskTexts::device_is_on, &KioskTexts::device_is_off};
    return this->*texts[static_cast<std::size_t>(what)];
}

Result<KioskTexts> parse_kiosk_texts(std::string_view json, std::string_view where) {
    return read_checked(json, largest_kiosk_texts, where, read_texts);
}

std::string read_plain_line(const checked_json::Node& node) {
    constexpr std::size_t longest_line = 200;
    std::string line = node.text();
    const bool has_control = std::ranges::any_of(line, [](char c) {
        return static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) == 0x7F;
    });
    if (line.empty() || line.size() > longest_line || has_control)
        node.refuse("a line of text of up to " + std::to_string(longest_line) + " bytes");
    return line;
}

std::map<std::string, std::string> read_by_language(const checked_json::Node& node,
                                                    std::string (*read)(const checked_json::Node&)) {
    if (!node.is_object()) return {{"", read(node)}};
    std::map<std::string, std::string> said;
    for (const std::string& language : node.members()) {
        if (!is_language(language)) node.refuse("an object of languages, such as {\"en\": ..., \"de\": ...}");
        said.emplace(language, read(node[language.c_str()]));
    }
    if (said.empty()) node.refuse("a text, or an object of one for each language");
    return said;
}

bool is_language(const std::string& word) {
    const std::size_t letters = std::min(word.find('-'), word.size());
    const auto is_small = [](char c) { return c >= 'a' && c <= 'z'; };
    const auto is_other = [&](char c) {
        return is_small(c) || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    };
    if ((letters != 2 && letters != 3) ||
        !std::all_of(word.begin(), word.begin() + static_cast<std::ptrdiff_t>(letters), is_small))
        return false;
    const std::string rest = word.substr(letters);
    return rest.empty() ||
           (rest.size() >= 2 && rest.size() <= 9 && std::all_of(rest.begin() + 1, rest.end(), is_other));
}

std::string own_language() {
    for (const char* const variable : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
        const char* const value = std::getenv(variable);
        if (!value || !*value) continue;
        const std::string locale = value;
        const std::string language = locale.substr(0, locale.find_first_of("_.@"));
        return language.size() <= 3 && is_language(language) ? language : "en";
    }
    return "en";
}

std::optional<std::size_t> TouchLabels::at(const glm::dvec2& pixel, std::int64_t frame,
                                           std::string_view segment) const {
    for (std::size_t k = 0; k < labels.size(); ++k) {
        const TouchLabel& label = labels[k];
        if (frame < label.first || frame > label.last) continue;
        if (label.segment.empty() ? is_inside_of(label.corners, pixel) : label.segment == segment) return k;
    }
    return std::nullopt;
}

Result<void> TouchLabels::fits(int width, int height, std::int64_t frames) const {
    for (std::size_t k = 0; k < labels.size(); ++k) {
        for (const glm::dvec2& corner : labels[k].corners)
            if (corner.x >= width || corner.y >= height)
                return input_error(name_of_label(*this, k) + " reaches pixel " +
                                   std::to_string(static_cast<int>(corner.x)) + ", " +
                                   std::to_string(static_cast<int>(corner.y)) + ": the clip is " +
                                   size_text(width, height) + ", and its pixels begin with 0, 0");
        if (frames > 0 && labels[k].first >= frames)
            return input_error(name_of_label(*this, k) + " begins with frame " +
                               std::to_string(labels[k].first) + ": the clip has " + std::to_string(frames) +
                               ", and the first is 0");
    }
    return {};
}

Result<void> TouchLabels::has_segments(const std::vector<std::string>& names) const {
    for (std::size_t k = 0; k < labels.size(); ++k)
        if (const std::string& name = labels[k].segment;
            !name.empty() && std::ranges::find(names, name) == names.end())
            return input_error(name_of_label(*this, k) + " is of a segment " + in_quotes(name) +
                               ", which no file of segments names");
    return {};
}

Result<TouchLabels> parse_touch_labels(std::string_view json, std::string_view where,
                                       const std::filesystem::path& folder) {
    return read_checked(json, largest_labels, where, [&](const LabelNode& node) {
        node.allow_only({"touchable_labels", "labels"});
        node.check_version("touchable_labels");
        TouchLabels labels{.labels = {}, .said_by = std::string(where)};
        for (const LabelNode& label : node["labels"].elements(
                 1, most_labels, "a list of 1 to " + std::to_string(most_labels) + " labels"))
            labels.labels.push_back(read_label(label, folder));
        return labels;
    });
}

/// Returns whether to announce its label now.
bool RestingFingers::rests(Finger& finger, const LabelledFinger& now, double now_s) const {
    if (now.label && now.label == finger.label) {
        finger.met_s = now_s;
        if (glm::distance(now.pixel, finger.at) > reach_) {
            finger.at = now.pixel;
            finger.since_s = now_s;
        }
        return !finger.is_said && now_s - finger.since_s >= rests_s;
    }
    if (finger.label && now_s - finger.met_s < grace_s) return false;
    finger = {.label = now.label, .at = now.pixel, .since_s = now_s, .met_s = now_s};
    return false;
}

std::optional<std::size_t> RestingFingers::take(std::span<const LabelledFinger> fingers, double now_s) {
    std::optional<std::size_t> said;
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
        Finger& finger = fingers_[k];
        if (rests(finger, k < fingers.size() ? fingers[k] : LabelledFinger{}, now_s)) {
            finger.is_said = true;
            shown_ = said = finger.label;
        }
        if (finger.is_said && finger.label == shown_)
            shown_until_s_ = std::max(shown_until_s_, now_s + stays_s);
    }
    if (shown_ && now_s >= shown_until_s_) shown_.reset();
    return said;
}

Result<std::unique_ptr<UseLog>> UseLog::open(const std::filesystem::path& file, WriteRow write) {
    const auto out = std::make_shared<Descriptor>(
        ::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0644));
    if (out->get() < 0) return input_error(file.string() + ": cannot be written: " + std::strerror(errno));
    if (const auto why = why_no_log(out->get()))
        return input_error(file.string() + ": " + *why +
                           "; must be a new file, or a log of use to go on with");
    return std::unique_ptr<UseLog>(new UseLog(
        file, [out, write = std::move(write)](std::string_view row) { return write(out->get(), row); }));
}

void UseLog::fault(Time now, const std::string& words) {
    add(now, "fault,,," + quoted_field(words));
}

Result<void> UseLog::finish(std::chrono::milliseconds longest) {
    if (!writer_.finish(longest, BackgroundWriter::Late::done))
        return input_error(file_.string() + ": " + not_in_time +
                           "; the last rows of the log of use may be lost");
    const auto lost = missing();
    return lost ? Result<void>(*lost) : Result<void>();
}

std::optional<Error> UseLog::missing() {
    for (const auto& row : writer_.take())
        if (!row.result && !missing_) missing_ = row.result.error();
    return missing_;
}

void UseLog::add(Time time, const std::string& rest) {
    writer_.give({.file = file_,
                  .write = [append = append_, row = in_universal_time(time) + ',' + rest +
                                                    '\n'](const std::filesystem::path& file) -> Result<void> {
                      const int why = append(row);
                      if (why == 0) return {};
                      return input_error(file.string() +
                                         ": rows of the log of use are lost: " + std::strerror(why));
                  }});
}

std::string in_universal_time(std::chrono::system_clock::time_point time) {
    const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    char words[32];
    return {words, std::strftime(words, sizeof words, "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

}  // namespace touchable
