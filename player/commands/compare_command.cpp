// SPDX-License-Identifier: Apache-2.0
#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/run_files.hpp"
#include "player/run/terminal.hpp"

namespace touchable {

namespace {

using Json = nlohmann::ordered_json;

struct CompareOptions {
    std::string a, b;
    JsonOutput json;
};

Json to_json(const ForceComparison::Deviation& d) {
    return {{"mean", d.mean}, {"p95", d.p95}, {"max", d.max}};
}

Json to_json(const ForceComparison& c) {
    Json bands = Json::array(), worst = Json::array();
    for (std::size_t k = 0; k < ForceComparison::noise_bands.size(); ++k)
        bands.push_back({{"from_hz", ForceComparison::noise_bands[k].from_hz},
                         {"to_hz", ForceComparison::noise_bands[k].to_hz},
                         {"a_n", c.noise_windows > 0 ? Json(c.noise_a_n[k]) : Json()},
                         {"b_n", c.noise_windows > 0 ? Json(c.noise_b_n[k]) : Json()}});
    for (const ForceComparison::WorstTick& one : c.worst)
        worst.push_back({{"tick", one.tick}, {"finger", one.finger}, {"difference_n", one.newtons}});
    return {
        {"touchable_compare", 1},
        {"ticks", c.ticks},
        {"fingers", c.fingers},
        {"other_goals", c.other_goals},
        {"contact", {{"both", c.both}, {"only_a", c.only_a}, {"only_b", c.only_b}, {"neither", c.neither}}},
        {"force_n", {{"a", c.mean_a_n}, {"b", c.mean_b_n}, {"a_minus_b", c.longer_n}}},
        {"difference_n", to_json(c.difference_n)},
        {"direction_degrees", to_json(c.direction_degrees)},
        {"noise_windows", c.noise_windows},
        {"noise_n", bands},
        {"worst", worst}};
}

void print_contact(const ForceComparison& c) {
    const double all = 0.01 * static_cast<double>(c.both + c.only_a + c.only_b + c.neither);
    std::cout << formatted("  contact      both %.1f %%, only A %.1f %%, only B %.1f %%, neither %.1f %%\n",
                           static_cast<double>(c.both) / all, static_cast<double>(c.only_a) / all,
                           static_cast<double>(c.only_b) / all, static_cast<double>(c.neither) / all);
}

void print_noise(const ForceComparison& c) {
    if (c.noise_windows == 0) {
        std::cout << formatted(
            "  noise        not known: the runs never touch at once for %zu ms; a hand that stays in contact "
            "helps (press, or wander with glide=1000)\n",
            ForceComparison::noise_window);
        return;
    }
    for (std::size_t k = 0; k < ForceComparison::noise_bands.size(); ++k)
        std::cout << formatted("  %s %3.0f to %3.0f Hz: A %.4f N, B %.4f N\n",
                               k == 0 ? "noise       " : "            ",
                               ForceComparison::noise_bands[k].from_hz, ForceComparison::noise_bands[k].to_hz,
                               c.noise_a_n[k], c.noise_b_n[k]);
}

void print_table(const ForceComparison& c) {
    std::cout << formatted("  compared     %lld ticks of %d finger%s\n", static_cast<long long>(c.ticks),
                           c.fingers, c.fingers == 1 ? "" : "s");
    if (c.other_goals > 0)
        std::cout << formatted("  left out     %lld whose goals differ\n",
                               static_cast<long long>(c.other_goals));
    print_contact(c);
    if (c.both > 0) {
        std::cout << formatted("  force        A %.4f N, B %.4f N, A - B %+.4f N (mean, where both touch)\n",
                               c.mean_a_n, c.mean_b_n, c.longer_n);
        std::cout << formatted("  difference   mean %.4f N, 95 %% at most %.4f N, largest %.4f N\n",
                               c.difference_n.mean, c.difference_n.p95, c.difference_n.max);
        std::cout << formatted(
            "  direction    mean %.2f degrees, 95 %% at most %.2f, largest %.2f (from %.2f N on)\n",
            c.direction_degrees.mean, c.direction_degrees.p95, c.direction_degrees.max,
            ForceComparison::least_newtons);
    }
    print_noise(c);
    for (const ForceComparison::WorstTick& one : c.worst)
        std::cout << formatted("  %s tick %lld, finger %d: %.4f N\n",
                               &one == &c.worst.front() ? "worst       " : "            ",
                               static_cast<long long>(one.tick), one.finger + 1, one.newtons);
    if (c.worst.empty()) std::cout << "  every force is the same\n";
}

Result<void> compare(const CompareOptions& options) {
    TRY(options.json.check({{"A", options.a}, {"B", options.b}}));
    TRY_ASSIGN(const auto a, read_force_table(options.a));
    TRY_ASSIGN(const auto b, read_force_table(options.b));
    TRY_ASSIGN(const auto compared, compare_forces(a, b));
    if (!options.json.replaces_words()) print_table(compared);
    return options.json.write(to_json(compared));
}

}  // namespace

void add_compare_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("compare", "compare the forces of two runs of the same hand");
    auto options = std::make_shared<CompareOptions>();
    add_file_option(*sub, "A", options->a, "forces file of the first run (touchable touch --forces)")
        ->required();
    add_file_option(*sub, "B", options->b, "forces file of the second run")->required();
    add_json_option(*sub, options->json, "print the same figures as JSON");
    set_work(*sub, command, [options] {
        return within_memory("the forces of both runs", [&] { return compare(*options); });
    });
}

}  // namespace touchable
