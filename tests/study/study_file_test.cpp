// The file of a study, and the order in which its conditions come.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "player/window/study.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

const std::filesystem::path own_study =
    std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "share/study/paper-4.2.json";

TEST(StudyFile, ThatComesWithTheProgramHasThePapersStudyInEnglishAndGerman) {
    const auto study = parse_study(file_contents(own_study), "paper-4.2.json");
    ASSERT_TRUE(study) << study.error().message;
    EXPECT_EQ(study->name, "paper-4.2");
    ASSERT_EQ(study->conditions.size(), 2U);
    EXPECT_EQ(study->conditions[0].force, StudyForce::on);
    EXPECT_EQ(study->conditions[1].force, StudyForce::off);
    EXPECT_EQ(study->clips(), 1U);
    EXPECT_EQ(study->before.back().id, "trial");
    // What the paper reports of its questionnaire.
    std::set<std::string> asked;
    for (const StudyStep& step : study->after)
        for (const StudyQuestion& question : step.questions) asked.insert(question.id);
    for (const char* id :
         {"useful", "helped-details", "disable", "realistic-roughness", "realistic-heights", "tiring"})
        EXPECT_TRUE(asked.contains(id)) << id;
    // Every text is there in both languages, and in no third one.
    const auto check = [](const auto& self, const nlohmann::json& node) -> void {
        if (node.is_object() && node.contains("en")) {
            EXPECT_EQ(node.size(), 2U) << node;
            EXPECT_TRUE(node.contains("de")) << node;
        }
        for (const auto& [name, value] : node.items()) {
            if (name == "title" || name == "text" || name == "low" || name == "high") {
                EXPECT_TRUE(value.is_object()) << value;
            }
            if (value.is_structured()) self(self, value);
        }
    };
    check(check, nlohmann::json::parse(file_contents(own_study)));
    EXPECT_NE(study->all_words("de").find("ü"), std::string::npos);
    EXPECT_EQ(study->all_words("en").find("ü"), std::string::npos);
}

std::string message_of(const std::string& json) {
    const auto study = parse_study(json, "s.json");
    return study ? "" : study.error().message;
}

/// A study that is right, but for what replaces one of its parts.
std::string with(const std::string& part, const std::string& instead) {
    std::string json =
        R"({"touchable_study": 1, "name": "s", "start": {"title": "Hello", "text": "Begin"},)"
        R"( "before": [{"id": "trial", "kind": "touch", "text": "Try", "force": "on", "most_s": 60}],)"
        R"( "conditions": [{"name": "a", "force": "on"}, {"name": "b", "force": "off"}],)"
        R"( "in_each_condition": [{"id": "globe", "kind": "touch", "text": "Touch"},)"
        R"( {"id": "about", "kind": "questions", "questions": [)"
        R"({"id": "rough", "text": "Rough?", "scale": {"least": 1, "most": 5, "low": "no", "high": "yes"}},)"
        R"({"id": "liked", "text": "Liked?", "choices": [{"value": "y", "text": "Yes"}, {"value": "n", "text": "No"}]}]}]})";
    const std::size_t at = json.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    return json.replace(at, part.size(), instead);
}

