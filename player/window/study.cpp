// SPDX-License-Identifier: Apache-2.0
#include "player/window/study.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <glm/geometric.hpp>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "player/window/kiosk.hpp"

namespace touchable {
namespace {

using StudyNode = checked_json::Node;
using StepKind = StudyStep::Kind;

constexpr std::size_t most_steps = 100, most_questions = 50, most_choices = 6, most_lines = 8,
                      longest_id = 40;
constexpr std::int64_t most_clips = 1000, largest_answer = 10;
constexpr double longest_wait_s = 24 * 3600;
constexpr std::pair<const char*, StudyForce> force_words[] = {{"on", StudyForce::on},
                                                              {"off", StudyForce::off}};

/// A name usable in a results table and in formulas.
std::string read_id(const StudyNode& node) {
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

std::string read_lines(const StudyNode& node) {
    if (!node.is_list()) return read_plain_line(node);
    std::string lines;
    for (const StudyNode& line : node.elements(1, most_lines, "a line, or up to 8 of them")) {
        if (!lines.empty()) lines += '\n';
        lines += read_plain_line(line);
    }
    return lines;
}

double read_seconds(const StudyNode& node) {
    return node.within(0, longest_wait_s, "seconds, up to a day of them");
}

std::size_t read_clip(const StudyNode& node) {
    return static_cast<std::size_t>(node.integer(1, most_clips) - 1);
}

void read_scale(const StudyNode& node, StudyQuestion& question) {
    node.allow_only({"least", "most", "low", "high"});
    question.is_scale = true;
    const std::int64_t least = node["least"].integer(0, largest_answer),
                       most = node["most"].integer(0, largest_answer);
    if (most <= least) node.refuse("from least to most, which is more");
    for (std::int64_t value = least; value <= most; ++value)
        question.answers.push_back({std::to_string(value), {{"", std::to_string(value)}}});
    question.low = read_by_language(node["low"], read_lines);
    question.high = read_by_language(node["high"], read_lines);
}

void read_choices(const StudyNode& node, StudyQuestion& question) {
    std::set<std::string> values;
    for (const StudyNode& choice : node.elements(2, most_choices, "a list of 2 to 6 choices")) {
        choice.allow_only({"value", "text"});
        StudyAnswer& answer = question.answers.emplace_back();
        answer.value = read_id(choice["value"]);
        answer.words = read_by_language(choice["text"], read_lines);
        if (!values.insert(answer.value).second) choice["value"].refuse("a value of its own");
    }
}

StudyQuestion read_question(const StudyNode& node) {
    node.allow_only({"id", "text", "scale", "choices"});
    StudyQuestion question;
    question.id = read_id(node["id"]);
    question.words = read_by_language(node["text"], read_lines);
    if (node.has("scale") == node.has("choices")) node.refuse("a question with a scale, or with choices");
    if (node.has("scale"))
        read_scale(node["scale"], question);
    else
        read_choices(node["choices"], question);
    return question;
}

void read_times(const StudyNode& node, StudyStep& step) {
    if (node.has("least_s")) step.least_s = read_seconds(node["least_s"]);
    if (!node.has("most_s")) return;
    step.most_s = read_seconds(node["most_s"]);
    if (*step.most_s < step.least_s || *step.most_s == 0)
        node["most_s"].refuse("more than 0, and no less than least_s");
}

/// `in_condition`: the condition sets the force.
StudyStep read_step(const StudyNode& node, bool in_condition) {
    constexpr std::pair<const char*, StepKind> kinds[] = {
        {"text", StepKind::text}, {"touch", StepKind::touch}, {"questions", StepKind::questions}};
    StudyStep step;
    step.kind = node["kind"].one_of(kinds);
    step.id = read_id(node["id"]);
    if (step.kind == StepKind::questions) {
        node.allow_only({"id", "kind", "questions"});
        for (const StudyNode& question :
             node["questions"].elements(1, most_questions, "a list of 1 to 50 questions"))
            step.questions.push_back(read_question(question));
        return step;
    }
    read_times(node, step);
    step.words = read_by_language(node["text"], read_lines);
    if (step.kind == StepKind::text) {
        node.allow_only({"id", "kind", "title", "text", "least_s", "most_s"});
        if (node.has("title")) step.title = read_by_language(node["title"], read_lines);
        return step;
    }
    node.allow_only({"id", "kind", "text", "least_s", "most_s", "clip", "force"});
    if (node.has("clip")) step.clip = read_clip(node["clip"]);
    if (node.has("force") && in_condition) node["force"].refuse("left out: the condition has it");
    if (node.has("force")) step.force = node["force"].one_of(force_words);
    return step;
}

StudyCondition read_condition(const StudyNode& node) {
    node.allow_only({"name", "force", "clip"});
    StudyCondition condition;
    condition.name = read_id(node["name"]);
    condition.force = node["force"].one_of(force_words);
    if (node.has("clip")) condition.clip = read_clip(node["clip"]);
    return condition;
}

/// Steps and questions have unique names; `known`: those so far.
std::vector<StudyStep> read_steps(const StudyNode& node, const char* member, bool in_condition,
                                  std::set<std::string>& known) {
    std::vector<StudyStep> steps;
    if (!node.has(member)) return steps;
    const auto is_new = [&](const StudyNode& id) {
        if (!known.insert(id.text()).second) id.refuse("a name of its own");
    };
    for (const StudyNode& step : node[member].elements(1, most_steps, "a list of 1 to 100 steps")) {
        steps.push_back(read_step(step, in_condition));
        is_new(step["id"]);
        if (steps.back().kind != StepKind::questions) continue;
        for (const StudyNode& question : step["questions"].elements(1, most_questions, "questions"))
            is_new(question["id"]);
    }
    return steps;
}

Study read_study(const StudyNode& node) {
    node.allow_only(
        {"touchable_study", "name", "idle_s", "start", "before", "conditions", "in_each_condition", "after"});
    node.check_version("touchable_study");
    Study study;
    study.name = read_id(node["name"]);
    if (node.has("idle_s")) study.idle_s = read_seconds(node["idle_s"]);
    if (study.idle_s < 1) node["idle_s"].refuse("at least a second");
    const StudyNode start = node["start"];
    start.allow_only({"title", "text"});
    study.title = read_by_language(start["title"], read_lines);
    study.words = read_by_language(start["text"], read_lines);
    std::set<std::string> known{"end"};  // id of the last row of a participant's table
    study.before = read_steps(node, "before", false, known);
    study.in_each_condition = read_steps(node, "in_each_condition", true, known);
    study.after = read_steps(node, "after", false, known);
    if (node.has("conditions") != node.has("in_each_condition"))
        node.refuse("both conditions and in_each_condition, or neither");
    if (study.before.empty() && study.after.empty() && study.in_each_condition.empty())
        node.refuse("a study of one step at least: before, in_each_condition, after");
    if (!node.has("conditions")) return study;
    std::set<std::string> names;
    for (const StudyNode& condition : node["conditions"].elements(
             1, most_study_conditions,
             "a list of 1 to " + std::to_string(most_study_conditions) + " conditions")) {
        study.conditions.push_back(read_condition(condition));
        if (!names.insert(study.conditions.back().name).second) condition["name"].refuse("a name of its own");
    }
    return study;
}

namespace fs = std::filesystem;

constexpr const char* table_header =
    "study,participant,language,hand,time,condition,place,step,question,answer,seconds,contact_s,touches,"
    "mean_force_n,max_force_n\n";

/// A device's name without CSV's special characters.
std::string plain_field(std::string words) {
    std::ranges::replace_if(
        words, [](char c) { return c == ',' || c == '"' || static_cast<unsigned char>(c) < 0x20; }, ' ');
    return words;
}

constexpr std::string_view file_stem = "participant-";
constexpr const char *partial_ending = ".partial.csv", *whole_ending = ".csv", *left_ending = ".left.csv";
constexpr std::size_t largest_number = 999'999;
constexpr const char* begin_tag = "begin";  // tag of the job that begins a participant

/// The participant's number in a file's name; 0: not a results file.
std::size_t participant_of(std::string_view name) {
    const std::size_t point = name.find('.');
    if (!name.starts_with(file_stem) || point == std::string_view::npos) return 0;
    const auto number = parsed_as<std::size_t>(name.substr(file_stem.size(), point - file_stem.size()));
    return number && *number <= largest_number ? *number : 0;
}

Result<std::size_t> largest_in(const fs::path& folder) {
    std::error_code failed;
    std::size_t largest = 0;
    for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed))
        largest = std::max(largest, participant_of(at->path().filename().string()));
    if (failed) return input_error(folder.string() + ": cannot be read: " + failed.message());
    return largest;
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
    const auto add = [&](const StudyWords& spoken) {
        if (const std::string* const said = said_in(spoken, language)) all += *said;
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
    return read_checked(json, largest_study, where, [](const StudyNode& node) { return read_study(node); });
}

std::vector<std::size_t> order_of_conditions(std::size_t count, std::size_t number) {
    const std::size_t rows = count % 2 == 0 ? count : 2 * count,
                      row = (number - 1) % std::max<std::size_t>(rows, 1);
    std::vector<std::size_t> order;
    // 0, 1, n - 1, 2, n - 2, ...; each row is the first one, shifted.
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t first = k % 2 == 1 ? (k + 1) / 2 : (count - k / 2) % count;
        order.push_back((first + row) % count);
    }
    // With an odd number of conditions half of the successions are in the mirrored rows.
    if (row >= count) std::ranges::reverse(order);
    return order;
}

std::vector<StudyScreen> screens_of(const Study& study, std::size_t number) {
    std::vector<StudyScreen> screens;
    const auto add = [&screens](const std::vector<StudyStep>& steps, const StudyCondition* condition,
                                std::size_t place) {
        for (const StudyStep& step : steps) {
            if (step.kind != StepKind::questions) screens.push_back({&step, nullptr, condition, place});
            for (const StudyQuestion& question : step.questions)
                screens.push_back({&step, &question, condition, place});
        }
    };
    add(study.before, nullptr, 0);
    std::size_t place = 0;
    for (const std::size_t k : order_of_conditions(study.conditions.size(), number))
        add(study.in_each_condition, &study.conditions[k], ++place);
    add(study.after, nullptr, 0);
    return screens;
}

Result<void> TouchMeter::consume(const TouchTick& tick) {
    const std::lock_guard lock(mutex_);
    touched_.resize(tick.contacts.size());
    constexpr int most_ticks = 100;  // limit on ticks of a late tick
    double largest = 0;
    int ticks = 0;
    for (std::size_t k = 0; k < tick.contacts.size(); ++k) {
        const bool does = tick.contacts[k].touching;
        measured_.touches += does && !touched_[k];
        touched_[k] = does;
        if (!does) continue;
        ticks = std::max(ticks, std::min(tick.contacts[k].ticks, most_ticks));
        largest =
            std::max(largest, glm::length(force_ == StudyForce::on ? tick.sent(k) : tick.forces[k].force));
    }
    if (ticks == 0) return {};
    contact_ticks_ += ticks;
    sum_newtons_ += ticks * largest;
    measured_.most_newtons = std::max(measured_.most_newtons, largest);
    return {};
}

/// A finger that already touches counts for this touch too.
void TouchMeter::begin(StudyForce force) {
    const std::lock_guard lock(mutex_);
    force_ = force;
    contact_ticks_ = 0;
    sum_newtons_ = 0;
    measured_ = {};
    touched_.clear();
}

TouchMeasures TouchMeter::measures() const {
    const std::lock_guard lock(mutex_);
    TouchMeasures measures = measured_;
    measures.contact_s = static_cast<double>(contact_ticks_) * 1e-9 * tick_ns;
    if (contact_ticks_ > 0) measures.mean_newtons = sum_newtons_ / static_cast<double>(contact_ticks_);
    return measures;
}

/// The participants' tables, one after another. All calls wait for the disk: they run in jobs of the writer,
/// and the last job's result says whether all answers are stored.
class StudyRun::Tables : NonCopyable {
public:
    explicit Tables(fs::path folder) : folder_(std::move(folder)) {}

