#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/result.hpp"
#include "player/study/participant_file.hpp"
#include "player/study/study.hpp"
#include "player/study/study_screen.hpp"
#include "player/study/touch_meter.hpp"

namespace touchable {

/// A study as it goes: one participant after the other, from the start screen through all screens and back to
/// it, and a file of results for each. Times `now_s` are the window's own, seconds, and do not go backward.
class StudyRun {
public:
    using Time = std::chrono::system_clock::time_point;
    /// Shorter than that nobody reads a screen: a click that was one too many goes on to nothing.
    static constexpr double least_s = 0.4;

    /// `hand`: what participants touch by, as results have it: "mouse", or a device's name. `folder` is made
    /// where it is not there. Refused (ErrorKind::input) where no results can be written.
    static Result<std::unique_ptr<StudyRun>> open(Study study, std::filesystem::path folder,
                                                  std::string language, std::string hand);

    const Study& study() const { return study_; }
    const std::string& language() const { return language_; }
    /// Measures what participants touch: a sink of the window's sessions.
    const std::shared_ptr<TouchMeter>& meter() const { return meter_; }

    /// Null: the start screen, and nobody has begun.
    const StudyScreen* screen() const { return screens_.empty() ? nullptr : &screens_[at_]; }
    /// Changes with each screen.
    std::size_t turn() const { return turn_; }
    /// Of the participant's screens, how many are behind, 0 to 1.
    double share_done() const;
    /// That was chosen of a question's answers, from 0.
    std::optional<std::size_t> chosen() const { return chosen_; }
    /// The clip of the touch that is on, or comes next, from 0.
    std::size_t clip() const;
    /// Whether the participant is to be given forces now.
    bool gives_force() const;

    /// An answer; nothing happens where there is no such one.
    void choose(std::size_t answer);
    /// The answer `by` further; the first, or last, where none was chosen.
    void choose_by(int by);
    /// How long the screen is still to be seen, seconds, before anybody may go on; 0: that is over.
    double wait_s(double now_s) const;
    /// Whether `go_on` would: time enough has passed, a question is answered.
    bool may_go_on(double now_s) const;
    /// The participant begins, or has done with the screen.
    void go_on(double now_s, Time time);
    /// Goes on by itself where its time has passed.
    void pass(double now_s, Time time);
    /// The screen is not to be seen yet: its time begins now.
    void wait(double now_s);
    /// The participant went away. (Who has answered everything has finished.)
    void leave(double now_s, Time time);
    /// The program ends. Refused where results are missing.
    Result<void> end(double now_s, Time time);

    /// Why answers are not kept, now; nothing where they are.
    std::optional<Error> fault() const;

private:
    StudyRun(Study study, std::filesystem::path folder, std::string language, std::string hand)
        : study_(std::move(study)),
          folder_(std::move(folder)),
          language_(std::move(language)),
          hand_(std::move(hand)) {}
    void begin(double now_s);
    void begin_screen(double now_s);
    void add_row(double now_s, Time time, const std::string& answer);
    void finish(ParticipantFile::End end, double now_s);
    std::string row(const std::string& rest, Time time) const;

    const Study study_;
    const std::filesystem::path folder_;
    const std::string language_, hand_;
    const std::shared_ptr<TouchMeter> meter_ = std::make_shared<TouchMeter>();
    std::vector<StudyScreen> screens_;  // of the participant; empty: nobody
    std::size_t at_ = 0, turn_ = 0;
    double began_s_ = 0, came_s_ = 0;  // the screen, the participant
    std::optional<std::size_t> chosen_;
    std::optional<ParticipantFile> file_;
    std::optional<ParticipantFile::End> ended_;  // that `file_` could not be finished with
    std::optional<Error> no_file_;
};

}  // namespace touchable
