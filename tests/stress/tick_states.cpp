#include "tests/stress/tick_states.hpp"

#include <array>
#include <cstdio>
#include <sstream>

namespace touchable::stress {

namespace {

class Line {
public:
    Line& add(std::int64_t value) { return text(std::to_string(value)); }
    Line& add(double value) {
        std::array<char, 32> digits;
        std::snprintf(digits.data(), digits.size(), "%.17g", value);
        return text(digits.data());
    }
    Line& add(const glm::dvec3& v) { return add(v.x).add(v.y).add(v.z); }
    const std::string& str() const { return line_; }

private:
    Line& text(const std::string& cell) {
        line_ += (line_.empty() ? "" : ",") + cell;
        return *this;
    }
    std::string line_;
};

std::string line_of(const TouchTick& tick, const FingerState& finger, std::size_t k) {
    const Contact& contact = tick.contacts[k];
    const Proxy& proxy = finger.proxy;
    Line line;
    line.add(tick.tick).add(static_cast<std::int64_t>(k));
    line.add(tick.pair.prev.number).add(tick.pair.next.number).add(tick.blend);
    line.add(contact.goal).add(static_cast<std::int64_t>(contact.goal_held));
    line.add(static_cast<std::int64_t>(proxy.feature)).add(proxy.i).add(proxy.j).add(proxy.a).add(proxy.b);
    line.add(static_cast<std::int64_t>(proxy.sliding)).add(contact.proxy);
    line.add(std::int64_t{contact.counts.events}).add(static_cast<std::int64_t>(contact.counts.capped));
    line.add(contact.properties.stiffness);
    line.add(contact.properties.static_friction).add(contact.properties.dynamic_friction);
    line.add(contact.force).add(tick.forces[k].force).add(std::int64_t{tick.forces[k].reasons});
    return line.str();
}

std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
}

std::string header() {
    std::string line;
    for (const std::string& field : state_fields()) line += (line.empty() ? "" : ",") + field;
    return line;
}

/// Where two lines of the same place part.
std::string parting(const std::string& now, const std::string& recorded) {
    const auto cells = cells_of(now), others = cells_of(recorded);
    const std::string where = "tick " + cells[0] + ", finger " + cells[1];
    for (std::size_t k = 0; k < cells.size(); ++k)
        if (k >= others.size() || cells[k] != others[k])
            return where + ", field " + state_fields()[k] + ": " + cells[k] + ", recorded " +
                   (k < others.size() ? others[k] : "nothing");
    return where + ": the recorded line goes on";
}

}  // namespace

const std::vector<std::string>& state_fields() {
    static const std::vector<std::string> fields{"tick",
                                                 "finger",
                                                 "frame_prev",
                                                 "frame_next",
                                                 "blend",
                                                 "goal_x",
                                                 "goal_y",
                                                 "goal_z",
                                                 "goal_held",
                                                 "feature",
                                                 "i",
                                                 "j",
                                                 "a",
                                                 "b",
                                                 "sliding",
                                                 "proxy_x",
                                                 "proxy_y",
                                                 "proxy_z",
                                                 "events",
                                                 "capped",
                                                 "stiffness",
                                                 "mu_static",
                                                 "mu_dynamic",
                                                 "solver_force_x",
                                                 "solver_force_y",
                                                 "solver_force_z",
                                                 "force_x",
                                                 "force_y",
                                                 "force_z",
                                                 "guard"};
    return fields;
}

StateWriter::StateWriter(std::ostream& out) : out_(out) {
    out_ << header() << '\n';
}

void StateWriter::take(const TouchTick& tick, std::span<const FingerState> fingers) {
    for (std::size_t k = 0; k < fingers.size(); ++k) out_ << line_of(tick, fingers[k], k) << '\n';
}

StateComparison::StateComparison(std::istream& recorded) : recorded_(recorded) {
    std::string first;
    std::getline(recorded_, first);
    if (first != header()) difference_ = "the recorded states have other fields";
}

void StateComparison::take(const TouchTick& tick, std::span<const FingerState> fingers) {
    for (std::size_t k = 0; k < fingers.size() && !difference_; ++k) {
        const std::string now = line_of(tick, fingers[k], k);
        std::string then;
        if (!std::getline(recorded_, then))
            difference_ = "tick " + std::to_string(tick.tick) + ", finger " + std::to_string(k) +
                          ": the recorded run has ended";
        else if (now != then)
            difference_ = parting(now, then);
    }
}

std::optional<std::string> StateComparison::difference() {
    std::string more;
    if (!difference_ && std::getline(recorded_, more)) difference_ = "the recorded run goes on: " + more;
    return difference_;
}

}  // namespace touchable::stress
