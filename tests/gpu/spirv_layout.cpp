// SPDX-License-Identifier: Apache-2.0
#include "tests/gpu/spirv_layout.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

namespace touchable {
namespace {

// The words of the SPIR-V specification this needs.
constexpr std::uint32_t magic = 0x07230203;
enum Op : std::uint32_t {
    op_entry_point = 15,
    op_execution_mode = 16,
    op_type_bool = 20,
    op_type_int = 21,
    op_type_float = 22,
    op_type_vector = 23,
    op_type_matrix = 24,
    op_type_image = 25,
    op_type_sampled_image = 27,
    op_type_array = 28,
    op_type_struct = 30,
    op_type_pointer = 32,
    op_constant = 43,
    op_constant_composite = 44,
    op_spec_constant_true = 48,
    op_spec_constant_false = 49,
    op_spec_constant = 50,
    op_spec_constant_composite = 51,
    op_function = 54,
    op_variable = 59,
    op_decorate = 71,
    op_member_decorate = 72,
    op_execution_mode_id = 331,
};
enum Decoration : std::uint32_t {
    spec_id = 1,
    array_stride = 6,
    matrix_stride = 7,
    built_in = 11,
    binding = 33,
    descriptor_set = 34,
    offset = 35,
};
enum Storage : std::uint32_t { uniform_constant = 0, uniform = 2, push_constant = 9, storage_buffer = 12 };
constexpr std::uint32_t mode_local_size = 17, mode_local_size_id = 38, built_in_workgroup_size = 25;
constexpr std::uint32_t execution_model_compute = 5, image_dim_buffer = 5;

using Words = std::span<const std::uint32_t>;  // of one instruction, without its first

/// Bytes a type takes, and the alignment C++ gives it.
struct Extent {
    std::uint32_t bytes = 0, alignment = 1;
};

class Reader {
public:
    explicit Reader(Words constants) : given_(constants) {}

    Result<SpirvLayout> read(Words module) {
        if (module.size() < 5 || module[0] != magic) return fault("these words are no SPIR-V");
        for (std::size_t at = 5; at < module.size();) {
            const std::uint32_t op = module[at] & 0xFFFFU, length = module[at] >> 16U;
            if (length == 0 || length > module.size() - at) return fault("the SPIR-V is cut off");
            if (op == op_function) break;  // what follows computes
            if (!take(op, module.subspan(at + 1, length - 1)))
                return fault("an instruction of the SPIR-V is too short");
            at += length;
        }
        return finish();
    }

private:
    static Error fault(std::string message) { return {ErrorKind::internal, std::move(message)}; }

    struct Type {
        std::uint32_t op = 0;
        std::vector<std::uint32_t> words;  // behind the id
    };
    struct Variable {
        std::uint32_t id, type, storage;
    };

    bool take(std::uint32_t op, Words w) {
        switch (op) {
            case op_entry_point:
                if (w.size() < 2) return false;
                computes_ = computes_ || w[0] == execution_model_compute;
                return true;
            case op_execution_mode:
            case op_execution_mode_id:
                return take_mode(op, w);
            case op_decorate:
                if (w.size() < 2) return false;
                decorations_[w[0]][w[1]] = w.size() > 2 ? w[2] : 0;
                return true;
            case op_member_decorate:
                if (w.size() < 3) return false;
                members_[w[0]][w[1]][w[2]] = w.size() > 3 ? w[3] : 0;
                return true;
            case op_variable:
                if (w.size() < 3) return false;
                variables_.push_back({w[1], w[0], w[2]});
                return true;
            case op_constant:
            case op_spec_constant:
            case op_spec_constant_true:
            case op_spec_constant_false:
            case op_constant_composite:
            case op_spec_constant_composite:
                return take_constant(op, w);
            case op_type_bool:
            case op_type_int:
            case op_type_float:
            case op_type_vector:
            case op_type_matrix:
            case op_type_image:
            case op_type_sampled_image:
            case op_type_array:
            case op_type_struct:
            case op_type_pointer:
                return take_type(op, w);
            default:
                return true;
        }
    }

    bool take_mode(std::uint32_t op, Words w) {
        if (w.size() < 2) return false;
        const bool direct = op == op_execution_mode && w[1] == mode_local_size;
        const bool by_id = op == op_execution_mode_id && w[1] == mode_local_size_id;
        if (!direct && !by_id) return true;
        if (w.size() < 5) return false;
        size_is_ids_ = by_id;
        std::copy_n(w.begin() + 2, 3, size_.begin());
        return true;
    }

