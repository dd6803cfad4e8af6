// read and raw: one device asked once.
#include "commands/client_commands.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "commands/one_off.hpp"
#include "output.hpp"
#include "takt/client/raw_request.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/value_json.hpp"
#include "takt/text/escape.hpp"
#include "takt/value/text.hpp"
#include "takt/wire/words.hpp"

namespace takt::app {
namespace {

using Values = std::vector<client::ReadValue>;

file::Json read_json(const ReadOptions& options, const Values& values, Duration time) {
    const auto& spec = options.spec;
    auto list = file::Json::array();
    for (const auto& read : values) list.push_back(report::to_json(spec.type(), false, read.value));
    auto object = object_of(options);
    object.set("function", static_cast<int>(wire::read_function(spec.area)));
    object.set("start", spec.start);
    object.set("type", name(spec.type()));
    object.set("values", std::move(list));
    object.set("time_ms", static_cast<double>(time.count()) / 1e6);
    return object;
}

std::string read_text(DataType type, const Values& values) {
    std::string text;
    for (const auto& [address, value] : values)
        text += fmt::format("{} {}\n", address,
                            type == DataType::boolean ? (std::get<bool>(value) ? "1" : "0")
                                                      : text::escape_line(value::format(type, false, value)));
    return text;
}

}  // namespace

ExitCode read(const CommonOptions& common, const ReadOptions& options) {
    const Texts texts(common.language);
    const auto& spec = options.spec;
    if (is_for_registers(texts, spec.area, options.registers_only)) return ExitCode::usage;
    if (is_beyond(texts, spec.start, spec.items())) return ExitCode::usage;
    if (options.watch) return watch(common, options);
    Values values;
    const auto one_off = OneOff::open(options);
    if (!one_off) return ended_by(texts, options, nullptr, one_off.error(), read_json(options, values, {}));
    const Instant begin = line::now();
    const auto done = client::read_values((*one_off)->device(), spec, values);
    auto object = read_json(options, values, line::now() - begin);
    if (!options.json) print(read_text(spec.type(), values));
    if (done && options.json) print(object.dump() + "\n");
    if (done) return ExitCode::ok;
    const ExitCode code = ended_by(texts, options, one_off->get(), done.error(), std::move(object));
    return values.empty() ? code : ExitCode::partly;
}

ExitCode raw(const CommonOptions& common, const RawOptions& options) {
    const Texts texts(common.language);
    const auto pdu = client::parse_pdu(options.bytes);
    if (!pdu && pdu.error().code == Code::syntax) {
        print_error(texts("app.raw.digits", {{"value", std::string(pdu.error().subject.view())}}));
        return ExitCode::usage;
    }
    if (!pdu) return bad_arguments(texts, pdu.error());
    auto object = object_of(options);
    object.set("request", wire::hex(pdu->span()));
    const auto one_off = OneOff::open(options);
    if (!one_off) return ended_by(texts, options, nullptr, one_off.error(), std::move(object));
    const UnitId unit{options.unit};
    const auto decoded = wire::decode_request(pdu->span());
    print_status(wire::describe_request(unit, pdu->span(), decoded) + "\n");
    const auto answer = (*one_off)->device().transact(*pdu, false);
    if (!answer) return ended_by(texts, options, one_off->get(), answer.error(), std::move(object));
    if (!answer->empty())
        print_status(wire::describe_response(unit, answer->pdu(), decoded ? &*decoded : nullptr) + "\n");
    if (options.json) {
        object.set("response", wire::hex(answer->pdu()));
        print(object.dump() + "\n");
    } else {
        print(wire::hex(answer->pdu()) + "\n");
    }
    return !answer->empty() && (answer->pdu()[0] & 0x80U) != 0 ? ExitCode::exception : ExitCode::ok;
}

}  // namespace takt::app