    const fs::path& folder() const { return folder_; }
    /// The participant's number. The window may read it between the end of `begin` and its next request.
    std::size_t number() const { return number_; }

    /// Creates the table of the next participant; first ends the previous one, if that had failed. The number
    /// is one more than the largest in the folder, of complete and partial tables. A number that another
    /// program takes at the same moment is skipped.
    Result<void> begin() {
        constexpr std::size_t most_tries = 100;
        if (unended_) TRY(end(*unended_));
        TRY_ASSIGN(const auto largest, largest_in(folder_));
        const std::size_t last_number = std::min(largest + most_tries, largest_number);
        for (number_ = largest + 1; number_ <= last_number; ++number_) {
            const fs::path name = named(partial_ending);
            out_ = Descriptor(::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644));
            if (out_.get() < 0 && errno == EEXIST) continue;
            if (out_.get() < 0) return failed(errno);
            std::error_code ignored;
            const bool is_taken =
                fs::exists(named(whole_ending), ignored) || fs::exists(named(left_ending), ignored);
            waiting_ = table_header;
            Result<void> begun = write();
            if (begun && !is_taken) return begun;
            out_.reset();
            (void)unlink(name.c_str());
            if (!begun) return begun;
        }
        return input_error(folder_.string() +
                           ": there is no number for another participant; give an empty folder");
    }
    /// After `begin`: syncs the file's name to disk. Until then a power failure may lose the table.
    Result<void> secure() {
        const int why = last ? sync_path(folder_) : 0;
        return why ? failed(why) : last;
    }
    /// Writes a row and all waiting ones. If the disk is full, they wait for the next row.
    Result<void> add(const std::string& row) {
        waiting_ += row;
        return write();
    }
    /// Syncs the table to disk under its final name. If rows are missing, or the name is taken, it stays
    /// partial.
    Result<void> end(bool is_whole) {
        unended_ = is_whole;
        TRY(write());
        const fs::path partial = named(partial_ending), whole = named(is_whole ? whole_ending : left_ending);
        if (const int why = move_to_free_name(partial, whole); why != 0)
            return input_error(partial.string() + ": stays partial: " + whole.filename().string() + ": " +
                               std::strerror(why));
        unended_.reset();
        const int why = sync_path(folder_);
        out_.reset();
        return why ? failed(why) : Result<void>();
    }
    /// Retries ending the table, if that failed.
    Result<void> end_again() { return unended_ ? end(*unended_) : last; }

