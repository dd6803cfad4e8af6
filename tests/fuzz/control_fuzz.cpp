// Arbitrary bytes, cut into arbitrary pieces, as commands of a control client: each command has exactly one
// answer, and each answer is one printable line or one line of JSON.
#include <algorithm>
#include <string>
#include <string_view>

#include "input.hpp"
#include "takt/console/command_reader.hpp"
#include "takt/text/escape.hpp"

namespace {

using namespace takt;

void require_one_line(std::string_view line) {
    fuzz::require(line.ends_with('\n'));
    line.remove_suffix(1);
    if (file::Json::parse(line))
        fuzz::require(line.find('\n') == std::string_view::npos);
    else
        fuzz::require(text::escape_line(line) == line);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Input input({data, size});
    const report::Texts texts(static_cast<text::Language>(input.byte() % 3));
    std::size_t answers = 0;
    const console::Reply reply = [&](const console::Answer& answer) {
        require_one_line(answer.line);
        fuzz::require(!answer.json.dump().empty());
        ++answers;
    };
    console::CommandReader reader(
        [](const std::string& line, const console::Reply& to, const report::Texts& of_line) -> Result<void> {
            TAKT_TRY(const auto command, console::parse_control(line));
            fuzz::require(line.size() <= console::LineSplitter::kMaxLine);
            to(console::error_answer(of_line, fail(Code::not_found, command.name).error()));
            return {};
        },
        texts);
    std::size_t commands = 0;
    while (!input.empty()) {
        const Bytes piece = input.bytes(1 + input.byte());
        commands += reader.feed({reinterpret_cast<const char*>(piece.data()), piece.size()}, reply);
    }
    commands += reader.end(reply);
    fuzz::require(commands == answers);
    return 0;
}
