#pragma once

#include "engine/frame/surface_frame.hpp"
#include "engine/surface/frame_changes.hpp"

namespace touchable {

/// Filtered vertices that know which build their frame holds. No other builder keeps them in a slot of its
/// own.
class TrackedVertices final : public FilteredVertices {
public:
    using FilteredVertices::FilteredVertices;
    BuildNumber build;
};

/// Those of a slot, new ones where it has none.
inline TrackedVertices& tracked_vertices(SurfaceFrame& slot) {
    auto* vertices = dynamic_cast<TrackedVertices*>(slot.vertices.get());
    if (vertices != nullptr) return *vertices;
    auto made = std::make_unique<TrackedVertices>(slot);
    vertices = made.get();
    slot.vertices = std::move(made);
    return *vertices;
}

}  // namespace touchable
