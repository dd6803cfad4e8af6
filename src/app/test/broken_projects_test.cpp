// Every pair of options of every command that reads a project, on projects that are broken in every way. Each
// run must end with a documented exit code, without an assertion, and with JSON where JSON was asked for.
//
// The broken projects are made from the examples: each key misspelt, removed, and accompanied by an unknown
// one; each value replaced by values of wrong kinds and ranges. All pairs run on a few other projects, and
// one set of options of each command on a share of these. TAKT_BROKEN_SHARE is the share: 100, one of a
// hundred; 1, all of them (./dev soak); 0, all of them with all pairs.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <sstream>

#include "folder.hpp"
#include "program.hpp"
#include "takt/base/assert.hpp"
#include "takt/file/json.hpp"
#include "takt/host/project_file.hpp"

namespace takt::app {
namespace broken_projects_test {

using Words = std::vector<std::string>;

constexpr std::size_t kShare = 100;
constexpr std::size_t kMostOutput = std::size_t{1} << 26;

std::string joined(const Words& words) {
    std::string text;
    for (const auto& word : words) text += (text.empty() ? "" : " ") + word;
    return text;
}

// Running a command in this process
// ----------------------------------------------------------------------------------------------

std::string g_case;  // the current case, for the report of a crash

void report_case() {
    std::fprintf(stderr, "while running: %s\n", g_case.c_str());
}

/// Collects what is written to a descriptor.
class Capture {
public:
    explicit Capture(int descriptor)
        : descriptor_(descriptor), saved_(::dup(descriptor)), memory_(::memfd_create("output", 0)) {
        ::dup2(memory_, descriptor_);
    }
    ~Capture() {
        ::dup2(saved_, descriptor_);
        ::close(saved_);
        ::close(memory_);
    }
    Capture(const Capture&) = delete;
    Capture& operator=(const Capture&) = delete;

