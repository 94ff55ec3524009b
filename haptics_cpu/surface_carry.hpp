#pragma once

#include "haptics_cpu/proxy.hpp"

namespace touchable {

/// Takes a proxy along with a surface that moved since its last tick, so that it is on or in front of it
/// again (docs/solver.md, A surface that moves); sets proxy.point. A proxy on the surface stays on its
/// pixel's ray; a free one that the surface rose past is taken along on its own.
///
/// A ray's way farther than `sudden` (lengths of the space) is asked about. A proxy that was buried goes to
/// the nearest place of the surface instead, where one in the window is less than half as far: an object that
/// arrived from the side pushes it aside, and does not pop it to its front. One whose surface sank away is
/// free where it was. Only of the world's metric; the paper's knows only the ray. False where the proxy did
/// not stay on its ray.
template <class Space>
bool carry(const Space& space, Proxy& proxy, double sudden);

}  // namespace touchable
