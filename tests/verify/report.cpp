#include <iomanip>

#include "tests/verify/checks.hpp"

namespace touchable::verify {
namespace {

void line(std::ostream& out, std::string_view what, std::int64_t count) {
    out << "  " << std::left << std::setw(44) << what << std::right << std::setw(12) << count << '\n';
}

}  // namespace

std::string_view name_of(Check check) {
    switch (check) {
        case Check::order:
            return "rows complete and in turn, S constant";
        case Check::finite:
            return "all numbers finite";
        case Check::behind:
            return "proxy not behind the surface";
        case Check::off_surface:
            return "in contact: proxy on the surface";
        case Check::pixel:
            return "in contact: pixel is where the proxy is";
        case Check::properties:
            return "in contact: stiffness and friction";
        case Check::force:
            return "in contact: F = k S (P - G)";
        case Check::free:
            return "out of contact: P = G, F = 0";
        case Check::minimum:
            return "minimum, or within the friction cone";
        case Check::slip:
            return "sticks, or slides to the dynamic cone";
        case Check::count_:
            break;
    }
    return "";
}

void Verifier::report(std::ostream& out) const {
    const Coverage& c = coverage_;
    out << "covered\n";
    line(out, "rows (ticks x fingers)", c.rows);
    line(out, "fingers", c.fingers);
    line(out, "frames", static_cast<std::int64_t>(c.frames.size()));
    line(out, "rows between two frames", c.between);
    line(out, "rows in contact", c.contacts);
    line(out, "  without friction: on a face", c.frictionless[0]);
    line(out, "                    on an edge", c.frictionless[1]);
    line(out, "                    at a vertex", c.frictionless[2]);
    line(out, "  with friction:    on a face", c.friction[0]);
    line(out, "                    on an edge", c.friction[1]);
    line(out, "                    at a vertex", c.friction[2]);
    line(out, "  held by friction away from the minimum", c.stuck);
    line(out, "  whose step within a facet was checked", c.slip_checked);
    line(out, "  where height is taken off", c.with_height);
    line(out, "  beside an invalid pixel", c.near_invalid);
    line(out, "  on the picture's ring or outside it", c.on_ring);
    line(out, "rows with a force changed by the guard", c.guarded);
    line(out, "rows capped by the event limit: no minimum yet", c.capped);
    out << std::scientific << std::setprecision(2) << "  largest deficit of q, relative " << c.largest_deficit
        << "; of the force " << c.largest_force_error << "; of the minimum " << c.largest_residual << '\n'
        << std::defaultfloat << std::setprecision(4) << "violations\n";
    for (std::size_t k = 0; k < findings_.size(); ++k) {
        line(out, name_of(static_cast<Check>(k)), findings_[k].count);
        for (const std::string& text : findings_[k].first) out << "    " << text << '\n';
    }
}

}  // namespace touchable::verify
