#pragma once

#include <istream>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/stress/watch.hpp"

/// Everything a run went through, one line of text a tick and finger, to find where two runs part: of two
/// compilers, two builders, two versions.
namespace touchable::stress {

/// Names of what a line holds, in order: tick, finger, goal, proxy, force and so on (the header of a file).
const std::vector<std::string>& state_fields();

/// Writes the header, then every tick. Numbers have 17 digits: equal text is equal bits (but for NaN's).
class StateWriter final : public TickSink {
public:
    explicit StateWriter(std::ostream& out);
    void take(const TouchTick& tick, std::span<const FingerState> fingers) override;

private:
    std::ostream& out_;
};

/// Compares a run with a written one as it goes, and remembers the first difference.
class StateComparison final : public TickSink {
public:
    /// `recorded` outlives this. Its header may be of another version: that is a difference.
    explicit StateComparison(std::istream& recorded);
    void take(const TouchTick& tick, std::span<const FingerState> fingers) override;
    /// "tick 17, finger 0, field force_x: 1.25, recorded 1.5", or nothing. To be asked once the run is over:
    /// what the other one has more of counts as well.
    std::optional<std::string> difference();

private:
    std::istream& recorded_;
    std::optional<std::string> difference_;
};

}  // namespace touchable::stress
