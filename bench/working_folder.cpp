#include "working_folder.hpp"

#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace takt::bench {
namespace {

volatile std::sig_atomic_t interrupted = 0;

}  // namespace

void catch_signals() {
    for (const int signal : {SIGINT, SIGTERM}) (void)std::signal(signal, [](int) { interrupted = 1; });
}

void check_interrupted() {
    if (interrupted != 0) throw Failure("interrupted");
}

WorkingFolder::WorkingFolder(const std::string& parent) : path_(parent + "/takt-bench-XXXXXX") {
    if (::mkdtemp(path_.data()) == nullptr) throw Failure(parent + ": " + std::strerror(errno));
}

WorkingFolder::~WorkingFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::string WorkingFolder::make(const std::string& name) const {
    std::filesystem::create_directories(*this / name);
    return *this / name;
}

std::uint64_t WorkingFolder::free_bytes() const {
    struct statvfs disk{};
    if (::statvfs(path_.c_str(), &disk) != 0) throw Failure(path_ + ": " + std::strerror(errno));
    return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

}  // namespace takt::bench
