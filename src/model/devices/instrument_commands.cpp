// Commands of instruments: those of their start, and those that carry a value.
#include <algorithm>
#include <set>

#include "devices/instrument_parts.hpp"
#include "takt/model/scalar.hpp"

namespace takt::model {
namespace {

using Form = TextTemplate::Kind;

constexpr std::size_t kMostStartCommands = 32;
constexpr std::size_t kMostCommands = 64;
constexpr Duration kLeastExpiry = std::chrono::seconds(1);
constexpr std::uint8_t kStartAttempts = 3;

constexpr std::string_view kNumberKeys[] = {"decimals", "digits", "least", "greatest"};

/// Data of any content would match.
bool matches_any(const AnswerFormat& format) {
    if (!format.until.empty())
        return std::ranges::all_of(format.pattern.pieces,
                                   [](const auto& piece) { return piece.kind == Form::skip; });
    return format.begins.empty() && format.checksum == Checksum::none;
}

std::optional<AnswerFormat> read_optional(Interpretation& state, Reader& reader, std::string_view key) {
    if (!reader.given(key)) return std::nullopt;
    std::set<std::string> names;
    return read_answer(state, reader, key, names);
}

Confirmation read_confirmation(Interpretation& state, Reader& reader, const Instrument& instrument,
                               std::uint8_t attempts) {
    Confirmation confirmation;
    confirmation.answer = read_optional(state, reader, "answer");
    confirmation.refused = read_optional(state, reader, "refused");
    confirmation.timeout = reader.duration("timeout").value_or(instrument.timeout);
    confirmation.pause = reader.duration("pause").value_or(Duration::zero());
    confirmation.attempts = static_cast<std::uint8_t>(reader.integer("attempts").value_or(attempts));
    if (confirmation.refused && !confirmation.answer)
        reader.report(Rule::field_missing, "answer", {}, {{"key", "answer"}});
    return confirmation;
}

/// Each item of a list, which has at most `most`.
template <class Read>
void each_item(Interpretation& state, Reader& reader, std::string_view key, std::size_t most, Object object,
               const Read& read) {
    if (!reader.given(key)) return;
    const Node* const list = reader.list(key);
    if (list == nullptr) return;
    if (list->items.size() > most) reader.report(Rule::field_out_of_range, key, "0.." + std::to_string(most));
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto path = reader.path_of(key) + "[" + std::to_string(i) + "]";
        if (!is_mapping(state, list->items[i], path)) continue;
        Reader own(state.findings, list->items[i], path, object, state.context);
        read(own);
    }
}

/// The request of a command: bytes and one placeholder, `value`.
TextTemplate read_request(Reader& reader) {
    auto request = read_template(reader, "request");
    if (!request) return {};
    const auto holds = [](const auto& piece) { return piece.kind != Form::literal; };
    const auto names = request->names();
    if (names.size() == 1 && names[0] == "value" && std::ranges::count_if(request->pieces, holds) == 1)
        return *std::move(request);
    reader.report(Rule::instrument_placeholder, "request", "value, value:hex, value:text");
    return {};
}

NumberFormat read_number_format(Reader& reader, const InstrumentCommand& command) {
    NumberFormat format;
    if (const auto decimals = reader.integer("decimals"))
        format.decimals = static_cast<std::uint8_t>(*decimals);
    format.digits = static_cast<std::uint8_t>(reader.integer("digits").value_or(format.digits));
    format.least = reader.number("least");
    format.greatest = reader.number("greatest");
    if (format.least && format.greatest && *format.least > *format.greatest)
        reader.report(Rule::instrument_range, "greatest", {},
                      {{"least", std::string(reader.value("least")->text)}});
    if (command.kind() == Form::text)
        for (const auto key : kNumberKeys)
            if (reader.given(key)) reader.report_without_effect(key, "{value:text}");
    if (command.kind() == Form::hex && reader.given("decimals"))
        reader.report_without_effect("decimals", "{value:hex}");
    return format;
}

/// Whether the measurement `value` of an answer is a text; nothing: there is none.
std::optional<bool> is_text(const AnswerFormat& format) {
    for (const auto& piece : format.pattern.pieces)
        if (piece.kind != Form::literal && piece.kind != Form::skip && piece.text == "value")
            return piece.kind == Form::text;
    return format.has("value") ? std::optional(false) : std::nullopt;
}

void check_kind(Reader& reader, std::string_view key, const AnswerFormat& answer,
                const InstrumentCommand& command) {
    const auto text = is_text(answer);
    if (text && !command.request.pieces.empty() && *text != (command.kind() == Form::text))
        reader.report(Rule::instrument_value_kind, key);
}

std::optional<Exchange> read_read_back(Interpretation& state, Reader& outer,
                                       const InstrumentCommand& command) {
    const Node* const node = outer.mapping("read_back");
    if (node == nullptr) return std::nullopt;
    Reader reader(state.findings, *node, outer.path_of("read_back"), Object::read_back, state.context);
    Exchange exchange{.location = node->location};
    exchange.request = reader.given("request") ? read_bytes(reader, "request") : std::string();
    std::set<std::string> names;
    exchange.answer = read_answer(state, reader, "answer", names);
    if (reader.given("answer") && !exchange.answer.has("value"))
        reader.report(Rule::template_without, "answer", "{value}", {{"name", "value"}});
    check_kind(reader, "answer", exchange.answer, command);
    return exchange;
}

/// The longest time that the command needs after an exchange that is in flight.
Duration needed(const InstrumentCommand& command, const Instrument& instrument) {
    const auto& confirmation = command.confirmation;
    const int answers = (confirmation.answer ? 1 : 0) + (command.read_back ? 1 : 0);
    return instrument.timeout + confirmation.attempts * answers * confirmation.timeout + confirmation.pause;
}

InstrumentCommand interpret_instrument_command(Interpretation& state, Reader& reader,
                                               const Instrument& instrument) {
    InstrumentCommand command;
    command.location = reader.node().location;
    command.name = reader.text("name").value_or("");
    const auto same = [&](const auto& other) { return !command.name.empty() && other.name == command.name; };
    if (std::ranges::any_of(instrument.commands, same))
        reader.report(Rule::number_twice, "name", {}, {{"key", "name"}});
    if (reader.given("request")) command.request = read_request(reader);
    command.format = read_number_format(reader, command);
    command.unit = reader.text("unit").value_or("");
    command.confirmation = read_confirmation(state, reader, instrument, 1);
    command.restore = reader.boolean("restore").value_or(true);
    if (reader.given("read_back")) command.read_back = read_read_back(state, reader, command);
    if (!reader.given("answer") && !reader.given("read_back") && !reader.given("refused"))
        reader.report(Rule::instrument_unconfirmed, "answer");
    if (command.confirmation.answer) check_kind(reader, "answer", *command.confirmation.answer, command);
    const auto least = needed(command, instrument);
    command.expires = reader.duration("expires").value_or(std::max(least, kLeastExpiry));
    if (command.expires < least)
        reader.report(Rule::instrument_expires, "expires", {}, {{"needed", to_text(least)}});
    return command;
}

}  // namespace

