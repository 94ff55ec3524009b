// SPDX-License-Identifier: Apache-2.0
// Hands: their words, and the tables that they repeat.

#include <glm/matrix.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "device/hand.hpp"
#include "device/hand_parts.hpp"
#include "engine/authoring/materials.hpp"
#include "engine/base/files.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/words.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/run_options.hpp"
#include "player/run/run_files.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"
#include "player/view/view.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/study.hpp"
#include "player/window/user_files.hpp"
#include "player/window/window_command.hpp"
#include "tests/device/fake_driver.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

constexpr int ticks = 20;

void require_goals(Hand& hand, const SurfaceProbe& probe) {
    std::vector<glm::dvec3> goals(static_cast<std::size_t>(hand.fingers()));
    for (int tick = 0; tick < ticks; ++tick) {
        hand.goals_at(tick, probe, goals);
        for (const glm::dvec3& goal : goals)
            require(std::isfinite(goal.x) && std::isfinite(goal.y) && std::isfinite(goal.z),
                    "a goal is not finite");
    }
}

bool parse_hand(std::string_view bytes) {
    const std::string words(bytes);
    // A table is another target's.
    if (words.starts_with("csv:")) return false;
    const FakeProbe probe = flat_view();
    const auto hand = make_hand(words, 2, default_workspace(640, 500, 800), probe);
    if (!is_taken(hand, Quotes::typed)) return false;
    require_goals(**hand, probe);
    return true;
}

/// A line of options, then the table.
bool parse_recorded_hand(std::string_view bytes) {
    Taken taken(bytes);
    const std::string options(taken.line());
    const FakeProbe probe = flat_view();
    const auto file = file_of(taken.rest(), "hand.csv").string();
    const auto hand = make_hand("csv:" + file + ":" + options, 1, default_workspace(640, 500, 800), probe);
    if (!is_taken(hand, Quotes::typed)) return false;
    require((*hand)->ticks().value_or(0) > 0, "a motion has no length");
    require_goals(**hand, probe);
    return true;
}

bool parse_csv_table(std::string_view bytes) {
    const auto file = file_of(bytes, "table.csv").string();
    (void)is_taken(read_force_table(file));
    const auto table = CsvTable::read(file);
    if (!is_taken(table)) return false;
    require(table->rows() > 0 && table->columns() > 0, "a table without a row");
    for (std::size_t column = 0; column < table->columns(); ++column) {
        const auto numbers = table->numbers(column);
        if (!is_taken(numbers)) continue;
        require(numbers->size() == table->rows(), "not a number for each row");
        for (const double number : *numbers) require(std::isfinite(number), "a number is not finite");
    }
    return true;
}

const Registered hand_target{{.name = "hand", .parse = parse_hand, .most_bytes = 256}};
// Three rows may be a motion of an hour: 82 MiB of ticks.
const Registered recorded_hand_target{
    {.name = "recorded_hand", .parse = parse_recorded_hand, .most_bytes = 1024, .most_live_mebibytes = 96}};
const Registered csv_table_target{{.name = "csv_table", .parse = parse_csv_table, .most_bytes = 1024}};

// The files of an exhibit: its words, its labels, its study.

constexpr std::size_t longest_line = 200;

/// Text for a window: lines of UTF-8 that are not empty.
void require_lines(std::string_view text, std::size_t most_lines, bool breaks) {
    require(!text.empty() && text.size() <= most_lines * (longest_line + 1), "a text of no right length");
    for (const char c : text)
        require((static_cast<unsigned char>(c) >= 0x20 && c != 0x7F) || (breaks && c == '\n'),
                "a text with control characters");
}

bool parse_texts(std::string_view bytes) {
    const auto texts = parse_kiosk_texts(bytes, "texts.json");
    if (!is_taken(texts)) return false;
    require(is_language(texts->language), "a language that is none");
    for (const TouchedBy by : {TouchedBy::mouse, TouchedBy::touch_screen, TouchedBy::device}) {
        require_lines(texts->how(by), 1, false);
        require_lines(texts->again(by), 1, false);
    }
    require_lines(texts->study_not_kept, 1, false);
    require(texts->all().size() <= 30 * longest_line, "texts that are too long");
    return true;
}

