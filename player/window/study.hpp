// SPDX-License-Identifier: Apache-2.0
#pragma once

// A study whose participants are a kiosk's visitors: its file (Study), the order of conditions for each
// participant, the resulting screens, the measurements of touch, and the run that guides participants and
// stores their results (StudyRun).

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/base/words.hpp"
#include "player/run/touch_session.hpp"
#include "player/window/background_writer.hpp"

namespace touchable {

/// A text for participants, by language; "" is any. Lines are separated by \n.
using StudyWords = std::map<std::string, std::string>;

/// Whether forces reach the participant's hand. Everything else is the same.
enum class StudyForce { on, off };

struct StudyAnswer {
    std::string value;  ///< in the table of results
    StudyWords words;   ///< a choice's text; on a scale, the number
};

struct StudyQuestion {
    std::string id;
    StudyWords words;
    std::vector<StudyAnswer> answers;
    bool is_scale = false;  ///< a row of numbers between two ends; otherwise choices
    StudyWords low, high;   ///< meaning of the ends
};

struct StudyStep {
    enum class Kind { text, touch, questions };
    Kind kind = Kind::text;
    std::string id;
    StudyWords title, words;  ///< a touch has no title
    double least_s = 0;       ///< minimum before a participant may continue
    std::optional<double> most_s;
    std::size_t clip = 0;  ///< of a touch, from 0
    StudyForce force = StudyForce::on;
    std::vector<StudyQuestion> questions;
};

struct StudyCondition {
    std::string name;
    StudyForce force = StudyForce::on;
    std::optional<std::size_t> clip;  ///< nullopt: the step's
};

/// A study: the texts, touches and questions for each participant. As JSON:
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
    double idle_s = 180;  ///< without input, until a participant counts as gone
    StudyWords title, words;
    std::vector<StudyStep> before, in_each_condition, after;
    std::vector<StudyCondition> conditions;

    /// The largest clip number, from 1.
    std::size_t clips() const;
    /// All texts for participants in that language, to find the glyphs that they need.
    std::string all_words(const std::string& language) const;
};

inline constexpr std::size_t most_study_conditions = 8;
/// Maximum file size, bytes.
inline constexpr std::size_t largest_study = std::size_t{1} << 18;

/// Fails with ErrorKind::input; the message begins with `where`.
Result<Study> parse_study(std::string_view json, std::string_view where);

/// The order of `count` conditions for participant `number`, from 1. Two conditions alternate. Of more, each
/// has each place equally often, and each follows each other equally often (Williams' designs), in every
/// `count` participants, or in twice as many if `count` is odd.
std::vector<std::size_t> order_of_conditions(std::size_t count, std::size_t number);

/// A participant's screen: a text, a touch, or one question. Refers to its study.
struct StudyScreen {
    const StudyStep* step = nullptr;
    const StudyQuestion* question = nullptr;    ///< null: a text or a touch
    const StudyCondition* condition = nullptr;  ///< null: outside
    std::size_t place = 0;                      ///< of the condition in the order, from 1; 0: outside

    bool is_touch() const { return step->kind == StudyStep::Kind::touch; }
    StudyForce force() const { return condition ? condition->force : step->force; }
    std::size_t clip() const { return condition ? condition->clip.value_or(step->clip) : step->clip; }
};

/// The screens of participant `number`, from 1, in their order.
std::vector<StudyScreen> screens_of(const Study& study, std::size_t number);

/// Measurements of a touch, from the session's ticks.
struct TouchMeasures {
    double contact_s = 0;     ///< with at least one finger touching
    int touches = 0;          ///< number of contacts made by fingers
    double mean_newtons = 0;  ///< on the finger with the largest force, over the time of contact; 0: none
    double most_newtons = 0;  ///< on any finger
};

/// Measures one touch after another. A session's thread calls `consume`, the window's the rest.
class TouchMeter final : public TouchSink {
public:
    Result<void> consume(const TouchTick& tick) override;
    /// Begins a touch. With force on, it measures the forces that reach the hand (all forces, for a mouse);
    /// with force off, those that the hand would have felt.
    void begin(StudyForce force);
    TouchMeasures measures() const;

private:
    mutable std::mutex mutex_;
    StudyForce force_ = StudyForce::on;
    std::int64_t contact_ticks_ = 0;
    double sum_newtons_ = 0;
    TouchMeasures measured_;
    std::vector<bool> touched_;  // by finger, in the previous tick
};

/// A running study: one participant after another, from the start screen through all screens and back. The
/// results of each are a table (CSV) in the study's folder: participant-007.partial.csv while it grows,
/// participant-007.csv once complete, participant-007.left.csv if the participant left. Each row is synced to
/// disk before the next one, and nothing is overwritten. A separate thread writes them: only `wait_for_disk`
/// and `end` wait for the disk. All calls belong to the window's thread. Times `now_s` are the window's,
/// seconds, monotonic.
class StudyRun {
public:
    using Time = std::chrono::system_clock::time_point;
    /// Minimum time of a screen, so that an extra click does not skip a screen unread.
    static constexpr double least_s = 0.4;
    /// Waiting time for the disk after which `fault` reports it.
    static constexpr double patience_s = 5;

