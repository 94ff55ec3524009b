#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "player/window/study.hpp"

namespace touchable {

/// What a participant has before him at a time: a text, a touch, or one question. Refers to its study.
struct StudyScreen {
    const StudyStep* step = nullptr;
    const StudyQuestion* question = nullptr;    ///< null: it is none
    const StudyCondition* condition = nullptr;  ///< null: outside
    std::size_t place = 0;                      ///< of the condition in the order, from 1; 0: outside

    bool is_touch() const { return step->kind == StudyStep::Kind::touch; }
    StudyForce force() const { return condition ? condition->force : step->force; }
    std::size_t clip() const { return condition ? condition->clip.value_or(step->clip) : step->clip; }
};

/// Of participant `number`, from 1, in the order in which they come.
std::vector<StudyScreen> screens_of(const Study& study, std::size_t number);

}  // namespace touchable