bool parse_labels(std::string_view bytes) {
    const auto labels = parse_touch_labels(bytes, "labels.json", "sounds");
    if (!is_taken(labels)) return false;
    require(!labels->labels.empty() && labels->labels.size() <= most_labels, "no right number of labels");
    for (std::size_t k = 0; k < labels->labels.size(); ++k) {
        const TouchLabel& label = labels->labels[k];
        require(label.corners.empty() != label.segment.empty(), "a label of two places, or of none");
        require(label.corners.empty() || label.corners.size() >= 3, "a polygon of two corners");
        require(0 <= label.first && label.first <= label.last, "frames that end before they begin");
        const std::string* const caption = said_in(label.captions, "de");
        require(caption != nullptr, "a label without a caption");
        require_lines(*caption, 1, false);
        // The border is inside: a corner has this label, or an earlier one that lies over it.
        if (label.corners.empty()) continue;
        const auto at = labels->at(label.corners.front(), label.first, "");
        require(at && *at <= k, "a corner without its label");
    }
    (void)is_taken(labels->fits(640, 480, 100));
    require(bool(labels->fits(16385, 16385, std::numeric_limits<std::int64_t>::max())),
            "a label beyond the largest clip");
    return true;
}

void require_words(const StudyWords& words) {
    require(!words.empty(), "words in no language");
    for (const auto& [language, said] : words) {
        require(language.empty() || is_language(language), "words in a language that is none");
        require_lines(said, 8, true);
    }
}

/// Each participant gets the same screens in an order of conditions; each has words and a name of its own.
void require_screens(const Study& study, std::size_t number) {
    const std::vector<StudyScreen> screens = screens_of(study, number);
    require(!screens.empty(), "a study without a screen");
    std::set<std::string> names;
    for (const StudyScreen& screen : screens) {
        require(screen.clip() < study.clips(), "a clip beyond the last");
        const std::string& id = screen.question ? screen.question->id : screen.step->id;
        const std::string condition = screen.condition ? screen.condition->name : "";
        require(names.insert(condition + "/" + id).second, "two screens of one name");
        require_words(screen.question ? screen.question->words : screen.step->words);
        if (screen.question) require(screen.question->answers.size() >= 2, "a question without a choice");
        require(std::isfinite(screen.step->least_s) &&
                    screen.step->least_s <= screen.step->most_s.value_or(screen.step->least_s),
                "a step that ends before it may");
    }
}

bool parse_study_file(std::string_view bytes) {
    const auto study = parse_study(bytes, "study.json");
    if (!is_taken(study)) return false;
    require_words(study->title);
    require_words(study->words);
    require(study->idle_s >= 1, "a participant is idle at once");
    require(study->all_words("de").find("0123456789") == 0, "letters without digits");
    for (std::size_t number = 1; number <= 2 * most_study_conditions; ++number)
        require_screens(*study, number);
    return true;
}

const Registered texts_target{
    {.name = "kiosk_texts", .parse = parse_texts, .cuts_are_refused = true, .needless_bytes = 1}};
const Registered labels_target{
    {.name = "touch_labels", .parse = parse_labels, .cuts_are_refused = true, .needless_bytes = 1}};
const Registered study_target{{.name = "study",
                               .parse = parse_study_file,
                               .cuts_are_refused = true,
                               .needless_bytes = 1,
                               .most_bytes = 8192}};

// Names of segments, and the history of a brush: files of unknown origin.

bool parse_names(std::string_view bytes) {
    const auto names = parse_segment_names(bytes, "names");
    if (!names) return false;
    const std::string text = segment_names_to_json(*names);
    const auto again = parse_segment_names(text, "again");
    require(bool(again), "names that were written are refused");
    require(segment_names_to_json(*again) == text, "names come back as others");
    return true;
}

