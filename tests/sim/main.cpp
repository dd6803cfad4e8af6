// takt-sim: runs many seeds in parallel processes. Each job is a process of its own, so that the memory of a
// run can be measured and a failed assertion shows its seed.
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <set>

#include "report.hpp"
#include "topology.hpp"

namespace takt::simtest {
namespace {

constexpr std::uint64_t kManySeeds = 150;  // so many must see every kind

struct Worker {
    pid_t pid = 0;
    std::FILE* results = nullptr;
};

/// Runs one seed. A violation is printed to stderr at once.
Result run_seed(const Options& options, const model::Project* given, std::uint64_t seed) {
    Run settings{.seed = seed,
                 .length = options.length(),
                 .faults = options.choice,
                 .merciless = !options.lenient,
                 .trace = options.trace};
    if (given) return run(*given, settings);
    const Topology topology = make_topology(seed);
    if (topology.error.empty()) return run(topology.project, settings);
    Result result{.seed = seed};
    result.violations.push_back({"reachable", {}, 0, "a legal project", topology.error});
    return result;
}

void work(const Options& options, const model::Project* given, const std::vector<std::uint64_t>& seeds,
          unsigned job, std::FILE* out) {
    for (std::size_t i = job; i < seeds.size(); i += options.jobs) {
        std::fprintf(out, "begin %llu\n", static_cast<unsigned long long>(seeds[i]));
        std::fflush(out);
        const Result result = run_seed(options, given, seeds[i]);
        if (!result.violations.empty()) std::fputs(violation_text(result, options).c_str(), stderr);
        std::fprintf(out, "%s\n", to_line(record_of(result)).c_str());
        std::fflush(out);
    }
}

class Session {
public:
    explicit Session(const Options& options) : options_(options) {}

    int run();

private:
    bool take_project();
    bool take_earlier_results();
    void start_workers();
    void collect();
    void take(const Record& record);
    void show_progress();
    int conclude();

