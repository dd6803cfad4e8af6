// The request table of a controller of the profile owen-kc1 (docs/specification.md, section 6): exactly its
// entries.
#pragma once

#include <cstdint>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/table/build.hpp"
#include "takt/table/owen_view.hpp"

namespace takt::table {

struct OwenTable {
    std::uint16_t version = kOwenVersion;
    std::uint16_t places = 0;  ///< in the value buffer
    std::vector<OwenMaster> masters;
    std::vector<OwenDevice> devices;
    std::vector<OwenEntry> entries;

    friend bool operator==(const OwenTable&, const OwenTable&) = default;
};

/// The table of a project, and everything that it cannot hold: each an error with the name of the
/// variable (of the first one of a request) and its location in the project; codes `table.…`. With errors the
/// table is of no use. Variables that no entry writes are a warning for each device.
struct OwenBuilt {
    OwenTable table;
    std::vector<model::Finding> findings;
};
[[nodiscard]] OwenBuilt build_owen(const model::Project& project, const plan::Plan& plan);

[[nodiscard]] Image write_owen(const OwenTable& table);

/// @returns what OwenView::open() returns
[[nodiscard]] Result<OwenTable> read_owen(Bytes image);

/// The codes of OwenBuilt::findings.
[[nodiscard]] std::span<const std::string_view> owen_codes();

}  // namespace takt::table
