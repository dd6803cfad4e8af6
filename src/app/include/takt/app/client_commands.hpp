// takt read, takt write and takt raw (docs/commands).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/app/client_options.hpp"
#include "takt/app/common_options.hpp"
#include "takt/app/exit_code.hpp"
#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"

namespace takt::app {

/// Items of one area, for watching.
struct WatchedRange {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;
    std::uint32_t count = 1;
};

struct ReadOptions : ClientOptions {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;
    std::uint32_t count = 1;  ///< values of `type`
    DataType type = DataType::uint16;
    std::uint16_t string_registers = 1;
    ByteOrder order;
    bool registers_only = false;      ///< an option was given that has no meaning for bits
    std::optional<Duration> watch;    ///< read again and again with this period
    std::optional<Duration> run_for;  ///< with `watch`: nothing: until stopped
    bool changes = false;             ///< with `watch`: print changes only
    std::vector<WatchedRange> also;   ///< with `watch`: more than the one range
};

struct WriteOptions : ClientOptions {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;
    std::vector<std::string> values;
    DataType type = DataType::uint16;
    ByteOrder order;
    bool registers_only = false;  ///< as for ReadOptions
    bool multiple = false;        ///< 0x0F / 0x10 also for a single item
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
