// SPDX-License-Identifier: Apache-2.0
#include "player/run/run_files.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "engine/base/files.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

struct Column {
    enum { tick, finger, goal_x, goal_y, goal_z, force_x, force_y, force_z, contact, count };
};
constexpr std::array<const char*, Column::count> column_names{
    "tick", "finger", "goal_x", "goal_y", "goal_z", "force_x", "force_y", "force_z", "contact"};
constexpr double fingers_of_a_hand = 256;

using Columns = std::array<std::vector<double>, Column::count>;

Result<Columns> read_columns(const CsvTable& table) {
    Columns columns;
    for (std::size_t c = 0; c < Column::count; ++c) {
        if (!table.names(column_names[c]))
            return input_error(table.file() + ": has no column " + column_names[c] +
                                   "; must be a file of forces that a run wrote",
                               {{Setting::forces}});
        TRY_ASSIGN(const auto at, table.column(column_names[c]));
        TRY_ASSIGN(columns[c], table.numbers(at));
    }
    return columns;
}

constexpr std::size_t window = ForceComparison::noise_window;
constexpr double samples_per_second = 1000;

ForceComparison::Deviation deviation_of(std::vector<double> values) {
    if (values.empty()) return {};
    std::ranges::sort(values);
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    const auto below = static_cast<std::size_t>(0.95 * static_cast<double>(values.size() - 1));
    return {sum / static_cast<double>(values.size()), values[below], values.back()};
}

/// Mean power of a force per band, over Hann windows (Welch's method).
class Spectrum {
public:
    Spectrum() {
        for (std::size_t k = 0; k < window; ++k) {
            const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(window);
            cosine_[k] = std::cos(angle);
            sine_[k] = std::sin(angle);
        }
    }
    void add(const ForceTable& table, int finger, std::size_t first) {
        for (int axis = 0; axis < 3; ++axis) {
            std::array<double, window> signal;
            double mean = 0;
            for (std::size_t k = 0; k < window; ++k)
                mean += signal[k] = table.at(first + k, finger).force[axis];
            mean /= static_cast<double>(window);
            for (std::size_t k = 0; k < window; ++k) signal[k] = (signal[k] - mean) * 0.5 * (1 - cosine_[k]);
            add(signal);
        }
        ++windows_;
    }
    double rms(std::size_t band) const {
        return windows_ > 0 ? std::sqrt(power_[band] / static_cast<double>(windows_)) : 0;
    }
    std::int64_t windows() const { return windows_; }

private:
    void add(const std::array<double, window>& signal) {
        constexpr double hz = samples_per_second / window;
        for (std::size_t bin = 1; bin <= window / 2; ++bin) {
            const double frequency = hz * static_cast<double>(bin);
            const auto in = [&](const ForceComparison::Band& band) {
                return frequency >= band.from_hz &&
                       (frequency < band.to_hz || band.to_hz == samples_per_second / 2);
            };
            const auto band = std::ranges::find_if(ForceComparison::noise_bands, in);
            if (band == ForceComparison::noise_bands.end()) continue;
            double cosine = 0, sine = 0;
            for (std::size_t k = 0; k < window; ++k) {
                cosine += signal[k] * cosine_[bin * k % window];
                sine += signal[k] * sine_[bin * k % window];
            }
            // Parseval: both halves of the spectrum, divided by the window's power (3/8 of its ticks).
            const double sides = bin == window / 2 ? 1 : 2;
            constexpr double n = window;
            power_[static_cast<std::size_t>(band - ForceComparison::noise_bands.begin())] +=
                sides * (cosine * cosine + sine * sine) / (n * n * 0.375);
        }
    }

    std::array<double, window> cosine_, sine_;
    std::array<double, ForceComparison::noise_bands.size()> power_{};
    std::int64_t windows_ = 0;
};

/// The five samples that differ most, at least 50 ms apart.
std::vector<ForceComparison::WorstTick> worst_of(std::vector<ForceComparison::WorstTick> all) {
    std::ranges::sort(all, [](const ForceComparison::WorstTick& a, const ForceComparison::WorstTick& b) {
        return a.newtons != b.newtons ? a.newtons > b.newtons : a.tick < b.tick;
    });
    std::vector<ForceComparison::WorstTick> out;
    for (const ForceComparison::WorstTick& one : all) {
        const bool near = std::ranges::any_of(out, [&](const ForceComparison::WorstTick& other) {
            return std::abs(one.tick - other.tick) < 50;
        });
        if (!near) out.push_back(one);
        if (out.size() == 5 || one.newtons == 0) break;
    }
    if (!out.empty() && out.back().newtons == 0) out.pop_back();
    return out;
}