/// Four segments in three frames of 12 x 8 pixels; one goes to the right, and another comes late.
SegmentStore small_segments() {
    SegmentStore store(12, 8);
    for (int frame = 0; frame < 3; ++frame) {
        Segmentation segmentation{12, 8, {}, {}};
        for (int k = 0; k < 96; ++k) {
            const int x = k % 12, y = k / 12;
            const int label = y == 7                                    ? (frame == 2 ? 4 : 0)
                              : y > 4 && x > 2 + frame && x < 8 + frame ? 3
                              : x < 6                                   ? 1
                                                                        : 2;
            segmentation.labels.push_back(static_cast<std::uint16_t>(label));
        }
        for (std::uint16_t label = 1; label <= (frame == 2 ? 4 : 3); ++label)
            segmentation.segments.push_back({label, 20, {100, 80, 60}, 1, 1, 0});
        store.add(segmentation);
    }
    return store;
}

bool parse_history(std::string_view bytes) {
    auto brush = MaterialBrush::begin(small_segments());
    require(bool(brush), "a brush does not begin");
    if (!brush->repeat(bytes, "history")) return false;
    const std::string history = brush->history();
    auto again = MaterialBrush::begin(small_segments());
    require(bool(again->repeat(history, "again")), "a history that was written is refused");
    require(again->history() == history, "a history comes back as another");
    while (brush->undo()) continue;
    while (brush->redo()) continue;
    return true;
}

const Registered names_target{
    {.name = "segment_names", .parse = parse_names, .cuts_are_refused = true, .needless_bytes = 1}};
const Registered history_target{
    {.name = "brush_history", .parse = parse_history, .cuts_are_refused = true, .needless_bytes = 1}};

// The position and direction of a camera, in a file or on the command line.

bool parse_world_from_camera(std::string_view bytes) {
    const auto frame = read_world_from_camera(file_of(bytes, "world.txt").string());
    const auto typed = read_world_from_camera(std::string(bytes.substr(0, 1024)));
    (void)is_taken(typed, Quotes::typed);
    if (!is_taken(frame)) return false;
    const glm::dmat4 back = glm::inverse(*frame) * *frame;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            require(std::isfinite((*frame)[column][row]), "a number is not finite");
            require(std::abs(back[column][row] - (column == row ? 1.0 : 0.0)) < 1e-6, "has no way back");
        }
    return true;
}

const Registered world_from_camera_target{{.name = "world_from_camera",
                                           .parse = parse_world_from_camera,
                                           .cuts_are_refused = true,
                                           .needless_bytes = 2,
                                           .most_bytes = 512,
                                           .most_live_mebibytes = 4}};

/// A recording of one part with a hash that is right, so that damage is not found by it alone.
std::string with_right_hash(std::string bytes) {
    constexpr std::size_t size = 8;
    if (bytes.size() < size) return bytes;
    ByteHash hash;
    hash.add(bytes.data(), bytes.size() - size);
    for (std::size_t k = 0; k < size; ++k)
        bytes[bytes.size() - size + k] = static_cast<char>(hash.value() >> (8 * k));
    return bytes;
}

bool parse_recording(std::string_view bytes) {
    const auto recording = read_recording(file_of(bytes, "touch.rec"));
    if (!is_taken(recording)) return false;
    require(!recording->empty(), "a recording without a part");
    for (const RecordedPart& part : *recording) {
        require(part.fingers > 0 && !part.ticks.empty(), "a part without fingers or ticks");
        for (const RecordedPart::Tick& tick : part.ticks)
            require(tick.goals.size() == static_cast<std::size_t>(part.fingers) &&
                        tick.forces.size() == tick.goals.size() && tick.guards.size() == tick.goals.size(),
                    "a tick has not one of each for a finger");
        TouchSetup setup;
        const auto scene = read_recorded_facts(part.facts, part.name, setup);
        if (!is_taken(scene)) return false;
        require(part.rules() >= 1, "rules of force below 1");
        for (const FrameRun& run : setup.recorded_frames.value_or(std::vector<FrameRun>()))
            require(run.first >= 0 && run.count >= 1, "a run of frames that cannot be");
    }
    return true;
}

bool parse_recording_and_mended(std::string_view bytes) {
    (void)parse_recording(with_right_hash(std::string(bytes)));
    return parse_recording(bytes);
}

