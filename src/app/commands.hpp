// The commands of the program, each with its options (docs/commands). The options of the command line fill
// them in (options/).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "exit_code.hpp"
#include "online/realtime_mode.hpp"
#include "takt/base/network.hpp"
#include "takt/base/time.hpp"
#include "takt/capture/latency.hpp"
#include "takt/client/load.hpp"
#include "takt/client/options.hpp"
#include "takt/client/values.hpp"
#include "takt/client/watch.hpp"
#include "takt/console/capture_file.hpp"
#include "takt/endpoint/overrides.hpp"
#include "takt/file/table.hpp"
#include "takt/line/target.hpp"
#include "takt/model/project.hpp"
#include "takt/sim/answer_faults.hpp"
#include "takt/sim/fill.hpp"
#include "takt/text/language.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/function.hpp"

namespace takt::app {

/// The options that every command has.
struct CommonOptions {
    text::Language language = text::Language::english;
    std::string log_file;
    std::string log_level = "info";
};

/// The options of the commands that address one device.
struct ClientOptions : client::Options {
    bool json = false;
    std::string traffic;  ///< file for the frames; "-": stderr; empty: none
};

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

struct CaptureOptions {
    std::string target;     ///< URL of a serial port; empty: an interface
    std::string interface;  ///< network interface; empty: a serial port
    console::CaptureFileOptions file;
    std::optional<Duration> run_for;  ///< nothing: until stopped
};

/// Records what passes on a serial line or a network interface, and sends nothing.
ExitCode capture(const CommonOptions& common, const CaptureOptions& options);

struct CheckOptions {
    std::string file;
    bool json = false;
    bool no_notes = false;
    bool firmware = false;  ///< the file describes a microcontroller
    bool prove = false;     ///< late values are errors, also where a turnaround is not known
};

ExitCode check(const CommonOptions& common, const CheckOptions& options);

/// The kind of a file; by default its name ends with it.
enum class FileKind : std::uint8_t { by_ending, csv, yaml, markdown };

struct ConvertOptions {
    std::vector<std::string> inputs;  ///< several: tables of one project
    std::string output;               ///< empty: stdout
    FileKind from = FileKind::by_ending;
    FileKind to = FileKind::by_ending;
    bool force = false;  ///< overwrite what is there
    // of tables
    file::TableKind table = file::TableKind::variables;  ///< of a project: which one
    bool table_given = false;
    bool map = false;  ///< of a project: the registers of its servers
    file::TableOptions reading;
    bool addresses_given = false;
    bool notation_given = false;
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

ExitCode convert(const CommonOptions& common, const ConvertOptions& options);

struct CtlOptions {
    std::string path;
    std::vector<std::string> words;
    bool json = false;  ///< print the answer as JSON
};

ExitCode ctl(const CommonOptions& common, const CtlOptions& options);

struct HistoryOptions {
    std::string file;                    ///< the project
    std::vector<std::string> variables;  ///< empty: list them
    std::string from = "-1h";
    std::string to = "now";
    std::string database;  ///< empty: publish::history_database() of the project
    bool json = false;
    bool csv = false;
    std::string svg;  ///< file for the picture; "-": stdout
    std::uint32_t points = 1000;
};

ExitCode history(const CommonOptions& common, const HistoryOptions& options);

/// How a target is measured. Nothing: not given.
struct LatencyLoad {
    std::optional<wire::Area> area;
    std::optional<std::uint32_t> start;
    std::optional<std::uint32_t> quantity;
    std::optional<std::uint32_t> unit;
    std::optional<std::uint32_t> connections;
    std::optional<std::uint32_t> in_flight;
    std::optional<client::Rate> rate;
    std::optional<Duration> run_for;
    std::optional<std::uint32_t> requests;
    bool same_content = false;
    RealtimeMode realtime;
};

struct LatencyOptions {
    std::string source;     ///< URL of a target, or the file of a capture; "-": standard input
    std::string interface;  ///< to listen on, instead of a source; empty: none
    /// Of the messages in captured TCP connections; nothing: found.
    std::optional<wire::Framing> framing;
    std::vector<std::uint16_t> ports;           ///< of servers in a capture; empty: 502
    std::optional<capture::Grouping> grouping;  ///< of a capture; nothing: all parts
    Duration timeout = std::chrono::seconds(1);
    std::optional<Duration> limit;
    bool json = false;
    bool csv = false;
    std::string svg;              ///< file for the picture; "-": stdout
    std::uint32_t histogram = 0;  ///< microseconds; 0: not printed
    LatencyLoad load;             ///< of a target
};

ExitCode latency(const CommonOptions& common, const LatencyOptions& options);

struct ListenOptions {
    std::string port;  ///< device file, serial target or capture
    std::string project;
    std::string write;  ///< file for the project of what was heard
    bool force = false;
    std::optional<Duration> run_for;
    Duration timeout = std::chrono::seconds(1);
    bool quiet = false;
    bool json = false;
};

ExitCode listen(const CommonOptions& common, const ListenOptions& options);

struct PlanOptions {
    std::string file;
    bool json = false;
    bool csv = false;
    bool compare = false;
    std::string svg;  ///< file for the picture; "-": stdout instead of the text; empty: none
    bool no_notes = false;
    bool prove = false;  ///< as for CheckOptions
    bool fix = false;    ///< plan again with the settings that change only the plan
};

ExitCode plan(const CommonOptions& common, const PlanOptions& options);

struct ProbeOptions : ClientOptions {
    std::vector<wire::Area> areas;  ///< empty: all four
    std::uint16_t first = 0;
    std::uint16_t last = 65535;
    std::optional<std::uint16_t> step;  ///< nothing: bus::step_within() of `max_requests`
    std::size_t max_requests = 4096;    ///< of each area
    bool yaml = false;
};

ExitCode probe(const CommonOptions& common, const ProbeOptions& options);

struct ReplayOptions {
    std::string file;    ///< the project
    std::string output;  ///< its name
    std::string from;    ///< as of takt history
    bool json = false;
};

ExitCode replay(const CommonOptions& common, const ReplayOptions& options);

/// The page and the API of a run.
struct WebOptions {
    std::optional<line::ListenAddress> address;  ///< nothing: they are not served
    bool or_free_port = false;                   ///< another port if that of `address` is in use
    bool allow_write = false;
    std::string token_file;          ///< empty: no token
    std::vector<std::string> names;  ///< further ones of this machine: web::WebServerOptions::names
    std::vector<Network> proxies;    ///< whose fields X-Forwarded-* count
    bool demo = false;
};

struct RunOptions {
    std::string file;
    bool create = false;              ///< the file, as an empty project; it must not exist
    std::string table;                ///< a request table instead of a project file
    std::string target;               ///< with a table of one line: another serial port, or host:port
    std::optional<Duration> run_for;  ///< nothing: until stopped
    bool json = false;
    std::string traffic;                  ///< file for the frames; "-": stderr; empty: none
    console::CaptureFileOptions capture;  ///< empty path: none
    bool commands_from_stdin = false;
    std::string control_path;  ///< Unix socket for commands; empty: none
    bool learn = true;         ///< devices with gaps: learn are tried
    std::string learnt;        ///< the file that keeps it; empty: none
    bool quiet = false;        ///< no values: changes of state only
    std::string device;        ///< values and events of this device only; empty: all
    std::string state;         ///< file of retained values; empty: beside the project (of the demo: none)
    RealtimeMode realtime;
    WebOptions web;
    /// Called if the process ends inside the run (leave_program()). May be empty.
    std::function<void()> on_leave = {};
};

struct DemoOptions {
    std::optional<Duration> run_for;
    bool json = false;
    bool web = true;  ///< serve the page
};

ExitCode run(const CommonOptions& common, const RunOptions& options);
ExitCode demo(const CommonOptions& common, const DemoOptions& options);

struct ScanOptions {
    std::vector<std::string> targets;
    std::string units;     ///< empty: all
    std::string bauds;     ///< empty: the target's, else the usual ones
    std::string parities;  ///< likewise
    std::string stop_bits;
    std::optional<Duration> timeout;  ///< nothing: as of bus::ScanRequest
    bool first = false;               ///< leave a serial port after the first settings that found something
    bool thorough = false;            ///< ask silent units by other functions too
    bool identify = true;
    bool json = false;
    bool probe = false;   ///< find the registers of each device for the project
    std::string project;  ///< file for a project of what was found; empty: none
    bool force = false;   ///< overwrite it
    std::string traffic;
};

ExitCode scan(const CommonOptions& common, const ScanOptions& options);

/// Prints the JSON Schema of project files.
ExitCode schema(const CommonOptions& common);

struct SelftestOptions {
    Duration time = std::chrono::seconds(5);  ///< of each measurement
    RealtimeMode realtime;
    bool json = false;
};

/// Measures what this computer adds to an exchange, idle and under load.
ExitCode selftest(const CommonOptions& common, const SelftestOptions& options);

struct ServeOptions {
    std::string file;    ///< a project whose devices to be; empty: a blank device
    std::string listen;  ///< host:port
    std::string port;    ///< serial port or serial target
    UnitId unit{1};      ///< of the blank device
    sim::Fill fill = sim::Fill::zero;
    bool strict = false;  ///< RTU: pauses above t1.5 inside a frame spoil it
    std::optional<Duration> run_for;
    std::string traffic;
    console::CaptureFileOptions capture;  ///< empty path: none
    bool json = false;                    ///< the summary at the end as one object
    endpoint::LimitOverrides limits;
    std::string access;  ///< file of access rules for all endpoints; empty: those of the project
    std::string audit;   ///< file of writes and refusals at all endpoints; empty: those of the project
    std::vector<sim::FaultRule> faults;
    std::string control_path;  ///< Unix socket for commands to the devices; empty: none
    bool commands_from_stdin = false;
    RealtimeMode realtime;
    std::string line;  ///< the devices of this line of the project alone; empty: of all lines
};

ExitCode serve(const CommonOptions& common, const ServeOptions& options);

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

ExitCode table_build(const CommonOptions& common, const TableBuildOptions& options);
ExitCode table_show(const CommonOptions& common, const TableShowOptions& options);

}  // namespace takt::app
