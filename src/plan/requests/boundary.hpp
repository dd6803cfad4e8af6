// Where a request must end between two variables, and why (docs/specification.md, section 4, rules 1 to 8).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

enum class Pass : std::uint8_t { read, write };

/// The function of a variable in that pass.
[[nodiscard]] const std::optional<wire::Function>& function_in(Pass pass, const model::Variable& variable);

/// Two neighbours in the sorted order of a pass.
struct Neighbours {
    const model::Variable& previous;  ///< the last member so far
    const model::Variable& next;      ///< the candidate
    bool numbers_adjoin = false;      ///< rule 8: the numbers of both follow each other
};

/// Rules 2 to 8: why `next` cannot share a request with `previous`; nothing if it can.
[[nodiscard]] std::optional<Reason> boundary(Pass pass, const Neighbours& neighbours);

/// Rule 1 for one function of one device. In strategy optimal registers_per_request is a limit only if the
/// user set it.
class ItemLimit {
public:
    ItemLimit(const model::Project& project, const model::Line& line, const model::Device& device,
              wire::Function function, model::Strategy strategy = model::Strategy::classic);

    [[nodiscard]] std::size_t items() const { return items_; }

    /// Why a request of `size` items that ends with `next` would be too long.
    [[nodiscard]] Reason reason(std::size_t size, const model::Variable& next) const;

private:
    std::size_t items_ = 0;
    const char* code_ = nullptr;
};

}  // namespace takt::plan
