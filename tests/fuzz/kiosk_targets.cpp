// What whoever sets up an exhibit writes: its words, its labels, its study.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "player/window/kiosk.hpp"
#include "player/window/study.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

constexpr std::size_t longest_line = 200;

/// What a window writes: lines of UTF-8 that are not empty.
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

/// Whoever takes part, the same screens in an order of conditions; each with words, and told from the others.
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
    require(study->idle_s >= 1, "whoever begins has left at once");
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

}  // namespace
}  // namespace touchable::fuzz
