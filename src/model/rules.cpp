#include "rules.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <tuple>

#include "takt/base/utf8.hpp"

namespace takt::model {
namespace {

struct Entry {
    Rule rule;
    std::string_view code;
    Severity severity = Severity::error;
};

constexpr std::array kRules{
    Entry{Rule::document_empty, "document.empty"},
    Entry{Rule::document_not_a_project, "document.not_a_project"},
    Entry{Rule::key_unknown, "key.unknown"},
    Entry{Rule::key_unlike, "key.unlike"},
    Entry{Rule::key_twice, "key.twice"},
    Entry{Rule::key_no_space, "key.no_space"},
    Entry{Rule::key_elsewhere, "key.elsewhere"},
    Entry{Rule::field_missing, "field.missing"},
    Entry{Rule::field_empty, "field.empty"},
    Entry{Rule::field_not_a_value, "field.not_a_value"},
    Entry{Rule::field_not_a_list, "field.not_a_list"},
    Entry{Rule::field_not_a_mapping, "field.not_a_mapping"},
    Entry{Rule::field_not_a_group, "field.not_a_group"},
    Entry{Rule::field_out_of_range, "field.out_of_range"},
    Entry{Rule::field_unknown_word, "field.unknown_word"},
    Entry{Rule::field_unlike_word, "field.unlike_word"},
    Entry{Rule::field_not_here, "field.not_here"},
    Entry{Rule::field_quoted_number, "field.quoted_number"},
    Entry{Rule::field_length, "field.length"},
    Entry{Rule::field_control_character, "field.control_character"},
    Entry{Rule::field_without_effect, "field.without_effect", Severity::warning},
    Entry{Rule::field_zero_replaced, "field.zero_replaced", Severity::warning},
    Entry{Rule::integer_malformed, "integer.malformed"},
    Entry{Rule::integer_fraction, "integer.fraction"},
    Entry{Rule::integer_leading_zero, "integer.leading_zero"},
    Entry{Rule::number_malformed, "number.malformed"},
    Entry{Rule::number_comma, "number.comma"},
    Entry{Rule::boolean_malformed, "boolean.malformed"},
    Entry{Rule::duration_malformed, "duration.malformed"},
    Entry{Rule::duration_no_unit, "duration.no_unit"},
    Entry{Rule::range_malformed, "range.malformed"},
    Entry{Rule::range_reversed, "range.reversed"},
    Entry{Rule::function_not_allowed, "function.not_allowed"},
    Entry{Rule::project_version, "project.version"},
    Entry{Rule::name_duplicate, "name.duplicate"},
    Entry{Rule::name_none, "name.none"},
    Entry{Rule::name_reserved, "name.reserved"},
    Entry{Rule::service_unknown, "service.unknown"},
    Entry{Rule::service_type, "service.type"},
    Entry{Rule::service_read_only, "service.read_only"},
    Entry{Rule::service_outgrows, "service.outgrows", Severity::warning},
    Entry{Rule::service_circular, "service.circular"},
    Entry{Rule::local_unknown, "local.unknown"},
    Entry{Rule::local_undeclared, "local.undeclared"},
    Entry{Rule::local_type, "local.type"},
    Entry{Rule::local_not_a_trigger, "local.not_a_trigger"},
    Entry{Rule::host_with_port, "host.with_port"},
    Entry{Rule::host_no_address, "host.no_address"},
    Entry{Rule::host_malformed, "host.malformed"},
    Entry{Rule::line_port_number, "line.port_number"},
    Entry{Rule::backoff_limit, "backoff.limit"},
    Entry{Rule::round_trip_usual, "round_trip.usual"},
    Entry{Rule::burst_alone, "burst.alone"},
    Entry{Rule::line_tls, "line.tls"},
    Entry{Rule::line_port_missing, "line.port_missing"},
    Entry{Rule::line_port_twice, "line.port_twice"},
    Entry{Rule::server_listen_twice, "server.listen_twice"},
    Entry{Rule::line_many_devices, "line.many_devices", Severity::warning},
    Entry{Rule::line_unknown, "line.unknown"},
    Entry{Rule::address_reserved, "address.reserved", Severity::warning},
    Entry{Rule::device_timeout_short, "device.timeout_short", Severity::warning},
    Entry{Rule::device_registers_cut, "device.registers_cut", Severity::warning},
    Entry{Rule::address_duplicate, "address.duplicate"},
    Entry{Rule::bank_twice, "bank.twice"},
    Entry{Rule::bank_overlay_bits, "bank.overlay_bits"},
    Entry{Rule::mirror_empty, "mirror.empty", Severity::warning},
    Entry{Rule::mirror_overlap, "mirror.overlap"},
    Entry{Rule::mirror_beyond_end, "mirror.beyond_end"},
    Entry{Rule::bank_missing, "bank.missing"},
    Entry{Rule::bank_retain_outside, "bank.retain_outside"},
    Entry{Rule::bank_read_only_outside, "bank.read_only_outside"},
    Entry{Rule::bank_overlay_outside, "bank.overlay_outside"},
    Entry{Rule::number_twice, "number.twice"},
    Entry{Rule::limits_reversed, "limits.reversed"},
    Entry{Rule::limits_outside, "limits.outside"},
    Entry{Rule::limits_contradictory, "limits.contradictory"},
    Entry{Rule::fifo_too_long, "fifo.too_long"},
    Entry{Rule::peer_malformed, "peer.malformed"},
    Entry{Rule::variable_outside_bank, "variable.outside_bank"},
    Entry{Rule::variable_default_limits, "variable.default_limits", Severity::warning},
    Entry{Rule::variable_bound_twice, "variable.bound_twice", Severity::warning},
    Entry{Rule::variable_overlap, "variable.overlap", Severity::warning},
    Entry{Rule::group_one_of, "group.one_of"},
    Entry{Rule::source_unknown, "source.unknown"},
    Entry{Rule::source_type, "source.type"},
    Entry{Rule::source_not_writable, "source.not_writable"},
    Entry{Rule::template_malformed, "template.malformed"},
    Entry{Rule::template_without, "template.without"},
    Entry{Rule::command_empty, "command.empty"},
    Entry{Rule::answer_form, "answer.form"},
    Entry{Rule::exchange_mixed, "exchange.mixed"},
    Entry{Rule::measurement_beyond, "measurement.beyond"},
    Entry{Rule::instrument_placeholder, "instrument.placeholder"},
    Entry{Rule::instrument_unconfirmed, "instrument.unconfirmed"},
    Entry{Rule::instrument_value_kind, "instrument.value_kind"},
    Entry{Rule::instrument_any_data, "instrument.any_data"},
    Entry{Rule::instrument_range, "instrument.range"},
    Entry{Rule::instrument_expires, "instrument.expires", Severity::warning},
    Entry{Rule::instrument_command_unknown, "instrument.command_unknown"},
    Entry{Rule::byte_order_unknown, "byte_order.unknown"},
    Entry{Rule::byte_order_type, "byte_order.type"},
    Entry{Rule::byte_order_contradiction, "byte_order.contradiction"},
    Entry{Rule::strategy_grouping_off, "strategy.grouping_off", Severity::warning},
    Entry{Rule::profile_too_many_devices, "profile.too_many_devices", Severity::warning},
    Entry{Rule::profile_too_many_variables, "profile.too_many_variables", Severity::warning},
    Entry{Rule::variable_address_missing, "variable.address_missing"},
    Entry{Rule::variable_address_twice, "variable.address_twice"},
    Entry{Rule::variable_area_missing, "variable.area_missing"},
    Entry{Rule::variable_no_traffic, "variable.no_traffic", Severity::warning},
    Entry{Rule::variable_type_area, "variable.type_area"},
    Entry{Rule::variable_function_area, "variable.function_area"},
    Entry{Rule::variable_read_only_area, "variable.read_only_area"},
    Entry{Rule::variable_overlaid_areas, "variable.overlaid_areas", Severity::warning},
    Entry{Rule::variable_single_register, "variable.single_register"},
    Entry{Rule::variable_write_single_only, "variable.write_single_only"},
    Entry{Rule::variable_bit_write, "variable.bit_write", Severity::warning},
    Entry{Rule::variable_bit_assumed, "variable.bit_assumed", Severity::warning},
    Entry{Rule::variable_bit_type, "variable.bit_type"},
    Entry{Rule::variable_coil_area, "variable.coil_area"},
    Entry{Rule::variable_beyond_end, "variable.beyond_end"},
    Entry{Rule::variable_needs_read, "variable.needs_read"},
    Entry{Rule::variable_needs_write, "variable.needs_write"},
    Entry{Rule::variable_length_type, "variable.length_type"},
    Entry{Rule::variable_length_missing, "variable.length_missing"},
    Entry{Rule::variable_scale_zero, "variable.scale_zero"},
    Entry{Rule::variable_scale_type, "variable.scale_type"},
    Entry{Rule::variable_larger_than_request, "variable.larger_than_request", Severity::warning},
    Entry{Rule::variable_read_in_parts, "variable.read_in_parts", Severity::warning},
    Entry{Rule::variable_deadline_without_period, "variable.deadline_without_period"},
    Entry{Rule::reference_malformed, "reference.malformed"},
    Entry{Rule::address_like_reference, "address.like_reference", Severity::warning},
    Entry{Rule::address_is_reference, "address.is_reference"},
    Entry{Rule::default_out_of_range, "default.out_of_range"},
    Entry{Rule::default_too_long, "default.too_long"},
    Entry{Rule::words_malformed, "words.malformed"},
    Entry{Rule::words_twice, "words.twice"},
    Entry{Rule::words_type, "words.type"},
    Entry{Rule::output_name, "output.name"},
    Entry{Rule::output_password, "output.password"},
    Entry{Rule::output_two_passwords, "output.two_passwords"},
    Entry{Rule::output_password_plain, "output.password_plain", Severity::warning},
    Entry{Rule::output_client_id_twice, "output.client_id_twice"},
    Entry{Rule::output_control_topic_twice, "output.control_topic_twice"},
    Entry{Rule::output_many_brokers, "output.many_brokers"},
    Entry{Rule::output_broker_malformed, "output.broker_malformed"},
    Entry{Rule::output_broker_scheme, "output.broker_scheme"},
    Entry{Rule::output_broker_user, "output.broker_user"},
    Entry{Rule::output_broker_twice, "output.broker_twice", Severity::warning},
    Entry{Rule::output_history_twice, "output.history_twice"},
    Entry{Rule::output_pattern_twice, "output.pattern_twice", Severity::warning},
    Entry{Rule::output_never, "output.never"},
    Entry{Rule::output_unknown, "output.unknown"},
    Entry{Rule::output_unused, "output.unused"},
    Entry{Rule::output_unmatched, "output.unmatched", Severity::warning},
    Entry{Rule::output_not_writable, "output.not_writable"},
    Entry{Rule::output_none_writable, "output.none_writable", Severity::warning},
    Entry{Rule::output_select_empty, "output.select_empty", Severity::warning},
    Entry{Rule::output_empty, "output.empty"},
    Entry{Rule::output_retain_partial, "output.retain_partial", Severity::warning},
    Entry{Rule::output_quota_short, "output.quota_short", Severity::warning},
    Entry{Rule::topic_unknown_part, "topic.unknown_part"},
    Entry{Rule::topic_brace, "topic.brace"},
    Entry{Rule::topic_wildcard, "topic.wildcard"},
    Entry{Rule::topic_empty_level, "topic.empty_level"},
    Entry{Rule::topic_variable, "topic.variable"},
    Entry{Rule::topic_shared, "topic.shared"},
    Entry{Rule::topic_reserved, "topic.reserved"},
    Entry{Rule::tag_malformed, "tag.malformed"},
    Entry{Rule::findings_more, "findings.more"},
};

constexpr bool in_order() {
    for (std::size_t i = 0; i < kRules.size(); ++i)
        if (static_cast<std::size_t>(kRules[i].rule) != i) return false;
    return kRules.back().rule == Rule::findings_more;
}
static_assert(in_order(), "kRules has an entry for each rule, in the order of the enum");

constexpr auto kCodes = [] {
    std::array<std::string_view, kRules.size()> codes;
    std::ranges::transform(kRules, codes.begin(), &Entry::code);
    return codes;
}();

const Entry& entry(Rule rule) {
    return kRules[static_cast<std::size_t>(rule)];
}

/// A value as in the file, cut to a printable length.
std::string shown(std::string_view value) {
    constexpr std::size_t kLongest = 200;
    if (value.size() <= kLongest) return std::string(value);
    return std::string(whole_characters(value, kLongest)) + "…";
}

bool earlier(const Finding& a, const Finding& b) {
    return std::tie(a.location.file, a.location.line, a.location.column, b.severity, a.path, a.code) <
           std::tie(b.location.file, b.location.line, b.location.column, a.severity, b.path, b.code);
}

}  // namespace

std::span<const std::string_view> finding_codes() {
    return kCodes;
}

bool Findings::full(Rule rule) const {
    return (entry(rule).severity == Severity::error ? errors_ : warnings_).size() >= kMost;
}

void Findings::add(Rule rule, const SourceLocation& location, const std::string& path, std::string_view value,
                   std::string allowed, Arguments arguments) {
    const auto& [_, code, severity] = entry(rule);
    const bool included = location.file != 0 && location.line != 0 && !full(rule);
    if (included && !included_
                         .emplace(rule, location.file, location.line, location.column,
                                  path.substr(path.rfind('.') + 1), shown(value))
                         .second)
        return;
    ++(severity == Severity::error ? errors_seen_ : warnings_seen_);
    if (full(rule)) return;
    for (auto& [name, text] : arguments) text = shown(text);
    (severity == Severity::error ? errors_ : warnings_)
        .push_back({severity, std::string(code), location, shown(path), shown(value), std::move(allowed),
                    std::move(arguments)});
}

const std::string_view* Findings::known_column(const SourceLocation& head) const {
    const auto found = columns_.find({head.file, head.line, head.column});
    return found == columns_.end() ? nullptr : &found->second;
}

void Findings::remember_column(const SourceLocation& head, std::string_view meant) {
    columns_.try_emplace({head.file, head.line, head.column}, meant);
}

std::vector<Finding> Findings::take() && {
    const std::size_t seen = errors_seen_ + warnings_seen_;
    std::vector<Finding> all = std::move(errors_);
    std::ranges::move(warnings_, std::back_inserter(all));
    const bool cut = seen > kMost;
    if (cut) all.erase(all.begin() + kMost - 1, all.end());
    const auto kept_errors =
        static_cast<std::size_t>(std::ranges::count(all, Severity::error, &Finding::severity));
    std::ranges::sort(all, earlier);
    if (cut) {
        const auto location = all.back().location;
        const auto severity = kept_errors < errors_seen_ ? Severity::error : Severity::warning;
        all.push_back({.severity = severity,
                       .code = std::string(entry(Rule::findings_more).code),
                       .location = location,
                       .arguments = {{"count", std::to_string(seen - all.size())}}});
    }
    return all;
}

}  // namespace takt::model
