// A history made by hand for the judge: one RTU line at 19200 8E1 with two devices, and its events.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "judge/line_judge.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/value/project_slots.hpp"
#include "topology.hpp"

namespace takt::simtest {

using namespace std::chrono_literals;

/// Device 1: `v` and `w` (holding registers 0 and 1, polled each second, written on change as one group), `x`
/// (input register 10, each two seconds), `s` (holding register 20, written by command), `p` and `q` (holding
/// registers 30 and 31, written by command and verified); device 2: `y` (input register 0, each four
/// seconds) and `z` (holding register 50, written by command and verified); device 3: `a` and `b` (bits 0 and
/// 1 of holding register 40, written on change by one read-modify-write and verified; only `a` is safe to
/// repeat). Locals: `on` enables device 2.
class Story {
public:
    Story();

    void link(Duration when, bool up) { judge_->on_link(at(when), up); }
    /// A request with that PDU; its end is kept for the answers. The claimed purpose is `purpose`, a write
    /// for `command` or for a group.
    void ask(Duration when, std::uint8_t unit, std::vector<std::uint8_t> pdu,
             poll::Purpose purpose = poll::Purpose::period, std::optional<value::CommandId> command = {},
             bool early = false);
    /// A probe before its back-off has passed.
    void probe_early(Duration when, std::uint8_t unit, std::vector<std::uint8_t> pdu);
    /// The device has looked at its registers at the end of the request.
    void serve(wire::Area area, std::uint16_t start, std::vector<std::uint16_t> values);
    void execute(std::uint16_t start, std::vector<std::uint16_t> values);
    /// The device will confirm a write that it did not execute.
    void ignore();
    /// The answer arrives 5 ms plus its own length after the end of the request.
    void answer(std::vector<std::uint8_t> pdu);
    void show(const std::string& name, std::int64_t value, value::Quality quality = value::Quality::good);
    /// It was read at `read` and is shown later.
    void show_held(Duration when, Duration read, const std::string& name, std::int64_t value);
    /// Since the begin: now.
    [[nodiscard]] Duration now() const { return now_ - Instant{}; }
    void look(Duration when);
    /// A whole read of one register that went well.
    void read(Duration when, std::uint8_t unit, std::uint8_t function, std::uint16_t start,
              const std::string& name, std::uint16_t value);

    void set(Duration when, const std::string& name, std::int64_t value);
    void command(Duration when, value::CommandId id, const std::string& name, std::int64_t value,
                 std::optional<Duration> expires = {});
    void outcome(Duration when, value::CommandId id, value::CommandResult result,
                 value::Reason reason = value::Reason::ok);
    void enable(Duration when, bool on) { judge_->on_local(at(when), 0, !on, on); }
    void finish(Duration when) { judge_->finish(at(when), store_, first_slot_); }

    [[nodiscard]] std::string complaint() const;  ///< the first invariant; empty: none
    [[nodiscard]] std::string text() const;
    /// The engine reports that everything sent has ended, or not.
    bool engine_ends = true;

private:
    [[nodiscard]] static Instant at(Duration since) { return Instant{} + since; }
    [[nodiscard]] std::optional<std::size_t> request_of(std::uint8_t unit,
                                                        const std::vector<std::uint8_t>& pdu,
                                                        poll::Purpose purpose) const;
    [[nodiscard]] value::SlotId slot(const std::string& name) const { return *store_.find(name); }
    [[nodiscard]] judge::VariableNumber number(const std::string& name) const {
        return slot(name).value - first_slot_;
    }

    model::Project project_;
    plan::Plan plan_;
    std::vector<plan::LineGuarantee> guarantees_;
    judge::Complaints complaints_;
    judge::Case case_{project_, plan_, guarantees_};
    value::Store store_{{}};
    std::uint32_t first_slot_ = 0;
    std::unique_ptr<judge::LineJudge> judge_;
    std::uint8_t unit_ = 0;
    Instant end_;
    Instant now_;
    std::vector<std::uint64_t> sent_{0, 0, 0};
};

}  // namespace takt::simtest
