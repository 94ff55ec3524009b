#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// What a participant reads, by language; "" is any. Lines are separated by \n.
using StudyWords = std::map<std::string, std::string>;

/// Whether a finger's force reaches the participant. Without it everything else is the same.
enum class StudyForce { on, off };

struct StudyAnswer {
    std::string value;  ///< as results have it
    StudyWords words;   ///< of a choice; of a scale the number itself
};

struct StudyQuestion {
    std::string id;
    StudyWords words;
    std::vector<StudyAnswer> answers;
    bool is_scale = false;  ///< numbers in a row, between two ends; otherwise choices
    StudyWords low, high;   ///< what its ends mean
};

struct StudyStep {
    enum class Kind { text, touch, questions };
    Kind kind = Kind::text;
    std::string id;
    StudyWords title, words;  ///< a touch has no title
    double least_s = 0;       ///< before a participant may go on
    std::optional<double> most_s;
    std::size_t clip = 0;  ///< of a touch, from 0
    StudyForce force = StudyForce::on;
    std::vector<StudyQuestion> questions;
};

struct StudyCondition {
    std::string name;
    StudyForce force = StudyForce::on;
    std::optional<std::size_t> clip;  ///< nothing: that of the step
};

/// A study: what each participant reads, touches and answers. As JSON:
/// {"touchable_study": 1, "name": "paper-4.2", "idle_s": 180,
///  "start": {"title": {"en": ...}, "text": {"en": ..., "de": [line, line]}},
///  "before": [steps],
///  "conditions": [{"name": "force-on", "force": "on"}, {"name": "force-off", "force": "off"}],
///  "in_each_condition": [steps],
///  "after": [steps]}
/// A step is one of
///  {"id": "welcome", "kind": "text", "title": ..., "text": ...}
///  {"id": "trial", "kind": "touch", "text": ..., "clip": 1, "force": "on"}
///  {"id": "after-trial", "kind": "questions", "questions": [
///    {"id": "rough", "text": ..., "scale": {"least": 1, "most": 7, "low": ..., "high": ...}},
///    {"id": "useful", "text": ..., "choices": [{"value": "yes", "text": ...}, ...]}]}
/// each with "least_s" and "most_s" besides (not questions). Clips count from 1.
struct Study {
    std::string name;
    double idle_s = 180;  ///< without input, until a participant has left
    StudyWords title, words;
    std::vector<StudyStep> before, in_each_condition, after;
    std::vector<StudyCondition> conditions;

    /// The largest number of a clip, from 1.
    std::size_t clips() const;
    /// All that a participant reads in that language, for its letters.
    std::string all_words(const std::string& language) const;
};

inline constexpr std::size_t most_study_conditions = 8;
/// A longer file is refused, bytes.
inline constexpr std::size_t largest_study = std::size_t{1} << 18;

/// Refused (ErrorKind::input, beginning with `where`) where that cannot be.
Result<Study> parse_study(std::string_view json, std::string_view where);

/// In which order participants meet `count` conditions: that of participant `number`, from 1. Two take turns.
/// With more each has each place equally often, and each follows each other equally often (Williams'
/// designs), in every `count` participants, or twice as many where `count` is odd.
std::vector<std::size_t> order_of_conditions(std::size_t count, std::size_t number);

}  // namespace touchable
