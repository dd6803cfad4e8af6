#include "takt/app/answer.hpp"

namespace takt::app {
namespace {

void append(std::string& line, const std::string& word) {
    if (!word.empty()) line += ' ' + word;
}

}  // namespace

std::string to_line(const Answer& answer) {
    std::string line;
    switch (answer.kind) {
        case Answer::Kind::ok:
            line = "ok";
            append(line, answer.name);
            append(line, answer.value);
            append(line, answer.quality);
            append(line, answer.waiting);
            break;
        case Answer::Kind::error:
            line = "error";
            append(line, answer.code);
            append(line, answer.text);
            break;
        case Answer::Kind::outcome:
            line = answer.outcome;
            append(line, answer.name);
            append(line, answer.reason);
            if (!answer.read_back.empty())
                line += " written " + answer.written + " read " + answer.read_back;
            else if (answer.outcome != "done")
                line += " wanted " + answer.wanted;
            break;
    }
    if (answer.rounded) line += " rounded";
    if (answer.not_retained) line += " not_retained";
    return line + '\n';
}

file::Json to_json(const Answer& answer) {
    auto object = file::Json::object();
    const auto set_known = [&object](const char* key, const std::string& text) {
        if (!text.empty()) object.set(key, text);
    };
    switch (answer.kind) {
        case Answer::Kind::ok: object.set("event", "answer"); break;
        case Answer::Kind::error: object.set("event", "error"); break;
        case Answer::Kind::outcome: object.set("event", "outcome"); break;
    }
    set_known("command", answer.command);
    if (answer.id > 0) object.set("id", answer.id);
    set_known("line", answer.line);
    set_known("device", answer.device);
    set_known("name", answer.name);
    set_known("value", answer.value);
    set_known("quality", answer.quality);
    if (!answer.waiting.empty()) object.set(answer.waiting, true);
    set_known("outcome", answer.outcome);
    if (answer.kind == Answer::Kind::outcome) object.set("reason", answer.reason);
    set_known("wanted", answer.wanted);
    set_known("written", answer.written);
    set_known("read", answer.read_back);
    if (answer.rounded) object.set("rounded", true);
    if (answer.not_retained) object.set("retained", false);
    set_known("code", answer.code);
    set_known("text", answer.text);
    return object;
}

}  // namespace takt::app
