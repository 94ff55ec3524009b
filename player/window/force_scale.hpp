#pragma once

#include <algorithm>
#include <span>

namespace touchable {

/// What the force bar goes up to: a round number of newtons, which rises at once where a force is higher, and
/// falls once no force has been for a while, so that bars do not jump while a finger is pressed.
class ForceScale {
public:
    static constexpr double patience_s = 5;

    /// For these forces, N, at a time that does not go backward.
    double most_newtons(std::span<const double> forces, double now_s) {
        double wanted = 2;
        for (const double force : forces)
            while (wanted < force) wanted = wanted < 5 ? 5 : (wanted < 10 ? 10 : 2 * wanted);
        if (wanted > most_ || now_s - needed_s_ > patience_s) most_ = wanted;
        if (wanted >= most_) needed_s_ = now_s;
        return most_;
    }

private:
    double most_ = 2, needed_s_ = 0;
};

}  // namespace touchable
