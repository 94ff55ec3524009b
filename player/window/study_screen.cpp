#include "player/window/study_screen.hpp"

namespace touchable {
namespace {

void add(std::vector<StudyScreen>& screens, const std::vector<StudyStep>& steps,
         const StudyCondition* condition, std::size_t place) {
    for (const StudyStep& step : steps) {
        if (step.kind != StudyStep::Kind::questions) {
            screens.push_back({&step, nullptr, condition, place});
            continue;
        }
        for (const StudyQuestion& question : step.questions)
            screens.push_back({&step, &question, condition, place});
    }
}

}  // namespace

std::vector<StudyScreen> screens_of(const Study& study, std::size_t number) {
    std::vector<StudyScreen> screens;
    add(screens, study.before, nullptr, 0);
    std::size_t place = 0;
    for (const std::size_t k : order_of_conditions(study.conditions.size(), number))
        add(screens, study.in_each_condition, &study.conditions[k], ++place);
    add(screens, study.after, nullptr, 0);
    return screens;
}

}  // namespace touchable
