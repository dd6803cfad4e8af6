#include "takt/console/fault_commands.hpp"

#include <sstream>
#include <utility>

#include "takt/value/text.hpp"

namespace takt::console {
namespace {

constexpr std::string_view kUsage = "fault add FAULT, fault clear, fault list, quit";
constexpr std::string_view kFaults =
    "silence, delay=50ms..2s, exception=1..255, bad_crc, wrong_unit, cut; :10% or @10s behind it";

Answer in_force(const sim::AnswerFaults& faults) {
    std::string rules;
    auto list = file::Json::array();
    for (const auto& rule : faults.rules()) {
        rules += ' ' + sim::to_text(rule);
        list.push_back(sim::to_text(rule));
    }
    auto object = file::Json::object();
    object.set("event", "answer");
    object.set("command", "fault");
    object.set("faults", std::move(list));
    return {.line = "ok" + rules + '\n', .json = std::move(object)};
}

Result<void> add(sim::AnswerFaults& faults, Instant now, const std::string& text) {
    const auto rule = sim::parse_fault(text);
    if (!rule) return fail(Code::syntax, value::beside_allowed(text, kFaults));
    if (!faults.add(now, *rule)) return fail(Code::queue_full, sim::AnswerFaults::kMost);
    return {};
}

}  // namespace

Execute fault_commands(std::shared_ptr<sim::AnswerFaults> faults, std::function<Instant()> now,
                       std::function<void()> quit) {
    return [faults = std::move(faults), now = std::move(now), quit = std::move(quit)](
               const std::string& line, const Reply& reply) -> Result<void> {
        std::istringstream stream(line);
        std::string command;
        std::string verb;
        std::string fault;
        std::string more;
        stream >> command >> verb >> fault >> more;
        if (command == "quit" && verb.empty()) {
            reply(quit_answer());
            quit();
            return {};
        }
        const bool adds = verb == "add" && !fault.empty() && more.empty();
        const bool whole = adds || ((verb == "clear" || verb == "list") && fault.empty());
        if (command != "fault" || !whole) return fail(Code::syntax, value::beside_allowed(line, kUsage));
        if (adds) TAKT_CHECK(add(*faults, now(), fault));
        if (verb == "clear") faults->clear();
        reply(in_force(*faults));
        return {};
    };
}

}  // namespace takt::console
