// `outputs`: connection, credentials and journal. The selection of values is in output_selection.cpp.
#include "takt/model/output.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "servers/interpretation.hpp"
#include "servers/output_parts.hpp"
#include "takt/base/ascii.hpp"
#include "takt/model/nearest.hpp"

namespace takt::model {
namespace {

constexpr std::string_view kMqttKeys[] = {
    "brokers",       "version",  "client_id",        "user",    "password_file", "password_env",
    "ca_file",       "key_file", "certificate_file", "alpn",    "keep_alive",    "in_flight",
    "control_topic", "commands", "command_expiry",   "backoff", "round_trip",    "backlog"};

/// Lower-case letters, digits, - and _, so that the name is a folder and a level of a topic everywhere.
bool is_plain(std::string_view name) {
    return std::ranges::all_of(name, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    });
}

std::string made_plain(std::string_view name) {
    std::string plain;
    for (const char c : name) {
        const char small = lower_case(c);
        if (is_plain(std::string_view(&small, 1)))
            plain += small;
        else if (!plain.ends_with('_'))
            plain += '_';
    }
    return plain.find_first_not_of('_') == std::string::npos ? "cloud" : plain;
}

void read_credentials(Reader& reader, MqttSettings& mqtt) {
    mqtt.user = reader.text("user").value_or("");
    mqtt.password_file = reader.text("password_file").value_or("");
    mqtt.password_env = reader.text("password_env").value_or("");
    if (reader.given("password_file") && reader.given("password_env"))
        reader.report(Rule::output_two_passwords, "password_env");
    const std::string_view key = reader.given("password_file") ? "password_file" : "password_env";
    if (!reader.given(key)) return;
    if (!reader.given("user") && !reader.misspelt("user"))
        reader.report(Rule::field_missing, "user", {}, {{"key", "user"}});
    const auto plain = std::ranges::find(mqtt.brokers, false, &Broker::tls);
    if (plain != mqtt.brokers.end() && !is_this_computer(plain->host))
        reader.report(Rule::output_password_plain, key, {}, {{"broker", url_of(*plain)}});
}

void read_certificates(Reader& reader, MqttSettings& mqtt) {
    mqtt.ca_file = reader.text("ca_file").value_or("");
    mqtt.certificate_file = reader.text("certificate_file").value_or("");
    mqtt.key_file = reader.text("key_file").value_or("");
    mqtt.alpn = reader.text("alpn").value_or("");
    for (const auto& [key, other] :
         {std::pair<std::string_view, std::string_view>("key_file", "certificate_file"),
          {"certificate_file", "key_file"}})
        if (reader.given(key) && !reader.given(other) && !reader.misspelt(other))
            reader.report(Rule::field_missing, other, {}, {{"key", std::string(other)}});
    if (mqtt.brokers.empty() || std::ranges::find(mqtt.brokers, true, &Broker::tls) != mqtt.brokers.end())
        return;
    for (const std::string_view key : {"ca_file", "certificate_file", "key_file", "alpn"})
        if (reader.given(key)) reader.report_without_effect(key, "brokers: mqtt://");
}

/// Two clients with one identifier end each other's connections; with one control topic each would execute
/// the commands of the other.
void check_others(Interpretation& state, Reader& reader, const MqttSettings& mqtt) {
    for (const auto& other : state.project.outputs) {
        const bool shared = std::ranges::any_of(mqtt.brokers, [&](const Broker& broker) {
            return std::ranges::find(other.mqtt.brokers, broker) != other.mqtt.brokers.end();
        });
        if (!shared) continue;
        if (!mqtt.client_id.empty() && other.mqtt.client_id == mqtt.client_id)
            reader.report(Rule::output_client_id_twice, "client_id", {}, {{"first", other.name}});
        if (reader.given("control_topic") && other.mqtt.control_topic == mqtt.control_topic)
            reader.report(Rule::output_control_topic_twice, "control_topic", {}, {{"first", other.name}});
    }
}

std::string read_control_topic(Reader& reader, std::string_view name) {
    constexpr std::string_view kDefault = "takt/{output}";
    const auto topic = read_topic(reader, "control_topic", std::array{TopicPart::output});
    auto text = topic.value_or(*TopicTemplate::parse(kDefault)).expand({.output = name});
    if (text.ends_with('/')) text.pop_back();
    return text;
}

void read_pauses(Interpretation& state, Reader& reader, MqttSettings& mqtt) {
    mqtt.backoff = read_backoff(state, reader, mqtt.backoff).value_or(mqtt.backoff);
    const bool limited = reader.is_mapping("backoff") && reader.value("backoff")->find("limit") != nullptr;
    mqtt.nearby_limit = limited ? mqtt.backoff.limit : std::max(mqtt.nearby_limit, mqtt.backoff.first);
}

MqttSettings read_mqtt(Interpretation& state, Reader& reader, std::string_view name) {
    MqttSettings mqtt;
    mqtt.brokers = read_brokers(state, reader);
    mqtt.version = reader.choice<MqttVersionChoice>("version").value_or(mqtt.version);
    mqtt.client_id = reader.text("client_id").value_or("");
    read_credentials(reader, mqtt);
    read_certificates(reader, mqtt);
    mqtt.keep_alive = reader.duration("keep_alive").value_or(mqtt.keep_alive);
    read_pauses(state, reader, mqtt);
    mqtt.in_flight = static_cast<std::uint16_t>(reader.integer("in_flight").value_or(mqtt.in_flight));
    mqtt.round_trip = reader.duration("round_trip").value_or(mqtt.round_trip);
    mqtt.backlog = reader.choice<Backlog>("backlog").value_or(mqtt.backlog);
    mqtt.control_topic = read_control_topic(reader, name);
    check_others(state, reader, mqtt);
    return mqtt;
}

/// A project has one history, in a file beside it.
void check_history(Interpretation& state, Reader& reader) {
    const auto& others = state.project.outputs;
    const auto first = std::ranges::find(others, OutputTransport::history, &Output::transport);
    if (first != others.end())
        reader.report(Rule::output_history_twice, "transport", {}, {{"first", first->name}});
}

JournalSettings read_journal(Reader& reader) {
    constexpr unsigned kMebi = 20;
    JournalSettings journal;
    if (const auto quota = reader.integer("quota_mb"))
        journal.quota = static_cast<std::uint64_t>(*quota) << kMebi;
    if (const auto buffer = reader.integer("buffer_mb"))
        journal.buffer = static_cast<std::uint64_t>(*buffer) << kMebi;
    journal.retention = reader.duration("retention").value_or(journal.retention);
    journal.directory = reader.text("directory").value_or("");
    return journal;
}

Output interpret_output(Interpretation& state, const Node& node, const std::string& path) {
    Reader reader(state.findings, node, path, Object::output, state.context);
    Output output;
    output.location = node.location;
    output.name = read_name(state, reader, state.output_names);
    if (!is_plain(output.name))
        reader.report(Rule::output_name, "name", "a-z 0-9 - _", {{"meant", made_plain(output.name)}});
    const auto transport = reader.choice<OutputTransport>("transport");
    output.transport = transport.value_or(OutputTransport::mqtt);
    if (output.transport == OutputTransport::history) {
        check_history(state, reader);
        report_keys_without_effect(reader, kMqttKeys, name(output.transport));
    } else if (transport || !reader.given("transport") || reader.given("brokers")) {
        output.mqtt = read_mqtt(state, reader, output.name);
        output.command_expiry = reader.duration("command_expiry").value_or(output.command_expiry);
        if (reader.given("command_expiry") && !reader.given("commands"))
            reader.report_without_effect("command_expiry", "commands: –");
    }
    output.journal = read_journal(reader);
    read_selections(state, reader, output);
    if (output.transport == OutputTransport::mqtt) {
        read_commands(state, reader, output);
        check_quota(state, reader, output);
        check_window(state, reader, output);
    }
    return output;
}

}  // namespace

std::span<const std::string_view> control_levels() {
    static constexpr std::array<std::string_view, 6> kLevels{"state",   "status", "gap",
                                                             "command", "set",    "answer"};
    return kLevels;
}

std::string_view name(OutputTransport transport) {
    return kOutputTransports[static_cast<std::size_t>(transport)];
}

std::string journal_directory(std::string_view project_file) {
    const auto slash = project_file.rfind('/');
    const auto begin = slash == std::string_view::npos ? 0 : slash + 1;
    const auto dot = project_file.rfind('.');
    const auto end = dot == std::string_view::npos || dot <= begin ? project_file.size() : dot;
    return std::string(project_file.substr(0, end)).append(".journal");
}

void interpret_outputs(Interpretation& state, Reader& project) {
    const Node* const list = project.list("outputs");
    if (list == nullptr) return;
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = "outputs[" + std::to_string(i) + "]";
        state.project.outputs.push_back(is_mapping(state, item, path) ? interpret_output(state, item, path)
                                                                      : Output{});
    }
}

}  // namespace takt::model