/// Compares samples with the same goal: contact in A and B, and the forces' difference.
class Comparing {
public:
    void take(std::int64_t tick, int finger, const ForceTable::Sample& a, const ForceTable::Sample& b) {
        if (a.goal != b.goal) {
            ++out_.other_goals;
            return;
        }
        ++(a.contact ? (b.contact ? out_.both : out_.only_a) : (b.contact ? out_.only_b : out_.neither));
        const double newtons = glm::distance(a.force, b.force);
        if (newtons > 0) differing_.push_back({tick, finger, newtons});
        if (!a.contact || !b.contact) return;
        const double a_n = glm::length(a.force), b_n = glm::length(b.force);
        sum_a_ += a_n;
        sum_b_ += b_n;
        differences_.push_back(newtons);
        if (std::min(a_n, b_n) >= ForceComparison::least_newtons)
            directions_.push_back(degrees_between(a.force, b.force));
    }
    ForceComparison finish() {
        if (out_.both > 0) {
            const auto both = static_cast<double>(out_.both);
            out_.mean_a_n = sum_a_ / both;
            out_.mean_b_n = sum_b_ / both;
            out_.longer_n = (sum_a_ - sum_b_) / both;
        }
        out_.difference_n = deviation_of(std::move(differences_));
        out_.direction_degrees = deviation_of(std::move(directions_));
        out_.worst = worst_of(std::move(differing_));
        return std::move(out_);
    }

private:
    ForceComparison out_;
    double sum_a_ = 0, sum_b_ = 0;
    std::vector<double> differences_, directions_;
    std::vector<ForceComparison::WorstTick> differing_;
};

/// Compares all consecutive windows of `window` ticks during which a finger touches in both tables.
void compare_noise(const ForceTable& a, const ForceTable& b, std::size_t ticks, ForceComparison& out) {
    Spectrum of_a, of_b;
    for (int finger = 0; finger < a.fingers; ++finger) {
        std::size_t held = 0;
        for (std::size_t tick = 0; tick < ticks; ++tick) {
            const ForceTable::Sample &in_a = a.at(tick, finger), &in_b = b.at(tick, finger);
            held = in_a.contact && in_b.contact && in_a.goal == in_b.goal ? held + 1 : 0;
            if (held < window) continue;
            of_a.add(a, finger, tick + 1 - window);
            of_b.add(b, finger, tick + 1 - window);
            held = 0;
        }
    }
    out.noise_windows = of_a.windows();
    for (std::size_t band = 0; band < ForceComparison::noise_bands.size(); ++band) {
        out.noise_a_n[band] = of_a.rms(band);
        out.noise_b_n[band] = of_b.rms(band);
    }
}

}  // namespace

Result<ForceTable> read_force_table(const std::string& file) {
    TRY_ASSIGN(const auto table, CsvTable::read(file));
    TRY_ASSIGN(const auto c, read_columns(table));
    ForceTable out;
    const double last_finger = *std::ranges::max_element(c[Column::finger]);
    if (!(last_finger >= 0 && last_finger < fingers_of_a_hand))
        return input_error(file + ": its column finger goes to " + std::to_string(last_finger) +
                           "; must be 0 to 255");
    out.fingers = static_cast<int>(last_finger) + 1;
    const std::size_t rows = table.rows(), fingers = static_cast<std::size_t>(out.fingers);
    out.samples.reserve(rows);
    for (std::size_t row = 0; row < rows; ++row) {
        const auto wanted_tick = static_cast<double>(row / fingers),
                   wanted_finger = static_cast<double>(row % fingers);
        if (c[Column::tick][row] != wanted_tick || c[Column::finger][row] != wanted_finger)
            return input_error(table.place(row) + ": must have tick " + std::to_string(row / fingers) +
                               " and finger " + std::to_string(row % fingers) +
                               ": every finger of every tick, in order");
        out.samples.push_back({{c[Column::goal_x][row], c[Column::goal_y][row], c[Column::goal_z][row]},
                               {c[Column::force_x][row], c[Column::force_y][row], c[Column::force_z][row]},
                               c[Column::contact][row] != 0});
    }
    if (rows % fingers != 0)
        return input_error(file + ": its last tick lacks fingers; must have " + std::to_string(out.fingers));
    return out;
}

Result<ForceComparison> compare_forces(const ForceTable& a, const ForceTable& b) {
    if (a.fingers != b.fingers)
        return usage_error("the first has " + std::to_string(a.fingers) + " fingers, the second " +
                           std::to_string(b.fingers) + "; must be runs of the same hand");
    const std::size_t ticks = std::min(a.ticks(), b.ticks());
    Comparing comparing;
    for (std::size_t tick = 0; tick < ticks; ++tick)
        for (int finger = 0; finger < a.fingers; ++finger)
            comparing.take(static_cast<std::int64_t>(tick), finger, a.at(tick, finger), b.at(tick, finger));
    ForceComparison out = comparing.finish();
    out.ticks = static_cast<std::int64_t>(ticks);
    out.fingers = a.fingers;
    if (out.both + out.only_a + out.only_b + out.neither == 0)
        return usage_error(
            "no goal is the same in both; must be two runs of the same hand, as a recording "
            "repeats one on any surface",
            {{Setting::hand, "rec:FILE"}});
    compare_noise(a, b, ticks, out);
    return out;
}

}  // namespace touchable
