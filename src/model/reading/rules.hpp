// The rules of a project: one table of codes and severities, and the list of findings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "takt/model/findings.hpp"

namespace takt::model {

/// A comment {name} lists the message's arguments besides value and allowed.
enum class Rule : std::uint8_t {
    document_empty,
    document_not_a_project,
    key_unknown,  // {nearest}
    key_unlike,
    key_twice,      // {key}
    key_no_space,   // {key}, {rest}
    key_elsewhere,  // {location}
    field_missing,  // {key}
    field_empty,    // {key}
    field_not_a_value,
    field_not_a_list,
    field_not_a_mapping,
    field_not_a_group,  // {key}
    field_out_of_range,
    field_unknown_word,  // {nearest}
    field_unlike_word,
    field_not_here,  // {condition}
    field_quoted_number,
    field_length,  // {length}
    field_control_character,
    field_without_effect,     // {key}, {condition}
    field_no_effect_default,  // {key}, {condition}
    field_needs,              // {key}, {condition}
    field_zero_replaced,      // {used}
    integer_malformed,
    integer_fraction,
    integer_leading_zero,
    number_malformed,
    number_comma,      // {meant}
    number_thousands,  // {meant}
    boolean_malformed,
    duration_malformed,
    duration_no_unit,
    range_malformed,
    range_reversed,
    function_not_allowed,
    project_version,
    name_duplicate,  // {first}
    name_none,       // {kind}
    name_reserved,
    service_unknown,  // {nearest}
    service_type,     // {type}
    service_read_only,
    service_outgrows,  // {type}
    service_circular,  // {device}
    local_unknown,     // {nearest}
    local_undeclared,
    local_type,           // {type}
    local_not_a_trigger,  // {key}, {type}
    host_with_port,       // {host}, {port}
    host_no_address,
    host_malformed,
    line_port_number,    // {port}
    line_port_settings,  // {keys}, {device}
    backoff_limit,       // {first}
    round_trip_usual,    // {longest}
    burst_alone,
    line_tls,
    line_port_missing,    // {key}
    line_port_twice,      // {first}
    server_listen_twice,  // {first}
    line_many_devices,    // {count}
    line_host_shared,     // {first}
    lines_none,
    line_unknown,          // {nearest}
    address_reserved,      // {limit}
    device_timeout_short,  // {turnaround}
    device_registers_cut,  // {limit}, {written}
    device_overlap,        // {first}, {second}
    address_duplicate,     // {first}
    bank_twice,            // {area}
    bank_overlay_bits,
    mirror_empty,
    mirror_overlap,          // {area}, {first}, {last}, {own_first}, {own_last}, {owner}
    mirror_beyond_end,       // {items}
    bank_missing,            // {area}
    bank_retain_outside,     // {area}, {first}, {last}
    bank_read_only_outside,  // {area}, {first}, {last}
    bank_overlay_outside,    // {area}, {first}, {last}
    number_twice,            // {key}
    limits_reversed,         // {least}
    limits_outside,          // {first}, {last}
    limits_contradictory,    // {register}, {first}
    fifo_too_long,           // {count}
    peer_malformed,
    variable_outside_bank,  // {area}
    variable_default_limits,
    variable_bound_twice,  // {other}
    variable_overlap,      // {other}
    group_one_of,          // {keys}
    source_unknown,        // {kind}, {nearest}
    source_type,           // {type}
    source_not_writable,   // {name}
    template_malformed,    // {position}
    template_without,      // {name}
    command_empty,
    answer_form,  // {key}
    exchange_mixed,
    measurement_beyond,  // {length}
    instrument_placeholder,
    instrument_unconfirmed,
    instrument_value_kind,
    instrument_any_data,
    instrument_range,    // {least}
    instrument_expires,  // {needed}
    instrument_command_unknown,
    byte_order_unknown,
    byte_order_type,           // {type}
    byte_order_contradiction,  // {key}, {order}
    strategy_grouping_off,
    profile_too_many_devices,    // {limit}
    profile_too_many_variables,  // {limit}, {count}
    variable_address_missing,
    variable_address_twice,  // {other}
    variable_area_missing,
    variable_no_traffic,
    variable_type_area,          // {type}
    variable_function_area,      // {area}
    variable_read_only_area,     // {area}
    variable_overlaid_areas,     // {area}, {written}
    variable_single_register,    // {registers}
    variable_write_single_only,  // {registers}
    variable_bit_write,
    variable_not_offered,       // {area}
    variable_area_not_offered,  // {area}
    variable_bit_assumed,
    variable_coil_assumed,            // {number}, {coil}
    variable_discrete_input_assumed,  // {number}, {coil}
    variable_bit_type,                // {type}
    variable_coil_area,               // {area}
    variable_beyond_end,              // {items}
    variable_needs_read,              // {key}
    variable_needs_write,             // {key}
    variable_length_type,             // {type}
    variable_length_missing,
    variable_scale_zero,
    variable_scale_type,  // {key}, {type}
    variable_write_range_malformed,
    variable_larger_than_request,  // {registers}, {limit}
    variable_read_in_parts,        // {registers}, {limit}
    variable_deadline_without_period,
    reference_malformed,
    address_like_reference,  // {area}, {number}, {wire}, {count}
    address_is_reference,    // {area}, {number}
    default_out_of_range,    // {type}
    default_too_long,        // {length}
    words_malformed,         // {key}
    words_twice,             // {key}
    words_type,              // {key}, {type}
    output_name,
    output_password,  // {key}
    output_two_passwords,
    output_password_plain,       // {broker}
    output_client_id_twice,      // {first}
    output_control_topic_twice,  // {first}
    output_many_brokers,         // {count}
    output_broker_malformed,     // {meant}
    output_broker_scheme,        // {meant}
    output_broker_user,          // {meant}
    output_broker_twice,         // {meant}
    output_history_twice,        // {first}
    output_pattern_twice,
    output_never,
    output_unknown,  // {kind}, {nearest}
    output_unused,
    output_unmatched,  // {kind}
    output_not_writable,
    output_none_writable,
    output_select_empty,
    output_empty,
    output_retain_partial,  // {message}
    output_quota_short,     // {output}, {time}, {rate}, {needed}
    output_falls_behind,    // {output}, {rate}, {limit}, {window}, {round_trip}, {needed}
    topic_unknown_part,     // {part}, {nearest}
    topic_brace,
    topic_wildcard,
    topic_empty_level,
    topic_variable,  // {message}
    topic_shared,    // {topic}, {first}, {second}
    topic_reserved,  // {topic}, {control}, {levels}
    tag_malformed,
    findings_more,  // {count}
};

/// Further placeholders of a message: name, text.
using Arguments = std::vector<std::pair<std::string, std::string>>;

/// Collects findings up to a limit. Warnings never displace errors.
class Findings {
public:
    static constexpr std::size_t kMost = 1000;

    void add(Rule rule, const SourceLocation& location, const std::string& path, std::string_view value,
             std::string allowed = {}, Arguments arguments = {});

    /// Whether further findings of that rule are only counted, so that expensive arguments need not be
    /// computed.
    [[nodiscard]] bool full(Rule rule) const;
    [[nodiscard]] bool any_error() const { return errors_seen_ > 0; }

    /// An unknown column of a table is reported once, not per row.
    /// @returns the likely key, possibly empty; nullptr: the column was not reported yet
    [[nodiscard]] const std::string_view* known_column(const SourceLocation& head) const;
    void remember_column(const SourceLocation& head, std::string_view meant);

    /// All findings ordered by location; the last one reports how many more there are.
    [[nodiscard]] std::vector<Finding> take() &&;

private:
    std::vector<Finding> errors_;
    std::vector<Finding> warnings_;
    std::size_t errors_seen_ = 0;
    std::size_t warnings_seen_ = 0;
    std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, std::string_view> columns_;
    /// Findings in templates and tables: rule, location, key, value. Several devices may have one template.
    std::set<std::tuple<Rule, std::uint32_t, std::uint32_t, std::uint32_t, std::string, std::string>>
        included_;
};

}  // namespace takt::model