    bool take_constant(std::uint32_t op, Words w) {
        if (w.size() < 2) return false;
        if (op == op_constant_composite || op == op_spec_constant_composite) {
            composites_[w[1]].assign(w.begin() + 2, w.end());
            return true;
        }
        if (op == op_constant || op == op_spec_constant) {
            if (w.size() < 3) return false;
            values_[w[1]] = w[2];
        } else {
            values_[w[1]] = op == op_spec_constant_true;
        }
        return true;
    }

    bool take_type(std::uint32_t op, Words w) {
        static constexpr struct {
            std::uint32_t op;
            std::size_t words;
        } least[] = {{op_type_bool, 1},          {op_type_int, 3},    {op_type_float, 2},
                     {op_type_vector, 3},        {op_type_matrix, 3}, {op_type_image, 8},
                     {op_type_sampled_image, 2}, {op_type_array, 3},  {op_type_struct, 1},
                     {op_type_pointer, 3}};
        for (const auto& entry : least)
            if (entry.op == op && w.size() < entry.words) return false;
        types_[w[0]] = {op, {w.begin() + 1, w.end()}};
        return true;
    }

    std::optional<std::uint32_t> decoration(std::uint32_t id, std::uint32_t what) const {
        const auto found = decorations_.find(id);
        if (found == decorations_.end()) return {};
        const auto value = found->second.find(what);
        return value == found->second.end() ? std::nullopt : std::optional(value->second);
    }

    std::uint32_t must(std::uint32_t id) const {
        const auto number = decoration(id, spec_id);
        if (number && *number < given_.size()) return given_[*number];
        const auto value = values_.find(id);
        return value == values_.end() ? 0 : value->second;
    }

    const Type* type_of(std::uint32_t id) const {
        const auto found = types_.find(id);
        return found == types_.end() ? nullptr : &found->second;
    }

    Result<SpirvLayout> finish() const {
        if (!computes_) return fault("the SPIR-V has no compute kernel");
        SpirvLayout layout;
        for (std::size_t i = 0; i < 3; ++i) layout.group_size[i] = size_is_ids_ ? must(size_[i]) : size_[i];
        for (const auto& [id, parts] : composites_)  // older: a built-in instead of a mode
            if (decoration(id, built_in) == built_in_workgroup_size && parts.size() == 3)
                for (std::size_t i = 0; i < 3; ++i) layout.group_size[i] = must(parts[i]);
        for (const auto& [id, value] : values_)
            if (const auto number = decoration(id, spec_id)) layout.constants[*number] = value;
        for (const Variable& variable : variables_) {
            const Type* pointer = type_of(variable.type);
            if (!pointer || pointer->op != op_type_pointer)
                return fault("the SPIR-V has a variable of no type");
            const std::uint32_t pointee = pointer->words[1];
            if (variable.storage == push_constant) {
                const auto extent = extent_of(pointee, 0, 0);
                if (!extent) return fault("the push constants hold a type this reader does not measure");
                layout.push_bytes =
                    (extent->bytes + extent->alignment - 1) / extent->alignment * extent->alignment;
            } else if (const auto number = decoration(variable.id, binding)) {
                if (decoration(variable.id, descriptor_set).value_or(0) != 0) layout.other_sets = true;
                layout.bindings[*number] = kind_of(variable.storage, pointee);
            }
        }
        return layout;
    }

    std::optional<GpuBindingKind> kind_of(std::uint32_t storage, std::uint32_t type_id) const {
        const Type* type = type_of(type_id);
        if (storage == storage_buffer) return GpuBindingKind::storage_buffer;
        if (type && type->op == op_type_sampled_image) type = type_of(type->words[0]);
        if (storage != uniform_constant || !type || type->op != op_type_image) return {};
        // Of an image: sampled type, dimension, depth, arrayed, multisampled, sampled (2: storage), format.
        if (type->words[1] != image_dim_buffer || type->words[5] == 2) return {};
        return GpuBindingKind::uniform_texels;
    }

