#include "player/session/sent_energy.hpp"

#include <algorithm>

namespace touchable {

/// The force that was held did the tick's work, and the spring that it is of stood before it.
void SentEnergy::take(const EnergyFigures& guarded, double share) {
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

}  // namespace touchable
