// takt read, takt write and takt raw (docs/commands).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commands/client_options.hpp"
#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/base/time.hpp"
#include "takt/client/values.hpp"
#include "takt/client/watch.hpp"

namespace takt::app {

struct ItemOptions : ClientOptions {
    bool as_bool = false;         ///< --type bool: the first item may be the register of a table
    bool registers_only = false;  ///< an option was given that has no meaning for bits
};

struct ReadOptions : ItemOptions {
    client::ReadSpec spec;
    bool count_given = false;
    bool all_types = false;                  ///< every type side by side; `spec.count` counts registers
    std::optional<Duration> watch;           ///< read again and again with this period
    std::optional<Duration> run_for;         ///< with `watch`: nothing: until stopped
    bool changes = false;                    ///< with `watch`: print changes only
    std::vector<client::WatchedRange> also;  ///< with `watch`: more than the one range
};

struct WriteOptions : ItemOptions {
    client::WriteSpec spec;
};

struct RawOptions : ClientOptions {
    std::vector<std::string> bytes;  ///< the PDU as hexadecimal text
};

ExitCode read(const CommonOptions& common, const ReadOptions& options);
/// read with `watch` set.
ExitCode watch(const CommonOptions& common, const ReadOptions& options);
ExitCode write(const CommonOptions& common, const WriteOptions& options);
ExitCode raw(const CommonOptions& common, const RawOptions& options);

}  // namespace takt::app
