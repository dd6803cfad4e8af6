// A plan as tables of text and as JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "takt/base/time.hpp"
#include "takt/file/json.hpp"
#include "takt/host/project_file.hpp"
#include "takt/plan/applied_measures.hpp"
#include "takt/plan/plan.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/report/plans/guarantee_report.hpp"

namespace takt::report {

/// The figures of a request that a table shows.
enum class Figures : std::uint8_t {
    usual,  ///< bus time, share of the line, greatest age of its values
    proof,  ///< C, R, D and that age (docs/guarantees.md, "Figures")
};

struct TableStyle {
    Figures figures = Figures::usual;
    std::size_t columns = SIZE_MAX;  ///< of the terminal; names are cut so that rows fit
};

/// A table of requests for each line. Below each request is the reason for its last item. A legend is at the
/// end.
/// @param guarantees  one for each line; empty: without proved figures
[[nodiscard]] std::string plan_text(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                                    std::span<const plan::LineGuarantee> guarantees = {},
                                    const TableStyle& style = {});

/// "rs485-1 (rtu, 38400 bit/s): 7 requests instead of 13, …"
[[nodiscard]] std::string line_heading(const Texts& texts, const model::Project& project,
                                       const plan::LinePlan& planned);

/// What makes a master send a request. An empty name: no trigger.
struct RequestCauses {
    std::optional<Duration> period;
    Duration phase{};
    std::string read_trigger;
    bool on_change = false;
    std::string write_trigger;
};

/// "1000 ms +300, on change": the causes, separated by commas; empty if there are none.
[[nodiscard]] std::string causes_text(const Texts& texts, const RequestCauses& causes);

/// The causes of a request: its period, its triggers, changes of its values.
[[nodiscard]] std::string when_text(const Texts& texts, const model::Project& project,
                                    const plan::Request& request);

/// The names of a request's variables. Of more than four: the first three, the last and their number.
[[nodiscard]] std::string variables_text(const model::Device& device, const plan::Request& request);

/// The object that `takt plan --json` prints (docs/commands/plan.md).
/// @param proof    of the project
/// @param applied  nullptr: no measures were applied
/// @param compare  as for plan_json()
[[nodiscard]] file::Json project_plan_json(const Texts& texts, const host::LoadedProject& loaded,
                                           const plan::Proof& proof, const plan::AppliedMeasures* applied,
                                           bool compare);

/// The same for a project that has no plan, because it has errors.
[[nodiscard]] file::Json no_plan_json(const Texts& texts, const host::LoadedProject& loaded);

/// The list "lines" of that object.
/// @param proof    of that plan
/// @param compare  add "compare" to each line: the cost under each strategy
[[nodiscard]] file::Json plan_json(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                                   const plan::Proof& proof, bool compare);

/// The plan before and after the measures, and the changes to write into the project file.
/// @param proof  of the project before
[[nodiscard]] std::string applied_text(const Texts& texts, const model::Project& before,
                                       const plan::Proof& proof, const plan::AppliedMeasures& applied,
                                       const TableStyle& style = {});

/// {"changes", "lines"}
[[nodiscard]] file::Json applied_json(const Texts& texts, const plan::AppliedMeasures& applied);

}  // namespace takt::report
