#include "player/window/study.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "engine/scene/checked_json.hpp"
#include "player/window/plain_line.hpp"
#include "player/window/touch_labels.hpp"

namespace touchable {
namespace {

using Node = checked_json::Node;
using Kind = StudyStep::Kind;

constexpr std::size_t most_steps = 100, most_questions = 50, most_choices = 6, most_lines = 8,
                      longest_id = 40;
constexpr std::int64_t most_clips = 1000, largest_answer = 10;
constexpr double longest_s = 24 * 3600;
constexpr std::pair<const char*, StudyForce> forces[] = {{"on", StudyForce::on}, {"off", StudyForce::off}};

/// A name that stands in a table, and in formulas of whoever reads that.
std::string read_id(const Node& node) {
    std::string id = node.text();
    const auto is_legal = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
               c == '_' || c == '.';
    };
    if (id.empty() || id.size() > longest_id || !std::ranges::all_of(id, is_legal))
        node.refuse("a name of up to " + std::to_string(longest_id) +
                    " letters, digits, hyphens, points and underscores");
    return id;
}

std::string read_lines(const Node& node) {
    if (!node.is_list()) return read_plain_line(node);
    std::string lines;
    for (const Node& line : node.elements(1, most_lines, "a line, or up to 8 of them")) {
        if (!lines.empty()) lines += '\n';
        lines += read_plain_line(line);
    }
    return lines;
}

/// A line or several of any language, or an object with those of each.
StudyWords read_words(const Node& node) {
    if (!node.is_object()) return {{"", read_lines(node)}};
    StudyWords words;
    for (const std::string& language : node.members()) {
        if (!is_language(language)) node.refuse("an object of languages, such as {\"en\": ..., \"de\": ...}");
        words.emplace(language, read_lines(node[language.c_str()]));
    }
    if (words.empty()) node.refuse("a text, or an object of one for each language");
    return words;
}

double read_seconds(const Node& node) {
    const double seconds = node.number();
    if (!(seconds >= 0 && seconds <= longest_s)) node.refuse("seconds, up to a day of them");
    return seconds;
}

std::size_t read_clip(const Node& node) {
    return static_cast<std::size_t>(node.integer(1, most_clips) - 1);
}

void read_scale(const Node& node, StudyQuestion& question) {
    node.allow_only({"least", "most", "low", "high"});
    question.is_scale = true;
    const std::int64_t least = node["least"].integer(0, largest_answer),
                       most = node["most"].integer(0, largest_answer);
    if (most <= least) node.refuse("from least to most, which is more");
    for (std::int64_t value = least; value <= most; ++value)
        question.answers.push_back({std::to_string(value), {{"", std::to_string(value)}}});
    question.low = read_words(node["low"]);
    question.high = read_words(node["high"]);
}

void read_choices(const Node& node, StudyQuestion& question) {
    std::set<std::string> values;
    for (const Node& choice : node.elements(2, most_choices, "a list of 2 to 6 choices")) {
        choice.allow_only({"value", "text"});
        StudyAnswer& answer = question.answers.emplace_back();
        answer.value = read_id(choice["value"]);
        answer.words = read_words(choice["text"]);
        if (!values.insert(answer.value).second) choice["value"].refuse("a value of its own");
    }
}

StudyQuestion read_question(const Node& node) {
    node.allow_only({"id", "text", "scale", "choices"});
    StudyQuestion question;
    question.id = read_id(node["id"]);
    question.words = read_words(node["text"]);
    if (node.has("scale") == node.has("choices")) node.refuse("a question with a scale, or with choices");
    if (node.has("scale"))
        read_scale(node["scale"], question);
    else
        read_choices(node["choices"], question);
    return question;
}

void read_times(const Node& node, StudyStep& step) {
    if (node.has("least_s")) step.least_s = read_seconds(node["least_s"]);
    if (!node.has("most_s")) return;
    step.most_s = read_seconds(node["most_s"]);
    if (*step.most_s < step.least_s || *step.most_s == 0)
        node["most_s"].refuse("more than 0, and no less than least_s");
}

/// `in_condition`: the force is the condition's.
StudyStep read_step(const Node& node, bool in_condition) {
    constexpr std::pair<const char*, Kind> kinds[] = {
        {"text", Kind::text}, {"touch", Kind::touch}, {"questions", Kind::questions}};
    StudyStep step;
    step.kind = node["kind"].one_of(kinds);
    step.id = read_id(node["id"]);
    if (step.kind == Kind::questions) {
        node.allow_only({"id", "kind", "questions"});
        for (const Node& question :
             node["questions"].elements(1, most_questions, "a list of 1 to 50 questions"))
            step.questions.push_back(read_question(question));
        return step;
    }
    read_times(node, step);
    step.words = read_words(node["text"]);
    if (step.kind == Kind::text) {
        node.allow_only({"id", "kind", "title", "text", "least_s", "most_s"});
        if (node.has("title")) step.title = read_words(node["title"]);
        return step;
    }
    node.allow_only({"id", "kind", "text", "least_s", "most_s", "clip", "force"});
    if (node.has("clip")) step.clip = read_clip(node["clip"]);
    if (node.has("force") && in_condition) node["force"].refuse("left out: the condition has it");
    if (node.has("force")) step.force = node["force"].one_of(forces);
    return step;
}

StudyCondition read_condition(const Node& node) {
    node.allow_only({"name", "force", "clip"});
    StudyCondition condition;
    condition.name = read_id(node["name"]);
    condition.force = node["force"].one_of(forces);
    if (node.has("clip")) condition.clip = read_clip(node["clip"]);
    return condition;
}

/// Each step, and each question, is told from the others by its name: `known`.
std::vector<StudyStep> read_steps(const Node& node, const char* member, bool in_condition,
                                  std::set<std::string>& known) {
    std::vector<StudyStep> steps;
    if (!node.has(member)) return steps;
    const auto is_new = [&](const Node& id) {
        if (!known.insert(id.text()).second) id.refuse("a name of its own");
    };
    for (const Node& step : node[member].elements(1, most_steps, "a list of 1 to 100 steps")) {
        steps.push_back(read_step(step, in_condition));
        is_new(step["id"]);
        if (steps.back().kind != Kind::questions) continue;
        for (const Node& question : step["questions"].elements(1, most_questions, "questions"))
            is_new(question["id"]);
    }
    return steps;
}

Study read_study(const Node& node) {
    node.allow_only(
        {"touchable_study", "name", "idle_s", "start", "before", "conditions", "in_each_condition", "after"});
    if (node["touchable_study"].integer(1, 1'000'000) != 1)
        node["touchable_study"].refuse("1, the version that is read here");
    Study study;
    study.name = read_id(node["name"]);
    if (node.has("idle_s")) study.idle_s = read_seconds(node["idle_s"]);
    if (study.idle_s < 1) node["idle_s"].refuse("at least a second");
    const Node start = node["start"];
    start.allow_only({"title", "text"});
    study.title = read_words(start["title"]);
    study.words = read_words(start["text"]);
    std::set<std::string> known{"end"};  // the last row of a participant's table
    study.before = read_steps(node, "before", false, known);
    study.in_each_condition = read_steps(node, "in_each_condition", true, known);
    study.after = read_steps(node, "after", false, known);
    if (node.has("conditions") != node.has("in_each_condition"))
        node.refuse("both conditions and in_each_condition, or neither");
    if (study.before.empty() && study.after.empty() && study.in_each_condition.empty())
        node.refuse("a study of one step at least: before, in_each_condition, after");
    if (!node.has("conditions")) return study;
    std::set<std::string> names;
    for (const Node& condition : node["conditions"].elements(
             1, most_study_conditions,
             "a list of 1 to " + std::to_string(most_study_conditions) + " conditions")) {
        study.conditions.push_back(read_condition(condition));
        if (!names.insert(study.conditions.back().name).second) condition["name"].refuse("a name of its own");
    }
    return study;
}

}  // namespace

