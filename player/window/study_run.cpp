#include "player/window/study_run.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "engine/base/new_file.hpp"
#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "player/window/universal_time.hpp"

namespace touchable {
namespace {

constexpr const char* header =
    "study,participant,language,hand,time,condition,place,step,question,answer,seconds,contact_s,touches,"
    "mean_force_n,max_force_n\n";

/// A device's name, in a table.
std::string as_field(std::string words) {
    std::ranges::replace_if(
        words, [](char c) { return c == ',' || c == '"' || static_cast<unsigned char>(c) < 0x20; }, ' ');
    return words;
}

}  // namespace

Result<std::unique_ptr<StudyRun>> StudyRun::open(Study study, std::filesystem::path folder,
                                                 std::string language, std::string hand,
                                                 std::unique_ptr<DiskWork> disk) {
    std::error_code failed;
    std::filesystem::create_directory(folder, failed);
    std::error_code unknown;
    if (!std::filesystem::is_directory(folder, unknown))
        return input_error(folder.string() + ": results cannot be kept there" +
                           (failed ? ": " + failed.message() : std::string()) + "; right would be a folder");
    TRY(NewFile(folder / "participant-000.csv", Existing::keep).check());
    return std::unique_ptr<StudyRun>(new StudyRun(std::move(study), std::move(folder), std::move(language),
                                                  as_field(std::move(hand)), std::move(disk)));
}

StudyRun::StudyRun(Study study, std::filesystem::path folder, std::string language, std::string hand,
                   std::unique_ptr<DiskWork> disk)
    : study_(std::move(study)),
      language_(std::move(language)),
      hand_(std::move(hand)),
      results_(std::move(folder), header, std::move(disk)) {}

double StudyRun::share_done() const {
    if (screens_.empty()) return 0;
    return static_cast<double>(at_) / static_cast<double>(screens_.size());
}

/// Before anybody has begun, the first of the study: it is there by the time it is wanted.
std::size_t StudyRun::clip() const {
    const std::vector<StudyScreen> first =
        screens_.empty() ? screens_of(study_, 1) : std::vector<StudyScreen>();
    const std::vector<StudyScreen>& screens = screens_.empty() ? first : screens_;
    for (std::size_t k = at_; k < screens.size(); ++k)
        if (screens[k].is_touch()) return screens[k].clip();
    for (std::size_t k = std::min(at_, screens.size()); k > 0; --k)
        if (screens[k - 1].is_touch()) return screens[k - 1].clip();
    return 0;
}

bool StudyRun::gives_force() const {
    return screen() && screen()->is_touch() && screen()->force() == StudyForce::on;
}

void StudyRun::choose(std::size_t answer) {
    if (screen() && screen()->question && answer < screen()->question->answers.size()) chosen_ = answer;
}

void StudyRun::choose_by(int by) {
    if (!screen() || !screen()->question) return;
    const auto count = static_cast<int>(screen()->question->answers.size());
    if (!chosen_)
        choose(by > 0 ? 0 : static_cast<std::size_t>(count - 1));
    else
        choose(static_cast<std::size_t>((static_cast<int>(*chosen_) + by + count) % count));
}

double StudyRun::wait_s(double now_s) const {
    const double all = screen() ? std::max(screen()->step->least_s, least_s) : least_s;
    return std::max(began_s_ + all - now_s, 0.0);
}

bool StudyRun::may_go_on(double now_s) const {
    if (wait_s(now_s) > 0) return false;
    return screen() ? chosen_ || !screen()->question : !is_beginning_;
}

void StudyRun::go_on(double now_s, Time time) {
    if (!may_go_on(now_s)) return;
    if (!screen()) {
        is_beginning_ = true;
        results_.begin();
        return;
    }
    add_row(now_s, time, chosen_ ? screen()->question->answers[*chosen_].value : "");
    if (at_ + 1 == screens_.size()) {
        results_.add(row(formatted(",,end,,finished,%.2f,,,,", now_s - came_s_), time));
        return finish(ParticipantFile::End::finished, now_s);
    }
    ++at_;
    begin_screen(now_s);
}

void StudyRun::pass(double now_s, Time time) {
    passed_s_ = now_s;
    if (results_.wait(std::chrono::milliseconds(0))) answered_s_ = now_s;
    begin_if_answered(now_s);
    if (!screen() || !screen()->step->most_s) return;
    if (now_s >= began_s_ + std::max(*screen()->step->most_s, least_s)) go_on(now_s, time);
}

void StudyRun::wait(double now_s) {
    if (!screen()) return;
    began_s_ = now_s;
    if (screen()->is_touch()) meter_->begin(screen()->force());
}

void StudyRun::begin_if_answered(double now_s) {
    if (!is_beginning_ || results_.is_beginning()) return;
    is_beginning_ = false;
    const auto number = results_.number();
    if (!number) return;
    screens_ = screens_of(study_, *number);
    at_ = 0;
    came_s_ = now_s;
    begin_screen(now_s);
}

void StudyRun::begin_screen(double now_s) {
    ++turn_;
    began_s_ = now_s;
    chosen_.reset();
    if (screen() && screen()->is_touch()) meter_->begin(screen()->force());
}

/// `rest`: from the condition on.
std::string StudyRun::row(const std::string& rest, Time time) const {
    std::string row;
    for (const std::string& field :
         {study_.name, std::to_string(*results_.number()), language_, hand_, in_universal_time(time)})
        row += field + ',';
    return row + rest + '\n';
}

void StudyRun::add_row(double now_s, Time time, const std::string& answer) {
    const StudyScreen& now = *screen();
    const std::string condition =
        now.condition ? now.condition->name + "," + std::to_string(now.place) : std::string(",");
    std::string touched = ",,,";
    if (now.is_touch()) {
        const TouchMeasures m = meter_->measures();
        touched = formatted("%.3f,%d,%.4f,%.4f", m.contact_s, m.touches, m.mean_newtons, m.most_newtons);
    }
    const std::string question = now.question ? now.question->id : std::string();
    std::string rest = condition;
    for (const std::string& field :
         {now.step->id, question, answer, formatted("%.2f", now_s - began_s_), touched}) {
        rest += ',';
        rest += field;
    }
    results_.add(row(rest, time));
}

void StudyRun::leave(double now_s, Time time) {
    if (!screen()) return;
    const bool is_done = at_ + 1 == screens_.size() && screen()->step->kind == StudyStep::Kind::text;
    add_row(now_s, time, "");
    results_.add(row(formatted(",,end,,%s,%.2f,,,,", is_done ? "finished" : "left", now_s - came_s_), time));
    finish(is_done ? ParticipantFile::End::finished : ParticipantFile::End::left, now_s);
}

/// The start screen is next, whatever becomes of the file.
void StudyRun::finish(ParticipantFile::End end, double now_s) {
    results_.end(end);
    screens_.clear();
    at_ = 0;
    chosen_.reset();
    began_s_ = now_s;
    ++turn_;
}

/// A participant who is at it stays in a partial file: it goes as far as it went.
Result<void> StudyRun::end(double now_s, Time time, std::chrono::milliseconds longest) {
    using Clock = std::chrono::steady_clock;
    const auto until = Clock::now() + longest;
    // Whoever has begun just now has begun.
    if (is_beginning_ && results_.wait(longest)) begin_if_answered(now_s);
    if (screen()) {
        add_row(now_s, time, "");
        results_.add(row(formatted(",,end,,ended,%.2f,,,,", now_s - came_s_), time));
        screens_.clear();
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    return results_.finish(std::max(left, std::chrono::milliseconds(0)));
}

std::optional<Error> StudyRun::fault() const {
    if (passed_s_ > answered_s_ + patience_s) return results_.no_answer();
    return results_.fault();
}

}  // namespace touchable