    /// `stride` is a matrix's; a depth keeps a broken module from going round for ever.
    std::optional<Extent> extent_of(std::uint32_t id, std::uint32_t stride, int depth) const {
        const Type* type = type_of(id);
        if (!type || depth > 16) return {};
        switch (type->op) {
            case op_type_int:
            case op_type_float:
                return Extent{type->words[0] / 8, std::max(type->words[0] / 8, 1U)};
            case op_type_vector: {
                const auto scalar = extent_of(type->words[0], 0, depth + 1);
                if (!scalar) return {};
                return Extent{scalar->bytes * type->words[1], scalar->alignment};
            }
            case op_type_matrix: {
                const auto column = extent_of(type->words[0], 0, depth + 1);
                if (!column || stride == 0 || type->words[1] == 0) return {};
                return Extent{stride * (type->words[1] - 1) + column->bytes, column->alignment};
            }
            case op_type_array: {
                const auto element = extent_of(type->words[0], stride, depth + 1);
                const std::uint32_t step = decoration(id, array_stride).value_or(0),
                                    count = must(type->words[1]);
                if (!element || count == 0) return {};
                return Extent{step * (count - 1) + element->bytes, element->alignment};
            }
            case op_type_struct:
                return extent_of_struct(id, *type, depth);
            default:
                return {};
        }
    }

    std::optional<Extent> extent_of_struct(std::uint32_t id, const Type& type, int depth) const {
        const auto decorated = members_.find(id);
        if (decorated == members_.end()) return {};
        Extent whole;
        for (std::uint32_t i = 0; i < type.words.size(); ++i) {
            const auto member = decorated->second.find(i);
            if (member == decorated->second.end()) return {};
            const auto at = member->second.find(offset);
            const auto stride = member->second.find(matrix_stride);
            const auto extent =
                extent_of(type.words[i], stride == member->second.end() ? 0 : stride->second, depth + 1);
            if (at == member->second.end() || !extent) return {};
            whole.bytes = std::max(whole.bytes, at->second + extent->bytes);
            whole.alignment = std::max(whole.alignment, extent->alignment);
        }
        return whole;
    }

    using Decorations = std::map<std::uint32_t, std::uint32_t>;

    Words given_;
    bool computes_ = false, size_is_ids_ = false;
    std::array<std::uint32_t, 3> size_{};
    std::map<std::uint32_t, Decorations> decorations_;
    std::map<std::uint32_t, std::map<std::uint32_t, Decorations>> members_;
    std::map<std::uint32_t, std::uint32_t> values_;
    std::map<std::uint32_t, std::vector<std::uint32_t>> composites_;
    std::map<std::uint32_t, Type> types_;
    std::vector<Variable> variables_;
};

std::string_view kind_name(std::optional<GpuBindingKind> kind) {
    if (!kind) return "of a kind this engine does not bind";
    return *kind == GpuBindingKind::storage_buffer ? "a storage buffer" : "uniform texels";
}

std::string text(const std::array<std::uint32_t, 3>& size) {
    return std::to_string(size[0]) + "x" + std::to_string(size[1]) + "x" + std::to_string(size[2]);
}

std::string difference_of_bindings(const SpirvLayout& kernel, const GpuLayout& believed) {
    for (const auto& [number, kind] : kernel.bindings) {
        const std::string what = "binding " + std::to_string(number) + " is " + std::string(kind_name(kind));
        if (number >= believed.bindings.size()) return what + ", and C++ has no such binding";
        if (kind != believed.bindings[number])
            return what + ", and C++ binds " + std::string(kind_name(believed.bindings[number]));
    }
    for (std::uint32_t i = 0; i < believed.bindings.size(); ++i)
        if (!kernel.bindings.contains(i))
            return "C++ has a binding " + std::to_string(i) + " that the kernel has not";
    return {};
}

}  // namespace

Result<SpirvLayout> read_spirv(std::span<const std::uint32_t> words,
                               std::span<const std::uint32_t> constants) {
    return Reader(constants).read(words);
}

std::string difference(const SpirvLayout& kernel, const GpuLayout& believed, std::size_t constants) {
    if (kernel.group_size != believed.group_size)
        return "its workgroup is " + text(kernel.group_size) + ", and C++ believes " +
               text(believed.group_size);
    if (kernel.push_bytes != believed.push_bytes)
        return "its push constants are " + std::to_string(kernel.push_bytes) + " bytes, and C++ has " +
               std::to_string(believed.push_bytes);
    if (kernel.other_sets) return "it has a descriptor set other than 0";
    for (std::uint32_t i = 0; i < constants; ++i)
        if (!kernel.constants.contains(i)) return "it has no specialisation constant " + std::to_string(i);
    return difference_of_bindings(kernel, believed);
}

std::string layout_fault(std::span<const std::uint32_t> spirv, const GpuLayout& layout,
                         std::span<const std::uint32_t> constants) {
    const auto kernel = read_spirv(spirv, constants);
    return kernel ? difference(*kernel, layout, constants.size()) : kernel.error().message;
}

}  // namespace touchable
