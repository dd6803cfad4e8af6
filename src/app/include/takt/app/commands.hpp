// What the command line asks for, one structure a command, and the commands themselves. docs/commands is
// their contract.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/app/exit_code.hpp"
#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/endpoint/blank_spec.hpp"
#include "takt/endpoint/overrides.hpp"
#include "takt/file/table.hpp"
#include "takt/model/project.hpp"
#include "takt/sim/answer_faults.hpp"
#include "takt/text/language.hpp"
#include "takt/wire/function.hpp"

namespace takt::app {

struct CommonOptions {
    text::Language language = text::Language::english;
    std::string log_file;
    std::string log_level = "info";
};

struct CheckOptions {
    std::string file;
    bool json = false;
    bool prove = false;  ///< late values are errors, whatever is known
};

struct PlanOptions {
    std::string file;
    bool json = false;
    bool compare = false;
    std::string svg;     ///< file for the picture; "-": stdout instead of the text; empty: none
    bool prove = false;  ///< as for CheckOptions
    bool fix = false;    ///< plan again with the settings that change only the plan
};

struct RunOptions {
    std::string file;
    std::string table;                ///< a request table instead of a project file
    std::string place;                ///< with a table of one line: another serial port, or host:port
    std::optional<Duration> run_for;  ///< nothing: until stopped
    bool json = false;
    std::string traffic;  ///< file for the frames; "-": stderr; empty: none
    bool commands_from_stdin = false;
    std::string control_path;  ///< Unix socket for commands; empty: none
    bool learn = true;         ///< devices with gaps: learn are tried
    std::string learnt;        ///< the file that keeps it; empty: none
    std::string state;         ///< file of retained values; empty: beside the project (of the demo: none)
};

struct DemoOptions {
    std::optional<Duration> run_for;
    bool json = false;
};

struct ServeOptions {
    std::string file;    ///< a project whose devices to be; empty: a blank device
    std::string listen;  ///< host:port
    std::string port;    ///< serial port or serial target
    endpoint::BlankSpec blank;
    bool strict = false;  ///< RTU: pauses above t1.5 inside a frame spoil it
    std::optional<Duration> run_for;
    std::string traffic;
    bool json = false;  ///< the summary at the end as one object
    endpoint::LimitOverrides limits;
    std::string access;  ///< file of access rules for all places; empty: those of the project
    std::string audit;   ///< file of writes and refusals at all places; empty: those of the project
    std::string state;   ///< file of the blank device's retained registers; empty: none
    model::Durability durability = model::Durability::acknowledged;  ///< of these
    std::vector<sim::FaultRule> faults;
    std::string control_path;  ///< Unix socket for commands that switch faults; empty: none
};

/// What `read`, `write` and `raw` have in common: whom to ask, and how long to wait.
struct ClientOptions {
    std::string target;
    std::uint8_t unit = 1;
    Duration timeout = std::chrono::seconds(1);
    std::uint16_t attempts = 1;
    bool json = false;
    std::string traffic;
    bool adaptive = false;   ///< the first attempt waits only as long as the answers so far let expect
    bool reconnect = false;  ///< a stream out of step is made anew instead of being the end
};

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
    bool changes = false;             ///< with `watch`: tell changes alone
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

struct ScanOptions {
    std::vector<std::string> targets;
    std::string units = "1-247";
    std::string bauds;     ///< empty: the target's, else the usual ones
    std::string parities;  ///< likewise
    std::string stop_bits;
    std::optional<Duration> timeout;  ///< nothing: 100 ms on serial lines, 1 s elsewhere
    bool first = false;               ///< leave a serial port after the first settings that found something
    bool thorough = false;            ///< ask silent units by other functions too
    bool identify = true;
    bool json = false;
    std::string project;  ///< file for a project of what was found; empty: none
    bool force = false;   ///< overwrite it
    std::string traffic;
};

struct ProbeOptions : ClientOptions {
    std::vector<wire::Area> areas;  ///< empty: all four
    std::uint16_t first = 0;
    std::uint16_t last = 65535;
    std::optional<std::uint16_t> step;  ///< nothing: as fine as half of `max_requests` allows
    std::size_t max_requests = 2000;    ///< of each area
    bool yaml = false;
};

struct TableBuildOptions {
    std::string file;
    std::string output;
    /// Nothing: Takt's own format, which holds any plan. owen_kc1: the project is read as of that profile,
    /// and the table is the controller's.
    std::optional<model::Profile> profile;
    bool no_names = false;  ///< Takt's own format without texts
};

struct TableShowOptions {
    std::string file;
    bool json = false;
};

struct CtlOptions {
    std::string path;
    std::vector<std::string> words;
};

/// What a file is; nothing said: its ending tells.
enum class FileKind : std::uint8_t { by_ending, csv, yaml };

struct ConvertOptions {
    std::string input;
    std::string output;  ///< empty: stdout
    FileKind from = FileKind::by_ending;
    FileKind to = FileKind::by_ending;
    bool force = false;  ///< overwrite what is there
    // of tables
    file::TableOptions reading;
    file::TableFormat writing;
    std::optional<file::Encoding> encoding;  ///< of the one table there is, or of the one that is written
    bool byte_order_mark = false;
    char separator = 0;  ///< likewise
    // of the project around a table
    std::string line = "line";
    std::string device;  ///< also: the only one to be taken
    std::optional<std::uint8_t> unit;
    std::string target = "rtu:///dev/ttyUSB0";
};

ExitCode check(const CommonOptions& common, const CheckOptions& options);
ExitCode convert(const CommonOptions& common, const ConvertOptions& options);
ExitCode plan(const CommonOptions& common, const PlanOptions& options);
ExitCode run(const CommonOptions& common, const RunOptions& options);
ExitCode demo(const CommonOptions& common, const DemoOptions& options);
ExitCode serve(const CommonOptions& common, const ServeOptions& options);
ExitCode read(const CommonOptions& common, const ReadOptions& options);
/// read with `watch` set.
ExitCode watch(const CommonOptions& common, const ReadOptions& options);
ExitCode write(const CommonOptions& common, const WriteOptions& options);
ExitCode raw(const CommonOptions& common, const RawOptions& options);
ExitCode scan(const CommonOptions& common, const ScanOptions& options);
ExitCode probe(const CommonOptions& common, const ProbeOptions& options);
ExitCode table_build(const CommonOptions& common, const TableBuildOptions& options);
ExitCode table_show(const CommonOptions& common, const TableShowOptions& options);
ExitCode ctl(const CommonOptions& common, const CtlOptions& options);

}  // namespace takt::app
