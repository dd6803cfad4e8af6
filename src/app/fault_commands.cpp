#include "fault_commands.hpp"

#include <sstream>
#include <utility>

#include "takt/value/text.hpp"

namespace takt::app {
namespace {

constexpr std::string_view kUsage = "fault add FAULT, fault clear, fault list, quit";
constexpr std::string_view kFaults =
    "silence, delay=50ms..2s, exception=1..255, bad_crc, wrong_unit, cut; :10% or @10s behind it";

Answer in_force(const sim::AnswerFaults& faults) {
    std::string rules;
    for (const auto& rule : faults.rules()) rules += ' ' + sim::to_text(rule);
    return {.line = "ok" + rules + '\n', .json = {}};
}

Result<void> add(sim::AnswerFaults& faults, const std::string& text) {
    const auto rule = sim::parse_fault(text);
    if (!rule) return fail(Code::syntax, value::beside_allowed(text, kFaults));
    if (!faults.add(line::now(), *rule)) return fail(Code::queue_full, sim::AnswerFaults::kMost);
    return {};
}

}  // namespace

Execute fault_commands(line::Loop& loop, std::shared_ptr<sim::AnswerFaults> faults) {
    return [&loop, faults = std::move(faults)](const std::string& line, const Reply& reply) -> Result<void> {
        std::istringstream stream(line);
        std::string command;
        std::string verb;
        std::string fault;
        std::string more;
        stream >> command >> verb >> fault >> more;
        if (command == "quit" && verb.empty()) {
            reply(quit_answer());
            loop.stop();
            return {};
        }
        const bool adds = verb == "add" && !fault.empty() && more.empty();
        const bool whole = adds || ((verb == "clear" || verb == "list") && fault.empty());
        if (command != "fault" || !whole) return fail(Code::syntax, value::beside_allowed(line, kUsage));
        if (adds) TAKT_CHECK(add(*faults, fault));
        if (verb == "clear") faults->clear();
        reply(in_force(*faults));
        return {};
    };
}

}  // namespace takt::app
