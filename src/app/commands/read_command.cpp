// read and raw: one device asked once.
#include "commands/client_commands.hpp"

#include <string>
#include <vector>

#include "commands/one_off.hpp"
#include "output.hpp"
#include "takt/client/raw_request.hpp"
#include "takt/wire/words.hpp"

namespace takt::app {

ExitCode read(const CommonOptions& common, const ReadOptions& options) {
    const Texts texts(common.language);
    const auto& spec = options.spec;
    if (is_for_registers(texts, spec.area, options.registers_only)) return ExitCode::usage;
    if (is_beyond(texts, spec.start, spec.items())) return ExitCode::usage;
    if (options.watch) return watch(common, options);
    auto run = run_of(options);
    std::vector<client::ReadValue> values;
    Result<void> ended;
    const auto one_off = OneOff::open(options);
    if (one_off) {
        auto& device = (*one_off)->device();
        const Instant begin = line::now();
        ended = client::read_values(device, spec, values);
        run.duration = line::now() - begin;
        run.interrupted = device.interrupted();
    } else {
        ended = std::unexpected(one_off.error());
    }
    print(options.json ? report::read_json(texts, run, spec, values, ended).dump() + '\n'
                       : report::read_text(spec.type(), values));
    if (ended) return ExitCode::ok;
    print_error(report::ended_text(texts, run, ended.error()));
    return values.empty() ? exit_code(run, ended.error()) : ExitCode::partly;
}

ExitCode raw(const CommonOptions& common, const RawOptions& options) {
    const Texts texts(common.language);
    const auto pdu = client::parse_pdu(options.bytes);
    if (!pdu && pdu.error().code == Code::syntax) {
        print_error(texts("app.raw.digits", {{"value", std::string(pdu.error().subject.view())}}));
        return ExitCode::usage;
    }
    if (!pdu) return bad_arguments(texts, pdu.error());
    auto run = run_of(options);
    const auto failed = [&](const Error& error) {
        if (options.json)
            print(report::raw_json(texts, run, pdu->span(), std::unexpected(error)).dump() + '\n');
        print_error(report::ended_text(texts, run, error));
        return exit_code(run, error);
    };
    const auto one_off = OneOff::open(options);
    if (!one_off) return failed(one_off.error());
    auto& device = (*one_off)->device();
    const UnitId unit{options.unit};
    const auto decoded = wire::decode_request(pdu->span());
    print_status(wire::describe_request(unit, pdu->span(), decoded) + "\n");
    const auto answer = device.transact(*pdu, false);
    run.interrupted = device.interrupted();
    if (!answer) return failed(answer.error());
    const Bytes response = answer->pdu();
    if (!answer->empty())
        print_status(wire::describe_response(unit, response, decoded ? &*decoded : nullptr) + "\n");
    print(options.json ? report::raw_json(texts, run, pdu->span(), response).dump() + '\n'
                       : wire::hex(response) + '\n');
    return !answer->empty() && wire::is_exception(response[0]) ? ExitCode::exception : ExitCode::ok;
}

}  // namespace takt::app
