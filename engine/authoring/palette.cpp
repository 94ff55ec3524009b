#include "engine/authoring/palette.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "engine/base/nearest_word.hpp"
#include "engine/base/printable.hpp"

namespace touchable {
namespace {

constexpr double hard = as_stiff_as_the_device;
constexpr std::string_view limit = "as stiff as the device can", estimate = "estimate";

// Friction from HaTT is that of a hand-held tool's tip that slides: the median of its materials of a kind.
// It has no static friction: that is estimated as four thirds of the dynamic one.
constexpr std::array<PaletteMaterial, 20> materials{{
    {"wood", hard, 0.29, 0.216, 100, limit, "HaTT: MDF, painted, stained and plain wood"},
    {"metal", hard, 0.36, 0.268, 40, limit, "HaTT: aluminium (2), mesh, shelving, textured metal"},
    {"glass", hard, 0.18, 0.137, 0, limit, "estimate: HaTT's glazed ceramic"},
    {"ceramic", hard, 0.18, 0.137, 30, limit, "HaTT: ceramic"},
    {"plastic", hard, 0.27, 0.206, 40, limit, "HaTT: ABS, acrylic (2), plastic mesh (2)"},
    {"paper", 1.2, 0.32, 0.24, 20, estimate, "HaTT: paper of 10 kinds"},
    {"cardboard", 1, 0.37, 0.28, 50, estimate, "HaTT: cardboard, gift box"},
    {"cloth", 0.5, 0.41, 0.307, 100, estimate, "HaTT: cotton, denim, silk and other cloth (10)"},
    {"felt", 0.5, 0.6, 0.447, 60, estimate, "HaTT: felt"},
    {"leather", 0.8, 0.53, 0.398, 100, estimate, "HaTT: fronts of leather (2)"},
    {"rubber", 1.1, 0.82, 0.612, 50, "flat punch of 4 mm radius, E 0.1 MPa", "HaTT: textured rubber"},
    {"foam", 0.22, 1.21, 0.911, 80, "flat punch of 4 mm radius, E 25 kPa",
     "HaTT: EPDM, pink and polyethylene foam"},
    {"cork", 1.5, 0.77, 0.578, 100, estimate, "HaTT: cork"},
    {"skin", 0.3, 0.61, 0.46, 60, estimate, "Zhang and Mak 1999: mean of all measurements"},
    {"stone", hard, 0.93, 0.699, 120, limit, "HaTT: stone tile (2)"},
    {"brick", hard, 0.68, 0.509, 150, limit, "HaTT: brick (2), painted brick"},
    {"carpet", 0.4, 1.34, 1.003, 150, estimate, "HaTT: carpet (4)"},
    {"fur", 0.15, 0.72, 0.54, 80, estimate, "estimate: HaTT's blanket, fleece, towel, velvet"},
    {"grass", 0.2, 1.48, 1.111, 150, estimate, "HaTT: artificial grass"},
    {"water", 0.05, 0.03, 0.02, 0, estimate, "estimate"},
}};

}  // namespace

std::span<const PaletteMaterial> palette() {
    return materials;
}

const PaletteMaterial* find_material(std::string_view name) {
    const auto found = std::find_if(materials.begin(), materials.end(),
                                    [&](const PaletteMaterial& material) { return material.name == name; });
    return found == materials.end() ? nullptr : &*found;
}

std::string material_names() {
    std::string all;
    for (const PaletteMaterial& material : materials)
        all += (all.empty() ? "" : ", ") + std::string(material.name);
    return all;
}

std::string no_such_material(std::string_view name) {
    std::vector<std::string> names;
    for (const PaletteMaterial& material : materials) names.emplace_back(material.name);
    const std::string meant = nearest_word(name, names);
    return in_quotes(name) + " is no material" + (meant.empty() ? "" : " (" + meant + "?)") +
           "; right would be one of " + material_names();
}

}  // namespace touchable
