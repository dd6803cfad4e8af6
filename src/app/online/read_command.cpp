// read and raw: one device asked once.
#include "commands.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "online/one_off.hpp"
#include "output.hpp"
#include "takt/client/raw_request.hpp"
#include "takt/report/states/all_types_report.hpp"
#include "takt/text/frame_text.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::app {
namespace {

constexpr std::uint32_t kRegistersOfLongestType = 4;

struct Reading {
    std::vector<client::ReadValue> values;
    Result<void> ended;
};

Reading read_once(const Texts& texts, const ReadOptions& options, const client::ReadSpec& spec,
                  report::ClientRun& run) {
    Reading reading;
    const auto one_off = OneOff::open(texts, options);
    if (!one_off) {
        reading.ended = std::unexpected(one_off.error());
        return reading;
    }
    auto& device = (*one_off)->device();
    const Instant begin = line::now();
    reading.ended = client::read_values(device, spec, reading.values);
    run.duration = line::now() - begin;
    run.interrupted = device.interrupted();
    return reading;
}

ExitCode end_of_read(const Texts& texts, const report::ClientRun& run,
                     const std::vector<client::ReadValue>& values, const Result<void>& ended) {
    if (ended) return ExitCode::ok;
    print_error(report::ended_text(texts, run, ended.error()));
    return values.empty() ? exit_code(run, ended.error()) : ExitCode::partly;
}

ExitCode read_all_types(const Texts& texts, const ReadOptions& options) {
    auto spec = options.spec;
    const value::Layout plain;
    for (const auto& [given, option] : {std::pair{options.watch.has_value(), "--watch"},
                                        std::pair{!(spec.layout.order == plain.order), "--order"},
                                        std::pair{spec.layout.registers != plain.registers, "--length"}}) {
        if (!given) continue;
        return ended_with(texts("app.read.all_alone", {{"option", option}}), ExitCode::usage);
    }
    spec.layout = {.type = DataType::uint16, .order = {}};
    if (!options.count_given) spec.count = kRegistersOfLongestType;
    if (is_beyond(texts, spec.start, spec.items())) return ExitCode::usage;
    auto run = run_of(options);
    const auto [values, ended] = read_once(texts, options, spec, run);
    std::vector<std::uint16_t> registers;
    for (const auto& read : values)
        registers.push_back(static_cast<std::uint16_t>(std::get<std::uint64_t>(read.value)));
    print(options.json ? report::all_types_json(texts, run, spec, registers, ended).dump() + '\n'
                       : report::all_types_text(texts, spec.start, registers));
    return end_of_read(texts, run, values, ended);
}

}  // namespace

ExitCode read(const CommonOptions& common, const ReadOptions& given) {
    const Texts texts(common.language);
    auto options = given;
    auto& spec = options.spec;
    const auto start = start_meant(texts, spec.area, spec.start, options);
    if (!start) return ExitCode::usage;
    spec.start = *start;
    if (options.all_types) return read_all_types(texts, options);
    if (is_beyond(texts, spec.start, spec.items())) return ExitCode::usage;
    if (options.watch) return watch(common, options);
    auto run = run_of(options);
    const auto [values, ended] = read_once(texts, options, spec, run);
    print(options.json ? report::read_json(texts, run, spec, values, ended).dump() + '\n'
                       : report::read_text(spec.type(), values));
    return end_of_read(texts, run, values, ended);
}

ExitCode raw(const CommonOptions& common, const RawOptions& options) {
    const Texts texts(common.language);
    const auto pdu = client::parse_pdu(options.bytes);
    if (!pdu && pdu.error().code == Code::syntax)
        return ended_with(texts("app.raw.digits", {{"value", std::string(pdu.error().subject.view())}}),
                          ExitCode::usage);
    if (!pdu) return ended_with(texts.describe(pdu.error()), ExitCode::usage);
    auto run = run_of(options);
    const auto failed = [&](const Error& error) {
        if (options.json)
            print(report::raw_json(texts, run, pdu->span(), std::unexpected(error)).dump() + '\n');
        print_error(report::ended_text(texts, run, error));
        return exit_code(run, error);
    };
    const auto one_off = OneOff::open(texts, options);
    if (!one_off) return failed(one_off.error());
    auto& device = (*one_off)->device();
    const UnitId unit{options.unit};
    const auto decoded = wire::decode_request(pdu->span());
    const auto print_words = [&](const std::string& words) {
        print_status(text::frame_text(texts.language(), words) + "\n");
    };
    print_words(wire::describe_request(unit, pdu->span(), decoded));
    const auto answer = device.transact(*pdu, false);
    run.interrupted = device.interrupted();
    if (!answer) return failed(answer.error());
    const Bytes response = answer->pdu();
    if (!answer->empty()) print_words(wire::describe_response(unit, response, decoded ? &*decoded : nullptr));
    print(options.json ? report::raw_json(texts, run, pdu->span(), response).dump() + '\n'
                       : wire::hex(response) + '\n');
    return !answer->empty() && wire::is_exception(response[0]) ? ExitCode::exception : ExitCode::ok;
}

}  // namespace takt::app
