// The own units of a project's server, with their banks, files and queues.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/serve/server.hpp"
#include "takt/sim/fill.hpp"
#include "unit_functions.hpp"

namespace takt::endpoint {

/// One unit: storage of exactly the items its banks have, with the default values of its variables in them.
/// Does not move in memory.
class StoredUnit {
public:
    /// @param unit  outlives it
    /// @param fill  of the items and files without a default
    StoredUnit(const model::ServerUnit& unit, sim::Fill fill);
    StoredUnit(const StoredUnit&) = delete;
    StoredUnit& operator=(const StoredUnit&) = delete;

    /// For a serve::Server; refers to this one.
    [[nodiscard]] const serve::Unit& unit() const { return unit_; }

private:
    struct Bank {
        std::vector<serve::AddressRange> offered;
        std::vector<serve::AddressRange> read_only;
        std::vector<serve::ValueLimits> limits;
        std::vector<std::uint16_t> registers;
        std::vector<std::uint8_t> bits;
        std::uint32_t count = 0;
    };

    void lay_out(const model::ServerUnit& unit);
    void fill(sim::Content& content);
    void add_functions(const model::ServerUnit& unit, sim::Content& content);
    void put(const model::Variable& variable);

    std::array<Bank, 4> banks_;  // by wire::Area
    UnitFunctions functions_;
    serve::Unit unit_;
};

/// All units of a server behind one responder.
class StoredUnits final : public serve::Responder {
public:
    /// @param units  outlive it
    explicit StoredUnits(std::span<const model::ServerUnit> units, sim::Fill fill = sim::Fill::zero);
    StoredUnits(const StoredUnits&) = delete;
    StoredUnits& operator=(const StoredUnits&) = delete;

    [[nodiscard]] bool serves(UnitId unit) const override { return server_.serves(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context,
                                       const wire::RequestView& request) override {
        return server_.handle(context, request);
    }
    void on_line_event(serve::LineEvent event) override { server_.on_line_event(event); }

    /// In the order of the project.
    [[nodiscard]] std::span<serve::Unit> units() { return units_; }

private:
    std::vector<std::unique_ptr<StoredUnit>> stored_;
    std::vector<serve::Unit> units_;
    serve::Server server_{{}};
};

}  // namespace takt::endpoint
