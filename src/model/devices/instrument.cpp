// Instruments: devices with commands of their own.
#include <algorithm>
#include <set>
#include <span>

#include "devices/instrument_parts.hpp"

namespace takt::model {
namespace {

constexpr std::string_view kInstrumentSerialKeys[] = {"port", "baud", "parity", "stop_bits", "data_bits"};
constexpr std::string_view kTextKeys[] = {"until", "pattern"};
constexpr std::string_view kBinaryKeys[] = {"length", "begins", "checksum", "fields"};
constexpr std::size_t kMostExchanges = 32;

std::size_t checksum_bytes(Checksum checksum) {
    switch (checksum) {
        case Checksum::none: return 0;
        case Checksum::sum:
        case Checksum::exclusive_or: return 1;
        case Checksum::crc16: return 2;
    }
    return 0;
}

/// Names are unique within one instrument.
void take_name(Reader& reader, std::string_view key, std::string_view name, std::set<std::string>& names) {
    if (!names.insert(std::string(name)).second)
        reader.report(Rule::number_twice, key, {}, {{"key", "name"}});
}

void read_field_type(Reader& reader, BinaryField& field) {
    const auto word = reader.word("type");
    if (!word) return;
    field.is_signed = word->starts_with("int");
    if (*word == "int8" || *word == "uint8") {
        field.bytes = 1;
        return;
    }
    field.type = data_type(*word);
    field.bytes = static_cast<std::uint16_t>(2 * register_count(*field.type));
}

void read_fields(Interpretation& state, Reader& reader, AnswerFormat& format, std::set<std::string>& names) {
    const Node* const list = reader.list("fields");
    if (list == nullptr) return;
    const std::size_t available =
        format.length - std::min<std::size_t>(format.length, checksum_bytes(format.checksum));
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("fields") + "[" + std::to_string(i) + "]";
        if (!is_mapping(state, item, path)) continue;
        Reader own(state.findings, item, path, Object::measurement, state.context);
        BinaryField field{.name = own.text("name").value_or("")};
        if (own.given("name")) take_name(own, "name", field.name, names);
        field.offset = static_cast<std::uint16_t>(own.integer("offset").value_or(0));
        read_field_type(own, field);
        field.order.high_byte_first = own.boolean("high_byte_first").value_or(true);
        field.order.high_register_first = own.boolean("high_register_first").value_or(true);
        if (field.offset + field.bytes > available)
            own.report(Rule::measurement_beyond, "offset", "0.." + std::to_string(available),
                       {{"length", std::to_string(format.length)}});
        format.fields.push_back(std::move(field));
    }
}

void read_text_answer(Reader& reader, AnswerFormat& format, std::set<std::string>& names) {
    format.until = read_bytes(reader, "until");
    if (!reader.given("until")) reader.report(Rule::field_missing, "until", {}, {{"key", "until"}});
    if (!reader.given("pattern")) {
        reader.report(Rule::field_missing, "pattern", {}, {{"key", "pattern"}});
        return;
    }
    auto pattern = read_template(reader, "pattern");
    if (!pattern) return;
    format.pattern = *std::move(pattern);
    for (const auto name : format.pattern.names()) take_name(reader, "pattern", name, names);
}

void read_exchanges(Interpretation& state, Reader& reader, Instrument& instrument) {
    const Node* const list = reader.list("exchanges");
    if (list == nullptr) return;
    if (list->items.empty() || list->items.size() > kMostExchanges)
        reader.report(Rule::field_empty, "exchanges", "1.." + std::to_string(kMostExchanges),
                      {{"key", "exchanges"}});
    std::set<std::string> names;
    std::optional<bool> asked;  // by a request, as the first one
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("exchanges") + "[" + std::to_string(i) + "]";
        if (!is_mapping(state, item, path)) continue;
        Reader own(state.findings, item, path, Object::exchange, state.context);
        Exchange exchange{.location = item.location};
        const bool has_request = own.given("request");
        if (has_request) exchange.request = read_bytes(own, "request");
        exchange.answer = read_answer(state, own, "answer", names);
        instrument.exchanges.push_back(std::move(exchange));
        if (asked.value_or(has_request) != has_request) own.report(Rule::exchange_mixed, "request");
        asked = asked.value_or(has_request);
    }
}

