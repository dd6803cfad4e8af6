#include <cstdio>
#include <exception>

#include "exit_code.hpp"
#include "program.hpp"
#include "takt/base/assert.hpp"
#include "takt/os/standard_streams.hpp"

int main(int argc, char** argv) {
    takt::os::open_standard_streams();
    takt::set_assert_hook([](const char* expression, const char* file, int line) {
        std::fprintf(stderr, "takt: internal error: %s (%s:%d)\n", expression, file, line);
    });
    try {
        return takt::app::run_program(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "takt: internal error: %s\n", error.what());
        return static_cast<int>(takt::app::ExitCode::usage);
    }
}
