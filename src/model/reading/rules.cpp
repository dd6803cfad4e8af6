#include "reading/rules.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <tuple>

#include "takt/base/utf8.hpp"

namespace takt::model {
namespace {

struct RuleInfo {
    Rule rule;
    std::string_view code;
    Severity severity = Severity::error;
};

constexpr std::array kRules{
    RuleInfo{Rule::document_empty, "document.empty"},
    RuleInfo{Rule::document_not_a_project, "document.not_a_project"},
    RuleInfo{Rule::key_unknown, "key.unknown"},
    RuleInfo{Rule::key_unlike, "key.unlike"},
    RuleInfo{Rule::key_twice, "key.twice"},
    RuleInfo{Rule::key_no_space, "key.no_space"},
    RuleInfo{Rule::key_elsewhere, "key.elsewhere"},
    RuleInfo{Rule::field_missing, "field.missing"},
    RuleInfo{Rule::field_empty, "field.empty"},
    RuleInfo{Rule::field_not_a_value, "field.not_a_value"},
    RuleInfo{Rule::field_not_a_list, "field.not_a_list"},
    RuleInfo{Rule::field_not_a_mapping, "field.not_a_mapping"},
    RuleInfo{Rule::field_not_a_group, "field.not_a_group"},
    RuleInfo{Rule::field_out_of_range, "field.out_of_range"},
    RuleInfo{Rule::field_unknown_word, "field.unknown_word"},
    RuleInfo{Rule::field_unlike_word, "field.unlike_word"},
    RuleInfo{Rule::field_not_here, "field.not_here"},
    RuleInfo{Rule::field_quoted_number, "field.quoted_number"},
    RuleInfo{Rule::field_length, "field.length"},
    RuleInfo{Rule::field_control_character, "field.control_character"},
    RuleInfo{Rule::field_without_effect, "field.without_effect", Severity::warning},
    RuleInfo{Rule::field_no_effect_default, "field.no_effect_default", Severity::warning},
    RuleInfo{Rule::field_needs, "field.needs"},
    RuleInfo{Rule::field_zero_replaced, "field.zero_replaced", Severity::warning},
    RuleInfo{Rule::integer_malformed, "integer.malformed"},
    RuleInfo{Rule::integer_fraction, "integer.fraction"},
    RuleInfo{Rule::integer_leading_zero, "integer.leading_zero"},
    RuleInfo{Rule::number_malformed, "number.malformed"},
    RuleInfo{Rule::number_comma, "number.comma"},
    RuleInfo{Rule::number_thousands, "number.thousands"},
    RuleInfo{Rule::boolean_malformed, "boolean.malformed"},
    RuleInfo{Rule::duration_malformed, "duration.malformed"},
    RuleInfo{Rule::duration_no_unit, "duration.no_unit"},
    RuleInfo{Rule::range_malformed, "range.malformed"},
    RuleInfo{Rule::range_reversed, "range.reversed"},
    RuleInfo{Rule::function_not_allowed, "function.not_allowed"},
    RuleInfo{Rule::project_version, "project.version"},
    RuleInfo{Rule::name_duplicate, "name.duplicate"},
    RuleInfo{Rule::name_none, "name.none"},
    RuleInfo{Rule::name_reserved, "name.reserved"},
    RuleInfo{Rule::service_unknown, "service.unknown"},
    RuleInfo{Rule::service_type, "service.type"},
    RuleInfo{Rule::service_read_only, "service.read_only"},
    RuleInfo{Rule::service_outgrows, "service.outgrows", Severity::warning},
    RuleInfo{Rule::service_circular, "service.circular"},
    RuleInfo{Rule::local_unknown, "local.unknown"},
    RuleInfo{Rule::local_undeclared, "local.undeclared"},
    RuleInfo{Rule::local_type, "local.type"},
    RuleInfo{Rule::local_not_a_trigger, "local.not_a_trigger"},
    RuleInfo{Rule::host_with_port, "host.with_port"},
    RuleInfo{Rule::host_no_address, "host.no_address"},
    RuleInfo{Rule::host_malformed, "host.malformed"},
    RuleInfo{Rule::line_port_number, "line.port_number"},
    RuleInfo{Rule::line_port_settings, "line.port_settings"},
    RuleInfo{Rule::backoff_limit, "backoff.limit"},
    RuleInfo{Rule::round_trip_usual, "round_trip.usual"},
    RuleInfo{Rule::burst_alone, "burst.alone"},
    RuleInfo{Rule::line_tls, "line.tls"},
    RuleInfo{Rule::line_port_missing, "line.port_missing"},
    RuleInfo{Rule::line_port_twice, "line.port_twice"},
    RuleInfo{Rule::server_listen_twice, "server.listen_twice"},
    RuleInfo{Rule::line_many_devices, "line.many_devices", Severity::warning},
    RuleInfo{Rule::line_host_shared, "line.host_shared", Severity::note},
    RuleInfo{Rule::lines_none, "lines.none", Severity::note},
    RuleInfo{Rule::line_unknown, "line.unknown"},
    RuleInfo{Rule::address_reserved, "address.reserved", Severity::warning},
    RuleInfo{Rule::device_timeout_short, "device.timeout_short", Severity::warning},
    RuleInfo{Rule::device_registers_cut, "device.registers_cut", Severity::warning},
    RuleInfo{Rule::device_overlap, "device.overlap", Severity::note},
    RuleInfo{Rule::address_duplicate, "address.duplicate"},
    RuleInfo{Rule::bank_twice, "bank.twice"},
    RuleInfo{Rule::bank_overlay_bits, "bank.overlay_bits"},
    RuleInfo{Rule::mirror_empty, "mirror.empty", Severity::warning},
    RuleInfo{Rule::mirror_overlap, "mirror.overlap"},
    RuleInfo{Rule::mirror_beyond_end, "mirror.beyond_end"},
    RuleInfo{Rule::bank_missing, "bank.missing"},
    RuleInfo{Rule::bank_retain_outside, "bank.retain_outside"},
    RuleInfo{Rule::bank_read_only_outside, "bank.read_only_outside"},
    RuleInfo{Rule::bank_overlay_outside, "bank.overlay_outside"},
    RuleInfo{Rule::number_twice, "number.twice"},
    RuleInfo{Rule::limits_reversed, "limits.reversed"},
    RuleInfo{Rule::limits_outside, "limits.outside"},
    RuleInfo{Rule::limits_contradictory, "limits.contradictory"},
    RuleInfo{Rule::fifo_too_long, "fifo.too_long"},
    RuleInfo{Rule::peer_malformed, "peer.malformed"},
    RuleInfo{Rule::variable_outside_bank, "variable.outside_bank"},
    RuleInfo{Rule::variable_default_limits, "variable.default_limits", Severity::warning},
    RuleInfo{Rule::variable_bound_twice, "variable.bound_twice", Severity::warning},
    RuleInfo{Rule::variable_overlap, "variable.overlap", Severity::warning},
    RuleInfo{Rule::group_one_of, "group.one_of"},
    RuleInfo{Rule::source_unknown, "source.unknown"},
    RuleInfo{Rule::source_type, "source.type"},
    RuleInfo{Rule::source_not_writable, "source.not_writable"},
    RuleInfo{Rule::template_malformed, "template.malformed"},
    RuleInfo{Rule::template_without, "template.without"},
    RuleInfo{Rule::command_empty, "command.empty"},
    RuleInfo{Rule::answer_form, "answer.form"},
    RuleInfo{Rule::exchange_mixed, "exchange.mixed"},
    RuleInfo{Rule::measurement_beyond, "measurement.beyond"},
    RuleInfo{Rule::instrument_placeholder, "instrument.placeholder"},
    RuleInfo{Rule::instrument_unconfirmed, "instrument.unconfirmed"},
    RuleInfo{Rule::instrument_value_kind, "instrument.value_kind"},
    RuleInfo{Rule::instrument_any_data, "instrument.any_data"},
    RuleInfo{Rule::instrument_range, "instrument.range"},
    RuleInfo{Rule::instrument_expires, "instrument.expires", Severity::warning},
    RuleInfo{Rule::instrument_command_unknown, "instrument.command_unknown"},
    RuleInfo{Rule::byte_order_unknown, "byte_order.unknown"},
    RuleInfo{Rule::byte_order_type, "byte_order.type"},
    RuleInfo{Rule::byte_order_contradiction, "byte_order.contradiction"},
    RuleInfo{Rule::strategy_grouping_off, "strategy.grouping_off", Severity::warning},
    RuleInfo{Rule::profile_too_many_devices, "profile.too_many_devices", Severity::warning},
    RuleInfo{Rule::profile_too_many_variables, "profile.too_many_variables", Severity::warning},
    RuleInfo{Rule::variable_address_missing, "variable.address_missing"},
    RuleInfo{Rule::variable_address_twice, "variable.address_twice"},
    RuleInfo{Rule::variable_area_missing, "variable.area_missing"},
    RuleInfo{Rule::variable_no_traffic, "variable.no_traffic", Severity::warning},
    RuleInfo{Rule::variable_type_area, "variable.type_area"},
    RuleInfo{Rule::variable_function_area, "variable.function_area"},
    RuleInfo{Rule::variable_read_only_area, "variable.read_only_area"},
    RuleInfo{Rule::variable_overlaid_areas, "variable.overlaid_areas", Severity::warning},
    RuleInfo{Rule::variable_single_register, "variable.single_register"},
    RuleInfo{Rule::variable_write_single_only, "variable.write_single_only"},
    RuleInfo{Rule::variable_bit_write, "variable.bit_write", Severity::warning},
    RuleInfo{Rule::variable_not_offered, "variable.not_offered", Severity::warning},
    RuleInfo{Rule::variable_area_not_offered, "variable.area_not_offered", Severity::warning},
    RuleInfo{Rule::variable_bit_assumed, "variable.bit_assumed", Severity::warning},
    RuleInfo{Rule::variable_coil_assumed, "variable.coil_assumed", Severity::warning},
    RuleInfo{Rule::variable_discrete_input_assumed, "variable.discrete_input_assumed", Severity::warning},
    RuleInfo{Rule::variable_bit_type, "variable.bit_type"},
    RuleInfo{Rule::variable_coil_area, "variable.coil_area"},
    RuleInfo{Rule::variable_beyond_end, "variable.beyond_end"},
    RuleInfo{Rule::variable_needs_read, "variable.needs_read"},
    RuleInfo{Rule::variable_needs_write, "variable.needs_write"},
    RuleInfo{Rule::variable_length_type, "variable.length_type"},
    RuleInfo{Rule::variable_length_missing, "variable.length_missing"},
    RuleInfo{Rule::variable_scale_zero, "variable.scale_zero"},
    RuleInfo{Rule::variable_scale_type, "variable.scale_type"},
    RuleInfo{Rule::variable_write_range_malformed, "variable.write_range_malformed"},
    RuleInfo{Rule::variable_larger_than_request, "variable.larger_than_request", Severity::warning},
    RuleInfo{Rule::variable_read_in_parts, "variable.read_in_parts", Severity::warning},
    RuleInfo{Rule::variable_deadline_without_period, "variable.deadline_without_period"},
    RuleInfo{Rule::reference_malformed, "reference.malformed"},
    RuleInfo{Rule::address_like_reference, "address.like_reference", Severity::warning},
    RuleInfo{Rule::address_is_reference, "address.is_reference"},
    RuleInfo{Rule::default_out_of_range, "default.out_of_range"},
    RuleInfo{Rule::default_too_long, "default.too_long"},
    RuleInfo{Rule::words_malformed, "words.malformed"},
    RuleInfo{Rule::words_twice, "words.twice"},
    RuleInfo{Rule::words_type, "words.type"},
    RuleInfo{Rule::output_name, "output.name"},
    RuleInfo{Rule::output_password, "output.password"},
    RuleInfo{Rule::output_two_passwords, "output.two_passwords"},
    RuleInfo{Rule::output_password_plain, "output.password_plain", Severity::warning},
    RuleInfo{Rule::output_client_id_twice, "output.client_id_twice"},
    RuleInfo{Rule::output_control_topic_twice, "output.control_topic_twice"},
    RuleInfo{Rule::output_many_brokers, "output.many_brokers"},
    RuleInfo{Rule::output_broker_malformed, "output.broker_malformed"},
    RuleInfo{Rule::output_broker_scheme, "output.broker_scheme"},
    RuleInfo{Rule::output_broker_user, "output.broker_user"},
    RuleInfo{Rule::output_broker_twice, "output.broker_twice", Severity::warning},
    RuleInfo{Rule::output_history_twice, "output.history_twice"},
    RuleInfo{Rule::output_pattern_twice, "output.pattern_twice", Severity::warning},
    RuleInfo{Rule::output_never, "output.never"},
    RuleInfo{Rule::output_unknown, "output.unknown"},
    RuleInfo{Rule::output_unused, "output.unused"},
    RuleInfo{Rule::output_unmatched, "output.unmatched", Severity::warning},
    RuleInfo{Rule::output_not_writable, "output.not_writable"},
    RuleInfo{Rule::output_none_writable, "output.none_writable", Severity::warning},
    RuleInfo{Rule::output_select_empty, "output.select_empty", Severity::warning},
    RuleInfo{Rule::output_empty, "output.empty"},
    RuleInfo{Rule::output_retain_partial, "output.retain_partial", Severity::warning},
    RuleInfo{Rule::output_quota_short, "output.quota_short", Severity::warning},
    RuleInfo{Rule::output_falls_behind, "output.falls_behind", Severity::note},
    RuleInfo{Rule::topic_unknown_part, "topic.unknown_part"},
    RuleInfo{Rule::topic_brace, "topic.brace"},
    RuleInfo{Rule::topic_wildcard, "topic.wildcard"},
    RuleInfo{Rule::topic_empty_level, "topic.empty_level"},
    RuleInfo{Rule::topic_variable, "topic.variable"},
    RuleInfo{Rule::topic_shared, "topic.shared"},
    RuleInfo{Rule::topic_reserved, "topic.reserved"},
    RuleInfo{Rule::tag_malformed, "tag.malformed"},
    RuleInfo{Rule::findings_more, "findings.more"},
};

constexpr bool rules_in_order() {
    for (std::size_t i = 0; i < kRules.size(); ++i)
        if (static_cast<std::size_t>(kRules[i].rule) != i) return false;
    return kRules.back().rule == Rule::findings_more;
}
static_assert(rules_in_order(), "kRules has an entry for each rule, in the order of the enum");

constexpr auto kCodes = [] {
    std::array<std::string_view, kRules.size()> codes;
    std::ranges::transform(kRules, codes.begin(), &RuleInfo::code);
    return codes;
}();

const RuleInfo& info_of(Rule rule) {
    return kRules[static_cast<std::size_t>(rule)];
}

/// A value as in the file, cut to a printable length.
std::string shortened(std::string_view value) {
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
    return (info_of(rule).severity == Severity::error ? errors_ : warnings_).size() >= kMost;
}

void Findings::add(Rule rule, const SourceLocation& location, const std::string& path, std::string_view value,
                   std::string allowed, Arguments arguments) {
    const auto& [_, code, severity] = info_of(rule);
    const bool included = location.file != 0 && location.line != 0 && !full(rule);
    if (included && !included_
                         .emplace(rule, location.file, location.line, location.column,
                                  path.substr(path.rfind('.') + 1), shortened(value))
                         .second)
        return;
    ++(severity == Severity::error ? errors_seen_ : warnings_seen_);
    if (full(rule)) return;
    for (auto& [name, text] : arguments) text = shortened(text);
    (severity == Severity::error ? errors_ : warnings_)
        .push_back({severity, std::string(code), location, shortened(path), shortened(value),
                    std::move(allowed), std::move(arguments)});
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
                       .code = std::string(info_of(Rule::findings_more).code),
                       .location = location,
                       .arguments = {{"count", std::to_string(seen - all.size())}}});
    }
    return all;
}

}  // namespace takt::model