    Result<void> last;  ///< the result of the last job

private:
    fs::path named(const char* ending) const {
        return folder_ / (std::string(file_stem) + formatted("%03zu", number_) + ending);
    }
    Error failed(int why) const {
        return input_error(named(partial_ending).string() + ": answers are not kept: " + std::strerror(why));
    }
    /// Writes all waiting rows, or none.
    Result<void> write() {
        if (const int why = append_durably(out_.get(), waiting_)) return failed(why);
        waiting_.clear();
        return {};
    }

    const fs::path folder_;
    std::size_t number_ = 0;
    Descriptor out_;
    std::string waiting_;          // complete rows
    std::optional<bool> unended_;  // the `is_whole` of a failed `end`
};

Result<std::unique_ptr<StudyRun>> StudyRun::open(Study study, fs::path folder, std::string language,
                                                 std::string hand, std::unique_ptr<BackgroundWriter> writer) {
    std::error_code failed;
    fs::create_directory(folder, failed);
    std::error_code unknown;
    if (!fs::is_directory(folder, unknown))
        return input_error(folder.string() + ": results cannot be kept there" +
                           (failed ? ": " + failed.message() : std::string()) + "; must be a folder");
    TRY(NewFile(folder / "participant-000.csv", Existing::keep).check());
    return std::unique_ptr<StudyRun>(
        new StudyRun(std::move(study), std::move(language), plain_field(std::move(hand)),
                     std::make_shared<Tables>(std::move(folder)), std::move(writer)));
}

