#include "player/draw/cpu_lattice.hpp"
#include "player/draw/lattice_raster.hpp"
#include "player/draw/surface_edges.hpp"
#include "player/draw/surface_painter.hpp"
#include "player/draw/view_rows.hpp"

namespace touchable {
namespace {

class CpuPainter final : public SurfacePainter {
public:
    std::string_view name() const override { return "cpu"; }

    Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair,
                                   const PlaneView& colour) override {
        return lattices_.surface_of(field, pair, colour);
    }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        const auto width = static_cast<std::size_t>(camera.width),
                   height = static_cast<std::size_t>(camera.height);
        PicturePlanes planes{camera.width, camera.height, std::vector<float>(width * height),
                             std::vector<PackedColour>(width * height)};
        edges_.clear();
        if (!is_own_view(camera))
            edges_.find(surface.q.data(), surface.width, surface.height, surface.width, CUT_RULE_RATIO,
                        surface.colours_are_values);
        raster_.draw({surface.q.data(), surface.colours.data(), surface.width, surface.height, surface.width},
                     edges_, camera, std::vector<PackedColour>(height), camera.width, planes.colours,
                     planes.z);
        return planes;
    }

private:
    CpuLattices lattices_{CpuLattices::usual_threads()};
    SurfaceEdges edges_{CpuLattices::usual_threads()};  // of what is painted
    LatticeRaster raster_{CpuLattices::usual_threads()};
};

}  // namespace

std::unique_ptr<SurfacePainter> make_cpu_painter() {
    return std::make_unique<CpuPainter>();
}

}  // namespace touchable
