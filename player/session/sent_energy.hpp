#pragma once

#include "haptics_cpu/energy_account.hpp"

namespace touchable {

/// A finger's energy as it was sent: of each force only the share that went to the hand did work on it, and
/// of the spring only that share was there. What is let through more or less is no motion of the hand's, and
/// so counts as put in by the surface, as the guard's ramp does.
class SentEnergy {
public:
    /// Of a tick: the guard's books up to it, and the share of its force that is sent and held. As long as
    /// all is sent, the figures are the guard's own to the bit.
    void take(const EnergyFigures& guarded, double share);
    const EnergyFigures& figures() const { return sent_; }

private:
    EnergyFigures guarded_, kept_, sent_;  // kept back: guarded less sent
    double share_ = 1;                     // of the force that is held
};

}  // namespace touchable
