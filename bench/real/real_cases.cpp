// SPDX-License-Identifier: Apache-2.0
#include "bench/real/real_cases.hpp"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "bench/real/edges.hpp"
#include "bench/real/filter_choices.hpp"
#include "bench/real/generated.hpp"
#include "bench/real/known_room.hpp"
#include "bench/real/recording.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/real/wiping.hpp"

namespace touchable {
namespace {

constexpr double room_focal_length = 481.2;
/// Rooms are too large for cameras of short range.
constexpr double half_as_large = 0.5, smallest = 0.4;
/// Walls are 3.9 m away, beyond what a Kinect is made for.
constexpr double far_away = 2.4;
constexpr int drawn_models = 8;

/// Adds a case per choice of filters; they share `made`, freed with the last one.
template <class Made>
void add(std::vector<BenchCase>& cases, const std::string& what, const std::shared_ptr<Made>& made,
         bool quick) {
    for (const FilterChoice& choice : filter_choices()) {
        const std::string name = "real-" + what + "-" + std::string(choice.name);
        cases.push_back({name, [made, choice, quick, name](Figures& figures) -> Result<void> {
                             auto measured = made->measure(choice, quick, figures);
                             if (measured) return measured;
                             return Error{measured.error().kind, name + ": " + measured.error().message};
                         }});
    }
}

void add_least_steps(std::vector<BenchCase>& cases, const SensorModel& model) {
    cases.push_back({"real-edges-" + model.name + "-chosen",
                     [model](Figures& figures) { return measure_least_steps(model, figures); }});
}

/// Adds a case with a pen `pen` mm high.
void add_low_relief(std::vector<BenchCase>& cases, SensorModel model, double middle, double pen,
                    const char* suffix = "") {
    model.name += suffix;
    cases.push_back({"real-relief-" + model.name + "-chosen",
                     [=](Figures& figures) { return measure_low_relief(model, middle, pen, figures); }});
}

void add_edges(std::vector<BenchCase>& cases, const SensorModel& model) {
    for (const FilterChoice& choice : filter_choices())
        cases.push_back(
            {"real-edges-" + model.name + "-" + std::string(choice.name),
             [model, choice](Figures& figures) { return measure_edges(model, choice, figures); }});
}

/// Adds cases with each choice of filters and with each file format.
void add_recording(std::vector<BenchCase>& cases, const CameraRecording& recording, bool quick) {
    const auto patches = std::make_shared<RecordingPatches>(recording);
    add(cases, recording.name, patches, quick);
    cases.push_back({"real-forms-" + recording.name,
                     [patches, quick](Figures& figures) { return patches->measure_forms(quick, figures); }});
    cases.push_back({"real-detail-" + recording.name, [patches, quick](Figures& figures) {
                         return patches->measure_details(quick, figures);
                     }});
    cases.push_back({"real-others-" + recording.name,
                     [patches, quick](Figures& figures) { return patches->compare(quick, figures); }});
    cases.push_back({"real-left-out-" + recording.name, [patches, quick](Figures& figures) {
                         return patches->measure_left_out(quick, figures);
                     }});
}

/// Adds invented cameras: the program's choice against an exhaustive search.
void add_drawn(std::vector<BenchCase>& cases, const std::filesystem::path& data, bool quick) {
    for (int number = 1; number <= drawn_models; ++number) {
        const SensorModel model = drawn_model(number);
        const auto room = std::make_shared<KnownRoom>(data, model, half_as_large);
        cases.push_back({"real-search-" + model.name,
                         [room, quick](Figures& figures) { return room->search(quick, figures); }});
    }
}

/// Counts drawn cameras whose films and stills the program's choice leaves nearly as good as the best.
Result<void> measure_models(const std::filesystem::path& data, const std::vector<SensorModel>& models,
                            Figures& figures) {
    constexpr double nearly = 1.3, hardly_worse = 1.02;
    struct Counts {
        int nearly_best = 0, worse_than_off = 0;
        double times_best = 0, times_off = 0;
    } film, still;
    std::size_t details = 1000;
    for (const SensorModel& model : models) {
        const auto found = KnownRoom(data, model, half_as_large).search_quickly();
        if (!found) return found.error();
        const auto add = [&](Counts& counts, const KnownRoom::Judged& of, const char* what) {
            const double best = of.chosen / of.best, off = of.chosen / of.off;
            counts.nearly_best += best <= nearly;
            counts.worse_than_off += off > hardly_worse;
            counts.times_best = std::max(counts.times_best, best);
            counts.times_off = std::max(counts.times_off, off);
            const std::string end = std::string("_") + what + "_" + model.name;
            figures.push_back({"chosen" + end, of.chosen, "deg", false});
            figures.push_back({"off" + end, of.off, "deg", false});
            figures.push_back({"best" + end, of.best, "deg", false});
        };
        details = std::min(details, found->details);
        add(film, found->film, "film");
        add(still, found->still, "still");
    }
    for (const auto& [counts, what] : {std::pair{film, "film_"}, {still, "still_"}}) {
        const std::string begin = what;
        figures.push_back({begin + "nearly_best_pct",
                           100 * static_cast<double>(counts.nearly_best) / static_cast<double>(models.size()),
                           "%"});
        figures.push_back({begin + "most_times_best", counts.times_best, ""});
        figures.push_back({begin + "worse_than_off", static_cast<double>(counts.worse_than_off), ""});
        figures.push_back({begin + "most_times_off", counts.times_off, ""});
    }
    figures.push_back({"least_details", static_cast<double>(details), ""});
    return {};
}

/// Counts drawn cameras whose forces are right as far as they are said to be trusted, in large rooms.
Result<void> measure_trust(const std::filesystem::path& data, const std::vector<SensorModel>& models,
                           Figures& figures) {
    constexpr double few_pct = 0.7;
    int right = 0;
    for (const SensorModel& model : models) {
        const auto errors = KnownRoom(data, model, far_away).press_chosen();
        if (!errors) return errors.error();
        right += errors->untrusted_pct() < 100 && errors->trusted_over_20deg_pct() <= few_pct;
        figures.push_back({"untrusted_pct_" + model.name, errors->untrusted_pct(), "%", false});
        figures.push_back(
            {"trusted_over_20deg_pct_" + model.name, errors->trusted_over_20deg_pct(), "%", false});
    }
    figures.push_back({"trust_is_right_pct", 100.0 * right / static_cast<double>(models.size()), "%"});
    return {};
}

void add_generated(std::vector<BenchCase>& cases) {
    for (const FilterChoice& choice : filter_choices())
        cases.push_back({"real-generated-" + std::string(choice.name),
                         [choice](Figures& figures) { return measure_generated(choice, figures); }});
}

bool is_there(const std::filesystem::path& data, const char* folder, const char* cases) {
    if (std::filesystem::exists(data / folder)) return true;
    std::fprintf(stderr, "%s are left out: no recording at %s\n", cases, (data / folder).c_str());
    return false;
}

}  // namespace

std::vector<BenchCase> real_cases(bool quick) {
    const std::filesystem::path data = TOUCHABLE_TEST_DATA;
    std::vector<BenchCase> cases;
    if (is_there(data, "visp_cube_realsense", "cases real-cube-..."))
        add_recording(cases, cube_recording(data), quick);
    if (is_there(data, "castel_sr300", "cases real-castel-..."))
        add_recording(cases, castel_recording(data), quick);
    if (is_there(data, "stills/redwood5", "cases real-redwood-..."))
        add_recording(cases, redwood_recording(data), quick);
    if (is_there(data, "stills/icl_nuim5", "cases real-icl-...")) {
        add(cases, "icl-kinect", std::make_shared<KnownRoom>(data, kinect_v1(), 1), quick);
        add(cases, "icl-d435", std::make_shared<KnownRoom>(data, d435(room_focal_length), half_as_large),
            quick);
        add(cases, "icl-sr300", std::make_shared<KnownRoom>(data, sr300(), smallest), quick);
        for (const auto& [model, factor] :
             {std::pair{kinect_v1(), 1.0}, {d435(room_focal_length), half_as_large}, {sr300(), smallest}}) {
            const auto room = std::make_shared<KnownRoom>(data, model, factor);
            cases.push_back({"real-others-" + model.name,
                             [room](Figures& figures) { return room->compare(true, figures); }});
        }
    }
    if (const char* const wiping = "haptics/epfl_wiping"; is_there(data, wiping, "cases real-wiping-..."))
        for (const int number : {0, 1, 2, 3})
            cases.push_back({"real-wiping-" + std::to_string(number), [=](Figures& figures) {
                                 return measure_demonstration(data / wiping, number, figures);
                             }});
    if (std::filesystem::exists(data / "stills/icl_nuim5")) {
        add_drawn(cases, data, quick);
        for (const int pixels : {3, 5, 7}) {
            const SensorModel model = d435_by_windows(room_focal_length, pixels);
            cases.push_back({"real-again-" + model.name, [=](Figures& figures) -> Result<void> {
                                 const auto times = KnownRoom(data, model, half_as_large).choose_again();
                                 if (!times) return times.error();
                                 figures.push_back({"most_times_first", *times, ""});
                                 return {};
                             }});
        }
        SensorModel sees_far = kinect_v1();
        sees_far.far_mm = 10'000;
        const auto far = std::make_shared<KnownRoom>(data, sees_far, far_away);
        cases.push_back({"real-icl-far-chosen", [far, quick](Figures& figures) {
                             return far->measure(filter_choices().back(), quick, figures);
                         }});
        cases.push_back({"real-detail-azure", [data](Figures& figures) {
                             return KnownRoom(data, azure_kinect(), 1).measure_details(figures);
                         }});
        const auto add_models = [&](const std::string& which, const std::vector<SensorModel>& models) {
            cases.push_back({"real-models-" + which,
                             [=](Figures& figures) { return measure_models(data, models, figures); }});
        };
        add_models("kinds", {depth_network(0.125), depth_network(8), phone(0), phone(1)});
        std::vector<SensorModel> models;
        for (int n = 1; n <= (quick ? 10 : 60); ++n) models.push_back(drawn_model(n));
        add_models("drawn", models);
        cases.push_back({"real-error-bars",
                         [=](Figures& figures) { return measure_error_bars(data, models, quick, figures); }});
        cases.push_back(
            {"real-models-far", [=](Figures& figures) { return measure_trust(data, models, figures); }});
    }
    for (int number = 1; number <= drawn_models; ++number) add_least_steps(cases, drawn_model(number));
    add_low_relief(cases, kinect_with_lone_pixels(), 1000, 12);
    add_low_relief(cases, coarse_light(), 1500, 30);
    add_low_relief(cases, azure_kinect(), 1000, 8);
    add_low_relief(cases, half_float_render(), 550, 2, "-0.5m");
    add_low_relief(cases, half_float_render(), 1100, 4, "-1m");
    add_low_relief(cases, half_float_render(), 2200, 8, "-2m");
    add_edges(cases, kinect_v1());
    add_edges(cases, d435(edges_focal_length));
    add_generated(cases);
    return cases;
}

}  // namespace touchable
