#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "player/window/disk_work.hpp"
#include "player/window/study.hpp"
#include "player/window/study_results.hpp"
#include "player/window/study_screen.hpp"
#include "player/window/touch_meter.hpp"

namespace touchable {

/// A study as it goes: one participant after the other, from the start screen through all screens and back to
/// it, and a file of results for each. No call waits for the disk but `wait_for_disk` and `end`. Times
/// `now_s` are the window's own, seconds, and do not go backward.
class StudyRun {
public:
    using Time = std::chrono::system_clock::time_point;
    /// Shorter than that nobody reads a screen: a click that was one too many goes on to nothing.
    static constexpr double least_s = 0.4;
    /// Who has waited for a disk for that long is told.
    static constexpr double patience_s = 5;

    /// `hand`: what participants touch by, as results have it: "mouse", or a device's name. `folder` is made
    /// where it is not there, and `disk` writes there. Refused (ErrorKind::input) where no results can be
    /// written.
    static Result<std::unique_ptr<StudyRun>> open(Study study, std::filesystem::path folder,
                                                  std::string language, std::string hand,
                                                  std::unique_ptr<DiskWork> disk);

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
    /// The participant has done with the screen, or begins: `pass` has the first screen once there is a file.
    void go_on(double now_s, Time time);
    /// To be called all the time: goes on by itself where its time has passed, or the disk has answered.
    void pass(double now_s, Time time);
    /// The screen is not to be seen yet: its time begins now.
    void wait(double now_s);
    /// The participant went away. (Who has answered everything has finished.)
    void leave(double now_s, Time time);
    /// The program ends; the last call. Refused where results are missing.
    Result<void> end(double now_s, Time time, std::chrono::milliseconds longest = std::chrono::seconds(2));

    /// Whether a participant has begun, and waits for a file of results.
    bool is_beginning() const { return is_beginning_; }
    /// Whether all that was done until now is kept, or refused, after that long at most.
    bool wait_for_disk(std::chrono::milliseconds longest) const { return results_.wait(longest); }
    /// Why answers are not kept, now; nothing where they are.
    std::optional<Error> fault() const;

private:
    StudyRun(Study study, std::filesystem::path folder, std::string language, std::string hand,
             std::unique_ptr<DiskWork> disk);
    void begin_if_answered(double now_s);
    void begin_screen(double now_s);
    void add_row(double now_s, Time time, const std::string& answer);
    void finish(ParticipantFile::End end, double now_s);
    std::string row(const std::string& rest, Time time) const;

    const Study study_;
    const std::string language_, hand_;
    const std::shared_ptr<TouchMeter> meter_ = std::make_shared<TouchMeter>();
    std::vector<StudyScreen> screens_;  // of the participant; empty: nobody
    std::size_t at_ = 0, turn_ = 0;
    double began_s_ = 0, came_s_ = 0;  // the screen, the participant
    std::optional<std::size_t> chosen_;
    StudyResults results_;
    bool is_beginning_ = false;
    double passed_s_ = 0;    // the last `pass`
    double answered_s_ = 0;  // the last one at which the disk had nothing to do
};

}  // namespace touchable
