#include "player/draw/cpu_drawing.hpp"

#include <utility>

#include "engine/base/try.hpp"
#include "player/draw/surface_unproject.hpp"

namespace touchable {
CpuDrawing::CpuDrawing() : lattices_(CpuLattices::usual_threads()) {}

void CpuDrawing::show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting) {
    painted_.reset();
    surface_.width = field.width();
    surface_.height = field.height();
    if (SurfaceUnproject::has_codes(field, pair))
        lattices_.q_of(field, pair, surface_.q);
    else
        surface_.q = q_of(field);
    surface_.colours_are_values = lighting == Lighting::plain && !colour.empty();
    surface_.colours.resize(surface_.q.size());
    lattices_.light(field, surface_.q.data(), surface_.width, colour, lighting, surface_.colours.data());
}

/// The surface before the background, if it is not of this surface from here already.
Result<void> CpuDrawing::paint(const ViewCamera& camera) {
    if (painted_ == camera.clip_from_lattice && bare_.width == camera.width && bare_.height == camera.height)
        return {};
    TRY_ASSIGN(auto planes, painter_->paint(surface_, camera));
    bare_ = on_background(std::move(planes));
    painted_ = camera.clip_from_lattice;
    return {};
}

Result<const Image*> CpuDrawing::draw(const ViewCamera& camera, std::span<const FingerMark> fingers,
                                      const MarkSizes& sizes) {
    TRY(paint(camera));
    LightPicture touched = bare_;
    draw_fingers(fingers, sizes, camera, touched);
    picture_ = developed(touched, 1);
    return &picture_;
}

}  // namespace touchable
