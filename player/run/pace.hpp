#pragma once

namespace touchable {

/// By which clock a run goes, and so what becomes of its files.
enum class Pace {
    own,         ///< it can be repeated: it waits for whoever reads, and a file is whole or not there
    wall_clock,  ///< it cannot: it waits for nobody, and what a full disk has taken of a file is kept
};

}  // namespace touchable
