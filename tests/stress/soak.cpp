// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <mutex>
#include <thread>

#include "engine/base/files.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "tests/stress/soak.hpp"

namespace touchable::stress {
namespace {

using Json = nlohmann::ordered_json;

constexpr int format = 2;
constexpr std::size_t violations_on_file = 100;

/// The names of a Coverage's members in the file.
constexpr std::array<std::pair<const char*, std::int64_t Coverage::*>, 19> counts{{
    {"ticks", &Coverage::ticks},
    {"finger_ticks", &Coverage::finger_ticks},
    {"contact", &Coverage::contact},
    {"with_heights", &Coverage::with_heights},
    {"with_friction", &Coverage::with_friction},
    {"sliding", &Coverage::sliding},
    {"at_invalid", &Coverage::at_invalid},
    {"in_holes", &Coverage::in_holes},
    {"landings", &Coverage::landings},
    {"departures", &Coverage::departures},
    {"frame_changes", &Coverage::frame_changes},
    {"between_frames", &Coverage::between_frames},
    {"held_goals", &Coverage::held_goals},
    {"refusals", &Coverage::refusals},
    {"capped", &Coverage::capped},
    {"most_events", &Coverage::most_events},
    {"certified", &Coverage::certified},
    {"compared", &Coverage::compared},
    {"other_basins", &Coverage::other_basins},
}};
constexpr std::array<std::pair<const char*, double Coverage::*>, 7> worsts{{
    {"worst_behind", &Coverage::worst_behind},
    {"worst_excess", &Coverage::worst_excess},
    {"worst_way", &Coverage::worst_way},
    {"worst_ratio", &Coverage::worst_ratio},
    {"worst_angle", &Coverage::worst_angle},
    {"energy_created", &Coverage::energy_created},
    {"energy_bound", &Coverage::energy_bound},
}};

Json to_json(const SoakState& state) {
    const SoakPlan& plan = state.plan;
    Json json{{"soak", format},
              {"solver", plan.solver},
              {"unit_ticks", plan.unit_ticks},
              {"certify_every", plan.certify_every},
              {"compare_every", plan.compare_every},
              {"replay_every", plan.replay_every},
              {"units", state.units},
              {"violation_count", state.violation_count},
              {"violations", state.violations}};
    for (const auto& [name, covered] : state.coverage) {
        Json& suite = json["suites"][name];
        for (const auto& [member, value] : counts) suite[member] = covered.*value;
        for (const auto& [member, value] : worsts) suite[member] = covered.*value;
    }
    return json;
}

/// Throws std::exception where something is missing or of another type.
SoakState from_json(const Json& json) {
    SoakState state;
    SoakPlan& plan = state.plan;
    if (json.at("soak").get<int>() != format) throw std::out_of_range("its format is another");
    plan.solver = json.at("solver").get<std::string>();
    plan.unit_ticks = json.at("unit_ticks").get<std::int64_t>();
    plan.certify_every = json.at("certify_every").get<int>();
    plan.compare_every = json.at("compare_every").get<int>();
    plan.replay_every = json.at("replay_every").get<int>();
    state.units = json.at("units").get<std::int64_t>();
    if (state.units < 0 || plan.unit_ticks < 1) throw std::out_of_range("its counts are impossible");
    state.violation_count = json.at("violation_count").get<std::int64_t>();
    state.violations = json.at("violations").get<std::vector<std::string>>();
    if (!json.contains("suites")) return state;
    for (const auto& [name, suite] : json["suites"].items()) {
        Coverage& covered = state.coverage[name];
        for (const auto& [member, value] : counts) covered.*value = suite.at(member).get<std::int64_t>();
        for (const auto& [member, value] : worsts) covered.*value = suite.at(member).get<double>();
    }
    return state;
}

}  // namespace

std::int64_t SoakState::ticks() const {
    return units * plan.unit_ticks;
}

void SoakState::add(const Suite& suite, std::uint64_t seed, const Watched& watched) {
    coverage[std::string(suite.name)].add(watched.coverage);
    violation_count += watched.violation_count;
    for (const std::string& violation : watched.violations)
        if (violations.size() < violations_on_file)
            violations.push_back("--suite " + std::string(suite.name) + " --seed " + std::to_string(seed) +
                                 " --ticks " + std::to_string(plan.unit_ticks) + ": " + violation);
}

std::vector<std::string> SoakState::empty_suites() const {
    std::vector<std::string> lines;
    for (const Suite& suite : suites()) {
        const auto found = coverage.find(suite.name);
        if (found == coverage.end()) continue;
        if (const std::string missing = found->second.missing(suite.needs); !missing.empty())
            lines.push_back(std::string(suite.name) + ": " + missing);
    }
    return lines;
}

std::string solver_identity() {
    std::uint64_t identity = 0;
    for (const Suite& suite : suites())
        for (const std::uint64_t seed : {0, 1, 2}) {
            const auto run = suite.run(seed);
            const std::string hash = watch(*run, {500, 0, 0}).force_hash;
            identity = mix64(identity ^ std::stoull(hash, nullptr, 16));
        }
    std::array<char, 17> text;
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(identity));
    return text.data();
}

