// SPDX-License-Identifier: Apache-2.0
// touchable-soak: the stress suites, one or all of them, for as long as wanted.
#include <CLI/CLI.hpp>
#include <cmath>
#include <fstream>
#include <iostream>
#include <thread>

#include "player/run/terminal.hpp"
#include "tests/stress/golden_runs.hpp"
#include "tests/stress/soak.hpp"

namespace {

using namespace touchable;
using namespace touchable::stress;

struct Words {
    SoakSettings soak;
    std::string suite, scene, builder = "cpu";
    std::uint64_t seed = 0;
    double ticks = 0;  ///< as typed: 1e8 is a number of ticks
    std::string states, compare;
    bool list = false;
};

void list() {
    for (const Suite& suite : suites()) std::cout << suite.name << ": " << suite.what << '\n';
    std::cout << "\nscenes with known forces:";
    for (const GoldenRun& run : golden_runs()) std::cout << ' ' << run.name;
    std::cout << '\n';
}

/// Watches a run; writes or compares its states where --states or --compare ask for it.
Result<Watched> watch_states(StressRun& run, const WatchSettings& settings, const Words& words) {
    if (!words.states.empty()) {
        std::ofstream out(words.states);
        StateWriter writer(out);
        Watched watched = watch(run, settings, &writer);
        out.close();
        if (!out) return input_error("--states " + words.states + ": cannot be written");
        return watched;
    }
    if (words.compare.empty()) return watch(run, settings);
    std::ifstream in(words.compare);
    if (!in) return input_error("--compare " + words.compare + ": cannot be read");
    StateComparison comparison(in);
    Watched watched = watch(run, settings, &comparison);
    const auto difference = comparison.difference();
    if (difference) return Error{ErrorKind::check, "differs first at " + *difference};
    std::cout << "every tick is as recorded\n";
    return watched;
}

Result<void> run_one(const Words& words) {
    std::unique_ptr<StressRun> run;
    Needs needs{0, false, false, false};
    if (!words.suite.empty()) {
        const Suite* suite = find_suite(words.suite);
        if (!suite) return usage_error("--suite " + words.suite + " is none; --list names all");
        run = suite->run(words.seed);
        needs = suite->needs;
    } else {
        const GoldenRun* golden = find_golden_run(words.scene);
        if (!golden) return usage_error("--scene " + words.scene + " is none; --list names all");
        if (words.builder != "cpu" && words.builder != "lazy")
            return usage_error("--builder " + words.builder + " is none of cpu, lazy");
        run = golden->make(words.builder == "cpu" ? GoldenBuilder::cpu : GoldenBuilder::lazy);
        if (words.ticks > 20000)
            return usage_error("--ticks: the hands over the scenes end after 20000 ticks");
    }
    WatchSettings settings;
    settings.ticks = words.scene.empty() ? words.soak.plan.unit_ticks : GoldenRun::ticks;
    if (words.ticks > 0) settings.ticks = static_cast<std::int64_t>(words.ticks);
    if (run->touch().metric != TouchMetric::world) settings.certify_every = settings.compare_every = 0;
    auto watched = watch_states(*run, settings, words);
    if (!watched) return watched.error();
    std::cout << watched->coverage.in_words() << "\nforce_hash " << watched->force_hash << '\n';
    for (const std::string& violation : watched->violations) std::cout << "violation: " << violation << '\n';
    if (watched->violation_count > 0)
        return Error{ErrorKind::check, std::to_string(watched->violation_count) + " violations"};
    if (const std::string missing = watched->coverage.missing(needs); !missing.empty())
        return input_error("the run is empty: " + missing);  // many_recordings.py goes by its status
    return {};
}

Result<void> run_soak(Words& words) {
    if (words.ticks > 0) words.soak.ticks = static_cast<std::int64_t>(words.ticks);
    catch_interrupts();
    const auto done = soak(words.soak, std::cerr);
    if (!done) return done.error();
    for (const auto& [name, covered] : done->coverage)
        std::cout << name << ": " << covered.in_words() << '\n';
    for (const std::string& violation : done->violations) std::cout << "violation: " << violation << '\n';
    std::cout << done->ticks() << " ticks, " << done->violation_count << " violations\n";
    if (done->violation_count > 0) return Error{ErrorKind::check, "invariants were violated"};
    return {};
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"The stress suites of the touch solver (docs/paper.md)", "touchable-soak"};
    Words words;
    words.soak.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    app.add_flag("--list", words.list, "name the suites and the scenes");
    auto* suite = app.add_option("--suite", words.suite, "one run of this suite, every tick certified");
    auto* scene = app.add_option("--scene", words.scene, "one run over this scene, every tick certified");
    suite->excludes(scene);
    app.add_option("--seed", words.seed, "of the suite")->needs(suite);
    app.add_option("--builder", words.builder, "of the scene's frames: cpu or lazy")->needs(scene);
    app.add_option("--ticks", words.ticks, "of the run, or of the whole soak (1e9)")
        ->check(CLI::Range(1.0, 1e12));
    auto* states =
        app.add_option("--states", words.states, "write what every tick of the run was to this file");
    app.add_option("--compare", words.compare,
                   "name the first tick, finger and field that differ from this file")
        ->excludes(states);
    app.add_option("--threads", words.soak.threads, "of a soak")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    app.add_option("--state", words.soak.state, "where a soak keeps how far it is")->capture_default_str();
    app.add_option("--certify-every", words.soak.plan.certify_every, "ticks of a soak; 0: never")
        ->check(CLI::Range(0, 1000000))
        ->capture_default_str();
    app.add_option("--compare-every", words.soak.plan.compare_every,
                   "ticks of a soak, with the reference; 0: never")
        ->check(CLI::Range(0, 1000000))
        ->capture_default_str();
    app.add_flag("--fresh", words.soak.fresh, "begin a soak anew");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : exit_code(ErrorKind::usage);
    }
    if (words.list) {
        list();
        return 0;
    }
    if (std::isnan(words.ticks)) {
        std::cerr << "touchable-soak: --ticks is not a number\n";
        return exit_code(ErrorKind::usage);
    }
    const bool one = !words.suite.empty() || !words.scene.empty();
    if (!one && !(words.states.empty() && words.compare.empty())) {
        std::cerr << "touchable-soak: --states and --compare are of one run; name it by --suite or --scene\n";
        return exit_code(ErrorKind::usage);
    }
    const Result<void> done = one ? run_one(words) : run_soak(words);
    if (!done) {
        std::cerr << "touchable-soak: " << done.error().message << '\n';
        return exit_code(done.error().kind);
    }
    return !one && stop_requested() ? 130 : 0;
}