bool parse_playback_script(std::string_view bytes) {
    const auto commands = parse_playback(bytes, "script");
    if (!is_taken(commands)) return false;
    require(bool(validate(*commands)), "commands that were read are invalid");
    (void)in_words(*commands);
    return true;
}

const Registered recording_target{
    {.name = "recording", .parse = parse_recording_and_mended, .cuts_are_refused = true}};
const Registered playback_target{{.name = "playback", .parse = parse_playback_script, .most_bytes = 1024}};

// Words of a person: options, scripts of the window and its settings, and text as messages quote it.

/// One text, read as every option that has words of its own.
bool parse_options(std::string_view bytes) {
    const std::string words(bytes);
    int taken = 0;
    if (const auto size = read_pixel_size("--size", words, 1, 8192); is_taken(size, Quotes::typed)) {
        require(size->width >= 1 && size->width <= 8192 && size->height >= 1 && size->height <= 8192,
                "a size beyond what was allowed");
        ++taken;
    }
    if (const auto number = read_whole_number<std::int64_t>("--n", words, -5, 5'000'000'000);
        is_taken(number, Quotes::typed)) {
        require(*number >= -5 && *number <= 5'000'000'000, "a number beyond what was allowed");
        ++taken;
    }
    if (const auto camera = read_live_camera(words); is_taken(camera, Quotes::typed)) {
        require(!camera->delivery.rate || camera->delivery.rate->num > 0, "a rate is not above 0");
        ++taken;
    }
    if (const auto view = parse_viewpoint(words); is_taken(view, Quotes::typed)) {
        require(std::abs(view->azimuth) <= 180 && std::abs(view->elevation) <= 89, "an impossible view");
        ++taken;
    }
    // A path that is there is read: another target's.
    CameraTyped typed;
    typed.intrinsics = words.substr(0, words.find_first_of("/."));
    taken += is_taken(read_camera(typed), Quotes::typed) ? 1 : 0;
    taken += is_taken(read_filters(words), Quotes::typed) ? 1 : 0;
    for (const FilterSetting& setting : filter_settings()) {
        FilterSettings filter;
        taken += setting.read(words, filter) ? 1 : 0;
    }
    return taken > 0;
}

bool parse_window_script(std::string_view bytes) {
    const auto inputs = read_window_script(file_of(bytes, "window.script"));
    if (!is_taken(inputs, Quotes::typed)) return false;
    double before = 0;
    for (const ScriptedInput& input : *inputs) {
        require(input.seconds >= before && input.seconds <= 1e6, "a moment is before the one above");
        before = input.seconds;
    }
    return true;
}

/// Settings survive a round trip through their file.
bool parse_settings(std::string_view bytes) {
    const auto file = file_of(bytes, "play.json");
    const SettingsFile kept(file);
    for (const std::string& aside : {file.string() + ".broken"}) std::filesystem::remove(aside);
    const auto written = file_of("{}", "again.json");
    require(bool(SettingsFile(written).write(kept.read())), "settings cannot be written");
    const SettingsFile again(written);
    require(again.message().empty(), "settings that were written are not right: " + again.message());
    require(again.read() == kept.read(), "settings are others when they are read again");
    return kept.message().empty();
}

bool parse_printable(std::string_view bytes) {
    constexpr std::size_t most = 40;
    for (const std::string& quoted : {printable(bytes, most), in_quotes(bytes)}) {
        for (const char c : quoted)
            require(static_cast<unsigned char>(c) >= 0x20 && c != '\x7f', "a control character is quoted");
        require(quoted.size() <= 4 * 80 + 5, "a quotation is long");
    }
    return true;
}

const Registered options_target{{.name = "options", .parse = parse_options, .most_bytes = 128}};
const Registered window_script_target{
    {.name = "window_script", .parse = parse_window_script, .most_bytes = 1024}};
const Registered settings_target{{.name = "settings", .parse = parse_settings, .most_bytes = 1024}};
const Registered printable_target{{.name = "printable", .parse = parse_printable, .most_bytes = 256}};

}  // namespace
}  // namespace touchable::fuzz