    const Options& options_;
    ReadProject project_;
    std::vector<std::uint64_t> seeds_;
    std::vector<Worker> workers_;
    std::ofstream kept_;
    Counts total_;
    std::uint64_t done_ = 0;
    std::uint64_t failed_ = 0;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point last_print_ = begin_;
};

bool Session::take_project() {
    if (options_.project.empty()) return true;
    project_ = read_file(options_.project);
    if (project_.error.empty()) return true;
    std::cerr << "takt-sim: " << options_.project << ": " << project_.error << "\n";
    return false;
}

// The first line names the run, so that results of other runs are not mixed in.
bool Session::take_earlier_results() {
    std::set<std::uint64_t> known;
    if (!options_.resume.empty()) {
        const std::string heading = "# " + replay(options_, 0);
        std::ifstream file(options_.resume);
        std::string line;
        const bool exists = static_cast<bool>(std::getline(file, line));
        if (exists && line != heading) {
            std::cerr << "takt-sim: " << options_.resume << " holds results of another run: " << line << "\n";
            return false;
        }
        for (Record record; std::getline(file, line); record = {}) {
            if (!from_line(line, record) || record.seed < options_.first || record.seed > options_.last ||
                !known.insert(record.seed).second)
                continue;
            take(record);
        }
        kept_.open(options_.resume, std::ios::app);
        if (!kept_) {
            std::cerr << "takt-sim: cannot write " << options_.resume << "\n";
            return false;
        }
        if (!exists) kept_ << heading << "\n";
    }
    for (std::uint64_t seed = options_.first; seed <= options_.last; ++seed)
        if (!known.contains(seed)) seeds_.push_back(seed);
    return true;
}

void Session::start_workers() {
    const model::Project* given = options_.project.empty() ? nullptr : &project_.project;
    for (unsigned job = 0; job < options_.jobs; ++job) {
        int ends[2];
        if (pipe(ends) != 0) std::exit(2);
        std::cout.flush();
        const pid_t pid = fork();
        if (pid < 0) std::exit(2);
        if (pid == 0) {
            close(ends[0]);
            for (const Worker& other : workers_) std::fclose(other.results);
            work(options_, given, seeds_, job, fdopen(ends[1], "w"));
            std::_Exit(0);
        }
        close(ends[1]);
        workers_.push_back({pid, fdopen(ends[0], "r")});
    }
}

void Session::take(const Record& record) {
    ++done_;
    if (!record.invariant.empty()) ++failed_;
    for (const auto& [kind, count] : record.counts) total_[kind] += count;
}

void Session::show_progress() {
    using namespace std::chrono_literals;
    const auto now = std::chrono::steady_clock::now();
    if (now - begin_ < 2s || now - last_print_ < 1s) return;
    last_print_ = now;
    const auto all = options_.last - options_.first + 1;
    std::cerr << (isatty(2) != 0 ? "\r" : "") << done_ << " of " << all << " seeds, " << failed_
              << " with a violation" << (isatty(2) != 0 ? "   " : "\n") << std::flush;
}

// Reads the workers in rotation: each one has its share of the seeds, in order.
void Session::collect() {
    std::vector<std::uint64_t> current(workers_.size());
    std::size_t open = workers_.size();
    char* line = nullptr;
    std::size_t capacity = 0;
    for (std::size_t w = 0; open > 0; w = (w + 1) % workers_.size()) {
        Worker& worker = workers_[w];
        if (!worker.results) continue;
        bool got = false;
        while (!got) {
            const auto length = getline(&line, &capacity, worker.results);
            if (length < 0) break;
            unsigned long long begun = 0;
            if (std::sscanf(line, "begin %llu", &begun) == 1) {
                current[w] = begun;
                continue;
            }
            Record record;
            if (!from_line(std::string(line, static_cast<std::size_t>(length)), record)) continue;
            got = true;
            take(record);
            print_seed(std::cout, record, options_);
            if (kept_.is_open()) kept_ << to_line(record) << "\n" << std::flush;
            show_progress();
        }
        if (got) continue;
        std::fclose(std::exchange(worker.results, nullptr));
        --open;
        int status = 0;
        waitpid(worker.pid, &status, 0);
        if (status == 0) continue;
        ++failed_;
        std::cerr << "seed " << current[w] << " ended the program (status " << status
                  << ")\n  again: " << replay(options_, current[w]) << "\n";
    }
    std::free(line);
}

int Session::conclude() {
    if (isatty(2) != 0 && last_print_ != begin_) std::cerr << "\n";
    print_summary(std::cout, total_, done_, failed_, options_);
    if (failed_ > 0) return 1;
    const bool all_kinds = done_ >= kManySeeds && options_.project.empty() && options_.faults == "seed";
    auto missing = all_kinds ? missing_kinds(total_) : std::vector<std::string>{};
    if (options_.lenient)
        std::erase_if(missing, [](const auto& kind) {
            return kind.ends_with("past_response") || kind.ends_with("duplicate_response");
        });
    for (const auto& kind : missing) std::cerr << "never seen: " << kind << "\n";
    return missing.empty() ? 0 : 1;
}

int Session::run() {
    if (!take_project() || !take_earlier_results()) return 2;
    start_workers();
    collect();
    return conclude();
}

int run_program(std::span<char*> arguments) {
    Options options;
    if (const auto wrong = parse_options(arguments, options)) {
        std::cerr << "takt-sim: " << *wrong << "\n";
        return 2;
    }
    if (options.help) {
        std::cout << usage();
        return 0;
    }
    if (options.print_project) {
        const Topology topology = make_topology(options.first);
        std::cout << topology.text;
        if (!topology.error.empty()) std::cerr << "takt-sim: " << topology.error << "\n";
        return topology.error.empty() ? 0 : 2;
    }
    return Session(options).run();
}

}  // namespace
}  // namespace takt::simtest

int main(int argc, char** argv) {
    return takt::simtest::run_program(std::span(argv, static_cast<std::size_t>(argc)).subspan(1));
}