StudyRun::StudyRun(Study study, std::string language, std::string hand, std::shared_ptr<Tables> tables,
                   std::unique_ptr<BackgroundWriter> writer)
    : study_(std::move(study)),
      language_(std::move(language)),
      hand_(std::move(hand)),
      tables_(std::move(tables)),
      writer_(std::move(writer)) {}

void StudyRun::write(std::function<Result<void>(Tables& tables)> work, std::string tag) {
    auto job = [tables = tables_, work = std::move(work)](const fs::path&) {
        return tables->last = work(*tables);
    };
    writer_->give({.file = tables_->folder(), .write = std::move(job), .tag = std::move(tag)});
}

/// Before a participant begins, the study's first clip, so that it is open in time.
std::size_t StudyRun::clip() const {
    const std::vector<StudyScreen> screens = screens_.empty() ? screens_of(study_, 1) : screens_;
    std::size_t last = 0;  // of the touches so far
    for (std::size_t k = 0; k < screens.size(); ++k) {
        if (!screens[k].is_touch()) continue;
        last = screens[k].clip();
        if (k >= at_) break;
    }
    return last;
}

void StudyRun::choose_by(int by) {
    if (!screen() || !screen()->question) return;
    const auto count = static_cast<int>(screen()->question->answers.size());
    if (!chosen_)
        choose(by > 0 ? 0 : static_cast<std::size_t>(count - 1));
    else
        choose(static_cast<std::size_t>((static_cast<int>(*chosen_) + by + count) % count));
}