    [[nodiscard]] std::string text() const {
        std::string text(static_cast<std::size_t>(::lseek(memory_, 0, SEEK_END)), '\0');
        const auto read = ::pread(memory_, text.data(), text.size(), 0);
        EXPECT_EQ(read, static_cast<ssize_t>(text.size()));
        return text;
    }

private:
    int descriptor_;
    int saved_;
    int memory_;
};

struct Outcome {
    int code = 0;
    std::string out;
    std::string err;
};

Outcome run(Words words) {
    g_case = joined(words);
    words.insert(words.begin(), "takt");
    std::vector<char*> argv;
    for (auto& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const Capture out(STDOUT_FILENO);
    const Capture err(STDERR_FILENO);
    Outcome outcome{.code = run_program(static_cast<int>(words.size()), argv.data())};
    std::fflush(stdout);
    outcome.out = out.text();
    outcome.err = err.text();
    return outcome;
}

// Options, read from the help of each command
// ----------------------------------------------------------------------------------------------

/// A command that reads a project.
struct Command {
    Words words;
    bool runs = false;  ///< and then runs it: refused if the project has errors
    Words required;
    Words before = {};        ///< between the command and the project
    bool json_lines = false;  ///< --json: one object per line
};

const std::vector<Command>& commands() {
    static const std::vector<Command> kCommands{{{"check"}},
                                                {{"plan"}},
                                                {{"convert"}, false, {"--from", "yaml"}},
                                                {{"table", "build"}, false, {"-o", "out.table"}},
                                                {{"listen"}, false, {}, {"line.pcap", "--project"}, true},
                                                {{"run"}, true, {"--for", "10ms"}},
                                                {{"serve"}, true, {"--for", "10ms"}}};
    return kCommands;
}

/// Values of the options that take one.
const std::multimap<std::string, std::string>& values() {
    static const std::multimap<std::string, std::string> kValues{{"--lang", "ru"},
                                                                 {"--log", "out.log"},
                                                                 {"--log-level", "trace"},
                                                                 {"--svg", "out.svg"},
                                                                 {"--svg", "-"},
                                                                 {"--output", "out.csv"},
                                                                 {"--from", "csv"},
                                                                 {"--to", "csv"},
                                                                 {"--to", "yaml"},
                                                                 {"--to", "md"},
                                                                 {"--line", "L"},
                                                                 {"--device", "D"},
                                                                 {"--unit", "3"},
                                                                 {"--target", "tcp://h"},
                                                                 {"--addresses", "reference"},
                                                                 {"--headings", "ru"},
                                                                 {"--notation", "coils_at_20001"},
                                                                 {"--separator", "tab"},
                                                                 {"--encoding", "cp1251"},
                                                                 {"--input-separator", "semicolon"},
                                                                 {"--profile", "owen-kc1"},
                                                                 {"--input-encoding", "cp1251"},
                                                                 {"--table", "out.table"},
                                                                 {"--table", "locals"},
                                                                 {"--port", "/dev/takt-none"},
                                                                 {"--traffic", "-"},
                                                                 {"--interface", "takt-none"},
                                                                 {"--framing", "rtu"},
                                                                 {"--size", "1M"},
                                                                 {"--files", "2"},
                                                                 {"--capture", "out.pcapng"},
                                                                 {"--capture-size", "1M"},
                                                                 {"--capture-files", "2"},
                                                                 {"--control", "out.sock"},
                                                                 {"--web", "127.0.0.1:0"},
                                                                 {"--web-name", "plant.example.com"},
                                                                 {"--web-proxy", "127.0.0.1"},
                                                                 {"--web-token", "none.token"},
                                                                 {"--state", "out.state"},
                                                                 {"--project", "none.yaml"},
                                                                 {"--write", "out.yaml"},
                                                                 {"--timeout", "100ms"},
                                                                 {"--for", "20ms"},
                                                                 {"--max-connections", "3"},
                                                                 {"--max-per-peer", "3"},
                                                                 {"--frame-timeout", "1s"},
                                                                 {"--byte-timeout", "1s"},
                                                                 {"--idle-timeout", "1s"},
                                                                 {"--write-timeout", "1s"},
                                                                 {"--access", "none.yaml"},
                                                                 {"--audit", "out.audit"},
                                                                 {"--fault", "exception=2"},
                                                                 {"--listen", "127.0.0.1:0"},
                                                                 {"--cpu", "0"},
                                                                 {"--spin", "10us"},
                                                                 {"--fill", "zero"}};
    return kValues;
}

/// Adds the options that a help lists, each with a value if it takes one: {"--json"}, {"--svg", "-"}.
void add_options(Words help, std::vector<Words>& options) {
    help.emplace_back("--help");
    const auto outcome = run(help);
    EXPECT_EQ(outcome.code, 0);
    static const std::regex kOption(R"(^  (?:-\w,)?(--[\w-]+)( \S+)?.*$)");
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);) {
        std::smatch found;
        if (!std::regex_match(line, found, kOption)) continue;
        const std::string name = found[1];
        if (name == "--help" || name == "--version") continue;
        if (!found[2].matched || found[2] == " Needs:" || found[2] == " Excludes:") {
            options.push_back({name});
            continue;
        }
        const auto [begin, end] = values().equal_range(name);
        EXPECT_NE(begin, end) << joined(help) << ": give " << name << " a value in this test";
        for (auto value = begin; value != end; ++value) options.push_back({name, value->second});
    }
}

std::vector<Words> options_of(const Command& command) {
    std::vector<Words> options;
    add_options({}, options);
    EXPECT_GE(options.size(), 3U);
    const std::size_t of_every_command = options.size();
    add_options(command.words, options);
    EXPECT_GE(options.size(), of_every_command + 2) << joined(command.words);
    return options;
}

/// No option, each option alone, and each pair.
std::vector<Words> pairs_of(const Command& command) {
    const auto options = options_of(command);
    std::vector<Words> sets{{}};
    for (std::size_t a = 0; a < options.size(); ++a) {
        sets.push_back(options[a]);
        for (std::size_t b = a + 1; b < options.size(); ++b) {
            if (options[a][0] == options[b][0]) continue;
            Words pair = options[a];
            pair.insert(pair.end(), options[b].begin(), options[b].end());
            sets.push_back(std::move(pair));
        }
    }
    return sets;
}

std::vector<std::vector<Words>> sets_of_all() {
    std::vector<std::vector<Words>> sets;
    for (const auto& command : commands()) sets.push_back(pairs_of(command));
    return sets;
}

/// TAKT_BROKEN_SHARE.
std::size_t share() {
    const char* const wanted = std::getenv("TAKT_BROKEN_SHARE");
    return wanted ? std::strtoull(wanted, nullptr, 10) : kShare;
}

// Broken projects
// ----------------------------------------------------------------------------------------------

/// A key of a YAML text with its value, up to a comma, a bracket or the end of the line.
struct Key {
    std::size_t key = 0;
    std::size_t colon = 0;
    std::size_t value = 0;
    std::size_t end = 0;
    bool in_braces = false;
};

std::vector<Key> keys_of(const std::string& text) {
    static const std::regex kKey(R"(([\w-]+):( +|$))");
    std::vector<Key> keys;
    for (std::size_t line = 0; line < text.size();) {
        const auto newline = std::min(text.find('\n', line), text.size());
        const auto comment = std::min(text.find('#', line), newline);
        const auto begin = text.begin() + static_cast<std::ptrdiff_t>(line);
        const auto last = text.begin() + static_cast<std::ptrdiff_t>(comment);
        for (std::sregex_iterator at(begin, last, kKey), none; at != none; ++at) {
            Key key;
            key.key = line + static_cast<std::size_t>(at->position(0));
            key.colon = key.key + static_cast<std::size_t>(at->length(1));
            key.value = key.key + static_cast<std::size_t>(at->length(0));
            key.in_braces = text.substr(line, key.key - line).find('{') != std::string::npos;
            key.end = key.in_braces ? text.find_first_of(",}\n", key.value) : comment;
            key.end = std::min(std::max(key.end, key.value), text.size());
            keys.push_back(key);
        }
        line = newline + 1;
    }
    return keys;
}

std::vector<std::string> broken_at(const std::string& text, const Key& key) {
    std::vector<std::string> broken;
    const auto with = [&](std::size_t from, std::size_t to, const std::string& instead) {
        broken.push_back(text.substr(0, from) + instead + text.substr(to));
    };
    with(key.key, key.colon, text.substr(key.key, key.colon - key.key) + "x");
    if (key.in_braces) {
        with(key.key, key.key, "foo: 1, ");
        const bool comma = text[key.end] == ',';
        with(key.key, key.end + (comma ? 1 : 0), "");
    } else {
        const auto line = text.rfind('\n', key.key) + 1;  // npos + 1 is 0
        const auto item = text.substr(line, key.key - line);
        const std::string indent(item.size(), ' ');
        with(key.key, key.key, "foo: 1\n" + indent);
        const auto next = text.find_first_not_of(" \n", key.end);
        with(key.key, next == std::string::npos ? text.size() : next, "");
    }
    for (const char* const value :
         {"-1", "0", "99999999999999999999", "1e400", "text", "''", "[1, 2]", "{a: 1}", "1d", "~"})
        with(key.value, key.end, value);
    return broken;
}

/// Keys that no example has.
const std::string& rare_keys() {
    static const std::string kProject =
        "takt: 1\nlines:\n  - name: L\n    transport: tcp\n    host: 127.0.0.1\n    tcp_port: 1\n    "
        "devices:\n"
        "      - name: D\n        address: 1\n        in_flight: 4\n"
        "        round_trip: {longest: 3100us, usual: 412us, exchanges: 600000, in_flight: 4}\n"
        "        variables:\n          - {name: v, type: int16, register: 0, read: 0x03}\n";
    return kProject;
}

/// Projects that are broken in one way each, in a fixed order.
const std::vector<std::string>& broken_projects() {
    static const std::vector<std::string> kBroken = [] {
        std::vector<std::filesystem::path> examples;
        for (const auto& entry : std::filesystem::directory_iterator(TAKT_EXAMPLES))
            if (entry.path().extension() == ".yaml") examples.push_back(entry.path());
        std::ranges::sort(examples);
        std::vector<std::string> all;
        const auto add = [&](const std::string& text) {
            for (const auto& key : keys_of(text))
                std::ranges::move(broken_at(text, key), std::back_inserter(all));
        };
        for (const auto& path : examples) {
            std::ifstream file(path);
            add({std::istreambuf_iterator<char>(file), {}});
        }
        add(rare_keys());
        return all;
    }();
    return kBroken;
}

/// One error at each level of a small project, and a file that is no document.
const std::vector<std::string>& few_broken_projects() {
    static const std::string kProject =
        "takt: 1\nlines:\n  - name: L\n    transport: serial\n    port: /dev/takt-none\n    devices:\n"
        "      - name: D\n        address: 1\n        variables:\n"
        "          - {name: v, type: int16, register: 0, read: 0x03}\n"
        "          - {name: w, type: int16, register: 9, write: 0x06, write_on_change: true}\n";
    static const std::vector<std::string> kFew{
        std::string(kProject).insert(kProject.find("    devices:"), "    foo: 1\n"),
        std::string(kProject).insert(kProject.find("        variables:"), "        foo: 1\n"),
        std::string(kProject).replace(kProject.find("register: 0"), 11, "register: 70000"),
        kProject + "foo: 1\n",
        std::string(rare_keys()).replace(rare_keys().find("usual: 412us"), 12, "usual: 9s"),
        kProject + "servers:\n  - name: S\n    listen: nowhere\n    units: [{unit: 999}]\n",
        "takt: 1\nlines: [\n"};
    return kFew;
}

// The checks
// ----------------------------------------------------------------------------------------------

class BrokenProjects : public testing::Test {
protected:
    void SetUp() override {
        std::filesystem::current_path(folder_.path());
        write_capture();
        set_assert_hook([](const char* expression, const char* file, int line) {
            std::fprintf(stderr, "%s (%s:%d)\n", expression, file, line);
        });
        std::signal(SIGABRT, [](int) { report_case(); });
        ::setenv("LC_ALL", "C.UTF-8", 1);
    }
    void TearDown() override {
        std::filesystem::current_path("/");
        std::signal(SIGABRT, SIG_DFL);
    }

