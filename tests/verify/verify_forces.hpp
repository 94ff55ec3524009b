#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace touchable::verify {

/// The program without its main: checks a forces file against exported frames, prints what was covered and
/// what is wrong. Exit code: 0 nothing is wrong, 2 bad usage, 3 unreadable input, 6 a row is wrong or too few
/// are in contact.
int verify_forces(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace touchable::verify
