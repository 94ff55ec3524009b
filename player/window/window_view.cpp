#include "player/window/window_view.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace touchable {
namespace {

/// The same pixels, and so many rows more below them.
ViewCamera with_rows_below(ViewCamera camera, int rows) {
    const double share = static_cast<double>(camera.height) / (camera.height + rows);
    for (glm::dmat4* const matrix : {&camera.clip_from_world, &camera.clip_from_lattice})
        for (int column = 0; column < 4; ++column) {
            glm::dvec4& to = (*matrix)[column];
            to.y = share * to.y - (1 - share) * to.w;
        }
    camera.height += rows;
    return camera;
}

}  // namespace

// On the clip camera's axis, so that the first turn does not jump.
WindowView::WindowView(const Scene& scene, const glm::dvec3& middle)
    : scene_(scene), home_(0, 0, middle.z), centre_(home_) {
    orbit_.zoom = 1;
    orbit_.keeps_axis = true;
}

ViewCamera WindowView::camera(int width, int height) const {
    Viewpoint viewpoint = orbit_;
    viewpoint.own = own_;
    const int below = std::clamp(static_cast<int>(std::lround(below_ * height)), 0, std::max(height - 1, 0));
    const ViewCamera camera = make_view(viewpoint, scene_, centre_, width, height - below);
    return below > 0 ? with_rows_below(camera, below) : camera;
}

double WindowView::pixels_per_vertex(int width, int height) const {
    const double whole =
        std::min(static_cast<double>(width) / scene_.width, (1 - below_) * height / scene_.height);
    return own_ ? whole : whole * orbit_.zoom.value_or(1);
}

void WindowView::leave_own() {
    own_ = false;
}

void WindowView::turn(double azimuth, double elevation) {
    leave_own();
    orbit_.azimuth = std::remainder(orbit_.azimuth + azimuth, 360.0);
    orbit_.elevation = std::clamp(orbit_.elevation + elevation, -89.0, 89.0);
}

void WindowView::pan(double x, double y, int width, int height) {
    leave_own();
    const ViewCamera camera = this->camera(std::max(width, 1), std::max(height, 1));
    const auto middle = camera.project(centre_);
    if (!middle) return;
    const glm::dvec3 moved = centre_ + camera.unproject(middle->x - x, middle->y - y, middle->z) -
                             camera.unproject(middle->x, middle->y, middle->z);
    set_centre(moved);
}

void WindowView::near_by(double factor) {
    leave_own();
    orbit_.zoom = std::clamp(orbit_.zoom.value_or(1) * factor, 0.1, 20.0);
}

void WindowView::look_at(const glm::dvec3& place) {
    leave_own();
    set_centre(place);
}

/// The eye stays as far away as it was; zoom counts from the clip's camera.
void WindowView::set_centre(const glm::dvec3& place) {
    if (!(place.z < 0)) return;
    orbit_.zoom = std::clamp(orbit_.zoom.value_or(1) * place.z / centre_.z, 0.1, 20.0);
    centre_ = place;
}

void WindowView::look_as(const WindowView& other) {
    go_home();
    own_ = other.own_;
    orbit_ = other.orbit_;
}

void WindowView::go_home() {
    own_ = true;
    orbit_ = Viewpoint{};
    orbit_.zoom = 1;
    orbit_.keeps_axis = true;
    centre_ = home_;
}

}  // namespace touchable