    /// Writes the project. Afterwards the commands read it.
    void use(const std::string& text) {
        folder_.write("project.yaml", text);
        const auto loaded = host::load_project("project.yaml");
        has_errors_ = loaded.has_errors();
        readable_ = loaded.readable;
    }

    void check(const Command& command, const Words& options) {
        if (command.runs && !has_errors_) return;
        Words words = command.words;
        words.insert(words.end(), command.before.begin(), command.before.end());
        words.emplace_back("project.yaml");
        const auto given = [&](const char* name) {
            return std::ranges::find(options, name) != options.end();
        };
        for (std::size_t i = 0; i + 1 < command.required.size(); i += 2)
            if (!given(command.required[i].c_str()))
                words.insert(words.end(), {command.required[i], command.required[i + 1]});
        words.insert(words.end(), options.begin(), options.end());
        const auto outcome = run(words);
        ++runs_;
        const auto report = [&] {
            return joined(words) + "\n" + folder_.read("project.yaml") + "\nexit code " +
                   std::to_string(outcome.code) + "\nstdout: " + outcome.out + "\nstderr: " + outcome.err;
        };
        // 3: a file of the options cannot be opened.
        EXPECT_TRUE(outcome.code >= 0 && outcome.code <= 3) << report();
        EXPECT_EQ(outcome.err.find("internal error"), std::string::npos) << report();
        const Words from_table{"--from", "csv"};  // convert reads the file as a table
        const bool as_project = std::ranges::search(options, from_table).empty();
        const bool corrected = given("--profile");  // replaces the key of the project
        EXPECT_FALSE(as_project && !corrected && has_errors_ && outcome.code == 0) << report();
        EXPECT_FALSE(as_project && (!readable_ || command.runs) && outcome.code != 2) << report();
        EXPECT_FALSE(command.runs && !outcome.out.empty()) << "nothing runs\n" << report();
        EXPECT_FALSE(outcome.code != 0 && (outcome.out + outcome.err).empty()) << report();
        const bool json = given("--json") && outcome.code <= 1;
        EXPECT_TRUE(!json || is_json(outcome.out, command.json_lines)) << report();
    }

