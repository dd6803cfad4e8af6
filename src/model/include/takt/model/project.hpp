// The project as the user describes it (docs/project-file.md; docs/specification.md, sections 1 and 2),
// checked and complete: defaults are filled in and names are resolved to indices.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/model/device.hpp"
#include "takt/model/document.hpp"
#include "takt/model/line.hpp"
#include "takt/model/output.hpp"
#include "takt/model/server.hpp"
#include "takt/model/source.hpp"
#include "takt/wire/frame.hpp"

namespace takt::model {

enum class Profile : std::uint8_t { generic, owen_kc1 };

/// Delays of the computer (docs/guarantees.md, "Model").
struct Host {
    Duration jitter = std::chrono::milliseconds(1);      ///< J: how late a release may be
    Duration overhead = std::chrono::microseconds(200);  ///< H: of each transaction
};

/// Assumed failures: in any window t at most burst + floor(t / every) attempts fail. Burst 0: none.
struct Faults {
    std::uint16_t burst = 1;
    Duration every = std::chrono::seconds(1);
};

/// A value of the project itself: triggers, statuses, enables, constants.
struct Local {
    std::string name;
    SourceLocation location;
    DataType type = DataType::boolean;
    std::optional<Constant> default_value;
    bool retain = false;
    std::optional<RateLimit> admission;  ///< of a trigger
    std::string comment;
    bool service = false;  ///< a service variable that the project uses (service.hpp), after all others
};

struct Project {
    int version = 1;
    Profile profile = Profile::generic;
    bool derive_timeouts = true;
    Duration timeout_margin = std::chrono::milliseconds(2);
    Host host;
    Faults faults;
    bool faults_set = false;  ///< set in the project
    Backoff backoff;
    std::vector<Line> lines;
    std::vector<Server> servers;
    std::vector<Instrument> instruments;
    std::vector<Local> locals;
    std::vector<Output> outputs;
    std::vector<std::string> files;  ///< by the file index of a location

    /// The profile's limits of frames of that framing (docs/specification.md, sections 2 and 3).
    [[nodiscard]] wire::FrameLimits frame_limits() const;
};

std::string_view name(Profile profile);

/// What a device has where the project does not say it (docs/specification.md, section 2). owen-kc1 keeps the
/// defaults of its source. Without a written strategy, grouping is classic in owen-kc1 and optimal in
/// generic.
struct DeviceDefaults {
    Duration poll_period{};
    Duration response_timeout{};
    bool group_requests = true;
    Strategy strategy = Strategy::optimal;  ///< of a device that groups
};
[[nodiscard]] DeviceDefaults device_defaults(Profile profile);

}  // namespace takt::model