TEST(StudyFile, ThatCannotBeIsOneLineWithThePlaceAndWhatWouldBeRight) {
    EXPECT_EQ(message_of(with("Hello", "Hello")), "");
    const struct {
        const char *part, *instead, *where, *right;
    } faults[] = {{"\"touchable_study\": 1", "\"touchable_study\": 2", "touchable_study", "1"},
                  {"\"name\": \"s\"", "\"name\": \"a, b\"", "name", "letters, digits"},
                  {"\"name\": \"s\",", "", "name", ""},
                  {"\"Hello\"", "{\"Deutsch\": \"Hallo\"}", "start.title", "languages"},
                  {"\"Hello\"", "{}", "start.title", "a text"},
                  {"\"Hello\"", "[]", "start.title", "a line"},
                  {"\"Hello\"", "\"\"", "start.title", "a line"},
                  {"\"kind\": \"touch\"", "\"kind\": \"dance\"", "before[0].kind", "questions"},
                  {"\"force\": \"on\", \"most_s\"", "\"force\": true, \"most_s\"", "before[0].force", "off"},
                  {"\"most_s\": 60", "\"most_s\": 0", "before[0].most_s", "more than 0"},
                  {"\"most_s\": 60", "\"most_s\": 5, \"least_s\": 9", "before[0].most_s", "least_s"},
                  {"\"most_s\": 60", "\"most_s\": -1", "before[0].most_s", "a day"},
                  {"\"most_s\": 60", "\"clip\": 0", "before[0].clip", "1"},
                  {"\"most_s\": 60", "\"seconds\": 6", "seconds", "most_s"},
                  {"\"text\": \"Touch\"", "\"text\": \"Touch\", \"force\": \"on\"",
                   "in_each_condition[0].force", "condition"},
                  {"\"id\": \"globe\"", "\"id\": \"trial\"", "in_each_condition[0].id", "of its own"},
                  {"\"id\": \"liked\"", "\"id\": \"globe\"", "questions[1].id", "of its own"},
                  {"\"id\": \"globe\"", "\"id\": \"end\"", "in_each_condition[0].id", "of its own"},
                  {"\"name\": \"b\"", "\"name\": \"a\"", "conditions[1].name", "of its own"},
                  {"\"force\": \"off\"", "\"force\": \"half\"", "conditions[1].force", "off"},
                  {"\"most\": 5", "\"most\": 1", "scale", "more"},
                  {"\"most\": 5", "\"most\": 100", "most", "10"},
                  {"\"value\": \"n\"", "\"value\": \"y\"", "choices[1].value", "of its own"},
                  {", {\"value\": \"n\", \"text\": \"No\"}", "", "choices", "2 to 6"},
                  {"\"choices\"", "\"chioces\"", "chioces", "choices"},
                  {"\"conditions\": [{\"name\": \"a\", \"force\": \"on\"}, {\"name\": \"b\", \"force\": "
                   "\"off\"}],",
                   "", "in_each_condition", "both"},
                  {"\"start\"", "\"start", "s.json: ", ""}};
    for (const auto& fault : faults) {
        const std::string message = message_of(with(fault.part, fault.instead));
        EXPECT_EQ(message.find("s.json: "), 0U) << fault.instead << ": " << message;
        EXPECT_NE(message.find(fault.where), std::string::npos) << fault.instead << ": " << message;
        EXPECT_NE(message.find(fault.right), std::string::npos) << fault.instead << ": " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
    EXPECT_NE(message_of(R"({"touchable_study": 1, "name": "s", "start": {"title": "a", "text": "b"}})"), "");
    EXPECT_NE(message_of("[]"), "");
}

/// Two take turns; of more each has each place, and each other before it, equally often.
TEST(StudyOrder, IsBalancedBetweenParticipants) {
    using Order = std::vector<std::size_t>;
    EXPECT_EQ(order_of_conditions(2, 1), (Order{0, 1}));
    EXPECT_EQ(order_of_conditions(2, 2), (Order{1, 0}));
    EXPECT_EQ(order_of_conditions(2, 3), (Order{0, 1}));
    EXPECT_EQ(order_of_conditions(0, 5), Order{});
    for (std::size_t count = 1; count <= most_study_conditions; ++count) {
        const std::size_t rows = count % 2 == 0 ? count : 2 * count;
        std::map<std::pair<std::size_t, std::size_t>, std::size_t> places, followers;
        for (std::size_t number = 1; number <= rows; ++number) {
            const Order order = order_of_conditions(count, number);
            EXPECT_EQ(std::set<std::size_t>(order.begin(), order.end()).size(), count);
            EXPECT_EQ(order, order_of_conditions(count, number + rows));
            for (std::size_t k = 0; k < count; ++k) ++places[{k, order[k]}];
            for (std::size_t k = 1; k < count; ++k) ++followers[{order[k - 1], order[k]}];
        }
        EXPECT_EQ(places.size(), count * count);
        for (const auto& [place, times] : places) EXPECT_EQ(times, rows / count) << count;
        EXPECT_EQ(followers.size(), count * (count - 1));
        for (const auto& [pair, times] : followers) EXPECT_EQ(times, rows / count) << count;
    }
}

}  // namespace
}  // namespace touchable::test
