#include "tests/stress/coverage.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace touchable::stress {

namespace {

double percent(std::int64_t part, std::int64_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

void Coverage::add(const Coverage& o) {
    for (const auto sum :
         {&Coverage::ticks, &Coverage::finger_ticks, &Coverage::contact, &Coverage::with_heights,
          &Coverage::with_friction, &Coverage::sliding, &Coverage::at_invalid, &Coverage::in_holes,
          &Coverage::landings, &Coverage::departures, &Coverage::frame_changes, &Coverage::between_frames,
          &Coverage::held_goals, &Coverage::refusals, &Coverage::capped, &Coverage::certified,
          &Coverage::compared, &Coverage::other_basins})
        this->*sum += o.*sum;
    most_events = std::max(most_events, o.most_events);
    for (const auto worst :
         {&Coverage::worst_behind, &Coverage::worst_excess, &Coverage::worst_way, &Coverage::worst_ratio,
          &Coverage::worst_angle, &Coverage::energy_created, &Coverage::energy_bound})
        this->*worst = std::max(this->*worst, o.*worst);
}

double Coverage::contact_share() const {
    return percent(contact, finger_ticks) / 100;
}

std::string Coverage::missing(const Needs& needs) const {
    if (contact_share() < needs.contact) {
        std::array<char, 96> text;
        std::snprintf(text.data(), text.size(), "contact in %.1f %% of ticks only, %.0f %% are needed",
                      100 * contact_share(), 100 * needs.contact);
        return text.data();
    }
    if (needs.frame_changes && frame_changes == 0) return "no frame changed";
    if (needs.refusals && refusals == 0) return "nothing impossible was refused";
    if (needs.held_goals && held_goals == 0) return "every goal was a number";
    if (certified == 0 && contact > capped) return "no tick was certified";
    return {};
}

std::string Coverage::in_words() const {
    std::array<char, 512> text;
    std::snprintf(
        text.data(), text.size(),
        "contact %.1f %%, landings %lld, departures %lld; of contact: heights %.0f %%, friction %.0f %% "
        "(sliding %.0f %%), at invalid pixels %.1f %%, hole stiffness %.1f %%; frame changes %lld, between "
        "frames %.0f %%, "
        "held goals %lld, refusals %lld; most events %lld, capped %lld; "
        "certified %lld (way left %.1e, behind %.1e), "
        "compared %lld (other basins %lld, distance x %.9f, angle %.1e deg); "
        "energy created %.3g of at most %.3g mJ",
        100 * contact_share(), static_cast<long long>(landings), static_cast<long long>(departures),
        percent(with_heights, contact), percent(with_friction, contact), percent(sliding, contact),
        percent(at_invalid, certified), percent(in_holes, certified), static_cast<long long>(frame_changes),
        percent(between_frames, ticks), static_cast<long long>(held_goals), static_cast<long long>(refusals),
        static_cast<long long>(most_events), static_cast<long long>(capped),
        static_cast<long long>(certified), worst_way, worst_behind, static_cast<long long>(compared),
        static_cast<long long>(other_basins), worst_ratio, worst_angle, 1000 * energy_created,
        1000 * energy_bound);
    return text.data();
}

}  // namespace touchable::stress
