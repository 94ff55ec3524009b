// SPDX-License-Identifier: Apache-2.0
#include "player/run/figures.hpp"

#include <bit>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/hand_thresholds.hpp"

namespace touchable {

namespace {

// A bin holds doubles with the same exponent and the same 7 leading mantissa bits; bit patterns of positive
// doubles are ordered like their values.
constexpr int bits_in_bin = 52 - 7;
constexpr double shortest = 0x1p-10, longest = 0x1p40;  // if in microseconds: a nanosecond, twelve days

constexpr std::uint64_t bin_of_all(double time) {
    return std::bit_cast<std::uint64_t>(time) >> bits_in_bin;
}
constexpr std::uint64_t first_bin = bin_of_all(shortest);
constexpr std::size_t bins = bin_of_all(longest) - first_bin + 1;

std::size_t bin_of(double time) {
    if (!(time >= shortest)) return 0;  // in the first bin
    return time < longest ? bin_of_all(time) - first_bin : bins - 1;
}

/// The middle of a bin.
double middle_of(std::size_t bin) {
    const auto end = [](std::uint64_t of) { return std::bit_cast<double>(of << bits_in_bin); };
    return (end(first_bin + bin) + end(first_bin + bin + 1)) / 2;
}

double share(double part, std::int64_t whole) {
    return whole ? part / static_cast<double>(whole) : 0.0;
}

bool is_finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

nlohmann::ordered_json to_json(const Spread& s) {
    return {{"mean", s.mean}, {"p50", s.p50}, {"p99", s.p99}, {"p999", s.p999}, {"max", s.max}};
}

TimeSpread::TimeSpread() : times_(bins) {}

void TimeSpread::add(double time) {
    ++times_[bin_of(time)];
    least_ = count_ == 0 ? time : std::min(least_, time);
    most_ = count_ == 0 ? time : std::max(most_, time);
    sum_ += time;
    ++count_;
}

double TimeSpread::quantile(double share) const {
    const auto rank = std::min(static_cast<std::int64_t>(share * static_cast<double>(count_)), count_ - 1);
    std::int64_t up_to = 0;
    for (std::size_t bin = 0; bin < bins; ++bin)
        if ((up_to += times_[bin]) > rank)
            return bin + 1 == bins ? most_ : std::clamp(middle_of(bin), least_, most_);
    return most_;
}

Spread TimeSpread::spread() const {
    if (count_ == 0) return {};
    return {sum_ / static_cast<double>(count_), quantile(0.5), quantile(0.99), quantile(0.999), most_};
}

/// The force held until now (old share_) did the tick's work; its spring energy is scaled by the new share.
void TouchFigures::SentEnergy::update(const EnergyFigures& guarded, double share) {
    const double back = 1 - share_;
    kept_.work += back * (guarded.work - guarded_.work);
    kept_.surface += back * (guarded.surface - guarded_.surface) + (share_ - share) * guarded.stored;
    kept_.bound += back * (guarded.bound - guarded_.bound);
    kept_.stored = (1 - share) * guarded.stored;
    const bool all_sent = share == 1 && kept_.work == 0 && kept_.surface == 0 && kept_.bound == 0;
    const double created = sent_.created;
    sent_ = guarded;
    sent_.work -= kept_.work;
    sent_.surface -= kept_.surface;
    sent_.bound -= kept_.bound;
    sent_.stored -= kept_.stored;
    if (!all_sent) sent_.created = std::max(created, sent_.balance());
    guarded_ = guarded;
    share_ = share;
}

Result<void> TouchFigures::consume(const TouchTick& tick) {
    bool contact = false, nonfinite = false, capped = false;
    std::uint32_t reasons = guard_none;  // of any finger
    led_.resize(tick.contacts.size());
    if (fingers_.empty())
        for (const Contact& c : tick.contacts) fingers_.push_back({.first_goal = c.goal});
    for (std::size_t k = 0; k < tick.contacts.size(); ++k) {
        const Contact& c = tick.contacts[k];
        Finger& finger = fingers_[k];
        const glm::dvec3 force = tick.sent(k);
        const bool all_sent = tick.share(k) == 1;
        hash_.add(tick.forces[k].force);
        contact |= c.touching;
        led_[k] = led_[k] || c.touching || c.goal != finger.first_goal;
        finger_contact_ticks_ += c.touching;
        hops_ += c.hops && !finger.hopping;
        finger.hopping = c.hops;
        nonfinite |= !is_finite(c.proxy) || !is_finite(force);
        capped |= c.counts.capped;
        reasons |= tick.forces[k].reasons;
        const bool limited = all_sent && (tick.forces[k].reasons & guard_force) != 0;
        finger.limited = limited ? finger.limited + 1 : 0;
        force_limited_ticks_ += limited;
        longest_limited_ = std::max(longest_limited_, finger.limited);
        finger.in_hole = c.in_hole ? finger.in_hole + 1 : 0;
        hole_ticks_ += c.in_hole;
        limited_in_hole_ticks_ += c.in_hole && limited;
        longest_in_hole_ = std::max(longest_in_hole_, finger.in_hole);
        finger.energy.update(tick.forces[k].energy, tick.share(k));
        events_ += c.counts.events;
        if (!c.touching) continue;
        held_back_ticks_ += !all_sent;
        const double newtons = std::sqrt(glm::dot(force, force));
        force_sum_ += newtons;
        force_max_ = std::max(force_max_, newtons);
        largest_stiffness_ = std::max(largest_stiffness_, c.properties.stiffness);
        smallest_stiffness_ = std::min(smallest_stiffness_, c.properties.stiffness);
    }
    ++ticks_;
    contact_ticks_ += contact;
    behind_ticks_ += tick.behind;
    nonfinite_ticks_ += nonfinite;
    capped_ticks_ += capped;
    guarded_ticks_ += reasons != guard_none;
    stiffness_limited_ticks_ += (reasons & guard_stiffness) != 0;
    waiting_ticks_ += (reasons & guard_waiting) != 0;
    stale_ticks_ += (reasons & guard_stale) != 0;
    tick_us_.add(tick.solve_us);
    late_us_.add(tick.late_us);
    const auto bin = std::ranges::upper_bound(late_below_us, tick.late_us);
    ++late_ticks_[static_cast<std::size_t>(bin - late_below_us.begin())];
    return {};
}

nlohmann::ordered_json TouchFigures::late_histogram() const {
    auto histogram = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < late_below_us.size(); ++k)
        histogram.push_back({{"below_us", late_below_us[k]}, {"ticks", late_ticks_[k]}});
    histogram.push_back({{"ticks", late_ticks_.back()}});
    return histogram;
}

EnergyFigures TouchFigures::energy() const {
    EnergyFigures all = energy_before_;
    for (const Finger& finger : fingers_) {
        const EnergyFigures& sent = finger.energy.figures();
        all.created += sent.created;
        all.bound += sent.bound;
        all.surface += sent.surface;
        all.work += sent.work;
    }
    return all;
}

void TouchFigures::end_part() {
    energy_before_ = energy();
    fingers_.clear();
}

nlohmann::ordered_json TouchFigures::energy_mj() const {
    const EnergyFigures all = energy();
    return {{"created", 1000 * all.created},
            {"zoh_bound", 1000 * all.bound},
            {"surface", 1000 * all.surface},
            {"on_hand", 1000 * all.work}};
}

nlohmann::ordered_json TouchFigures::to_json() const {
    const auto noticed = just_noticed_newtons(force_max_);
    return {{"ticks", ticks_},
            {"contact_ticks", contact_ticks_},
            {"fingers_led", fingers_led()},
            {"finger_contact_pct",
             100.0 * share(static_cast<double>(finger_contact_ticks_), ticks_ * fingers_led())},
            {"hops", hops_},
            {"proxy_behind_mesh_ticks", behind_ticks_},
            {"nonfinite_ticks", nonfinite_ticks_},
            {"capped_ticks", capped_ticks_},
            {"guarded_ticks", guarded_ticks_},
            {"waiting_ticks", waiting_ticks_},
            {"stale_ticks", stale_ticks_},
            {"late_ticks", 0},  // a live run overwrites this
            {"events_mean", share(static_cast<double>(events_), finger_contact_ticks_)},
            {"force_hash", force_hash()},
            {"force_n",
             {{"mean", share(force_sum_, finger_contact_ticks_)},
              {"max", force_max_},
              {"max_jnd", noticed ? nlohmann::ordered_json(*noticed) : nlohmann::ordered_json()}}},
            {"force_limited", {{"finger_ticks", force_limited_ticks_}, {"longest_ticks", longest_limited_}}},
            {"stiffness_limited",
             {{"ticks", stiffness_limited_ticks_},
              {"smallest_n_mm", std::min(smallest_stiffness_, largest_stiffness_) / 1000},
              {"largest_n_mm", largest_stiffness_ / 1000}}},
            {"energy_mj", energy_mj()},
            {"hole_contact",
             {{"finger_ticks", hole_ticks_},
              {"contact_pct", 100.0 * share(static_cast<double>(hole_ticks_), finger_contact_ticks_)},
              {"longest_ticks", longest_in_hole_},
              {"force_limited_ticks", limited_in_hole_ticks_}}},
            {"held_back_ticks", held_back_ticks_},
            {"tick_us", touchable::to_json(tick_us_.spread())}};
}

}  // namespace touchable
