// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "tests/verify/verify_forces.hpp"

namespace touchable::verify {
namespace {

constexpr real relative = 1e-9L;

template <class... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream stream;
    stream.precision(12);
    (stream << ... << parts);
    return stream.str();
}

std::string text_of(const Vec3& v) {
    return text("(", v.x, ", ", v.y, ", ", v.z, ")");
}

bool finite(const ForceRow& r) {
    const std::array<real, 16> numbers = {
        r.goal.x,  r.goal.y,  r.goal.z,  r.proxy.x,   r.proxy.y,   r.proxy.z,    r.force.x,         r.force.y,
        r.force.z, r.pixel_x, r.pixel_y, r.stiffness, r.mu_static, r.mu_dynamic, r.metres_per_unit, r.blend};
    return std::all_of(numbers.begin(), numbers.end(), [](real v) { return std::isfinite(v); });
}

bool close(real a, real b) {
    return std::fabs(a - b) <= relative * (1 + std::fabs(b));
}

}  // namespace

void Verifier::found(Check check, const ForceRow& row, const std::string& what) {
    Finding& finding = findings_[static_cast<std::size_t>(check)];
    if (finding.count++ < settings_.shown)
        finding.first.push_back(
            text("tick ", row.tick, " finger ", row.finger, " (line ", row.line, "): ", what));
}

void Verifier::check_order(const ForceRow& row) {
    if (last_) {
        const bool same_tick = row.tick == last_->tick && row.finger == last_->finger + 1;
        const bool next_tick =
            row.tick == last_->tick + 1 && row.finger == 0 && last_->finger + 1 == coverage_.fingers;
        const bool first_tick = last_->finger + 1 == coverage_.fingers;  // which tells how many there are
        if (same_tick && first_tick && coverage_.rows == coverage_.fingers)
            ++coverage_.fingers;
        else if (!next_tick && !(same_tick && row.finger < coverage_.fingers))
            found(Check::order, row,
                  text("follows tick ", last_->tick, " finger ", last_->finger, " of ", coverage_.fingers));
    } else {
        coverage_.fingers = 1;
        if (row.finger != 0) found(Check::order, row, "must be finger 0");
    }
    if (!metres_per_unit_) metres_per_unit_ = row.metres_per_unit;
    if (!(row.metres_per_unit > 0 && row.metres_per_unit == *metres_per_unit_))
        found(Check::order, row, text("S is ", row.metres_per_unit, ", at first ", *metres_per_unit_));
    last_ = row;
}

void Verifier::finish() {
    if (last_ && last_->finger + 1 != coverage_.fingers)
        found(Check::order, *last_, text("the last tick has not all ", coverage_.fingers, " fingers"));
}

Result<void> Verifier::check(const ForceRow& row) {
    check_order(row);
    ++coverage_.rows;
    if (!finite(row)) {
        found(Check::finite, row, "a number is not finite");
        return {};
    }
    auto earlier = frames_.get(row.frame_prev);
    if (!earlier) return earlier.error();
    auto later = frames_.get(row.frame_next);
    if (!later) return later.error();
    coverage_.frames.insert({row.frame_prev, row.frame_next});
    coverage_.between += row.frame_prev != row.frame_next && row.blend > 0;
    coverage_.guarded += row.guarded;
    const Surface surface(**earlier, **later, row.blend);
    if (row.contact)
        check_contact(row, surface);
    else
        check_free(row, surface);
    return {};
}

void Verifier::check_free(const ForceRow& row, const Surface& surface) {
    trails_.erase(row.finger);
    if (!(row.proxy == row.goal) || !(row.force == Vec3{}))
        found(Check::free, row,
              text("out of contact, but P - G is ", text_of(row.proxy - row.goal), " and F ",
                   text_of(row.force)));
    if (row.proxy.z < 0)
        check_place(row, surface);  // what is not in front of the camera is not behind anything
}

void Verifier::check_contact(const ForceRow& row, const Surface& surface) {
    ++coverage_.contacts;
    if (!(row.proxy.z < 0)) {
        trails_.erase(row.finger);
        return found(Check::off_surface, row,
                     text("in contact at z = ", row.proxy.z, ", not before the camera"));
    }
    const bool placed = check_place(row, surface);
    const ImagePosition at = surface.project(row.proxy);
    if (std::fabs(at.x - row.pixel_x) > 1e-6L + relative * std::fabs(at.x) ||
        std::fabs(at.y - row.pixel_y) > 1e-6L + relative * std::fabs(at.y))
        found(Check::pixel, row,
              text("is seen at (", at.x, ", ", at.y, "), not (", row.pixel_x, ", ", row.pixel_y, ")"));
    const Touch touch = surface.touch_at({row.pixel_x, row.pixel_y});
    check_properties(row, touch);
    check_force(row);
    if (!placed) {
        trails_.erase(row.finger);
        return;
    }
    const Star star = star_at(surface, at);
    cover(surface, star, touch.mu_static);
    if (row.capped) {
        ++coverage_.capped;
        trails_.erase(row.finger);
        return;
    }
    check_minimum(row, star, touch.mu_static);
    if (settings_.check_slip) check_slip(row, star, surface);
}

