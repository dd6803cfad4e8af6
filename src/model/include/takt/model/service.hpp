// Service variables: read-only values that the program itself provides. Their table, and their names in a
// project (docs/service-variables.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/model/project.hpp"

namespace takt::model {

/// Names with this beginning are reserved for service variables.
inline constexpr std::string_view kServicePrefix = "system.";

enum class ServiceScope : std::uint8_t { program, line, device };

enum class ServiceValue : std::uint8_t {
    time,
    uptime,
    first_cycle,
    pulse_1s,
    pulse_1min,
    line_up,
    line_load,
    line_cycle,
    line_requests,
    line_errors,
    device_state,
    device_answering,
    device_response_time,
    device_requests,
    device_errors,
    device_timeouts,
    device_checksum_errors,
    device_exceptions,
    device_outages,
};

/// How often a value is computed.
enum class ServiceRate : std::uint8_t { fast, each_second };

/// A row of the table of service variables.
struct ServiceField {
    ServiceValue value;
    ServiceScope scope;
    std::string_view word;  ///< the last part of its name; unique in its scope
    DataType type;
    std::string_view unit;
    ServiceRate rate = ServiceRate::each_second;
    Duration min_interval{};  ///< of a trigger: its rate limit
    Duration period{};        ///< of a pulse; zero: it is none
};

/// The whole table, by ServiceValue.
std::span<const ServiceField> service_fields();

/// A service variable of a project.
struct ServiceVariable {
    const ServiceField* field = nullptr;  ///< in service_fields()
    std::size_t line = 0;                 ///< index in the project, by scope
    std::size_t device = 0;               ///< index in the line, by scope
};

/// Whether a name that nothing has is meant as that of a service variable: `sytem.uptime`.
bool resembles_service_name(std::string_view name);

/// Whether the values of a service variable grow beyond a type: a counter in a register of 16 bits.
bool outgrows(const ServiceField& field, DataType type, bool scaled);

/// Whether the name is reserved for service variables.
constexpr bool is_service_name(std::string_view name) {
    return name.starts_with(kServicePrefix);
}

/// The row of the table that a name selects by its form: `system.WORD`, `system.line.NAME.WORD` or
/// `system.device.NAME.WORD`. The line or device need not exist.
const ServiceField* find_service_field(std::string_view name);

/// Help for a name that is no service variable.
struct ServiceHint {
    std::string nearest;  ///< an existing service variable
    std::string allowed;  ///< the names that exist, or their forms
};

/// Finds the service variables of a project by their names. The project must outlive it, unchanged.
///
/// A device has the name that it has in the project. If several devices have this name, the name of the line
/// goes before it: LINE/DEVICE; if these are on one line, its address stands for its name: LINE/ADDRESS. Each
/// device may be named in these ways.
class ServiceNames {
public:
    explicit ServiceNames(const Project& project);

    [[nodiscard]] std::optional<ServiceVariable> find(std::string_view name) const;
    [[nodiscard]] ServiceHint hint(std::string_view name) const;
    /// The shortest name of a variable of this project.
    [[nodiscard]] std::string name(const ServiceVariable& variable) const;

private:
    struct Position {
        std::size_t line = 0;
        std::size_t device = 0;
    };
    [[nodiscard]] std::optional<Position> device(std::string_view name) const;
    [[nodiscard]] std::span<const Position> on_line(std::size_t line, std::string_view name) const;
    [[nodiscard]] std::optional<Position> qualified_device(std::string_view name) const;
    [[nodiscard]] std::string shortest_name(const Position& position) const;
    [[nodiscard]] std::vector<std::string> subjects(ServiceScope scope) const;

    const Project& project_;
    std::unordered_map<std::string_view, std::size_t> lines_;
    std::unordered_map<std::string_view, std::vector<Position>> devices_;  // in the order of the project
    std::unordered_map<std::uint64_t, std::size_t> addresses_;             // by line and address
};

/// The first service variable that a trigger or an enable of a line uses; nullptr: none.
const Local* service_of_lines(const Project& project);

/// The service variable as a local of the project: its name and type, and its rate limit as a trigger.
Local service_local(std::string name, const ServiceField& field);

}  // namespace takt::model