void read_instrument_port(Interpretation& state, Reader& reader, Instrument& instrument,
                          bool has_default_port) {
    const std::string_view key = instrument.serial ? "port" : "host";
    const std::string_view transport = instrument.serial ? "serial" : "tcp";
    instrument.port = reader.text(key).value_or("");
    if (!instrument.serial) check_host(reader, key, instrument.port);
    report_keys_without_effect(
        reader, instrument.serial ? std::span<const std::string_view>(kClientKeys) : kInstrumentSerialKeys,
        transport);
    if (const auto port = reader.integer("tcp_port")) instrument.tcp_port = static_cast<std::uint16_t>(*port);
    const bool missing = report_missing_port(reader, key, transport);
    if (instrument.serial)
        register_port(state, reader, instrument.port);
    else if (!missing && !has_default_port)
        report_missing_port(reader, "tcp_port", transport);
}

}  // namespace

std::string read_bytes(Reader& reader, std::string_view key) {
    const Node* const node = reader.scalar(key);
    if (node == nullptr) return {};
    auto parsed = parse_bytes(node->text);
    if (parsed && !parsed->empty()) return *std::move(parsed);
    reader.report(Rule::template_malformed, key, {},
                  {{"position", std::to_string(parsed ? std::size_t{1} : parsed.error().position)}});
    return {};
}

AnswerFormat read_answer(Interpretation& state, Reader& outer, std::string_view name,
                         std::set<std::string>& names) {
    AnswerFormat format;
    const Node* const node = outer.mapping(name);
    if (node == nullptr) return format;
    Reader reader(state.findings, *node, outer.path_of(name), Object::answer, state.context);
    const bool binary = reader.given("length");
    for (const auto key : binary ? std::span<const std::string_view>(kTextKeys) : kBinaryKeys)
        if (reader.given(key)) reader.report(Rule::answer_form, key, {}, {{"key", std::string(key)}});
    if (!binary) {
        read_text_answer(reader, format, names);
        return format;
    }
    format.length = static_cast<std::uint16_t>(reader.integer("length").value_or(1));
    format.begins = reader.given("begins") ? read_bytes(reader, "begins") : std::string();
    format.checksum = reader.choice<Checksum>("checksum").value_or(Checksum::none);
    if (format.begins.size() + checksum_bytes(format.checksum) > format.length)
        reader.report(Rule::measurement_beyond, "length", "1.." + std::to_string(format.length),
                      {{"length", std::to_string(format.length)}});
    read_fields(state, reader, format, names);
    return format;
}

std::vector<std::string_view> AnswerFormat::names() const {
    auto names = pattern.names();
    for (const auto& field : fields) names.emplace_back(field.name);
    return names;
}

bool AnswerFormat::has(std::string_view measurement) const {
    return pattern.has(measurement) ||
           std::ranges::find(fields, measurement, &BinaryField::name) != fields.end();
}

bool Instrument::has(std::string_view measurement) const {
    return std::ranges::any_of(exchanges, [&](const Exchange& e) { return e.answer.has(measurement); });
}

Instrument interpret_instrument(Interpretation& state, const Node& node, const std::string& path) {
    state.context = Context{.profile = state.context.profile};
    Reader reader(state.findings, node, path, Object::instrument, state.context);
    Instrument instrument;
    instrument.location = node.location;
    instrument.name = read_name(state, reader, state.line_names);
    const bool tls = report_tls(reader);
    const auto [serial, tcp] = kInstrumentTransports;
    instrument.serial =
        !tls && reader.word("transport").value_or(names_host(reader) ? tcp : serial) == serial;
    read_instrument_port(state, reader, instrument, tls);
    instrument.format = read_character_format(reader, wire::Framing::rtu);
    instrument.every = reader.duration("every").value_or(instrument.every);
    instrument.timeout = reader.duration("timeout").value_or(instrument.timeout);
    read_exchanges(state, reader, instrument);
    if (!instrument.exchanges.empty() && !instrument.is_asked() && reader.given("every"))
        reader.report_without_effect("every", "request: none");
    read_commands(state, reader, instrument);
    return instrument;
}

}  // namespace takt::model