void StudyRun::go_on(double now_s, Time time) {
    if (!may_go_on(now_s)) return;
    if (!screen()) {
        is_beginning_ = true;
        write([](Tables& tables) { return tables.begin(); }, begin_tag);
        write([](Tables& tables) { return tables.secure(); });  // the participant does not wait for it
        return;
    }
    add_row(now_s, time, chosen_ ? screen()->question->answers[*chosen_].value : "");
    if (at_ + 1 == screens_.size()) {
        add_end(now_s, time, "finished");
        return finish(true, now_s);
    }
    ++at_;
    begin_screen(now_s);
}

void StudyRun::pass(double now_s, Time time) {
    passed_s_ = now_s;
    if (wait_for_disk(std::chrono::milliseconds(0))) answered_s_ = now_s;
    take_written(now_s);
    if (!screen() || !screen()->step->most_s) return;
    if (now_s >= began_s_ + std::max(*screen()->step->most_s, least_s)) go_on(now_s, time);
}

void StudyRun::wait(double now_s) {
    if (!screen()) return;
    began_s_ = now_s;
    if (screen()->is_touch()) meter_->begin(screen()->force());
}

void StudyRun::take_written(double now_s) {
    for (const auto& written : writer_->take()) {
        fault_ = written.result ? std::nullopt : std::optional(written.result.error());
        if (written.tag != begin_tag) continue;
        is_beginning_ = false;
        if (fault_) continue;
        number_ = tables_->number();
        screens_ = screens_of(study_, number_);
        at_ = 0;
        came_s_ = now_s;
        begin_screen(now_s);
    }
}

void StudyRun::begin_screen(double now_s) {
    ++turn_;
    began_s_ = now_s;
    chosen_.reset();
    wait(now_s);
}

/// `rest`: the columns from the condition on.
std::string StudyRun::row(const std::string& rest, Time time) const {
    return study_.name + ',' + std::to_string(number_) + ',' + language_ + ',' + hand_ + ',' +
           in_universal_time(time) + ',' + rest + '\n';
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
    add(row(condition + ',' + now.step->id + ',' + question + ',' + answer +
                formatted(",%.2f,", now_s - began_s_) + touched,
            time));
}

void StudyRun::leave(double now_s, Time time) {
    if (!screen()) return;
    const bool is_done = at_ + 1 == screens_.size() && screen()->step->kind == StudyStep::Kind::text;
    add_row(now_s, time, "");
    add_end(now_s, time, is_done ? "finished" : "left");
    finish(is_done, now_s);
}

void StudyRun::add(const std::string& row) {
    write([row](Tables& tables) { return tables.add(row); });
}

/// The start screen follows, even if the file cannot be finished.
void StudyRun::finish(bool is_whole, double now_s) {
    write([is_whole](Tables& tables) { return tables.end(is_whole); });
    screens_.clear();
    at_ = 0;
    begin_screen(now_s);
}

/// The file of an unfinished participant stays partial.
Result<void> StudyRun::end(double now_s, Time time, std::chrono::milliseconds longest) {
    using Clock = std::chrono::steady_clock;
    const auto until = Clock::now() + longest;
    // A participant who began just now counts too.
    if (is_beginning_ && wait_for_disk(longest)) take_written(now_s);
    if (screen()) {
        add_row(now_s, time, "");
        add_end(now_s, time, "ended");
        screens_.clear();
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    write([](Tables& tables) { return tables.end_again(); });
    if (!writer_->finish(std::max(left, std::chrono::milliseconds(0)), BackgroundWriter::Late::done))
        return no_answer();
    take_written(now_s);
    return fault_ ? Result<void>(*fault_) : Result<void>();
}

Error StudyRun::no_answer() const {
    return input_error(tables_->folder().string() + ": " + not_in_time + "; the last answers may be lost");
}

}  // namespace touchable
