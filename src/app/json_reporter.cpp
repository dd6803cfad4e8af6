// Everything as a JSON object a line (docs/commands/run.md).
#include <utility>

#include "takt/app/reporter.hpp"
#include "takt/app/summary.hpp"
#include "takt/report/value_json.hpp"

namespace takt::app {
namespace {

double milliseconds(Duration duration) {
    return static_cast<double>(duration.count()) / 1e6;
}

class JsonReporter final : public Reporter {
public:
    JsonReporter(const Scene& scene, const Texts& texts, os::LineWriter& out)
        : scene_(scene), texts_(texts), out_(out) {}

    void on_value(const value::Event& event) override {
        const auto& info = scene_.master.store().info(event.slot);
        const auto& slot = scene_.master.store()[event.slot];
        auto object = begin("value", event.t);
        object.set("line", line_name(scene_, event.slot));
        object.set("device", device_name(scene_, event.slot));
        object.set("name", info.name);
        object.set("value", report::to_json(info.type, info.scaled, event.value));
        object.set("quality", value::name(event.quality));
        object.set("reason", reason_text(event.reason));
        object.set("age_ms", slot.good_at
                                 ? file::Json(milliseconds(std::max(Duration{}, event.t - *slot.good_at)))
                                 : file::Json());
        put(object);
    }

    void on_missed(std::uint64_t events) override {
        auto object = file::Json::object();
        object.set("event", "gap");
        object.set("missed", events);
        put(object);
    }

    void on_device(Instant t, std::size_t line, std::size_t device, poll::DeviceState state) override {
        auto object = begin("device", t);
        object.set("line", scene_.project.lines[line].name);
        object.set("device", scene_.project.lines[line].devices[device].name);
        object.set("state", poll::name(state));
        put(object);
    }

    void on_overrun(Instant t, std::size_t line, const plan::Request& request,
                    const Overrun& overrun) override {
        auto object = begin("overrun", t);
        name_request(object, line, request);
        object.set("period_ms", milliseconds(overrun.period));
        object.set("real_period_ms", milliseconds(overrun.real));
        object.set("overrun", overrun.overrun);
        put(object);
    }

    void on_write_waiting(Instant t, std::size_t line, const plan::Request& request,
                          std::size_t variable) override {
        auto object = begin("write_waiting", t);
        name_request(object, line, request);
        object.set("name", scene_.project.lines[line].devices[request.device].variables[variable].name);
        put(object);
    }

    void on_learnt(Instant t, std::size_t line, const poll::GapEvent& lesson) override {
        auto object = begin("learnt", t);
        object.set("line", scene_.project.lines[line].name);
        object.set("device", scene_.project.lines[line].devices[lesson.device].name);
        object.set("function", static_cast<int>(lesson.read));
        object.set("first", lesson.items.first);
        object.set("last", lesson.items.last);
        object.set("result", poll::name(lesson.kind));
        object.set("exception", lesson.exception > 0 ? file::Json(lesson.exception) : file::Json());
        put(object);
    }

    void on_verify_failed(Instant t, value::SlotId slot, const value::Value& written,
                          const value::Value& read) override {
        const auto& info = scene_.master.store().info(slot);
        auto object = begin("verify_failed", t);
        object.set("line", line_name(scene_, slot));
        object.set("device", device_name(scene_, slot));
        object.set("name", info.name);
        object.set("written", report::to_json(info.type, info.scaled, written));
        object.set("read", report::to_json(info.type, info.scaled, read));
        put(object);
    }

    void on_unwritten(Instant t, const Unwritten&, const Answer& answer) override { on_answer(t, answer); }

    void on_link(Instant t, std::size_t line, bool up, const std::optional<Error>& why) override {
        auto object = begin("link", t);
        object.set("line", scene_.project.lines[line].name);
        object.set("up", up);
        if (why) object.set("text", texts_.describe(*why));
        put(object);
    }

    void on_answer(Instant t, const Answer& answer) override {
        auto object = to_json(answer);
        object.set("time_ms", milliseconds(t - scene_.start));
        put(object);
    }

    void refresh(Instant) override {}

    void end(Instant t) override { out_.put_last(summary_json(scene_, t).dump() + '\n'); }

private:
    [[nodiscard]] file::Json begin(const char* event, Instant t) const {
        auto object = file::Json::object();
        object.set("event", event);
        object.set("time_ms", milliseconds(t - scene_.start));
        return object;
    }

    void name_request(file::Json& object, std::size_t line, const plan::Request& planned) const {
        object.set("line", scene_.project.lines[line].name);
        object.set("device", scene_.project.lines[line].devices[planned.device].name);
        object.set("function", static_cast<int>(planned.read ? *planned.read : *planned.write));
        object.set("start", planned.start);
    }

    void put(const file::Json& object) { out_.put(object.dump() + '\n'); }

    Scene scene_;
    Texts texts_;
    os::LineWriter& out_;
};

}  // namespace

std::unique_ptr<Reporter> make_json_reporter(const Scene& scene, const Texts& texts, os::LineWriter& out) {
    return std::make_unique<JsonReporter>(scene, texts, out);
}

}  // namespace takt::app
