// A server of a project at work: its units with their banks, files and queues.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/serve/server.hpp"
#include "unit_functions.hpp"

namespace takt::app {

/// Several owners of hooks on one unit, asked in the order they were added; the first refusal counts.
class UnitHookChain final : public serve::UnitHooks {
public:
    /// @param hooks  outlives the chain
    void add(serve::UnitHooks& hooks) { links_.push_back(&hooks); }

    std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                              const serve::Access& access) override {
        for (serve::UnitHooks* link : links_)
            if (const auto refusal = link->before(context, access)) return refusal;
        return std::nullopt;
    }
    void written(const serve::Context& context, const serve::Access& access) override {
        for (serve::UnitHooks* link : links_) link->written(context, access);
    }

private:
    std::vector<serve::UnitHooks*> links_;
};

/// One unit: storage of exactly the items its banks have, with the default values of its variables in them.
/// Does not move in memory.
class ServedUnit {
public:
    /// @param unit  outlives it
    explicit ServedUnit(const model::ServerUnit& unit);
    ServedUnit(const ServedUnit&) = delete;
    ServedUnit& operator=(const ServedUnit&) = delete;

    /// Refers to this one.
    [[nodiscard]] serve::Unit& unit() { return unit_; }

    /// For who feeds the unit's items or follows what is written.
    void add_hooks(serve::UnitHooks& hooks) { hooks_.add(hooks); }

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
    void add_functions(const model::ServerUnit& unit);
    void put(const model::Variable& variable);

    std::array<Bank, 4> banks_;  // by wire::Area
    UnitFunctions functions_;
    UnitHookChain hooks_;
    serve::Unit unit_;
};

/// All units of a server behind one responder.
class ServedServer final : public serve::Responder {
public:
    /// @param server  outlives it
    explicit ServedServer(const model::Server& server);

    [[nodiscard]] bool serves(UnitId unit) const override { return server_.serves(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes pdu) override {
        return server_.handle(context, pdu);
    }
    void heard(serve::LineEvent event) override { server_.heard(event); }

    /// In the order of the project; what answers for it: units()[i].
    [[nodiscard]] ServedUnit& served(std::size_t index) { return *units_[index]; }
    [[nodiscard]] std::span<serve::Unit> units() { return in_server_; }

private:
    std::vector<std::unique_ptr<ServedUnit>> units_;
    std::vector<serve::Unit> in_server_;
    serve::Server server_{{}};
};

}  // namespace takt::app
