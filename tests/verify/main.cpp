// SPDX-License-Identifier: Apache-2.0
#include <exception>
#include <iostream>

#include "tests/verify/verify_forces.hpp"

int main(int count, char** arguments) {
    try {
        return touchable::verify::verify_forces({arguments + (count > 0 ? 1 : 0), arguments + count},
                                                std::cout, std::cerr);
    } catch (const std::exception& fault) {
        std::cerr << "verify_forces: " << fault.what() << '\n';
        return 1;
    }
}