TextTemplate::Kind InstrumentCommand::kind() const {
    const auto found = std::ranges::find_if(
        request.pieces, [](const TextTemplate::Piece& piece) { return piece.kind != Form::literal; });
    return found == request.pieces.end() ? Form::number : found->kind;
}

void read_commands(Interpretation& state, Reader& reader, Instrument& instrument) {
    each_item(state, reader, "start", kMostStartCommands, Object::start_command, [&](Reader& own) {
        StartCommand command{.location = own.node().location};
        if (own.given("request")) command.request = read_bytes(own, "request");
        command.confirmation = read_confirmation(state, own, instrument, kStartAttempts);
        instrument.start.push_back(std::move(command));
    });
    each_item(state, reader, "commands", kMostCommands, Object::instrument_command, [&](Reader& own) {
        instrument.commands.push_back(interpret_instrument_command(state, own, instrument));
    });
    instrument.start_retry = reader.duration("start_retry").value_or(instrument.start_retry);
    instrument.reset = read_optional(state, reader, "reset");
    if (reader.is_mapping("reset") && matches_any(*instrument.reset))
        reader.report(Rule::instrument_any_data, "reset");
    if (const auto limit = reader.integer("silent_after"))
        instrument.silent_after = static_cast<std::uint8_t>(*limit);
    if (!instrument.exchanges.empty() && !instrument.is_asked() && reader.given("silent_after"))
        reader.report_without_effect("silent_after", "request: none");
    if (!instrument.start.empty() || !instrument.commands.empty()) return;
    for (const std::string_view key : {"start_retry", "reset", "silent_after"})
        if (reader.given(key)) reader.report_without_effect(key, "start: none, commands: none");
}

}  // namespace takt::model
