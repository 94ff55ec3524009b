#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "player/window/window_command.hpp"

namespace touchable {

/// What a participant of a study has before him, in his language.
struct StudyFacts {
    bool is_page = true;  ///< over all of the window; otherwise a strip below the picture that is touched
    bool shows_force = false;          ///< of a strip: whether forces are to be seen
    std::string title, words;          ///< either may be empty; of a question the words
    std::vector<std::string> answers;  ///< of a question; empty: it is none
    bool is_scale = false;             ///< they are numbers in a row, between two ends
    std::string low, high;             ///< what those mean
    std::optional<std::size_t> chosen{};
    std::string go_on;  ///< on the button; empty: there is none
    bool may_go_on = false;
    int wait_s = 0;         ///< seconds until it may, which are said on the button; 0: no time is waited for
    double share_done = 0;  ///< of the study, 0 to 1
    std::string fault;      ///< that a participant is to call somebody; empty: all is well
};

/// How high the strip is, in a window of that size.
float study_strip_height(float width, float height);

/// Draws it, and takes clicks: of an answer, and of the button. In an ImGui window of its own, whose
/// ImGui::End is the caller's. Between ImGuiLayer's `begin` and `end`; sizes in pixels.
void begin_study(const StudyFacts& facts, float width, float height, std::vector<WindowCommand>& asked);

}  // namespace touchable