bool Verifier::check_place(const ForceRow& row, const Surface& surface) {
    const real q = -1 / row.proxy.z, wanted = surface.q_at(surface.project(row.proxy));
    coverage_.largest_deficit = std::max(coverage_.largest_deficit, 1 - q / wanted);
    const bool behind = q < wanted * (1 - relative), before = row.contact && q > wanted * (1 + relative);
    if (behind)
        found(Check::behind, row,
              text("the proxy's q is ", q, ", the surface's ", wanted, ": ",
                   static_cast<double>(1 - q / wanted), " behind"));
    if (before)
        found(Check::off_surface, row,
              text("in contact, but the proxy's q is ", q, ", the surface's ", wanted));
    return !behind && !before;
}

void Verifier::check_properties(const ForceRow& row, const Touch& touch) {
    const bool stiffness = row.guarded || close(row.stiffness, touch.stiffness);  // the guard may clamp it
    if (!stiffness || !close(row.mu_static, touch.mu_static) || !close(row.mu_dynamic, touch.mu_dynamic))
        found(Check::properties, row,
              text("stiffness ", row.stiffness, ", friction ", row.mu_static, " and ", row.mu_dynamic,
                   " at (", row.pixel_x, ", ", row.pixel_y, ") must be ", touch.stiffness, ", ",
                   touch.mu_static, " and ", touch.mu_dynamic));
}

void Verifier::check_force(const ForceRow& row) {
    const Vec3 wanted = row.share * row.stiffness * row.metres_per_unit * (row.proxy - row.goal);
    if (row.guarded) {
        if (!row.braked && length(row.force) > length(wanted) * (1 + relative))
            found(Check::force, row, text("the guard made ", length(row.force), " N of ", length(wanted)));
        return;
    }
    const real error = length(row.force - wanted);
    if (length(wanted) > 0)
        coverage_.largest_force_error = std::max(coverage_.largest_force_error, error / length(wanted));
    if (!(error <= relative * length(wanted)))
        found(Check::force, row,
              text("F is ", text_of(row.force), ", its share of k S (P - G) ", text_of(wanted)));
}

void Verifier::check_minimum(const ForceRow& row, const Star& star, real mu) {
    const Judgement j = judge(star, row.proxy, row.goal, mu);
    const real distance = length(row.goal - row.proxy);
    coverage_.stuck += j.verdict == Verdict::stuck;
    if (j.holds()) {
        if (distance > 1e-6L * length(row.proxy))  // below, it is rounding
            coverage_.largest_residual =
                std::max(coverage_.largest_residual, std::max<real>(0, j.tangential - j.allowed) / distance);
        return;
    }
    static constexpr std::array<std::string_view, 3> places = {"a face", "an edge", "a vertex"};
    const std::string where = text("on ", places[std::min<std::size_t>(2, star.facets.size() - 1)], " at (",
                                   row.pixel_x, ", ", row.pixel_y, "), |P - G| ", distance, ": ");
    if (j.verdict == Verdict::leaves)
        found(Check::minimum, row, where + "the straight way to the goal is free");
    else
        found(Check::minimum, row,
              where + text("slides ", j.tangential, " to the closest point, friction holds ", j.allowed));
}

void Verifier::check_slip(const ForceRow& row, const Star& star, const Surface& surface) {
    const auto trail = trails_.find(row.finger);
    const Vec3 pixel{row.pixel_x, row.pixel_y, 0};
    if (star.facets.size() > 1) {
        trails_[row.finger] = {pixel, std::nullopt};
        return;
    }
    const Facet& facet = star.facets[0];
    Motion motion = Motion::unknown;
    if (trail != trails_.end()) {
        const Trail& last = trail->second;
        if (last.before) {
            std::string why;
            const Step step = judge_step(*last.before, row, facet, surface, why);
            coverage_.slip_checked += step != Step::unknown;
            if (step == Step::wrong) found(Check::slip, row, why);
        }
        if (last.pixel == pixel)
            motion = Motion::none;
        else if (last.before && last.before->facet == facet && length(last.pixel - pixel) > 1e-9L)
            motion = Motion::slid;
    }
    trails_[row.finger] = {pixel, Before{row.tick, facet, row.proxy, motion}};
}

