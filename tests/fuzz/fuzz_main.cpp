// SPDX-License-Identifier: Apache-2.0
// The targets as one program of libFuzzer's. `./run fuzz` calls it:
//   touchable-fuzz --list                  names of all targets, each with its most bytes and mebibytes
//   touchable-fuzz --cuts=NAME             every seed of a target, cut at every length
//   touchable-fuzz --target=NAME [...]     fuzzes it, with libFuzzer's options and folders
#include <sanitizer/common_interface_defs.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <optional>

#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

const Target* chosen = nullptr;
std::string_view in_hand;  // of --cuts: what is being parsed

bool parse(std::string_view bytes) {
    try {
        return parse_in_memory(*chosen, bytes);
    } catch (const Fault& fault) {
        std::cerr << "fault: " << fault.what << '\n';
        std::abort();
    }
}

/// libFuzzer writes the input that ends it into a file; without libFuzzer this does.
void keep_in_hand() {
    const std::string file = std::string("cut-of-") + chosen->name;
    std::ofstream(file, std::ios::binary).write(in_hand.data(), static_cast<std::streamsize>(in_hand.size()));
    std::cerr << "the bytes are in " << file << '\n';
}

[[noreturn]] void cut_seeds() {
    __sanitizer_set_death_callback(keep_in_hand);
    std::int64_t cuts = 0;
    for (const Seed& seed : seeds_of(*chosen)) {
        in_hand = seed.bytes;
        const bool is_taken_whole = parse(in_hand);
        for (std::size_t length = 0; length < seed.bytes.size(); ++length, ++cuts) {
            const std::string cut = seed.bytes.substr(0, length);  // ends where its memory does
            in_hand = cut;
            if (!parse(in_hand) || !is_taken_whole || !chosen->refuses_cut(length, seed.bytes.size()))
                continue;
            std::cerr << "fault: " << seed.name << " is taken when it is cut to " << length << " bytes\n";
            std::abort();
        }
    }
    std::cout << cuts << '\n';
    std::exit(0);
}

void list() {
    for (const Target& target : all_targets())
        std::cout << target.name << ' ' << target.most_bytes << ' ' << target.most_mebibytes << '\n';
    std::exit(0);
}

void choose(std::string_view name) {
    for (const Target& target : all_targets())
        if (name == target.name) chosen = &target;
    if (chosen) return;
    std::cerr << "touchable-fuzz: there is no target '" << name << "'; --list names them\n";
    std::exit(2);
}

/// The part of an argument behind `option`; nothing where it is another one.
std::optional<std::string_view> after(std::string_view argument, std::string_view option) {
    if (!argument.starts_with(option)) return std::nullopt;
    return argument.substr(option.size());
}

}  // namespace
}  // namespace touchable::fuzz

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
    using namespace touchable::fuzz;
    for (int k = 1; k < *count; ++k) {
        const std::string_view argument = (*arguments)[k];
        if (argument == "--list") list();
        if (const auto name = after(argument, "--target=")) choose(*name);
        if (const auto name = after(argument, "--cuts=")) {
            choose(*name);
            cut_seeds();
        }
    }
    if (!chosen) choose("");
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    (void)touchable::fuzz::parse({reinterpret_cast<const char*>(bytes), size});
    return 0;
}
