// Who tells the user what happens while a project runs: as JSON lines, as text lines, or in place on a
// terminal.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "takt/app/answer.hpp"
#include "takt/app/texts.hpp"
#include "takt/os/record_writer.hpp"
#include "takt/poll/master.hpp"

namespace takt::app {

/// The running project, as reporters look at it. All of it outlives them.
struct Scene {
    const model::Project& project;
    const plan::Plan& plan;
    const poll::Master& master;
    Instant start;  ///< when the run began
};

/// How the period of a request is held.
struct Overrun {
    Duration period{};
    Duration real{};
    bool overrun = false;  ///< false: it holds again
};

/// A value that was to be written, and was not, or not for sure.
struct Unwritten {
    value::SlotId slot;
    value::CommandResult result{};
    value::Reason reason{};
    std::string wanted;  ///< as text
};

/// Told of what happens, on the I/O thread, outside the engines' calls. Must not block.
class Reporter {
public:
    virtual ~Reporter() = default;

    virtual void on_value(const value::Event& event) = 0;
    /// Value events that were overwritten before they could be told.
    virtual void on_missed(std::uint64_t events) = 0;
    virtual void on_device(Instant t, std::size_t line, std::size_t device, poll::DeviceState state) = 0;
    /// Of a request of the plan that ran then; it may be another one by now.
    virtual void on_overrun(Instant t, std::size_t line, const plan::Request& request,
                            const Overrun& overrun) = 0;
    virtual void on_write_waiting(Instant t, std::size_t line, const plan::Request& request,
                                  std::size_t variable) = 0;
    virtual void on_learnt(Instant t, std::size_t line, const poll::GapEvent& lesson) = 0;
    /// A variable was read back as another value than was written to it.
    virtual void on_verify_failed(Instant t, value::SlotId slot, const value::Value& written,
                                  const value::Value& read) = 0;
    /// Whoever asked for it. `answer` is what who asked was told.
    virtual void on_unwritten(Instant t, const Unwritten& what, const Answer& answer) = 0;
    virtual void on_link(Instant t, std::size_t line, bool up, const std::optional<Error>& why) = 0;
    /// The answer to a command that came on standard input.
    virtual void on_answer(Instant t, const Answer& answer) = 0;
    /// About five times a second.
    virtual void refresh(Instant t) = 0;
    /// The last call: the summary.
    virtual void end(Instant t) = 0;
};

[[nodiscard]] std::unique_ptr<Reporter> make_json_reporter(const Scene& scene, const Texts& texts,
                                                           os::LineWriter& out);
[[nodiscard]] std::unique_ptr<Reporter> make_line_reporter(const Scene& scene, const Texts& texts,
                                                           os::LineWriter& out);
/// For a terminal on stdout.
[[nodiscard]] std::unique_ptr<Reporter> make_live_reporter(const Scene& scene, const Texts& texts,
                                                           os::LineWriter& out);

/// A value as people read it: text, unit, and why it is not good.
[[nodiscard]] std::string shown_value(const Scene& scene, value::SlotId slot, const value::Value& value);

/// Name of the device a slot belongs to; empty for locals.
[[nodiscard]] std::string device_name(const Scene& scene, value::SlotId slot);
[[nodiscard]] std::string line_name(const Scene& scene, value::SlotId slot);

/// Why a value is not good, in JSON: "timeout", "exception 2"; empty for good ones.
[[nodiscard]] std::string reason_text(value::Reason reason);

/// What happened to a line or a request, in words.
[[nodiscard]] std::string overrun_text(const Scene& scene, const Texts& texts, std::size_t line,
                                       const plan::Request& request, const Overrun& overrun);
[[nodiscard]] std::string unwritten_text(const Scene& scene, const Texts& texts, const Unwritten& what);
[[nodiscard]] std::string write_waiting_text(const Scene& scene, const Texts& texts, std::size_t line,
                                             const plan::Request& request, std::size_t variable);
[[nodiscard]] std::string verify_failed_text(const Scene& scene, const Texts& texts, value::SlotId slot,
                                             const value::Value& written, const value::Value& read);
[[nodiscard]] std::string link_text(const Scene& scene, const Texts& texts, std::size_t line, bool up,
                                    const std::optional<Error>& why);

}  // namespace takt::app
