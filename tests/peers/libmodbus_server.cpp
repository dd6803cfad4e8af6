// A libmodbus slave with 10000 of each area, filled with the ramp (register a holds a, bit a holds a & 1).
// Prints "ready" when it can be asked; ends when its standard input ends.
//
// usage: libmodbus_server tcp PORT UNIT | libmodbus_server rtu DEVICE BAUD PARITY(N|E|O) UNIT
#include <modbus/modbus.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

constexpr int kCount = 10000;

modbus_mapping_t* ramp() {
    modbus_mapping_t* map = modbus_mapping_new(kCount, kCount, kCount, kCount);
    for (int a = 0; a < kCount; ++a) {
        map->tab_bits[a] = map->tab_input_bits[a] = static_cast<std::uint8_t>(a & 1);
        map->tab_registers[a] = map->tab_input_registers[a] = static_cast<std::uint16_t>(a);
    }
    return map;
}

/// Waits for bytes on `fd`; false when standard input has ended.
bool wait_for(int fd) {
    std::array<pollfd, 2> watched{{{fd, POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}}};
    for (;;) {
        if (poll(watched.data(), watched.size(), -1) < 0) {
            if (errno == EINTR) continue;
            return false;
        }
        char byte = 0;
        if (watched[1].revents != 0 && read(STDIN_FILENO, &byte, 1) <= 0) return false;
        if (watched[0].revents != 0) return true;
    }
}

/// Answers until the peer goes away (true) or standard input ends (false).
bool serve(modbus_t* bus, modbus_mapping_t* map) {
    std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> frame{};
    while (wait_for(modbus_get_socket(bus))) {
        const int size = modbus_receive(bus, frame.data());
        if (size > 0) {
            modbus_reply(bus, frame.data(), size, map);
        } else if (size < 0 && (errno == ECONNRESET || errno == EBADF || errno == EIO)) {
            return true;
        }
    }
    return false;
}

void say_ready() {
    std::printf("ready\n");
    std::fflush(stdout);
}

void serve_tcp(modbus_t* bus, modbus_mapping_t* map) {
    int listener = modbus_tcp_listen(bus, 5);
    say_ready();
    while (wait_for(listener) && modbus_tcp_accept(bus, &listener) >= 0) {
        if (!serve(bus, map)) break;
        modbus_close(bus);
    }
    close(listener);
}

}  // namespace

int main(int argc, char** argv) {
    const std::string kind = argc > 1 ? argv[1] : "";
    if (!(kind == "tcp" && argc == 4) && !(kind == "rtu" && argc == 6)) return 2;
    modbus_t* bus = kind == "tcp" ? modbus_new_tcp("127.0.0.1", std::atoi(argv[2]))
                                  : modbus_new_rtu(argv[2], std::atoi(argv[3]), argv[4][0], 8, 1);
    modbus_set_slave(bus, std::atoi(argv[argc - 1]));
    modbus_mapping_t* map = ramp();
    if (kind == "tcp") {
        serve_tcp(bus, map);
    } else if (modbus_connect(bus) == 0) {
        say_ready();
        serve(bus, map);
    } else {
        std::fprintf(stderr, "%s\n", modbus_strerror(errno));
        return 3;
    }
    modbus_close(bus);
    modbus_mapping_free(map);
    modbus_free(bus);
}
