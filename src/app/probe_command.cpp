// takt probe: which items of each area a device has.
#include "takt/app/probe_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "takt/app/client.hpp"
#include "takt/app/console.hpp"
#include "takt/app/progress.hpp"
#include "takt/app/texts.hpp"
#include "takt/discover/range_probe.hpp"
#include "takt/file/json.hpp"
#include "takt/report/formatting.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;
using discover::ProbeEnd;
using discover::ProbeReply;
using wire::Area;

constexpr std::array kAllAreas{Area::holding_register, Area::input_register, Area::coil,
                               Area::discrete_input};
constexpr int kBusyTries = 20;
constexpr Duration kBusyPause = 100ms;
constexpr Duration kReconnectPause = 500ms;
constexpr int kReconnects = 10;

bool is_busy(int exception) {
    return exception == static_cast<int>(wire::ExceptionCode::acknowledge) ||
           exception == static_cast<int>(wire::ExceptionCode::server_device_busy);
}

std::string_view name(ProbeEnd end) {
    switch (end) {
        case ProbeEnd::complete: return "complete";
        case ProbeEnd::out_of_requests: return "out_of_requests";
        case ProbeEnd::stopped: return "stopped";
        case ProbeEnd::no_function: return "no_function";
        case ProbeEnd::no_answer: return "no_answer";
        case ProbeEnd::fell_silent: return "fell_silent";
    }
    return "stopped";
}

bool is_whole(ProbeEnd end) {
    return end == ProbeEnd::complete || end == ProbeEnd::no_function || end == ProbeEnd::no_answer;
}

std::string ranges_text(const std::vector<model::ItemRange>& ranges) {
    std::string text;
    for (const auto& [first, last] : ranges)
        text += (text.empty() ? "" : ", ") +
                (first == last ? std::to_string(first) : fmt::format("{}..{}", first, last));
    return text;
}

std::size_t items(const std::vector<model::ItemRange>& ranges) {
    std::size_t count = 0;
    for (const auto& range : ranges) count += std::size_t{range.last} - range.first + 1;
    return count;
}

class Probe {
public:
    Probe(const Texts& texts, const ProbeOptions& options)
        : texts_(texts), options_(options), start_(line::now()), progress_(texts, start_) {}

    ExitCode run() {
        auto opened = Client::open(options_);
        if (!opened) return ended_by(texts_, opened.error());
        client_ = *std::move(opened);
        if (!answers()) {
            if (!client_->interrupted()) return ended_by(texts_, no_answer_);
            stopped_ = true;
            report();
            return code();
        }
        const auto& wanted = options_.areas;
        for (const auto area : kAllAreas) {
            if (!wanted.empty() && std::ranges::find(wanted, area) == wanted.end()) continue;
            look_through(area);
            if (stopped_) break;
        }
        progress_.clear();
        report();
        return code();
    }

private:
    struct AreaResult {
        Area area;
        std::uint16_t step;
        discover::ProbeResult found;
    };

    // Any answer will do; without one the search would be a series of time-outs.
    bool answers() {
        for (const auto area : kAllAreas) {
            const auto request =
                wire::prepare(wire::ReadRequest{wire::read_function(area), DataAddress{options_.first}, 1});
            const auto answer = request ? client_->transact(*request)
                                        : Result<wire::ResponseView>(std::unexpected(request.error()));
            if (answer) return true;
            no_answer_ = answer.error();
            if (client_->interrupted()) return false;
        }
        return false;
    }

    ProbeReply ask(wire::Function function, const discover::ProbeRead& read) {
        const auto request = wire::prepare(wire::ReadRequest{function, DataAddress{read.start}, read.quantity});
        if (!request) return ProbeReply::refused;
        int links = 0;
        for (int busy = 0;;) {
            const auto answer = client_->transact(*request);
            if (client_->interrupted()) return ProbeReply::stop;
            if (!answer) {
                if (answer.error().code == Code::timed_out || answer.error().code == Code::bad_checksum)
                    return ProbeReply::silent;
                if (answer.error().code == Code::unexpected_reply) return ProbeReply::refused;
                if (++links > kReconnects) return give_up(answer.error());
                client_->pause(kReconnectPause);
                continue;
            }
            if (!answer->is_exception()) return ProbeReply::values;
            const int exception = answer->exception();
            if (is_busy(exception) && ++busy < kBusyTries) {
                client_->pause(kBusyPause);
                continue;
            }
            ++exceptions_[exception];
            return exception == 1 ? ProbeReply::no_function : ProbeReply::refused;
        }
    }

    ProbeReply give_up(const Error& error) {
        lost_ = error;
        return ProbeReply::stop;
    }

    [[nodiscard]] std::uint16_t step_of() const {
        if (options_.step) return *options_.step;
        const std::size_t addresses = std::size_t{options_.last} - options_.first + 1;
        std::size_t step = 1;
        while (addresses / step > options_.max_requests / 2 && step < 0x4000) step *= 2;
        return static_cast<std::uint16_t>(step);
    }

    void look_through(Area area) {
        const auto function = wire::read_function(area);
        discover::ProbeConfig config;
        config.first = options_.first;
        config.last = options_.last;
        config.most = static_cast<std::uint16_t>(wire::max_items(wire::Framing::tcp, function));
        config.step = step_of();
        config.max_requests = options_.max_requests;
        const std::size_t expected =
            std::min(options_.max_requests, discover::most_probe_requests(config, 0, 0, 1));
        std::size_t asked = 0;
        const auto result = discover::probe_ranges(config, [&](const discover::ProbeRead& read) {
            const auto reply = ask(function, read);
            ++asked;
            progress_.show(line::now(), {std::min(asked, expected), expected, client_->transmissions()},
                           fmt::format("{} {}", wire::name(area), read.start));
            return reply;
        });
        stopped_ = result.end == ProbeEnd::stopped || result.end == ProbeEnd::fell_silent;
        results_.push_back({area, config.step, result});
    }