    static bool is_json(const std::string& text, bool lines) {
        if (!lines) return file::Json::parse(text, kMostOutput).has_value();
        std::istringstream all(text);
        for (std::string line; std::getline(all, line);)
            if (!file::Json::parse(line, kMostOutput)) return false;
        return true;
    }

    /// A capture of one frame, which is Modbus RTU.
    void write_capture() {
        folder_.write("line.pcap",
                      std::string("\xD4\xC3\xB2\xA1\x02\0\x04\0\0\0\0\0\0\0\0\0\xFF\xFF\0\0\x93\0\0\0", 24) +
                          std::string("\x01\0\0\0\0\0\0\0\x08\0\0\0\x08\0\0\0", 16) +
                          std::string("\x01\x03\0\0\0\x01\x84\x0A", 8));
    }

    takt::test::Folder folder_;
    bool has_errors_ = false;
    bool readable_ = false;
    std::size_t runs_ = 0;
};

TEST_F(BrokenProjects, EveryPairOfOptionsIsRefusedInOrder) {
    const auto& projects = few_broken_projects();
    const auto sets = sets_of_all();
    for (std::size_t p = 0; p < projects.size(); ++p) {
        use(projects[p]);
        for (std::size_t c = 0; c < sets.size(); ++c) {
            // A command that runs a project ends when it is loaded: each pair on one of the projects.
            const std::size_t step = commands()[c].runs && share() != 0 ? projects.size() : 1;
            for (std::size_t n = step == 1 ? 0 : p; n < sets[c].size(); n += step)
                check(commands()[c], sets[c][n]);
        }
    }
    RecordProperty("runs", static_cast<int>(runs_));
    EXPECT_GE(runs_, 1500U);
}

// The options rotate: project i is run with the set i of each command.
TEST_F(BrokenProjects, EveryWayOfBreakingAProjectIsRefusedInOrder) {
    const auto& projects = broken_projects();
    EXPECT_GE(projects.size(), 1000U);
    const auto sets = sets_of_all();
    const std::size_t step = std::max<std::size_t>(share(), 1);
    for (std::size_t i = 0; i < projects.size(); i += step) {
        use(projects[i]);
        for (std::size_t c = 0; c < sets.size(); ++c) {
            const auto& own = sets[c];
            const std::size_t count = share() == 0 ? own.size() : 1;
            for (std::size_t n = 0; n < count; ++n) check(commands()[c], own[(i / step + n) % own.size()]);
        }
    }
    RecordProperty("runs", static_cast<int>(runs_));
}

}  // namespace broken_projects_test
}  // namespace takt::app