void Verifier::cover(const Surface& surface, const Star& star, real mu) {
    const std::size_t place = std::min<std::size_t>(2, star.facets.size() - 1);
    ++(mu > 0 ? coverage_.friction : coverage_.frictionless)[place];
    const Meaning& m = surface.meaning();
    const FacetId id = star.facets[0].id;
    const bool in_picture = id.column >= 0 && id.row >= 0 && id.column < m.width - 1 && id.row < m.height - 1;
    if (!in_picture) {
        ++coverage_.on_ring;
        return;
    }
    bool invalid = false, height = false;
    for (int corner = 0; corner < 4; ++corner) {
        if (corner == (id.half == 0 ? 2 : 1)) continue;  // not of this half
        const Vertex v = surface.vertex(id.column + (corner & 1), id.row + (corner >> 1));
        invalid |= !v.solid;
        height |= v.height > 0;
    }
    coverage_.near_invalid += invalid;
    coverage_.with_height += height;
}

std::int64_t Verifier::violations() const {
    std::int64_t sum = 0;
    for (const Finding& finding : findings_) sum += finding.count;
    return sum;
}

}  // namespace touchable::verify
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
namespace touchable::verify {
namespace {

constexpr std::string_view usage =
    "verify_forces --forces FILE.csv --frames DIR [--min-contact SHARE] [--no-slip] [--shown N]\n"
    "  FILE.csv       written by touchable touch --forces\n"
    "  DIR            DIR/N holds what touchable export --frame N wrote, for every frame that the file "
    "names\n"
    "  --min-contact  fail where fewer rows are in contact, 0 to 1 (default 0)\n"
    "  --no-slip      do not check how a proxy moves within a facet (for substeps, or other than Coulomb "
    "friction)\n"
    "  --shown        offenders shown of each kind (default 3)\n";

struct Options {
    std::string forces, frames;
    double min_contact = 0;
    Settings settings;
};

template <class Number>
bool read_number(const std::string& text, Number least, Number most, Number& out) {
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), out);
    return status == std::errc() && end == text.data() + text.size() && out >= least && out <= most;
}

Result<Options> read_options(const std::vector<std::string>& arguments) {
    Options options;
    for (std::size_t k = 0; k < arguments.size(); ++k) {
        const std::string& name = arguments[k];
        if (name == "--no-slip") {
            options.settings.check_slip = false;
            continue;
        }
        if (name != "--forces" && name != "--frames" && name != "--min-contact" && name != "--shown")
            return usage_error("unknown option " + name);
        if (k + 1 == arguments.size()) return usage_error(name + " needs a value");
        const std::string& value = arguments[++k];
        if (name == "--forces") options.forces = value;
        if (name == "--frames") options.frames = value;
        if (name == "--min-contact" && !read_number(value, 0.0, 1.0, options.min_contact))
            return usage_error("--min-contact is \"" + value + "\": must be 0 to 1");
        if (name == "--shown" && !read_number(value, 0, 1000000, options.settings.shown))
            return usage_error("--shown is \"" + value + "\": must be a whole number, 0 or more");
    }
    if (options.forces.empty() || options.frames.empty())
        return usage_error("--forces and --frames must be given");
    return options;
}

Result<void> check_rows(const std::string& forces, Verifier& verifier) {
    auto reader = ForcesReader::open(forces);
    if (!reader) return reader.error();
    ForceRow row;
    for (;;) {
        const auto more = reader->next(row);
        if (!more) return more.error();
        if (!*more) break;
        if (auto checked = verifier.check(row); !checked)
            return input_error(checked.error().message + " (line " + std::to_string(row.line) + " of " +
                               forces + " needs it)");
    }
    verifier.finish();
    if (verifier.coverage().rows == 0) return input_error(forces + ": has no rows");
    return {};
}

}  // namespace

int verify_forces(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
    const auto options = read_options(arguments);
    if (!options) {
        err << "verify_forces: " << options.error().message << '\n' << usage;
        return exit_code(options.error().kind);
    }
    FrameStore frames(options->frames);
    Verifier verifier(frames, options->settings);
    if (const auto checked = check_rows(options->forces, verifier); !checked) {
        err << "verify_forces: " << checked.error().message << '\n';
        return exit_code(checked.error().kind);
    }
    verifier.report(out);
    const Coverage& c = verifier.coverage();
    const double share = static_cast<double>(c.contacts) / static_cast<double>(c.rows);
    out << "contact share " << share << ", at least " << options->min_contact << " wanted\n";
    const bool good = verifier.violations() == 0 && share >= options->min_contact;
    out << (good ? "verified" : "NOT verified") << '\n';
    return good ? 0 : exit_code(ErrorKind::check);
}

}  // namespace touchable::verify