    [[nodiscard]] std::size_t requests() const {
        std::size_t count = 0;
        for (const auto& result : results_) count += result.found.requests;
        return count;
    }

    void report() const {
        if (options_.json) print(json().dump() + "\n");
        if (options_.yaml) print(yaml());
        if (!options_.json && !options_.yaml) print(text());
        for (const auto& result : results_) remark(result);
        print_status(texts_("app.probe.summary", {{"requests", std::to_string(requests())},
                                                  {"sent", std::to_string(client_->transmissions())},
                                                  {"time", rough_time(line::now() - start_)}}) +
                     '\n');
        if (lost_) print_error(texts_.describe(*lost_));
        if (client_->interrupted()) print_status(texts_("app.interrupted") + '\n');
    }

    void remark(const AreaResult& result) const {
        const auto& found = result.found;
        const Texts::Arguments arguments{{"area", std::string(wire::name(result.area))},
                                         {"step", std::to_string(result.step)},
                                         {"longest", std::to_string(found.longest)},
                                         {"next", std::to_string(found.next)},
                                         {"requests", std::to_string(found.requests)}};
        if (found.end != ProbeEnd::complete && found.end != ProbeEnd::stopped)
            print_status(texts_(fmt::format("app.probe.{}", name(found.end)), arguments) + '\n');
        if (found.limited) print_status(texts_("app.probe.limited", arguments) + '\n');
        if (found.end == ProbeEnd::complete && result.step > 1)
            print_status(texts_("app.probe.step", arguments) + '\n');
    }

    [[nodiscard]] std::string text() const {
        std::string text;
        for (const auto& result : results_)
            for (const auto& range : result.found.readable)
                text += fmt::format("{} {}\n", wire::name(result.area), ranges_text({range}));
        return text;
    }

    [[nodiscard]] std::string yaml() const {
        std::string text;
        std::size_t registers = 0;
        for (const auto& result : results_) {
            const auto& found = result.found;
            if (!found.readable.empty())
                text += fmt::format("  {}: [{}]\n", wire::name(result.area), ranges_text(found.readable));
            if (!is_bit_area(result.area) && found.limited && found.longest >= 2)
                registers = registers == 0 ? found.longest : std::min<std::size_t>(registers, found.longest);
        }
        if (text.empty()) return {};
        text = "readable:\n" + text;
        if (registers > 0) text += fmt::format("registers_per_request: {}\n", registers);
        return text;
    }

    [[nodiscard]] file::Json area_json(const AreaResult& result) const {
        const auto& found = result.found;
        auto ranges = file::Json::array();
        for (const auto& range : found.readable)
            ranges.push_back(file::Json(file::Json::Array{range.first, range.last}));
        auto object = file::Json::object();
        object.set("area", wire::name(result.area));
        object.set("function", static_cast<int>(wire::read_function(result.area)));
        object.set("end", name(found.end));
        object.set("ranges", std::move(ranges));
        object.set("items", static_cast<std::uint64_t>(items(found.readable)));
        object.set("longest_read", found.longest);
        object.set("limited", found.limited);
        object.set("step", result.step);
        object.set("requests", static_cast<std::uint64_t>(found.requests));
        object.set("next", found.next > 65535 ? file::Json() : file::Json(found.next));
        return object;
    }

    [[nodiscard]] file::Json json() const {
        auto areas = file::Json::array();
        auto readable = file::Json::object();
        for (const auto& result : results_) {
            areas.push_back(area_json(result));
            if (!result.found.readable.empty())
                readable.set(wire::name(result.area), ranges_text(result.found.readable));
        }
        auto exceptions = file::Json::object();
        for (const auto& [code, count] : exceptions_) exceptions.set(std::to_string(code), count);
        auto object = file::Json::object();
        object.set("target", options_.target);
        object.set("unit", options_.unit);
        object.set("areas", std::move(areas));
        object.set("readable", std::move(readable));
        object.set("exceptions", std::move(exceptions));
        object.set("requests", static_cast<std::uint64_t>(requests()));
        object.set("transmissions", client_->transmissions());
        object.set("duration_ms", (line::now() - start_) / 1ms);
        object.set("complete", whole());
        return object;
    }

    [[nodiscard]] bool whole() const {
        return !stopped_ &&
               std::ranges::all_of(results_, [](const auto& r) { return is_whole(r.found.end); });
    }

    [[nodiscard]] ExitCode code() const {
        if (!whole()) return ExitCode::partly;
        const bool any =
            std::ranges::any_of(results_, [](const auto& result) { return !result.found.readable.empty(); });
        return any ? ExitCode::ok : ExitCode::no;
    }

    Texts texts_;
    const ProbeOptions& options_;
    Instant start_;
    Progress progress_;
    std::unique_ptr<Client> client_;
    std::vector<AreaResult> results_;
    std::map<int, std::uint64_t> exceptions_;
    std::optional<Error> lost_;
    Error no_answer_;
    bool stopped_ = false;
};

}  // namespace

ExitCode probe(const CommonOptions& common, const ProbeOptions& options) {
    const Texts texts(common.language);
    if (options.first > options.last) {
        print_error(
            texts.describe(fail(Code::out_of_range, "--to", options.last, options.first, 65535).error()));
        return ExitCode::usage;
    }
    return Probe(texts, options).run();
}

}  // namespace takt::app