Result<std::optional<SoakState>> read_soak(const std::filesystem::path& file) {
    std::error_code failure;
    if (!std::filesystem::exists(file, failure) && !failure) return std::optional<SoakState>();
    std::ifstream in(file);
    const Json json = Json::parse(in, nullptr, false);
    try {
        return std::optional(from_json(json));
    } catch (const std::exception& fault) {
        return input_error(file.string() + ": is no state of a soak: " + fault.what());
    }
}

Result<void> write_soak(const std::filesystem::path& file, const SoakState& state) {
    std::error_code ignored;  // the file tells, where it cannot be made
    if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
    NewFile out(file);
    if (auto usable = out.check(); !usable) return usable;
    std::ofstream stream(out.path());
    stream << to_json(state).dump(1) << '\n';
    stream.close();
    if (!stream)
        return input_error(file.string() + ": cannot be written (no permission, or the disk is full)");
    return out.commit();
}

}  // namespace touchable::stress
namespace touchable::stress {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds between_saves{10};

struct Unit {
    const Suite* suite = nullptr;
    std::uint64_t seed = 0;
};
Unit unit_at(std::int64_t n) {
    const auto count = static_cast<std::int64_t>(suites().size());
    return {&suites()[static_cast<std::size_t>(n % count)], static_cast<std::uint64_t>(n / count)};
}

Watched watch_unit(const SoakPlan& plan, std::int64_t n) {
    const Unit unit = unit_at(n);
    const WatchSettings settings{plan.unit_ticks, plan.certify_every, plan.compare_every};
    Watched watched = watch(*unit.suite->run(unit.seed), settings);
    if (plan.replay_every > 0 && n % plan.replay_every == 0) {
        const std::string again = watch(*unit.suite->run(unit.seed), {plan.unit_ticks, 0, 0}).force_hash;
        if (again != watched.force_hash) {
            ++watched.violation_count;
            watched.violations.push_back("S6: forces " + watched.force_hash + ", then " + again);
        }
    }
    return watched;
}

/// Units that are done, taken over in their order, so that the state is always that of all units below a
/// number.
class Ledger {
public:
    Ledger(SoakState& state, const SoakSettings& settings, std::ostream& progress)
        : state_(state), settings_(settings), progress_(progress), started_at_(state.ticks()) {}

    void enter(std::int64_t n, Watched watched) {
        const std::lock_guard lock(mutex_);
        waiting_.emplace(n, std::move(watched));
        for (auto first = waiting_.begin(); first != waiting_.end() && first->first == state_.units;
             first = waiting_.erase(first), ++state_.units) {
            const Unit unit = unit_at(first->first);
            const std::size_t known = state_.violations.size();
            state_.add(*unit.suite, unit.seed, first->second);
            for (std::size_t k = known; k < state_.violations.size(); ++k)
                progress_ << "violation: " << state_.violations[k] << std::endl;
        }
        if (Clock::now() - saved_ >= between_saves) save();
    }
    /// Also once all is over.
    void save() {
        if (auto written = write_soak(settings_.state, state_); !written) failure_ = written.error();
        saved_ = Clock::now();
        const double seconds = std::chrono::duration<double>(saved_ - started_).count();
        const auto done = static_cast<double>(state_.ticks() - started_at_);
        progress_ << std::fixed << std::setprecision(1) << static_cast<double>(state_.ticks()) / 1e6 << " of "
                  << static_cast<double>(settings_.ticks) / 1e6 << " million ticks, " << done / 1e6 / seconds
                  << " million/s, " << state_.violation_count << " violations" << std::endl;
    }
    bool failed() {
        const std::lock_guard lock(mutex_);
        return failure_.has_value();
    }
    const std::optional<Error>& failure() const { return failure_; }

private:
    SoakState& state_;
    const SoakSettings& settings_;
    std::ostream& progress_;
    std::int64_t started_at_;
    std::mutex mutex_;
    std::map<std::int64_t, Watched> waiting_;
    const Clock::time_point started_ = Clock::now();
    Clock::time_point saved_ = started_;
    std::optional<Error> failure_;
};

Result<SoakState> begin(const SoakSettings& settings) {
    SoakState state;
    state.plan = settings.plan;
    state.plan.solver = solver_identity();
    if (settings.fresh) return state;
    auto read = read_soak(settings.state);
    if (!read) return read.error();
    if (!*read) return state;
    if ((*read)->plan == state.plan) return std::move(**read);
    return usage_error(settings.state.string() + ": is of another solver (" + (*read)->plan.solver +
                       ", this one is " + state.plan.solver + ") or another plan; --fresh begins anew");
}

}  // namespace

Result<SoakState> soak(const SoakSettings& settings, std::ostream& progress) {
    auto begun = begin(settings);
    if (!begun) return begun;
    SoakState& state = *begun;
    const std::int64_t units = (settings.ticks + state.plan.unit_ticks - 1) / state.plan.unit_ticks;
    Ledger ledger(state, settings, progress);
    std::atomic<std::int64_t> next{state.units};
    auto work = [&] {
        for (std::int64_t n = next++; n < units && !stop_requested() && !ledger.failed(); n = next++)
            ledger.enter(n, watch_unit(state.plan, n));
    };
    std::vector<std::thread> threads;
    for (int k = 1; k < settings.threads; ++k) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
    ledger.save();
    if (ledger.failure()) return *ledger.failure();

    for (const std::string& empty : state.empty_suites()) {
        ++state.violation_count;
        state.violations.push_back("empty: " + empty);
    }
    return begun;
}

}  // namespace touchable::stress
