// The functions of a unit beyond its banks: diagnostics, identification, files and queues.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "takt/base/numbers.hpp"
#include "takt/serve/diagnostics.hpp"
#include "takt/serve/fifos.hpp"
#include "takt/serve/files.hpp"
#include "takt/serve/identification.hpp"

namespace takt::endpoint {

/// These functions with the storage they refer to. Does not move in memory.
class UnitFunctions {
public:
    explicit UnitFunctions(const serve::DiagnosticsOptions& options) : diagnostics_(options, &log_) {}
    UnitFunctions(const UnitFunctions&) = delete;
    UnitFunctions& operator=(const UnitFunctions&) = delete;

    /// Before extensions().
    /// @param text  outlives it
    void add_object(std::uint8_t id, std::string_view text) { objects_.push_back({id, text}); }

    /// Function 17. Its answer is the unit's number as the id, the run indicator and the text, as most
    /// masters read it. Before extensions().
    /// @param text  outlives it; empty: function 17 is exception 1
    void set_server_id(UnitId unit, std::string_view text) {
        server_id_ = {unit.value};
        server_text_ = text;
    }

    /// Before extensions(). @returns the file's records, all 0; they stay where they are
    std::span<std::uint16_t> add_file(std::uint16_t number, std::size_t records, bool read_only = false);

    /// Before extensions(). @param values  outlive it
    void add_fifo(std::uint16_t address, std::span<const std::uint16_t> values) {
        fifo_list_.push_back({address, values});
    }

    /// For serve::Unit; valid as long as this object. Called once.
    [[nodiscard]] std::span<serve::Extension* const> extensions();

private:
    serve::EventLog log_;
    serve::Diagnostics diagnostics_;
    std::array<std::uint8_t, 1> server_id_{};
    std::string_view server_text_;
    std::vector<serve::IdentificationObject> objects_;
    std::optional<serve::Identification> identification_;
    std::deque<std::vector<std::uint16_t>> records_;
    std::vector<serve::File> file_list_;
    std::optional<serve::Files> files_;
    std::vector<serve::Fifo> fifo_list_;
    std::optional<serve::Fifos> fifos_;
    std::vector<serve::Extension*> extensions_;
};

}  // namespace takt::endpoint
