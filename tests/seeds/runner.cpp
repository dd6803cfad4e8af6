#include "runner.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <set>
#include <utility>

namespace takt::seeds {
namespace {

struct Worker {
    pid_t pid = 0;
    std::FILE* results = nullptr;
};

class Session {
public:
    Session(const Options& options, const Program& program) : options_(options), program_(program) {}

    int run() {
        if (!take_earlier_results()) return 2;
        start_workers();
        collect();
        return conclude();
    }

private:
    bool take_earlier_results();
    bool read_results(std::set<std::uint64_t>& known, bool& exists);
    void start_workers();
    void work(unsigned job, std::FILE* out) const;
    void collect();
    bool take_one(Worker& worker, std::uint64_t& current);
    void on_end(Worker& worker, std::uint64_t current);
    void take(const Record& record);
    void show_progress();
    int conclude();

    const Options& options_;
    const Program& program_;
    std::vector<std::uint64_t> seeds_;
    std::vector<Worker> workers_;
    std::ofstream kept_;
    Counts total_;
    std::uint64_t done_ = 0;
    std::uint64_t failed_ = 0;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point last_print_ = begin_;
};

bool Session::take_earlier_results() {
    std::set<std::uint64_t> known;
    if (!options_.resume.empty()) {
        bool exists = false;
        if (!read_results(known, exists)) return false;
        kept_.open(options_.resume, std::ios::app);
        if (!kept_) {
            std::cerr << program_.name << ": cannot write " << options_.resume << "\n";
            return false;
        }
        if (!exists) kept_ << "# " << program_.replay(0) << "\n";
    }
    for (std::uint64_t seed = options_.first; seed <= options_.last; ++seed)
        if (!known.contains(seed)) seeds_.push_back(seed);
    return true;
}

// The first line names the run, so that results of other runs are not mixed in.
bool Session::read_results(std::set<std::uint64_t>& known, bool& exists) {
    std::ifstream file(options_.resume);
    std::string line;
    exists = static_cast<bool>(std::getline(file, line));
    if (exists && line != "# " + program_.replay(0)) {
        std::cerr << program_.name << ": " << options_.resume << " holds results of another run: " << line
                  << "\n";
        return false;
    }
    for (Record record; std::getline(file, line); record = {}) {
        if (!from_line(line, record) || record.seed < options_.first || record.seed > options_.last ||
            !known.insert(record.seed).second)
            continue;
        take(record);
    }
    return true;
}

void Session::start_workers() {
    for (unsigned job = 0; job < options_.jobs; ++job) {
        int ends[2];
        if (pipe(ends) != 0) std::exit(2);
        std::cout.flush();
        const pid_t pid = fork();
        if (pid < 0) std::exit(2);
        if (pid == 0) {
            close(ends[0]);
            for (const Worker& other : workers_) std::fclose(other.results);
            work(job, fdopen(ends[1], "w"));
            std::_Exit(0);
        }
        close(ends[1]);
        workers_.push_back({pid, fdopen(ends[0], "r")});
    }
}

void Session::work(unsigned job, std::FILE* out) const {
    for (std::size_t i = job; i < seeds_.size(); i += options_.jobs) {
        std::fprintf(out, "begin %llu\n", static_cast<unsigned long long>(seeds_[i]));
        std::fflush(out);
        std::fprintf(out, "%s\n", to_line(program_.run(seeds_[i])).c_str());
        std::fflush(out);
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
    for (std::size_t w = 0; open > 0; w = (w + 1) % workers_.size()) {
        Worker& worker = workers_[w];
        if (!worker.results || take_one(worker, current[w])) continue;
        on_end(worker, current[w]);
        --open;
    }
}

/// @returns false: the worker has ended
bool Session::take_one(Worker& worker, std::uint64_t& current) {
    char* line = nullptr;
    std::size_t capacity = 0;
    bool got = false;
    while (!got) {
        const auto length = getline(&line, &capacity, worker.results);
        if (length < 0) break;
        unsigned long long begun = 0;
        if (std::sscanf(line, "begin %llu", &begun) == 1) {
            current = begun;
            continue;
        }
        Record record;
        if (!from_line(std::string(line, static_cast<std::size_t>(length)), record)) continue;
        got = true;
        take(record);
        print_seed(std::cout, record, options_.json, program_.shown);
        if (kept_.is_open()) kept_ << to_line(record) << "\n" << std::flush;
        show_progress();
    }
    std::free(line);
    return got;
}

void Session::on_end(Worker& worker, std::uint64_t current) {
    std::fclose(std::exchange(worker.results, nullptr));
    int status = 0;
    waitpid(worker.pid, &status, 0);
    if (status == 0) return;
    ++failed_;
    std::cerr << "seed " << current << " ended the program (status " << status
              << ")\n  again: " << program_.replay(current) << "\n";
}

int Session::conclude() {
    if (isatty(2) != 0 && last_print_ != begin_) std::cerr << "\n";
    const auto never_seen = program_.missing_kinds(total_);
    print_summary(std::cout, total_, done_, failed_, never_seen, options_.json);
    if (failed_ > 0) return 1;
    if (!program_.all_kinds || done_ < program_.many_seeds) return 0;
    for (const auto& kind : never_seen) std::cerr << "never seen: " << kind << "\n";
    return never_seen.empty() ? 0 : 1;
}

}  // namespace

int run_seeds(const Options& options, const Program& program) {
    return Session(options, program).run();
}

}  // namespace takt::seeds