    /// `hand`: the participants' input device, for the results: "mouse", or a device's name. Creates `folder`
    /// if necessary; `writer` writes there. Fails (ErrorKind::input) if results cannot be written.
    static Result<std::unique_ptr<StudyRun>> open(Study study, std::filesystem::path folder,
                                                  std::string language, std::string hand,
                                                  std::unique_ptr<BackgroundWriter> writer);

    const Study& study() const { return study_; }
    const std::string& language() const { return language_; }
    /// Measures participants' touches: a sink of the window's sessions.
    const std::shared_ptr<TouchMeter>& meter() const { return meter_; }

    /// Null: the start screen; no participant has begun.
    const StudyScreen* screen() const { return screens_.empty() ? nullptr : &screens_[at_]; }
    /// Changes with each screen.
    std::size_t turn() const { return turn_; }
    /// Completed share of the participant's screens, 0 to 1.
    double share_done() const {
        if (screens_.empty()) return 0;
        return static_cast<double>(at_) / static_cast<double>(screens_.size());
    }
    /// The chosen answer of a question, from 0.
    std::optional<std::size_t> chosen() const { return chosen_; }
    /// The clip of the current or next touch, from 0.
    std::size_t clip() const;
    /// Whether the participant receives forces now.
    bool gives_force() const {
        return screen() && screen()->is_touch() && screen()->force() == StudyForce::on;
    }

    /// Chooses an answer; does nothing if there is no such answer.
    void choose(std::size_t answer) {
        if (screen() && screen()->question && answer < screen()->question->answers.size()) chosen_ = answer;
    }
    /// Chooses the answer `by` further; the first, or last, if none was chosen.
    void choose_by(int by);
    /// Seconds until the participant may continue.
    double wait_s(double now_s) const {
        const double all = screen() ? std::max(screen()->step->least_s, least_s) : least_s;
        return std::max(began_s_ + all - now_s, 0.0);
    }
    /// Whether `go_on` would continue: enough time has passed, and a question is answered.
    bool may_go_on(double now_s) const {
        if (wait_s(now_s) > 0) return false;
        return screen() ? chosen_ || !screen()->question : !is_beginning_;
    }
    /// Completes the screen, or begins a participant: `pass` shows the first screen once there is a file.
    void go_on(double now_s, Time time);
    /// Call regularly: continues when the screen's time has passed, or the disk has answered.
    void pass(double now_s, Time time);
    /// The screen cannot be shown yet: restarts its time.
    void wait(double now_s);
    /// The participant left. One who has answered everything has finished.
    void leave(double now_s, Time time);
    /// Call last, at the program's end. Fails if results are missing.
    Result<void> end(double now_s, Time time, std::chrono::milliseconds longest = std::chrono::seconds(2));

    /// Whether a participant has begun, and waits for a results file.
    bool is_beginning() const { return is_beginning_; }
    /// Waits for `longest` at most; returns whether all results so far are stored or refused.
    bool wait_for_disk(std::chrono::milliseconds longest) const { return writer_->wait(longest); }
    /// Why answers are currently not stored; nullopt: they are.
    std::optional<Error> fault() const {
        return passed_s_ > answered_s_ + patience_s ? std::optional(no_answer()) : fault_;
    }

private:
    class Tables;
    StudyRun(Study study, std::string language, std::string hand, std::shared_ptr<Tables> tables,
             std::unique_ptr<BackgroundWriter> writer);
    void write(std::function<Result<void>(Tables& tables)> work, std::string tag = {});
    void take_written(double now_s);
    void add(const std::string& row);
    Error no_answer() const;
    void begin_screen(double now_s);
    void add_row(double now_s, Time time, const std::string& answer);
    /// The last row of a participant.
    void add_end(double now_s, Time time, const char* how) {
        add(row(formatted(",,end,,%s,%.2f,,,,", how, now_s - came_s_), time));
    }
    void finish(bool is_whole, double now_s);
    std::string row(const std::string& rest, Time time) const;

    const Study study_;
    const std::string language_, hand_;
    const std::shared_ptr<TouchMeter> meter_ = std::make_shared<TouchMeter>();
    std::vector<StudyScreen> screens_;  // the participant's; empty: none has begun
    std::size_t at_ = 0, turn_ = 0;
    double began_s_ = 0, came_s_ = 0;  // start of the screen, of the participant
    std::optional<std::size_t> chosen_;
    const std::shared_ptr<Tables> tables_;  // shared with the writer's jobs
    const std::unique_ptr<BackgroundWriter> writer_;
    std::size_t number_ = 0;      // the participant's
    std::optional<Error> fault_;  // the writer's last job's
    bool is_beginning_ = false;
    double passed_s_ = 0;    // the last `pass`
    double answered_s_ = 0;  // the last `pass` with an idle disk
};

}  // namespace touchable