std::size_t Study::clips() const {
    std::size_t clips = 1;
    for (const auto* const steps : {&before, &in_each_condition, &after})
        for (const StudyStep& step : *steps) clips = std::max(clips, step.clip + 1);
    for (const StudyCondition& condition : conditions)
        clips = std::max(clips, condition.clip.value_or(0) + 1);
    return clips;
}

std::string Study::all_words(const std::string& language) const {
    std::string all = "0123456789";
    const auto add = [&](const StudyWords& words) {
        if (const std::string* const said = said_in(words, language)) all += *said;
    };
    add(title);
    add(words);
    for (const auto* const steps : {&before, &in_each_condition, &after})
        for (const StudyStep& step : *steps) {
            add(step.title);
            add(step.words);
            for (const StudyQuestion& question : step.questions) {
                add(question.words);
                add(question.low);
                add(question.high);
                for (const StudyAnswer& answer : question.answers) add(answer.words);
            }
        }
    return all;
}

Result<Study> parse_study(std::string_view json, std::string_view where) {
    try {
        const checked_json::Json text = checked_json::parse(json, largest_study);
        return read_study(Node(text, ""));
    } catch (const checked_json::Refusal& reason) {
        return input_error(std::string(where) + ": " + reason.message);
    }
}

std::vector<std::size_t> order_of_conditions(std::size_t count, std::size_t number) {
    const std::size_t rows = count % 2 == 0 ? count : 2 * count,
                      row = (number - 1) % std::max<std::size_t>(rows, 1);
    std::vector<std::size_t> order;
    // 0, 1, n - 1, 2, n - 2, ...: each row is the first one, shifted.
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t first = k % 2 == 1 ? (k + 1) / 2 : (count - k / 2) % count;
        order.push_back((first + row) % count);
    }
    // Of an odd number of conditions half of the followers come in the mirrored rows.
    if (row >= count) std::ranges::reverse(order);
    return order;
}

}  // namespace touchable
