#include "tests/stress/soak.hpp"

#include <atomic>
#include <chrono>
#include <iomanip>
#include <mutex>
#include <thread>

#include "engine/base/threads.hpp"

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
